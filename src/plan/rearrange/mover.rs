//! Moves of one body to a free place: pick-and-place, or a drag along a path.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use super::table::{Layout, Table};
use crate::action::{Move, MoveCosts};
use crate::error::Result;
use crate::geom::{Frame, Pose2, normalize_angle};
use crate::motion::{Enclosure, PathLimits, PathParams, PathPlanner, PathScratch, Region};
use crate::run::{Key, Stop};
use crate::scene::{Mask, Rearrangement, State};

/// The table with the means to move its bodies.
#[derive(Debug)]
pub struct Mover {
    pub table: Table,
    pub costs: MoveCosts,
    paths: Arc<PathPlanner>,
}

/// Working memory of one worker.
#[derive(Debug, Default)]
pub struct MoverScratch {
    paths: PathScratch,
    /// A state in which some bodies are absent.
    state: State,
}

/// Distance of the frames along a corridor in cells of the grid of paths, by the metric of drags.
const CORRIDOR_STEP: f64 = 4.0 / 3.0;
/// Iterations spent on a corridor: it is a guide, not a move.
const CORRIDOR_ITERATIONS: u32 = 100;

impl Mover {
    /// Prepares the scene of a problem.
    pub fn new(problem: &Rearrangement, paths: PathParams, costs: MoveCosts) -> Result<Mover> {
        let table = Table::new(problem, paths.clearance);
        let paths = PathParams { turn_weight: costs.turn, ..paths };
        Ok(Mover { table, costs, paths: Arc::new(PathPlanner::new(Arc::clone(&problem.scene), paths)?) })
    }

    /// Estimated bytes of the paths that are kept.
    pub fn memory_bytes(&self) -> usize {
        self.paths.memory_bytes()
    }

    /// Keeps paths in no more than so many bytes.
    pub fn limit_bytes(&self, most: Option<usize>) {
        self.paths.limit_bytes(most);
    }

    /// The means for another problem on the same table.
    pub fn with_table(&self, table: Table) -> Mover {
        Mover { table, costs: self.costs, paths: Arc::clone(&self.paths) }
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
            let waypoints = self.path(scratch, &layout.state, body, to, None, stop)?;
            return Some(Move::Drag { body, waypoints });
        }
        Some(Move::PickPlace { body, pick: layout.pose(body), place: to })
    }

    /// Drops the places that the body certainly cannot be brought to.
    pub fn retain_reachable(
        &self,
        scratch: &mut MoverScratch,
        layout: &Layout,
        body: usize,
        places: &mut Vec<(f64, Pose2)>,
        stop: &Stop,
    ) {
        if self.table.drag_only.contains(body) && !places.is_empty() {
            self.paths.retain_reachable(&layout.state, body, places, |place| place.1, Some(stop), &mut scratch.paths);
        }
    }

    /// Whether `body`, which can only be dragged, certainly cannot be brought to its goal if of all others only `staying` are
    /// there.
    pub fn enclosure(
        &self,
        scratch: &mut MoverScratch,
        layout: &Layout,
        body: usize,
        staying: &[usize],
        stop: &Stop,
    ) -> Enclosure {
        let Some(goal) = self.table.goal(body) else { return Enclosure::Unknown };
        let mut state = std::mem::take(&mut scratch.state);
        state.clone_from(&layout.state);
        (0..self.table.len()).filter(|other| *other != body && !staying.contains(other)).for_each(|other| {
            state.set_present(other, false);
        });
        // One region for each turn of the body that looks the same, or one for any heading.
        let turns = goal.symmetry.max(1);
        let heading = if goal.symmetry == 0 { PI } else { goal.rotation_tolerance };
        let regions: Vec<Region> = (0..turns)
            .map(|turn| {
                let theta = goal.pose.theta + TAU * f64::from(turn) / f64::from(turns);
                Region { pose: Pose2 { theta, ..goal.pose }, position: goal.position_tolerance, heading }
            })
            .collect();
        let found = self.paths.enclosure(&state, body, &regions, stop, &mut scratch.paths);
        scratch.state = state;
        found
    }

    /// A path of `body` to `to` as if the bodies of `without` were not there, if one is found soon.
    pub fn path_without(
        &self,
        scratch: &mut MoverScratch,
        layout: &Layout,
        body: usize,
        to: Pose2,
        without: Mask,
        stop: &Stop,
    ) -> Option<Arc<[Pose2]>> {
        let mut state = std::mem::take(&mut scratch.state);
        state.clone_from(&layout.state);
        without.iter().filter(|&other| other != body).for_each(|other| state.set_present(other, false));
        let path = self.path(scratch, &state, body, to, Some(CORRIDOR_ITERATIONS), stop);
        scratch.state = state;
        path
    }

    fn path(
        &self,
        scratch: &mut MoverScratch,
        state: &State,
        body: usize,
        to: Pose2,
        iterations: Option<u32>,
        stop: &Stop,
    ) -> Option<Arc<[Pose2]>> {
        let limits = PathLimits { iterations, stop: Some(stop) };
        // One key for all: the same question has the same answer, wherever it is asked.
        let found = self.paths.path(state, body, &state.pose(body), &to, limits, Key::new(0), &mut scratch.paths);
        found.path().map(|path| path.waypoints.as_slice().into())
    }

    /// Frames along a path of a body, close to each other.
    pub fn frames_along(&self, body: usize, path: &[Pose2], out: &mut Vec<Frame>) {
        let step = CORRIDOR_STEP * self.paths.cell(body);
        out.extend(path.first().map(Pose2::frame));
        for pair in path.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let turn = normalize_angle(b.theta - a.theta);
            let steps = (self.costs.distance(&a, &b) / step).ceil().max(1.0);
            for step in 1..=steps as u32 {
                let t = f64::from(step) / steps;
                let pose = Pose2::new(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.theta + t * turn);
                out.push(pose.frame());
            }
        }
    }
}
