//! A planner is a recipe: a sampler, a reward and the parameters of the one search.

use super::options::{Confirm, PlannerOptions};
use super::outcome::PlannedAction;
use super::retrieval::Reward;
use super::{hedge, mcts, more, pmbs, vft};
use crate::action::{Action, Push};
use crate::error::{Error, Result};
use crate::geom::normalize_angle;
use crate::physics::PhysicsOptions;
use crate::run::Budget;
use crate::search::Params;

/// When two pushes after another are executed as one motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Join {
    /// Greatest difference of their directions, radians.
    pub angle: f64,
    /// Greatest distance of the second's start from the first's end: metres, for the published gripper.
    pub distance: f64,
}

impl Join {
    fn one_motion(&self, first: &Push, second: &Push, scale: f64) -> bool {
        normalize_angle(second.angle() - first.angle()).abs() < self.angle
            && (second.start() - first.end()).norm() < scale * self.distance
    }

    /// Makes the pushes at the beginning of a plan that go on in one line a single one, from the first start to the last end.
    /// The state predicted after it is that of the last. `scale` is the gripper's.
    pub fn merge(&self, actions: &mut Vec<PlannedAction>, scale: f64) {
        while let [first, second, ..] = &actions[..]
            && let (Action::Push(a), Action::Push(b)) = (&first.action, &second.action)
            && self.one_motion(a, b, scale)
        {
            let whole = Push { end: b.end, ..*a };
            actions[1] = PlannedAction { action: Action::Push(whole), value: first.value, ..second.clone() };
            actions.remove(0);
        }
    }
}

/// What makes a planner by name.
#[derive(Debug, Clone)]
pub struct Recipe {
    pub search: Params,
    /// Engine of the search.
    pub physics: PhysicsOptions,
    /// Engine that plans are tried in before the decision.
    pub confirm: Option<PhysicsOptions>,
    /// What says how good a state is: one of [`crate::grasp::SCORERS`].
    pub scorer: String,
    /// What values pushes before they are tried: one of [`PRIORS`].
    pub prior: Option<String>,
    /// Whether the robot executes pushes in one line as one motion.
    pub join: Option<Join>,
    /// Plans are chosen by their expected number of actions in perturbed worlds.
    pub hedges: bool,
    /// Name of its push sampler.
    pub sampler: &'static str,
    pub reward: Reward,
    /// Limits of a decision where the user sets none.
    pub budget: Budget,
}

impl Recipe {
    /// Geometric grasps, no network, nothing confirmed.
    pub fn new(
        search: Params,
        physics: PhysicsOptions,
        sampler: &'static str,
        reward: Reward,
        budget: Budget,
    ) -> Recipe {
        let (scorer, prior, join) = ("geometric".into(), None, None);
        Recipe { search, physics, confirm: None, scorer, prior, join, hedges: false, sampler, reward, budget }
    }
}

/// What can value pushes before they are tried.
pub const PRIORS: [&str; 1] = ["ppn"];

/// The ids of the planners.
pub const PLANNERS: [&str; 7] = ["hedge", "pmbs", "mcts", "more", "ppn", "vft", "dipn"];

/// The planner's own recipe with what the options change in it.
pub fn recipe(options: &PlannerOptions) -> Result<Recipe> {
    let mut recipe = match options.planner.as_str() {
        "hedge" => hedge::recipe(options)?,
        "pmbs" => pmbs::recipe(options)?,
        "mcts" => mcts::recipe(options)?,
        "more" => more::recipe(options)?,
        "ppn" => more::policy(options)?,
        "vft" => vft::recipe(options)?,
        "dipn" => vft::greedy(options)?,
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
    if let Some(scorer) = &options.scorer {
        recipe.scorer.clone_from(scorer);
    }
    match options.prior.as_deref() {
        None => {}
        Some("none") => recipe.prior = None,
        Some(name) if PRIORS.contains(&name) => recipe.prior = Some(name.into()),
        Some(name) => {
            let known = PRIORS.join(", ");
            return Err(Error::not_found(
                "prior",
                format!("nothing named `{name}` values pushes; known: {known}, none"),
            ));
        }
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
