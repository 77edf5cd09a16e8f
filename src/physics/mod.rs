//! What a push does: the [`Transition`] interface and the engines behind it.

mod options;
pub mod prism;
pub mod rapier;
mod transition;

pub use options::{ENGINES, EngineInfo, PhysicsOptions, Purpose, engine};
pub use prism::{Prism, PrismSettings};
pub use rapier::{Rapier, RapierSettings};
pub use transition::{PushJob, PushResult, PushStatus, Scratch, Transition};
