//! What the C API needs of the library and the library does not offer yet: answered with "unsupported", never left out.

use std::sync::Arc;

use crate::action::{Action, Grasp};
use crate::error::{Error, Result};
use crate::physics::{self, PhysicsOptions, PushStatus, Scratch, Transition};
use crate::run::Stop;
use crate::scene::{Problem, Scene, State};

fn absent<T>(what: &str) -> Result<T> {
    Err(Error::Unsupported(format!("{what} is not part of this build; see jostle_feature()")))
}

/// The best grasp of a body, if it has one.
pub(super) fn best_grasp(scene: &Scene, state: &State, body: usize) -> Result<Option<Grasp>> {
    let _ = (scene, state, body);
    absent("the grasp test")
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct JudgeOptions {
    pub physics: PhysicsOptions,
    pub friction_spread: f64,
    pub noise_position_m: f64,
    pub noise_rotation_rad: f64,
    pub seed: u64,
}

pub(super) enum Effect {
    Pushed,
    Blocked,
    Grasped,
    Missed,
}

/// The world that actions are executed in.
pub(super) struct Judge {
    nominal: Arc<Scene>,
    engine: Arc<dyn Transition>,
    scratch: Scratch,
    target: usize,
    truth: State,
}

impl Judge {
    pub fn new(problem: &Problem, options: &JudgeOptions, _trial: u64) -> Result<Judge> {
        if options.friction_spread != 0.0 || options.noise_position_m != 0.0 || options.noise_rotation_rad != 0.0 {
            return absent("a simulator with noise");
        }
        let engine = physics::engine(&options.physics, Arc::clone(&problem.scene))?;
        Ok(Judge {
            nominal: Arc::clone(&problem.scene),
            scratch: engine.scratch(),
            engine,
            target: problem.target,
            truth: problem.state.clone(),
        })
    }

    pub fn truth(&self) -> &State {
        &self.truth
    }

    pub fn observe(&mut self) -> State {
        self.truth.clone()
    }

    pub fn target_left(&self) -> bool {
        let pose = self.truth.pose(self.target);
        !self.nominal.workspace().holds(&self.nominal.body(self.target).footprint, &pose)
    }

    pub fn execute(&mut self, action: &Action) -> Result<Effect> {
        let Action::Push(push) = action else {
            let _ = (Effect::Grasped, Effect::Missed);
            return absent("the grasp test");
        };
        let result = self.engine.step(&mut self.scratch, &self.truth, push, &Stop::never());
        match result.status {
            PushStatus::Executed => {
                self.truth = result.state;
                Ok(Effect::Pushed)
            }
            PushStatus::Illegal { .. } => Ok(Effect::Blocked),
            PushStatus::Interrupted => Err(Error::Internal("the engine stopped in mid push".into())),
        }
    }
}
