//! The world of one push: built, stepped, read out, thrown away.

use rapier2d::prelude::*;

use super::friction::{Twist, after_friction};
use super::{Bordered, Rapier, bordered, vector};
use crate::action::Push;
use crate::geom::{Piece, Pose2, pieces_gap_below};
use crate::physics::transition::DEEPEST;
use crate::run::Stop;
use crate::scene::{Mask, State};

pub struct World<'a> {
    engine: &'a Rapier,
    world: PhysicsWorld,
    /// Body index and handle of every present body.
    handles: Vec<(usize, RigidBodyHandle)>,
    tip: RigidBodyHandle,
    tip_collider: ColliderHandle,
    steps: usize,
    touched: Mask,
    /// Deepest overlap of the tip and a body so far, borders included.
    deepest: f32,
}

impl<'a> World<'a> {
    /// The world at the moment the tip has travelled `travel` metres and is about to touch.
    pub fn new(engine: &'a Rapier, state: &State, push: &Push, travel: f64) -> Self {
        let settings = &engine.settings;
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::ZERO;
        let p = &mut world.integration_parameters;
        p.length_unit = settings.length_unit as f32;
        p.num_solver_iterations = settings.solver_iterations;
        p.num_internal_pgs_iterations = settings.sweeps;
        p.max_ccd_substeps = 0;
        p.normalized_prediction_distance = (settings.prediction / settings.length_unit) as f32;
        p.normalized_max_corrective_velocity = (settings.correction_speed / settings.length_unit) as f32;
        p.contact_recycling = settings.recycle > 0.0;
        p.normalized_contact_recycle_distance = (settings.recycle / settings.length_unit) as f32;
        p.friction_in_bias_pass = settings.friction_with_bias;
        p.contact_softness.natural_frequency = settings.contact_frequency as f32;
        p.contact_softness.damping_ratio = settings.contact_damping as f32;

        // Equal steps that end exactly at the push's end.
        let left = push.length() - travel;
        let steps = (left / (settings.speed * settings.time_step)).ceil().max(1.0);
        p.dt = settings.time_step as f32;
        let velocity = push.direction() * (left / (steps * settings.time_step));

        let mut handles = Vec::with_capacity(state.len());
        let borders = borders_in(engine, state);
        for (i, pose) in state.iter() {
            let prepared = &engine.bodies[i];
            let body = RigidBodyBuilder::dynamic()
                .pose(to_pose(&pose))
                .can_sleep(false)
                .additional_mass_properties(prepared.mass_properties);
            let handle = world.insert_body(body);
            let border = borders[handles.len()];
            for piece in &prepared.pieces {
                let collider = ColliderBuilder::new(shape(piece, border, settings.border))
                    .translation(offset(&piece.piece))
                    .density(0.0)
                    .friction(prepared.friction)
                    .friction_combine_rule(CoefficientCombineRule::Multiply)
                    .restitution(0.0)
                    .user_data(i as u128);
                world.insert_collider(collider, Some(handle));
            }
            handles.push((i, handle));
        }
        let tip = &engine.scene.gripper().push;
        let at = Pose2::at(push.start() + push.direction() * travel, push.angle());
        let (tip, tip_collider) = world.insert(
            RigidBodyBuilder::kinematic_velocity_based().pose(to_pose(&at)).linvel(vector(velocity)),
            ColliderBuilder::cuboid((tip.thickness / 2.0) as f32, (tip.width / 2.0) as f32)
                .friction(engine.scene.friction().tip as f32)
                .friction_combine_rule(CoefficientCombineRule::Multiply)
                .restitution(0.0),
        );
        Self { engine, world, handles, tip, tip_collider, steps: steps as usize, touched: Mask::EMPTY, deepest: 0.0 }
    }

    /// Pushes, lifts the tip and lets the bodies come to rest. False if the stop was requested on the way.
    pub fn run(&mut self, stop: &Stop) -> bool {
        for _ in 0..self.steps {
            if stop.requested() {
                return false;
            }
            self.step();
            self.note_touched();
        }
        self.world.remove_body(self.tip);
        let settle = (self.engine.settings.settle_time / self.engine.settings.time_step).ceil() as usize;
        for _ in 0..settle {
            if self.at_rest() {
                break;
            }
            if stop.requested() {
                return false;
            }
            self.step();
        }
        true
    }

    /// The tip went into a body on its way.
    pub fn is_unsolved(&self) -> bool {
        let settings = &self.engine.settings;
        f64::from(self.deepest) > DEEPEST + settings.border + settings.speed * settings.time_step
    }

    pub fn touched(&self) -> Mask {
        self.touched
    }

    /// Writes the bodies' poses into the state they came from. A body that never moved keeps its bits.
    pub fn read(&self, state: &mut State) {
        for &(i, handle) in &self.handles {
            let pose = self.world.bodies[handle].position();
            let pose = Pose2::new(
                f64::from(pose.translation.x),
                f64::from(pose.translation.y),
                f64::from(pose.rotation.angle()),
            );
            let before = state.pose(i);
            let moved = (pose.position() - before.position()).norm() > 1e-6
                || crate::geom::normalize_angle(pose.theta - before.theta).abs() > 1e-5;
            if moved {
                state.set_pose(i, pose);
            }
        }
    }

    fn step(&mut self) {
        let settings = &self.engine.settings;
        for &(i, handle) in &self.handles {
            let body = &mut self.world.bodies[handle];
            let (v, w) = (body.linvel(), body.angvel());
            if v.x == 0.0 && v.y == 0.0 && w == 0.0 {
                continue;
            }
            let prepared = &self.engine.bodies[i];
            let twist = Twist { linear: [f64::from(v.x), f64::from(v.y)], angular: f64::from(w) };
            let after =
                after_friction(twist, prepared.inertia, prepared.surface, settings.pressure_lead, settings.time_step);
            body.set_linvel(Vector::new(after.linear[0] as f32, after.linear[1] as f32), false);
            body.set_angvel(after.angular as f32, false);
        }
        self.world.step();
    }

    fn note_touched(&mut self) {
        for pair in self.world.narrow_phase.contact_pairs_with(self.tip_collider) {
            if pair.has_any_active_contact() {
                let other = if pair.collider1 == self.tip_collider { pair.collider2 } else { pair.collider1 };
                self.touched.insert(self.world.colliders[other].user_data as usize);
                let points = pair.manifolds().iter().flat_map(|m| &m.points);
                self.deepest = points.fold(self.deepest, |deepest, point| deepest.max(-point.dist));
            }
        }
    }

    fn at_rest(&self) -> bool {
        let limit = self.engine.settings.settle_speed as f32;
        self.handles.iter().all(|&(_, handle)| {
            let body = &self.world.bodies[handle];
            body.linvel().length() < limit && body.angvel().abs() * 0.03 < limit
        })
    }
}

/// The present bodies' borders in this state, in the order of [`State::iter`]: the settings', or half the gap to the
/// nearest neighbour where that is less.
fn borders_in(engine: &Rapier, state: &State) -> Vec<f64> {
    let full = engine.settings.border;
    let bodies: Vec<(usize, Pose2)> = state.iter().collect();
    let mut borders = vec![full; bodies.len()];
    for (k, (i, pose)) in bodies.iter().enumerate() {
        for (l, (j, other)) in bodies.iter().enumerate().skip(k + 1) {
            let (a, b) = (&engine.scene.body(*i).footprint, &engine.scene.body(*j).footprint);
            let half = (pieces_gap_below(a, pose, b, other, 2.0 * full) / 2.0).max(0.0);
            borders[k] = borders[k].min(half);
            borders[l] = borders[l].min(half);
        }
    }
    borders
}

fn shape(piece: &Bordered, border: f64, full: f64) -> SharedShape {
    if border >= full { piece.full.clone() } else { bordered(&piece.piece, border) }
}

fn offset(piece: &Piece) -> Vector {
    match piece {
        Piece::Disc { centre, .. } => vector(*centre),
        Piece::Convex(_) => Vector::ZERO,
    }
}

fn to_pose(pose: &Pose2) -> Pose {
    Pose::new(vector(pose.position()), pose.theta as f32)
}
