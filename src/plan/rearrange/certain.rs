//! What is known of a problem without a search: that it has no solution, or a move that is of use whatever comes next.

use super::mover::{Mover, MoverScratch};
use super::samplers::{anywhere, direct, tiles};
use super::table::{Layout, stored};
use crate::action::Move;
use crate::geom::footprints_apart;
use crate::motion::Enclosure;
use crate::plan::Reason;
use crate::run::{Key, Stop};

/// Places drawn for a body in the way, beside those of the grid.
const DRAWN: usize = 32;

/// Why no plan solves the problem: bodies that have to be dragged and that bodies which never move keep from their goals.
/// Empty where nothing is known, or the work was asked to end before it was.
pub fn impossible(mover: &Mover, start: &Layout, scratch: &mut MoverScratch, stop: &Stop) -> Vec<Reason> {
    let table = &mover.table;
    let waiting = table.misplaced(&start.state) & table.drag_only;
    let mut reasons = Vec::new();
    for body in waiting.iter() {
        let fixed: Vec<usize> = (0..table.len()).filter(|&other| !table.movable.contains(other)).collect();
        match mover.enclosure(scratch, start, body, &fixed, stop) {
            Enclosure::Unknown => {}
            Enclosure::Stuck => reasons.push(Reason::Stuck { body: name(mover, body) }),
            Enclosure::Enclosed => {
                let by = least(fixed, |some| mover.enclosure(scratch, start, body, some, stop) == Enclosure::Enclosed);
                let by = by.into_iter().map(|other| name(mover, other)).collect();
                reasons.push(Reason::Enclosed { body: name(mover, body), by });
            }
        }
    }
    reasons
}

/// Members without which `holds` would not: one after another is left out where it holds without.
fn least(all: Vec<usize>, mut holds: impl FnMut(&[usize]) -> bool) -> Vec<usize> {
    let mut left = all.clone();
    for member in all {
        let without: Vec<usize> = left.iter().copied().filter(|&other| other != member).collect();
        if holds(&without) {
            left = without;
        }
    }
    left
}

fn name(mover: &Mover, body: usize) -> String {
    mover.table.problem.scene.body(body).name.clone()
}

/// Moves that are of use whatever comes next, for where a search had no time to find any: every body that can go home
/// in turn does, or else one that stands on another's goal leaves it. Work of a fraction of a millisecond but for paths, and
/// those end with `stop`.
pub fn useful(mover: &Mover, start: &Layout, scratch: &mut MoverScratch, stop: &Stop) -> Vec<Move> {
    let table = &mover.table;
    let misplaced = table.misplaced(&start.state);
    let mut layout = start.clone();
    let mut moves = Vec::new();
    for body in (misplaced & table.movable).iter() {
        let home = direct(table, &layout, body);
        if let Some(action) = home.and_then(|home| mover.attempt(scratch, &layout, body, home.pose, stop)) {
            layout.place(body, action.to());
            moves.push(action);
        }
    }
    if moves.is_empty() {
        moves.extend(misplaced.iter().find_map(|body| {
            let blockers = table.goal_blockers(start, body) & table.movable;
            blockers.iter().find_map(|other| leave(mover, start, scratch, other, body, stop))
        }));
    }
    moves
}

/// A move of `body` to a free place off the goal of `waiting`.
fn leave(
    mover: &Mover,
    layout: &Layout,
    scratch: &mut MoverScratch,
    body: usize,
    waiting: usize,
    stop: &Stop,
) -> Option<Move> {
    let table = &mover.table;
    let goal = table.goal_pose(waiting, &layout.pose(waiting))?.frame();
    let mut stream = Key::new(0).child(body as u64).stream();
    let drawn: Vec<_> = (0..DRAWN).map(|_| stored(anywhere(table, body, &mut stream))).collect();
    let off = |pose: &crate::geom::Pose2| {
        footprints_apart(table.footprint(body), &pose.frame(), table.footprint(waiting), &goal, table.clearance)
    };
    let places = drawn.into_iter().chain(tiles(table, body));
    // A body that is dragged gets to some places only.
    let tried = if table.drag_only.contains(body) { 4 } else { 1 };
    let mut free = places.filter(|pose| off(pose) && table.is_free(layout, body, pose)).take(tried);
    free.find_map(|pose| mover.attempt(scratch, layout, body, pose, stop))
}
