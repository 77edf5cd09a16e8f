//! `pmmr`: parallel Monte Carlo tree search for multi-primitive rearrangement (REMP, "Adapting MCTS").
//!
//! The text's parameters are [`Params::pmmr`]; its action space is that of [`super::samplers`]. Where the text is silent:
//! "a direct move is prioritized" is a prior of 1 against 0, by which expansion and the biased simulation choose; an
//! action whose drag has no path is illegal, and a rollout then tries another; the discount counts every action from
//! the root on.
//!
//! Tuned, it differs in four things. Moves are proposed by the dependency graph: goals that are free, and for bodies in
//! the way, the places where they block least. Half of the budget goes to attempts of `untangle` ([`super::improve`]),
//! and the tree is then searched for a plan with fewer moves. Solutions that rollouts meet are kept, and limit the depth
//! from then on. And a decision ends when its plan has as few moves as any can have, or has not become shorter for a
//! while; one that begins with the plan of an earlier decision has 1/D of the seconds.

use std::sync::{Arc, Mutex};

use super::domain::{Proposals, Reached, Rearrange};
use super::improve::{self, Candidate, Found, Limits, candidate};
use super::mover::Mover;
use super::options::RearrangeOptions;
use super::outcome::RankedMove;
use super::table::Layout;
use super::untangle::{Worker, lower_bound};
use crate::action::Move;
use crate::error::Result;
use crate::plan::Variant;
use crate::run::{Budget, Pool, Progress, Stop, StopReason};
use crate::search::{EndReason, Params, Run, Told, Tree};

/// Lanes of the search: the cores of the source's machine.
const LANES: u32 = 10;
/// Attempts between two updates of the best plan.
const ATTEMPTS: usize = 16;
/// Places proposed for a body in the way of others and for one that is not.
const PLACES: usize = 6;
const RANDOM: usize = 1;
/// Part of the budget for attempts before the tree.
const FIRST: f64 = 0.5;
/// Iterations between two looks at the plan, and looks without a shorter one after which a decision ends; the latter is
/// less where an earlier decision has made the plan.
const SLICE: u64 = 200;
const PATIENCE: u32 = 10;
const PATIENCE_KNOWN: u32 = 1;
/// Iterations of that one look.
const SLICE_KNOWN: u64 = 40;
/// First moves that a plan lists.
const CONSIDERED: usize = 16;

/// What a decision may use.
pub struct Means<'a> {
    pub options: &'a RearrangeOptions,
    pub pool: &'a Pool,
    pub stop: &'a Stop,
    pub budget: Budget,
    pub progress: Option<&'a Progress>,
    pub seed: u64,
    /// Most moves of a plan.
    pub max_moves: usize,
}

/// The parameters that the options lead to, for a problem of so many bodies.
pub fn params(options: &RearrangeOptions, bodies: usize) -> Params {
    if let Some(params) = options.search {
        return params;
    }
    let text = Params { lanes: options.lanes.map_or(LANES, |lanes| lanes as u32), ..Params::pmmr(bodies) };
    let text = Params { max_depth: options.max_depth.unwrap_or(text.max_depth), ..text };
    match options.variant {
        Variant::Tuned => {
            Params { prefer_solution: true, adopt_solutions: true, shrink_depth_on_solution: true, ..text }
        }
        Variant::Dissertation | Variant::Code => Params { reuse_rollouts: false, ..text },
    }
}

/// One decision; `known` is a plan to begin with.
pub fn search(
    tree: &mut Tree<Rearrange>,
    workers: &mut Vec<Mutex<Worker>>,
    mover: &Arc<Mover>,
    known: Option<Vec<Move>>,
    means: &Means,
) -> Result<(Found, Vec<RankedMove>)> {
    let tuned = means.options.variant == Variant::Tuned;
    let mut params = params(means.options, mover.table.len());
    let proposals = if tuned {
        Proposals::Ranked { places: PLACES, random: RANDOM }
    } else {
        Proposals::Sampled(means.options.samples)
    };
    let domain = Rearrange::new(Arc::clone(mover), proposals, means.options.reward);
    let start = Layout::new(&mover.table.problem.start);
    // All decisions that begin with a plan take no longer together than the first, which made it.
    let share = if tuned && known.is_some() { 1.0 / f64::from(params.max_depth.max(1)) } else { 1.0 };
    let (whole, stop) = (means.stop, means.stop.sooner(share));
    let means = &Means { stop: &stop, ..*means };
    let mut patience = if known.is_some() { PATIENCE_KNOWN } else { PATIENCE };
    let mut found = if tuned { first(workers, mover, known, means)? } else { Found::default() };
    if !tuned {
        found.at_least = lower_bound(mover, &start, means.stop);
        found.best.misplaced = usize::MAX;
    } else if found.best.solved && means.options.search.is_none() {
        // Only a plan with fewer moves is of use.
        params.max_depth = params.max_depth.min(found.best.moves.len().saturating_sub(1).max(1) as u32);
    } else {
        patience = PATIENCE;
    }
    let root = Reached { state: start.state.clone(), ..Reached::default() };
    let mut idle = 0;
    let mut planted = false;
    // What was done before each slice, by `untangle` too, which tells its attempts: progress goes forward.
    let attempts = found.attempts;
    let mut told = means.progress.map(|progress| Told { progress, iterations: attempts, simulations: attempts });
    loop {
        let proven = found.best.solved && found.best.moves.len() <= found.at_least;
        found.settled = tuned && found.best.solved && (proven || idle >= patience);
        let left = means.budget.iterations.map_or(u64::MAX, |most| most.saturating_sub(found.attempts));
        if found.settled || left == 0 || means.stop.requested() {
            break;
        }
        let own = if patience == PATIENCE { SLICE } else { SLICE_KNOWN };
        let slice = if tuned { own.min(left) } else { left };
        let iterations = (slice < u64::MAX).then_some(slice);
        let budget = Budget { iterations, seconds: None, bytes: means.budget.bytes };
        let run = Run { pool: means.pool, stop: means.stop, budget, progress: told };
        let report = if planted {
            tree.resume(&domain, &params, &run)?
        } else {
            tree.search(&domain, &root, &params, means.seed, &run)?
        };
        planted = true;
        told = told.map(|told| told.and(&report));
        found.attempts += report.iterations;
        idle += 1;
        if keep(mover, &start, tree, &mut found.best) {
            idle = 0;
        }
        if report.reason != EndReason::Iterations {
            // A tree whose moves were broken off has tried nothing to its end.
            let ended = matches!(report.reason, EndReason::Exhausted | EndReason::Solved);
            found.settled = ended && !means.stop.requested();
            found.full = report.reason == EndReason::Memory;
            break;
        }
    }
    if stop.reason() == Some(StopReason::Interrupted) {
        whole.interrupt();
    }
    let considered = if planted { considered(tree) } else { Vec::new() };
    Ok((found, considered))
}

/// Attempts of `untangle` with the first part of the budget.
fn first(
    workers: &mut Vec<Mutex<Worker>>,
    mover: &Arc<Mover>,
    known: Option<Vec<Move>>,
    means: &Means,
) -> Result<Found> {
    let stop = means.stop.sooner(FIRST);
    let iterations = means.budget.iterations.map(|most| ((most as f64 * FIRST) as u64).max(1));
    let limits = Limits {
        pool: means.pool,
        stop: &stop,
        budget: Budget { iterations, ..means.budget },
        progress: means.progress,
        lanes: ATTEMPTS,
        max_moves: means.max_moves,
        seed: means.seed,
    };
    let found = improve::search(mover, workers, known, &limits)?;
    if stop.reason() == Some(StopReason::Interrupted) {
        means.stop.interrupt();
    }
    Ok(found)
}

/// Takes the tree's plan if it is better than the best so far.
fn keep(mover: &Mover, start: &Layout, tree: &Tree<Rearrange>, best: &mut Candidate) -> bool {
    let moves = tree.best_path().iter().filter_map(|node| node.state.last.clone()).collect();
    let new = candidate(mover, start, moves);
    let shorter = new.solved && (!best.solved || new.moves.len() < best.moves.len());
    if shorter || !best.solved || new.solved && new.moves.len() == best.moves.len() && new.seconds < best.seconds {
        *best = new;
    }
    shorter
}

fn considered(tree: &Tree<Rearrange>) -> Vec<RankedMove> {
    let mut ranked: Vec<RankedMove> = tree
        .root_children()
        .filter_map(|child| {
            let node = child.node?;
            Some(RankedMove {
                action: node.state.last.clone()?,
                value: child.score.unwrap_or(node.mean),
                best_return: node.best,
                visits: u64::from(node.visits),
                prior: f64::from(child.prior),
                solution_level: node.solved_level,
            })
        })
        .collect();
    // Stable: equal values stay in the sampler's order.
    ranked.sort_by(|a, b| b.value.total_cmp(&a.value));
    ranked.truncate(CONSIDERED);
    ranked
}
