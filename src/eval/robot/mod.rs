//! What a full robot did, held against what the library foretells: grasps and pushes recorded one attempt a line.
//!
//! | file | holds |
//! |---|---|
//! | `record` | the lines of such files: [`RobotGrasp`], [`RobotPush`], and the scenes that they are about |
//! | `grasps` | what a score says of the recorded grasps: [`GraspReliability`] |
//! | `fit` | the chance of keeping, fitted to recorded grasps: [`fit_keeping`] |
//! | `hand` | a hand that keeps and loses bodies as recorded: [`RobotHand`] |
//! | `pushes` | where an engine says that the bodies go: [`PushAccuracy`] |

mod fit;
mod grasps;
mod hand;
mod pushes;
mod record;
#[cfg(test)]
mod tests;

pub use fit::fit_keeping;
pub use grasps::{BANDS, GraspReliability, ReliabilityBand, grasp_reliability};
pub use hand::{Held, RobotHand, shove};
pub use pushes::{PushAccuracy, push_accuracy};
pub use record::{GraspOutcome, RobotBody, RobotGrasp, RobotPush, RobotRecords, RobotSurfaces};
