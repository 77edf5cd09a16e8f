//! Makes room on a full table: bodies are pushed together until one fits where it is wanted.

use super::mover::{Mover, MoverScratch};
use super::table::{Layout, stored};
use crate::action::Move;
use crate::geom::Pose2;
use crate::run::Stop;
use crate::scene::Mask;

/// Rounds of pushing bodies out of each other.
const ROUNDS: usize = 60;
/// Of an overlap of two bodies, what each gives way in a round; one that does not give way leaves all of it to the other.
const SHARE: f64 = 0.6;
/// Added to each step, metres, so that it does not end just short.
const EXTRA: f64 = 1e-5;

/// Working memory.
#[derive(Debug, Default)]
pub struct RoomMaker {
    /// Where the bodies shall be, and where they were before a round.
    wanted: Layout,
    before: Layout,
    layout: Layout,
    made: Vec<Move>,
}

impl RoomMaker {
    /// Moves the others from where `body` would be at `pose`, as little as will do. False, with nothing changed, where no
    /// way was found that takes at most `limit` moves.
    #[allow(clippy::too_many_arguments)]
    pub fn make_room(
        &mut self,
        mover: &Mover,
        scratch: &mut MoverScratch,
        (layout, moves): (&mut Layout, &mut Vec<Move>),
        body: usize,
        pose: Pose2,
        limit: usize,
        stop: &Stop,
    ) -> bool {
        if !self.spread(mover, layout, body, pose, stop) || !self.order(mover, scratch, layout, body, limit, stop) {
            return false;
        }
        layout.clone_from(&self.layout);
        moves.append(&mut self.made);
        true
    }

    /// Finds where the others may be: each gives way to those that it overlaps.
    fn spread(&mut self, mover: &Mover, layout: &Layout, body: usize, pose: Pose2, stop: &Stop) -> bool {
        let table = &mover.table;
        self.wanted.clone_from(layout);
        self.wanted.place(body, pose);
        for _ in 0..ROUNDS {
            if stop.requested() {
                return false;
            }
            self.before.clone_from(&self.wanted);
            let mut apart = true;
            for other in table.movable.iter().filter(|&other| other != body) {
                let now = self.before.pose(other);
                let blockers = table.blockers(&self.before, other, &now, table.clearance);
                let (mut x, mut y) = (0.0, 0.0);
                for blocker in blockers.iter() {
                    let from = now.position() - self.before.pose(blocker).position();
                    let distance = from.norm().max(1e-6);
                    let depth = table.depth(&self.before, other, &now, blocker, distance);
                    let stays = blocker == body || !table.movable.contains(blocker);
                    let step = if stays { depth } else { SHARE * depth } + EXTRA;
                    x += from.x / distance * step;
                    y += from.y / distance * step;
                }
                if !blockers.is_empty() {
                    apart = false;
                    let new = table.brought_inside(other, Pose2::new(now.x + x, now.y + y, now.theta));
                    self.wanted.place(other, stored(new));
                }
            }
            if apart {
                return true;
            }
        }
        false
    }

    /// Brings the others there, one after the other.
    fn order(
        &mut self,
        mover: &Mover,
        scratch: &mut MoverScratch,
        layout: &Layout,
        body: usize,
        limit: usize,
        stop: &Stop,
    ) -> bool {
        let table = &mover.table;
        self.made.clear();
        self.layout.clone_from(layout);
        let mut left = Mask::EMPTY;
        let moved = |other: &usize| *other != body && layout.pose(*other) != self.wanted.pose(*other);
        table.movable.iter().filter(moved).for_each(|other| left.insert(other));
        while !left.is_empty() {
            let before = left;
            for other in before.iter() {
                let to = self.wanted.pose(other);
                if !table.is_free(&self.layout, other, &to) || self.made.len() == limit {
                    continue;
                }
                let Some(action) = mover.attempt(scratch, &self.layout, other, to, stop) else { continue };
                self.layout.place(other, to);
                self.made.push(action);
                left.remove(other);
            }
            if left == before {
                return false;
            }
        }
        !self.made.is_empty()
    }
}
