//! Contacts that live from step to step: Bullet's rule for a manifold that gains one point a step.
//!
//! GJK finds one nearest point a step; Bullet keeps up to four of them and drops one when its two halves have parted or
//! slid apart by a threshold (`btPersistentManifold::refreshContactPoints`). So a sliding block stands on one to three
//! corners at a time and falls on the next: it rocks. That rocking is most of what separates Bullet from a planar model.

use super::collide::{along, dot, sub};
use super::model::{Flat, Real};

/// Most points that a manifold keeps, as in Bullet.
pub const MOST_POINTS: usize = 4;

/// Place, heading and lean of a body.
#[derive(Debug, Clone, Copy, Default)]
pub struct Pose {
    /// Centre of mass.
    pub at: [Real; 3],
    pub theta: Real,
    pub cos: Real,
    pub sin: Real,
    /// The body's axis is (a, b, 1).
    pub tilt: Flat,
}

impl Pose {
    #[inline]
    pub fn turn(&self, l: Flat) -> Flat {
        [self.cos * l[0] - self.sin * l[1], self.sin * l[0] + self.cos * l[1]]
    }

    #[inline]
    pub fn turn_back(&self, r: Flat) -> Flat {
        [self.cos * r[0] + self.sin * r[1], self.cos * r[1] - self.sin * r[0]]
    }

    /// From the centre of mass to a point of the body, in the world's directions.
    #[inline]
    pub fn arm(&self, l: [Real; 3]) -> [Real; 3] {
        let r = self.turn([l[0], l[1]]);
        [r[0] + self.tilt[0] * l[2], r[1] + self.tilt[1] * l[2], l[2] - self.tilt[0] * r[0] - self.tilt[1] * r[1]]
    }

    /// How far the body's outline at height `z` is shifted by its lean.
    #[inline]
    pub fn shift(&self, z: Real) -> Flat {
        [self.tilt[0] * (z - self.at[2]), self.tilt[1] * (z - self.at[2])]
    }
}

/// A point between two bodies.
#[derive(Debug, Clone, Copy, Default)]
pub struct BodyPoint {
    /// In the first body and in the second.
    pub local: [[Real; 3]; 2],
    /// From the first to the second, horizontal.
    pub normal: Flat,
    pub gap: Real,
    /// From each centre of mass, as of the last refresh.
    pub arm: [[Real; 3]; 2],
    /// Impulses of the last step: along the normal, across it, and up.
    pub impulse: [Real; 3],
}

/// A point between a body and the ground.
#[derive(Debug, Clone, Copy, Default)]
pub struct GroundPoint {
    /// The corner, body frame.
    pub local: Flat,
    /// Where on the ground it touched down.
    pub anchor: Flat,
    pub gap: Real,
    /// From the centre of mass, as of the last refresh.
    pub arm: [Real; 3],
    /// Impulses of the last step: up, x, y.
    pub impulse: [Real; 3],
}

/// The points between two pieces of two bodies, or between a piece and the ground.
#[derive(Debug, Clone, Copy, Default)]
pub struct Manifold<P> {
    points: [P; MOST_POINTS],
    count: u8,
    /// Torque impulses of the last step: about the normal and the two other axes.
    pub torque: [Real; 3],
}

impl<P: Copy + Default> Manifold<P> {
    #[inline]
    pub fn points(&self) -> &[P] {
        &self.points[..self.count as usize]
    }

    #[inline]
    pub fn points_mut(&mut self) -> &mut [P] {
        &mut self.points[..self.count as usize]
    }

    pub fn clear(&mut self) {
        self.count = 0;
        self.torque = [0.0; 3];
    }

    /// Puts a point into the place of the nearest one if that is within the threshold or there is no room, else adds it.
    #[inline]
    fn put(&mut self, point: P, within: Real, squared_distance: impl Fn(&P) -> Real, keep: impl Fn(&P, &mut P)) {
        let mut nearest = (Real::INFINITY, 0);
        for (i, p) in self.points().iter().enumerate() {
            let d = squared_distance(p);
            if d < nearest.0 {
                nearest = (d, i);
            }
        }
        if nearest.0 <= within * within || self.count as usize == MOST_POINTS {
            let mut point = point;
            keep(&self.points[nearest.1], &mut point);
            self.points[nearest.1] = point;
        } else {
            self.points[self.count as usize] = point;
            self.count += 1;
        }
    }

    /// Drops the points that `keep` refuses; the others keep their order.
    #[inline]
    fn retain(&mut self, mut keep: impl FnMut(&mut P) -> bool) {
        let mut kept = 0;
        for i in 0..self.count as usize {
            if keep(&mut self.points[i]) {
                if kept < i {
                    self.points[kept] = self.points[i];
                }
                kept += 1;
            }
        }
        self.count = kept as u8;
        if kept == 0 {
            self.torque = [0.0; 3];
        }
    }
}

impl Manifold<BodyPoint> {
    pub fn add(&mut self, point: BodyPoint, threshold: Real) {
        let distance = |p: &BodyPoint| {
            let (a, b) = (p.local[0], point.local[0]);
            (0..3).map(|i| (a[i] - b[i]) * (a[i] - b[i])).sum()
        };
        self.put(point, threshold, distance, |old, new| new.impulse = old.impulse);
    }

    /// Computes gaps and arms anew and drops what has parted. `slack` is what the borders give way.
    #[inline]
    pub fn refresh(&mut self, a: &Pose, b: &Pose, slack: Real, threshold: Real) {
        self.retain(|p| {
            p.arm = [a.arm(p.local[0]), b.arm(p.local[1])];
            let apart = [0, 1, 2].map(|i| b.at[i] - a.at[i] + p.arm[1][i] - p.arm[0][i]);
            let flat = [apart[0], apart[1]];
            let bare = dot(flat, p.normal);
            p.gap = bare + slack;
            let drift = along(flat, p.normal, -bare);
            p.gap <= threshold && dot(drift, drift) + apart[2] * apart[2] <= threshold * threshold
        });
    }
}

impl Manifold<GroundPoint> {
    pub fn add(&mut self, point: GroundPoint, threshold: Real) {
        let distance = |p: &GroundPoint| {
            let d = sub(p.anchor, point.anchor);
            dot(d, d)
        };
        self.put(point, threshold, distance, |old, new| new.impulse = old.impulse);
    }

    /// Computes gaps and arms anew and drops what has lifted or slid off. `below` is the depth of the base under the
    /// centre of mass.
    #[inline]
    pub fn refresh(&mut self, pose: &Pose, below: Real, border: Real, threshold: Real) {
        self.retain(|p| {
            p.arm = pose.arm([p.local[0], p.local[1], -below]);
            p.gap = pose.at[2] + p.arm[2] - border;
            let drift = sub([pose.at[0] + p.arm[0], pose.at[1] + p.arm[1]], p.anchor);
            p.gap <= threshold && dot(drift, drift) <= threshold * threshold
        });
    }
}
