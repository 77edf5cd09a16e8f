//! Limits and cancels by the work that is done, not by the clock: a token triggers at a look, a limit is over at once.

#[path = "common/carried.rs"]
mod carried;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use carried::carried_along;
use jostle::Result;
use jostle::action::{Action, Push};
use jostle::geom::{Pose2, Shape};
use jostle::net::{ImageScratch, MotionModel, ObjectBatch, PushValue, PushValueScratch, TargetProbability};
use jostle::physics::{PhysicsOptions, Purpose, PushJob, PushResult, PushStatus, engine};
use jostle::plan::clear::{CLEAR_PLANNERS, ClearOptions, ClearPlanner};
use jostle::plan::{Control, Outcome, OwnNetworks, PLANNERS, Plan, Planner, PlannerOptions};
use jostle::run::{Budget, CancelToken, Key, Stop};
use jostle::scene::{BodyDef, Clearing, Gripper, Problem, Scene, SceneBuilder, State, Workspace};

/// Blocks and discs on a square lattice, so near to each other that no finger fits between them.
fn pack(bodies: usize, seed: u64) -> (Arc<Scene>, State, usize) {
    let mut draw = Key::new(seed).stream();
    let columns = (bodies as f64).sqrt().ceil() as usize;
    let half = 0.025 * columns as f64 + 0.12;
    let mut builder = SceneBuilder::new();
    builder.workspace(Workspace { min: [-half, -half], max: [half, half], ..Workspace::default() });
    // Something is always in the way of the fingers, so that a search lasts.
    let mut gripper = Gripper::default();
    gripper.grasp.finger_width = 2.0;
    gripper.grasp.finger_thickness = 2.0;
    builder.gripper(gripper);
    let mut poses = Vec::new();
    for i in 0..bodies {
        let side = draw.uniform(0.040, 0.046);
        let shape = if draw.chance(0.7) { Shape::rectangle(side, side) } else { Shape::Disc { radius: side / 2.0 } };
        builder.add_body(BodyDef::new(shape)).unwrap();
        let at = |k: usize| 0.05 * (k as f64 - (columns - 1) as f64 / 2.0);
        poses.push(Pose2::new(at(i % columns), at(i / columns), draw.uniform(-0.02, 0.02)));
    }
    (Arc::new(builder.build().unwrap()), State::new(poses), bodies / 2)
}

/// Stand-ins that count what they are asked, and what of it after the end was asked for.
#[derive(Default)]
struct Counts {
    asked: AtomicU64,
    late: AtomicU64,
}

impl Counts {
    fn note(&self, items: usize, stop: &Stop) {
        self.asked.fetch_add(items as u64, Ordering::Relaxed);
        if stop.reason().is_some() {
            self.late.fetch_add(items as u64, Ordering::Relaxed);
        }
    }
}

struct Moves(Arc<Counts>);

impl MotionModel for Moves {
    fn name(&self) -> &str {
        "moves"
    }
    fn wants_guess(&self) -> bool {
        false
    }
    fn chunk(&self) -> usize {
        4
    }
    fn predict(&self, batch: &ObjectBatch, motions: &mut Vec<[f32; 3]>, stop: &Stop) -> Result<()> {
        self.0.note(batch.items(), stop);
        carried_along(batch, 0.045, 0.034, motions);
        Ok(())
    }
}

struct Never(Arc<Counts>);

impl TargetProbability for Never {
    fn probability(&self, _: &mut ImageScratch, _: &Scene, _: &State, _: usize, stop: &Stop) -> Result<f64> {
        self.0.note(1, stop);
        Ok(0.1)
    }
    fn threshold(&self) -> f64 {
        0.5
    }
}

struct Ranks(Arc<Counts>);

impl PushValue for Ranks {
    fn name(&self) -> &str {
        "ranks"
    }
    fn values(
        &self,
        _: &mut PushValueScratch,
        _: &Scene,
        _: &State,
        _: usize,
        pushes: &[Push],
        values: &mut Vec<f32>,
        stop: &Stop,
    ) -> Result<()> {
        self.0.note(1, stop);
        values.clear();
        values.extend((0..pushes.len()).map(|i| 1.0 / (1.0 + i as f32)));
        Ok(())
    }
}

fn is_clearing(planner: &str) -> bool {
    CLEAR_PLANNERS.contains(&planner)
}

/// Every planner with stand-ins for its networks.
fn decide(planner: &str, bodies: usize, budget: Budget, control: &Control, counts: &Arc<Counts>) -> (Plan, usize) {
    let (scene, state, target) = pack(bodies, bodies as u64);
    let learned = matches!(planner, "vft" | "dipn" | "dipn_gn");
    let own = OwnNetworks {
        motion: learned.then(|| Arc::new(Moves(Arc::clone(counts))) as Arc<dyn MotionModel>),
        graspability: learned.then(|| Arc::new(Never(Arc::clone(counts))) as Arc<dyn TargetProbability>),
        push_value: matches!(planner, "more" | "ppn")
            .then(|| Arc::new(Ranks(Arc::clone(counts))) as Arc<dyn PushValue>),
        grasp_map: None,
    };
    let options = PlannerOptions { planner: planner.into(), budget, seed: 3, threads: 1, ..PlannerOptions::default() };
    if is_clearing(planner) {
        let mut planner = ClearPlanner::with_networks(ClearOptions::of(options), own).unwrap();
        let plan = planner.solve(&Clearing::new("pack", scene, state).unwrap(), control).unwrap();
        (plan, planner.memory_bytes())
    } else {
        let mut planner = Planner::with_networks(options, own).unwrap();
        let plan = planner.solve(&Problem::new("pack", scene, state, target).unwrap(), control).unwrap();
        (plan, planner.memory_bytes())
    }
}

fn planners() -> impl Iterator<Item = &'static str> {
    PLANNERS.into_iter().chain(CLEAR_PLANNERS)
}

#[test]
fn nothing_more_is_begun_once_the_end_was_asked_for() {
    for planner in planners().filter(|planner| !matches!(*planner, "random_push" | "grasp_only")) {
        for (bodies, looks) in [(5, 1), (5, 30), (12, 4), (12, 60), (40, 2), (40, 50), (40, 300)] {
            let counts = Arc::new(Counts::default());
            let control = Control { cancel: vec![CancelToken::after_looks(looks)], ..Control::default() };
            let (plan, _) = decide(planner, bodies, Budget::iterations(1 << 30), &control, &counts);
            let here = format!("{planner}, {bodies} bodies, {looks} looks");
            assert_eq!(plan.outcome, Outcome::Cancelled, "{here}");
            assert!(plan.actions.is_empty() && plan.considered.is_empty(), "{here}");
            assert_eq!(counts.late.load(Ordering::Relaxed), 0, "{here}: a network was asked after the end");
            // Work is cut into pieces with a look before each: a chunk of a network, some steps of some pushes.
            let items = counts.asked.load(Ordering::Relaxed);
            assert!(items <= 4 * looks, "{here}: {items} items of networks");
            let simulations = plan.statistics.simulations + plan.statistics.confirm_simulations;
            assert!(simulations <= 4 * looks, "{here}: {simulations} pushes");
        }
    }
}

#[test]
fn a_limit_that_is_over_at_once_leaves_a_legal_action() {
    for planner in planners().filter(|planner| *planner != "grasp_only") {
        for bodies in [2, 5, 12, 40, 128] {
            let counts = Arc::new(Counts::default());
            let (plan, _) = decide(planner, bodies, Budget::seconds(1e-9), &Control::default(), &counts);
            let here = format!("{planner}, {bodies} bodies");
            assert_eq!(
                plan.outcome,
                if planner == "random_push" { Outcome::Partial } else { Outcome::Budget },
                "{here}"
            );
            assert_eq!(counts.asked.load(Ordering::Relaxed), 0, "{here}");
            let [first] = &plan.actions[..] else { panic!("{here}: {} actions", plan.actions.len()) };
            let Action::Push(push) = first.action else { panic!("{here}: nothing can be grasped") };
            let (scene, state, _) = pack(bodies, bodies as u64);
            let planar = engine(&PhysicsOptions::named("planar", None, Purpose::Planning).unwrap(), scene).unwrap();
            let result = planar.step(&mut planar.scratch(), &state, &push, &Stop::never());
            assert_eq!(result.status, PushStatus::Executed, "{here}: the tip starts clear of everything");
        }
    }
}

#[test]
fn a_byte_budget_bounds_what_is_kept() {
    for planner in planners().filter(|planner| !matches!(*planner, "random_push" | "grasp_only")) {
        for bytes in [60_000, 100_000, 250_000, 1_000_000] {
            let budget = Budget { iterations: Some(400), seconds: None, bytes: Some(bytes) };
            let (plan, kept) = decide(planner, 10, budget, &Control::default(), &Arc::default());
            assert!(kept > 0 && kept <= bytes, "{planner}, {bytes} bytes: {kept}");
            assert!(!plan.actions.is_empty(), "{planner}, {bytes} bytes");
        }
    }
}

/// A body whose outline has so many corners and no two on one line: many convex pieces.
fn star(corners: usize) -> Shape {
    let corner = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / corners as f64;
        let radius = if k.is_multiple_of(2) { 0.045 } else { 0.036 };
        [radius * angle.cos(), radius * angle.sin()]
    };
    Shape::Polygon((0..corners).map(corner).collect())
}

#[test]
fn engines_look_at_the_stop_by_the_work_they_do() {
    for name in ["planar", "prism", "rapier"] {
        for corners in [8, 60] {
            let mut builder = SceneBuilder::new();
            let poses: Vec<Pose2> = (0..4).map(|i| Pose2::new(0.4 + 0.0905 * f64::from(i), 0.0, 0.0)).collect();
            for _ in &poses {
                builder.add_body(BodyDef::new(star(corners))).unwrap();
            }
            let scene = Arc::new(builder.build().unwrap());
            let options = PhysicsOptions::named(name, None, Purpose::Planning).unwrap();
            let engine = engine(&options, scene).unwrap();
            let state = State::new(poses);
            let push = Push::new(jostle::geom::vec2(0.34, 0.0), jostle::geom::vec2(0.42, 0.0));
            let jobs = vec![PushJob { state: &state, push }; 20];
            let mut scratch = engine.scratch();
            let mut interrupted = |looks: u64| {
                let stop = Budget::default().start(&[CancelToken::after_looks(looks)]);
                let mut results = vec![PushResult::default(); jobs.len()];
                engine.step_batch(&mut scratch, &jobs, &mut results, &stop);
                results.iter().filter(|r| r.status == PushStatus::Interrupted).count()
            };
            // A push takes more looks than one, and those that are interrupted leave nothing behind.
            assert_eq!(interrupted(1), 20, "{name}");
            for looks in [2, 5, 10, 20] {
                assert!(interrupted(looks) >= 18, "{name}, {corners} corners, {looks} looks: {}", interrupted(looks));
            }
            assert_eq!(interrupted(u64::MAX), 0, "{name}");
        }
    }
}
