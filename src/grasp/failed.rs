//! Less belief in grasps like those that failed.

use crate::action::Grasp;
use crate::geom::{Pose2, Vec2, normalize_angle, vec2};
use crate::scene::State;

/// A grasp this far off along or across the body (metres, for the published gripper), or turned by this (radians), has a
/// third of the doubt.
const NEAR: (f64, f64) = (0.020, 0.5);
/// Share of its score that a grasp loses which has just failed, and any other of the same body.
const DOUBT: f64 = 0.75;
const DOUBT_ANYWHERE: f64 = 0.25;

/// A grasp that was tried and failed, where it was on its body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FailedGrasp {
    pub body: usize,
    /// In the body's frame, metres.
    position: Vec2,
    /// Of the closing direction in the body's frame, radians; half a turn is the same.
    angle: f64,
    /// 1 where it has just failed.
    doubt: f64,
}

impl FailedGrasp {
    /// The grasp failed where its body was in this state.
    pub fn new(grasp: &Grasp, state: &State) -> FailedGrasp {
        let pose = state.pose(grasp.body);
        let position = pose.inverse_transform_point(vec2(grasp.position[0], grasp.position[1]));
        FailedGrasp { body: grasp.body, position, angle: grasp.angle - pose.theta, doubt: 1.0 }
    }

    /// The same after the body was moved: what was in the way may be gone.
    #[must_use]
    pub fn halved(self) -> FailedGrasp {
        FailedGrasp { doubt: 0.5 * self.doubt, ..self }
    }

    /// The same on a body that was seen anew and has another number and frame: `was` and `is` are its poses. How it was
    /// turned since is not known: a camera gives every look its own frame.
    #[must_use]
    pub fn seen_anew(self, body: usize, was: &Pose2, is: &Pose2) -> FailedGrasp {
        let turned = was.theta - is.theta;
        let position = Pose2::new(0.0, 0.0, turned).transform_point(self.position);
        FailedGrasp { body, position, angle: self.angle + turned, ..self }
    }

    /// What is left of the score of a grasp of its body; `scale` is the gripper's ([`crate::scene::Gripper::scale`]).
    pub(super) fn belief(&self, position: Vec2, angle: f64, scale: f64) -> f64 {
        let off = (position - self.position).norm() / (scale * NEAR.0);
        // The closing direction and its reverse are the same grasp.
        let turn = 0.5 * normalize_angle(2.0 * (angle - self.angle)) / NEAR.1;
        let like = (-off * off - turn * turn).exp();
        (1.0 - self.doubt * DOUBT_ANYWHERE) * (1.0 - self.doubt * DOUBT * like)
    }
}

/// What is left of a body's score where these failed.
pub(super) fn belief(failed: &[FailedGrasp], body: usize, position: Vec2, angle: f64, scale: f64) -> f64 {
    failed.iter().filter(|f| f.body == body).map(|f| f.belief(position, angle, scale)).product()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grasp(x: f64, y: f64, angle: f64) -> Grasp {
        Grasp { body: 0, position: [x, y], angle, opening: 0.08, width: 0.04, margin: 0.01, score: 1.0 }
    }

    #[test]
    fn the_doubt_is_on_grasps_like_it_and_turns_with_the_body() {
        let failed = FailedGrasp::new(&grasp(0.51, 0.0, 0.5), &State::new([Pose2::new(0.5, 0.0, 0.5)]));
        let at = vec2(0.01, 0.0);
        let at = Pose2::new(0.0, 0.0, -0.5).transform_point(at);
        let belief = |p: Vec2, angle: f64| failed.belief(p, angle, 1.0);
        let (same, other) = (0.75 * 0.25, 0.75);
        assert!((belief(at, 0.0) - same).abs() < 1e-6);
        assert!((belief(at, std::f64::consts::PI) - same).abs() < 1e-6, "the reverse is the same");
        let across = belief(at, std::f64::consts::FRAC_PI_2);
        assert!(across > 0.99 * other && across < other && belief(at + vec2(0.06, 0.0), 0.0) > 0.99 * other);
        assert!(belief(at + vec2(0.006, 0.0), 0.1) < 0.3);
        assert!((failed.halved().belief(at, 0.0, 1.0) - 0.875 * 0.625).abs() < 1e-6);
        // The same body with another frame: the same place on it.
        let anew = failed.seen_anew(3, &Pose2::new(0.5, 0.0, 0.5), &Pose2::new(0.5, 0.0, -0.2));
        let there = Pose2::new(0.0, 0.0, 0.7).transform_point(at);
        assert!(anew.body == 3 && (anew.belief(there, 0.7, 1.0) - same).abs() < 1e-6);
    }
}
