//! An engine at the size that its constants were made for.
//!
//! Step lengths, borders, penetrations and the like are lengths that suit the published gripper and blocks. A scene with a
//! gripper of another size ([`crate::scene::Gripper::scale`]) is brought to that size, simulated there, and brought
//! back. Pushing and tipping are quasi-static, so what happens does not depend on the size; where speed counts (a body
//! that is flung in Bullet) it is that of the scene at the published size.

use std::sync::Arc;

use super::approach::Approach;
use super::transition::{GraspResult, GraspStatus, PushJob, PushResult, PushStatus, Scratch, Stance, Transition};
use crate::action::{Grasp, Push};
use crate::run::Stop;
use crate::scene::{Mask, Scene, State};

pub struct Scaled {
    scene: Arc<Scene>,
    /// Prepared for the scene at the published size.
    inner: Arc<dyn Transition>,
    scale: f64,
}

/// Working memory of one thread.
struct Workspace {
    inner: Scratch,
    /// The jobs' states at the published size.
    states: Vec<State>,
}

impl Scaled {
    /// `inner` must be prepared for `scene.scaled(1 / scale)`.
    pub fn new(scene: Arc<Scene>, inner: Arc<dyn Transition>, scale: f64) -> Scaled {
        Scaled { scene, inner, scale }
    }

    fn workspace(&self) -> Workspace {
        Workspace { inner: self.inner.scratch(), states: Vec::new() }
    }

    /// Runs `work` on the scratch, or on a fresh one where it is another engine's.
    fn with<R>(&self, scratch: &mut Scratch, work: impl FnOnce(&mut Workspace) -> R) -> R {
        match scratch.downcast_mut::<Workspace>() {
            Some(own) => work(own),
            None => work(&mut self.workspace()),
        }
    }

    fn brought(&self, state: &State) -> State {
        let mut out = State::default();
        out.scale_from(state, 1.0 / self.scale);
        out
    }

    /// Brings `after`, which came of `within`, back to the size of the scene; what did not move keeps its bits.
    fn bring_back(&self, before: &State, within: &State, after: &mut State) {
        let unmoved = |i: usize| within.poses().get(i) == after.poses().get(i);
        let poses: Vec<_> = (0..after.len())
            .map(|i| if unmoved(i) { before.pose(i) } else { after.pose(i).scaled(self.scale) })
            .collect();
        for (i, pose) in poses.into_iter().enumerate() {
            after.set_pose(i, pose);
        }
    }

    fn finish(&self, job: &PushJob<'_>, within: &State, result: &mut PushResult) {
        match result.status {
            PushStatus::Executed => {
                self.bring_back(job.state, within, &mut result.state);
                result.left = Mask::EMPTY;
                Approach::settle(&self.scene, job, result);
            }
            PushStatus::Illegal { .. } | PushStatus::Unsolved => result.state.clone_from(job.state),
            PushStatus::Interrupted => {}
        }
    }

    fn push(&self, push: &Push) -> Push {
        push.scaled(1.0 / self.scale)
    }
}

impl Transition for Scaled {
    fn name(&self) -> &str {
        self.inner.name()
    }

    fn scene(&self) -> &Scene {
        &self.scene
    }

    fn scratch(&self) -> Scratch {
        Box::new(self.workspace())
    }

    fn batch_size(&self) -> usize {
        self.inner.batch_size()
    }

    fn step_batch(&self, scratch: &mut Scratch, jobs: &[PushJob<'_>], results: &mut [PushResult], stop: &Stop) {
        self.with(scratch, |Workspace { inner, states }| {
            states.resize_with(states.len().max(jobs.len()), State::default);
            for (state, job) in states.iter_mut().zip(jobs) {
                state.scale_from(job.state, 1.0 / self.scale);
            }
            let within: Vec<PushJob<'_>> =
                states.iter().zip(jobs).map(|(state, job)| PushJob { state, push: self.push(&job.push) }).collect();
            self.inner.step_batch(inner, &within, results, stop);
            for ((job, state), result) in jobs.iter().zip(&*states).zip(results) {
                self.finish(job, state, result);
            }
        });
    }

    fn grasp(&self, scratch: &mut Scratch, state: &State, grasp: &Grasp, stop: &Stop) -> Option<GraspResult> {
        let within = self.brought(state);
        let grasp = grasp.scaled(1.0 / self.scale);
        let mut result = self.with(scratch, |memory| self.inner.grasp(&mut memory.inner, &within, &grasp, stop))?;
        if result.status != GraspStatus::Interrupted {
            self.bring_back(state, &within, &mut result.state);
            result.gap *= self.scale;
        }
        Some(result)
    }

    fn step_standing(&self, scratch: &mut Scratch, job: &PushJob<'_>, stances: &[Stance], stop: &Stop) -> PushResult {
        let within = self.brought(job.state);
        let stances: Vec<_> = stances.iter().map(|s| Stance { rise: s.rise / self.scale, ..*s }).collect();
        let inner = PushJob { state: &within, push: self.push(&job.push) };
        let mut result =
            self.with(scratch, |memory| self.inner.step_standing(&mut memory.inner, &inner, &stances, stop));
        self.finish(job, &within, &mut result);
        result
    }
}
