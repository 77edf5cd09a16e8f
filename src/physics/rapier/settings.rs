//! The constants of the rapier engine, and its presets.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, check_positive, check_range};

/// Every constant of the rapier2d adapter. SI units. The presets differ in the time step, `fast`
/// in the prediction too.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RapierSettings {
    /// Time step, seconds.
    pub time_step: f64,
    /// Velocity of the tip, m/s.
    pub speed: f64,
    /// Solver iterations (small steps) of a time step.
    pub solver_iterations: usize,
    /// Gauss-Seidel sweeps of a solver iteration.
    pub sweeps: usize,
    /// rapier's unit of length, metres: scales its tolerances. At its default of 1 m blocks sink into each other.
    pub length_unit: f64,
    /// Frequency of the contact springs, Hz.
    pub contact_frequency: f64,
    /// Damping ratio of the contact springs.
    pub contact_damping: f64,
    /// Bodies nearer than this get a contact before they touch, metres.
    pub prediction: f64,
    /// Greatest speed at which an overlap is pushed out, m/s.
    pub correction_speed: f64,
    /// A contact whose bodies moved less than this against each other is not computed anew, metres; 0 computes all.
    pub recycle: f64,
    /// Solve friction while overlaps are pushed out too.
    pub friction_with_bias: bool,
    /// Collision border round every body, metres (Bullet's hull margin of 1 mm). Where neighbours are nearer than two
    /// borders it shrinks to half the gap, so that nothing starts in overlap because of it.
    pub border: f64,
    /// Torque of the limit surface: greatest force times this times the mean distance of the area from its centre.
    pub torque_ratio: f64,
    /// Distance of the centre of pressure ahead of the centre of mass, metres.
    pub pressure_lead: f64,
    /// m/s^2.
    pub gravity: f64,
    /// Greatest time after the tip is lifted, seconds.
    pub settle_time: f64,
    /// A body slower than this has come to rest, m/s (and rad/s times 0.03 m).
    pub settle_speed: f64,
    /// The tip may overlap a body by this where it comes down; deeper is a landing on the body, metres.
    pub landing_tolerance: f64,
}

impl Default for RapierSettings {
    fn default() -> Self {
        Self::balanced()
    }
}

impl RapierSettings {
    /// The names that [`RapierSettings::by_name`] knows.
    pub const PRESETS: [&'static str; 3] = ["fast", "balanced", "fine"];

    fn with_step(time_step: f64) -> Self {
        Self {
            time_step,
            speed: 0.13,
            solver_iterations: 3,
            sweeps: 1,
            length_unit: 0.01,
            contact_frequency: 90.0,
            contact_damping: 10.0,
            prediction: 0.0002,
            correction_speed: 0.03,
            recycle: 0.001,
            friction_with_bias: false,
            border: 0.001,
            torque_ratio: 1.9,
            pressure_lead: 0.012,
            gravity: 9.8,
            settle_time: 0.25,
            settle_speed: 0.005,
            landing_tolerance: 0.0005,
        }
    }

    /// 60 steps a second: for search.
    pub fn fast() -> Self {
        // The tip moves 2 mm a step: without a look ahead it is deep in a body before there is a contact.
        Self { prediction: 0.001, ..Self::with_step(1.0 / 60.0) }
    }

    /// 120 steps a second.
    pub fn balanced() -> Self {
        Self::with_step(1.0 / 120.0)
    }

    /// 240 steps a second: for judging.
    pub fn fine() -> Self {
        Self::with_step(1.0 / 240.0)
    }

    /// A preset.
    pub fn by_name(name: &str) -> Result<Self> {
        match name {
            "fast" => Ok(Self::fast()),
            "balanced" => Ok(Self::balanced()),
            "fine" => Ok(Self::fine()),
            _ => Err(Error::not_found(
                "physics.preset",
                format!("rapier has no preset `{name}`; known: {}", Self::PRESETS.join(", ")),
            )),
        }
    }

    /// Checks every constant; errors name the field.
    pub fn validate(&self) -> Result<()> {
        check_range("physics.time_step", self.time_step, 1e-5..=0.1)?;
        check_range("physics.speed", self.speed, 1e-3..=10.0)?;
        check_range("physics.solver_iterations", self.solver_iterations as f64, 1.0..=1000.0)?;
        check_range("physics.sweeps", self.sweeps as f64, 1.0..=1000.0)?;
        check_range("physics.length_unit", self.length_unit, 1e-4..=100.0)?;
        check_positive("physics.contact_frequency", self.contact_frequency)?;
        check_positive("physics.contact_damping", self.contact_damping)?;
        check_range("physics.prediction", self.prediction, 0.0..=0.1)?;
        check_positive("physics.correction_speed", self.correction_speed)?;
        check_range("physics.recycle", self.recycle, 0.0..=0.1)?;
        check_range("physics.border", self.border, 0.0..=0.02)?;
        check_positive("physics.torque_ratio", self.torque_ratio)?;
        check_range("physics.pressure_lead", self.pressure_lead, 0.0..=0.1)?;
        check_range("physics.gravity", self.gravity, 0.0..=1000.0)?;
        check_range("physics.settle_time", self.settle_time, 0.0..=60.0)?;
        check_positive("physics.settle_speed", self.settle_speed)?;
        check_range("physics.landing_tolerance", self.landing_tolerance, 0.0..=0.05)
    }
}
