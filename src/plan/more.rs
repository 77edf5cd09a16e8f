//! `more`: tree search that a push prediction network guides, and `ppn`, that network alone (dissertation, chapter MORE).
//!
//! The network PPN gives every push of a state a value before it is simulated: the order in which pushes are tried, the
//! actions of rollouts and a part of a node's score. The rest is `mcts`: the same pushes, engine, reward and budget, so
//! that the two can be compared. The network learns from searches of `mcts` (`jostle datagen ppn`); MORE calls this going
//! from System 2 to System 1.
//!
//! * `Dissertation`: depth 3, score `(sum of the three best returns + prior) / (n + 1)`, discount 0.5, the final choice the
//!   greatest return plus prior.
//! * `Code`: depth 2.
//! * `Tuned`, the default: as the text, and a shortest known plan is preferred, as in tuned `mcts`.
//!
//! `ppn` simulates its few best pushes only to see that they can be executed, and takes the one it values most.

use super::mcts;
use super::options::{PlannerOptions, Variant};
use super::recipe::Recipe;
use crate::error::Result;
use crate::run::Budget;
use crate::search::{EarlyStop, FinalChoice, Params};

/// Pushes that `ppn` tries: more than one, as some are illegal.
const TRIED: u64 = 4;

pub fn recipe(options: &PlannerOptions) -> Result<Recipe> {
    let text = Params::guided();
    let search = match options.variant {
        Variant::Tuned => Params { prefer_solution: true, ..text },
        Variant::Dissertation => text,
        Variant::Code => Params { max_depth: 2, ..text },
    };
    Ok(Recipe { search, prior: Some("ppn".into()), ..mcts::recipe(options)? })
}

/// The network alone.
pub fn policy(options: &PlannerOptions) -> Result<Recipe> {
    let search =
        Params { max_depth: 1, final_choice: FinalChoice::Prior, early_stop: EarlyStop::Never, ..Params::guided() };
    Ok(Recipe { search, prior: Some("ppn".into()), budget: Budget::iterations(TRIED), ..mcts::recipe(options)? })
}
