//! What holds for the Bullet engine beyond the contract of every engine (`tests/transition.rs`).
#![cfg(feature = "bullet")]

use std::sync::Arc;

use jostle::action::Push;
use jostle::geom::{Pose2, Shape, vec2};
use jostle::physics::bullet::{Bullet, BulletSettings, Solver};
use jostle::physics::{PhysicsOptions, PushJob, PushStatus, Stance, Transition, engine};
use jostle::run::Stop;
use jostle::scene::{BodyDef, Friction, Scene, SceneBuilder, State};

const CENTRE: [f64; 2] = [0.5, 0.0];

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

/// A packed scene, and pushes into it from six sides.
fn packed() -> (Arc<Scene>, State, Vec<Push>) {
    let l = Shape::Polygon(vec![[-0.03, -0.03], [0.03, -0.03], [0.03, 0.0], [0.0, 0.0], [0.0, 0.03], [-0.03, 0.03]]);
    let scene = scene_of(&[l, square(), Shape::Disc { radius: 0.02 }, Shape::rectangle(0.09, 0.045), square()]);
    let state = at(&[(0.0, 0.0, 0.1), (0.025, 0.035, 0.0), (-0.06, 0.0, 0.0), (0.0, -0.06, 0.05), (0.09, -0.01, 0.6)]);
    let pushes = (0..6)
        .map(|k| {
            let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 6.0 + 0.2).sin_cos();
            let point = |r: f64| vec2(CENTRE[0] + r * cos, CENTRE[1] + r * sin);
            Push::new(point(0.16), point(0.05))
        })
        .collect();
    (scene, state, pushes)
}

fn after(scene: &Arc<Scene>, settings: BulletSettings, state: &State, push: &Push) -> State {
    let engine = Bullet::new(Arc::clone(scene), settings).unwrap();
    let result = engine.step(&mut engine.scratch(), state, push, &Stop::never());
    assert_eq!(result.status, PushStatus::Executed);
    result.state
}

fn greatest_distance(a: &State, b: &State) -> f64 {
    (0..a.len()).map(|i| (a.pose(i).position() - b.pose(i).position()).norm()).fold(0.0, f64::max)
}

#[test]
fn the_compact_solver_gives_the_bits_of_bullets_own() {
    let (scene, state, pushes) = packed();
    for base in [BulletSettings::reference(), BulletSettings::fast()] {
        for push in &pushes {
            let with = |solver| after(&scene, BulletSettings { solver, ..base }, &state, push);
            let own = with(Solver::Bullet);
            assert_eq!(own, with(Solver::Compact), "{push:?}");
            assert_ne!(own, state, "the push moves something");
        }
    }
}

#[test]
fn the_square_root_gives_the_same_up_to_rounding_while_nothing_is_chaotic() {
    let scene = scene_of(&[square()]);
    let state = at(&[(0.0, 0.0, 0.3)]);
    let push = Push::new(vec2(0.43, 0.01), vec2(0.52, 0.0));
    let with = |solver| after(&scene, BulletSettings { solver, ..BulletSettings::reference() }, &state, &push);
    let apart = greatest_distance(&with(Solver::Bullet), &with(Solver::CompactRoot));
    assert!(apart < 1e-4, "{apart}");
}

#[test]
fn a_tall_body_topples_and_is_reported() {
    let mut builder = SceneBuilder::new();
    builder.add_body(BodyDef { height: 0.15, ..BodyDef::new(Shape::rectangle(0.02, 0.05)) }).unwrap();
    builder.add_body(BodyDef::new(square())).unwrap();
    // On a ground that holds it, pushed above its middle.
    builder.friction(Friction { ground: 3.0, tip: 0.9 });
    let scene = Arc::new(builder.build().unwrap());
    let state = at(&[(0.0, 0.0, 0.0), (0.0, 0.15, 0.0)]);
    let push = Push::new(vec2(0.45, 0.0), vec2(0.52, 0.0));
    let settings = BulletSettings { tip_bottom: 0.1, tip_top: 0.16, ..BulletSettings::reference() };
    let engine = Bullet::new(Arc::clone(&scene), settings).unwrap();
    let (result, details) = engine.push_in_detail(&PushJob { state: &state, push }, &Stop::never());
    assert_eq!(result.toppled.iter().collect::<Vec<_>>(), [0], "{details:?}");
    assert!(details[0].tilt > 1.0 && details[0].rise < -0.03, "{details:?}");
    assert!(details[1].tilt < 0.01 && details[1].rise.abs() < 1e-3, "{details:?}");
    assert_eq!(result.state.poses()[1], state.poses()[1]);
    // Pushed low it slides.
    let engine = Bullet::new(scene, BulletSettings { tip_bottom: 0.001, tip_top: 0.012, ..settings }).unwrap();
    let low = engine.step(&mut engine.scratch(), &state, &push, &Stop::never());
    assert!(low.toppled.is_empty() || low.state != result.state);
}

#[test]
fn a_stance_is_where_the_push_begins() {
    let scene = scene_of(&[square(), square()]);
    let state = at(&[(0.0, 0.0, 0.0), (0.049, 0.002, 0.1)]);
    let push = Push::new(vec2(0.44, 0.003), vec2(0.53, 0.003));
    let engine = Bullet::new(Arc::clone(&scene), BulletSettings::reference()).unwrap();
    let job = PushJob { state: &state, push };
    let with = |stances: &[Stance]| engine.step_standing(&mut engine.scratch(), &job, stances, &Stop::never()).state;
    let flat = with(&[]);
    assert_eq!(flat, with(&[Stance::default(); 2]));
    let leaning = with(&[Stance { lean: [0.004, 0.0], rise: 5e-5 }, Stance::default()]);
    assert_ne!(flat, leaning);
    assert!(greatest_distance(&flat, &leaning) < 0.01);
}

#[test]
fn constants_of_another_engine_are_refused() {
    let scene = scene_of(&[square()]);
    let options = PhysicsOptions { bullet: Some(BulletSettings::fast()), ..PhysicsOptions::default() };
    let error = engine(&options, Arc::clone(&scene)).err().unwrap().to_string();
    assert_eq!(error, "physics.bullet: are constants of bullet, but the engine is `rapier`");
    let options = PhysicsOptions { engine: "bullet".into(), ..options };
    assert_eq!(engine(&options, scene).unwrap().name(), "bullet custom");
}

/// Final poses of a few pushes into a packed scene, as they came out on the machine that recorded them. There they come
/// again to the bit. Elsewhere the last bit of a sine may differ, and chaos makes millimetres of it in some poses: a
/// change of the settings or of the scene's construction moves most poses by more.
#[test]
fn poses_are_as_recorded() {
    let (scene, state, pushes) = packed();
    let mut text = String::new();
    for (name, settings) in [("reference", BulletSettings::reference()), ("fast", BulletSettings::fast())] {
        for (k, push) in pushes.iter().enumerate() {
            let result = after(&scene, settings, &state, push);
            for (i, pose) in result.poses().iter().enumerate() {
                text += &format!("{name} {k} {i} {:.6} {:.6} {:.5}\n", pose.x, pose.y, pose.theta);
            }
        }
    }
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/bullet_pushes.txt");
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    let golden = std::fs::read_to_string(&path).unwrap();
    let position = |line: &str| -> [f64; 2] {
        let mut words = line.split(' ').skip(3).map(|w| w.parse().unwrap());
        [words.next().unwrap(), words.next().unwrap()]
    };
    let apart: Vec<f64> = text
        .lines()
        .zip(golden.lines())
        .map(|(a, b)| {
            let ([ax, ay], [bx, by]) = (position(a), position(b));
            (ax - bx).hypot(ay - by)
        })
        .collect();
    assert_eq!(apart.len(), golden.lines().count());
    let close = apart.iter().filter(|d| **d < 5e-4).count();
    assert!(
        close * 10 >= apart.len() * 8 && apart.iter().all(|d| *d < 0.015),
        "{close} of {} poses are as recorded; UPDATE_GOLDEN=1 writes them anew, with a reason in the commit\n{text}",
        apart.len()
    );
}
