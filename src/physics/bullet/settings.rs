//! The constants of the Bullet engine, and its presets. Present in every build, whatever its features.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, check_positive, check_range};

/// How Bullet's constraint rows are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Solver {
    /// By Bullet's own code.
    Bullet,
    /// The same operations in the same order on compact memory: the same bits, in less time.
    Compact,
    /// Compact, with the friction cone by a square root in place of three trigonometric functions. Equal up to rounding.
    CompactRoot,
}

/// What the bodies stand on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Ground {
    /// A box of 200 m, as the originals have it.
    Box,
    /// A plane.
    Plane,
}

/// Every constant of the Bullet adapter. SI units. `docs/bullet.md` says what each is worth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BulletSettings {
    /// Time step, seconds. Do not coarsen it: at 1/120 s the agreement with the originals falls from 0.91 to 0.80.
    pub time_step: f64,
    /// Velocity of the tip, m/s. Do not raise it: at 0.26 m/s the agreement falls to 0.81.
    pub speed: f64,
    /// Greatest number of sweeps of the contact solver a step.
    pub iterations: u32,
    /// The solver ends a step's sweeps when the sum of squared impulses of one falls below this.
    pub residual: f64,
    pub solver: Solver,
    pub ground: Ground,
    /// The tip is of Bullet's kinematic kind, not a heavy body that is set anew every step.
    pub kinematic_tip: bool,
    /// Contacts farther apart than this give no constraint, metres; 0 means all do.
    pub contact_processing: f64,
    /// Collision margin of all shapes, metres: bodies rest this far above the ground and meet at twice this distance.
    /// Where neighbours are nearer their cores shrink, so that nothing starts in overlap because of it.
    pub margin: f64,
    /// Height of the ground, metres.
    pub ground_height: f64,
    pub ground_restitution: f64,
    /// Share of an overlap that a step removes.
    pub erp: f64,
    /// The same for friction anchors.
    pub friction_erp: f64,
    /// Overlap that is let be, metres.
    pub linear_slop: f64,
    pub warm_start: f64,
    /// Coefficient of the bodies' surfaces against rolling, metres.
    pub rolling_friction: f64,
    /// Coefficient of the bodies' surfaces against spinning, metres.
    pub spinning_friction: f64,
    /// m/s^2.
    pub gravity: f64,
    /// Height of the tip's lower end, metres.
    pub tip_bottom: f64,
    /// Height of the tip's upper end, metres.
    pub tip_top: f64,
    /// How much of the tip's free travel is simulated, metres: it starts this far before it touches anything.
    pub approach: f64,
    /// Greatest time after the tip is lifted, seconds.
    pub settle_time: f64,
    /// A body slower than this has come to rest, m/s (and rad/s times 0.03 m).
    pub settle_speed: f64,
    /// The tip may overlap a body by this where it comes down; deeper is a landing on the body, metres.
    pub landing_tolerance: f64,
    /// A body that leans by more than this afterwards has toppled, radians.
    pub topple_tilt: f64,
    /// A body whose centre rose or sank by more than this has climbed (onto another one) or fallen, metres.
    pub climb: f64,
    /// A body that moved by less than this keeps its pose to the bit: Bullet lets resting bodies creep, metres ...
    pub rest_distance: f64,
    /// ... and turned by less than this, radians.
    pub rest_angle: f64,
}

impl Default for BulletSettings {
    fn default() -> Self {
        Self::reference()
    }
}

impl BulletSettings {
    /// The names that [`BulletSettings::by_name`] knows.
    pub const PRESETS: [&'static str; 2] = ["fast", "reference"];

    /// The settings of the originals' simulator, PyBullet. The tip is taken away at the end of a push, not lifted, which
    /// saves 32 steps and changes nothing measurable.
    pub fn reference() -> Self {
        Self {
            time_step: 1.0 / 240.0,
            speed: 0.13,
            iterations: 50,
            residual: 1e-7,
            solver: Solver::Compact,
            ground: Ground::Box,
            kinematic_tip: false,
            contact_processing: 0.0,
            margin: 0.001,
            ground_height: -0.0005,
            ground_restitution: 0.5,
            erp: 0.08,
            friction_erp: 0.2,
            linear_slop: 1e-5,
            warm_start: 0.1,
            rolling_friction: 0.001,
            spinning_friction: 0.001,
            gravity: 9.8,
            tip_bottom: 0.011,
            tip_top: 0.061,
            approach: 10.0,
            settle_time: 2.0,
            settle_speed: 0.005,
            landing_tolerance: 0.0005,
            topple_tilt: 0.26,
            climb: 0.005,
            rest_distance: 2e-5,
            rest_angle: 2e-4,
        }
    }

    /// What saves time and costs little agreement: fewer sweeps, a plane, a kinematic tip, no free travel.
    pub fn fast() -> Self {
        Self {
            iterations: 20,
            residual: 1e-5,
            solver: Solver::CompactRoot,
            ground: Ground::Plane,
            kinematic_tip: true,
            contact_processing: 0.002,
            approach: 0.003,
            ..Self::reference()
        }
    }

    /// A preset.
    pub fn by_name(name: &str) -> Result<Self> {
        match name {
            "fast" => Ok(Self::fast()),
            "reference" => Ok(Self::reference()),
            _ => Err(Error::not_found(
                "physics.preset",
                format!("bullet has no preset `{name}`; known: {}", Self::PRESETS.join(", ")),
            )),
        }
    }

    /// Checks every constant; errors name the field.
    pub fn validate(&self) -> Result<()> {
        check_range("physics.time_step", self.time_step, 1e-5..=0.1)?;
        check_range("physics.speed", self.speed, 1e-3..=10.0)?;
        check_range("physics.iterations", f64::from(self.iterations), 1.0..=10_000.0)?;
        check_range("physics.residual", self.residual, 0.0..=1.0)?;
        check_range("physics.contact_processing", self.contact_processing, 0.0..=0.1)?;
        check_range("physics.margin", self.margin, 1e-5..=0.01)?;
        check_range("physics.ground_height", self.ground_height, -1.0..=1.0)?;
        check_range("physics.ground_restitution", self.ground_restitution, 0.0..=1.0)?;
        check_range("physics.erp", self.erp, 0.0..=1.0)?;
        check_range("physics.friction_erp", self.friction_erp, 0.0..=1.0)?;
        check_range("physics.linear_slop", self.linear_slop, 0.0..=0.01)?;
        check_range("physics.warm_start", self.warm_start, 0.0..=1.0)?;
        check_range("physics.rolling_friction", self.rolling_friction, 0.0..=1.0)?;
        check_range("physics.spinning_friction", self.spinning_friction, 0.0..=1.0)?;
        check_range("physics.gravity", self.gravity, 0.0..=1000.0)?;
        check_range("physics.tip_bottom", self.tip_bottom, 0.0..=10.0)?;
        check_range("physics.tip_top", self.tip_top, 0.0..=10.0)?;
        if self.tip_top - self.tip_bottom < 4.0 * self.margin {
            return Err(Error::argument("physics.tip_top", "lies too near to tip_bottom; the tip needs a height"));
        }
        check_range("physics.approach", self.approach, 0.0..=100.0)?;
        check_range("physics.settle_time", self.settle_time, 0.0..=60.0)?;
        check_positive("physics.settle_speed", self.settle_speed)?;
        check_range("physics.landing_tolerance", self.landing_tolerance, 0.0..=0.05)?;
        check_range("physics.topple_tilt", self.topple_tilt, 1e-3..=4.0)?;
        check_range("physics.climb", self.climb, 1e-4..=10.0)?;
        check_range("physics.rest_distance", self.rest_distance, 0.0..=0.01)?;
        check_range("physics.rest_angle", self.rest_angle, 0.0..=0.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_valid_and_bad_constants_are_named() {
        for name in BulletSettings::PRESETS {
            BulletSettings::by_name(name).unwrap().validate().unwrap();
        }
        let fails = |s: BulletSettings| s.validate().unwrap_err().to_string();
        let good = BulletSettings::reference();
        assert!(fails(BulletSettings { margin: 0.0, ..good }).starts_with("physics.margin: is 0"));
        assert!(fails(BulletSettings { tip_top: 0.012, ..good }).starts_with("physics.tip_top: lies too near"));
        assert!(fails(BulletSettings { iterations: 0, ..good }).starts_with("physics.iterations: is 0"));
        assert!(BulletSettings::by_name("quick").unwrap_err().to_string().starts_with("physics.preset: bullet has no"));
    }
}
