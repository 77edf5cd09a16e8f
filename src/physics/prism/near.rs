//! Which bodies are near each other, and the contacts between them and with the ground.

use super::collide::{Axes, Outline, Touch, along, dot, sub, touch};
use super::contact::{BodyPoint, GroundPoint, Manifold, Pose};
use super::model::{Flat, Model, Real, Shape};
use super::settings::PrismSettings;
use super::world::World;

/// Pairs nearer than this (beyond the reach of contacts) are listed; the list is made anew when bodies have moved by half
/// of it. Metres.
pub const SKIN: Real = 0.012;
/// Added to every reach, metres: so far the lean of tall bodies may shift their outlines.
const LEAN: Real = 0.003;

/// Two pieces that are near each other.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    /// Order in the list.
    pub key: u64,
    pub pieces: [u32; 2],
    pub bodies: [u32; 2],
    pub threshold: Real,
    /// How much the borders give way, because the bodies began nearer than the borders allow.
    pub slack: Real,
    pub friction: Real,
    pub rolling: Real,
    /// See [`touch`].
    pub axes: Axes,
    /// The pieces cannot meet before bodies have moved this far; see `World::way`.
    pub apart_until: Real,
    pub manifold: Manifold<BodyPoint>,
}

/// Box round a piece.
#[derive(Debug, Clone, Copy, Default)]
pub struct Bounds {
    pub low: Flat,
    pub high: Flat,
}

impl Bounds {
    #[inline]
    fn gap(&self, other: &Bounds) -> Real {
        let x = (self.low[0] - other.high[0]).max(other.low[0] - self.high[0]);
        let y = (self.low[1] - other.high[1]).max(other.low[1] - self.high[1]);
        x.max(y)
    }
}

impl World {
    #[inline]
    fn outline_of(&self, shape: &Shape, piece: usize) -> Outline<'_> {
        let middle = self.middles[piece];
        if shape.is_disc {
            return Outline::Disc(middle);
        }
        let range = shape.corners.0 as usize..shape.corners.1 as usize;
        Outline::Polygon { corners: &self.corners[range.clone()], normals: &self.normals[range], middle }
    }

    /// Makes the list of near pairs anew, the tip's first; known ones keep their contacts.
    pub(super) fn list_pairs(&mut self, model: &Model, settings: &PrismSettings) {
        std::mem::swap(&mut self.pairs, &mut self.pairs_before);
        self.pairs.clear();
        self.way_at_list = self.way;
        let tip = model.tip();
        let mut known = 0;
        let count = self.present.len();
        for first in 0..=count {
            // The tip comes first, then the bodies.
            let a = if first == 0 { tip } else { self.present[first - 1] as usize };
            if a == tip && !self.tip_is_down {
                continue;
            }
            for second in first..count {
                let b = self.present[second] as usize;
                let reach = model.bodies[a].radius + model.bodies[b].radius + SKIN + LEAN;
                let d = sub([self.poses[b].at[0], self.poses[b].at[1]], [self.poses[a].at[0], self.poses[a].at[1]]);
                if dot(d, d) > reach * reach {
                    continue;
                }
                self.list_pieces(model, settings, [a, b], first as u64, &mut known);
            }
        }
    }

    fn list_pieces(
        &mut self,
        model: &Model,
        settings: &PrismSettings,
        [a, b]: [usize; 2],
        rank: u64,
        known: &mut usize,
    ) {
        let (body_a, body_b) = (&model.bodies[a], &model.bodies[b]);
        for p in body_a.pieces.0..body_a.pieces.1 {
            for q in body_b.pieces.0..body_b.pieces.1 {
                let (shape_a, shape_b) = (&model.pieces[p as usize], &model.pieces[q as usize]);
                let threshold = settings.body_breaking as Real * shape_a.motion_disc.min(shape_b.motion_disc);
                let reach = shape_a.round + shape_b.round + threshold + SKIN + LEAN;
                if self.bounds[p as usize].gap(&self.bounds[q as usize]) > reach {
                    continue;
                }
                let key = rank << 48
                    | (b as u64) << 32
                    | u64::from(p - body_a.pieces.0) << 16
                    | u64::from(q - body_b.pieces.0);
                while self.pairs_before.get(*known).is_some_and(|pair| pair.key < key) {
                    *known += 1;
                }
                if let Some(pair) = self.pairs_before.get(*known).filter(|pair| pair.key == key) {
                    self.pairs.push(*pair);
                    continue;
                }
                self.pairs.push(Pair {
                    key,
                    pieces: [p, q],
                    bodies: [a as u32, b as u32],
                    threshold,
                    slack: 0.0,
                    friction: body_a.friction * body_b.friction,
                    rolling: body_a.friction * body_b.rolling + body_b.friction * body_a.rolling,
                    axes: [0; 2],
                    apart_until: 0.0,
                    manifold: Manifold::default(),
                });
            }
        }
    }

    /// Lets the borders of pairs give way that begin nearer than these allow.
    pub(super) fn give_way(&mut self, model: &Model, settings: &PrismSettings) {
        for k in 0..self.pairs.len() {
            let mut pair = self.pairs[k];
            let [a, b] = pair.pieces.map(|p| &model.pieces[p as usize]);
            if let Ok(found) = self.nearest(model, &mut pair, a.round + b.round) {
                let overlap = a.round + b.round - found.gap;
                let borders = a.border + b.border;
                self.pairs[k].slack = (overlap - settings.border_overlap as Real).clamp(0.0, borders);
            }
        }
    }

    /// See [`touch`].
    #[inline]
    fn nearest(&self, model: &Model, pair: &mut Pair, reach: Real) -> Result<Touch, Real> {
        let [p, q] = pair.pieces.map(|p| p as usize);
        let gap = self.bounds[p].gap(&self.bounds[q]);
        if gap > reach {
            return Err(gap);
        }
        let (a, b) = (&model.pieces[p], &model.pieces[q]);
        touch(self.outline_of(a, p), self.outline_of(b, q), reach, &mut pair.axes)
    }

    /// Contacts of the bodies that are awake.
    pub(super) fn find_contacts(&mut self, model: &Model, settings: &PrismSettings) {
        let mut pairs = std::mem::take(&mut self.pairs);
        for pair in &mut pairs {
            let [a, b] = pair.bodies.map(|i| i as usize);
            if !(self.awake[a] || self.awake[b]) || self.way < pair.apart_until {
                continue;
            }
            let shapes = pair.pieces.map(|p| &model.pieces[p as usize]);
            let (pose_a, pose_b) = (self.poses[a], self.poses[b]);
            if a == model.tip() && model.path.is_some() && passes_over(model, [a, b], [&pose_a, &pose_b]) {
                pair.manifold = Manifold::default();
                continue;
            }
            let heights = common_heights(model, [a, b], [&pose_a, &pose_b]);
            let round = shapes[0].round + shapes[1].round;
            let lean = lean(&pose_a, heights) + lean(&pose_b, heights);
            let threshold = pair.threshold * self.pace.body_share;
            let reach = threshold + round - pair.slack + lean;
            let found = self.nearest(model, pair, reach);
            if let Ok(found) = found {
                let (gap, height) = heights
                    .into_iter()
                    .map(|h| {
                        (found.gap - round + pair.slack + dot(found.normal, sub(pose_b.shift(h), pose_a.shift(h))), h)
                    })
                    .fold((Real::INFINITY, 0.0), |best, next| if next.0 < best.0 { next } else { best });
                if gap < threshold {
                    let point = new_point(&found, height, [&pose_a, &pose_b], shapes.map(|s| s.round));
                    pair.manifold.add(point, threshold);
                }
                if a == model.tip() && !self.awake[b] && gap < settings.wake_gap as Real {
                    self.awake[b] = true;
                }
            }
            pair.manifold.refresh(&pose_a, &pose_b, pair.slack, threshold);
            if let Err(gap) = found
                && pair.manifold.points().is_empty()
            {
                // Both may move, and lean.
                pair.apart_until =
                    self.way + 0.5 * (gap - (reach - threshold + pair.threshold) - (LEAN - lean).max(0.0));
            }
        }
        self.pairs = pairs;
        let border = settings.border as Real;
        for &i in &self.present {
            let i = i as usize;
            if !self.awake[i] {
                continue;
            }
            let (body, pose) = (&model.bodies[i], self.poses[i]);
            for p in body.pieces.0 as usize..body.pieces.1 as usize {
                let shape = &model.pieces[p];
                let threshold = self.pace.ground_breaking * shape.motion_disc;
                // Lowest where the base leans most downwards.
                let down = pose.turn_back(pose.tilt);
                let corners = &model.corners[shape.corners.0 as usize..shape.corners.1 as usize];
                let mut best = (Real::NEG_INFINITY, [0.0; 2]);
                for &c in corners {
                    let d = dot(c, down);
                    if d > best.0 {
                        best = (d, c);
                    }
                }
                let arm = pose.arm([best.1[0], best.1[1], -body.half_height]);
                let gap = pose.at[2] + arm[2] - border;
                let manifold = &mut self.ground[p];
                if gap < threshold {
                    let anchor = [pose.at[0] + arm[0], pose.at[1] + arm[1]];
                    manifold.add(GroundPoint { local: best.1, anchor, ..GroundPoint::default() }, threshold);
                }
                manifold.refresh(&pose, body.half_height, border, threshold);
            }
        }
    }
}

/// How far a body's outline can be shifted by its lean between these heights.
#[inline]
fn lean(pose: &Pose, heights: [Real; 2]) -> Real {
    let height = (heights[0] - pose.at[2]).abs().max((heights[1] - pose.at[2]).abs());
    (pose.tilt[0].abs() + pose.tilt[1].abs()) * height
}

/// Whether the first body is above the second.
#[inline]
fn passes_over(model: &Model, [a, b]: [usize; 2], poses: [&Pose; 2]) -> bool {
    poses[0].at[2] - model.bodies[a].half_height >= poses[1].at[2] + model.bodies[b].half_height
}

/// The lower and the upper end of the heights at which both bodies are. Where there are none, as for a tip over a flat
/// body, both are the lower body's top: the world is planar, and a tip passes over a body only on a robot's path.
#[inline]
fn common_heights(model: &Model, bodies: [usize; 2], poses: [&Pose; 2]) -> [Real; 2] {
    let half = bodies.map(|i| model.bodies[i].half_height);
    let low = (poses[0].at[2] - half[0]).max(poses[1].at[2] - half[1]);
    let high = (poses[0].at[2] + half[0]).min(poses[1].at[2] + half[1]);
    [low.min(high), high]
}

#[inline]
fn new_point(found: &Touch, height: Real, poses: [&Pose; 2], round: [Real; 2]) -> BodyPoint {
    let n = found.normal;
    let tangent = [-n[1], n[0]];
    // Leaning shifts the two outlines along their common face too; the point of both is where they meet then.
    let [a, b] = poses.map(|pose| pose.shift(height));
    let beside = 0.5 * dot(tangent, sub(b, a));
    let sides = [round[0], -round[1]];
    let local = [0, 1].map(|k| {
        let pose = poses[k];
        let on = along(along(found.points[k], n, sides[k]), tangent, [beside, -beside][k]);
        let r = sub(on, [pose.at[0], pose.at[1]]);
        let l = pose.turn_back(r);
        [l[0], l[1], height - pose.at[2] + pose.tilt[0] * r[0] + pose.tilt[1] * r[1]]
    });
    BodyPoint { local, normal: n, ..BodyPoint::default() }
}
