//! How well the geometric grasp test foretells what happens when a grasp is tried out in Bullet.
//!
//! One scene at a time ([`grasp_samples`]), so that the caller may run scenes side by side; [`Confusion`] counts the
//! samples for any threshold.

use serde::{Deserialize, Serialize};

use crate::action::Grasp;
use crate::error::Result;
use crate::geom::{normalize_angle, vec2};
use crate::grasp::{GraspScratch, GraspTest};
use crate::physics::Bullet;
use crate::physics::bullet::GraspMotion;
use crate::run::{Key, Stop};
use crate::scene::{Mask, Problem};

/// Random grasps lie within this distance of the body's middle along the pads, metres ...
const ALONG: f64 = 0.018;
/// ... and across the opening.
const ACROSS: f64 = 0.012;

/// One grasp, as the test and the trial see it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GraspSample {
    pub grasp: Grasp,
    /// The test's best grasp of its body; else one drawn at random.
    pub best: bool,
    /// The test's verdict.
    pub holds: bool,
    /// The test's score in [0, 1]; 0 where it does not hold.
    pub score: f64,
    /// Spare room by the test, metres.
    pub margin: f64,
    /// Angle between the gripped faces by the test, radians.
    pub wedge: f64,
    /// Width between the pads by the test, metres.
    pub width: f64,
    /// The trial lifted this body and no other.
    pub success: bool,
    /// A finger came down on a body.
    pub blocked: bool,
}

/// Tries out the test's best grasp of these bodies of a scene, and `random` more of each that are drawn around it.
/// Ends early where the stop was requested.
#[allow(clippy::too_many_arguments)]
pub fn grasp_samples(
    problem: &Problem,
    engine: &Bullet,
    test: &GraspTest,
    motion: &GraspMotion,
    bodies: Mask,
    random: usize,
    key: Key,
    stop: &Stop,
) -> Result<Vec<GraspSample>> {
    let (scene, state) = (&*problem.scene, &problem.state);
    let mut scratch = GraspScratch::default();
    let mut samples = Vec::new();
    for (body, pose) in state.iter().filter(|(i, _)| bodies.contains(*i)) {
        let mut draws = key.child(body as u64).stream();
        let best = test.best(scene, state, body, &mut scratch);
        let middle = pose.transform_point(scene.body(body).footprint.centroid);
        let drawn = (0..random).map(|_| {
            let angle = draws.uniform(0.0, std::f64::consts::PI);
            let (axis, along) = (vec2(angle.cos(), angle.sin()), vec2(-angle.sin(), angle.cos()));
            let at = middle + axis * draws.uniform(-ACROSS, ACROSS) + along * draws.uniform(-ALONG, ALONG);
            let opening = scene.gripper().grasp.opening;
            Grasp { body, position: [at.x, at.y], angle: normalize_angle(angle), opening, ..Grasp::default() }
        });
        for (grasp, is_best) in best.into_iter().map(|g| (g, true)).chain(drawn.map(|g| (g, false))) {
            let check = test.check(scene, state, &grasp, &mut scratch);
            let trial = engine.grasp(state, &grasp, motion, stop)?;
            if trial.interrupted {
                return Ok(samples);
            }
            let holds = check.holds();
            samples.push(GraspSample {
                grasp,
                best: is_best,
                holds,
                score: if holds { check.score } else { 0.0 },
                margin: check.margin,
                wedge: check.wedge,
                width: check.width,
                success: trial.success,
                blocked: trial.blocked_by.is_some(),
            });
        }
    }
    Ok(samples)
}

/// How a verdict and the trials agree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Confusion {
    /// Held by verdict and in trial.
    pub both: usize,
    /// Held by verdict only.
    pub verdict_only: usize,
    /// Held in trial only.
    pub trial_only: usize,
    pub neither: usize,
}

impl Confusion {
    /// Counts samples by the test's verdict with at least this score.
    pub fn of<'a>(samples: impl IntoIterator<Item = &'a GraspSample>, least_score: f64) -> Self {
        Self::by(samples, |s| s.holds && s.score >= least_score)
    }

    /// Counts samples by any verdict.
    pub fn by<'a>(samples: impl IntoIterator<Item = &'a GraspSample>, verdict: impl Fn(&GraspSample) -> bool) -> Self {
        let mut counts = Self::default();
        for sample in samples {
            match (verdict(sample), sample.success) {
                (true, true) => counts.both += 1,
                (true, false) => counts.verdict_only += 1,
                (false, true) => counts.trial_only += 1,
                (false, false) => counts.neither += 1,
            }
        }
        counts
    }

    /// Share of the grasps that hold by verdict which hold in trial; 1 if there are none.
    pub fn precision(&self) -> f64 {
        share(self.both, self.verdict_only)
    }

    /// Share of the grasps that hold in trial which hold by verdict; 1 if there are none.
    pub fn recall(&self) -> f64 {
        share(self.both, self.trial_only)
    }

    /// Share of all grasps on which verdict and trial agree; 1 if there are none.
    pub fn agreement(&self) -> f64 {
        share(self.both + self.neither, self.verdict_only + self.trial_only)
    }
}

fn share(part: usize, rest: usize) -> f64 {
    if part + rest == 0 { 1.0 } else { part as f64 / (part + rest) as f64 }
}
