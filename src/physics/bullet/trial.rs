//! The world of one grasp: two finger boxes come down, close and lift.

use super::engine::{BodyDetail, Bullet};
use super::grasp::{GraspMotion, GraspTrial};
use super::native::{BoxDef, Motion, World};
use super::world::{about_vertical, detail, settle, with_bodies};
use crate::action::Grasp;
use crate::error::{Error, Result};
use crate::geom::{Vec2, vec2};
use crate::run::Stop;
use crate::scene::State;

/// Pads and bodies no farther apart than this touch when they lift, metres.
const TOUCHING: f64 = 5e-4;

impl Bullet {
    /// Tries out a grasp from a state. What is fixed of the motion is the scene's gripper (pad width, finger thickness)
    /// and the grasp (position, direction, opening).
    ///
    /// Equal inputs give equal bits, as for a push. An error is one of the arguments, or memory.
    pub fn grasp(&self, state: &State, grasp: &Grasp, motion: &GraspMotion, stop: &Stop) -> Result<GraspTrial> {
        motion.validate()?;
        if state.len() != self.scene.len() {
            return Err(Error::argument("state", "does not belong to the engine's scene"));
        }
        if !state.is_present(grasp.body) {
            return Err(Error::argument("grasp.body", format!("there is no body {} to be grasped", grasp.body)));
        }
        let numbers = [grasp.position[0], grasp.position[1], grasp.angle, grasp.opening];
        if !numbers.iter().all(|v| v.is_finite()) || grasp.opening <= 0.0 {
            return Err(Error::argument("grasp", "needs a finite pose and an opening greater than 0"));
        }
        Trial::new(self, state, grasp, motion)?.run(state, grasp.body, stop)
    }
}

struct Trial<'a> {
    engine: &'a Bullet,
    motion: &'a GraspMotion,
    world: World,
    bodies: Vec<usize>,
    middle: Vec2,
    /// Unit vector along which the fingers close.
    axis: Vec2,
    angle: f64,
    /// Half of a finger's thickness.
    half_thickness: f64,
    /// Distance between the pads.
    gap: f64,
    /// Height of the fingers' lower end.
    height: f64,
    /// Where that is to be.
    bottom: f64,
    touching: [Vec<u8>; 2],
    force: [Vec<f64>; 2],
}

impl<'a> Trial<'a> {
    fn new(engine: &'a Bullet, state: &State, grasp: &Grasp, motion: &'a GraspMotion) -> Result<Self> {
        let (mut world, bodies) = with_bodies(engine, state, &[])?;
        let gripper = &engine.scene.gripper().grasp;
        let settings = &engine.settings;
        for _ in 0..2 {
            world.add_box(&BoxDef {
                half: [gripper.finger_thickness / 2.0, gripper.finger_width / 2.0, motion.pad_height / 2.0],
                // A finger is given its closing speed anew every step; stopping it takes just the grip force.
                mass: motion.grip_force * settings.time_step / motion.close_speed,
                friction: engine.scene.friction().tip,
                kinematic: 0,
            })?;
        }
        world.place_bodies()?;
        let highest = bodies.iter().map(|&i| engine.scene.body(i).height).fold(0.0, f64::max);
        let count = bodies.len();
        let target = engine.scene.bodies().get(grasp.body).map_or(0.0, |body| body.height);
        let bottom = motion.pad_bottom.max(engine.scene.gripper().fingers_end(target));
        Ok(Self {
            engine,
            motion,
            bottom,
            world,
            bodies,
            middle: vec2(grasp.position[0], grasp.position[1]),
            axis: vec2(grasp.angle.cos(), grasp.angle.sin()),
            angle: grasp.angle,
            half_thickness: gripper.finger_thickness / 2.0,
            gap: grasp.opening,
            height: (highest + motion.start_above).max(bottom),
            touching: [vec![0; count], vec![0; count]],
            force: [vec![0.0; count], vec![0.0; count]],
        })
    }

    fn run(mut self, state: &State, target: usize, stop: &Stop) -> Result<GraspTrial> {
        let mut trial = GraspTrial { after: state.clone(), ..GraspTrial::default() };
        let finished = self.descend(&mut trial, stop)?
            && (trial.blocked_by.is_some() || (self.close(stop)? && self.lift(stop)?));
        if !finished {
            trial.interrupted = true;
            return Ok(trial);
        }
        trial.gap = self.gap;
        if trial.blocked_by.is_none() {
            self.look(&mut trial)?;
            trial.success = trial.held == Some(target) && trial.lifted.count() == 1;
        }
        if !self.leave(&mut trial, stop)? {
            trial.interrupted = true;
        }
        Ok(trial)
    }

    /// False if the stop was requested.
    fn descend(&mut self, trial: &mut GraspTrial, stop: &Stop) -> Result<bool> {
        let stride = self.motion.descend_speed * self.engine.settings.time_step;
        while self.height > self.bottom {
            if stop.requested() {
                return Ok(false);
            }
            let down = stride.min(self.height - self.bottom);
            self.step(0.0, -down)?;
            for finger in 0..2 {
                for (k, &body) in self.bodies.iter().enumerate() {
                    if self.touching[finger][k] != 0 {
                        trial.touched_on_descent.insert(body);
                    }
                    if self.force[finger][k] > self.motion.descent_force && trial.blocked_by.is_none() {
                        trial.blocked_by = Some(body);
                    }
                }
            }
            if trial.blocked_by.is_some() {
                break;
            }
        }
        Ok(true)
    }

    /// Closes until the fingers stand still against something, or against each other.
    fn close(&mut self, stop: &Stop) -> Result<bool> {
        let settings = &self.engine.settings;
        let stride = self.motion.close_speed * settings.time_step;
        // Long enough for the whole way, and as long again for what the fingers push along.
        let most = (self.gap / stride).ceil() as usize;
        let mut still = 0;
        for _ in 0..most {
            if stop.requested() {
                return Ok(false);
            }
            let before = self.gap;
            self.step(self.motion.close_speed, 0.0)?;
            still = if before - self.gap < 0.1 * stride { still + 1 } else { 0 };
            if self.gap <= 0.0 || still >= 5 {
                break;
            }
        }
        Ok(true)
    }

    fn lift(&mut self, stop: &Stop) -> Result<bool> {
        let settings = &self.engine.settings;
        let stride = self.motion.lift_speed * settings.time_step;
        let rising = (self.motion.lift / stride).ceil() as usize;
        let holding = (self.motion.hold_time / settings.time_step).ceil() as usize;
        for k in 0..rising + holding {
            if stop.requested() {
                return Ok(false);
            }
            self.step(self.motion.close_speed, if k < rising { stride } else { 0.0 })?;
        }
        Ok(true)
    }

    /// Moves the fingers by `up` metres in one step, while each closes at `closing` m/s as far as it can.
    fn step(&mut self, closing: f64, up: f64) -> Result<()> {
        let dt = self.engine.settings.time_step;
        let offset = self.gap / 2.0 + self.half_thickness;
        for finger in 0..2 {
            let side = side(finger);
            let at = self.middle + self.axis * (side * offset);
            let inwards = self.axis * (-side * closing);
            self.world.move_box(
                finger,
                &Motion {
                    position: [at.x, at.y, self.height + self.motion.pad_height / 2.0],
                    rotation: about_vertical(self.angle),
                    linear: [inwards.x, inwards.y, up / dt],
                    angular: [0.0; 3],
                },
            )?;
        }
        self.world.step()?;
        self.height += up;
        let mut travelled = 0.0;
        for finger in 0..2 {
            let reached = self.world.box_motion(finger)?.position;
            let from = self.middle + self.axis * (side(finger) * offset);
            travelled -= side(finger) * (vec2(reached[0], reached[1]) - from).dot(&self.axis) / 2.0;
            let (touching, force) = (&mut self.touching[finger as usize], &mut self.force[finger as usize]);
            touching.fill(0);
            force.fill(0.0);
            self.world.contacts(finger, TOUCHING, touching, force)?;
        }
        if closing > 0.0 {
            // The fingers are geared: both have gone as far as they have on average.
            self.gap = (self.gap - 2.0 * travelled).max(0.0);
        }
        Ok(())
    }

    /// What rose with the fingers, and what is between them.
    fn look(&self, trial: &mut GraspTrial) -> Result<()> {
        for (k, &body) in self.bodies.iter().enumerate() {
            let stands = detail(&self.engine.scene, &self.engine.settings, body, &self.world.body(k)?);
            if stands.rise > self.motion.lift / 2.0 {
                trial.lifted.insert(body);
                if self.touching.iter().all(|t| t[k] != 0) && trial.held.is_none() {
                    trial.held = Some(body);
                }
            }
        }
        Ok(())
    }

    /// Takes the fingers away (and what they hold with them) and lets the rest come to rest. False if stopped.
    fn leave(&mut self, trial: &mut GraspTrial, stop: &Stop) -> Result<bool> {
        let held = if trial.success { trial.held } else { None };
        let mut details = vec![BodyDetail::default(); self.engine.scene.len()];
        if held.is_none() {
            self.world.remove_box(0)?;
            self.world.remove_box(1)?;
            if !settle(&mut self.world, &self.engine.settings, stop)? {
                return Ok(false);
            }
        }
        trial.toppled = super::world::read(
            &self.engine.scene,
            &self.engine.settings,
            &self.world,
            &self.bodies,
            held,
            &mut trial.after,
            &mut details,
        )?;
        Ok(true)
    }
}

/// On which side of the middle a finger is.
fn side(finger: u32) -> f64 {
    if finger == 0 { -1.0 } else { 1.0 }
}
