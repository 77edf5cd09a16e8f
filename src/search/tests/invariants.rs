//! What must hold of every tree, whatever made it.

use proptest::prelude::*;

use super::*;
use crate::search::arena::UNSOLVED;

/// Counts everything anew and compares.
pub(super) fn check<D: Domain>(tree: &Tree<D>, name: &str) {
    let arena = &tree.arena;
    let max_depth = tree.frontier.max_depth;
    let mut open = vec![0; arena.len()];
    let mut solved = vec![UNSOLVED; arena.len()];
    for id in (0..arena.len() as u32).rev() {
        let (node, stats) = (arena.node(id), arena.stat(id));
        assert_eq!(stats.virtual_visits, 0, "{name}");
        assert_eq!(stats.pending, 0, "{name}");
        let edges = || arena.edges_of(id).map(|edge| arena.edge(edge));
        let of = |kind| edges().filter(|edge| edge.tried == kind).count() as u32;
        assert_eq!(of(Tried::Pending), 0);
        assert_eq!(of(Tried::No), stats.untried);
        let mut visits = 0;
        for (edge, action) in arena.edges_of(id).zip(edges()) {
            match action.tried {
                Tried::Yes => {
                    let child = arena.node(action.child);
                    assert!(child.real && child.parent == id && child.edge == edge && child.level == node.level + 1);
                    assert_eq!(child.key, node.key.child(u64::from(edge - node.first)));
                    visits += arena.stat(action.child).visits;
                }
                Tried::No if action.child != NONE => {
                    let ghost = arena.node(action.child);
                    assert!(!ghost.real && ghost.parent == id && ghost.edge == edge);
                    assert!(tree.params.reuse_rollouts, "{name}");
                }
                _ => {}
            }
        }
        if node.real {
            // A visit ends here (as a new node, or as a revisit) or goes on to one child.
            assert!(stats.visits >= visits, "{name}");
            // No visit ends at a node on the way to an adopted solution.
            assert!(id == 0 || stats.visits > visits || tree.params.adopt_solutions);
            assert!(id == 0 || stats.visits > 0);
            assert_eq!(arena.top(id).len(), (stats.visits as usize).min(tree.params.remembered()));
            assert!(arena.top(id).is_sorted_by(|a, b| a >= b));
            if stats.visits > 0 {
                assert_eq!(arena.top(id)[0], stats.best);
            }
            open[id as usize] += if node.level < max_depth { stats.untried } else { 0 };
            if node.terminal {
                solved[id as usize] = node.level;
            }
        } else {
            assert_eq!(stats.visits, 0);
        }
        assert_eq!((stats.open, stats.solved), (open[id as usize], solved[id as usize]), "{name}");
        if id > 0 {
            let parent = node.parent as usize;
            assert!(parent < id as usize);
            open[parent] += open[id as usize];
            solved[parent] = solved[parent].min(solved[id as usize]);
        }
    }
    assert_eq!(tree.frontier.solution, solved.first().copied().unwrap_or(UNSOLVED));
    assert_eq!(tree.frontier.nodes, tree.nodes().count() as u64);
    let unfinished = tree.nodes().filter(|node| node.untried > 0).map(|node| node.level).min();
    let complete = unfinished.unwrap_or(u32::MAX).min(max_depth);
    assert_eq!(tree.frontier.proved(), tree.frontier.solution.min(complete + 1), "{name}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_tree_is_consistent(
        tree_seed in 0u64..1000, seed in 0u64..1000, branching in 1u32..12, illegal in 0.0..0.9, solutions in 0.0..0.2,
        end in 1u32..12, lanes in 1u32..40, depth in 1u32..7, extra in 0u32..4, iterations in 1u64..250,
    ) {
        let toy = Toy { seed: tree_seed, branching, illegal, solutions, end, ..Toy::default() };
        for (name, params) in all_params() {
            let lanes = if params.lanes > 1 { lanes } else { 1 };
            let params = Params { lanes, max_depth: depth, rollout_extra: extra, ..params };
            let (mut tree, report) = search(&toy, &params, seed, iterations, 1);
            check(&tree, name);
            prop_assert!(report.iterations <= iterations);
            prop_assert_eq!(u64::from(tree.arena.stat(0).visits), report.iterations);
            if let Some(best) = report.best_action {
                prop_assert!(tree.advance(best));
                check(&tree, name);
            }
        }
    }
}
