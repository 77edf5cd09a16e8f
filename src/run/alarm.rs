//! Work that cannot poll a [`Stop`](super::Stop): another thread tells it to end.

use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

use crate::error::{Error, Result};

/// Does the work on this thread. If it lasts longer than `limit`, `stop` is called on another, once; the work is waited for
/// all the same.
///
/// # Errors
/// [`Error::State`] if the other thread cannot be started; then nothing was done.
pub fn within<R>(limit: Duration, stop: impl FnOnce() + Send, work: impl FnOnce() -> R) -> Result<R> {
    // Nothing is ever sent: that the sender is gone says that the work has ended, however it did.
    let (working, ended) = sync_channel::<()>(1);
    std::thread::scope(|scope| {
        let watch = move || {
            if ended.recv_timeout(limit) == Err(RecvTimeoutError::Timeout) {
                stop();
            }
        };
        std::thread::Builder::new()
            .name("jostle-alarm".into())
            .spawn_scoped(scope, watch)
            .map_err(|e| Error::State(format!("the thread that keeps the time cannot be started: {e}")))?;
        let result = work();
        drop(working);
        Ok(result)
    })
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn work_that_lasts_too_long_is_told_to_end_and_other_work_is_not() {
        // Ends only because it is told to.
        let (tell, told) = channel();
        within(Duration::ZERO, move || tell.send(7).unwrap(), || assert_eq!(told.recv(), Ok(7))).unwrap();
        let stopped = AtomicBool::new(false);
        let late = || stopped.store(true, Ordering::Relaxed);
        assert_eq!(within(Duration::from_secs(1 << 20), late, || 3), Ok(3));
        let panics = || within(Duration::from_secs(1 << 20), late, || panic!("of the test"));
        assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(panics)).is_err());
        assert!(!stopped.load(Ordering::Relaxed));
    }
}
