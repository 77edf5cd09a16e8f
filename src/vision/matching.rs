//! Poses of known shapes from masks.
//!
//! A region's border gives pairs of neighbouring pixels, one inside and one outside. The shape is laid on the region's
//! centroid at several headings; the best of them are refined by registering the middles of the pairs to the shape's
//! outline (Besl and McKay 1992, point to line: Chen and Medioni 1992), and the best of these by asking that of every
//! pair one pixel lie within the shape and the other without (logistic loss, Newton's method). The last step is what
//! makes clean masks accurate: with n pairs its error falls as 1/n, that of a fit to the middles as 1/sqrt(n).

use super::assign::assign;
use super::regions::Region;
use crate::error::{Error, Result, check_range};
use crate::geom::{Footprint, Pose2, Shape, Vec2, normalize_angle, vec2};
use nalgebra::{Matrix3, Vector3};

/// Headings that are tried at first.
const HEADINGS: usize = 24;
/// Pairs of pixels that rate a heading.
const COARSE_PAIRS: usize = 32;
/// Headings that are refined.
const REFINED: usize = 4;
/// Pairs of pixels that are registered; of a longer border a part.
const PAIRS: usize = 256;
/// Width of the step from inside to outside in the loss of a clean mask, pixels, and its growth with the noise.
const SHARPEST: f64 = 0.1;
const NOISE: f64 = 1.0;
/// A shape and a region whose areas differ by a greater factor are not compared in the search for the assignment.
const AREA_RATIO: f64 = 1.5;

/// How far a match may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchOptions {
    /// Greatest cost of a match ([`Match::cost`]) that [`Matcher::assign`] accepts, pixels.
    pub greatest_cost: f64,
}

impl Default for MatchOptions {
    fn default() -> Self {
        Self { greatest_cost: 3.0 }
    }
}

/// A shape laid on a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    /// World pose of the shape's frame. The heading of a disc is 0.
    pub pose: Pose2,
    /// Root mean square distance of the region's border from the shape's outline, pixels. That of a clean mask is
    /// about 0.3.
    pub rms: f64,
    /// Area of the region over that of the shape.
    pub area_ratio: f64,
    /// What the match is rated by, pixels: `rms` and the width of a seam along the border as large as the areas'
    /// difference.
    pub cost: f64,
}

/// A shape made ready for matching: its frame is moved to the centroid.
#[derive(Debug, Clone)]
struct Template {
    centroid: Vec2,
    area: f64,
    perimeter: f64,
    /// Sides of the outlines, their unit directions and lengths; empty for a disc.
    sides: Vec<Side>,
    /// Radius of a disc.
    disc: Option<f64>,
    /// The first shape that is the same.
    same_as: usize,
}

#[derive(Debug, Clone, Copy)]
struct Side {
    from: Vec2,
    along: Vec2,
    length: f64,
}

impl Template {
    fn new(footprint: &Footprint, same_as: usize) -> Template {
        let centroid = footprint.centroid;
        let disc = match footprint.shape {
            Shape::Disc { radius } => Some(radius),
            _ => None,
        };
        let outlines = footprint.outlines.iter().filter(|_| disc.is_none());
        let sides: Vec<Side> = outlines
            .flat_map(|outline| {
                (0..outline.len()).map(|i| {
                    let (a, b) = (outline[i], outline[(i + 1) % outline.len()]);
                    let length = (b - a).norm();
                    Side { from: a - centroid, along: (b - a) / length.max(f64::MIN_POSITIVE), length }
                })
            })
            .collect();
        let perimeter = disc.map_or(sides.iter().map(|s| s.length).sum(), |r| std::f64::consts::TAU * r);
        Template { centroid, area: footprint.area, perimeter, sides, disc, same_as }
    }

    /// Signed distance of a point from the outline (negative inside) and the direction in which it grows.
    #[inline]
    fn distance(&self, p: Vec2) -> (f64, Vec2) {
        if let Some(radius) = self.disc {
            let r = p.norm();
            let n = if r > 0.0 { p / r } else { vec2(1.0, 0.0) };
            return (r - radius, n);
        }
        let mut best = (f64::INFINITY, 0.0, Vec2::zeros());
        for side in &self.sides {
            let d = p - side.from;
            let t = d.dot(&side.along);
            // The outline runs counter-clockwise: to the right of a side is outside.
            let across = d.x * side.along.y - d.y * side.along.x;
            let over = if t < 0.0 { t } else { (t - side.length).max(0.0) };
            let squared = across * across + over * over;
            // At a corner the side that the point is more in front of tells the sign.
            if squared < best.0 - 1e-15 || (squared < best.0 + 1e-15 && across.abs() > f64::abs(best.1)) {
                let normal = vec2(side.along.y, -side.along.x) * across + side.along * over;
                best = (squared, across, normal);
            }
        }
        let (squared, across, toward) = best;
        let length = squared.sqrt();
        let sign = if across < 0.0 { -1.0 } else { 1.0 };
        let normal = if length > 1e-12 { toward * (sign / length) } else { vec2(0.0, 0.0) };
        (sign * length, normal)
    }
}

/// Finds poses of known shapes. Keeps its working memory.
#[derive(Debug)]
pub struct Matcher {
    templates: Vec<Template>,
    options: MatchOptions,
    middles: Vec<Vec2>,
}

impl Matcher {
    pub fn new<'a>(shapes: impl IntoIterator<Item = &'a Footprint>, options: MatchOptions) -> Result<Matcher> {
        check_range("greatest_cost", options.greatest_cost, 0.0..=1e6)?;
        let shapes: Vec<&Footprint> = shapes.into_iter().collect();
        let templates = shapes
            .iter()
            .map(|footprint| {
                let same_as = shapes.iter().position(|other| other.shape == footprint.shape).unwrap_or(0);
                Template::new(footprint, same_as)
            })
            .collect();
        Ok(Matcher { templates, options, middles: Vec::new() })
    }

    /// Number of shapes.
    pub fn len(&self) -> usize {
        self.templates.len()
    }

    pub fn is_empty(&self) -> bool {
        self.templates.is_empty()
    }

    /// The pose at which shape number `shape` fits a region best.
    pub fn pose(&mut self, shape: usize, region: &Region) -> Result<Match> {
        if shape >= self.templates.len() {
            let count = self.templates.len();
            return Err(Error::not_found("shape", format!("there is no shape {shape}; there are {count}")));
        }
        let mut rated = self.register(shape, region);
        self.separate(shape, region, &mut rated);
        Ok(rated)
    }

    /// Which shape is which region, and at which pose: for each shape the number of its region and the match, or none
    /// where no region is left for it that fits. The total cost is the least possible.
    pub fn assign(&mut self, regions: &[Region]) -> Vec<Option<(usize, Match)>> {
        let (rows, found) = (self.templates.len(), regions.len());
        // A further column for each shape: it is not there.
        let cols = found + rows;
        let none = self.options.greatest_cost;
        // Too dear to be chosen.
        let mut costs = vec![none * 4.0 + 1.0; rows * cols];
        let mut matches: Vec<Option<Match>> = vec![None; rows * found];
        for row in 0..rows {
            for col in 0..found {
                let (template, region) = (&self.templates[row], &regions[col]);
                let first = template.same_as;
                let ratio = region.area / template.area;
                let rated = if first < row {
                    matches[first * found + col]
                } else if !(1.0 / AREA_RATIO..=AREA_RATIO).contains(&ratio) {
                    None
                } else {
                    Some(self.register(row, region))
                };
                matches[row * found + col] = rated;
                if let Some(rated) = rated
                    && rated.cost <= none
                {
                    costs[row * cols + col] = rated.cost;
                }
            }
            for col in found..cols {
                costs[row * cols + col] = none * 2.0;
            }
        }
        let chosen = assign(&costs, rows, cols);
        (0..rows)
            .map(|row| {
                let col = chosen[row];
                let mut rated = matches.get(row * found + col).copied().flatten().filter(|_| col < found)?;
                if rated.cost > none {
                    return None;
                }
                self.separate(row, &regions[col], &mut rated);
                Some((col, rated))
            })
            .collect()
    }

    /// The best pose by the middles of the pairs.
    fn register(&mut self, shape: usize, region: &Region) -> Match {
        let template = &self.templates[shape];
        let pixel = region.pixel;
        let step = region.border.len().div_ceil(PAIRS).max(1);
        self.middles.clear();
        self.middles.extend(region.border.iter().step_by(step).map(|pair| pair.middle()));
        let coarse = self.middles.len().div_ceil(COARSE_PAIRS).max(1);
        let mut starts = [(f64::INFINITY, 0.0); HEADINGS];
        let headings = if template.disc.is_some() { 1 } else { HEADINGS };
        for (k, start) in starts.iter_mut().enumerate().take(headings) {
            let heading = std::f64::consts::TAU * k as f64 / HEADINGS as f64;
            let frame = Pose2::at(region.centroid, heading).frame();
            let sum: f64 =
                self.middles.iter().step_by(coarse).map(|&p| template.distance(frame.inverse_point(p)).0.powi(2)).sum();
            *start = (sum, heading);
        }
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut best: Option<(f64, Pose2)> = None;
        for &(_, heading) in starts.iter().take(REFINED.min(headings)) {
            let mut pose = Pose2::at(region.centroid, heading);
            let mut scale = f64::INFINITY;
            for _ in 0..8 {
                let (step, rms) = registration_step(template, &self.middles, &pose, scale, pixel);
                pose = moved(&pose, step);
                // Once it lies well, what is far off is an error of the mask.
                scale = (2.5 * rms).max(pixel);
                if step.x.hypot(step.y) < 1e-3 * pixel && step.z.abs() < 1e-4 {
                    break;
                }
            }
            let rms = rms_of(template, &self.middles, &pose);
            if best.is_none_or(|(least, _)| rms < least) {
                best = Some((rms, pose));
            }
        }
        let (rms, pose) = best.unwrap_or((f64::INFINITY, Pose2::at(region.centroid, 0.0)));
        let seam = (region.area - template.area).abs() / template.perimeter;
        Match {
            pose: pose_of_frame(template, &pose),
            rms: rms / pixel,
            area_ratio: region.area / template.area,
            cost: (rms + seam) / pixel,
        }
    }

    /// Refines a match so that the shape parts the pixels inside from those outside.
    fn separate(&mut self, shape: usize, region: &Region, rated: &mut Match) {
        let template = &self.templates[shape];
        let mut pose = Pose2::at(rated.pose.transform_point(template.centroid), rated.pose.theta);
        // The middles of a clean mask are 0.3 pixels off; what is more is noise.
        let last = (SHARPEST + NOISE * (rated.rms - 0.3)).clamp(SHARPEST, 0.6);
        for (softness, rounds) in [(last.max(0.3), 3), (last.max(0.15), 4), (last, 5)] {
            for _ in 0..rounds {
                let step = separation_step(template, &region.band, &pose, softness * region.pixel);
                pose = moved(&pose, step);
                if step.x.hypot(step.y) < 2e-3 * region.pixel && step.z.abs() < 2e-4 {
                    break;
                }
            }
        }
        let step = region.border.len().div_ceil(PAIRS).max(1);
        self.middles.clear();
        self.middles.extend(region.border.iter().step_by(step).map(|pair| pair.middle()));
        let rms = rms_of(template, &self.middles, &pose) / region.pixel;
        // Where the two steps disagree by much the mask is not this shape; the first is the more careful.
        if rms <= 1.3 * rated.rms + 0.1 {
            rated.pose = pose_of_frame(template, &pose);
            rated.cost += rms - rated.rms;
            rated.rms = rms;
        }
    }
}

/// The pose of the body's frame from that of its centroid.
fn pose_of_frame(template: &Template, centred: &Pose2) -> Pose2 {
    let theta = if template.disc.is_some() { 0.0 } else { normalize_angle(centred.theta) };
    let turned = Pose2::at(centred.position(), theta);
    Pose2::at(turned.transform_point(-template.centroid), theta)
}

/// A pose moved by a step in its own frame.
fn moved(pose: &Pose2, step: Vector3<f64>) -> Pose2 {
    Pose2::at(pose.transform_point(vec2(step.x, step.y)), pose.theta + step.z)
}

fn rms_of(template: &Template, points: &[Vec2], pose: &Pose2) -> f64 {
    let frame = pose.frame();
    let sum: f64 = points.iter().map(|&p| template.distance(frame.inverse_point(p)).0.powi(2)).sum();
    (sum / points.len().max(1) as f64).sqrt()
}

/// The derivative of a point's distance by a step of the shape in its own frame.
#[inline]
fn gradient(normal: Vec2, p: Vec2) -> Vector3<f64> {
    -Vector3::new(normal.x, normal.y, normal.y * p.x - normal.x * p.y)
}

/// Solves the normal equations; turns are damped so that a disc does not turn.
fn solve(mut hessian: Matrix3<f64>, right: Vector3<f64>, pixel: f64) -> Vector3<f64> {
    let trace = hessian[(0, 0)] + hessian[(1, 1)];
    let damping = 1e-9 * trace + f64::MIN_POSITIVE;
    hessian[(0, 0)] += damping;
    hessian[(1, 1)] += damping;
    hessian[(2, 2)] += 1e-3 * trace * pixel * pixel + f64::MIN_POSITIVE;
    let step = hessian.cholesky().map_or(Vector3::zeros(), |c| c.solve(&right));
    let length = step.x.hypot(step.y);
    // No step may leave the region.
    let limit = (4.0 * pixel / length.max(f64::MIN_POSITIVE)).min(0.3 / step.z.abs().max(f64::MIN_POSITIVE)).min(1.0);
    if step.iter().all(|v| v.is_finite()) { step * limit } else { Vector3::zeros() }
}

/// A step of Gauss and Newton with Tukey's weights of width `scale`, and the present distance (root mean square).
fn registration_step(
    template: &Template,
    points: &[Vec2],
    pose: &Pose2,
    scale: f64,
    pixel: f64,
) -> (Vector3<f64>, f64) {
    let frame = pose.frame();
    let (mut hessian, mut right, mut sum) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
    for &p in points {
        let q = frame.inverse_point(p);
        let (d, normal) = template.distance(q);
        sum += d * d;
        let relative = d / (2.0 * scale);
        if relative.abs() >= 1.0 {
            continue;
        }
        let weight = (1.0 - relative * relative).powi(2);
        let g = gradient(normal, q);
        hessian += g * g.transpose() * weight;
        right -= g * (weight * d);
    }
    (solve(hessian, right, pixel), (sum / points.len().max(1) as f64).sqrt())
}

/// A step of Newton's method on the logistic loss of pixels on the wrong side.
fn separation_step(template: &Template, band: &[(Vec2, bool)], pose: &Pose2, softness: f64) -> Vector3<f64> {
    let frame = pose.frame();
    let (mut hessian, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for &(p, inside) in band {
        let sign = if inside { 1.0 } else { -1.0 };
        let q = frame.inverse_point(p);
        let (d, normal) = template.distance(q);
        let x = sign * d / softness;
        if x < -12.0 {
            continue;
        }
        // Loss ln(1 + e^x); its first and second derivative.
        let wrong = 1.0 / (1.0 + (-x).exp());
        let curvature = (wrong * (1.0 - wrong)).max(0.02 * wrong);
        let g = gradient(normal, q);
        hessian += g * g.transpose() * (curvature / (softness * softness));
        right -= g * (sign * wrong / softness);
    }
    solve(hessian, right, softness)
}
