//! `mcts`: Monte Carlo tree search over a physics engine (dissertation, chapter MORE, section "Monte-Carlo Tree Search").
//!
//! Serial UCT with the mean of the ten best returns, depth 4, discount 0.5, 50 iterations, MORE's contour pushes,
//! reward `[solved] + 0.2 q`. Early stop as in the text: a graspable node whose parent level is fully expanded.

use super::recipe::Recipe;
use super::retrieval::Reward;
use crate::run::Budget;
use crate::search::Params;

/// Published iterations of a decision (MCTS-50).
const ITERATIONS: u64 = 50;

pub fn recipe(solved_score: f64) -> Recipe {
    Recipe {
        search: Params::mcts(),
        sampler: "more",
        reward: Reward { shaping: 0.2, solved_score },
        budget: Budget::iterations(ITERATIONS),
    }
}
