//! Evaluation: a planner in closed loop with a judge, suites of problems, and the numbers that come of it.

mod fidelity;
mod metrics;
pub mod statistics;
#[cfg(test)]
mod testing;

pub use fidelity::{
    Against, AllAgreement, Fidelity, MOVED_POSITION, MOVED_ROTATION, MovedAgreement, Recording, compare, read,
};
pub use metrics::{CaseReport, Decision, Effect, Mean, Spread, Total, Trial, TrialEnd};
