//! Plans made with one engine, executed whole in another: where the cheap model misleads.
//!
//! Every problem is planned once. The plan's pushes are executed in the other engine from the same state, without noise
//! and without looking in between, and the planned target's grasp is looked for where the bodies then are. The share
//! that fails, by the number of bodies that a plan moves, says which plans a planar model can be trusted with.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;

use super::fidelity::{MOVED_POSITION, MOVED_ROTATION};
use crate::action::Action;
use crate::error::Result;
use crate::geom::normalize_angle;
use crate::grasp::{GeometricScorer, GraspAssessment, GraspParams, Scorer};
use crate::physics::{PushStatus, Transition};
use crate::plan::{Control, Outcome, Planner, PlannerOptions};
use crate::run::Stop;
use crate::scene::{Problem, Scene, State};

/// Plans of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct CrosscheckRow {
    pub plans: usize,
    /// The target can be grasped at the end in the other engine too.
    pub succeeded: usize,
    /// Of those that did not: a push came down on a body that was not predicted there.
    pub blocked: usize,
    /// `succeeded / plans`.
    pub share: f64,
}

/// What became of the plans.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Crosscheck {
    /// Names of the engines that planned and that executed.
    pub planned_in: String,
    pub executed_in: String,
    pub total: CrosscheckRow,
    /// By the greatest number of bodies that a push of the plan moves in the engine that planned.
    pub by_bodies_moved: BTreeMap<usize, CrosscheckRow>,
    /// By the number of pushes.
    pub by_pushes: BTreeMap<usize, CrosscheckRow>,
    /// Problems that a grasp alone solves, or for which no plan was found; not counted.
    pub left_out: usize,
}

impl CrosscheckRow {
    fn add(&mut self, end: End) {
        self.plans += 1;
        self.succeeded += usize::from(end == End::Freed);
        self.blocked += usize::from(end == End::Blocked);
        self.share = self.succeeded as f64 / self.plans as f64;
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    Freed,
    Blocked,
    Held,
}

/// Plans every problem with `options` and executes the plans in the engine that `engine` makes for a scene. `done` hears
/// of every problem and ends the comparison by returning false.
pub fn crosscheck(
    problems: &[Problem],
    options: &PlannerOptions,
    engine: &dyn Fn(Arc<Scene>) -> Result<Arc<dyn Transition>>,
    control: &Control,
    done: &mut dyn FnMut(usize) -> bool,
) -> Result<Crosscheck> {
    let model = options.model()?;
    let mut report = Crosscheck { planned_in: format!("{} {}", model.engine, model.preset), ..Crosscheck::default() };
    for (index, problem) in problems.iter().enumerate() {
        let plan = Planner::new(options.clone())?.solve(problem, control)?;
        let other = engine(Arc::clone(&problem.scene))?;
        report.executed_in = other.name().to_string();
        let pushes = plan.actions.iter().filter(|a| matches!(a.action, Action::Push(_))).count();
        if plan.outcome != Outcome::Solved || pushes == 0 {
            report.left_out += 1;
        } else {
            let mut most = 0;
            let mut before = &problem.state;
            for step in plan.actions.iter().filter(|a| matches!(a.action, Action::Push(_))) {
                most = most.max(moved(before, &step.predicted));
                before = &step.predicted;
            }
            let end = execute(problem, &plan.actions, &*other, options.grasp.solved_score)?;
            report.total.add(end);
            report.by_bodies_moved.entry(most).or_default().add(end);
            report.by_pushes.entry(pushes).or_default().add(end);
        }
        if !done(index + 1) {
            break;
        }
    }
    Ok(report)
}

fn execute(
    problem: &Problem,
    actions: &[crate::plan::PlannedAction],
    engine: &dyn Transition,
    solved_score: f64,
) -> Result<End> {
    let mut scratch = engine.scratch();
    let mut state = problem.state.clone();
    for step in actions {
        let Action::Push(push) = &step.action else { continue };
        let result = engine.step(&mut scratch, &state, push, &Stop::never());
        if result.status != PushStatus::Executed {
            return Ok(End::Blocked);
        }
        state = result.state;
    }
    let scorer = GeometricScorer::new(&problem.scene, GraspParams::default())?;
    let mut found = [GraspAssessment::default()];
    scorer.assess(scorer.scratch().as_mut(), &problem.scene, &[&state], problem.target, &mut found, &Stop::never());
    let freed = found[0].grasp.is_some() && found[0].score >= solved_score;
    Ok(if freed { End::Freed } else { End::Held })
}

/// How many bodies differ between the states.
fn moved(a: &State, b: &State) -> usize {
    a.iter()
        .filter(|&(i, p)| {
            let q = b.pose(i);
            (p.position() - q.position()).norm() > MOVED_POSITION
                || normalize_angle(p.theta - q.theta).abs() > MOVED_ROTATION
        })
        .count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::Suite;
    use crate::physics::{self, PhysicsOptions};
    use crate::plan::Confirm;
    use crate::run::Budget;

    #[test]
    fn every_plan_succeeds_in_the_engine_that_made_it_and_not_every_one_in_another() {
        let suite = Suite::generated(12, 3, None).unwrap();
        let options = PlannerOptions {
            physics: Some(PhysicsOptions::preset("fast")),
            confirm: Confirm::Off,
            budget: Budget::iterations(200),
            ..PlannerOptions::default()
        };
        let in_preset = |preset: &'static str| {
            let engine = move |scene| physics::engine(&PhysicsOptions::preset(preset), scene);
            crosscheck(&suite.problems, &options, &engine, &Control::default(), &mut |_| true).unwrap()
        };
        let same = in_preset("fast");
        assert!(same.total.plans >= 8, "{same:?}");
        assert_eq!(same.total.succeeded, same.total.plans, "{same:?}");
        assert_eq!(same.by_pushes.values().map(|r| r.plans).sum::<usize>(), same.total.plans);
        assert_eq!(same.by_bodies_moved.values().map(|r| r.plans).sum::<usize>(), same.total.plans);
        let finer = in_preset("fine");
        assert!(finer.total.succeeded < finer.total.plans, "{finer:?}");
        assert_eq!((same.planned_in.as_str(), finer.executed_in.as_str()), ("rapier fast", "rapier fine"));
    }
}
