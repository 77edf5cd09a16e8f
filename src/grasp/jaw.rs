//! Exact queries against convex pieces in the jaw's frame, where fingers and strips are upright rectangles.

use crate::geom::{Footprint, Frame, Piece, Vec2, vec2};

/// Convex pieces in one frame, in memory that is used again.
#[derive(Debug, Default)]
pub(super) struct Pieces {
    points: Vec<Vec2>,
    list: Vec<Moved>,
}

/// A convex piece with its bounds. A disc has one point, its centre.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moved {
    /// Whose piece it is.
    pub body: usize,
    first: usize,
    end: usize,
    radius: f64,
    pub min: Vec2,
    pub max: Vec2,
}

/// A band of the plane: y from `lo` to `hi`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Band {
    pub lo: f64,
    pub hi: f64,
}

impl Band {
    pub fn around(y: f64, half: f64) -> Band {
        Band { lo: y - half, hi: y + half }
    }
}

impl Pieces {
    pub fn clear(&mut self) {
        self.points.clear();
        self.list.clear();
    }

    /// Adds the pieces of a footprint, `frame` being its frame as the jaw sees it.
    pub fn add(&mut self, body: usize, footprint: &Footprint, frame: &Frame) {
        for piece in &footprint.pieces {
            let first = self.points.len();
            let (radius, min, max) = match piece {
                Piece::Disc { centre, radius } => {
                    let c = frame.point(*centre);
                    self.points.push(c);
                    (*radius, c.add_scalar(-radius), c.add_scalar(*radius))
                }
                Piece::Convex(corners) => {
                    let (mut min, mut max) = (vec2(f64::INFINITY, f64::INFINITY), vec2(-f64::INFINITY, -f64::INFINITY));
                    for p in corners {
                        let p = frame.point(*p);
                        min = min.inf(&p);
                        max = max.sup(&p);
                        self.points.push(p);
                    }
                    (0.0, min, max)
                }
            };
            self.list.push(Moved { body, first, end: self.points.len(), radius, min, max });
        }
    }

    pub fn iter(&self) -> impl Iterator<Item = &Moved> {
        self.list.iter()
    }

    /// The x that the piece takes up within the band: an interval, the piece being convex.
    pub fn slice(&self, piece: &Moved, band: Band) -> Option<(f64, f64)> {
        if piece.min.y > band.hi || piece.max.y < band.lo {
            return None;
        }
        if piece.min.y >= band.lo && piece.max.y <= band.hi {
            return Some((piece.min.x, piece.max.x));
        }
        let points = &self.points[piece.first..piece.end];
        if let [centre] = points {
            let dy = (band.lo - centre.y).max(centre.y - band.hi).max(0.0);
            let half = (piece.radius * piece.radius - dy * dy).max(0.0).sqrt();
            return Some((centre.x - half, centre.x + half));
        }
        let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut p = points[points.len() - 1];
        for &q in points {
            if q.y >= band.lo && q.y <= band.hi {
                min = min.min(q.x);
                max = max.max(q.x);
            }
            for y in [band.lo, band.hi] {
                if (p.y < y) != (q.y < y) {
                    let x = p.x + (q.x - p.x) * ((y - p.y) / (q.y - p.y));
                    min = min.min(x);
                    max = max.max(x);
                }
            }
            p = q;
        }
        (min <= max).then_some((min, max))
    }

    /// The y that the piece takes up within the band where x is at least `least` on one side (1: towards +x, -1: where -x
    /// is at least `least`).
    pub fn beyond(&self, piece: &Moved, band: Band, side: f64, least: f64) -> Option<(f64, f64)> {
        if (piece.max.x * side).max(piece.min.x * side) < least || piece.min.y > band.hi || piece.max.y < band.lo {
            return None;
        }
        let points = &self.points[piece.first..piece.end];
        let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut meet = |x: f64, y: f64| {
            if x >= least && y >= band.lo && y <= band.hi {
                min = min.min(y);
                max = max.max(y);
            }
        };
        if let [centre] = points {
            let dx = (least - centre.x * side).max(0.0);
            let half = (piece.radius * piece.radius - dx * dx).max(0.0).sqrt();
            let (lo, hi) = ((centre.y - half).max(band.lo), (centre.y + half).min(band.hi));
            return (lo <= hi).then_some((lo, hi));
        }
        // The region's ends along y are corners of the piece or where its edges leave the region.
        let last = points[points.len() - 1];
        let mut p = (last.x * side, last.y);
        for q in points {
            let q = (q.x * side, q.y);
            meet(q.0, q.1);
            for y in [band.lo, band.hi] {
                if (p.1 < y) != (q.1 < y) {
                    meet(p.0 + (q.0 - p.0) * ((y - p.1) / (q.1 - p.1)), y);
                }
            }
            if (p.0 < least) != (q.0 < least) {
                meet(least, p.1 + (q.1 - p.1) * ((least - p.0) / (q.0 - p.0)));
            }
            p = q;
        }
        (min <= max).then_some((min, max))
    }

    /// How far a rectangle can grow on all sides before it meets the piece, metres; negative: how far it must shrink.
    /// Values from `cap` on may be too small, but are at least `cap`.
    pub fn growth(&self, piece: &Moved, centre: Vec2, half: Vec2, cap: f64) -> f64 {
        let apart = (piece.min.x - centre.x - half.x)
            .max(centre.x - half.x - piece.max.x)
            .max(piece.min.y - centre.y - half.y)
            .max(centre.y - half.y - piece.max.y);
        if apart >= cap {
            return apart;
        }
        let points = &self.points[piece.first..piece.end];
        if let [disc] = points {
            // Growing moves the sides outwards one for one; round a corner the disc is met later.
            let (qx, qy) = ((disc.x - centre.x).abs() - half.x, (disc.y - centre.y).abs() - half.y);
            let face = qx.max(qy) - piece.radius;
            if qx.min(qy) <= face {
                return face;
            }
            let d = qx - qy;
            return (qx + qy) / 2.0 - (piece.radius * piece.radius / 2.0 - d * d / 4.0).max(0.0).sqrt();
        }
        // Two convex polygons are apart if a side of one separates them, and growing keeps the sides' directions: the
        // bounds above are the rectangle's own sides, the rest are the piece's.
        let mut best = apart;
        let mut p = points[points.len() - 1] - centre;
        for q in points {
            let q = q - centre;
            let n = vec2(q.y - p.y, p.x - q.x);
            let (ax, ay) = (n.x.abs(), n.y.abs());
            best = best.max((-n.dot(&p) - ax * half.x - ay * half.y) / (ax + ay).max(f64::MIN_POSITIVE));
            p = q;
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Pose2, Shape};

    fn pieces(shape: Shape, pose: Pose2) -> Pieces {
        let mut pieces = Pieces::default();
        pieces.add(0, &Footprint::new(shape).unwrap(), &pose.frame());
        pieces
    }

    #[test]
    fn slices_of_a_diamond_and_a_disc() {
        let r = 0.02f64;
        let diamond = Shape::ConvexPolygon(vec![[r, 0.0], [0.0, r], [-r, 0.0], [0.0, -r]]);
        for (shape, half_at) in [
            (diamond, Box::new(|y: f64| 0.02 - y.abs()) as Box<dyn Fn(f64) -> f64>),
            (Shape::Disc { radius: r }, Box::new(move |y: f64| (r * r - y * y).sqrt())),
        ] {
            let p = pieces(shape, Pose2::new(0.1, 0.3, 0.0));
            let piece = p.iter().next().unwrap();
            for (lo, hi, widest) in [(0.005, 0.01, 0.005), (-0.01, 0.03, 0.0), (-0.05, -0.012, -0.012)] {
                let (a, b) = p.slice(piece, Band { lo: 0.3 + lo, hi: 0.3 + hi }).unwrap();
                let want = half_at(widest);
                assert!((a - (0.1 - want)).abs() < 1e-12 && (b - (0.1 + want)).abs() < 1e-12, "{lo} {hi}: {a} {b}");
            }
            assert!(p.slice(piece, Band { lo: 0.321, hi: 0.4 }).is_none());
        }
    }

    #[test]
    fn what_lies_beyond_a_line_has_an_extent() {
        let square = pieces(Shape::rectangle(0.04, 0.06), Pose2::new(0.1, 0.3, 0.0));
        let disc = pieces(Shape::Disc { radius: 0.02 }, Pose2::new(0.1, 0.3, 0.0));
        let r = 0.02f64;
        let diamond =
            pieces(Shape::ConvexPolygon(vec![[r, 0.0], [0.0, r], [-r, 0.0], [0.0, -r]]), Pose2::new(0.1, 0.3, 0.0));
        let chord = (r * r - 0.018f64.powi(2)).sqrt();
        for (pieces, half, wanted) in [
            (&square, 0.03, 0.03),
            (&square, 0.011, 0.011),
            (&disc, 0.03, chord),
            (&disc, 0.001, 0.001),
            (&diamond, 0.03, 0.002),
        ] {
            let piece = pieces.iter().next().unwrap();
            for (side, least) in [(1.0, 0.118), (-1.0, -0.082)] {
                let (lo, hi) = pieces.beyond(piece, Band::around(0.3, half), side, least).unwrap();
                assert!(
                    (lo - (0.3 - wanted)).abs() < 1e-12 && (hi - (0.3 + wanted)).abs() < 1e-12,
                    "{wanted}: {lo} {hi}"
                );
                assert!(pieces.beyond(piece, Band::around(0.3, half), side, least + 0.003).is_none());
                assert!(pieces.beyond(piece, Band::around(0.35, 0.01), side, least).is_none());
            }
        }
    }

    #[test]
    fn growth_is_where_the_grown_rectangle_first_touches() {
        let shapes = [
            Shape::rectangle(0.03, 0.05),
            Shape::Disc { radius: 0.02 },
            Shape::ConvexPolygon(vec![[0.02, 0.03], [-0.02, 0.0], [0.02, -0.03]]),
        ];
        for (i, shape) in shapes.into_iter().enumerate() {
            let f = Footprint::new(shape.clone()).unwrap();
            for k in 0..300 {
                let r = |prime: f64| (k as f64 * prime.sqrt() + i as f64 * 0.37).fract() - 0.5;
                let pose = Pose2::new(0.14 * r(2.0), 0.14 * r(3.0), 6.3 * r(5.0));
                let p = pieces(shape.clone(), pose);
                let growth = p.growth(p.iter().next().unwrap(), vec2(0.0, 0.0), vec2(0.02, 0.01), f64::INFINITY);
                let meets = |grown: f64| {
                    let tool = crate::geom::Obb {
                        centre: vec2(0.0, 0.0),
                        axis: vec2(1.0, 0.0),
                        half: [0.02 + grown, 0.01 + grown],
                    };
                    tool.overlaps(&f, &pose.frame())
                };
                if growth > -0.0099 {
                    assert!(!meets(growth - 1e-9) && meets(growth + 1e-9), "{i} {k}: {growth}");
                }
            }
        }
    }
}
