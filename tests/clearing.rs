//! Tables to be cleared: decisions, determinism, limits, and the bookkeeping of trials.

use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use jostle::action::{Action, ContourSampler, Grasp};
use jostle::eval::clutter::{ALONE, ClutterGenerator, ClutterKind};
use jostle::eval::{ClearEnd, ClearTrials, Effect, JudgeOptions, clear_cap, clear_case};
use jostle::geom::{Pose2, Shape};
use jostle::grasp::{GeometricScorer, GraspAssessment, GraspParams, GraspScratch, GraspTest, Scorer};
use jostle::physics::{self, PhysicsOptions, Purpose};
use jostle::plan::clear::{ClearOptions, ClearParts, ClearPlanner};
use jostle::plan::{Control, GraspDecision, Outcome, Plan, Reason, Variant};
use jostle::run::{Budget, CancelToken, Stop};
use jostle::scene::{BodyDef, Clearing, Scene, SceneBuilder, State};

/// Cubes of 45 mm in rows and columns with this gap, about the middle of the table.
fn grid(side: usize, gap: f64) -> Clearing {
    let mut builder = SceneBuilder::new();
    let mut poses = Vec::new();
    let at = |k: usize| (k as f64 - (side as f64 - 1.0) / 2.0) * (0.045 + gap);
    for i in 0..side * side {
        builder.add_body(BodyDef::new(Shape::rectangle(0.045, 0.045))).unwrap();
        poses.push(Pose2::new(0.5 + at(i % side), at(i / side), 0.0));
    }
    Clearing::new("grid", Arc::new(builder.build().unwrap()), State::new(poses)).unwrap()
}

fn planner(options: ClearOptions) -> ClearPlanner {
    ClearPlanner::new(options).unwrap()
}

fn solve(planner: &mut ClearPlanner, problem: &Clearing) -> Plan {
    planner.solve(problem, &Control::default()).unwrap()
}

#[test]
fn a_loose_table_is_cleared_by_a_grasp_for_each_body_and_an_empty_one_by_nothing() {
    let problem = grid(3, 0.05);
    let plan = solve(&mut planner(ClearOptions::default()), &problem);
    assert_eq!((plan.outcome, plan.actions.len()), (Outcome::Solved, 9));
    let mut taken: Vec<usize> = plan
        .actions
        .iter()
        .map(|a| if let Action::Grasp(grasp) = a.action { grasp.body } else { panic!("{a:?}") })
        .collect();
    taken.sort_unstable();
    assert_eq!(taken, (0..9).collect::<Vec<_>>());
    let end = &plan.actions[8].predicted;
    assert!(end.present().is_empty());
    let nothing = solve(&mut planner(ClearOptions::default()), &problem.at(end.clone()));
    assert_eq!((nothing.outcome, nothing.actions.len()), (Outcome::Solved, 0));
}

#[test]
fn a_tight_pack_is_pushed_apart_and_the_prediction_is_what_the_confirming_engine_does() {
    let problem = grid(3, 0.001);
    let options = ClearOptions::default();
    let plan = solve(&mut planner(options.clone()), &problem);
    let Action::Push(push) = plan.actions[0].action else { panic!("{plan:?}") };
    assert!(plan.actions.len() > 1 && matches!(plan.actions[1].action, Action::Grasp(_)), "{plan:?}");
    assert!(plan.statistics.simulations > 20 && plan.statistics.plans_tried == 8, "{:?}", plan.statistics);
    let engine = physics::engine(&options.confirmed_in().unwrap().unwrap(), Arc::clone(&problem.scene)).unwrap();
    let after = engine.step(&mut engine.scratch(), &problem.state, &push, &Stop::never());
    assert_eq!(after.state, plan.actions[0].predicted);
    assert!(plan.considered.windows(2).all(|w| w[0].value >= w[1].value) && !plan.considered.is_empty());
}

#[test]
fn every_form_and_baseline_decides_the_same_at_any_number_of_threads() {
    let mut problems = vec![grid(3, 0.001)];
    problems.extend(ClutterGenerator::new(ClutterKind::Packed.params(), 5).unwrap().problems(1).unwrap());
    for problem in &problems {
        for (name, variant) in [
            ("greedy", Variant::Tuned),
            ("greedy", Variant::Dissertation),
            ("greedy", Variant::Code),
            ("random_push", Variant::Tuned),
            ("grasp_only", Variant::Tuned),
        ] {
            for budget in [Budget::default(), Budget::iterations(37)] {
                let options = |threads| ClearOptions {
                    planner: name.into(),
                    variant,
                    threads,
                    seed: 7,
                    budget,
                    ..ClearOptions::default()
                };
                let plan = solve(&mut planner(options(1)), problem);
                assert!(plan.statistics.iterations <= budget.iterations.unwrap_or(u64::MAX));
                for threads in [2, 5] {
                    let mut planner = planner(options(threads));
                    // Whatever ran before.
                    solve(&mut planner, &grid(2, 0.002));
                    // The same question has the same answer.
                    for _ in 0..2 {
                        let other = solve(&mut planner, problem);
                        assert_eq!(other.hash_bits(), plan.hash_bits(), "{name} {variant:?} {threads}");
                    }
                }
            }
        }
    }
}

#[test]
fn what_failed_is_not_offered_again_before_something_was_pushed() {
    // Two far from each other: both can be taken.
    let problem = grid(2, 0.1);
    let mut planner = planner(ClearOptions::default());
    let first = solve(&mut planner, &problem).actions[0].action;
    let Action::Grasp(Grasp { body, .. }) = first else { panic!("{first:?}") };
    planner.failed(&first);
    let next = solve(&mut planner, &problem);
    assert_eq!(next.actions.len(), 3, "the others are taken first");
    assert!(next.actions.iter().all(|a| matches!(a.action, Action::Grasp(g) if g.body != body)), "{next:?}");
    // Alone it has to be pushed.
    let mut alone = problem.state.clone();
    (0..4).filter(|&i| i != body).for_each(|i| alone.set_present(i, false));
    let alone = problem.at(alone);
    let push = solve(&mut planner, &alone);
    assert!(matches!(push.actions[0].action, Action::Push(_)), "{push:?}");
    // A push that is blocked is not offered again either.
    planner.failed(&push.actions[0].action);
    let other = solve(&mut planner, &alone);
    assert!(matches!(other.actions[0].action, Action::Push(_)), "{other:?}");
    assert_ne!(other.actions[0].action, push.actions[0].action);
    planner.advance(&other.actions[0].action);
    let moved = alone.at(other.actions[0].predicted.clone());
    assert!(matches!(solve(&mut planner, &moved).actions[0].action, Action::Grasp(g) if g.body == body));
    planner.reset();
    assert_eq!(solve(&mut planner, &problem).actions[0].action, first);
}

/// Some bodies that no jaw fits may be left; where all are such, nothing can be done, and the plan says why.
#[test]
fn a_table_of_bodies_that_no_jaw_fits_is_infeasible_with_a_reason_for_each() {
    for (wide, loose) in [(1, 0), (3, 0), (2, 1)] {
        let mut builder = SceneBuilder::new();
        let sides = std::iter::repeat_n(0.12, wide).chain(std::iter::repeat_n(0.04, loose));
        for side in sides {
            builder.add_body(BodyDef::new(Shape::rectangle(side, side))).unwrap();
        }
        let poses = (0..wide + loose).map(|i| Pose2::new(0.36 + 0.14 * i as f64, 0.0, 0.0));
        let problem = Clearing::new("wide", Arc::new(builder.build().unwrap()), State::new(poses)).unwrap();
        for id in ["greedy", "random_push", "grasp_only"] {
            let options = ClearOptions { planner: id.into(), ..ClearOptions::default() };
            let plan = solve(&mut planner(options), &problem);
            if loose > 0 {
                assert!(matches!(plan.actions[0].action, Action::Grasp(g) if g.body == wide), "{id}: {plan:?}");
                continue;
            }
            assert_eq!((plan.outcome, plan.actions.len()), (Outcome::Infeasible, 0), "{id}");
            assert_eq!(plan.reasons.len(), wide, "{id}");
            assert!(plan.reasons.iter().all(|r| matches!(r, Reason::TooWide { width, .. } if *width > 0.11)), "{id}");
        }
    }
}

#[test]
fn limits_and_cancelling_are_outcomes() {
    let problem = grid(3, 0.001);
    let control = Control { cancel: vec![CancelToken::new()], progress: None };
    control.cancel[0].trigger();
    let plan = planner(ClearOptions::default()).solve(&problem, &control).unwrap();
    assert_eq!((plan.outcome, plan.actions.len()), (Outcome::Cancelled, 0));
    // A deadline that is over at once leaves a legal push.
    let hurried = ClearOptions { budget: Budget::seconds(1e-9), ..ClearOptions::default() };
    let plan = solve(&mut planner(hurried), &problem);
    assert_eq!((plan.outcome, plan.actions.len()), (Outcome::Budget, 1));
    assert!(matches!(plan.actions[0].action, Action::Push(_)), "{plan:?}");
    let one = planner(ClearOptions::default()).step(&problem, 20, &Control::default()).unwrap();
    assert_eq!(one.statistics.simulations, 20);
    for (options, field) in [
        (ClearOptions { planner: "oracle".into(), ..ClearOptions::default() }, "planner"),
        (ClearOptions { sampler: Some("dice".into()), ..ClearOptions::default() }, "sampler"),
        (ClearOptions { push_length: Some(2.0), ..ClearOptions::default() }, "push_length"),
        (ClearOptions { budget: Budget::iterations(0), ..ClearOptions::default() }, "iterations"),
    ] {
        let error = ClearPlanner::new(options).unwrap_err().to_string();
        assert!(error.starts_with(field), "{error}");
    }
    let mut rule = ClearOptions::default().own_rule().unwrap();
    rule.lengths.clear();
    let error = ClearPlanner::new(ClearOptions { rule: Some(rule), ..ClearOptions::default() }).unwrap_err();
    assert!(error.to_string().starts_with("rule.lengths"), "{error}");
}

#[test]
fn no_push_of_the_tuned_form_brings_a_body_near_the_edge() {
    // A pair near the edge: the push that parts them best would drive one of them outwards.
    let mut builder = SceneBuilder::new();
    for _ in 0..4 {
        builder.add_body(BodyDef::new(Shape::rectangle(0.045, 0.045))).unwrap();
    }
    let poses = [(0.66, 0.0), (0.614, 0.0), (0.66, 0.046), (0.614, 0.046)].map(|(x, y)| Pose2::new(x, y, 0.0));
    let problem = Clearing::new("edge", Arc::new(builder.build().unwrap()), State::new(poses)).unwrap();
    let options = ClearOptions::default();
    let edge = options.own_rule().unwrap().edge;
    let plan = solve(&mut planner(options.clone()), &problem);
    let pushes: Vec<_> = plan.considered.iter().map(|a| a.action).chain([plan.actions[0].action]).collect();
    let engine = physics::engine(&options.model().unwrap(), Arc::clone(&problem.scene)).unwrap();
    assert!(pushes.len() > 2, "{plan:?}");
    for action in pushes {
        let Action::Push(push) = action else { panic!("{action:?}") };
        let after = engine.step(&mut engine.scratch(), &problem.state, &push, &Stop::never()).state;
        for (i, pose) in after.iter() {
            let inset = |pose: &Pose2| problem.scene.workspace().inset(pose.position());
            let (before, now) = (inset(&problem.state.pose(i)), inset(&pose));
            assert!(now >= edge || now >= before - 0.0021, "{push:?}: body {i} from {before} to {now}");
        }
    }
}

/// A scorer that gives each body a score by how far it lies from where it was.
struct Moved {
    before: State,
    at_rest: f64,
    moved: f64,
}

impl Scorer for Moved {
    fn name(&self) -> &str {
        "moved"
    }

    fn scratch(&self) -> Box<dyn Any + Send> {
        Box::new(())
    }

    fn assess(
        &self,
        _: &mut (dyn Any + Send),
        _: &Scene,
        states: &[&State],
        target: usize,
        out: &mut [GraspAssessment],
        _: &Stop,
    ) {
        for (state, out) in states.iter().zip(out) {
            let far = (state.pose(target).position() - self.before.pose(target).position()).norm() > 0.02;
            let score = if far { self.moved } else { self.at_rest };
            let grasp = Grasp { body: target, opening: 0.08, score, ..Grasp::default() };
            *out = GraspAssessment { grasp: Some(grasp), score, nearness: 1.0 };
        }
    }
}

#[test]
fn the_dissertations_rule_weighs_the_mean_now_against_the_discounted_mean_after_the_best_push() {
    // One body: the mean is its score, and every push of it that goes far enough gives it the other.
    let problem = grid(1, 0.0);
    let decide = |variant, at_rest: f64, moved: f64| {
        let before = problem.state.clone();
        let options = ClearOptions { variant, ..ClearOptions::default() };
        let mut planner = ClearPlanner::with_parts(options, move |scene| {
            Ok(ClearParts {
                scene: Arc::clone(scene),
                engine: physics::engine(&PhysicsOptions::named("planar", None, Purpose::Planning)?, Arc::clone(scene))?,
                confirming: None,
                sampler: Box::new(ContourSampler::preset("dense")?.prepared(scene)),
                scorer: Box::new(Moved { before: before.clone(), at_rest, moved }),
            })
        })
        .unwrap();
        matches!(solve(&mut planner, &problem).actions[0].action, Action::Push(_))
    };
    use Variant::{Code, Dissertation, Tuned};
    // 0.9 x 0.6 = 0.54.
    assert!(decide(Dissertation, 0.53, 0.6) && !decide(Dissertation, 0.55, 0.6));
    assert!(!decide(Dissertation, 0.7, 1.0), "a grasp of 0.7 is executed at once");
    assert!(decide(Dissertation, 0.69, 1.0));
    // The code discounts only above 0.5.
    assert!(decide(Code, 0.45, 0.46) && !decide(Dissertation, 0.45, 0.46));
    assert!(!decide(Code, 0.55, 0.6));
    // Tuned, what can be grasped is.
    assert!(!decide(Tuned, 0.31, 1.0) && decide(Tuned, 0.29, 1.0));
}

#[test]
fn taking_a_body_never_hinders_the_grasp_of_another() {
    let test = GraspTest::new(GraspParams::default()).unwrap();
    let mut scratch = GraspScratch::default();
    for problem in ClutterGenerator::new(ClutterKind::Random.params(), 11).unwrap().problems(3).unwrap() {
        let test = test.prepared(&problem.scene);
        let mut best =
            |state: &State, body| test.best(&problem.scene, state, body, &mut scratch).map_or(0.0, |g| g.score);
        for taken in 0..problem.scene.len() {
            let mut less = problem.state.clone();
            less.set_present(taken, false);
            for body in (0..problem.scene.len()).filter(|&body| body != taken) {
                let (before, after) = (best(&problem.state, body), best(&less, body));
                // The test does not try every place between the pads: more room may lead it to one that is a little worse.
                assert!(after >= 0.85 * before, "{}: {body} without {taken}: {before} to {after}", problem.name);
            }
        }
    }
}

/// A scorer that counts what it is asked.
struct Counted {
    inner: GeometricScorer,
    asked: Arc<AtomicUsize>,
}

impl Scorer for Counted {
    fn name(&self) -> &str {
        "counted"
    }

    fn scratch(&self) -> Box<dyn Any + Send> {
        self.inner.scratch()
    }

    fn assess(
        &self,
        scratch: &mut (dyn Any + Send),
        scene: &Scene,
        states: &[&State],
        target: usize,
        out: &mut [GraspAssessment],
        stop: &Stop,
    ) {
        self.asked.fetch_add(states.len(), Ordering::Relaxed);
        self.inner.assess(scratch, scene, states, target, out, stop);
    }
}

#[test]
fn a_plan_to_take_everything_asks_of_a_body_at_most_twice_and_every_grasp_of_it_holds() {
    let problem = grid(5, 0.03);
    let asked = Arc::new(AtomicUsize::new(0));
    let count = Arc::clone(&asked);
    let mut planner = ClearPlanner::with_parts(ClearOptions::default(), move |scene| {
        let inner = GeometricScorer::new(scene, GraspParams::default())?;
        Ok(ClearParts {
            scene: Arc::clone(scene),
            engine: physics::engine(&PhysicsOptions::named("planar", None, Purpose::Planning)?, Arc::clone(scene))?,
            confirming: None,
            sampler: Box::new(ContourSampler::preset("dense")?.prepared(scene)),
            scorer: Box::new(Counted { inner, asked: Arc::clone(&count) }),
        })
    })
    .unwrap();
    let plan = solve(&mut planner, &problem);
    assert_eq!((plan.outcome, plan.actions.len()), (Outcome::Solved, 25));
    // Networks take milliseconds for each.
    let asked = asked.load(Ordering::Relaxed);
    assert!((25..=50).contains(&asked), "asked {asked} times");
    let (test, mut scratch) = (GraspTest::new(GraspParams::default()).unwrap(), GraspScratch::default());
    let mut state = problem.state.clone();
    for planned in &plan.actions {
        let Action::Grasp(grasp) = planned.action else { panic!("{planned:?}") };
        assert!(test.check(&problem.scene, &state, &grasp, &mut scratch).holds(), "{grasp:?}");
        state.set_present(grasp.body, false);
        assert_eq!(state, planned.predicted);
    }
}

/// The suites of the tool, as their files are.
fn suite(name: &str) -> Vec<(String, Clearing)> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("suites").join(name);
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.iter().map(|f| (std::fs::read_to_string(f).unwrap(), Clearing::read(f).unwrap())).collect()
}

#[test]
fn the_suites_are_what_their_generator_makes_and_every_body_can_be_taken_when_it_is_alone() {
    let test = GraspTest::new(GraspParams::default()).unwrap();
    let mut scratch = GraspScratch::default();
    let enough = GraspDecision::default().execute_score;
    for (name, kind, count) in [("clear-random", ClutterKind::Random, 30), ("clear-packed", ClutterKind::Packed, 10)] {
        let files = suite(name);
        let made = ClutterGenerator::new(kind.params(), 0).unwrap().problems(count).unwrap();
        assert_eq!(files.len(), count);
        let mut most = 0;
        for ((text, problem), made) in files.iter().zip(&made) {
            assert_eq!(*text, made.to_json().unwrap(), "{}", problem.name);
            assert!(problem.left(&problem.state).is_empty());
            let n = problem.scene.len();
            most = most.max(n);
            let mut open = 0;
            for body in 0..n {
                let mut alone = problem.state.clone();
                (0..n).filter(|&i| i != body).for_each(|i| alone.set_present(i, false));
                let best = test.best(&problem.scene, &alone, body, &mut scratch).unwrap();
                assert!(best.score >= ALONE, "{}: {body} scores {}", problem.name, best.score);
                let now = test.best(&problem.scene, &problem.state, body, &mut scratch);
                open += usize::from(now.is_some_and(|grasp| grasp.score >= enough));
            }
            assert!(kind == ClutterKind::Random || open <= 1, "{}: {open} can be taken at first", problem.name);
        }
        assert_eq!(most, if kind == ClutterKind::Random { 30 } else { 12 });
    }
}

#[test]
fn a_closed_loop_keeps_its_books_and_tampering_is_found_out() {
    let problem = grid(2, 0.002);
    let config = ClearTrials {
        judge: JudgeOptions { physics: PhysicsOptions::preset("fast"), ..JudgeOptions::default() },
        trials: 2,
        ..ClearTrials::default()
    };
    let case = clear_case(&problem, &config, &Control::default()).unwrap();
    assert_eq!((case.bodies, case.trials.len(), case.numbers.runs), (4, 2, 2));
    assert_eq!(case.numbers.completion, 1.0, "{case:?}");
    let cap = clear_cap(&problem, None);
    assert_eq!(cap, 12);
    let again = clear_case(&problem, &config, &Control::default()).unwrap();
    let trial = &case.trials[0];
    let actions = |trial: &jostle::eval::ClearTrial| trial.decisions.iter().map(|d| d.action).collect::<Vec<_>>();
    assert_eq!(actions(trial), actions(&again.trials[0]), "a trial can be repeated");
    trial.check(&problem, cap).unwrap();
    assert_eq!(trial.actions, trial.pushes + trial.grasps);

    let broken = |change: &dyn Fn(&mut jostle::eval::ClearTrial)| {
        let mut trial = trial.clone();
        change(&mut trial);
        trial.check(&problem, cap).unwrap_err().to_string()
    };
    assert!(broken(&|t| t.taken -= 1).contains("counts"));
    assert!(broken(&|t| t.end = ClearEnd::ActionCap).contains("ended as ActionCap"));
    assert!(broken(&|t| t.bodies = 5).contains("the problem has 4"));
    assert!(broken(&|t| t.decisions.push(t.decisions[0].clone())).contains("empty table"));
    let twice = |t: &mut jostle::eval::ClearTrial| {
        let first = t.decisions.iter().position(|d| d.effect == Some(Effect::Grasped)).unwrap();
        let last = t.decisions.len() - 1;
        t.decisions[last] = t.decisions[first].clone();
    };
    assert!(broken(&twice).contains("which is not there"));
    assert!(trial.check(&problem, trial.actions - 1).is_err(), "more actions than the cap");
}

#[test]
fn what_never_pushes_cannot_clear_a_tight_pack() {
    let config = ClearTrials {
        planner: ClearOptions { planner: "grasp_only".into(), ..ClearOptions::default() },
        judge: JudgeOptions { physics: PhysicsOptions::preset("fast"), ..JudgeOptions::default() },
        trials: 1,
        ..ClearTrials::default()
    };
    let case = clear_case(&grid(3, 0.001), &config, &Control::default()).unwrap();
    assert_eq!((case.numbers.completion, case.numbers.taken), (0.0, 0), "{case:?}");
    assert_eq!(case.trials[0].end, ClearEnd::NoAction);
}
