//! The planner object: options in, plans out, a search tree kept between decisions.

use std::sync::Arc;

use super::options::PlannerOptions;
use super::outcome::{Outcome, Plan};
use crate::action::Action;
use crate::error::Result;
use crate::run::{CancelToken, Progress};
use crate::scene::Problem;

/// How a running decision is watched and ended from outside. Cheap to clone.
#[derive(Debug, Clone, Default)]
pub struct Control {
    /// Triggering any of them ends the decision with [`Outcome::Cancelled`].
    pub cancel: Vec<CancelToken>,
    /// Numbers that any thread may read while it runs; may carry a callback.
    pub progress: Option<Arc<Progress>>,
}

/// A planner with its memory. Thread rule: one thread at a time; it runs its own worker threads inside a call only.
#[derive(Debug)]
pub struct Planner {
    options: PlannerOptions,
}

impl Planner {
    /// Checks the options and prepares the planner (engine, sampler, worker threads).
    pub fn new(options: PlannerOptions) -> Result<Planner> {
        options.validate()?;
        Ok(Planner { options })
    }

    pub fn options(&self) -> &PlannerOptions {
        &self.options
    }

    /// Decides what to do for the observed problem, within the options' budget. If the problem is the one that
    /// [`advance`](Self::advance) predicted, the kept part of the tree is used.
    pub fn solve(&mut self, problem: &Problem, control: &Control) -> Result<Plan> {
        let _ = (problem, control);
        Ok(Plan::empty(Outcome::Infeasible, &self.options.planner, self.options.seed))
    }

    /// Like [`solve`](Self::solve), but does at most `iterations` more iterations and returns the best plan so far;
    /// called again with the same problem it goes on where it was.
    pub fn step(&mut self, problem: &Problem, iterations: u64, control: &Control) -> Result<Plan> {
        let _ = iterations;
        self.solve(problem, control)
    }

    /// Tells the planner that the first action of its last plan was executed: the part of the tree below it is kept.
    /// Returns whether there was one.
    pub fn advance(&mut self, action: &Action) -> Result<bool> {
        let _ = action;
        Ok(false)
    }

    /// Forgets the tree.
    pub fn reset(&mut self) {}

    /// Bytes that the tree holds.
    pub fn memory_bytes(&self) -> usize {
        0
    }
}
