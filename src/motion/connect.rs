//! RRT-Connect (Kuffner and LaValle 2000) in SE(2), with exact motions between its nodes, and shortening.
//!
//! Written here because the crates that offer it do not fit: `rrt` 0.7 tests points, not motions, so that a path may
//! jump over a thin wall, and allocates every node; `oxmpl` 0.8 ends by the wall clock only, so that no result can be
//! had again. Neither can be interrupted.

use super::params::{PathParams, SWEEP_SLACK};
use super::reach::Reach;
use super::shape::MovingShape;
use super::sweep::{Motion, Obstacles, sweep_inside};
use crate::geom::{Pose2, normalize_angle, vec2};
use crate::run::{Stop, Stream};
use crate::scene::Workspace;

/// Least progress worth a node, and how far an extension stays back from what stopped it; metres by the metric, less in a
/// room that is smaller than a table.
const LEAST_PROGRESS: f64 = 0.003;
const STAY_BACK: f64 = 0.001;

#[derive(Debug, Clone, Copy)]
struct Node {
    pose: Pose2,
    parent: u32,
}

/// No parent.
const ROOT: u32 = u32::MAX;

#[derive(Debug, Default)]
struct Tree {
    nodes: Vec<Node>,
}

impl Tree {
    fn start(&mut self, pose: Pose2) {
        self.nodes.clear();
        self.nodes.push(Node { pose, parent: ROOT });
    }

    fn nearest(&self, pose: &Pose2, turn_weight: f64) -> usize {
        let mut best = (f64::INFINITY, 0);
        for (i, node) in self.nodes.iter().enumerate() {
            let (dx, dy) = (node.pose.x - pose.x, node.pose.y - pose.y);
            let square = dx * dx + dy * dy;
            if square >= best.0 {
                continue;
            }
            let turn = turn_weight * normalize_angle(node.pose.theta - pose.theta);
            let square = square + turn * turn;
            if square < best.0 {
                best = (square, i);
            }
        }
        best.1
    }

    fn add(&mut self, pose: Pose2, parent: usize) -> usize {
        self.nodes.push(Node { pose, parent: parent as u32 });
        self.nodes.len() - 1
    }

    /// The poses from a node to the root.
    fn to_root(&self, node: usize) -> impl Iterator<Item = Pose2> {
        let mut at = node as u32;
        std::iter::from_fn(move || {
            let node = self.nodes.get(at as usize)?;
            at = node.parent;
            Some(node.pose)
        })
    }
}

/// One body among the others.
pub(super) struct World<'a> {
    pub shape: &'a MovingShape,
    pub workspace: &'a Workspace,
    pub params: &'a PathParams,
    /// The size of the room.
    pub room: f64,
    pub obstacles: &'a mut Obstacles,
}

impl World<'_> {
    /// The fraction of a motion that is free.
    pub fn sweep(&mut self, motion: &Motion) -> f64 {
        let inside = sweep_inside(self.shape, self.workspace, motion, 1.0);
        if inside <= 0.0 { 0.0 } else { self.obstacles.sweep(self.shape, motion, inside) }
    }

    fn least_progress(&self) -> f64 {
        LEAST_PROGRESS * self.room.min(1.0)
    }

    pub fn is_free(&mut self, a: &Pose2, b: &Pose2) -> bool {
        let motion = Motion::new(a, b);
        sweep_inside(self.shape, self.workspace, &motion, 1.0) >= 1.0
            && self.obstacles.sweep(self.shape, &motion, 1.0) >= 1.0
    }

    /// How far along a motion the body gets and can go on from: all the way, or somewhat short of what stops it.
    pub fn advance(&mut self, motion: &Motion) -> f64 {
        let length = motion.by.norm() + self.params.turn_weight * motion.turn.abs();
        let mut reached = self.sweep(motion);
        if reached >= 1.0 {
            return 1.0;
        }
        for _ in 0..3 {
            reached -= STAY_BACK * self.room.min(1.0) / length;
            if reached * length < self.least_progress() {
                return 0.0;
            }
            if self.obstacles.is_free(self.shape, &motion.at(reached), 0.5 * SWEEP_SLACK) {
                return reached;
            }
        }
        0.0
    }
}

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ended {
    Found,
    UsedUp,
    Stopped,
}

/// The two trees, and the path that was found last.
#[derive(Debug, Default)]
pub(super) struct Connect {
    from_start: Tree,
    from_goal: Tree,
    pub path: Vec<Pose2>,
    spare: Vec<Pose2>,
    /// A way that the grid shows: from the start to the goal, free or nearly.
    pub way: Vec<Pose2>,
}

impl Connect {
    pub fn start(&mut self, from: Pose2, to: Pose2) {
        self.from_start.start(from);
        self.from_goal.start(to);
        self.path.clear();
        self.way.clear();
    }

    /// Follows the grid's way with as few motions as will do. `false` where one of its steps is not free: then both trees
    /// have what was passed from their ends, and only the rest stays as the way, for the search to find a way through.
    pub fn follow_way(&mut self, world: &mut World, from: Pose2, to: Pose2) -> bool {
        self.way.insert(0, from);
        self.way.push(to);
        let stuck = follow(world, &self.way, &mut self.path);
        if stuck + 1 == self.way.len() {
            return true;
        }
        self.way.reverse();
        let left = follow(world, &self.way, &mut self.spare);
        self.way.reverse();
        let back = self.way.len() - 1 - left;
        if back <= stuck {
            // Free backwards though not forwards: by as little as sweeps are uncertain.
            let follow_back = self.spare.iter().rev().skip_while(|pose| **pose != self.way[stuck]).skip(1);
            self.path.extend(follow_back);
            if self.path.last() == Some(&to) {
                return true;
            }
        }
        for (tree, passed) in [(&mut self.from_start, &self.path), (&mut self.from_goal, &self.spare)] {
            let mut parent = 0;
            for pose in &passed[1..] {
                parent = tree.add(*pose, parent);
            }
        }
        self.path.clear();
        self.way.truncate(back.max(stuck) + 1);
        self.way.drain(..stuck.min(back));
        false
    }

    /// Goes on for some iterations. Samples are drawn where the grid says the start can be brought to, if it was made.
    pub fn search(
        &mut self,
        world: &mut World,
        iterations: u32,
        reach: Option<&Reach>,
        stop: Option<&Stop>,
        random: &mut Stream,
    ) -> Ended {
        let weight = world.params.turn_weight;
        for iteration in 0..iterations {
            if iteration % 16 == 0 && stop.is_some_and(Stop::requested) {
                return Ended::Stopped;
            }
            let forward = iteration % 2 == 0;
            let (a, b) = if forward {
                (&mut self.from_start, &mut self.from_goal)
            } else {
                (&mut self.from_goal, &mut self.from_start)
            };
            let sample = match reach {
                Some(reach) if !self.way.is_empty() && random.chance(0.7) => near_way(&self.way, reach, random),
                _ => sample(world, reach, random),
            };
            let near = a.nearest(&sample, weight);
            let from = a.nodes[near].pose;
            let mut motion = Motion::new(&from, &sample);
            let length = motion.by.norm() + weight * motion.turn.abs();
            if length < world.least_progress() {
                continue;
            }
            let part = (world.params.step / length).min(1.0);
            motion.by *= part;
            motion.turn *= part;
            let reached = world.advance(&motion);
            if reached <= 0.0 {
                continue;
            }
            let pose = motion.at(reached);
            let new = a.add(pose, near);
            // The other tree comes straight towards the new node, as far as it can.
            let near = b.nearest(&pose, weight);
            let motion = Motion::new(&b.nodes[near].pose, &pose);
            let reached =
                if motion.by.norm() + weight * motion.turn.abs() < 1e-9 { 1.0 } else { world.advance(&motion) };
            if reached >= 1.0 {
                let (start_node, goal_node) = if forward { (new, near) } else { (near, new) };
                self.path.extend(self.from_start.to_root(start_node));
                self.path.reverse();
                self.path.extend(self.from_goal.to_root(goal_node));
                return Ended::Found;
            }
            if reached > 0.0 {
                b.add(motion.at(reached), near);
            }
        }
        Ended::UsedUp
    }

    /// Shortens the path: corners that can be left out, then cuts from anywhere to anywhere on it.
    pub fn shorten(&mut self, world: &mut World, random: &mut Stream) {
        self.leave_out(world);
        for _ in 0..world.params.shortcuts {
            let segments = self.path.len() - 1;
            if segments < 2 {
                return;
            }
            let (mut i, mut j) = (random.index(segments), random.index(segments));
            let (mut ti, mut tj) = (random.unit(), random.unit());
            if i == j {
                continue;
            }
            if i > j {
                (i, j) = (j, i);
                (ti, tj) = (tj, ti);
            }
            let p = Motion::new(&self.path[i], &self.path[i + 1]).at(ti);
            let q = Motion::new(&self.path[j], &self.path[j + 1]).at(tj);
            let old = world.params.length(&p, &self.path[i + 1])
                + self.path[i + 1..=j].windows(2).map(|w| world.params.length(&w[0], &w[1])).sum::<f64>()
                + world.params.length(&self.path[j], &q);
            if world.params.length(&p, &q) < old - 1e-4 && world.is_free(&p, &q) {
                self.spare.clear();
                self.spare.extend_from_slice(&self.path[..=i]);
                self.spare.extend([p, q]);
                self.spare.extend_from_slice(&self.path[j + 1..]);
                std::mem::swap(&mut self.path, &mut self.spare);
            }
        }
        self.leave_out(world);
    }

    /// From each corner straight to the farthest one that can be reached so.
    fn leave_out(&mut self, world: &mut World) {
        let mut at = 0;
        while at + 2 < self.path.len() {
            let mut next = self.path.len() - 1;
            while next > at + 1 && !world.is_free(&self.path[at], &self.path[next]) {
                next -= 1;
            }
            self.path.drain(at + 1..next);
            at += 1;
        }
    }
}

/// Passes along a way from its first pose as far as its steps are free, leaving out poses where it can. Says at which
/// pose it ends; `passed` has those that it goes by, with the first.
fn follow(world: &mut World, way: &[Pose2], passed: &mut Vec<Pose2>) -> usize {
    passed.clear();
    passed.push(way[0]);
    let mut at = 0;
    while at + 1 < way.len() {
        let mut step = 0;
        loop {
            let wider = (at + (2 * step).max(1)).min(way.len() - 1) - at;
            if wider == step || !world.is_free(&way[at], &way[at + wider]) {
                break;
            }
            step = wider;
        }
        if step == 0 {
            break;
        }
        at += step;
        passed.push(way[at]);
    }
    at
}

/// A pose about a way that the grid shows.
fn near_way(way: &[Pose2], reach: &Reach, random: &mut Stream) -> Pose2 {
    let at = way[random.index(way.len())];
    let (metres, radians) = reach.spread();
    Pose2::new(
        at.x + random.uniform(-metres, metres),
        at.y + random.uniform(-metres, metres),
        normalize_angle(at.theta + random.uniform(-radians, radians)),
    )
}

/// A pose with the shape's middle anywhere in the workspace.
fn sample(world: &World, reach: Option<&Reach>, random: &mut Stream) -> Pose2 {
    let workspace = world.workspace;
    let middle = world.shape.middle;
    let mut pose = Pose2::IDENTITY;
    // Rejection; where hardly anything can be reached, the last draw does.
    for _ in 0..64 {
        let at = vec2(
            random.uniform(workspace.min[0], workspace.max[0]),
            random.uniform(workspace.min[1], workspace.max[1]),
        );
        let theta = random.uniform(-std::f64::consts::PI, std::f64::consts::PI);
        pose = Pose2::new(0.0, 0.0, theta);
        let origin = at - pose.frame().vector(middle);
        (pose.x, pose.y) = (origin.x, origin.y);
        if reach.is_none_or(|reach| reach.holds(at, theta)) {
            break;
        }
    }
    pose
}
