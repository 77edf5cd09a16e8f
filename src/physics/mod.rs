//! What a push does: the [`Transition`] interface and the engines behind it.

mod approach;
pub mod bullet;
pub mod dipn;
mod ensemble;
pub mod lanes;
pub mod narrow;
mod options;
pub mod planar;
pub mod prism;
pub mod rapier;
mod scaled;
mod transition;

#[cfg(feature = "bullet")]
pub use bullet::Bullet;
pub use bullet::BulletSettings;
pub use dipn::{Dipn, DipnSettings};
pub use ensemble::Ensemble;
pub use options::{
    ENGINES, EngineInfo, EngineSettings, FOLLOW_PATHS, PhysicsOptions, Purpose, engine, engine_with, network,
};
pub use planar::{Planar, PlanarSettings};
pub use prism::{Prism, PrismSettings};
pub use rapier::{Rapier, RapierSettings};
pub use transition::{DEEPEST, GraspResult, GraspStatus, PushJob, PushResult, PushStatus, Scratch, Stance, Transition};
