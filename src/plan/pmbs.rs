//! `pmbs`: parallel Monte Carlo tree search with batched simulation (dissertation, chapter PMBS).
//!
//! Waves of lanes with virtual loss and leaf parallelism; mean returns, c = 0.3, discount 0.8, depth 7 with at least 3
//! more rollout steps, reward `[solved] + 0.1 q`, early stop by level. With one lane it is the chapter's serial search.
//! The published 1000 environments suit a graphics card; here a lane is a push on a processor core, so a wave is 64.
//! The published code explores with 0.3 times the root of 2, expands the root in one batch first, and ends rollouts when
//! a tenth of the lanes is left.

use super::options::{PlannerOptions, Variant};
use super::recipe::Recipe;
use super::retrieval::Reward;
use crate::run::Budget;
use crate::search::{EarlyStop, Mean, Params, Selection};

/// Lanes where the user sets none.
const LANES: usize = 64;
/// Published seconds of a decision (T_max), and those of the published scripts.
const SECONDS: f64 = 60.0;
const SECONDS_CODE: f64 = 30.0;

pub fn recipe(options: &PlannerOptions) -> Recipe {
    let lanes = options.lanes.unwrap_or(LANES) as u32;
    let text = Params::pmbs(lanes);
    let (search, seconds) = match options.variant {
        Variant::Dissertation => (text, SECONDS),
        Variant::Code => {
            let exploration = 0.3 * std::f64::consts::SQRT_2;
            let selection = Selection::Ucb { mean: Mean::All, exploration };
            let parallel = Params {
                selection,
                first_expand: true,
                early_stop: EarlyStop::LevelComplete { first: 2, last: None },
                rollout_cutoff: 0.1,
                ..text
            };
            (if lanes > 1 { parallel } else { Params { selection, ..text } }, SECONDS_CODE)
        }
    };
    Recipe {
        search,
        sampler: "pmbs",
        reward: Reward { shaping: 0.1, solved_score: options.grasp.solved_score },
        budget: Budget::seconds(seconds),
    }
}
