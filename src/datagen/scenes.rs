//! The scenes of training data: packed as the planners meet them, loose, and between; of the library's blocks and of
//! the family's shapes; with the library's materials and with drawn ones.

use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::RangeInclusive;
use std::sync::Arc;

use serde::Serialize;

use super::shapes::{ShapeFamily, Split};
use crate::error::{Error, Result};
use crate::geom::{Footprint, Pose2, Vec2, pieces_gap_below, vec2};
use crate::run::{Key, Stream};
use crate::scene::generate::{Generator, GeneratorParams};
use crate::scene::{BodyDef, Friction, Gripper, PushTip, Scene, SceneBuilder, State};

/// Greatest number of bodies of a training scene: the width of the padded tensors.
pub const WIDTH: usize = 12;

/// Middle of the workspace of the originals, metres.
const MIDDLE: [f64; 2] = [0.5, 0.0];
/// From how far off a body is slid against the pack, metres.
const FAR: f64 = 0.45;
/// Directions tried for a body before the scene is begun anew.
const TRIES: usize = 40;
/// Scenes begun before the parameters are held to be impossible.
const ATTEMPTS: u64 = 50;

/// Which scenes to make.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneParams {
    /// Least and greatest number of bodies.
    pub bodies: RangeInclusive<usize>,
    /// How often each kind of scene is made, in relation.
    pub mix: SceneMix,
    /// Share of scenes with the library's mass, friction and tip; the others draw them.
    pub default_materials: f64,
    /// Share of scenes whose bodies are all 45 mm tall; the others draw 30 to 60 mm.
    pub default_heights: f64,
    /// Share of scenes whose tip is 30 mm by 22 mm; the others have 30 mm by 6 mm.
    pub thick_tip: f64,
}

/// Relative numbers of scenes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SceneMix {
    /// The generator's packed blocks. Scenes of the splits for validation and tests are `packed` in their place where
    /// splits go by shapes.
    pub generated: f64,
    /// Shapes of the family, slid against each other.
    pub packed: f64,
    /// Dropped at random places.
    pub loose: f64,
    /// A pack with others dropped about it.
    pub mixed: f64,
    /// Splits follow from the scene's number alone, also for scenes of blocks; else the blocks are for training only.
    pub split_blocks: bool,
}

impl Default for SceneParams {
    fn default() -> Self {
        SceneParams {
            bodies: 1..=WIDTH,
            mix: SceneMix { generated: 0.3, packed: 0.35, loose: 0.2, mixed: 0.15, split_blocks: false },
            default_materials: 0.5,
            default_heights: 0.8,
            thick_tip: 0.8,
        }
    }
}

impl SceneParams {
    /// The generator's scenes alone, with the library's materials, split by scene.
    pub fn generated(bodies: RangeInclusive<usize>) -> Self {
        SceneParams {
            bodies,
            mix: SceneMix { generated: 1.0, packed: 0.0, loose: 0.0, mixed: 0.0, split_blocks: true },
            default_materials: 1.0,
            default_heights: 1.0,
            thick_tip: 1.0,
        }
    }

    /// Errors name the field.
    pub fn validate(&self) -> Result<()> {
        let (least, most) = (*self.bodies.start(), *self.bodies.end());
        if least == 0 || least > most || most > WIDTH {
            let reason = format!("is {least}..{most}; it must be a range within 1..{WIDTH}");
            return Err(Error::argument("bodies", reason));
        }
        let mix = [self.mix.generated, self.mix.packed, self.mix.loose, self.mix.mixed];
        if mix.iter().any(|w| !w.is_finite() || *w < 0.0) || mix.iter().sum::<f64>() <= 0.0 {
            return Err(Error::argument("mix", "needs weights that are not negative, and one above zero"));
        }
        Ok(())
    }
}

/// A scene with the family's indices of its bodies' shapes.
#[derive(Debug, Clone)]
pub struct TrainingScene {
    pub scene: Arc<Scene>,
    pub state: State,
    pub shapes: Vec<u16>,
    pub split: Split,
    /// `generated`, `packed`, `loose` or `mixed`.
    pub kind: &'static str,
}

/// Makes scenes; number `i` is the same whatever was made before.
#[derive(Debug, Clone)]
pub struct SceneMaker {
    params: SceneParams,
    family: Arc<ShapeFamily>,
}

impl SceneMaker {
    pub fn new(params: SceneParams, family: Arc<ShapeFamily>) -> Result<SceneMaker> {
        params.validate()?;
        Ok(SceneMaker { params, family })
    }

    pub fn params(&self) -> &SceneParams {
        &self.params
    }

    pub fn family(&self) -> &ShapeFamily {
        &self.family
    }

    /// The scene of a key.
    pub fn scene(&self, key: Key) -> Result<TrainingScene> {
        let mut random = key.stream();
        let mut split = Split::of_hash(random.bits());
        let mix = &self.params.mix;
        let weights =
            [("generated", mix.generated), ("packed", mix.packed), ("loose", mix.loose), ("mixed", mix.mixed)];
        let mut ticket = random.uniform(0.0, weights.iter().map(|(_, w)| w).sum());
        let mut kind = weights[0].0;
        for (name, weight) in weights {
            if weight > 0.0 {
                kind = name;
                if ticket < weight {
                    break;
                }
            }
            ticket -= weight;
        }
        if kind == "generated" && split != Split::Train && !mix.split_blocks {
            kind = "packed";
        }
        if kind != "generated" && self.family.of(split).is_empty() {
            split = Split::Train;
        }
        let (shapes, poses) = match kind {
            "generated" => self.generated(&mut random)?,
            _ => self.placed(kind, split, key)?,
        };
        let scene = self.materials(&shapes, &mut random)?;
        let state = State::new(poses);
        Ok(TrainingScene { scene: Arc::new(scene), state, shapes, split, kind })
    }

    fn count(&self, random: &mut Stream) -> usize {
        let (least, most) = (*self.params.bodies.start(), *self.params.bodies.end());
        least + random.index(most - least + 1)
    }

    fn generated(&self, random: &mut Stream) -> Result<(Vec<u16>, Vec<Pose2>)> {
        let bodies = self.params.bodies.clone();
        let problem =
            Generator::new(GeneratorParams { bodies, ..GeneratorParams::default() }, random.bits())?.problem(0)?;
        let block = |body: &crate::scene::Body| {
            // The generator names a body by its block and its number.
            self.family.block(body.name.rsplit_once(' ').map_or(body.name.as_str(), |(block, _)| block))
        };
        let shapes: Result<Vec<u16>> = problem.scene.bodies().iter().map(block).collect();
        let poses = (0..problem.scene.len()).map(|i| problem.state.pose(i)).collect();
        Ok((shapes?, poses))
    }

    fn placed(&self, kind: &str, split: Split, key: Key) -> Result<(Vec<u16>, Vec<Pose2>)> {
        let of_split = self.family.of(split);
        for attempt in 0..ATTEMPTS {
            let mut random = key.child(attempt).stream();
            let count = self.count(&mut random);
            // Half of the scenes are made of few shapes, as sets of toys and parts are.
            let few = 1 + random.index(4);
            let pool: Vec<u16> = (0..few).map(|_| of_split[random.index(of_split.len())]).collect();
            let of_few = random.chance(0.5);
            let blocks = split == Split::Train && random.chance(0.25);
            let shapes: Vec<u16> = (0..count)
                .map(|_| match (blocks, of_few) {
                    (true, _) => random.index(crate::scene::library::BLOCKS.len()) as u16,
                    (false, true) => pool[random.index(few)],
                    (false, false) => of_split[random.index(of_split.len())],
                })
                .collect();
            let packed = match kind {
                "packed" => count,
                "loose" => 0,
                _ => count.div_ceil(2),
            };
            if let Some(poses) = self.place(&shapes, packed, &mut random) {
                return Ok((shapes, poses));
            }
        }
        Err(Error::State(format!("found no room for the bodies of a {kind} scene")))
    }

    /// The first `packed` bodies slid against each other, the others dropped about them.
    fn place(&self, shapes: &[u16], packed: usize, random: &mut Stream) -> Option<Vec<Pose2>> {
        let footprint = |i: usize| &self.family.shape(shapes[i]).footprint;
        let base = random.uniform(-PI, PI);
        let flush = random.uniform(0.3, 1.0);
        let mut poses: Vec<Pose2> = Vec::with_capacity(shapes.len());
        let spread = random.uniform(0.08, 0.2) + 0.008 * shapes.len() as f64;
        let apart = random.uniform(0.001, 0.012);
        for i in 0..shapes.len() {
            let theta =
                if random.chance(flush) { base + FRAC_PI_2 * random.index(4) as f64 } else { random.uniform(-PI, PI) };
            let found = (0..TRIES).find_map(|_| {
                if i >= packed {
                    let at = vec2(random.uniform(-spread, spread), random.uniform(-spread, spread));
                    let pose = Pose2::at(at, theta);
                    let free = least_gap(footprint, &poses, footprint(i), &pose, apart) >= apart;
                    return free.then_some(pose);
                }
                if poses.is_empty() {
                    return Some(Pose2::new(0.0, 0.0, theta));
                }
                let host = poses[random.index(poses.len())].position();
                let aim = host + vec2(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02));
                // Mostly onto a side of the pack's own grid, so that faces meet.
                let angle = if random.chance(flush) {
                    base + FRAC_PI_2 * random.index(4) as f64
                } else {
                    random.uniform(-PI, PI)
                };
                let gap = random.uniform(0.0005, 0.0025);
                slide(footprint, &poses, footprint(i), theta, aim, vec2(angle.cos(), angle.sin()), gap)
            });
            poses.push(found?);
        }
        // Turned as a whole, with the mean position near the workspace's middle.
        let mean = poses.iter().map(Pose2::position).sum::<Vec2>() / poses.len() as f64;
        let shift = vec2(MIDDLE[0], MIDDLE[1]) + vec2(random.uniform(-0.03, 0.03), random.uniform(-0.03, 0.03)) - mean;
        Some(poses.into_iter().map(|p| Pose2::at(p.position() + shift, p.theta)).collect())
    }

    /// The bodies with their materials, heights and the tip.
    fn materials(&self, shapes: &[u16], random: &mut Stream) -> Result<Scene> {
        let mut builder = SceneBuilder::new();
        let usual = random.chance(self.params.default_materials);
        let same_height = random.chance(self.params.default_heights);
        let thickness = if random.chance(self.params.thick_tip) { 0.022 } else { 0.006 };
        // Coefficients of contacts, of which the surfaces' follow: a contact has the product of its two surfaces.
        let [ground, body, tip] = [(0.3, 0.8), (0.15, 0.5), (0.3, 0.6)].map(|(low, high)| random.uniform(low, high));
        let [least, most] = [random.uniform(0.02, 0.3), random.uniform(0.02, 0.3)];
        let surface =
            if usual { BodyDef::new(crate::geom::Shape::rectangle(0.01, 0.01)).friction } else { body.sqrt() };
        if !usual {
            builder.friction(Friction { ground: ground / surface, tip: tip / surface });
        }
        for &shape in shapes {
            let mut def = BodyDef::new(self.family.shape(shape).footprint.shape.clone());
            let (mass, height) = (random.uniform(least.min(most), least.max(most)), random.uniform(0.030, 0.060));
            def.friction = surface;
            if !usual {
                def.mass = mass;
            }
            if !same_height {
                def.height = height;
            }
            builder.add_body(def)?;
        }
        let push = PushTip { thickness, ..PushTip::default() };
        builder.gripper(Gripper { push, ..Gripper::robotiq_2f85() });
        builder.build()
    }
}

/// The gap to the nearest body that is there, where it is below `limit`.
fn least_gap<'a>(
    of: impl Fn(usize) -> &'a Footprint,
    poses: &[Pose2],
    footprint: &Footprint,
    pose: &Pose2,
    limit: f64,
) -> f64 {
    poses
        .iter()
        .enumerate()
        .fold(limit, |least, (k, at)| least.min(pieces_gap_below(footprint, pose, of(k), at, least)))
}

/// Slides a body from afar along `direction` through `aim` until it is `gap` from the pack; `None` if it passes by.
fn slide<'a>(
    of: impl Fn(usize) -> &'a Footprint,
    poses: &[Pose2],
    footprint: &Footprint,
    theta: f64,
    aim: Vec2,
    direction: Vec2,
    gap: f64,
) -> Option<Pose2> {
    let mut travelled = 0.0;
    for _ in 0..100 {
        let pose = Pose2::at(aim - direction * (FAR - travelled), theta);
        let free = least_gap(&of, poses, footprint, &pose, FAR) - gap;
        if free < 2e-4 {
            return (travelled > 0.0).then_some(pose);
        }
        // The gap is never given too large, so the body can move by it.
        travelled += free;
        if travelled > FAR + 0.05 {
            return None;
        }
    }
    None
}
