//! Trying plans in a second engine before the decision: the search affords a cheap engine, the decision a faithful one.
//!
//! Every solution in the tree is a plan. The chosen one and its best rivals are executed from the observed state in the
//! confirming engine, all side by side, one push after the other. Of those that free the target there too, the one with
//! the fewest pushes is returned, and of these the one with the best grasp. Where none does, the search
//! goes on for a while (`decision`); in the end its own choice stands, as the best that is known.

use std::cmp::Reverse;
use std::sync::{Arc, Mutex};

use super::retrieval::{Retrieval, Scratch};
use crate::action::{Grasp, Push};
use crate::error::Result;
use crate::grasp::GraspAssessment;
use crate::physics::{PushJob, PushResult, PushStatus, Scratch as EngineScratch, Transition};
use crate::run::{Pool, Stop};
use crate::scene::State;
use crate::search::Tree;

/// Most plans that are tried.
const PLANS: usize = 24;
/// Plans of at most this many pushes more than the shortest are tried.
const LONGER: u32 = 1;
/// Share of a decision's time that the search may use; the rest is for trying.
pub const SEARCH_SHARE: f64 = 0.7;

/// A plan that succeeds in the confirming engine.
pub struct Confirmed {
    /// The pushes, each with the state after it in the confirming engine.
    pub pushes: Vec<(Push, State)>,
    pub grasp: Grasp,
    pub score: f64,
}

/// A first push with what it came to in perturbed worlds.
#[derive(Clone, Copy)]
pub struct Weighed {
    pub push: Push,
    pub chance: f64,
    pub expected: f64,
}

/// What trying the plans came to.
#[derive(Default)]
pub struct Verdict {
    pub best: Option<Confirmed>,
    pub tried: u64,
    pub confirmed: u64,
    pub simulations: u64,
    /// Of the best plan in perturbed worlds: share of them in which it succeeds, mean number of actions, their number.
    pub chance: Option<f64>,
    pub expected: Option<f64>,
    pub worlds: u64,
    /// The first pushes that were weighed in perturbed worlds, best first.
    pub weighed: Vec<Weighed>,
    /// Wall-clock time.
    pub seconds: f64,
}

/// A plan on its way through the confirming engine.
struct Try {
    pushes: Vec<Push>,
    /// States after the pushes so far.
    states: Vec<State>,
    /// Place in the search's order: the chosen plan first.
    rank: usize,
    end: End,
}

enum End {
    UnderWay,
    Failed,
    Freed(GraspAssessment),
}

/// A push shared by all tries that begin alike.
struct Shared {
    from: State,
    push: Push,
    result: PushResult,
    /// Of the state it led to; none if the push is of no use.
    verdict: Option<GraspAssessment>,
}

/// The plans of one decision in the confirming engine.
pub struct Confirmation<'a> {
    domain: &'a Retrieval,
    engine: &'a Arc<dyn Transition>,
    pool: &'a Pool,
    stop: &'a Stop,
    scratches: Vec<Mutex<(EngineScratch, Scratch)>>,
    /// Nodes whose plans were tried.
    seen: Vec<usize>,
    pub verdict: Verdict,
}

impl<'a> Confirmation<'a> {
    pub fn new(domain: &'a Retrieval, engine: &'a Arc<dyn Transition>, pool: &'a Pool, stop: &'a Stop) -> Self {
        let scratches = (0..pool.workers()).map(|_| Mutex::new((engine.scratch(), domain.new_scratch()))).collect();
        Self { domain, engine, pool, stop, scratches, seen: Vec::new(), verdict: Verdict::default() }
    }

    /// Executes the tree's plans that were not tried before. With a requested stop what is known by then counts.
    pub fn try_plans(&mut self, tree: &Tree<Retrieval>, observed: &State) -> Result<()> {
        let from = self.stop.elapsed();
        let mut tries = plans(tree, &mut self.seen);
        self.verdict.tried += tries.len() as u64;
        let longest = tries.iter().map(|t| t.pushes.len()).max().unwrap_or(0);
        for depth in 0..longest {
            if self.stop.requested() {
                break;
            }
            self.push_all(&mut tries, depth, observed)?;
        }
        self.verdict.confirmed += tries.iter().filter(|t| matches!(t.end, End::Freed(_))).count() as u64;
        // Earlier rounds confirmed nothing, or there would be no further one.
        self.verdict.best = best(tries);
        self.verdict.seconds += (self.stop.elapsed() - from).as_secs_f64();
        Ok(())
    }

    /// Executes push `depth` of every try that is under way. Tries that began alike share it.
    fn push_all(&mut self, tries: &mut [Try], depth: usize, observed: &State) -> Result<()> {
        let mut shared: Vec<Shared> = Vec::new();
        let mut of_try: Vec<Option<usize>> = Vec::with_capacity(tries.len());
        for t in &*tries {
            let open = matches!(t.end, End::UnderWay) && depth < t.pushes.len();
            of_try.push(open.then(|| {
                let (from, push) = (t.states.last().unwrap_or(observed), t.pushes[depth]);
                shared.iter().position(|s| s.push == push && s.from == *from).unwrap_or_else(|| {
                    shared.push(Shared { from: from.clone(), push, result: PushResult::default(), verdict: None });
                    shared.len() - 1
                })
            }));
        }
        self.verdict.simulations += shared.len() as u64;
        let (domain, engine, stop) = (self.domain, self.engine, self.stop);
        self.pool.for_each_group(&mut shared, engine.batch_size(), &self.scratches, |(memory, scratch), group| {
            let jobs: Vec<PushJob> = group.iter().map(|s| PushJob { state: &s.from, push: s.push }).collect();
            let mut results = vec![PushResult::default(); group.len()];
            engine.step_batch(memory, &jobs, &mut results, stop);
            for (s, result) in group.iter_mut().zip(results) {
                let useful = result.status == PushStatus::Executed && domain.useful(&s.from, &result);
                let found = useful.then(|| domain.assess(scratch, &result.state, stop));
                s.verdict = found.filter(|_| !stop.requested());
                s.result = result;
            }
        })?;
        for (t, at) in tries.iter_mut().zip(&of_try) {
            let Some(s) = at.map(|at| &shared[at]) else { continue };
            t.states.push(s.result.state.clone());
            t.end = match s.verdict {
                Some(found) if domain.solves(&found) => End::Freed(found),
                Some(_) if depth + 1 < t.pushes.len() => End::UnderWay,
                _ => End::Failed,
            };
        }
        Ok(())
    }
}

/// Fewest pushes, then the best grasp, then the search's order.
fn best(tries: Vec<Try>) -> Option<Confirmed> {
    let freed = tries.into_iter().filter_map(|t| match t.end {
        End::Freed(GraspAssessment { grasp: Some(grasp), score, .. }) => {
            Some((t.states, t.pushes, t.rank, grasp, score))
        }
        _ => None,
    });
    let (states, pushes, _, grasp, score) = freed.min_by(|a, b| {
        let (x, y) = (a.0.len(), b.0.len());
        x.cmp(&y).then(b.4.total_cmp(&a.4)).then(a.2.cmp(&b.2))
    })?;
    Some(Confirmed { pushes: pushes.into_iter().zip(states).collect(), grasp, score })
}

/// The tree's plans in the order in which they are worth trying: the chosen one, then by length, the value of the
/// first push, and the grasp. Nodes in `seen` are left out, those listed are added to it.
fn plans(tree: &Tree<Retrieval>, seen: &mut Vec<usize>) -> Vec<Try> {
    let nodes: Vec<_> = tree.nodes().collect();
    let chosen = tree.best_path().last().filter(|n| n.terminal).map(|n| n.id);
    let Some(shortest) = nodes.iter().filter(|n| n.terminal && n.level > 0).map(|n| n.level).min() else {
        return Vec::new();
    };
    // Ids are dense within the arena but `nodes` skips some: look parents up by id.
    let place = |id: usize| nodes.binary_search_by_key(&id, |n| n.id).ok();
    let mut found = Vec::new();
    for node in nodes.iter().filter(|n| n.terminal && n.level > 0 && n.level <= shortest + LONGER) {
        if seen.contains(&node.id) {
            continue;
        }
        let mut pushes = Vec::with_capacity(node.level as usize);
        let (mut at, mut first_mean) = (Some(node), 0.0);
        while let Some((here, (_, push))) = at.and_then(|n| Some((n, n.action?))) {
            pushes.push(*push);
            first_mean = here.mean;
            at = here.parent.and_then(place).map(|i| &nodes[i]);
        }
        pushes.reverse();
        if pushes.len() == node.level as usize {
            found.push((node.id, node.level, first_mean, node.quality, pushes));
        }
    }
    found.sort_by(|a, b| {
        let own = |id: usize| Reverse(chosen == Some(id));
        own(a.0)
            .cmp(&own(b.0))
            .then(a.1.cmp(&b.1))
            .then(b.2.total_cmp(&a.2))
            .then(b.3.total_cmp(&a.3))
            .then(a.0.cmp(&b.0))
    });
    found
        .into_iter()
        .take(PLANS)
        .inspect(|(id, ..)| seen.push(*id))
        .enumerate()
        .map(|(rank, (.., pushes))| Try { pushes, states: Vec::new(), rank, end: End::UnderWay })
        .collect()
}
