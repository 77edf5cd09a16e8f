//! Leaves out of a plan what it can do without.
//!
//! An attempt decides one move at a time, so that a body may be put aside several times where once would do. Here each
//! move of a body that is moved again, or need not be moved at all, is left out, or the body is at once put where it is
//! put next; the rest is made as before, drags along new paths, if every place is still free.

use super::mover::{Mover, MoverScratch};
use super::table::Layout;
use crate::action::Move;
use crate::geom::Pose2;
use crate::run::Stop;
use crate::scene::Mask;

/// Working memory.
#[derive(Debug, Default)]
pub struct Shortener {
    layout: Layout,
    steps: Vec<(usize, Pose2)>,
    tried: Vec<(usize, Pose2)>,
    made: Vec<Move>,
}

impl Shortener {
    /// Shortens moves from `start` that lead every body home.
    pub fn shorten(
        &mut self,
        mover: &Mover,
        scratch: &mut MoverScratch,
        start: &Layout,
        moves: &mut Vec<Move>,
        stop: &Stop,
    ) {
        let misplaced = mover.table.misplaced(&start.state);
        self.steps.clear();
        self.steps.extend(moves.iter().map(|action| (action.body(), action.to())));
        let mut index = self.steps.len();
        while index > 0 && !stop.requested() {
            index -= 1;
            let body = self.steps[index].0;
            let next = (index + 1..self.steps.len()).find(|&later| self.steps[later].0 == body);
            let earlier = self.steps[..index].iter().any(|step| step.0 == body);
            if next.is_none() && !earlier && misplaced.contains(body) {
                continue;
            }
            let mut shorter = self.without(mover, scratch, start, index, None, stop);
            if !shorter && next.is_some() {
                shorter = self.without(mover, scratch, start, index, next, stop);
            }
            if shorter {
                std::mem::swap(&mut self.steps, &mut self.tried);
                std::mem::swap(moves, &mut self.made);
                index = index.min(self.steps.len());
            }
        }
    }

    /// Makes the plan without the step `index` or, with `next`, without that one, the body being put there at once; false
    /// where that leads nowhere.
    fn without(
        &mut self,
        mover: &Mover,
        scratch: &mut MoverScratch,
        start: &Layout,
        index: usize,
        next: Option<usize>,
        stop: &Stop,
    ) -> bool {
        self.tried.clone_from(&self.steps);
        if let Some(next) = next {
            self.tried[index].1 = self.tried[next].1;
        }
        self.tried.remove(next.unwrap_or(index));
        self.layout.clone_from(start);
        self.made.clear();
        for &(body, to) in &self.tried {
            if !mover.table.may_stand(&self.layout, body, &to) {
                return false;
            }
            let Some(action) = mover.attempt(scratch, &self.layout, body, to, stop) else { return false };
            self.layout.place(body, to);
            self.made.push(action);
        }
        mover.table.misplaced(&self.layout.state) == Mask::EMPTY
    }
}
