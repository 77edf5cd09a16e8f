//! Grasps and pushes that were tried and failed, also where every look makes the scene anew.

use std::sync::Arc;

use jostle::action::{Action, Grasp, Push};
use jostle::geom::{Pose2, Shape};
use jostle::physics;
use jostle::plan::{Control, Outcome, Planner, PlannerOptions, Reason};
use jostle::run::{Budget, Key, Stop, Stream};
use jostle::scene::{BodyDef, Gripper, Problem, SceneBuilder, State};

/// A cube that can be grasped from two sides, and another far off.
fn open() -> Problem {
    looked_at(&[[0.5, 0.0], [0.5, 0.15]], 0, None)
}

/// Cubes at these places as a camera sees them: with noise, the sides differ by 0.1 mm, places by half a millimetre.
fn looked_at(places: &[[f64; 2]], target: usize, mut noise: Option<&mut Stream>) -> Problem {
    let mut by = |far: f64| noise.as_mut().map_or(0.0, |draw| draw.uniform(-far, far));
    let mut builder = SceneBuilder::new();
    let mut poses = Vec::new();
    for [x, y] in places {
        builder.add_body(BodyDef::new(Shape::rectangle(0.045 + by(1e-4), 0.045 + by(1e-4)))).unwrap();
        poses.push(Pose2::new(x + by(5e-4), y + by(5e-4), by(0.005)));
    }
    Problem::new("open", Arc::new(builder.build().unwrap()), State::new(poses), target).unwrap()
}

fn solve(planner: &mut Planner, problem: &Problem) -> jostle::plan::Plan {
    planner.solve(problem, &Control::default()).unwrap()
}

/// About the same grasp of a body that was not moved.
fn like(a: &Grasp, b: &Grasp) -> bool {
    let off = (a.position[0] - b.position[0]).hypot(a.position[1] - b.position[1]);
    (a.angle - b.angle).sin().abs() < 0.2 && off < 0.006
}

fn planner(name: &str) -> Planner {
    let budget = Budget::iterations(200);
    Planner::new(PlannerOptions { planner: name.into(), budget, threads: 1, ..PlannerOptions::default() }).unwrap()
}

/// A cube in the middle of a cross of cubes: it cannot be grasped before one of them is pushed away.
const CROSS: [[f64; 2]; 5] = [[0.5, 0.0], [0.547, 0.0], [0.453, 0.0], [0.5, 0.047], [0.5, -0.047]];

#[test]
fn a_grasp_that_failed_is_not_offered_again_before_the_bodies_were_pushed() {
    for name in ["hedge", "pmbs", "mcts"] {
        let options =
            PlannerOptions { planner: name.into(), budget: Budget::iterations(200), ..PlannerOptions::default() };
        let mut planner = Planner::new(options.clone()).unwrap();
        let problem = open();
        let first = solve(&mut planner, &problem);
        let Action::Grasp(grasp) = first.actions[0].action else { panic!("{name}: {first:?}") };

        // First from the other sides, then pushes.
        let mut failed = vec![grasp];
        planner.failed(&Action::Grasp(grasp));
        let second = loop {
            let plan = solve(&mut planner, &problem);
            let Action::Grasp(other) = plan.actions[0].action else { break plan };
            assert!(!failed.iter().any(|old| like(old, &other)), "{name}: {other:?} after {failed:?}");
            planner.failed(&Action::Grasp(other));
            failed.push(other);
            assert!(failed.len() < 6, "{name}: {failed:?}");
        };
        assert!(failed.len() >= 2, "{name}: a cube has two pairs of faces");
        let Action::Push(push) = second.actions[0].action else { panic!("{name}: {second:?}") };
        assert_ne!(second.outcome, Outcome::Infeasible, "{name}");

        let engine = physics::engine(&options.model().unwrap(), Arc::clone(&problem.scene)).unwrap();
        let after = engine.step(&mut engine.scratch(), &problem.state, &push, &Stop::never()).state;
        planner.advance(&second.actions[0].action).unwrap();
        let moved = Problem { state: after, ..problem.clone() };
        let third = solve(&mut planner, &moved);
        assert!(matches!(third.actions[0].action, Action::Grasp(_)), "{name}: {third:?}");

        // A push that failed says nothing of grasps, and what was reset is as new.
        let mut fresh = Planner::new(options).unwrap();
        fresh.failed(&Action::Push(push));
        assert_eq!(solve(&mut fresh, &problem).hash_bits(), first.hash_bits(), "{name}");
        fresh.failed(&Action::Grasp(grasp));
        fresh.reset();
        assert_eq!(solve(&mut fresh, &problem).hash_bits(), first.hash_bits(), "{name}");
    }
}

#[test]
fn a_grasp_that_failed_is_remembered_where_the_scene_is_made_anew() {
    let mut draw = Key::new(4).stream();
    for name in ["hedge", "pmbs", "mcts"] {
        let mut planner = planner(name);
        let first = solve(&mut planner, &open());
        let Action::Grasp(failed) = first.actions[0].action else { panic!("{name}: {first:?}") };
        planner.failed(&first.actions[0].action);
        let again = |plan: jostle::plan::Plan| matches!(plan.actions[0].action, Action::Grasp(g) if like(&failed, &g));
        for look in 0..4 {
            let anew = looked_at(&[[0.5, 0.0], [0.5, 0.15]], 0, Some(&mut draw));
            assert!(!again(solve(&mut planner, &anew)), "{name}, look {look}");
            // Labels of a camera come in any order.
            let swapped = looked_at(&[[0.5, 0.15], [0.5, 0.0]], 1, Some(&mut draw));
            assert!(!again(solve(&mut planner, &swapped)), "{name}, look {look}");
        }
        // The other cube is another target.
        let other = looked_at(&[[0.5, 0.0], [0.5, 0.15]], 1, None);
        assert!(matches!(solve(&mut planner, &other).actions[0].action, Action::Grasp(_)), "{name}");
        // And what failed on the first is not forgotten for it.
        assert!(!again(solve(&mut planner, &open())), "{name}");
    }
}

/// A half-cube scores best across its 22.5 mm; where that does not hold, it is gripped along its long side.
#[test]
fn the_other_way_to_grip_a_half_cube_is_tried_before_a_push() {
    let mut builder = SceneBuilder::new();
    builder.add_body(BodyDef::new(Shape::rectangle(0.045, 0.0225))).unwrap();
    let state = State::new([Pose2::new(0.5, 0.0, 0.4)]);
    let problem = Problem::new("half", Arc::new(builder.build().unwrap()), state, 0).unwrap();
    for name in ["hedge", "pmbs", "mcts"] {
        let mut planner = planner(name);
        let width = |plan: &jostle::plan::Plan| match plan.actions[0].action {
            Action::Grasp(grasp) => grasp.width,
            Action::Push(push) => panic!("{name}: {push:?}"),
        };
        let first = solve(&mut planner, &problem);
        assert!((width(&first) - 0.0225).abs() < 1e-3, "{name}: {first:?}");
        planner.failed(&first.actions[0].action);
        let second = solve(&mut planner, &problem);
        assert!(width(&second) > 0.04, "{name}: {second:?}");
    }
}

/// A gripper whose score is the chance of keeping asks for less where grasps failed, and not for nothing: it pushes at last.
#[test]
fn a_gripper_with_chances_pushes_too_where_grasps_fail() {
    let mut builder = SceneBuilder::new();
    builder.gripper(Gripper::robotiq_2f85_kept());
    builder.add_body(BodyDef::new(Shape::rectangle(0.045, 0.045))).unwrap();
    let problem =
        Problem::new("lone", Arc::new(builder.build().unwrap()), State::new([Pose2::new(0.5, 0.0, 0.0)]), 0).unwrap();
    for name in ["hedge", "pmbs", "mcts"] {
        let mut planner = planner(name);
        let mut grasps = 0;
        while let Action::Grasp(_) = solve(&mut planner, &problem).actions[0].action {
            let plan = solve(&mut planner, &problem);
            planner.failed(&plan.actions[0].action);
            grasps += 1;
            assert!(grasps < 6, "{name}: {plan:?}");
        }
        assert!(grasps >= 2, "{name}");
    }
}

#[test]
fn a_push_that_failed_does_not_come_again_before_another_was_executed() {
    let near = |a: &Push, b: &Push| (a.start() - b.start()).norm() < 0.005 && a.direction().dot(&b.direction()) > 0.99;
    let mut draw = Key::new(5).stream();
    for (name, noisy) in [("hedge", false), ("hedge", true), ("pmbs", false), ("pmbs", true), ("mcts", true)] {
        let mut planner = planner(name);
        let mut failed: Vec<Push> = Vec::new();
        for _ in 0..6 {
            let plan = solve(&mut planner, &looked_at(&CROSS, 0, noisy.then_some(&mut draw)));
            let Action::Push(push) = plan.actions[0].action else { panic!("{name}: {plan:?}") };
            assert!(!failed.iter().any(|old| near(old, &push)), "{name}, noisy {noisy}: {push:?} after {failed:?}");
            planner.failed(&plan.actions[0].action);
            failed.push(push);
        }
        // Once another was executed it is one of many again.
        planner.advance(&Action::Push(Push { start: [0.7, 0.2], end: [0.6, 0.2], body: None })).unwrap();
        let plan = solve(&mut planner, &looked_at(&CROSS, 0, None));
        let fresh = solve(&mut self::planner(name), &looked_at(&CROSS, 0, None));
        assert_eq!(plan.actions[0].action, fresh.actions[0].action, "{name}");
    }
}

#[test]
fn where_everything_failed_the_outcome_says_so() {
    let mut planner = planner("pmbs");
    let problem = looked_at(&CROSS, 0, None);
    let mut tried = 0;
    let plan = loop {
        let plan = solve(&mut planner, &problem);
        let Some(action) = plan.actions.first() else { break plan };
        planner.failed(&action.action);
        tried += 1;
        assert!(tried < 400, "{plan:?}");
    };
    assert!(tried > 5);
    assert_eq!(plan.outcome, Outcome::Infeasible);
    let said = plan.reasons.contains(&Reason::Failed { grasps: 0, pushes: tried });
    assert!(said, "{tried}: {:?}", plan.reasons);
    planner.reset();
    assert!(!solve(&mut planner, &problem).actions.is_empty());
}
