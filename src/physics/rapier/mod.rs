//! rapier2d as a [`Transition`]: rigid bodies in the plane, a limit surface under each, a kinematic tip.
//!
//! The world is built afresh for every push, which costs about 2 % of it and makes equal inputs give equal bits.
//! Settings were fitted against recorded 3D pushes (`docs/benchmarks.md`): a border of 1 mm round the bodies, a length
//! unit of 1 cm, and a friction ellipsoid whose centre of pressure runs 12 mm ahead.

mod friction;
mod settings;
mod world;

use std::sync::Arc;

pub use friction::{Inertia, LimitSurface, Twist, after_friction};
pub use settings::RapierSettings;

use self::world::World;
use super::approach::Approach;
use super::transition::{PushJob, PushResult, PushStatus, Scratch, Transition};
use crate::error::Result;
use crate::geom::{Piece, Vec2};
use crate::run::Stop;
use crate::scene::Scene;
use rapier2d::prelude::{MassProperties, SharedShape, Vector};

/// The engine prepared for one scene.
pub struct Rapier {
    name: String,
    scene: Arc<Scene>,
    settings: RapierSettings,
    bodies: Vec<Prepared>,
}

/// What of a body does not change from push to push.
struct Prepared {
    pieces: Vec<Bordered>,
    mass_properties: MassProperties,
    inertia: Inertia,
    surface: LimitSurface,
    friction: f32,
}

/// A piece as rapier takes it: with the full border ready made, and what is needed for a thinner one.
struct Bordered {
    full: SharedShape,
    piece: Piece,
}

impl Rapier {
    /// Prepares the scene.
    pub fn new(scene: Arc<Scene>, settings: RapierSettings) -> Result<Rapier> {
        Self::with_name("rapier".into(), scene, settings)
    }

    pub(super) fn with_name(name: String, scene: Arc<Scene>, settings: RapierSettings) -> Result<Rapier> {
        settings.validate()?;
        let bodies = scene
            .bodies()
            .iter()
            .map(|body| {
                let force = scene.friction().ground * body.friction * body.mass * settings.gravity;
                let radius = body.footprint.mean_distance(body.centre_of_mass);
                Prepared {
                    pieces: body
                        .footprint
                        .pieces
                        .iter()
                        .map(|piece| Bordered { full: bordered(piece, settings.border), piece: piece.clone() })
                        .collect(),
                    mass_properties: MassProperties::new(
                        vector(body.centre_of_mass),
                        body.mass as f32,
                        body.inertia as f32,
                    ),
                    inertia: Inertia { mass: body.mass, about_centre: body.inertia },
                    surface: LimitSurface { force, torque: force * settings.torque_ratio * radius },
                    friction: body.friction as f32,
                }
            })
            .collect();
        Ok(Rapier { name, scene, settings, bodies })
    }

    pub fn settings(&self) -> &RapierSettings {
        &self.settings
    }

    fn push(&self, job: &PushJob<'_>, result: &mut PushResult, stop: &Stop) {
        let Some(travel) = self.approach().begin(&self.scene, job, result) else { return };
        let push = &job.push;
        let mut world = World::new(self, job.state, push, travel);
        if !world.run(stop) {
            result.status = PushStatus::Interrupted;
            return;
        }
        result.touched = world.touched();
        world.read(&mut result.state);
        Approach::end(&self.scene, job, result);
    }

    fn approach(&self) -> Approach {
        Approach { landing_tolerance: self.settings.landing_tolerance, border: self.settings.border }
    }
}

impl Transition for Rapier {
    fn name(&self) -> &str {
        &self.name
    }

    fn scene(&self) -> &Scene {
        &self.scene
    }

    fn scratch(&self) -> Scratch {
        Box::new(())
    }

    fn step_batch(&self, _: &mut Scratch, jobs: &[PushJob<'_>], results: &mut [PushResult], stop: &Stop) {
        for (job, result) in jobs.iter().zip(results) {
            if stop.requested() {
                result.status = PushStatus::Interrupted;
            } else {
                self.push(job, result, stop);
            }
        }
    }
}

#[inline]
fn vector(v: Vec2) -> Vector {
    Vector::new(v.x as f32, v.y as f32)
}

/// A piece grown by a round border.
fn bordered(piece: &Piece, border: f64) -> SharedShape {
    match piece {
        Piece::Disc { radius, .. } => SharedShape::ball((radius + border) as f32),
        Piece::Convex(points) => {
            let corners: Vec<Vector> = points.iter().map(|&p| vector(p)).collect();
            let shape = if border > 0.0 {
                SharedShape::round_convex_polyline(corners.clone(), border as f32)
            } else {
                SharedShape::convex_polyline(corners.clone())
            };
            // A piece is convex and has an area, so this is not reached; a point cloud's hull is the same shape.
            shape.unwrap_or_else(|| SharedShape::convex_hull(&corners).unwrap_or_else(|| SharedShape::ball(1e-3)))
        }
    }
}
