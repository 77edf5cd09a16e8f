//! Plane geometry: poses, polygons, footprints and the exact tests between them.
//!
//! Metres and radians, right-handed, angles counter-clockwise from +x. Double precision throughout;
//! only a `State` stores single precision.

mod apart;
mod clearance;
mod decompose;
mod footprint;
mod outline;
#[cfg(test)]
mod outline_tests;
mod polygon;
mod pose;
mod simple;
mod simplify;
mod triangulate;

pub use apart::footprints_apart;
pub use clearance::{Obb, piece_gap, pieces_gap, pieces_gap_below};
pub use decompose::convex_pieces;
pub use footprint::{CompoundPart, Footprint, MAX_CORNERS, Piece, Shape};
pub(crate) use footprint::{check_corner_count, corners};
pub use polygon::{area, area_moments, clip_convex, contains_point, convex_hull, intersection_area, is_convex};
pub use pose::{Frame, Pose2, Vec2, normalize_angle, vec2};
pub use simple::{OutlineFault, is_simple, outline_fault};
pub use simplify::OUTLINE_TOLERANCE;
pub(crate) use simplify::{kept_corners, run};
