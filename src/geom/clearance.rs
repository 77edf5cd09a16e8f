//! Signed gaps between convex pieces: exact where they overlap along a separating axis, never too large elsewhere.

use super::footprint::{Footprint, Piece};
use super::polygon::edges;
use super::pose::{Frame, Pose2, Vec2, vec2};

/// An oriented rectangle in the world frame: the footprint of a tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Obb {
    pub centre: Vec2,
    /// Unit vector of the first axis.
    pub axis: Vec2,
    /// Half extents along the first axis and across it, metres.
    pub half: [f64; 2],
}

impl Obb {
    /// Corners, counter-clockwise.
    pub fn corners(&self) -> [Vec2; 4] {
        let (u, v) = (self.axis * self.half[0], vec2(-self.axis.y, self.axis.x) * self.half[1]);
        let c = self.centre;
        [c - u - v, c + u - v, c + u + v, c - u + v]
    }

    /// Grown by `margin` on every side.
    pub fn grown(&self, margin: f64) -> Obb {
        Obb { half: [self.half[0] + margin, self.half[1] + margin], ..*self }
    }

    /// Gap to a body, metres: negative where they overlap.
    pub fn gap_to(&self, footprint: &Footprint, pose: &Pose2) -> f64 {
        // The circle round the body settles most queries.
        let away = (pose.position() - self.centre).norm() - footprint.radius - self.half[0].hypot(self.half[1]);
        if away > 0.05 {
            return away;
        }
        let frame = pose.frame();
        let corners = self.corners().map(|c| frame.inverse_point(c));
        footprint.pieces.iter().map(|piece| polygon_piece_gap(&corners, piece)).fold(f64::INFINITY, f64::min)
    }
}

impl Obb {
    /// Whether the rectangle and a body share more than their borders. The body's pose is given as its frame, so that
    /// a caller with many rectangles works out sine and cosine once. Much faster than [`Obb::gap_to`]: no square root,
    /// no memory, and it stops at the first separating line.
    pub fn overlaps(&self, footprint: &Footprint, frame: &Frame) -> bool {
        let away = frame.origin - self.centre;
        let reach = footprint.radius + (self.half[0] * self.half[0] + self.half[1] * self.half[1]).sqrt();
        away.norm_squared() < reach * reach && self.overlaps_near(footprint, frame)
    }

    /// As [`Obb::overlaps`], for a body that is known to be near.
    pub(crate) fn overlaps_near(&self, footprint: &Footprint, frame: &Frame) -> bool {
        let away = frame.origin - self.centre;
        // The body's frame as the rectangle sees it.
        let seen = Frame {
            origin: vec2(away.dot(&self.axis), self.axis.x * away.y - self.axis.y * away.x),
            sin: frame.sin * self.axis.x - frame.cos * self.axis.y,
            cos: frame.cos * self.axis.x + frame.sin * self.axis.y,
        };
        footprint.pieces.iter().any(|piece| match piece {
            Piece::Disc { centre, radius } => {
                let c = seen.point(*centre);
                let (x, y) = ((c.x.abs() - self.half[0]).max(0.0), (c.y.abs() - self.half[1]).max(0.0));
                x * x + y * y < radius * radius
            }
            Piece::Convex(points) => self.overlaps_convex(points, &seen),
        })
    }

    /// Separating lines along the polygon's edges and the rectangle's own, in the rectangle's frame.
    fn overlaps_convex(&self, points: &[Vec2], seen: &Frame) -> bool {
        let Some(last) = points.last() else { return false };
        let [hx, hy] = self.half;
        let mut p = seen.point(*last);
        let (mut min, mut max) = (p, p);
        for q in points {
            let q = seen.point(*q);
            let (nx, ny) = (q.y - p.y, p.x - q.x);
            if nx * p.x + ny * p.y <= -(nx.abs() * hx + ny.abs() * hy) {
                return false;
            }
            min = min.inf(&q);
            max = max.sup(&q);
            p = q;
        }
        min.x < hx && max.x > -hx && min.y < hy && max.y > -hy
    }
}

/// Greatest signed distance along the edge normals of `a` to the piece `b`, both in one frame.
fn face_gap(a: &[Vec2], b: &Piece) -> f64 {
    edges(a)
        .map(|(p, q)| {
            let d = (q - p).normalize();
            let n = vec2(d.y, -d.x);
            -b.support(-n) - n.dot(&p)
        })
        .fold(f64::NEG_INFINITY, f64::max)
}

fn vertex_gap(points: &[Vec2], centre: Vec2) -> f64 {
    // Distance from a disc's centre to the nearest boundary point of a polygon, negative inside.
    let mut outside = false;
    let mut best = f64::INFINITY;
    for (a, b) in edges(points) {
        let (ab, ac) = (b - a, centre - a);
        let t = (ac.dot(&ab) / ab.norm_squared()).clamp(0.0, 1.0);
        best = best.min((ac - ab * t).norm());
        outside |= ab.x * ac.y - ab.y * ac.x < 0.0;
    }
    if outside { best } else { -best }
}

fn polygon_piece_gap(a: &[Vec2], b: &Piece) -> f64 {
    match b {
        Piece::Disc { centre, radius } => vertex_gap(a, *centre) - radius,
        Piece::Convex(points) => {
            let separation = face_gap(a, b).max(
                edges(points)
                    .map(|(p, q)| {
                        let d = (q - p).normalize();
                        let n = vec2(d.y, -d.x);
                        a.iter().map(|c| n.dot(c)).fold(f64::INFINITY, f64::min) - n.dot(&p)
                    })
                    .fold(f64::NEG_INFINITY, f64::max),
            );
            if separation <= 0.0 {
                return separation;
            }
            // Apart: the true distance may be from corner to corner.
            let to = |points: &[Vec2], others: &[Vec2]| {
                others.iter().map(|&c| vertex_gap(points, c)).filter(|d| *d >= 0.0).fold(f64::INFINITY, f64::min)
            };
            to(a, points).min(to(points, a))
        }
    }
}

/// Signed gap between two pieces, `b` given in the frame of `a` by `b_in_a`; metres, negative is penetration depth.
pub fn piece_gap(a: &Piece, b: &Piece, b_in_a: &Frame) -> f64 {
    let moved = match b {
        Piece::Convex(points) => Piece::Convex(points.iter().map(|&p| b_in_a.point(p)).collect()),
        Piece::Disc { centre, radius } => Piece::Disc { centre: b_in_a.point(*centre), radius: *radius },
    };
    match (a, &moved) {
        (Piece::Convex(points), _) => polygon_piece_gap(points, &moved),
        (_, Piece::Convex(points)) => polygon_piece_gap(points, a),
        (Piece::Disc { centre, radius }, Piece::Disc { centre: c, radius: r }) => (centre - c).norm() - radius - r,
    }
}

/// Signed gap between two bodies at poses in one frame: the least over their pieces.
pub fn pieces_gap(a: &Footprint, pose_a: &Pose2, b: &Footprint, pose_b: &Pose2) -> f64 {
    let away = (pose_a.position() - pose_b.position()).norm() - a.radius - b.radius;
    if away > 0.05 {
        return away;
    }
    let frame = pose_a.inverse().compose(pose_b).frame();
    a.pieces
        .iter()
        .flat_map(|p| b.pieces.iter().map(move |q| (p, q)))
        .map(|(p, q)| piece_gap(p, q, &frame))
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::super::footprint::Shape;
    use super::*;

    fn gap(a: Shape, pa: Pose2, b: Shape, pb: Pose2) -> f64 {
        pieces_gap(&Footprint::new(a).unwrap(), &pa, &Footprint::new(b).unwrap(), &pb)
    }

    #[test]
    fn gaps_of_squares_and_discs() {
        let sq = || Shape::rectangle(0.04, 0.04);
        let disc = || Shape::Disc { radius: 0.02 };
        let at = Pose2::new;
        for (a, b, pose, want) in [
            (sq(), sq(), at(0.05, 0.0, 0.0), 0.01),
            (sq(), sq(), at(0.03, 0.0, 0.0), -0.01),
            (sq(), sq(), at(0.05, 0.05, 0.0), 0.01 * 2f64.sqrt()),
            (sq(), disc(), at(0.05, 0.0, 1.0), 0.01),
            (disc(), sq(), at(0.05, 0.05, 0.0), (0.03f64.powi(2) * 2.0).sqrt() - 0.02),
            (disc(), disc(), at(0.03, 0.0, 0.0), -0.01),
            (sq(), disc(), at(0.0, 0.0, 0.0), -0.04),
        ] {
            let got = gap(a.clone(), Pose2::IDENTITY, b.clone(), pose);
            assert!((got - want).abs() < 1e-9, "{a:?} {b:?} {pose:?}: {got} != {want}");
            // Both in another frame, and the other way round.
            let f = at(0.3, -0.2, 0.7);
            let turned = gap(b, f.compose(&pose), a, f);
            assert!((turned - want).abs() < 1e-9, "{turned} != {want}");
        }
    }

    #[test]
    fn a_tool_rectangle_measures_its_gap() {
        let f = Footprint::new(Shape::rectangle(0.04, 0.04)).unwrap();
        let tool = Obb { centre: vec2(0.05, 0.0), axis: vec2(0.0, 1.0), half: [0.015, 0.01] };
        assert!((tool.gap_to(&f, &Pose2::IDENTITY) - 0.02).abs() < 1e-12);
        assert!((tool.grown(0.02).gap_to(&f, &Pose2::IDENTITY)).abs() < 1e-12);
    }

    #[test]
    fn overlap_agrees_with_the_signed_gap() {
        let l = vec![[-0.04, -0.03], [0.04, -0.03], [0.04, 0.0], [0.0, 0.0], [0.0, 0.03], [-0.04, 0.03]];
        let shapes = [
            Shape::rectangle(0.045, 0.09),
            Shape::Disc { radius: 0.022 },
            Shape::Polygon(l),
            Shape::ConvexPolygon(vec![[0.0225, 0.045], [-0.0225, 0.0], [0.0225, -0.045]]),
        ];
        let mut overlapping = 0;
        for (i, shape) in shapes.into_iter().enumerate() {
            let f = Footprint::new(shape).unwrap();
            for k in 0..2000 {
                // A low-discrepancy walk through positions and angles.
                let r = |prime: f64| (k as f64 * prime.sqrt() + i as f64 * 0.37).fract();
                let pose = Pose2::new(0.16 * r(2.0) - 0.08, 0.16 * r(3.0) - 0.08, 6.3 * r(5.0));
                let a = 6.3 * r(7.0);
                let tool = Obb { centre: vec2(0.0, 0.0), axis: vec2(a.cos(), a.sin()), half: [0.013, 0.017] };
                let gap = tool.gap_to(&f, &pose);
                let got = tool.overlaps(&f, &pose.frame());
                overlapping += usize::from(got);
                assert!(got == (gap < 0.0) || gap.abs() < 1e-9, "{i} {k}: {gap} {got}");
            }
        }
        assert!(overlapping > 1000 && overlapping < 7000, "{overlapping}");
    }
}
