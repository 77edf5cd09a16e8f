//! An independent check of plans of rearrangements: it shares geometry with the planners and nothing else.
//!
//! Every step is looked at in its own right: the moved body is where the move begins, it may be moved so, it ends inside
//! the workspace and clear of the others, and a drag does so all along. Drags are followed by conservative advancement:
//! from a pose with a gap `d` to all else, no contact can come before some point of the body has gone `d`, so the check
//! goes on to there. Contact within [`CONTACT_SLACK`] is none; of a deeper one at most 10 micrometres escape.

use std::fmt;

use crate::action::Move;
use crate::geom::{Pose2, normalize_angle, pieces_gap_below};
use crate::scene::{CONTACT_SLACK, Rearrangement, State};

/// What is wrong with a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    /// Number of the move from 0; the number of moves if what they lead to is wrong.
    pub step: usize,
    pub fault: Fault,
}

/// Why a move is refused. Bodies by index; lengths in metres.
#[derive(Debug, Clone, PartialEq)]
pub enum Fault {
    /// There is no such body.
    NoBody { body: usize },
    /// A pose is not finite, or a drag has less than two waypoints.
    Malformed { body: usize },
    /// The body must not be moved this way.
    Forbidden { body: usize },
    /// The move begins where the body is not.
    Elsewhere { body: usize, distance: f64 },
    /// The body reaches out of the workspace at this pose.
    Outside { body: usize, pose: Pose2, by: f64 },
    /// The body overlaps another at this pose.
    Contact { body: usize, other: usize, pose: Pose2, depth: f64 },
    /// The body is not at its goal in the end.
    NotAtGoal { body: usize },
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Violation { step, fault } = self;
        let at = |p: &Pose2| format!("({:.4} m, {:.4} m, {:.3} rad)", p.x, p.y, p.theta);
        match fault {
            Fault::NoBody { body } => write!(f, "move {step}: there is no body {body}"),
            Fault::Malformed { body } => {
                write!(f, "move {step}: body {body} has a pose that is not finite, or fewer than two waypoints")
            }
            Fault::Forbidden { body } => write!(f, "move {step}: body {body} must not be moved this way"),
            Fault::Elsewhere { body, distance } => {
                write!(f, "move {step}: begins {:.3} mm from where body {body} is", distance * 1e3)
            }
            Fault::Outside { body, pose, by } => {
                write!(f, "move {step}: body {body} at {} is {:.3} mm outside", at(pose), by * 1e3)
            }
            Fault::Contact { body, other, pose, depth } => {
                write!(f, "move {step}: body {body} at {} is {:.3} mm in body {other}", at(pose), depth * 1e3)
            }
            Fault::NotAtGoal { body } => write!(f, "after {step} moves: body {body} is not at its goal"),
        }
    }
}

impl std::error::Error for Violation {}

/// How far a move may begin from where the body is: metres, and radians.
const SAME: f64 = 1e-6;
/// Least advance of a point of the body between two looks at a drag, metres.
const LEAST_ADVANCE: f64 = 1e-5;
/// Gaps are worked out up to this, metres.
const FAR: f64 = 0.1;

/// Checks that the moves are possible one after the other and bring every body to its goal; gives the last state.
pub fn certify<'a>(
    problem: &Rearrangement,
    moves: impl IntoIterator<Item = &'a Move>,
) -> std::result::Result<State, Violation> {
    let mut count = 0;
    let moves = moves.into_iter().inspect(|_| count += 1);
    let state = certify_moves(problem, moves)?;
    match (0..state.len()).find(|&body| !problem.at_goal(body, &state.pose(body))) {
        Some(body) => Err(Violation { step: count, fault: Fault::NotAtGoal { body } }),
        None => Ok(state),
    }
}

/// Checks that the moves are possible one after the other; gives the last state.
pub fn certify_moves<'a>(
    problem: &Rearrangement,
    moves: impl IntoIterator<Item = &'a Move>,
) -> std::result::Result<State, Violation> {
    let mut state = problem.start.clone();
    for (step, action) in moves.into_iter().enumerate() {
        check(problem, &state, action).map_err(|fault| Violation { step, fault })?;
        state.set_pose(action.body(), action.to());
    }
    Ok(state)
}

fn check(problem: &Rearrangement, state: &State, action: &Move) -> std::result::Result<(), Fault> {
    let body = action.body();
    let Some(moved) = problem.scene.bodies().get(body) else { return Err(Fault::NoBody { body }) };
    let poses = action.poses();
    if poses.len() < 2 || !poses.iter().all(Pose2::is_finite) {
        return Err(Fault::Malformed { body });
    }
    let lifted = matches!(action, Move::PickPlace { .. });
    if !(if lifted { moved.pickable } else { moved.pushable }) {
        return Err(Fault::Forbidden { body });
    }
    let (now, from) = (state.pose(body), action.from());
    let distance = (now.position() - from.position()).norm();
    if distance > SAME || normalize_angle(now.theta - from.theta).abs() > SAME {
        return Err(Fault::Elsewhere { body, distance });
    }
    if lifted {
        return room(problem, state, body, &action.to()).map(drop);
    }
    poses.windows(2).try_for_each(|pair| drag(problem, state, body, &pair[0], &pair[1]))
}

/// The least distance of the body at a pose to the edge and to all others, if nothing is wrong there.
fn room(problem: &Rearrangement, state: &State, body: usize, pose: &Pose2) -> std::result::Result<f64, Fault> {
    let footprint = &problem.scene.body(body).footprint;
    let mut room = problem.scene.workspace().margin(footprint, pose);
    if room < -CONTACT_SLACK {
        return Err(Fault::Outside { body, pose: *pose, by: -room });
    }
    for (other, there) in state.iter().filter(|(other, _)| *other != body) {
        let gap = pieces_gap_below(footprint, pose, &problem.scene.body(other).footprint, &there, FAR);
        if gap < -CONTACT_SLACK {
            return Err(Fault::Contact { body, other, pose: *pose, depth: -gap });
        }
        room = room.min(gap);
    }
    Ok(room)
}

/// One straight piece of a drag.
fn drag(problem: &Rearrangement, state: &State, body: usize, a: &Pose2, b: &Pose2) -> std::result::Result<(), Fault> {
    let turn = normalize_angle(b.theta - a.theta);
    // No point of the body goes farther than this.
    let way = (b.position() - a.position()).norm() + turn.abs() * problem.scene.body(body).footprint.radius;
    let mut gone = 0.0;
    loop {
        let t = if way > 0.0 { gone / way } else { 1.0 };
        let pose = Pose2::new(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.theta + t * turn);
        let room = room(problem, state, body, &pose)?;
        if t >= 1.0 {
            return Ok(());
        }
        gone = (gone + room.max(LEAST_ADVANCE)).min(way);
    }
}

#[cfg(test)]
#[path = "certificate_tests.rs"]
mod tests;
