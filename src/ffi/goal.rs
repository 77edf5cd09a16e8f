//! Goals of a scene's bodies: what makes it a rearrangement.

use super::abi::{Sized32, init_sized, jostle_body, jostle_pose2, out, pose, read_sized, write_sized};
use super::guard::guard;
use super::scene::{jostle_scene, with, with_mut};
use super::status::{Failure, JOSTLE_ERROR_NOT_FOUND, jostle_status};
use crate::geom::Pose2;
use crate::scene::Goal;

/// Where a body is wanted.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct jostle_goal {
    /// Set by jostle_goal_default().
    pub struct_size: u32,
    /// Turns about the body's origin that look the same: 1 (the default) none, 2 half a turn, 4 a square's, 0 any. A
    /// disc about its origin counts as 0 whatever is given.
    pub symmetry: u32,
    /// Of the body's frame in the world.
    pub pose: jostle_pose2,
    /// A body whose origin is at most this far from the goal's is there, metres: 5 mm by default.
    pub position_tolerance: f64,
    /// And whose heading differs by at most this, radians: 3 degrees by default.
    pub rotation_tolerance: f64,
}

impl From<&Goal> for jostle_goal {
    fn from(goal: &Goal) -> Self {
        jostle_goal {
            struct_size: size_of::<Self>() as u32,
            symmetry: goal.symmetry,
            pose: goal.pose.into(),
            position_tolerance: goal.position_tolerance,
            rotation_tolerance: goal.rotation_tolerance,
        }
    }
}

// SAFETY: repr(C), struct_size first, numbers without padding.
unsafe impl Sized32 for jostle_goal {
    const NAME: &'static str = "jostle_goal";
    const FIRST_SIZE: usize = 48;
    fn defaults() -> Self {
        (&Goal::at(Pose2::IDENTITY)).into()
    }
}

/// Sets every field to its default; `size` is sizeof(jostle_goal) as the caller was compiled. jostle_goal_default() in
/// this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_goal_init(goal: *mut jostle_goal, size: usize) -> jostle_status {
    // SAFETY: the caller promises `size` writable bytes.
    guard("jostle_goal_init", |_| unsafe { init_sized(goal, "goal", size) })
}

/// Says where a body is wanted; planners of rearrangements bring it there. Whether the goals fit each other is checked
/// when a planner is given the scene. A body without a goal may end anywhere.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: goal (takes the body's goal away).
/// Owns: `goal` is copied.
/// Errors: ARGUMENT (null, zero body, a field of goal: the message names it), HANDLE, BUSY, NOT_FOUND, POISONED, ABI.
/// On failure the scene is unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_set_goal(
    scene: *mut jostle_scene,
    body: jostle_body,
    goal: *const jostle_goal,
) -> jostle_status {
    with_mut("jostle_scene_set_goal", scene, |content| {
        let index = content.index(body, "body")?;
        if goal.is_null() {
            content.goals[index] = None;
            return Ok(());
        }
        // SAFETY: the caller promises an initialised struct.
        let given = unsafe { read_sized(goal, "goal") }?;
        let new = Goal {
            pose: pose(given.pose, "goal.pose")?,
            position_tolerance: given.position_tolerance,
            rotation_tolerance: given.rotation_tolerance,
            symmetry: given.symmetry,
        };
        new.validate().map_err(|error| error.within("goal"))?;
        content.goals[index] = Some(new);
        Ok(())
    })
}

/// Where a body is wanted.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: the caller; goal->struct_size says how much is written.
/// Errors: ARGUMENT (null, zero body, goal not initialised), HANDLE, BUSY, NOT_FOUND (the body, or it has no goal),
/// POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_get_goal(
    scene: *const jostle_scene,
    body: jostle_body,
    goal: *mut jostle_goal,
) -> jostle_status {
    with("jostle_scene_get_goal", scene, |content| {
        // SAFETY: the caller promises a writable place.
        unsafe { out(goal, "goal") }?;
        let index = content.index(body, "body")?;
        let known = content.goals[index]
            .as_ref()
            .ok_or_else(|| Failure::new(JOSTLE_ERROR_NOT_FOUND, "goal: the body has none".to_owned()))?;
        // SAFETY: the caller promises an initialised struct.
        unsafe { write_sized(goal, "goal", &known.into()) }
    })
}
