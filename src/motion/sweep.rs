//! The bodies that stand still, and exact tests of one that moves among them.
//!
//! A straight motion in SE(2) is linear in x, y and heading (the shorter way round). It is checked by conservative
//! advancement (Mirtich 1996) with directions: from a line that separates two convex pieces by a known gap follows for
//! how long they certainly stay apart, because along that line no corner comes nearer faster than the translation's
//! component and the turn's speed at the farthest corner. Nothing is sampled, so nothing is jumped over. A motion
//! along a wall costs one step, however near.

use super::gap::separation;
use super::params::{EDGE_TOLERANCE, MIN_CLEARANCE, SWEEP_SLACK};
use super::shape::{Core, MovingShape};
use crate::geom::{Frame, Pose2, Vec2, normalize_angle};
use crate::scene::{Mask, State, Workspace};

/// A body that stands still.
#[derive(Debug, Clone, Copy)]
struct Standing {
    body: usize,
    origin: Vec2,
    radius: f64,
    /// Its cores.
    first: usize,
    last: usize,
    /// Gap to keep from it, metres.
    need: f64,
}

/// All bodies but one, placed in the world, and working memory.
#[derive(Debug, Default)]
pub(super) struct Obstacles {
    /// What they were made of: see [`Obstacles::place`].
    made_of: Option<(u64, usize)>,
    standing: Vec<Standing>,
    /// Grows and never shrinks; the standing bodies say which are in use.
    cores: Vec<Core>,
    moved: Core,
}

/// A straight motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    pub from: Pose2,
    pub by: Vec2,
    pub turn: f64,
}

impl Motion {
    pub fn new(a: &Pose2, b: &Pose2) -> Motion {
        Motion { from: *a, by: b.position() - a.position(), turn: normalize_angle(b.theta - a.theta) }
    }

    /// Where the body is at a fraction of the motion.
    pub fn at(&self, t: f64) -> Pose2 {
        Pose2::new(self.from.x + self.by.x * t, self.from.y + self.by.y * t, self.from.theta + self.turn * t)
    }
}

impl Obstacles {
    /// Places all present bodies but `body`. `hash` is that of their poses: with the same one nothing is to be done.
    pub fn place(&mut self, shapes: &[MovingShape], state: &State, body: usize, hash: u64) {
        if self.made_of == Some((hash, body)) {
            return;
        }
        self.made_of = Some((hash, body));
        self.standing.clear();
        let mut used = 0;
        for (other, pose) in state.iter().filter(|(other, _)| *other != body) {
            let Some(shape) = shapes.get(other) else { continue };
            let frame = pose.frame();
            let first = used;
            for core in &shape.cores {
                if used == self.cores.len() {
                    self.cores.push(Core::default());
                }
                self.cores[used].place(core, &frame);
                used += 1;
            }
            let (origin, radius) = (pose.position(), shape.radius);
            self.standing.push(Standing { body: other, origin, radius, first, last: used, need: 0.0 });
        }
    }

    /// The same gap to all.
    pub fn keep(&mut self, need: f64) {
        self.standing.iter_mut().for_each(|s| s.need = need);
    }

    /// From each body the gap `need`, or the gap at the nearer of these poses where that is less. `false` where a pose
    /// is so near to another body that they count as touching.
    pub fn keep_as_at(&mut self, shape: &MovingShape, need: f64, poses: [&Pose2; 2]) -> bool {
        self.keep(need);
        for pose in poses {
            for at in 0..self.standing.len() {
                let standing = self.standing[at];
                let gap = self.gap_to(shape, pose, &standing, standing.need);
                if gap < MIN_CLEARANCE {
                    return false;
                }
                self.standing[at].need = standing.need.min(gap);
            }
        }
        true
    }

    /// Lowers the gaps to keep to those at a pose less `slack`, where that is less; to no less than [`MIN_CLEARANCE`].
    pub fn keep_as_near(&mut self, shape: &MovingShape, pose: &Pose2, slack: f64) {
        for at in 0..self.standing.len() {
            let standing = self.standing[at];
            let gap = self.gap_to(shape, pose, &standing, standing.need + slack) - slack;
            self.standing[at].need = standing.need.min(gap.max(MIN_CLEARANCE));
        }
    }

    /// Gap to one body where it is less than `limit`, else `limit`.
    fn gap_to(&mut self, shape: &MovingShape, pose: &Pose2, standing: &Standing, limit: f64) -> f64 {
        let reach = shape.radius + standing.radius + limit;
        if (pose.position() - standing.origin).norm_squared() >= reach * reach {
            return limit;
        }
        let frame = pose.frame();
        let mut least = limit;
        for core in &shape.cores {
            let centre = frame.point(core.centre);
            let mut placed = false;
            for other in &self.cores[standing.first..standing.last] {
                let reach = core.radius + other.radius + least;
                if (centre - other.centre).norm_squared() >= reach * reach {
                    continue;
                }
                if !placed {
                    self.moved.place(core, &frame);
                    placed = true;
                }
                least = least.min(separation(&self.moved, other, least).gap);
            }
        }
        least
    }

    /// The least gap to any body where it is less than `limit`, else `limit`; metres, negative where they overlap.
    pub fn gap(&mut self, shape: &MovingShape, pose: &Pose2, limit: f64) -> f64 {
        let mut least = limit;
        for at in 0..self.standing.len() {
            let standing = self.standing[at];
            least = least.min(self.gap_to(shape, pose, &standing, least));
        }
        least
    }

    /// Whether the needed gap is kept at a pose, less `slack`.
    pub fn is_free(&mut self, shape: &MovingShape, pose: &Pose2, slack: f64) -> bool {
        (0..self.standing.len()).all(|at| {
            let standing = self.standing[at];
            self.gap_to(shape, pose, &standing, standing.need) >= standing.need - slack
        })
    }

    /// The bodies from which the needed gap is not kept at a pose.
    pub fn blockers(&mut self, shape: &MovingShape, pose: &Pose2, slack: f64) -> Mask {
        let mut blockers = Mask::EMPTY;
        for at in 0..self.standing.len() {
            let standing = self.standing[at];
            if self.gap_to(shape, pose, &standing, standing.need) < standing.need - slack {
                blockers.insert(standing.body);
            }
        }
        blockers
    }

    /// What was placed: a hash of poses and shapes, and the body that moves.
    pub fn made_of(&self) -> Option<(u64, usize)> {
        self.made_of
    }

    /// The cores of each standing body, and the gap to keep from it.
    pub fn bodies(&self) -> impl Iterator<Item = (&[Core], f64)> {
        self.standing.iter().map(|s| (&self.cores[s.first..s.last], s.need))
    }

    /// The fraction of a motion, up to `limit`, through which the needed gaps are certainly kept.
    pub fn sweep(&mut self, shape: &MovingShape, motion: &Motion, limit: f64) -> f64 {
        let mut limit = limit;
        let Obstacles { standing, cores, moved, .. } = self;
        for s in standing.iter() {
            let reach = shape.radius + s.radius + s.need;
            if segment_distance_squared(motion.from.position(), motion.by * limit, s.origin) >= reach * reach {
                continue;
            }
            for core in &shape.cores {
                for other in &cores[s.first..s.last] {
                    limit = sweep_pair(core, other, moved, motion, s.need, limit);
                    if limit <= 0.0 {
                        return 0.0;
                    }
                }
            }
        }
        limit
    }
}

/// As [`Obstacles::sweep`], for two pieces.
fn sweep_pair(core: &Core, other: &Core, moved: &mut Core, motion: &Motion, need: f64, limit: f64) -> f64 {
    let turn_speed = motion.turn.abs() * core.reach;
    let speed = motion.by.norm();
    let centre_speed = speed + motion.turn.abs() * core.centre.norm();
    let mut t = 0.0;
    while t < limit {
        let frame = motion.at(t).frame();
        // The circles first: they move no faster than their centres.
        let apart = (frame.point(core.centre) - other.centre).norm() - core.radius - other.radius - need;
        let reach = centre_speed * (limit - t);
        if apart >= reach {
            return limit;
        }
        // Steps too small to count in `t` would never end.
        if apart > (0.25 * reach).max(0.1 * SWEEP_SLACK) {
            t += apart / centre_speed;
            continue;
        }
        moved.place(core, &frame);
        // A line that shows this much serves for the whole rest of the motion.
        let enough = need + (speed + turn_speed) * (limit - t);
        let s = separation(moved, other, enough);
        if s.gap < need - 0.5 * SWEEP_SLACK {
            return t;
        }
        let closing = (-s.axis.dot(&motion.by)).max(0.0) + turn_speed;
        let safe = s.gap - (need - SWEEP_SLACK);
        if safe >= closing * (limit - t) {
            return limit;
        }
        t += safe / closing;
    }
    limit
}

/// Squared distance of a point from the segment that begins at `a` and extends by `d`.
fn segment_distance_squared(a: Vec2, d: Vec2, p: Vec2) -> f64 {
    let ap = p - a;
    let square = d.norm_squared();
    let t = if square > 0.0 { (ap.dot(&d) / square).clamp(0.0, 1.0) } else { 0.0 };
    (ap - d * t).norm_squared()
}

/// By how much a footprint at a frame lies within the workspace; metres, negative where it reaches out.
pub(super) fn inset(shape: &MovingShape, workspace: &Workspace, frame: &Frame) -> f64 {
    shape.extremes.iter().map(|&(p, rounding)| workspace.inset(frame.point(p)) - rounding).fold(f64::INFINITY, f64::min)
}

/// Whether a footprint lies within the workspace.
pub(super) fn is_inside(shape: &MovingShape, workspace: &Workspace, pose: &Pose2) -> bool {
    workspace.inset(pose.position()) >= shape.radius || inset(shape, workspace, &pose.frame()) >= -EDGE_TOLERANCE
}

/// The fraction of a motion, up to `limit`, through which the whole footprint stays within the workspace.
///
/// Between two instants a corner's path leaves its chord by no more than the sagitta of its turn, so halves are looked
/// at only where the chord is nearer to the edge than that.
pub(super) fn sweep_inside(shape: &MovingShape, workspace: &Workspace, motion: &Motion, limit: f64) -> f64 {
    let end = motion.at(limit);
    if workspace.inset(motion.from.position()).min(workspace.inset(end.position())) >= shape.radius {
        return limit;
    }
    let at = |t: f64| inset(shape, workspace, &motion.at(t).frame());
    let (mut from, mut from_inset) = (0.0, at(0.0));
    let (mut to, mut to_inset) = (limit, at(limit));
    loop {
        let half = 0.5 * motion.turn.abs() * (to - from);
        let sagitta = shape.radius * (1.0 - half.min(std::f64::consts::PI).cos());
        if from_inset.min(to_inset) - sagitta >= -EDGE_TOLERANCE {
            if to >= limit {
                return limit;
            }
            (from, from_inset) = (to, to_inset);
            (to, to_inset) = (limit, at(limit));
        } else if sagitta <= 0.5 * EDGE_TOLERANCE || to - from < 1e-9 {
            // As good as straight: the inset is then concave, and leaves no sooner than its chord.
            let inward = from_inset + EDGE_TOLERANCE;
            if inward <= 0.0 || sagitta > 0.0 {
                return from;
            }
            return from + (to - from) * inward / (from_inset - to_inset);
        } else {
            to = from + 0.5 * (to - from);
            to_inset = at(to);
        }
    }
}
