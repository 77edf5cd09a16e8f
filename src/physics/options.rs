//! Choosing an engine by name.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::rapier::{Rapier, RapierSettings};
use super::transition::Transition;
use crate::error::{Error, Result};
use crate::scene::Scene;

/// The ids of the engines.
pub const ENGINES: [&str; 1] = ["rapier"];

/// Which engine predicts what a push does, and how finely.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PhysicsOptions {
    /// One of [`ENGINES`].
    pub engine: String,
    /// The engine's preset: for rapier `fast`, `balanced` or `fine`.
    pub preset: String,
    /// Every constant of rapier; takes the place of the preset.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rapier: Option<RapierSettings>,
}

impl Default for PhysicsOptions {
    fn default() -> Self {
        Self::preset("fast")
    }
}

impl PhysicsOptions {
    /// The default engine with a preset.
    pub fn preset(preset: &str) -> Self {
        Self { engine: "rapier".into(), preset: preset.into(), rapier: None }
    }

    /// Checks the names and constants.
    pub fn validate(&self) -> Result<()> {
        self.settings().map(drop)
    }

    fn settings(&self) -> Result<RapierSettings> {
        if !ENGINES.contains(&self.engine.as_str()) {
            return Err(Error::not_found(
                "physics.engine",
                format!("no engine is named `{}`; known: {}", self.engine, ENGINES.join(", ")),
            ));
        }
        let settings = match self.rapier {
            Some(settings) => settings,
            None => RapierSettings::by_name(&self.preset)?,
        };
        settings.validate()?;
        Ok(settings)
    }
}

/// Prepares an engine for a scene.
pub fn engine(options: &PhysicsOptions, scene: Arc<Scene>) -> Result<Arc<dyn Transition>> {
    let settings = options.settings()?;
    let name = if options.rapier.is_some() { "rapier custom".into() } else { format!("rapier {}", options.preset) };
    Ok(Arc::new(Rapier::with_name(name, scene, settings)?))
}
