//! Clearing a table in closed loop: observe, decide, execute the first action, until nothing is left to be taken.
//!
//! The numbers are the dissertation's: completion, grasp success (bodies taken over grasps), action efficiency (bodies
//! taken over actions), each over all trials and over the completed ones alone. A body that leaves the workspace ends a
//! trial as failed, and so does the cap of three actions for each body.

use serde::{Deserialize, Serialize};

use super::judge::{Judge, JudgeOptions};
use super::metrics::{Decision, Effect, Spread};
use super::statistics::mean;
use crate::action::Action;
use crate::error::{Error, Result, check_range};
use crate::plan::clear::{ClearOptions, ClearPlanner};
use crate::plan::{Control, Outcome, Plan};
use crate::run::{CancelToken, Stop};
use crate::scene::{Clearing, Mask};

/// Actions for each body after which a trial fails (dissertation: 3).
pub const CLEAR_ACTIONS_PER_BODY: usize = 3;
/// Times that a planner without an action to offer may look again (with new noise) before the trial fails.
const LOOKS_WITHOUT_ACTION: usize = 3;

/// How trials are run.
#[derive(Debug, Clone, PartialEq)]
pub struct ClearTrials {
    /// Trial `t` plans with the seed `planner.seed + t`.
    pub planner: ClearOptions,
    pub judge: JudgeOptions,
    pub trials: u64,
    /// A trial fails after this many actions; three for each body if absent. Blocked pushes and missed grasps count.
    pub max_actions: Option<usize>,
}

impl Default for ClearTrials {
    fn default() -> Self {
        ClearTrials { planner: ClearOptions::default(), judge: JudgeOptions::default(), trials: 5, max_actions: None }
    }
}

impl ClearTrials {
    pub fn validate(&self) -> Result<()> {
        self.planner.validate()?;
        self.judge.validate()?;
        check_range("trials", self.trials as f64, 1.0..=1e6)?;
        check_range("max_actions", self.max_actions.unwrap_or(1) as f64, 1.0..=1e4)
    }
}

/// How a trial ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ClearEnd {
    /// Every body was taken: the only success.
    Cleared,
    /// A body left the workspace.
    BodyLeft,
    /// The cap on actions was reached.
    ActionCap,
    /// The planner had no action to offer, again after looking again.
    NoAction,
    /// Cancelled from outside; the trial does not count.
    Cancelled,
}

/// One trial of one case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ClearTrial {
    /// From 0.
    pub index: u64,
    pub end: ClearEnd,
    /// Bodies that were to be taken.
    pub bodies: usize,
    /// Bodies that were.
    pub taken: usize,
    /// Actions that were executed, blocked pushes and missed grasps included.
    pub actions: usize,
    pub pushes: usize,
    /// Pushes whose tip would have come down on a body.
    pub blocked: usize,
    /// Grasps that were attempted.
    pub grasps: usize,
    /// Sum over the decisions.
    pub planning_s: f64,
    pub decisions: Vec<Decision>,
}

impl ClearTrial {
    pub fn new(index: u64, end: ClearEnd, bodies: usize, decisions: Vec<Decision>) -> ClearTrial {
        let count = |wanted: Effect| decisions.iter().filter(|d| d.effect == Some(wanted)).count();
        let (taken, blocked) = (count(Effect::Grasped), count(Effect::Blocked));
        let pushes = count(Effect::Pushed) + count(Effect::Toppled) + blocked;
        let grasps = taken + count(Effect::Missed);
        let planning_s = decisions.iter().map(|d| d.milliseconds).sum::<f64>() / 1e3;
        ClearTrial {
            index,
            end,
            bodies,
            taken,
            actions: pushes + grasps,
            pushes,
            blocked,
            grasps,
            planning_s,
            decisions,
        }
    }

    pub fn completed(&self) -> bool {
        self.end == ClearEnd::Cleared
    }

    /// Checks the trial's bookkeeping against the problem and the cap: what was taken was there and was taken once,
    /// nothing was done after the end, the counts are those of the decisions, and the end is the right one.
    ///
    /// # Errors
    /// [`Error::State`] says what does not fit.
    pub fn check(&self, problem: &Clearing, max_actions: usize) -> Result<()> {
        let wrong = |what: String| Err(Error::State(format!("{}, trial {}: {what}", problem.name, self.index)));
        let mut left = problem.remaining(&problem.state);
        if self.bodies != left.count() {
            return wrong(format!("{} bodies, the problem has {}", self.bodies, left.count()));
        }
        let mut actions = 0;
        for (i, decision) in self.decisions.iter().enumerate() {
            if left.is_empty() {
                return wrong(format!("decision {i} was made for an empty table"));
            }
            match (&decision.action, decision.effect) {
                (None, None) => {}
                (Some(Action::Push(_)), Some(Effect::Pushed | Effect::Toppled | Effect::Blocked)) => actions += 1,
                (Some(Action::Grasp(grasp)), Some(effect @ (Effect::Grasped | Effect::Missed))) => {
                    if !left.contains(grasp.body) {
                        return wrong(format!("decision {i} grasps body {}, which is not there", grasp.body));
                    }
                    if effect == Effect::Grasped {
                        left.remove(grasp.body);
                    }
                    actions += 1;
                }
                (action, effect) => return wrong(format!("decision {i}: {action:?} had the effect {effect:?}")),
            }
        }
        let again = ClearTrial::new(self.index, self.end, self.bodies, self.decisions.clone());
        if again != *self || self.actions != actions || self.taken != self.bodies - left.count() {
            return wrong("the counts are not those of the decisions".into());
        }
        let ended = match self.end {
            ClearEnd::Cleared => left.is_empty(),
            ClearEnd::ActionCap => !left.is_empty() && actions == max_actions,
            ClearEnd::NoAction => !left.is_empty() && self.decisions.last().is_some_and(|d| d.action.is_none()),
            ClearEnd::BodyLeft => !left.is_empty(),
            ClearEnd::Cancelled => true,
        };
        if !ended || actions > max_actions {
            return wrong(format!("ended as {:?} with {} bodies left after {actions} actions", self.end, left.count()));
        }
        Ok(())
    }
}

/// The numbers of several trials.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ClearNumbers {
    pub runs: usize,
    pub completed: usize,
    /// Completed trials over trials.
    pub completion: f64,
    /// Trials in which no body left the workspace over trials.
    pub nothing_left: f64,
    /// Bodies taken over grasps attempted; none without a grasp.
    pub grasp_success: Option<f64>,
    /// Bodies taken over actions; none without an action.
    pub efficiency: Option<f64>,
    /// The same of the completed trials alone.
    pub grasp_success_completed: Option<f64>,
    pub efficiency_completed: Option<f64>,
    pub actions: usize,
    pub pushes: usize,
    pub blocked: usize,
    pub grasps: usize,
    pub taken: usize,
    /// Mean over trials of the summed decision time.
    pub planning_s: f64,
    pub decision_ms: Spread,
}

impl ClearNumbers {
    pub fn of<'a>(trials: impl IntoIterator<Item = &'a ClearTrial>) -> ClearNumbers {
        let trials: Vec<&ClearTrial> = trials.into_iter().collect();
        let completed: Vec<&ClearTrial> = trials.iter().copied().filter(|t| t.completed()).collect();
        let sum = |of: &[&ClearTrial], value: fn(&ClearTrial) -> usize| of.iter().map(|t| value(t)).sum::<usize>();
        let ratio = |part: usize, whole: usize| (whole > 0).then(|| part as f64 / whole as f64);
        let kept = trials.iter().filter(|t| t.end != ClearEnd::BodyLeft).count();
        let times: Vec<f64> = trials.iter().flat_map(|t| &t.decisions).map(|d| d.milliseconds).collect();
        ClearNumbers {
            runs: trials.len(),
            completed: completed.len(),
            completion: ratio(completed.len(), trials.len()).unwrap_or(0.0),
            nothing_left: ratio(kept, trials.len()).unwrap_or(0.0),
            grasp_success: ratio(sum(&trials, |t| t.taken), sum(&trials, |t| t.grasps)),
            efficiency: ratio(sum(&trials, |t| t.taken), sum(&trials, |t| t.actions)),
            grasp_success_completed: ratio(sum(&completed, |t| t.taken), sum(&completed, |t| t.grasps)),
            efficiency_completed: ratio(sum(&completed, |t| t.taken), sum(&completed, |t| t.actions)),
            actions: sum(&trials, |t| t.actions),
            pushes: sum(&trials, |t| t.pushes),
            blocked: sum(&trials, |t| t.blocked),
            grasps: sum(&trials, |t| t.grasps),
            taken: sum(&trials, |t| t.taken),
            planning_s: mean(&trials.iter().map(|t| t.planning_s).collect::<Vec<_>>()),
            decision_ms: Spread::of(&times),
        }
    }
}

/// The trials of one case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ClearCase {
    pub name: String,
    pub bodies: usize,
    #[serde(flatten)]
    pub numbers: ClearNumbers,
    pub trials: Vec<ClearTrial>,
}

/// Many cases, and the numbers over all their trials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ClearReport {
    pub planner: String,
    pub cases: Vec<ClearCase>,
    pub total: ClearNumbers,
}

/// What decides: a planner, or something that stands for one.
pub trait ClearPolicy {
    fn decide(&mut self, problem: &Clearing, control: &Control) -> Result<Plan>;
    fn executed(&mut self, action: &Action);
    fn failed(&mut self, action: &Action);
}

impl ClearPolicy for ClearPlanner {
    fn decide(&mut self, problem: &Clearing, control: &Control) -> Result<Plan> {
        self.solve(problem, control)
    }

    fn executed(&mut self, action: &Action) {
        self.advance(action);
    }

    fn failed(&mut self, action: &Action) {
        ClearPlanner::failed(self, action);
    }
}

/// The cap on actions of a problem.
pub fn clear_cap(problem: &Clearing, max_actions: Option<usize>) -> usize {
    max_actions.unwrap_or_else(|| CLEAR_ACTIONS_PER_BODY * problem.remaining(&problem.state).count().max(1))
}

/// Runs one trial.
pub fn clear_trial(
    policy: &mut dyn ClearPolicy,
    judge: &mut Judge,
    problem: &Clearing,
    index: u64,
    max_actions: usize,
    control: &Control,
) -> Result<ClearTrial> {
    let bodies = problem.remaining(judge.truth()).count();
    let mut decisions: Vec<Decision> = Vec::new();
    let (mut actions, mut looks) = (0, 0);
    let end = loop {
        if judge.target_left() {
            break ClearEnd::BodyLeft;
        }
        if problem.remaining(judge.truth()) == Mask::EMPTY {
            break ClearEnd::Cleared;
        }
        if actions == max_actions {
            break ClearEnd::ActionCap;
        }
        if looks == LOOKS_WITHOUT_ACTION {
            break ClearEnd::NoAction;
        }
        let seen = problem.at(judge.observe());
        let watch = Stop::never();
        let plan = policy.decide(&seen, control)?;
        let milliseconds = watch.elapsed().as_secs_f64() * 1e3;
        if plan.outcome == Outcome::Cancelled {
            break ClearEnd::Cancelled;
        }
        let action = plan.actions.first().map(|a| a.action);
        let chance = action.and_then(|a| judge.chance(&a));
        let effect = action.map(|a| judge.execute(&a)).transpose()?;
        decisions.push(Decision {
            milliseconds,
            iterations: plan.statistics.iterations,
            simulations: plan.statistics.simulations,
            outcome: plan.outcome,
            planned: plan.actions.len(),
            action,
            chance,
            effect,
        });
        match (action, effect) {
            (Some(action), Some(effect)) if effect.is_executed() => policy.executed(&action),
            (Some(action), _) => policy.failed(&action),
            (None, _) => {}
        }
        if action.is_some() {
            (actions, looks) = (actions + 1, 0);
        } else {
            looks += 1;
        }
    };
    Ok(ClearTrial::new(index, end, bodies, decisions))
}

/// Runs the trials of one problem, each with a fresh planner. A cancelled trial ends the case and is not counted.
pub fn clear_case(problem: &Clearing, config: &ClearTrials, control: &Control) -> Result<ClearCase> {
    problem.validate()?;
    let cap = clear_cap(problem, config.max_actions);
    let mut trials = Vec::new();
    for index in 0..config.trials {
        let seed = config.planner.seed.wrapping_add(index);
        let mut planner = ClearPlanner::new(ClearOptions { seed, ..config.planner.clone() })?;
        let mut judge = Judge::of_clearing(problem, &config.judge, index)?;
        let trial = clear_trial(&mut planner, &mut judge, problem, index, cap, control)?;
        if trial.end == ClearEnd::Cancelled {
            break;
        }
        trial.check(problem, cap)?;
        trials.push(trial);
    }
    let bodies = problem.remaining(&problem.state).count();
    Ok(ClearCase { name: problem.name.clone(), bodies, numbers: ClearNumbers::of(&trials), trials })
}

/// Runs a suite; `done` is called after each case.
pub fn clear_suite(
    problems: &[Clearing],
    config: &ClearTrials,
    control: &Control,
    mut done: impl FnMut(&ClearCase),
) -> Result<ClearReport> {
    config.validate()?;
    let mut cases = Vec::new();
    for problem in problems {
        let case = clear_case(problem, config, control)?;
        done(&case);
        cases.push(case);
        if control.cancel.iter().any(CancelToken::is_triggered) {
            break;
        }
    }
    let total = ClearNumbers::of(cases.iter().flat_map(|case| &case.trials));
    Ok(ClearReport { planner: config.planner.planner.clone(), cases, total })
}
