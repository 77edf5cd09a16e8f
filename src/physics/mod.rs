//! What a push does: the [`Transition`] interface and the engines behind it.

pub mod bullet;
pub mod lanes;
mod options;
pub mod prism;
pub mod rapier;
mod transition;

#[cfg(feature = "bullet")]
pub use bullet::Bullet;
pub use bullet::BulletSettings;
pub use options::{ENGINES, EngineInfo, EngineSettings, PhysicsOptions, Purpose, engine};
pub use prism::{Prism, PrismSettings};
pub use rapier::{Rapier, RapierSettings};
pub use transition::{PushJob, PushResult, PushStatus, Scratch, Transition};
