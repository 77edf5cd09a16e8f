//! One attempt of `untangle`, a planner of our own: bodies go home as soon as they can; where they wait in a circle,
//! one that breaks the circle is put aside.
//!
//! What is put aside is drawn from the least feedback sets of the dependency graph ([`super::graph`]), and where, from
//! many free places by what they would block: a place on the goal of a body that must move before the waiting body can
//! go home makes a new circle, one on another goal only an order. So waiting places are as good as chosen late, as in
//! TRLB (Gao et al. 2022). A body that can only be dragged has a corridor, its path if those that can move were not
//! there; what stands in the corridor is in its way like what stands on its goal.

use std::sync::Arc;

use super::feedback::Feedback;
use super::graph::Graph;
use super::mover::{Mover, MoverScratch};
use super::room::RoomMaker;
use super::samplers::{anywhere, direct, tiles};
use super::shorten::Shortener;
use super::table::{Layout, stored};
use crate::action::Move;
use crate::geom::{Frame, Pose2, footprints_apart};
use crate::run::{Stop, Stream};
use crate::scene::{Mask, PLACE_SLACK};

/// Places drawn for a body that is put aside: anywhere, and near where it is.
const ANYWHERE: usize = 48;
const NEARBY: usize = 12;
/// Spread of the latter, metres on a table of room 1 and radians.
const NEAR: (f64, f64) = (0.08, 0.6);
/// Steps by which a drawn place is moved out of the bodies it overlaps.
const RELAXATIONS: usize = 6;
/// Bodies tried before an attempt is given up; how many of them are chosen by the graph, the others being any; and for
/// each that is dragged, places tried by a path.
const BODIES: usize = 8;
const CHOSEN: usize = 4;
const PATHS: usize = 3;
/// Bodies for which room is tried to be made, and the chance that it is at the body's goal.
const ROOMS: usize = 3;
const ROOM_AT_GOAL: f64 = 0.7;
/// What a place costs: for each goal or corridor that it blocks with and without a circle, per metre of detour on a table
/// of room 1, and at random.
const CIRCLE: f64 = 1.0;
const ORDER: f64 = 0.1;
const DETOUR: f64 = 0.3;
const NOISE: f64 = 0.2;
/// Chances: that the body put aside is from a least feedback set, else from a circle or in somebody's way, else any.
const FROM_SET: f64 = 0.75;
const FROM_CIRCLE: f64 = 0.8;
/// That a place is any free one instead of the best.
const ANY_PLACE: f64 = 0.1;

/// Working memory of one worker.
#[derive(Debug, Default)]
pub struct Worker {
    mover: MoverScratch,
    /// Where the attempt is; after it, where its moves lead.
    pub layout: Layout,
    /// The moves of the attempt.
    pub moves: Vec<Move>,
    graph: Graph,
    feedback: Feedback,
    /// Path of each body that can only be dragged, as frames close to each other; empty where there is none.
    corridors: Vec<Vec<Frame>>,
    places: Vec<(f64, Pose2)>,
    order: Vec<usize>,
    shortener: Shortener,
    room: RoomMaker,
}

/// How far an attempt goes and what it may do.
#[derive(Debug, Clone, Copy)]
pub struct Course {
    /// Most moves.
    pub limit: usize,
    /// It ends once it has put a body aside and made this many moves.
    pub soon: usize,
    /// Chance that it makes room where nobody can go home, instead of putting a body aside.
    pub room: f64,
}

impl Course {
    /// All the way.
    pub fn whole(limit: usize) -> Course {
        Course { limit, soon: usize::MAX, room: 0.0 }
    }
}

/// A tighter or looser way to go about an attempt, drawn for each.
#[derive(Debug, Clone, Copy)]
struct Manner {
    /// Bodies do not go home into somebody's corridor while anything else can be done.
    wary: bool,
}

/// Attempts moves from `start` that lead every body home; false without.
pub fn attempt(
    mover: &Mover,
    worker: &mut Worker,
    start: &Layout,
    course: Course,
    stream: &mut Stream,
    stop: &Stop,
) -> bool {
    worker.moves.clear();
    worker.layout.clone_from(start);
    let manner = Manner { wary: stream.chance(0.5) };
    while !stop.requested() {
        if worker.go_home(mover, manner, stream, stop) {
            continue;
        }
        let misplaced = mover.table.misplaced(&worker.layout.state);
        if misplaced.is_empty() {
            worker.shortener.shorten(mover, &mut worker.mover, start, &mut worker.moves, stop);
            return worker.moves.len() <= course.limit;
        }
        if worker.moves.len() + worker.bound(mover, misplaced, stop) > course.limit {
            return false;
        }
        if course.room > 0.0
            && stream.chance(course.room)
            && worker.make_room(mover, misplaced, course.limit, stream, stop)
        {
            continue;
        }
        if !worker.put_aside(mover, misplaced, stream, stop) || worker.moves.len() >= course.soon {
            return false;
        }
    }
    false
}

/// No plan from here has fewer moves.
pub fn lower_bound(mover: &Mover, layout: &Layout, stop: &Stop) -> usize {
    let mut worker = Worker { layout: layout.clone(), ..Worker::default() };
    let misplaced = mover.table.misplaced(&layout.state);
    worker.bound(mover, misplaced, stop)
}

/// Least robot time of any plan from here that brings each body to its goal's pose, seconds: every misplaced body goes
/// there straight.
pub fn least_seconds(mover: &Mover, layout: &Layout) -> f64 {
    let straight = |body: usize| {
        let from = layout.pose(body);
        let to = mover.table.goal_pose(body, &from)?;
        Some(match mover.table.drag_only.contains(body) {
            true => Move::Drag { body, waypoints: [from, to].into() },
            false => Move::PickPlace { body, pick: from, place: to },
        })
    };
    mover.table.misplaced(&layout.state).iter().filter_map(straight).map(|action| mover.costs.seconds(&action)).sum()
}

impl Worker {
    fn bound(&mut self, mover: &Mover, misplaced: Mask, stop: &Stop) -> usize {
        self.graph.clear(mover.table.len());
        for body in misplaced.iter() {
            let blockers = mover.table.goal_blockers(&self.layout, body);
            self.graph.set(body, blockers & misplaced);
        }
        self.graph.close();
        self.feedback.find(&self.graph, stop);
        misplaced.count() + self.feedback.at_least
    }

    fn make(&mut self, action: Move) {
        self.layout.place(action.body(), action.to());
        self.moves.push(action);
    }

    /// Brings one body home; false if none can go.
    fn go_home(&mut self, mover: &Mover, manner: Manner, stream: &mut Stream, stop: &Stop) -> bool {
        let table = &mover.table;
        let misplaced = table.misplaced(&self.layout.state) & table.movable;
        self.order.clear();
        self.order.extend(misplaced.iter());
        stream.shuffle(&mut self.order);
        // Those that are dragged first: what is placed later may stand in their way.
        self.order.sort_by_key(|&body| !table.drag_only.contains(body));
        let waiting = !(misplaced & table.drag_only).is_empty();
        if waiting && manner.wary {
            self.find_corridors(mover, misplaced, stop);
        }
        for index in 0..self.order.len() {
            let body = self.order[index];
            if stop.requested() {
                return false;
            }
            let Some(place) = direct(table, &self.layout, body) else { continue };
            let dragged = table.drag_only.contains(body);
            if waiting && manner.wary && !dragged && self.corridors_at(mover, body, &place.pose) != Mask::EMPTY {
                continue;
            }
            if let Some(action) = mover.attempt(&mut self.mover, &self.layout, body, place.pose, stop) {
                self.make(action);
                return true;
            }
        }
        false
    }

    /// The corridors of misplaced bodies that can only be dragged.
    fn find_corridors(&mut self, mover: &Mover, misplaced: Mask, stop: &Stop) {
        let table = &mover.table;
        self.corridors.resize_with(table.len(), Vec::new);
        self.corridors.iter_mut().for_each(Vec::clear);
        for body in (misplaced & table.drag_only).iter() {
            let Some(goal) = table.goal_pose(body, &self.layout.pose(body)) else { continue };
            let pickable = table.movable.without(table.drag_only);
            let path = mover
                .path_without(&mut self.mover, &self.layout, body, goal, pickable, stop)
                .or_else(|| mover.path_without(&mut self.mover, &self.layout, body, goal, table.movable, stop));
            if let Some(path) = path {
                mover.frames_along(body, &path, &mut self.corridors[body]);
            }
        }
    }

    /// The bodies whose corridors `body` would stand in at `pose`.
    fn corridors_at(&self, mover: &Mover, body: usize, pose: &Pose2) -> Mask {
        let mut mask = Mask::EMPTY;
        let frame = pose.frame();
        let footprint = mover.table.footprint(body);
        for (owner, corridor) in self.corridors.iter().enumerate().filter(|(owner, _)| *owner != body) {
            let other = mover.table.footprint(owner);
            if corridor.iter().any(|at| !footprints_apart(footprint, &frame, other, at, mover.table.clearance)) {
                mask.insert(owner);
            }
        }
        mask
    }

    /// The graph of goals and corridors; not all of it where the work was asked to end.
    pub fn find_graph(&mut self, mover: &Mover, misplaced: Mask, stop: &Stop) {
        let table = &mover.table;
        self.find_corridors(mover, misplaced, stop);
        self.graph.clear(table.len());
        for body in misplaced.iter() {
            if stop.requested() {
                return;
            }
            let mut blockers = table.goal_blockers(&self.layout, body);
            for other in table.movable.iter().filter(|&other| other != body) {
                let (footprint, frame) = (table.footprint(other), self.layout.pose(other).frame());
                let own = table.footprint(body);
                let blocks = |at: &Frame| !footprints_apart(own, at, footprint, &frame, table.clearance);
                if !blockers.contains(other) && self.corridors[body].iter().any(blocks) {
                    blockers.insert(other);
                }
            }
            self.graph.set(body, blockers & table.movable);
        }
        self.graph.close();
        self.feedback.find(&self.graph, stop);
    }

    /// Moves a body out of the way; false if none was found that can be.
    fn put_aside(&mut self, mover: &Mover, misplaced: Mask, stream: &mut Stream, stop: &Stop) -> bool {
        self.find_graph(mover, misplaced, stop);
        for index in 0..BODIES {
            let any = index >= CHOSEN;
            if stop.requested() {
                return false;
            }
            let Some(body) = self.whom(mover, misplaced, any, stream) else { return false };
            if let Some(action) = self.aside(mover, body, misplaced, stream, stop) {
                self.make(action);
                return true;
            }
        }
        false
    }

    /// Makes room for a misplaced body at its goal, or for one anywhere.
    fn make_room(&mut self, mover: &Mover, misplaced: Mask, limit: usize, stream: &mut Stream, stop: &Stop) -> bool {
        let table = &mover.table;
        let waiting = misplaced & table.movable;
        if waiting.is_empty() {
            return false;
        }
        (0..ROOMS).any(|_| {
            let body = waiting.iter().nth(stream.index(waiting.count())).unwrap_or_default();
            let goal = table.goal_pose(body, &self.layout.pose(body)).filter(|_| stream.chance(ROOM_AT_GOAL));
            let pose = goal.unwrap_or_else(|| stored(anywhere(table, body, stream)));
            let left = limit.saturating_sub(self.moves.len());
            let made = (&mut self.layout, &mut self.moves);
            self.room.make_room(mover, &mut self.mover, made, body, pose, left, stop)
        })
    }

    /// Which body to put aside.
    fn whom(&self, mover: &Mover, misplaced: Mask, any: bool, stream: &mut Stream) -> Option<usize> {
        let draw = |mask: Mask, stream: &mut Stream| mask.iter().nth(stream.index(mask.count()));
        if !any && !self.feedback.sets.is_empty() && stream.chance(FROM_SET) {
            let set = self.feedback.sets[stream.index(self.feedback.sets.len())];
            return draw(set, stream);
        }
        if !any && stream.chance(FROM_CIRCLE) {
            let cyclic = self.graph.cyclic();
            let mask = if cyclic.is_empty() || stream.chance(0.5) { self.in_the_way(misplaced) } else { cyclic };
            if !mask.is_empty() {
                return draw(mask, stream);
            }
        }
        draw(mover.table.movable, stream)
    }

    /// A move of `body` to a place where it can wait.
    fn aside(&mut self, mover: &Mover, body: usize, misplaced: Mask, stream: &mut Stream, stop: &Stop) -> Option<Move> {
        let table = &mover.table;
        let now = self.layout.pose(body);
        // A body in somebody's way that is at its goal only within the tolerance goes exactly there.
        if !misplaced.contains(body)
            && let Some(place) = direct(table, &self.layout, body)
            && place.pose != now
            && stream.chance(0.5)
        {
            return mover.attempt(&mut self.mover, &self.layout, body, place.pose, stop);
        }
        let any = stream.chance(ANY_PLACE);
        self.rank_places(mover, body, misplaced, any, stream, stop);
        let tried = if table.drag_only.contains(body) { PATHS } else { 1 };
        for index in 0..self.places.len().min(tried) {
            let pose = self.places[index].1;
            let action = mover.attempt(&mut self.mover, &self.layout, body, pose, stop);
            if action.is_some() {
                return action;
            }
        }
        None
    }

    /// Free places for `body`, the best first or, with `any`, in an order of their detours alone; none where the work was
    /// asked to end. The graph must have been found.
    pub fn rank_places(
        &mut self,
        mover: &Mover,
        body: usize,
        misplaced: Mask,
        any: bool,
        stream: &mut Stream,
        stop: &Stop,
    ) {
        let table = &mover.table;
        let now = self.layout.pose(body);
        self.find_places(mover, body, stream, stop);
        let home = table.goal_pose(body, &now).unwrap_or(now);
        let straight = (home.position() - now.position()).norm();
        for index in 0..self.places.len() {
            if stop.requested() {
                self.places.clear();
                return;
            }
            let pose = self.places[index].1;
            let detour =
                (pose.position() - now.position()).norm() + (home.position() - pose.position()).norm() - straight;
            let blocking = if any { 0.0 } else { self.blocking(mover, body, &pose, misplaced) };
            self.places[index].0 = blocking + DETOUR * detour / table.room + NOISE * stream.unit();
        }
        self.places.sort_by(|a, b| a.0.total_cmp(&b.0));
    }

    /// The places found last, with what each costs.
    pub fn places(&self) -> &[(f64, Pose2)] {
        &self.places
    }

    /// Moves that lead every body home from `start`, without those that can be done without.
    pub fn shorten(&mut self, mover: &Mover, start: &Layout, mut moves: Vec<Move>, stop: &Stop) -> Vec<Move> {
        self.shortener.shorten(mover, &mut self.mover, start, &mut moves, stop);
        moves
    }

    /// Bodies that keep a misplaced one from going home.
    pub fn in_the_way(&self, misplaced: Mask) -> Mask {
        misplaced.iter().fold(Mask::EMPTY, |mask, body| mask | self.graph.blockers(body))
    }

    /// A move of `body` in the layout as it is.
    pub fn attempt(&mut self, mover: &Mover, body: usize, to: Pose2, stop: &Stop) -> Option<Move> {
        mover.attempt(&mut self.mover, &self.layout, body, to, stop)
    }

    /// What a waiting place costs by what it would block.
    fn blocking(&self, mover: &Mover, body: usize, pose: &Pose2, misplaced: Mask) -> f64 {
        let table = &mover.table;
        let first = self.graph.reach(body);
        let frame = pose.frame();
        let mut cost = 0.0;
        let corridors = self.corridors_at(mover, body, pose);
        for other in misplaced.iter().filter(|&other| other != body) {
            let Some(goal) = table.goal_pose(other, &self.layout.pose(other)) else { continue };
            let apart =
                |gap| footprints_apart(table.footprint(body), &frame, table.footprint(other), &goal.frame(), gap);
            if !apart(-PLACE_SLACK) || corridors.contains(other) {
                // A body that has no goal to go to must be moved once more, for nothing.
                let circle = first.contains(other) || table.goal(body).is_none();
                cost += if circle { CIRCLE } else { ORDER };
            }
        }
        cost
    }

    /// Free places for `body`.
    fn find_places(&mut self, mover: &Mover, body: usize, stream: &mut Stream, stop: &Stop) {
        let table = &mover.table;
        let now = self.layout.pose(body);
        self.places.clear();
        for draw in 0..ANYWHERE + NEARBY {
            if stop.requested() {
                return;
            }
            let mut pose = anywhere(table, body, stream);
            if draw >= ANYWHERE {
                let (x, y, turn) = (stream.normal(), stream.normal(), stream.normal());
                let near = NEAR.0 * table.room;
                pose = Pose2::new(now.x + near * x, now.y + near * y, now.theta + NEAR.1 * turn);
            }
            if let Some(pose) = relaxed(mover, &self.layout, body, pose) {
                self.places.push((0.0, pose));
            }
        }
        let layout = &self.layout;
        let free = tiles(table, body).into_iter().filter(|pose| table.is_free(layout, body, pose));
        self.places.extend(free.map(|pose| (0.0, pose)));
        mover.retain_reachable(&mut self.mover, &self.layout, body, &mut self.places, stop);
    }
}

/// The pose, moved out of what it overlaps if that takes a few steps.
fn relaxed(mover: &Mover, layout: &Layout, body: usize, pose: Pose2) -> Option<Pose2> {
    /// Added to each step, metres, so that it does not end just short.
    const EXTRA: f64 = 1e-4;
    let table = &mover.table;
    let mut pose = stored(pose);
    for _ in 0..RELAXATIONS {
        if table.is_free(layout, body, &pose) {
            return Some(pose);
        }
        let (mut x, mut y) = (0.0, 0.0);
        for other in table.blockers(layout, body, &pose, table.clearance).iter() {
            let from = pose.position() - layout.pose(other).position();
            let distance = from.norm().max(1e-6);
            let depth = table.depth(layout, body, &pose, other, distance) + EXTRA;
            x += from.x / distance * depth;
            y += from.y / distance * depth;
        }
        pose = stored(table.brought_inside(body, Pose2::new(pose.x + x, pose.y + y, pose.theta)));
    }
    table.is_free(layout, body, &pose).then_some(pose)
}

/// The same moves backwards: from where they end to where they begin.
pub fn reversed(moves: &[Move]) -> Vec<Move> {
    let back = |action: &Move| match action {
        Move::PickPlace { body, pick, place } => Move::PickPlace { body: *body, pick: *place, place: *pick },
        Move::Drag { body, waypoints } => {
            let waypoints: Arc<[Pose2]> = waypoints.iter().rev().copied().collect();
            Move::Drag { body: *body, waypoints }
        }
    };
    moves.iter().rev().map(back).collect()
}
