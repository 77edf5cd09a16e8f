//! The planner `hedge`: what it proves, what it estimates, and that neither depends on threads.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use jostle::action::{Action, ContourSampler, Push, PushSampler, SamplerScratch};
use jostle::eval::{Judge, JudgeOptions, Suite, TrialEnd, needs_push, needs_pushes, run_trial};
use jostle::geom::{Pose2, Shape, normalize_angle};
use jostle::grasp::{GraspParams, GraspScratch, GraspTest};
use jostle::physics::{self, PhysicsOptions, Purpose, PushStatus, Transition};
use jostle::plan::{Confirm, Control, Outcome, Plan, Planner, PlannerOptions};
use jostle::record::explanation;
use jostle::run::{Budget, Key, Progress, Stop};
use jostle::scene::arc::ArcProfile;
use jostle::scene::generate::{Generator, GeneratorParams};
use jostle::scene::{BodyDef, Gripper, Problem, SceneBuilder, State};

fn options() -> PlannerOptions {
    PlannerOptions { budget: Budget::iterations(1500), seed: 3, ..PlannerOptions::default() }
}

fn solve(options: &PlannerOptions, problem: &Problem) -> Plan {
    Planner::new(options.clone()).unwrap().solve(problem, &Control::default()).unwrap()
}

/// Small confined scenes that need a push.
fn small(count: usize) -> Vec<Problem> {
    let params = GeneratorParams { bodies: 5..=6, profile: ArcProfile::Pmbs, ..GeneratorParams::default() };
    Generator::new(params, 4).unwrap().generate_filtered(count, |p| needs_push(p).unwrap()).unwrap()
}

fn pushes(plan: &Plan) -> usize {
    plan.actions.iter().filter(|a| matches!(a.action, Action::Push(_))).count()
}

/// Everything that a plan says, without the times.
fn bits(plan: &Plan) -> String {
    let s = plan.statistics;
    let counts = [s.iterations, s.nodes, s.simulations, s.plans_tried, s.confirm_simulations, s.worlds];
    let said = (s.no_plan_within, s.proved_shortest, s.success_chance, s.expected_actions);
    format!("{:x} {counts:?} {said:?} {:?}", plan.hash_bits(), plan.considered)
}

#[test]
fn threads_do_not_change_a_bit_of_a_decision() {
    for problem in small(3) {
        let plans = [0, 2, 5].map(|threads| bits(&solve(&PlannerOptions { threads, ..options() }, &problem)));
        assert_eq!(plans[0], plans[1], "{}", problem.name);
        assert_eq!(plans[0], plans[2], "{}", problem.name);
    }
}

/// The planner's own parts, put together without a planner.
struct Model {
    engine: Arc<dyn Transition>,
    sampler: Box<dyn PushSampler>,
    test: GraspTest,
    problem: Problem,
}

impl Model {
    fn pushes(&self, state: &State) -> Vec<Push> {
        let (mut scratch, mut out) = (SamplerScratch::default(), Vec::new());
        let p = &self.problem;
        self.sampler.sample(&p.scene, state, p.target, None, &mut Key::new(9).stream(), &mut scratch, &mut out);
        out
    }

    fn after(&self, state: &State, push: &Push) -> Option<State> {
        let result = self.engine.step(&mut self.engine.scratch(), state, push, &Stop::never());
        let moved = state.iter().any(|(i, a)| {
            let b = result.state.pose(i);
            (a.position() - b.position()).norm() > 0.002 || normalize_angle(a.theta - b.theta).abs() > 0.035
        });
        (result.status == PushStatus::Executed && result.left.is_empty() && moved).then_some(result.state)
    }

    fn freed(&self, state: &State) -> bool {
        let (scene, target) = (&self.problem.scene, self.problem.target);
        let solved = PlannerOptions::default().grasp.solved_score;
        self.test.best(scene, state, target, &mut GraspScratch::default()).is_some_and(|g| g.score >= solved)
    }

    /// The fewest pushes that free the target, if that is one or two.
    fn fewest(&self) -> Option<usize> {
        let root = &self.problem.state;
        let first: Vec<State> = self.pushes(root).iter().filter_map(|push| self.after(root, push)).collect();
        if first.iter().any(|s| self.freed(s)) {
            return Some(1);
        }
        let two = |s: &State| self.pushes(s).iter().filter_map(|push| self.after(s, push)).any(|s| self.freed(&s));
        first.iter().any(two).then_some(2)
    }
}

#[test]
fn what_is_called_shortest_is_shortest_by_trying_everything() {
    let mut seen = [0; 3];
    for problem in small(8) {
        // Of the default set every sequence of two would be ten times as many.
        let set = "pmbs_contour";
        let options = PlannerOptions { confirm: Confirm::Off, sampler: Some(set.into()), ..options() };
        let plan = solve(&options, &problem);
        let model = Model {
            engine: physics::engine(&options.model().unwrap(), Arc::clone(&problem.scene)).unwrap(),
            sampler: ContourSampler::preset(set).unwrap().prepare(&problem.scene),
            test: GraspTest::new(GraspParams::default()).unwrap(),
            problem,
        };
        let fewest = model.fewest();
        let (name, s) = (&model.problem.name, plan.statistics);
        seen[fewest.unwrap_or(3) - 1] += 1;
        // What the search went through, it went through rightly.
        let without = s.no_plan_within.unwrap_or(0) as usize;
        assert!(fewest.is_none_or(|n| n > without), "{name}: {fewest:?} {s:?}");
        if plan.outcome == Outcome::Solved {
            assert_eq!(s.proved_shortest, pushes(&plan) <= without + 1, "{name}: {s:?}");
            assert!(!s.proved_shortest || fewest.is_none_or(|n| n == pushes(&plan)), "{name}: {fewest:?} {s:?}");
        }
    }
    assert!(seen[0] > 0 && seen[1] > 0, "the scenes are of several kinds: {seen:?}");
}

#[test]
fn a_decision_of_several_searches_goes_forward_to_those_who_watch() {
    let mut longest = 0;
    for problem in small(4) {
        let seen = Arc::new(Mutex::new(Vec::new()));
        let note = Arc::clone(&seen);
        let progress = Progress::with_callback(Duration::ZERO, move |now| {
            note.lock().unwrap().push((now.iterations, now.simulations));
            true
        });
        let control = Control { progress: Some(Arc::new(progress)), ..Control::default() };
        let plan = Planner::new(options()).unwrap().solve(&problem, &control).unwrap();
        let seen = seen.lock().unwrap();
        assert!(seen.windows(2).all(|w| w[0].0 <= w[1].0 && w[0].1 <= w[1].1), "{}: {seen:?}", problem.name);
        let last = seen.last().unwrap();
        assert!(last.0 <= plan.statistics.iterations && last.1 <= plan.statistics.simulations);
        longest = longest.max(plan.statistics.iterations);
    }
    assert!(longest > 100, "some decision searched level 2: {longest}");
}

#[test]
fn a_search_that_was_cut_short_proves_nothing_beyond_what_it_tried() {
    let problem = small(8).into_iter().find(|p| {
        let s = solve(&options(), p).statistics;
        s.no_plan_within.is_some_and(|n| n >= 1)
    });
    let plan = solve(&PlannerOptions { budget: Budget::iterations(3), ..options() }, &problem.unwrap());
    assert_eq!(plan.statistics.no_plan_within, Some(0), "three pushes are not all of level 1");
    assert!(!plan.statistics.proved_shortest || pushes(&plan) == 1, "{:?}", plan.statistics);
}

#[test]
fn the_estimated_chance_is_what_execution_shows() {
    let judged = PhysicsOptions::named("prism", None, Purpose::Planning).unwrap();
    let (mut chance, mut expected, mut within, mut actions, mut trials) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for problem in small(6) {
        let plan = solve(&options(), &problem);
        let (Some(p), Some(e)) = (plan.statistics.success_chance, plan.statistics.expected_actions) else { continue };
        for trial in 0..6 {
            let judge = JudgeOptions { physics: judged.clone(), ..JudgeOptions::default() };
            let mut judge = Judge::new(&problem, &judge, trial).unwrap();
            // The plan's first push in a world like those of the ensemble, then the planner by what it sees and remembers.
            let mut planner = Planner::new(options()).unwrap();
            assert_eq!(planner.solve(&problem, &Control::default()).unwrap().actions[0].action, plan.actions[0].action);
            judge.execute(&plan.actions[0].action).unwrap();
            planner.advance(&plan.actions[0].action).unwrap();
            let control = Control::default();
            let rest = run_trial(&mut planner, &mut judge, trial, 12, &control, &mut |_| ()).unwrap();
            let taken = 1 + rest.actions + if rest.end == TrialEnd::Grasped { 0 } else { 6 };
            within += f64::from(u8::from(taken <= plan.actions.len()));
            actions += taken as f64;
            (chance, expected, trials) = (chance + p, expected + e, trials + 1.0);
        }
    }
    assert!(trials >= 24.0, "{trials}");
    let (chance, within) = (chance / trials, within / trials);
    assert!((chance - within).abs() < 0.25, "estimated {chance}, executed {within}");
    let (expected, actions) = (expected / trials, actions / trials);
    assert!((expected - actions).abs() < 0.75, "estimated {expected}, executed {actions}");
}

#[test]
fn the_chosen_action_stands_first_among_those_explained() {
    for problem in small(3) {
        let plan = solve(&options(), &problem);
        let weighed = plan.considered.iter().filter(|a| a.expected_actions.is_some()).count();
        if weighed > 0 {
            assert_eq!(plan.considered[0].action, plan.actions[0].action, "{}", problem.name);
            assert_eq!(plan.considered[0].expected_actions, plan.statistics.expected_actions);
        }
        let expected: Vec<f64> = plan.considered.iter().filter_map(|a| a.expected_actions).collect();
        assert!(expected.is_sorted() && plan.considered[weighed..].iter().all(|a| a.success_chance.is_none()));
        let text = explanation(&problem, &plan).render();
        let panels = text.matches("<g transform").count();
        assert_eq!(panels, plan.considered.len().min(9), "{}", problem.name);
        assert!(weighed == 0 || text.contains("chance ") && text.contains("1, chosen:"), "{}", problem.name);
    }
}

#[test]
fn the_suites_are_what_they_are_called() {
    let suite = |name: &str| {
        let suite = Suite::open(&format!("{}/suites/{name}", env!("CARGO_MANIFEST_DIR")), None).unwrap();
        assert!(suite.refused.is_empty() && suite.gripper() == "dissertation_mask", "{name}: {:?}", suite.refused);
        suite.problems
    };
    for (name, count, width) in [("own-hard", 22, 0.448), ("own-confined", 20, 0.288), ("deep", 20, 0.288)] {
        let problems = suite(name);
        assert_eq!(problems.len(), count);
        for problem in &problems {
            let w = problem.scene.workspace();
            assert!((w.max[0] - w.min[0] - width).abs() < 1e-9 && needs_push(problem).unwrap(), "{}", problem.name);
        }
        if name == "deep" {
            assert!(problems.iter().all(|p| needs_pushes(p, 3, 0.05).unwrap()));
        } else {
            assert!(!problems.iter().all(|p| needs_pushes(p, 3, 0.05).unwrap()));
        }
    }
}

/// A gripper that knows its chance of keeping: thresholds and expectation are chances, and threads change none of it.
#[test]
fn a_gripper_that_knows_its_chance_of_keeping_decides_by_it() {
    let alone = |height: f64| {
        let mut builder = SceneBuilder::new();
        builder.add_body(BodyDef { height, ..BodyDef::new(Shape::rectangle(0.0225, 0.045)) }).unwrap();
        builder.gripper(Gripper::robotiq_2f85_kept());
        let state = State::new([Pose2::new(0.5, 0.0, 0.4)]);
        Problem::new("half-cube", Arc::new(builder.build().unwrap()), state, 0).unwrap()
    };
    // Of a body that no grasp keeps surely the best is taken at once: no push makes it higher.
    for (height, least, greatest) in [(0.045, 0.9, 1.0), (0.0235, 0.3, 0.8)] {
        let plan = solve(&options(), &alone(height));
        assert_eq!((plan.outcome, plan.actions.len()), (Outcome::Solved, 1));
        let Action::Grasp(grasp) = plan.actions[0].action else { panic!("{plan:?}") };
        assert!((grasp.width - 0.045).abs() < 1e-6 && grasp.score > least && grasp.score < greatest, "{grasp:?}");
    }
    let mut weighed = 0;
    for mut problem in small(3) {
        problem.scene = Arc::new(problem.scene.with_gripper(Gripper::robotiq_2f85_kept()).unwrap());
        let plan = solve(&options(), &problem);
        assert_eq!(bits(&plan), bits(&solve(&PlannerOptions { threads: 2, ..options() }, &problem)));
        if let Some(chance) = plan.statistics.success_chance {
            assert!(chance < 1.0, "no grasp is certain: {chance}");
            weighed += 1;
        }
    }
    assert!(weighed > 0);
}
