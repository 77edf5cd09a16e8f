//! A planner is a recipe: a sampler, a reward and the parameters of the one search.

use super::options::{Confirm, PlannerOptions};
use super::retrieval::Reward;
use super::{hedge, mcts, pmbs};
use crate::error::{Error, Result};
use crate::physics::PhysicsOptions;
use crate::run::Budget;
use crate::search::Params;

/// What makes a planner by name.
#[derive(Debug, Clone)]
pub struct Recipe {
    pub search: Params,
    /// Engine of the search.
    pub physics: PhysicsOptions,
    /// Engine that plans are tried in before the decision.
    pub confirm: Option<PhysicsOptions>,
    /// Plans are chosen by their expected number of actions in perturbed worlds.
    pub hedges: bool,
    /// Name of its push sampler.
    pub sampler: &'static str,
    pub reward: Reward,
    /// Limits of a decision where the user sets none.
    pub budget: Budget,
}

/// The ids of the planners.
pub const PLANNERS: [&str; 3] = ["hedge", "pmbs", "mcts"];

/// The planner's own recipe with what the options change in it.
pub fn recipe(options: &PlannerOptions) -> Result<Recipe> {
    let mut recipe = match options.planner.as_str() {
        "hedge" => hedge::recipe(options)?,
        "pmbs" => pmbs::recipe(options)?,
        "mcts" => mcts::recipe(options)?,
        other => {
            let known = PLANNERS.join(", ");
            return Err(Error::not_found("planner", format!("no planner is named `{other}`; known: {known}")));
        }
    };
    if let Some(physics) = &options.physics {
        recipe.physics = physics.clone();
    }
    match &options.confirm {
        Confirm::Own => {}
        Confirm::Off => recipe.confirm = None,
        Confirm::With(physics) => recipe.confirm = Some(physics.clone()),
    }
    if let Some(lanes) = options.lanes {
        recipe.search.lanes = lanes as u32;
    }
    if let Some(depth) = options.max_depth {
        recipe.search.max_depth = depth;
    }
    if let Some(search) = options.search {
        recipe.search = search;
    }
    recipe.search.validate().map_err(|e| e.within("search"))?;
    Ok(recipe)
}
