//! A grasp that was tried and failed.

use std::sync::Arc;

use jostle::action::Action;
use jostle::geom::{Pose2, Shape};
use jostle::physics;
use jostle::plan::{Control, Outcome, Planner, PlannerOptions};
use jostle::run::{Budget, Stop};
use jostle::scene::{BodyDef, Problem, SceneBuilder, State};

/// A cube that can be grasped from two sides, and another far off.
fn open() -> Problem {
    let mut builder = SceneBuilder::new();
    for _ in 0..2 {
        builder.add_body(BodyDef::new(Shape::rectangle(0.045, 0.045))).unwrap();
    }
    let state = State::new([Pose2::new(0.5, 0.0, 0.0), Pose2::new(0.5, 0.15, 0.0)]);
    Problem::new("open", Arc::new(builder.build().unwrap()), state, 0).unwrap()
}

#[test]
fn a_grasp_that_failed_is_not_offered_again_before_the_bodies_were_pushed() {
    for name in ["hedge", "pmbs", "mcts"] {
        let options =
            PlannerOptions { planner: name.into(), budget: Budget::iterations(200), ..PlannerOptions::default() };
        let mut planner = Planner::new(options.clone()).unwrap();
        let problem = open();
        let solve = |planner: &mut Planner, problem: &Problem| planner.solve(problem, &Control::default()).unwrap();
        let first = solve(&mut planner, &problem);
        let Action::Grasp(grasp) = first.actions[0].action else { panic!("{name}: {first:?}") };

        planner.failed(&Action::Grasp(grasp));
        let second = solve(&mut planner, &problem);
        let Action::Push(push) = second.actions[0].action else { panic!("{name}: {second:?}") };
        assert_ne!(second.outcome, Outcome::Infeasible, "{name}");

        let engine = physics::engine(&options.model().unwrap(), Arc::clone(&problem.scene)).unwrap();
        let after = engine.step(&mut engine.scratch(), &problem.state, &push, &Stop::never()).state;
        planner.advance(&second.actions[0].action).unwrap();
        let moved = Problem { state: after, ..problem.clone() };
        let third = solve(&mut planner, &moved);
        assert!(matches!(third.actions[0].action, Action::Grasp(_)), "{name}: {third:?}");

        // Another table is another matter, and so is a push that failed.
        let mut fresh = Planner::new(options).unwrap();
        fresh.failed(&Action::Push(push));
        assert_eq!(solve(&mut fresh, &problem).hash_bits(), first.hash_bits(), "{name}");
    }
}
