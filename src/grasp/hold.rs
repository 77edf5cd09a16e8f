//! What the jaw finds between its pads when it comes down on a body: a matter of the body's shape alone.

use super::jaw::{Band, Pieces};
use super::params::GraspScore;
use crate::geom::{Footprint, Frame, Piece, Shape, Vec2};
use crate::scene::{Body, GraspFeatures, Grasper, Gripper};

/// Features of the target this close to the point that a pad meets first count as met: a pad gives that much. Metres, for
/// the published gripper.
const TOUCH: f64 = 5e-5;
/// What lies this close to the target's outermost point comes to lie on the pad when it closes ([`GraspFeatures::touch`]):
/// metres, for the published gripper.
const YIELD: f64 = 0.002;
/// From a whole factor of the end to its floor, as a share of the way to the end.
const END_WIDTH: f64 = 0.1;
/// An edge is in a band if this much of it is, metres, for the published gripper.
const SLIVER: f64 = 1e-6;

/// By what a hold is judged.
pub(super) struct Rule<'a> {
    pub gripper: &'a Gripper,
    /// Fitted to the gripper.
    pub score: GraspScore,
    /// Of the gripper: [`Gripper::scale`].
    pub scale: f64,
}

/// A body between the pads, in the jaw's frame turned about the body's origin: x is the position of the jaw's middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hold {
    /// Where the jaw's middle may be with the target fitting between the fingers; none where `lo > hi`.
    pub lo: f64,
    pub hi: f64,
    /// Extent of the target between the pads.
    pub left: f64,
    pub right: f64,
    /// Length of the target that the pads cover.
    pub cover: f64,
    /// Angle between the two gripped faces, radians.
    pub wedge: f64,
    /// The least turn that lays a face flat on its pad, radians.
    turn: f64,
    /// How far the target reaches beyond the pads' middle along them, the lesser of both ways.
    past: f64,
    /// Score with all the clearance in the world.
    pub score: f64,
    /// Log odds of keeping without the share of the clearance; 0 for a gripper without a model of that.
    log_odds: f64,
}

impl Hold {
    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    pub fn middle(&self) -> f64 {
        (self.left + self.right) / 2.0
    }

    /// Spare room of the fit with the jaw's middle at `x`, metres.
    pub fn fit_spare(&self, x: f64, opening: f64, grasper: &Grasper) -> f64 {
        opening / 2.0 - grasper.fit - (self.right - x).max(x - self.left)
    }

    /// Gap between the open fingers and the target with the jaw's middle at `x`, metres.
    pub fn gap(&self, x: f64, opening: f64) -> f64 {
        opening / 2.0 - (self.right - x).max(x - self.left)
    }

    /// The score with the jaw's middle at `x`, where the open fingers have `gap` to the other bodies and the rule's spare
    /// room beside these is `spare`, metres.
    pub fn scored(&self, x: f64, opening: f64, gap: f64, spare: f64, rule: &Rule) -> f64 {
        match &rule.gripper.keeping {
            Some(keeping) => keeping.with_clearance(self.log_odds, gap.min(self.gap(x, opening))),
            None => self.score * rule.score.clearance(spare),
        }
    }

    /// The pads cover enough of the target, and its faces are parallel enough.
    pub fn meets(&self, grasper: &Grasper) -> bool {
        self.cover >= grasper.min_cover && self.wedge <= grasper.max_wedge
    }

    /// The target passes between the fingers.
    pub fn fits(&self) -> bool {
        self.lo <= self.hi
    }
}

impl<'a> Rule<'a> {
    /// `score` as [`GraspScore::fitted`] to the gripper gives it.
    pub fn new(gripper: &'a Gripper, score: GraspScore) -> Self {
        Rule { gripper, score, scale: gripper.scale() }
    }

    /// More room than this makes no grasp better, metres.
    pub fn enough_clearance(&self) -> f64 {
        self.gripper.keeping.as_ref().map_or(self.score.full_clearance, |keeping| keeping.clearance.end())
    }
}

/// A body for working out holds.
pub(super) struct Subject<'a> {
    body: &'a Body,
    pub footprint: &'a Footprint,
    /// The outlines that are no discs.
    outlines: Vec<&'a [Vec2]>,
}

impl<'a> Subject<'a> {
    pub fn new(body: &'a Body) -> Self {
        let footprint = &body.footprint;
        let mut discs = Vec::new();
        mark_discs(&footprint.shape, &mut discs);
        let outlines =
            footprint.outlines.iter().zip(&discs).filter(|(_, disc)| !**disc).map(|(o, _)| o.as_slice()).collect();
        Self { body, footprint, outlines }
    }

    /// The hold of a jaw whose frame sees the body at `frame`, with the pads' middle at height `y`.
    /// `pieces` is working memory. None where there is nothing between the pads.
    pub fn hold(&self, frame: &Frame, y: f64, opening: f64, rule: &Rule, pieces: &mut Pieces) -> Option<Hold> {
        let (grasper, score) = (&rule.gripper.grasp, &rule.score);
        pieces.clear();
        pieces.add(0, self.footprint, frame);
        let half = grasper.finger_width / 2.0;
        let span = |band: Band| {
            pieces
                .iter()
                .filter_map(|p| pieces.slice(p, band))
                .reduce(|a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1)))
        };
        let pads = Band::around(y, half);
        let (left, right) = span(pads)?;
        // The fingers keep their clearance to the target too, also where it bulges beside the pads.
        let (near_left, near_right) = span(Band::around(y, half + grasper.finger_clearance))?;
        let need_right = (right + grasper.fit).max(near_right + grasper.finger_clearance);
        let need_left = (left - grasper.fit).min(near_left - grasper.finger_clearance);
        let (low, high) = pieces
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi): (f64, f64), p| (lo.min(p.min.y), hi.max(p.max.y)));
        let within = |reach: f64| (high.min(y + reach) - low.max(y - reach)).max(0.0);
        let (right_tilts, left_tilts) =
            (self.tilts(frame, pads, 1.0, rule.scale)?, self.tilts(frame, pads, -1.0, rule.scale)?);
        let wedge = (right_tilts.lo - left_tilts.hi).max(left_tilts.lo - right_tilts.hi).max(0.0);
        let turn = right_tilts.least.min(left_tilts.least);
        let spare = (opening - (right - left)) / 2.0 - grasper.fit;
        let middle = frame.point(self.footprint.centroid).y;
        let end = if y > middle { (y - middle) / (high - middle) } else { (y - middle) / (low - middle) };
        let mut hold = Hold {
            lo: need_right - opening / 2.0,
            hi: need_left + opening / 2.0,
            left,
            right,
            cover: within(half),
            wedge,
            turn,
            past: (high - y).min(y - low),
            score: 0.0,
            log_odds: 0.0,
        };
        match &rule.gripper.keeping {
            Some(keeping) => {
                let features = self.features(&hold, y, opening, rule, pieces);
                hold.log_odds = keeping.without_clearance(&features);
                hold.score = keeping.with_clearance(hold.log_odds, features.clearance);
            }
            None => {
                let alone = score.alone(within(2.0 * half), wedge, grasper.max_wedge, turn, spare);
                hold.score = alone * score.end(end, turn);
            }
        }
        Some(hold)
    }

    /// What a hold is known by, its clearance being that to the target from the middle. `pieces` are those that it was
    /// found with.
    pub fn features(&self, hold: &Hold, y: f64, opening: f64, rule: &Rule, pieces: &Pieces) -> GraspFeatures {
        let pads = Band::around(y, rule.gripper.grasp.finger_width / 2.0);
        let touch = |side: f64, outermost: f64| {
            let met = pieces.iter().filter_map(|p| pieces.beyond(p, pads, side, outermost - rule.scale * YIELD));
            met.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).map_or(0.0, |(lo, hi)| hi - lo)
        };
        GraspFeatures {
            width: hold.width(),
            touch: touch(1.0, hold.right).min(touch(-1.0, -hold.left)),
            turn: hold.turn,
            end: hold.past,
            clearance: hold.gap(hold.middle(), opening),
            height: self.body.height,
            mass: self.body.mass,
        }
    }

    /// The tilts of the faces that the pad on one side (1: towards +x, -1: towards -x) meets in the band: angles of
    /// the faces' normals from the pad's, the same for parallel faces on either side. A corner met in the band's
    /// inside stands for every tilt between its two faces.
    fn tilts(&self, frame: &Frame, band: Band, side: f64, scale: f64) -> Option<Tilts> {
        let mut tilts = Tilts { lo: f64::INFINITY, hi: f64::NEG_INFINITY, least: f64::INFINITY };
        let mut reach = f64::NEG_INFINITY;
        // Twice over: how far the faces reach, then which of them reach so far.
        for pass in 0..2 {
            let mut face = |extent: f64, tilt: f64| {
                if pass == 0 {
                    reach = reach.max(extent);
                } else if extent >= reach - scale * TOUCH {
                    tilts.lo = tilts.lo.min(tilt);
                    tilts.hi = tilts.hi.max(tilt);
                    tilts.least = tilts.least.min(tilt.abs());
                }
            };
            for outline in &self.outlines {
                for (i, &p) in outline.iter().enumerate() {
                    let (p, q) = (frame.point(p), frame.point(outline[(i + 1) % outline.len()]));
                    let (nx, ny) = ((q.y - p.y) * side, (p.x - q.x) * side);
                    let (lo, hi) = (p.y.min(q.y).max(band.lo), p.y.max(q.y).min(band.hi));
                    if nx <= 0.0 || hi - lo <= (scale * SLIVER).min(nx / 2.0) {
                        continue;
                    }
                    let x = |y: f64| (p.x + (q.x - p.x) * (y - p.y) / (q.y - p.y)) * side;
                    face(x(lo).max(x(hi)), ny.atan2(nx));
                }
            }
            for piece in &self.footprint.pieces {
                if let Piece::Disc { centre, radius } = piece {
                    let c = frame.point(*centre);
                    let dy = c.y.clamp(band.lo, band.hi) - c.y;
                    if dy.abs() < *radius {
                        let half = (radius * radius - dy * dy).sqrt();
                        // The normal's reverse is what counts on the left, as for the edges.
                        face(c.x * side + half, (dy * side).atan2(half));
                    }
                }
            }
        }
        (tilts.lo <= tilts.hi).then_some(tilts)
    }
}

struct Tilts {
    lo: f64,
    hi: f64,
    /// Least absolute tilt of a face met.
    least: f64,
}

/// Which of the outlines of a footprint are discs, in their order.
fn mark_discs(shape: &Shape, out: &mut Vec<bool>) {
    match shape {
        Shape::Compound(parts) => parts.iter().for_each(|p| mark_discs(&p.shape, out)),
        other => out.push(matches!(other, Shape::Disc { .. })),
    }
}

impl GraspScore {
    /// All factors but that of clearance.
    fn alone(&self, face: f64, wedge: f64, max_wedge: f64, turn: f64, spare: f64) -> f64 {
        let square = |x: f64, limit: f64| if limit > 0.0 { (x / limit).clamp(0.0, 1.0).powi(2) } else { 0.0 };
        (face / self.full_face).min(1.0)
            * (1.0 - (1.0 - self.wedge_floor) * square(wedge, max_wedge))
            * (1.0 - (1.0 - self.turn_floor) * square(turn, self.full_turn))
            * ramp(self.width_floor, spare / self.full_width_spare)
    }

    /// The factor of a grip turned by `turn`, at this share of the way from the centroid to the body's end.
    fn end(&self, share: f64, turn: f64) -> f64 {
        ramp(self.end_floor, (self.end_share - self.end_turn * turn - share) / END_WIDTH)
    }

    /// The factor of clearance for so much spare room round the fingers, metres.
    pub(super) fn clearance(&self, spare: f64) -> f64 {
        ramp(self.clearance_floor, spare / self.full_clearance)
    }
}

fn ramp(floor: f64, x: f64) -> f64 {
    floor + (1.0 - floor) * x.clamp(0.0, 1.0)
}
