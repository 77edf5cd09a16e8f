//! The path planner: what a caller sees.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use super::connect::{Connect, Ended, World};
use super::params::{MIN_CLEARANCE, PathParams, SWEEP_SLACK, room};
use super::reach::{Cells, Reach};
use super::shape::MovingShape;
use super::sweep::{Motion, Obstacles, is_inside};
use crate::error::Result;
use crate::geom::{Pose2, normalize_angle};
use crate::run::{Key, Stop};
use crate::scene::{Mask, Scene, State};

/// A path of one body: straight motions from each waypoint to the next, turning the shorter way round.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// The first is the pose the path begins at, the last the one asked for. At least two.
    pub waypoints: Vec<Pose2>,
    /// Metres: translation plus [`PathParams::turn_weight`] times the angle turned.
    pub length: f64,
}

/// The answer to a path query.
#[derive(Debug, Clone, PartialEq)]
pub enum PathOutcome {
    /// A path along which the clearance is kept, less at most [`super::SWEEP_SLACK`].
    Found(Arc<Path>),
    /// Certainly there is none: one of its ends is not free, or whatever way the body takes, it does not get from the
    /// one to the other.
    Enclosed,
    /// None was found within the iterations.
    NotFound,
    /// The work was asked to end.
    Interrupted,
}

impl PathOutcome {
    /// The path, if one was found.
    pub fn path(&self) -> Option<&Arc<Path>> {
        match self {
            PathOutcome::Found(path) => Some(path),
            _ => None,
        }
    }
}

/// What ends a query. Results are the same for the same number of iterations; a stop only makes `Interrupted`.
#[derive(Debug, Clone, Copy, Default)]
pub struct PathLimits<'a> {
    /// Iterations of RRT-Connect; `None` for [`PathParams::iterations`].
    pub iterations: Option<u32>,
    /// Polled while the search runs.
    pub stop: Option<&'a Stop>,
}

/// Working memory of one thread. Holds no results that could change an answer; any planner may use it.
#[derive(Debug, Default)]
pub struct PathScratch {
    pub(super) obstacles: Obstacles,
    connect: Connect,
    pub(super) reach: Reach,
    guide: Reach,
}

impl PathScratch {
    pub fn new() -> Self {
        Self::default()
    }
}

/// Results that are kept by each part of the cache before it is emptied.
const CACHED: usize = 1 << 13;
const PARTS: usize = 16;

/// Answers what one body of a scene can do among the others. Shared by all threads; each brings its own
/// [`PathScratch`]. An answer is a function of the question and its key alone.
#[derive(Debug)]
pub struct PathPlanner {
    scene: Arc<Scene>,
    params: PathParams,
    shapes: Vec<MovingShape>,
    /// For each body, the parameters with the lengths that fit it and the room.
    fitted: Vec<PathParams>,
    room: f64,
    /// Tells the scenes apart for a scratch that serves several.
    fingerprint: u64,
    cache: [Mutex<Known>; PARTS],
    /// Estimated bytes that each part may hold.
    most_bytes: AtomicUsize,
}

/// A part of the results that are kept.
#[derive(Debug, Default)]
struct Known {
    outcomes: HashMap<u128, PathOutcome>,
    /// Estimated.
    bytes: usize,
}

impl Known {
    fn keep(&mut self, name: u128, outcome: PathOutcome, most_bytes: usize) {
        let waypoints = outcome.path().map_or(0, |path| size_of::<Path>() + size_of_val(path.waypoints.as_slice()));
        // The table holds a byte an entry beside it, and room for as many again.
        let bytes = 2 * (size_of::<(u128, PathOutcome)>() + 1) + waypoints;
        if self.outcomes.len() >= CACHED || self.bytes + bytes > most_bytes {
            *self = Known::default();
        }
        if bytes <= most_bytes && self.outcomes.insert(name, outcome).is_none() {
            self.bytes += bytes;
        }
    }
}

impl PathPlanner {
    /// Prepares the shapes of a scene.
    pub fn new(scene: Arc<Scene>, params: PathParams) -> Result<PathPlanner> {
        params.validate().map_err(|e| e.within("paths"))?;
        let shapes: Vec<MovingShape> = scene.bodies().iter().map(|b| MovingShape::new(&b.footprint)).collect();
        let mut hash = Hash::new(shapes.len() as u64);
        for shape in &shapes {
            for core in &shape.cores {
                core.points.iter().for_each(|p| hash.add_pair(p.x.to_bits(), p.y.to_bits()));
                hash.add(core.rounding.to_bits());
            }
        }
        let fingerprint = hash.low;
        let room = room(scene.workspace());
        let fitted = shapes.iter().map(|shape| params.fitted(room, shape.width)).collect();
        Ok(PathPlanner {
            scene,
            params,
            shapes,
            fitted,
            room,
            fingerprint,
            cache: Default::default(),
            most_bytes: usize::MAX.into(),
        })
    }

    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// Estimated bytes that the results kept take.
    pub fn memory_bytes(&self) -> usize {
        self.cache.iter().map(|part| part.lock().unwrap_or_else(PoisonError::into_inner).bytes).sum()
    }

    /// Keeps results in no more than so many bytes from now on; those kept already stay until then. No answer depends on
    /// it.
    pub fn limit_bytes(&self, most: Option<usize>) {
        self.most_bytes.store(most.map_or(usize::MAX, |most| most / PARTS), Ordering::Relaxed);
    }

    pub fn params(&self) -> &PathParams {
        &self.params
    }

    /// How fine the grid of a body is: the edge of a cell, metres.
    pub fn cell(&self, body: usize) -> f64 {
        self.fitted[body].cell
    }

    pub(super) fn shape(&self, body: usize) -> &MovingShape {
        &self.shapes[body]
    }

    pub(super) fn fitted(&self, body: usize) -> &PathParams {
        &self.fitted[body]
    }

    /// The length of a path by the metric, metres.
    pub fn length(&self, waypoints: &[Pose2]) -> f64 {
        waypoints.windows(2).map(|w| self.params.length(&w[0], &w[1])).sum()
    }

    /// Whether the whole footprint lies within the workspace, whatever the workspace's rule for leaving is.
    pub fn is_inside(&self, body: usize, pose: &Pose2) -> bool {
        is_inside(&self.shapes[body], self.scene.workspace(), pose)
    }

    /// Whether a body at a pose lies within the workspace and keeps the clearance from all others that are present.
    pub fn pose_is_free(&self, state: &State, body: usize, pose: &Pose2, scratch: &mut PathScratch) -> bool {
        if !self.is_inside(body, pose) {
            return false;
        }
        self.place(state, body, scratch);
        scratch.obstacles.keep(self.params.clearance);
        scratch.obstacles.is_free(&self.shapes[body], pose, 0.5 * SWEEP_SLACK)
    }

    /// The gap between a body at a pose and the nearest other one where it is less than `limit`, else `limit`; metres,
    /// negative where they overlap.
    pub fn pose_gap(&self, state: &State, body: usize, pose: &Pose2, limit: f64, scratch: &mut PathScratch) -> f64 {
        self.place(state, body, scratch);
        scratch.obstacles.gap(&self.shapes[body], pose, limit)
    }

    /// The bodies that are nearer than the clearance to a body at a pose.
    pub fn blockers(&self, state: &State, body: usize, pose: &Pose2, scratch: &mut PathScratch) -> Mask {
        self.place(state, body, scratch);
        scratch.obstacles.keep(self.params.clearance);
        scratch.obstacles.blockers(&self.shapes[body], pose, 0.5 * SWEEP_SLACK)
    }

    /// Whether the straight motion keeps the clearance and stays within the workspace throughout. Nothing is sampled.
    pub fn motion_is_free(&self, state: &State, body: usize, a: &Pose2, b: &Pose2, scratch: &mut PathScratch) -> bool {
        self.place(state, body, scratch);
        scratch.obstacles.keep(self.params.clearance);
        self.world(body, &mut scratch.obstacles).is_free(a, b)
    }

    /// How far a body gets on a straight motion: the fraction of it through which the clearance is kept, less a
    /// millimetre where something is in the way, so that the body can go on from there. 0 where it gets nowhere.
    /// From bodies that it stands nearer to at the start it keeps that smaller gap.
    pub fn free_fraction(&self, state: &State, body: usize, a: &Pose2, b: &Pose2, scratch: &mut PathScratch) -> f64 {
        self.place(state, body, scratch);
        if !scratch.obstacles.keep_as_at(&self.shapes[body], self.params.clearance, [a, a]) {
            return 0.0;
        }
        self.world(body, &mut scratch.obstacles).advance(&Motion::new(a, b))
    }

    /// Keeps the items whose poses a body can be brought to from where it stands, as the grid shows it: a guess that is
    /// seldom wrong. One map serves all items. The poses are taken to keep the clearance. Asked to end, it keeps all.
    pub fn retain_reachable<T>(
        &self,
        state: &State,
        body: usize,
        items: &mut Vec<T>,
        pose: impl Fn(&T) -> Pose2,
        stop: Option<&Stop>,
        scratch: &mut PathScratch,
    ) {
        self.place(state, body, scratch);
        let (shape, workspace) = (&self.shapes[body], self.scene.workspace());
        let PathScratch { obstacles, reach, .. } = scratch;
        let from = state.pose(body);
        if !obstacles.keep_as_at(shape, self.params.clearance, [&from, &from]) {
            items.clear();
        } else if reach.make(Cells::NotBlocked, shape, obstacles, workspace, &self.fitted[body], &from, stop) {
            items.retain(|item| {
                let to = pose(item);
                reach.holds(to.transform_point(shape.middle), to.theta)
            });
        }
    }

    /// A path of a body from a pose to another among the others as they stand in `state` (where it stands itself does
    /// not matter). The straight motion if that is free; else what RRT-Connect or the grid's way gives, shortened.
    #[allow(clippy::too_many_arguments)]
    pub fn path(
        &self,
        state: &State,
        body: usize,
        from: &Pose2,
        to: &Pose2,
        limits: PathLimits,
        key: Key,
        scratch: &mut PathScratch,
    ) -> PathOutcome {
        let iterations = limits.iterations.unwrap_or(self.params.iterations);
        let others = self.others(state, body);
        let mut hash = Hash::new(others.low);
        hash.add_pair(others.high, key.bits());
        hash.add_pair(body as u64, u64::from(iterations));
        for v in [from.x, from.y, from.theta, to.x, to.y, to.theta] {
            hash.add(v.to_bits());
        }
        let part = &self.cache[hash.low as usize % PARTS];
        let name = u128::from(hash.low) << 64 | u128::from(hash.high);
        if let Some(known) = part.lock().unwrap_or_else(PoisonError::into_inner).outcomes.get(&name) {
            return known.clone();
        }
        scratch.obstacles.place(&self.shapes, state, body, others.low);
        let outcome = self.search(body, from, to, iterations, limits.stop, Key::from_bits(hash.high), scratch);
        if outcome != PathOutcome::Interrupted {
            let most = self.most_bytes.load(Ordering::Relaxed);
            part.lock().unwrap_or_else(PoisonError::into_inner).keep(name, outcome.clone(), most);
        }
        outcome
    }

    #[allow(clippy::too_many_arguments)]
    fn search(
        &self,
        body: usize,
        from: &Pose2,
        to: &Pose2,
        iterations: u32,
        stop: Option<&Stop>,
        key: Key,
        scratch: &mut PathScratch,
    ) -> PathOutcome {
        let (shape, workspace) = (&self.shapes[body], self.scene.workspace());
        let PathScratch { obstacles, connect, reach, guide } = scratch;
        let normal = |p: &Pose2| Pose2::new(p.x, p.y, normalize_angle(p.theta));
        let (from, to) = (&normal(from), &normal(to));
        if !from.is_finite()
            || !to.is_finite()
            || !is_inside(shape, workspace, from)
            || !is_inside(shape, workspace, to)
            || !obstacles.keep_as_at(shape, self.params.clearance, [from, to])
        {
            return PathOutcome::Enclosed;
        }
        let params = &self.fitted[body];
        let mut world = World { shape, workspace, params, room: self.room, obstacles };
        if world.is_free(from, to) {
            return self.found(&[*from, *to]);
        }
        let mut random = key.stream();
        connect.start(*from, *to);
        let quick = self.params.quick_iterations.min(iterations);
        let mut ended = connect.search(&mut world, quick, None, stop, &mut random);
        if ended == Ended::UsedUp {
            if stop.is_some_and(Stop::requested) {
                return PathOutcome::Interrupted;
            }
            let known = reach.make(Cells::NotBlocked, shape, world.obstacles, workspace, params, from, stop);
            if known && !reach.holds(to.transform_point(shape.middle), to.theta) {
                return PathOutcome::Enclosed;
            }
            let mut rest = iterations - quick;
            let shown = rest > 0
                && guide.make(Cells::FreeMiddle, shape, world.obstacles, workspace, params, from, stop)
                && guide.trace(shape, from, to, &mut connect.way, stop);
            if stop.is_some_and(Stop::requested) {
                return PathOutcome::Interrupted;
            }
            if !shown {
                // Hardly any path is left that the grid does not show.
                rest /= 4;
            } else if connect.follow_way(&mut world, *from, *to) {
                connect.shorten(&mut world, &mut random);
                return self.found(&connect.path);
            }
            ended = connect.search(&mut world, rest, known.then_some(reach), stop, &mut random);
        }
        match ended {
            Ended::UsedUp => PathOutcome::NotFound,
            Ended::Stopped => PathOutcome::Interrupted,
            Ended::Found => {
                connect.shorten(&mut world, &mut random);
                self.found(&connect.path)
            }
        }
    }

    fn found(&self, waypoints: &[Pose2]) -> PathOutcome {
        PathOutcome::Found(Arc::new(Path { waypoints: waypoints.to_vec(), length: self.length(waypoints) }))
    }

    pub(super) fn world<'a>(&'a self, body: usize, obstacles: &'a mut Obstacles) -> World<'a> {
        let (shape, params) = (&self.shapes[body], &self.fitted[body]);
        World { shape, workspace: self.scene.workspace(), params, room: self.room, obstacles }
    }

    pub(super) fn place(&self, state: &State, body: usize, scratch: &mut PathScratch) {
        let hash = self.others(state, body).low;
        scratch.obstacles.place(&self.shapes, state, body, hash);
    }

    /// A hash of the exact bits of the poses of the present bodies but one.
    fn others(&self, state: &State, body: usize) -> Hash {
        let mut hash = Hash::new(self.fingerprint);
        for other in state.present().iter().filter(|other| *other != body) {
            let Some(pose) = state.poses().get(other) else { break };
            let place = u64::from(pose.x.to_bits()) << 32 | u64::from(pose.y.to_bits());
            hash.add_pair(place, u64::from(pose.theta.to_bits()) << 32 | other as u64);
        }
        hash
    }
}

/// Two independent 64-bit hashes.
#[derive(Debug, Clone, Copy)]
struct Hash {
    low: u64,
    high: u64,
}

impl Hash {
    fn new(seed: u64) -> Hash {
        let key = Key::new(seed);
        Hash { low: key.bits(), high: key.child(1).bits() }
    }

    fn add(&mut self, value: u64) {
        self.low = Key::from_bits(self.low).child(value).bits();
        self.high = Key::from_bits(self.high).child(!value).bits();
    }

    fn add_pair(&mut self, a: u64, b: u64) {
        self.add(a);
        self.add(b);
    }
}

const _: () = assert!(MIN_CLEARANCE > SWEEP_SLACK);
