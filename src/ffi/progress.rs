//! How far a decision is: a snapshot to poll, and a callback.

use std::ffi::c_void;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use super::abi::{Sized32, init_sized};
use super::guard::guard;
use super::status::jostle_status;
use crate::run::{Progress, ProgressSnapshot};

/// `jostle_progress.solution_actions` while no solution is known.
pub const JOSTLE_NO_SOLUTION: u32 = 0xffff_ffff;

/// How far a decision is.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct jostle_progress {
    /// Set by jostle_progress_default().
    pub struct_size: u32,
    /// Actions of the shortest solution found so far, JOSTLE_NO_SOLUTION while there is none.
    pub solution_actions: u32,
    /// Iterations done.
    pub iterations: u64,
    /// Nodes of the search tree.
    pub nodes: u64,
    /// Pushes simulated.
    pub simulations: u64,
    /// Best return seen for a first action.
    pub best_value: f64,
    /// Since the decision began.
    pub elapsed_seconds: f64,
}

// SAFETY: repr(C), struct_size first, numbers without padding.
unsafe impl Sized32 for jostle_progress {
    const NAME: &'static str = "jostle_progress";
    const FIRST_SIZE: usize = 48;
    fn defaults() -> Self {
        ProgressSnapshot::default().into()
    }
}

impl From<ProgressSnapshot> for jostle_progress {
    fn from(now: ProgressSnapshot) -> Self {
        jostle_progress {
            struct_size: size_of::<jostle_progress>() as u32,
            solution_actions: now.solution_level.unwrap_or(JOSTLE_NO_SOLUTION),
            iterations: now.iterations,
            nodes: now.nodes,
            simulations: now.simulations,
            best_value: now.best_value,
            elapsed_seconds: now.elapsed_us as f64 * 1e-6,
        }
    }
}

/// Told how far a decision is; a value other than 0 cancels it. It is called on the thread that decides (the caller's
/// for solve and step, the job's own for a job) while the search waits, so it should return soon. No lock is held, but
/// the planner is in use: calls on it return JOSTLE_ERROR_BUSY. It must not throw or longjmp.
pub type jostle_progress_callback =
    Option<unsafe extern "C" fn(progress: *const jostle_progress, user: *mut c_void) -> i32>;

/// Sets every field to its default; `size` is sizeof(jostle_progress) as the caller was compiled.
/// jostle_progress_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_progress_init(progress: *mut jostle_progress, size: usize) -> jostle_status {
    // SAFETY: the caller promises `size` writable bytes.
    guard("jostle_progress_init", |_| unsafe { init_sized(progress, "progress", size) })
}

/// The callback of one decision.
#[derive(Clone, Copy)]
pub(super) struct Listener {
    pub callback: jostle_progress_callback,
    pub user: *mut c_void,
    pub interval: Duration,
}

// SAFETY: the host promises that the callback may be called on the thread that decides (see
// `jostle_progress_callback`).
unsafe impl Send for Listener {}

/// A planner's progress: one object for its whole life, so that it can be polled without a lock, with the callback of
/// the decision that runs.
pub(super) struct Publisher {
    pub progress: Arc<Progress>,
    listener: Arc<Mutex<Listening>>,
}

#[derive(Default)]
struct Listening {
    listener: Option<Listener>,
    last_us: u64,
}

impl Publisher {
    pub fn new() -> Self {
        let listener = Arc::new(Mutex::new(Listening::default()));
        let shared = Arc::clone(&listener);
        let progress = Progress::with_callback(Duration::ZERO, move |now| {
            let turn = {
                let mut listening = shared.lock().unwrap_or_else(PoisonError::into_inner);
                let Some(listener) = listening.listener else { return true };
                let since = now.elapsed_us.saturating_sub(listening.last_us);
                if u128::from(since) < listener.interval.as_micros() {
                    return true;
                }
                listening.last_us = now.elapsed_us;
                listener
            };
            let Some(callback) = turn.callback else { return true };
            let progress = jostle_progress::from(*now);
            // SAFETY: the host gave the callback for this; `progress` lives until it returns.
            unsafe { callback(&progress, turn.user) == 0 }
        });
        Publisher { progress: Arc::new(progress), listener }
    }

    /// Sets the callback of the next decision.
    pub fn listen(&self, listener: Option<Listener>) {
        let mut listening = self.listener.lock().unwrap_or_else(PoisonError::into_inner);
        *listening = Listening { listener, last_us: 0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::{Budget, Stop};

    unsafe extern "C" fn count(progress: *const jostle_progress, user: *mut c_void) -> i32 {
        // SAFETY: the test passes a counter, the library a valid struct.
        unsafe {
            *user.cast::<u64>() += 1;
            i32::from((*progress).iterations >= 3)
        }
    }

    #[test]
    fn the_callback_is_called_counts_and_cancels() {
        let publisher = Publisher::new();
        let mut calls = 0u64;
        let listener =
            Listener { callback: Some(count), user: (&raw mut calls).cast(), interval: Duration::from_micros(0) };
        let stop = Budget::default().start(&[]);
        let publish = |iterations, stop: &Stop| {
            publisher.progress.publish(&ProgressSnapshot { iterations, ..Default::default() }, stop);
        };
        publish(1, &stop);
        publisher.listen(Some(listener));
        publish(2, &stop);
        assert!(!stop.requested());
        publish(3, &stop);
        assert!(stop.requested());
        publisher.listen(None);
        publish(4, &stop);
        assert_eq!(calls, 2);
        publisher.listen(Some(Listener { interval: Duration::from_secs(3600), ..listener }));
        publish(5, &stop);
        assert_eq!(calls, 2);
        assert_eq!(publisher.progress.snapshot().iterations, 5);
    }
}
