//! How far a search is: numbers that any thread may read while it runs, and a callback.

use std::fmt;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::time::Duration;

use super::Stop;

/// The state of a search at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ProgressSnapshot {
    /// Iterations done (backed-up pairs).
    pub iterations: u64,
    /// Nodes of the tree.
    pub nodes: u64,
    /// Actions that were simulated.
    pub simulations: u64,
    /// Best return seen for an action of the root; 0 before the first iteration.
    pub best_value: f64,
    /// Number of actions of the shortest solution found so far.
    pub solution_level: Option<u32>,
    /// Microseconds since the search began.
    pub elapsed_us: u64,
}

type Callback = Box<dyn Fn(&ProgressSnapshot) -> bool + Send + Sync>;

const UNSOLVED: u32 = u32::MAX;

/// Published progress: lock-free counters, and optionally a callback.
///
/// Reading never waits and never delays the search. A snapshot taken while the search publishes may mix the numbers
/// of two neighbouring moments; each number by itself is right.
pub struct Progress {
    iterations: AtomicU64,
    nodes: AtomicU64,
    simulations: AtomicU64,
    best_value: AtomicU64,
    solution_level: AtomicU32,
    elapsed_us: AtomicU64,
    callback: Option<Callback>,
    interval_us: u64,
    last_call_us: AtomicU64,
}

impl Default for Progress {
    fn default() -> Self {
        Progress {
            iterations: AtomicU64::new(0),
            nodes: AtomicU64::new(0),
            simulations: AtomicU64::new(0),
            best_value: AtomicU64::new(0),
            solution_level: AtomicU32::new(UNSOLVED),
            elapsed_us: AtomicU64::new(0),
            callback: None,
            interval_us: 0,
            last_call_us: AtomicU64::new(0),
        }
    }
}

impl fmt::Debug for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Progress").field("snapshot", &self.snapshot()).finish_non_exhaustive()
    }
}

impl Progress {
    /// Counters only.
    pub fn new() -> Self {
        Self::default()
    }

    /// Calls `callback` at most once per `interval`, from the thread that called the search and from no other. The
    /// search waits for it, so it should return soon. Returning `false` ends the search as a cancel would.
    pub fn with_callback(
        interval: Duration,
        callback: impl Fn(&ProgressSnapshot) -> bool + Send + Sync + 'static,
    ) -> Self {
        Progress {
            callback: Some(Box::new(callback)),
            interval_us: u64::try_from(interval.as_micros()).unwrap_or(u64::MAX),
            ..Self::default()
        }
    }

    /// The latest published numbers. From any thread, at any time.
    pub fn snapshot(&self) -> ProgressSnapshot {
        let level = self.solution_level.load(Ordering::Relaxed);
        ProgressSnapshot {
            iterations: self.iterations.load(Ordering::Relaxed),
            nodes: self.nodes.load(Ordering::Relaxed),
            simulations: self.simulations.load(Ordering::Relaxed),
            best_value: f64::from_bits(self.best_value.load(Ordering::Relaxed)),
            solution_level: (level != UNSOLVED).then_some(level),
            elapsed_us: self.elapsed_us.load(Ordering::Relaxed),
        }
    }

    /// Publishes new numbers (all but the time, which is `stop`'s) and calls the callback if its turn has come. A
    /// refusal of the callback interrupts `stop`. Only the thread that coordinates the work calls this.
    pub fn publish(&self, now: &ProgressSnapshot, stop: &Stop) {
        let elapsed_us = u64::try_from(stop.elapsed().as_micros()).unwrap_or(u64::MAX);
        self.iterations.store(now.iterations, Ordering::Relaxed);
        self.nodes.store(now.nodes, Ordering::Relaxed);
        self.simulations.store(now.simulations, Ordering::Relaxed);
        self.best_value.store(now.best_value.to_bits(), Ordering::Relaxed);
        self.solution_level.store(now.solution_level.unwrap_or(UNSOLVED), Ordering::Relaxed);
        self.elapsed_us.store(elapsed_us, Ordering::Relaxed);
        let Some(callback) = &self.callback else { return };
        let last = self.last_call_us.load(Ordering::Relaxed);
        // The clock of a second search starts anew; then `last` lies in the future.
        if elapsed_us < last || elapsed_us - last >= self.interval_us {
            self.last_call_us.store(elapsed_us, Ordering::Relaxed);
            if !callback(&ProgressSnapshot { elapsed_us, ..*now }) {
                stop.interrupt();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::run::StopReason;

    #[test]
    fn what_is_published_can_be_read() {
        let progress = Progress::new();
        assert_eq!(progress.snapshot(), ProgressSnapshot::default());
        let now = ProgressSnapshot {
            iterations: 3,
            nodes: 4,
            simulations: 5,
            best_value: 0.25,
            solution_level: Some(2),
            elapsed_us: 0,
        };
        progress.publish(&now, &Stop::never());
        assert_eq!(ProgressSnapshot { elapsed_us: 0, ..progress.snapshot() }, now);
    }

    #[test]
    fn the_callback_is_rate_limited_and_can_end_the_work() {
        let calls = Arc::new(AtomicU32::new(0));
        let counter = Arc::clone(&calls);
        let hourly = Progress::with_callback(Duration::from_secs(3600), move |_| {
            counter.fetch_add(1, Ordering::Relaxed);
            true
        });
        let stop = Stop::never();
        for _ in 0..10 {
            hourly.publish(&ProgressSnapshot::default(), &stop);
        }
        assert_eq!(calls.load(Ordering::Relaxed), 0);
        assert!(!stop.requested());

        let refusing = Progress::with_callback(Duration::ZERO, |now| now.iterations < 2);
        refusing.publish(&ProgressSnapshot { iterations: 1, ..Default::default() }, &stop);
        assert!(!stop.requested());
        refusing.publish(&ProgressSnapshot { iterations: 2, ..Default::default() }, &stop);
        assert_eq!(stop.reason(), Some(StopReason::Interrupted));
    }
}
