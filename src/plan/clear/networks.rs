//! The networks of a clearing's recipe: those that the options name, or a caller's own.

use std::sync::Arc;

use super::greedy::Recipe;
use super::options::ClearOptions;
use crate::error::Result;
use crate::grasp::{self, GraspabilityScorer, MapScorer, Scorer};
use crate::net::{Gn, GraspMap, MotionModel, TargetProbability, check_gripper};
use crate::physics::{self, PhysicsOptions, Transition};
use crate::plan::OwnNetworks;
use crate::plan::networks::motion;
use crate::scene::{Gripper, Scene};

/// Loaded once for a planner.
#[derive(Default)]
pub(super) struct ClearNetworks {
    /// Of the engine that predicts pushes and of the confirming one, where they are learned.
    model: Option<Arc<dyn MotionModel>>,
    confirm: Option<Arc<dyn MotionModel>>,
    /// The caller's own.
    graspability: Option<Arc<dyn TargetProbability>>,
    grasp_map: Option<Arc<dyn GraspMap>>,
    /// Those that the options name.
    scorer: grasp::Networks,
}

impl ClearNetworks {
    /// Loads what the recipe needs and the caller does not bring.
    pub fn load(options: &ClearOptions, recipe: &Recipe, own: OwnNetworks) -> Result<ClearNetworks> {
        let brought = own.graspability.is_some() || own.grasp_map.is_some();
        Ok(ClearNetworks {
            model: match own.motion {
                Some(motion) => Some(motion),
                None => motion(Some(&recipe.physics), options.engine_model.as_ref())?,
            },
            confirm: motion(recipe.confirm.as_ref(), options.engine_model.as_ref())?,
            scorer: match brought {
                true => grasp::Networks::default(),
                false => grasp::Networks::new(&recipe.scorer, options.scorer_model.clone())?,
            },
            graspability: own.graspability,
            grasp_map: own.grasp_map,
        })
    }

    /// Refuses a gripper that one of them was not made for; `field` is what the error names.
    pub fn check_gripper(&self, field: &str, gripper: &Gripper) -> Result<()> {
        let own = [
            self.model.as_ref().and_then(|network| network.info()),
            self.confirm.as_ref().and_then(|network| network.info()),
            self.graspability.as_ref().and_then(|network| network.info()),
            self.grasp_map.as_ref().and_then(|network| network.info()),
        ];
        own.into_iter().flatten().chain(self.scorer.infos()).try_for_each(|info| check_gripper(field, info, gripper))
    }

    /// What predicts pushes: the engine, or DIPN.
    pub fn engine(&self, physics: &PhysicsOptions, scene: &Arc<Scene>) -> Result<Arc<dyn Transition>> {
        // A caller's own network is the engine, whatever engine the options name.
        let learned = PhysicsOptions { engine: "dipn".into(), ..physics.clone() };
        let physics = if self.model.is_some() { &learned } else { physics };
        physics::engine_with(physics, Arc::clone(scene), self.model.as_ref())
    }

    pub fn confirming(&self, physics: &PhysicsOptions, scene: &Arc<Scene>) -> Result<Arc<dyn Transition>> {
        physics::engine_with(physics, Arc::clone(scene), self.confirm.as_ref())
    }

    /// The learned scorer; none where grasps are judged by geometry. A grasp of a map counts only if its fingers keep their
    /// clearances.
    pub fn scorer(&self, name: &str, scene: &Scene) -> Result<Option<Box<dyn Scorer>>> {
        if let Some(network) = &self.graspability {
            return Ok(Some(Box::new(GraspabilityScorer::new(scene, Arc::clone(network))?)));
        }
        let map = match (&self.grasp_map, &self.scorer.gn, name) {
            (Some(own), ..) => Some(Arc::clone(own)),
            (None, Some(model), "gn") => {
                let network: Arc<dyn GraspMap> = Arc::new(Gn::new(model.clone())?);
                Some(network)
            }
            _ => None,
        };
        Ok(match (map, name) {
            (Some(map), _) => Some(Box::new(MapScorer::new(map)?.checked())),
            (None, "geometric") => None,
            (None, name) => Some(grasp::scorer(name, scene, &self.scorer)?),
        })
    }
}
