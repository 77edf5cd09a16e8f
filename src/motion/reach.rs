//! Where a body can be brought to, as a bitmap over x, y and heading: the certain "no", and where to draw samples.
//!
//! A cell is blocked only if *every* pose in it (edges included) is in conflict with one pair of convex pieces or with
//! the workspace's edge. The signed gap of two convex bodies changes by no more than the greatest displacement of a
//! point of the moving one, so a cell is blocked if at its middle the two overlap at least as deep as a point can move
//! within the cell, less the gap to keep. The set of such middles is the Minkowski difference of the pieces (Lozano-
//! Perez 1983) with its edges moved inwards: convex, and filled row by row. A path that is free runs through cells
//! that are not blocked, neighbours by a face; so if the goal's cell is not in the start's component, there is none.
//!
//! The same bitmap of the cells whose middle is free has no certainty, but shows the way through narrow places: the
//! shortest way from cell to cell is the middle of a corridor, in which samples are worth most.

use std::f64::consts::{PI, TAU};

use super::params::{EDGE_TOLERANCE, PathParams, SWEEP_SLACK};
use super::shape::{Core, MovingShape};
use super::sweep::Obstacles;
use crate::geom::{Frame, Pose2, Vec2, normalize_angle, vec2};
use crate::scene::Workspace;

/// Corners of the polygon within a disc that stands for it.
const DISC_CORNERS: usize = 16;

/// The bitmap, its memory reused.
#[derive(Debug, Default)]
pub(super) struct Reach {
    origin: Vec2,
    cell: f64,
    columns: usize,
    rows: usize,
    words: usize,
    layers: usize,
    /// Bit set: not certainly blocked. By layer, row, word.
    open: Vec<u64>,
    /// Bit set: connected with the start.
    seen: Vec<u64>,
    /// For each cell, the direction that a search first came to it by, from 1; 0 for none.
    came: Vec<u8>,
    queue: Vec<u32>,
    queued: Vec<bool>,
    moved: Core,
    polygon: Core,
    lines: Vec<Line>,
}

/// Which cells are open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cells {
    /// All that are not certainly blocked.
    NotBlocked,
    /// Those whose middle is free.
    FreeMiddle,
}

/// The half-plane x * nx + y * ny <= c, in the grid's units, as a bound of x in a row.
#[derive(Debug, Clone, Copy)]
struct Line {
    nx: f64,
    /// Bound of x at row 0 and its change by row; where `nx` is 0, of y.
    at: f64,
    slope: f64,
}

impl Reach {
    /// Makes the bitmap for one body and floods it from a pose. `needs` of the obstacles are obeyed.
    /// `false` where the start's own cell is not open, which of cells that are not blocked only rounding could do: then
    /// nothing is known.
    pub fn make(
        &mut self,
        cells: Cells,
        shape: &MovingShape,
        obstacles: &Obstacles,
        workspace: &Workspace,
        params: &PathParams,
        from: &Pose2,
    ) -> bool {
        self.size(shape, workspace, params);
        let half_layer = PI / self.layers as f64;
        let (displacement, slack) = match cells {
            Cells::NotBlocked => {
                let displacement = self.cell * 0.5f64.sqrt() + shape.middle_radius * half_layer;
                (displacement + EDGE_TOLERANCE, SWEEP_SLACK)
            }
            Cells::FreeMiddle => (0.0, 0.0),
        };
        self.open.fill(0);
        for layer in 0..self.layers {
            let heading = layer as f64 * TAU / self.layers as f64;
            // The shape about its middle.
            let mut frame = Pose2::new(0.0, 0.0, heading).frame();
            frame.origin = -frame.vector(shape.middle);
            self.open_inside(shape, workspace, &frame, displacement, layer);
            for core in &shape.cores {
                let mut moved = std::mem::take(&mut self.moved);
                polygon_of(core, &frame, &mut moved);
                for (others, need) in obstacles.bodies() {
                    // Outwards the edges may only move where no certainty is asked for: corners would have to be round.
                    let erosion = displacement + slack - need;
                    let erosion = if cells == Cells::NotBlocked { erosion.max(0.0) } else { erosion };
                    for other in others {
                        self.block(&moved, other, erosion, layer);
                    }
                }
                self.moved = moved;
            }
        }
        let place = match cells {
            // Nothing but the start's own cell gives certainty.
            Cells::NotBlocked => self
                .place_of(from.transform_point(shape.middle), from.theta)
                .filter(|&(row, column)| self.is_open(row, column)),
            Cells::FreeMiddle => self.open_near(shape, from),
        };
        place.is_some_and(|place| self.flood(place))
    }

    /// Chooses the grid: cells as asked, and as many layers as make a turn by one move a point no farther than a cell.
    fn size(&mut self, shape: &MovingShape, workspace: &Workspace, params: &PathParams) {
        let extent = [workspace.max[0] - workspace.min[0], workspace.max[1] - workspace.min[1]];
        // No more than some thousand cells a side, however large the workspace.
        self.cell = params.cell.max(extent[0].max(extent[1]) / 1024.0);
        self.origin = vec2(workspace.min[0], workspace.min[1]);
        self.columns = (extent[0] / self.cell).ceil().max(1.0) as usize;
        self.rows = (extent[1] / self.cell).ceil().max(1.0) as usize;
        self.words = self.columns.div_ceil(64);
        self.layers = ((PI * shape.middle_radius / self.cell).ceil() as usize).clamp(8, params.headings as usize);
        let words = self.layers * self.rows * self.words;
        self.open.resize(words, 0);
        self.seen.resize(words, 0);
        self.queued.resize(self.layers * self.rows, false);
    }

    /// Opens the rectangle of cells whose footprint need not reach out of the workspace.
    fn open_inside(&mut self, shape: &MovingShape, workspace: &Workspace, frame: &Frame, margin: f64, layer: usize) {
        let (mut min, mut max) = (vec2(f64::INFINITY, f64::INFINITY), vec2(f64::NEG_INFINITY, f64::NEG_INFINITY));
        for &(p, rounding) in &shape.extremes {
            let p = frame.point(p);
            min = min.inf(&(p - vec2(rounding, rounding)));
            max = max.sup(&(p + vec2(rounding, rounding)));
        }
        let cells = |low: f64, high: f64, count: usize| {
            // Middles of cells lie at k + 1/2.
            let first = (low / self.cell - 0.5).ceil().max(0.0);
            let last = (high / self.cell - 0.5).floor().min(count as f64 - 1.0);
            (first, last)
        };
        let (x0, y0) = (workspace.min[0], workspace.min[1]);
        let (c0, c1) = cells(-min.x - margin, workspace.max[0] - x0 - max.x + margin, self.columns);
        let (r0, r1) = cells(-min.y - margin, workspace.max[1] - y0 - max.y + margin, self.rows);
        if c0 > c1 || r0 > r1 {
            return;
        }
        for row in r0 as usize..=r1 as usize {
            let at = (layer * self.rows + row) * self.words;
            set(&mut self.open[at..at + self.words], c0 as usize, c1 as usize);
        }
    }

    /// Blocks the cells whose middle lies at least `erosion` deep in the difference of two pieces.
    fn block(&mut self, moved: &Core, other: &Core, erosion: f64, layer: usize) {
        let mut polygon = std::mem::take(&mut self.polygon);
        let other = if other.normals.is_empty() {
            polygon_of(other, &Pose2::IDENTITY.frame(), &mut polygon);
            &polygon
        } else {
            other
        };
        self.lines.clear();
        let mut rows = (0.0, self.rows as f64 - 1.0);
        // In cells, with the middle of cell (0, 0) at the origin.
        let scale = 1.0 / self.cell;
        let shift = self.origin + vec2(0.5, 0.5) * self.cell;
        let mut empty = false;
        let mut add = |n: Vec2, offset: f64| {
            let c = (offset - erosion - n.dot(&shift)) * scale;
            if n.x.abs() > 1e-9 {
                self.lines.push(Line { nx: n.x, at: c / n.x, slope: -n.y / n.x });
            } else if n.y > 0.0 {
                rows.1 = f64::min(rows.1, c / n.y);
            } else {
                rows.0 = f64::max(rows.0, c / n.y);
            }
        };
        for (n, p) in other.normals.iter().zip(&other.points) {
            add(*n, n.dot(p) - extent(&moved.points, *n).0);
        }
        for (n, p) in moved.normals.iter().zip(&moved.points) {
            // A normal of the moved piece is one of its mirror image the other way round.
            add(-*n, extent(&other.points, -*n).1 + n.dot(p));
        }
        // Rows that the difference spans at all.
        let (up, scale_y) = (vec2(0.0, 1.0), scale);
        let (moved_low, moved_high) = extent(&moved.points, up);
        let (other_low, other_high) = extent(&other.points, up);
        rows.0 = rows.0.max((other_low - moved_high + erosion - shift.y) * scale_y);
        rows.1 = rows.1.min((other_high - moved_low - erosion - shift.y) * scale_y);
        empty |= rows.0 > rows.1;
        if !empty {
            let (first, last) = (rows.0.ceil().max(0.0) as usize, rows.1.floor());
            if last >= first as f64 {
                for row in first..=last as usize {
                    let y = row as f64;
                    let (mut low, mut high) = (0.0, self.columns as f64 - 1.0);
                    for line in &self.lines {
                        let x = line.at + line.slope * y;
                        if line.nx > 0.0 {
                            high = f64::min(high, x);
                        } else {
                            low = f64::max(low, x);
                        }
                    }
                    let (low, high) = (low.ceil(), high.floor());
                    if low <= high {
                        let at = (layer * self.rows + row) * self.words;
                        clear(&mut self.open[at..at + self.words], low as usize, high as usize);
                    }
                }
            }
        }
        self.polygon = polygon;
    }

    /// Finds what is connected with the start by faces of open cells.
    fn flood(&mut self, (row, column): (usize, usize)) -> bool {
        self.seen.fill(0);
        self.queue.clear();
        self.seen[row * self.words + column / 64] = 1u64 << (column % 64);
        self.queue.push(row as u32);
        self.queued[row] = true;
        let total = self.layers * self.rows;
        while let Some(at) = self.queue.pop() {
            let at = at as usize;
            self.queued[at] = false;
            let span = at * self.words..(at + 1) * self.words;
            spread(&mut self.seen[span.clone()], &self.open[span]);
            let row = at % self.rows;
            let neighbours = [
                (row > 0).then(|| at - 1),
                (row + 1 < self.rows).then_some(at + 1),
                Some((at + self.rows) % total),
                Some((at + total - self.rows) % total),
            ];
            for to in neighbours.into_iter().flatten() {
                let mut grew = false;
                for word in 0..self.words {
                    let (source, target) = (at * self.words + word, to * self.words + word);
                    let new = self.seen[source] & self.open[target] & !self.seen[target];
                    self.seen[target] |= new;
                    grew |= new != 0;
                }
                if grew && !self.queued[to] {
                    self.queued[to] = true;
                    self.queue.push(to as u32);
                }
            }
        }
        true
    }

    fn is_open(&self, row: usize, column: usize) -> bool {
        self.open[row * self.words + column / 64] >> (column % 64) & 1 == 1
    }

    /// The cell of a pose, or an open one next to it.
    fn open_near(&self, shape: &MovingShape, pose: &Pose2) -> Option<(usize, usize)> {
        let (at, column) = self.place_of(pose.transform_point(shape.middle), pose.theta)?;
        if self.is_open(at, column) {
            return Some((at, column));
        }
        let (layer, row) = (at / self.rows, at % self.rows);
        let mut best: Option<(usize, (usize, usize))> = None;
        for turn in 0..5 {
            let layer = (layer + self.layers + turn - 2) % self.layers;
            for row in row.saturating_sub(2)..(row + 3).min(self.rows) {
                for near in column.saturating_sub(2)..(column + 3).min(self.columns) {
                    let place = layer * self.rows + row;
                    let away = turn.abs_diff(2) + row.abs_diff(at % self.rows) + near.abs_diff(column);
                    if best.is_none_or(|(least, _)| away < least) && self.is_open(place, near) {
                        best = Some((away, (place, near)));
                    }
                }
            }
        }
        best.map(|(_, place)| place)
    }

    /// The poses of the middles of the cells on a shortest way through open cells, from a pose to another. `false` where
    /// there is none.
    pub fn trace(&mut self, shape: &MovingShape, from: &Pose2, to: &Pose2, way: &mut Vec<Pose2>) -> bool {
        way.clear();
        let (Some(start), Some(goal)) = (self.open_near(shape, from), self.open_near(shape, to)) else { return false };
        let (columns, rows) = (self.columns, self.rows);
        let total = self.layers * rows * columns;
        let cell = |(row, column): (usize, usize)| row * columns + column;
        // From the goal, so that the way is read off from the start.
        self.came.clear();
        self.came.resize(total, 0);
        self.queue.clear();
        self.queue.push(cell(goal) as u32);
        self.came[cell(goal)] = 7;
        let layer_cells = rows * columns;
        let next = |at: usize, direction: u8| -> Option<usize> {
            let (row, column) = (at / columns % rows, at % columns);
            match direction {
                1 => (column > 0).then(|| at - 1),
                2 => (column + 1 < columns).then_some(at + 1),
                3 => (row > 0).then(|| at - columns),
                4 => (row + 1 < rows).then_some(at + columns),
                5 => Some((at + total - layer_cells) % total),
                _ => Some((at + layer_cells) % total),
            }
        };
        let mut head = 0;
        while head < self.queue.len() && self.came[cell(start)] == 0 {
            let at = self.queue[head] as usize;
            head += 1;
            for direction in 1..=6 {
                let Some(to) = next(at, direction) else { continue };
                if self.came[to] == 0 && self.is_open(to / columns, to % columns) {
                    self.came[to] = direction;
                    self.queue.push(to as u32);
                }
            }
        }
        let mut at = cell(start);
        if self.came[at] == 0 {
            return false;
        }
        loop {
            way.push(self.pose_of(shape, at / columns, at % columns));
            let direction = self.came[at];
            if direction == 7 {
                return true;
            }
            // Back against the direction that it was come to by.
            let back = if direction % 2 == 1 { direction + 1 } else { direction - 1 };
            match next(at, back) {
                Some(before) => at = before,
                None => return false,
            }
        }
    }

    /// The pose of a cell's middle.
    fn pose_of(&self, shape: &MovingShape, at: usize, column: usize) -> Pose2 {
        let (layer, row) = (at / self.rows, at % self.rows);
        let theta = normalize_angle(layer as f64 * TAU / self.layers as f64);
        let middle = self.origin + vec2(column as f64 + 0.5, row as f64 + 0.5) * self.cell;
        let origin = middle - Pose2::new(0.0, 0.0, theta).frame().vector(shape.middle);
        Pose2::at(origin, theta)
    }

    /// How far a sample may lie from a way's poses: metres each way, and radians.
    pub fn spread(&self) -> (f64, f64) {
        (1.5 * self.cell, 1.5 * TAU / self.layers as f64)
    }

    /// The row (with its layer) and column of a place of the shape's middle.
    fn place_of(&self, middle: Vec2, theta: f64) -> Option<(usize, usize)> {
        let at = (middle - self.origin) / self.cell;
        let (column, row) = (at.x.floor(), at.y.floor());
        // A middle on the upper edge belongs to the last cell.
        let (columns, rows) = (self.columns as f64, self.rows as f64);
        if !(-1.0..=columns).contains(&column) || !(-1.0..=rows).contains(&row) {
            return None;
        }
        let (column, row) = (column.clamp(0.0, columns - 1.0) as usize, row.clamp(0.0, rows - 1.0) as usize);
        let layer = (theta.rem_euclid(TAU) / TAU * self.layers as f64).round() as usize % self.layers;
        Some((layer * self.rows + row, column))
    }

    /// Whether the start may be brought to this place of the shape's middle; `false` is certain.
    pub fn holds(&self, middle: Vec2, theta: f64) -> bool {
        self.place_of(middle, theta)
            .is_some_and(|(row, column)| self.seen[row * self.words + column / 64] >> (column % 64) & 1 == 1)
    }
}

/// Least and greatest coordinate along a direction.
fn extent(points: &[Vec2], n: Vec2) -> (f64, f64) {
    points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
        let x = n.x * p.x + n.y * p.y;
        (low.min(x), high.max(x))
    })
}

/// The core seen through a frame; for a disc, a regular polygon within it.
fn polygon_of(core: &Core, frame: &Frame, out: &mut Core) {
    out.place(core, frame);
    if core.normals.is_empty() {
        let centre = out.centre;
        out.points.clear();
        let step = TAU / DISC_CORNERS as f64;
        for k in 0..DISC_CORNERS {
            let (s, c) = (k as f64 * step).sin_cos();
            out.points.push(centre + vec2(c, s) * core.rounding);
            let (s, c) = ((k as f64 + 0.5) * step).sin_cos();
            out.normals.push(vec2(c, s));
        }
        out.rounding = 0.0;
    }
}

/// The bits from `first` to `last` in word `word`.
fn bits(word: usize, first: usize, last: usize) -> u64 {
    let low = first.saturating_sub(word * 64).min(63);
    let high = (last - word * 64).min(63);
    (u64::MAX << low) & (u64::MAX >> (63 - high))
}

fn set(row: &mut [u64], first: usize, last: usize) {
    for (word, cells) in row.iter_mut().enumerate().take(last / 64 + 1).skip(first / 64) {
        *cells |= bits(word, first, last);
    }
}

fn clear(row: &mut [u64], first: usize, last: usize) {
    for (word, cells) in row.iter_mut().enumerate().take(last / 64 + 1).skip(first / 64) {
        *cells &= !bits(word, first, last);
    }
}

/// Lets the set bits of a row run through open neighbours in the row.
fn spread(seen: &mut [u64], open: &[u64]) {
    let mut carry = 0;
    for (s, &o) in seen.iter_mut().zip(open) {
        let (mut g, mut p) = (*s | (carry & o), o);
        for k in [1, 2, 4, 8, 16, 32] {
            g |= p & (g << k);
            p &= p << k;
        }
        *s = g;
        carry = g >> 63;
    }
    carry = 0;
    for (s, &o) in seen.iter_mut().zip(open).rev() {
        let (mut g, mut p) = (*s | (carry & o), o);
        for k in [1, 2, 4, 8, 16, 32] {
            g |= p & (g >> k);
            p &= p >> k;
        }
        *s = g;
        carry = (g & 1) << 63;
    }
}
