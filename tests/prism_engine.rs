//! The prism engine: no allocation once warm, and many random pushes.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::Arc;

use jostle::action::Push;
use jostle::geom::{Pose2, Shape, pieces_gap_below, vec2};
use jostle::physics::{Prism, PrismSettings, PushJob, PushResult, PushStatus, Scratch, Transition};
use jostle::run::{Key, Stop};
use jostle::scene::{BodyDef, Scene, SceneBuilder, State};

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

/// Counts the allocations of each thread.
struct Counting;

// SAFETY: everything is passed on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        unsafe { System.alloc(layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        unsafe { System.realloc(memory, layout, size) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const SIDE: f64 = 0.045;

/// Bodies of every kind: blocks, a disc, a concave one, one of many corners; masses and frictions of all sorts if wanted.
fn scene(bodies: usize, seed: u64, uneven: bool) -> (Arc<Scene>, State) {
    let mut random = Key::new(seed).stream();
    let ring = (0..20).map(|k| f64::from(k) * std::f64::consts::TAU / 20.0).map(|a| [0.02 * a.cos(), 0.02 * a.sin()]);
    let notch = vec![[-0.03, -0.03], [0.03, -0.03], [0.03, 0.0], [0.0, 0.0], [0.0, 0.03], [-0.03, 0.03]];
    let shapes = [
        Shape::rectangle(SIDE, SIDE),
        Shape::rectangle(2.0 * SIDE, SIDE),
        Shape::Disc { radius: SIDE / 2.0 },
        Shape::Polygon(notch),
        Shape::ConvexPolygon(ring.collect()),
    ];
    let mut builder = SceneBuilder::new();
    let mut poses: Vec<Pose2> = Vec::new();
    let mut placed = Vec::new();
    let width = 0.075 * (bodies as f64).sqrt();
    while poses.len() < bodies {
        let mut def = BodyDef::new(shapes[random.index(shapes.len())].clone());
        if uneven {
            def.mass = 0.02 * 50f64.powf(random.unit());
            def.friction = random.uniform(0.1, 1.0);
        }
        let body = jostle::scene::Body::new(def.clone()).unwrap();
        // Somewhere free; tight places are tried often.
        let found = (0..10_000).find_map(|_| {
            let pose = Pose2::new(
                0.5 + random.uniform(-width, width) / 1.6,
                random.uniform(-width, width) / 1.6,
                random.uniform(-3.1, 3.1),
            );
            let free = placed.iter().zip(&poses).all(|(other, at): (&jostle::scene::Body, _)| {
                pieces_gap_below(&body.footprint, &pose, &other.footprint, at, 0.001) >= 0.0005
            });
            free.then_some(pose)
        });
        poses.push(found.expect("there is room"));
        placed.push(body);
        builder.add_body(def).unwrap();
    }
    (Arc::new(builder.build().unwrap()), State::new(poses))
}

/// Pushes from anywhere in the scene to anywhere near: many are illegal, many start close to a body.
fn pushes(count: usize, seed: u64, width: f64) -> Vec<Push> {
    let mut random = Key::new(seed).child(1).stream();
    (0..count)
        .map(|_| {
            let from = vec2(0.5 + random.uniform(-width, width), random.uniform(-width, width));
            let angle = random.uniform(-3.2, 3.2);
            Push::new(from, from + vec2(angle.cos(), angle.sin()) * random.uniform(0.02, 0.12))
        })
        .collect()
}

fn run(engine: &Prism, scratch: &mut Scratch, state: &State, pushes: &[Push]) -> Vec<PushResult> {
    let jobs: Vec<PushJob<'_>> = pushes.iter().map(|&push| PushJob { state, push }).collect();
    let mut results = vec![PushResult::default(); jobs.len()];
    engine.step_batch(scratch, &jobs, &mut results, &Stop::never());
    results
}

#[test]
fn a_warm_engine_allocates_nothing() {
    let (scene, state) = scene(12, 5, false);
    let pushes = pushes(36, 6, 0.25);
    for settings in [PrismSettings::fast(), PrismSettings::fine()] {
        let engine = Prism::new(Arc::clone(&scene), settings).unwrap();
        let jobs: Vec<PushJob<'_>> = pushes.iter().map(|&push| PushJob { state: &state, push }).collect();
        let mut results = vec![PushResult::default(); jobs.len()];
        let mut scratch = engine.scratch();
        let stop = Stop::never();
        let mut counted = 0;
        for _ in 0..3 {
            let before = ALLOCATIONS.get();
            engine.step_batch(&mut scratch, &jobs, &mut results, &stop);
            counted = ALLOCATIONS.get() - before;
        }
        assert!(results.iter().any(|r| r.state != state));
        assert_eq!(counted, 0);
    }
}

/// How deep bodies may end in each other, and how far a push may carry one beyond its length, metres.
const DEEPEST: f64 = 0.02;
const FARTHEST: f64 = 0.1;

/// `SOAK=10000 cargo test --release --test prism_engine soak -- --nocapture` runs as many pushes.
#[test]
fn a_soak_of_random_pushes_throws_nothing_about() {
    let total: usize = std::env::var("SOAK").ok().and_then(|n| n.parse().ok()).unwrap_or(400);
    let (mut done, mut executed, mut toppled, mut index) = (0, 0, 0, 0);
    let (mut deepest, mut farthest, mut beyond) = (0.0f64, 0.0f64, 0);
    let mut scratch: Option<Scratch> = None;
    while done < total {
        let bodies = [1, 3, 6, 8, 12, 20, 30][index % 7];
        let (scene, state) = scene(bodies, 100 + index as u64, index % 2 == 1);
        let settings = if index % 3 == 0 { PrismSettings::fine() } else { PrismSettings::fast() };
        let engine = Prism::new(Arc::clone(&scene), settings).unwrap();
        let scratch = scratch.get_or_insert_with(|| engine.scratch());
        let pushes = pushes(60, 100 + index as u64, 0.075 * (bodies as f64).sqrt());
        for (push, result) in pushes.iter().zip(run(&engine, scratch, &state, &pushes)) {
            match result.status {
                PushStatus::Executed if result.toppled.is_empty() => executed += 1,
                PushStatus::Executed => {
                    toppled += 1;
                    continue;
                }
                _ => continue,
            }
            let moved: Vec<usize> = (0..bodies).filter(|&i| result.state.poses()[i] != state.poses()[i]).collect();
            for &i in &moved {
                let pose = result.state.pose(i);
                assert!(pose.is_finite(), "scene {index} {push:?}: {pose:?}");
                let travel = (pose.position() - state.pose(i).position()).norm();
                farthest = farthest.max(travel - push.length());
                assert!(travel < push.length() + FARTHEST, "scene {index} {push:?}: body {i} went {travel}");
                for j in (0..bodies).filter(|&j| j != i) {
                    let (a, b) = (&scene.body(i).footprint, &scene.body(j).footprint);
                    let gap = pieces_gap_below(a, &pose, b, &result.state.pose(j), 0.0);
                    deepest = deepest.max(-gap);
                    beyond += usize::from(gap < -0.001);
                    assert!(gap > -DEEPEST, "scene {index} {push:?}: {i} in {j} by {gap}");
                }
            }
        }
        done += pushes.len();
        index += 1;
    }
    println!(
        "{done} pushes ({executed} executed, {toppled} toppled a body): deepest overlap {:.2} mm, {beyond} beyond 1 mm; \
         farthest beyond the push's length {:.1} mm",
        deepest * 1e3,
        farthest * 1e3
    );
    assert!(executed * 4 > done, "{executed}");
}
