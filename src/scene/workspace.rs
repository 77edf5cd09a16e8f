//! The rectangle that bodies must not leave.

use serde::{Deserialize, Serialize};

use crate::bounds;
use crate::error::{Error, Result};
use crate::geom::{Footprint, Pose2, Vec2, vec2};

/// When a body counts as having left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LeaveRule {
    /// Its frame's origin is outside (the originals' rule).
    #[default]
    Centre,
    /// Any part of its footprint is outside.
    Footprint,
}

/// Which bodies the rule holds for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LeaveScope {
    #[default]
    AllBodies,
    /// The target alone.
    TargetOnly,
}

/// An axis-aligned rectangle in the world frame, metres, and the rule for leaving it.
/// The table goes on beyond it: a body that leaves keeps sliding, and is reported.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Workspace {
    pub min: [f64; 2],
    pub max: [f64; 2],
    #[serde(default)]
    pub leave_rule: LeaveRule,
    #[serde(default)]
    pub leave_scope: LeaveScope,
}

impl Default for Workspace {
    /// The originals' square of 0.448 m in front of the robot, centred at (0.5, 0).
    fn default() -> Self {
        Self::rectangle(vec2(0.276, -0.224), vec2(0.724, 0.224))
    }
}

impl Workspace {
    pub fn rectangle(min: Vec2, max: Vec2) -> Self {
        Self {
            min: [min.x, min.y],
            max: [max.x, max.y],
            leave_rule: LeaveRule::default(),
            leave_scope: LeaveScope::default(),
        }
    }

    /// The same workspace that ends so far within its border, but no farther than its middle; beyond it where negative.
    #[must_use]
    pub fn shrunk(&self, by: f64) -> Self {
        let by = by.min((self.max[0] - self.min[0]) / 2.0).min((self.max[1] - self.min[1]) / 2.0);
        Self { min: self.min.map(|v| v + by), max: self.max.map(|v| v - by), ..*self }
    }

    /// The same workspace with every length times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Workspace {
        Workspace { min: self.min.map(|v| factor * v), max: self.max.map(|v| factor * v), ..*self }
    }

    pub fn validate(&self) -> Result<()> {
        for (axis, name) in ["x", "y"].into_iter().enumerate() {
            let (lo, hi) = (self.min[axis], self.max[axis]);
            bounds::POSITION.check(&format!("workspace.min.{name}"), lo)?;
            bounds::POSITION.check(&format!("workspace.max.{name}"), hi)?;
            if hi <= lo {
                return Err(Error::argument(
                    format!("workspace.{name}"),
                    format!("max {hi} must be greater than min {lo}"),
                ));
            }
            bounds::SIDE.check(&format!("workspace.{name}"), hi - lo)?;
        }
        Ok(())
    }

    /// Distance of a point to the nearest edge, metres; negative outside.
    pub fn inset(&self, p: Vec2) -> f64 {
        (p.x - self.min[0]).min(self.max[0] - p.x).min(p.y - self.min[1]).min(self.max[1] - p.y)
    }

    /// The body has not left, by the workspace's rule.
    pub fn holds(&self, footprint: &Footprint, pose: &Pose2) -> bool {
        self.room(footprint, pose) >= 0.0
    }

    /// How far the body is from leaving, by the workspace's rule, metres; negative by as much as it has left.
    pub fn room(&self, footprint: &Footprint, pose: &Pose2) -> f64 {
        match self.leave_rule {
            LeaveRule::Centre => self.inset(pose.position()),
            LeaveRule::Footprint => self.margin(footprint, pose),
        }
    }

    /// Distance of the footprint to the nearest edge, metres; negative by as much as it reaches out.
    pub fn margin(&self, footprint: &Footprint, pose: &Pose2) -> f64 {
        let frame = pose.frame();
        let extent = |d: Vec2| footprint.support(frame.inverse_vector(d)) + pose.position().dot(&d);
        let right = self.max[0] - extent(vec2(1.0, 0.0));
        let top = self.max[1] - extent(vec2(0.0, 1.0));
        let left = -extent(vec2(-1.0, 0.0)) - self.min[0];
        let bottom = -extent(vec2(0.0, -1.0)) - self.min[1];
        right.min(top).min(left).min(bottom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shrunk_workspace_ends_within_and_never_beyond_its_middle() {
        let whole = Workspace::rectangle(vec2(-0.1, 0.0), vec2(0.1, 0.3));
        assert_eq!(whole.shrunk(0.0), whole);
        let (less, more) = (whole.shrunk(0.02), whole.shrunk(-0.02));
        for (p, within, beyond) in
            [(vec2(0.09, 0.1), false, true), (vec2(0.11, 0.1), false, true), (vec2(0.0, 0.1), true, true)]
        {
            assert_eq!((less.inset(p) > 0.0, more.inset(p) > 0.0), (within, beyond), "{p:?}");
        }
        let none = whole.shrunk(7.0);
        assert!((none.min[0] - none.max[0]).abs() < 1e-12 && none.max[1] - none.min[1] > 0.09);
    }
}
