//! A small made-up world for tests: a random tree that never changes.
//!
//! The same file serves the integration tests, which see the crate from outside.

use crate::run::{CancelToken, Key, Stop};
use crate::search::{Candidate, Domain, Job, Outcome, Status};

/// A deterministic random tree: everything about a state follows from the path of actions that led to it.
#[derive(Debug, Clone)]
pub struct Toy {
    /// Which tree.
    pub seed: u64,
    /// Greatest number of actions of a state; the number varies from 1 to this.
    pub branching: u32,
    /// Fraction of illegal actions.
    pub illegal: f64,
    /// Fraction of states that are solutions.
    pub solutions: f64,
    /// Levels from which on states have no actions.
    pub end: u32,
    /// Jobs per call of `step`.
    pub group: usize,
    /// Triggered when so many actions were executed by one worker.
    pub cancel: Option<(u64, CancelToken)>,
}

impl Default for Toy {
    fn default() -> Self {
        Toy { seed: 1, branching: 5, illegal: 0.15, solutions: 0.03, end: u32::MAX, group: 1, cancel: None }
    }
}

/// The path as a hash, and its length.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ToyState {
    pub hash: u64,
    pub length: u32,
}

impl Toy {
    pub fn start(&self) -> ToyState {
        ToyState { hash: Key::new(self.seed).bits(), length: 0 }
    }

    /// What an action does; `None` if it is illegal.
    pub fn next(&self, from: &ToyState, action: u32) -> Option<ToyState> {
        let hash = Key::from_bits(from.hash).child(u64::from(action)).bits();
        let illegal = Key::from_bits(hash).child(1).stream().unit() < self.illegal;
        (!illegal).then_some(ToyState { hash, length: from.length + 1 })
    }

    pub fn terminal(&self, state: &ToyState) -> bool {
        state.length > 0 && Key::from_bits(state.hash).child(2).stream().unit() < self.solutions
    }

    pub fn value(&self, state: &ToyState) -> f64 {
        let score = Key::from_bits(state.hash).child(3).stream().unit();
        0.1 * score + if self.terminal(state) { 1.0 } else { 0.0 }
    }

    pub fn actions(&self, state: &ToyState) -> u32 {
        if state.length >= self.end {
            return 0;
        }
        1 + Key::from_bits(state.hash).child(4).stream().index(self.branching as usize) as u32
    }

    fn fill(&self, state: &ToyState, key: Key, out: &mut Outcome<Self>) {
        out.status = Status::Legal;
        out.value = self.value(state);
        out.terminal = self.terminal(state);
        out.quality = out.value;
        out.cost = 0.5;
        let mut stream = Key::from_bits(state.hash).child(5).stream();
        for action in 0..self.actions(state) {
            let mut candidate = Candidate::with_prior(action, stream.unit() as f32);
            candidate.expansion_only = stream.chance(0.1);
            out.candidates.push(candidate);
        }
        // An order that only a stable key repeats.
        key.stream().shuffle(&mut out.candidates);
    }
}

impl Domain for Toy {
    type State = ToyState;
    type Action = u32;
    type Scratch = u64;

    fn scratch(&self) -> u64 {
        0
    }

    fn root(&self, _: &mut u64, state: &ToyState, key: Key, out: &mut Outcome<Self>, _: &Stop) {
        self.fill(state, key, out);
    }

    fn step(&self, scratch: &mut u64, jobs: &mut [Job<Self>], stop: &Stop) {
        for job in jobs {
            if stop.requested() {
                return;
            }
            *scratch += 1;
            if let Some((after, token)) = &self.cancel
                && *scratch == *after
            {
                token.trigger();
            }
            match self.next(&job.from, job.action) {
                None => job.outcome.status = Status::Illegal,
                Some(state) => {
                    self.fill(&state, job.key, &mut job.outcome);
                    job.outcome.state = state;
                }
            }
        }
    }

    fn group_size(&self) -> usize {
        self.group
    }
}
