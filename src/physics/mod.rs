//! What a push does: the [`Transition`] interface and the engines behind it.

mod transition;

pub use transition::{PushJob, PushResult, PushStatus, Scratch, Transition};
