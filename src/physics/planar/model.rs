//! What of a scene does not change from push to push.

use std::ops::Range;

use super::settings::PlanarSettings;
use crate::action::Push;
use crate::geom::{Vec2, vec2};
use crate::physics::narrow::Outline;
use crate::scene::{Scene, State, TipPath};

/// A body. Its fictitious mass is its greatest friction force over the scene's typical one: the mass metric is then
/// the metric of the limit surface, in the coordinates (x, y, `torque_radius` times angle).
#[derive(Debug, Clone, PartialEq)]
pub struct BodyModel {
    /// Body frame, metres.
    pub centre_of_mass: [f32; 2],
    /// Greatest distance of the body from its origin, metres.
    pub radius: f32,
    /// Greatest friction torque over greatest friction force, metres.
    pub torque_radius: f32,
    /// One over the square root of the fictitious mass.
    pub inverse_root: f32,
    /// Impulse at which the body yields, in scaled coordinates, over that of a typical body.
    pub threshold: f32,
    pub friction: f32,
    /// Its pieces in [`Model::outlines`].
    pub pieces: Range<usize>,
}

/// The scene as the engine wants it.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    pub bodies: Vec<BodyModel>,
    pub outlines: Vec<Outline>,
    /// Where each outline's octets are kept.
    pub octets: Vec<Range<usize>>,
    /// Octets of all outlines.
    pub octet_count: usize,
    /// Frame: origin at its centre, x along the push.
    pub tip: Outline,
    pub tip_friction: f32,
    /// Some bodies' masses differ greatly; see [`PlanarSettings::uneven_masses`].
    pub uneven: bool,
    /// The robot's, for the tip.
    pub path: Option<TipPath>,
    /// Of the bodies.
    pub heights: Vec<f64>,
}

/// Least fictitious mass. A body without friction would be of no mass at all.
const LEAST_MASS: f64 = 1e-3;

impl Model {
    pub fn new(scene: &Scene, settings: &PlanarSettings) -> Model {
        let ground = scene.friction().ground;
        let force = |i: usize| ground * scene.body(i).friction * scene.body(i).mass;
        let mean = (0..scene.len()).map(force).sum::<f64>() / scene.len().max(1) as f64;
        let (mut outlines, mut octets, mut octet_count) = (Vec::new(), Vec::new(), 0);
        let bodies = scene.bodies().iter().enumerate().map(|(i, body)| {
            let first = outlines.len();
            for piece in &body.footprint.pieces {
                let outline = Outline::new(piece);
                octets.push(octet_count..octet_count + outline.octets.len());
                octet_count += outline.octets.len();
                outlines.push(outline);
            }
            let relative = if mean > 0.0 { force(i) / mean } else { 0.0 };
            let mass = relative.max(LEAST_MASS);
            let radius = settings.torque_ratio * body.footprint.mean_distance(body.centre_of_mass);
            BodyModel {
                centre_of_mass: [body.centre_of_mass.x as f32, body.centre_of_mass.y as f32],
                radius: (body.footprint.radius * (1.0 + 1e-6)) as f32,
                torque_radius: radius as f32,
                inverse_root: (1.0 / mass.sqrt()) as f32,
                threshold: (relative / mass.sqrt()) as f32,
                friction: body.friction as f32,
                pieces: first..outlines.len(),
            }
        });
        let bodies: Vec<BodyModel> = bodies.collect();
        let roots = bodies.iter().map(|b| b.inverse_root);
        let (least, greatest) = roots.fold((1.0f32, 1.0f32), |(low, high), root| (low.min(root), high.max(root)));
        let tip = &scene.gripper().push;
        let half: Vec2 = vec2(tip.thickness / 2.0, tip.width / 2.0);
        let corner = |x: f64, y: f64| vec2(x * half.x, y * half.y);
        let tip = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        Model {
            bodies,
            outlines,
            octets,
            octet_count,
            tip: Outline::polygon(&tip),
            tip_friction: scene.friction().tip as f32,
            path: scene.gripper().path.clone(),
            heights: scene.bodies().iter().map(|body| body.height).collect(),
            // On a ground without friction all bodies are alike.
            uneven: mean > 0.0 && greatest * greatest > settings.uneven_masses as f32 * (least * least),
        }
    }

    /// What a push is likely to cost beside others: how far the tip would push the bodies on its way, all together,
    /// metres.
    pub fn effort(&self, state: &State, push: &Push) -> f32 {
        let (start, direction, length) = (push.start(), push.direction(), push.length() as f32);
        let [x, y, ux, uy] = [start.x as f32, start.y as f32, direction.x as f32, direction.y as f32];
        let mut effort = 0.0;
        for (body, pose) in self.bodies.iter().zip(state.poses()) {
            let reach = body.radius + self.tip.radius;
            let (dx, dy) = (pose.x - x, pose.y - y);
            let (along, across) = (dx * ux + dy * uy, dy * ux - dx * uy);
            if across.abs() < reach && along > 0.0 {
                effort += (length - (along - reach).max(0.0)).max(0.0);
            }
        }
        effort
    }
}
