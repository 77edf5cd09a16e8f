//! Actions as C has them.

use super::abi::{jostle_body, jostle_vec2, read};
use super::scene::Bodies;
use super::status::{Failure, Outcome};
use crate::action::{Action, Grasp, Move, Push};

/// What an action is: one of the JOSTLE_ACTION_ values.
pub type jostle_action_kind = i32;
/// A straight push; `push` says which, `grasp` is zero.
pub const JOSTLE_ACTION_PUSH: jostle_action_kind = 1;
/// A vertical two-finger grasp; `grasp` says which, `push` is zero.
pub const JOSTLE_ACTION_GRASP: jostle_action_kind = 2;
/// A pick-and-place of `body` in a rearrangement: `push` goes from where it is picked to where it is placed, `grasp` is
/// zero. jostle_plan_waypoints gives both poses.
pub const JOSTLE_ACTION_PICK_PLACE: jostle_action_kind = 3;
/// A drag of `body` along the table in a rearrangement: `push` goes from where it begins to where it ends, `grasp` is
/// zero. jostle_plan_waypoints gives the way.
pub const JOSTLE_ACTION_DRAG: jostle_action_kind = 4;

/// A straight push in the world frame: the closed fingers come down at `start`, move to `end` and lift. The points are
/// the centre of the fingers' footprint; their width stays across the push. Frozen: never changes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct jostle_push {
    pub start: jostle_vec2,
    pub end: jostle_vec2,
}

/// A vertical two-finger grasp in the world frame. Frozen: never changes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct jostle_grasp {
    /// Midpoint between the pads.
    pub position: jostle_vec2,
    /// Direction along which the fingers close, from +x, in [0, pi).
    pub angle: f64,
    /// Distance between the pads before closing, metres.
    pub opening: f64,
    /// Width of the body between the pads, metres.
    pub width: f64,
    /// Least spare room of all conditions of the grasp, metres; it holds while this is not negative.
    pub margin: f64,
    /// Expected quality in [0, 1].
    pub score: f64,
}

/// One action. Frozen: never changes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct jostle_action {
    /// One of the JOSTLE_ACTION_ values.
    pub kind: jostle_action_kind,
    /// 0.
    pub reserved: u32,
    /// The body that a grasp takes, a move moves or a push was aimed at; zero for a push aimed at none.
    pub body: jostle_body,
    pub push: jostle_push,
    pub grasp: jostle_grasp,
}

pub(super) fn c_grasp(grasp: &Grasp) -> jostle_grasp {
    jostle_grasp {
        position: grasp.position.into(),
        angle: grasp.angle,
        opening: grasp.opening,
        width: grasp.width,
        margin: grasp.margin,
        score: grasp.score,
    }
}

pub(super) fn c_action(action: &Action, bodies: &Bodies) -> jostle_action {
    match action {
        Action::Push(push) => jostle_action {
            kind: JOSTLE_ACTION_PUSH,
            body: push.body.map(|index| bodies.id(index)).unwrap_or_default(),
            push: jostle_push { start: push.start.into(), end: push.end.into() },
            ..jostle_action::default()
        },
        Action::Grasp(grasp) => jostle_action {
            kind: JOSTLE_ACTION_GRASP,
            body: bodies.id(grasp.body),
            grasp: c_grasp(grasp),
            ..jostle_action::default()
        },
    }
}

pub(super) fn c_move(action: &Move, bodies: &Bodies) -> jostle_action {
    let kind = match action {
        Move::PickPlace { .. } => JOSTLE_ACTION_PICK_PLACE,
        Move::Drag { .. } => JOSTLE_ACTION_DRAG,
    };
    let (from, to) = (action.from(), action.to());
    jostle_action {
        kind,
        body: bodies.id(action.body()),
        push: jostle_push { start: [from.x, from.y].into(), end: [to.x, to.y].into() },
        ..jostle_action::default()
    }
}

/// Reads and checks a caller's action.
///
/// # Safety
/// `action` is null or readable.
pub(super) unsafe fn read_action(action: *const jostle_action, bodies: &Bodies) -> Outcome<Action> {
    // SAFETY: as promised by the caller.
    let given = unsafe { read(action, "action") }?;
    let action = match given.kind {
        JOSTLE_ACTION_PUSH => {
            let push = given.push;
            let body = if given.body.id == 0 { None } else { Some(bodies.index(given.body, "action.body")?) };
            Action::Push(Push { start: [push.start.x, push.start.y], end: [push.end.x, push.end.y], body })
        }
        JOSTLE_ACTION_GRASP => {
            let grasp = given.grasp;
            Action::Grasp(Grasp {
                body: bodies.index(given.body, "action.body")?,
                position: [grasp.position.x, grasp.position.y],
                angle: grasp.angle,
                opening: grasp.opening,
                width: grasp.width,
                margin: grasp.margin,
                score: grasp.score,
            })
        }
        JOSTLE_ACTION_PICK_PLACE | JOSTLE_ACTION_DRAG => {
            return Err(Failure::argument("action.kind", "is a move of a rearrangement, which has no place here"));
        }
        kind => {
            return Err(Failure::argument("action.kind", format!("is {kind}; it must be a JOSTLE_ACTION_ value")));
        }
    };
    action.validate().map_err(|error| error.within("action"))?;
    Ok(action)
}
