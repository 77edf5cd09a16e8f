//! Where a body may be put: the four criteria of REMP ("Action Space Design").

use std::f64::consts::{FRAC_PI_2, PI};

use serde::{Deserialize, Serialize};

use super::table::{Layout, Table, stored};
use crate::error::{Error, Result, check_range};
use crate::geom::{Pose2, vec2};
use crate::run::Stream;
use crate::scene::PLACE_SLACK;

/// Which criterion proposed a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Criterion {
    Direct,
    Random,
    AroundCurrent,
    AroundGoal,
    Grid,
}

/// A collision-free place for a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    pub pose: Pose2,
    pub criterion: Criterion,
}

/// How many places are sampled for one body in one state. The source gives no counts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SampleCounts {
    pub random: u32,
    pub around_current: u32,
    pub around_goal: u32,
    /// Tiles of the grid, of both orientations together; drawn from all free ones.
    pub grid: u32,
    /// Random places that rollouts may use ("action space bias"); those of the other criteria are for expansion only.
    pub rollout: u32,
    /// Standard deviation of the samples around a pose: metres, radians.
    pub position_spread: f64,
    pub rotation_spread: f64,
    /// Draws until a sample is given up for want of a free place.
    pub tries: u32,
}

impl Default for SampleCounts {
    fn default() -> Self {
        SampleCounts {
            random: 8,
            around_current: 8,
            around_goal: 8,
            grid: 20,
            rollout: 2,
            position_spread: 0.04,
            rotation_spread: 0.3,
            tries: 20,
        }
    }
}

impl SampleCounts {
    pub fn validate(&self) -> Result<()> {
        let counts = [
            ("samples.random", self.random),
            ("samples.around_current", self.around_current),
            ("samples.around_goal", self.around_goal),
            ("samples.grid", self.grid),
            ("samples.rollout", self.rollout),
        ];
        for (field, count) in counts {
            check_range(field, f64::from(count), 0.0..=10_000.0)?;
        }
        if counts[..4].iter().all(|(_, count)| *count == 0) {
            return Err(Error::argument("samples", "are all 0; a body in the way could go nowhere"));
        }
        check_range("samples.tries", f64::from(self.tries), 1.0..=10_000.0)?;
        check_range("samples.position_spread", self.position_spread, 0.0..=10.0)?;
        check_range("samples.rotation_spread", self.rotation_spread, 0.0..=10.0)
    }

    /// All places for a body: the goal first if it is free, then random ones, those around, and the grid.
    pub fn places(&self, table: &Table, layout: &Layout, body: usize, stream: &mut Stream, out: &mut Vec<Place>) {
        let now = layout.pose(body);
        if !table.problem.at_goal(body, &now) {
            out.extend(direct(table, layout, body));
        }
        let mut add = |count: u32, criterion: Criterion, draw: &mut dyn FnMut(&mut Stream) -> Pose2| {
            for _ in 0..count {
                let place = (0..self.tries).map(|_| stored(draw(stream))).find(|p| table.is_free(layout, body, p));
                out.extend(place.map(|pose| Place { pose, criterion }));
            }
        };
        add(self.random, Criterion::Random, &mut |stream| anywhere(table, body, stream));
        add(self.around_current, Criterion::AroundCurrent, &mut |stream| self.around(&now, stream));
        if let Some(goal) = table.goal_pose(body, &now) {
            add(self.around_goal, Criterion::AroundGoal, &mut |stream| self.around(&goal, stream));
        }
        self.grid(table, layout, body, stream, out);
    }

    fn around(&self, pose: &Pose2, stream: &mut Stream) -> Pose2 {
        let (x, y) = (stream.normal(), stream.normal());
        let theta = pose.theta + self.rotation_spread * stream.normal();
        Pose2::new(pose.x + self.position_spread * x, pose.y + self.position_spread * y, theta)
    }

    /// Tiles of the workspace by the body's bounding box, flush with the edges, lying along either axis.
    fn grid(&self, table: &Table, layout: &Layout, body: usize, stream: &mut Stream, out: &mut Vec<Place>) {
        let mut tiles = tiles(table, body);
        stream.shuffle(&mut tiles);
        let free = tiles.into_iter().filter(|pose| table.is_free(layout, body, pose));
        out.extend(free.take(self.grid as usize).map(|pose| Place { pose, criterion: Criterion::Grid }));
    }
}

/// The body's goal, if it is free.
pub fn direct(table: &Table, layout: &Layout, body: usize) -> Option<Place> {
    let pose = table.goal_pose(body, &layout.pose(body))?;
    let free = table.blockers(layout, body, &pose, -PLACE_SLACK).is_empty();
    free.then_some(Place { pose, criterion: Criterion::Direct })
}

/// A pose anywhere on the table, free or not.
pub fn anywhere(table: &Table, body: usize, stream: &mut Stream) -> Pose2 {
    let workspace = table.problem.scene.workspace();
    let theta = stream.uniform(-PI, PI);
    // So that the footprint is inside for this heading; where it does not fit, the middle.
    let frame = Pose2::new(0.0, 0.0, theta).frame();
    let extent = |x: f64, y: f64| table.footprint(body).support(frame.inverse_vector(vec2(x, y)));
    let mut range = |low: f64, high: f64| {
        if low <= high { stream.uniform(low, high) } else { (low + high) / 2.0 }
    };
    let x = range(workspace.min[0] + extent(-1.0, 0.0), workspace.max[0] - extent(1.0, 0.0));
    let y = range(workspace.min[1] + extent(0.0, -1.0), workspace.max[1] - extent(0.0, 1.0));
    Pose2::new(x, y, theta)
}

/// Every tile of the grid, free or not.
pub fn tiles(table: &Table, body: usize) -> Vec<Pose2> {
    /// Tiles keep this far from the edge, metres: single precision must not put them outside.
    const INSET: f64 = 1e-6;
    let workspace = table.problem.scene.workspace();
    let bounds = table.boxes[body];
    let mut tiles = Vec::new();
    for (turn, [width, height]) in [(0.0, bounds.size), (FRAC_PI_2, [bounds.size[1], bounds.size[0]])] {
        let columns = stops(workspace.min[0] + INSET, workspace.max[0] - INSET, width);
        let rows = stops(workspace.min[1] + INSET, workspace.max[1] - INSET, height);
        let theta = turn - bounds.angle;
        let middle = Pose2::new(0.0, 0.0, theta).frame().vector(bounds.middle);
        for &y in &rows {
            tiles.extend(columns.iter().map(|&x| stored(Pose2::new(x - middle.x, y - middle.y, theta))));
        }
    }
    tiles
}

/// Middles of intervals of one size that cover `low..high`, the first and the last flush with the ends.
fn stops(low: f64, high: f64, size: f64) -> Vec<f64> {
    let room = high - low - size;
    if room < 0.0 {
        return Vec::new();
    }
    let gaps = (room / size).ceil().max(1.0) as usize;
    (0..=gaps).map(|k| low + size / 2.0 + room * k as f64 / gaps as f64).collect()
}
