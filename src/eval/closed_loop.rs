//! A planner in closed loop: observe, plan, execute the first action, until the target is out.

use super::judge::{Judge, JudgeOptions};
use super::metrics::{CaseReport, Decision, Effect, Trial, TrialEnd};
use crate::action::Action;
use crate::error::{Error, Result, check_range};
use crate::plan::{Control, Outcome, Plan, Planner, PlannerOptions};
use crate::run::Stop;
use crate::scene::Problem;

/// Anything that decides what to do next.
pub trait Policy {
    fn decide(&mut self, problem: &Problem, control: &Control) -> Result<Plan>;

    /// The first action of the last plan was executed as planned.
    fn executed(&mut self, action: &Action) -> Result<()> {
        let _ = action;
        Ok(())
    }

    /// The first action of the last plan was tried and failed.
    fn failed(&mut self, action: &Action) {
        let _ = action;
    }
}

impl Policy for Planner {
    fn decide(&mut self, problem: &Problem, control: &Control) -> Result<Plan> {
        self.solve(problem, control)
    }

    fn executed(&mut self, action: &Action) -> Result<()> {
        self.advance(action).map(drop)
    }

    fn failed(&mut self, action: &Action) {
        self.failed(action);
    }
}

/// How problems are tried.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosedLoopOptions {
    /// Trial `t` plans with the seed `planner.seed + t`.
    pub planner: PlannerOptions,
    pub judge: JudgeOptions,
    pub trials: u64,
    /// A trial fails after this many actions; blocked pushes and missed grasps count.
    pub max_actions: usize,
}

/// The cap on actions where none is asked for.
pub const DEFAULT_MAX_ACTIONS: usize = 30;

/// Times that a planner without an action to offer may look again (with new noise) before the trial fails.
const LOOKS_WITHOUT_ACTION: usize = 3;

impl Default for ClosedLoopOptions {
    fn default() -> Self {
        Self {
            planner: PlannerOptions::default(),
            judge: JudgeOptions::default(),
            trials: 5,
            max_actions: DEFAULT_MAX_ACTIONS,
        }
    }
}

impl ClosedLoopOptions {
    pub fn validate(&self) -> Result<()> {
        self.planner.validate()?;
        self.judge.validate()?;
        check_range("trials", self.trials as f64, 1.0..=1e6)?;
        check_range("max_actions", self.max_actions as f64, 1.0..=1e4)
    }
}

/// What happens while a suite runs, for progress displays.
#[derive(Debug, Clone, Copy)]
pub enum Event<'a> {
    /// Case `index` (from 0) begins.
    Case { index: usize, name: &'a str },
    /// A decision was made and its action executed.
    Decision { trial: u64, decision: &'a Decision },
    /// A trial ended.
    Trial { trial: &'a Trial },
    /// All trials of a case are done.
    CaseDone { report: &'a CaseReport },
}

/// Runs one trial.
pub fn run_trial(
    policy: &mut dyn Policy,
    judge: &mut Judge,
    index: u64,
    max_actions: usize,
    control: &Control,
    observer: &mut dyn FnMut(Event<'_>),
) -> Result<Trial> {
    let mut decisions = Vec::new();
    let (mut actions, mut looks) = (0, 0);
    // Time that the policy took to note what was done; it belongs to the next decision.
    let mut noting = 0.0;
    let end = loop {
        if judge.target_left() {
            break TrialEnd::TargetLeft;
        }
        if actions == max_actions {
            break TrialEnd::ActionCap;
        }
        if looks == LOOKS_WITHOUT_ACTION {
            break TrialEnd::NoAction;
        }
        let problem = judge.observed_problem();
        // Where it is seen beyond the edge by more than is taken as noise, there is no problem to give to a planner.
        if problem.target_left() {
            break TrialEnd::TargetLeft;
        }
        let watch = Stop::never();
        let plan = policy.decide(&problem, control)?;
        let milliseconds = watch.elapsed().as_secs_f64() * 1e3 + noting;
        if plan.outcome == Outcome::Cancelled {
            break TrialEnd::Cancelled;
        }
        let action = plan.actions.first().map(|a| a.action);
        let chance = action.and_then(|a| judge.chance(&a));
        let effect = action.map(|a| judge.execute(&a)).transpose()?;
        let decision = Decision {
            milliseconds,
            iterations: plan.statistics.iterations,
            simulations: plan.statistics.simulations,
            outcome: plan.outcome,
            planned: plan.actions.len(),
            action,
            chance,
            effect,
        };
        observer(Event::Decision { trial: index, decision: &decision });
        decisions.push(decision);
        let watch = Stop::never();
        match (action, effect) {
            (_, Some(Effect::Grasped)) => break TrialEnd::Grasped,
            (Some(action), Some(effect)) if effect.is_executed() => policy.executed(&action)?,
            (Some(action), _) => policy.failed(&action),
            (None, _) => {}
        }
        noting = watch.elapsed().as_secs_f64() * 1e3;
        if action.is_some() {
            (actions, looks) = (actions + 1, 0);
        } else {
            looks += 1;
        }
    };
    Ok(Trial::new(index, end, decisions))
}

/// Runs all trials of one problem, each with a fresh planner. A cancelled trial ends the case and is not counted.
pub fn run_case(
    problem: &Problem,
    options: &ClosedLoopOptions,
    control: &Control,
    observer: &mut dyn FnMut(Event<'_>),
) -> Result<CaseReport> {
    let mut trials = Vec::new();
    for index in 0..options.trials {
        let mut planner =
            Planner::new(PlannerOptions { seed: options.planner.seed.wrapping_add(index), ..options.planner.clone() })?;
        let mut judge = Judge::new(problem, &options.judge, index)?;
        let trial = run_trial(&mut planner, &mut judge, index, options.max_actions, control, observer)
            .map_err(|e| named(e, &problem.name, index))?;
        if trial.end == TrialEnd::Cancelled {
            break;
        }
        observer(Event::Trial { trial: &trial });
        trials.push(trial);
    }
    let report = CaseReport::new(&problem.name, problem.state.present().count(), trials);
    observer(Event::CaseDone { report: &report });
    Ok(report)
}

/// Says where in a suite an error came up.
fn named(error: Error, case: &str, trial: u64) -> Error {
    match error {
        Error::Argument { .. } | Error::NotFound { .. } => error.within(&format!("{case}, trial {trial}")),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Line, Script, row};
    use super::*;
    use crate::geom::Pose2;
    use crate::physics::PhysicsOptions;
    use std::sync::Arc;

    fn trial(lines: &[Line], offset: Pose2) -> (Trial, Script) {
        let mut script = Script::new(lines);
        let engine = |scene| Ok(Arc::new(super::super::testing::Slide { scene, offset }) as _);
        let options = JudgeOptions::exact(PhysicsOptions::default());
        let mut judge = Judge::with_engine(&row(), &options, 0, &engine).unwrap();
        let trial = run_trial(&mut script, &mut judge, 0, 4, &Control::default(), &mut |_| ()).unwrap();
        (trial, script)
    }

    #[test]
    fn pushes_until_it_grasps() {
        let (t, script) = trial(&[Line::Push, Line::BadGrasp, Line::GoodGrasp], Pose2::new(0.01, 0.0, 0.0));
        assert_eq!((t.end, t.actions, t.pushes, t.grasps), (TrialEnd::Grasped, 3, 1, 2));
        assert_eq!((script.executed, script.failed), (1, 1));
        let effects: Vec<_> = t.decisions.iter().map(|d| d.effect).collect();
        assert_eq!(effects, [Some(Effect::Pushed), Some(Effect::Missed), Some(Effect::Grasped)]);
    }

    #[test]
    fn ends_at_the_cap() {
        let (t, _) = trial(&[Line::Push], Pose2::IDENTITY);
        assert_eq!((t.end, t.actions), (TrialEnd::ActionCap, 4));
        let (t, _) = trial(&[Line::BadGrasp, Line::BadGrasp, Line::BadGrasp, Line::GoodGrasp], Pose2::IDENTITY);
        assert_eq!((t.end, t.actions), (TrialEnd::Grasped, 4), "the last action counts");
    }

    #[test]
    fn ends_when_the_target_leaves() {
        let (t, _) = trial(&[Line::Push], Pose2::new(0.15, 0.0, 0.0));
        assert_eq!((t.end, t.actions), (TrialEnd::TargetLeft, 2));
    }

    #[test]
    fn looks_again_before_it_gives_up() {
        let (t, _) = trial(&[Line::Nothing], Pose2::IDENTITY);
        assert_eq!((t.end, t.actions, t.decisions.len()), (TrialEnd::NoAction, 0, LOOKS_WITHOUT_ACTION));
        let (t, _) =
            trial(&[Line::Nothing, Line::Nothing, Line::Push, Line::Nothing, Line::GoodGrasp], Pose2::IDENTITY);
        assert_eq!((t.end, t.actions, t.decisions.len()), (TrialEnd::Grasped, 2, 5));
    }

    #[test]
    fn a_cancel_ends_it() {
        let (t, _) = trial(&[Line::Push, Line::Cancel], Pose2::IDENTITY);
        assert_eq!((t.end, t.actions), (TrialEnd::Cancelled, 1));
    }

    #[test]
    fn a_case_runs_every_trial() {
        let options = ClosedLoopOptions { trials: 2, ..ClosedLoopOptions::default() };
        let mut trials = 0;
        let report = run_case(&row(), &options, &Control::default(), &mut |event| {
            trials += usize::from(matches!(event, Event::Trial { .. }));
        })
        .unwrap();
        assert_eq!((trials, report.trials.len(), report.bodies), (2, 2, 2));
    }
}
