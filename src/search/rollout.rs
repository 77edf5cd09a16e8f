//! Rollouts: from every new node on, until a solution, the depth limit or a failure.
//!
//! All rollouts of a wave take a step at once. A rollout is a walker on the tree: the states it sees become ghosts,
//! nodes that only rollouts have visited. Later expansions and rollouts take them instead of simulating again; without
//! `reuse_rollouts` they are removed at the end of the wave, and everything else is the same.

use std::cmp::Reverse;

use super::Search;
use super::arena::{NONE, Tried};
use super::domain::{Domain, Status};
use super::params::{Return, RolloutFailure, RolloutPolicy};
use super::wave::Pair;
use crate::error::Result;

/// What a rollout has seen so far.
#[derive(Debug, Clone, Copy)]
struct Trace {
    /// Product of the discounts since the new node.
    discount: f64,
    /// Greatest discounted value.
    greatest: f64,
    /// Greatest plain value, and the same discounted.
    plain: f64,
    plain_discounted: f64,
    /// Last value, and the greatest before it.
    last: f64,
    earlier: f64,
}

impl Trace {
    fn new(value: f64) -> Self {
        Trace {
            discount: 1.0,
            greatest: value,
            plain: value,
            plain_discounted: value,
            last: value,
            earlier: f64::NEG_INFINITY,
        }
    }

    fn add(&mut self, value: f64, discount: f64) {
        self.discount *= discount;
        let discounted = self.discount * value;
        self.greatest = self.greatest.max(discounted);
        if value > self.plain {
            (self.plain, self.plain_discounted) = (value, discounted);
        }
        self.earlier = self.earlier.max(self.last);
        self.last = value;
    }

    fn value(&self, returns: Return) -> f64 {
        match returns {
            Return::Greatest => self.greatest,
            Return::BestPlain => self.plain_discounted,
            Return::Last { earlier } if earlier > 0.0 && self.earlier > f64::NEG_INFINITY => {
                self.discount * self.last.max(earlier * self.earlier)
            }
            Return::Last { .. } => self.discount * self.last,
        }
    }
}

/// A rollout on its way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Walker {
    pair: u32,
    node: u32,
    limit: u32,
    trace: Trace,
}

/// A step of a rollout.
#[derive(Debug, Clone, Copy)]
pub(super) struct Branch {
    walker: Walker,
    edge: u32,
    /// Index of its job; `NONE` if the outcome is known.
    job: u32,
}

impl<D: Domain> Search<'_, D> {
    /// Rolls out every pair and leaves it with its return.
    pub(super) fn roll_out(&mut self) -> Result<()> {
        *self.wave += 1;
        self.work.failures.clear();
        self.work.next.clear();
        for index in 0..self.work.pairs.len() {
            let node = self.work.pairs[index].child;
            let limit = self.frontier.rollout_limit(&self.params, self.arena.node(node).level);
            let trace = Trace::new(self.arena.node(node).value);
            self.go_on(Walker { pair: index as u32, node, limit, trace });
        }
        std::mem::swap(&mut self.work.walkers, &mut self.work.next);
        let enough = self.params.rollout_cutoff * f64::from(self.params.lanes);
        while self.work.walkers.len() as f64 > enough && !self.full && !self.run.stop.requested() {
            self.share();
            self.branch();
            self.step_rollouts()?;
        }
        for index in 0..self.work.walkers.len() {
            self.finish(self.work.walkers[index]);
        }
        Ok(())
    }

    /// Lets the walker take another step, or ends it.
    fn go_on(&mut self, walker: Walker) {
        let node = self.arena.node(walker.node);
        if node.terminal || node.level >= walker.limit || node.count == 0 {
            self.finish(walker);
        } else {
            self.work.next.push(walker);
        }
    }

    /// Gives the walker's return to its pair, which keeps the greatest.
    fn finish(&mut self, walker: Walker) {
        let value = walker.trace.value(self.params.returns);
        let node = self.arena.node(walker.node);
        let useful = node.terminal && node.level <= self.frontier.max_depth;
        let pair = &mut self.work.pairs[walker.pair as usize];
        if useful && value > pair.solution_value {
            (pair.solution, pair.solution_value) = (walker.node, value);
        }
        pair.value = pair.value.max(value);
        pair.plain = pair.plain.max(walker.trace.plain);
    }

    /// Makes the solutions that rollouts have met nodes of the tree, with the ghosts that lead to them. The iteration is
    /// then backed up from the solution.
    pub(super) fn adopt(&mut self) {
        for index in 0..self.work.pairs.len() {
            let Pair { child, solution, .. } = self.work.pairs[index];
            // The limit may have fallen since the rollout began: a longer solution is of no use.
            if solution == NONE || solution == child || self.arena.node(solution).level > self.frontier.max_depth {
                continue;
            }
            self.work.path.clear();
            let mut node = solution;
            while !self.arena.node(node).real {
                self.work.path.push(node);
                node = self.arena.node(node).parent;
            }
            while let Some(node) = self.work.path.pop() {
                let (parent, edge) = (self.arena.node(node).parent, self.arena.node(node).edge);
                self.frontier.take(self.arena, parent, edge);
                self.frontier.attach(self.arena, node);
            }
            let pair = &mut self.work.pairs[index];
            let own = self.arena.node(solution).value;
            (pair.child, pair.value, pair.plain) = (solution, own, own);
        }
    }

    /// How many actions each walker tries. More than one where lanes are to spare, which includes those of rollouts
    /// that have ended: an even share, the rest to states with more actions, and never more than a state has.
    fn share(&mut self) {
        let work = &mut *self.work;
        work.shares.clear();
        let lanes = self.params.lanes as usize;
        if !self.params.leaf_parallel || work.walkers.len() >= lanes {
            work.shares.resize(work.walkers.len(), 1);
            return;
        }
        work.free.clear();
        for walker in &work.walkers {
            let free = self.arena.edges_of(walker.node).filter(|&edge| self.arena.free(edge, *self.wave));
            work.free.push(free.count() as u32);
        }
        let even = (lanes / work.walkers.len()) as u32;
        work.shares.extend(work.free.iter().map(|&free| free.min(even)));
        let mut spare = lanes - work.shares.iter().sum::<u32>() as usize;
        work.order.clear();
        work.order.extend(0..work.walkers.len() as u32);
        work.order.sort_unstable_by_key(|&walker| (Reverse(work.free[walker as usize]), walker));
        while spare > 0 {
            let before = spare;
            for &walker in &work.order {
                let walker = walker as usize;
                if spare > 0 && work.shares[walker] < work.free[walker] {
                    work.shares[walker] += 1;
                    spare -= 1;
                }
            }
            if spare == before {
                break;
            }
        }
    }

    /// Chooses the actions of all walkers and prepares the jobs. Walkers without a free action end.
    fn branch(&mut self) {
        self.work.branches.clear();
        for index in 0..self.work.walkers.len() {
            let walker = self.work.walkers[index];
            let mut chosen = 0;
            // A walker with nothing free has a share of 0; it is asked once, to end it.
            while chosen < self.work.shares[index].max(1) {
                let Some(edge) = self.rollout_action(walker) else { break };
                self.arena.edge_mut(edge).taken = *self.wave;
                self.work.branches.push(Branch { walker, edge, job: NONE });
                chosen += 1;
            }
            if chosen == 0 {
                self.finish(walker);
            }
        }
    }

    fn rollout_action(&mut self, walker: Walker) -> Option<u32> {
        let (arena, wave) = (&*self.arena, *self.wave);
        let stream = &mut self.work.pairs[walker.pair as usize].stream;
        let mut free = arena.edges_of(walker.node).filter(|&edge| arena.free(edge, wave));
        let level = f64::from(arena.node(walker.node).level);
        let random = match self.params.rollout_policy {
            RolloutPolicy::Uniform => true,
            RolloutPolicy::BestPrior => false,
            RolloutPolicy::Mix { polynomial: [a, b, c], floor } => {
                stream.chance((a + b * level + c * level * level).max(floor))
            }
        };
        if random {
            let count = free.clone().count();
            return free.nth(stream.index(count));
        }
        let first = free.next()?;
        Some(free.fold(first, |best, edge| if arena.edge(edge).prior > arena.edge(best).prior { edge } else { best }))
    }

    /// Executes the branches; the walkers that go on are left in `walkers`.
    fn step_rollouts(&mut self) -> Result<()> {
        let mut jobs = 0;
        for index in 0..self.work.branches.len() {
            let Branch { walker, edge, .. } = self.work.branches[index];
            if self.arena.edge(edge).child == NONE && !self.arena.edge(edge).known_dead {
                self.prepare(jobs, walker.node, edge);
                self.work.branches[index].job = jobs as u32;
                jobs += 1;
            }
        }
        self.execute(jobs)?;
        self.work.next.clear();
        for index in 0..self.work.branches.len() {
            let Branch { mut walker, edge, job } = self.work.branches[index];
            let status = match job {
                NONE => {
                    self.reused += 1;
                    if self.arena.edge(edge).known_dead { Status::Illegal } else { Status::Legal }
                }
                job => self.work.jobs[job as usize].outcome.status,
            };
            match status {
                Status::Legal => {
                    let known = (job == NONE).then_some(self.arena.edge(edge).child);
                    let child = if known.is_some() { known } else { self.store(job, walker.node, edge)? };
                    let Some(child) = child else {
                        self.finish(walker);
                        continue;
                    };
                    let node = self.arena.node(child);
                    walker.node = child;
                    walker.trace.add(node.value, node.discount);
                    self.go_on(walker);
                }
                Status::Illegal => {
                    if job != NONE {
                        self.arena.edge_mut(edge).known_dead = true;
                        self.work.failures.push(edge);
                    }
                    match self.params.rollout_failure {
                        RolloutFailure::End => self.finish(walker),
                        RolloutFailure::Retry => self.go_on(walker),
                    }
                }
                Status::Interrupted => self.finish(walker),
            }
        }
        std::mem::swap(&mut self.work.walkers, &mut self.work.next);
        Ok(())
    }

    /// Removes what rollouts of this wave have added beyond the given lengths.
    pub(super) fn forget_rollouts(&mut self, nodes: usize, edges: usize) {
        for ghost in nodes..self.arena.len() {
            let (parent, edge) = (self.arena.node(ghost as u32).parent, self.arena.node(ghost as u32).edge);
            if (parent as usize) < nodes {
                self.arena.edge_mut(edge).child = NONE;
            }
        }
        for &edge in &self.work.failures {
            if (edge as usize) < edges {
                self.arena.edge_mut(edge).known_dead = false;
            }
        }
        self.arena.truncate(nodes, edges);
    }
}

impl<D: Domain> super::arena::Arena<D> {
    /// Whether a rollout of this wave may take the action.
    fn free(&self, edge: u32, wave: u32) -> bool {
        let edge = self.edge(edge);
        edge.taken != wave && edge.tried != Tried::Dead && !edge.expansion_only
    }
}
