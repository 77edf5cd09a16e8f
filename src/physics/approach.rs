//! What every engine does before the tip meets a body, and after the world has come to rest.

use super::transition::{DEEPEST, PushJob, PushResult, PushStatus};
use crate::action::Push;
use crate::geom::{Obb, Pose2, pieces_gap_below};
use crate::scene::{Mask, Scene, State};

/// A gap below this ends the free travel of the tip, metres.
const NEAR: f64 = 2e-4;
/// A body that goes farther than this many times the push and so many metres was thrown.
const THROWN: (f64, f64) = (3.0, 0.05);
/// A push that is shorter goes nowhere, metres.
const LEAST_LENGTH: f64 = 1e-6;

/// What the model of an engine says of the first contact.
#[derive(Debug, Clone, Copy)]
pub struct Approach {
    /// The tip may overlap a body by this where it comes down; deeper is a landing on the body, metres.
    pub landing_tolerance: f64,
    /// Bodies are felt from this far, metres.
    pub border: f64,
    /// The tip passes over bodies that are lower than this, metres, where the robot has no path of its own for it.
    pub tip_low: f64,
    /// Bodies are not to end in others by their outlines.
    pub flat: bool,
}

impl Approach {
    /// Begins a push: the result holds the state before. Gives how far the tip travels before it comes within the
    /// border of a body, or nothing if the result is complete (the push is illegal or meets nothing).
    pub fn begin(&self, scene: &Scene, job: &PushJob<'_>, result: &mut PushResult) -> Option<f64> {
        result.state.clone_from(job.state);
        (result.touched, result.left, result.toppled) = (Mask::EMPTY, Mask::EMPTY, Mask::EMPTY);
        let push = &job.push;
        if !push.is_finite() || push.length() < LEAST_LENGTH {
            result.status = PushStatus::Illegal { body: None };
            return None;
        }
        if let Some(body) = self.landed_on(scene, job.state, push) {
            result.status = PushStatus::Illegal { body: Some(body) };
            return None;
        }
        let travel = self.free_travel(scene, job.state, push);
        if travel.is_none() {
            // The tip meets nothing: the world stays as it is, to the bit.
            result.status = PushStatus::Executed;
        }
        travel
    }

    /// Ends a push whose result holds the state after: notes the bodies that left the workspace, or takes the push back
    /// if the tip or a body ended in a body, or a body was thrown away. (Where a body toppled the push ended before, and outlines say little.)
    pub fn end(&self, scene: &Scene, job: &PushJob<'_>, result: &mut PushResult) {
        if !self.is_solved(scene, job, result) {
            return result.take_back(job.state);
        }
        Self::settle(scene, job, result);
    }

    /// Ends a push that is known to be solved: notes the bodies that left the workspace.
    pub fn settle(scene: &Scene, job: &PushJob<'_>, result: &mut PushResult) {
        result.status = PushStatus::Executed;
        let workspace = scene.workspace();
        for (i, pose) in result.state.iter() {
            let footprint = &scene.body(i).footprint;
            if !workspace.holds(footprint, &pose) && workspace.holds(footprint, &job.state.pose(i)) {
                result.left.insert(i);
            }
        }
    }

    fn is_solved(&self, scene: &Scene, job: &PushJob<'_>, result: &PushResult) -> bool {
        if !result.state.iter().all(|(_, pose)| pose.is_finite()) {
            return false;
        }
        let wrong = || {
            job.state.iter().any(|(i, pose)| is_thrown(&job.push, &pose, &result.state.pose(i)))
                || self.tip_ends_in_a_body(scene, job, &result.state)
                || self.flat && bodies_end_in_others(scene, job, result)
        };
        !result.toppled.is_empty() || !wrong()
    }

    fn tip_ends_in_a_body(&self, scene: &Scene, job: &PushJob<'_>, after: &State) -> bool {
        let start = job.push.tip_at_start(&scene.gripper().push);
        let length = job.push.length();
        let tip = Obb { centre: start.centre + job.push.direction() * length, ..start };
        let path = scene.gripper().path.as_ref();
        let low = path.map_or(self.tip_low, |path| path.height(&path.stroke(job.push.start(), job.push.end()), length));
        after.iter().any(|(i, pose)| {
            let body = scene.body(i);
            body.height > low && tip.gap_below(&body.footprint, &pose, 0.0) < -DEEPEST
        })
    }

    /// The body that the tip would come down on: the one it overlaps most.
    fn landed_on(&self, scene: &Scene, state: &State, push: &Push) -> Option<usize> {
        let tip = push.tip_at_start(&scene.gripper().push);
        state
            .iter()
            .map(|(i, pose)| (i, tip.gap_below(&scene.body(i).footprint, &pose, 0.0)))
            .filter(|(_, gap)| *gap < -self.landing_tolerance)
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(i, _)| i)
    }

    /// How far the tip travels before it comes within the border of a body; `None` if it never does.
    /// Conservative advancement: the tip may always move by its gap to the nearest body.
    fn free_travel(&self, scene: &Scene, state: &State, push: &Push) -> Option<f64> {
        let (length, direction) = (push.length(), push.direction());
        let start = push.tip_at_start(&scene.gripper().push);
        let mut travel = 0.0;
        for _ in 0..64 {
            let tip = Obb { centre: start.centre + direction * travel, ..start };
            // Far enough to reach the end is all that has to be known of a gap.
            let gap = state.iter().fold(length - travel + self.border, |least, (i, pose)| {
                least.min(tip.gap_below(&scene.body(i).footprint, &pose, least))
            });
            let free = gap - self.border;
            if free < NEAR {
                return Some(travel);
            }
            travel += free;
            if travel >= length {
                return None;
            }
        }
        Some(travel)
    }
}

/// Whether a body went farther than the push carries anything: solvers that diverge throw bodies away. A lever, such as a
/// long body pushed beside its middle, makes more of the tip's way than one.
pub fn is_thrown(push: &Push, before: &Pose2, after: &Pose2) -> bool {
    (after.position() - before.position()).norm() > THROWN.0 * push.length() + THROWN.1
}

/// Whether a body that moved is in another, and deeper than before the push.
fn bodies_end_in_others(scene: &Scene, job: &PushJob<'_>, result: &PushResult) -> bool {
    let after = &result.state;
    let moved = |i: usize| after.poses()[i] != job.state.poses()[i];
    let overlap = |state: &State, i: usize, j: usize| {
        let (a, b) = (&scene.body(i).footprint, &scene.body(j).footprint);
        -pieces_gap_below(a, &state.pose(i), b, &state.pose(j), 0.0)
    };
    after.iter().filter(|(i, _)| moved(*i)).any(|(i, _)| {
        let mut others = after.iter().filter(|(j, _)| *j < i || *j > i && !moved(*j));
        others.any(|(j, _)| {
            let deep = overlap(after, i, j);
            deep > DEEPEST && deep > overlap(job.state, i, j)
        })
    })
}
