//! What a path query may be told.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, check_positive, check_range};
use crate::geom::{Pose2, normalize_angle};
use crate::scene::Workspace;

/// How paths are measured and searched.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PathParams {
    /// Gap to keep from the other bodies, metres. Where the body already stands or shall stand nearer to another one,
    /// the path keeps that smaller gap from it. From the workspace's edge no gap is kept.
    pub clearance: f64,
    /// Metres that one radian of turning counts as, in lengths of paths and in the search.
    pub turn_weight: f64,
    /// Greatest length of one extension of a tree towards a sample on a table of 0.78 m x 0.52 m, in metres by the metric.
    /// On others it is in proportion: see [`room`].
    pub step: f64,
    /// Iterations of RRT-Connect before the question is put to the grid whether the goal can be reached at all.
    pub quick_iterations: u32,
    /// Iterations of RRT-Connect in all, unless the query says otherwise.
    pub iterations: u32,
    /// Attempts to shorten a path by cutting across.
    pub shortcuts: u32,
    /// Edge of a cell of the grid on a table of 0.78 m x 0.52 m, metres. On others it is in proportion, and for a body whose
    /// narrow side is less than some cells it is less.
    pub cell: f64,
    /// Layers of the grid in a full turn.
    pub headings: u32,
}

impl Default for PathParams {
    /// 2 mm of clearance and 0.1 m/rad are the proposal for REMP; the rest was chosen by measuring (see
    /// `docs/rearrangement.md`).
    fn default() -> Self {
        Self {
            clearance: 0.002,
            turn_weight: 0.1,
            step: 0.1,
            quick_iterations: 64,
            iterations: 2000,
            shortcuts: 40,
            cell: 0.006,
            headings: 72,
        }
    }
}

impl PathParams {
    /// Refuses what cannot be worked with, by the field's name.
    pub fn validate(&self) -> Result<()> {
        check_range("clearance", self.clearance, MIN_CLEARANCE..=0.1)?;
        check_range("turn_weight", self.turn_weight, 0.0..=10.0)?;
        check_positive("step", self.step)?;
        check_range("cell", self.cell, 0.001..=0.1)?;
        if !(8..=360).contains(&self.headings) {
            return Err(Error::argument("headings", format!("is {}; it must lie in 8..=360", self.headings)));
        }
        Ok(())
    }

    /// The lengths of the search for a room of this size and a body that is `width` wide where it is narrowest.
    pub(super) fn fitted(&self, room: f64, width: f64) -> PathParams {
        /// Greatest cell as a part of the width, and least one as a part of what the room asks for.
        const OF_WIDTH: f64 = 0.3;
        const OF_ROOM: f64 = 0.125;
        let cell = self.cell * room;
        PathParams { cell: (OF_WIDTH * width).clamp(OF_ROOM * cell, cell), step: self.step * room, ..*self }
    }

    /// The length of the straight motion from one pose to another, metres: translation and weighted turn, summed.
    pub fn length(&self, a: &Pose2, b: &Pose2) -> f64 {
        (b.x - a.x).hypot(b.y - a.y) + self.turn_weight * normalize_angle(b.theta - a.theta).abs()
    }
}

/// The size of a room: its diagonal, that of a table of 0.78 m x 0.52 m being 1. Lengths of searches that were chosen on
/// that table are in proportion to it, so that a problem ten times as large takes no more work.
pub fn room(workspace: &Workspace) -> f64 {
    const TABLE: [f64; 2] = [0.78, 0.52];
    let extent = |axis: usize| workspace.max[axis] - workspace.min[axis];
    extent(0).hypot(extent(1)) / TABLE[0].hypot(TABLE[1])
}

/// Distances are told apart to this, metres: a motion that passes has at every instant at least its clearance less
/// this, and one that keeps its clearance throughout passes. It makes every advance of a sweep a step of some length.
pub const SWEEP_SLACK: f64 = 1e-4;

/// Least clearance that can be asked for or that two bodies may have at the ends of a path, metres.
pub const MIN_CLEARANCE: f64 = 2.0 * SWEEP_SLACK;

/// How far a footprint may reach over the workspace's edge and still count as inside, metres: what single-precision
/// poses leave undecided.
pub const EDGE_TOLERANCE: f64 = 1e-6;
