//! Networks held against engines, in scenes and shapes that no training saw.
//!
//! | file | asks |
//! |---|---|
//! | `chain` | where bodies end after several pushes in a row, each predicted on the prediction before |
//! | `grasps` | whether the grasp that a network names holds in an engine with a third dimension |
//! | `classifier` | whether a target can be grasped when a network says so, by geometry and in such an engine |
//!
//! `targets` has the held-out targets of the last two.

mod chain;
mod classifier;
mod grasps;
mod targets;

use std::sync::Arc;

pub use chain::{ChainEngine, ChainParams, ChainReport, ChainStep, chains};
pub use classifier::{Agreement, ClassifierTrials, ReliabilityBin, StatedProbability, try_classifier};
pub use grasps::{GraspTally, GraspTrials, NamedGrasp, try_grasps};
pub use targets::GraspTrialParams;

use super::scenes::{SceneMaker, TrainingScene};
use super::shapes::Split;
use crate::error::{Error, Result};
use crate::physics::Transition;
use crate::run::Key;
use crate::scene::Scene;

/// Makes an engine for a scene.
pub type EngineMaker<'a> = &'a dyn Fn(Arc<Scene>) -> Result<Arc<dyn Transition>>;

/// Scenes looked at for each one that is used, before the parameters are held to be impossible.
const LOOKED_AT: u64 = 400;

/// Held-out scenes of a seed, one after the other.
struct HeldOut {
    maker: SceneMaker,
    root: Key,
    next: u64,
    end: u64,
}

impl HeldOut {
    fn new(maker: SceneMaker, seed: u64, wanted: usize) -> HeldOut {
        HeldOut { maker, root: Key::new(seed), next: 0, end: LOOKED_AT.saturating_mul(wanted as u64) }
    }

    /// The next scene of the split for tests, with a key for what is done in it.
    fn scene(&mut self) -> Result<(TrainingScene, Key)> {
        while self.next < self.end {
            let key = self.root.child(self.next);
            self.next += 1;
            let made = self.maker.scene(key.child(0))?;
            if made.split == Split::Test {
                return Ok((made, key.child(1)));
            }
        }
        Err(Error::State(format!("of {} scenes too few are held out and of use", self.end)))
    }
}

#[cfg(test)]
mod tests;
