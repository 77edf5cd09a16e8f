//! Ending a call of the runtime that is under way: a second thread looks at the stop and tells the runtime.
//!
//! The number of items of a call is fixed, for another rounds differently (see [`super::Model`]), so a long call cannot be cut
//! into short ones. ONNX Runtime ends a call between two nodes of the network; the embedded backend knows no such request.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, Thread, park_timeout, scope};
use std::time::Duration;

use ort::session::RunOptions;

use crate::run::Stop;

/// Time between two looks at the stop.
const LOOK: Duration = Duration::from_micros(500);
/// A thread of its own is worth it for calls that take longer, seconds.
pub(super) const WORTH_WATCHING: f64 = 1e-3;
/// The watching thread calls next to nothing.
const STACK: usize = 64 * 1024;

/// Tells the watching thread that the call is over, also where it panicked.
struct Over<'a>(&'a AtomicBool, Option<Thread>);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
        if let Some(thread) = &self.1 {
            thread.unpark();
        }
    }
}

/// Makes a call with these options, and ends it when the stop is requested. Where no thread can be had it runs to its end.
pub(super) fn watched<R>(options: &RunOptions, stop: &Stop, call: impl FnOnce() -> R) -> R {
    let over = AtomicBool::new(false);
    scope(|scope| {
        let watch = || {
            while !over.load(Ordering::Acquire) {
                if stop.requested() {
                    // Refused by a runtime that cannot end a call.
                    let _ = options.terminate();
                    return;
                }
                park_timeout(stop.remaining().map_or(LOOK, |left| left.min(LOOK)));
            }
        };
        let watching = Builder::new().name("jostle-watch".into()).stack_size(STACK).spawn_scoped(scope, watch);
        let _over = Over(&over, watching.ok().map(|handle| handle.thread().clone()));
        call()
    })
}
