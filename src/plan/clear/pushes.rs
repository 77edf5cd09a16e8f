//! Candidate pushes: simulated and judged side by side, and the best of them tried in a second engine.

use std::sync::Mutex;

use super::options::{ClearRule, PushWorth};
use super::outlook::Outlook;
use super::parts::{ClearParts, Scratch};
use crate::action::Push;
use crate::error::Result;
use crate::geom::{Pose2, normalize_angle};
use crate::physics::{PushJob, PushResult, PushStatus};
use crate::run::{Key, Pool, Progress, ProgressSnapshot, Stop};
use crate::scene::{BodyPose, Scene, State};

/// Pushes judged between two looks at the clock and two reports of progress, for each worker's batch.
const BATCHES_PER_LOOK: usize = 4;
/// A push that moves no body by more than this (metres, for the published gripper; radians) is dropped: it leads back to
/// where it began.
const IDLE: (f64, f64) = (0.002, 0.035);
/// How much a push loses by being of no use in all worlds of the confirming engine: more than any can be worth.
const REFUSED: f64 = 1.0;

/// One push from one state.
pub(super) struct Candidate {
    pub push: Push,
    /// Index of the state it starts from.
    pub world: usize,
    pub result: PushResult,
    /// Of the state after it; none where it is of no use, or was not judged in time.
    pub outlook: Option<Outlook>,
    /// The engine has executed it to its end.
    pub done: bool,
}

impl Candidate {
    pub fn new(push: Push, world: usize) -> Candidate {
        Candidate { push, world, result: PushResult::default(), outlook: None, done: false }
    }

    /// Estimated, with the state after the push.
    pub fn bytes(scene: &Scene) -> usize {
        size_of::<Candidate>() + scene.len() * size_of::<BodyPose>()
    }
}

/// What pushes are judged with.
pub(super) struct Judging<'a> {
    pub parts: &'a ClearParts,
    pub rule: &'a ClearRule,
    /// A body whose grasp scores this can be taken.
    pub enough: f64,
    pub pool: &'a Pool,
    pub scratches: &'a [Mutex<Scratch>],
    pub stop: &'a Stop,
    pub progress: Option<&'a Progress>,
}

/// A push with what it is expected to be worth, over one world or several.
#[derive(Debug, Clone, Copy)]
pub(super) struct Judged {
    /// Index of the candidate whose result is the prediction.
    pub candidate: usize,
    pub value: f64,
    /// Mean number of bodies that can be taken after it.
    pub freed: f64,
    pub mean: f64,
    pub greatest: f64,
}

impl Judging<'_> {
    /// Executes every candidate from its world, in the confirming engine or the model, and judges the state after it.
    /// With a requested stop the rest stays as it was. Gives how many were executed.
    pub fn judge(&self, worlds: &[State], candidates: &mut [Candidate], confirming: bool) -> Result<u64> {
        let engine = match (&self.parts.confirming, confirming) {
            (Some(engine), true) => engine,
            _ => &self.parts.engine,
        };
        let batch = engine.batch_size().max(1);
        let look = BATCHES_PER_LOOK * batch * self.pool.workers();
        let mut done = 0;
        for run in candidates.chunks_mut(look) {
            if self.stop.requested() {
                break;
            }
            self.pool.for_each_group(run, batch, self.scratches, |scratch, group| {
                let jobs: Vec<PushJob> =
                    group.iter().map(|c| PushJob { state: &worlds[c.world], push: c.push }).collect();
                let mut results = std::mem::take(&mut scratch.results);
                results.resize_with(jobs.len().max(results.len()), PushResult::default);
                let memory = match &mut scratch.confirming {
                    Some(memory) if confirming => memory,
                    _ => &mut scratch.engine,
                };
                engine.step_batch(memory, &jobs, &mut results[..jobs.len()], self.stop);
                drop(jobs);
                for (candidate, result) in group.iter_mut().zip(&mut results) {
                    std::mem::swap(&mut candidate.result, result);
                }
                scratch.results = results;
                self.judge_states(scratch, worlds, group);
            })?;
            done += run.iter().filter(|c| c.done).count() as u64;
            if let (Some(progress), false) = (self.progress, confirming) {
                let now = ProgressSnapshot { iterations: done, nodes: done, simulations: done, ..Default::default() };
                progress.publish(&now, self.stop);
            }
        }
        Ok(done)
    }

    fn judge_states(&self, scratch: &mut Scratch, worlds: &[State], group: &mut [Candidate]) {
        for candidate in &mut *group {
            candidate.done = candidate.result.status != PushStatus::Interrupted;
            candidate.outlook = None;
        }
        let useful: Vec<bool> = group.iter().map(|c| c.done && self.useful(&worlds[c.world], &c.result)).collect();
        let states: Vec<&State> =
            group.iter().zip(&useful).filter(|(_, useful)| **useful).map(|(c, _)| &c.result.state).collect();
        let Some(first) = states.first() else { return };
        // A push takes nothing away: the bodies to be taken are the same in all states.
        let which = self.parts.remaining(first);
        let Scratch { scorer, found, state, .. } = scratch;
        self.parts.assess_all(scorer.as_mut(), &states, which, found, self.stop);
        let count = states.len();
        let enough = if self.rule.worth == PushWorth::Freed { self.enough } else { f64::INFINITY };
        let useful = group.iter_mut().zip(&useful).filter(|(_, useful)| **useful);
        for (k, (candidate, _)) in useful.enumerate() {
            if self.stop.requested() {
                candidate.done = false;
            } else {
                state.clone_from(&candidate.result.state);
                let of = |body: usize| found[body * count + k];
                let outlook = Outlook::new(self.parts, scorer.as_mut(), state, which, enough, of, self.stop);
                candidate.done = !self.stop.requested();
                candidate.outlook = candidate.done.then_some(outlook);
            }
        }
    }

    /// Something moved, nothing toppled or left the workspace, and nothing came too near to its edge.
    fn useful(&self, before: &State, result: &PushResult) -> bool {
        let scene = &self.parts.scene;
        let inset = |pose: &Pose2| scene.workspace().inset(pose.position());
        let scale = scene.gripper().scale();
        let (idle, edge) = (scale * IDLE.0, scale * self.rule.edge);
        let mut moved = false;
        for (i, a) in before.iter() {
            let b = result.state.pose(i);
            let by = (a.position() - b.position()).norm_squared();
            moved |= by > idle * idle || normalize_angle(a.theta - b.theta).abs() > IDLE.1;
            let inside = inset(&b);
            if inside < edge && inside < inset(&a) - idle {
                return false;
            }
        }
        moved && result.status == PushStatus::Executed && result.left.is_empty() && result.toppled.is_empty()
    }

    /// What a state is worth by the rule.
    pub fn worth(&self, outlook: &Outlook) -> f64 {
        match self.rule.worth {
            // Where nothing can be grasped, nearness says where to push.
            PushWorth::MeanReward => outlook.mean + 1e-3 * outlook.nearness,
            PushWorth::Freed => outlook.freed_value(),
        }
    }

    /// The candidates that are of use, the best first; equals in their order.
    pub fn ranked(&self, candidates: &[Candidate]) -> Vec<Judged> {
        let mut ranked: Vec<Judged> = candidates
            .iter()
            .enumerate()
            .filter_map(|(candidate, c)| {
                let outlook = c.outlook.as_ref()?;
                let (value, freed) = (self.worth(outlook), outlook.freed as f64);
                Some(Judged { candidate, value, freed, mean: outlook.mean, greatest: outlook.greatest })
            })
            .collect();
        ranked.sort_by(|a, b| b.value.total_cmp(&a.value));
        ranked
    }

    /// Tries the best candidates in the confirming engine, in every world. Gives the trials, those of one push side by
    /// side, and the pushes in their new order; `Judged::candidate` is the trial in the first world. Empty if not all
    /// were done in time.
    pub fn confirm(
        &self,
        worlds: &[State],
        candidates: &[Candidate],
        ranked: &[Judged],
    ) -> Result<(Vec<Candidate>, Vec<Judged>)> {
        let mut trials: Vec<Candidate> = ranked
            .iter()
            .take(self.rule.confirm_pushes)
            .flat_map(|judged| (0..worlds.len()).map(|world| Candidate::new(candidates[judged.candidate].push, world)))
            .collect();
        self.judge(worlds, &mut trials, true)?;
        if trials.iter().any(|t| !t.done) {
            return Ok((trials, Vec::new()));
        }
        let mut judged: Vec<Judged> = trials
            .chunks(worlds.len().max(1))
            .enumerate()
            .map(|(push, of_worlds)| {
                let n = of_worlds.len() as f64;
                let mean = |value: &dyn Fn(&Outlook) -> f64, refused: f64| {
                    of_worlds.iter().map(|t| t.outlook.as_ref().map_or(refused, value)).sum::<f64>() / n
                };
                Judged {
                    candidate: push * worlds.len(),
                    value: mean(&|o| self.worth(o), -REFUSED),
                    freed: mean(&|o| o.freed as f64, 0.0),
                    mean: mean(&|o| o.mean, 0.0),
                    greatest: mean(&|o| o.greatest, 0.0),
                }
            })
            .collect();
        judged.sort_by(|a, b| b.value.total_cmp(&a.value));
        Ok((trials, judged))
    }

    /// The observed state, and others that differ from it as a camera's next looks would.
    pub fn worlds(&self, observed: &State, key: Key) -> Vec<State> {
        let mut worlds = vec![observed.clone()];
        let noise_position = self.parts.scene.gripper().scale() * self.rule.noise_position;
        for world in 1..self.rule.confirm_worlds {
            let mut state = observed.clone();
            for (i, pose) in observed.iter() {
                let mut draw = key.child(world as u64).child(i as u64).stream();
                let (position, rotation) = (noise_position, self.rule.noise_rotation);
                let [dx, dy, turn] = [position, position, rotation].map(|deviation| deviation * draw.normal());
                state.set_pose(i, Pose2::new(pose.x + dx, pose.y + dy, pose.theta + turn));
            }
            worlds.push(state);
        }
        worlds
    }
}
