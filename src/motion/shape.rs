//! A footprint made ready for sweeping: convex cores with a rounding radius.
//!
//! A polygon is a core with radius 0, a disc a core of one corner. So one routine serves all pairs.

use crate::geom::{Footprint, Frame, Piece, Vec2, vec2};

/// A convex core in some frame.
#[derive(Debug, Clone, Default)]
pub(super) struct Core {
    /// Counter-clockwise corners; one for a disc.
    pub points: Vec<Vec2>,
    /// Outward unit normals, the k-th of the edge from corner k to the next; none for a disc.
    pub normals: Vec<Vec2>,
    /// The core is grown by this, metres.
    pub rounding: f64,
    /// A circle round the grown core.
    pub centre: Vec2,
    pub radius: f64,
    /// Greatest distance of a corner from the frame's origin.
    pub reach: f64,
}

impl Core {
    fn new(piece: &Piece) -> Core {
        match piece {
            Piece::Disc { centre, radius } => Core {
                points: vec![*centre],
                normals: Vec::new(),
                rounding: *radius,
                centre: *centre,
                radius: *radius,
                reach: centre.norm(),
            },
            Piece::Convex(points) => {
                let normals = (0..points.len())
                    .map(|k| {
                        let d = (points[(k + 1) % points.len()] - points[k]).normalize();
                        vec2(d.y, -d.x)
                    })
                    .collect();
                let (centre, radius) = enclosing_circle(points);
                let reach = points.iter().map(|p| p.norm()).fold(0.0, f64::max);
                Core { points: points.clone(), normals, rounding: 0.0, centre, radius, reach }
            }
        }
    }

    /// Makes this core `from` as seen through `frame`, in the memory it has.
    pub fn place(&mut self, from: &Core, frame: &Frame) {
        self.points.clear();
        self.points.extend(from.points.iter().map(|&p| frame.point(p)));
        self.normals.clear();
        self.normals.extend(from.normals.iter().map(|&n| frame.vector(n)));
        self.rounding = from.rounding;
        self.centre = frame.point(from.centre);
        self.radius = from.radius;
    }
}

/// A circle round the points: the better of those about the box's middle and about the mean. Not the least, but near.
fn enclosing_circle(points: &[Vec2]) -> (Vec2, f64) {
    let first = points.first().copied().unwrap_or_default();
    let (min, max) = points.iter().fold((first, first), |(a, b), p| (a.inf(p), b.sup(p)));
    let mean = points.iter().sum::<Vec2>() / points.len().max(1) as f64;
    let radius = |c: Vec2| points.iter().map(|p| (p - c).norm()).fold(0.0, f64::max);
    let (box_middle, a) = ((min + max) / 2.0, radius((min + max) / 2.0));
    let b = radius(mean);
    if a <= b { (box_middle, a) } else { (mean, b) }
}

/// Least extent of grown points in any direction; nearly, where some are grown.
fn width(points: &[(Vec2, f64)]) -> f64 {
    /// Directions looked at, a half turn of them.
    const DIRECTIONS: u32 = 36;
    let extent = |k: u32| {
        let (s, c) = (f64::from(k) * std::f64::consts::PI / f64::from(DIRECTIONS)).sin_cos();
        let along = |sign: f64| {
            points.iter().map(|(p, grown)| sign * (p.x * c + p.y * s) + grown).fold(f64::NEG_INFINITY, f64::max)
        };
        along(1.0) + along(-1.0)
    };
    (0..DIRECTIONS).map(extent).fold(f64::INFINITY, f64::min)
}

/// A body's shape for motions.
#[derive(Debug, Clone)]
pub(super) struct MovingShape {
    pub cores: Vec<Core>,
    /// Corners of the convex hull of all cores, with the rounding of each: what may leave the workspace.
    pub extremes: Vec<(Vec2, f64)>,
    /// Greatest distance of a point of the shape from the body's origin.
    pub radius: f64,
    /// A point within the convex hull, and the greatest distance of a point of the shape from it: the point that the
    /// grid follows, because it is within the workspace wherever the body is.
    pub middle: Vec2,
    pub middle_radius: f64,
    /// Least extent of the convex hull in any direction.
    pub width: f64,
}

impl MovingShape {
    pub fn new(footprint: &Footprint) -> MovingShape {
        let cores: Vec<Core> = footprint.pieces.iter().map(Core::new).collect();
        let mut extremes: Vec<(Vec2, f64)> =
            cores.iter().flat_map(|core| core.points.iter().map(|&p| (p, core.rounding))).collect();
        if cores.iter().all(|core| core.rounding == 0.0) {
            let corners: Vec<Vec2> = extremes.iter().map(|e| e.0).collect();
            extremes = crate::geom::convex_hull(&corners).into_iter().map(|p| (p, 0.0)).collect();
        }
        let middle = extremes.iter().map(|e| e.0).sum::<Vec2>() / extremes.len().max(1) as f64;
        let middle_radius = extremes.iter().map(|e| (e.0 - middle).norm() + e.1).fold(0.0, f64::max);
        let width = width(&extremes);
        MovingShape { cores, extremes, radius: footprint.radius, middle, middle_radius, width }
    }
}
