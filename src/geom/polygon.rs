//! Measures and set operations of polygons given as counter-clockwise lists of corners.

use super::pose::{Vec2, vec2};

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

/// No two edges cross or touch, other than neighbours in their shared corner.
pub fn is_simple(points: &[Vec2]) -> bool {
    let n = points.len();
    let edge = |i: usize| (points[i], points[(i + 1) % n]);
    for i in 0..n {
        let (a, b) = edge(i);
        // A neighbour may only share its corner: it must not fold back onto this edge.
        let (_, c) = edge((i + 1) % n);
        if cross(b - a, c - b).abs() < 1e-18 && (b - a).dot(&(c - b)) < 0.0 {
            return false;
        }
        for j in i + 2..n {
            if (j + 1) % n != i && segments_touch(a, b, edge(j).0, edge(j).1) {
                return false;
            }
        }
    }
    true
}

fn segments_touch(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> bool {
    let on = |p: Vec2, q: Vec2, r: Vec2| {
        r.x <= p.x.max(q.x) && r.x >= p.x.min(q.x) && r.y <= p.y.max(q.y) && r.y >= p.y.min(q.y)
    };
    let (d1, d2) = (cross(b - a, c - a), cross(b - a, d - a));
    let (d3, d4) = (cross(d - c, a - c), cross(d - c, b - c));
    if d1 * d2 < 0.0 && d3 * d4 < 0.0 {
        return true;
    }
    (d1 == 0.0 && on(a, b, c)) || (d2 == 0.0 && on(a, b, d)) || (d3 == 0.0 && on(c, d, a)) || (d4 == 0.0 && on(c, d, b))
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

/// The convex hull, counter-clockwise, without collinear corners (monotone chain).
pub fn convex_hull(points: &[Vec2]) -> Vec<Vec2> {
    let mut p = points.to_vec();
    p.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    p.dedup();
    if p.len() < 3 {
        return p;
    }
    let mut hull: Vec<Vec2> = Vec::with_capacity(p.len() + 1);
    for pass in 0..2 {
        let floor = hull.len() + 1;
        for i in 0..p.len() {
            let q = if pass == 0 { p[i] } else { p[p.len() - 1 - i] };
            while hull.len() > floor
                && cross(hull[hull.len() - 1] - hull[hull.len() - 2], q - hull[hull.len() - 1]) <= 1e-15
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
    fn a_bow_tie_is_not_simple() {
        assert!(!is_simple(&[vec2(0., 0.), vec2(1., 1.), vec2(1., 0.), vec2(0., 1.)]));
        assert!(is_simple(&square(0., 0., 1.)));
        assert!(!is_simple(&[vec2(0., 0.), vec2(1., 0.), vec2(0.5, 0.0), vec2(0.5, 1.0)]), "folds back");
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
    fn point_in_concave_polygon() {
        let l = [vec2(0., 0.), vec2(2., 0.), vec2(2., 1.), vec2(1., 1.), vec2(1., 2.), vec2(0., 2.)];
        assert!(contains_point(&l, vec2(0.5, 1.5)) && !contains_point(&l, vec2(1.5, 1.5)));
        assert!(contains_point(&l, vec2(2.0, 0.5)), "the border counts");
    }
}
