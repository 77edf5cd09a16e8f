//! Solutions that rollouts meet become nodes of the tree.

use super::*;
use crate::error::Error;

/// A search that takes a shortest known solution, if it knows one.
fn adopting(lanes: u32) -> Params {
    Params { adopt_solutions: true, prefer_solution: true, ..Params::pmbs(lanes) }
}

/// Solutions within the depth limit that only rollouts have seen.
fn ghosts_of_solutions(tree: &Tree<Toy>) -> usize {
    let known = |&id: &u32| {
        let node = tree.arena.node(id);
        node.terminal && !node.real && node.level <= tree.frontier.max_depth
    };
    (0..tree.arena.len() as u32).filter(known).count()
}

#[test]
fn a_single_rollout_that_meets_a_solution_gives_a_whole_plan() {
    let (mut plans, mut deeper) = (0, 0);
    for seed in 0..200 {
        let toy = Toy { seed, solutions: 0.05, ..Toy::default() };
        let params = Params { discount: 0.5, ..adopting(1) };
        let (tree, report) = search(&toy, &params, seed, 1, 1);
        let (off, plain) = search(&toy, &Params { adopt_solutions: false, ..params }, seed, 1, 1);
        assert_eq!(report.simulations, plain.simulations, "the same is simulated");
        let ghosts = (0..off.arena.len() as u32).map(|id| off.arena.node(id)).filter(|node| node.terminal);
        let met = ghosts.map(|node| node.level).min().filter(|level| *level <= params.max_depth);
        assert_eq!(report.solution_level, met, "seed {seed}");
        invariants::check(&tree, "one rollout");
        let Some(level) = met else {
            assert_eq!(dump(&tree), dump(&off), "without a solution nothing is different");
            continue;
        };
        plans += 1;
        deeper += u32::from(level > 1);
        // Every node of the plan has the one visit, and the return of the solution at its distance.
        let path = tree.best_path();
        assert_eq!(path.len(), level as usize);
        let solution = &path[path.len() - 1];
        assert!(solution.terminal && path[..path.len() - 1].iter().all(|node| !node.terminal));
        for (place, node) in path.iter().enumerate() {
            assert_eq!((node.level, node.visits), (place as u32 + 1, 1));
            let expected = (node.level..level).fold(solution.value, |value, _| value * params.discount);
            // An ancestor's own value counts where it is greater.
            assert!(node.mean >= expected && (node.mean == expected || expected < 0.1), "{} {expected}", node.mean);
        }
        assert_eq!((report.nodes, report.depth), (u64::from(level) + 1, level));
        // The limit falls to the solution's level, if it lies below it.
        assert_eq!(tree.frontier.max_depth, level);
        assert_eq!(tree.frontier.rollout_extra, if level < params.max_depth { 0 } else { params.rollout_extra });
    }
    assert!(plans > 20 && deeper > 10, "{plans} {deeper}");
}

#[test]
fn no_solution_within_the_limit_stays_a_ghost() {
    // One rollout per pair, so every solution is the best that its pair meets.
    for lanes in [1, 8, 64] {
        for seed in 0..20 {
            let toy = Toy { seed, solutions: 0.04, ..Toy::default() };
            let fixed = Params { leaf_parallel: false, early_stop: EarlyStop::Never, ..adopting(lanes) };
            for params in [fixed, Params { shrink_depth_on_solution: false, ..fixed }] {
                let (tree, report) = search(&toy, &params, seed, 150, 1);
                invariants::check(&tree, "adopted");
                assert_eq!(ghosts_of_solutions(&tree), 0, "seed {seed}, {lanes} lanes");
                let path = tree.best_path();
                if let Some(level) = report.solution_level {
                    assert_eq!(path.len(), level as usize);
                    assert!(path[path.len() - 1].terminal);
                }
            }
        }
    }
}

#[test]
fn several_rollouts_of_a_pair_give_it_their_best_solution_within_the_limit() {
    // Without a discount a longer way to a better solution has the greater return; beyond the limit it is of no use.
    let mut found = 0;
    for seed in 0..60 {
        let toy = Toy { seed, branching: 4, solutions: 0.1, illegal: 0.0, ..Toy::default() };
        let params = Params { discount: 1.0, max_depth: 3, rollout_extra: 6, ..adopting(64) };
        let (tree, report) = search(&toy, &params, seed, 1, 1);
        invariants::check(&tree, "leaf parallel");
        let ids = || (0..tree.arena.len() as u32).map(|id| tree.arena.node(id)).filter(|node| node.terminal);
        let within = ids().filter(|node| node.level <= params.max_depth);
        let best = within.max_by(|a, b| a.value.total_cmp(&b.value));
        assert_eq!(report.solution_level, best.map(|node| node.level), "seed {seed}");
        found += u32::from(best.is_some_and(|best| ids().any(|other| other.value > best.value)));
        assert!(best.is_none_or(|node| node.real));
    }
    assert!(found > 5, "{found}");
}

#[test]
fn threads_do_not_change_what_is_adopted() {
    for lanes in [1, 8, 64] {
        for seed in 0..5 {
            let toy = Toy { seed, solutions: 0.03, ..Toy::default() };
            for params in [adopting(lanes), Params { early_stop: EarlyStop::Never, ..adopting(lanes) }] {
                let (tree, report) = search(&toy, &params, seed, 200, 1);
                let wanted = dump(&tree);
                for threads in [2, 5] {
                    let (tree, other) = search(&toy, &params, seed, 200, threads);
                    assert!(dump(&tree) == wanted, "seed {seed}, {lanes} lanes, {threads} threads");
                    assert_eq!((other.simulations, other.nodes), (report.simulations, report.nodes));
                }
            }
        }
    }
}

#[test]
fn plans_are_known_earlier() {
    let (mut with, mut without) = (0, 0);
    for seed in 0..100 {
        let toy = Toy { seed, solutions: 0.01, branching: 8, ..Toy::default() };
        let solved = |adopt_solutions| {
            let params = Params { adopt_solutions, ..adopting(8) };
            u32::from(search(&toy, &params, seed, 40, 1).1.solution_level.is_some())
        };
        with += solved(true);
        without += solved(false);
    }
    assert!(with > without + 20, "{with} {without}");
}

#[test]
fn adopting_needs_the_states_of_rollouts() {
    let params = Params { reuse_rollouts: false, ..adopting(1) };
    match params.validate() {
        Err(Error::Argument { field, .. }) => assert_eq!(field, "adopt_solutions"),
        other => panic!("{other:?}"),
    }
    let pool = Pool::inline();
    let run = Run { pool: &pool, stop: &Stop::never(), budget: Budget::iterations(5), progress: None };
    let toy = Toy::default();
    assert!(Tree::new().search(&toy, &toy.start(), &params, 1, &run).is_err());
}
