//! Can the gripper take a body where it lies?
//!
//! | file | holds |
//! |---|---|
//! | `params` | [`GraspParams`]: how finely the test searches and how it scores |
//! | `jaw` | exact queries of rectangles against convex pieces in the jaw's frame |
//! | `hold` | what the jaw finds between its pads: width, cover, wedge; and the score |
//! | `table` | the holds of a body that its own shape allows, worked out once for a scene |
//! | `test` | [`GraspTest`]: the best grasp of a body in a state; [`GraspCheck`]: one grasp examined |
//! | `examine` | [`GraspExamination`]: all that is known of a grasp, and of the best ones of a body |
//! | `failed` | [`FailedGrasp`]: less belief in grasps like those that failed |
//! | `dense` | the score of every grasp on a grid of positions and directions |
//! | `graspability` | [`GraspabilityScorer`]: a network of kind `gc` as a scorer |
//! | `map` | [`MapScorer`]: a network of kind `gn` as a scorer |
//! | `choice` | [`SCORERS`], [`Networks`], [`scorer`]: a scorer by its name |
//! | `holds` | [`Jaw`]: whether a grasp that was planned for observed poses holds at the true ones |
//! | `scorer` | [`Scorer`], the interface of everything that says how good a state is, and [`GeometricScorer`] |
//!
//! The jaw's frame has x along the closing direction and y along the pads.

mod choice;
mod dense;
mod examine;
#[cfg(test)]
mod examine_tests;
mod failed;
mod graspability;
mod hold;
mod holds;
mod jaw;
#[cfg(test)]
mod keeping_tests;
mod map;
#[cfg(test)]
mod network_tests;
mod params;
mod scorer;
mod table;
mod test;
#[cfg(test)]
mod tests;

pub use choice::{Networks, SCORERS, check_scorer, scorer};
pub use dense::GraspGrid;
pub use examine::{APART, GraspExamination, GraspSpares};
pub use failed::FailedGrasp;
pub use graspability::GraspabilityScorer;
pub use holds::Jaw;
pub use map::MapScorer;
pub use params::{GraspParams, GraspScore};
pub use scorer::{GeometricScorer, GraspAssessment, Scorer};
pub use test::{GraspCheck, GraspScratch, GraspTest, Limit, Unholdable};
