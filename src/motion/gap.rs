//! The signed gap between two convex cores and the direction along which it holds.

use super::shape::Core;
use crate::geom::{Vec2, vec2};

/// Along the unit vector `axis`, every point of the one core lies at least `gap` beyond every point of the other. As a
/// property of two bodies at rest it is their distance; under a motion it tells how long they certainly stay apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Separation {
    /// Metres; where the cores overlap, the negative depth along the best of the edges' normals.
    pub gap: f64,
    /// From the second core to the first.
    pub axis: Vec2,
}

/// Least coordinate of the points along a direction.
#[inline]
fn least(points: &[Vec2], axis: Vec2) -> f64 {
    points.iter().fold(f64::INFINITY, |least, p| least.min(axis.x * p.x + axis.y * p.y))
}

/// The gap between two cores in one frame. Exact (the Euclidean distance) where they are apart, unless the gap exceeds
/// `enough`: then some separating line that shows this much.
pub(super) fn separation(a: &Core, b: &Core, enough: f64) -> Separation {
    let rounding = a.rounding + b.rounding;
    let enough = enough + rounding;
    let mut best = Separation { gap: f64::NEG_INFINITY, axis: vec2(1.0, 0.0) };
    for (n, p) in b.normals.iter().zip(&b.points) {
        let gap = least(&a.points, *n) - n.dot(p);
        if gap > best.gap {
            best = Separation { gap, axis: *n };
        }
    }
    if best.gap <= enough {
        for (n, p) in a.normals.iter().zip(&a.points) {
            let gap = least(&b.points, *n) - n.dot(p);
            if gap > best.gap {
                best = Separation { gap, axis: -*n };
            }
        }
    }
    // Apart, or without edges: the nearest features may be two corners.
    if best.gap <= enough && (best.gap > 0.0 || best.gap == f64::NEG_INFINITY) {
        let mut nearest = (f64::INFINITY, vec2(0.0, 0.0));
        for p in &a.points {
            for q in &b.points {
                let d = *p - *q;
                let square = d.norm_squared();
                if square < nearest.0 {
                    nearest = (square, d);
                }
            }
        }
        let distance = nearest.0.sqrt();
        if distance > 1e-9 {
            let axis = nearest.1 / distance;
            let gap = least(&a.points, axis) + least(&b.points, -axis);
            if gap > best.gap {
                best = Separation { gap, axis };
            }
        } else if best.gap == f64::NEG_INFINITY {
            // Two discs about one point.
            best.gap = 0.0;
        }
    }
    best.gap -= rounding;
    best
}

#[cfg(test)]
mod tests {
    use super::super::shape::MovingShape;
    use super::*;
    use crate::geom::{Footprint, Pose2, Shape, pieces_gap};
    use proptest::prelude::*;

    fn shapes() -> [Shape; 4] {
        [
            Shape::rectangle(0.08, 0.03),
            Shape::Disc { radius: 0.02 },
            Shape::ConvexPolygon(vec![[0.0, 0.0], [0.07, 0.01], [0.02, 0.05]]),
            Shape::ConvexPolygon(vec![[-0.03, 0.0], [0.0, -0.02], [0.04, 0.0], [0.03, 0.03], [-0.01, 0.03]]),
        ]
    }

    proptest! {
        #[test]
        fn the_gap_is_the_distance_that_geom_gives(
            a in 0..4usize, b in 0..4usize, x in -0.12..0.12f64, y in -0.12..0.12f64, ta in -4.0..4.0f64, tb in -4.0..4.0f64,
        ) {
            let (fa, fb) =
                (Footprint::new(shapes()[a].clone()).unwrap(), Footprint::new(shapes()[b].clone()).unwrap());
            let (pa, pb) = (Pose2::new(x, y, ta), Pose2::new(0.0, 0.0, tb));
            let (mut ca, mut cb) = (Core::default(), Core::default());
            ca.place(&MovingShape::new(&fa).cores[0], &pa.frame());
            cb.place(&MovingShape::new(&fb).cores[0], &pb.frame());
            let got = separation(&ca, &cb, f64::INFINITY);
            let want = pieces_gap(&fa, &pa, &fb, &pb);
            // Where they overlap, only the sign and a bound are promised.
            if want > 0.0 {
                prop_assert!((got.gap - want).abs() < 1e-9, "{got:?} {want}");
            } else {
                prop_assert!(got.gap <= 1e-9, "{got:?} {want}");
            }
        }
    }
}
