//! A scorer by its name.

use super::graspability::GraspabilityScorer;
use super::map::MapScorer;
use super::params::GraspParams;
use super::scorer::{GeometricScorer, Scorer};
use crate::error::{Error, Result};
use crate::net::{Gc, Gn, Kind, LoadOptions, Model, ModelInfo, check_gripper};
use crate::scene::Scene;

/// The names of the scorers.
pub const SCORERS: [&str; 3] = ["geometric", "gc", "gn"];

/// The networks of the scorers, loaded once.
#[derive(Debug, Clone, Default)]
pub struct Networks {
    pub gc: Option<Model>,
    pub gn: Option<Model>,
}

impl Networks {
    /// What their files say.
    pub fn infos(&self) -> impl Iterator<Item = &ModelInfo> {
        [&self.gc, &self.gn].into_iter().flatten().map(Model::info)
    }

    /// What a scorer needs: the model given, else the built-in one of the scorer's name. Errors name `scorer`.
    pub fn new(scorer: &str, model: Option<Model>) -> Result<Networks> {
        let load = |kind: Kind| match model.clone() {
            Some(model) => model.expect(kind).map(|()| model),
            None => Model::builtin(kind.id(), &LoadOptions::default()),
        };
        match scorer {
            "geometric" if model.is_some() => {
                Err(Error::argument("scorer_model", "is given, but the scorer `geometric` has no network"))
            }
            "geometric" => Ok(Networks::default()),
            "gc" => Ok(Networks { gc: Some(load(Kind::Gc)?), gn: None }),
            "gn" => Ok(Networks { gc: None, gn: Some(load(Kind::Gn)?) }),
            _ => Err(unknown(scorer)),
        }
    }
}

fn unknown(name: &str) -> Error {
    Error::not_found("scorer", format!("no scorer is named `{name}`; known: {}", SCORERS.join(", ")))
}

/// Refuses a name that no scorer has.
pub fn check_scorer(name: &str) -> Result<()> {
    if SCORERS.contains(&name) { Ok(()) } else { Err(unknown(name)) }
}

/// A scorer prepared for a scene. The scene's gripper must be the one that the network was trained for.
pub fn scorer(name: &str, scene: &Scene, networks: &Networks) -> Result<Box<dyn Scorer>> {
    let missing = || Error::State(format!("scorer: the network of `{name}` was not loaded"));
    match name {
        "geometric" => Ok(Box::new(GeometricScorer::new(scene, GraspParams::default())?)),
        "gc" => {
            let model = networks.gc.clone().ok_or_else(missing)?;
            check_gripper("scene.gripper", model.info(), scene.gripper())?;
            Ok(Box::new(GraspabilityScorer::new(scene, std::sync::Arc::new(Gc::new(model)?))?))
        }
        "gn" => {
            let model = networks.gn.clone().ok_or_else(missing)?;
            check_gripper("scene.gripper", model.info(), scene.gripper())?;
            Ok(Box::new(MapScorer::new(std::sync::Arc::new(Gn::new(model)?))?))
        }
        _ => Err(unknown(name)),
    }
}
