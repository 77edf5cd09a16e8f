//! From an outline of many points to few corners, or to a disc.

use crate::geom::{Vec2, area, is_simple, kept_corners, run, vec2};

/// Angles of corners with a smaller sine are too blunt to be found by intersecting their sides.
const BLUNT: f64 = 0.17;

/// An outline in few numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Simple {
    /// Counter-clockwise corners.
    Polygon(Vec<Vec2>),
    Disc {
        centre: Vec2,
        radius: f64,
    },
}

/// Greatest and root mean square distance of the outline's points from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Deviation {
    pub greatest: f64,
    pub rms: f64,
}

fn deviation(points: &[Vec2], distance: impl Fn(Vec2) -> f64) -> Deviation {
    let (greatest, sum) = points.iter().fold((0.0f64, 0.0), |(greatest, sum), &p| {
        let d = distance(p);
        (greatest.max(d), sum + d * d)
    });
    Deviation { greatest, rms: (sum / points.len().max(1) as f64).sqrt() }
}

fn to_polygon(corners: &[Vec2], p: Vec2) -> f64 {
    let mut least = f64::INFINITY;
    for i in 0..corners.len() {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        let along = b - a;
        let t = ((p - a).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        least = least.min((p - a - along * t).norm_squared());
    }
    least.sqrt()
}

/// Simplifies a counter-clockwise outline within `tolerance` (metres) and keeps `wanted` (square metres) as its area.
/// A disc is taken, where allowed, if it is within the tolerance and no worse than a polygon of six or more corners.
pub(super) fn simplify(
    outline: &[Vec2],
    centroid: Vec2,
    wanted: f64,
    tolerance: f64,
    discs: bool,
) -> Option<(Simple, Deviation)> {
    with(outline, centroid, wanted, tolerance, tolerance, discs)
}

/// [`simplify`] with a tolerance that may have been raised from the `first`.
fn with(
    outline: &[Vec2],
    centroid: Vec2,
    wanted: f64,
    tolerance: f64,
    first: f64,
    discs: bool,
) -> Option<(Simple, Deviation)> {
    let kept = kept_corners(outline, centroid, tolerance, |_| true);
    if kept.len() < 3 {
        return None;
    }
    let plain: Vec<Vec2> = kept.iter().map(|&i| outline[i]).collect();
    let fitted = refit(outline, &kept, tolerance);
    let fewer = refit(outline, &merged(outline, kept, tolerance), tolerance);
    let mut best: Option<(Vec<Vec2>, Deviation)> = None;
    for corners in [fewer, fitted, plain] {
        if corners.len() < 3 || !is_simple(&corners) || area(&corners) <= 0.0 {
            continue;
        }
        let corners = scaled(corners, wanted);
        let off = deviation(outline, |p| to_polygon(&corners, p));
        let better = best.as_ref().is_none_or(|(_, least)| least.greatest > tolerance && off.greatest < least.greatest);
        if better {
            best = Some((corners, off));
        }
    }
    let Some((corners, off)) = best else {
        // Ragged outlines cross themselves once few points are left of them; fewer points do so less.
        return (tolerance < 4.0 * first).then(|| with(outline, centroid, wanted, 2.0 * tolerance, first, discs))?;
    };
    if discs && corners.len() >= 6 {
        let radius = (wanted / std::f64::consts::PI).sqrt();
        let round = deviation(outline, |p| ((p - centroid).norm() - radius).abs());
        if round.greatest <= tolerance && round.rms <= off.rms + 0.05 * tolerance {
            return Some((Simple::Disc { centre: centroid, radius }, round));
        }
    }
    Some((Simple::Polygon(corners), off))
}

/// The same polygon with another area, about its centroid.
fn scaled(corners: Vec<Vec2>, wanted: f64) -> Vec<Vec2> {
    let (area, centroid, _) = crate::geom::area_moments(&corners);
    let factor = (wanted / area).sqrt();
    corners.into_iter().map(|p| centroid + (p - centroid) * factor).collect()
}

/// Takes corners away, the least missed first, while the refitted polygon stays within a part of the tolerance: the
/// steps of the pixels make such corners, and the points at which [`kept_corners`] begins.
fn merged(outline: &[Vec2], mut kept: Vec<usize>, tolerance: f64) -> Vec<usize> {
    const PART: f64 = 0.9;
    // More corners are those of a ragged outline, which stays ragged; trying them all would take long.
    const MOST: usize = 20;
    if kept.len() > MOST {
        return kept;
    }
    let mut fewer = Vec::with_capacity(kept.len());
    while kept.len() > 3 {
        let mut best = (0, f64::INFINITY);
        for k in 0..kept.len() {
            fewer.clear();
            fewer.extend(kept.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, &at)| at));
            let corners = refit(outline, &fewer, tolerance);
            let off = deviation(outline, |p| to_polygon(&corners, p));
            if off.greatest <= PART * tolerance && off.rms < best.1 {
                best = (k, off.rms);
            }
        }
        if best.1 == f64::INFINITY {
            break;
        }
        kept.remove(best.0);
    }
    kept
}

/// The corners where lines fitted to the sides meet: the points between two corners are many, and tell the side better
/// than the corners do.
fn refit(outline: &[Vec2], kept: &[usize], tolerance: f64) -> Vec<Vec2> {
    let (n, count) = (outline.len(), kept.len());
    let lines: Vec<(Vec2, Vec2)> = (0..count)
        .map(|k| {
            let (from, to) = run(outline, kept[k], kept[(k + 1) % count]);
            // Near the corners the outline is rounded off.
            let trim = ((to - from) / 5).min(2);
            fit_line((from + trim..=to - trim).map(|i| outline[i % n]), outline[to % n] - outline[from])
        })
        .collect();
    (0..count)
        .map(|k| {
            let corner = outline[kept[k]];
            let ((p, u), (q, v)) = (lines[(k + count - 1) % count], lines[k]);
            let cross = u.x * v.y - u.y * v.x;
            let meet = p + u * (((q - p).x * v.y - (q - p).y * v.x) / cross);
            if cross.abs() > BLUNT && (meet - corner).norm() <= 2.5 * tolerance {
                return meet;
            }
            let foot = |at: Vec2, along: Vec2| at + along * (corner - at).dot(&along);
            (foot(p, u) + foot(q, v)) * 0.5
        })
        .collect()
}

/// A point and the direction of the line with the least squared distances, directed like `along`.
fn fit_line(points: impl Iterator<Item = Vec2> + Clone, along: Vec2) -> (Vec2, Vec2) {
    let count = points.clone().count().max(1) as f64;
    let middle = points.clone().sum::<Vec2>() / count;
    let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
    for p in points {
        let d = p - middle;
        xx += d.x * d.x;
        yy += d.y * d.y;
        xy += d.x * d.y;
    }
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    let u = vec2(angle.cos(), angle.sin());
    (middle, if u.dot(&along) < 0.0 { -u } else { u })
}
