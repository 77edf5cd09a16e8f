//! Splits a simple polygon into convex pieces.

use super::pose::Vec2;
use super::simple::outline_fault;
use super::triangulate::{merged, triangles};
use crate::error::{Error, Result};

/// How far a merged piece may be dented, in sizes of the polygon: rounding bends what is straight by less.
const DENT: f64 = 1e-12;

/// Convex, counter-clockwise pieces whose union is the simple, counter-clockwise polygon `points`.
/// The number of pieces is at most four times the least possible.
pub fn convex_pieces(points: &[Vec2]) -> Result<Vec<Vec<Vec2>>> {
    let refused = || {
        let fault = outline_fault(points).map_or_else(|| "is not simple".into(), |fault| fault.describe(points));
        Error::argument("points", format!("{fault}; give the corners counter-clockwise round the outline"))
    };
    if points.len() < 3 {
        return Err(Error::argument("points", format!("are {}; a polygon needs at least 3", points.len())));
    }
    let triangles = triangles(points).ok_or_else(refused)?;
    let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    let pieces = merged(points, &triangles, DENT * size);
    Ok(pieces.into_iter().map(|piece| piece.into_iter().map(|i| points[i]).collect()).collect())
}
