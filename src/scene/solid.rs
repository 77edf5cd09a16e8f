//! Lays a prism with a pose in space down in the plane: its outline from above, height, heading and mass.
//!
//! A prism within [`RESTS_WITHIN`] of lying on one of its six sides is taken to lie flat on it, as it does when the
//! simulators let it settle. Standing on its base it keeps its outline, upside down the mirrored one, and on any other
//! side (or none) it becomes the silhouette: the convex hull of its shadow. A notch in a silhouette is filled: the push
//! tip is lower than the arch over it.

use nalgebra::{Rotation3, Vector3};

use super::body::BodyDef;
use super::library::{self, BlockConvention};
use crate::error::Result;
use crate::geom::{Footprint, Shape, Vec2, area_moments, convex_hull, vec2};

/// Greatest tilt, radians, that is put down to the body not having settled.
const RESTS_WITHIN: f64 = 0.15;
/// Corners closer than this are one, metres.
const SAME_CORNER: f64 = 1e-6;
/// Corners of a disc lying on its side, on the circle (the original's mesh).
const DISC_CORNERS: usize = 32;

/// A body laid down.
pub(super) struct LaidDown {
    pub def: BodyDef,
    /// Heading of the planar body frame, whose origin is the block's own.
    pub theta: f64,
    /// Height of the lowest point above the table, metres.
    pub lowest: f64,
    /// It stands on its base, so that nothing but its pose was taken from the angles.
    pub upright: bool,
}

/// Lays a block of the library down. `z` is the height of its origin, `angles` are roll, pitch and yaw.
pub(super) fn lay_down(
    mut def: BodyDef,
    block: &str,
    z: f64,
    angles: [f64; 3],
    convention: BlockConvention,
) -> Result<LaidDown> {
    let rotation = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
    // All that follows is done in the block's own frame, where `up` is the world's vertical.
    let up = resting(rotation.inverse() * Vector3::z());
    let lead = if up.x.abs() > 0.7 { Vector3::y() } else { Vector3::x() };
    let along = (lead - up * up.dot(&lead)).normalize();
    let across = up.cross(&along);
    let heading = rotation * along;
    let theta = heading.y.atan2(heading.x);

    let outline = corners(&def.shape)?;
    let half = def.height / 2.0;
    let solid: Vec<Vector3<f64>> =
        outline.iter().flat_map(|p| [Vector3::new(p.x, p.y, -half), Vector3::new(p.x, p.y, half)]).collect();
    let lowest = solid.iter().map(|p| p.dot(&up)).fold(f64::INFINITY, f64::min);
    let highest = solid.iter().map(|p| p.dot(&up)).fold(f64::NEG_INFINITY, f64::max);
    let lowest_point = z + lowest;
    if up.z == 1.0 {
        return Ok(LaidDown { def, theta, lowest: lowest_point, upright: true });
    }

    let (centre, second) = mass_moments(&def, block, &outline, convention)?;
    if up.z == -1.0 {
        def.shape = mirrored(def.shape);
    } else {
        let shadow: Vec<Vec2> = solid.iter().map(|p| vec2(p.dot(&along), p.dot(&across))).collect();
        let mut hull = convex_hull(&shadow);
        hull.dedup_by(|b, a| (*b - *a).norm() < SAME_CORNER);
        // The last corner has the first beside it.
        while hull.len() > 3 && (hull[0] - hull[hull.len() - 1]).norm() < SAME_CORNER {
            hull.pop();
        }
        def.shape = Shape::ConvexPolygon(hull.into_iter().map(|p| [p.x, p.y]).collect());
    }
    def.height = highest - lowest;

    // The mass stays where it is in the solid, which need not be amid the silhouette.
    let footprint = Footprint::new(def.shape.clone())?;
    let centre = vec2(centre.dot(&along), centre.dot(&across));
    let inertia = def.mass * (second.sum() - up.dot(&second.component_mul(&up)));
    let apart = (centre - footprint.centroid).norm() > 1e-9;
    def.centre_of_mass = apart.then_some([centre.x, centre.y]);
    let differs = (inertia / (def.mass * footprint.gyration_squared) - 1.0).abs() > 1e-9;
    def.inertia = (apart || differs).then_some(inertia);
    Ok(LaidDown { def, theta, lowest: lowest_point, upright: false })
}

/// The vertical as the body has it once it has settled on the side that it nearly lies on.
fn resting(up: Vector3<f64>) -> Vector3<f64> {
    let axis = up.iamax();
    if up[axis].abs() < RESTS_WITHIN.cos() {
        return up;
    }
    let mut flat = Vector3::zeros();
    flat[axis] = up[axis].signum();
    flat
}

/// The outline as the solid has it: that of the footprint, with a disc's corners on the circle.
fn corners(shape: &Shape) -> Result<Vec<Vec2>> {
    if let Shape::Disc { radius } = shape {
        let step = std::f64::consts::TAU / DISC_CORNERS as f64;
        return Ok((0..DISC_CORNERS)
            .map(|i| vec2((i as f64 * step).cos(), (i as f64 * step).sin()) * *radius)
            .collect());
    }
    Ok(Footprint::new(shape.clone())?.outlines.concat())
}

/// Centre of mass and mean squared distances from it along the block's axes. (All blocks are symmetric about an axis
/// of theirs, so that there are no mixed moments.)
fn mass_moments(
    def: &BodyDef,
    block: &str,
    outline: &[Vec2],
    convention: BlockConvention,
) -> Result<(Vector3<f64>, Vector3<f64>)> {
    if convention == BlockConvention::Simulator {
        let box_size = library::simulator_box(block)?;
        return Ok((Vector3::zeros(), Vector3::from(box_size).map(|d| d * d / 12.0)));
    }
    let (area, centroid, _) = area_moments(outline);
    let (mut xx, mut yy) = (0.0, 0.0);
    for i in 0..outline.len() {
        let (p, q) = (outline[i] - centroid, outline[(i + 1) % outline.len()] - centroid);
        let cross = p.x * q.y - p.y * q.x;
        xx += cross * (p.x * p.x + p.x * q.x + q.x * q.x) / 12.0;
        yy += cross * (p.y * p.y + p.y * q.y + q.y * q.y) / 12.0;
    }
    let zz = def.height * def.height / 12.0;
    Ok((Vector3::new(centroid.x, centroid.y, 0.0), Vector3::new(xx / area, yy / area, zz)))
}

/// The shape seen from below. A shape that is its own mirror image stays as it is written.
fn mirrored(shape: Shape) -> Shape {
    let flip = |points: Vec<[f64; 2]>| -> Vec<[f64; 2]> {
        let has = |p: [f64; 2]| points.iter().any(|q| (q[0] - p[0]).hypot(q[1] - p[1]) < 1e-12);
        if points.iter().all(|&[x, y]| has([x, -y])) {
            return points;
        }
        points.into_iter().rev().map(|[x, y]| [x, -y]).collect()
    };
    match shape {
        Shape::ConvexPolygon(points) => Shape::ConvexPolygon(flip(points)),
        Shape::Polygon(points) => Shape::Polygon(flip(points)),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    use super::super::body::Body;
    use super::*;

    fn lay(block: &str, angles: [f64; 3]) -> (Body, LaidDown) {
        let def = library::block(block).unwrap();
        let laid = lay_down(def, block, 0.0225, angles, BlockConvention::TrueCentroid).unwrap();
        (Body::new(laid.def.clone()).unwrap(), laid)
    }

    /// Extent of the footprint along its own axes, millimetres.
    fn size(body: &Body) -> [f64; 2] {
        let (low, high) = body.footprint.bounds();
        [high.x - low.x, high.y - low.y].map(|v| (v * 1e7).round() / 1e4)
    }

    #[test]
    fn an_upright_block_is_untouched_even_if_it_leans_a_little() {
        for angles in [[0.0, 0.0, 1.2], [1e-3, -5e-4, 1.2], [0.1, 0.0, 1.2]] {
            let (_, laid) = lay("concave", angles);
            assert!(laid.upright && laid.def == library::block("concave").unwrap());
            assert!((laid.theta - 1.2).abs() < 1e-12 && laid.lowest.abs() < 1e-12);
        }
    }

    #[test]
    fn upside_down_the_outline_is_mirrored() {
        let (body, laid) = lay("concave", [PI, 0.0, 0.3]);
        assert!(!laid.upright && (laid.theta - 0.3).abs() < 1e-12);
        let upright = Body::new(library::block("concave").unwrap()).unwrap();
        assert!((body.footprint.area - upright.footprint.area).abs() < 1e-12);
        assert!((body.centre_of_mass - vec2(0.0, -upright.centre_of_mass.y)).norm() < 1e-12);
        assert!((body.inertia / upright.inertia - 1.0).abs() < 1e-9);
        assert!(!body.footprint.contains(&crate::geom::Pose2::IDENTITY, vec2(0.0, -0.02)), "the notch is below now");
        // Turned over about y instead, the x axis points back.
        let (_, laid) = lay("rect", [0.0, PI, 0.3]);
        assert!(laid.def == library::block("rect").unwrap() && (laid.theta - (0.3 - PI)).abs() < 1e-12);
    }

    #[test]
    fn on_its_side_a_block_is_its_silhouette() {
        for (block, angles, footprint, height) in [
            ("half_cube", [-FRAC_PI_2, -0.03, 0.0], [22.5, 45.0], 0.045),
            ("half_cube", [0.0, FRAC_PI_2, 0.0], [45.0, 45.0], 0.0225),
            ("rect", [FRAC_PI_2, 0.0, 0.5], [45.0, 45.0], 0.09),
            ("concave", [FRAC_PI_2 + 0.09, 0.05, 1.5], [90.0, 45.0], 0.045),
            ("concave", [0.0, -FRAC_PI_2, 0.0], [45.0, 45.0], 0.09),
            ("cylinder", [FRAC_PI_2, 0.0, 0.0], [44.0, 45.0], 0.044),
            ("triangle", [FRAC_PI_2, 0.0, 0.0], [45.0, 45.0], 0.09),
        ] {
            let (body, laid) = lay(block, angles);
            assert_eq!(size(&body), footprint, "{block} {angles:?}");
            assert!((body.height - height).abs() < 1e-9 && !laid.upright, "{block} {angles:?}: {}", body.height);
            assert_eq!(body.footprint.pieces.len(), 1);
        }
        // A half cube on its side is a half cube again.
        assert_eq!(lay("half_cube", [FRAC_PI_2, 0.0, 0.0]).1.def, library::block("half_cube").unwrap());
    }

    #[test]
    fn the_mass_stays_where_it_is_in_the_solid() {
        let (body, _) = lay("triangle", [FRAC_PI_2, 0.0, 0.0]);
        assert!((body.centre_of_mass - vec2(0.0075, 0.0)).norm() < 1e-12);
        // Across a triangle of height h lie h^2 / 18, along the axis of the prism a twelfth.
        let want = 0.1 * (0.045 * 0.045 / 18.0 + 0.045 * 0.045 / 12.0);
        assert!((body.inertia / want - 1.0).abs() < 1e-9, "{}", body.inertia);
        let def = library::block_of("triangle", library::BlockSet::More, BlockConvention::Simulator).unwrap();
        let laid = lay_down(def, "triangle", 0.0225, [FRAC_PI_2, 0.0, 0.0], BlockConvention::Simulator).unwrap();
        assert!(laid.def.inertia.is_none_or(|i| (i / (0.1 / 12.0 * 2.0 * 0.051 * 0.051) - 1.0).abs() < 1e-9));
        assert!(laid.def.centre_of_mass.is_none(), "the origin is amid the silhouette");
    }

    #[test]
    fn a_tilted_block_casts_its_exact_shadow() {
        let (body, laid) = lay("cube", [FRAC_PI_4, 0.0, 0.0]);
        let diagonal = 45.0 * 2f64.sqrt();
        assert!((size(&body)[0] - 45.0).abs() < 1e-3 && (size(&body)[1] - diagonal).abs() < 1e-3, "{:?}", size(&body));
        assert!((body.height * 1e3 - diagonal).abs() < 1e-9);
        assert!(((0.0225 - laid.lowest) * 2e3 - diagonal).abs() < 1e-9);
    }
}
