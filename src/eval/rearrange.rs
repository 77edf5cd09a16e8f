//! Rearrangements in closed loop: decide, execute the first move, decide again, until every body is at its goal.
//!
//! Moves end where the plan says (the source finds "a small sim-to-real gap"), so there is no judge but the
//! [certificate](super::certificate), which every plan has to pass.

use serde::{Deserialize, Serialize};

use super::certificate::{certify, certify_moves};
use super::statistics::mean;
use crate::action::{Move, MoveCosts};
use crate::error::Result;
use crate::plan::rearrange::{RearrangeOptions, RearrangePlan, RearrangePlanner};
use crate::plan::{Control, Outcome};
use crate::run::Key;
use crate::scene::Rearrangement;

/// Actions after which a trial has failed (REMP: 20).
pub const REARRANGE_MAX_ACTIONS: usize = 20;

/// How trials are run.
#[derive(Debug, Clone, PartialEq)]
pub struct RearrangeTrials {
    pub options: RearrangeOptions,
    /// Trials of each case, each with a seed of its own.
    pub trials: u64,
    pub max_actions: usize,
    /// Execute every plan that solves the problem to its end instead of planning anew after each action.
    pub open_loop: bool,
}

impl Default for RearrangeTrials {
    fn default() -> Self {
        RearrangeTrials {
            options: RearrangeOptions::default(),
            trials: 5,
            max_actions: REARRANGE_MAX_ACTIONS,
            open_loop: false,
        }
    }
}

/// How a trial ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RearrangeEnd {
    /// Every body is at its goal: the only success.
    Completed,
    /// The cap on actions was reached.
    ActionCap,
    /// The planner had no action to offer.
    NoAction,
    /// A plan did not pass the certificate.
    Invalid,
    /// Cancelled from outside; the trial does not count.
    Cancelled,
}

/// One trial of one case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RearrangeTrial {
    /// From 0.
    pub index: u64,
    pub end: RearrangeEnd,
    pub actions: usize,
    /// Actions that were drags.
    pub drags: usize,
    pub decisions: usize,
    /// Wall-clock seconds of all decisions.
    pub planning_s: f64,
    /// Robot time of the executed actions.
    pub robot_s: f64,
    /// Their cost in metres.
    pub cost: f64,
    /// Iterations of each decision.
    pub iterations: Vec<u64>,
    /// What the certificate says of an invalid plan.
    pub violation: Option<String>,
    /// The executed actions.
    #[serde(skip)]
    pub moves: Vec<Move>,
}

impl RearrangeTrial {
    pub fn completed(&self) -> bool {
        self.end == RearrangeEnd::Completed
    }
}

/// The trials of one case. Means of actions and robot time are over the completed ones, as in the source; planning time
/// is over all.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RearrangeCase {
    pub name: String,
    pub bodies: usize,
    pub completion: f64,
    pub actions: Option<f64>,
    pub robot_s: Option<f64>,
    pub planning_s: f64,
    pub trials: Vec<RearrangeTrial>,
}

/// Many cases and their means over all trials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RearrangeReport {
    pub planner: String,
    pub cases: Vec<RearrangeCase>,
    pub completion: f64,
    /// Over all trials, failed ones with the cap, as the source counts them.
    pub actions: f64,
    /// Over the completed trials.
    pub actions_completed: Option<f64>,
    pub robot_s: Option<f64>,
    /// Mean over trials of the summed time of the decisions, and the greatest of a case's mean.
    pub planning_s: f64,
    pub planning_s_max: f64,
    /// Plans that did not pass the certificate.
    pub invalid: usize,
}

/// Runs the trials of one problem.
pub fn rearrange_case(problem: &Rearrangement, config: &RearrangeTrials, control: &Control) -> Result<RearrangeCase> {
    problem.validate()?;
    let trials = (0..config.trials).map(|index| trial(problem, config, index, control)).collect::<Result<Vec<_>>>()?;
    Ok(RearrangeCase::new(problem, trials))
}

/// Runs a suite; `done` is called after each case.
pub fn rearrange_suite(
    problems: &[Rearrangement],
    config: &RearrangeTrials,
    control: &Control,
    mut done: impl FnMut(&RearrangeCase),
) -> Result<RearrangeReport> {
    let mut cases = Vec::new();
    for problem in problems {
        let case = rearrange_case(problem, config, control)?;
        done(&case);
        cases.push(case);
    }
    Ok(RearrangeReport::new(&config.options.planner, config.max_actions, cases))
}

fn trial(problem: &Rearrangement, config: &RearrangeTrials, index: u64, control: &Control) -> Result<RearrangeTrial> {
    let seed = Key::new(config.options.seed).child(index).bits();
    let mut planner = RearrangePlanner::new(RearrangeOptions { seed, ..config.options.clone() })?;
    let costs = config.options.costs;
    let mut trial = RearrangeTrial {
        index,
        end: RearrangeEnd::Completed,
        actions: 0,
        drags: 0,
        decisions: 0,
        planning_s: 0.0,
        robot_s: 0.0,
        cost: 0.0,
        iterations: Vec::new(),
        violation: None,
        moves: Vec::new(),
    };
    let mut now = problem.clone();
    while !now.solved(&now.start) {
        if trial.moves.len() >= config.max_actions {
            trial.end = RearrangeEnd::ActionCap;
            break;
        }
        let plan = planner.solve(&now, control)?;
        trial.decisions += 1;
        trial.planning_s += plan.statistics.seconds;
        trial.iterations.push(plan.statistics.iterations);
        if let Some(end) = refused(&now, &plan, &mut trial.violation) {
            trial.end = end;
            break;
        }
        // A plan that leads nowhere is worth its first move at most.
        let whole = config.open_loop && plan.outcome == Outcome::Solved;
        let most = if whole { config.max_actions - trial.moves.len() } else { 1 };
        let mut state = now.start.clone();
        for step in plan.moves.into_iter().take(most) {
            planner.advance(&step.action)?;
            state.set_pose(step.action.body(), step.action.to());
            trial.moves.push(step.action);
        }
        now = now.from_state(state);
    }
    if trial.end == RearrangeEnd::Completed
        && let Err(violation) = certify(problem, &trial.moves)
    {
        trial.end = RearrangeEnd::Invalid;
        trial.violation = Some(violation.to_string());
    }
    trial.count(&costs);
    Ok(trial)
}

/// Why a plan is not executed.
fn refused(problem: &Rearrangement, plan: &RearrangePlan, violation: &mut Option<String>) -> Option<RearrangeEnd> {
    let moves = plan.moves.iter().map(|step| &step.action);
    let checked = if plan.outcome == Outcome::Solved { certify(problem, moves) } else { certify_moves(problem, moves) };
    match checked {
        Err(found) => {
            *violation = Some(found.to_string());
            Some(RearrangeEnd::Invalid)
        }
        Ok(_) if plan.outcome == Outcome::Cancelled => Some(RearrangeEnd::Cancelled),
        Ok(_) => plan.moves.is_empty().then_some(RearrangeEnd::NoAction),
    }
}

impl RearrangeTrial {
    fn count(&mut self, costs: &MoveCosts) {
        self.actions = self.moves.len();
        self.drags = self.moves.iter().filter(|action| matches!(action, Move::Drag { .. })).count();
        self.robot_s = self.moves.iter().map(|action| costs.seconds(action)).sum();
        self.cost = self.moves.iter().map(|action| costs.metres(action)).sum();
    }
}

/// The mean over what passes, if anything does.
fn mean_of<'a>(
    trials: impl Iterator<Item = &'a RearrangeTrial>,
    value: impl Fn(&RearrangeTrial) -> f64,
) -> Option<f64> {
    let values: Vec<f64> = trials.filter(|trial| trial.completed()).map(value).collect();
    (!values.is_empty()).then(|| mean(&values))
}

impl RearrangeCase {
    fn new(problem: &Rearrangement, mut trials: Vec<RearrangeTrial>) -> RearrangeCase {
        trials.retain(|trial| trial.end != RearrangeEnd::Cancelled);
        let completed = trials.iter().filter(|trial| trial.completed()).count();
        RearrangeCase {
            name: problem.name.clone(),
            bodies: problem.scene.len(),
            completion: completed as f64 / trials.len().max(1) as f64,
            actions: mean_of(trials.iter(), |trial| trial.actions as f64),
            robot_s: mean_of(trials.iter(), |trial| trial.robot_s),
            planning_s: mean(&trials.iter().map(|trial| trial.planning_s).collect::<Vec<_>>()),
            trials,
        }
    }
}

impl RearrangeReport {
    pub fn new(planner: &str, max_actions: usize, cases: Vec<RearrangeCase>) -> RearrangeReport {
        let trials: Vec<&RearrangeTrial> = cases.iter().flat_map(|case| &case.trials).collect();
        let all =
            |value: &dyn Fn(&RearrangeTrial) -> f64| mean(&trials.iter().map(|trial| value(trial)).collect::<Vec<_>>());
        let counted = |t: &RearrangeTrial| if t.completed() { t.actions as f64 } else { max_actions as f64 };
        RearrangeReport {
            planner: planner.to_string(),
            completion: all(&|trial| f64::from(u8::from(trial.completed()))),
            actions: all(&counted),
            actions_completed: mean_of(trials.iter().copied(), |trial| trial.actions as f64),
            robot_s: mean_of(trials.iter().copied(), |trial| trial.robot_s),
            planning_s: all(&|trial| trial.planning_s),
            planning_s_max: cases.iter().map(|case| case.planning_s).fold(0.0, f64::max),
            invalid: trials.iter().filter(|trial| trial.end == RearrangeEnd::Invalid).count(),
            cases,
        }
    }
}
