//! Planners of rearrangements: HBFS and PMMR (REMP, dissertation chapter 7), and `untangle`, our own.

mod bridge;
mod certain;
mod domain;
mod feedback;
mod graph;
mod hbfs;
mod improve;
mod mover;
mod options;
mod outcome;
mod planner;
mod pmmr;
mod room;
mod samplers;
mod shorten;
mod table;
#[cfg(test)]
mod tests;
mod untangle;

pub use options::{REARRANGE_PLANNERS, RearrangeOptions, RearrangeReward};
pub use outcome::{PlannedMove, RankedMove, RearrangePlan};
pub use planner::RearrangePlanner;
pub use samplers::SampleCounts;
