//! What a robot may do: pushes and grasps, the moves of a rearrangement, and the samplers that propose pushes.

mod moves;
mod push;
pub mod sampler;

pub use moves::{Move, MoveCosts};
pub use push::{Action, Grasp, Push};
pub use sampler::{ContourSampler, PushSampler, SamplerParams, SamplerScratch};
