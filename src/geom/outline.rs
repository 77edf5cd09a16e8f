//! A footprint's outline as a fixed number of points: how networks are told of shapes.

use super::footprint::{Footprint, Piece, corners};
use super::polygon::{convex_hull, edges};
use super::pose::{Vec2, vec2};

impl Footprint {
    /// `N` points evenly spaced by arc length along the outline, counter-clockwise, relative to the centroid of the area, in
    /// the body frame, metres. The first is the outline's first corner. A disc has them on its circle, the first along +x;
    /// a shape of several parts has them on its convex hull.
    pub fn outline_points<const N: usize>(&self) -> [Vec2; N] {
        let mut points = [vec2(0.0, 0.0); N];
        if let [Piece::Disc { radius, .. }] = self.pieces.as_slice() {
            for (i, point) in points.iter_mut().enumerate() {
                let angle = std::f64::consts::TAU * i as f64 / N as f64;
                *point = vec2(angle.cos(), angle.sin()) * *radius;
            }
            return points;
        }
        let hull;
        let ring: &[Vec2] = match self.outlines.as_slice() {
            [one] => one,
            _ => {
                let all: Vec<Vec2> = self.pieces.iter().flat_map(|piece| corners(piece).to_vec()).collect();
                hull = convex_hull(&all);
                &hull
            }
        };
        let length: f64 = edges(ring).map(|(p, q)| (q - p).norm()).sum();
        let (mut next, mut walked) = (0, 0.0);
        for (p, q) in edges(ring) {
            let side = (q - p).norm();
            while next < N {
                let along = length * next as f64 / N as f64 - walked;
                if along >= side {
                    break;
                }
                points[next] = p + (q - p) * (along / side) - self.centroid;
                next += 1;
            }
            walked += side;
        }
        // Rounding may leave the last point to the ring's end, which is its beginning.
        for point in &mut points[next..] {
            *point = ring.first().map_or(vec2(0.0, 0.0), |first| first - self.centroid);
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{CompoundPart, Pose2, Shape};

    #[test]
    fn a_rectangle_has_its_corners_among_its_points() {
        // Round it goes 0.32 m, a centimetre a point.
        let f = Footprint::new(Shape::Polygon(vec![[0.0, 0.0], [0.1, 0.0], [0.1, 0.06], [0.0, 0.06]])).unwrap();
        let points = f.outline_points::<32>();
        let first = f.outlines[0][0] - vec2(0.05, 0.03);
        assert!((points[0] - first).norm() < 1e-12);
        for (p, q) in edges(&points) {
            assert!(((q - p).norm() - 0.01).abs() < 1e-9, "{p} {q}");
        }
        assert!(crate::geom::area(&points) > 0.0059, "counter-clockwise");
    }

    #[test]
    fn a_disc_has_them_on_its_circle_wherever_its_origin_is() {
        let part = CompoundPart { pose: Pose2::new(0.1, 0.2, 1.0), shape: Shape::Disc { radius: 0.02 } };
        let f = Footprint::new(Shape::Compound(vec![part])).unwrap();
        let points = f.outline_points::<32>();
        assert!((points[0] - vec2(0.02, 0.0)).norm() < 1e-12);
        assert!((points[8] - vec2(0.0, 0.02)).norm() < 1e-12);
    }

    #[test]
    fn several_parts_have_them_on_their_hull() {
        let part = |x: f64| CompoundPart { pose: Pose2::new(x, 0.0, 0.0), shape: Shape::rectangle(0.02, 0.02) };
        let f = Footprint::new(Shape::Compound(vec![part(0.0), part(0.02)])).unwrap();
        for p in f.outline_points::<32>() {
            let outside = (p.x.abs() - 0.02).max(p.y.abs() - 0.01);
            assert!(outside.abs() < 1e-12, "{p}");
        }
    }

    #[test]
    fn a_notched_outline_is_followed_into_the_notch() {
        let u = vec![
            [0.0, 0.0],
            [0.06, 0.0],
            [0.06, 0.06],
            [0.04, 0.06],
            [0.04, 0.02],
            [0.02, 0.02],
            [0.02, 0.06],
            [0.0, 0.06],
        ];
        let f = Footprint::new(Shape::Polygon(u)).unwrap();
        let inside =
            f.outline_points::<32>().iter().map(|p| p + f.centroid).filter(|p| (p.y - 0.02).abs() < 1e-9).count();
        assert!(inside >= 1);
    }
}
