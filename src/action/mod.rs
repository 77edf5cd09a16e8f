//! What a robot may do: pushes and grasps, and the samplers that propose pushes.

mod push;
pub mod sampler;

pub use push::{Action, Grasp, Push};
pub use sampler::{ContourSampler, PushSampler, SamplerParams, SamplerScratch};
