//! What a planner of rearrangements answers.

use crate::action::Move;
use crate::plan::{Outcome, PlanStatistics, Reason};
use crate::scene::State;

/// One move of a plan with what the planner expects of it.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedMove {
    pub action: Move,
    /// The state after the move.
    pub predicted: State,
    /// The search's value of the move; 0 for planners without values.
    pub value: f64,
}

/// A first move that was considered, for explaining the decision.
#[derive(Debug, Clone, PartialEq)]
pub struct RankedMove {
    pub action: Move,
    /// Mean of the counted returns.
    pub value: f64,
    /// Greatest return.
    pub best_return: f64,
    pub visits: u64,
    pub prior: f64,
    /// Fewest moves to a solution below it, if one was found.
    pub solution_level: Option<u32>,
}

/// The answer of a planner: what to do, in order.
#[derive(Debug, Clone, PartialEq)]
pub struct RearrangePlan {
    /// [`Solved`](Outcome::Solved) if the moves bring every body to its goal.
    pub outcome: Outcome,
    /// Why it is not solved; empty for a plan that is, and for one that was cancelled.
    pub reasons: Vec<Reason>,
    pub moves: Vec<PlannedMove>,
    /// Cost of all moves, metres; see [`MoveCosts::metres`](crate::action::MoveCosts::metres).
    pub cost: f64,
    /// Robot time of all moves, seconds.
    pub robot_seconds: f64,
    /// The first moves considered, best first (at most 16).
    pub considered: Vec<RankedMove>,
    pub statistics: PlanStatistics,
    /// The planner's id.
    pub planner: String,
    pub seed: u64,
}

impl RearrangePlan {
    pub(crate) fn empty(outcome: Outcome, planner: &str, seed: u64) -> RearrangePlan {
        RearrangePlan {
            outcome,
            reasons: Vec::new(),
            moves: Vec::new(),
            cost: 0.0,
            robot_seconds: 0.0,
            considered: Vec::new(),
            statistics: PlanStatistics::default(),
            planner: planner.to_string(),
            seed,
        }
    }

    /// A hash of the exact bits of outcome, moves and predicted states: equal for equal plans.
    pub fn hash_bits(&self) -> u64 {
        let mut h = 0x9e37_79b9_7f4a_7c15u64;
        let mut mix = |v: u64| h = (h ^ v).wrapping_mul(0x0100_0000_01b3).rotate_left(29);
        mix(self.outcome as u64);
        for step in &self.moves {
            mix(matches!(step.action, Move::Drag { .. }) as u64);
            mix(step.action.body() as u64);
            for pose in step.action.poses() {
                [pose.x, pose.y, pose.theta].iter().for_each(|v| mix(v.to_bits()));
            }
            mix(step.predicted.hash_bits());
            mix(step.value.to_bits());
        }
        h
    }
}
