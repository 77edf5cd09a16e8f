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
use crate::run::Stop;
use crate::scene::Workspace;

/// Corners of the polygon within a disc that stands for it.
const DISC_CORNERS: usize = 16;
/// Rows or cells that a search looks at between two looks at the stop.
const STEPS_PER_LOOK: usize = 1024;

/// The bitmap, its memory reused.
#[derive(Debug, Default)]
pub(super) struct Reach {
    /// What `open` shows. The same question is asked several times in a row: where may this body go, is there a path to
    /// this place, to that.
    made_of: Option<MadeOf>,
    needs: Vec<f64>,
    /// `seen` is of these cells.
    flooded: bool,
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
    /// Rows that a flood has yet to look at.
    rows_left: Vec<u32>,
    queued: Vec<bool>,
    /// For each cell, the direction that the search for a way came to it by, from 1; 0 for none.
    came: Vec<u8>,
    /// Cells for the search to look at, and those to look at after them.
    queue: Vec<u64>,
    soon: Vec<u64>,
    moved: Core,
    polygon: Core,
    lines: Vec<Line>,
    /// For each row that a difference spans, its first and last cell.
    spans: (Vec<f64>, Vec<f64>),
}

/// All that a bitmap depends on but the gaps to keep.
#[derive(Debug, Clone, Copy, PartialEq)]
struct MadeOf {
    cells: Cells,
    obstacles: (u64, usize),
    workspace: [[f64; 2]; 2],
    cell: f64,
    headings: u32,
}

/// Which cells are open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cells {
    /// All that are not certainly blocked.
    NotBlocked,
    /// Those whose middle is free.
    FreeMiddle,
}

/// A cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Place {
    layer: usize,
    row: usize,
    column: usize,
}

/// Stands for a direction where a search begins.
const GOAL: u8 = 7;

impl Place {
    /// In one word with a direction: a grid has at most 360 layers and 1025 rows and columns.
    fn packed(self, direction: u8) -> u64 {
        (self.layer as u64) << 32 | (self.row as u64) << 20 | (self.column as u64) << 8 | u64::from(direction)
    }

    fn unpacked(packed: u64) -> (Place, u8) {
        let part = |shift: u32| (packed >> shift & 0xfff) as usize;
        (Place { layer: part(32), row: part(20), column: part(8) }, (packed & 0xff) as u8)
    }
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
    /// Makes the bitmap for one body, and of cells that are not blocked floods it from a pose. The gaps that the obstacles
    /// ask for are kept. `false` where the start's own cell is not open, which only rounding could do, and where the work
    /// was asked to end: then nothing is known.
    #[allow(clippy::too_many_arguments)]
    pub fn make(
        &mut self,
        cells: Cells,
        shape: &MovingShape,
        obstacles: &Obstacles,
        workspace: &Workspace,
        params: &PathParams,
        from: &Pose2,
        stop: Option<&Stop>,
    ) -> bool {
        if !self.is_made(cells, obstacles, workspace, params)
            && !self.fill(cells, shape, obstacles, workspace, params, stop)
        {
            self.made_of = None;
            return false;
        }
        if cells == Cells::FreeMiddle {
            return true;
        }
        // Nothing but the start's own cell gives certainty.
        let middle = from.transform_point(shape.middle);
        let Some((row, column)) = self.place_of(middle, from.theta) else { return false };
        let known = self.is_open(row, column);
        // Where the start is connected with the last one, so is all the rest.
        if known && !(self.flooded && self.holds(middle, from.theta)) {
            self.flooded = self.flood((row, column), stop);
        }
        known && self.flooded
    }

    /// Whether the bitmap is already that of these; if not, it is said to be from now on.
    fn is_made(&mut self, cells: Cells, obstacles: &Obstacles, workspace: &Workspace, params: &PathParams) -> bool {
        let new = obstacles.made_of().map(|obstacles| MadeOf {
            cells,
            obstacles,
            workspace: [workspace.min, workspace.max],
            cell: params.cell,
            headings: params.headings,
        });
        let needs = || obstacles.bodies().map(|(_, need)| need);
        if new.is_some() && self.made_of == new && self.needs.iter().copied().eq(needs()) {
            return true;
        }
        self.made_of = new;
        self.needs.clear();
        self.needs.extend(needs());
        self.flooded = false;
        false
    }

    /// Fills the bitmap; `false` if the work was asked to end.
    fn fill(
        &mut self,
        cells: Cells,
        shape: &MovingShape,
        obstacles: &Obstacles,
        workspace: &Workspace,
        params: &PathParams,
        stop: Option<&Stop>,
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
            if stop.is_some_and(Stop::requested) {
                return false;
            }
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
        true
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
                let last = last as usize;
                let (lows, highs) = (&mut self.spans.0, &mut self.spans.1);
                lows.clear();
                lows.resize(last + 1 - first, 0.0);
                highs.clear();
                highs.resize(last + 1 - first, self.columns as f64 - 1.0);
                // Line by line, not row by row: these loops the compiler makes vectors of.
                for line in &self.lines {
                    let at = line.at + line.slope * first as f64;
                    if line.nx > 0.0 {
                        for (k, high) in highs.iter_mut().enumerate() {
                            let x = at + line.slope * k as u32 as f64;
                            *high = if x < *high { x } else { *high };
                        }
                    } else {
                        for (k, low) in lows.iter_mut().enumerate() {
                            let x = at + line.slope * k as u32 as f64;
                            *low = if x > *low { x } else { *low };
                        }
                    }
                }
                let mut at = (layer * self.rows + first) * self.words;
                for (&low, &high) in lows.iter().zip(highs.iter()) {
                    if low <= high {
                        // Both lie between 0 and the last column: rounded up and down without a call.
                        let (first, last) = (low as u32, high as u32);
                        let first = first + u32::from(f64::from(first) < low);
                        if first <= last {
                            clear(&mut self.open[at..at + self.words], first as usize, last as usize);
                        }
                    }
                    at += self.words;
                }
            }
        }
        self.polygon = polygon;
    }

    /// Finds what is connected with the start by faces of open cells; `false` if the work was asked to end.
    fn flood(&mut self, (row, column): (usize, usize), stop: Option<&Stop>) -> bool {
        self.seen.fill(0);
        self.rows_left.clear();
        self.queued.fill(false);
        let mut looked = 0usize;
        self.seen[row * self.words + column / 64] = 1u64 << (column % 64);
        self.rows_left.push(row as u32);
        self.queued[row] = true;
        let total = self.layers * self.rows;
        while let Some(at) = self.rows_left.pop() {
            looked += 1;
            if looked.is_multiple_of(STEPS_PER_LOOK) && stop.is_some_and(Stop::requested) {
                return false;
            }
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
                    self.rows_left.push(to as u32);
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
    /// there is none, or the work was asked to end. A search by the distance gone and the distance at least left (A*, Hart
    /// et al. 1968).
    pub fn trace(
        &mut self,
        shape: &MovingShape,
        from: &Pose2,
        to: &Pose2,
        way: &mut Vec<Pose2>,
        stop: Option<&Stop>,
    ) -> bool {
        way.clear();
        let (Some(start), Some(goal)) = (self.open_near(shape, from), self.open_near(shape, to)) else { return false };
        let place = |(at, column): (usize, usize)| Place { layer: at / self.rows, row: at % self.rows, column };
        let (start, goal) = (place(start), place(goal));
        // From the goal, so that the way is read off from the start.
        self.came.clear();
        self.came.resize(self.layers * self.rows * self.columns, 0);
        self.soon.clear();
        self.queue.clear();
        self.queue.push(goal.packed(GOAL));
        let mut looked = 0usize;
        loop {
            looked += 1;
            if looked.is_multiple_of(STEPS_PER_LOOK) && stop.is_some_and(Stop::requested) {
                return false;
            }
            let Some(next) = self.queue.pop() else {
                // Every step leads nearer by one or away by one, so what comes next is two farther.
                std::mem::swap(&mut self.queue, &mut self.soon);
                if self.queue.is_empty() {
                    return false;
                }
                continue;
            };
            let (at, came) = Place::unpacked(next);
            let index = self.index(at);
            if self.came[index] != 0 {
                continue;
            }
            self.came[index] = came;
            if at == start {
                break;
            }
            let left = self.steps(at, start);
            for direction in 1..=6 {
                let Some(to) = self.neighbour(at, direction) else { continue };
                if self.came[self.index(to)] == 0 && self.is_open(to.layer * self.rows + to.row, to.column) {
                    let nearer = self.steps(to, start) < left;
                    let list = if nearer { &mut self.queue } else { &mut self.soon };
                    list.push(to.packed(direction));
                }
            }
        }
        let mut at = start;
        loop {
            way.push(self.pose_of(shape, at));
            let direction = self.came[self.index(at)];
            if direction == GOAL {
                return true;
            }
            // Back against the direction that it was come to by.
            let back = if direction % 2 == 1 { direction + 1 } else { direction - 1 };
            match self.neighbour(at, back) {
                Some(before) => at = before,
                None => return false,
            }
        }
    }

    fn index(&self, at: Place) -> usize {
        (at.layer * self.rows + at.row) * self.columns + at.column
    }

    /// The cell next to a cell in one of the directions 1 to 6; layers have no end.
    fn neighbour(&self, at: Place, direction: u8) -> Option<Place> {
        let Place { layer, row, column } = at;
        Some(match direction {
            1 => Place { column: column.checked_sub(1)?, ..at },
            2 => Place { column: Some(column + 1).filter(|&column| column < self.columns)?, ..at },
            3 => Place { row: row.checked_sub(1)?, ..at },
            4 => Place { row: Some(row + 1).filter(|&row| row < self.rows)?, ..at },
            5 => Place { layer: layer.checked_sub(1).unwrap_or(self.layers - 1), ..at },
            _ => Place { layer: Some(layer + 1).filter(|&layer| layer < self.layers).unwrap_or(0), ..at },
        })
    }

    /// Steps between two cells where nothing is in the way.
    fn steps(&self, a: Place, b: Place) -> usize {
        let turn = a.layer.abs_diff(b.layer);
        a.column.abs_diff(b.column) + a.row.abs_diff(b.row) + turn.min(self.layers - turn)
    }

    /// The pose of a cell's middle.
    fn pose_of(&self, shape: &MovingShape, at: Place) -> Pose2 {
        let theta = normalize_angle(at.layer as f64 * TAU / self.layers as f64);
        let middle = self.origin + vec2(at.column as f64 + 0.5, at.row as f64 + 0.5) * self.cell;
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

    /// Whether the start may be brought to any place of the shape's middle within a square about this one, with a heading
    /// within `turn`; `false` is certain.
    pub fn holds_near(&self, middle: Vec2, half: f64, theta: f64, turn: f64) -> bool {
        let cell = |at: f64, low: f64, count: usize| {
            (((at - low) / self.cell).floor().max(0.0) as usize).min(count.saturating_sub(1))
        };
        let (x, y) = (self.origin.x, self.origin.y);
        let columns = cell(middle.x - half, x, self.columns)..=cell(middle.x + half, x, self.columns);
        let rows = cell(middle.y - half, y, self.rows)..=cell(middle.y + half, y, self.rows);
        let layer = |heading: f64| (heading / TAU * self.layers as f64).round() as i64;
        // No layer twice, however wide the turn.
        let (first, last) = (layer(theta - turn), layer(theta + turn));
        let layers = first..=last.min(first + self.layers as i64 - 1);
        layers.map(|layer| layer.rem_euclid(self.layers as i64) as usize).any(|layer| {
            rows.clone().any(|row| {
                let at = (layer * self.rows + row) * self.words;
                columns.clone().any(|column| self.seen[at + column / 64] >> (column % 64) & 1 == 1)
            })
        })
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
