//! How far the world may be from what is known of it: friction that is off by a factor, poses seen with noise.
//!
//! The judge of `eval` draws its true worlds from here, and a planner the worlds that it prepares for. Everything is a
//! function of a key, so worlds are the same for everything that is compared in them (common random numbers).

use serde::{Deserialize, Serialize};

use super::state::State;
use super::world::Scene;
use crate::error::{Result, check_range};
use crate::geom::Pose2;
use crate::run::Key;

/// What is not known exactly. Metres and radians.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Uncertainty {
    /// The friction of the tip and of every body is off by a factor between 1 - this and 1 + this, uniformly.
    pub friction_spread: f64,
    /// Standard deviation of each observed coordinate.
    pub position: f64,
    /// Standard deviation of each observed heading.
    pub rotation: f64,
    /// Standard deviation of how far beyond a border a body may be predicted and yet not leave, or within and leave.
    pub border: f64,
}

impl Default for Uncertainty {
    /// 20 %, 1 mm, 1 degree; 3 mm at the border, as engines are off by about that from each other and from a robot
    /// (docs/robot.md).
    fn default() -> Self {
        Self { friction_spread: 0.2, position: 0.001, rotation: 1f64.to_radians(), border: 0.003 }
    }
}

/// Poses that no perception would report (bodies deep in each other) are drawn again this often at full noise; then the
/// noise shrinks by a tenth with every further draw.
const FULL_NOISE_DRAWS: u64 = 32;
/// Draws after that, at the end of which the noise is a hundredth.
const SHRINKING_DRAWS: u64 = 40;

impl Uncertainty {
    /// Everything is as it is known.
    pub const NONE: Uncertainty = Uncertainty { friction_spread: 0.0, position: 0.0, rotation: 0.0, border: 0.0 };

    pub fn validate(&self) -> Result<()> {
        check_range("uncertainty.friction_spread", self.friction_spread, 0.0..=0.9)?;
        check_range("uncertainty.position", self.position, 0.0..=1.0)?;
        check_range("uncertainty.rotation", self.rotation, 0.0..=0.5)?;
        check_range("uncertainty.border", self.border, 0.0..=1.0)
    }

    /// The scene with every friction scaled by a factor of its own, and its border where that may be.
    pub fn scene(&self, scene: &Scene, key: Key) -> Scene {
        let mut draw = key.stream();
        let mut factor = || draw.uniform(1.0 - self.friction_spread, 1.0 + self.friction_spread);
        let tip = factor();
        let bodies: Vec<f64> = (0..scene.len()).map(|_| factor()).collect();
        let inset = self.border * draw.normal();
        scene.with_scaled_friction(tip, &bodies).with_shrunk_workspace(inset)
    }

    /// The state with noise on every pose: what a camera reports of it, or where the bodies may be that it reports so.
    pub fn state(&self, scene: &Scene, state: &State, key: Key) -> State {
        for draw in 0..FULL_NOISE_DRAWS + SHRINKING_DRAWS {
            let scale = 0.9f64.powi(draw.saturating_sub(FULL_NOISE_DRAWS) as i32);
            let seen = self.noisy(state, key.child(draw), scale);
            if scene.check_state(&seen).is_ok() {
                return seen;
            }
        }
        state.clone()
    }

    fn noisy(&self, state: &State, key: Key, scale: f64) -> State {
        let (position, rotation) = (self.position * scale, self.rotation * scale);
        let mut seen = state.clone();
        for (i, pose) in state.iter() {
            let mut draw = key.child(i as u64).stream();
            let (x, y) = (pose.x + position * draw.normal(), pose.y + position * draw.normal());
            seen.set_pose(i, Pose2::new(x, y, pose.theta + rotation * draw.normal()));
        }
        seen
    }
}
