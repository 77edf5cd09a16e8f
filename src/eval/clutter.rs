//! Seeded tables to be cleared: random clutter, and tight packs.
//!
//! Random clutter has blocks of the library, rectangles, discs and convex polygons with sides of 20 to 75 mm. They come one
//! after the other to a random place of the table, about as far from its middle as the scene's spread says; a part of
//! them slides towards the middle until something is met. So there are loose bodies, heaps and all between. Packs are
//! those of the generator of retrieval scenes, of which only those are kept in which few bodies can be grasped at first,
//! and which grasps alone do not clear.
//!
//! Every body can be grasped when it is alone on the table: its best grasp scores at least [`ALONE`].

use std::f64::consts::{PI, TAU};
use std::ops::RangeInclusive;
use std::sync::Arc;

use crate::error::{Error, Result, check_range};
use crate::geom::{Footprint, Pose2, Shape, Vec2, convex_hull, pieces_gap_below, vec2};
use crate::grasp::{GraspParams, GraspScratch, GraspTest};
use crate::plan::GraspDecision;
use crate::run::{Key, Stream};
use crate::scene::generate::{Generator, GeneratorParams};
use crate::scene::library::{self, BLOCKS};
use crate::scene::{BodyDef, Clearing, Gripper, Mask, SceneBuilder, State, Workspace};

/// Least score of a body's best grasp when it is alone.
pub const ALONE: f64 = 0.5;
/// Least gap between bodies, metres.
const GAP: f64 = 0.001;
/// Step of a body that slides, metres.
const SLIDE: f64 = 0.0005;
/// No centre is nearer to the workspace's edge, metres.
const INSET: f64 = 0.045;
/// Mass of a square metre of random body, kilograms: that of a block of 45 mm and 0.1 kg.
const DENSITY: f64 = 0.1 / (0.045 * 0.045);
/// Places tried for a body, scenes begun, and draws for each one that is kept.
const PLACES: usize = 500;
const ATTEMPTS: u64 = 200;
const DRAWS_PER_KEPT: u64 = 2000;

/// Which tables to make.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ClutterKind {
    #[default]
    Random,
    Packed,
}

impl ClutterKind {
    pub const NAMES: [&str; 2] = ["random", "packed"];

    pub fn by_name(name: &str) -> Result<ClutterKind> {
        match name {
            "random" => Ok(ClutterKind::Random),
            "packed" => Ok(ClutterKind::Packed),
            _ => Err(Error::not_found("kind", format!("there is no `{name}`; there are random and packed"))),
        }
    }

    pub fn params(self) -> ClutterParams {
        let bodies = match self {
            ClutterKind::Random => 10..=30,
            ClutterKind::Packed => 7..=12,
        };
        ClutterParams { kind: self, bodies, ..ClutterParams::default() }
    }
}

/// What tables to make.
#[derive(Debug, Clone, PartialEq)]
pub struct ClutterParams {
    pub kind: ClutterKind,
    /// Least and greatest number of bodies; every number between is as likely.
    pub bodies: RangeInclusive<usize>,
    /// Least and greatest standard deviation of the places about the middle, metres (random).
    pub spread: [f64; 2],
    /// Probability that a body slides towards the middle until it meets another (random).
    pub slides: f64,
    /// Most bodies that can be grasped at first (packed).
    pub graspable: usize,
    pub gripper: Gripper,
}

impl Default for ClutterParams {
    fn default() -> Self {
        Self {
            kind: ClutterKind::Random,
            bodies: 10..=30,
            spread: [0.05, 0.16],
            slides: 0.5,
            graspable: 1,
            gripper: Gripper::default(),
        }
    }
}

impl ClutterParams {
    /// Errors name the field.
    pub fn validate(&self) -> Result<()> {
        let (least, most) = (*self.bodies.start(), *self.bodies.end());
        if least == 0 || most < least || most > 60 {
            let reason = format!("is {least}..={most}; it must be a range within 1..=60");
            return Err(Error::argument("clutter.bodies", reason));
        }
        check_range("clutter.spread[0]", self.spread[0], 0.0..=1.0)?;
        check_range("clutter.spread[1]", self.spread[1], self.spread[0]..=1.0)?;
        check_range("clutter.slides", self.slides, 0.0..=1.0)?;
        self.gripper.validate()
    }
}

/// Makes tables: number `i` of a seed is the same whatever was made before, and on every thread.
#[derive(Debug, Clone)]
pub struct ClutterGenerator {
    params: ClutterParams,
    seed: u64,
    test: GraspTest,
}

impl ClutterGenerator {
    pub fn new(params: ClutterParams, seed: u64) -> Result<ClutterGenerator> {
        params.validate()?;
        Ok(ClutterGenerator { params, seed, test: GraspTest::new(GraspParams::default())? })
    }

    /// The first `count` problems.
    pub fn problems(&self, count: usize) -> Result<Vec<Clearing>> {
        match self.params.kind {
            ClutterKind::Random => (0..count as u64).map(|index| self.random(index)).collect(),
            ClutterKind::Packed => self.packed(count),
        }
    }

    /// Random clutter number `index`, named `clear-random-SEED-INDEX`.
    fn random(&self, index: u64) -> Result<Clearing> {
        let key = Key::new(self.seed).child(index);
        for attempt in 0..ATTEMPTS {
            let mut draw = key.child(attempt).stream();
            if let Some((bodies, poses)) = self.scatter(&mut draw)? {
                let name = format!("clear-random-{}-{index:02}", self.seed);
                return self.problem(name, bodies, poses, Workspace::default());
            }
        }
        let reason = format!("found no room for {:?}; ask for fewer, or a greater spread", self.params.bodies);
        Err(Error::argument("clutter.bodies", reason))
    }

    fn scatter(&self, draw: &mut Stream) -> Result<Option<(Vec<BodyDef>, Vec<Pose2>)>> {
        let (least, most) = (*self.params.bodies.start(), *self.params.bodies.end());
        let count = least + draw.index(most - least + 1);
        let spread = draw.uniform(self.params.spread[0], self.params.spread[1]);
        let workspace = Workspace::default();
        let centre = vec2(workspace.min[0] + workspace.max[0], workspace.min[1] + workspace.max[1]) / 2.0;
        let mut placed: Vec<(Footprint, Pose2)> = Vec::new();
        let mut defs = Vec::new();
        while placed.len() < count {
            let def = self.body(draw)?;
            let name = format!("{} {}", def.name, placed.len());
            let def = def.named(name);
            let footprint = Footprint::new(def.shape.clone())?;
            let slides = draw.chance(self.params.slides);
            let free = |pose: &Pose2| {
                workspace.inset(pose.position()) >= INSET
                    && placed.iter().all(|(other, at)| {
                        let reach = footprint.radius + other.radius + GAP;
                        (pose.position() - at.position()).norm_squared() > reach * reach
                            || pieces_gap_below(&footprint, pose, other, at, GAP) >= GAP
                    })
            };
            let place = (0..PLACES).find_map(|_| {
                let offset = vec2(draw.normal(), draw.normal()) * spread;
                let pose = Pose2::at(centre + offset, draw.uniform(-PI, PI));
                free(&pose).then_some(pose)
            });
            let Some(mut pose) = place else { return Ok(None) };
            if slides {
                let way = pose.position() - centre;
                let steps = (way.norm() / SLIDE).floor() as usize;
                for step in 1..=steps {
                    let share = 1.0 - step as f64 / steps as f64;
                    let next = Pose2::at(centre + way * share, pose.theta);
                    if !free(&next) {
                        break;
                    }
                    pose = next;
                }
            }
            placed.push((footprint, pose));
            defs.push(def);
        }
        Ok(Some((defs, placed.into_iter().map(|(_, pose)| pose).collect())))
    }

    /// A body that can be grasped when it is alone.
    fn body(&self, draw: &mut Stream) -> Result<BodyDef> {
        for _ in 0..PLACES {
            let def = random_body(draw)?;
            if self.graspable_alone(&def)? {
                return Ok(def);
            }
        }
        Err(Error::argument("clutter.gripper", "takes none of the bodies that are drawn"))
    }

    fn graspable_alone(&self, def: &BodyDef) -> Result<bool> {
        let mut builder = SceneBuilder::new();
        builder.gripper(self.params.gripper.clone());
        builder.add_body(def.clone())?;
        let scene = builder.build()?;
        let state = State::new([Pose2::new(0.5, 0.0, 0.0)]);
        let best = self.test.best(&scene, &state, 0, &mut GraspScratch::default());
        Ok(best.is_some_and(|grasp| grasp.score >= ALONE))
    }

    /// The first packs of a generator of retrieval scenes that are packed enough, named `clear-packed-SEED-NN`.
    fn packed(&self, count: usize) -> Result<Vec<Clearing>> {
        let params = GeneratorParams { bodies: self.params.bodies.clone(), ..GeneratorParams::default() };
        let generator = Generator::new(params, self.seed)?;
        let mut kept = Vec::new();
        for index in 0..DRAWS_PER_KEPT.saturating_mul(count as u64) {
            if kept.len() == count {
                break;
            }
            let drawn = generator.problem(index)?;
            let defs = drawn.scene.bodies().iter().map(|body| body.def()).collect();
            let poses = drawn.state.iter().map(|(_, pose)| pose).collect();
            let name = format!("clear-packed-{}-{:02}", self.seed, kept.len());
            let problem = self.problem(name, defs, poses, *drawn.scene.workspace())?;
            if self.is_packed(&problem)? {
                kept.push(problem);
            }
        }
        if kept.len() < count {
            let reason =
                format!("{} of the packs that were drawn are packed enough; {count} were asked for", kept.len());
            return Err(Error::State(reason));
        }
        Ok(kept)
    }

    /// Few bodies can be grasped, grasps alone do not clear the table, and every body can be grasped when it is alone.
    fn is_packed(&self, problem: &Clearing) -> Result<bool> {
        let mut scratch = GraspScratch::default();
        let enough = GraspDecision::default().execute_score;
        let test = self.test.prepared(&problem.scene);
        let mut state = problem.state.clone();
        let mut open = |state: &State| -> Mask {
            let mut open = Mask::EMPTY;
            for (body, _) in state.iter() {
                let best = test.best(&problem.scene, state, body, &mut scratch);
                if best.is_some_and(|grasp| grasp.score >= enough) {
                    open.insert(body);
                }
            }
            open
        };
        let mut now = open(&state);
        if now.count() > self.params.graspable {
            return Ok(false);
        }
        while !now.is_empty() {
            now.iter().for_each(|body| state.set_present(body, false));
            now = open(&state);
        }
        if state.present().is_empty() {
            return Ok(false);
        }
        for body in problem.scene.bodies() {
            if !self.graspable_alone(&body.def())? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn problem(&self, name: String, defs: Vec<BodyDef>, poses: Vec<Pose2>, workspace: Workspace) -> Result<Clearing> {
        let mut builder = SceneBuilder::new();
        builder.gripper(self.params.gripper.clone()).workspace(workspace);
        for def in defs {
            builder.add_body(def)?;
        }
        Clearing::new(name, Arc::new(builder.build()?), State::new(poses))
    }
}

/// Half of the time a block; else a rectangle, a disc or a convex polygon, 30 to 50 mm tall. Named after its kind.
fn random_body(draw: &mut Stream) -> Result<BodyDef> {
    if draw.chance(0.5) {
        let name = BLOCKS[draw.index(BLOCKS.len())];
        return Ok(library::block(name)?.named(name));
    }
    // Whole tenths of a millimetre, as one would measure.
    let tenths = |metres: f64| (metres * 1e4).round() / 1e4;
    let (name, shape) = match draw.index(3) {
        0 => ("box", Shape::rectangle(tenths(draw.uniform(0.025, 0.065)), tenths(draw.uniform(0.025, 0.075)))),
        1 => ("disc", Shape::Disc { radius: tenths(draw.uniform(0.0125, 0.032)) }),
        _ => {
            let corners = 5 + draw.index(4);
            let [a, b] = [draw.uniform(0.02, 0.035), draw.uniform(0.016, 0.03)];
            let points: Vec<Vec2> = (0..corners)
                .map(|k| {
                    let angle = (k as f64 + draw.uniform(-0.3, 0.3)) / corners as f64 * TAU;
                    vec2(tenths(a * angle.cos()), tenths(b * angle.sin()))
                })
                .collect();
            ("polygon", Shape::ConvexPolygon(convex_hull(&points).iter().map(|p| [p.x, p.y]).collect()))
        }
    };
    let area = Footprint::new(shape.clone())?.area;
    let mut def = BodyDef::new(shape).named(name);
    def.mass = (DENSITY * area * 1e3).round() / 1e3;
    def.height = (draw.uniform(0.03, 0.05) * 1e3).round() / 1e3;
    Ok(def)
}
