//! The holds that a body's own shape allows, worked out once for a scene: most of the grasp test never changes. A body's are
//! worked out when they are first asked for: a retrieval grasps one body, and a decision must not wait for 128.

use std::sync::OnceLock;

use super::hold::{Hold, Rule, Subject};
use super::jaw::Pieces;
use super::params::GraspParams;
use crate::geom::{Footprint, Frame, Vec2, convex_hull, vec2};
use crate::scene::{Body, Grasper, Gripper, Keeping, Scene};

/// At the ends of a body the pads cover this much more than they must, the noise of an observation: metres, for the
/// published gripper.
const END_SPARE: f64 = 0.002;
/// Positions nearer than this to each other are one: metres, for the published gripper.
const SAME_PLACE: f64 = 0.001;

/// A hold to try in a state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Candidate {
    pub hold: Hold,
    /// Index into [`BodyTable::directions`].
    pub direction: usize,
    /// Height of the pads' middle in the jaw's frame.
    pub y: f64,
    pub opening: f64,
    /// Greatest margin that the state can leave it, metres.
    pub margin: f64,
    /// Nearness is measured here.
    pub guide: bool,
}

/// The holds of one body.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BodyTable {
    /// Best score first, then widest margin, then nearest to the middle, then lowest direction.
    pub candidates: Vec<Candidate>,
    /// Closing directions in the body's frame: angle, sine and cosine.
    pub directions: Vec<(f64, f64, f64)>,
    /// No part of the jaw is farther from the body's origin, metres.
    pub reach: f64,
    /// Least width of the body between the pads where they cover enough of it and its faces are parallel enough,
    /// whatever the opening; infinite where there is no such place.
    pub narrowest: f64,
}

/// The holds of every body of a scene.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tables {
    bodies: Vec<OnceLock<BodyTable>>,
    /// What the holds of every body depend on.
    measures: Vec<Measures>,
    /// Fitted to the scene's gripper.
    pub params: GraspParams,
    grasper: Grasper,
    scale: f64,
    keeping: Option<Keeping>,
}

/// Area and radius of a footprint; height and mass where the gripper or its score asks for them.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Measures {
    area: f64,
    radius: f64,
    height_and_mass: Option<(f64, f64)>,
}

impl Measures {
    fn of(body: &Body, gripper: &Gripper) -> Measures {
        let asked = gripper.keeping.is_some() || gripper.grasp.lowest > 0.0;
        let height_and_mass = asked.then_some((body.height, body.mass));
        Measures { area: body.footprint.area, radius: body.footprint.radius, height_and_mass }
    }
}

impl Tables {
    pub fn new(scene: &Scene, params: &GraspParams) -> Tables {
        Tables {
            // Not `vec![..; n]`: valgrind takes the copy of an empty cell for a use of what it does not hold.
            bodies: std::iter::repeat_with(OnceLock::new).take(scene.len()).collect(),
            measures: scene.bodies().iter().map(|b| Measures::of(b, scene.gripper())).collect(),
            params: params.fitted(scene.gripper()),
            grasper: scene.gripper().grasp,
            scale: scene.gripper().scale(),
            keeping: scene.gripper().keeping.clone(),
        }
    }

    /// The table of a body of a scene that they fit, made when it is first asked for.
    pub fn body(&self, scene: &Scene, body: usize) -> Option<&BodyTable> {
        let table = self.bodies.get(body)?;
        Some(table.get_or_init(|| BodyTable::new(scene.body(body), scene.gripper(), &self.params)))
    }

    /// The tables were made for footprints and a gripper like this scene's.
    pub fn fits(&self, scene: &Scene) -> bool {
        let gripper = scene.gripper();
        let measures = scene.bodies().iter().map(|b| Measures::of(b, gripper));
        self.grasper == gripper.grasp
            && self.scale == gripper.scale()
            && self.keeping == gripper.keeping
            && measures.eq(self.measures.iter().copied())
    }
}

impl BodyTable {
    fn new(body: &Body, gripper: &Gripper, params: &GraspParams) -> BodyTable {
        let (footprint, grasper, rule) = (&body.footprint, &gripper.grasp, Rule::new(gripper, params.score));
        let subject = Subject::new(body);
        let zero = longest_side_normal(footprint);
        let directions: Vec<(f64, f64, f64)> = (0..params.angles)
            .map(|k| {
                let angle = zero + std::f64::consts::PI * k as f64 / params.angles as f64;
                let (sin, cos) = angle.sin_cos();
                (angle, sin, cos)
            })
            .collect();
        let full = [grasper.opening];
        let openings = if params.pre_openings.is_empty() { &full[..] } else { &params.pre_openings[..] };
        let mut candidates = Vec::new();
        let mut pieces = Pieces::default();
        let mut heights = Vec::new();
        let mut narrowest = f64::INFINITY;
        let reached = gripper.too_low(body.height).is_none();
        for (direction, &(_, sin, cos)) in directions.iter().enumerate().filter(|_| reached) {
            let seen = Frame { origin: Vec2::zeros(), sin: -sin, cos };
            offsets(footprint, &seen, grasper, params, rule.scale, &mut heights);
            for &y in &heights {
                for &opening in openings.iter().filter(|o| **o <= grasper.opening) {
                    let hold = subject.hold(&seen, y, opening, &rule, &mut pieces);
                    let Some(hold) = hold.filter(|h| h.meets(grasper)) else { continue };
                    narrowest = narrowest.min(hold.width());
                    if !hold.fits() {
                        continue;
                    }
                    let margin =
                        hold.fit_spare(hold.middle(), opening, grasper).min(hold.cover - grasper.min_cover).max(0.0);
                    candidates.push(Candidate { hold, direction, y, opening, margin, guide: false });
                }
            }
        }
        let off = |c: &Candidate| {
            let (_, sin, cos) = directions[c.direction];
            let seen = Frame { origin: Vec2::zeros(), sin: -sin, cos };
            quantum((c.y - seen.point(footprint.centroid).y).abs())
        };
        // Rounded, so that equals stay in the order of their directions.
        candidates.sort_by_key(|c| {
            (std::cmp::Reverse(quantum(c.hold.score)), std::cmp::Reverse(quantum(c.margin)), off(c), c.direction)
        });
        let mut guides = vec![0; params.angles];
        for c in &mut candidates {
            guides[c.direction] += 1;
            c.guide = guides[c.direction] <= params.near_offsets;
        }
        let half_width = grasper.finger_width / 2.0 + grasper.finger_clearance;
        let reach = candidates
            .iter()
            .map(|c| {
                let x = c.hold.lo.abs().max(c.hold.hi.abs());
                let along = x + c.opening / 2.0 + grasper.finger_thickness + grasper.finger_clearance;
                along.hypot(c.y.abs() + half_width)
            })
            .fold(0.0, f64::max);
        BodyTable { candidates, directions, reach, narrowest }
    }
}

/// A measure as a whole number of 1e-9.
fn quantum(x: f64) -> i64 {
    (x * 1e9).round() as i64
}

/// Positions of the pads' middle in the jaw's frame: evenly about the centroid, and as far apart beyond until the pads
/// just cover enough of either end, and there.
fn offsets(
    footprint: &Footprint,
    seen: &Frame,
    grasper: &Grasper,
    params: &GraspParams,
    scale: f64,
    out: &mut Vec<f64>,
) {
    let centre = seen.point(footprint.centroid).y;
    out.clear();
    if params.offsets < 2 {
        out.push(centre);
        return;
    }
    let step = 2.0 * params.offset_reach / (params.offsets - 1) as f64;
    out.extend((0..params.offsets).map(|j| centre - params.offset_reach + step * j as f64));
    if step <= 0.0 {
        return;
    }
    let beyond = grasper.finger_width / 2.0 - grasper.min_cover - scale * END_SPARE;
    for side in [-1.0, 1.0] {
        let end = footprint.support(seen.inverse_vector(vec2(0.0, side))) + beyond - side * centre;
        let end = end.min(params.end_reach);
        let steps = ((end - params.offset_reach) / step - scale * SAME_PLACE / step).ceil();
        let mut at = params.offset_reach;
        for _ in 0..steps.max(0.0) as usize {
            at = (at + step).min(end);
            out.push(centre + side * at);
        }
    }
}

/// Angle of the normal of the hull's longest side, the first of several.
fn longest_side_normal(footprint: &Footprint) -> f64 {
    let hull = convex_hull(&footprint.outlines.concat());
    let mut best = (0.0, 0.0);
    for (i, p) in hull.iter().enumerate() {
        let side = hull[(i + 1) % hull.len()] - p;
        if side.norm() > best.0 + 1e-9 {
            best = (side.norm(), (-side.x).atan2(side.y));
        }
    }
    best.1
}
