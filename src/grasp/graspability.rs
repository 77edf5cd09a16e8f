//! A network that says whether the target can be grasped (kind `gc`), as a scorer.

use std::any::Any;
use std::sync::Arc;

use super::params::GraspParams;
use super::scorer::{GraspAssessment, Scorer};
use super::test::{GraspScratch, GraspTest, Unholdable};
use crate::error::Result;
use crate::net::{ImageScratch, TargetProbability};
use crate::run::Stop;
use crate::scene::{Scene, State};

/// Nearness of a state that the network would grasp although no grasp is found, and the bound of all that it would not.
const NEAREST: f64 = 0.999;

/// Scores a state by the probability that the target can be grasped.
///
/// From the network's threshold on the grasp itself comes from the geometric test, as the network names none, and is given
/// the probability as its score. Below it there is no grasp, and the nearness is the probability's share of the threshold.
/// A network that cannot be run after it was loaded scores 0.
pub struct GraspabilityScorer {
    network: Arc<dyn TargetProbability>,
    test: GraspTest,
}

#[derive(Default)]
struct Memory {
    image: ImageScratch,
    grasp: GraspScratch,
}

impl GraspabilityScorer {
    /// Prepared for a scene; it stays right for others, and slow. `network` is a [`crate::net::Gc`], or a stand-in.
    pub fn new(scene: &Scene, network: Arc<dyn TargetProbability>) -> Result<Self> {
        Ok(Self { network, test: GraspTest::new(GraspParams::default())?.prepared(scene) })
    }

    fn one(&self, memory: &mut Memory, scene: &Scene, state: &State, target: usize, stop: &Stop) -> GraspAssessment {
        let possible = target < scene.len() && state.is_present(target) && scene.body(target).pickable;
        let probability = match possible {
            true => self.network.probability(&mut memory.image, scene, state, target, stop).unwrap_or(0.0),
            false => 0.0,
        };
        let threshold = self.network.threshold();
        if probability < threshold {
            let nearness = NEAREST * probability / threshold;
            return GraspAssessment { grasp: None, score: 0.0, nearness };
        }
        match self.test.best(scene, state, target, &mut memory.grasp) {
            Some(mut grasp) => {
                grasp.score = probability;
                GraspAssessment { grasp: Some(grasp), score: probability, nearness: 1.0 }
            }
            None => GraspAssessment { grasp: None, score: 0.0, nearness: if possible { NEAREST } else { 0.0 } },
        }
    }
}

impl Scorer for GraspabilityScorer {
    fn unholdable(&self, scene: &Scene, body: usize) -> Option<Unholdable> {
        self.test.unholdable(scene, body)
    }

    fn name(&self) -> &str {
        "gc"
    }

    fn scratch(&self) -> Box<dyn Any + Send> {
        Box::<Memory>::default()
    }

    fn assess(
        &self,
        scratch: &mut (dyn Any + Send),
        scene: &Scene,
        states: &[&State],
        target: usize,
        out: &mut [GraspAssessment],
        stop: &Stop,
    ) {
        let mut fresh = Memory::default();
        let memory = scratch.downcast_mut::<Memory>().unwrap_or(&mut fresh);
        for (state, out) in states.iter().zip(out) {
            if stop.requested() {
                return;
            }
            let found = self.one(memory, scene, state, target, stop);
            // A network that was interrupted has said nothing.
            if stop.requested() {
                return;
            }
            *out = found;
        }
    }
}
