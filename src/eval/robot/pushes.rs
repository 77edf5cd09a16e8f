//! Where an engine says that recorded pushes bring the bodies.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::super::fidelity::Sums;
use super::record::{RobotPush, pose};
use crate::error::{Error, Result};
use crate::physics::{PushStatus, Transition};
use crate::run::Stop;
use crate::scene::{Gripper, Scene};

/// How well an engine agrees with recorded pushes of a robot, over bodies that moved by either (as
/// [`super::super::Fidelity`] has it).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PushAccuracy {
    /// The engine's name for itself.
    pub engine: String,
    /// Pushes compared.
    pub count: usize,
    /// Pushes left out: the robot broke them off, or bodies lie on each other.
    pub left_out: usize,
    /// Pushes that the engine refused; counted as if nothing had moved.
    pub refused: usize,
    /// Bodies that moved.
    pub moved: usize,
    pub median_position_mm: f64,
    pub p90_position_mm: f64,
    pub median_rotation_deg: f64,
    pub p90_rotation_deg: f64,
}

/// Runs every push through the engine that `engine` makes for its scene. The tip goes straight where the command says.
pub fn push_accuracy(
    pushes: &[RobotPush],
    gripper: &Gripper,
    engine: &dyn Fn(Arc<Scene>) -> Result<Arc<dyn Transition>>,
) -> Result<PushAccuracy> {
    let mut sums = Sums::default();
    let mut found = PushAccuracy::default();
    for push in pushes {
        let scene = Arc::new(push.scene(gripper)?);
        let state = push.state();
        if push.aborted || scene.check_state(&state).is_err() {
            found.left_out += 1;
            continue;
        }
        let transition = engine(Arc::clone(&scene))?;
        let mut scratch = transition.scratch();
        let result = transition.step(&mut scratch, &state, &push.push(), &Stop::never());
        found.count += 1;
        found.refused += usize::from(result.status != PushStatus::Executed);
        for (i, after) in push.after.iter().enumerate() {
            sums.add(&scene.body(i).footprint, &state.pose(i), &pose(after), &result.state.pose(i));
        }
        found.engine = transition.name().to_string();
    }
    if found.count == 0 {
        return Err(Error::argument("pushes", "none of them can be compared with"));
    }
    let (moved, _) = sums.finish();
    found.moved = moved.count;
    (found.median_position_mm, found.p90_position_mm) = (moved.median_position_mm, moved.p90_position_mm);
    (found.median_rotation_deg, found.p90_rotation_deg) = (moved.median_rotation_deg, moved.p90_rotation_deg);
    Ok(found)
}
