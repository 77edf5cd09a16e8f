//! Choosing an engine by name.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::planar::{Planar, PlanarSettings};
use super::rapier::{Rapier, RapierSettings};
use super::transition::Transition;
use crate::error::{Error, Result};
use crate::scene::Scene;

/// What is known of an engine without making one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EngineInfo {
    pub id: &'static str,
    /// Names of its presets, from the quickest to the finest.
    pub presets: &'static [&'static str],
    /// The preset that planners search with where none is named.
    pub planning: &'static str,
    /// The preset that a judge executes with where none is named.
    pub judging: &'static str,
    /// Whether this build has it; if not, what brings it.
    pub available: std::result::Result<(), &'static str>,
}

/// The engines, present in this build or not.
pub const ENGINES: [EngineInfo; 2] = [
    EngineInfo {
        id: "rapier",
        presets: &RapierSettings::PRESETS,
        planning: "fast",
        judging: "fine",
        available: Ok(()),
    },
    EngineInfo {
        id: "planar",
        presets: &PlanarSettings::PRESETS,
        planning: "fast",
        judging: "fine",
        available: Ok(()),
    },
];

/// What an engine is wanted for: decides its preset where none is named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    Planning,
    Judging,
}

/// Which engine predicts what a push does, and how finely.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PhysicsOptions {
    /// The id of one of [`ENGINES`].
    pub engine: String,
    /// One of the engine's presets.
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

impl EngineInfo {
    /// The engine with this id, whether this build has it or not.
    pub fn find(id: &str) -> Result<&'static EngineInfo> {
        ENGINES.iter().find(|e| e.id == id).ok_or_else(|| {
            let known: Vec<_> = ENGINES.iter().map(|e| e.id).collect();
            Error::not_found("physics.engine", format!("no engine is named `{id}`; known: {}", known.join(", ")))
        })
    }

    /// The engines of this build.
    pub fn available() -> impl Iterator<Item = &'static EngineInfo> {
        ENGINES.iter().filter(|e| e.available.is_ok())
    }

    fn check_available(&self) -> Result<()> {
        self.available
            .map_err(|how| Error::Unsupported(format!("physics.engine: this build has no `{}`; {how}", self.id)))
    }

    /// Refuses a preset that the engine does not have.
    pub fn check_preset(&self, preset: &str) -> Result<()> {
        if self.presets.contains(&preset) {
            return Ok(());
        }
        let known = self.presets.join(", ");
        Err(Error::not_found("physics.preset", format!("{} has no preset `{preset}`; known: {known}", self.id)))
    }
}

impl PhysicsOptions {
    /// rapier with a preset.
    pub fn preset(preset: &str) -> Self {
        Self { engine: "rapier".into(), preset: preset.into(), rapier: None }
    }

    /// An engine by its id, with a preset or (`None`) the one that suits the purpose.
    pub fn named(engine: &str, preset: Option<&str>, purpose: Purpose) -> Result<Self> {
        let info = EngineInfo::find(engine)?;
        let usual = match purpose {
            Purpose::Planning => info.planning,
            Purpose::Judging => info.judging,
        };
        let options = Self { engine: engine.into(), preset: preset.unwrap_or(usual).into(), rapier: None };
        options.validate()?;
        Ok(options)
    }

    /// Checks the names and constants, and that this build has the engine.
    pub fn validate(&self) -> Result<()> {
        let info = EngineInfo::find(&self.engine)?;
        match &self.rapier {
            Some(settings) if self.engine == "rapier" => settings.validate()?,
            Some(_) => {
                let reason = format!("are constants of rapier, but the engine is `{}`", self.engine);
                return Err(Error::argument("physics.rapier", reason));
            }
            None => info.check_preset(&self.preset)?,
        }
        info.check_available()
    }
}

/// Prepares an engine for a scene.
pub fn engine(options: &PhysicsOptions, scene: Arc<Scene>) -> Result<Arc<dyn Transition>> {
    options.validate()?;
    let name = |custom: bool| {
        if custom { format!("{} custom", options.engine) } else { format!("{} {}", options.engine, options.preset) }
    };
    Ok(match options.engine.as_str() {
        "rapier" => {
            let settings = match options.rapier {
                Some(settings) => settings,
                None => RapierSettings::by_name(&options.preset)?,
            };
            Arc::new(Rapier::with_name(name(options.rapier.is_some()), scene, settings)?)
        }
        "planar" => {
            let settings = PlanarSettings::by_name(&options.preset)?;
            Arc::new(Planar::with_name(name(false), scene, settings)?)
        }
        other => return Err(Error::Internal(format!("engine `{other}` is listed but cannot be made"))),
    })
}
