//! The tables that `--suite clear-random` and `--suite clear-packed` stand for; `suites` has them as files.

/// Scene files, in the order of their names.
pub const RANDOM: &[&str] = &[];
pub const PACKED: &[&str] = &[];
