//! What a long computation needs around it: worker threads, limits, cancelling, progress and random numbers.
//!
//! | file | holds | thread rule |
//! |---|---|---|
//! | `budget` | [`Budget`] (limits as the user writes them), [`Stop`] (what running work polls) | `Stop` is polled from any thread |
//! | `alarm` | [`within`]: work that another thread tells to end | any thread |
//! | `cancel` | [`CancelToken`] | any thread, also while work runs |
//! | `progress` | [`Progress`], [`ProgressSnapshot`] | read from any thread; written by the coordinating thread |
//! | `random` | [`Key`], [`Stream`] | plain values |
//! | `pool` | [`Pool`] | shared by `&`; dropping it joins its threads |
//!
//! Nothing here knows what is computed. Time is read in `budget` only, so that everything else is a function of its
//! inputs and its seed.

pub mod alarm;
pub mod budget;
pub mod cancel;
pub mod pool;
pub mod progress;
pub mod random;

pub use alarm::within;
pub use budget::{Budget, Stop, StopReason};
pub use cancel::CancelToken;
pub use pool::Pool;
pub use progress::{Progress, ProgressSnapshot};
pub use random::{Key, Stream};
