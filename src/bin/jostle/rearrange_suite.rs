//! The 40 rearrangements that `--suite rearrange` stands for; `suites/rearrange` has them as files.

/// Scene files, in the order of their names.
pub const SUITE: [&str; 0] = [];
