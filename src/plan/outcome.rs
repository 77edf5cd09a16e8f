//! What a planner answers.

use serde::{Deserialize, Serialize};

use super::reason::Reason;
use crate::action::Action;
use crate::scene::State;

/// How a decision ended. None of these is an error. [`Plan::reasons`] says why one is not solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The plan ends with the target grasped, or with every body at its goal or off the table, in the planner's model.
    Solved,
    /// The search ended by itself short of that; the plan holds the best found.
    Partial,
    /// It was shown that the planner's actions do not solve the problem: nothing can be done, or a body that has to be
    /// dragged is enclosed by what stays. The plan holds no actions.
    Infeasible,
    /// A limit was reached first; the plan holds the best found so far.
    Budget,
    /// Cancelled; the plan holds no actions, so that an unread outcome moves no robot.
    Cancelled,
}

/// One action of a plan with what the planner expects of it.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedAction {
    pub action: Action,
    /// The state after the action in the planner's model; after a grasp, without the grasped body.
    pub predicted: State,
    /// The search's value of the action.
    pub value: f64,
}

/// A first action that was considered, for explaining the decision.
#[derive(Debug, Clone, PartialEq)]
pub struct RankedAction {
    pub action: Action,
    /// Mean of the counted returns.
    pub value: f64,
    /// Greatest return.
    pub best_return: f64,
    pub visits: u64,
    pub prior: f64,
    /// Fewest actions to a solution below it, if one was found.
    pub solution_level: Option<u32>,
    /// Estimated from perturbed worlds, where the planner weighs plans in them: the probability that the target is out
    /// after no more actions than the best plan that begins so, and the mean number of actions.
    pub success_chance: Option<f64>,
    pub expected_actions: Option<f64>,
    /// The state after the action in the model of the search.
    pub predicted: State,
}

/// What the decision took.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PlanStatistics {
    /// Iterations of the search; the same number as an iteration budget gives the same plan again.
    pub iterations: u64,
    pub nodes: u64,
    /// Pushes simulated.
    pub simulations: u64,
    /// Wall-clock seconds of the decision.
    pub seconds: f64,
    /// Seconds of all threads within domain steps: physics, grasp test, sampling.
    pub domain_seconds: f64,
    /// Seconds of the coordinating thread outside of domain steps.
    pub search_seconds: f64,
    /// No plan of this many pushes or fewer exists in the planner's action set and model (all were tried), if known.
    pub no_plan_within: Option<u32>,
    /// Plans tried in the confirming engine before the decision.
    pub plans_tried: u64,
    /// Of these, plans that succeed there too.
    pub plans_confirmed: u64,
    /// Pushes simulated in the confirming engine.
    pub confirm_simulations: u64,
    /// Wall-clock seconds of it, contained in `seconds`.
    pub confirm_seconds: f64,
    /// No plan of fewer pushes exists in the planner's action set and model: every push of every state that fewer
    /// pushes lead to was tried.
    pub proved_shortest: bool,
    /// Estimated probability that the target is out after no more actions than the plan has, if the robot looks and plans
    /// again after every action; of planners that weigh plans in perturbed worlds.
    pub success_chance: Option<f64>,
    /// Estimated number of actions until then, on average.
    pub expected_actions: Option<f64>,
    /// Perturbed worlds that these two are estimated from.
    pub worlds: u64,
}

/// The answer of a planner.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    pub outcome: Outcome,
    /// Why it is not solved; empty for a plan that is, and for one that was cancelled.
    pub reasons: Vec<Reason>,
    /// What to do, in order. Execute the first action, observe, and plan again.
    pub actions: Vec<PlannedAction>,
    /// Probability-like score of the plan's last grasp in the model, 0 without one.
    pub grasp_score: f64,
    /// The first actions considered, best first (at most 16).
    pub considered: Vec<RankedAction>,
    pub statistics: PlanStatistics,
    /// The planner's id.
    pub planner: String,
    pub seed: u64,
}

impl Plan {
    pub(crate) fn empty(outcome: Outcome, planner: &str, seed: u64) -> Plan {
        Plan {
            outcome,
            reasons: Vec::new(),
            actions: Vec::new(),
            grasp_score: 0.0,
            considered: Vec::new(),
            statistics: PlanStatistics::default(),
            planner: planner.to_string(),
            seed,
        }
    }

    /// A hash of the exact bits of outcome, actions and predicted states: equal for equal plans.
    pub fn hash_bits(&self) -> u64 {
        let mut h = 0x9e37_79b9_7f4a_7c15u64;
        let mut mix = |v: u64| h = (h ^ v).wrapping_mul(0x0100_0000_01b3).rotate_left(29);
        mix(self.outcome as u64);
        for step in &self.actions {
            match &step.action {
                Action::Push(p) => p.start.iter().chain(&p.end).for_each(|v| mix(v.to_bits())),
                Action::Grasp(g) => {
                    mix(g.body as u64);
                    [g.position[0], g.position[1], g.angle, g.opening].iter().for_each(|v| mix(v.to_bits()));
                }
            }
            mix(step.predicted.hash_bits());
            mix(step.value.to_bits());
        }
        h
    }
}
