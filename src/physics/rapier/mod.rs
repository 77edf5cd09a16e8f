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
use rapier2d::geometry::ConvexPolygon;
use rapier2d::parry::shape::RoundShape;
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
        let approach = self.approach();
        let Some(travel) = approach.begin(&self.scene, job, result) else { return };
        let push = &job.push;
        let mut world = World::new(self, job.state, push, travel);
        if !world.run(stop) {
            result.status = PushStatus::Interrupted;
            return;
        }
        if world.is_unsolved() {
            return result.take_back(job.state);
        }
        result.touched = world.touched();
        world.read(&mut result.state);
        approach.end(&self.scene, job, result);
    }

    fn approach(&self) -> Approach {
        let RapierSettings { landing_tolerance, border, .. } = self.settings;
        Approach { landing_tolerance, border, tip_low: 0.0, flat: true }
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
            let bordered = |inner_shape: ConvexPolygon| {
                if border > 0.0 {
                    SharedShape::new(RoundShape { inner_shape, border_radius: border as f32 })
                } else {
                    SharedShape::new(inner_shape)
                }
            };
            // Unmodified: the other ways to make a polygon drop corners where its sides turn by less than 1.5 degrees,
            // one after the other, so that a finely cut arc becomes its chord. A piece is convex and has an area: the
            // rest is reached only by corners that are one in single precision.
            ConvexPolygon::from_convex_polyline_unmodified(corners.clone())
                .or_else(|| ConvexPolygon::from_convex_hull(&corners))
                .map_or_else(|| SharedShape::ball(1e-3), bordered)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::action::Push;
    use crate::geom::{Footprint, Pose2, Shape, vec2};
    use crate::scene::{BodyDef, SceneBuilder, State};

    /// A quarter of a disc, its arc cut into segments.
    fn quarter(radius: f64, segments: u32) -> Shape {
        let at = |i: u32| {
            let angle = std::f64::consts::FRAC_PI_2 * f64::from(i) / f64::from(segments);
            [radius * angle.cos(), radius * angle.sin()]
        };
        Shape::ConvexPolygon(std::iter::once([0.0, 0.0]).chain((0..=segments).map(at)).collect())
    }

    #[test]
    fn a_piece_keeps_every_corner_however_finely_it_is_cut() {
        for segments in [2, 10, 59, 60, 61, 120, 240, 480] {
            for radius in [0.01, 0.045, 0.2] {
                let footprint = Footprint::new(quarter(radius, segments)).unwrap();
                for border in [0.0, 0.0004, 0.001] {
                    let shape = bordered(&footprint.pieces[0], border);
                    let plain = shape.as_convex_polygon();
                    let round = shape.as_round_convex_polygon().map(|round| &round.inner_shape);
                    assert!(plain.is_some() == (border == 0.0) && round.is_some() == (border > 0.0));
                    let corners = plain.or(round).map(|polygon| polygon.points().len());
                    assert_eq!(corners, Some(segments as usize + 2), "radius {radius}, border {border}");
                }
            }
        }
    }

    #[test]
    fn how_finely_an_arc_is_cut_does_not_matter_to_a_push() {
        let ends: Vec<Pose2> = [30, 59, 60, 120]
            .into_iter()
            .map(|segments| {
                let mut builder = SceneBuilder::new();
                builder
                    .add_body(BodyDef { outline_tolerance: Some(0.0), ..BodyDef::new(quarter(0.045, segments)) })
                    .unwrap();
                let engine = Rapier::new(Arc::new(builder.build().unwrap()), RapierSettings::fast()).unwrap();
                // The arc faces the tip.
                let state = State::new([Pose2::new(0.5, 0.0, std::f64::consts::PI * 0.75)]);
                let push = Push::new(vec2(0.42, 0.004), vec2(0.53, 0.004));
                engine.step(&mut engine.scratch(), &state, &push, &Stop::never()).state.pose(0)
            })
            .collect();
        for end in &ends {
            let apart = (end.position() - ends[0].position()).norm();
            assert!(end.x > 0.55 && apart < 1.5e-3, "{ends:?}");
        }
    }

    #[test]
    fn a_body_goes_along_with_the_tip_however_slow_it_is() {
        for preset in RapierSettings::PRESETS {
            for speed in [0.001, 0.01, 0.05, 0.13] {
                for side in [0.005, 0.045, 0.4] {
                    let settings = RapierSettings { speed, ..RapierSettings::by_name(preset).unwrap() };
                    let mut builder = SceneBuilder::new();
                    builder.add_body(BodyDef::new(Shape::rectangle(side, side))).unwrap();
                    let engine = Rapier::new(Arc::new(builder.build().unwrap()), settings).unwrap();
                    let front = engine.scene.gripper().push.thickness / 2.0;
                    let state = State::new([Pose2::new(0.5, 0.0, 0.0)]);
                    let start = vec2(0.5 - side / 2.0 - front - 0.005, 0.0);
                    let push = Push::new(start, start + vec2(0.025, 0.0));
                    let result = engine.step(&mut engine.scratch(), &state, &push, &Stop::never());
                    let moved = result.state.pose(0).x - 0.5;
                    let of = format!("{preset}, {speed} m/s, side {side}: {moved} m");
                    // By the border more than the tip travels in contact, and it may coast on once the tip is lifted.
                    let least = 0.02 + settings.border - 5e-4;
                    let coasts = speed * speed / (2.0 * 1.1 * 0.5 * settings.gravity);
                    let along = (least..least + coasts + 1e-3).contains(&moved);
                    assert!(result.status == PushStatus::Executed && along, "{of}");
                }
            }
        }
    }
}
