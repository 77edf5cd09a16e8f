//! A grasp tried out in space: how the fingers move, and what came of it. Present in every build.

use serde::{Deserialize, Serialize};

use crate::error::{Result, check_positive, check_range};
use crate::scene::{Mask, State};

/// How the fingers move and how hard they press. SI units; heights are above the table.
///
/// The two fingers are boxes of the gripper's measures that come straight down, close evenly (as geared fingers do) with
/// a limited force, and rise. Their friction is that of the push tip.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GraspMotion {
    /// Height of the fingers' lower end when they close.
    pub pad_bottom: f64,
    /// Height of the fingers' boxes.
    pub pad_height: f64,
    /// The descent begins this far above the highest body.
    pub start_above: f64,
    /// m/s.
    pub descend_speed: f64,
    /// Speed of each finger, m/s.
    pub close_speed: f64,
    /// Force of each finger, newton. The default holds 0.9 kg where pad and body have a friction of 0.45. A greater one
    /// makes the fingers heavy against the bodies, and Bullet's sweeps converge less: with 40 N bodies of 25 g are squeezed
    /// out of grips that hold with 5 and 10 N.
    pub grip_force: f64,
    /// How far the fingers rise.
    pub lift: f64,
    /// m/s.
    pub lift_speed: f64,
    /// How long what is held must stay, seconds.
    pub hold_time: f64,
    /// A descent that meets a body with a greater force than this ends there, newton.
    pub descent_force: f64,
}

impl Default for GraspMotion {
    fn default() -> Self {
        Self {
            pad_bottom: 0.01,
            pad_height: 0.05,
            start_above: 0.005,
            descend_speed: 0.25,
            close_speed: 0.1,
            grip_force: 10.0,
            lift: 0.1,
            lift_speed: 0.25,
            hold_time: 0.05,
            descent_force: 20.0,
        }
    }
}

impl GraspMotion {
    /// Checks every field; errors name it.
    pub fn validate(&self) -> Result<()> {
        check_range("grasp_motion.pad_bottom", self.pad_bottom, 0.0..=1.0)?;
        check_range("grasp_motion.pad_height", self.pad_height, 1e-3..=1.0)?;
        check_range("grasp_motion.start_above", self.start_above, 1e-3..=1.0)?;
        check_range("grasp_motion.descend_speed", self.descend_speed, 1e-3..=10.0)?;
        check_range("grasp_motion.close_speed", self.close_speed, 1e-3..=10.0)?;
        check_range("grasp_motion.grip_force", self.grip_force, 1e-3..=10_000.0)?;
        check_range("grasp_motion.lift", self.lift, 0.01..=1.0)?;
        check_range("grasp_motion.lift_speed", self.lift_speed, 1e-3..=10.0)?;
        check_range("grasp_motion.hold_time", self.hold_time, 0.0..=10.0)?;
        check_positive("grasp_motion.descent_force", self.descent_force)
    }
}

/// What came of a grasp.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GraspTrial {
    /// The target, and nothing else, was lifted and is held between the pads.
    pub success: bool,
    /// The body that is held between both pads, if any.
    pub held: Option<usize>,
    /// Every body that rose with the fingers, held or not.
    pub lifted: Mask,
    /// The body that stopped the descent, if one did.
    pub blocked_by: Option<usize>,
    /// Bodies that the fingers touched on their way down.
    pub touched_on_descent: Mask,
    /// Distance between the pads at the end, metres.
    pub gap: f64,
    /// The stop was requested before the end; nothing else is to be used.
    pub interrupted: bool,
    /// Where the bodies came to rest. One that is held keeps its pose; one that slipped lies where it fell.
    pub after: State,
    /// Bodies that lean, lie or stand on others afterwards.
    pub toppled: Mask,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_motions_are_refused_by_name() {
        GraspMotion::default().validate().unwrap();
        let error = GraspMotion { lift: 0.0, ..GraspMotion::default() }.validate().unwrap_err().to_string();
        assert!(error.starts_with("grasp_motion.lift: is 0"), "{error}");
    }
}
