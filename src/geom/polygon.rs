//! Measures and set operations of polygons given as counter-clockwise lists of corners.

use super::pose::{Vec2, vec2};
use super::triangulate::orientation;

#[inline]
pub(crate) fn cross(a: Vec2, b: Vec2) -> f64 {
    a.x * b.y - a.y * b.x
}

/// The directed edges of a closed polygon.
pub(crate) fn edges(points: &[Vec2]) -> impl Iterator<Item = (Vec2, Vec2)> + '_ {
    (0..points.len()).map(move |i| (points[i], points[(i + 1) % points.len()]))
}

/// Signed area in square metres, positive when the corners run counter-clockwise.
pub fn area(points: &[Vec2]) -> f64 {
    edges(points).map(|(a, b)| cross(a, b)).sum::<f64>() * 0.5
}

/// Area, centroid, and second moment of area about the centroid (m^4) of a simple polygon.
pub fn area_moments(points: &[Vec2]) -> (f64, Vec2, f64) {
    // Sums about the first corner keep the cancellation small far from the origin.
    let o = points[0];
    let (mut a2, mut m1, mut m2) = (0.0, Vec2::zeros(), 0.0);
    for (p, q) in edges(points) {
        let (p, q) = (p - o, q - o);
        let c = cross(p, q);
        a2 += c;
        m1 += (p + q) * c;
        m2 += c * (p.dot(&p) + p.dot(&q) + q.dot(&q));
    }
    let a = a2 * 0.5;
    let centroid = m1 / (3.0 * a2);
    (a, centroid + o, m2 / 12.0 - a * centroid.norm_squared())
}

/// Every corner turns left (within `slack` metres of straight).
pub fn is_convex(points: &[Vec2], slack: f64) -> bool {
    let n = points.len();
    (0..n).all(|i| {
        let (a, b, c) = (points[i], points[(i + 1) % n], points[(i + 2) % n]);
        let base = (c - a).norm().max(f64::MIN_POSITIVE);
        cross(b - a, c - a) >= -slack * base
    })
}

/// The point lies inside or on the border of a simple polygon.
pub fn contains_point(points: &[Vec2], p: Vec2) -> bool {
    let mut inside = false;
    for (a, b) in edges(points) {
        if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
            inside = !inside;
        }
        let (ab, ap) = (b - a, p - a);
        if cross(ab, ap).abs() <= 1e-12 * ab.norm() && ap.dot(&ab) >= 0.0 && ap.dot(&ab) <= ab.norm_squared() {
            return true;
        }
    }
    inside
}

/// Twice the area by which a corner of a hull may stand out and still be taken for straight, square metres.
const STRAIGHT: f64 = 1e-15;

/// The convex hull, counter-clockwise from the leftmost corner, without corners that are straight but for rounding.
pub fn convex_hull(points: &[Vec2]) -> Vec<Vec2> {
    let exact = hull_corners(points);
    let mut hull: Vec<Vec2> = Vec::with_capacity(exact.len());
    let straight = |a: Vec2, b: Vec2, c: Vec2| cross(b - a, c - b) <= STRAIGHT;
    for q in exact.into_iter().map(|i| points[i]) {
        while hull.len() > 1 && straight(hull[hull.len() - 2], hull[hull.len() - 1], q) {
            hull.pop();
        }
        hull.push(q);
    }
    while hull.len() > 2 && straight(hull[hull.len() - 2], hull[hull.len() - 1], hull[0]) {
        hull.pop();
    }
    while hull.len() > 2 && straight(hull[hull.len() - 1], hull[0], hull[1]) {
        hull.remove(0);
    }
    hull
}

/// Indices of the corners of the convex hull, counter-clockwise from the leftmost (monotone chain), by exact signs: where
/// many points lie on a line but for rounding, a tolerance on the way could lose the ends of the line.
pub(super) fn hull_corners(points: &[Vec2]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&i, &j| points[i].x.total_cmp(&points[j].x).then(points[i].y.total_cmp(&points[j].y)));
    order.dedup_by(|i, j| points[*i] == points[*j]);
    if order.len() < 3 {
        return order;
    }
    let mut hull: Vec<usize> = Vec::with_capacity(order.len() + 1);
    for pass in 0..2 {
        let floor = hull.len() + 1;
        for k in 0..order.len() {
            let q = if pass == 0 { order[k] } else { order[order.len() - 1 - k] };
            while hull.len() > floor
                && orientation(points[hull[hull.len() - 2]], points[hull[hull.len() - 1]], points[q]) <= 0.0
            {
                hull.pop();
            }
            hull.push(q);
        }
        hull.pop();
    }
    hull
}

/// The part of convex polygon `subject` inside convex polygon `clip` (Sutherland and Hodgman 1974), into `out`.
/// `spare` is working memory; both are overwritten.
pub fn clip_convex(subject: &[Vec2], clip: &[Vec2], out: &mut Vec<Vec2>, spare: &mut Vec<Vec2>) {
    out.clear();
    out.extend_from_slice(subject);
    for (a, b) in edges(clip) {
        std::mem::swap(out, spare);
        out.clear();
        let side = |p: Vec2| cross(b - a, p - a);
        for (p, q) in edges(spare) {
            let (sp, sq) = (side(p), side(q));
            if sp >= 0.0 {
                out.push(p);
            }
            if (sp > 0.0 && sq < 0.0) || (sp < 0.0 && sq > 0.0) {
                out.push(p + (q - p) * (sp / (sp - sq)));
            }
        }
        if out.is_empty() {
            return;
        }
    }
}

/// Area that two convex polygons share.
pub fn intersection_area(a: &[Vec2], b: &[Vec2]) -> f64 {
    let (mut out, mut spare) = (Vec::with_capacity(a.len() + b.len()), Vec::with_capacity(a.len() + b.len()));
    clip_convex(a, b, &mut out, &mut spare);
    if out.len() < 3 { 0.0 } else { area(&out) }
}

/// A regular polygon of the same area as the disc, for measures that need corners.
pub(crate) fn disc_polygon(centre: Vec2, radius: f64, corners: usize) -> Vec<Vec2> {
    let step = std::f64::consts::TAU / corners as f64;
    let r = radius * (step / step.sin()).sqrt();
    (0..corners).map(|i| centre + vec2((i as f64 * step).cos(), (i as f64 * step).sin()) * r).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64, side: f64) -> Vec<Vec2> {
        vec![vec2(x, y), vec2(x + side, y), vec2(x + side, y + side), vec2(x, y + side)]
    }

    #[test]
    fn moments_of_a_shifted_square() {
        let (a, c, j) = area_moments(&square(5.0, -3.0, 2.0));
        assert!((a - 4.0).abs() < 1e-12 && (c - vec2(6.0, -2.0)).norm() < 1e-12);
        assert!((j - 4.0 * (4.0 + 4.0) / 12.0).abs() < 1e-9, "{j}");
    }

    #[test]
    fn clipping_overlapping_squares() {
        assert!((intersection_area(&square(0., 0., 1.), &square(0.5, 0.5, 1.)) - 0.25).abs() < 1e-12);
        assert_eq!(intersection_area(&square(0., 0., 1.), &square(2., 0., 1.)), 0.0);
    }

    #[test]
    fn hull_drops_inner_and_collinear_points() {
        let mut p = square(0., 0., 1.);
        p.extend([vec2(0.5, 0.5), vec2(0.5, 0.0), vec2(1.0, 0.25)]);
        let h = convex_hull(&p);
        assert_eq!(h.len(), 4);
        assert!((area(&h) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_hull_keeps_the_ends_of_lines_that_rounding_bends() {
        // Points along the sides of a rectangle, off them by rounding, at every turn.
        for turn in 0..360 {
            let (sin, cos) = (f64::from(turn) * std::f64::consts::PI / 180.0).sin_cos();
            let side = |k: usize, t: f64| {
                let p = [vec2(t, 0.0), vec2(1.0, 2.0 * t), vec2(1.0 - t, 2.0), vec2(0.0, 2.0 - 2.0 * t)][k] * 0.03;
                let noise = 1e-17 * f64::from((turn * 31 + (t * 80.0) as i32 * 17) % 7 - 3);
                vec2(p.x * cos - p.y * sin + noise, p.x * sin + p.y * cos - noise)
            };
            let points: Vec<Vec2> = (0..4).flat_map(|k| (0..8).map(move |i| side(k, f64::from(i) / 8.0))).collect();
            let hull = convex_hull(&points);
            assert_eq!(hull.len(), 4, "{turn}: {hull:?}");
            assert!((area(&hull) - 1.8e-3).abs() < 1e-15, "{turn}: {}", area(&hull));
        }
    }

    #[test]
    fn point_in_concave_polygon() {
        let l = [vec2(0., 0.), vec2(2., 0.), vec2(2., 1.), vec2(1., 1.), vec2(1., 2.), vec2(0., 2.)];
        assert!(contains_point(&l, vec2(0.5, 1.5)) && !contains_point(&l, vec2(1.5, 1.5)));
        assert!(contains_point(&l, vec2(2.0, 0.5)), "the border counts");
    }
}
