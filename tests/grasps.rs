//! The list of a body's best grasps beside what planners do.

use jostle::action::Action;
use jostle::eval::Suite;
use jostle::grasp::{GraspParams, GraspScratch, GraspTest};
use jostle::plan::{Control, Outcome, Planner, PlannerOptions};
use jostle::run::Budget;
use jostle::scene::Problem;

fn suite(name: &str) -> Vec<Problem> {
    Suite::open(&format!("{}/suites/{name}", env!("CARGO_MANIFEST_DIR")), None).unwrap().problems
}

/// Where a plan ends with a grasp, that is the first of the list in the state that the plan expects before it.
#[test]
fn the_first_of_the_list_is_the_grasp_that_a_plan_ends_with() {
    let test = GraspTest::new(GraspParams::default()).unwrap();
    let mut compared = 0;
    for (name, planner) in [("own-hard", "hedge"), ("own-hard", "pmbs"), ("own-confined", "pmbs"), ("deep", "mcts")] {
        for problem in suite(name).iter().take(5) {
            let options = PlannerOptions {
                planner: planner.into(),
                budget: Budget::iterations(1500),
                ..PlannerOptions::default()
            };
            let plan = Planner::new(options).unwrap().solve(problem, &Control::default()).unwrap();
            let Some((last, before)) = plan.actions.split_last().filter(|_| plan.outcome == Outcome::Solved) else {
                continue;
            };
            let Action::Grasp(grasp) = last.action else { panic!("{}: {plan:?}", problem.name) };
            let state = before.last().map_or(&problem.state, |step| &step.predicted);
            let list = test.best_apart(&problem.scene, state, problem.target, 3, &mut GraspScratch::default()).unwrap();
            let first = &list[0].grasp;
            let place = (first.position, first.angle, first.opening);
            assert_eq!(place, (grasp.position, grasp.angle, grasp.opening), "{name} {}", problem.name);
            assert!((first.score - grasp.score).abs() < 1e-6, "{first:?} {grasp:?}");
            compared += 1;
        }
    }
    assert!(compared > 10, "only {compared} plans end with a grasp");
}
