use std::sync::Arc;

use super::*;
use crate::geom::{Shape, vec2};
use crate::scene::{BodyDef, Goal, SceneBuilder, Workspace};

/// Three squares of 10 cm in a row: one to pick, one to drag, one that stays.
fn problem() -> Rearrangement {
    let mut builder = SceneBuilder::new();
    builder.workspace(Workspace::rectangle(vec2(0.0, 0.0), vec2(0.78, 0.52)));
    for (pickable, pushable) in [(true, false), (false, true), (false, false)] {
        let square = BodyDef::new(Shape::rectangle(0.1, 0.1));
        builder.add_body(BodyDef { pickable, pushable, ..square }).unwrap();
    }
    let start = State::new([at(0.1, 0.1), at(0.3, 0.1), at(0.5, 0.1)]);
    let goals = vec![Some(Goal::at(at(0.1, 0.4))), Some(Goal::at(at(0.7, 0.1))), None];
    Rearrangement::new("three", Arc::new(builder.build().unwrap()), start, goals).unwrap()
}

fn at(x: f64, y: f64) -> Pose2 {
    Pose2::new(x, y, 0.0)
}

fn pose(state: &State, body: usize) -> Pose2 {
    state.pose(body)
}

fn pick(from: Pose2, place: Pose2) -> Move {
    Move::PickPlace { body: 0, pick: from, place }
}

fn drag(waypoints: &[Pose2]) -> Move {
    Move::Drag { body: 1, waypoints: waypoints.into() }
}

fn fault(moves: &[Move]) -> Fault {
    certify_moves(&problem(), moves).unwrap_err().fault
}

#[test]
fn a_right_plan_passes_and_a_plan_that_stops_short_does_not() {
    let problem = problem();
    let start = &problem.start;
    let around = [pose(start, 1), at(0.3, 0.3), at(0.7, 0.3), at(0.7, 0.1)];
    let plan = [pick(pose(start, 0), at(0.1, 0.4)), drag(&around)];
    let last = certify(&problem, &plan).unwrap();
    assert!(problem.solved(&last));
    let short = certify(&problem, &plan[..1]).unwrap_err();
    assert_eq!(short, Violation { step: 1, fault: Fault::NotAtGoal { body: 1 } });
    assert_eq!(short.to_string(), "after 1 moves: body 1 is not at its goal");
}

#[test]
fn a_drag_through_a_body_is_refused_however_fast_it_is() {
    let start = problem().start;
    let through = [pose(&start, 1), at(0.7, 0.1)];
    assert!(matches!(fault(&[drag(&through)]), Fault::Contact { body: 1, other: 2, .. }));
    // Over the corner of the one that stays by 20 micrometres, between two free waypoints.
    let touching = [pose(&start, 1), at(0.3, 0.3), at(0.45, 0.2 - 2e-5), at(0.55, 0.2 - 2e-5)];
    assert!(matches!(fault(&[drag(&touching)]), Fault::Contact { depth, .. } if depth < 3e-5));
    let beside = [pose(&start, 1), at(0.3, 0.3), at(0.45, 0.2), at(0.55, 0.2)];
    certify_moves(&problem(), &[drag(&beside)]).unwrap();
}

#[test]
fn a_turn_that_sweeps_a_body_is_refused() {
    let start = problem().start;
    // The diagonal is 141 mm: turned on the spot beside the third square, a corner reaches over the gap.
    let spot = at(0.395, 0.1);
    let turned = Pose2 { theta: 0.78, ..spot };
    assert!(matches!(fault(&[drag(&[pose(&start, 1), spot, turned])]), Fault::Contact { other: 2, .. }));
    let apart = at(0.375, 0.1);
    let turned = Pose2 { theta: 0.78, ..apart };
    certify_moves(&problem(), &[drag(&[pose(&start, 1), apart, turned])]).unwrap();
}

#[test]
fn wrong_moves_are_refused_with_the_step_and_the_reason() {
    let start = problem().start;
    let (p0, p1) = (pose(&start, 0), pose(&start, 1));
    let first = pick(p0, at(0.1, 0.4));
    let wrong = certify_moves(&problem(), &[first.clone(), first]).unwrap_err();
    assert_eq!(wrong.step, 1);
    assert!(wrong.to_string().starts_with("move 1: begins 300.000 mm from where body 0 is"), "{wrong}");
    assert!(matches!(fault(&[pick(p0, at(0.04, 0.4))]), Fault::Outside { by, .. } if (by - 0.01).abs() < 1e-6));
    assert!(matches!(fault(&[pick(p0, at(0.21, 0.1))]), Fault::Contact { other: 1, .. }));
    assert!(matches!(fault(&[pick(p0, at(f64::NAN, 0.1))]), Fault::Malformed { body: 0 }));
    assert!(matches!(fault(&[drag(&[p1])]), Fault::Malformed { body: 1 }));
    let out = [p1, at(0.3, -0.1), at(0.3, 0.1)];
    assert!(matches!(fault(&[drag(&out)]), Fault::Outside { body: 1, .. }));
    let lifted = Move::PickPlace { body: 1, pick: p1, place: at(0.3, 0.4) };
    assert_eq!(fault(&[lifted]), Fault::Forbidden { body: 1 });
    let dragged = Move::Drag { body: 0, waypoints: [p0, at(0.1, 0.4)].into() };
    assert_eq!(fault(&[dragged]), Fault::Forbidden { body: 0 });
    assert_eq!(fault(&[Move::Drag { body: 3, waypoints: [p0, p0].into() }]), Fault::NoBody { body: 3 });
}
