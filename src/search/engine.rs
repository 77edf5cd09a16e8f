//! A running search: what it works on, and the loop of waves.

use std::sync::Mutex;
use std::time::Duration;

use super::arena::{Arena, NONE, UNSOLVED};
use super::choose;
use super::domain::{Domain, Outcome, Status};
use super::frontier::Frontier;
use super::params::Params;
use super::report::{EndReason, Run, SearchReport};
use super::wave::{Workspace, check};
use crate::error::{Error, Result};
use crate::run::{Key, ProgressSnapshot, StopReason};

/// A running search. Its methods are in `select`, `wave`, `rollout` and `backup`.
pub(super) struct Search<'a, D: Domain> {
    // Constant while it runs.
    pub domain: &'a D,
    pub params: Params,
    pub run: &'a Run<'a>,
    pub key: Key,
    // The tree's, changed.
    pub arena: &'a mut Arena<D>,
    pub frontier: &'a mut Frontier,
    pub work: &'a mut Workspace<D>,
    /// Number of the next iteration, counting those that did not count.
    pub ordinal: &'a mut u64,
    pub wave: &'a mut u32,
    // Counts of this search.
    pub iterations: u64,
    pub simulations: u64,
    pub reused: u64,
    pub waves: u64,
    pub step_time: Duration,
    /// A state was left out as it would have exceeded the budget of bytes.
    pub full: bool,
}

impl<D: Domain> Search<'_, D> {
    /// Evaluates the state and makes it the root of an empty tree. `None` if the work was asked to end before.
    pub fn plant(&mut self, state: &D::State, key: Key) -> Result<Option<()>> {
        let begin = self.run.stop.elapsed();
        if self.work.jobs.is_empty() {
            self.work.jobs.push(super::Job::default());
        }
        let outcome = &mut self.work.jobs[0].outcome;
        outcome.clear();
        outcome.state.clone_from(state);
        let (domain, stop) = (self.domain, self.run.stop);
        let root = |scratch: &mut D::Scratch, outcome: &mut [Outcome<D>]| {
            outcome.iter_mut().for_each(|outcome| domain.root(scratch, state, key, outcome, stop));
        };
        let one = std::slice::from_mut(outcome);
        self.run.pool.for_each_group(one, 1, &self.work.scratches, root)?;
        self.step_time += self.run.stop.elapsed().saturating_sub(begin);
        match outcome.status {
            Status::Legal => {
                check(outcome)?;
                self.arena.push(NONE, NONE, key, 1.0, outcome);
                self.frontier.attach(self.arena, 0);
                self.frontier.complete_levels();
                Ok(Some(()))
            }
            Status::Illegal => Err(Error::argument("root", "is not a state from which the domain can go on")),
            Status::Interrupted => Ok(None),
        }
    }

    /// Waves until one of the reasons to end. The tree has a root.
    pub fn search(&mut self) -> Result<EndReason> {
        if self.params.first_expand {
            while self.next_root_actions() {
                self.wave_of_root_actions(self.wanted())?;
                self.waves += 1;
                self.publish();
            }
        }
        loop {
            if let Some(reason) = self.ended() {
                return Ok(reason);
            }
            self.wave(self.wanted())?;
            self.waves += 1;
            self.publish();
        }
    }

    /// Whether untried actions of the root are left for `first_expand`.
    fn next_root_actions(&self) -> bool {
        let root = self.arena.stat(0);
        root.untried > 0 && root.open > 0 && self.wanted() > 0 && !self.full && !self.run.stop.requested()
    }

    /// Lanes of the next wave: no more than the budget has iterations left.
    fn wanted(&self) -> usize {
        let left = self.run.budget.iterations.map_or(u64::MAX, |most| most.saturating_sub(self.iterations));
        left.min(u64::from(self.params.lanes)) as usize
    }

    /// Why no further wave begins.
    fn ended(&self) -> Option<EndReason> {
        if self.arena.node(0).terminal {
            return Some(EndReason::Solved);
        }
        if self.iterations >= self.params.min_iterations && self.frontier.solved(self.params.early_stop) {
            return Some(EndReason::Solved);
        }
        if self.arena.stat(0).open == 0 {
            return Some(EndReason::Exhausted);
        }
        if self.wanted() == 0 {
            return Some(EndReason::Iterations);
        }
        if self.run.stop.requested() {
            return Some(self.run.stop.reason().unwrap_or(StopReason::Interrupted).into());
        }
        let full = self.full || self.run.budget.bytes.is_some_and(|most| self.bytes() > most);
        // Indices have 32 bits; a wave adds less than the other half of them.
        let many = self.arena.len().max(self.arena.edge_len()) > (u32::MAX / 2) as usize;
        (full || many).then_some(EndReason::Memory)
    }

    /// Another state with so many actions fits into the budget of bytes, and the system gives the memory for it.
    pub fn fits(&mut self, actions: usize) -> bool {
        let (state, action) = (self.domain.state_bytes(), self.domain.action_bytes());
        let allowed = |most| self.arena.bytes_with(actions, state, action) <= most;
        self.run.budget.bytes.is_none_or(allowed) && self.arena.reserve(actions)
    }

    fn bytes(&self) -> usize {
        self.arena.bytes(self.domain.state_bytes(), self.domain.action_bytes())
    }

    fn publish(&self) {
        let Some(told) = self.run.progress else { return };
        let best = choose::best_child(self.arena, &self.params, 0);
        let now = ProgressSnapshot {
            iterations: told.iterations + self.iterations,
            nodes: self.frontier.nodes,
            simulations: told.simulations + self.simulations,
            best_value: best.map_or(0.0, |best| best.score),
            solution_level: self.solution_level(),
            elapsed_us: 0,
        };
        told.progress.publish(&now, self.run.stop);
    }

    fn solution_level(&self) -> Option<u32> {
        (self.frontier.solution != UNSOLVED).then_some(self.frontier.solution)
    }

    pub fn report(&self, reason: EndReason, begin: Duration) -> SearchReport {
        let best = if self.arena.len() > 0 { choose::best_child(self.arena, &self.params, 0) } else { None };
        SearchReport {
            reason,
            iterations: self.iterations,
            simulations: self.simulations,
            reused: self.reused,
            waves: self.waves,
            nodes: self.frontier.nodes,
            stored: self.arena.len() as u64,
            bytes: self.bytes(),
            depth: self.frontier.depth,
            solution_level: self.solution_level(),
            proved_level: self.frontier.proved(),
            best_action: best.map(|best| (best.edge - self.arena.node(0).first) as usize),
            best_value: best.map_or(0.0, |best| best.score),
            time: self.run.stop.elapsed().saturating_sub(begin),
            step_time: self.step_time,
        }
    }
}

/// One scratch per worker, made anew: a scratch may be of use to one domain only.
pub(super) fn renew_scratches<D: Domain>(scratches: &mut Vec<Mutex<D::Scratch>>, domain: &D, run: &Run) {
    scratches.clear();
    scratches.extend((0..run.pool.workers()).map(|_| Mutex::new(domain.scratch())));
}
