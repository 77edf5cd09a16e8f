//! The constants of the planar engine, and its presets.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, check_positive, check_range};
use crate::physics::lanes::InstructionSet;

/// Every constant of the planar engine. SI units. The presets differ in the length of a step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PlanarSettings {
    /// Travel of the tip in a step, metres. A push is cut into equal steps of at most this.
    pub step_length: f64,
    /// Sweeps of the contact solver in a step, at most; see `sweeps_per_contact` for long chains.
    pub sweeps: usize,
    /// A step with many contacts may take this many sweeps for each of them.
    pub sweeps_per_contact: f64,
    /// A step is solved when no impulse changed by more than this share of its travel in a sweep.
    pub tolerance: f64,
    /// Regularisation of the limit surface: a body yields at an impulse that would move it, without friction, by the
    /// step's travel divided by this. Smaller is nearer to quasi-static, and stiffer.
    pub compliance: f64,
    /// Least slope of the friction law that the solver assumes: keeps its steps finite where a body is at rest.
    pub least_slope: f64,
    /// Share of an impulse's last change that is added to its next one, at most: speeds up long chains.
    pub momentum: f64,
    /// Sweeps over the contacts that press, at most, between two over all of them; 0 visits all contacts always.
    pub partial_sweeps: usize,
    /// Bodies whose masses differ by more than this factor, from each other or from the scene's mean (masses as the
    /// greatest friction forces have them), may need more sweeps than the above.
    pub uneven_masses: f64,
    /// They get them until no contact misses the displacement that it wants by more than this share of the step's travel,
    pub uneven_residual: f64,
    /// or until there were so many in the step.
    pub uneven_sweeps: usize,
    /// Contacts are made between bodies nearer than this, and where the tip would come nearer than this in the step,
    /// metres. More makes contacts that hinder what only passes by.
    pub reach: f64,

    /// Share of an overlap that is pushed out in a step.
    pub correction: f64,
    /// Steps with a still tip at the end of a push, at most: they push out what overlap is left.
    pub clean_up_steps: usize,
    /// `tolerance` of these steps: a light body between heavy ones yields slowly, by little in each sweep.
    pub clean_up_tolerance: f64,
    /// Two bodies, borders included, may overlap by this at the end of a push without such steps, metres.
    pub clean_up_overlap: f64,
    /// Collision border round every body, metres (Bullet's hull margin of 1 mm). Where neighbours are nearer than two
    /// borders it shrinks to half the gap, so that nothing starts in overlap because of it.
    pub border: f64,
    /// Torque of the limit surface: greatest force times this times the mean distance of the area from its centre.
    pub torque_ratio: f64,
    /// Distance of the centre of pressure ahead of the centre of mass, metres.
    pub pressure_lead: f64,
    /// Where a robot's path lets the tip rise, it pushes a body until it has come to this share of the body's height:
    /// farther up the body tips more than it moves. Chosen on recorded pushes (docs/robot.md).
    pub tipping_share: f64,
    /// The tip may overlap a body by this where it comes down; deeper is a landing on the body, metres.
    pub landing_tolerance: f64,
    /// Instruction set; the widest of the processor if absent. It changes the speed and no bit of a result.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instruction_set: Option<InstructionSet>,
}

impl Default for PlanarSettings {
    fn default() -> Self {
        Self::fast()
    }
}

impl PlanarSettings {
    /// The names that [`PlanarSettings::by_name`] knows.
    pub const PRESETS: [&'static str; 2] = ["fast", "fine"];

    fn with_step(step_length: f64) -> Self {
        Self {
            step_length,
            sweeps: 40,
            sweeps_per_contact: 2.0,
            tolerance: 0.03,
            compliance: 0.5,
            least_slope: 0.2,
            momentum: 0.8,
            partial_sweeps: 8,
            uneven_masses: 12.0,
            uneven_residual: 0.05,
            uneven_sweeps: 2000,
            reach: 0.001,
            correction: 0.8,
            clean_up_steps: 40,
            clean_up_tolerance: 0.005,
            clean_up_overlap: 0.0005,
            border: 0.001,
            torque_ratio: 1.5,
            pressure_lead: 0.010,
            tipping_share: 0.62,
            landing_tolerance: 0.0005,
            instruction_set: None,
        }
    }

    /// Steps of 6.8 mm, solved coarsely: for search.
    pub fn fast() -> Self {
        Self { tolerance: 0.075, compliance: 0.8, sweeps_per_contact: 0.8, ..Self::with_step(0.0068) }
    }

    /// Steps of 2 mm: for judging.
    pub fn fine() -> Self {
        Self::with_step(0.002)
    }

    /// A preset.
    pub fn by_name(name: &str) -> Result<Self> {
        match name {
            "fast" => Ok(Self::fast()),
            "fine" => Ok(Self::fine()),
            _ => Err(Error::not_found(
                "physics.preset",
                format!("planar has no preset `{name}`; known: {}", Self::PRESETS.join(", ")),
            )),
        }
    }

    /// Checks every constant; errors name the field.
    pub fn validate(&self) -> Result<()> {
        check_range("physics.step_length", self.step_length, 1e-4..=0.02)?;
        check_range("physics.sweeps", self.sweeps as f64, 1.0..=10_000.0)?;
        check_range("physics.sweeps_per_contact", self.sweeps_per_contact, 0.0..=100.0)?;
        check_range("physics.tolerance", self.tolerance, 0.0..=1.0)?;
        check_range("physics.compliance", self.compliance, 0.01..=10.0)?;
        check_range("physics.least_slope", self.least_slope, 0.01..=1.0)?;
        check_range("physics.momentum", self.momentum, 0.0..=0.99)?;
        check_range("physics.partial_sweeps", self.partial_sweeps as f64, 0.0..=10_000.0)?;
        check_range("physics.uneven_masses", self.uneven_masses, 1.0..=1e12)?;
        check_range("physics.uneven_residual", self.uneven_residual, 0.0..=1.0)?;
        check_range("physics.uneven_sweeps", self.uneven_sweeps as f64, 0.0..=1e6)?;
        check_range("physics.reach", self.reach, 0.0..=0.02)?;
        check_range("physics.correction", self.correction, 0.0..=1.0)?;
        check_range("physics.clean_up_steps", self.clean_up_steps as f64, 0.0..=1000.0)?;
        check_range("physics.clean_up_tolerance", self.clean_up_tolerance, 0.0..=1.0)?;
        check_range("physics.clean_up_overlap", self.clean_up_overlap, 0.0..=0.01)?;
        check_range("physics.border", self.border, 0.0..=0.02)?;
        check_positive("physics.torque_ratio", self.torque_ratio)?;
        check_range("physics.pressure_lead", self.pressure_lead, 0.0..=0.1)?;
        check_range("physics.tipping_share", self.tipping_share, 0.0..=1.0)?;
        check_range("physics.landing_tolerance", self.landing_tolerance, 0.0..=0.05)?;
        match self.instruction_set {
            Some(set) if !set.is_available() => {
                Err(Error::Unsupported(format!("physics.instruction_set: this processor has no {set:?}")))
            }
            _ => Ok(()),
        }
    }
}
