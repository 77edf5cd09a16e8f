//! Paths of one body among the others in SE(2).
//!
//! A [`PathPlanner`] answers for a scene: is a pose free, is a straight motion free, is there a path. Gaps are those
//! between footprints; the whole footprint stays within the workspace.
//!
//! | file | holds |
//! |---|---|
//! | `params` | [`PathParams`] and what they default to |
//! | `planner` | [`PathPlanner`]: queries, their cache |
//! | `enclosure` | [`Enclosure`]: whether a body certainly cannot be brought to its goal |
//! | `shape`, `gap`, `sweep` | convex cores, their signed gap, exact checks of poses and motions |
//! | `connect` | RRT-Connect and shortening |
//! | `reach` | bitmaps: where a body certainly cannot be brought, and a way that may be free |

mod connect;
mod enclosure;
mod gap;
mod params;
mod planner;
mod reach;
mod shape;
mod sweep;
#[cfg(test)]
mod tests;

pub use enclosure::{Enclosure, Region};
pub use params::{EDGE_TOLERANCE, MIN_CLEARANCE, PathParams, SWEEP_SLACK, room};
pub use planner::{Path, PathLimits, PathOutcome, PathPlanner, PathScratch};
