//! The contract of every [`Transition`]: what holds for an engine whatever its model.

use std::sync::{Arc, OnceLock};

use jostle::action::Push;
use jostle::geom::{Pose2, Shape, vec2};
use jostle::net::MotionModel;
use jostle::physics::{
    EngineInfo, EngineSettings, PhysicsOptions, Purpose, PushJob, PushResult, PushStatus, Transition, engine,
    engine_with, network,
};
use jostle::run::{Budget, CancelToken, Stop};
use jostle::scene::{BodyDef, Gripper, LeaveRule, Scene, SceneBuilder, State, Workspace};

const CENTRE: [f64; 2] = [0.5, 0.0];

/// Every engine of this build with every preset, on this scene. The learned one among them wherever its network can be
/// run.
fn engines(scene: &Arc<Scene>) -> Vec<Arc<dyn Transition>> {
    static LEARNED: OnceLock<Option<Arc<dyn MotionModel>>> = OnceLock::new();
    let learned = LEARNED.get_or_init(|| {
        let load = || network(&PhysicsOptions::named("dipn", None, Purpose::Planning)?);
        load().unwrap_or_else(|e| {
            println!("the learned engine is left out: {e}");
            None
        })
    });
    let options = EngineInfo::available().filter(|info| info.id != "dipn" || learned.is_some()).flat_map(|info| {
        info.presets.iter().map(|preset| PhysicsOptions { engine: info.id.into(), ..PhysicsOptions::preset(preset) })
    });
    options.map(|o| engine_with(&o, Arc::clone(scene), learned.as_ref()).unwrap()).collect()
}

fn scene_of(shapes: &[Shape]) -> Arc<Scene> {
    let mut builder = SceneBuilder::new();
    for shape in shapes {
        builder.add_body(BodyDef::new(shape.clone())).unwrap();
    }
    Arc::new(builder.build().unwrap())
}

fn square() -> Shape {
    Shape::rectangle(0.045, 0.045)
}

fn at(poses: &[(f64, f64, f64)]) -> State {
    State::new(poses.iter().map(|&(x, y, t)| Pose2::new(CENTRE[0] + x, CENTRE[1] + y, t)))
}

fn push(x0: f64, y0: f64, x1: f64, y1: f64) -> Push {
    Push::new(vec2(CENTRE[0] + x0, CENTRE[1] + y0), vec2(CENTRE[0] + x1, CENTRE[1] + y1))
}

fn run(engine: &dyn Transition, state: &State, push: &Push) -> PushResult {
    engine.step(&mut engine.scratch(), state, push, &Stop::never())
}

#[test]
fn a_centred_push_moves_a_block_straight_by_the_travel_in_contact() {
    let scene = scene_of(&[square(), Shape::Disc { radius: 0.022 }]);
    for engine in engines(&scene) {
        let state = at(&[(0.0, 0.0, 0.0), (0.0, 0.15, 0.0)]);
        let result = run(&*engine, &state, &push(-0.06, 0.0, 0.04, 0.0));
        assert_eq!(result.status, PushStatus::Executed, "{}", engine.name());
        // The tip's front ends at 0.04 + 0.011; the block's near face was at -0.0225.
        let moved = result.state.pose(0).x - CENTRE[0];
        assert!((moved - 0.0735).abs() < 0.004, "{}: moved {moved}", engine.name());
        assert!(result.state.pose(0).y.abs() < 1e-3 && result.state.pose(0).theta.abs() < 0.02);
        assert_eq!(result.touched.iter().collect::<Vec<_>>(), [0]);
        assert_eq!(result.state.poses()[1], state.poses()[1], "what nothing touches keeps its bits");
    }
}

#[test]
fn a_push_that_meets_nothing_changes_nothing() {
    let scene = scene_of(&[square()]);
    for engine in engines(&scene) {
        let state = at(&[(0.0, 0.0, 0.3)]);
        let result = run(&*engine, &state, &push(-0.1, 0.08, 0.1, 0.08));
        assert_eq!((result.status, &result.state), (PushStatus::Executed, &state));
        assert!(result.touched.is_empty());
    }
}

#[test]
fn a_tip_that_would_land_on_a_block_is_illegal_and_names_it() {
    let scene = scene_of(&[square(), square()]);
    for engine in engines(&scene) {
        let state = at(&[(0.0, 0.0, 0.0), (0.1, 0.0, 0.5)]);
        let result = run(&*engine, &state, &push(0.09, 0.0, 0.2, 0.0));
        assert_eq!(result.status, PushStatus::Illegal { body: Some(1) });
        assert_eq!(result.state, state);
        for nonsense in [push(0.2, 0.2, 0.2, 0.2), push(f64::NAN, 0.0, 0.1, 0.0)] {
            assert_eq!(run(&*engine, &state, &nonsense).status, PushStatus::Illegal { body: None });
        }
    }
}

#[test]
fn a_push_that_starts_in_contact_pushes_from_there() {
    let scene = scene_of(&[square()]);
    for engine in engines(&scene) {
        // The tip's front touches the face, then overlaps it by less than the landing tolerance.
        for gap in [0.0, 0.0003, -0.0003] {
            let state = at(&[(0.0, 0.0, 0.0)]);
            let x = -0.0225 - 0.011 - gap;
            let result = run(&*engine, &state, &push(x, 0.0, x + 0.05, 0.0));
            assert_eq!(result.status, PushStatus::Executed);
            let moved = result.state.pose(0).x - CENTRE[0];
            assert!((moved - 0.05).abs() < 0.004, "{} gap {gap}: moved {moved}", engine.name());
        }
    }
}

#[test]
fn touching_and_overlapping_blocks_are_not_thrown_apart() {
    let scene = scene_of(&[square(), square(), square()]);
    for engine in engines(&scene) {
        for gap in [0.0, 0.0005, -0.001, -0.004] {
            let pitch = 0.045 + gap;
            let state = at(&[(0.0, 0.0, 0.0), (pitch, 0.0, 0.0), (-0.15, 0.1, 0.0)]);
            // A push elsewhere: the pair may be pushed out of its overlap, and no farther.
            let result = run(&*engine, &state, &push(-0.21, 0.1, -0.16, 0.1));
            assert_eq!(result.status, PushStatus::Executed);
            for body in [0, 1] {
                let moved = (result.state.pose(body).position() - state.pose(body).position()).norm();
                let limit = (-gap).max(0.0) + 2e-4;
                assert!(moved <= limit, "{} gap {gap}: body {body} moved {moved}", engine.name());
            }
        }
    }
}

#[test]
fn a_body_that_leaves_the_workspace_is_reported_and_goes_on_sliding() {
    for rule in [LeaveRule::Centre, LeaveRule::Footprint] {
        let mut builder = scene_of(&[square(), square()]).to_builder();
        builder.workspace(Workspace { leave_rule: rule, ..Workspace::default() });
        let scene = Arc::new(builder.build().unwrap());
        for engine in engines(&scene) {
            let state = at(&[(0.19, 0.0, 0.0), (0.0, 0.3, 0.0)]);
            let result = run(&*engine, &state, &push(0.13, 0.0, 0.23, 0.0));
            assert!(result.state.pose(0).x > 0.724, "{}", engine.name());
            // Body 1 was outside before: that is not this push's doing.
            assert_eq!(result.left.iter().collect::<Vec<_>>(), [0], "{}", engine.name());
        }
    }
}

/// Engines that keep what they saw of a pair of bodies from step to step could push by what was there before.
#[test]
fn what_tip_and_pushed_body_pass_at_a_distance_stays_to_the_bit() {
    // A border and what `fast` looks ahead are 2 mm together for the published gripper.
    const CLEAR: [f64; 3] = [0.0025, 0.004, 0.0075];
    let mut wrong = Vec::new();
    for scale in [0.2, 1.0, 5.0] {
        for side in [0.005, 0.02, 0.045, 0.15, 0.4].map(|side| side * scale) {
            let mut builder = SceneBuilder::new();
            builder.gripper(Gripper::robotiq_2f85().scaled(scale));
            // The pushed body is narrower than the tip.
            for side in [0.02 * scale, side, side] {
                builder.add_body(BodyDef::new(Shape::rectangle(side, side))).unwrap();
            }
            builder.workspace(Workspace::rectangle(vec2(-9.0, -9.0), vec2(9.0, 9.0)));
            let scene = Arc::new(builder.build().unwrap());
            // In the others bodies rock, and sink in where they stand.
            for engine in engines(&scene).iter().filter(|engine| engine.name().starts_with("rapier")) {
                for (clear, heading) in CLEAR.into_iter().flat_map(|c| [(c, 0.0), (c, 0.6)]) {
                    let along = Pose2::new(CENTRE[0], CENTRE[1], heading);
                    let place = |x: f64, y: f64| along.compose(&Pose2::new(x * scale, y, 0.0));
                    // One at either side of the way: the left one abreast of where the push begins, the right one of its end.
                    let y = scene.gripper().push.width / 2.0 + clear * scale + side / 2.0;
                    let state = State::new([place(-0.03, 0.0), place(-0.06, y), place(0.05, -y)]);
                    let push = Push::new(place(-0.08, 0.0).position(), place(0.07, 0.0).position());
                    let result = run(&**engine, &state, &push);
                    let executed = result.status == PushStatus::Executed && result.state.pose(0) != state.pose(0);
                    let alone = result.touched.iter().eq([0]);
                    if !(executed && alone && result.state.poses()[1..] == state.poses()[1..]) {
                        let of = format!("{} scale {scale} side {side} clear {clear} heading {heading}", engine.name());
                        wrong.push(format!("{of}: {:?} {:?}", result.status, result.state.poses()));
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn absent_bodies_are_not_there() {
    let scene = scene_of(&[square(), square()]);
    for engine in engines(&scene) {
        let mut state = at(&[(0.0, 0.0, 0.0), (0.05, 0.0, 0.0)]);
        state.set_present(0, false);
        let result = run(&*engine, &state, &push(-0.02, 0.0, 0.01, 0.0));
        assert_eq!(result.status, PushStatus::Executed, "the tip may come down where an absent body was");
        assert_eq!(result.state.poses()[0], state.poses()[0]);
        assert!(!result.state.is_present(0));
    }
}

/// A packed scene with concave, round and compound bodies, and pushes into it.
fn mixed() -> (Arc<Scene>, State, Vec<Push>) {
    let l = Shape::Polygon(vec![[-0.03, -0.03], [0.03, -0.03], [0.03, 0.0], [0.0, 0.0], [0.0, 0.03], [-0.03, 0.03]]);
    let scene = scene_of(&[l, square(), Shape::Disc { radius: 0.02 }, Shape::rectangle(0.09, 0.045), square()]);
    let state = at(&[(0.0, 0.0, 0.1), (0.025, 0.035, 0.0), (-0.06, 0.0, 0.0), (0.0, -0.06, 0.05), (0.09, -0.01, 0.6)]);
    scene.check_state(&state).unwrap();
    let pushes = (0..24)
        .map(|k| {
            let a = k as f64 * std::f64::consts::TAU / 24.0;
            push(0.16 * a.cos(), 0.16 * a.sin(), 0.05 * a.cos(), 0.05 * a.sin())
        })
        .collect();
    (scene, state, pushes)
}

#[test]
fn the_same_push_gives_the_same_bits_whatever_ran_before_and_wherever() {
    let (scene, state, pushes) = mixed();
    for engine in engines(&scene) {
        let alone: Vec<PushResult> = pushes.iter().map(|p| run(&*engine, &state, p)).collect();
        assert!(alone.iter().filter(|r| r.state != state).count() > 12, "most pushes move something");
        // Batched and reversed on a used scratch.
        let mut scratch = engine.scratch();
        let jobs: Vec<PushJob> = pushes.iter().rev().map(|&push| PushJob { state: &state, push }).collect();
        for _ in 0..2 {
            let mut batched = vec![PushResult::default(); jobs.len()];
            engine.step_batch(&mut scratch, &jobs, &mut batched, &Stop::never());
            batched.reverse();
            assert_eq!(alone, batched, "{}", engine.name());
        }
        // On other threads at the same time.
        let threaded: Vec<Vec<PushResult>> = std::thread::scope(|s| {
            let threads: Vec<_> =
                (0..2).map(|_| s.spawn(|| pushes.iter().map(|p| run(&*engine, &state, p)).collect())).collect();
            threads.into_iter().map(|t| t.join().unwrap()).collect()
        });
        assert!(threaded.iter().all(|t| *t == alone), "{}", engine.name());
    }
}

#[test]
fn results_are_finite_and_bodies_do_not_end_deep_in_each_other() {
    let (scene, state, pushes) = mixed();
    for engine in engines(&scene) {
        for p in &pushes {
            let after = run(&*engine, &state, p).state;
            let loose = scene.to_builder();
            let mut loose = loose.clone();
            loose.overlap_tolerance(0.003);
            loose.build().unwrap().check_state(&after).unwrap_or_else(|e| panic!("{} {p:?}: {e}", engine.name()));
        }
    }
}

#[test]
fn the_outcome_turns_with_the_world() {
    let (scene, state, pushes) = mixed();
    // A rigid motion of everything about the scene's centre, up to rounding and chaos. The engines that let bodies rock
    // are as chaotic as what they imitate: rounding alone moves some bodies by millimetres.
    let turn = Pose2::new(CENTRE[0], CENTRE[1], 0.7).compose(&Pose2::new(-CENTRE[0], -CENTRE[1], 0.0));
    let mut workspace = scene.to_builder();
    workspace.workspace(Workspace::rectangle(vec2(-1.0, -1.0), vec2(2.0, 1.0)));
    let scene = Arc::new(workspace.build().unwrap());
    for engine in engines(&scene) {
        let (mut same_pushes, mut same_bodies, mut moved) = (0, 0, 0);
        for p in &pushes {
            let plain = run(&*engine, &state, p).state;
            let turned = State::new((0..state.len()).map(|i| turn.compose(&state.pose(i))));
            let q = Push::new(turn.transform_point(p.start()), turn.transform_point(p.end()));
            let other = run(&*engine, &turned, &q).state;
            let apart = |i: usize| (turn.compose(&plain.pose(i)).position() - other.pose(i).position()).norm();
            same_pushes += usize::from((0..state.len()).all(|i| apart(i) < 2e-3));
            for i in (0..state.len()).filter(|&i| plain.poses()[i] != state.poses()[i]) {
                moved += 1;
                same_bodies += usize::from(apart(i) < 3e-3);
            }
        }
        let name = engine.name();
        if name.starts_with("rapier") || name.starts_with("planar") {
            assert!(same_pushes * 4 >= pushes.len() * 3, "{name}: {same_pushes} of {} agree", pushes.len());
        } else {
            // In Bullet a push repeated after rounding ends 1.6 mm away on average, and its friction with the ground
            // knows the world's axes.
            assert!(moved > 24 && same_bodies * 2 >= moved, "{name}: {same_bodies} of {moved} moved bodies agree");
        }
    }
}

#[test]
fn a_requested_stop_interrupts() {
    let (scene, state, pushes) = mixed();
    let token = CancelToken::new();
    token.trigger();
    let stop = Budget::default().start(&[token]);
    for engine in engines(&scene) {
        let result = engine.step(&mut engine.scratch(), &state, &pushes[0], &stop);
        assert_eq!(result.status, PushStatus::Interrupted);
    }
}

#[test]
fn unknown_engines_presets_and_bad_constants_are_refused_by_name() {
    let scene = scene_of(&[square()]);
    let fails = |o: PhysicsOptions| engine(&o, Arc::clone(&scene)).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(fails(PhysicsOptions { engine: "newton".into(), ..Default::default() }).starts_with("physics.engine: "));
    assert!(fails(PhysicsOptions::preset("slow")).starts_with("physics.preset: "));
    let mut custom = jostle::physics::RapierSettings::fast();
    custom.speed = -1.0;
    assert!(fails(PhysicsOptions::custom(EngineSettings::Rapier(custom))).starts_with("physics.speed: is -1"));
    let mixed = PhysicsOptions { engine: "prism".into(), ..PhysicsOptions::custom(EngineSettings::Rapier(custom)) };
    assert!(fails(mixed).starts_with("physics.settings: are constants of rapier"));
}
