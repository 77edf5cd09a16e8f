//! What can be asked of a planner of rearrangements. Every field has a default; errors name the field.

use super::samplers::SampleCounts;
use crate::action::MoveCosts;
use crate::error::{Error, Result, check_range};
use crate::motion::PathParams;
use crate::plan::Variant;
use crate::run::Budget;
use crate::search::Params;

/// Planners of rearrangements, by id.
pub const REARRANGE_PLANNERS: [&str; 3] = ["untangle", "pmmr", "hbfs"];

/// What a state is worth to PMMR (REMP, "Reward Shaping").
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RearrangeReward {
    /// Reward of a body at its goal, `r_o`: 0.7.
    pub body: f64,
    /// Factor on it for a body that can only be dragged: 1.1.
    pub drag_only: f64,
    /// Whether the reward of the initial state, `R_b`, is subtracted (the ablation "no R_b" is without).
    pub base: bool,
}

impl Default for RearrangeReward {
    fn default() -> Self {
        RearrangeReward { body: 0.7, drag_only: 1.1, base: true }
    }
}

/// Everything a planner of rearrangements can be told.
#[derive(Debug, Clone, PartialEq)]
pub struct RearrangeOptions {
    /// One of [`REARRANGE_PLANNERS`].
    pub planner: String,
    /// Tuned, or as the text says; no code was published.
    pub variant: Variant,
    /// Limits of one decision. Without iterations and seconds the planner's own budget is used. An iteration is one
    /// of the search (`pmmr`) or one plan tried (`untangle`, `hbfs`).
    pub budget: Budget,
    pub seed: u64,
    /// Physical threads; 0 or 1 runs on the caller. Never changes a plan made within an iteration budget.
    pub threads: usize,
    /// Plans worked at between two updates of the best one, or lanes of the tree search. Changes plans.
    pub lanes: Option<usize>,
    /// Runs of `hbfs`, each with a seed of its own; the best plan is taken.
    pub seeds: usize,
    /// Most moves of a plan; 20, or three for each body where that is more, if absent.
    pub max_moves: Option<u32>,
    /// Greatest depth of the tree of `pmmr`; 2 N + 2 if absent. The ablation has 3.
    pub max_depth: Option<u32>,
    /// How drags are planned. Its clearance is kept by all places but goals, which are taken as they are given; its
    /// weight of turns is that of `costs`. Fewer iterations and shortcuts than for a single path: a plan asks for thousands.
    pub paths: PathParams,
    pub costs: MoveCosts,
    pub samples: SampleCounts,
    pub reward: RearrangeReward,
    /// Every parameter of the tree search; takes the place of `pmmr`'s own, of `lanes` and of `max_depth`.
    pub search: Option<Params>,
}

impl Default for RearrangeOptions {
    fn default() -> Self {
        RearrangeOptions {
            planner: "untangle".into(),
            variant: Variant::Tuned,
            budget: Budget::default(),
            seed: 0,
            threads: 0,
            lanes: None,
            seeds: 1,
            max_moves: None,
            max_depth: None,
            paths: PathParams { iterations: 400, shortcuts: 12, ..PathParams::default() },
            costs: MoveCosts::default(),
            samples: SampleCounts::default(),
            reward: RearrangeReward::default(),
            search: None,
        }
    }
}

impl RearrangeOptions {
    /// Checks what can be checked without a scene.
    pub fn validate(&self) -> Result<()> {
        if !REARRANGE_PLANNERS.contains(&self.planner.as_str()) {
            let known = REARRANGE_PLANNERS.join(", ");
            return Err(Error::not_found("planner", format!("there is no `{}`; there are {known}", self.planner)));
        }
        self.budget.validate()?;
        check_range("threads", self.threads as f64, 0.0..=1024.0)?;
        if let Some(lanes) = self.lanes {
            check_range("lanes", lanes as f64, 1.0..=65536.0)?;
        }
        check_range("seeds", self.seeds as f64, 1.0..=65536.0)?;
        if let Some(moves) = self.max_moves {
            check_range("max_moves", f64::from(moves), 1.0..=1000.0)?;
        }
        if let Some(depth) = self.max_depth {
            check_range("max_depth", f64::from(depth), 1.0..=1000.0)?;
        }
        self.paths.validate().map_err(|error| error.within("paths"))?;
        check_range("reward.body", self.reward.body, 0.0..=1e6)?;
        check_range("reward.drag_only", self.reward.drag_only, 0.0..=1e6)?;
        self.costs.validate()?;
        self.samples.validate()?;
        self.search.as_ref().map_or(Ok(()), Params::validate)
    }
}
