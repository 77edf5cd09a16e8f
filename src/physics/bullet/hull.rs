//! Prisms as Bullet takes them: corners of convex hulls, rounded to single precision.

use super::native::Pieces;
use crate::geom::{Footprint, Piece, Vec2, vec2};

/// Corners that stand for a disc, on its circle: the originals' mesh.
const DISC_CORNERS: usize = 32;

/// The convex pieces of a prism about its centre of mass, their outlines drawn in by `inset` metres.
///
/// Bullet snaps a hull's corners to a grid and truncates, so that the last bit of a coordinate decides over 4
/// micrometres. The originals read single-precision files; so the numbers are rounded here, before they reach C++, where
/// a compiler was seen to drop the rounding.
pub(super) fn prism(footprint: &Footprint, centre: Vec2, height: f64, inset: f64) -> Pieces {
    let mut out = Pieces::default();
    for piece in &footprint.pieces {
        let outline = match piece {
            Piece::Disc { centre, radius } => disc(*centre, (radius - inset).max(0.1 * radius)),
            Piece::Convex(corners) => drawn_in(corners, inset),
        };
        out.sizes.push(2 * outline.len() as u32);
        for z in [-height / 2.0, height / 2.0] {
            for p in &outline {
                out.points.extend([p.x - centre.x, p.y - centre.y, z].map(rounded));
            }
        }
    }
    out
}

/// Rounds to single precision.
pub(super) fn rounded(value: f64) -> f64 {
    f64::from(value as f32)
}

fn disc(centre: Vec2, radius: f64) -> Vec<Vec2> {
    let step = std::f64::consts::TAU / DISC_CORNERS as f64;
    (0..DISC_CORNERS).map(|i| centre + vec2((i as f64 * step).cos(), (i as f64 * step).sin()) * radius).collect()
}

/// A convex outline with every edge moved inwards. An outline too narrow for that shrinks about its middle instead.
fn drawn_in(corners: &[Vec2], inset: f64) -> Vec<Vec2> {
    if inset <= 0.0 {
        return corners.to_vec();
    }
    let n = corners.len();
    let normal = |i: usize| {
        let along = (corners[(i + 1) % n] - corners[i]).normalize();
        vec2(along.y, -along.x)
    };
    let moved: Vec<Vec2> = (0..n)
        .map(|i| {
            // The corner lies on the edge before it and the edge after it.
            let (a, b) = (normal((i + n - 1) % n), normal(i));
            let cosine = a.dot(&b);
            corners[i] - (a + b) * (inset / (1.0 + cosine).max(0.05))
        })
        .collect();
    let inside = (0..n).all(|i| (moved[(i + 1) % n] - moved[i]).dot(&(corners[(i + 1) % n] - corners[i])) > 0.0);
    if inside {
        return moved;
    }
    let middle = corners.iter().sum::<Vec2>() / n as f64;
    corners.iter().map(|p| middle + (p - middle) * 0.9).collect()
}

#[cfg(test)]
mod tests {
    use super::super::native;
    use super::*;
    use crate::geom::{Shape, area};

    /// The originals' cube: Bullet truncates 0.0225 in single precision to this. In double precision it would be
    /// another grid point, and so it was where the compiler dropped the rounding.
    #[test]
    fn a_cubes_corners_are_those_of_single_precision() {
        let square = Footprint::new(Shape::rectangle(0.045, 0.045)).unwrap();
        let pieces = prism(&square, vec2(0.0, 0.0), 0.045, 0.0);
        assert!(pieces.points.iter().all(|v| f64::from(*v as f32) == *v));
        let hull = native::hull(&pieces.points, 0.001).unwrap();
        assert_eq!(hull.len(), 8);
        for v in hull.iter().flatten() {
            assert!((v.abs() - 0.022495596).abs() < 1e-9 || (v.abs() - 0.0225).abs() < 1e-9, "{hull:?}");
        }
        let first = hull[0][0].abs();
        assert!((first - 0.022495596).abs() < 1e-9, "{first}");
    }

    #[test]
    fn an_outline_is_drawn_in_edge_by_edge() {
        let corners = [vec2(0.0, 0.0), vec2(0.04, 0.0), vec2(0.04, 0.02), vec2(0.0, 0.02)];
        assert_eq!(drawn_in(&corners, 0.0), corners);
        let inner = drawn_in(&corners, 0.001);
        assert!((area(&inner) - 0.038 * 0.018).abs() < 1e-12, "{inner:?}");
        let thin = [vec2(0.0, 0.0), vec2(0.04, 0.0), vec2(0.04, 0.0015), vec2(0.0, 0.0015)];
        let inner = drawn_in(&thin, 0.001);
        assert!(area(&inner) > 0.0 && inner.iter().all(|p| p.y > 0.0 && p.y < 0.0015), "{inner:?}");
    }
}
