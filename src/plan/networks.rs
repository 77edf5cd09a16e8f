//! The networks of a planner's parts: those that its options name, or a caller's own.

use std::sync::Arc;

use super::options::PlannerOptions;
use super::recipe::Recipe;
use crate::error::Result;
use crate::grasp::{self, GraspabilityScorer, MapScorer, Scorer};
use crate::net::{Dipn, GraspMap, LoadOptions, Model, MotionModel, Ppn, PushValue, TargetProbability, check_gripper};
use crate::physics::{self, PhysicsOptions, Transition};
use crate::scene::{Gripper, Scene};

/// Learned parts that a caller brings, in place of what the options name: a network of another runtime, or a stand-in.
#[derive(Clone, Default)]
pub struct OwnNetworks {
    /// Takes the place of the engine of the search.
    pub motion: Option<Arc<dyn MotionModel>>,
    /// Takes the place of the network that values pushes.
    pub push_value: Option<Arc<dyn PushValue>>,
    /// Takes the place of the scorer.
    pub graspability: Option<Arc<dyn TargetProbability>>,
    /// Takes the place of the scorer, as the network `gn` does.
    pub grasp_map: Option<Arc<dyn GraspMap>>,
}

/// Loaded once for a planner.
pub(super) struct Networks {
    /// Of the search's engine and of the confirming one, where they are learned.
    search: Option<Arc<dyn MotionModel>>,
    confirm: Option<Arc<dyn MotionModel>>,
    scorer: grasp::Networks,
    graspability: Option<Arc<dyn TargetProbability>>,
    grasp_map: Option<Arc<dyn GraspMap>>,
    pub prior: Option<Arc<dyn PushValue>>,
}

impl Networks {
    /// Loads what the recipe needs and the caller does not bring.
    pub fn load(options: &PlannerOptions, recipe: &Recipe, own: OwnNetworks) -> Result<Networks> {
        let motion = |physics: Option<&PhysicsOptions>| motion(physics, options.engine_model.as_ref());
        let search = match own.motion {
            Some(motion) => Some(motion),
            None => motion(Some(&recipe.physics))?,
        };
        let prior = match (own.push_value, &recipe.prior) {
            (Some(value), _) => Some(value),
            (None, Some(network)) => Some(push_value(network, options.prior_model.as_ref())?),
            (None, None) => None,
        };
        let scorer = if own.graspability.is_some() || own.grasp_map.is_some() {
            grasp::Networks::default()
        } else {
            grasp::Networks::new(&recipe.scorer, options.scorer_model.clone())?
        };
        Ok(Networks {
            search,
            confirm: motion(recipe.confirm.as_ref())?,
            scorer,
            graspability: own.graspability,
            grasp_map: own.grasp_map,
            prior,
        })
    }

    /// Refuses a gripper that one of them was not made for; `field` is what the error names.
    pub fn check_gripper(&self, field: &str, gripper: &Gripper) -> Result<()> {
        let own = [
            self.search.as_ref().and_then(|network| network.info()),
            self.confirm.as_ref().and_then(|network| network.info()),
            self.graspability.as_ref().and_then(|network| network.info()),
            self.grasp_map.as_ref().and_then(|network| network.info()),
            self.prior.as_ref().and_then(|network| network.info()),
        ];
        own.into_iter().flatten().chain(self.scorer.infos()).try_for_each(|info| check_gripper(field, info, gripper))
    }

    /// The engine of the search, prepared for a scene.
    pub fn engine(&self, recipe: &Recipe, scene: &Arc<Scene>) -> Result<Arc<dyn Transition>> {
        physics::engine_with(&self.searching(recipe), Arc::clone(scene), self.search.as_ref())
    }

    fn searching(&self, recipe: &Recipe) -> PhysicsOptions {
        match &self.search {
            Some(_) => PhysicsOptions { engine: "dipn".into(), ..recipe.physics.clone() },
            None => recipe.physics.clone(),
        }
    }

    /// What perturbed worlds are simulated with: the confirming engine, or the search's where nothing is confirmed.
    pub fn worlds(&self, recipe: &Recipe) -> (PhysicsOptions, Option<&Arc<dyn MotionModel>>) {
        match &recipe.confirm {
            Some(confirm) => (confirm.clone(), self.confirm.as_ref()),
            None => (self.searching(recipe), self.search.as_ref()),
        }
    }

    /// The engine that plans are confirmed in, if they are.
    pub fn confirming(&self, recipe: &Recipe, scene: &Arc<Scene>) -> Result<Option<Arc<dyn Transition>>> {
        let engine = |options| physics::engine_with(options, Arc::clone(scene), self.confirm.as_ref());
        recipe.confirm.as_ref().map(engine).transpose()
    }

    pub fn scorer(&self, recipe: &Recipe, scene: &Scene) -> Result<Box<dyn Scorer>> {
        match (&self.graspability, &self.grasp_map) {
            (Some(network), _) => Ok(Box::new(GraspabilityScorer::new(scene, Arc::clone(network))?)),
            (None, Some(network)) => Ok(Box::new(MapScorer::new(Arc::clone(network))?)),
            (None, None) => grasp::scorer(&recipe.scorer, scene, &self.scorer),
        }
    }
}

/// The network of an engine, if the engine is a learned one: `model`, or what the preset names.
pub(super) fn motion(physics: Option<&PhysicsOptions>, model: Option<&Model>) -> Result<Option<Arc<dyn MotionModel>>> {
    let learned = physics.filter(|physics| physics.engine == "dipn");
    let load = |physics: &PhysicsOptions| -> Result<Arc<dyn MotionModel>> {
        match model {
            Some(model) => Ok(Arc::new(Dipn::new(model.clone())?)),
            None => physics::Dipn::load(&physics.preset),
        }
    };
    learned.map(load).transpose()
}

fn push_value(name: &str, model: Option<&Model>) -> Result<Arc<dyn PushValue>> {
    let model = match model {
        Some(model) => model.clone(),
        None => Model::builtin(name, &LoadOptions::default())?,
    };
    Ok(Arc::new(Ppn::new(model)?))
}
