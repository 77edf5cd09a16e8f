//! `pmbs`: parallel Monte Carlo tree search with batched simulation (dissertation, chapter PMBS).
//!
//! Waves of lanes with virtual loss and leaf parallelism; mean returns, c = 0.3, discount 0.8, depth 7 with at least 3
//! more rollout steps, reward `[solved] + 0.1 q`, early stop by level. With one lane it is the chapter's serial search.
//! The published 1000 environments suit a graphics card; here a lane is a push on a processor core, so a wave is 64.

use super::recipe::Recipe;
use super::retrieval::Reward;
use crate::run::Budget;
use crate::search::Params;

/// Lanes where the user sets none.
const LANES: usize = 64;
/// Published seconds of a decision (T_max).
const SECONDS: f64 = 60.0;

pub fn recipe(lanes: Option<usize>, solved_score: f64) -> Recipe {
    Recipe {
        search: Params::pmbs(lanes.unwrap_or(LANES) as u32),
        sampler: "pmbs",
        reward: Reward { shaping: 0.1, solved_score },
        budget: Budget::seconds(SECONDS),
    }
}
