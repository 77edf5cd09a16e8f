//! Planners: what they are asked, what they answer, and one file for each system's composition.

pub mod clear;
mod confirm;
mod decision;
mod failures;
mod hedge;
mod mcts;
mod more;
mod networks;
mod options;
mod outcome;
mod planner;
mod pmbs;
pub mod rearrange;
mod reason;
mod recipe;
mod retrieval;
mod vft;

pub use failures::FailedPushes;
pub use networks::OwnNetworks;
pub use options::{Confirm, GraspDecision, PlannerOptions, Variant};
pub use outcome::{Outcome, Plan, PlanStatistics, PlannedAction, RankedAction};
pub use planner::{Control, Planner};
pub use reason::{Reason, WrittenReason};
pub use recipe::{PLANNERS, PRIORS};
pub use retrieval::{Retrieval, Reward};
