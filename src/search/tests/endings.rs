//! Every way a search can end leaves a valid tree and says why.

use std::time::Duration;

use super::*;
use crate::error::Error;
use crate::run::{CancelToken, Key, Progress};

fn inline<'a>(pool: &'a Pool, stop: &'a Stop, budget: Budget) -> Run<'a> {
    Run { pool, stop, budget, progress: None }
}

/// Too large to exhaust.
fn open_toy() -> Toy {
    Toy { solutions: 0.0, branching: 14, ..Toy::default() }
}

#[test]
fn the_budget_of_iterations_is_kept_exactly() {
    for (name, params) in all_params() {
        let params = Params { early_stop: EarlyStop::Never, ..params };
        for iterations in [1, 2, 37] {
            let (tree, report) = search(&open_toy(), &params, 1, iterations, 1);
            assert_eq!((report.reason, report.iterations), (EndReason::Iterations, iterations), "{name}");
            assert_eq!(u64::from(tree.arena.stat(0).visits), iterations);
        }
    }
}

#[test]
fn a_root_that_is_a_solution_ends_at_once() {
    let toy = Toy { solutions: 1.0, ..Toy::default() };
    let pool = Pool::inline();
    let mut tree = Tree::new();
    // The toy's start is never a solution; any other state is.
    let mut root = toy.start();
    root.length = 1;
    let report =
        tree.search(&toy, &root, &Params::vft(), 1, &inline(&pool, &Stop::never(), Budget::default())).unwrap();
    assert_eq!((report.reason, report.solution_level, report.proved_level), (EndReason::Solved, Some(0), 0));
    assert_eq!((report.iterations, report.best_action), (0, None));
    assert!(tree.best_path().is_empty());
    assert_eq!(tree.root_children().count(), 0);
}

#[test]
fn a_root_without_actions_is_exhausted() {
    for (name, params) in all_params() {
        let (tree, report) = search(&Toy { end: 0, ..Toy::default() }, &params, 1, 10, 1);
        assert_eq!((report.reason, report.iterations, report.best_action), (EndReason::Exhausted, 0, None), "{name}");
        assert_eq!(tree.nodes().count(), 1);
        let (_, report) = search(&Toy { illegal: 1.0, ..Toy::default() }, &params, 1, 10, 1);
        assert_eq!((report.reason, report.iterations, report.best_action), (EndReason::Exhausted, 0, None), "{name}");
        assert!(report.simulations > 0);
    }
}

/// Level of the shallowest solution down to `depth`, by looking at everything.
fn shortest(toy: &Toy, depth: u32) -> Option<u32> {
    let mut level = vec![toy.start()];
    for number in 1..=depth {
        let all = level.iter().flat_map(|state| (0..toy.actions(state)).filter_map(|action| toy.next(state, action)));
        level = all.collect();
        if level.iter().any(|state| toy.terminal(state)) {
            return Some(number);
        }
    }
    None
}

#[test]
fn an_exhausted_search_has_found_the_shortest_solution() {
    for (name, params) in all_params() {
        let params = Params { early_stop: EarlyStop::Never, max_depth: 4, ..params };
        for seed in 0..10 {
            let toy = Toy { seed, branching: 3, ..Toy::default() };
            // Revisits spend iterations on solutions, so an exhaustive search may need many.
            let (tree, report) = search(&toy, &Params { closed: Closed::Skip, ..params }, 1, 100_000, 1);
            assert_eq!(report.reason, EndReason::Exhausted, "{name} {seed}");
            let truth = shortest(&toy, params.max_depth);
            assert_eq!(report.solution_level, truth, "{name} {seed}");
            assert_eq!(report.proved_level, truth.unwrap_or(params.max_depth + 1), "{name} {seed}");
            let chosen = Params { prefer_solution: true, ..params };
            let path = super::super::choose::best_path(&tree.arena, &chosen);
            if let Some(level) = truth {
                assert_eq!(path.len(), level as usize);
                assert!(tree.arena.node(path[path.len() - 1]).terminal);
            }
        }
    }
}

#[test]
fn early_stop_waits_for_the_level_before() {
    let mut stopped = 0;
    for seed in 0..40 {
        let toy = Toy { seed, branching: 4, solutions: 0.05, ..Toy::default() };
        for lanes in [1, 8] {
            let (tree, report) = search(&toy, &Params::pmbs(lanes), seed, 2000, 1);
            if report.reason != EndReason::Solved {
                continue;
            }
            stopped += 1;
            let level = report.solution_level.unwrap();
            assert_eq!(report.proved_level, level);
            assert_eq!(Some(level), shortest(&toy, 7));
            // Solutions of level 1 end the search at once; others when the levels before are done.
            assert!(level == 1 || tree.nodes().all(|node| node.level + 1 >= level || node.untried == 0));
        }
    }
    assert!(stopped > 20);
}

#[test]
fn early_stop_can_be_held_back_and_bounded() {
    let toy = Toy { solutions: 0.5, ..Toy::default() };
    let (_, at_once) = search(&toy, &Params::mcts(), 1, 200, 1);
    assert_eq!(at_once.reason, EndReason::Solved);
    let (_, held) = search(&toy, &Params { min_iterations: 50, ..Params::mcts() }, 1, 200, 1);
    assert_eq!((held.reason, held.iterations), (EndReason::Solved, 50));
    let only_first = EarlyStop::LevelComplete { first: 1, last: Some(1) };
    let deep = Toy { seed: 3, solutions: 0.02, ..Toy::default() };
    assert!(shortest(&deep, 1).is_none());
    let (_, bounded) = search(&deep, &Params { early_stop: only_first, ..Params::mcts() }, 1, 400, 1);
    assert_ne!(bounded.reason, EndReason::Solved);
}

#[test]
fn a_solution_lowers_the_depth_limit() {
    let toy = Toy { solutions: 0.1, ..Toy::default() };
    let params = Params { early_stop: EarlyStop::Never, lanes: 1, ..Params::pmbs(2) };
    let (tree, report) = search(&toy, &params, 1, 100_000, 1);
    assert_eq!(report.reason, EndReason::Exhausted);
    assert_eq!(Some(tree.frontier.max_depth), report.solution_level);
    assert_eq!(tree.frontier.rollout_extra, 0);
}

#[test]
fn cancelling_within_a_step_leaves_a_tree_that_can_go_on() {
    for (name, params) in all_params() {
        for after in [1, 5, 50] {
            for threads in [1, 3] {
                let token = CancelToken::new();
                let toy = Toy { cancel: Some((after, token.clone())), ..open_toy() };
                let pool = Pool::new(threads, "cancel").unwrap();
                let stop = Budget::default().start(&[token]);
                let mut tree = Tree::new();
                let report = tree.search(&toy, &toy.start(), &params, 1, &inline(&pool, &stop, Budget::default()));
                assert_eq!(report.unwrap().reason, EndReason::Cancelled, "{name}");
                invariants::check(&tree, name);
                let more = Budget::iterations(40);
                let toy = Toy { cancel: None, ..toy };
                let report = tree.resume(&toy, &params, &inline(&pool, &Stop::never(), more)).unwrap();
                assert_eq!((report.reason, report.iterations), (EndReason::Iterations, 40), "{name}");
                invariants::check(&tree, name);
            }
        }
    }
}

#[test]
fn a_deadline_and_a_callback_end_the_search() {
    let toy = Toy { solutions: 0.0, branching: 30, ..Toy::default() };
    let pool = Pool::inline();
    let mut tree = Tree::new();
    let params = Params { max_depth: 20, ..Params::vft() };
    let stop = Budget::seconds(0.02).start(&[]);
    let report = tree.search(&toy, &toy.start(), &params, 1, &inline(&pool, &stop, Budget::default())).unwrap();
    assert_eq!(report.reason, EndReason::Deadline);
    assert!(report.iterations > 0 && report.best_action.is_some());
    assert!(report.time >= Duration::from_millis(19) && report.step_time <= report.time);

    let progress = Progress::with_callback(Duration::ZERO, |now| now.iterations < 10);
    let stop = Stop::never();
    let run = Run { progress: Some((&progress).into()), ..inline(&pool, &stop, Budget::default()) };
    let report = tree.search(&toy, &toy.start(), &params, 1, &run).unwrap();
    assert_eq!((report.reason, report.iterations), (EndReason::Interrupted, 10));
    let seen = progress.snapshot();
    assert_eq!((seen.iterations, seen.nodes, seen.simulations), (10, report.nodes, report.simulations));
    assert_eq!(seen.best_value, report.best_value);

    // Asked before it began: no root, nothing to read, nothing to resume.
    let stop = Stop::never();
    stop.interrupt();
    let report = tree.search(&toy, &toy.start(), &params, 1, &inline(&pool, &stop, Budget::default())).unwrap();
    assert_eq!((report.reason, report.iterations, report.best_action), (EndReason::Interrupted, 0, None));
}

#[test]
fn the_budget_of_memory_is_obeyed() {
    let toy = Toy { solutions: 0.0, ..Toy::default() };
    let pool = Pool::inline();
    let stop = Stop::never();
    let mut tree = Tree::new();
    for bytes in [5_000, 20_000, 70_000, 200_000] {
        for lanes in [1, 16, 256] {
            let budget = Budget { iterations: Some(1_000_000), bytes: Some(bytes), seconds: None };
            let params = Params { max_depth: 30, ..Params::pmbs(lanes) };
            let report = tree.search(&toy, &toy.start(), &params, 1, &inline(&pool, &stop, budget)).unwrap();
            assert_eq!(report.reason, EndReason::Memory);
            // Not even the wave that fills it goes beyond.
            assert!(report.bytes <= bytes && report.bytes > bytes / 2, "{lanes} lanes, {bytes}: {}", report.bytes);
            assert_eq!(tree.bytes(&toy), report.bytes);
            assert!(report.best_action.is_some(), "{lanes} lanes, {bytes}");
            // A search that goes on in a full tree adds nothing.
            let again = tree.resume(&toy, &params, &inline(&pool, &stop, budget)).unwrap();
            assert!(again.reason == EndReason::Memory && again.bytes <= bytes, "{lanes} lanes, {bytes}: {again:?}");
        }
    }
}

#[test]
fn advancing_keeps_what_is_below_and_goes_on() {
    let toy = open_toy();
    let pool = Pool::new(2, "advance").unwrap();
    let stop = Stop::never();
    for (name, params) in all_params() {
        let (mut tree, report) = search(&toy, &params, 5, 200, 1);
        let best = report.best_action.unwrap();
        let wanted = tree.root_children().nth(best).unwrap().node.unwrap();
        let (state, visits, id) = (wanted.state.clone(), wanted.visits, wanted.id as u32);
        let mut below = String::new();
        dump_node(&tree, id, &mut below);
        assert!(!tree.advance(99));
        assert!(tree.advance(best), "{name}");
        assert_eq!(tree.root_state(), Some(&state));
        assert_eq!(tree.arena.stat(0).visits, visits);
        let shifted: String = below
            .lines()
            .enumerate()
            .map(|(number, line)| {
                let line = line.strip_prefix("  ").unwrap();
                let rest = line.split_once(' ').unwrap().1;
                if number == 0 { format!("0 {rest}\n") } else { format!("{line}\n") }
            })
            .collect();
        assert_eq!(dump(&tree), shifted, "{name}");
        invariants::check(&tree, name);
        let run = inline(&pool, &stop, Budget::iterations(100));
        let more = tree.resume(&toy, &params, &run).unwrap();
        assert_eq!(more.iterations, 100, "{name}");
        assert_eq!(tree.arena.stat(0).visits, visits + 100);
        invariants::check(&tree, name);
        // States below the new root have the lists of actions they always had.
        let mut rollout_free = tree.nodes().filter(|node| node.level > 0);
        let node = rollout_free.next().unwrap();
        let mut out = Outcome::<Toy>::default();
        toy.root(&mut 0, node.state, tree.arena.node(node.id as u32).key, &mut out, &Stop::never());
        let listed: Vec<u32> = tree.arena.edges_of(node.id as u32).map(|edge| tree.arena.edge(edge).action).collect();
        assert_eq!(listed, out.candidates.iter().map(|c| c.action).collect::<Vec<_>>());
    }
}

#[test]
fn what_cannot_go_on_says_so() {
    let toy = Toy::default();
    let pool = Pool::inline();
    let stop = Stop::never();
    let mut tree = Tree::<Toy>::new();
    let run = inline(&pool, &stop, Budget::iterations(5));
    assert!(matches!(tree.resume(&toy, &Params::vft(), &run), Err(Error::State(_))));
    assert!(!tree.advance(0));
    assert!(tree.root_state().is_none() && tree.best_path().is_empty() && tree.nodes().next().is_none());
    let bad = Params { discount: 2.0, ..Params::vft() };
    assert!(matches!(tree.search(&toy, &toy.start(), &bad, 1, &run), Err(Error::Argument { .. })));
    let none = inline(&pool, &stop, Budget { iterations: Some(0), ..Budget::default() });
    match tree.search(&toy, &toy.start(), &Params::vft(), 1, &none) {
        Err(Error::Argument { field, .. }) => assert_eq!(field, "budget.iterations"),
        other => panic!("{other:?}"),
    }
}

/// A domain with a fault.
struct Faulty(&'static str);

impl Domain for Faulty {
    type State = ();
    type Action = u8;
    type Scratch = ();

    fn scratch(&self) {}

    fn root(&self, (): &mut (), (): &(), _: Key, out: &mut Outcome<Self>, _: &Stop) {
        out.status = if self.0 == "root" { Status::Illegal } else { Status::Legal };
        out.candidates.extend((0..4).map(Candidate::new));
    }

    fn step(&self, (): &mut (), jobs: &mut [Job<Self>], _: &Stop) {
        for job in jobs {
            match self.0 {
                "panic" => panic!("of the domain"),
                "value" => job.outcome.value = f64::NAN,
                "prior" => job.outcome.candidates.push(Candidate::with_prior(0, f32::INFINITY)),
                _ => return,
            }
            job.outcome.status = Status::Legal;
        }
    }
}

#[test]
fn faults_of_a_domain_become_errors() {
    let pool = Pool::inline();
    let stop = Stop::never();
    let run = inline(&pool, &stop, Budget::default());
    for (fault, text) in [("panic", "panic: of the domain"), ("value", "the value NaN"), ("prior", "the prior inf")] {
        for params in [Params::vft(), Params { first_expand: true, ..Params::pmbs(8) }] {
            let mut tree = Tree::new();
            match tree.search(&Faulty(fault), &(), &params, 1, &run) {
                Err(Error::Internal(message)) => assert!(message.contains(text), "{message}"),
                other => panic!("{fault}: {other:?}"),
            }
            assert!(tree.root_state().is_none());
        }
    }
    let mut tree = Tree::new();
    assert!(matches!(tree.search(&Faulty("root"), &(), &Params::vft(), 1, &run), Err(Error::Argument { .. })));
    // Gives up without being asked: the search ends rather than ask for ever.
    let report = tree.search(&Faulty("idle"), &(), &Params::vft(), 1, &run).unwrap();
    assert_eq!(report.reason, EndReason::Interrupted);
}
