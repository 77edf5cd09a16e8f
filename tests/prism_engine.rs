//! The prism engine: no allocation once warm, and many random pushes.

use std::sync::Arc;

use jostle::action::Push;
use jostle::geom::pieces_gap_below;
use jostle::physics::{Prism, PrismSettings, PushJob, PushResult, PushStatus, Scratch, Transition};
use jostle::run::Stop;
use jostle::scene::State;

#[path = "common/clutter.rs"]
mod clutter;
#[path = "common/counting.rs"]
mod counting;

use clutter::{pushes, scene};
use counting::ALLOCATIONS;

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

#[test]
fn a_body_that_leans_across_a_contact_does_not_pass_into_the_other() {
    // A light block, pushed along a sleeping one's corner, leans by almost as much as would topple it. A contact whose
    // halves were placed without the lean was farther apart than contacts live, and was dropped as soon as it was made.
    let (scene, state) = scene(6, 1033, true);
    let push = pushes(60, 1033, 0.075 * 6f64.sqrt())[5];
    for settings in [PrismSettings::fine(), PrismSettings::fast()] {
        let engine = Prism::new(Arc::clone(&scene), settings).unwrap();
        let after = run(&engine, &mut engine.scratch(), &state, &[push]).remove(0).state;
        let (a, b) = (&scene.body(0).footprint, &scene.body(4).footprint);
        let gap = pieces_gap_below(a, &after.pose(0), b, &after.pose(4), 0.0);
        assert!(after.pose(0) != state.pose(0) && gap > -0.001, "{gap}");
    }
}

/// How deep bodies may end in each other, and how far a push may carry one beyond its length, metres.
const DEEPEST: f64 = 0.006;
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
