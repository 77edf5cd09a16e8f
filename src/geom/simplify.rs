//! Outlines with fewer corners, within a tolerance. No corner is moved: some are left out.

use super::polygon::{area_moments, edges, hull_corners};
use super::pose::Vec2;
use super::simple::is_simple;

/// An outline that is rough by less than this loses the corners of its roughness, unless the body says otherwise, metres.
pub const OUTLINE_TOLERANCE: f64 = 1e-4;
/// But by no more than this part of its thickness: a tenth of a millimetre is much on a body of two.
const OF_THICKNESS: f64 = 0.01;
/// How far a corner may lie inside the hull and the polygon still counts as convex, metres.
const CONVEX_SLACK: f64 = 1e-7;
/// Dents of so many tolerances do not count: corners of a convex outline that were rounded to a grid as wide as the
/// tolerance lie half a diagonal of a cell too far in or out.
const DENT: f64 = std::f64::consts::SQRT_2;
/// A tolerance at which the outline would cross itself is halved so many times.
const HALVINGS: u32 = 6;

/// What is left of an outline.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Simplified {
    /// Indices of the corners that stay, ascending.
    pub kept: Vec<usize>,
    /// Greatest distance of a corner that was left out from the edge in its place, metres.
    pub deviation: f64,
    /// What stays is the convex hull, within the tolerance.
    pub convex: bool,
}

/// The tolerance of an outline for which none was asked: 0.1 mm, or a hundredth of the thickness where that is less. The
/// thickness is twice the area over the perimeter: a disc's radius, half a square's side, the width of a long strip.
pub(super) fn usual_tolerance(points: &[Vec2]) -> f64 {
    let perimeter: f64 = edges(points).map(|(a, b)| (b - a).norm()).sum();
    let thickness = 2.0 * super::polygon::area(points).abs() / perimeter;
    OUTLINE_TOLERANCE.min(OF_THICKNESS * thickness)
}

/// Leaves out the corners of a simple, counter-clockwise outline that are of no account within `tolerance` metres; with 0
/// all stay. An outline that is convex but for dents of up to [`DENT`] tolerances becomes convex.
pub(super) fn simplified(points: &[Vec2], tolerance: f64) -> Simplified {
    let mut hull = hull_corners(points);
    hull.sort_unstable();
    let convex =
        runs(points, &hull).all(|(from, to)| deviation_of(points, from, to) <= (DENT * tolerance).max(CONVEX_SLACK));
    let all = || Simplified { kept: (0..points.len()).collect(), deviation: 0.0, convex };
    if tolerance <= 0.0 {
        return all();
    }
    let (_, centroid, _) = area_moments(points);
    let mut on_hull = vec![!convex; points.len()];
    hull.iter().for_each(|&i| on_hull[i] = true);
    for halving in 0..HALVINGS {
        let tolerance = tolerance / f64::from(1u32 << halving);
        let kept = kept_corners(points, centroid, tolerance, |i| on_hull[i]);
        let left: Vec<Vec2> = kept.iter().map(|&i| points[i]).collect();
        if kept.len() >= 3 && (convex || is_simple(&left)) {
            let deviation = runs(points, &kept).map(|(from, to)| deviation_of(points, from, to)).fold(0.0, f64::max);
            return Simplified { kept, deviation, convex };
        }
    }
    all()
}

/// The stretches between corners that follow each other, as indices that may pass the end of the outline.
fn runs<'a>(points: &'a [Vec2], corners: &'a [usize]) -> impl Iterator<Item = (usize, usize)> + 'a {
    (0..corners.len()).map(|k| run(points, corners[k], corners[(k + 1) % corners.len()]))
}

/// The indices from one corner to another, which may pass the end of the outline.
pub(crate) fn run(outline: &[Vec2], from: usize, to: usize) -> (usize, usize) {
    (from, if to > from { to } else { to + outline.len() })
}

/// Greatest distance of the points between two corners from the straight line between these.
fn deviation_of(points: &[Vec2], from: usize, to: usize) -> f64 {
    let n = points.len();
    let (a, b) = (points[from % n], points[to % n]);
    (from + 1..to).map(|i| distance_to_segment(points[i % n], a, b)).fold(0.0, f64::max)
}

fn distance_to_segment(p: Vec2, a: Vec2, b: Vec2) -> f64 {
    let along = b - a;
    let length = along.norm().max(f64::MIN_POSITIVE);
    let p = p - a;
    let t = (p.dot(&along) / (length * length)).clamp(0.0, 1.0);
    (p - along * t).norm()
}

/// Indices of the points that remain when those nearer than `tolerance` to the line between their neighbours go
/// (Ramer 1972, Douglas and Peucker 1973), beginning at the point farthest from `about`, which is one that `may_stay`.
pub(crate) fn kept_corners(
    outline: &[Vec2],
    about: Vec2,
    tolerance: f64,
    may_stay: impl Fn(usize) -> bool,
) -> Vec<usize> {
    let n = outline.len();
    let farthest = |from: Vec2| {
        (0..n).fold((0, -1.0), |best, i| {
            let d = (outline[i] - from).norm_squared();
            if d > best.1 { (i, d) } else { best }
        })
    };
    let (first, _) = farthest(about);
    let (second, _) = farthest(outline[first]);
    if first == second {
        return Vec::new();
    }
    let mut kept = vec![first, second];
    let mut runs = vec![run(outline, first, second), run(outline, second, first)];
    while let Some((from, to)) = runs.pop() {
        let (a, b) = (outline[from % n], outline[to % n]);
        let mut off = false;
        let mut worst = (from, f64::NEG_INFINITY);
        for i in from + 1..to {
            let d = distance_to_segment(outline[i % n], a, b);
            off |= d > tolerance;
            if d > worst.1 && may_stay(i % n) {
                worst = (i, d);
            }
        }
        if off && worst.0 != from {
            kept.push(worst.0 % n);
            runs.push((from, worst.0));
            runs.push((worst.0, to));
        }
    }
    kept.sort_unstable();
    kept.dedup();
    kept
}
