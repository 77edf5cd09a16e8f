//! Limits of a computation, and what the computation polls to obey them.
//!
//! This is the only file of the library that reads a clock.

use std::sync::atomic::{AtomicU8, Ordering};
use std::time::{Duration, Instant};

use crate::error::{Error, Result, check_positive};

use super::CancelToken;

/// How much a computation may use. `None` is "no such limit"; the first limit that is reached ends the work.
///
/// Only a budget of iterations gives the same result on every machine; time and memory budgets end the same sequence
/// of steps earlier or later.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Budget {
    /// Iterations of the search (see `search`: one selected and backed-up pair of node and action).
    pub iterations: Option<u64>,
    /// Wall-clock seconds.
    pub seconds: Option<f64>,
    /// Bytes of search memory, as estimated by the search.
    pub bytes: Option<usize>,
}

impl Budget {
    /// A budget of iterations only: reproducible.
    pub fn iterations(iterations: u64) -> Self {
        Budget { iterations: Some(iterations), ..Self::default() }
    }

    /// A budget of wall-clock time only.
    pub fn seconds(seconds: f64) -> Self {
        Budget { seconds: Some(seconds), ..Self::default() }
    }

    /// Refuses limits that cannot be obeyed: zero, negative or not finite.
    pub fn validate(&self) -> Result<()> {
        if self.iterations == Some(0) {
            return Err(Error::argument("iterations", "is 0; it must be at least 1, or absent for no limit"));
        }
        if let Some(seconds) = self.seconds {
            check_positive("seconds", seconds)?;
        }
        if self.bytes == Some(0) {
            return Err(Error::argument("bytes", "is 0; it must be at least 1, or absent for no limit"));
        }
        Ok(())
    }

    /// Like [`validate`](Self::validate), and refuses a budget that would never end the work by itself: one with
    /// neither iterations nor seconds. For callers whose work has no other end.
    pub fn validate_bounded(&self) -> Result<()> {
        self.validate()?;
        if self.iterations.is_none() && self.seconds.is_none() {
            return Err(Error::argument("budget", "has no limit; set `iterations` or `seconds`"));
        }
        Ok(())
    }

    /// Starts the clock. The work ends at the deadline, if there is one, or when any of `tokens` is triggered.
    pub fn start(&self, tokens: &[CancelToken]) -> Stop {
        let start = Instant::now();
        // A duration too long for the clock is as good as none.
        let limit = self.seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        Stop {
            start,
            deadline: limit.and_then(|limit| start.checked_add(limit)),
            tokens: tokens.to_vec(),
            seen: AtomicU8::new(RUNNING),
            #[cfg(test)]
            looks: None,
        }
    }
}

/// Why work was asked to end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// The time is up.
    Deadline,
    /// A [`CancelToken`] was triggered.
    Cancelled,
    /// The progress callback, or the code that runs the work, asked for the end.
    Interrupted,
}

const RUNNING: u8 = 0;
const DEADLINE: u8 = 1;
const CANCELLED: u8 = 2;
const INTERRUPTED: u8 = 3;

/// What long work polls: a deadline, cancel tokens, and a flag of its own.
///
/// Shared by reference among all threads of one piece of work. Once a request was seen it stays, so every thread
/// agrees on the reason even if a token is reset meanwhile.
#[derive(Debug)]
pub struct Stop {
    start: Instant,
    deadline: Option<Instant>,
    tokens: Vec<CancelToken>,
    seen: AtomicU8,
    /// For tests: looks until the time is up.
    #[cfg(test)]
    looks: Option<std::sync::Arc<std::sync::atomic::AtomicU64>>,
}

impl Stop {
    /// Never asks for the end by itself; [`interrupt`](Self::interrupt) still works.
    pub fn never() -> Self {
        Budget::default().start(&[])
    }

    /// Time that is up after so many looks, instead of by a clock: tests end work at every place where it can end.
    #[cfg(test)]
    pub fn after_looks(looks: u64) -> Self {
        Stop { looks: Some(std::sync::Arc::new(looks.into())), ..Self::never() }
    }

    /// Whether the work should end now. Cheap enough for every slice of a simulation: atomics first, and the clock
    /// (about 25 ns) only where there is a deadline.
    pub fn requested(&self) -> bool {
        if self.seen.load(Ordering::Acquire) != RUNNING {
            return true;
        }
        if self.tokens.iter().any(CancelToken::is_triggered) {
            self.see(CANCELLED);
            return true;
        }
        #[cfg(test)]
        if let Some(looks) = &self.looks
            && looks.fetch_update(Ordering::AcqRel, Ordering::Acquire, |left| left.checked_sub(1)).is_err()
        {
            self.see(DEADLINE);
            return true;
        }
        if self.deadline.is_some_and(|deadline| Instant::now() >= deadline) {
            self.see(DEADLINE);
            return true;
        }
        false
    }

    /// Time that is left before the deadline, if there is one.
    pub fn remaining(&self) -> Option<Duration> {
        self.deadline.map(|deadline| deadline.saturating_duration_since(Instant::now()))
    }

    /// Whether work that cannot be broken off and takes so many seconds would end after the deadline. Then the time is up
    /// now: such work is not begun.
    pub fn leaves_less_than(&self, seconds: f64) -> bool {
        if self.remaining().is_some_and(|left| left.as_secs_f64() < seconds) {
            self.see(DEADLINE);
        }
        self.requested()
    }

    /// It may ask for the end by itself: there is a deadline or a token.
    pub fn is_bounded(&self) -> bool {
        self.deadline.is_some() || !self.tokens.is_empty()
    }

    /// A request of its own for a first part of the work: its deadline comes after this share of the time that there is
    /// from the start to the deadline. Without a deadline it has none; cancel tokens and requests made so far are shared.
    pub fn sooner(&self, share: f64) -> Stop {
        Stop {
            start: self.start,
            deadline: self.deadline.map(|deadline| self.start + (deadline - self.start).mul_f64(share.clamp(0.0, 1.0))),
            tokens: self.tokens.clone(),
            seen: AtomicU8::new(self.seen.load(Ordering::Acquire)),
            #[cfg(test)]
            looks: self.looks.clone(),
        }
    }

    /// Asks for the end from within: the progress callback said so, or a part of the work failed.
    pub fn interrupt(&self) {
        self.see(INTERRUPTED);
    }

    /// Why the end was asked for; `None` while nothing that polled has seen a request.
    pub fn reason(&self) -> Option<StopReason> {
        match self.seen.load(Ordering::Acquire) {
            DEADLINE => Some(StopReason::Deadline),
            CANCELLED => Some(StopReason::Cancelled),
            INTERRUPTED => Some(StopReason::Interrupted),
            _ => None,
        }
    }

    /// Time since the work began.
    pub fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }

    /// The first reason wins.
    fn see(&self, reason: u8) {
        let _ = self.seen.compare_exchange(RUNNING, reason, Ordering::AcqRel, Ordering::Acquire);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(result: Result<()>) -> String {
        match result {
            Err(Error::Argument { field, .. }) => field,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn limits_that_cannot_be_obeyed_are_refused_by_name() {
        assert_eq!(field(Budget { iterations: Some(0), ..Budget::default() }.validate()), "iterations");
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(field(Budget::seconds(bad).validate()), "seconds");
        }
        assert_eq!(field(Budget { bytes: Some(0), ..Budget::default() }.validate()), "bytes");
        assert_eq!(field(Budget { bytes: Some(1), ..Budget::default() }.validate_bounded()), "budget");
        assert!(Budget::default().validate().is_ok());
        assert!(Budget::iterations(1).validate_bounded().is_ok());
        assert!(Budget::seconds(1e300).validate_bounded().is_ok());
    }

    #[test]
    fn a_share_of_the_time_ends_sooner_and_shares_the_tokens() {
        let token = CancelToken::new();
        let whole = Budget::seconds(3600.0).start(std::slice::from_ref(&token));
        let none = whole.sooner(0.0);
        assert!(none.requested() && !whole.requested());
        assert_eq!(none.reason(), Some(StopReason::Deadline));
        let half = whole.sooner(0.5);
        assert!(!half.requested());
        token.trigger();
        assert!(half.requested() && whole.requested());
        assert_eq!(half.reason(), Some(StopReason::Cancelled));
        assert!(!Stop::never().sooner(0.0).requested(), "no deadline, no share of it");
    }

    #[test]
    fn work_that_would_end_after_the_deadline_is_not_begun() {
        let hour = || Budget::seconds(3600.0).start(&[]);
        for (seconds, late) in [(0.0, false), (1.0, false), (3500.0, false), (3601.0, true), (f64::INFINITY, true)] {
            let stop = hour();
            assert_eq!(stop.leaves_less_than(seconds), late, "{seconds}");
            assert_eq!(stop.reason(), late.then_some(StopReason::Deadline));
            assert!(!Stop::never().leaves_less_than(seconds), "no deadline");
        }
    }

    #[test]
    fn a_stop_says_why() {
        let never = Budget::seconds(1e300).start(&[]);
        assert!(!never.requested() && never.reason().is_none());
        never.interrupt();
        assert!(never.requested());
        assert_eq!(never.reason(), Some(StopReason::Interrupted));

        let late = Budget::seconds(1e-9).start(&[]);
        std::thread::sleep(Duration::from_millis(1));
        assert!(late.requested());
        assert_eq!(late.reason(), Some(StopReason::Deadline));

        let tokens = [CancelToken::new(), CancelToken::new()];
        let stop = Budget::default().start(&tokens);
        assert!(!stop.requested());
        tokens[1].trigger();
        assert!(stop.requested());
        tokens[1].reset();
        assert!(stop.requested(), "a request that was seen stays");
        assert_eq!(stop.reason(), Some(StopReason::Cancelled));
    }
}
