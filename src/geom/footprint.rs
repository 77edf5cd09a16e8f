//! What a body looks like from above: the shape a user gives, and the footprint made of it.

use serde::{Deserialize, Serialize};

use super::decompose::convex_pieces;
use super::polygon::{area_moments, contains_point, convex_hull, disc_polygon, edges, intersection_area};
use super::pose::{Pose2, Vec2, vec2};
use super::simple::outline_fault;
use super::simplify::{simplified, usual_tolerance};
use crate::bounds;
use crate::error::{Error, Result};

/// Corners that stand for a disc where corners are needed (outlines, areas).
const DISC_CORNERS: usize = 32;
/// Neighbouring corners nearer to each other than this are one, metres.
const SAME_CORNER: f64 = 1e-7;
/// The most corners that a body may have once its outlines are simplified, all its parts together; a disc counts as one.
/// What a push costs grows with them.
pub const MAX_CORNERS: usize = 512;

/// A planar shape in the body frame, as given. Corners in either direction; metres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// A convex polygon; refused where it is not convex within the tolerance of outlines.
    ConvexPolygon(Vec<[f64; 2]>),
    /// A simple polygon, convex or not, split into convex pieces.
    Polygon(Vec<[f64; 2]>),
    /// A disc about the body's origin.
    Disc { radius: f64 },
    /// Parts at poses in the body frame. They should touch; where they overlap the mass counts twice.
    Compound(Vec<CompoundPart>),
}

/// A part of a compound shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CompoundPart {
    #[serde(default)]
    pub pose: Pose2,
    pub shape: Shape,
}

impl Shape {
    /// An axis-aligned rectangle about the origin: extent along x and along y, metres.
    pub fn rectangle(x: f64, y: f64) -> Shape {
        let (x, y) = (x / 2.0, y / 2.0);
        Shape::ConvexPolygon(vec![[-x, -y], [x, -y], [x, y], [-x, y]])
    }
}

impl Shape {
    /// The same shape with every length times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Shape {
        let corners = |points: &[[f64; 2]]| points.iter().map(|p| p.map(|v| factor * v)).collect();
        match self {
            Shape::ConvexPolygon(points) => Shape::ConvexPolygon(corners(points)),
            Shape::Polygon(points) => Shape::Polygon(corners(points)),
            Shape::Disc { radius } => Shape::Disc { radius: factor * radius },
            Shape::Compound(parts) => Shape::Compound(
                parts
                    .iter()
                    .map(|p| CompoundPart { pose: p.pose.scaled(factor), shape: p.shape.scaled(factor) })
                    .collect(),
            ),
        }
    }
}

/// A convex piece of a footprint, in the body frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Piece {
    /// Counter-clockwise corners.
    Convex(Vec<Vec2>),
    Disc {
        centre: Vec2,
        radius: f64,
    },
}

impl Piece {
    /// Greatest extent of the piece along a direction of the body frame.
    #[inline]
    pub fn support(&self, direction: Vec2) -> f64 {
        match self {
            Piece::Convex(points) => points.iter().map(|p| p.dot(&direction)).fold(f64::NEG_INFINITY, f64::max),
            Piece::Disc { centre, radius } => centre.dot(&direction) + radius * direction.norm(),
        }
    }
}

/// The shape of a body made ready for use: convex pieces, outlines, and their measures. Body frame, metres.
#[derive(Debug, Clone, PartialEq)]
pub struct Footprint {
    /// The shape it was made of.
    pub shape: Shape,
    /// Convex pieces that cover the shape.
    pub pieces: Vec<Piece>,
    /// Counter-clockwise outlines, one for each part (one unless the shape is a compound), without the corners that
    /// simplifying left out.
    pub outlines: Vec<Vec<Vec2>>,
    /// Greatest distance of a corner that simplifying left out from the outline, metres.
    pub deviation: f64,
    /// Square metres, of the shape as given, like centroid and radius of gyration.
    pub area: f64,
    /// Centroid of the area.
    pub centroid: Vec2,
    /// Squared radius of gyration about the centroid, square metres.
    pub gyration_squared: f64,
    /// Greatest distance of a point of the shape from the body's origin.
    pub radius: f64,
    /// Of the outlines, square metres.
    outlined: f64,
}

impl Footprint {
    /// Checks the shape and prepares it with every corner. Errors name the field within the shape.
    pub fn new(shape: Shape) -> Result<Footprint> {
        Self::simplified(shape, Some(0.0))
    }

    /// As [`Footprint::new`], without the corners that are of no account within a tolerance, metres: where none is asked
    /// for [`super::OUTLINE_TOLERANCE`], less for thin shapes. No other corner moves, and an outline that is convex
    /// within the tolerance becomes convex.
    pub fn simplified(shape: Shape, tolerance: Option<f64>) -> Result<Footprint> {
        let mut parts = Vec::new();
        collect_parts(&shape, &Pose2::IDENTITY, tolerance, "shape", 0, &mut parts)?;
        check_corners(parts.iter().map(Part::corners).sum(), "shape")?;
        let total: f64 = parts.iter().map(|p| p.area).sum();
        let centroid = parts.iter().map(|p| p.centroid * p.area).sum::<Vec2>() / total;
        let second: f64 = parts.iter().map(|p| p.second + p.area * (p.centroid - centroid).norm_squared()).sum();
        let radius = parts
            .iter()
            .flat_map(|p| p.pieces.iter())
            .map(|piece| match piece {
                Piece::Convex(points) => points.iter().map(|q| q.norm()).fold(0.0, f64::max),
                Piece::Disc { centre, radius } => centre.norm() + radius,
            })
            .fold(0.0, f64::max);
        bounds::REACH.check("shape", radius)?;
        let outlines = parts.iter().map(|p| p.outline.clone()).collect();
        Ok(Footprint {
            deviation: parts.iter().map(|p| p.deviation).fold(0.0, f64::max),
            outlined: parts.iter().map(|p| p.outlined).sum(),
            shape,
            pieces: parts.into_iter().flat_map(|p| p.pieces).collect(),
            outlines,
            area: total,
            centroid,
            gyration_squared: second / total,
            radius,
        })
    }

    /// A footprint given directly by its convex pieces (corners counter-clockwise).
    pub fn from_convex_pieces(pieces: Vec<Vec<Vec2>>) -> Result<Footprint> {
        let parts = pieces
            .into_iter()
            .map(|p| CompoundPart {
                pose: Pose2::IDENTITY,
                shape: Shape::ConvexPolygon(p.into_iter().map(|q| [q.x, q.y]).collect()),
            })
            .collect();
        Footprint::new(Shape::Compound(parts))
    }

    /// The same footprint, piece by piece, with every length times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Footprint {
        let corners = |points: &Vec<Vec2>| points.iter().map(|p| p * factor).collect();
        let piece = |piece: &Piece| match piece {
            Piece::Convex(points) => Piece::Convex(corners(points)),
            Piece::Disc { centre, radius } => Piece::Disc { centre: centre * factor, radius: radius * factor },
        };
        Footprint {
            shape: self.shape.scaled(factor),
            pieces: self.pieces.iter().map(piece).collect(),
            outlines: self.outlines.iter().map(corners).collect(),
            area: self.area * factor * factor,
            centroid: self.centroid * factor,
            gyration_squared: self.gyration_squared * factor * factor,
            radius: self.radius * factor,
            deviation: self.deviation * factor,
            outlined: self.outlined * factor * factor,
        }
    }

    /// Greatest extent along a direction of the body frame.
    #[inline]
    pub fn support(&self, direction: Vec2) -> f64 {
        self.pieces.iter().map(|p| p.support(direction)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The world point lies on the body.
    pub fn contains(&self, pose: &Pose2, point: Vec2) -> bool {
        let p = pose.inverse_transform_point(point);
        self.pieces.iter().any(|piece| match piece {
            Piece::Convex(points) => contains_point(points, p),
            Piece::Disc { centre, radius } => (p - centre).norm_squared() <= radius * radius,
        })
    }

    /// Intersection over union of the footprint at two poses, in [0, 1].
    pub fn iou(&self, a: &Pose2, b: &Pose2) -> f64 {
        let at = |pose: &Pose2| -> Vec<Vec<Vec2>> {
            let frame = pose.frame();
            self.pieces.iter().map(|p| corners(p).iter().map(|&q| frame.point(q)).collect()).collect()
        };
        let (pa, pb) = (at(a), at(b));
        let shared: f64 = pa.iter().flat_map(|x| pb.iter().map(move |y| intersection_area(x, y))).sum();
        let area: f64 = pa.iter().map(|x| super::polygon::area(x)).sum();
        shared / (2.0 * area - shared).max(f64::MIN_POSITIVE)
    }

    /// Mean distance of the area from a point of the body frame, metres: the radius at which uniform pressure acts
    /// against turning about that point. Exact, by triangles with their apex at the point.
    pub fn mean_distance(&self, from: Vec2) -> f64 {
        let mut moment = 0.0;
        for (p, q) in self.outlines.iter().flat_map(|outline| edges(outline)) {
            let (p, q) = (p - from, q - from);
            let along = (q - p).normalize();
            let h = p.x * along.y - p.y * along.x;
            if h.abs() < 1e-12 {
                continue;
            }
            // The integral of h^3 / (3 cos^3) over the angle the edge spans, as seen from the point.
            let part = |t: f64| {
                let (tan, sec) = (t / h.abs(), (t / h).hypot(1.0));
                // The logarithm is odd. Far on the negative side its argument cancels, to nothing in the end.
                let log = if tan < -1e3 { -(sec - tan).ln() } else { (sec + tan).ln() };
                0.5 * (sec * tan + log)
            };
            moment += h * h * h / 3.0 * (part(q.dot(&along)) - part(p.dot(&along)));
        }
        moment / self.outlined
    }

    /// Bounding box (least, greatest corner) in the body frame.
    pub fn bounds(&self) -> (Vec2, Vec2) {
        let (x, y) = (vec2(1.0, 0.0), vec2(0.0, 1.0));
        (vec2(-self.support(-x), -self.support(-y)), vec2(self.support(x), self.support(y)))
    }

    /// Directions of greatest and least spread of the area (principal axes), unit vectors of the body frame.
    /// The first is the long axis; its angle lies in (-pi/2, pi/2]. A shape without a preferred direction gives +x.
    pub fn principal_axes(&self) -> (Vec2, Vec2) {
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for outline in &self.outlines {
            // Second moments by triangles about the centroid.
            for (p, q) in edges(outline) {
                let (p, q) = (p - self.centroid, q - self.centroid);
                let w = (p.x * q.y - p.y * q.x) / 12.0;
                xx += w * (p.x * p.x + p.x * q.x + q.x * q.x);
                yy += w * (p.y * p.y + p.y * q.y + q.y * q.y);
                xy += w * (2.0 * p.x * p.y + p.x * q.y + q.x * p.y + 2.0 * q.x * q.y) / 2.0;
            }
        }
        let spread = (0.5 * (xx - yy)).hypot(xy);
        if spread < 1e-3 * (xx + yy) {
            return (vec2(1.0, 0.0), vec2(0.0, 1.0));
        }
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        let long = vec2(angle.cos(), angle.sin());
        (long, vec2(-long.y, long.x))
    }
}

/// Corners of a piece; a disc is replaced by a polygon of the same area.
pub(crate) fn corners(piece: &Piece) -> std::borrow::Cow<'_, [Vec2]> {
    match piece {
        Piece::Convex(points) => points.as_slice().into(),
        Piece::Disc { centre, radius } => disc_polygon(*centre, *radius, DISC_CORNERS).into(),
    }
}

struct Part {
    pieces: Vec<Piece>,
    outline: Vec<Vec2>,
    deviation: f64,
    outlined: f64,
    area: f64,
    centroid: Vec2,
    second: f64,
}

impl Part {
    fn corners(&self) -> usize {
        if let [Piece::Disc { .. }] = self.pieces.as_slice() { 1 } else { self.outline.len() }
    }
}

/// Refuses more corners than can be planned with.
fn check_corners(corners: usize, field: &str) -> Result<()> {
    if corners <= MAX_CORNERS {
        return Ok(());
    }
    let reason = format!(
        "has {corners} corners after simplifying, and a body at most {MAX_CORNERS}; give a coarser outline or a greater \
         outline_tolerance"
    );
    Err(Error::argument(field, reason))
}

fn collect_parts(
    shape: &Shape,
    pose: &Pose2,
    tolerance: Option<f64>,
    field: &str,
    depth: usize,
    out: &mut Vec<Part>,
) -> Result<()> {
    match shape {
        Shape::Disc { radius } => {
            bounds::RADIUS.check(&format!("{field}.disc.radius"), *radius)?;
            let centre = pose.position();
            let area = std::f64::consts::PI * radius * radius;
            out.push(Part {
                pieces: vec![Piece::Disc { centre, radius: *radius }],
                outline: disc_polygon(centre, *radius, DISC_CORNERS),
                deviation: 0.0,
                outlined: area,
                area,
                centroid: centre,
                second: area * radius * radius / 2.0,
            });
        }
        Shape::ConvexPolygon(points) => {
            out.push(polygon_part(points, pose, tolerance, &format!("{field}.convex_polygon"), true)?);
        }
        Shape::Polygon(points) => {
            out.push(polygon_part(points, pose, tolerance, &format!("{field}.polygon"), false)?);
        }
        Shape::Compound(parts) => {
            if depth > 8 {
                return Err(Error::argument(field, "compounds are nested more than 8 deep"));
            }
            let count = out.len() + parts.len();
            if !(bounds::PARTS.least..=bounds::PARTS.greatest).contains(&(count as f64)) {
                let reason = format!("has {count} parts; a compound has {}", bounds::PARTS.range());
                return Err(Error::argument(format!("{field}.compound"), reason));
            }
            for (i, part) in parts.iter().enumerate() {
                let field = format!("{field}.compound[{i}]");
                bounds::LOCAL.check(&format!("{field}.pose.x"), part.pose.x)?;
                bounds::LOCAL.check(&format!("{field}.pose.y"), part.pose.y)?;
                bounds::HEADING.check(&format!("{field}.pose.theta"), part.pose.theta)?;
                collect_parts(&part.shape, &pose.compose(&part.pose), tolerance, &field, depth + 1, out)?;
            }
        }
    }
    Ok(())
}

/// Refuses too few or too many corners of a polygon; asked before the corners themselves are read.
pub(crate) fn check_corner_count(field: &str, count: usize) -> Result<()> {
    let [least, most] = [bounds::CORNERS.least, bounds::CORNERS.greatest];
    if (least..=most).contains(&(count as f64)) {
        return Ok(());
    }
    Err(Error::argument(field, format!("has {count} corners; a polygon has {least} to {most}")))
}

/// The least distance between two parallel lines that hold the points between them; that of the hull, at an edge of it.
fn width(points: &[Vec2]) -> f64 {
    let hull = convex_hull(points);
    edges(&hull)
        .map(|(p, q)| {
            let across = vec2(p.y - q.y, q.x - p.x).normalize();
            hull.iter().map(|r| across.dot(&(r - p)).abs()).fold(0.0, f64::max)
        })
        .fold(f64::INFINITY, f64::min)
}

fn polygon_part(
    points: &[[f64; 2]],
    pose: &Pose2,
    tolerance: Option<f64>,
    field: &str,
    must_be_convex: bool,
) -> Result<Part> {
    let local = checked_outline(points, field)?;
    let frame = pose.frame();
    let turned = |points: &[Vec2]| -> Vec<Vec2> { points.iter().map(|&p| frame.point(p)).collect() };
    let (a, centroid, second) = area_moments(&turned(&local));
    // A polygon that is nearly a line has no hull to measure.
    let said = |what: String, bound: bounds::Bound| {
        move |_| Error::argument(field, format!("{what}; it must lie in {} ({})", bound.range(), bound.why))
    };
    bounds::AREA.check(field, a).map_err(said(format!("has an area of {a:.3e} m^2"), bounds::AREA))?;
    let wide = width(&local);
    bounds::WIDTH.check(field, wide).map_err(said(format!("is {wide:.3e} m wide"), bounds::WIDTH))?;
    let simple = simplified(&local, tolerance.unwrap_or_else(|| usual_tolerance(&local)));
    if must_be_convex && !simple.convex {
        return Err(Error::argument(field, "is not convex; use a `polygon`, which is split into convex pieces"));
    }
    check_corners(simple.kept.len(), field)?;
    let kept: Vec<Vec2> = simple.kept.iter().map(|&i| local[i]).collect();
    let mut outline = turned(&kept);
    let outlined = area_moments(&outline).0;
    let pieces = if simple.convex {
        outline = convex_hull(&outline);
        vec![Piece::Convex(outline.clone())]
    } else {
        // Split before it is turned, so that the pieces are the same whichever way a part lies; the hull takes away
        // their collinear corners, and what had no area but by rounding.
        let split = convex_pieces(&kept).map_err(|e| e.within(field))?;
        split.iter().map(|p| convex_hull(&turned(p))).filter(|p| p.len() >= 3).map(Piece::Convex).collect()
    };
    Ok(Part { pieces, outline, deviation: simple.deviation, outlined, area: a, centroid, second })
}

/// The corners that do not lie where the one before them lies. Sections of meshes have such corners where the plane passes a
/// vertex, and rings of other libraries end with the corner that they begin with.
fn distinct_corners(points: &[Vec2]) -> Vec<usize> {
    let same = |i: usize, j: usize| (points[i] - points[j]).norm() < SAME_CORNER;
    let mut kept: Vec<usize> = Vec::with_capacity(points.len());
    for i in 0..points.len() {
        if kept.last().is_none_or(|&last| !same(last, i)) {
            kept.push(i);
        }
    }
    while kept.len() > 1 && same(kept[0], kept[kept.len() - 1]) {
        kept.pop();
    }
    kept
}

/// The corners, counter-clockwise, if they make an outline; of neighbours at one place the first. Errors number the corners
/// as they were given.
fn checked_outline(points: &[[f64; 2]], field: &str) -> Result<Vec<Vec2>> {
    check_corner_count(field, points.len())?;
    for (i, p) in points.iter().enumerate() {
        bounds::LOCAL.check_all(&format!("{field}[{i}]"), *p)?;
    }
    let given: Vec<Vec2> = points.iter().map(|p| vec2(p[0], p[1])).collect();
    let distinct = distinct_corners(&given);
    if distinct.len() < 3 {
        let reason = format!("has {} corners at places of their own; a polygon has 3 or more", distinct.len());
        return Err(Error::argument(field, reason));
    }
    let mut outline: Vec<Vec2> = distinct.iter().map(|&i| given[i]).collect();
    if let Some(fault) = outline_fault(&outline) {
        let said = fault.numbered(|i| distinct[i % distinct.len()]).describe(&given);
        return Err(Error::argument(field, format!("{said}; give the corners in order round the outline")));
    }
    if area_moments(&outline).0 < 0.0 {
        outline.reverse();
    }
    Ok(outline)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_has_its_textbook_measures() {
        let f = Footprint::new(Shape::rectangle(0.04, 0.02)).unwrap();
        assert!((f.area - 8e-4).abs() < 1e-15);
        assert!((f.gyration_squared - (0.04f64.powi(2) + 0.02f64.powi(2)) / 12.0).abs() < 1e-12);
        assert_eq!(f.pieces.len(), 1);
        let (long, _) = f.principal_axes();
        assert!((long.x.abs() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn principal_axes_follow_the_rotation() {
        let c = 0.5f64;
        let r = |x: f64, y: f64| [c.cos() * x - c.sin() * y, c.sin() * x + c.cos() * y];
        let f = Footprint::new(Shape::Polygon(vec![r(-0.04, -0.01), r(0.04, -0.01), r(0.04, 0.01), r(-0.04, 0.01)]))
            .unwrap();
        let (long, _) = f.principal_axes();
        assert!((long.y.atan2(long.x) - c).abs() < 1e-9);
    }

    #[test]
    fn bad_shapes_name_the_field() {
        let cases: Vec<(Shape, &str)> = vec![
            (Shape::Disc { radius: f64::NAN }, "shape.disc.radius"),
            (Shape::ConvexPolygon(vec![[0., 0.], [1., 0.]]), "shape.convex_polygon"),
            (Shape::Polygon(vec![[0., 0.], [1., 1.], [1., 0.], [0., 1.]]), "shape.polygon"),
            (Shape::ConvexPolygon(vec![[0., 0.], [2., 0.], [0.5, 0.5], [0., 2.]]), "shape.convex_polygon"),
            (Shape::Compound(vec![]), "shape.compound"),
            (
                Shape::Compound(vec![CompoundPart { pose: Pose2::IDENTITY, shape: Shape::Disc { radius: 0.0 } }]),
                "shape.compound[0].disc.radius",
            ),
        ];
        for (shape, field) in cases {
            match Footprint::new(shape.clone()) {
                Err(Error::Argument { field: f, .. }) => assert_eq!(f, field, "{shape:?}"),
                other => panic!("{shape:?}: {other:?}"),
            }
        }
    }

    #[test]
    fn mean_distance_of_disc_and_square() {
        let disc = Footprint::new(Shape::Disc { radius: 0.03 }).unwrap();
        assert!((disc.mean_distance(vec2(0.0, 0.0)) - 0.02).abs() < 1e-5);
        let side = 0.04;
        let square = Footprint::new(Shape::rectangle(side, side)).unwrap();
        let known = side * (2f64.sqrt() + (1.0 + 2f64.sqrt()).ln()) / 6.0;
        assert!((square.mean_distance(vec2(0.0, 0.0)) - known).abs() < 1e-12);
        let from = vec2(0.05, 0.0);
        let n = 400;
        let grid: f64 = (0..n * n)
            .map(|k| {
                let at = |i: usize| ((i as f64 + 0.5) / n as f64 - 0.5) * side;
                (vec2(at(k % n), at(k / n)) - from).norm()
            })
            .sum();
        assert!((square.mean_distance(from) - grid / (n * n) as f64).abs() < 1e-6, "from outside");
    }

    #[test]
    fn the_mean_distance_is_even_where_an_edge_points_at_the_point() {
        let square = Footprint::new(Shape::rectangle(0.04, 0.04)).unwrap();
        let on_the_line = square.mean_distance(vec2(0.05, 0.02));
        for power in 4..16 {
            for off in [10f64.powi(-power), -(10f64.powi(-power))] {
                let beside = square.mean_distance(vec2(0.05, 0.02 + off));
                assert!((beside - on_the_line).abs() <= off.abs(), "{off}: {beside} for {on_the_line}");
            }
        }
    }

    #[test]
    fn iou_of_a_shifted_square_is_known() {
        let f = Footprint::new(Shape::rectangle(0.04, 0.04)).unwrap();
        let iou = f.iou(&Pose2::IDENTITY, &Pose2::new(0.02, 0.0, 0.0));
        assert!((iou - 1.0 / 3.0).abs() < 1e-12);
    }
}
