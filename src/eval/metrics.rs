//! What a trial was, and the numbers of a case and of a suite.
//!
//! Two ways of counting actions are in use, so both are given:
//! * `mean_actions` (PMBS): all executed actions over all trials, failed ones included;
//! * `actions_per_success` (VFT and MORE): all executed actions over the number of successful trials.
//!
//! They agree where every trial succeeds. An action is a push or a grasp that was sent to the robot, also one that
//! was blocked or missed.

use serde::{Deserialize, Serialize};

use super::statistics::{max, mean, median, percentile};
use crate::action::Action;
use crate::plan::Outcome;

/// What became of an action.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Effect {
    /// The push was executed.
    Pushed,
    /// The push was executed, or as much of it as the engine simulates, and a body fell over or leans on something: its
    /// outline is no longer what it was.
    Toppled,
    /// The tip would have come down on a body, or the engine could not solve the push; nothing was moved.
    Blocked,
    /// The target is out of the clutter.
    Grasped,
    /// The grasp does not hold at the true poses; nothing was moved, unless the recorded robot executes: it may shove the
    /// body or lose it on the way.
    Missed,
}

impl Effect {
    /// The bodies are no longer where they were.
    pub fn is_executed(self) -> bool {
        matches!(self, Effect::Pushed | Effect::Toppled | Effect::Grasped)
    }
}

/// One decision of a planner and what became of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Decision {
    /// Wall-clock time of the decision.
    pub milliseconds: f64,
    pub iterations: u64,
    pub simulations: u64,
    pub outcome: Outcome,
    /// Number of actions of the plan.
    pub planned: usize,
    /// The plan's first action, which was executed; none if the plan is empty.
    pub action: Option<Action>,
    /// Of a grasp: the chance that a real hand keeps it, by [`crate::scene::Keeping::robotiq_2f85`] at the true poses. The
    /// judge's engine tries the grasp out without it: no engine here knows the fingers' compliance or the swing of the arm.
    #[serde(default)]
    pub chance: Option<f64>,
    pub effect: Option<Effect>,
}

/// How a trial ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrialEnd {
    /// The target was grasped: the only success.
    Grasped,
    /// The cap on actions was reached.
    ActionCap,
    /// The target left the workspace.
    TargetLeft,
    /// The planner had no action to offer, again after looking again.
    NoAction,
    /// Cancelled from outside; the trial does not count.
    Cancelled,
}

/// One trial of one case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// From 0.
    pub index: u64,
    pub end: TrialEnd,
    /// Actions that were executed, blocked ones and missed grasps included.
    pub actions: usize,
    pub pushes: usize,
    /// Grasps that were attempted.
    pub grasps: usize,
    /// Sum over the decisions.
    pub planning_s: f64,
    pub decisions: Vec<Decision>,
}

impl Trial {
    pub fn new(index: u64, end: TrialEnd, decisions: Vec<Decision>) -> Trial {
        let count =
            |wanted: &[Effect]| decisions.iter().filter(|d| d.effect.is_some_and(|e| wanted.contains(&e))).count();
        let pushes = count(&[Effect::Pushed, Effect::Toppled, Effect::Blocked]);
        let grasps = count(&[Effect::Grasped, Effect::Missed]);
        let planning_s = decisions.iter().map(|d| d.milliseconds).sum::<f64>() / 1e3;
        Trial { index, end, actions: pushes + grasps, pushes, grasps, planning_s, decisions }
    }

    pub fn success(&self) -> bool {
        self.end == TrialEnd::Grasped
    }
}

/// The trials of one case and their numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CaseReport {
    pub name: String,
    pub bodies: usize,
    /// Share of successful trials, in [0, 1].
    pub completion: f64,
    /// All actions over all trials.
    pub mean_actions: f64,
    /// All actions over the successful trials; none without a success.
    pub actions_per_success: Option<f64>,
    /// Successes over grasps attempted; none without a grasp.
    pub grasp_success: Option<f64>,
    /// Mean over trials of the summed decision time.
    pub planning_s: f64,
    pub decision_ms: Spread,
    pub trials: Vec<Trial>,
}

impl CaseReport {
    pub fn new(name: impl Into<String>, bodies: usize, trials: Vec<Trial>) -> CaseReport {
        let n = Counts::of(&trials);
        CaseReport {
            name: name.into(),
            bodies,
            completion: n.completion(),
            mean_actions: n.mean_actions(),
            actions_per_success: n.actions_per_success(),
            grasp_success: n.grasp_success(),
            planning_s: mean(&trials.iter().map(|t| t.planning_s).collect::<Vec<_>>()),
            decision_ms: Spread::of(&decision_times(&trials)),
            trials,
        }
    }
}

/// Median, 99th percentile and greatest value.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Spread {
    pub median: f64,
    pub p99: f64,
    pub max: f64,
}

impl Spread {
    pub fn of(values: &[f64]) -> Spread {
        Spread { median: median(values), p99: percentile(values, 0.99), max: max(values) }
    }
}

/// A mean by name, so that reports can grow.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Mean {
    pub mean: f64,
}

/// The numbers of a suite. Every trial counts the same, whatever its case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Total {
    pub cases: usize,
    pub trials: usize,
    pub successes: usize,
    /// Successes over trials, in [0, 1].
    pub completion: f64,
    /// All actions over all trials, failed ones included.
    pub mean_actions: f64,
    /// All actions over the successful trials; none without a success.
    pub actions_per_success: Option<f64>,
    /// Successes over grasps attempted; none without a grasp.
    pub grasp_success: Option<f64>,
    pub actions: usize,
    pub grasps: usize,
    /// Mean chance that a real hand keeps a grasp that was attempted, [`Decision::chance`]; none without a grasp.
    #[serde(default)]
    pub grasp_chance: Option<f64>,
    /// Pushes whose tip would have come down on a body.
    pub blocked: usize,
    pub decisions: usize,
    pub decision_ms: Spread,
    /// Sum over the decisions of a trial, mean over all trials.
    pub planning_s_per_case: Mean,
}

impl Total {
    pub fn of(cases: &[CaseReport]) -> Total {
        let trials: Vec<&Trial> = cases.iter().flat_map(|c| &c.trials).collect();
        let n = Counts::of(trials.iter().copied());
        let times = decision_times(trials.iter().copied());
        Total {
            cases: cases.len(),
            trials: n.trials,
            successes: n.successes,
            completion: n.completion(),
            mean_actions: n.mean_actions(),
            actions_per_success: n.actions_per_success(),
            grasp_success: n.grasp_success(),
            actions: n.actions,
            grasps: n.grasps,
            grasp_chance: mean_chance(&trials),
            blocked: n.blocked,
            decisions: times.len(),
            decision_ms: Spread::of(&times),
            planning_s_per_case: Mean { mean: mean(&trials.iter().map(|t| t.planning_s).collect::<Vec<_>>()) },
        }
    }
}

fn decision_times<'a>(trials: impl IntoIterator<Item = &'a Trial>) -> Vec<f64> {
    trials.into_iter().flat_map(|t| &t.decisions).map(|d| d.milliseconds).collect()
}

#[derive(Default)]
struct Counts {
    trials: usize,
    successes: usize,
    actions: usize,
    grasps: usize,
    blocked: usize,
}

impl Counts {
    fn of<'a>(trials: impl IntoIterator<Item = &'a Trial>) -> Counts {
        let mut n = Counts::default();
        for trial in trials {
            n.trials += 1;
            n.successes += usize::from(trial.success());
            n.actions += trial.actions;
            n.grasps += trial.grasps;
            n.blocked += trial.decisions.iter().filter(|d| d.effect == Some(Effect::Blocked)).count();
        }
        n
    }

    fn completion(&self) -> f64 {
        ratio(self.successes, self.trials).unwrap_or(0.0)
    }

    fn mean_actions(&self) -> f64 {
        ratio(self.actions, self.trials).unwrap_or(0.0)
    }

    fn actions_per_success(&self) -> Option<f64> {
        ratio(self.actions, self.successes)
    }

    fn grasp_success(&self) -> Option<f64> {
        ratio(self.successes, self.grasps)
    }
}

fn mean_chance(trials: &[&Trial]) -> Option<f64> {
    let chances: Vec<f64> = trials.iter().flat_map(|t| &t.decisions).filter_map(|d| d.chance).collect();
    (!chances.is_empty()).then(|| mean(&chances))
}

fn ratio(part: usize, whole: usize) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decision(milliseconds: f64, effect: Option<Effect>) -> Decision {
        Decision {
            milliseconds,
            iterations: 1,
            simulations: 1,
            outcome: Outcome::Budget,
            planned: usize::from(effect.is_some()),
            action: None,
            chance: matches!(effect, Some(Effect::Grasped | Effect::Missed)).then_some(milliseconds / 10.0),
            effect,
        }
    }

    fn trial(index: u64, end: TrialEnd, steps: &[(f64, Effect)]) -> Trial {
        Trial::new(index, end, steps.iter().map(|&(ms, e)| decision(ms, Some(e))).collect())
    }

    /// Case a: success after push + grasp, success after push + missed + grasp. Case b: failure at a cap of 3.
    fn cases() -> Vec<CaseReport> {
        use Effect::{Blocked, Grasped, Missed, Pushed};
        let a = vec![
            trial(0, TrialEnd::Grasped, &[(10.0, Pushed), (2.0, Grasped)]),
            trial(1, TrialEnd::Grasped, &[(20.0, Pushed), (4.0, Missed), (6.0, Grasped)]),
        ];
        let b = vec![
            trial(0, TrialEnd::ActionCap, &[(30.0, Pushed), (30.0, Blocked), (30.0, Pushed)]),
            trial(1, TrialEnd::Grasped, &[(1.0, Grasped)]),
        ];
        vec![CaseReport::new("a", 5, a), CaseReport::new("b", 7, b)]
    }

    #[test]
    fn a_case_by_hand() {
        let cases = cases();
        let a = &cases[0];
        assert_eq!((a.completion, a.mean_actions, a.actions_per_success), (1.0, 2.5, Some(2.5)));
        assert!((a.grasp_success.unwrap() - 2.0 / 3.0).abs() < 1e-12);
        assert!((a.planning_s - 0.021).abs() < 1e-12);
        let b = &cases[1];
        assert_eq!((b.completion, b.mean_actions, b.actions_per_success), (0.5, 2.0, Some(4.0)));
        assert_eq!(b.grasp_success, Some(1.0));
    }

    #[test]
    fn a_suite_by_hand() {
        let total = Total::of(&cases());
        assert_eq!((total.cases, total.trials, total.successes, total.decisions), (2, 4, 3, 9));
        assert_eq!((total.actions, total.grasps, total.blocked), (9, 4, 1));
        assert_eq!(total.completion, 0.75);
        assert_eq!(total.mean_actions, 2.25, "failures included, over all trials");
        assert_eq!(total.actions_per_success, Some(3.0), "failures' actions over successes");
        assert_eq!(total.grasp_success, Some(0.75));
        assert!((total.grasp_chance.unwrap() - 0.325).abs() < 1e-12, "of 0.2, 0.4, 0.6 and 0.1");
        // 1 2 4 6 10 20 30 30 30: the middle one, and 0.08 below the last two, which are equal.
        assert_eq!((total.decision_ms.median, total.decision_ms.p99, total.decision_ms.max), (10.0, 30.0, 30.0));
        // (12 + 30 + 90 + 1) / 4 ms
        assert!((total.planning_s_per_case.mean - 0.03325).abs() < 1e-12);
    }

    #[test]
    fn decisions_without_an_action_take_time_but_are_no_actions() {
        let idle = Trial::new(0, TrialEnd::NoAction, vec![decision(5.0, None), decision(5.0, None)]);
        assert_eq!((idle.actions, idle.grasps, idle.planning_s), (0, 0, 0.01));
        let total = Total::of(&[CaseReport::new("c", 3, vec![idle])]);
        assert_eq!((total.completion, total.mean_actions, total.decisions), (0.0, 0.0, 2));
        assert_eq!((total.actions_per_success, total.grasp_success), (None, None));
    }

    #[test]
    fn nothing_has_numbers_too() {
        let total = Total::of(&[]);
        assert_eq!((total.trials, total.completion, total.mean_actions), (0, 0.0, 0.0));
    }
}
