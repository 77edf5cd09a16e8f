//! Whether a thread still lives in the process that something was made in.

use crate::error::{Error, Result};

/// The process in which something was made. Threads do not survive a fork: what has some waits for ever in the child.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Home(u32);

impl Home {
    /// This process.
    pub fn here() -> Home {
        Home(std::process::id())
    }

    /// Refuses another process than the one it was made in; `what` begins the sentence.
    pub fn check(self, what: &str) -> Result<()> {
        if self == Home::here() {
            return Ok(());
        }
        Err(Error::State(format!(
            "{what}: has threads of the process that made it, and this is a child of that process, to which a fork takes no \
             threads; make a new one here"
        )))
    }
}
