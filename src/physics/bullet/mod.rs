//! Bullet as a [`Transition`](super::Transition): prisms in space on a ground, pushed by a box with a height.
//!
//! The settings are those under which Bullet gives the bits of PyBullet, the simulator of the published planners
//! (`docs/bullet.md`). The engine is there with the cargo feature `bullet`; its settings are there always.

mod settings;

mod grasp;

#[cfg(feature = "bullet")]
mod engine;
#[cfg(feature = "bullet")]
mod hull;
#[cfg(feature = "bullet")]
#[allow(unsafe_code)]
mod native;
#[cfg(feature = "bullet")]
mod trial;
#[cfg(feature = "bullet")]
mod world;

#[cfg(feature = "bullet")]
pub use engine::{BodyDetail, Bullet};
pub use grasp::{GraspMotion, GraspTrial};
pub use settings::{BulletSettings, Ground, Solver};

/// Whether this build has the engine; if not, what brings it.
pub(super) const AVAILABLE: Result<(), &str> = if cfg!(feature = "bullet") {
    Ok(())
} else {
    Err("build it with the cargo feature `bullet` (Debian: apt install libbullet-dev)")
};
