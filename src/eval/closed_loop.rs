//! A planner in closed loop: observe, plan, execute the first action, until the target is out.

use serde::Serialize;

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

    /// The first action of the last plan was not executed.
    fn refused(&mut self) {}
}

impl Policy for Planner {
    fn decide(&mut self, problem: &Problem, control: &Control) -> Result<Plan> {
        self.solve(problem, control)
    }

    fn executed(&mut self, action: &Action) -> Result<()> {
        self.advance(action).map(drop)
    }

    fn refused(&mut self) {
        self.reset();
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
        let watch = Stop::never();
        let plan = policy.decide(&problem, control)?;
        let milliseconds = watch.elapsed().as_secs_f64() * 1e3;
        if plan.outcome == Outcome::Cancelled {
            break TrialEnd::Cancelled;
        }
        let action = plan.actions.first().map(|a| a.action);
        let effect = action.map(|a| judge.execute(&a)).transpose()?;
        let decision = Decision {
            milliseconds,
            iterations: plan.statistics.iterations,
            simulations: plan.statistics.simulations,
            outcome: plan.outcome,
            planned: plan.actions.len(),
            action,
            effect,
        };
        observer(Event::Decision { trial: index, decision: &decision });
        decisions.push(decision);
        match (action, effect) {
            (Some(action), Some(Effect::Pushed)) => policy.executed(&action)?,
            (_, Some(Effect::Grasped)) => break TrialEnd::Grasped,
            _ => policy.refused(),
        }
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
        let mut planner = Planner::new(PlannerOptions {
            seed: options.planner.seed.wrapping_add(index),
            ..options.planner.clone()
        })?;
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

/// A serializable copy of what was asked.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Configuration {
    pub version: String,
    pub suite: String,
    pub planner: String,
    /// The engine of the planner's model.
    pub physics: crate::physics::PhysicsOptions,
    pub gripper: String,
    pub sampler: Option<String>,
    /// Metres; none is the sampler's own.
    pub push_length: Option<f64>,
    pub budget: BudgetReport,
    pub execute_score: f64,
    pub solved_score: f64,
    pub lanes: Option<usize>,
    pub max_depth: Option<u32>,
    pub threads: usize,
    pub seed: u64,
    pub trials: u64,
    pub max_actions: usize,
    pub judge: JudgeOptions,
}

/// The limits of one decision; none is the planner's own.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BudgetReport {
    pub iterations: Option<u64>,
    pub seconds: Option<f64>,
    pub bytes: Option<usize>,
}

impl Configuration {
    pub fn new(suite: &str, gripper: &str, options: &ClosedLoopOptions) -> Configuration {
        let p = &options.planner;
        Configuration {
            version: env!("CARGO_PKG_VERSION").into(),
            suite: suite.into(),
            planner: p.planner.clone(),
            physics: p.physics.clone(),
            gripper: gripper.into(),
            sampler: p.sampler.clone(),
            push_length: p.push_length,
            budget: BudgetReport {
                iterations: p.budget.iterations,
                seconds: p.budget.seconds,
                bytes: p.budget.bytes,
            },
            execute_score: p.grasp.execute_score,
            solved_score: p.grasp.solved_score,
            lanes: p.lanes,
            max_depth: p.max_depth,
            threads: p.threads,
            seed: p.seed,
            trials: options.trials,
            max_actions: options.max_actions,
            judge: options.judge.clone(),
        }
    }
}
