//! The constants of the learned engine.

use serde::{Deserialize, Serialize};

use crate::error::{Result, check_range};

/// What the network does not decide. SI units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DipnSettings {
    /// The tip may overlap a body by this where it comes down; deeper is a landing on the body, metres.
    pub landing_tolerance: f64,
    /// Bodies are felt from this far, metres.
    pub border: f64,
    /// A body that moves less than this, metres,
    pub still_position: f64,
    /// and turns less than this, radians, stays where it is, to the bit: networks are never quite silent. Below what a
    /// planner takes for a motion (2 mm, 2 degrees).
    pub still_angle: f64,
}

impl Default for DipnSettings {
    fn default() -> Self {
        Self { landing_tolerance: 0.0005, border: 0.001, still_position: 0.001, still_angle: 0.0175 }
    }
}

impl DipnSettings {
    /// The built-in network. Other presets are names of built-in networks and paths of files.
    pub const PRESETS: [&'static str; 1] = ["dipn"];

    /// Checks every constant; errors name the field.
    pub fn validate(&self) -> Result<()> {
        check_range("physics.landing_tolerance", self.landing_tolerance, 0.0..=0.05)?;
        check_range("physics.border", self.border, 0.0..=0.02)?;
        check_range("physics.still_position", self.still_position, 0.0..=0.01)?;
        check_range("physics.still_angle", self.still_angle, 0.0..=0.2)
    }
}
