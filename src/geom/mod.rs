//! Plane geometry: poses, polygons, footprints and the exact tests between them.
//!
//! Metres and radians, right-handed, angles counter-clockwise from +x. Double precision throughout;
//! only a `State` stores single precision.

mod apart;
mod clearance;
mod decompose;
mod footprint;
mod outline;
mod polygon;
mod pose;

pub use apart::footprints_apart;
pub use clearance::{Obb, piece_gap, pieces_gap, pieces_gap_below};
pub use decompose::convex_pieces;
pub use footprint::{CompoundPart, Footprint, Piece, Shape};
pub(crate) use footprint::{check_corner_count, corners};
pub use polygon::{
    area, area_moments, clip_convex, contains_point, convex_hull, intersection_area, is_convex, is_simple,
};
pub use pose::{Frame, Pose2, Vec2, normalize_angle, vec2};
