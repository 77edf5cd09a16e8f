//! Every planner of rearrangements, as its user sees it. Every plan has to pass the certificate.

mod random_rearrangements;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use jostle::action::Move;
use jostle::eval::certificate::{certify, certify_moves};
use jostle::eval::{RearrangeEnd, RearrangeTrials, rearrange_case};
use jostle::geom::{Pose2, Shape, vec2};
use jostle::plan::rearrange::{REARRANGE_PLANNERS, RearrangeOptions, RearrangePlan, RearrangePlanner};
use jostle::plan::{Control, Outcome, Variant};
use jostle::run::{Budget, CancelToken, Progress};
use jostle::scene::{BodyDef, Goal, Rearrangement, SceneBuilder, State, Workspace};
use random_rearrangements::random_problem;

fn at(x: f64, y: f64) -> Pose2 {
    Pose2::new(x, y, 0.0)
}

/// Squares of 10 cm on the published table, the ones from `drag` on only to be dragged.
fn squares(poses: &[Pose2], goals: &[Option<Pose2>], drag: usize) -> Rearrangement {
    let mut builder = SceneBuilder::new();
    builder.workspace(Workspace::rectangle(vec2(0.0, 0.0), vec2(0.78, 0.52)));
    for index in 0..poses.len() {
        builder.add_body(BodyDef { pickable: index < drag, ..BodyDef::new(Shape::rectangle(0.1, 0.1)) }).unwrap();
    }
    let goals = goals.iter().map(|goal| goal.map(Goal::at)).collect();
    let state = State::new(poses.iter().copied());
    Rearrangement::new("squares", Arc::new(builder.build().unwrap()), state, goals).unwrap()
}

/// Two squares that change places.
fn swap(drag: usize) -> Rearrangement {
    let (a, b) = (at(0.2, 0.25), at(0.5, 0.25));
    squares(&[a, b], &[Some(b), Some(a)], drag)
}

fn options(planner: &str, iterations: u64) -> RearrangeOptions {
    RearrangeOptions { planner: planner.into(), budget: Budget::iterations(iterations), ..RearrangeOptions::default() }
}

fn solve(problem: &Rearrangement, options: RearrangeOptions) -> RearrangePlan {
    let plan = RearrangePlanner::new(options).unwrap().solve(problem, &Control::default()).unwrap();
    let moves = plan.moves.iter().map(|step| &step.action);
    if plan.outcome == Outcome::Solved {
        certify(problem, moves).unwrap();
    } else {
        certify_moves(problem, moves).unwrap();
    }
    plan
}

/// Small bodies, some of which can only be dragged: what every planner can do something with.
fn mixed(seed: u64) -> Rearrangement {
    random_problem(seed, 4 + seed as usize % 3, 0.1, 0.12)
}

#[test]
fn a_swap_takes_three_moves_and_no_planner_of_ours_takes_more() {
    for planner in ["untangle", "pmmr"] {
        for drag in [2, 1, 0] {
            let plan = solve(&swap(drag), options(planner, 2000));
            assert_eq!((plan.outcome, plan.moves.len()), (Outcome::Solved, 3), "{planner} {drag}");
            assert_eq!(plan.statistics.no_plan_within, Some(2), "{planner} {drag}");
            let drags = plan.moves.iter().filter(|step| matches!(step.action, Move::Drag { .. })).count();
            assert!(if drag == 2 { drags == 0 } else { drags > 0 }, "{planner} {drag}");
        }
    }
}

#[test]
fn every_plan_of_every_planner_passes_the_certificate() {
    let mut solved = 0;
    for seed in 0..6 {
        let problem = mixed(seed);
        for planner in REARRANGE_PLANNERS {
            for variant in [Variant::Tuned, Variant::Dissertation] {
                let plan = solve(&problem, RearrangeOptions { variant, seed, ..options(planner, 40) });
                solved += usize::from(plan.outcome == Outcome::Solved);
                let last = plan.moves.last().map_or(&problem.start, |step| &step.predicted);
                assert_eq!(plan.outcome == Outcome::Solved, problem.solved(last), "{planner} {seed}");
            }
        }
    }
    assert!(solved > 18, "{solved} of 36");
}

#[test]
fn threads_do_not_change_a_bit_of_a_plan() {
    let mut hashes = std::collections::BTreeSet::new();
    // On an easy problem several planners have the same plan: enough problems that they have different ones too.
    for seed in 0..3 {
        let problem = mixed(seed);
        for (planner, variant) in [
            ("untangle", Variant::Tuned),
            ("pmmr", Variant::Tuned),
            ("pmmr", Variant::Dissertation),
            ("hbfs", Variant::Tuned),
        ] {
            let plan = |threads: usize| {
                let options = RearrangeOptions { variant, threads, seeds: 5, seed, ..options(planner, 32) };
                solve(&problem, options).hash_bits()
            };
            let alone = plan(1);
            assert_eq!((alone, alone), (plan(2), plan(4)), "{planner} {variant:?} {seed}");
            hashes.insert(alone);
        }
    }
    assert!(hashes.len() > 5, "{}", hashes.len());
}

#[test]
fn a_planner_used_before_gives_the_same_plan() {
    let (first, second) = (mixed(5), mixed(6));
    for planner in REARRANGE_PLANNERS {
        let mut used = RearrangePlanner::new(options(planner, 48)).unwrap();
        used.solve(&second, &Control::default()).unwrap();
        used.reset();
        let again = used.solve(&first, &Control::default()).unwrap();
        assert_eq!(again.hash_bits(), solve(&first, options(planner, 48)).hash_bits(), "{planner}");
    }
}

#[test]
fn the_same_question_has_the_same_answer_until_something_was_executed() {
    for planner in REARRANGE_PLANNERS {
        for variant in [Variant::Tuned, Variant::Dissertation] {
            let mut used = RearrangePlanner::new(RearrangeOptions { variant, ..options(planner, 48) }).unwrap();
            let mut problem = mixed(5);
            for moved in 0..2 {
                let mut ask = || used.solve(&problem, &Control::default()).unwrap();
                let plan = ask();
                let wanted = (plan.outcome, plan.hash_bits(), plan.statistics.iterations);
                for _ in 0..2 {
                    let again = ask();
                    let got = (again.outcome, again.hash_bits(), again.statistics.iterations);
                    assert_eq!(got, wanted, "{planner} {variant:?} after {moved}");
                }
                // A step goes on from the plan and is no worse; the answer stays.
                let further = used.step(&problem, 16, &Control::default()).unwrap();
                if planner != "hbfs" && variant == Variant::Tuned && plan.outcome == Outcome::Solved {
                    assert!(further.outcome == Outcome::Solved && further.moves.len() <= plan.moves.len(), "{planner}");
                }
                let last = used.solve(&problem, &Control::default()).unwrap();
                assert_eq!(last.hash_bits(), wanted.1, "{planner} {variant:?} after {moved} and a step");
                let Some(first) = last.moves.first() else { break };
                used.advance(&first.action).unwrap();
                problem = problem.from_state(first.predicted.clone());
            }
        }
    }
}

#[test]
fn the_rest_of_a_plan_is_kept_after_its_first_move_was_executed() {
    let problem = swap(2);
    for planner in ["untangle", "pmmr"] {
        let mut used = RearrangePlanner::new(options(planner, 400)).unwrap();
        let plan = used.solve(&problem, &Control::default()).unwrap();
        assert!(used.advance(&plan.moves[0].action).unwrap());
        let next = used.step(&problem.from_state(plan.moves[0].predicted.clone()), 1, &Control::default()).unwrap();
        assert_eq!((next.outcome, next.moves.len()), (Outcome::Solved, 2), "{planner}");
        // Another move than the planned one: nothing is kept.
        assert!(!used.advance(&plan.moves[0].action).unwrap());
    }
}

#[test]
fn a_solved_problem_needs_no_moves() {
    let a = at(0.2, 0.2);
    let problem = squares(&[a], &[Some(at(0.203, 0.2))], 1);
    for planner in REARRANGE_PLANNERS {
        let plan = solve(&problem, options(planner, 10));
        assert_eq!((plan.outcome, plan.moves.len()), (Outcome::Solved, 0), "{planner}");
    }
}

#[test]
fn a_body_without_a_goal_is_moved_out_of_the_way_if_need_be() {
    let problem = squares(&[at(0.1, 0.1), at(0.5, 0.25)], &[Some(at(0.5, 0.25)), None], 2);
    for planner in REARRANGE_PLANNERS {
        let plan = solve(&problem, RearrangeOptions { seeds: 8, ..options(planner, 200) });
        assert_eq!(plan.outcome, Outcome::Solved, "{planner}");
        if planner != "hbfs" {
            assert_eq!(plan.moves.len(), 2, "{planner}");
        }
    }
}

#[test]
fn cancelled_plans_have_no_moves() {
    let token = CancelToken::new();
    token.trigger();
    let control = Control { cancel: vec![token], progress: None };
    for planner in REARRANGE_PLANNERS {
        let plan = RearrangePlanner::new(options(planner, 10)).unwrap().solve(&mixed(1), &control).unwrap();
        assert_eq!((plan.outcome, plan.moves.len()), (Outcome::Cancelled, 0), "{planner}");
    }
}

#[test]
fn progress_is_told_and_can_end_the_work() {
    for planner in ["untangle", "pmmr"] {
        let calls = Arc::new(AtomicU64::new(0));
        let counter = Arc::clone(&calls);
        let progress = Progress::with_callback(Duration::ZERO, move |_| counter.fetch_add(1, Ordering::Relaxed) < 2);
        let control = Control { cancel: Vec::new(), progress: Some(Arc::new(progress)) };
        let mut used = RearrangePlanner::new(options(planner, 100_000_000)).unwrap();
        // Too hard to be settled by the second call.
        let plan = used.solve(&random_problem(3, 6, 0.3, 0.12), &control).unwrap();
        assert_eq!((plan.outcome, plan.moves.len()), (Outcome::Cancelled, 0), "{planner}");
        assert!(calls.load(Ordering::Relaxed) >= 3, "{planner}");
    }
}

#[test]
fn a_plan_of_several_searches_goes_forward_to_those_who_watch() {
    for planner in ["untangle", "pmmr"] {
        let seen = Arc::new(Mutex::new(Vec::new()));
        let note = Arc::clone(&seen);
        let progress = Progress::with_callback(Duration::ZERO, move |now| {
            note.lock().unwrap().push((now.iterations, now.simulations));
            true
        });
        let control = Control { cancel: Vec::new(), progress: Some(Arc::new(progress)) };
        // Too hard for the attempts alone with which `pmmr` begins.
        let problem = random_problem(3, 6, 0.3, 0.12);
        RearrangePlanner::new(options(planner, 1000)).unwrap().solve(&problem, &control).unwrap();
        let seen = seen.lock().unwrap();
        assert!(seen.len() > 2 && seen.iter().any(|now| now.0 > 0), "{planner}: {seen:?}");
        assert!(seen.windows(2).all(|w| w[0].0 <= w[1].0 && w[0].1 <= w[1].1), "{planner}: {seen:?}");
    }
}

#[test]
fn options_are_refused_by_name() {
    let ok = RearrangeOptions::default;
    let cases = [
        ("planner", RearrangeOptions { planner: "magic".into(), ..ok() }),
        ("seeds", RearrangeOptions { seeds: 0, ..ok() }),
        ("max_moves", RearrangeOptions { max_moves: Some(0), ..ok() }),
        ("max_depth", RearrangeOptions { max_depth: Some(0), ..ok() }),
        ("lanes", RearrangeOptions { lanes: Some(0), ..ok() }),
        ("seconds", RearrangeOptions { budget: Budget::seconds(-1.0), ..ok() }),
    ];
    for (field, options) in cases {
        let error = RearrangePlanner::new(options).unwrap_err().to_string();
        assert!(error.starts_with(field), "{error}");
    }
    let mut options = ok();
    options.samples.tries = 0;
    assert!(options.validate().unwrap_err().to_string().starts_with("samples.tries"));
    options = ok();
    options.paths.clearance = 1.0;
    assert!(options.validate().unwrap_err().to_string().starts_with("paths.clearance"));
}

#[test]
fn trials_end_completed_and_count_what_was_done() {
    let problem = swap(1);
    for open_loop in [false, true] {
        let config = RearrangeTrials { options: options("untangle", 200), trials: 2, open_loop, ..Default::default() };
        let case = rearrange_case(&problem, &config, &Control::default()).unwrap();
        assert_eq!((case.completion, case.actions), (1.0, Some(3.0)), "{case:?}");
        for trial in &case.trials {
            assert_eq!(trial.end, RearrangeEnd::Completed);
            assert_eq!(trial.decisions, if open_loop { 1 } else { 3 });
            assert!(trial.drags >= 1 && trial.robot_s > 3.0 * 1.5, "{trial:?}");
            certify(&problem, &trial.moves).unwrap();
        }
    }
    // One action is too few.
    let config = RearrangeTrials { options: options("hbfs", 1), trials: 1, max_actions: 1, ..Default::default() };
    let case = rearrange_case(&problem, &config, &Control::default()).unwrap();
    assert_eq!((case.completion, case.trials[0].end), (0.0, RearrangeEnd::ActionCap));
}

fn shared(path: &str) -> Option<PathBuf> {
    let root = std::env::var_os("JOSTLE_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let path = root.join(path);
    if !path.exists() {
        println!("skipped: {} is not there (set JOSTLE_SHARED)", path.display());
        return None;
    }
    Some(path)
}

/// The original TRLB takes 10.2 and 22.2 moves in the mean for discs, D = 0.3, n = 10 and 20; 11.8 and 14.2 for
/// D = 0.5, n = 6 and 10.
#[test]
fn arrangements_of_trlb_are_solved_with_few_moves() {
    let cases = [
        ("disk/D=0.3/n=10", 10.2),
        ("disk/D=0.3/n=20", 22.2),
        ("disk/D=0.5/n=6", 11.8),
        ("disk/D=0.5/n=10", 14.2),
        ("stick/D=0.2/n=5", 7.0),
        ("stick/D=0.2/n=10", 13.0),
        ("stick/D=0.3/n=5", 7.5),
        ("stick/D=0.3/n=10", 13.0),
    ];
    for (folder, most) in cases {
        let Some(path) = shared(&format!("cases/trlb/{folder}")) else { return };
        let problems = jostle::eval::Problems::open(&path, None).unwrap().rearrangements;
        assert!(!problems.is_empty());
        let mut moves = 0;
        for problem in &problems {
            let plan = solve(problem, options("untangle", 3000));
            assert_eq!(plan.outcome, Outcome::Solved, "{folder} {}", problem.name);
            moves += plan.moves.len();
        }
        let mean = moves as f64 / problems.len() as f64;
        assert!(mean <= most, "{folder}: {mean} moves");
    }
}
