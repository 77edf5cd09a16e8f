//! What a grasp tried out in Bullet says of plain cases.
#![cfg(feature = "bullet")]

use std::sync::Arc;

use jostle::action::Grasp;
use jostle::geom::{Pose2, Shape};
use jostle::physics::bullet::{Bullet, BulletSettings, GraspMotion, GraspTrial};
use jostle::run::{Budget, CancelToken, Stop};
use jostle::scene::{BodyDef, SceneBuilder, State};

const X: f64 = 0.5;

fn engine(shapes: &[Shape]) -> Bullet {
    let mut builder = SceneBuilder::new();
    for shape in shapes {
        builder.add_body(BodyDef::new(shape.clone())).unwrap();
    }
    Bullet::new(Arc::new(builder.build().unwrap()), BulletSettings::reference()).unwrap()
}

fn at(poses: &[(f64, f64, f64)]) -> State {
    State::new(poses.iter().map(|&(x, y, t)| Pose2::new(X + x, y, t)))
}

/// A grasp of body 0 along a direction, off its middle by (dx, dy).
fn grasp(dx: f64, dy: f64, angle: f64) -> Grasp {
    Grasp { body: 0, position: [X + dx, dy], angle, opening: 0.0807, ..Grasp::default() }
}

fn run(engine: &Bullet, state: &State, grasp: &Grasp) -> GraspTrial {
    engine.grasp(state, grasp, &GraspMotion::default(), &Stop::never()).unwrap()
}

fn square() -> Shape {
    Shape::rectangle(0.045, 0.045)
}

#[test]
fn a_cube_and_a_cylinder_are_held_and_the_gap_is_their_width() {
    for (shape, width) in [(square(), 0.045), (Shape::Disc { radius: 0.022 }, 0.044)] {
        let engine = engine(&[shape]);
        for (dy, theta) in [(0.0, 0.0), (0.004, 0.1), (-0.006, -0.15)] {
            let trial = run(&engine, &at(&[(0.0, 0.0, theta)]), &grasp(0.003, dy, 0.0));
            assert!(trial.success && trial.held == Some(0), "{theta}: {trial:?}");
            // A margin of 1 mm on either side.
            assert!((trial.gap - width - 0.002).abs() < 0.003, "{theta}: {trial:?}");
            assert!(trial.blocked_by.is_none() && trial.touched_on_descent.is_empty() && trial.toppled.is_empty());
        }
    }
}

#[test]
fn what_is_too_wide_stops_the_descent() {
    let engine = engine(&[Shape::rectangle(0.09, 0.045)]);
    let trial = run(&engine, &at(&[(0.0, 0.0, 0.0)]), &grasp(0.0, 0.0, 0.0));
    assert!(!trial.success && trial.held.is_none() && trial.blocked_by == Some(0), "{trial:?}");
}

#[test]
fn a_neighbour_in_a_fingers_way_stops_the_descent() {
    let engine = engine(&[square(), square()]);
    let trial = run(&engine, &at(&[(0.0, 0.0, 0.0), (0.0545, 0.0, 0.0)]), &grasp(0.0, 0.0, 0.0));
    assert!(!trial.success && trial.blocked_by == Some(1) && trial.touched_on_descent.contains(1), "{trial:?}");
    // Across the free direction the same block is taken, and nothing else.
    let trial =
        run(&engine, &at(&[(0.0, 0.0, 0.0), (0.0545, 0.0, 0.0)]), &grasp(0.0, 0.0, std::f64::consts::FRAC_PI_2));
    assert!(trial.success, "{trial:?}");
}

#[test]
fn two_bodies_between_the_fingers_are_not_a_success() {
    let half = Shape::rectangle(0.0225, 0.045);
    let engine = engine(&[half.clone(), half]);
    let trial = run(&engine, &at(&[(0.0, 0.0, 0.0), (0.026, 0.0, 0.0)]), &grasp(0.013, 0.0, 0.0));
    assert!(!trial.success, "{trial:?}");
    assert!(trial.gap > 0.04, "both are between the pads: {trial:?}");
}

#[test]
fn empty_fingers_hold_nothing_and_leave_the_body_where_it_is() {
    let engine = engine(&[square()]);
    let state = at(&[(0.0, 0.0, 0.0)]);
    let trial = run(&engine, &state, &grasp(0.0, 0.12, 0.0));
    assert!(!trial.success && trial.held.is_none() && trial.lifted.is_empty() && trial.gap < 0.002, "{trial:?}");
    assert_eq!(trial.after, state);
}

/// 24 grasps off by up to 4 mm and 8 degrees: how many hold.
fn jittered(engine: &Bullet, angle: f64, middle: (f64, f64)) -> usize {
    (0..24)
        .filter(|k| {
            let k = f64::from(*k);
            let (dx, dy) = (0.004 * (k * 2.4).sin(), 0.004 * (k * 2.4).cos());
            let trial = run(
                engine,
                &at(&[(0.0, 0.0, 0.0)]),
                &grasp(middle.0 + dx, middle.1 + dy, angle + 0.14 * (k * 1.7).sin()),
            );
            trial.success
        })
        .count()
}

/// The full robot simulation of the originals held a cube, a cylinder and a rectangle across in 24 of 24 trials, and a
/// right-angled triangle by two of its faces in none.
#[test]
fn flat_faces_hold_and_wedges_slip() {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
    assert_eq!(jittered(&engine(&[square()]), 0.0, (0.0, 0.0)), 24);
    assert_eq!(jittered(&engine(&[Shape::rectangle(0.09, 0.045)]), FRAC_PI_2, (0.0, 0.0)), 24);
    // Hypotenuse along x at y = 0, apex at (0, 0.045): gripped by the hypotenuse and a leg, across which lie 45 degrees.
    let triangle = Shape::ConvexPolygon(vec![[-0.045, 0.0], [0.045, 0.0], [0.0, 0.045]]);
    let wedge = jittered(&engine(&[triangle]), FRAC_PI_4 + 0.39, (-0.015, 0.01));
    assert!(wedge < 20, "{wedge} of 24");
}

#[test]
fn the_same_grasp_gives_the_same_bits_and_a_stop_interrupts() {
    let engine = engine(&[square(), square()]);
    let state = at(&[(0.0, 0.0, 0.2), (0.0, 0.06, 0.0)]);
    let first = run(&engine, &state, &grasp(0.001, 0.0, 0.1));
    run(&engine, &state, &grasp(0.0, 0.0, 1.0));
    assert_eq!(first, run(&engine, &state, &grasp(0.001, 0.0, 0.1)));

    let token = CancelToken::new();
    token.trigger();
    let stop = Budget::default().start(&[token]);
    let trial = engine.grasp(&state, &grasp(0.0, 0.0, 0.0), &GraspMotion::default(), &stop).unwrap();
    assert!(trial.interrupted && !trial.success);
}

#[test]
fn bad_arguments_are_refused_by_name() {
    let engine = engine(&[square()]);
    let state = at(&[(0.0, 0.0, 0.0)]);
    let fails = |grasp: Grasp, motion: GraspMotion| {
        engine.grasp(&state, &grasp, &motion, &Stop::never()).unwrap_err().to_string()
    };
    let good = grasp(0.0, 0.0, 0.0);
    assert!(fails(Grasp { body: 3, ..good }, GraspMotion::default()).starts_with("grasp.body: there is no body 3"));
    assert!(fails(Grasp { angle: f64::NAN, ..good }, GraspMotion::default()).starts_with("grasp: needs a finite"));
    let motion = GraspMotion { grip_force: -1.0, ..GraspMotion::default() };
    assert!(fails(good, motion).starts_with("grasp_motion.grip_force: is -1"));
}
