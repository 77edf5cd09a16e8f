//! The world of one push: built, stepped, read out, thrown away.

use super::engine::{BodyDetail, Bullet};
use super::hull;
use super::native::{BodyDef, BoxDef, Motion, World, WorldSettings, ground, solver};
use super::settings::{BulletSettings, Ground, Solver};
use crate::action::Push;
use crate::error::Result;
use crate::geom::{Pose2, Vec2, normalize_angle, pieces_gap_below, vec2};
use crate::physics::transition::Stance;
use crate::run::Stop;
use crate::scene::{Mask, Scene, State, Stroke, TipPath};

/// Neighbours may be nearer than two margins by this before their cores shrink, metres: rounding of poses.
const NEAR: f64 = 5e-5;
/// So heavy that bodies do not hold it back within a step, kilograms.
const TIP_MASS: f64 = 1000.0;
/// The number of the tip among the boxes.
const TIP: u32 = 0;

pub(super) struct PushWorld<'a> {
    engine: &'a Bullet,
    world: World,
    /// Body index of every present body, in the world's order.
    bodies: Vec<usize>,
    start: Vec2,
    direction: Vec2,
    /// How far the tip has come, metres.
    travel: f64,
    /// What is left of the push, metres.
    left: f64,
    /// Of the robot, where it has a path for the tip.
    stroke: Option<(&'a TipPath, Stroke)>,
    touching: Vec<u8>,
    force: Vec<f64>,
}

impl<'a> PushWorld<'a> {
    /// The world at the moment the tip has travelled `travel` metres.
    pub fn new(engine: &'a Bullet, state: &State, stances: &[Stance], push: &Push, travel: f64) -> Result<Self> {
        let settings = &engine.settings;
        let (mut world, bodies) = with_bodies(engine, state, stances)?;
        let tip = &engine.scene.gripper().push;
        world.add_box(&BoxDef {
            half: [tip.thickness / 2.0, tip.width / 2.0, (settings.tip_top - settings.tip_bottom) / 2.0],
            mass: TIP_MASS,
            friction: engine.scene.friction().tip,
            kinematic: i32::from(settings.kinematic_tip),
        })?;
        world.place_bodies()?;
        let count = bodies.len();
        Ok(Self {
            engine,
            world,
            bodies,
            start: push.start() + push.direction() * travel,
            direction: push.direction(),
            travel,
            left: push.length() - travel,
            stroke: engine.scene.gripper().path.as_ref().map(|path| (path, path.stroke(push.start(), push.end()))),
            touching: vec![0; count],
            force: vec![0.0; count],
        })
    }

    /// Pushes, takes the tip away and lets the bodies come to rest. False if the stop was requested on the way.
    pub fn run(&mut self, stop: &Stop) -> Result<bool> {
        let settings = &self.engine.settings;
        let stride = settings.speed * settings.time_step;
        let steps = (self.left / stride).ceil().max(1.0) as usize;
        let angle = self.direction.y.atan2(self.direction.x);
        let mut motion = Motion {
            rotation: about_vertical(angle),
            linear: [self.direction.x * settings.speed, self.direction.y * settings.speed, 0.0],
            ..Motion::default()
        };
        for k in 1..=steps {
            if stop.requested() {
                return Ok(false);
            }
            let gone = (k as f64 * stride).min(self.left);
            let at = self.start + self.direction * gone;
            let mut z = (settings.tip_bottom + settings.tip_top) / 2.0;
            if let Some((path, stroke)) = &self.stroke {
                z += path.height(stroke, self.travel + gone) - settings.tip_bottom;
                motion.linear[2] = path.slope(stroke, self.travel + gone) * settings.speed;
            }
            motion.position = [at.x, at.y, z];
            self.world.move_box(TIP, &motion)?;
            self.world.step()?;
            self.world.contacts(TIP, 0.0, &mut self.touching, &mut self.force)?;
        }
        self.world.remove_box(TIP)?;
        settle(&mut self.world, settings, stop)
    }

    pub fn touched(&self) -> Mask {
        let mut mask = Mask::EMPTY;
        for (i, _) in self.bodies.iter().zip(&self.touching).filter(|(_, touching)| **touching != 0) {
            mask.insert(*i);
        }
        mask
    }

    /// Writes the bodies' poses into the state they came from, and how they stand. Gives the bodies that toppled. A body
    /// that came to rest where it was keeps its bits.
    pub fn read(&self, state: &mut State, details: &mut [BodyDetail]) -> Result<Mask> {
        read(&self.engine.scene, &self.engine.settings, &self.world, &self.bodies, None, state, details)
    }
}

/// As [`PushWorld::read`], leaving out one body.
pub(super) fn read(
    scene: &Scene,
    settings: &BulletSettings,
    world: &World,
    bodies: &[usize],
    except: Option<usize>,
    state: &mut State,
    details: &mut [BodyDetail],
) -> Result<Mask> {
    let mut toppled = Mask::EMPTY;
    for (k, &i) in bodies.iter().enumerate().filter(|(_, i)| except != Some(**i)) {
        let motion = world.body(k)?;
        let detail = detail(scene, settings, i, &motion);
        details[i] = detail;
        if detail.tilt > settings.topple_tilt || detail.rise.abs() > settings.climb {
            toppled.insert(i);
        }
        let pose = planar(&motion, scene.body(i).centre_of_mass);
        let before = state.pose(i);
        let moved = (pose.position() - before.position()).norm() > settings.rest_distance
            || normalize_angle(pose.theta - before.theta).abs() > settings.rest_angle;
        if moved {
            state.set_pose(i, pose);
        }
    }
    Ok(toppled)
}

/// A world with the ground and the present bodies, in the order of [`State::iter`], and their indices.
pub(super) fn with_bodies(engine: &Bullet, state: &State, stances: &[Stance]) -> Result<(World, Vec<usize>)> {
    let (scene, settings) = (&engine.scene, &engine.settings);
    let mut world = World::new(&world_settings(scene, settings))?;
    let borders = borders_in(scene, state, settings.margin);
    let mut bodies = Vec::with_capacity(borders.len());
    for ((i, pose), border) in state.iter().zip(borders) {
        let body = scene.body(i);
        let pieces = hull::prism(&body.footprint, body.centre_of_mass, body.height, settings.margin - border);
        let at = pose.transform_point(body.centre_of_mass);
        let stance = stances.get(i).copied().unwrap_or_default();
        world.add_body(&BodyDef {
            mass: body.mass,
            inertia: engine.inertias[i],
            friction: body.friction,
            rolling_friction: settings.rolling_friction,
            spinning_friction: settings.spinning_friction,
            position: [at.x, at.y, resting_height(scene, settings, i) + stance.rise],
            rotation: leaning(stance.lean, pose.theta),
            pieces: &pieces,
        })?;
        bodies.push(i);
    }
    Ok((world, bodies))
}

/// Steps until every body has come to rest. False if the stop was requested on the way.
pub(super) fn settle(world: &mut World, settings: &BulletSettings, stop: &Stop) -> Result<bool> {
    let most = (settings.settle_time / settings.time_step).ceil() as usize;
    for _ in 0..most {
        if stop.requested() {
            return Ok(false);
        }
        world.step()?;
        if at_rest(world, settings)? {
            break;
        }
    }
    Ok(true)
}

fn at_rest(world: &World, settings: &BulletSettings) -> Result<bool> {
    for k in 0..world.bodies() {
        let motion = world.body(k)?;
        let norm = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm(motion.linear) >= settings.settle_speed || norm(motion.angular) * 0.03 >= settings.settle_speed {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The height of a resting body's centre of mass, which lies at half its height.
pub(super) fn resting_height(scene: &Scene, settings: &BulletSettings, body: usize) -> f64 {
    settings.ground_height + settings.margin + scene.body(body).height / 2.0
}

/// How a body stands.
pub(super) fn detail(scene: &Scene, settings: &BulletSettings, body: usize, motion: &Motion) -> BodyDetail {
    let [x, y, ..] = motion.rotation;
    BodyDetail {
        tilt: (1.0 - 2.0 * (x * x + y * y)).clamp(-1.0, 1.0).acos(),
        rise: motion.position[2] - resting_height(scene, settings, body),
    }
}

/// The pose in the plane of a body whose base frame lies at its centre of mass.
pub(super) fn planar(motion: &Motion, centre_of_mass: Vec2) -> Pose2 {
    let [x, y, z, w] = motion.rotation;
    let theta = (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z));
    let turned = Pose2::new(0.0, 0.0, theta).transform_point(centre_of_mass);
    Pose2::at(vec2(motion.position[0], motion.position[1]) - turned, theta)
}

/// The quaternion of a turn about the vertical.
pub(super) fn about_vertical(angle: f64) -> [f64; 4] {
    [0.0, 0.0, (angle / 2.0).sin(), (angle / 2.0).cos()]
}

/// The quaternion of a turn about the vertical, followed by a lean (see [`Stance`]).
fn leaning(lean: [f64; 2], angle: f64) -> [f64; 4] {
    let [_, _, sin, cos] = about_vertical(angle);
    let lean_angle = lean[0].hypot(lean[1]);
    if lean_angle == 0.0 {
        return [0.0, 0.0, sin, cos];
    }
    let (s, w) = ((lean_angle / 2.0).sin() / lean_angle, (lean_angle / 2.0).cos());
    let (x, y) = (lean[0] * s, lean[1] * s);
    [x * cos + y * sin, y * cos - x * sin, w * sin, w * cos]
}

fn world_settings(scene: &Scene, settings: &BulletSettings) -> WorldSettings {
    WorldSettings {
        time_step: settings.time_step,
        gravity: settings.gravity,
        erp: settings.erp,
        friction_erp: settings.friction_erp,
        linear_slop: settings.linear_slop,
        residual: settings.residual,
        warm_start: settings.warm_start,
        contact_processing: settings.contact_processing,
        margin: settings.margin,
        ground_height: settings.ground_height,
        ground_friction: scene.friction().ground,
        ground_restitution: settings.ground_restitution,
        iterations: settings.iterations as i32,
        solver: match settings.solver {
            Solver::Bullet => solver::JOSTLE_BT_SOLVER_BULLET,
            Solver::Compact => solver::JOSTLE_BT_SOLVER_COMPACT,
            Solver::CompactRoot => solver::JOSTLE_BT_SOLVER_COMPACT_ROOT,
        } as i32,
        ground: match settings.ground {
            Ground::Box => ground::JOSTLE_BT_GROUND_BOX,
            Ground::Plane => ground::JOSTLE_BT_GROUND_PLANE,
        } as i32,
    }
}

/// The present bodies' collision borders in this state: the margin, or half the gap to the nearest neighbour where that
/// is less.
fn borders_in(scene: &Scene, state: &State, full: f64) -> Vec<f64> {
    let bodies: Vec<(usize, Pose2)> = state.iter().collect();
    let mut borders = vec![full; bodies.len()];
    for (k, (i, pose)) in bodies.iter().enumerate() {
        for (l, (j, other)) in bodies.iter().enumerate().skip(k + 1) {
            let (a, b) = (&scene.body(*i).footprint, &scene.body(*j).footprint);
            let gap = pieces_gap_below(a, pose, b, other, 2.0 * full);
            if gap < 2.0 * full - NEAR {
                let half = (gap / 2.0).max(0.0);
                borders[k] = borders[k].min(half);
                borders[l] = borders[l].min(half);
            }
        }
    }
    borders
}
