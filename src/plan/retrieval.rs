//! Target retrieval as a search domain: states of the scene, pushes between them, a grasp of the target at the end.

use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::failures::FailedPushes;
use super::options::GraspDecision;
use crate::action::{Push, PushSampler, SamplerScratch};
use crate::geom::normalize_angle;
use crate::grasp::{FailedGrasp, GraspAssessment, Scorer};
use crate::net::{PushValue, PushValueScratch};
use crate::physics::{PushJob, PushResult, PushStatus, Scratch as EngineScratch, Transition};
use crate::run::{Key, Stop};
use crate::scene::{LeaveScope, Scene, State};
use crate::search::{Candidate, Domain, Job, Outcome, Status};

/// What a state is worth: `shaping * q + [q >= solved]`, with `q` the scorer's judgement in [0, 1]
/// (MORE: delta = 0.2; PMBS, published code: 0.1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reward {
    /// Weight of the judgement itself: tells good pushes from bad ones before a grasp is in sight.
    pub shaping: f64,
    /// A state whose grasp scores at least this is a solution.
    pub solved_score: f64,
}

/// A push that moves no body by more than this (metres, for the published gripper; radians) is dropped: it leads back to
/// where it began.
const IDLE: (f64, f64) = (0.002, 0.035);

/// The parts of a retrieval planner, prepared for one scene and target.
pub struct Retrieval {
    pub scene: Arc<Scene>,
    pub target: usize,
    pub engine: Arc<dyn Transition>,
    pub sampler: Box<dyn PushSampler>,
    pub scorer: Box<dyn Scorer>,
    /// Takes the scorer's place for the present state where a grasp has failed in it: once something was pushed there is less
    /// to doubt.
    pub present: Option<Box<dyn Scorer>>,
    /// What is expected of pushes before they are tried.
    pub prior: Option<Arc<dyn PushValue>>,
    pub reward: Reward,
    /// When a grasp is executed.
    pub grasp: GraspDecision,
    /// A grasp has to score at least this as well: more than one that was tried and failed. 0 asks for nothing more.
    pub demand: f64,
    /// Pushes that failed where the bodies are now; not proposed at the root.
    pub failed: FailedPushes,
    /// The engine left open what a push does.
    pub unsolved: AtomicBool,
}

/// Where grasps failed and what is asked follows the best that a body has, it falls to no less than this share of what is
/// asked usually: then the body is pushed.
const LEAST_WHERE_FAILED: f64 = 0.5;

/// However good a grasp was that failed, a simulated state whose grasp scores this much is a solution.
const GREATEST_DEMAND: f64 = 0.9;

/// Working memory of one worker.
pub struct Scratch {
    engine: EngineScratch,
    scorer: Box<dyn Any + Send>,
    sampler: SamplerScratch,
    prior: PushValueScratch,
    values: Vec<f32>,
    results: Vec<PushResult>,
    pushes: Vec<Push>,
}

impl Retrieval {
    pub fn new_scratch(&self) -> Scratch {
        Scratch {
            engine: self.engine.scratch(),
            scorer: self.scorer.scratch(),
            sampler: SamplerScratch::default(),
            prior: PushValueScratch::default(),
            values: Vec::new(),
            results: Vec::new(),
            pushes: Vec::new(),
        }
    }

    /// Believes less in grasps like those that failed: as much less in the present state, and by half once something was
    /// pushed. `thresholds` says what is asked of a grasp by a scorer. Nothing changes where the scorer cannot tell one
    /// grasp from another.
    pub(super) fn doubt(
        &mut self,
        failed: &[FailedGrasp],
        thresholds: &dyn Fn(&dyn Scorer) -> (GraspDecision, Reward),
    ) {
        let later: Vec<FailedGrasp> = failed.iter().map(|grasp| grasp.halved()).collect();
        let avoiding = |failed: &[FailedGrasp]| self.scorer.avoiding(failed);
        let (Some(usual), Some(present), Some(later)) = (avoiding(&[]), avoiding(failed), avoiding(&later)) else {
            return;
        };
        let (grasp, reward) = thresholds(usual.as_ref());
        let least = |asked: f64, usual: f64| asked.max(LEAST_WHERE_FAILED * usual).min(usual);
        let now = thresholds(present.as_ref()).0;
        self.grasp = GraspDecision {
            execute_score: least(now.execute_score, grasp.execute_score),
            solved_score: least(now.solved_score, grasp.solved_score),
        };
        let solved_score = least(thresholds(later.as_ref()).1.solved_score, reward.solved_score);
        self.reward = Reward { solved_score, ..reward };
        (self.scorer, self.present) = (later, Some(present));
    }

    /// What the scorer says of a state; where the stop is requested, nothing that is to be used.
    pub fn assess(&self, scratch: &mut Scratch, state: &State, stop: &Stop) -> GraspAssessment {
        let mut out = [GraspAssessment::default()];
        self.scorer.assess(scratch.scorer.as_mut(), &self.scene, &[state], self.target, &mut out, stop);
        out[0]
    }

    /// The same of the present state.
    pub fn assess_present(&self, scratch: &mut Scratch, state: &State, stop: &Stop) -> GraspAssessment {
        let mut out = [GraspAssessment::default()];
        let scorer = self.present.as_deref().unwrap_or(self.scorer.as_ref());
        scorer.assess(scratch.scorer.as_mut(), &self.scene, &[state], self.target, &mut out, stop);
        out[0]
    }

    /// The pushes that the sampler lists for a state, in an order of its own.
    pub(super) fn list(&self, scratch: &mut Scratch, state: &State, out: &mut Vec<Push>) {
        let mut order = Key::default().stream();
        self.sampler.sample(&self.scene, state, self.target, None, &mut order, &mut scratch.sampler, out);
    }

    /// Executes pushes in the model.
    pub(super) fn simulate(
        &self,
        scratch: &mut Scratch,
        jobs: &[PushJob<'_>],
        results: &mut [PushResult],
        stop: &Stop,
    ) {
        self.engine.step_batch(&mut scratch.engine, jobs, results, stop);
    }

    /// A state with this assessment is a solution.
    pub fn solves(&self, assessment: &GraspAssessment) -> bool {
        assessment.grasp.is_some() && assessment.score >= self.reward.solved_score.max(self.demand.min(GREATEST_DEMAND))
    }

    /// Value, terminal flag and actions of `out.state`. With a requested stop its status stays as it was.
    fn judge(&self, scratch: &mut Scratch, key: Key, previous: Option<&Push>, out: &mut Outcome<Self>, stop: &Stop) {
        let assessment = match previous {
            None => self.assess_present(scratch, &out.state, stop),
            Some(_) => self.assess(scratch, &out.state, stop),
        };
        if stop.requested() {
            return;
        }
        // Where a grasp has failed just now, it has to be bettered however good it looked.
        let solved = self.solves(&assessment) && (previous.is_some() || assessment.score >= self.demand);
        let quality = if assessment.grasp.is_some() { assessment.score } else { 0.0 };
        // Without a grasp the nearness ranks states below every graspable one.
        let judged = if assessment.grasp.is_some() { 0.5 + 0.5 * quality } else { 0.5 * assessment.nearness };
        out.value = self.reward.shaping * judged + if solved { 1.0 } else { 0.0 };
        out.quality = quality;
        out.terminal = solved;
        out.status = Status::Legal;
        if solved {
            return;
        }
        let mut order = key.stream();
        scratch.pushes.clear();
        self.sampler.sample(
            &self.scene,
            &out.state,
            self.target,
            previous,
            &mut order,
            &mut scratch.sampler,
            &mut scratch.pushes,
        );
        if previous.is_none() {
            self.failed.take_out(self.scene.gripper().scale(), &mut scratch.pushes);
        }
        let Some(prior) = &self.prior else {
            out.candidates.extend(scratch.pushes.iter().map(|push| Candidate::new(*push)));
            return;
        };
        let Scratch { prior: memory, values, pushes, .. } = scratch;
        // A network that cannot be run after it was loaded expects nothing.
        let asked = prior.values(memory, &self.scene, &out.state, self.target, pushes, values, stop);
        if stop.requested() {
            out.status = Status::Interrupted;
            return;
        }
        let value = |i: usize| if asked.is_ok() { values.get(i).copied().unwrap_or(0.0) } else { 0.0 };
        out.candidates.extend(pushes.iter().enumerate().map(|(i, push)| Candidate::with_prior(*push, value(i))));
    }

    /// A body that counts has left the workspace, or one has toppled.
    pub(super) fn harmful(&self, result: &PushResult) -> bool {
        let left = match self.scene.workspace().leave_scope {
            LeaveScope::AllBodies => !result.left.is_empty(),
            LeaveScope::TargetOnly => result.left.contains(self.target),
        };
        left || !result.toppled.is_empty()
    }

    /// The push does no harm, and something moved.
    pub(super) fn useful(&self, before: &State, result: &PushResult) -> bool {
        let idle = self.scene.gripper().scale() * IDLE.0;
        !self.harmful(result)
            && before.iter().any(|(i, a)| {
                let b = result.state.pose(i);
                (a.position() - b.position()).norm_squared() > idle * idle
                    || normalize_angle(a.theta - b.theta).abs() > IDLE.1
            })
    }
}

impl Domain for Retrieval {
    type State = State;
    type Action = Push;
    type Scratch = Scratch;

    fn scratch(&self) -> Scratch {
        self.new_scratch()
    }

    fn root(&self, scratch: &mut Scratch, _: &State, key: Key, out: &mut Outcome<Self>, stop: &Stop) {
        self.judge(scratch, key, None, out, stop);
    }

    fn step(&self, scratch: &mut Scratch, jobs: &mut [Job<Self>], stop: &Stop) {
        let mut results = std::mem::take(&mut scratch.results);
        results.resize_with(jobs.len().max(results.len()), PushResult::default);
        if let [job] = &*jobs {
            let one = [PushJob { state: &job.from, push: job.action }];
            self.engine.step_batch(&mut scratch.engine, &one, &mut results[..1], stop);
        } else {
            let batch: Vec<PushJob> = jobs.iter().map(|j| PushJob { state: &j.from, push: j.action }).collect();
            self.engine.step_batch(&mut scratch.engine, &batch, &mut results[..jobs.len()], stop);
        }
        for (job, result) in jobs.iter_mut().zip(&mut results) {
            match result.status {
                // To judge a state of many bodies takes a while: the rest of the jobs is left.
                PushStatus::Executed if stop.requested() => job.outcome.status = Status::Interrupted,
                PushStatus::Executed if self.useful(&job.from, result) => {
                    std::mem::swap(&mut job.outcome.state, &mut result.state);
                    self.judge(scratch, job.key, Some(&job.action), &mut job.outcome, stop);
                }
                PushStatus::Executed | PushStatus::Illegal { .. } | PushStatus::Unsolved => {
                    if result.leaves_open() {
                        self.unsolved.store(true, Ordering::Relaxed);
                    }
                    job.outcome.status = Status::Illegal;
                }
                PushStatus::Interrupted => job.outcome.status = Status::Interrupted,
            }
        }
        scratch.results = results;
    }

    fn group_size(&self) -> usize {
        self.engine.batch_size()
    }

    fn state_bytes(&self) -> usize {
        size_of::<State>() + self.scene.len() * size_of::<crate::scene::BodyPose>()
    }
}
