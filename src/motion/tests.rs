//! Whole queries, checked against dense sampling with the distances of `geom`.

use std::sync::Arc;

use proptest::prelude::*;

use super::*;
use crate::geom::{Pose2, Shape, normalize_angle, pieces_gap, vec2};
use crate::run::{Budget, Key, Stream};
use crate::scene::{BodyDef, LeaveRule, Scene, SceneBuilder, State, Workspace};

const WIDTH: f64 = 0.78;
const DEPTH: f64 = 0.52;

fn scene_of(shapes: Vec<Shape>) -> Arc<Scene> {
    let mut builder = SceneBuilder::new();
    for shape in shapes {
        builder.add_body(BodyDef::new(shape)).unwrap();
    }
    let mut workspace = Workspace::rectangle(vec2(0.0, 0.0), vec2(WIDTH, DEPTH));
    workspace.leave_rule = LeaveRule::Footprint;
    builder.workspace(workspace);
    Arc::new(builder.build().unwrap())
}

fn planner(shapes: Vec<Shape>) -> PathPlanner {
    PathPlanner::new(scene_of(shapes), PathParams::default()).unwrap()
}

fn l_shape(size: f64, thick: f64) -> Shape {
    let (s, t) = (size, thick);
    Shape::Polygon(vec![[0.0, 0.0], [s, 0.0], [s, t], [t, t], [t, s], [0.0, s]])
}

/// A body of any kind, 4 to 20 cm.
fn any_shape(random: &mut Stream) -> Shape {
    match random.index(4) {
        0 => Shape::rectangle(random.uniform(0.04, 0.2), random.uniform(0.04, 0.1)),
        1 => Shape::Disc { radius: random.uniform(0.02, 0.06) },
        2 => l_shape(random.uniform(0.08, 0.18), random.uniform(0.02, 0.05)),
        _ => {
            let n = 3 + random.index(4);
            let r = random.uniform(0.03, 0.09);
            let turn = random.uniform(0.0, 6.0);
            let corner = |k: usize| turn + (k as f64 + 0.5) * std::f64::consts::TAU / n as f64;
            Shape::ConvexPolygon((0..n).map(|k| [r * corner(k).cos(), 0.7 * r * corner(k).sin()]).collect())
        }
    }
}

fn any_pose(random: &mut Stream) -> Pose2 {
    Pose2::new(random.uniform(0.0, WIDTH), random.uniform(0.0, DEPTH), random.uniform(-3.2, 3.2))
}

/// A planner and a state whose bodies keep the clearance; fewer bodies where they do not fit.
fn any_table(seed: u64, bodies: usize) -> (PathPlanner, State, Stream) {
    let mut random = Key::new(seed).stream();
    let shapes: Vec<Shape> = (0..bodies).map(|_| any_shape(&mut random)).collect();
    let planner = planner(shapes);
    let mut state = State::new(vec![Pose2::IDENTITY; bodies]);
    let mut scratch = PathScratch::new();
    (0..bodies).for_each(|body| state.set_present(body, false));
    for body in 0..bodies {
        for _ in 0..300 {
            let pose = any_pose(&mut random);
            if planner.pose_is_free(&state, body, &pose, &mut scratch) {
                state.set_pose(body, pose);
                state.set_present(body, true);
                break;
            }
        }
    }
    (planner, state, random)
}

fn least_gap(scene: &Scene, state: &State, body: usize, pose: &Pose2) -> f64 {
    let footprint = &scene.body(body).footprint;
    let gaps = state.iter().filter(|(other, _)| *other != body);
    gaps.map(|(other, at)| pieces_gap(footprint, pose, &scene.body(other).footprint, &at)).fold(f64::INFINITY, f64::min)
}

fn inset(scene: &Scene, body: usize, pose: &Pose2) -> f64 {
    let (footprint, frame, w) = (&scene.body(body).footprint, pose.frame(), scene.workspace());
    let reach = |x: f64, y: f64| footprint.support(frame.inverse_vector(vec2(x, y)));
    let right = w.max[0] - pose.x - reach(1.0, 0.0);
    let left = pose.x - reach(-1.0, 0.0) - w.min[0];
    let up = w.max[1] - pose.y - reach(0.0, 1.0);
    let down = pose.y - reach(0.0, -1.0) - w.min[1];
    right.min(left).min(up).min(down)
}

fn along(a: &Pose2, b: &Pose2, t: f64) -> Pose2 {
    Pose2::new(a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.theta + normalize_angle(b.theta - a.theta) * t)
}

/// Samples each motion every 0.2 mm, or nearly.
fn check_path(scene: &Scene, state: &State, body: usize, waypoints: &[Pose2], need: f64) -> Result<(), String> {
    for pair in waypoints.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        let turn = normalize_angle(b.theta - a.theta).abs() * scene.body(body).footprint.radius;
        let steps = (((b.position() - a.position()).norm() + turn) / 2e-4).ceil().max(1.0) as usize;
        for k in 0..=steps {
            let pose = along(a, b, k as f64 / steps as f64);
            let (gap, inset) = (least_gap(scene, state, body, &pose), inset(scene, body, &pose));
            if gap < need || inset < -2.0 * EDGE_TOLERANCE {
                return Err(format!("{pose:?}: gap {gap}, inset {inset}"));
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_motion_is_free_exactly_if_no_instant_of_it_is_in_conflict(seed in 0..u64::MAX) {
        let (planner, state, mut random) = any_table(seed, 5);
        let mut scratch = PathScratch::new();
        let clearance = planner.params().clearance;
        for body in 0..5 {
            let (a, b) = (any_pose(&mut random), any_pose(&mut random));
            // Also short motions, which are free more often.
            for b in [b, along(&a, &b, 0.1)] {
                let free = planner.motion_is_free(&state, body, &a, &b, &mut scratch);
                if free {
                    let checked = check_path(planner.scene(), &state, body, &[a, b], clearance - SWEEP_SLACK);
                    prop_assert!(checked.is_ok(), "{checked:?}");
                } else {
                    let checked = check_path(planner.scene(), &state, body, &[a, b], clearance + 1e-4);
                    prop_assert!(checked.is_err(), "body {body} from {a:?} to {b:?} is free");
                }
            }
        }
    }

    #[test]
    fn a_path_that_is_found_keeps_clear_all_the_way(seed in 0..u64::MAX) {
        let (planner, state, mut random) = any_table(seed, 6);
        let mut scratch = PathScratch::new();
        for body in state.present().iter() {
            let from = state.pose(body);
            let to = any_pose(&mut random);
            let outcome =
                planner.path(&state, body, &from, &to, PathLimits::default(), Key::new(seed), &mut scratch);
            if let PathOutcome::Found(path) = outcome {
                prop_assert_eq!(path.waypoints[0].position(), from.position());
                prop_assert_eq!(path.waypoints[path.waypoints.len() - 1].position(), to.position());
                let ends = [from, to].map(|end| least_gap(planner.scene(), &state, body, &end));
                let need = ends.into_iter().fold(planner.params().clearance, f64::min) - 1.01 * SWEEP_SLACK;
                let checked = check_path(planner.scene(), &state, body, &path.waypoints, need);
                prop_assert!(checked.is_ok(), "{checked:?}");
                prop_assert!((planner.length(&path.waypoints) - path.length).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_goal_is_never_called_enclosed_if_a_random_walk_gets_there(seed in 0..u64::MAX) {
        let (planner, state, mut random) = any_table(seed, 7);
        let mut scratch = PathScratch::new();
        for body in state.present().iter() {
            let from = state.pose(body);
            let mut to = from;
            for _ in 0..400 {
                let step = Pose2::new(
                    to.x + random.uniform(-0.05, 0.05),
                    to.y + random.uniform(-0.05, 0.05),
                    to.theta + random.uniform(-0.5, 0.5),
                );
                if planner.motion_is_free(&state, body, &to, &step, &mut scratch) {
                    to = step;
                }
            }
            // No search before the grid is asked.
            let params = PathParams { quick_iterations: 0, ..*planner.params() };
            let grid_only = PathPlanner::new(planner.scene().clone(), params).unwrap();
            let limits = PathLimits { iterations: Some(0), stop: None };
            let outcome = grid_only.path(&state, body, &from, &to, limits, Key::new(1), &mut scratch);
            prop_assert!(outcome != PathOutcome::Enclosed, "body {body} from {from:?} to {to:?}");
        }
    }
}

/// A wall across the depth of the table, 2 mm thin, with a slot of this width in the middle.
fn wall_with_slot(slot: f64) -> Vec<(Shape, Pose2)> {
    let half = (DEPTH - slot) / 2.0;
    let part = || Shape::rectangle(0.002, half);
    let x = WIDTH / 2.0;
    vec![(part(), Pose2::new(x, half / 2.0, 0.0)), (part(), Pose2::new(x, DEPTH - half / 2.0, 0.0))]
}

/// The stick from one side to the other, turned across the slot at both ends.
fn through(slot: f64, stick: Shape) -> (PathOutcome, PathPlanner, State) {
    let mut bodies = vec![(stick, Pose2::new(0.15, 0.26, 1.5))];
    bodies.extend(wall_with_slot(slot));
    let planner = planner(bodies.iter().map(|b| b.0.clone()).collect());
    let state = State::new(bodies.iter().map(|b| b.1));
    let to = Pose2::new(0.63, 0.26, 1.5);
    let mut scratch = PathScratch::new();
    let outcome = planner.path(&state, 0, &state.pose(0), &to, PathLimits::default(), Key::new(3), &mut scratch);
    (outcome, planner, state)
}

#[test]
fn a_thin_wall_is_not_jumped_over() {
    let (outcome, ..) = through(0.0, Shape::rectangle(0.12, 0.03));
    assert_eq!(outcome, PathOutcome::Enclosed);
}

#[test]
fn a_slot_is_passed_by_turning() {
    for slot in [0.04, 0.05, 0.08] {
        let (outcome, planner, state) = through(slot, Shape::rectangle(0.12, 0.03));
        let path = outcome.path().unwrap_or_else(|| panic!("{slot}: {outcome:?}"));
        assert!(path.waypoints.len() > 2);
        check_path(planner.scene(), &state, 0, &path.waypoints, 0.0019 - 1e-6).unwrap();
    }
}

#[test]
fn a_slot_too_narrow_for_the_body_however_it_turns_is_certainly_no_way() {
    assert_eq!(through(0.025, Shape::rectangle(0.12, 0.06)).0, PathOutcome::Enclosed);
}

#[test]
fn a_straight_motion_that_is_free_is_the_path() {
    let planner = planner(vec![l_shape(0.1, 0.03), Shape::Disc { radius: 0.03 }]);
    let state = State::new([Pose2::new(0.1, 0.1, 0.0), Pose2::new(0.4, 0.45, 0.0)]);
    let to = Pose2::new(0.6, 0.2, 2.5);
    let limits = PathLimits { iterations: Some(0), stop: None };
    let outcome = planner.path(&state, 0, &state.pose(0), &to, limits, Key::new(0), &mut PathScratch::new());
    let path = outcome.path().expect("nothing is in the way");
    assert_eq!(path.waypoints.len(), 2);
    let expected = 0.5f64.hypot(0.1) + 0.1 * 2.5;
    assert!((path.length - expected).abs() < 1e-6, "{} {expected}", path.length);
}

#[test]
fn ends_that_are_not_free_are_enclosed() {
    let planner = planner(vec![Shape::rectangle(0.1, 0.1), Shape::rectangle(0.1, 0.1)]);
    let state = State::new([Pose2::new(0.2, 0.2, 0.0), Pose2::new(0.5, 0.2, 0.0)]);
    let mut scratch = PathScratch::new();
    for to in [Pose2::new(0.5, 0.25, 0.0), Pose2::new(0.04, 0.2, 0.0), Pose2::new(f64::NAN, 0.2, 0.0)] {
        let outcome = planner.path(&state, 0, &state.pose(0), &to, PathLimits::default(), Key::new(0), &mut scratch);
        assert_eq!(outcome, PathOutcome::Enclosed, "{to:?}");
    }
}

#[test]
fn a_body_nearer_than_the_clearance_may_be_drawn_away() {
    let planner = planner(vec![Shape::rectangle(0.1, 0.1), Shape::rectangle(0.1, 0.1)]);
    // A gap of half a millimetre.
    let state = State::new([Pose2::new(0.2, 0.2, 0.0), Pose2::new(0.3005, 0.2, 0.0)]);
    let (from, to) = (state.pose(0), Pose2::new(0.2, 0.4, 0.0));
    let mut scratch = PathScratch::new();
    assert!(!planner.pose_is_free(&state, 0, &from, &mut scratch));
    assert!(!planner.motion_is_free(&state, 0, &from, &to, &mut scratch));
    assert_eq!(planner.free_fraction(&state, 0, &from, &to, &mut scratch), 1.0);
    let outcome = planner.path(&state, 0, &from, &to, PathLimits::default(), Key::new(0), &mut scratch);
    assert_eq!(outcome.path().map(|p| p.waypoints.len()), Some(2));
    let blockers = planner.blockers(&state, 0, &from, &mut scratch);
    assert_eq!(blockers.iter().collect::<Vec<_>>(), [1]);
    assert!((planner.pose_gap(&state, 0, &from, 1.0, &mut scratch) - 0.0005).abs() < 1e-7);
}

#[test]
fn a_body_gets_as_far_as_the_first_thing_in_its_way() {
    let planner = planner(vec![Shape::rectangle(0.1, 0.1), Shape::rectangle(0.1, 0.1)]);
    let state = State::new([Pose2::new(0.2, 0.2, 0.0), Pose2::new(0.5, 0.2, 0.0)]);
    let (from, to) = (state.pose(0), Pose2::new(0.7, 0.2, 0.0));
    let mut scratch = PathScratch::new();
    let part = planner.free_fraction(&state, 0, &from, &to, &mut scratch);
    let reached = along(&from, &to, part);
    // The blocks touch at x = 0.4; clearance and a millimetre stay.
    assert!((reached.x - 0.397).abs() < 2e-4, "{reached:?}");
    assert!(planner.pose_is_free(&state, 0, &reached, &mut scratch));
}

#[test]
fn answers_depend_on_nothing_but_the_question() {
    let mut scratch = PathScratch::new();
    let mut found = 0;
    for seed in 0..20 {
        let (first, state, mut random) = any_table(seed, 6);
        let second = PathPlanner::new(first.scene().clone(), *first.params()).unwrap();
        // Of one body after the other several: what was found out for one question may serve the next.
        let bodies = state.present().iter().flat_map(|body| [body; 3]);
        let queries: Vec<_> = bodies.map(|body| (body, state.pose(body), any_pose(&mut random))).collect();
        let mut ask = |planner: &PathPlanner, q: &(usize, Pose2, Pose2)| {
            planner.path(&state, q.0, &q.1, &q.2, PathLimits::default(), Key::new(9), &mut scratch)
        };
        let forward: Vec<_> = queries.iter().map(|q| ask(&first, q)).collect();
        let mut backward: Vec<_> = queries.iter().rev().map(|q| ask(&second, q)).collect();
        backward.reverse();
        assert_eq!(forward, backward);
        // Each with new memory.
        let third = PathPlanner::new(first.scene().clone(), *first.params()).unwrap();
        let alone: Vec<_> = queries
            .iter()
            .map(|q| third.path(&state, q.0, &q.1, &q.2, PathLimits::default(), Key::new(9), &mut PathScratch::new()))
            .collect();
        assert_eq!(forward, alone);
        // And once more, from the cache.
        let again: Vec<_> = queries.iter().map(|q| ask(&first, q)).collect();
        assert_eq!(forward, again);
        found += forward.iter().filter(|o| o.path().is_some()).count();
    }
    assert!(found > 10, "{found}");
}

#[test]
fn a_requested_stop_interrupts_the_search() {
    let (_, planner, state) = through(0.12, Shape::rectangle(0.12, 0.03));
    let stop = Budget::default().start(&[]);
    stop.interrupt();
    let limits = PathLimits { iterations: None, stop: Some(&stop) };
    let to = Pose2::new(0.63, 0.2, 1.5);
    let mut scratch = PathScratch::new();
    assert_eq!(
        planner.path(&state, 0, &state.pose(0), &to, limits, Key::new(3), &mut scratch),
        PathOutcome::Interrupted
    );
    // It was not kept as an answer.
    let outcome = planner.path(&state, 0, &state.pose(0), &to, PathLimits::default(), Key::new(3), &mut scratch);
    assert!(outcome.path().is_some(), "{outcome:?}");
}

#[test]
fn parameters_that_cannot_be_worked_with_are_refused_by_name() {
    let scene = scene_of(vec![Shape::Disc { radius: 0.02 }]);
    let good = PathParams::default();
    for (params, field) in [
        (PathParams { clearance: 0.0, ..good }, "paths.clearance"),
        (PathParams { turn_weight: -1.0, ..good }, "paths.turn_weight"),
        (PathParams { step: f64::NAN, ..good }, "paths.step"),
        (PathParams { cell: 0.0, ..good }, "paths.cell"),
        (PathParams { headings: 0, ..good }, "paths.headings"),
    ] {
        match PathPlanner::new(scene.clone(), params) {
            Err(crate::Error::Argument { field: got, .. }) => assert_eq!(got, field),
            other => panic!("{field}: {other:?}"),
        }
    }
}
