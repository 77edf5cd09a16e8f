use std::sync::Arc;

use super::collide::{Outline, touch};
use super::model::Flat;
use super::pool::Pool;
use super::*;
use crate::action::Push;
use crate::geom::{Piece, Pose2, Shape, Vec2, piece_gap, pieces_gap, vec2};
use crate::physics::PushStatus;
use crate::physics::lanes::InstructionSet;
use crate::scene::generate::{Generator, GeneratorParams};
use crate::scene::{BodyDef, Gripper, PushTip, SceneBuilder, State};

fn presets() -> [PrismSettings; 2] {
    [PrismSettings::fast(), PrismSettings::fine()]
}

fn square() -> BodyDef {
    BodyDef::new(Shape::rectangle(0.045, 0.045))
}

fn scene(bodies: &[BodyDef], tip: Option<PushTip>) -> Arc<Scene> {
    let mut builder = SceneBuilder::new();
    for body in bodies {
        builder.add_body(body.clone()).unwrap();
    }
    if let Some(push) = tip {
        builder.gripper(Gripper { push, ..Gripper::default() });
    }
    Arc::new(builder.build().unwrap())
}

fn push(x0: f64, y0: f64, x1: f64, y1: f64) -> Push {
    Push::new(vec2(x0, y0), vec2(x1, y1))
}

fn run(engine: &Prism, state: &State, push: &Push) -> PushResult {
    engine.step(&mut engine.scratch(), state, push, &Stop::never())
}

/// Numbers in [0, 1) that fill an interval evenly.
fn even(k: usize, salt: f64) -> f64 {
    ((k + 1) as f64 * salt.sqrt()).fract()
}

/// Pushes from a ring round the scene towards its middle and past it.
fn pushes(centre: [f64; 2], numbers: std::ops::Range<usize>) -> Vec<Push> {
    numbers
        .map(|k| {
            let (a, b) = (std::f64::consts::TAU * even(k, 2.0), std::f64::consts::TAU * even(k, 3.0));
            let (from, to) = (0.05 + 0.1 * even(k, 5.0), 0.06 * even(k, 7.0));
            let [x, y] = centre;
            push(x + from * a.cos(), y + from * a.sin(), x + to * b.cos(), y + to * b.sin())
        })
        .collect()
}

fn centre(state: &State) -> [f64; 2] {
    let n = state.len() as f64;
    let (x, y) = state.iter().fold((0.0, 0.0), |s, (_, p)| (s.0 + p.x / n, s.1 + p.y / n));
    [x, y]
}

#[test]
fn every_instruction_set_order_and_thread_gives_the_same_bits() {
    let problem = Generator::new(GeneratorParams::default(), 3).unwrap().problem(1).unwrap();
    for settings in presets() {
        let engine = Prism::new(Arc::clone(&problem.scene), settings).unwrap();
        let pushes = pushes(centre(&problem.state), 0..60);
        let alone: Vec<PushResult> = pushes.iter().map(|p| run(&engine, &problem.state, p)).collect();
        let moved = alone.iter().filter(|r| r.status == PushStatus::Executed && r.state != problem.state).count();
        assert!(moved > 15, "only {moved} pushes move something");
        for set in InstructionSet::ALL {
            // A pool that was used, and the jobs in another order.
            let mut pool = Pool::with_set(set);
            for order in [7, 11, 1] {
                let turned = |k: usize| (k * order) % pushes.len();
                let jobs: Vec<PushJob> =
                    (0..pushes.len()).map(|k| PushJob { state: &problem.state, push: pushes[turned(k)] }).collect();
                let mut results = vec![PushResult::default(); jobs.len()];
                pool.run(&engine, &jobs, &mut results, &Stop::never());
                for (k, result) in results.iter().enumerate() {
                    assert_eq!(*result, alone[turned(k)], "{set:?}, push {}", turned(k));
                }
            }
        }
        for threads in [2, 5] {
            let share = pushes.len().div_ceil(threads);
            let work = |part: &[Push]| {
                let jobs: Vec<PushJob> = part.iter().map(|&push| PushJob { state: &problem.state, push }).collect();
                let mut results = vec![PushResult::default(); jobs.len()];
                engine.step_batch(&mut engine.scratch(), &jobs, &mut results, &Stop::never());
                results
            };
            let results: Vec<PushResult> = std::thread::scope(|scope| {
                let work = &work;
                let parts: Vec<_> = pushes.chunks(share).map(|part| scope.spawn(move || work(part))).collect();
                parts.into_iter().flat_map(|part| part.join().unwrap()).collect()
            });
            assert!(results == alone, "{threads} threads");
        }
    }
}

#[test]
fn a_push_off_the_centre_turns_a_block_as_quasi_statics_says() {
    // A narrow tip that sticks to the face at an offset d: the ellipsoidal limit surface gives
    // w = -d v / (a^2 + c^2 + d^2), with a the depth of the face and c the greatest torque over the greatest force.
    let tip = PushTip { width: 0.004, thickness: 0.01, clearance: 0.0 };
    let scene = scene(&[square()], Some(tip));
    let state = State::new([Pose2::new(0.5, 0.0, 0.0)]);
    for settings in presets() {
        let engine = Prism::new(Arc::clone(&scene), settings).unwrap();
        let mut before = 0.0;
        for d in [0.006, 0.010, 0.014] {
            let x = 0.5 - 0.0225 - 0.001 - 0.005;
            let travel = 0.02;
            let turned = [1.0, -1.0].map(|side| {
                let result = run(&engine, &state, &push(x, side * d, x + travel, side * d));
                -side * result.state.pose(0).theta
            });
            // The load stands on the corners, 32 mm from the middle.
            let quasi_static = d * travel / (0.0235_f64.powi(2) + 0.032_f64.powi(2) + d * d);
            for turned in turned {
                let ratio = turned / quasi_static;
                assert!((0.5..1.6).contains(&ratio), "offset {d}: turned {turned}, expected {quasi_static}");
            }
            assert!(turned[0] > before, "the farther out, the more it turns");
            before = turned[0];
        }
    }
}

#[test]
fn a_thin_plate_topples_and_says_so() {
    // The tip reaches down to 12 mm: a block is tipped over its front edge where 0.55 times that is more than half its
    // thickness.
    let plate = |thick: f64| BodyDef { height: 0.15, ..BodyDef::new(Shape::rectangle(thick, 0.06)) };
    for settings in presets() {
        for (thick, topples) in [(0.008, true), (0.03, false)] {
            let scene = scene(&[plate(thick), square()], None);
            let state = State::new([Pose2::new(0.5, 0.0, 0.0), Pose2::new(0.5, 0.2, 0.0)]);
            let engine = Prism::new(scene, settings).unwrap();
            let result = run(&engine, &state, &push(0.45, 0.0, 0.53, 0.0));
            assert_eq!(result.status, PushStatus::Executed);
            assert_eq!(result.toppled.contains(0), topples, "thickness {thick}");
            assert!(!result.toppled.contains(1));
            assert!(result.state.iter().all(|(_, pose)| pose.is_finite()));
        }
    }
}

#[test]
fn a_chain_of_ten_blocks_is_pushed_as_a_whole() {
    let count = 10;
    let scene = scene(&vec![square(); count], None);
    // Gaps of 2 mm: border against border.
    let state = State::new((0..count).map(|i| Pose2::new(0.3 + 0.047 * i as f64, 0.0, 0.0)));
    for settings in presets() {
        let engine = Prism::new(Arc::clone(&scene), settings).unwrap();
        let start = 0.3 - 0.0225 - 0.011 - 0.005;
        let result = run(&engine, &state, &push(start, 0.0, start + 0.035, 0.0));
        for i in 0..count {
            let moved = result.state.pose(i).x - state.pose(i).x;
            assert!((moved - 0.031).abs() < 0.006, "block {i} of {count} moved {moved}");
        }
        for i in 1..count {
            let gap = result.state.pose(i).x - result.state.pose(i - 1).x - 0.045;
            assert!(gap > -5e-4, "block {i} ends {gap} in its neighbour");
        }
    }
}

#[test]
fn mass_height_and_friction_of_each_body_count() {
    let state = State::new([Pose2::new(0.5, 0.0, 0.0), Pose2::new(0.547, 0.012, 0.0)]);
    let moved = |first: BodyDef| {
        let engine = Prism::new(scene(&[first, square()], None), PrismSettings::fine()).unwrap();
        let result = run(&engine, &state, &push(0.46, 0.0, 0.51, 0.0));
        assert!(result.toppled.is_empty());
        (result.state.pose(0), result.state.pose(1))
    };
    let plain = moved(square());
    for (what, other) in [
        ("mass", BodyDef { mass: 1.0, ..square() }),
        ("friction", BodyDef { friction: 0.9, ..square() }),
        ("height", BodyDef { height: 0.02, ..square() }),
    ] {
        assert_ne!(moved(other), plain, "{what}");
    }
}

#[test]
fn the_edges_of_the_last_look_do_not_change_what_is_found() {
    let ring = |n: usize, r: f64| -> Vec<Vec2> {
        (0..n).map(|k| std::f64::consts::TAU * k as f64 / n as f64).map(|a| vec2(r * a.cos(), r * a.sin())).collect()
    };
    let long = vec![vec2(-0.045, -0.0225), vec2(0.045, -0.0225), vec2(0.045, 0.0225), vec2(-0.045, 0.0225)];
    let shapes = [long, ring(20, 0.02), ring(3, 0.03), ring(5, 0.025)];
    let placed = |points: &[Vec2], pose: &Pose2| -> (Vec<Flat>, Vec<Flat>, Flat) {
        let at: Vec<Vec2> = points.iter().map(|p| pose.transform_point(*p)).collect();
        let normal = |i: usize| (at[(i + 1) % at.len()] - at[i]).normalize();
        let normals = (0..at.len()).map(normal).map(|d| [d.y as f32, -d.x as f32]).collect();
        (at.iter().map(|p| [p.x as f32, p.y as f32]).collect(), normals, [pose.x as f32, pose.y as f32])
    };
    let mut met = 0;
    for k in 0..4000 {
        let (a, b) = (&shapes[k % 4], &shapes[k / 4 % 4]);
        let first = Pose2::new(0.0, 0.0, 6.0 * even(k, 2.0));
        let turn = 6.3 * even(k, 3.0);
        let apart = 0.01 + 0.06 * even(k, 5.0);
        let second = Pose2::new(apart * turn.cos(), apart * turn.sin(), 6.0 * even(k, 7.0));
        let pieces = [a, b].map(|points| Piece::Convex(points.clone()));
        let gap = piece_gap(&pieces[0], &pieces[1], &first.inverse().compose(&second).frame(), f64::INFINITY);
        let ((ca, na, ma), (cb, nb, mb)) = (placed(a, &first), placed(b, &second));
        let reach = 0.004;
        for hint in 0..a.len() * b.len() {
            let mut axes = [(hint % a.len()) as u16, (hint / a.len()) as u16];
            let one = Outline::Polygon { corners: &ca, normals: &na, middle: ma };
            let two = Outline::Polygon { corners: &cb, normals: &nb, middle: mb };
            match touch(one, two, reach, &mut axes) {
                Ok(found) => {
                    met += 1;
                    assert!((f64::from(found.gap) - gap).abs() < 0.001, "{k} {hint}: {} is {gap}", found.gap);
                }
                Err(bound) => assert!(
                    gap > f64::from(bound) - 1e-6 && gap > f64::from(reach) - 0.001,
                    "{k} {hint}: {bound}, {gap}"
                ),
            }
        }
    }
    assert!(met > 1000, "{met}");
}

/// Greatest overlap of any two bodies, metres.
fn overlap(scene: &Scene, state: &State) -> f64 {
    let mut deepest: f64 = 0.0;
    for (i, a) in state.iter() {
        for (j, b) in state.iter().filter(|(j, _)| *j > i) {
            let (f, g) = (&scene.body(i).footprint, &scene.body(j).footprint);
            if (a.position() - b.position()).norm() < f.radius + g.radius {
                deepest = deepest.max(-pieces_gap(f, &a, g, &b));
            }
        }
    }
    deepest
}

/// `JOSTLE_SOAK=100000` makes that many pushes for each preset.
#[test]
fn random_pushes_in_random_scenes_neither_throw_nor_crush_bodies() {
    let wanted = std::env::var("JOSTLE_SOAK").ok().and_then(|n| n.parse().ok()).unwrap_or(400_usize);
    let generator = Generator::new(GeneratorParams { bodies: 5..=12, ..GeneratorParams::default() }, 11).unwrap();
    let a_scene = 40;
    for settings in presets() {
        let (mut executed, mut toppled, mut deepest, mut farthest) = (0, 0, 0.0_f64, 0.0_f64);
        for index in 0..wanted.div_ceil(a_scene) {
            let problem = generator.problem(index as u64).unwrap();
            let engine = Prism::new(Arc::clone(&problem.scene), settings).unwrap();
            let pushes = pushes(centre(&problem.state), a_scene * index..a_scene * (index + 1));
            let jobs: Vec<PushJob> = pushes.iter().map(|&push| PushJob { state: &problem.state, push }).collect();
            let mut results = vec![PushResult::default(); jobs.len()];
            engine.step_batch(&mut engine.scratch(), &jobs, &mut results, &Stop::never());
            let before = overlap(&problem.scene, &problem.state);
            for (push, result) in pushes.iter().zip(&results).filter(|(_, r)| r.status == PushStatus::Executed) {
                executed += 1;
                toppled += usize::from(!result.toppled.is_empty());
                let more = overlap(&problem.scene, &result.state) - before;
                deepest = deepest.max(more);
                assert!(more < 0.002, "scene {index}, {push:?}: bodies end {more} m in each other");
                for (i, pose) in result.state.iter() {
                    assert!(pose.is_finite(), "scene {index}, {push:?}: body {i}");
                    let moved = (pose.position() - problem.state.pose(i).position()).norm();
                    farthest = farthest.max(moved - push.length());
                    assert!(moved < push.length() + 0.03, "scene {index}, {push:?}: body {i} moved {moved}");
                }
            }
        }
        println!(
            "{executed} pushes of {wanted}, step {} s: {toppled} toppled something; overlap grew by {:.2} mm at most; no \
             body went farther than its push and {:.1} mm",
            settings.time_step,
            deepest * 1e3,
            farthest * 1e3
        );
        assert!(executed * 4 > wanted, "{executed}");
    }
}

#[test]
fn bad_constants_are_refused_by_name() {
    let mut settings = PrismSettings::fast();
    settings.border = f64::NAN;
    let scene = scene(&[square()], None);
    let error = Prism::new(scene, settings).err().unwrap().to_string();
    assert!(error.starts_with("physics.border: "), "{error}");
    assert!(PrismSettings::by_name("slow").is_err());
}
