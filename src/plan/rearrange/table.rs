//! The problem made ready for planning: which places are free, and what blocks the ones that are not.

use std::sync::Arc;

use crate::geom::{Footprint, Frame, Pose2, Shape, Vec2, convex_hull, footprints_apart, pieces_gap_below, vec2};
use crate::motion::room;
use crate::scene::{BodyPose, Goal, Mask, PLACE_SLACK, Rearrangement, State};

/// A state with the sine and cosine of every heading worked out.
#[derive(Debug, Default)]
pub struct Layout {
    pub state: State,
    frames: Vec<Frame>,
}

impl Clone for Layout {
    fn clone(&self) -> Self {
        Layout { state: self.state.clone(), frames: self.frames.clone() }
    }

    fn clone_from(&mut self, source: &Self) {
        self.state.clone_from(&source.state);
        self.frames.clone_from(&source.frames);
    }
}

impl Layout {
    pub fn new(state: &State) -> Self {
        let mut layout = Layout::default();
        layout.set(state);
        layout
    }

    /// Becomes the layout of `state`, in the memory it has.
    pub fn set(&mut self, state: &State) {
        self.state.clone_from(state);
        self.frames.clear();
        self.frames.extend((0..state.len()).map(|body| state.pose(body).frame()));
    }

    /// Moves one body.
    pub fn place(&mut self, body: usize, pose: Pose2) {
        self.state.set_pose(body, pose);
        self.frames[body] = self.state.pose(body).frame();
    }

    pub fn pose(&self, body: usize) -> Pose2 {
        self.state.pose(body)
    }

    pub fn frame(&self, body: usize) -> &Frame {
        &self.frames[body]
    }
}

/// The pose as a state stores it, so that a move ends exactly where the next one begins.
pub fn stored(pose: Pose2) -> Pose2 {
    BodyPose::from(pose).into()
}

/// The least rectangle round a footprint, one of whose sides lies along an edge of the hull.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundingBox {
    /// Direction of the first side in the body frame, radians.
    pub angle: f64,
    /// Extents along the first side and across it, metres.
    pub size: [f64; 2],
    /// Middle, in the body frame.
    pub middle: Vec2,
}

impl BoundingBox {
    fn of(footprint: &Footprint) -> BoundingBox {
        let points: Vec<Vec2> = footprint.outlines.iter().flatten().copied().collect();
        let hull = convex_hull(&points);
        let mut best = BoundingBox { angle: 0.0, size: [f64::INFINITY; 2], middle: vec2(0.0, 0.0) };
        for k in 0..hull.len() {
            let side = hull[(k + 1) % hull.len()] - hull[k];
            let angle = side.y.atan2(side.x);
            let u = vec2(angle.cos(), angle.sin());
            let v = vec2(-u.y, u.x);
            // The footprint's own support: a disc is no polygon.
            let (right, left) = (footprint.support(u), -footprint.support(-u));
            let (top, bottom) = (footprint.support(v), -footprint.support(-v));
            let size = [right - left, top - bottom];
            if size[0] * size[1] < best.size[0] * best.size[1] {
                best = BoundingBox { angle, size, middle: u * ((left + right) / 2.0) + v * ((bottom + top) / 2.0) };
            }
        }
        best
    }
}

/// A rearrangement problem with what its planners ask again and again.
#[derive(Debug)]
pub struct Table {
    pub problem: Rearrangement,
    /// Bodies that may be moved.
    pub movable: Mask,
    /// Bodies that can only be dragged.
    pub drag_only: Mask,
    /// Gap that sampled places keep from other bodies, metres.
    pub clearance: f64,
    pub boxes: Arc<[BoundingBox]>,
    /// The size of the room: lengths that were chosen on a table are in proportion to it.
    pub room: f64,
}

impl Table {
    pub fn new(problem: &Rearrangement, clearance: f64) -> Table {
        let scene = &problem.scene;
        let (mut movable, mut drag_only) = (Mask::EMPTY, Mask::EMPTY);
        for (index, body) in scene.bodies().iter().enumerate() {
            if body.movable() {
                movable.insert(index);
                if !body.pickable {
                    drag_only.insert(index);
                }
            }
        }
        let boxes = scene.bodies().iter().map(|body| BoundingBox::of(&body.footprint)).collect();
        Table { problem: problem.clone(), movable, drag_only, clearance, boxes, room: room(scene.workspace()) }
    }

    pub fn len(&self) -> usize {
        self.problem.scene.len()
    }

    pub fn footprint(&self, body: usize) -> &Footprint {
        &self.problem.scene.body(body).footprint
    }

    pub fn goal(&self, body: usize) -> Option<&Goal> {
        self.problem.goals[body].as_ref()
    }

    /// The pose to which a body at `pose` is brought at its goal.
    pub fn goal_pose(&self, body: usize, pose: &Pose2) -> Option<Pose2> {
        self.goal(body).map(|goal| stored(goal.nearest(pose)))
    }

    /// Bodies that are not at their goals.
    pub fn misplaced(&self, state: &State) -> Mask {
        let mut mask = Mask::EMPTY;
        for body in 0..self.len() {
            if !self.problem.at_goal(body, &state.pose(body)) {
                mask.insert(body);
            }
        }
        mask
    }

    /// The footprint lies in the workspace.
    pub fn inside(&self, body: usize, pose: &Pose2) -> bool {
        self.problem.scene.workspace().margin(self.footprint(body), pose) >= 0.0
    }

    /// The other bodies that come nearer than `gap` to `body` at `pose`.
    pub fn blockers(&self, layout: &Layout, body: usize, pose: &Pose2, gap: f64) -> Mask {
        let frame = pose.frame();
        let footprint = self.footprint(body);
        let mut mask = Mask::EMPTY;
        for other in 0..self.len() {
            if other != body && !footprints_apart(footprint, &frame, self.footprint(other), &layout.frames[other], gap)
            {
                mask.insert(other);
            }
        }
        mask
    }

    /// The bodies that overlap the body's goal.
    pub fn goal_blockers(&self, layout: &Layout, body: usize) -> Mask {
        match self.goal_pose(body, &layout.pose(body)) {
            Some(pose) => self.blockers(layout, body, &pose, -PLACE_SLACK),
            None => Mask::EMPTY,
        }
    }

    /// A place to put `body`: inside the workspace and at least the clearance from every other body.
    pub fn is_free(&self, layout: &Layout, body: usize, pose: &Pose2) -> bool {
        if !self.inside(body, pose) {
            return false;
        }
        let frame = pose.frame();
        let footprint = self.footprint(body);
        (0..self.len()).all(|other| {
            other == body
                || footprints_apart(footprint, &frame, self.footprint(other), &layout.frames[other], self.clearance)
        })
    }

    /// A place that a plan may put `body` to: free, or its goal with nothing on it.
    pub fn may_stand(&self, layout: &Layout, body: usize, pose: &Pose2) -> bool {
        self.is_free(layout, body, pose)
            || (self.goal_pose(body, &layout.pose(body)) == Some(*pose)
                && self.blockers(layout, body, pose, -PLACE_SLACK).is_empty())
    }

    /// How deep `body` at `pose` lies in another body, metres, the clearance included. Exact for discs; for others a
    /// step that a few repetitions make enough.
    pub fn depth(&self, layout: &Layout, body: usize, pose: &Pose2, other: usize, distance: f64) -> f64 {
        /// Of the overlap of the circles round the footprints, what a step takes back.
        const PART: f64 = 0.25;
        let (a, b) = (self.footprint(body), self.footprint(other));
        let round = (a.radius + b.radius - distance).max(0.0);
        if let (Shape::Disc { .. }, Shape::Disc { .. }) = (&a.shape, &b.shape) {
            return round + self.clearance;
        }
        let gap = pieces_gap_below(a, pose, b, &layout.pose(other), self.clearance);
        (self.clearance - gap).clamp(PART * self.clearance, round + self.clearance)
    }

    /// The pose, moved into the workspace if it fits there.
    pub fn brought_inside(&self, body: usize, pose: Pose2) -> Pose2 {
        /// Single precision must not put it outside again, metres.
        const INSET: f64 = 1e-6;
        let workspace = self.problem.scene.workspace();
        let frame = pose.frame();
        let extent = |x: f64, y: f64| self.footprint(body).support(frame.inverse_vector(vec2(x, y)));
        let bring = |value: f64, low: f64, high: f64| if low <= high { value.clamp(low, high) } else { value };
        let x =
            bring(pose.x, workspace.min[0] + extent(-1.0, 0.0) + INSET, workspace.max[0] - extent(1.0, 0.0) - INSET);
        let y =
            bring(pose.y, workspace.min[1] + extent(0.0, -1.0) + INSET, workspace.max[1] - extent(0.0, 1.0) - INSET);
        Pose2::new(x, y, pose.theta)
    }

    /// The problem of getting from one state exactly to another, on the same table.
    pub fn between(&self, from: &State, to: &State) -> Table {
        let exactly =
            |body: usize| Goal { position_tolerance: 0.0, rotation_tolerance: 0.0, ..Goal::at(to.pose(body)) };
        let problem = Rearrangement {
            name: String::new(),
            scene: Arc::clone(&self.problem.scene),
            start: from.clone(),
            goals: (0..self.len()).map(|body| self.movable.contains(body).then(|| exactly(body))).collect(),
        };
        Table { problem, boxes: Arc::clone(&self.boxes), ..*self }
    }

    /// The same problem from another state.
    pub fn starting_at(&self, start: &State) -> Table {
        Table { problem: self.problem.from_state(start.clone()), boxes: Arc::clone(&self.boxes), ..*self }
    }
}
