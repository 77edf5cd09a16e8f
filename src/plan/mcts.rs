//! `mcts`: Monte Carlo tree search over a physics engine (dissertation, chapter MORE, section "Monte-Carlo Tree Search").
//!
//! Serial UCT with the mean of the ten best returns, depth 4, discount 0.5, 50 iterations, MORE's contour pushes,
//! reward `[solved] + 0.2 q`. Early stop as in the text: a graspable node whose parent level is fully expanded.
//! The published code searches to depth 3 and stops early at level 2 at most. Tuned, it differs from
//! the text in one thing: the final choice is among the actions that lead to a shortest known plan, so that a plan which
//! was found is the plan that is returned.

use super::options::{PlannerOptions, Variant};
use super::recipe::Recipe;
use super::retrieval::Reward;
use crate::error::Result;
use crate::physics::{PhysicsOptions, Purpose};
use crate::run::Budget;
use crate::search::{EarlyStop, Params};

/// Published iterations of a decision (MCTS-50).
const ITERATIONS: u64 = 50;

pub fn recipe(options: &PlannerOptions) -> Result<Recipe> {
    let text = Params::mcts();
    let search = match options.variant {
        Variant::Tuned => Params { prefer_solution: true, ..text },
        Variant::Dissertation => text,
        Variant::Code => {
            Params { max_depth: 3, early_stop: EarlyStop::LevelComplete { first: 1, last: Some(2) }, ..text }
        }
    };
    Ok(Recipe::new(
        search,
        PhysicsOptions::named("planar", None, Purpose::Planning)?,
        "more",
        Reward { shaping: 0.2, solved_score: options.grasp.solved_score },
        Budget::iterations(ITERATIONS),
    ))
}
