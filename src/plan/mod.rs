//! Planners: what they are asked, what they answer, and one file for each system's composition.

mod options;
mod outcome;
mod planner;

pub use options::{GraspDecision, PLANNERS, PlannerOptions};
pub use outcome::{Outcome, Plan, PlanStatistics, PlannedAction, RankedAction};
pub use planner::{Control, Planner};
