//! The same search gives the same bits, whatever runs it.

use proptest::prelude::*;

use super::*;

/// Compares with a committed file; `UPDATE_GOLDEN=1` writes it instead.
fn check_golden(name: &str, text: &str) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/search_{name}.txt"));
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, text).unwrap();
    }
    let wanted = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(wanted == text, "{name} differs from {}; it is now\n{text}", path.display());
}

#[test]
fn whole_trees_are_as_recorded() {
    let toy = Toy { seed: 12, branching: 6, ..Toy::default() };
    for (name, params) in all_params() {
        let (tree, report) = search(&toy, &params, 7, 40, 1);
        let path: Vec<_> = tree.best_path().iter().map(|node| node.action.unwrap().0).collect();
        let head = format!(
            "{:?} iterations={} simulations={} reused={} waves={} nodes={} depth={} solution={:?} proved={}\npath={path:?} score={:?}\n",
            report.reason,
            report.iterations,
            report.simulations,
            report.reused,
            report.waves,
            report.nodes,
            report.depth,
            report.solution_level,
            report.proved_level,
            report.best_value,
        );
        check_golden(name, &(head + &dump(&tree)));
    }
}

#[test]
fn threads_and_groups_do_not_change_a_bit() {
    for lanes in [1, 8, 64] {
        for (name, params) in all_params() {
            let params = Params { lanes, ..params };
            let (tree, report) = search(&Toy::default(), &params, 3, 300, 1);
            let wanted = dump(&tree);
            for (threads, group) in [(1, 8), (2, 1), (2, 8), (5, 1), (5, 3)] {
                let toy = Toy { group, ..Toy::default() };
                let (tree, other) = search(&toy, &params, 3, 300, threads);
                assert!(dump(&tree) == wanted, "{name}, {lanes} lanes, {threads} threads, groups of {group}");
                assert_eq!(other.simulations, report.simulations);
            }
        }
    }
}

#[test]
fn a_used_tree_searches_like_a_new_one() {
    let toy = Toy::default();
    let pool = Pool::inline();
    let run = Run { pool: &pool, stop: &Stop::never(), budget: Budget::iterations(100), progress: None };
    let mut used = Tree::new();
    for (name, params) in all_params() {
        for seed in 0..3 {
            used.search(&toy, &toy.start(), &params, seed, &run).unwrap();
            let (new, _) = search(&toy, &params, seed, 100, 1);
            assert!(dump(&used) == dump(&new), "{name}");
        }
    }
}

#[test]
fn another_seed_is_another_search() {
    let params = Params::vft();
    let (a, _) = search(&Toy::default(), &params, 1, 50, 1);
    let (b, _) = search(&Toy::default(), &params, 2, 50, 1);
    assert_ne!(dump(&a), dump(&b));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    /// Keeping rollouts is a cache: it saves simulations and decides nothing.
    #[test]
    fn keeping_rollouts_changes_no_decision(
        tree_seed in 0u64..1000, seed in 0u64..1000, branching in 1u32..9, illegal in 0.0..0.6, lanes in 1u32..20,
        iterations in 1u64..200, end in 1u32..9,
    ) {
        let toy = Toy { seed: tree_seed, branching, illegal, end, ..Toy::default() };
        // Adopted solutions are kept rollouts.
        for (name, params) in all_params().into_iter().filter(|(_, params)| !params.adopt_solutions) {
            let params = if params.lanes > 1 { Params { lanes, ..params } } else { params };
            let (with, report) = search(&toy, &Params { reuse_rollouts: true, ..params }, seed, iterations, 1);
            let (without, other) = search(&toy, &Params { reuse_rollouts: false, ..params }, seed, iterations, 1);
            prop_assert!(dump(&with) == dump(&without), "{}", name);
            prop_assert_eq!(report.best_action, other.best_action);
            prop_assert_eq!(report.simulations + report.reused, other.simulations);
            prop_assert_eq!(other.stored, other.nodes);
        }
    }
}
