//! A flag that asks running work to end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Asks running work to end. Clones share one flag; any of them may be triggered or read from any thread, also after
/// the work, the planner or the scene it belonged to is gone.
#[derive(Debug, Clone, Default)]
pub struct CancelToken {
    flag: Arc<AtomicBool>,
    /// Looks until it triggers by itself, where it does.
    looks: Option<Arc<AtomicU64>>,
}

impl CancelToken {
    /// A token that is not triggered.
    pub fn new() -> Self {
        Self::default()
    }

    /// A token that triggers by itself at the look number `looks` of the work that polls it: work is interrupted at the
    /// same place each time it runs on one thread, without a clock. For tests of what polls.
    pub fn after_looks(looks: u64) -> Self {
        CancelToken { looks: Some(Arc::new(AtomicU64::new(looks))), ..Self::default() }
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
        if let Some(looks) = &self.looks
            && looks.fetch_update(Ordering::AcqRel, Ordering::Acquire, |left| left.checked_sub(1)) == Ok(1)
        {
            self.trigger();
        }
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

    #[test]
    fn a_token_can_trigger_at_a_look() {
        for looks in 1..5 {
            let token = CancelToken::after_looks(looks);
            let seen: Vec<bool> = (0..6).map(|_| token.is_triggered()).collect();
            assert_eq!(seen.iter().position(|seen| *seen), Some(looks as usize - 1), "{seen:?}");
            assert!(seen[looks as usize..].iter().all(|seen| *seen), "{seen:?}");
        }
    }
}
