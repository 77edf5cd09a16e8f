//! Choosing an engine by name.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::bullet::{self, BulletSettings};
use super::dipn::{self, Dipn, DipnSettings};
use super::planar::{Planar, PlanarSettings};
use super::prism::{Prism, PrismSettings};
use super::rapier::{Rapier, RapierSettings};
use super::scaled::Scaled;
use super::transition::Transition;
use crate::error::{Error, Result};
use crate::net::MotionModel;
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
pub const ENGINES: [EngineInfo; 5] = [
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
    EngineInfo { id: "prism", presets: &PrismSettings::PRESETS, planning: "fast", judging: "fine", available: Ok(()) },
    EngineInfo {
        id: "bullet",
        presets: &BulletSettings::PRESETS,
        planning: "fast",
        judging: "reference",
        available: bullet::AVAILABLE,
    },
    EngineInfo {
        id: "dipn",
        presets: &DipnSettings::PRESETS,
        planning: "dipn",
        judging: "dipn",
        available: dipn::AVAILABLE,
    },
];

/// The engines that simulate [`crate::scene::Gripper::path`].
pub const FOLLOW_PATHS: [&str; 3] = ["planar", "prism", "bullet"];

/// Every constant of an engine, for settings that no preset has.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EngineSettings {
    Rapier(RapierSettings),
    Planar(PlanarSettings),
    Prism(PrismSettings),
    Bullet(BulletSettings),
    Dipn(DipnSettings),
}

impl EngineSettings {
    /// The id of the engine whose settings they are.
    pub fn engine(&self) -> &'static str {
        match self {
            Self::Rapier(_) => "rapier",
            Self::Planar(_) => "planar",
            Self::Prism(_) => "prism",
            Self::Bullet(_) => "bullet",
            Self::Dipn(_) => "dipn",
        }
    }

    /// A preset of an engine. Errors name `physics.engine` or `physics.preset`.
    pub fn by_name(engine: &str, preset: &str) -> Result<Self> {
        let info = EngineInfo::find(engine)?;
        match info.id {
            "rapier" => RapierSettings::by_name(preset).map(Self::Rapier),
            "planar" => PlanarSettings::by_name(preset).map(Self::Planar),
            "prism" => PrismSettings::by_name(preset).map(Self::Prism),
            "bullet" => BulletSettings::by_name(preset).map(Self::Bullet),
            // The preset names the network.
            "dipn" => Ok(Self::Dipn(DipnSettings::default())),
            other => Err(Error::Internal(format!("engine `{other}` is listed but has no settings"))),
        }
    }

    /// Checks every constant; errors name the field.
    pub fn validate(&self) -> Result<()> {
        match self {
            Self::Rapier(settings) => settings.validate(),
            Self::Planar(settings) => settings.validate(),
            Self::Prism(settings) => settings.validate(),
            Self::Bullet(settings) => settings.validate(),
            Self::Dipn(settings) => settings.validate(),
        }
    }
}

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
    /// One of the engine's presets; for `dipn` the name of a built-in network or the path of a file.
    pub preset: String,
    /// Every constant of the engine; takes the place of the preset.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub settings: Option<Box<EngineSettings>>,
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

    fn check_available(&self, preset: &str) -> Result<()> {
        if self.id == "dipn" && !self.presets.contains(&preset) {
            // A network of the user's own.
            return Ok(());
        }
        self.available
            .map_err(|how| Error::Unsupported(format!("physics.engine: this build has no `{}`; {how}", self.id)))
    }

    /// Refuses a preset that the engine does not have.
    pub fn check_preset(&self, preset: &str) -> Result<()> {
        let network = self.id == "dipn" && !preset.is_empty();
        if self.presets.contains(&preset) || network {
            return Ok(());
        }
        let known = self.presets.join(", ");
        Err(Error::not_found("physics.preset", format!("{} has no preset `{preset}`; known: {known}", self.id)))
    }
}

impl PhysicsOptions {
    /// rapier with a preset.
    pub fn preset(preset: &str) -> Self {
        Self { engine: "rapier".into(), preset: preset.into(), settings: None }
    }

    /// An engine by its id, with a preset or (`None`) the one that suits the purpose.
    pub fn named(engine: &str, preset: Option<&str>, purpose: Purpose) -> Result<Self> {
        let info = EngineInfo::find(engine)?;
        let usual = match purpose {
            Purpose::Planning => info.planning,
            Purpose::Judging => info.judging,
        };
        let options = Self { engine: engine.into(), preset: preset.unwrap_or(usual).into(), settings: None };
        options.validate()?;
        Ok(options)
    }

    /// The same engine with the preset of a judge, where this one is that of a planner and the two differ.
    pub fn finer(&self) -> Option<Self> {
        let info = EngineInfo::find(&self.engine).ok()?;
        let planning = self.settings.is_none() && self.preset == info.planning && info.judging != info.planning;
        planning.then(|| Self { preset: info.judging.into(), ..self.clone() })
    }

    /// Reads `ENGINE:PRESET`, `ENGINE` (with the preset that suits the purpose), or a preset of rapier.
    pub fn parse(text: &str, purpose: Purpose) -> Result<Self> {
        match text.split_once(':') {
            Some((engine, preset)) => Self::named(engine, Some(preset), purpose),
            None if RapierSettings::PRESETS.contains(&text) => Self::named("rapier", Some(text), purpose),
            None => Self::named(text, None, purpose),
        }
    }

    /// An engine with constants of your own.
    pub fn custom(settings: EngineSettings) -> Self {
        Self { engine: settings.engine().into(), preset: "custom".into(), settings: Some(Box::new(settings)) }
    }

    /// Checks the names and constants, and that this build has the engine.
    pub fn validate(&self) -> Result<()> {
        let info = EngineInfo::find(&self.engine)?;
        match &self.settings {
            None => info.check_preset(&self.preset)?,
            Some(settings) if settings.engine() == info.id => settings.validate()?,
            Some(settings) => {
                let reason = format!("are constants of {}, but the engine is `{}`", settings.engine(), self.engine);
                return Err(Error::argument("physics.settings", reason));
            }
        }
        info.check_available(&self.preset)
    }
}

/// Prepares an engine for a scene. The engine `dipn` loads its network every time; see [`engine_with`].
pub fn engine(options: &PhysicsOptions, scene: Arc<Scene>) -> Result<Arc<dyn Transition>> {
    engine_with(options, scene, None)
}

/// The network of the engine, loaded, for callers that prepare it for many scenes; none for other engines.
pub fn network(options: &PhysicsOptions) -> Result<Option<Arc<dyn MotionModel>>> {
    options.validate()?;
    if options.engine != "dipn" {
        return Ok(None);
    }
    Dipn::load(own_network(options)).map(Some)
}

/// What the preset names: a built-in network or a file.
fn own_network(options: &PhysicsOptions) -> &str {
    if options.preset == "custom" { DipnSettings::PRESETS[0] } else { &options.preset }
}

/// The same with a network that is loaded already, for the engine `dipn`.
///
/// An engine's lengths are those for the published gripper; a scene with a larger or smaller one is simulated at that
/// size ([`crate::scene::Gripper::scale`]).
pub fn engine_with(
    options: &PhysicsOptions,
    scene: Arc<Scene>,
    network: Option<&Arc<dyn MotionModel>>,
) -> Result<Arc<dyn Transition>> {
    scene.check_simulated()?;
    check_path(options, &scene)?;
    let scale = scene.gripper().scale();
    if scale == 1.0 {
        return at_size(options, scene, network);
    }
    let inner = at_size(options, Arc::new(scene.scaled(1.0 / scale)), network)?;
    Ok(Arc::new(Scaled::new(scene, inner, scale)))
}

/// Refuses a robot whose tip has a path where the engine would not follow it.
fn check_path(options: &PhysicsOptions, scene: &Scene) -> Result<()> {
    if scene.gripper().path.is_none() || FOLLOW_PATHS.contains(&options.engine.as_str()) {
        return Ok(());
    }
    Err(Error::Unsupported(format!(
        "physics.engine: `{}` cannot follow the path of the tip that `gripper.path` has; {} can, or leave the path out",
        options.engine,
        FOLLOW_PATHS.join(", ")
    )))
}

/// The engine with its constants as they are.
fn at_size(
    options: &PhysicsOptions,
    scene: Arc<Scene>,
    network: Option<&Arc<dyn MotionModel>>,
) -> Result<Arc<dyn Transition>> {
    if let (Some(network), "dipn") = (network, options.engine.as_str()) {
        let settings = match options.settings.as_deref() {
            Some(EngineSettings::Dipn(settings)) => *settings,
            _ => DipnSettings::default(),
        };
        return Ok(Arc::new(Dipn::new(scene, settings, Arc::clone(network))?));
    }
    options.validate()?;
    let preset = if options.settings.is_some() { "custom" } else { &options.preset };
    let name = format!("{} {preset}", options.engine);
    let settings = match &options.settings {
        Some(settings) => **settings,
        None => EngineSettings::by_name(&options.engine, &options.preset)?,
    };
    Ok(match settings {
        EngineSettings::Rapier(settings) => Arc::new(Rapier::with_name(name, scene, settings)?),
        EngineSettings::Planar(settings) => Arc::new(Planar::with_name(name, scene, settings)?),
        EngineSettings::Prism(settings) => Arc::new(Prism::with_name(name, scene, settings)?),
        #[cfg(feature = "bullet")]
        EngineSettings::Bullet(settings) => Arc::new(bullet::Bullet::with_name(name, scene, settings)?),
        #[cfg(not(feature = "bullet"))]
        EngineSettings::Bullet(_) => return Err(Error::Internal("bullet is not built but was not refused".into())),
        EngineSettings::Dipn(settings) => {
            // Constants of one's own go with the built-in network, unless the preset names another.
            Arc::new(Dipn::new(scene, settings, Dipn::load(own_network(options))?)?)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_planning_preset_has_a_finer_one_and_no_other_does() {
        let parse = |text| PhysicsOptions::parse(text, Purpose::Planning).unwrap();
        assert_eq!(parse("prism").finer(), Some(parse("prism:fine")));
        assert_eq!(parse("prism:fine").finer(), None);
        assert_eq!(parse("rapier:balanced").finer(), None, "was asked for");
        assert_eq!(PhysicsOptions::custom(EngineSettings::Prism(PrismSettings::default())).finer(), None);
        let learned = PhysicsOptions { engine: "dipn".into(), preset: "dipn".into(), settings: None };
        assert_eq!(learned.finer(), None, "one network is all it has");
    }
}
