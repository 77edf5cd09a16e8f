//! A wave: the lanes are selected one after another, expanded at once, rolled out at once, and backed up one after
//! another. With one lane this is plain serial search.

use std::sync::Mutex;

use super::Search;
use super::arena::{NONE, Tried};
use super::domain::{Domain, Job, Outcome, Status};
use super::rollout::{Branch, Walker};
use crate::error::{Error, Result};
use crate::run::Stream;

/// A selected pair of node and action, and what became of it.
#[derive(Debug, Clone)]
pub(super) struct Pair {
    pub node: u32,
    /// `NONE` for a revisit of `node`.
    pub edge: u32,
    /// The new node; `NONE` where there is none.
    pub child: u32,
    /// Where its outcome comes: an index of a job, or `NONE` if it is known.
    pub job: u32,
    /// The randomness of this iteration.
    pub stream: Stream,
    /// Return of the new node, and the greatest plain value it was made from.
    pub value: f64,
    pub plain: f64,
    /// The solution within the depth limit that gave the greatest return of those that rollouts met, and that return;
    /// `NONE` without.
    pub solution: u32,
    pub solution_value: f64,
}

impl Pair {
    pub fn new(node: u32, edge: u32, stream: Stream) -> Self {
        Pair {
            node,
            edge,
            child: NONE,
            job: NONE,
            stream,
            value: f64::NEG_INFINITY,
            plain: f64::NEG_INFINITY,
            solution: NONE,
            solution_value: f64::NEG_INFINITY,
        }
    }
}

/// Buffers of a search; all of them keep their memory from one search to the next.
pub(super) struct Workspace<D: Domain> {
    pub scratches: Vec<Mutex<D::Scratch>>,
    pub jobs: Vec<Job<D>>,
    pub pairs: Vec<Pair>,
    /// Nodes with virtual visits at them or below.
    pub touched: Vec<u32>,
    pub walkers: Vec<Walker>,
    pub next: Vec<Walker>,
    pub branches: Vec<Branch>,
    /// Branches wanted of each walker, its free actions, and the order in which walkers get more.
    pub shares: Vec<u32>,
    pub free: Vec<u32>,
    pub order: Vec<u32>,
    /// Actions that rollouts of this wave found illegal.
    pub failures: Vec<u32>,
    /// New place of every node while a tree is cut.
    pub map: Vec<u32>,
    /// Ghosts on the way to a solution.
    pub path: Vec<u32>,
}

impl<D: Domain> Default for Workspace<D> {
    fn default() -> Self {
        Workspace {
            scratches: Vec::new(),
            jobs: Vec::new(),
            pairs: Vec::new(),
            touched: Vec::new(),
            walkers: Vec::new(),
            next: Vec::new(),
            branches: Vec::new(),
            shares: Vec::new(),
            free: Vec::new(),
            order: Vec::new(),
            failures: Vec::new(),
            map: Vec::new(),
            path: Vec::new(),
        }
    }
}

impl<D: Domain> Search<'_, D> {
    /// One wave of at most `wanted` iterations.
    pub(super) fn wave(&mut self, wanted: usize) -> Result<()> {
        self.select(wanted);
        self.expand()?;
        let (nodes, edges) = (self.arena.len(), self.arena.edge_len());
        self.roll_out()?;
        if self.params.adopt_solutions {
            self.adopt();
        }
        self.back_up();
        if !self.params.reuse_rollouts {
            self.forget_rollouts(nodes, edges);
        }
        self.frontier.complete_levels();
        Ok(())
    }

    /// Before the first wave: every action of the root, without rollouts ("first_expand").
    pub(super) fn wave_of_root_actions(&mut self, wanted: usize) -> Result<()> {
        self.work.pairs.clear();
        for edge in self.arena.edges_of(0) {
            if self.work.pairs.len() < wanted && self.arena.edge(edge).tried == Tried::No {
                self.frontier.take(self.arena, 0, edge);
                let key = self.key.child(*self.ordinal);
                *self.ordinal += 1;
                self.work.pairs.push(Pair::new(0, edge, key.stream()));
            }
        }
        self.expand()?;
        for pair in &mut self.work.pairs {
            pair.value = self.arena.node(pair.child).value;
            pair.plain = pair.value;
        }
        self.back_up();
        self.frontier.complete_levels();
        Ok(())
    }

    /// Executes the selected actions; afterwards `pairs` holds those that have a node.
    fn expand(&mut self) -> Result<()> {
        let mut jobs = 0;
        for index in 0..self.work.pairs.len() {
            let Pair { node, edge, .. } = self.work.pairs[index];
            if edge == NONE || self.arena.edge(edge).child != NONE || self.arena.edge(edge).known_dead {
                continue;
            }
            self.prepare(jobs, node, edge);
            self.work.pairs[index].job = jobs as u32;
            jobs += 1;
        }
        self.execute(jobs)?;
        for index in 0..self.work.pairs.len() {
            self.work.pairs[index].child = self.expanded(index)?;
        }
        self.work.pairs.retain(|pair| pair.child != NONE);
        Ok(())
    }

    /// Puts the outcome of a pair into the tree.
    fn expanded(&mut self, index: usize) -> Result<u32> {
        let Pair { node, edge, job, .. } = self.work.pairs[index];
        if edge == NONE {
            return Ok(node);
        }
        let child = if job != NONE {
            match self.work.jobs[job as usize].outcome.status {
                Status::Legal => match self.store(job, node, edge)? {
                    Some(child) => child,
                    None => return Ok(self.put_back(node, edge)),
                },
                Status::Illegal => NONE,
                Status::Interrupted => return Ok(self.put_back(node, edge)),
            }
        } else {
            self.reused += 1;
            self.arena.edge(edge).child
        };
        if child == NONE {
            self.frontier.kill(self.arena, node, edge);
        } else {
            self.frontier.attach(self.arena, child);
        }
        Ok(child)
    }

    /// As if the action had not been selected.
    fn put_back(&mut self, node: u32, edge: u32) -> u32 {
        self.frontier.untake(self.arena, node, edge);
        NONE
    }

    /// Makes job number `index` ready: `edge` of `node`.
    pub(super) fn prepare(&mut self, index: usize, node: u32, edge: u32) {
        if self.work.jobs.len() == index {
            self.work.jobs.push(Job::default());
        }
        let job = &mut self.work.jobs[index];
        let from = self.arena.node(node);
        job.from.clone_from(&from.state);
        job.action.clone_from(&self.arena.edge(edge).action);
        job.key = from.key.child(u64::from(edge - from.first));
        job.level = from.level + 1;
        job.outcome.clear();
    }

    /// Runs the first `count` jobs on all workers.
    pub(super) fn execute(&mut self, count: usize) -> Result<()> {
        if count == 0 {
            return Ok(());
        }
        let begin = self.run.stop.elapsed();
        let jobs = &mut self.work.jobs[..count];
        let (domain, stop) = (self.domain, self.run.stop);
        let step = |scratch: &mut D::Scratch, group: &mut [Job<D>]| domain.step(scratch, group, stop);
        self.run.pool.for_each_group(jobs, domain.group_size(), &self.work.scratches, step)?;
        self.step_time += self.run.stop.elapsed().saturating_sub(begin);
        let done = jobs.iter().filter(|job| job.outcome.status != Status::Interrupted).count();
        self.simulations += done as u64;
        if done < count && !stop.requested() {
            // The domain gave up unasked. Trying again would do the same for ever.
            stop.interrupt();
        }
        Ok(())
    }

    /// Stores the outcome of a job as a ghost below `edge` of `node`. None where the budget of bytes has no room for it: the
    /// search ends with this wave.
    pub(super) fn store(&mut self, job: u32, node: u32, edge: u32) -> Result<Option<u32>> {
        let job_index = job as usize;
        let job = &self.work.jobs[job_index];
        check(&job.outcome)?;
        let actions = if job.outcome.terminal { 0 } else { job.outcome.candidates.len() };
        if self.full || !self.fits(actions) {
            self.full = true;
            return Ok(None);
        }
        let job = &mut self.work.jobs[job_index];
        Ok(Some(self.arena.push(node, edge, job.key, self.params.discount, &mut job.outcome)))
    }
}

/// Numbers that are not finite would make every later comparison meaningless.
pub(super) fn check<D: Domain>(outcome: &Outcome<D>) -> Result<()> {
    let numbers = [("value", outcome.value), ("quality", outcome.quality), ("cost", outcome.cost)].into_iter();
    let numbers = numbers.chain(outcome.discount.map(|discount| ("discount", discount)));
    let priors = outcome.candidates.iter().map(|candidate| ("prior", f64::from(candidate.prior)));
    match numbers.chain(priors).find(|(_, number)| !number.is_finite()) {
        None => Ok(()),
        Some((name, number)) => Err(Error::Internal(format!("a simulated state has the {name} {number}"))),
    }
}
