//! The report of a run: what was asked, what came of every case, and the totals.

use serde::Serialize;

use super::closed_loop::{ClosedLoopOptions, Event, run_case};
use super::folder::Refused;
use super::judge::JudgeOptions;
use super::metrics::{CaseReport, Total};
use super::suite::Suite;
use crate::error::Result;
use crate::physics::PhysicsOptions;
use crate::plan::{Control, Variant};
use crate::search::Selection;

/// A serializable copy of what was asked.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Configuration {
    pub version: String,
    pub suite: String,
    pub planner: String,
    pub variant: Variant,
    /// The engine of the planner's model.
    pub physics: PhysicsOptions,
    /// The engine that plans are confirmed in; none if they are not.
    pub confirm: Option<PhysicsOptions>,
    pub gripper: String,
    pub sampler: Option<String>,
    /// Metres; none is the sampler's own.
    pub push_length: Option<f64>,
    pub budget: BudgetReport,
    pub execute_score: f64,
    pub solved_score: f64,
    pub lanes: Option<usize>,
    pub max_depth: Option<u32>,
    /// Weight of exploration in the search's upper confidence bounds; none where a prior guides it.
    pub exploration: Option<f64>,
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
    pub fn new(suite: &str, gripper: &str, options: &ClosedLoopOptions) -> Result<Configuration> {
        let p = &options.planner;
        Ok(Configuration {
            version: env!("CARGO_PKG_VERSION").into(),
            suite: suite.into(),
            planner: p.planner.clone(),
            variant: p.variant,
            physics: p.model()?,
            confirm: p.confirmed_in()?,
            gripper: gripper.into(),
            sampler: p.sampler.clone(),
            push_length: p.push_length,
            budget: BudgetReport { iterations: p.budget.iterations, seconds: p.budget.seconds, bytes: p.budget.bytes },
            execute_score: p.grasp.execute_score,
            solved_score: p.grasp.solved_score,
            lanes: p.lanes,
            max_depth: p.max_depth,
            exploration: match p.search_params()?.selection {
                Selection::Ucb { exploration, .. } => Some(exploration),
                Selection::Guided { .. } => None,
            },
            threads: p.threads,
            seed: p.seed,
            trials: options.trials,
            max_actions: options.max_actions,
            judge: options.judge.clone(),
        })
    }
}

/// The report of a suite.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    pub configuration: Configuration,
    pub cases: Vec<CaseReport>,
    /// Cases that could not be read; they are not counted.
    pub refused: Vec<Refused>,
    pub total: Total,
}

/// Runs every case of a suite, one after the other.
pub fn run_suite(
    suite: &Suite,
    options: &ClosedLoopOptions,
    control: &Control,
    observer: &mut dyn FnMut(Event<'_>),
) -> Result<Report> {
    options.validate()?;
    let mut cases = Vec::with_capacity(suite.problems.len());
    for (index, problem) in suite.problems.iter().enumerate() {
        observer(Event::Case { index, name: &problem.name });
        cases.push(run_case(problem, options, control, observer)?);
        if control.cancel.iter().any(crate::run::CancelToken::is_triggered) {
            break;
        }
    }
    Ok(Report {
        configuration: Configuration::new(&suite.name, &suite.gripper(), options)?,
        total: Total::of(&cases),
        cases,
        refused: suite.refused.clone(),
    })
}
