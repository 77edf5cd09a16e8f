//! Evaluation: a planner in closed loop with a judge, suites of problems, and the numbers that come of it.
//!
//! ```text
//! Suite::open -> run_suite -> Report
//!                  run_case: every trial with a fresh Planner and a fresh Judge
//!                    run_trial: observe, decide, execute the first action, until the target is out
//! ```
//!
//! Trials run one after the other: a planner uses the threads it was given.

pub mod arrange;
#[cfg(feature = "bullet")]
mod calibration;
pub mod certificate;
mod clear;
mod closed_loop;
pub mod clutter;
mod crosscheck;
mod fidelity;
mod folder;
mod judge;
mod metrics;
mod rearrange;
mod recording;
mod report;
pub mod robot;
pub mod statistics;
mod suite;
#[cfg(test)]
mod testing;

#[cfg(feature = "bullet")]
pub use calibration::{Confusion, GraspSample, grasp_samples};
pub use clear::{
    CLEAR_ACTIONS_PER_BODY, ClearCase, ClearEnd, ClearNumbers, ClearPolicy, ClearReport, ClearTrial, ClearTrials,
    clear_cap, clear_case, clear_suite, clear_trial,
};
pub use closed_loop::{ClosedLoopOptions, DEFAULT_MAX_ACTIONS, Event, Policy, run_case, run_trial};
pub use crosscheck::{Crosscheck, CrosscheckRow, crosscheck};
pub use fidelity::{Against, AllAgreement, Fidelity, MOVED_POSITION, MOVED_ROTATION, MovedAgreement, compare};
pub use folder::{Problems, Refused};
pub use judge::{Executor, Judge, JudgeOptions};
pub use metrics::{CaseReport, Decision, Effect, Mean, Spread, Total, Trial, TrialEnd};
pub use rearrange::{
    REARRANGE_MAX_ACTIONS, RearrangeCase, RearrangeEnd, RearrangeReport, RearrangeTrial, RearrangeTrials,
    rearrange_case, rearrange_suite,
};
pub use recording::{
    RecordParams, RecordedShape, RecordedTip, Recording, read as read_recordings, record, to_lines as recording_lines,
};
pub use report::{BudgetReport, Configuration, Report, run_suite};
pub use suite::{Suite, max_actions, needs_push, needs_pushes, push_travel, read_problem, retrieval_of, with_gripper};
