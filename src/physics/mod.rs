//! What a push does: the [`Transition`] interface and the engines behind it.

pub mod lanes;
pub mod narrow;
mod options;
pub mod planar;
pub mod rapier;
mod transition;

pub use options::{ENGINES, EngineInfo, PhysicsOptions, Purpose, engine};
pub use planar::{Planar, PlanarSettings};
pub use rapier::{Rapier, RapierSettings};
pub use transition::{PushJob, PushResult, PushStatus, Scratch, Transition};
