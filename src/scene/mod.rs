//! The world a planner thinks about: bodies, gripper, workspace, friction (a [`Scene`], immutable while planning),
//! where the bodies are (a [`State`]), and what is asked (a [`Problem`]).

mod body;
mod gripper;
mod scene;
mod state;
mod workspace;

pub use body::{Body, BodyDef, MAX_BODIES};
pub use gripper::{Grasper, Gripper, PushTip};
pub use scene::{DEFAULT_OVERLAP_TOLERANCE, Friction, Problem, Scene, SceneBuilder};
pub use state::{BodyPose, Mask, State};
pub use workspace::{LeaveRule, LeaveScope, Workspace};
