//! Seeded packed retrieval scenes, after the generator of the originals' hard cases.
//!
//! A scene grows from one item at the workspace's centre. Each further item, at orientation 0 or pi, is attached with
//! a corner (or, by [`GeneratorParams::midpoint_chance`], the middle of an edge) to a corner (or middle of an edge) of
//! an item that is there already, so that the two share a stretch of edge and nothing overlaps. An item is a block, or
//! two concave blocks with a cylinder between them. Items are placed by their bounding polygons (a cylinder by its
//! square, a concave block by its rectangle), grown a little so that gaps of one to two millimetres stay between the
//! blocks. At the end the whole scene is turned by a random angle about the workspace's centre.
//!
//! Two things differ from the original: polygons attach to any item instead of the outline of the union (a place
//! within the outline is refused for its overlap, so the same arrangements come about), and the scene is settled as it
//! is placed, where the original drops it.

use std::f64::consts::PI;
use std::ops::RangeInclusive;
use std::sync::Arc;

use super::arc::ArcProfile;
use super::body::{Body, BodyDef, MAX_SIMULATED};
use super::library::{self, BlockConvention, block_of, block_size};
use super::state::State;
use super::world::{Problem, SceneBuilder};
use crate::error::{Error, Result, check_range};
use crate::geom::{Pose2, Vec2, intersection_area, vec2};
use crate::run::{Key, Stream};

/// How often each item is drawn, in relation: each polygon 6, the concave block 4, the cylinder 2, the sandwich 1.
const WEIGHTS: [(&str, usize); 7] =
    [("cube", 6), ("half_cube", 6), ("rect", 6), ("triangle", 6), ("concave", 4), ("cylinder", 2), (SANDWICH, 1)];
const SANDWICH: &str = "concave, cylinder, concave";
/// Least stretch of edge that an attached item shares with another, metres.
const LEAST_CONTACT: f64 = 0.005;
/// Places tried for an item before the scene is begun anew.
const PLACES: usize = 200;
/// Scenes begun before the parameters are held to be impossible.
const ATTEMPTS: u64 = 200;
/// Scenes drawn for each one that a filter keeps, at most (over a whole call).
const DRAWS_PER_KEPT: u64 = 1000;
/// How far from a body's side its neighbourhood is probed, metres: amid a finger that grasps it.
const FINGER_REACH: f64 = 0.008;
/// Spacing of the probes along the side, metres.
const PROBE_SPACING: f64 = 0.005;

/// Which body is to be retrieved. It is made body 0, as in the originals' files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TargetRule {
    /// The one with the greatest part of its side so close to others that no finger fits between.
    #[default]
    MostEnclosed,
    /// The first placed, about which the others were laid (the originals' rule).
    FirstPlaced,
}

/// What scenes to make.
#[derive(Debug, Clone, PartialEq)]
pub struct GeneratorParams {
    /// Least and greatest number of bodies; every number between is as likely.
    pub bodies: RangeInclusive<usize>,
    /// Workspace, friction and masses. Body centres keep a push's length from the workspace's edge (before the scene
    /// is turned), footprints stay within the circle inscribed in it.
    pub profile: ArcProfile,
    /// Least and greatest gap between attached items, metres.
    pub gap: [f64; 2],
    /// Probability that an item attaches by the middle of an edge instead of a corner.
    pub midpoint_chance: f64,
    pub target: TargetRule,
    pub convention: BlockConvention,
}

impl Default for GeneratorParams {
    fn default() -> Self {
        Self {
            bodies: 5..=12,
            profile: ArcProfile::More,
            gap: [0.001, 0.002],
            midpoint_chance: 0.3,
            target: TargetRule::MostEnclosed,
            convention: BlockConvention::TrueCentroid,
        }
    }
}

impl GeneratorParams {
    /// Errors name the field.
    pub fn validate(&self) -> Result<()> {
        let (least, most) = (*self.bodies.start(), *self.bodies.end());
        if least == 0 || most < least || most > MAX_SIMULATED {
            let reason = format!("is {least}..={most}; it must be a range within 1..={MAX_SIMULATED}");
            return Err(Error::argument("generator.bodies", reason));
        }
        check_range("generator.gap[0]", self.gap[0], 0.0..=0.02)?;
        check_range("generator.gap[1]", self.gap[1], self.gap[0]..=0.02)?;
        check_range("generator.midpoint_chance", self.midpoint_chance, 0.0..=1.0)
    }
}

/// Makes scenes: number `i` of a seed is the same whatever was made before, and on every thread.
#[derive(Debug, Clone)]
pub struct Generator {
    params: GeneratorParams,
    seed: u64,
}

/// One or more blocks that are placed as one.
struct Item {
    blocks: Vec<(&'static str, Pose2)>,
    /// Convex, counter-clockwise, grown by its part of the gap.
    outline: Vec<Vec2>,
    /// Corners of the outline's bounding box.
    bounds: [Vec2; 2],
}

impl Item {
    fn new(blocks: Vec<(&'static str, Pose2)>, outline: Vec<Vec2>) -> Item {
        let bounds =
            [outline.iter().copied().reduce(|a, b| a.inf(&b)), outline.iter().copied().reduce(|a, b| a.sup(&b))];
        Item { blocks, bounds: bounds.map(Option::unwrap_or_default), outline }
    }

    /// The bounding boxes are nearer than rounding.
    fn is_near(&self, other: &Item) -> bool {
        let ([low, high], [other_low, other_high]) = (self.bounds, other.bounds);
        (0..2).all(|axis| low[axis] < other_high[axis] + 1e-6 && other_low[axis] < high[axis] + 1e-6)
    }
}

impl Generator {
    pub fn new(params: GeneratorParams, seed: u64) -> Result<Generator> {
        params.validate()?;
        Ok(Generator { params, seed })
    }

    pub fn params(&self) -> &GeneratorParams {
        &self.params
    }

    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Problem `index` of the seed; named `generated-SEED-INDEX`.
    /// Fails if the parameters ask for more bodies than find room.
    pub fn problem(&self, index: u64) -> Result<Problem> {
        let key = Key::new(self.seed).child(index);
        for attempt in 0..ATTEMPTS {
            let mut random = key.child(attempt).stream();
            if let Some(blocks) = self.grow(&mut random)? {
                return self.problem_of(blocks, index);
            }
        }
        Err(Error::argument(
            "generator.bodies",
            format!(
                "found no room for scene {index} of {:?} bodies; ask for fewer bodies or a larger workspace",
                self.params.bodies
            ),
        ))
    }

    /// The first `count` problems, by index, that `keep` accepts. To keep the scenes that need at least one push, hand
    /// in the test that the target cannot be grasped as it stands. Fails after a thousand draws for each one wanted.
    pub fn generate_filtered(&self, count: usize, keep: impl Fn(&Problem) -> bool) -> Result<Vec<Problem>> {
        let mut kept = Vec::new();
        let most = DRAWS_PER_KEPT.saturating_mul(count as u64);
        for index in 0..most {
            if kept.len() == count {
                break;
            }
            let problem = self.problem(index)?;
            if keep(&problem) {
                kept.push(problem);
            }
        }
        if kept.len() < count {
            let reason = format!("the filter kept {} of {most} scenes; {count} were asked for", kept.len());
            return Err(Error::State(reason));
        }
        Ok(kept)
    }

    /// Blocks at poses about the origin, or `None` if the scene grew into a corner.
    fn grow(&self, random: &mut Stream) -> Result<Option<Vec<(&'static str, Pose2)>>> {
        let (least, most) = (*self.params.bodies.start(), *self.params.bodies.end());
        let wanted = least + random.index(most - least + 1);
        let mut placed = vec![self.item(wanted, random)?];
        let mut count = placed[0].blocks.len();
        while count < wanted {
            let item = self.item(wanted - count, random)?;
            let Some(item) = (0..PLACES).find_map(|_| self.attach(&item, &placed, random)) else { return Ok(None) };
            count += item.blocks.len();
            placed.push(item);
        }
        let turn = Pose2::new(0.0, 0.0, random.uniform(-PI, PI));
        Ok(Some(placed.iter().flat_map(|i| &i.blocks).map(|(name, pose)| (*name, turn.compose(pose))).collect()))
    }

    /// Draws an item of at most `room` blocks.
    fn item(&self, room: usize, random: &mut Stream) -> Result<Item> {
        let fits = |name: &str| name != SANDWICH || room >= 3;
        let total: usize = WEIGHTS.iter().filter(|(name, _)| fits(name)).map(|(_, weight)| weight).sum();
        let mut ticket = random.index(total);
        let mut kind = WEIGHTS[0].0;
        for (name, weight) in WEIGHTS.into_iter().filter(|(name, _)| fits(name)) {
            kind = name;
            if ticket < weight {
                break;
            }
            ticket -= weight;
        }
        let gap = random.uniform(self.params.gap[0], self.params.gap[1]);
        let (blocks, outline) = if kind == SANDWICH {
            // The notches face each other round the cylinder.
            let [width, depth] = block_size("concave")?;
            let apart = (depth + gap) / 2.0;
            let blocks = vec![
                ("concave", Pose2::new(0.0, -apart, 0.0)),
                ("cylinder", Pose2::IDENTITY),
                ("concave", Pose2::new(0.0, apart, PI)),
            ];
            (blocks, rectangle(width, 2.0 * depth + gap))
        } else {
            let [x, y] = block_size(kind)?;
            let outline = match kind {
                "triangle" => vec![vec2(x / 2.0, y / 2.0), vec2(-x / 2.0, 0.0), vec2(x / 2.0, -y / 2.0)],
                _ => rectangle(x, y),
            };
            (vec![(kind, Pose2::IDENTITY)], outline)
        };
        Ok(Item::new(blocks, grown(&outline, gap / 2.0)))
    }

    /// The item at a random place against one of those that are there, if it is free and near enough.
    fn attach(&self, item: &Item, placed: &[Item], random: &mut Stream) -> Option<Item> {
        let host = &placed[random.index(placed.len())].outline;
        let to = self.anchor(host, random);
        let turn = if random.chance(0.5) { PI } else { 0.0 };
        let from = self.anchor(&item.outline, random);
        let turned = Pose2::new(0.0, 0.0, turn);
        let shift = Pose2::at(to - turned.transform_point(from), turn);
        let outline: Vec<Vec2> = item.outline.iter().map(|&p| shift.transform_point(p)).collect();

        let workspace = self.params.profile.workspace();
        let half = (workspace.max[0] - workspace.min[0]) / 2.0;
        let reach = half - self.params.profile.push_length();
        let blocks: Vec<_> = item.blocks.iter().map(|(name, pose)| (*name, shift.compose(pose))).collect();
        let inside = outline.iter().all(|p| p.norm() < half)
            && blocks.iter().all(|(_, pose)| pose.x.abs() <= reach && pose.y.abs() <= reach);
        if !inside {
            return None;
        }
        let item = Item::new(blocks, outline);
        let near: Vec<&Item> = placed.iter().filter(|other| item.is_near(other)).collect();
        // A hundredth of a square millimetre is rounding.
        let free = near.iter().all(|other| intersection_area(&item.outline, &other.outline) < 1e-8);
        let touches = || near.iter().any(|other| contact(&item.outline, &other.outline) >= LEAST_CONTACT);
        (free && touches()).then_some(item)
    }

    /// A corner of the outline or the middle of an edge.
    fn anchor(&self, outline: &[Vec2], random: &mut Stream) -> Vec2 {
        let i = random.index(outline.len());
        let corner = outline[i];
        if random.chance(self.params.midpoint_chance) {
            (corner + outline[(i + 1) % outline.len()]) / 2.0
        } else {
            corner
        }
    }

    fn problem_of(&self, mut blocks: Vec<(&'static str, Pose2)>, index: u64) -> Result<Problem> {
        let profile = self.params.profile;
        let workspace = profile.workspace();
        let centre = vec2(workspace.min[0] + workspace.max[0], workspace.min[1] + workspace.max[1]) / 2.0;
        for (_, pose) in &mut blocks {
            *pose = Pose2::at(pose.position() + centre, pose.theta);
        }
        let def = |name: &str| -> Result<BodyDef> { block_of(name, profile.block_set(), self.params.convention) };
        if self.params.target == TargetRule::MostEnclosed {
            let bodies: Result<Vec<(Body, Pose2)>> =
                blocks.iter().map(|(name, pose)| Ok((Body::new(def(name)?)?, *pose))).collect();
            let target = most_enclosed(&bodies?);
            blocks[..=target].rotate_right(1);
        }
        let mut builder = SceneBuilder::new();
        builder.workspace(workspace).friction(profile.friction());
        for (i, (name, _)) in blocks.iter().enumerate() {
            builder.add_body(def(name)?.named(format!("{} {i}", library::canonical(name)?)))?;
        }
        let state = State::new(blocks.iter().map(|(_, pose)| *pose));
        Problem::new(format!("generated-{}-{index}", self.seed), Arc::new(builder.build()?), state, 0)
    }
}

/// The body with the greatest part of its side blocked; the first of equals.
fn most_enclosed(bodies: &[(Body, Pose2)]) -> usize {
    let mut best = (0, -1.0);
    for i in 0..bodies.len() {
        let part = enclosed_part(bodies, i);
        if part > best.1 {
            best = (i, part);
        }
    }
    best.0
}

/// The part of a body's side before which another body stands in the way of a finger, from 0 to 1.
fn enclosed_part(bodies: &[(Body, Pose2)], which: usize) -> f64 {
    let (body, pose) = &bodies[which];
    let frame = pose.frame();
    let reach = |other: &Body| body.footprint.radius + other.footprint.radius + FINGER_REACH;
    let near: Vec<&(Body, Pose2)> = bodies
        .iter()
        .enumerate()
        .filter(|(i, (other, at))| *i != which && (at.position() - pose.position()).norm() < reach(other))
        .map(|(_, other)| other)
        .collect();
    let (mut blocked, mut probes) = (0u32, 0u32);
    for outline in &body.footprint.outlines {
        for k in 0..outline.len() {
            let (a, b) = (frame.point(outline[k]), frame.point(outline[(k + 1) % outline.len()]));
            let side = b - a;
            let outward = vec2(side.y, -side.x).normalize() * FINGER_REACH;
            let steps = (side.norm() / PROBE_SPACING).ceil().max(1.0) as u32;
            for step in 0..steps {
                let probe = a + side * ((f64::from(step) + 0.5) / f64::from(steps)) + outward;
                blocked += u32::from(near.iter().any(|(other, at)| {
                    let close = (at.position() - probe).norm_squared() <= other.footprint.radius.powi(2);
                    close && other.footprint.contains(at, probe)
                }));
                probes += 1;
            }
        }
    }
    f64::from(blocked) / f64::from(probes.max(1))
}

fn rectangle(x: f64, y: f64) -> Vec<Vec2> {
    let (x, y) = (x / 2.0, y / 2.0);
    vec![vec2(-x, -y), vec2(x, -y), vec2(x, y), vec2(-x, y)]
}

/// A convex polygon with every side moved outward.
fn grown(outline: &[Vec2], by: f64) -> Vec<Vec2> {
    let n = outline.len();
    let outward = |i: usize| {
        let side = (outline[(i + 1) % n] - outline[i % n]).normalize();
        vec2(side.y, -side.x)
    };
    (0..n)
        .map(|i| {
            let (before, after) = (outward(i + n - 1), outward(i));
            outline[i] + (before + after) * (by / (1.0 + before.dot(&after)))
        })
        .collect()
}

/// The longest stretch that an edge of one convex polygon shares with one of the other, metres.
fn contact(a: &[Vec2], b: &[Vec2]) -> f64 {
    let mut longest: f64 = 0.0;
    for i in 0..a.len() {
        let (p, q) = (a[i], a[(i + 1) % a.len()]);
        let along = (q - p).normalize();
        for k in 0..b.len() {
            let (r, s) = (b[k] - p, b[(k + 1) % b.len()] - p);
            let off = |v: Vec2| (along.x * v.y - along.y * v.x).abs();
            if off(r) < 1e-6 && off(s) < 1e-6 {
                // Outlines on either side of the line run in opposite directions.
                let (from, to) = (s.dot(&along), r.dot(&along));
                longest = longest.max(to.min((q - p).norm()) - from.max(0.0));
            }
        }
    }
    longest
}

#[cfg(test)]
#[path = "generate_tests.rs"]
mod tests;
