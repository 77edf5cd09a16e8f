//! Single rules by hand: scores, returns, backups, the final choice, shares of lanes.

use super::*;
use crate::run::{Key, Progress};

/// A tree given as a list: state `i` has the value `values[i]` and the children named in `children[i]`.
struct Listed {
    values: Vec<f64>,
    children: Vec<Vec<usize>>,
    solutions: Vec<usize>,
    qualities: Vec<f64>,
    costs: Vec<f64>,
}

impl Listed {
    fn new(values: &[f64], children: &[&[usize]]) -> Self {
        let mut children: Vec<Vec<usize>> = children.iter().map(|list| list.to_vec()).collect();
        children.resize(values.len(), Vec::new());
        let zeros = vec![0.0; values.len()];
        Listed { values: values.to_vec(), children, solutions: vec![], qualities: zeros.clone(), costs: zeros }
    }

    fn fill(&self, state: usize, out: &mut Outcome<Self>) {
        out.status = Status::Legal;
        out.state = state;
        out.value = self.values[state];
        out.terminal = self.solutions.contains(&state);
        out.quality = self.qualities[state];
        out.cost = self.costs[state];
        out.candidates.extend(self.children[state].iter().map(|&child| Candidate::new(child)));
    }

    fn search(&self, params: Params, iterations: u64) -> (Tree<Self>, SearchReport) {
        let mut tree = Tree::new();
        let pool = Pool::inline();
        let progress = Progress::new();
        let run = Run {
            pool: &pool,
            stop: &Stop::never(),
            budget: Budget::iterations(iterations),
            progress: Some((&progress).into()),
        };
        let report = tree.search(self, &0, &params, 1, &run).unwrap();
        (tree, report)
    }
}

impl Domain for Listed {
    type State = usize;
    type Action = usize;
    type Scratch = ();

    fn scratch(&self) {}

    fn root(&self, (): &mut (), &state: &usize, _: Key, out: &mut Outcome<Self>, _: &Stop) {
        self.fill(state, out);
    }

    fn step(&self, (): &mut (), jobs: &mut [Job<Self>], _: &Stop) {
        for job in jobs {
            self.fill(job.action, &mut job.outcome);
        }
    }
}

#[test]
fn returns_are_made_as_published() {
    // A chain 0 -> 1 -> 2 -> 3; the first iteration expands 1 and rolls out to 3.
    let chain = Listed::new(&[0.0, 0.5, 0.9, 0.7], &[&[1], &[2], &[3]]);
    let cases = [
        (Return::Greatest, 0.5),
        (Return::BestPlain, 0.5 * 0.9),
        (Return::Last { earlier: 0.0 }, 0.25 * 0.7),
        (Return::Last { earlier: 0.5 }, 0.25 * 0.7),
        (Return::Last { earlier: 1.0 }, 0.25 * 0.9),
    ];
    for (returns, wanted) in cases {
        let params = Params { returns, discount: 0.5, backup: Backup::AsIs, ..Params::vft() };
        let (tree, _) = chain.search(params, 1);
        assert_eq!(tree.arena.stat(1).sum, wanted, "{returns:?}");
        assert_eq!(tree.arena.stat(0).sum, 0.5 * wanted, "{returns:?}");
    }
    let params = Params { discount: 0.9, backup: Backup::AsIs, ..Params::vft() };
    assert_eq!(chain.search(params, 1).0.arena.stat(1).sum, 0.9 * 0.9);
}

#[test]
fn backups_are_made_as_published() {
    // Second iteration: 2 is expanded below 1, whose own value is greater than what comes up.
    let chain = Listed::new(&[0.0, 0.6, 0.8, 0.1], &[&[1], &[2], &[3]]);
    let params = |backup, returns| Params { backup, returns, discount: 0.5, ..Params::vft() };
    let second = |backup, returns| {
        let stats = *chain.search(params(backup, returns), 2).0.arena.stat(1);
        stats.sum - chain.search(params(backup, returns), 1).0.arena.stat(1).sum
    };
    assert!((second(Backup::AsIs, Return::Greatest) - 0.4).abs() < 1e-15);
    assert!((second(Backup::GreatestWithOwn, Return::Greatest) - 0.6).abs() < 1e-15);
    // The plain value 0.8 beats 0.6, so the discounted 0.4 stays.
    assert!((second(Backup::OwnIfBestPlain, Return::BestPlain) - 0.4).abs() < 1e-15);
}

#[test]
fn a_discount_of_the_action_replaces_that_of_the_search() {
    struct Gentle(Listed);
    impl Domain for Gentle {
        type State = usize;
        type Action = usize;
        type Scratch = ();
        fn scratch(&self) {}
        fn root(&self, (): &mut (), _: &usize, _: Key, out: &mut Outcome<Self>, _: &Stop) {
            out.status = Status::Legal;
            out.candidates.push(Candidate::new(1));
        }
        fn step(&self, (): &mut (), jobs: &mut [Job<Self>], _: &Stop) {
            for job in jobs {
                job.outcome.status = Status::Legal;
                job.outcome.value = self.0.values[job.action];
                job.outcome.discount = Some(0.25);
            }
        }
    }
    let pool = Pool::inline();
    let run = Run { pool: &pool, stop: &Stop::never(), budget: Budget::iterations(1), progress: None };
    let mut tree = Tree::new();
    tree.search(&Gentle(Listed::new(&[0.0, 1.0], &[])), &0, &Params::vft(), 1, &run).unwrap();
    assert_eq!(tree.arena.stat(0).sum, 0.25);
}

#[test]
fn the_best_returns_are_kept_in_order() {
    let (mut tree, _) = Listed::new(&[0.0], &[&[]]).search(Params::mcts(), 1);
    tree.arena.clear(3);
    tree.arena.push(NONE, NONE, Key::default(), 1.0, &mut Outcome::default());
    for value in [0.2, 0.5, 0.1, 0.5, 0.3, 0.9] {
        tree.arena.add_return(0, value, 2);
    }
    assert_eq!(tree.arena.top(0), [0.9, 0.5, 0.5]);
    assert_eq!(tree.arena.stat(0).top_sum, 0.9 + 0.5);
    assert_eq!(tree.arena.stat(0).best, 0.9);
    tree.arena.restride(5, 3);
    assert_eq!(tree.arena.top(0), [0.9, 0.5, 0.5]);
    assert_eq!(tree.arena.stat(0).top_sum, 0.9 + 0.5 + 0.5);
    tree.arena.add_return(0, 0.4, 3);
    assert_eq!(tree.arena.top(0), [0.9, 0.5, 0.5, 0.4]);
    tree.arena.restride(1, 1);
    assert_eq!(tree.arena.top(0), [0.9]);
}

#[test]
fn ties_go_to_the_shorter_the_better_the_cheaper_and_the_first() {
    // Five actions with the same mean: 1 and 2 no solution, 3 to 5 solutions.
    let mut fan = Listed::new(&[0.0, 1.0, 1.0, 1.0, 1.0, 1.0], &[&[1, 2, 3, 4, 5]]);
    let all = Params { first_expand: true, early_stop: EarlyStop::Never, max_depth: 1, ..Params::pmbs(8) };
    let best = |fan: &Listed| fan.search(all, 5).1.best_action;
    assert_eq!(best(&fan), Some(0));
    fan.costs = vec![0.0, 2.0, 1.0, 2.0, 1.0, 1.0];
    assert_eq!(best(&fan), Some(1));
    fan.solutions = vec![3, 4, 5];
    assert_eq!(best(&fan), Some(3));
    fan.qualities = vec![9.0, 9.0, 9.0, 0.7, 0.6, 0.7];
    assert_eq!(best(&fan), Some(4));
}

#[test]
fn a_solution_may_be_preferred_to_a_better_mean() {
    let mut two = Listed::new(&[0.0, 0.9, 0.5], &[&[1, 2]]);
    two.solutions = vec![2];
    let params = Params { early_stop: EarlyStop::Never, ..Params::pmbs(1) };
    assert_eq!(two.search(params, 2).1.best_action, Some(0));
    assert_eq!(two.search(Params { prefer_solution: true, ..params }, 2).1.best_action, Some(1));
}

#[test]
fn first_expand_tries_every_root_action_once_and_ends_at_a_solution() {
    let mut fan = Listed::new(&[0.0, 0.1, 0.2, 0.3, 0.4, 0.5], &[&[1, 2, 3, 4, 5]]);
    let params = |lanes| Params {
        first_expand: true,
        early_stop: EarlyStop::LevelComplete { first: 2, last: None },
        ..Params::pmbs(lanes)
    };
    fan.solutions = vec![2];
    // The published code needs as many lanes as the root has actions; here fewer take more waves.
    for lanes in [1, 2, 8] {
        let (tree, report) = fan.search(params(lanes), 100);
        assert_eq!((report.reason, report.iterations), (EndReason::Solved, 5), "{lanes}");
        assert!(tree.root_children().all(|action| action.node.unwrap().visits == 1));
        assert_eq!(report.best_action, Some(4), "the mean decides");
    }
}

#[test]
fn guided_search_weighs_priors_against_returns() {
    struct Priors;
    impl Domain for Priors {
        type State = u32;
        type Action = u32;
        type Scratch = ();
        fn scratch(&self) {}
        fn root(&self, (): &mut (), _: &u32, _: Key, out: &mut Outcome<Self>, _: &Stop) {
            out.status = Status::Legal;
            out.candidates
                .extend((0u8..3).map(|i| Candidate::with_prior(u32::from(i), [0.3, 5.0, 0.4][usize::from(i)])));
        }
        fn step(&self, (): &mut (), jobs: &mut [Job<Self>], _: &Stop) {
            for job in jobs {
                job.outcome.status = Status::Legal;
                let ends = job.action == 0 || job.action == 2;
                job.outcome.value = if ends { 0.2 } else { 0.1 };
                job.outcome.terminal = ends;
                job.outcome.candidates.push(Candidate::with_prior(9, 0.0));
            }
        }
    }
    let pool = Pool::inline();
    let visits = |params: Params, iterations| {
        let mut tree = Tree::new();
        let run = Run { pool: &pool, stop: &Stop::never(), budget: Budget::iterations(iterations), progress: None };
        let report = tree.search(&Priors, &0, &params, 1, &run).unwrap();
        let visits: Vec<_> = tree.root_children().map(|a| a.node.map_or(0, |node| node.visits)).collect();
        (visits, report)
    };
    let params = Params { early_stop: EarlyStop::Never, max_depth: 10, ..Params::guided() };
    // The greatest prior first, then the next.
    assert_eq!(visits(params, 1).0, [0, 1, 0]);
    assert_eq!(visits(params, 2).0, [0, 1, 1]);
    // All tried. Scores: (0.3 + 0.2) / 2, (1.2 + 0.1) / 2, (0.4 + 0.2) / 2. The prior is clipped to 1.2.
    assert_eq!(visits(params, 4).0, [1, 2, 1]);
    // Deeper nodes return 0.05, 0.025: (1.2 + 0.15) / 3 and (1.2 + 0.175) / 4 are ahead, (1.2 + 0.175) / 5 is not.
    assert_eq!(visits(params, 6).0, [1, 4, 1]);
    assert_eq!(visits(params, 7).0, [1, 4, 2]);
    let (_, report) = visits(params, 6);
    assert_eq!(report.best_action, Some(1));
    assert!((report.best_value - 1.3).abs() < 1e-12);
    // Competing: the middle one is entered again while 1.3 / 2 beats the next prior, 0.4.
    let compete = Params { expansion: Expansion::Compete, ..params };
    assert_eq!(visits(compete, 3).0, [0, 3, 0]);
    assert_eq!(visits(compete, 4).0, [0, 3, 1]);
}

#[test]
fn spare_lanes_roll_out_one_node_several_times_and_keep_the_best() {
    // One action at the root; its state has 3 actions, fewer than the 8 lanes; each leads to 2 more.
    let values = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95];
    let bush = Listed::new(&values, &[&[1], &[2, 3, 4], &[5, 6], &[7, 8], &[9, 10]]);
    let params = Params { discount: 1.0, early_stop: EarlyStop::Never, ..Params::pmbs(8) };
    let (tree, report) = bush.search(params, 1);
    assert_eq!((report.iterations, report.simulations), (1, 10), "every state was seen");
    assert_eq!(tree.arena.stat(1).sum, 0.95);
    // Two lanes see two ways down; the first of the remainder goes to the state with more actions.
    let (_, report) = bush.search(Params { lanes: 2, ..params }, 1);
    assert_eq!(report.simulations, 1 + 2 + 2);
    let (_, report) = bush.search(Params { leaf_parallel: false, ..params }, 1);
    assert_eq!(report.simulations, 3);
}

#[test]
fn rollouts_end_when_few_lanes_are_active() {
    let long = Listed::new(&[0.0; 8], &[&[1], &[2], &[3], &[4], &[5], &[6], &[7]]);
    let params = Params { leaf_parallel: false, early_stop: EarlyStop::Never, ..Params::pmbs(10) };
    assert_eq!(long.search(params, 1).1.simulations, 7);
    // One active rollout of ten lanes is not more than a tenth.
    assert_eq!(long.search(Params { rollout_cutoff: 0.1, ..params }, 1).1.simulations, 1);
}

#[test]
fn virtual_visits_spread_a_wave() {
    // Two children with many actions each; the first looks better.
    let many: Vec<usize> = (3..23).collect();
    let mut values = vec![0.0, 0.6, 0.5];
    values.resize(23, 0.0);
    let wide = Listed::new(&values, &[&[1, 2], &many, &many]);
    let params = Params {
        closed: Closed::Skip,
        leaf_parallel: false,
        early_stop: EarlyStop::Never,
        max_depth: 2,
        rollout_extra: 0,
        ..Params::pmbs(1)
    };
    let visits = |params| {
        let (tree, _) = wide.search(params, 10);
        tree.root_children().map(|a| a.node.unwrap().visits).collect::<Vec<_>>()
    };
    assert_eq!(visits(Params { lanes: 8, virtual_loss: 0.0, ..params }), [9, 1], "without, all go to the best");
    assert_eq!(visits(Params { lanes: 8, ..params }), [5, 5]);
}
