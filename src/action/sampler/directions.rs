//! What a sampler knows of a body before it sees a state: directions and starts in the body's frame.

use super::params::{ContourRule, SamplerParams};
use crate::geom::{Footprint, Piece, Vec2, convex_hull, vec2};
use crate::scene::{Gripper, Scene};

/// A corner of the hull counts as one where the outline turns by more than this; a disc given as a polygon of more
/// than 18 corners has none.
const CORNER_TURN: f64 = 0.35;

/// Where a direction came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    Axis,
    Other,
    /// To be taken only where it differs enough from what was accepted.
    Greedy,
}

/// A push in the body's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Candidate {
    pub start: Vec2,
    pub direction: Vec2,
    pub source: Source,
    /// Length of the push as a share of the sampler's.
    pub share: f64,
}

/// The pushes of one body.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BodyTable {
    pub candidates: Vec<Candidate>,
    /// Greatest distance of a start from the body's origin, after backing off.
    pub reach: f64,
    /// Radius of a disc about the body's origin that lies within the body; 0 where the origin does not.
    pub inner: f64,
    /// Measures of the footprint, by which a table for another scene is told.
    area: f64,
    radius: f64,
}

/// The pushes of every body of a scene.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tables {
    pub bodies: Vec<BodyTable>,
    /// Fitted to the scene's gripper.
    pub params: SamplerParams,
    gripper: Gripper,
}

impl Tables {
    /// `length` is the commanded length of a push, where it is not the parameters'.
    pub fn new(scene: &Scene, params: &SamplerParams, length: Option<f64>) -> Tables {
        let gripper = scene.gripper().clone();
        let mut params = params.fitted(&gripper);
        params.length = length.unwrap_or(params.length);
        let bodies = scene.bodies().iter().map(|b| BodyTable::new(&b.footprint, &params)).collect();
        Tables { bodies, params, gripper }
    }

    /// The tables were made for footprints and a gripper like this scene's.
    pub fn fits(&self, scene: &Scene) -> bool {
        self.bodies.len() == scene.len()
            && self.gripper.push == scene.gripper().push
            && self.gripper.grasp == scene.gripper().grasp
            && self
                .bodies
                .iter()
                .zip(scene.bodies())
                .all(|(t, b)| t.area == b.footprint.area && t.radius == b.footprint.radius)
    }
}

impl BodyTable {
    // Inlined into the loop over bodies, the cosines below would be taken before it even of angles that no parameter
    // sets: without effect, but reported by valgrind as a use of uninitialised memory.
    #[inline(never)]
    fn new(footprint: &Footprint, params: &SamplerParams) -> BodyTable {
        let mut directions: Vec<(Vec2, Source)> = Vec::new();
        let (a, b) = footprint.principal_axes();
        if params.axes {
            directions.extend([a, b, -a, -b].map(|d| (d, Source::Axis)));
        }
        if params.diagonals {
            directions.extend([a + b, b - a, -a - b, a - b].map(|d| (d.normalize(), Source::Other)));
        }
        if let Some(corners) = params.corners {
            let limit = corners.separation.cos();
            let mut taken = 0;
            for corner in corners_by_distance(footprint) {
                let d = (footprint.centroid - corner).normalize();
                if taken < corners.most && directions.iter().all(|(other, _)| other.dot(&d) < limit) {
                    directions.push((d, Source::Other));
                    taken += 1;
                }
            }
        }
        match params.contour {
            ContourRule::None => {}
            ContourRule::OffAxes { points, separation } => {
                let limit = separation.cos();
                let off = |d: &Vec2| [a, b, -a, -b].iter().all(|axis| axis.dot(d) < limit);
                directions
                    .extend(contour_directions(footprint, points).into_iter().filter(off).map(|d| (d, Source::Other)));
            }
            ContourRule::Greedy { points, .. } => {
                directions.extend(contour_directions(footprint, points).into_iter().map(|d| (d, Source::Greedy)));
            }
        }
        let c = footprint.centroid;
        let candidates: Vec<Candidate> = directions
            .into_iter()
            .flat_map(|(direction, source)| {
                let side = vec2(-direction.y, direction.x);
                let push = move |offset: f64, share: f64, source: Source| {
                    let behind = extent_behind(footprint, direction, offset, params.strip)?;
                    let start = c + side * offset - direction * (behind + params.stand_off);
                    Some(Candidate { start, direction, source, share })
                };
                let lateral: &[f64] = if source == Source::Axis { &params.lateral } else { &[] };
                std::iter::once(push(0.0, 1.0, source))
                    .chain(params.lengths.iter().map(move |&share| push(0.0, share, Source::Other)))
                    .chain(lateral.iter().map(move |&offset| push(offset, 1.0, Source::Other)))
                    .flatten()
            })
            .collect();
        let back = params.back_off.iter().copied().fold(0.0, f64::max);
        BodyTable {
            reach: candidates.iter().map(|k| k.start.norm()).fold(0.0, f64::max) + back,
            candidates,
            inner: inner_radius(footprint),
            area: footprint.area,
            radius: footprint.radius,
        }
    }
}

/// How far the body reaches behind its centroid, against `direction`, within `strip` of the line that passes the centroid
/// `offset` to the left. None where the strip misses the body. Exact for polygons and discs.
pub(super) fn extent_behind(footprint: &Footprint, direction: Vec2, offset: f64, strip: f64) -> Option<f64> {
    let side = vec2(-direction.y, direction.x);
    let local = |p: Vec2| {
        let r = p - footprint.centroid;
        vec2(-r.dot(&direction), r.dot(&side) - offset)
    };
    let mut best = f64::NEG_INFINITY;
    for piece in &footprint.pieces {
        match piece {
            Piece::Disc { centre, radius } => {
                let c = local(*centre);
                let off = (c.y.abs() - strip).max(0.0);
                if off <= *radius {
                    best = best.max(c.x + (radius * radius - off * off).sqrt());
                }
            }
            Piece::Convex(points) => {
                for (i, &p) in points.iter().enumerate() {
                    let (p, q) = (local(p), local(points[(i + 1) % points.len()]));
                    // The part of the edge within the strip: its ends carry the greatest extent.
                    let (lo, hi) = if p.y <= q.y { (p, q) } else { (q, p) };
                    if lo.y > strip || hi.y < -strip {
                        continue;
                    }
                    let rise = hi.y - lo.y;
                    let at = |y: f64| {
                        let t = if rise > 0.0 { (y - lo.y) / rise } else { 0.0 };
                        lo.x + (hi.x - lo.x) * t.clamp(0.0, 1.0)
                    };
                    if rise <= 0.0 {
                        best = best.max(lo.x.max(hi.x));
                    } else {
                        best = best.max(at(lo.y.max(-strip))).max(at(hi.y.min(strip)));
                    }
                }
            }
        }
    }
    best.is_finite().then_some(best)
}

/// Radius of a disc about the body's origin that lies within one of its pieces.
fn inner_radius(footprint: &Footprint) -> f64 {
    let within = |piece: &Piece| match piece {
        Piece::Disc { centre, radius } => radius - centre.norm(),
        Piece::Convex(points) => (0..points.len())
            .map(|i| {
                let (p, q) = (points[i], points[(i + 1) % points.len()]);
                (p.x * q.y - p.y * q.x) / (q - p).norm()
            })
            .fold(f64::INFINITY, f64::min),
    };
    footprint.pieces.iter().map(within).fold(0.0, f64::max)
}

/// The outline that contour points lie on: of a compound, the hull.
fn outline(footprint: &Footprint) -> Vec<Vec2> {
    match footprint.outlines.as_slice() {
        [one] => one.clone(),
        many => convex_hull(&many.concat()),
    }
}

/// Directions from equally spaced points of the outline towards the centroid.
fn contour_directions(footprint: &Footprint, points: usize) -> Vec<Vec2> {
    let outline = outline(footprint);
    let edge = |i: usize| (outline[i], outline[(i + 1) % outline.len()]);
    let length: f64 = (0..outline.len()).map(|i| (edge(i).1 - edge(i).0).norm()).sum();
    let mut found = Vec::with_capacity(points);
    let (mut i, mut walked) = (0, 0.0);
    for k in 0..points {
        let at = length * k as f64 / points as f64;
        while i + 1 < outline.len() && walked + (edge(i).1 - edge(i).0).norm() <= at {
            walked += (edge(i).1 - edge(i).0).norm();
            i += 1;
        }
        let (p, q) = edge(i);
        let point = p + (q - p) * ((at - walked) / (q - p).norm().max(f64::MIN_POSITIVE));
        let d = footprint.centroid - point;
        // A point on the centroid (a ring's inner edge, say) has no direction.
        if d.norm() > 1e-6 {
            found.push(d.normalize());
        }
    }
    found
}

/// The corners of the hull, those farthest from the centroid first.
fn corners_by_distance(footprint: &Footprint) -> Vec<Vec2> {
    let hull = convex_hull(&footprint.outlines.concat());
    let n = hull.len();
    let mut corners: Vec<Vec2> = (0..n)
        .filter(|&i| {
            let (before, after) = (hull[i] - hull[(i + n - 1) % n], hull[(i + 1) % n] - hull[i]);
            (before.x * after.y - before.y * after.x).atan2(before.dot(&after)) > CORNER_TURN
        })
        .map(|i| hull[i])
        .filter(|p| (p - footprint.centroid).norm() > 1e-6)
        .collect();
    let distance = |p: &Vec2| (p - footprint.centroid).norm();
    corners.sort_by(|p, q| distance(q).total_cmp(&distance(p)));
    corners
}
