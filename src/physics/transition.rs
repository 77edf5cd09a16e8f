//! One interface for every model of what a push does.

use std::any::Any;

use crate::action::{Grasp, Push};
use crate::run::Stop;
use crate::scene::{Mask, Scene, State};

/// Working memory of an engine for one thread. Made by [`Transition::scratch`]; opaque to the caller.
pub type Scratch = Box<dyn Any + Send>;

/// A push to be executed from a state.
#[derive(Debug, Clone, Copy)]
pub struct PushJob<'a> {
    pub state: &'a State,
    pub push: Push,
}

/// How a push ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PushStatus {
    /// Executed; the state is the world afterwards.
    #[default]
    Executed,
    /// The tip would come down on this body (or the push is not finite or of no length: `None`);
    /// nothing was executed and the state is the one before.
    Illegal { body: Option<usize> },
    /// The engine could not solve the push, as a body is far too light between others: the tip or a body came deeper into
    /// a body than [`DEEPEST`] allows, or a body was thrown farther than a push carries it. Nothing was executed and the state is the one before.
    Unsolved,
    /// The stop was requested before the end; the state is not to be used.
    Interrupted,
}

/// No executed push ends with the tip or a body deeper in a body than this, by the outlines without any borders, metres.
/// (Bullet's steps, and what a network says of two bodies, are checked for the tip only.) An engine of steps also gives up
/// where one of them begins deeper by its travel.
pub const DEEPEST: f64 = 0.002;

/// What a push did.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PushResult {
    pub status: PushStatus,
    pub state: State,
    /// Bodies that the tip touched.
    pub touched: Mask,
    /// Bodies that are outside the workspace now and were inside before, by the workspace's rule
    /// (for all bodies: the planner applies the scope).
    pub left: Mask,
    /// Bodies that lean, lie or stand on others afterwards (they were upright before). Planar engines report none.
    pub toppled: Mask,
}

impl PushResult {
    /// The engine does not say what the push does in the end: it could not solve it, or a body toppled.
    pub fn leaves_open(&self) -> bool {
        self.status == PushStatus::Unsolved || !self.toppled.is_empty()
    }

    /// What became of a push that could not be solved: nothing.
    pub(super) fn take_back(&mut self, before: &State) {
        self.state.clone_from(before);
        (self.touched, self.left, self.toppled) = (Mask::EMPTY, Mask::EMPTY, Mask::EMPTY);
        self.status = PushStatus::Unsolved;
    }
}

/// How a grasp ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GraspStatus {
    /// The fingers came down, closed and lifted.
    #[default]
    Executed,
    /// A finger came down on this body (`None`: on something else, or the grasp is not finite); nothing was lifted.
    Blocked { body: Option<usize> },
    /// The stop was requested before the end; the result is not to be used.
    Interrupted,
}

/// What a grasp did.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GraspResult {
    pub status: GraspStatus,
    /// The body that hangs between the pads, if one does.
    pub held: Option<usize>,
    /// Every body that rose with the fingers, held or not.
    pub lifted: Mask,
    /// Distance of the pads in the end, metres.
    pub gap: f64,
    /// The world afterwards: without the body that is held, if nothing else was lifted; else the fingers have let go.
    pub state: State,
    /// Bodies that lean, lie or stand on others afterwards.
    pub toppled: Mask,
}

impl GraspResult {
    /// This body, and nothing else, was taken.
    pub fn took(&self, body: usize) -> bool {
        self.status == GraspStatus::Executed && self.held == Some(body) && self.lifted.iter().eq([body])
    }
}

/// How a body stands at the start of a push: what a pose in the plane does not say. Flat on the ground by default.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stance {
    /// The body leans by a turn about this horizontal axis of the world frame, whose length is the angle in radians.
    pub lean: [f64; 2],
    /// How far the body's centre lies above where it rests when it stands flat, metres.
    pub rise: f64,
}

/// A model of what a push does to every body, prepared for one scene.
///
/// Batch-first: an engine may run the jobs of a call side by side, and the result of a job must not depend on the
/// others, on what ran before on the same scratch, or on the thread: the same state and push give the same bits.
///
/// Thread rule: shared freely between threads; one scratch is used by one thread at a time.
pub trait Transition: Send + Sync {
    /// Name and settings for reports, such as `rapier balanced`.
    fn name(&self) -> &str;

    /// The scene it was prepared for.
    fn scene(&self) -> &Scene;

    /// Working memory for one thread.
    fn scratch(&self) -> Scratch;

    /// How many jobs a call should have for the engine to be at its best.
    fn batch_size(&self) -> usize {
        1
    }

    /// Executes `jobs[i]` into `results[i]`. A requested stop leaves the rest `Interrupted` within a physics slice
    /// (well under a millisecond). `results` keeps its memory between calls.
    fn step_batch(&self, scratch: &mut Scratch, jobs: &[PushJob<'_>], results: &mut [PushResult], stop: &Stop);

    /// Executes a grasp of the scene's gripper: down, close, lift. `None` from an engine without a third dimension, whose
    /// user has to judge grasps by geometry.
    fn grasp(&self, scratch: &mut Scratch, state: &State, grasp: &Grasp, stop: &Stop) -> Option<GraspResult> {
        let _ = (scratch, state, grasp, stop);
        None
    }

    /// One push of bodies that stand as `stances` says (one for each body of the scene). Planar engines know no stance.
    fn step_standing(&self, scratch: &mut Scratch, job: &PushJob<'_>, _stances: &[Stance], stop: &Stop) -> PushResult {
        self.step(scratch, job.state, &job.push, stop)
    }

    /// One push on its own.
    fn step(&self, scratch: &mut Scratch, state: &State, push: &Push, stop: &Stop) -> PushResult {
        let mut result = [PushResult::default()];
        self.step_batch(scratch, &[PushJob { state, push: *push }], &mut result, stop);
        let [result] = result;
        result
    }
}
