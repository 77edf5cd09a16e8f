//! How finely the grasp test searches and how it scores.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, check_positive, check_range};
use crate::scene::{Grasper, Gripper};

/// Resolution of the search for a grasp. The rule itself is the gripper's ([`crate::scene::Grasper`]).
///
/// Lengths are those for the published gripper; for another the test takes [`GraspParams::fitted`].
///
/// The position across the opening is not sampled: the room between the obstacles is worked out exactly, which finds
/// every grasp that sampled positions find and the narrow ones between them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GraspParams {
    /// Closing directions over half a turn, from the normal of the longest straight side of the body's hull on.
    pub angles: usize,
    /// Positions along the pads, evenly spread within `offset_reach` of the body's centroid.
    pub offsets: usize,
    /// Metres.
    pub offset_reach: f64,
    /// Positions as far apart as these go on to the body's ends, where the pads still cover enough of it: what is hemmed in
    /// is often held by an end. None is farther from the centroid than this, metres.
    pub end_reach: f64,
    /// Openings to choose from, metres, whatever the gripper; empty: the gripper's full opening alone. The originals always open fully;
    /// 45 to 80 mm lets the fingers come down in narrower gaps.
    pub pre_openings: Vec<f64>,
    /// How closely a state that allows no grasp is measured for [`crate::grasp::GraspAssessment::nearness`]: the best
    /// so many positions along the pads for each direction,
    pub near_offsets: usize,
    /// and so many positions across the opening.
    pub near_across: usize,
    /// Violation at which nearness has fallen to 1/e, metres.
    pub nearness_scale: f64,
    pub score: GraspScore,
}

/// How the score falls from 1; every factor is 1 where all is well.
///
/// `score = face * wedge * turn * end * width * clearance`, a judgement fitted to what the full robot simulation of MORE was
/// seen to do (24 jittered grasps each: cube, cylinder, half-cylinder and rectangle across its 45 mm always held;
/// half-cube by its 22.5 mm side 14 of 24; triangle by its long side never, apex against hypotenuse always; a width
/// near the opening is forced):
/// * `face = min(1, f / full_face)`, `f` the length of the target along the pads within one pad width of their middle;
/// * `wedge = 1 - (1 - wedge_floor) (w / max_wedge)^2`, `w` the angle between the gripped faces;
/// * `turn = 1 - (1 - turn_floor) min(1, t / full_turn)^2`, `t` the least turn that lays a face flat on its pad;
/// * `end` falls from 1 to `end_floor` where a grip turned by `t` is farther from the centroid than `end_share - end_turn t` of
///   the way to the body's end: such bodies turn between the pads and slip (fitted to 3678 grasps tried out in Bullet);
/// * `width = width_floor + (1 - width_floor) min(1, s / full_width_spare)`, `s` the spare width on each side;
/// * `clearance = clearance_floor + (1 - clearance_floor) min(1, c / full_clearance)`, `c` the spare clearance of the
///   fingers and the jaw from the other bodies (graspable on one candidate alone: robust in 0.45 to 0.55 of trials).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GraspScore {
    /// Metres. 38.5 mm gives the half-cube its 14/24.
    pub full_face: f64,
    /// Factor at the greatest wedge that the gripper allows.
    pub wedge_floor: f64,
    /// Factor at a turn of `full_turn` or more.
    pub turn_floor: f64,
    /// Radians; 45 degrees by default, at which a square is gripped by opposite corners.
    pub full_turn: f64,
    /// Factor towards the end.
    pub end_floor: f64,
    /// Share of the way from the centroid to the end from which a flat grip would have it.
    pub end_share: f64,
    /// By how much less of the way for each radian of turn.
    pub end_turn: f64,
    /// Metres.
    pub full_width_spare: f64,
    pub width_floor: f64,
    /// Metres.
    pub full_clearance: f64,
    pub clearance_floor: f64,
}

impl Default for GraspParams {
    /// 16 directions, 7 positions within 18 mm, and to the ends of bodies of up to 100 mm.
    fn default() -> Self {
        Self {
            angles: 16,
            offsets: 7,
            offset_reach: 0.018,
            end_reach: 0.05,
            pre_openings: Vec::new(),
            near_offsets: 1,
            near_across: 5,
            nearness_scale: 0.03,
            score: GraspScore::default(),
        }
    }
}

impl Default for GraspScore {
    fn default() -> Self {
        Self {
            full_face: 0.0385,
            wedge_floor: 0.25,
            turn_floor: 0.1,
            full_turn: std::f64::consts::FRAC_PI_4,
            end_floor: 0.3,
            end_share: 1.1,
            end_turn: 0.93,
            full_width_spare: 0.005,
            width_floor: 0.5,
            full_clearance: 0.004,
            clearance_floor: 0.5,
        }
    }
}

impl GraspScore {
    /// The same judgement for a gripper of another size. A face is no fuller for pads that are narrower than the
    /// gripper is small: what they cover is all there is to hold.
    #[must_use]
    pub fn fitted(&self, gripper: &Gripper) -> GraspScore {
        let scale = gripper.scale();
        let pads = gripper.grasp.finger_width / Grasper::default().finger_width;
        GraspScore {
            full_face: scale.min(pads) * self.full_face,
            full_width_spare: scale * self.full_width_spare,
            full_clearance: scale * self.full_clearance,
            ..*self
        }
    }
}

impl GraspParams {
    /// The same test for a gripper of another size: every length grows with it ([`Gripper::scale`]). Nothing changes
    /// for the published gripper.
    #[must_use]
    pub fn fitted(&self, gripper: &Gripper) -> GraspParams {
        let scale = gripper.scale();
        GraspParams {
            offset_reach: scale * self.offset_reach,
            end_reach: scale * self.end_reach,
            nearness_scale: scale * self.nearness_scale,
            score: self.score.fitted(gripper),
            ..self.clone()
        }
    }

    /// Checks every field; errors name it.
    pub fn validate(&self) -> Result<()> {
        for (field, value) in [
            ("grasp.angles", self.angles),
            ("grasp.offsets", self.offsets),
            ("grasp.near_offsets", self.near_offsets),
            ("grasp.near_across", self.near_across),
        ] {
            if !(1..=1024).contains(&value) {
                return Err(Error::argument(field, format!("is {value}; it must lie in 1 to 1024")));
            }
        }
        check_range("grasp.offset_reach", self.offset_reach, 0.0..=1.0)?;
        check_range("grasp.end_reach", self.end_reach, 0.0..=1.0)?;
        for (i, opening) in self.pre_openings.iter().enumerate() {
            check_positive(&format!("grasp.pre_openings[{i}]"), *opening)?;
        }
        check_positive("grasp.nearness_scale", self.nearness_scale)?;
        let s = &self.score;
        check_positive("grasp.score.full_face", s.full_face)?;
        check_positive("grasp.score.full_width_spare", s.full_width_spare)?;
        check_positive("grasp.score.full_clearance", s.full_clearance)?;
        check_positive("grasp.score.full_turn", s.full_turn)?;
        check_range("grasp.score.wedge_floor", s.wedge_floor, 0.0..=1.0)?;
        check_range("grasp.score.turn_floor", s.turn_floor, 0.0..=1.0)?;
        check_range("grasp.score.end_floor", s.end_floor, 0.0..=1.0)?;
        check_range("grasp.score.end_share", s.end_share, 0.0..=10.0)?;
        check_range("grasp.score.end_turn", s.end_turn, 0.0..=10.0)?;
        check_range("grasp.score.width_floor", s.width_floor, 0.0..=1.0)?;
        check_range("grasp.score.clearance_floor", s.clearance_floor, 0.0..=1.0)
    }
}
