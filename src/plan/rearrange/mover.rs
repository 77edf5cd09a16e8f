//! Moves of one body to a free place: pick-and-place, or a drag along a path.

use std::sync::Arc;

use super::table::{Layout, Table};
use crate::action::{Move, MoveCosts};
use crate::geom::{Frame, Pose2, normalize_angle};
use crate::run::Stop;
use crate::scene::Mask;

/// The table with the means to move its bodies.
#[derive(Debug)]
pub struct Mover {
    pub table: Table,
    pub costs: MoveCosts,
}

/// Working memory of one worker.
#[derive(Debug, Default)]
pub struct MoverScratch;

/// Distance of the frames along a corridor, metres by the metric of drags.
const CORRIDOR_STEP: f64 = 0.008;

impl Mover {
    /// The means for another problem on the same table.
    pub fn with_table(&self, table: Table) -> Mover {
        Mover { table, costs: self.costs }
    }

    /// The move of `body` to `to`, a free place; `None` where no path is found.
    pub fn attempt(
        &self,
        scratch: &mut MoverScratch,
        layout: &Layout,
        body: usize,
        to: Pose2,
        stop: &Stop,
    ) -> Option<Move> {
        if self.table.drag_only.contains(body) {
            let waypoints = self.path_without(scratch, layout, body, to, Mask::EMPTY, stop)?;
            return Some(Move::Drag { body, waypoints });
        }
        Some(Move::PickPlace { body, pick: layout.pose(body), place: to })
    }

    /// A path of `body` to `to` as if the bodies of `without` were not there.
    pub fn path_without(
        &self,
        _: &mut MoverScratch,
        _: &Layout,
        _: usize,
        _: Pose2,
        _: Mask,
        _: &Stop,
    ) -> Option<Arc<[Pose2]>> {
        None
    }

    /// Frames along a path, close to each other.
    pub fn frames_along(&self, path: &[Pose2], out: &mut Vec<Frame>) {
        out.extend(path.first().map(Pose2::frame));
        for pair in path.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let turn = normalize_angle(b.theta - a.theta);
            let steps = (self.costs.distance(&a, &b) / CORRIDOR_STEP).ceil().max(1.0);
            for step in 1..=steps as u32 {
                let t = f64::from(step) / steps;
                let pose = Pose2::new(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.theta + t * turn);
                out.push(pose.frame());
            }
        }
    }
}
