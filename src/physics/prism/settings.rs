//! The constants of the prism engine, and its presets.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, check_positive, check_range};

/// Every constant of the prism engine. SI units.
///
/// What is imitated is PyBullet 3.2.7 as the original planners use it (1/240 s, hull margin 1 mm, rolling and spinning
/// friction 0.001). Constants that Bullet has keep Bullet's value unless the comment says that they were fitted; the
/// fit was made on the even-numbered recorded pushes (`docs/engines-prism.md`).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PrismSettings {
    /// Time step, seconds.
    pub time_step: f64,
    /// Velocity of the tip, m/s.
    pub speed: f64,
    /// Most Gauss-Seidel sweeps of a step.
    pub iterations: usize,
    /// Sweeps end when no normal velocity changed by more than this, m/s; 0 always makes `iterations` sweeps.
    pub tolerance: f64,
    /// Bodies that touch and whose masses differ by more than this factor may need more sweeps than `iterations`.
    pub uneven_masses: f64,
    /// They get them until no normal velocity misses what is wanted by more than this, m/s,
    pub uneven_residual: f64,
    /// or until there were so many in the step.
    pub uneven_sweeps: usize,
    /// Share of the last step's impulses that a step starts from. Fitted; Bullet's 0.1 needs many more sweeps.
    pub warm_start: f64,
    /// Share of an overlap that is pushed out in a step (Bullet's `erp2`, 0.08 at 1/240 s).
    pub correction: f64,
    /// Greatest speed at which an overlap is pushed out, m/s. Bullet has no such limit; without one a deep overlap at
    /// the start (measuring noise) would throw bodies apart.
    pub correction_speed: f64,
    /// Overlap that is left alone, metres, negative: Bullet's `linearSlop`.
    pub slop: f64,
    /// A cached contact between bodies is dropped when its halves part or slide apart by this times the smaller
    /// angular motion disc of the two pieces (Bullet's `gContactBreakingThreshold`).
    pub body_breaking: f64,
    /// The same for contacts with the ground. Fitted (Bullet: 0.02): few sweeps leave the blocks less sunk.
    pub ground_breaking: f64,
    /// Contacts whose halves will be farther apart than this at the end of the step take no part in it, metres.
    pub ignored_gap: f64,
    /// Rolling and spinning friction of a body's surface, metres: the urdf files' `rolling_friction`. A contact takes
    /// the sum of each surface's value times the coefficient of the other.
    pub rolling: f64,
    /// Fraction of a velocity lost a second (Bullet's damping).
    pub damping: f64,
    /// Collision border round every body, metres (Bullet's hull margin).
    pub border: f64,
    /// Bodies that overlap by more than this at the start because of their borders have these shrunk by the rest.
    pub border_overlap: f64,
    /// Lowest point of the tip over the ground and its highest, metres (the recorded tip less its own border).
    pub tip_low: f64,
    pub tip_high: f64,
    /// A sleeping body wakes when the tip is nearer than this, metres.
    pub wake_gap: f64,
    /// A sleeping body wakes when another presses it by more than this in a step, newton seconds.
    pub wake_impulse: f64,
    /// m/s^2.
    pub gravity: f64,
    /// Greatest time after the tip is lifted, seconds.
    pub settle_time: f64,
    /// A body slower than this has come to rest, m/s (and rad/s times 0.03 m).
    pub settle_speed: f64,
    /// A body sleeps again that was as slow as that for so many steps while no other pressed it; 0: never.
    pub rest_steps: usize,
    /// So many steps after a body woke are made as two of half the length: what a body does when it is first touched
    /// decides most.
    pub halved_steps: usize,
    /// `body_breaking`, `ground_breaking`, `correction` and `iterations` of half a step.
    pub half_body_breaking: f64,
    pub half_ground_breaking: f64,
    pub half_correction: f64,
    pub half_iterations: usize,
    /// A body that leans more than this (radians, about either axis) would topple: the push ends there and says so.
    pub topple_tilt: f64,
    /// The tip may overlap a body by this where it comes down; deeper is a landing on the body, metres.
    pub landing_tolerance: f64,
}

impl Default for PrismSettings {
    fn default() -> Self {
        Self::fine()
    }
}

impl PrismSettings {
    /// The names that [`PrismSettings::by_name`] knows.
    pub const PRESETS: [&'static str; 2] = ["fast", "fine"];

    /// 240 steps a second, as Bullet: for judging.
    pub fn fine() -> Self {
        Self {
            time_step: 1.0 / 240.0,
            speed: 0.13,
            iterations: 6,
            tolerance: 0.01,
            uneven_masses: 12.0,
            uneven_residual: 0.05,
            uneven_sweeps: 400,
            warm_start: 0.9,
            correction: 0.08,
            correction_speed: 0.05,
            slop: 1e-5,
            body_breaking: 0.02,
            ground_breaking: 0.03,
            ignored_gap: 1e-5,
            rolling: 0.001,
            damping: 0.04,
            border: 0.001,
            border_overlap: 0.0005,
            tip_low: 0.0125,
            tip_high: 0.0605,
            wake_gap: 0.0002,
            wake_impulse: 1e-5,
            gravity: 9.8,
            settle_time: 200.0 / 240.0,
            settle_speed: 0.02,
            rest_steps: 4,
            halved_steps: 0,
            half_body_breaking: 0.02,
            half_ground_breaking: 0.03,
            half_correction: 0.08,
            half_iterations: 6,
            topple_tilt: 0.1,
            landing_tolerance: 0.0005,
        }
    }

    /// 120 steps a second with as many sweeps as each needs, halved after every first touch: for search. What drifts in a
    /// step is twice as much, so the contacts live to twice the drift.
    pub fn fast() -> Self {
        Self {
            time_step: 1.0 / 120.0,
            iterations: 12,
            correction: 0.16,
            body_breaking: 0.05,
            ground_breaking: 0.08,
            halved_steps: 6,
            ..Self::fine()
        }
    }

    /// A preset.
    pub fn by_name(name: &str) -> Result<Self> {
        match name {
            "fast" => Ok(Self::fast()),
            "fine" => Ok(Self::fine()),
            _ => Err(Error::not_found(
                "physics.preset",
                format!("prism has no preset `{name}`; known: {}", Self::PRESETS.join(", ")),
            )),
        }
    }

    /// Checks every constant; errors name the field.
    pub fn validate(&self) -> Result<()> {
        check_range("physics.time_step", self.time_step, 1e-5..=0.1)?;
        check_range("physics.speed", self.speed, 1e-3..=10.0)?;
        check_range("physics.iterations", self.iterations as f64, 1.0..=1000.0)?;
        check_range("physics.tolerance", self.tolerance, 0.0..=10.0)?;
        check_range("physics.uneven_masses", self.uneven_masses, 1.0..=1e12)?;
        check_range("physics.uneven_residual", self.uneven_residual, 0.0..=10.0)?;
        check_range("physics.uneven_sweeps", self.uneven_sweeps as f64, 0.0..=1e6)?;
        check_range("physics.warm_start", self.warm_start, 0.0..=1.0)?;
        check_range("physics.correction", self.correction, 0.0..=1.0)?;
        check_positive("physics.correction_speed", self.correction_speed)?;
        check_range("physics.slop", self.slop, 0.0..=0.001)?;
        check_range("physics.body_breaking", self.body_breaking, 1e-4..=1.0)?;
        check_range("physics.ground_breaking", self.ground_breaking, 1e-4..=1.0)?;
        check_range("physics.ignored_gap", self.ignored_gap, 0.0..=0.01)?;
        check_range("physics.rolling", self.rolling, 0.0..=0.1)?;
        check_range("physics.damping", self.damping, 0.0..=10.0)?;
        check_range("physics.border", self.border, 1e-5..=0.02)?;
        check_range("physics.border_overlap", self.border_overlap, 0.0..=0.02)?;
        check_range("physics.tip_low", self.tip_low, 0.0..=10.0)?;
        check_range("physics.tip_high", self.tip_high, self.tip_low..=10.0)?;
        check_range("physics.wake_gap", self.wake_gap, 0.0..=0.01)?;
        check_positive("physics.wake_impulse", self.wake_impulse)?;
        check_range("physics.gravity", self.gravity, 0.1..=1000.0)?;
        check_range("physics.settle_time", self.settle_time, 0.0..=60.0)?;
        check_positive("physics.settle_speed", self.settle_speed)?;
        check_range("physics.rest_steps", self.rest_steps as f64, 0.0..=1e6)?;
        check_range("physics.halved_steps", self.halved_steps as f64, 0.0..=1e6)?;
        check_range("physics.half_body_breaking", self.half_body_breaking, 1e-4..=1.0)?;
        check_range("physics.half_ground_breaking", self.half_ground_breaking, 1e-4..=1.0)?;
        check_range("physics.half_correction", self.half_correction, 0.0..=1.0)?;
        check_range("physics.half_iterations", self.half_iterations as f64, 1.0..=1000.0)?;
        check_range("physics.topple_tilt", self.topple_tilt, 0.01..=0.3)?;
        check_range("physics.landing_tolerance", self.landing_tolerance, 0.0..=0.05)
    }
}
