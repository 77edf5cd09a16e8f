//! The search's bookkeeping allocates nothing once its memory has grown, and costs little time.

use jostle::{run, search};

#[path = "common/counting.rs"]
mod counting;
#[path = "../src/search/toy.rs"]
#[allow(dead_code)]
mod toy;

use counting::ALLOCATIONS;
use run::{Budget, Pool, Stop};
use search::{EarlyStop, Params, Run, Tree};
use toy::Toy;

/// Searches several times with one tree and returns the allocations of the last time.
fn allocations(params: &Params, solutions: f64, advance: bool) -> u64 {
    // The toy's own lists live in the outcomes of the jobs, so a second search finds them as they were.
    let toy = Toy { branching: 12, solutions, ..Toy::default() };
    let pool = Pool::inline();
    let mut tree = Tree::new();
    let mut counted = 0;
    for _ in 0..3 {
        let stop = Stop::never();
        let run = Run { pool: &pool, stop: &stop, budget: Budget::iterations(300), progress: None };
        let before = ALLOCATIONS.get();
        let report = tree.search(&toy, &toy.start(), params, 5, &run).unwrap();
        assert_eq!(report.iterations, 300);
        if advance {
            assert!(tree.advance(report.best_action.unwrap()));
            tree.resume(&toy, params, &run).unwrap();
        }
        counted = ALLOCATIONS.get() - before;
    }
    counted
}

#[test]
fn a_second_search_allocates_nothing() {
    for lanes in [1, 16] {
        let pmbs = Params { early_stop: EarlyStop::Never, ..Params::pmbs(lanes) };
        for params in [Params { lanes, ..Params::vft() }, pmbs, Params { reuse_rollouts: false, ..pmbs }] {
            assert_eq!(allocations(&params, 0.0, false), 0, "{params:?}");
            assert_eq!(allocations(&params, 0.0, true), 0, "{params:?}");
        }
    }
}

#[test]
fn adopting_solutions_allocates_nothing_either() {
    for lanes in [1, 16] {
        // The depth limit stays, so that solutions are met to the end.
        let params = Params {
            adopt_solutions: true,
            shrink_depth_on_solution: false,
            early_stop: EarlyStop::Never,
            ..Params::pmbs(lanes)
        };
        assert_eq!(allocations(&params, 0.05, false), 0, "{params:?}");
        assert_eq!(allocations(&params, 0.05, true), 0, "{params:?}");
    }
}

/// `cargo test --release --test search_memory -- --ignored --nocapture`
#[test]
#[ignore = "a measurement"]
fn bookkeeping_per_simulation() {
    let toy = Toy { branching: 60, solutions: 0.0, ..Toy::default() };
    let pool = Pool::inline();
    let mut tree = Tree::new();
    for (name, params, iterations) in [
        ("vft", Params::vft(), 150),
        ("vft", Params::vft(), 20_000),
        ("mcts", Params::mcts(), 20_000),
        ("pmbs(1)", Params::pmbs(1), 20_000),
        ("pmbs(64)", Params::pmbs(64), 20_000),
        ("pmbs(1000)", Params::pmbs(1000), 100_000),
    ] {
        for _ in 0..2 {
            let stop = Stop::never();
            let run = Run { pool: &pool, stop: &stop, budget: Budget::iterations(iterations), progress: None };
            let report = tree.search(&toy, &toy.start(), &params, 5, &run).unwrap();
            let own = (report.time - report.step_time).as_secs_f64() * 1e6;
            println!(
                "{name} {iterations} iterations: {} simulations, {:.2} us each in the toy, {:.2} us each in the search, {} nodes, {} stored, {} bytes",
                report.simulations,
                report.step_time.as_secs_f64() * 1e6 / report.simulations as f64,
                own / report.simulations as f64,
                report.nodes,
                report.stored,
                report.bytes,
            );
        }
    }
}
