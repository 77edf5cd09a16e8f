//! Plans found in one engine and confirmed in another before the decision.

use std::sync::Arc;

use jostle::action::Action;
use jostle::eval::Suite;
use jostle::grasp::{GraspParams, GraspScratch, GraspTest};
use jostle::physics::{self, PhysicsOptions};
use jostle::plan::{Confirm, Control, Outcome, Plan, Planner, PlannerOptions};
use jostle::run::{Budget, CancelToken, Stop};
use jostle::scene::Problem;

fn problems() -> Vec<Problem> {
    Suite::generated(8, 11, None).unwrap().problems
}

fn options(confirm: Confirm) -> PlannerOptions {
    PlannerOptions {
        planner: "pmbs".into(),
        physics: Some(PhysicsOptions::preset("fast")),
        confirm,
        budget: Budget::iterations(200),
        seed: 5,
        ..PlannerOptions::default()
    }
}

fn solve(options: &PlannerOptions, problem: &Problem) -> Plan {
    Planner::new(options.clone()).unwrap().solve(problem, &Control::default()).unwrap()
}

fn fine() -> Confirm {
    Confirm::With(PhysicsOptions::preset("fine"))
}

#[test]
fn a_confirmed_plan_is_what_the_confirming_engine_does() {
    let (mut confirmed, mut changed) = (0, 0);
    for problem in problems() {
        let plan = solve(&options(fine()), &problem);
        let s = plan.statistics;
        assert!(s.plans_confirmed <= s.plans_tried && s.plans_tried <= s.confirm_simulations.max(1), "{s:?}");
        let unconfirmed = solve(&options(Confirm::Off), &problem);
        assert_eq!(unconfirmed.statistics.plans_tried, 0);
        assert!(s.iterations >= unconfirmed.statistics.iterations, "it searches on, and no less: {}", problem.name);
        assert!(s.iterations <= 200, "the budget holds for all searches together: {}", problem.name);
        if s.plans_confirmed == 0 {
            continue;
        }
        confirmed += 1;
        changed += u32::from(plan.actions[0].action != unconfirmed.actions[0].action);
        let engine = physics::engine(&PhysicsOptions::preset("fine"), Arc::clone(&problem.scene)).unwrap();
        let (mut scratch, mut state) = (engine.scratch(), problem.state.clone());
        for step in &plan.actions {
            match &step.action {
                Action::Push(push) => {
                    state = engine.step(&mut scratch, &state, push, &Stop::never()).state;
                    assert_eq!(state, step.predicted, "{}", problem.name);
                }
                Action::Grasp(_) => {
                    let test = GraspTest::new(GraspParams::default()).unwrap();
                    let best = test.best(&problem.scene, &state, problem.target, &mut GraspScratch::default()).unwrap();
                    assert!(best.score >= options(fine()).grasp.solved_score);
                }
            }
        }
        assert_eq!(plan.outcome, Outcome::Solved);
    }
    assert!(confirmed >= 5, "{confirmed} of 8 confirmed");
    assert!(changed >= 1, "confirming changes no decision");
}

#[test]
fn every_plan_is_confirmed_in_the_engine_that_made_it() {
    for problem in problems() {
        let plan = solve(&options(Confirm::With(PhysicsOptions::preset("fast"))), &problem);
        let s = plan.statistics;
        assert_eq!(s.plans_confirmed, s.plans_tried, "{}", problem.name);
        assert_eq!(plan.outcome == Outcome::Solved, s.plans_tried > 0);
    }
}

#[test]
fn threads_change_no_bit_of_a_confirmed_plan() {
    for problem in &problems()[..4] {
        let at = |threads| solve(&PlannerOptions { threads, ..options(fine()) }, problem);
        let one = at(1);
        for threads in [0, 2, 5] {
            let other = at(threads);
            assert_eq!(one.hash_bits(), other.hash_bits(), "{}", problem.name);
            assert_eq!(one.statistics.plans_confirmed, other.statistics.plans_confirmed);
        }
    }
}

#[test]
fn a_confirmed_decision_keeps_the_subtree_of_its_first_push() {
    let problem = &problems()[0];
    let mut planner = Planner::new(options(fine())).unwrap();
    let plan = planner.solve(problem, &Control::default()).unwrap();
    assert!(planner.advance(&plan.actions[0].action).unwrap());
}

#[test]
fn a_cancel_and_a_deadline_hold_while_plans_are_tried() {
    let problem = &problems()[1];
    let cancel = CancelToken::new();
    cancel.trigger();
    let control = Control { cancel: vec![cancel], ..Control::default() };
    let plan = Planner::new(options(fine())).unwrap().solve(problem, &control).unwrap();
    assert_eq!((plan.outcome, plan.actions.len()), (Outcome::Cancelled, 0));
    // Hardly any time: whatever was found by then is returned, and nothing fails.
    let hurried = PlannerOptions { budget: Budget::seconds(1e-4), ..options(fine()) };
    let plan = solve(&hurried, problem);
    assert_ne!(plan.outcome, Outcome::Cancelled);
}
