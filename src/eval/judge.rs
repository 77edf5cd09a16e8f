//! The world that a planner is judged in: not the planner's own model.
//!
//! The judge differs from the planner's model as a real table does: a finer engine, friction that is off by an
//! unknown factor for every body and the tip, and observations with noise. Everything is a function of
//! (seed, the problem's name, trial, step), so a trial can be run again on its own.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::metrics::Effect;
use super::robot::{Held, RobotHand, shove};
use crate::action::{Action, Grasp, Push};
use crate::error::{Error, Result, check_range};
use crate::geom::Pose2;
use crate::grasp::Jaw;
use crate::physics::{self, FOLLOW_PATHS, GraspStatus, PhysicsOptions, PushStatus, Scratch, Transition};
use crate::run::{Key, Stop};
use crate::scene::{Clearing, Gripper, Keeping, Problem, Scene, State, TipPath, Uncertainty};

/// What executes actions in a judge's world.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Executor {
    /// A free tip goes straight where it is sent, or as the gripper's path says; the engine's trial of a grasp, or where it has
    /// none geometry, says what is taken.
    #[default]
    Engine,
    /// The recorded robot (docs/robot.md): its tip goes as [`TipPath::ur5e`] says, or the gripper's own path, and its hand
    /// keeps, shoves and loses bodies by the chance that [`Keeping::robotiq_2f85`], or the gripper's own model, gives at
    /// the true poses.
    Robot,
}

/// How the judge's world differs from the planner's model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct JudgeOptions {
    pub physics: PhysicsOptions,
    /// What executes actions in it.
    pub executor: Executor,
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
            executor: Executor::Engine,
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
        let executor = Executor::Engine;
        Self { physics, executor, friction_spread: 0.0, noise_position_m: 0.0, noise_rotation_rad: 0.0, seed: 0 }
    }

    /// How the world differs from what the planner knows of it.
    pub fn uncertainty(&self) -> Uncertainty {
        Uncertainty {
            friction_spread: self.friction_spread,
            position: self.noise_position_m,
            rotation: self.noise_rotation_rad,
            border: 0.0,
        }
    }

    pub fn validate(&self) -> Result<()> {
        self.physics.validate().map_err(|e| e.within("judge"))?;
        if self.executor == Executor::Robot && !FOLLOW_PATHS.contains(&self.physics.engine.as_str()) {
            let known = FOLLOW_PATHS.join(", ");
            let reason =
                format!("is `{}`, which cannot move the tip as the robot does; {known} can", self.physics.engine);
            return Err(Error::argument("judge.physics.engine", reason));
        }
        check_range("judge.friction_spread", self.friction_spread, 0.0..=0.9)?;
        check_range("judge.noise_position_m", self.noise_position_m, 0.0..=0.02)?;
        check_range("judge.noise_rotation_rad", self.noise_rotation_rad, 0.0..=0.5)
    }
}

/// The true world of one trial.
pub struct Judge {
    options: JudgeOptions,
    /// The scene as the planner knows it.
    nominal: Arc<Scene>,
    engine: Arc<dyn Transition>,
    scratch: Scratch,
    jaw: Jaw,
    /// Of the same measures, with the chance that it keeps what it grasps.
    hand: Jaw,
    /// Which executes grasps, where the robot does.
    robot: Option<RobotHand>,
    name: String,
    /// The body to be retrieved; where there is none, any pickable body may be taken.
    target: Option<usize>,
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
        let Problem { name, scene, state, target } = problem;
        Self::of(name, scene, state, Some(*target), options, trial, engine)
    }

    /// The world of trial `trial` of a table to be cleared: any pickable body may be taken from it.
    pub fn of_clearing(problem: &Clearing, options: &JudgeOptions, trial: u64) -> Result<Judge> {
        Self::of_clearing_with_engine(problem, options, trial, &|scene| physics::engine(&options.physics, scene))
    }

    /// The same with an engine of the caller's, prepared for the perturbed scene.
    pub fn of_clearing_with_engine(
        problem: &Clearing,
        options: &JudgeOptions,
        trial: u64,
        engine: &dyn Fn(Arc<Scene>) -> Result<Arc<dyn Transition>>,
    ) -> Result<Judge> {
        Self::of(&problem.name, &problem.scene, &problem.state, None, options, trial, engine)
    }

    fn of(
        name: &str,
        nominal: &Arc<Scene>,
        state: &State,
        target: Option<usize>,
        options: &JudgeOptions,
        trial: u64,
        engine: &dyn Fn(Arc<Scene>) -> Result<Arc<dyn Transition>>,
    ) -> Result<Judge> {
        options.validate()?;
        // FNV-1a: cases of a suite get draws of their own, whichever of them are run.
        let name_hash =
            name.bytes().fold(0xcbf2_9ce4_8422_2325u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
        let key = Key::new(options.seed).child(name_hash).child(trial);
        let mut scene = options.uncertainty().scene(nominal, key.child(0));
        let gripper = scene.gripper().clone();
        if options.executor == Executor::Robot && gripper.path.is_none() {
            let path = Some(TipPath::ur5e().scaled(gripper.scale()));
            scene = scene.with_gripper(Gripper { path, ..gripper })?;
        }
        let engine = engine(Arc::new(scene))?;
        Ok(Judge {
            options: options.clone(),
            nominal: Arc::clone(nominal),
            scratch: engine.scratch(),
            engine,
            jaw: Jaw::new(nominal)?,
            hand: hand(nominal, options.executor)?,
            robot: (options.executor == Executor::Robot).then(|| RobotHand::new(key.child(2))),
            name: name.to_owned(),
            target,
            truth: state.clone(),
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

    /// The target, or where there is none any body, is outside the workspace, by the workspace's rule.
    pub fn target_left(&self) -> bool {
        self.truth.iter().any(|(i, pose)| {
            self.target.is_none_or(|target| target == i)
                && !self.nominal.workspace().holds(&self.nominal.body(i).footprint, &pose)
        })
    }

    /// What a camera reports now: every call draws new noise.
    pub fn observe(&mut self) -> State {
        let key = self.key.child(self.observations);
        self.observations += 1;
        self.options.uncertainty().state(&self.nominal, &self.truth, key)
    }

    /// The problem as observed now, of a retrieval (a clearing has no target: [`Clearing::at`] what was observed).
    pub fn observed_problem(&mut self) -> Problem {
        Problem {
            name: self.name.clone(),
            scene: Arc::clone(&self.nominal),
            state: self.observe(),
            target: self.target.unwrap_or_default(),
        }
    }

    /// The chance that a real hand keeps what a grasp takes at the true poses ([`super::Decision::chance`]); none for a push.
    pub fn chance(&mut self, action: &Action) -> Option<f64> {
        match action {
            Action::Grasp(grasp) => Some(self.hand.chance(&self.truth, grasp)),
            Action::Push(_) => None,
        }
    }

    /// Does it in the true world.
    pub fn execute(&mut self, action: &Action) -> Result<Effect> {
        let effect = self.execute_until(action, &Stop::never())?;
        effect.ok_or_else(|| Error::Internal("the judge's engine stopped in mid action".into()))
    }

    /// The same until the stop is requested: then nothing was done, and there is no effect.
    pub fn execute_until(&mut self, action: &Action, stop: &Stop) -> Result<Option<Effect>> {
        action.validate()?;
        match action {
            Action::Push(push) => Ok(self.push(push, stop)),
            Action::Grasp(grasp) => Ok(self.grasp(grasp, stop)),
        }
    }

    fn push(&mut self, push: &Push, stop: &Stop) -> Option<Effect> {
        let result = self.engine.step(&mut self.scratch, &self.truth, push, stop);
        match result.status {
            PushStatus::Executed => {
                self.truth = result.state;
                Some(if result.toppled.is_empty() { Effect::Pushed } else { Effect::Toppled })
            }
            PushStatus::Illegal { .. } | PushStatus::Unsolved => Some(Effect::Blocked),
            PushStatus::Interrupted => None,
        }
    }

    /// The grasp was planned for observed poses. An engine that executes grasps says what was lifted, and only the target
    /// alone counts, or where there is none the body that the grasp was for; in any other the grasp holds if the geometric test passes for it at the true poses.
    fn grasp(&mut self, grasp: &Grasp, stop: &Stop) -> Option<Effect> {
        if self.robot.is_some() {
            return Some(self.grasp_by_robot(grasp));
        }
        let Some(result) = self.engine.grasp(&mut self.scratch, &self.truth, grasp, stop) else {
            if !self.wanted(grasp.body) || !self.jaw.holds(&self.truth, grasp) {
                return Some(Effect::Missed);
            }
            self.truth.set_present(grasp.body, false);
            return Some(Effect::Grasped);
        };
        if result.status == GraspStatus::Interrupted {
            return None;
        }
        let taken = self.wanted(grasp.body) && result.took(grasp.body);
        // What was taken wrongly lies where the fingers let go of it. A pose in the plane cannot say how a fallen body
        // lies: then everything is put back.
        if taken || result.toppled.is_empty() && result.state.present() == self.truth.present() {
            self.truth = result.state;
        }
        Some(if taken { Effect::Grasped } else { Effect::Missed })
    }
}

/// The scene's jaw as a hand that may lose what it grasps.
fn hand(scene: &Scene, executor: Executor) -> Result<Jaw> {
    let gripper = scene.gripper();
    let own = gripper.keeping.clone().filter(|_| executor == Executor::Robot);
    let keeping = Some(own.unwrap_or_else(|| Keeping::robotiq_2f85().scaled(gripper.scale())));
    Jaw::new(&scene.with_gripper(Gripper { keeping, ..gripper.clone() })?)
}

impl Judge {
    /// The robot's hand knows nothing of what the fingers do to other bodies; a body that it shoves stays on the table.
    fn grasp_by_robot(&mut self, grasp: &Grasp) -> Effect {
        let body = grasp.body;
        let chance = if self.wanted(body) { self.hand.chance_if_tried(&self.truth, grasp) } else { 0.0 };
        let Some(robot) = &mut self.robot else { return Effect::Missed };
        match robot.attempt(body, chance) {
            Held::Kept => {
                self.truth.set_present(body, false);
                return Effect::Grasped;
            }
            _ if !self.truth.is_present(body) => {}
            Held::Slipped(motion) => {
                let motion = motion.scaled(self.nominal.gripper().scale());
                shove(&self.nominal, &mut self.truth, body, &motion);
            }
            Held::Lost(motion) => {
                let (pose, motion) = (self.truth.pose(body), motion.scaled(self.nominal.gripper().scale()));
                self.truth.set_pose(body, Pose2::new(pose.x + motion.x, pose.y + motion.y, pose.theta + motion.theta));
            }
        }
        Effect::Missed
    }

    /// The body may be taken.
    fn wanted(&self, body: usize) -> bool {
        match self.target {
            Some(target) => body == target,
            None => self.truth.is_present(body) && self.nominal.bodies().get(body).is_some_and(|b| b.pickable),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Claw, Slide, row, squeeze};
    use super::*;
    use crate::geom::vec2;
    use crate::physics::GraspResult;
    use crate::scene::Mask;

    fn judge(options: &JudgeOptions, trial: u64) -> Judge {
        let engine = |scene| Ok(Arc::new(Slide { scene, offset: Pose2::new(0.03, 0.0, 0.0) }) as Arc<dyn Transition>);
        Judge::with_engine(&row(), options, trial, &engine).unwrap()
    }

    #[test]
    fn a_trial_is_the_same_again_and_different_from_others() {
        let options = JudgeOptions::default();
        let (mut a, mut b) = (judge(&options, 0), judge(&options, 0));
        assert_eq!(a.scene(), b.scene());
        let first = a.observe();
        assert_eq!(first, b.observe());
        assert_ne!(first, a.observe(), "every look is another one");
        let mut other = judge(&options, 1);
        assert_ne!(first, other.observe());
        assert_ne!(a.scene().friction(), other.scene().friction());
        let mut reseeded = judge(&JudgeOptions { seed: 1, ..options.clone() }, 0);
        assert_ne!(first, reseeded.observe());
        let renamed = Problem { name: "other".into(), ..row() };
        let engine = |scene| Ok(Arc::new(Slide { scene, offset: Pose2::IDENTITY }) as Arc<dyn Transition>);
        assert_ne!(first, Judge::with_engine(&renamed, &options, 0, &engine).unwrap().observe());
    }

    #[test]
    fn what_was_observed_does_not_depend_on_what_was_done() {
        let (mut a, mut b) = (judge(&JudgeOptions::default(), 3), judge(&JudgeOptions::default(), 3));
        a.observe();
        b.observe();
        b.execute(&Action::Push(Push::new(vec2(0.4, 0.0), vec2(0.45, 0.0)))).unwrap();
        let (a, b) = (a.observe(), b.observe());
        assert_eq!(a.pose(1), b.pose(1));
        assert!((b.pose(0).x - a.pose(0).x - 0.03).abs() < 1e-6, "the same noise on a moved body");
    }

    #[test]
    fn friction_and_noise_are_as_wide_as_asked() {
        let options = JudgeOptions { noise_rotation_rad: 0.0, ..JudgeOptions::default() };
        let nominal = row();
        let (mut sum, mut n, mut least, mut greatest) = (0.0, 0.0, f64::MAX, f64::MIN);
        for trial in 0..200 {
            let mut judge = judge(&options, trial);
            let factor = judge.scene().body(0).friction / nominal.scene.body(0).friction;
            (least, greatest) = (f64::min(least, factor), f64::max(greatest, factor));
            for (i, pose) in judge.observe().iter() {
                assert_eq!(pose.theta, nominal.state.pose(i).theta);
                sum += (pose.x - nominal.state.pose(i).x).powi(2);
                n += 1.0;
            }
        }
        assert!((0.8..0.82).contains(&least) && (1.18..=1.2).contains(&greatest), "{least} {greatest}");
        let sd = f64::sqrt(sum / n);
        assert!((sd - 0.001).abs() < 1.5e-4, "{sd}");
    }

    #[test]
    fn the_exact_judge_is_the_model() {
        let mut judge = judge(&JudgeOptions::exact(PhysicsOptions::default()), 0);
        assert_eq!(judge.observe(), row().state);
        assert_eq!(*judge.scene(), *row().scene);
    }

    #[test]
    fn a_push_onto_a_body_is_blocked_and_moves_nothing() {
        let mut judge = Judge::new(&row(), &JudgeOptions::default(), 0).unwrap();
        let before = judge.truth().clone();
        let onto = Push::new(vec2(0.5, 0.0), vec2(0.6, 0.0));
        assert_eq!(judge.execute(&Action::Push(onto)).unwrap(), Effect::Blocked);
        assert_eq!(*judge.truth(), before);
        let beside = Push::new(vec2(0.44, 0.0), vec2(0.52, 0.0));
        assert_eq!(judge.execute(&Action::Push(beside)).unwrap(), Effect::Pushed);
        assert!(judge.truth().pose(0).x > before.pose(0).x + 0.01);
    }

    #[test]
    fn a_grasp_holds_at_the_true_poses_or_not_at_all() {
        let mut judge = judge(&JudgeOptions::default(), 0);
        let problem = row();
        let good = squeeze(&problem, [0.5, 0.0]);
        let beside = squeeze(&problem, [0.5, 0.06]);
        assert_eq!(judge.execute(&Action::Grasp(beside)).unwrap(), Effect::Missed);
        assert_eq!(judge.execute(&Action::Grasp(Grasp { body: 1, ..good })).unwrap(), Effect::Missed);
        assert!(judge.truth().is_present(0));
        assert_eq!(judge.execute(&Action::Grasp(good)).unwrap(), Effect::Grasped);
        assert!(!judge.truth().is_present(0));
    }

    #[test]
    fn an_engine_that_grasps_decides_and_only_the_target_alone_counts() {
        let problem = row();
        // Geometry would refuse this grasp, and accept the other.
        let (beside, good) = (squeeze(&problem, [0.5, 0.06]), squeeze(&problem, [0.5, 0.0]));
        let executed = |held, lifted| GraspResult { held, lifted: Mask::from(lifted), ..GraspResult::default() };
        let blocked = GraspResult { status: GraspStatus::Blocked { body: Some(1) }, ..GraspResult::default() };
        for (result, grasp, wanted) in [
            (executed(Some(0), 0b01), beside, Effect::Grasped),
            (executed(Some(1), 0b10), good, Effect::Missed),
            (executed(Some(0), 0b11), good, Effect::Missed),
            (executed(None, 0b01), good, Effect::Missed),
            (executed(None, 0), good, Effect::Missed),
            (blocked, good, Effect::Missed),
            (executed(Some(0), 0b01), Grasp { body: 1, ..good }, Effect::Missed),
        ] {
            let engine = |scene| Ok(Arc::new(Claw { scene, result: result.clone() }) as Arc<dyn Transition>);
            let mut judge = Judge::with_engine(&problem, &JudgeOptions::default(), 0, &engine).unwrap();
            assert_eq!(judge.execute(&Action::Grasp(grasp)).unwrap(), wanted, "{result:?}");
            assert_eq!(judge.truth().is_present(0), wanted == Effect::Missed);
        }
        let result = GraspResult { status: GraspStatus::Interrupted, ..GraspResult::default() };
        let engine = |scene| Ok(Arc::new(Claw { scene, result: result.clone() }) as Arc<dyn Transition>);
        let mut judge = Judge::with_engine(&problem, &JudgeOptions::default(), 0, &engine).unwrap();
        assert!(judge.execute(&Action::Grasp(good)).is_err());
    }

    #[test]
    fn bad_options_are_named() {
        let bad = JudgeOptions { friction_spread: 1.5, ..JudgeOptions::default() };
        assert!(bad.validate().unwrap_err().to_string().starts_with("judge.friction_spread"));
        let bad = JudgeOptions { physics: PhysicsOptions::preset("finest"), ..JudgeOptions::default() };
        assert!(bad.validate().unwrap_err().to_string().starts_with("judge.physics.preset"));
    }
}
