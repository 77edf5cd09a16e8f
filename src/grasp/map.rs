//! A network that finds grasps (kind `gn`), as a scorer.

use std::any::Any;
use std::sync::Arc;

use super::params::GraspParams;
use super::scorer::{GraspAssessment, Scorer};
use super::test::{GraspScratch, GraspTest};
use crate::action::Grasp;
use crate::error::Result;
use crate::net::{GraspMap, ImageScratch, MapGrasp};
use crate::run::Stop;
use crate::scene::{Scene, State};

/// Bound of the nearness where no grasp counts.
const NEAREST: f64 = 0.999;
/// Grasps of the map that are examined until one keeps its clearances.
const EXAMINED: usize = 32;

/// Scores a state by the best grasp of the target in the network's map, as the map has it: where the best cell is, with
/// the gripper fully open.
///
/// Below the network's threshold there is no grasp, and the nearness is the quality's share of the threshold. With
/// [`checked`](Self::checked) the best grasp counts whose fingers keep their clearances by the geometric rule. A network that
/// cannot be run after it was loaded scores 0.
pub struct MapScorer {
    network: Arc<dyn GraspMap>,
    test: GraspTest,
    checked: bool,
}

#[derive(Default)]
struct Memory {
    image: ImageScratch,
    grasp: GraspScratch,
    found: Vec<MapGrasp>,
}

impl MapScorer {
    /// `network` is a [`crate::net::Gn`], or a stand-in.
    pub fn new(network: Arc<dyn GraspMap>) -> Result<Self> {
        Ok(Self { network, test: GraspTest::new(GraspParams::default())?, checked: false })
    }

    /// The same that offers only grasps whose fingers keep their clearances.
    #[must_use]
    pub fn checked(self) -> Self {
        Self { checked: true, ..self }
    }

    fn one(&self, memory: &mut Memory, scene: &Scene, state: &State, target: usize, stop: &Stop) -> GraspAssessment {
        let none = GraspAssessment::default();
        if target >= scene.len() || !state.is_present(target) || !scene.body(target).pickable {
            return none;
        }
        let Memory { image, grasp: scratch, found } = memory;
        let most = if self.checked { EXAMINED } else { 1 };
        if self.network.best(image, scene, state, target, most, found, stop).is_err() {
            return none;
        }
        let threshold = self.network.threshold();
        let nearness = |quality: f64| NEAREST * (quality / threshold).min(1.0);
        for best in found.iter().take_while(|best| best.quality >= threshold) {
            let mut grasp = Grasp {
                body: target,
                position: [best.position.x, best.position.y],
                angle: best.angle,
                opening: scene.gripper().grasp.opening,
                width: 0.0,
                margin: 0.0,
                score: best.quality,
            };
            let check = self.test.check(scene, state, &grasp, scratch);
            if self.checked && !check.holds() {
                continue;
            }
            (grasp.width, grasp.margin) = (check.width, check.margin);
            return GraspAssessment { grasp: Some(grasp), score: best.quality, nearness: 1.0 };
        }
        let quality = found.first().map_or(0.0, |best| best.quality);
        GraspAssessment { nearness: nearness(quality), ..none }
    }
}

impl Scorer for MapScorer {
    fn name(&self) -> &str {
        "gn"
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
