//! How good states are.

use std::any::Any;

use serde::{Deserialize, Serialize};

use super::failed::FailedGrasp;
use super::params::GraspParams;
use super::test::{GraspScratch, GraspTest, Unholdable};
use crate::action::Grasp;
use crate::error::Result;
use crate::run::Stop;
use crate::scene::{Scene, State};

/// What a scorer says of a state.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct GraspAssessment {
    /// The best grasp of the target, if there is one.
    pub grasp: Option<Grasp>,
    /// Expected quality of the best grasp in [0, 1]; 0 without one.
    pub score: f64,
    /// 1 with a grasp; without, in [0, 1) and the greater the less is in the way: it ranks states that are not
    /// graspable yet. 0 for a body that no state makes graspable.
    pub nearness: f64,
}

/// Says how good states are for retrieving a target. Batch-first: networks want many states at once.
///
/// Thread rule: shared freely between threads; one scratch is used by one thread at a time. An assessment depends on
/// the scene, the state and the target only.
pub trait Scorer: Send + Sync {
    /// Name for reports.
    fn name(&self) -> &str;

    /// Working memory for one thread.
    fn scratch(&self) -> Box<dyn Any + Send>;

    /// Assesses `states[i]` into `out[i]`, as many as both hold. The states must belong to `scene`. A requested stop leaves the
    /// rest as it was: whoever has a stop asks it afterwards.
    fn assess(
        &self,
        scratch: &mut (dyn Any + Send),
        scene: &Scene,
        states: &[&State],
        target: usize,
        out: &mut [GraspAssessment],
        stop: &Stop,
    );

    /// The same scorer that believes less in grasps like these; none where it cannot tell one grasp from another.
    fn avoiding(&self, _failed: &[FailedGrasp]) -> Option<Box<dyn Scorer>> {
        None
    }

    /// The greatest score that the body has in any state of the scene, where that is known.
    fn greatest_score(&self, _scene: &Scene, _body: usize) -> Option<f64> {
        None
    }

    /// Why no state of the scene has a grasp of the body, where that is known.
    fn unholdable(&self, _scene: &Scene, _body: usize) -> Option<Unholdable> {
        None
    }
}

/// The geometric grasp test as a scorer.
#[derive(Debug, Clone)]
pub struct GeometricScorer {
    test: GraspTest,
}

impl GeometricScorer {
    /// Prepared for a scene; it stays right for others, and slow.
    pub fn new(scene: &Scene, params: GraspParams) -> Result<Self> {
        Ok(Self { test: GraspTest::new(params)?.prepared(scene) })
    }

    /// The test behind it.
    pub fn test(&self) -> &GraspTest {
        &self.test
    }
}

impl Scorer for GeometricScorer {
    fn avoiding(&self, failed: &[FailedGrasp]) -> Option<Box<dyn Scorer>> {
        Some(Box::new(Self { test: self.test.avoiding(failed) }))
    }

    fn unholdable(&self, scene: &Scene, body: usize) -> Option<Unholdable> {
        self.test.unholdable(scene, body)
    }

    fn greatest_score(&self, scene: &Scene, body: usize) -> Option<f64> {
        self.test.greatest_score(scene, body)
    }

    fn name(&self) -> &str {
        "geometric"
    }

    fn scratch(&self) -> Box<dyn Any + Send> {
        Box::new(GraspScratch::default())
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
        // Another scorer's scratch is of no use; it must not be a reason to fail.
        let mut fresh = GraspScratch::default();
        let scratch = scratch.downcast_mut::<GraspScratch>().unwrap_or(&mut fresh);
        for (state, out) in states.iter().zip(out) {
            if stop.requested() {
                return;
            }
            *out = self.test.assess(scene, state, target, scratch);
        }
    }
}
