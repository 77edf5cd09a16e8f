//! The final choice: which child of a node is best, and the path that follows from it.

use std::cmp::Ordering;

use super::arena::{Arena, Stats, Tried, UNSOLVED};
use super::domain::Domain;
use super::params::{FinalChoice, Mean, Params};

/// A child with its score.
#[derive(Debug, Clone, Copy)]
pub(super) struct Choice {
    pub edge: u32,
    pub child: u32,
    pub score: f64,
}

/// The score of a child by [`FinalChoice`]. The child has been visited.
pub(super) fn score<D: Domain>(arena: &Arena<D>, params: &Params, child: u32, prior: f32) -> f64 {
    let stats = arena.stat(child);
    match params.final_choice {
        FinalChoice::Returns(Mean::All) => stats.sum / f64::from(stats.visits),
        FinalChoice::Returns(Mean::Top(m)) => {
            let top = arena.top(child);
            let top = &top[..top.len().min(m as usize)];
            top.iter().sum::<f64>() / top.len() as f64
        }
        FinalChoice::ReturnsAndPrior { limit } => stats.best + f64::from(prior).clamp(0.0, limit),
        FinalChoice::Visits => f64::from(stats.visits),
        FinalChoice::Prior => f64::from(prior),
    }
}

/// The best visited child of a node. With `prefer_solution` those that lead to a shallowest solution come first.
pub(super) fn best_child<D: Domain>(arena: &Arena<D>, params: &Params, node: u32) -> Option<Choice> {
    best_of(arena, params, node, params.prefer_solution)
}

fn best_of<D: Domain>(arena: &Arena<D>, params: &Params, node: u32, solution_first: bool) -> Option<Choice> {
    let mut best: Option<Choice> = None;
    for edge in arena.edges_of(node) {
        let (child, prior) = (arena.edge(edge).child, arena.edge(edge).prior);
        if arena.edge(edge).tried != Tried::Yes || arena.stat(child).visits == 0 {
            continue;
        }
        let choice = Choice { edge, child, score: score(arena, params, child, prior) };
        if best.is_none_or(|best| compare(arena, &choice, &best, solution_first) == Ordering::Greater) {
            best = Some(choice);
        }
    }
    best
}

/// Score, then the shorter solution, then its quality, then the lower cost; the first of full equals stays.
fn compare<D: Domain>(arena: &Arena<D>, a: &Choice, b: &Choice, solution_first: bool) -> Ordering {
    let (x, y) = (arena.stat(a.child), arena.stat(b.child));
    let level = y.solved.cmp(&x.solved);
    let cost = |stats: &Stats, child: u32| {
        if stats.solved == UNSOLVED { arena.node(child).cost } else { stats.solved_cost }
    };
    let quality = |stats: &Stats| if stats.solved == UNSOLVED { 0.0 } else { stats.solved_quality };
    let first = if solution_first { level } else { Ordering::Equal };
    first
        .then(a.score.total_cmp(&b.score))
        .then(level)
        .then(quality(x).total_cmp(&quality(y)))
        .then(cost(y, b.child).total_cmp(&cost(x, a.child)))
}

/// The nodes of the best path below the root: the final choice there, then towards the shallowest solution below it,
/// and where there is none the best children down to the last.
pub(super) fn best_path<D: Domain>(arena: &Arena<D>, params: &Params) -> Vec<u32> {
    let mut path = Vec::new();
    if arena.len() == 0 {
        return path;
    }
    let mut next = best_child(arena, params, 0);
    while let Some(choice) = next {
        path.push(choice.child);
        let ended = arena.node(choice.child).terminal;
        next = if ended { None } else { best_of(arena, params, choice.child, true) };
    }
    path
}
