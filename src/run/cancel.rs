//! A flag that asks running work to end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Asks running work to end. Clones share one flag; any of them may be triggered or read from any thread, also after
/// the work, the planner or the scene it belonged to is gone.
#[derive(Debug, Clone, Default)]
pub struct CancelToken {
    flag: Arc<AtomicBool>,
}

impl CancelToken {
    /// A token that is not triggered.
    pub fn new() -> Self {
        Self::default()
    }

    /// Asks the work to end. Work that polls this token stops at its next check; asking twice changes nothing.
    pub fn trigger(&self) {
        self.flag.store(true, Ordering::Release);
    }

    /// Makes the token usable for the next piece of work. Work that has seen the request already still ends.
    pub fn reset(&self) {
        self.flag.store(false, Ordering::Release);
    }

    /// Whether the work was asked to end.
    pub fn is_triggered(&self) -> bool {
        self.flag.load(Ordering::Acquire)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_share_one_flag() {
        let token = CancelToken::new();
        let other = token.clone();
        assert!(!other.is_triggered());
        std::thread::spawn(move || other.trigger()).join().unwrap();
        assert!(token.is_triggered());
        token.reset();
        assert!(!token.is_triggered());
    }
}
