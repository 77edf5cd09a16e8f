//! Rearrangement as a search domain: states of the table, moves between them, every body home in the end.

use std::sync::Arc;

use super::mover::Mover;
use super::options::RearrangeReward;
use super::samplers::{Criterion, Place, SampleCounts, direct};
use super::table::Layout;
use super::untangle::Worker;
use crate::action::Move;
use crate::geom::Pose2;
use crate::run::{Key, Stop};
use crate::scene::{BodyPose, Mask, State};
use crate::search::{Candidate, Domain, Job, Outcome, Status};

/// Where a move takes a body. How, for a drag, is found out when it is executed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Placement {
    pub body: u32,
    pub pose: BodyPose,
}

/// A state and how it was reached.
#[derive(Debug, Clone, Default)]
pub struct Reached {
    pub state: State,
    /// The move that led here; none at the root.
    pub last: Option<Move>,
    /// Of all moves from the root, metres.
    pub cost: f64,
}

/// Which moves are proposed in a state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Proposals {
    /// The four criteria of the text, for every body.
    Sampled(SampleCounts),
    /// Goals that are free, and for bodies in the way of others, the places where they block least; a few random ones.
    Ranked { places: usize, random: usize },
}

/// The parts of PMMR, prepared for one problem.
pub struct Rearrange {
    mover: Arc<Mover>,
    proposals: Proposals,
    reward: RearrangeReward,
    /// `R_g`.
    all_home: f64,
    /// `R_b`.
    base: f64,
}

/// Working memory of one worker.
#[derive(Debug, Default)]
pub struct Scratch {
    worker: Worker,
    places: Vec<Place>,
}

/// Priors: of a body's goal, of the best and the worst place of a body in the way, of any other body's.
const HOME: f32 = 1.0;
const ASIDE: (f32, f32) = (0.6, 0.4);
const ELSEWHERE: f32 = 0.1;

impl Rearrange {
    pub fn new(mover: Arc<Mover>, proposals: Proposals, reward: RearrangeReward) -> Rearrange {
        let start = mover.table.problem.start.clone();
        let wanted = mover.table.problem.goals.iter().flatten().count();
        let all_home = 2.0 * reward.body * wanted as f64;
        let mut domain = Rearrange { mover, proposals, reward, all_home, base: 0.0 };
        if reward.base {
            domain.base = domain.home(&start);
        }
        domain
    }

    /// `R_o`: the reward of the bodies at their goals.
    fn home(&self, state: &State) -> f64 {
        let table = &self.mover.table;
        let each = |body: usize| {
            let home = table.goal(body).is_some_and(|goal| goal.reached(&state.pose(body)));
            let factor = if table.drag_only.contains(body) { self.reward.drag_only } else { 1.0 };
            if home { self.reward.body * factor } else { 0.0 }
        };
        (0..table.len()).map(each).sum()
    }

    /// Value, terminal flag and moves of `out.state`.
    fn judge(&self, scratch: &mut Scratch, key: Key, stop: &Stop, out: &mut Outcome<Self>) {
        let table = &self.mover.table;
        let misplaced = table.misplaced(&out.state.state);
        out.status = Status::Legal;
        out.terminal = misplaced.is_empty();
        let reward = if out.terminal { self.all_home } else { self.home(&out.state.state) };
        out.value = (reward - out.state.cost - self.base).max(0.0);
        if out.terminal {
            return;
        }
        scratch.worker.layout.set(&out.state.state);
        match self.proposals {
            Proposals::Sampled(counts) => self.sample(scratch, &counts, key, out),
            Proposals::Ranked { places, random } => {
                self.rank(scratch, misplaced, (places, random), key, stop, out);
                if stop.requested() {
                    out.clear();
                }
            }
        }
    }

    /// The text's moves: direct ones first, the others in random order. Rollouts see the direct ones and a few random.
    fn sample(&self, scratch: &mut Scratch, counts: &SampleCounts, key: Key, out: &mut Outcome<Self>) {
        let mut stream = key.stream();
        for body in self.mover.table.movable.iter() {
            scratch.places.clear();
            counts.places(&self.mover.table, &scratch.worker.layout, body, &mut stream, &mut scratch.places);
            let mut random = 0;
            for place in &scratch.places {
                let direct = place.criterion == Criterion::Direct;
                random += u32::from(place.criterion == Criterion::Random);
                let rollout = direct || place.criterion == Criterion::Random && random <= counts.rollout;
                let candidate = Candidate::with_prior(placement(body, place.pose), if direct { HOME } else { 0.0 });
                out.candidates.push(Candidate { expansion_only: !rollout, ..candidate });
            }
        }
        stream.shuffle(&mut out.candidates);
    }

    /// Moves by the dependency graph.
    fn rank(
        &self,
        scratch: &mut Scratch,
        misplaced: Mask,
        (places, random): (usize, usize),
        key: Key,
        stop: &Stop,
        out: &mut Outcome<Self>,
    ) {
        let table = &self.mover.table;
        let mut stream = key.stream();
        let worker = &mut scratch.worker;
        worker.find_graph(&self.mover, misplaced, stop);
        let in_the_way = worker.in_the_way(misplaced);
        for body in table.movable.iter() {
            let home = if misplaced.contains(body) { direct(table, &worker.layout, body) } else { None };
            if let Some(place) = home {
                out.candidates.push(Candidate::with_prior(placement(body, place.pose), HOME));
            }
            let wanted = if in_the_way.contains(body) { places } else { random };
            if wanted == 0 {
                continue;
            }
            worker.rank_places(&self.mover, body, misplaced, false, &mut stream, stop);
            let found = worker.places();
            for (rank, (_, pose)) in found.iter().take(wanted).enumerate() {
                let prior = if in_the_way.contains(body) {
                    let spread = (ASIDE.0 - ASIDE.1) * rank as f32 / places as f32;
                    ASIDE.0 - spread + 0.05 * stream.unit() as f32
                } else {
                    ELSEWHERE * stream.unit() as f32
                };
                let candidate = Candidate::with_prior(placement(body, *pose), prior);
                out.candidates.push(Candidate { expansion_only: rank > 1, ..candidate });
            }
        }
    }
}

fn placement(body: usize, pose: Pose2) -> Placement {
    Placement { body: body as u32, pose: pose.into() }
}

impl Domain for Rearrange {
    type State = Reached;
    type Action = Placement;
    type Scratch = Scratch;

    fn scratch(&self) -> Scratch {
        Scratch::default()
    }

    fn root(&self, scratch: &mut Scratch, _: &Reached, key: Key, out: &mut Outcome<Self>, stop: &Stop) {
        self.judge(scratch, key, stop, out);
    }

    fn step(&self, scratch: &mut Scratch, jobs: &mut [Job<Self>], stop: &Stop) {
        for job in jobs {
            let layout: &mut Layout = &mut scratch.worker.layout;
            layout.set(&job.from.state);
            let body = job.action.body as usize;
            let done = scratch.worker.attempt(&self.mover, body, job.action.pose.into(), stop);
            let Some(action) = done else {
                if stop.requested() {
                    return;
                }
                job.outcome.status = Status::Illegal;
                continue;
            };
            let cost = self.mover.costs.metres(&action);
            let reached = &mut job.outcome.state;
            reached.state.clone_from(&job.from.state);
            reached.state.set_pose(body, action.to());
            reached.cost = job.from.cost + cost;
            reached.last = Some(action);
            job.outcome.cost = cost;
            self.judge(scratch, job.key, stop, &mut job.outcome);
        }
    }

    fn state_bytes(&self) -> usize {
        // A drag has some ten waypoints.
        size_of::<Reached>() + self.mover.table.len() * size_of::<BodyPose>() + 10 * size_of::<Pose2>()
    }
}
