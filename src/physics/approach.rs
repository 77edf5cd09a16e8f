//! What every engine does before the tip meets a body, and after the world has come to rest.

use super::transition::{PushJob, PushResult, PushStatus};
use crate::action::Push;
use crate::geom::Obb;
use crate::scene::{Mask, Scene, State};

/// A gap below this ends the free travel of the tip, metres.
const NEAR: f64 = 2e-4;
/// A push that is shorter goes nowhere, metres.
const LEAST_LENGTH: f64 = 1e-6;

/// What the model of an engine says of the first contact.
#[derive(Debug, Clone, Copy)]
pub struct Approach {
    /// The tip may overlap a body by this where it comes down; deeper is a landing on the body, metres.
    pub landing_tolerance: f64,
    /// Bodies are felt from this far, metres.
    pub border: f64,
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

    /// Ends a push whose result holds the state after: notes the bodies that left the workspace.
    pub fn end(scene: &Scene, job: &PushJob<'_>, result: &mut PushResult) {
        result.status = PushStatus::Executed;
        let workspace = scene.workspace();
        for (i, pose) in result.state.iter() {
            let footprint = &scene.body(i).footprint;
            if !workspace.holds(footprint, &pose) && workspace.holds(footprint, &job.state.pose(i)) {
                result.left.insert(i);
            }
        }
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
