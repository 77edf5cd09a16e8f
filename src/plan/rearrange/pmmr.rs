//! `pmmr`: parallel Monte Carlo tree search for multi-primitive rearrangement (REMP, "Adapting MCTS").
//!
//! The text's parameters are [`Params::pmmr`]; its action space is that of [`super::samplers`]. Where the text is silent:
//! "a direct move is prioritized" is a prior of 1 against 0, by which expansion and the biased simulation choose; an
//! action whose drag has no path is illegal, and a rollout then tries another; the discount counts every action from
//! the root on.
//!
//! Tuned, it differs in three things. Moves are proposed by the dependency graph: goals that are free, and for bodies in
//! the way, the places where they block least. Solutions that rollouts meet are kept, and limit the depth from then on.
//! And a decision ends when its plan has as few moves as any can have, or has not become shorter for a while.

use std::sync::Arc;

use super::domain::{Proposals, Reached, Rearrange};
use super::improve::{Candidate, Found, candidate};
use super::mover::Mover;
use super::options::RearrangeOptions;
use super::outcome::RankedMove;
use super::table::Layout;
use super::untangle::lower_bound;
use crate::action::Move;
use crate::error::Result;
use crate::plan::Variant;
use crate::run::{Budget, Pool, Progress, Stop};
use crate::search::{EndReason, Params, Run, Tree};

/// Lanes of the search: the cores of the source's machine.
const LANES: u32 = 10;
/// Places proposed for a body in the way of others and for one that is not.
const PLACES: usize = 6;
const RANDOM: usize = 1;
/// Iterations between two looks at the plan, and looks without a shorter one after which a decision ends, and after
/// which it ends if no plan can be shorter.
const SLICE: u64 = 200;
const PATIENCE: u32 = 10;
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
    mover: &Arc<Mover>,
    known: Option<Vec<Move>>,
    means: &Means,
) -> Result<(Found, Vec<RankedMove>)> {
    let tuned = means.options.variant == Variant::Tuned;
    let params = params(means.options, mover.table.len());
    let proposals = if tuned {
        Proposals::Ranked { places: PLACES, random: RANDOM }
    } else {
        Proposals::Sampled(means.options.samples)
    };
    let domain = Rearrange::new(Arc::clone(mover), proposals, means.options.reward);
    let start = Layout::new(&mover.table.problem.start);
    let mut found = Found { at_least: lower_bound(mover, &start), ..Found::default() };
    found.best.misplaced = usize::MAX;
    if let Some(moves) = known {
        found.best = candidate(mover, &start, moves);
    }
    let root = Reached { state: start.state.clone(), ..Reached::default() };
    let mut idle = 0;
    let mut planted = false;
    loop {
        let proven = found.best.solved && found.best.moves.len() <= found.at_least;
        found.settled = tuned && found.best.solved && (proven || idle >= PATIENCE);
        let left = means.budget.iterations.map_or(u64::MAX, |most| most.saturating_sub(found.attempts));
        if found.settled || left == 0 || means.stop.requested() {
            break;
        }
        let slice = if tuned { SLICE.min(left) } else { left };
        let iterations = (slice < u64::MAX).then_some(slice);
        let budget = Budget { iterations, seconds: None, bytes: means.budget.bytes };
        let run = Run { pool: means.pool, stop: means.stop, budget, progress: means.progress };
        let report = if planted {
            tree.resume(&domain, &params, &run)?
        } else {
            tree.search(&domain, &root, &params, means.seed, &run)?
        };
        planted = true;
        found.attempts += report.iterations;
        idle += 1;
        if keep(mover, &start, tree, &mut found.best) {
            idle = 0;
        }
        if report.reason != EndReason::Iterations {
            found.settled = matches!(report.reason, EndReason::Exhausted | EndReason::Solved);
            break;
        }
    }
    let considered = if planted { considered(tree) } else { Vec::new() };
    Ok((found, considered))
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
