//! The world a planner thinks about: bodies, gripper, workspace, friction (a [`Scene`], immutable while planning),
//! where the bodies are (a [`State`]), and what is asked (a [`Problem`]).

mod body;
mod gripper;
pub mod library;
mod state;
#[cfg(test)]
pub(crate) mod testing;
mod workspace;
mod world;

pub use body::{Body, BodyDef, MAX_BODIES};
pub use gripper::{Grasper, Gripper, PushTip};
pub use state::{BodyPose, Mask, State};
pub use workspace::{LeaveRule, LeaveScope, Workspace};
pub use world::{DEFAULT_OVERLAP_TOLERANCE, Friction, Problem, Scene, SceneBuilder};
