//! Planners of rearrangements: HBFS and PMMR (REMP, dissertation chapter 7).

mod outcome;

pub use outcome::{PlannedMove, RankedMove, RearrangePlan};
