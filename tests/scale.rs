//! Scenes of every size: what is valid is planned, whatever the gripper measures.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use jostle::action::{Action, ContourSampler, Push, PushSampler, SamplerScratch};
use jostle::geom::{Pose2, Shape};
use jostle::grasp::{GraspParams, GraspScratch, GraspTest};
use jostle::physics::{self, ENGINES, PhysicsOptions, PushStatus};
use jostle::plan::clear::{ClearOptions, ClearPlanner};
use jostle::plan::{Confirm, Control, Outcome, Plan, Planner, PlannerOptions, Reason};
use jostle::run::{Budget, Key, Stop, Stream};
use jostle::scene::generate::{Generator, GeneratorParams};
use jostle::scene::{BodyDef, Clearing, Gripper, Problem, Scene, SceneBuilder, State, Workspace};

fn shape(draw: &mut Stream, scale: f64) -> Shape {
    let mut side = || scale * draw.uniform(0.015, 0.075);
    let (a, b) = (side(), side());
    match draw.index(3) {
        0 => Shape::Disc { radius: a / 2.0 },
        1 => Shape::rectangle(a, b),
        _ => Shape::ConvexPolygon(vec![[-a / 2.0, -b / 2.0], [a / 2.0, -b / 2.0], [0.0, b / 2.0]]),
    }
}

/// Bodies in a heap round the target, drawn at random; none where they lie in each other too deep.
fn heap(key: Key, scale: f64) -> Option<Problem> {
    let draw = &mut key.stream();
    let mut builder = SceneBuilder::new();
    let mut poses = Vec::new();
    for _ in 0..1 + draw.index(7) {
        builder.add_body(BodyDef { height: scale * 0.045, ..BodyDef::new(shape(draw, scale)) }).ok()?;
        let mut at = || scale * draw.uniform(-0.09, 0.09);
        let (x, y) = (at(), at());
        poses.push(Pose2::new(0.5 * scale + x, y, draw.uniform(-3.1, 3.1)));
    }
    builder.gripper(Gripper::robotiq_2f85().scaled(scale));
    let side = |at: f64| scale * at;
    builder.workspace(Workspace {
        min: [side(0.276), side(-0.224)],
        max: [side(0.724), side(0.224)],
        ..Workspace::default()
    });
    builder.overlap_tolerance((scale * 0.006).min(0.05));
    Problem::new("heap", Arc::new(builder.build().ok()?), State::new(poses), 0).ok()
}

/// The first so many valid heaps of a scale.
fn heaps(scale: f64, count: usize) -> impl Iterator<Item = Problem> {
    let key = Key::new(17).child((scale * 1000.0) as u64);
    (0..).filter_map(move |i| heap(key.child(i), scale)).take(count)
}

/// How many of these heaps no grasp test gets through.
fn panics(scale: f64, count: usize) -> usize {
    let test = GraspTest::new(GraspParams::default()).unwrap();
    let broken = |problem: &Problem| {
        let test = test.prepared(&problem.scene);
        let assess = |body| test.assess(&problem.scene, &problem.state, body, &mut GraspScratch::default()).score;
        catch_unwind(AssertUnwindSafe(|| (0..problem.scene.len()).map(assess).sum::<f64>())).is_err()
    };
    heaps(scale, count).filter(broken).count()
}

const SCALES: [f64; 8] = [0.05, 0.1, 0.3, 0.7, 1.0, 2.0, 5.0, 10.0];

#[test]
fn valid_scenes_of_any_size_are_judged_without_a_panic() {
    let broken: Vec<_> = SCALES.map(|scale| (scale, panics(scale, 200))).into_iter().filter(|b| b.1 > 0).collect();
    assert!(broken.is_empty(), "scale and number of heaps of 200: {broken:?}");
}

#[test]
#[ignore = "minutes; the same with many more"]
fn thousands_of_valid_scenes_of_any_size_are_judged_without_a_panic() {
    let broken = SCALES.map(|scale| (scale, panics(scale, 4000)));
    assert!(broken.iter().all(|b| b.1 == 0), "scale and number of heaps of 4000: {broken:?}");
}

#[test]
fn valid_scenes_of_any_size_are_planned() {
    for planner in ["hedge", "pmbs", "mcts"] {
        for scale in SCALES {
            let options =
                PlannerOptions { planner: planner.into(), budget: Budget::iterations(4), ..PlannerOptions::default() };
            let mut planner_of = Planner::new(options).unwrap();
            for (i, problem) in heaps(scale, 6).enumerate() {
                let plan = planner_of.solve(&problem, &Control::default());
                assert!(plan.is_ok(), "{planner}, scale {scale}, heap {i}: {plan:?}");
            }
        }
    }
}

/// The scene with every length times `factor`, built anew from the bodies' definitions.
fn scaled_scene(scene: &Scene, factor: f64) -> Arc<Scene> {
    let mut builder = SceneBuilder::new();
    for body in scene.bodies() {
        let def = body.def();
        builder
            .add_body(BodyDef {
                shape: def.shape.scaled(factor),
                height: factor * def.height,
                centre_of_mass: def.centre_of_mass.map(|c| c.map(|v| factor * v)),
                inertia: def.inertia.map(|i| factor * factor * i),
                outline_tolerance: Some(factor * def.outline_tolerance.unwrap_or(1e-4)),
                ..def
            })
            .unwrap();
    }
    let workspace = scene.workspace();
    builder.gripper(scene.gripper().scaled(factor)).friction(*scene.friction());
    builder.workspace(Workspace {
        min: workspace.min.map(|v| factor * v),
        max: workspace.max.map(|v| factor * v),
        ..*workspace
    });
    builder.overlap_tolerance((factor * scene.overlap_tolerance()).min(0.05));
    Arc::new(builder.build().unwrap())
}

fn scaled_state(state: &State, factor: f64) -> State {
    let at = |i: usize| {
        let p = state.pose(i);
        Pose2::new(factor * p.x, factor * p.y, p.theta)
    };
    State::new((0..state.len()).map(at))
}

fn scaled_problem(problem: &Problem, factor: f64) -> Problem {
    let scene = scaled_scene(&problem.scene, factor);
    Problem::new("scaled", scene, scaled_state(&problem.state, factor), problem.target).unwrap()
}

const FACTORS: [f64; 7] = [0.1, 0.125, 0.2, 0.5, 2.0, 8.0, 10.0];

/// How far an action is from another with every length times `factor`, in lengths of the other.
fn apart(a: &Action, other: &Action, factor: f64) -> f64 {
    let points = |p: [f64; 2], q: [f64; 2]| (p[0] / factor - q[0]).hypot(p[1] / factor - q[1]);
    match (a, other) {
        (Action::Push(p), Action::Push(q)) if p.body == q.body => points(p.start, q.start).max(points(p.end, q.end)),
        (Action::Grasp(p), Action::Grasp(q)) if p.body == q.body => {
            let sizes = (p.opening / factor - q.opening).abs().max((p.width / factor - q.width).abs());
            points(p.position, q.position).max(sizes)
        }
        _ => f64::INFINITY,
    }
}

/// The plans have the same outcome and the same kinds of actions, nearer to each other than `within` metres.
fn assert_alike(plan: &Plan, other: &Plan, factor: f64, within: f64, of: &str) {
    let kinds = |p: &Plan| -> (Outcome, Vec<bool>) {
        (p.outcome, p.actions.iter().map(|a| matches!(a.action, Action::Push(_))).collect())
    };
    assert_eq!(kinds(plan), kinds(other), "{of} times {factor}");
    for (k, (a, b)) in plan.actions.iter().zip(&other.actions).enumerate() {
        let apart = apart(&a.action, &b.action, factor);
        assert!(apart <= within, "{of} times {factor}, action {k}: {apart}: {:?} for {:?}", a.action, b.action);
    }
}

/// Metres that plans may differ by. Poses are single-precision numbers. A factor that is a power of two loses no bit of them, and
/// plans are the same. Every other factor rounds them; a push in clutter can make millimetres of that, and then plans
/// are alike in outcome and kinds of actions only.
fn tolerance(factor: f64) -> f64 {
    if factor.log2().fract() == 0.0 { 1e-9 } else { f64::INFINITY }
}

fn generated(index: u64) -> Problem {
    let params = GeneratorParams { bodies: 4..=7, ..GeneratorParams::default() };
    Generator::new(params, 5).unwrap().problem(index).unwrap()
}

#[test]
fn whole_scenes_times_any_factor_are_planned_alike() {
    for planner in ["hedge", "pmbs", "mcts"] {
        let options = PlannerOptions {
            planner: planner.into(),
            budget: Budget::iterations(100),
            seed: 3,
            ..PlannerOptions::default()
        };
        let solve =
            |problem: &Problem| Planner::new(options.clone()).unwrap().solve(problem, &Control::default()).unwrap();
        for index in 0..4 {
            let problem = generated(index);
            let plan = solve(&problem);
            for factor in FACTORS {
                let scaled = solve(&scaled_problem(&problem, factor));
                assert_alike(&scaled, &plan, factor, tolerance(factor), &format!("{planner}, scene {index}"));
            }
        }
    }
}

#[test]
fn whole_tables_times_any_factor_are_cleared_alike() {
    // The noise of the confirming worlds, and which of equal pushes comes first, follow from the bits of the poses.
    let options = ClearOptions { confirm: Confirm::Off, ..ClearOptions::default() };
    let solve =
        |problem: &Clearing| ClearPlanner::new(options.clone()).unwrap().solve(problem, &Control::default()).unwrap();
    for index in 0..3 {
        let (scene, state) = pack(index);
        let table = |factor: f64| Clearing {
            name: String::new(),
            scene: scaled_scene(&scene, factor),
            state: scaled_state(&state, factor),
        };
        let plan = solve(&table(1.0));
        assert!(matches!(plan.actions[0].action, Action::Push(_)), "a pack is pushed apart first: {plan:?}");
        for factor in FACTORS {
            assert_alike(&solve(&table(factor)), &plan, factor, f64::INFINITY, &format!("table {index}"));
        }
    }
}

/// Nine cubes a millimetre or more apart, no two gaps alike, turned as one.
fn pack(index: u32) -> (Arc<Scene>, State) {
    let mut builder = SceneBuilder::new();
    let theta = 0.2 * f64::from(index);
    let turned = Pose2::new(0.5, 0.0, theta);
    let mut poses = Vec::new();
    for k in 0..9 {
        builder.add_body(BodyDef::new(Shape::rectangle(0.045, 0.045))).unwrap();
        let at = |k: i32| 0.047 * f64::from(k - 1);
        let off = 1.5e-4 * f64::from(k * k % 7);
        poses.push(turned.compose(&Pose2::new(at(k / 3) + off, at(k % 3) - off, 0.0)));
    }
    (Arc::new(builder.build().unwrap()), State::new(poses))
}

#[test]
fn a_push_of_every_engine_is_the_same_at_any_size() {
    for info in ENGINES.iter().filter(|e| e.available.is_ok() && e.id != "dipn") {
        for preset in [info.planning, info.judging] {
            let options = PhysicsOptions { engine: info.id.into(), preset: preset.into(), settings: None };
            let problem = generated(1);
            let sampler = ContourSampler::preset("dense").unwrap();
            let (mut pushes, mut scratch) = (Vec::new(), SamplerScratch::default());
            let random = &mut Key::new(1).stream();
            sampler.sample(&problem.scene, &problem.state, 0, None, random, &mut scratch, &mut pushes);
            let step = |problem: &Problem, push: &Push| {
                let engine = physics::engine(&options, Arc::clone(&problem.scene)).unwrap();
                let result = engine.step(&mut engine.scratch(), &problem.state, push, &Stop::never());
                assert_eq!(result.status, PushStatus::Executed);
                result
            };
            for (k, push) in pushes.iter().take(4).enumerate() {
                let result = step(&problem, push);
                for factor in FACTORS {
                    let after = step(&scaled_problem(&problem, factor), &push.scaled(factor));
                    let of = format!("{} {preset}, push {k}, times {factor}", info.id);
                    assert_eq!((after.touched, after.left), (result.touched, result.left), "{of}");
                    let exact = tolerance(factor).is_finite();
                    for i in 0..problem.scene.len() {
                        let (p, q) = (after.state.pose(i), result.state.pose(i));
                        let off = (p.x / factor - q.x).hypot(p.y / factor - q.y);
                        let turn = (p.theta - q.theta).abs();
                        let most = if exact { (1e-9, 1e-9) } else { (1e-2, 0.3) };
                        assert!(off <= most.0 && turn <= most.1, "{of}, body {i}: {off} m, {turn} rad");
                    }
                }
            }
        }
    }
}

#[test]
fn tips_of_any_thickness_find_room_to_push() {
    for name in ["vft", "more", "pmbs", "pmbs_contour", "dense", "rich"] {
        for thickness in [0.004, 0.022, 0.04, 0.054, 0.06, 0.1] {
            for clearance in [0.0, 0.002, 0.01] {
                let mut builder = SceneBuilder::new();
                builder.add_body(BodyDef::new(Shape::Disc { radius: 0.05 })).unwrap();
                let mut gripper = Gripper::robotiq_2f85();
                (gripper.push.thickness, gripper.push.clearance) = (thickness, clearance);
                builder.gripper(gripper);
                let scene = Arc::new(builder.build().unwrap());
                let state = State::new([Pose2::new(0.5, 0.0, 0.0)]);
                let sampler = ContourSampler::preset(name).unwrap().prepared(&scene);
                let (mut pushes, mut scratch) = (Vec::new(), SamplerScratch::default());
                sampler.sample(&scene, &state, 0, None, &mut Key::new(1).stream(), &mut scratch, &mut pushes);
                assert!(pushes.len() >= 4, "{name}, {thickness} m thick, {clearance} m clear: {pushes:?}");
                let engine = physics::engine(&PhysicsOptions::default(), Arc::clone(&scene)).unwrap();
                for push in &pushes {
                    let result = engine.step(&mut engine.scratch(), &state, push, &Stop::never());
                    let moved = result.state != state;
                    assert!(result.status == PushStatus::Executed && moved, "{name} {thickness} {clearance}: {push:?}");
                }
            }
        }
    }
}

#[test]
fn a_free_cube_that_suits_its_gripper_is_grasped_at_once_and_as_well_at_any_size() {
    let grasp_of = |scale: f64| {
        let mut builder = SceneBuilder::new();
        let side = scale * 0.045;
        builder.add_body(BodyDef { height: side, ..BodyDef::new(Shape::rectangle(side, side)) }).unwrap();
        builder.gripper(Gripper::robotiq_2f85().scaled(scale));
        let scene = Arc::new(builder.build().unwrap());
        let problem = Problem::new("cube", scene, State::new([Pose2::new(0.5, 0.0, 0.3)]), 0).unwrap();
        let plan = Planner::new(PlannerOptions::default()).unwrap().solve(&problem, &Control::default()).unwrap();
        match plan.actions.as_slice() {
            [only] => match only.action {
                Action::Grasp(grasp) => grasp.score,
                Action::Push(push) => panic!("{scale}: {push:?}"),
            },
            actions => panic!("{scale}: {actions:?}"),
        }
    };
    let score = grasp_of(1.0);
    assert!(score > 0.9, "{score}");
    for scale in [0.05, 0.1, 0.2, 0.5, 3.0] {
        assert!((grasp_of(scale) - score).abs() < 1e-5, "{scale}: {} for {score}", grasp_of(scale));
    }
}

#[test]
fn a_target_that_no_grasp_fits_is_shown_infeasible_at_once_with_the_two_numbers() {
    let around = [[0.0, 0.0], [0.05, 0.0], [0.0, 0.05]];
    for (opening, shape, width) in [
        (0.03, Shape::rectangle(0.045, 0.045), Some(0.045)),
        (0.0807, Shape::rectangle(0.09, 0.12), Some(0.09)),
        // Held beside its middle, as far as its wedge allows, it is narrower.
        (0.0807, Shape::Disc { radius: 0.05 }, Some(0.09656)),
        (0.0807, Shape::rectangle(0.008, 0.008), None),
    ] {
        let mut builder = SceneBuilder::new();
        for i in 0..around.len() {
            let shape = if i == 0 { shape.clone() } else { Shape::rectangle(0.02, 0.02) };
            builder.add_body(BodyDef::new(shape).named(["target", "one", "other"][i])).unwrap();
        }
        let mut gripper = Gripper::robotiq_2f85();
        gripper.grasp.opening = opening;
        builder.gripper(gripper);
        let state = State::new(around.map(|[x, y]| Pose2::new(0.5 + 2.0 * x, 2.0 * y, 0.0)));
        let problem = Problem::new("wide", Arc::new(builder.build().unwrap()), state, 0).unwrap();
        for planner in ["hedge", "pmbs", "mcts"] {
            let options = PlannerOptions { planner: planner.into(), ..PlannerOptions::default() };
            let plan = Planner::new(options).unwrap().solve(&problem, &Control::default()).unwrap();
            let told = (plan.outcome, plan.actions.len(), plan.statistics.iterations);
            assert_eq!(told, (Outcome::Infeasible, 0, 0), "{planner} {shape:?}");
            match (&plan.reasons[..], width) {
                ([Reason::TooWide { body, width, opening: most, .. }], Some(least)) => {
                    assert_eq!(body, "target");
                    assert!((width - least).abs() < 1e-5 && *most == opening, "{:?}", plan.reasons);
                    let text = plan.reasons[0].to_string();
                    let numbers = [format!("{:.1} mm", width * 1e3), format!("{:.1} mm", opening * 1e3)];
                    assert!(numbers.iter().all(|n| text.contains(n)), "{text}");
                }
                ([Reason::NoHold { body }], None) => assert_eq!(body, "target"),
                (reasons, _) => panic!("{reasons:?}"),
            }
        }
    }
}
