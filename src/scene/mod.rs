//! The world a planner thinks about: bodies, gripper, workspace, friction (a [`Scene`], immutable while planning),
//! where the bodies are (a [`State`]), and what is asked (a [`Problem`]).
//!
//! Problems come from a [`SceneBuilder`], from scene files ([`Problem::read`]), from the originals' case files
//! ([`arc`]) and from the seeded [`generate`]; [`library`] has the originals' blocks.

pub mod arc;
mod body;
mod clearing;
mod file;
pub mod generate;
mod gripper;
mod input;
mod keeping;
pub mod library;
mod rearrangement;
mod solid;
mod state;
mod table;
#[cfg(test)]
pub(crate) mod testing;
mod tip_path;
pub mod trlb;
mod uncertainty;
mod workspace;
mod world;

pub use body::{Body, BodyDef, MAX_BODIES, MAX_SIMULATED};
pub use clearing::Clearing;
pub use file::{AnyProblem, SCENE_VERSION};
pub use gripper::{Grasper, Gripper, PushTip};
pub use input::{Input, InputKind, is_meant};
pub use keeping::{GraspFeatures, Keeping};
pub use rearrangement::{CONTACT_SLACK, Goal, PLACE_SLACK, Rearrangement};
pub use state::{BodyPose, Mask, State, check_pose};
pub use table::Table;
pub use tip_path::{Stroke, TipPath};
pub use uncertainty::Uncertainty;
pub use workspace::{LeaveRule, LeaveScope, Workspace};
pub use world::{DEFAULT_OVERLAP_TOLERANCE, Friction, Problem, Scene, SceneBuilder};
