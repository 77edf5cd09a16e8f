//! A robot's tip sinks and lifts on the way: what that does to pushes, in every engine that follows it.

use std::sync::Arc;

use jostle::action::Push;
use jostle::geom::{Pose2, Shape, vec2};
use jostle::physics::{ENGINES, PhysicsOptions, PushResult, PushStatus, engine};
use jostle::run::Stop;
use jostle::scene::{BodyDef, Gripper, Scene, SceneBuilder, State, TipPath};

/// The engines of this build that follow paths.
fn engines() -> Vec<&'static str> {
    let all: Vec<&str> = ENGINES.iter().filter(|e| e.available.is_ok()).map(|e| e.id).collect();
    all.into_iter().filter(|id| ["planar", "prism", "bullet"].contains(id)).collect()
}

fn scene(height: f64, gripper: Gripper) -> (Arc<Scene>, State) {
    let mut builder = SceneBuilder::new();
    let side = 0.045 * gripper.scale();
    let block = BodyDef { height, ..BodyDef::new(Shape::rectangle(side, side)) };
    builder.add_body(block).unwrap();
    builder.gripper(gripper);
    (Arc::new(builder.build().unwrap()), State::new([Pose2::new(0.5, 0.0, 0.0)]))
}

fn push(id: &str, scene: &Arc<Scene>, state: &State, push: Push) -> PushResult {
    let options = PhysicsOptions::named(id, None, jostle::physics::Purpose::Planning).unwrap();
    let engine = engine(&options, Arc::clone(scene)).unwrap();
    engine.step(&mut engine.scratch(), state, &push, &Stop::never())
}

/// From 20 mm before the block's face by 100 mm, along the arm.
fn along() -> Push {
    Push::new(vec2(0.4465, 0.0), vec2(0.5465, 0.0))
}

#[test]
fn the_arm_lifts_before_the_end_and_a_low_body_is_left_behind_sooner() {
    for id in engines() {
        let far = |height: f64, gripper: Gripper| {
            let (scene, state) = scene(height, gripper);
            let result = push(id, &scene, &state, along());
            assert_eq!(result.status, PushStatus::Executed, "{id} {height}");
            result.state.pose(0).x - 0.5
        };
        let straight = far(0.045, Gripper::robotiq_2f85());
        let robot = |height: f64| far(height, Gripper::robotiq_2f85_ur5e());
        assert!((0.078..0.092).contains(&straight), "{id}: {straight}");
        let ways = [0.023, 0.045, 0.07].map(robot);
        println!("{id}: straight {straight:.4}, by height {ways:.4?}");
        assert!(ways[0] < ways[1] - 0.003 && ways[2] < straight + 1e-3, "{id}: {ways:?}");
        assert!(ways[1] < straight - 0.002 && ways[0] > straight - 0.0181 - 0.006, "{id}: {straight} {ways:?}");
        // Bullet lets what rests creep by hundredths of a millimetre.
        assert!(robot(0.009).abs() < 1e-4, "{id}: the tip never comes down so low");
    }
}

#[test]
fn across_the_arm_the_push_is_shorter() {
    for id in engines() {
        let (scene, state) = scene(0.023, Gripper::robotiq_2f85_ur5e());
        let across = Push::new(vec2(0.5, -0.0535), vec2(0.5, 0.0465));
        let far = push(id, &scene, &state, across).state.pose(0).y;
        let near = push(id, &scene, &state, along()).state.pose(0).x - 0.5;
        assert!(far > 0.05 && far < near - 0.003, "{id}: {far} across, {near} along");
    }
}

#[test]
fn a_robot_of_another_size_pushes_alike() {
    for id in engines() {
        let moved = |factor: f64| {
            let gripper = Gripper::robotiq_2f85_ur5e().scaled(factor);
            let mut builder = SceneBuilder::new();
            let side = 0.045 * factor;
            builder.add_body(BodyDef { height: side, ..BodyDef::new(Shape::rectangle(side, side)) }).unwrap();
            builder.gripper(gripper);
            let scene = Arc::new(builder.build().unwrap());
            let state = State::new([Pose2::new(0.5 * factor, 0.0, 0.0)]);
            push(id, &scene, &state, along().scaled(factor)).state.pose(0).x / factor - 0.5
        };
        assert!((moved(0.5) - moved(1.0)).abs() < 2e-4, "{id}: {} {}", moved(0.5), moved(1.0));
    }
}

#[test]
fn an_engine_that_cannot_follow_the_path_says_so() {
    let (with, _) = scene(0.045, Gripper::robotiq_2f85_ur5e());
    let error = engine(&PhysicsOptions::preset("fast"), with).err().unwrap().to_string();
    assert!(error.contains("`rapier` cannot follow") && error.contains("planar, prism, bullet"), "{error}");
    let (without, _) = scene(0.045, Gripper::robotiq_2f85_kept());
    engine(&PhysicsOptions::preset("fast"), without).unwrap();
}

/// A path at the engine's own height that never lifts is no path.
#[test]
fn a_straight_path_is_the_straight_push() {
    use jostle::scene::Table;
    for (id, level) in [("planar", 0.01), ("prism", 0.0125), ("bullet", 0.011)] {
        if !engines().contains(&id) {
            continue;
        }
        let flat = TipPath {
            sink: Table::new(&[[0.0, level]]),
            shortfall_along: 0.0,
            shortfall_across: 0.0,
            base: None,
            rise: Table::new(&[[0.0, 0.0], [1.0, 0.0]]),
        };
        let gripper = Gripper { path: Some(flat), ..Gripper::robotiq_2f85() };
        let (with, state) = scene(0.045, gripper);
        let (without, _) = scene(0.045, Gripper::robotiq_2f85());
        let (a, b) = (push(id, &with, &state, along()), push(id, &without, &state, along()));
        let apart = (a.state.pose(0).position() - b.state.pose(0).position()).norm();
        assert!(apart < 1e-4, "{id}: {apart}");
    }
}

/// Bullet tries a grasp out with fingers that end where the gripper's do: above low neighbours on every side.
#[cfg(feature = "bullet")]
#[test]
fn fingers_that_end_above_the_neighbours_are_not_blocked_by_them() {
    use jostle::grasp::{GraspParams, GraspScratch, GraspTest};
    use jostle::scene::Grasper;
    let held = |finger_length: f64| {
        let mut builder = SceneBuilder::new();
        let mut poses = Vec::new();
        for (x, y, height) in
            [(0.0, 0.0, 0.1), (0.046, 0.0, 0.02), (-0.046, 0.0, 0.02), (0.0, 0.046, 0.02), (0.0, -0.046, 0.02)]
        {
            builder.add_body(BodyDef { height, ..BodyDef::new(Shape::rectangle(0.045, 0.045)) }).unwrap();
            poses.push(Pose2::new(0.5 + x, y, 0.0));
        }
        let jaw = Gripper::robotiq_2f85();
        builder.gripper(Gripper { grasp: Grasper { finger_length, ..jaw.grasp }, ..jaw });
        let (scene, state) = (Arc::new(builder.build().unwrap()), State::new(poses));
        let short = scene.with_gripper(Gripper {
            grasp: Grasper { finger_length: 0.03, ..scene.gripper().grasp },
            ..scene.gripper().clone()
        });
        let test = GraspTest::new(GraspParams::default()).unwrap();
        let grasp = test.best(&short.unwrap(), &state, 0, &mut GraspScratch::default()).expect("it is above them");
        let options = PhysicsOptions::named("bullet", None, jostle::physics::Purpose::Judging).unwrap();
        let engine = engine(&options, Arc::clone(&scene)).unwrap();
        engine.grasp(&mut engine.scratch(), &state, &grasp, &Stop::never()).unwrap().took(0)
    };
    assert!(held(0.03), "they end at 70 mm");
    assert!(!held(f64::INFINITY), "they end at the table, on the neighbours");
}
