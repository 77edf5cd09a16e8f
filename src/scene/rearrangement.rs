//! A rearrangement problem: every object from where it is to where it is wanted (REMP, dissertation chapter 7).

use std::f64::consts::TAU;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::body::Body;
use super::state::{State, check_pose};
use super::world::Scene;
use crate::bounds;
use crate::error::{Error, Result};
use crate::geom::{Pose2, Shape, normalize_angle, pieces_gap_below};

/// Two bodies that share no more than this depth touch and do not overlap, metres. States store single precision: on
/// a table of a metre a pose is known to 0.1 micrometres.
pub const CONTACT_SLACK: f64 = 1e-5;
/// What planners allow themselves of it, and less what goals may: so rounding never decides whether a plan is valid, or
/// whether there is one.
pub const PLACE_SLACK: f64 = 0.75 * CONTACT_SLACK;
const GOAL_SLACK: f64 = 0.5 * CONTACT_SLACK;

/// Where a body is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Goal {
    pub pose: Pose2,
    /// A body whose origin is at most this far from the goal's is there, metres.
    #[serde(default = "default_position_tolerance")]
    pub position_tolerance: f64,
    /// And whose heading differs by at most this, radians.
    #[serde(default = "default_rotation_tolerance")]
    pub rotation_tolerance: f64,
    /// Turns about the body's origin that look the same: 1 none, 2 half a turn, 4 a square's, 0 any. A disc about its
    /// origin counts as 0 whatever is given.
    #[serde(default = "default_symmetry")]
    pub symmetry: u32,
}

fn default_position_tolerance() -> f64 {
    0.005
}
fn default_rotation_tolerance() -> f64 {
    3f64.to_radians()
}
fn default_symmetry() -> u32 {
    1
}

impl Goal {
    /// A goal with the tolerances 5 mm and 3 degrees, without symmetry.
    pub fn at(pose: Pose2) -> Self {
        Goal {
            pose,
            position_tolerance: default_position_tolerance(),
            rotation_tolerance: default_rotation_tolerance(),
            symmetry: default_symmetry(),
        }
    }

    /// Of the poses that look like the goal, the one whose heading is nearest to that of `pose`.
    pub fn nearest(&self, pose: &Pose2) -> Pose2 {
        let theta = match self.symmetry {
            0 => pose.theta,
            1 => self.pose.theta,
            order => {
                let step = TAU / f64::from(order);
                let steps = (normalize_angle(pose.theta - self.pose.theta) / step).round();
                normalize_angle(self.pose.theta + steps * step)
            }
        };
        Pose2::new(self.pose.x, self.pose.y, theta)
    }

    /// A body at `pose` has reached the goal, within the tolerances.
    pub fn reached(&self, pose: &Pose2) -> bool {
        let nearest = self.nearest(pose);
        (pose.position() - nearest.position()).norm() <= self.position_tolerance
            && normalize_angle(pose.theta - nearest.theta).abs() <= self.rotation_tolerance
    }

    /// Refuses numbers that cannot be used, by the field's name.
    pub fn validate(&self) -> Result<()> {
        check_pose("pose", &self.pose)?;
        bounds::POSITION_TOLERANCE.check("position_tolerance", self.position_tolerance)?;
        bounds::ROTATION_TOLERANCE.check("rotation_tolerance", self.rotation_tolerance)?;
        bounds::SYMMETRY.check("symmetry", f64::from(self.symmetry))
    }
}

/// Bring the bodies to their goals, one at a time, by pick-and-place or by a drag along the table.
///
/// A body's flags say what may be done: one that is [`pickable`](Body::pickable) is picked and placed, one that is only
/// [`pushable`](Body::pushable) is dragged, one that is neither is an obstacle that stays. A body without a goal may be
/// moved out of the way and may end anywhere. All footprints stay wholly inside the workspace, whatever its leave rule.
#[derive(Debug, Clone, PartialEq)]
pub struct Rearrangement {
    /// Where it came from: a file's stem, a generator's seed.
    pub name: String,
    pub scene: Arc<Scene>,
    pub start: State,
    /// One for each body.
    pub goals: Vec<Option<Goal>>,
}

impl Rearrangement {
    /// Checks the problem; see [`validate`](Self::validate). Discs get the symmetry 0.
    pub fn new(
        name: impl Into<String>,
        scene: Arc<Scene>,
        start: State,
        mut goals: Vec<Option<Goal>>,
    ) -> Result<Rearrangement> {
        for (goal, body) in goals.iter_mut().zip(scene.bodies()) {
            if let (Some(goal), Shape::Disc { .. }) = (goal, &body.footprint.shape) {
                goal.symmetry = 0;
            }
        }
        let problem = Rearrangement { name: name.into(), scene, start, goals };
        problem.validate()?;
        Ok(problem)
    }

    /// Refuses a problem that cannot be solved by any plan: poses or goals missing, outside of the workspace or
    /// overlapping, and bodies that should move and must not. The error names the pose or the goal.
    pub fn validate(&self) -> Result<()> {
        let scene = &self.scene;
        scene.check_state(&self.start)?;
        if self.goals.len() != scene.len() {
            let reason =
                format!("has {} goals for {} bodies; give one for each, or none", self.goals.len(), scene.len());
            return Err(Error::argument("goals", reason));
        }
        if let Some(missing) = (0..scene.len()).find(|&body| !self.start.is_present(body)) {
            let reason = "is not present; a rearrangement needs every body on the table";
            return Err(Error::argument(format!("poses[{missing}]"), reason));
        }
        for body in 0..scene.len() {
            self.check_pose(&format!("poses[{body}]"), body, &self.start.pose(body))?;
            let Some(goal) = &self.goals[body] else { continue };
            let field = format!("goals[{body}]");
            goal.validate().map_err(|error| error.within(&field))?;
            self.check_pose(&field, body, &goal.pose)?;
            if !scene.body(body).movable() && !goal.reached(&self.start.pose(body)) {
                let reason = format!(
                    "`{}` is neither pickable nor pushable and not at its goal; set a flag",
                    scene.body(body).name
                );
                return Err(Error::argument(field, reason));
            }
        }
        let start = |body: usize| Some(self.start.pose(body));
        self.check_overlap("poses", CONTACT_SLACK, start)?;
        // Where a body must be in the end: its goal, or where it is if it cannot move.
        let end = |body: usize| match &self.goals[body] {
            Some(goal) => Some(goal.pose),
            None => (!scene.body(body).movable()).then(|| self.start.pose(body)),
        };
        self.check_overlap("goals", GOAL_SLACK, end)
    }

    fn check_pose(&self, field: &str, body: usize, pose: &Pose2) -> Result<()> {
        let margin = self.scene.workspace().margin(&self.scene.body(body).footprint, pose);
        if margin < -CONTACT_SLACK {
            let name = &self.scene.body(body).name;
            let reason = format!("`{name}` reaches {:.1} mm out of the workspace; move it inside", -margin * 1e3);
            return Err(Error::argument(field, reason));
        }
        Ok(())
    }

    fn check_overlap(&self, field: &str, slack: f64, pose: impl Fn(usize) -> Option<Pose2>) -> Result<()> {
        let bodies = self.scene.bodies();
        for i in 0..bodies.len() {
            for j in 0..i {
                let (Some(pi), Some(pj)) = (pose(i), pose(j)) else { continue };
                let gap = pieces_gap_below(&bodies[i].footprint, &pi, &bodies[j].footprint, &pj, 0.0);
                if gap < -slack {
                    let (a, b) = (&bodies[i].name, &bodies[j].name);
                    let reason = format!("`{a}` overlaps `{b}` by {:.2} mm; move them apart", -gap * 1e3);
                    return Err(Error::argument(format!("{field}[{i}]"), reason));
                }
            }
        }
        Ok(())
    }

    /// The body may stay where it is: it has no goal, or has reached it.
    pub fn at_goal(&self, body: usize, pose: &Pose2) -> bool {
        self.goals[body].as_ref().is_none_or(|goal| goal.reached(pose))
    }

    /// Every body is at its goal.
    pub fn solved(&self, state: &State) -> bool {
        state.iter().all(|(body, pose)| self.at_goal(body, &pose))
    }

    /// The same problem from another state.
    pub fn from_state(&self, state: State) -> Rearrangement {
        Rearrangement { start: state, ..self.clone() }
    }
}

impl Body {
    /// A plan may move it: by pick-and-place if it is pickable, else by a drag.
    pub fn movable(&self) -> bool {
        self.pickable || self.pushable
    }
}

#[cfg(test)]
#[path = "rearrangement_tests.rs"]
mod tests;
