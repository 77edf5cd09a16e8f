//! Splits a simple polygon into convex pieces: parry's ear clipping, then Hertel and Mehlhorn (1983).

use parry2d::shape::TriMesh;
use parry2d::transformation::hertel_mehlhorn_idx;

use super::polygon::is_convex;
use super::pose::Vec2;
use crate::error::{Error, Result};

/// Convex, counter-clockwise pieces whose union is the simple, counter-clockwise polygon `points`.
/// The number of pieces is at most four times the least possible.
pub fn convex_pieces(points: &[Vec2]) -> Result<Vec<Vec<Vec2>>> {
    if is_convex(points, 0.0) {
        return Ok(vec![points.to_vec()]);
    }
    // parry works in single precision: centre and scale the corners to order one so that nothing is lost,
    // and take back only the indices.
    let centre = points.iter().sum::<Vec2>() / points.len() as f64;
    let size = points.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
    let unit = |p: &Vec2| {
        let q = (p - centre) / size;
        parry2d::math::Vector::new(q.x as f32, q.y as f32)
    };
    let vertices: Vec<_> = points.iter().map(unit).collect();
    let mesh = TriMesh::from_polygon(vertices.clone())
        .ok_or_else(|| Error::argument("points", "the polygon cannot be triangulated; check that no edges cross"))?;
    let pieces = hertel_mehlhorn_idx(&vertices, mesh.indices());
    Ok(pieces.into_iter().map(|piece| piece.into_iter().map(|i| points[i as usize]).collect()).collect())
}

#[cfg(test)]
mod tests {
    use super::super::{polygon::area, pose::vec2};
    use super::*;

    #[test]
    fn an_l_shape_becomes_two_rectangles() {
        let l = [vec2(0., 0.), vec2(2., 0.), vec2(2., 1.), vec2(1., 1.), vec2(1., 2.), vec2(0., 2.)];
        let pieces = convex_pieces(&l).unwrap();
        assert!(pieces.len() <= 3, "{}", pieces.len());
        assert!(pieces.iter().all(|p| is_convex(p, 1e-9)));
        assert!((pieces.iter().map(|p| area(p)).sum::<f64>() - 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_notch_with_an_arc_is_covered_exactly() {
        let mut p = vec![vec2(-0.045, 0.0225), vec2(-0.045, -0.0225), vec2(0.045, -0.0225), vec2(0.045, 0.0225)];
        for i in 0..=16 {
            let a = std::f64::consts::PI * i as f64 / 16.0;
            p.push(vec2(0.0235 * a.cos(), 0.0225 - 0.0235 * a.sin()));
        }
        let total: f64 = convex_pieces(&p).unwrap().iter().map(|q| area(q)).sum();
        assert!((total - area(&p)).abs() < 1e-12);
    }
}
