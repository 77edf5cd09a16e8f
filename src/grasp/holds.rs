//! Whether a commanded grasp holds at the true poses.

use super::{GraspParams, GraspScratch, GraspTest};
use crate::action::Grasp;
use crate::error::Result;
use crate::scene::{Scene, State};

/// The library's grasp rule without the planner's safety distances: a finger may come down as near to a body as it
/// likes, but not on it, and the target must pass between the pads. What else the rule asks for (nothing foreign
/// between the pads, enough cover, gripped faces near parallel) holds unchanged.
pub struct Jaw {
    scene: Scene,
    test: GraspTest,
    scratch: GraspScratch,
}

impl Jaw {
    pub fn new(scene: &Scene) -> Result<Jaw> {
        let mut gripper = scene.gripper().clone();
        gripper.grasp.finger_clearance = 0.0;
        gripper.grasp.fit = 0.0;
        Ok(Jaw {
            scene: scene.with_gripper(gripper)?,
            test: GraspTest::new(GraspParams::default())?,
            scratch: GraspScratch::default(),
        })
    }

    pub fn holds(&mut self, state: &State, grasp: &Grasp) -> bool {
        self.test.check(&self.scene, state, grasp, &mut self.scratch).holds()
    }

    /// The chance that the target is kept: 0 where the grasp does not hold; 1 where it does, for a gripper without a model
    /// of that.
    pub fn chance(&mut self, state: &State, grasp: &Grasp) -> f64 {
        let check = self.test.check(&self.scene, state, grasp, &mut self.scratch);
        if check.holds() { check.chance.unwrap_or(1.0) } else { 0.0 }
    }

    /// The chance that the target is kept, also where the rule of what is allowed forbids the grasp: 0 where the jaw would
    /// not touch it, or for a gripper without a model of that.
    pub fn chance_if_tried(&mut self, state: &State, grasp: &Grasp) -> f64 {
        self.test.check(&self.scene, state, grasp, &mut self.scratch).chance.unwrap_or(0.0)
    }
}
