//! What a robot may do: pushes and grasps, and the samplers that propose pushes.

mod push;

pub use push::{Action, Grasp, Push};
