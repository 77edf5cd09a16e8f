//! Can the gripper take a body where it lies?
//!
//! | file | holds |
//! |---|---|
//! | `params` | [`GraspParams`]: how finely the test searches and how it scores |
//! | `jaw` | exact queries of rectangles against convex pieces in the jaw's frame |
//! | `hold` | what the jaw finds between its pads: width, cover, wedge; and the score |
//! | `table` | the holds of a body that its own shape allows, worked out once for a scene |
//! | `test` | [`GraspTest`]: the best grasp of a body in a state; [`GraspCheck`]: one grasp examined |
//! | `holds` | [`Jaw`]: whether a grasp that was planned for observed poses holds at the true ones |
//! | `scorer` | [`Scorer`], the interface of everything that says how good a state is, and [`GeometricScorer`] |
//!
//! The jaw's frame has x along the closing direction and y along the pads.

mod hold;
mod holds;
mod jaw;
mod params;
mod scorer;
mod table;
mod test;
#[cfg(test)]
mod tests;

pub use holds::Jaw;
pub use params::{GraspParams, GraspScore};
pub use scorer::{GeometricScorer, GraspAssessment, Scorer};
pub use test::{GraspCheck, GraspScratch, GraspTest, Limit};
