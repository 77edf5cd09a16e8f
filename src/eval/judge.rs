//! The world that a planner is judged in: not the planner's own model.
//!
//! The judge differs from the planner's model as a real table does: a finer engine, friction that is off by an
//! unknown factor for every body and the tip, and observations with noise. Everything is a function of
//! (seed, the problem's name, trial, step), so a trial can be run again on its own.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::metrics::Effect;
use crate::action::{Action, Grasp, Push};
use crate::error::{Error, Result, check_range};
use crate::geom::Pose2;
use crate::grasp::GraspTest;
use crate::physics::{self, PhysicsOptions, PushStatus, Scratch, Transition};
use crate::run::{Key, Stop};
use crate::scene::{Problem, Scene, State};

/// How the judge's world differs from the planner's model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct JudgeOptions {
    pub physics: PhysicsOptions,
    /// The friction of the tip and of every body is scaled by factors drawn uniformly from 1 - this to 1 + this.
    pub friction_spread: f64,
    /// Standard deviation of each observed coordinate, metres.
    pub noise_position_m: f64,
    /// Standard deviation of each observed heading, radians.
    pub noise_rotation_rad: f64,
    pub seed: u64,
}

impl Default for JudgeOptions {
    fn default() -> Self {
        Self {
            physics: PhysicsOptions::preset("fine"),
            friction_spread: 0.2,
            noise_position_m: 0.001,
            noise_rotation_rad: 1f64.to_radians(),
            seed: 0,
        }
    }
}

impl JudgeOptions {
    /// No noise and no spread: the planner's model, if the engine is the same.
    pub fn exact(physics: PhysicsOptions) -> Self {
        Self { physics, friction_spread: 0.0, noise_position_m: 0.0, noise_rotation_rad: 0.0, seed: 0 }
    }

    pub fn validate(&self) -> Result<()> {
        self.physics.validate().map_err(|e| e.within("judge"))?;
        check_range("judge.friction_spread", self.friction_spread, 0.0..=0.9)?;
        check_range("judge.noise_position_m", self.noise_position_m, 0.0..=0.02)?;
        check_range("judge.noise_rotation_rad", self.noise_rotation_rad, 0.0..=0.5)
    }
}

/// Observations that no perception would report (bodies deep in each other) are drawn again this often at full noise;
/// then the noise shrinks by a tenth with every further draw.
const FULL_NOISE_DRAWS: u64 = 32;

/// The true world of one trial.
pub struct Judge {
    options: JudgeOptions,
    /// The scene as the planner knows it.
    nominal: Arc<Scene>,
    engine: Arc<dyn Transition>,
    scratch: Scratch,
    grasp_test: GraspTest,
    name: String,
    target: usize,
    truth: State,
    key: Key,
    observations: u64,
}

impl Judge {
    /// The world of trial `trial` of a problem.
    pub fn new(problem: &Problem, options: &JudgeOptions, trial: u64) -> Result<Judge> {
        Self::with_engine(problem, options, trial, &|scene| physics::engine(&options.physics, scene))
    }

    /// The same with an engine of the caller's, prepared for the perturbed scene.
    pub fn with_engine(
        problem: &Problem,
        options: &JudgeOptions,
        trial: u64,
        engine: &dyn Fn(Arc<Scene>) -> Result<Arc<dyn Transition>>,
    ) -> Result<Judge> {
        options.validate()?;
        // FNV-1a: cases of a suite get draws of their own, whichever of them are run.
        let name_hash =
            problem.name.bytes().fold(0xcbf2_9ce4_8422_2325u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
        let key = Key::new(options.seed).child(name_hash).child(trial);
        let scene = perturbed(&problem.scene, options.friction_spread, key.child(0));
        let engine = engine(Arc::new(scene))?;
        Ok(Judge {
            options: options.clone(),
            nominal: Arc::clone(&problem.scene),
            scratch: engine.scratch(),
            engine,
            grasp_test: GraspTest::new(&problem.scene),
            name: problem.name.clone(),
            target: problem.target,
            truth: problem.state.clone(),
            key: key.child(1),
            observations: 0,
        })
    }

    /// Where the bodies really are.
    pub fn truth(&self) -> &State {
        &self.truth
    }

    /// The perturbed scene.
    pub fn scene(&self) -> &Scene {
        self.engine.scene()
    }

    /// The target is outside the workspace, by the workspace's rule.
    pub fn target_left(&self) -> bool {
        let pose = self.truth.pose(self.target);
        !self.nominal.workspace().holds(&self.nominal.body(self.target).footprint, &pose)
    }

    /// What a camera reports now: every call draws new noise.
    pub fn observe(&mut self) -> State {
        let key = self.key.child(self.observations);
        self.observations += 1;
        for draw in 0..FULL_NOISE_DRAWS + 40 {
            let scale = 0.9f64.powi(draw.saturating_sub(FULL_NOISE_DRAWS) as i32);
            let observed = self.noisy(key.child(draw), scale);
            if self.nominal.check_state(&observed).is_ok() {
                return observed;
            }
        }
        self.truth.clone()
    }

    /// The problem as observed now.
    pub fn observed_problem(&mut self) -> Problem {
        Problem {
            name: self.name.clone(),
            scene: Arc::clone(&self.nominal),
            state: self.observe(),
            target: self.target,
        }
    }

    fn noisy(&self, key: Key, scale: f64) -> State {
        let position = self.options.noise_position_m * scale;
        let rotation = self.options.noise_rotation_rad * scale;
        let mut observed = self.truth.clone();
        for (i, pose) in self.truth.iter() {
            let mut draw = key.child(i as u64).stream();
            observed.set_pose(
                i,
                Pose2::new(
                    pose.x + position * draw.normal(),
                    pose.y + position * draw.normal(),
                    pose.theta + rotation * draw.normal(),
                ),
            );
        }
        observed
    }

    /// Does it in the true world.
    pub fn execute(&mut self, action: &Action) -> Result<Effect> {
        match action {
            Action::Push(push) => self.push(push),
            Action::Grasp(grasp) => Ok(self.grasp(grasp)),
        }
    }

    fn push(&mut self, push: &Push) -> Result<Effect> {
        let result = self.engine.step(&mut self.scratch, &self.truth, push, &Stop::never());
        match result.status {
            PushStatus::Executed => {
                self.truth = result.state;
                Ok(Effect::Pushed)
            }
            PushStatus::Illegal { .. } => Ok(Effect::Blocked),
            PushStatus::Interrupted => Err(Error::Internal("the judge's engine stopped in mid push".into())),
        }
    }

    /// The grasp was planned for observed poses; it holds if the test passes for it at the true ones.
    fn grasp(&mut self, grasp: &Grasp) -> Effect {
        if grasp.body != self.target || !self.grasp_test.holds(&self.truth, grasp) {
            return Effect::Missed;
        }
        self.truth.set_present(self.target, false);
        Effect::Grasped
    }
}

/// The scene with every friction scaled by a factor of its own.
fn perturbed(scene: &Scene, spread: f64, key: Key) -> Scene {
    let mut draw = key.stream();
    let mut factor = || draw.uniform(1.0 - spread, 1.0 + spread);
    let tip = factor();
    let bodies: Vec<f64> = (0..scene.len()).map(|_| factor()).collect();
    scene.with_scaled_friction(tip, &bodies)
}
