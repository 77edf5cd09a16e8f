//! One decision: search, try the plans found in the confirming engine, and search on where none of them succeeds there.

use std::sync::Arc;

use super::confirm::{Confirmation, SEARCH_SHARE, Verdict};
use super::retrieval::Retrieval;
use crate::error::Result;
use crate::physics::Transition;
use crate::run::{Budget, Pool, Progress, Stop, StopReason};
use crate::scene::State;
use crate::search::{EndReason, Params, Run, SearchReport, Told, Tree};

/// Searches at most, for one decision.
const ROUNDS: usize = 6;
/// Iterations of a further search, unless the planner's least is more.
const FURTHER: u64 = 128;

/// What a decision is made with.
pub(super) struct Decision<'a> {
    pub domain: &'a Retrieval,
    pub confirming: Option<&'a Arc<dyn Transition>>,
    pub params: &'a Params,
    pub budget: Budget,
    pub pool: &'a Pool,
    pub stop: &'a Stop,
    pub progress: Option<&'a Progress>,
}

/// Where the search starts.
pub(super) enum From<'a> {
    /// From a state, with a seed.
    Root(&'a State, u64),
    /// From the tree that is there.
    Tree,
}

/// What was found. The counts of the report are those of all searches.
pub(super) struct Found {
    pub report: SearchReport,
    pub verdict: Verdict,
    /// The end was asked for from outside.
    pub cancelled: bool,
}

impl Decision<'_> {
    /// Decides what to do in the observed state. On error the tree is empty.
    pub fn make(&self, tree: &mut Tree<Retrieval>, from: From<'_>, observed: &State) -> Result<Found> {
        let search_stop = self.stop.sooner(if self.confirming.is_some() { SEARCH_SHARE } else { 1.0 });
        let run = |budget, progress| Run { pool: self.pool, stop: &search_stop, budget, progress };
        let first = run(self.budget, self.progress.map(Told::from));
        let mut report = match from {
            From::Root(state, seed) => tree.search(self.domain, state, self.params, seed, &first)?,
            From::Tree => tree.resume(self.domain, self.params, &first)?,
        };
        let mut confirmation =
            self.confirming.map(|engine| Confirmation::new(self.domain, engine, self.pool, self.stop));
        for _ in 1..ROUNDS {
            let Some(confirmation) = confirmation.as_mut().filter(|_| !asked(&report, &search_stop)) else { break };
            confirmation.try_plans(tree, observed)?;
            let left = self.budget.iterations.map(|most| most.saturating_sub(report.iterations));
            // A search that ended by itself can go on and find other plans; one that used its budget cannot.
            if confirmation.verdict.best.is_some() || report.reason != EndReason::Solved || left == Some(0) {
                break;
            }
            let params = Params { min_iterations: self.params.min_iterations.max(FURTHER), ..*self.params };
            let told = self.progress.map(|progress| Told::from(progress).and(&report));
            let further = tree.resume(self.domain, &params, &run(Budget { iterations: left, ..self.budget }, told))?;
            report = both(&report, further);
        }
        let verdict = confirmation.map(|c| c.verdict).unwrap_or_default();
        Ok(Found { cancelled: asked(&report, &search_stop) || cancelled(self.stop), report, verdict })
    }
}

/// The later report with the counts of both searches.
pub(super) fn both(earlier: &SearchReport, later: SearchReport) -> SearchReport {
    SearchReport {
        iterations: earlier.iterations + later.iterations,
        simulations: earlier.simulations + later.simulations,
        reused: earlier.reused + later.reused,
        waves: earlier.waves + later.waves,
        time: earlier.time + later.time,
        step_time: earlier.step_time + later.step_time,
        ..later
    }
}

/// The request may have come while the search found its end, and the progress callback asks the search alone.
pub(super) fn asked(report: &SearchReport, stop: &Stop) -> bool {
    matches!(report.reason, EndReason::Cancelled | EndReason::Interrupted) || cancelled(stop)
}

/// The end was asked for from outside. A deadline is no such request.
pub(super) fn cancelled(stop: &Stop) -> bool {
    stop.requested() && stop.reason() != Some(StopReason::Deadline)
}
