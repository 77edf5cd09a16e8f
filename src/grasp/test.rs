//! The geometric grasp test.

use super::failed::{FailedGrasp, belief};
use super::hold::{Hold, Rule, Subject};
use super::jaw::{Band, Pieces};
use super::params::{GraspParams, GraspScore};
use super::scorer::GraspAssessment;
use super::table::{BodyTable, Candidate, Tables};
use crate::action::Grasp;
use crate::error::Result;
use crate::geom::{Frame, Pose2, Vec2, vec2};
use crate::scene::{GraspFeatures, Grasper, Scene, State};

/// Scores and margins closer than this are equal: rounding must not choose between grasps.
const EQUAL: f64 = 1e-9;

/// Finds vertical two-finger grasps from footprints alone.
///
/// The rule, all measures being the gripper's ([`Grasper`]): the open fingers, two rectangles outside the opening, keep
/// `finger_clearance` to every body on all sides; the target between the pads leaves `fit` on either side; no other
/// body reaches into the space between the fingers, but for the outer `pad_edge` on either side; the pads cover at
/// least `min_cover` of the target; the gripped faces are at most `max_wedge` out of parallel. Clearance is kept
/// as a rectangle grown on all sides, as image masks do. Exact for convex pieces and discs.
///
/// Directions and positions are the body's own, so the result turns and moves with the scene.
///
/// Thread rule: shared freely between threads; a scratch is used by one thread at a time.
#[derive(Debug, Clone)]
pub struct GraspTest {
    params: GraspParams,
    tables: Option<Tables>,
    /// Grasps like these are believed in less.
    failed: Vec<FailedGrasp>,
}

/// Working memory of the grasp test for one thread.
#[derive(Debug, Default)]
pub struct GraspScratch {
    /// The other bodies near the target.
    near: Vec<(usize, Frame)>,
    /// The same as the jaw sees them, for each direction that was needed.
    views: Vec<View>,
    /// What the pads' height leaves in the way.
    blocks: Vec<Block>,
    /// Blocked positions of the jaw, sorted.
    blocked: Vec<(f64, f64)>,
    /// Working memory of a single check.
    pub(super) pieces: Pieces,
}

#[derive(Debug, Default)]
struct View {
    ready: bool,
    pieces: Pieces,
}

/// A piece in the way of a finger or of the jaw: positions of the jaw's middle between `lo` and `hi` are blocked.
#[derive(Debug, Clone, Copy)]
struct Block {
    body: usize,
    lo: f64,
    hi: f64,
    /// How far the piece would have to go along the pads to be out of the way.
    depth: f64,
}

/// A condition of the grasp rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// The target is not there, or no part of it is between the pads.
    Missing,
    /// The target may not be grasped ([`crate::scene::Body::pickable`]).
    NotPickable,
    /// The gripper does not open so far.
    Opening,
    /// The gripped faces are too far out of parallel.
    Wedge,
    /// The target's width in the opening.
    Width,
    /// The length of the target that the pads cover.
    Cover,
    /// The clearance of a finger to this body; to the target itself where that would fit between the fingers, but not with
    /// the jaw's middle here.
    Finger { body: usize },
    /// This body reaches between the fingers.
    Jaw { body: usize },
    /// How far the fingers reach down the target.
    Depth,
}

/// Why a body cannot be grasped wherever it and the others lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unholdable {
    /// It is at least so wide wherever it could be held, metres, which is more than the jaw takes.
    TooWide { width: f64 },
    /// The pads cover too little of it, or meet faces too far out of parallel.
    NoFaces,
    /// Its top is so much too low for the fingers, metres.
    TooLow { missing: f64 },
}

/// What the rule says of one grasp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GraspCheck {
    /// Least spare room of all conditions that are lengths, metres.
    pub margin: f64,
    /// The condition with the least spare room, or the one that is not met and has no length.
    pub limit: Limit,
    /// Angle between the gripped faces, radians.
    pub wedge: f64,
    /// Width of the target between the pads, metres.
    pub width: f64,
    /// Quality in [0, 1]; 0 where a condition is not met.
    pub score: f64,
    /// The chance that the gripper keeps the target, whether or not the conditions are met: they say what a planner may
    /// do. None for a gripper without a model of that ([`crate::scene::Keeping`]); 0 where no part of the target is
    /// between the pads.
    pub chance: Option<f64>,
}

impl GraspCheck {
    /// All conditions hold.
    pub fn holds(&self) -> bool {
        self.margin >= 0.0 && !matches!(self.limit, Limit::Missing | Limit::NotPickable | Limit::Wedge)
    }

    /// Nothing to grasp.
    pub(super) fn missing(scene: &Scene, body: usize) -> GraspCheck {
        let kept_back = scene.bodies().get(body).is_some_and(|body| !body.pickable);
        GraspCheck {
            margin: f64::NEG_INFINITY,
            limit: if kept_back { Limit::NotPickable } else { Limit::Missing },
            wedge: 0.0,
            width: 0.0,
            score: 0.0,
            chance: scene.gripper().keeping.as_ref().map(|_| 0.0),
        }
    }
}

/// A grasp of the search's.
#[derive(Clone, Copy)]
pub(super) struct Best {
    candidate: Candidate,
    x: f64,
    margin: f64,
    score: f64,
}

impl Best {
    /// Which of two is the better; rounding must not choose.
    pub fn beats(&self, other: &Best) -> bool {
        self.score > other.score + EQUAL || (self.score > other.score - EQUAL && self.margin > other.margin + EQUAL)
    }
}

impl GraspTest {
    pub fn new(params: GraspParams) -> Result<Self> {
        params.validate()?;
        Ok(Self { params, tables: None, failed: Vec::new() })
    }

    pub fn params(&self) -> &GraspParams {
        &self.params
    }

    /// The same test with all that does not depend on poses worked out for this scene. The result is the same without
    /// it, and much slower. It may be used on any scene with the same footprints and gripper.
    #[must_use]
    pub fn prepared(&self, scene: &Scene) -> Self {
        let tables = Some(Tables::new(scene, &self.params));
        Self { params: self.params.clone(), tables, failed: self.failed.clone() }
    }

    /// The same test that scores grasps like these lower when it looks for the best; [`check`](Self::check) does not.
    #[must_use]
    pub fn avoiding(&self, failed: &[FailedGrasp]) -> Self {
        Self { failed: failed.to_vec(), ..self.clone() }
    }

    pub(super) fn with_tables<R>(&self, scene: &Scene, run: impl FnOnce(&Tables) -> R) -> R {
        match &self.tables {
            Some(tables) if tables.fits(scene) => run(tables),
            _ => run(&Tables::new(scene, &self.params)),
        }
    }

    /// The best grasp of a body: highest score, then widest margin, then nearest to the body's middle, then lowest
    /// direction. None where there is none, or the body is absent or not pickable.
    /// `state` must belong to `scene`. No memory is allocated once `scratch` is warm and the test is prepared.
    pub fn best(&self, scene: &Scene, state: &State, body: usize, scratch: &mut GraspScratch) -> Option<Grasp> {
        self.with_tables(scene, |tables| self.search(tables, scene, state, body, scratch, None))
    }

    /// The best grasp of any body that is present and pickable; the lowest index of equals.
    pub fn best_any(&self, scene: &Scene, state: &State, scratch: &mut GraspScratch) -> Option<Grasp> {
        self.with_tables(scene, |tables| {
            let mut best: Option<Grasp> = None;
            for (body, _) in state.iter() {
                let Some(grasp) = self.search(tables, scene, state, body, scratch, None) else { continue };
                let better = best.is_none_or(|b| {
                    grasp.score > b.score + EQUAL || (grasp.score > b.score - EQUAL && grasp.margin > b.margin + EQUAL)
                });
                if better {
                    best = Some(grasp);
                }
            }
            best
        })
    }

    /// Why the body has no grasp in any state; none where it has one on an empty table. As far as the test's directions
    /// and positions go.
    pub fn unholdable(&self, scene: &Scene, body: usize) -> Option<Unholdable> {
        if let Some(missing) = scene.gripper().too_low(scene.bodies().get(body)?.height) {
            return Some(Unholdable::TooLow { missing });
        }
        self.with_tables(scene, |tables| {
            let table = tables.body(scene, body).filter(|table| table.candidates.is_empty())?;
            let wide = table.narrowest.is_finite();
            Some(if wide { Unholdable::TooWide { width: table.narrowest } } else { Unholdable::NoFaces })
        })
    }

    /// The score of the best grasp that the body has where it lies alone; none where it has no grasp. As far as the test's
    /// directions and positions go.
    pub fn greatest_score(&self, scene: &Scene, body: usize) -> Option<f64> {
        self.with_tables(scene, |tables| {
            let table = tables.body(scene, body)?;
            if self.failed.is_empty() {
                return Some(table.candidates.first()?.hold.score);
            }
            let scale = scene.gripper().scale();
            let score = |c: &Candidate| c.hold.score * self.believed(table, c, c.hold.middle(), body, scale);
            table.candidates.iter().map(score).max_by(f64::total_cmp)
        })
    }

    /// What is left of a candidate's score where grasps of the body failed.
    fn believed(&self, table: &BodyTable, candidate: &Candidate, x: f64, body: usize, scale: f64) -> f64 {
        let (angle, sin, cos) = table.directions[candidate.direction];
        let place = Frame { origin: Vec2::zeros(), sin, cos }.point(vec2(x, candidate.y));
        belief(&self.failed, body, place, angle, scale)
    }

    /// The best grasp, and how near the state is to allowing one.
    pub fn assess(&self, scene: &Scene, state: &State, body: usize, scratch: &mut GraspScratch) -> GraspAssessment {
        self.with_tables(scene, |tables| {
            let mut violation = f64::INFINITY;
            let grasp = self.search(tables, scene, state, body, scratch, Some(&mut violation));
            match grasp {
                Some(g) => GraspAssessment { grasp, score: g.score, nearness: 1.0 },
                // Below 1 whatever the scale.
                None => GraspAssessment {
                    grasp,
                    score: 0.0,
                    nearness: 0.999 * (-violation / tables.params.nearness_scale).exp(),
                },
            }
        })
    }

    /// The best grasp. Where there is none and it is asked for, the least violation of the rule, metres: at one hold,
    /// the sum over the bodies in the way of how far each would have to go.
    pub(super) fn search(
        &self,
        tables: &Tables,
        scene: &Scene,
        state: &State,
        body: usize,
        scratch: &mut GraspScratch,
        mut violation: Option<&mut f64>,
    ) -> Option<Grasp> {
        let mut trial = Trial::new(self, tables, scene, state, body, scratch)?;
        let mut best: Option<Best> = None;
        for candidate in &trial.table.candidates {
            if let Some(b) = &best {
                // Sorted by score: nothing better comes.
                if candidate.hold.score < b.score - EQUAL {
                    break;
                }
                if candidate.hold.score <= b.score + EQUAL && candidate.margin <= b.margin + EQUAL {
                    continue;
                }
            }
            let wanted = candidate.guide && best.is_none();
            let Some(found) = trial.grasp(candidate, violation.as_deref_mut().filter(|_| wanted)) else { continue };
            if best.is_none_or(|b| found.beats(&b)) {
                best = Some(found);
            }
        }
        best.map(|b| trial.placed(&b))
    }

    /// Examines one grasp by the same rule, whatever its direction and position. Its `margin`, `score` and `width`
    /// are not read.
    pub fn check(&self, scene: &Scene, state: &State, grasp: &Grasp, scratch: &mut GraspScratch) -> GraspCheck {
        let score = self.params.score.fitted(scene.gripper());
        match look(scene, state, grasp, score, scratch) {
            Some(met) => met.judged(scene, grasp, &score, 0.0),
            None => GraspCheck::missing(scene, grasp.body),
        }
    }

    /// What one grasp is known by, whatever the rule says of it. None where no part of the body is between the pads, or
    /// it is absent or not pickable. The grasp's `margin`, `score` and `width` are not read.
    pub fn features(
        &self,
        scene: &Scene,
        state: &State,
        grasp: &Grasp,
        scratch: &mut GraspScratch,
    ) -> Option<GraspFeatures> {
        let score = self.params.score.fitted(scene.gripper());
        look(scene, state, grasp, score, scratch).map(|met| met.features)
    }
}

/// A body among the others, made ready for its holds to be tried.
pub(super) struct Trial<'a> {
    test: &'a GraspTest,
    scene: &'a Scene,
    pub table: &'a BodyTable,
    params: &'a GraspParams,
    rule: Rule<'a>,
    body: usize,
    pose: Pose2,
    own: Frame,
    scratch: &'a mut GraspScratch,
}

impl<'a> Trial<'a> {
    /// None for a body that is absent or not pickable.
    pub fn new(
        test: &'a GraspTest,
        tables: &'a Tables,
        scene: &'a Scene,
        state: &State,
        body: usize,
        scratch: &'a mut GraspScratch,
    ) -> Option<Self> {
        if body >= scene.len() || !state.is_present(body) || !scene.body(body).pickable {
            return None;
        }
        let table = tables.body(scene, body)?;
        let params = &tables.params;
        let rule = Rule::new(scene.gripper(), params.score);
        let GraspScratch { near, views, .. } = &mut *scratch;
        let pose = state.pose(body);
        let own = pose.frame();
        let end = scene.gripper().fingers_end(scene.body(body).height);
        let in_the_way = |i: usize| i != body && scene.body(i).height > end;
        near.clear();
        near.extend(state.iter().filter(|(i, _)| in_the_way(*i)).filter_map(|(i, other)| {
            let away = other.position() - own.origin;
            let reach = table.reach + scene.body(i).footprint.radius;
            (away.norm_squared() < reach * reach).then(|| (i, seen_from(&own, &other.frame())))
        }));
        if views.len() < table.directions.len() {
            views.resize_with(table.directions.len(), View::default);
        }
        views.iter_mut().for_each(|v| v.ready = false);
        Some(Trial { test, scene, table, params, rule, body, pose, own, scratch })
    }

    /// The candidate where it has the most room, if it has any. Where it has none and that is asked for, lowers `least`
    /// to the candidate's violation.
    pub fn grasp(&mut self, candidate: &Candidate, least: Option<&mut f64>) -> Option<Best> {
        let (rule, grasper) = (&self.rule, &self.scene.gripper().grasp);
        let enough = rule.enough_clearance();
        let GraspScratch { near, views, blocks, blocked, .. } = &mut *self.scratch;
        let view = &mut views[candidate.direction];
        if !view.ready {
            let (_, sin, cos) = self.table.directions[candidate.direction];
            let jaw = Frame { origin: Vec2::zeros(), sin, cos };
            view.pieces.clear();
            for (i, frame) in near.iter() {
                view.pieces.add(*i, &self.scene.body(*i).footprint, &seen_from(&jaw, frame));
            }
            view.ready = true;
        }
        let free = collect_blocks(&view.pieces, candidate, grasper, least.is_none(), blocks)
            .then(|| roomiest(&candidate.hold, blocks, blocked, enough))
            .flatten();
        let Some(x) = free else {
            if let Some(least) = least {
                measure(&candidate.hold, blocks, self.params.near_across, least);
            }
            return None;
        };
        let cap = candidate.margin.max(enough);
        let room = Room::about(&view.pieces, x, candidate.y, candidate.opening, grasper, cap);
        // A position between the blocks is legal; rounding may say otherwise by a hair.
        let spare = room.spare.max(0.0);
        let mut score = candidate.hold.scored(x, candidate.opening, room.gap, spare, rule);
        if !self.test.failed.is_empty() {
            score *= self.test.believed(self.table, candidate, x, self.body, rule.scale);
        }
        let margin = spare
            .min(candidate.hold.fit_spare(x, candidate.opening, grasper).max(0.0))
            .min((x - candidate.hold.lo).min(candidate.hold.hi - x).max(0.0))
            .min(candidate.hold.cover - grasper.min_cover);
        Some(Best { candidate: *candidate, x, margin, score })
    }

    /// The same in the world.
    pub fn placed(&self, best: &Best) -> Grasp {
        to_grasp(best, self.table, self.body, &self.pose, &self.own)
    }
}

/// What the jaw meets at one grasp.
pub(super) struct Met {
    hold: Hold,
    pub features: GraspFeatures,
    room: Room,
}

impl Met {
    /// What the rule says. Lengths that are missing by no more than `hair` are there.
    pub fn judged(&self, scene: &Scene, grasp: &Grasp, score: &GraspScore, hair: f64) -> GraspCheck {
        let (grasper, hold, room) = (&scene.gripper().grasp, &self.hold, &self.room);
        let fit = hold.fit_spare(0.0, grasp.opening, grasper);
        let aside = fit < 0.0 && hold.width() + 2.0 * grasper.fit <= grasp.opening;
        let mut check = GraspCheck {
            margin: fit,
            limit: if aside { Limit::Finger { body: grasp.body } } else { Limit::Width },
            wedge: hold.wedge,
            width: hold.width(),
            score: 0.0,
            chance: scene.gripper().keeping.as_ref().map(|keeping| keeping.chance(&self.features)),
        };
        let mut consider = |spare: f64, limit: Limit| {
            if spare < check.margin {
                (check.margin, check.limit) = (spare, limit);
            }
        };
        consider((-hold.lo).min(hold.hi), Limit::Finger { body: grasp.body });
        if grasp.opening > grasper.opening {
            consider(grasper.opening - grasp.opening, Limit::Opening);
        }
        consider(hold.cover - grasper.min_cover, Limit::Cover);
        if let Some(missing) = scene.gripper().too_low(scene.body(grasp.body).height) {
            consider(-missing, Limit::Depth);
        }
        consider(room.spare, room.limit);
        if hold.wedge > grasper.max_wedge {
            check.limit = Limit::Wedge;
        } else if check.margin >= -hair {
            check.margin = check.margin.max(0.0);
            check.score = check.chance.unwrap_or_else(|| hold.score * score.clearance(room.spare));
        }
        check
    }

    /// Spare room between the open fingers and the target, metres.
    pub fn fit_spare(&self, opening: f64, grasper: &Grasper) -> f64 {
        self.hold.fit_spare(0.0, opening, grasper).min((-self.hold.lo).min(self.hold.hi))
    }

    /// A part of the target is between the open pads.
    pub fn is_between(&self, opening: f64) -> bool {
        self.hold.left < opening / 2.0 && self.hold.right > -opening / 2.0
    }

    /// Length of the target that the pads cover, metres.
    pub fn cover(&self) -> f64 {
        self.hold.cover
    }
}

/// Looks at one grasp; the scratch's pieces are then those of the other bodies, as the jaw sees them.
pub(super) fn look(
    scene: &Scene,
    state: &State,
    grasp: &Grasp,
    score: GraspScore,
    scratch: &mut GraspScratch,
) -> Option<Met> {
    let finite = grasp.position.iter().all(|v| v.is_finite()) && grasp.angle.is_finite() && grasp.opening > 0.0;
    if grasp.body >= scene.len() || !state.is_present(grasp.body) || !scene.body(grasp.body).pickable || !finite {
        return None;
    }
    let jaw = Pose2::new(grasp.position[0], grasp.position[1], grasp.angle).frame();
    let seen = seen_from(&jaw, &state.pose(grasp.body).frame());
    let (subject, rule) = (Subject::new(scene.body(grasp.body)), Rule::new(scene.gripper(), score));
    let pieces = &mut scratch.pieces;
    let hold = subject.hold(&seen, 0.0, grasp.opening, &rule, pieces)?;
    let mut features = subject.features(&hold, 0.0, grasp.opening, &rule, pieces);
    // `pieces` held the target; its own clearance to the fingers is part of the fit.
    pieces.clear();
    let end = scene.gripper().fingers_end(scene.body(grasp.body).height);
    for (i, pose) in state.iter().filter(|(i, _)| *i != grasp.body && scene.body(*i).height > end) {
        pieces.add(i, &scene.body(i).footprint, &seen_from(&jaw, &pose.frame()));
    }
    let room = Room::about(pieces, 0.0, 0.0, grasp.opening, &scene.gripper().grasp, f64::INFINITY);
    features.clearance = room.gap.min(hold.gap(0.0, grasp.opening));
    Some(Met { hold, features, room })
}

/// A frame as seen from another.
pub(super) fn seen_from(viewer: &Frame, other: &Frame) -> Frame {
    Frame {
        origin: viewer.inverse_point(other.origin),
        sin: other.sin * viewer.cos - other.cos * viewer.sin,
        cos: other.cos * viewer.cos + other.sin * viewer.sin,
    }
}

/// Which positions of the jaw the pieces block, in the order of their bodies. With `stop`: false as soon as one of
/// them blocks all.
fn collect_blocks(pieces: &Pieces, c: &Candidate, grasper: &Grasper, stop: bool, blocks: &mut Vec<Block>) -> bool {
    blocks.clear();
    let (clear, half) = (grasper.finger_clearance, grasper.finger_width / 2.0);
    let inner = c.opening / 2.0 - clear;
    let outer = c.opening / 2.0 + grasper.finger_thickness + clear;
    let fingers = Band::around(c.y, half + clear);
    let strip = Band::around(c.y, half - grasper.pad_edge);
    let hold = &c.hold;
    for piece in pieces.iter() {
        if piece.min.x >= hold.hi + outer || piece.max.x <= hold.lo - outer {
            continue;
        }
        let Some((left, right)) = pieces.slice(piece, fingers) else { continue };
        let depth = (fingers.hi - piece.min.y).min(piece.max.y - fingers.lo);
        let mut block = |lo: f64, hi: f64, depth: f64| {
            let inside = lo < hold.hi && hi > hold.lo && lo < hi && depth > 0.0;
            if inside {
                blocks.push(Block { body: piece.body, lo, hi, depth });
            }
            inside && lo < hold.lo && hi > hold.hi
        };
        // The finger at -x, the one at +x, the space between them.
        let mut all = block(left + inner, right + outer, depth) | block(left - outer, right - inner, depth);
        if let Some((left, right)) = pieces.slice(piece, strip) {
            let depth = (strip.hi - piece.min.y).min(piece.max.y - strip.lo);
            all |= block(left - c.opening / 2.0, right + c.opening / 2.0, depth);
        }
        if all && stop {
            return false;
        }
    }
    true
}

/// The free position with the most room on either side (room beyond `enough` counts no more), and of equals the one
/// nearest to the target's middle. The fit bounds the room too.
fn roomiest(hold: &Hold, blocks: &[Block], blocked: &mut Vec<(f64, f64)>, enough: f64) -> Option<f64> {
    let middle = hold.middle();
    blocked.clear();
    blocked.extend(blocks.iter().map(|b| (b.lo, b.hi)));
    blocked.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let mut best: Option<(f64, f64)> = None;
    let mut from = hold.lo;
    for &(lo, hi) in blocked.iter().chain(std::iter::once(&(hold.hi, f64::INFINITY))) {
        let to = lo.min(hold.hi);
        if to >= from {
            let room = ((to - from) / 2.0).min(enough);
            // Not `clamp`: where there is no room to choose, rounding may carry the first bound beyond the second.
            let x = middle.max(from + room).min(to - room);
            let better = best.is_none_or(|(r, at)| {
                room > r + EQUAL || (room > r - EQUAL && (x - middle).abs() < (at - middle).abs() - EQUAL)
            });
            if better {
                best = Some((room, x));
            }
        }
        from = from.max(hi);
    }
    best.map(|(_, x)| x)
}

/// Lowers `least` to the violation at the best of some positions: the sum over bodies of how far each must go.
fn measure(hold: &Hold, blocks: &[Block], positions: usize, least: &mut f64) {
    for k in 0..positions {
        let t = if positions > 1 { k as f64 / (positions - 1) as f64 } else { 0.5 };
        let x = hold.lo + (hold.hi - hold.lo) * t;
        let (mut sum, mut worst, mut body) = (0.0, 0.0f64, usize::MAX);
        for b in blocks {
            if b.body != body {
                sum += worst;
                (worst, body) = (0.0, b.body);
            }
            worst = worst.max((x - b.lo).min(b.hi - x).min(b.depth));
            if sum + worst >= *least {
                break;
            }
        }
        *least = least.min(sum + worst);
    }
}

/// Room about the open jaw.
#[derive(Debug, Clone, Copy)]
pub(super) struct Room {
    /// Least spare room of the fingers and of the space between them to the pieces, metres.
    pub spare: f64,
    /// What leaves it.
    pub limit: Limit,
    /// Least gap of the fingers alone to the pieces, metres.
    pub gap: f64,
}

impl Room {
    /// Values from `cap` on may be too small, but are at least `cap`.
    pub fn about(pieces: &Pieces, x: f64, y: f64, opening: f64, grasper: &Grasper, cap: f64) -> Room {
        let mut room = Room { spare: f64::INFINITY, limit: Limit::Missing, gap: f64::INFINITY };
        let finger = vec2(grasper.finger_thickness / 2.0, grasper.finger_width / 2.0);
        let space = vec2(opening / 2.0, grasper.finger_width / 2.0 - grasper.pad_edge);
        let off = opening / 2.0 + grasper.finger_thickness / 2.0;
        let clear = grasper.finger_clearance;
        for piece in pieces.iter() {
            for side in [-off, off] {
                let gap = pieces.growth(piece, vec2(x + side, y), finger, cap.min(room.gap) + clear);
                room.gap = room.gap.min(gap);
                if gap - clear < room.spare {
                    (room.spare, room.limit) = (gap - clear, Limit::Finger { body: piece.body });
                }
            }
            let spare = pieces.growth(piece, vec2(x, y), space, cap.min(room.spare));
            if spare < room.spare {
                (room.spare, room.limit) = (spare, Limit::Jaw { body: piece.body });
            }
        }
        room
    }
}

fn to_grasp(b: &Best, table: &BodyTable, body: usize, pose: &Pose2, own: &Frame) -> Grasp {
    let (angle, sin, cos) = table.directions[b.candidate.direction];
    let jaw = Frame { origin: Vec2::zeros(), sin, cos };
    let position = own.point(jaw.point(vec2(b.x, b.candidate.y)));
    // A closing direction and its reverse are the same grasp.
    let turned = (pose.theta + angle).rem_euclid(std::f64::consts::PI);
    Grasp {
        body,
        position: [position.x, position.y],
        angle: if turned < std::f64::consts::PI { turned } else { 0.0 },
        opening: b.candidate.opening,
        width: b.candidate.hold.width(),
        margin: b.margin,
        score: b.score,
    }
}
