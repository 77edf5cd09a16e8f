//! Tests of the search on the toy tree. Every test goes through [`search`] and [`dump`].

mod adopt;
mod determinism;
mod endings;
mod formulae;
mod invariants;
mod serial;

use std::fmt::Write;

use super::arena::{NONE, Tried};
use super::toy::Toy;
use super::*;
use crate::run::{Budget, Pool, Stop};

/// Searches with a budget of iterations on threads of its own.
fn search(toy: &Toy, params: &Params, seed: u64, iterations: u64, threads: usize) -> (Tree<Toy>, SearchReport) {
    let mut tree = Tree::new();
    let pool = Pool::new(threads, "search-test").unwrap();
    let run = Run { pool: &pool, stop: &Stop::never(), budget: Budget::iterations(iterations), progress: None };
    let report = tree.search(toy, &toy.start(), params, seed, &run).unwrap();
    (tree, report)
}

/// The whole tree as text, numbers in full; the same for the same tree whatever rollouts have left in its memory.
fn dump<D: Domain>(tree: &Tree<D>) -> String {
    let mut text = String::new();
    if tree.arena.len() > 0 {
        dump_node(tree, 0, &mut text);
    }
    text
}

fn dump_node<D: Domain>(tree: &Tree<D>, node: u32, text: &mut String) {
    let (data, stats) = (tree.arena.node(node), tree.arena.stat(node));
    let indent = data.level as usize * 2;
    let place = if data.edge == NONE { 0 } else { data.edge - tree.arena.node(data.parent).first };
    let _ = write!(text, "{:indent$}{place} n={} sum={:?} best={:?}", "", stats.visits, stats.sum, stats.best);
    let _ = write!(text, " top={:?} value={:?}", tree.arena.top(node), data.value);
    if data.terminal {
        text.push_str(" solution");
    }
    let dead: Vec<u32> = places(tree, node, Tried::Dead);
    let untried: Vec<u32> = places(tree, node, Tried::No);
    let _ = writeln!(text, " untried={untried:?} dead={dead:?}");
    for edge in tree.arena.edges_of(node) {
        if tree.arena.edge(edge).tried == Tried::Yes {
            dump_node(tree, tree.arena.edge(edge).child, text);
        }
    }
}

fn places<D: Domain>(tree: &Tree<D>, node: u32, tried: Tried) -> Vec<u32> {
    let first = tree.arena.node(node).first;
    let of_kind = |edge: &u32| tree.arena.edge(*edge).tried == tried;
    tree.arena.edges_of(node).filter(of_kind).map(|edge| edge - first).collect()
}

/// Parameter sets that between them use every option.
fn all_params() -> Vec<(&'static str, Params)> {
    let vft = Params::vft();
    let pmbs = Params::pmbs(8);
    let never = EarlyStop::Never;
    vec![
        ("vft", vft),
        (
            "vft_code",
            Params {
                expansion: Expansion::InOrder,
                returns: Return::BestPlain,
                backup: Backup::OwnIfBestPlain,
                discount: 0.6,
                ..vft
            },
        ),
        ("mcts", Params { early_stop: never, ..Params::mcts() }),
        ("mcts_text", Params { returns: Return::Last { earlier: 0.0 }, ..Params::mcts() }),
        ("guided", Params { early_stop: never, ..Params::guided() }),
        ("guided_compete", Params { early_stop: never, expansion: Expansion::Compete, ..Params::guided() }),
        ("pmmr", Params::pmmr(3)),
        ("pmbs_serial", Params::pmbs(1)),
        ("pmbs_8", Params { early_stop: never, ..pmbs }),
        (
            "pmbs_64_code",
            Params {
                first_expand: true,
                rollout_cutoff: 0.1,
                early_stop: EarlyStop::LevelComplete { first: 2, last: None },
                ..Params::pmbs(64)
            },
        ),
        (
            "waves",
            Params {
                rollout_policy: RolloutPolicy::Mix { polynomial: [-0.106, 0.231, -0.013], floor: 0.2 },
                rollout_failure: RolloutFailure::Retry,
                rollout_depth: RolloutDepth::Sum,
                rollout_extra: 1,
                returns: Return::Last { earlier: 0.5 },
                closed: Closed::Skip,
                final_choice: FinalChoice::Visits,
                lanes: 5,
                ..vft
            },
        ),
        ("waves_revisit", Params { lanes: 16, leaf_parallel: true, prefer_solution: true, ..vft }),
        ("adopt_serial", Params { adopt_solutions: true, ..Params::pmbs(1) }),
        ("adopt_8", Params { adopt_solutions: true, early_stop: never, ..pmbs }),
        (
            // The limit stays, so solutions of every length are adopted; returns are not the solutions'.
            "adopt_waves",
            Params {
                adopt_solutions: true,
                rollout_failure: RolloutFailure::Retry,
                backup: Backup::AsIs,
                returns: Return::Last { earlier: 0.5 },
                leaf_parallel: true,
                lanes: 5,
                ..vft
            },
        ),
    ]
}
