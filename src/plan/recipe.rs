//! A planner is a recipe: a sampler, a reward and the parameters of the one search.

use super::retrieval::Reward;
use crate::run::Budget;
use crate::search::Params;

/// What makes a planner by name.
#[derive(Debug, Clone)]
pub struct Recipe {
    pub search: Params,
    /// Name of its push sampler.
    pub sampler: &'static str,
    pub reward: Reward,
    /// Limits of a decision where the user sets none.
    pub budget: Budget,
}
