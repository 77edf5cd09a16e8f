//! What of a scene does not change from push to push, in the form that the simulation reads.

use super::settings::PrismSettings;
use crate::geom::{Footprint, Piece, Vec2};
use crate::scene::{Scene, TipPath};

/// The simulation's floating-point type: eight single-precision numbers fit a register.
pub type Real = f32;

/// A point or vector in the plane.
pub type Flat = [Real; 2];

/// Corners that stand for a disc where it touches the ground.
const DISC_CORNERS: usize = 32;

/// The bodies of a scene and, as the last one, the tip.
pub struct Model {
    pub bodies: Vec<Body>,
    pub pieces: Vec<Shape>,
    /// Corners of all pieces; each piece has a range of them. Body frame, relative to the centre of mass.
    pub corners: Vec<Flat>,
    /// Outward unit normals of the edges that begin at the corners.
    pub normals: Vec<Flat>,
    /// Friction coefficient of the ground's surface.
    pub ground_friction: Real,
    /// The robot's, for the tip.
    pub path: Option<TipPath>,
}

/// A body: an upright prism.
#[derive(Debug, Clone, Copy)]
pub struct Body {
    pub pieces: (u32, u32),
    /// Over the mass; 0 for the tip.
    pub inverse_mass: Real,
    /// About the body's axes through its centre of mass.
    pub inverse_inertia: [Real; 3],
    /// Centre of mass in the body frame of the scene, metres.
    pub centre: Flat,
    /// Height of the prism below and above its centre of mass.
    pub half_height: Real,
    /// Of the circle round the centre of mass that holds the body with its border.
    pub radius: Real,
    /// Friction coefficient of the surface.
    pub friction: Real,
    /// Rolling friction of the surface, metres.
    pub rolling: Real,
}

/// A convex piece of a body's footprint.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    pub body: u32,
    /// Its range in `corners` and `normals`. A disc has the corners with which it touches the ground.
    pub corners: (u32, u32),
    /// The border, and for a disc its radius too.
    pub round: Real,
    pub border: Real,
    pub is_disc: bool,
    /// A point inside; the centre of a disc.
    pub middle: Flat,
    /// Of the circle round the centre of mass that holds the piece without `round`.
    pub radius: Real,
    /// Bullet's angular motion disc: half diagonal of the box with its border, and that box's distance from the
    /// centre of mass.
    pub motion_disc: Real,
}

impl Model {
    pub fn new(scene: &Scene, settings: &PrismSettings) -> Model {
        let mut model = Model {
            bodies: Vec::new(),
            pieces: Vec::new(),
            corners: Vec::new(),
            normals: Vec::new(),
            ground_friction: scene.friction().ground as Real,
            path: scene.gripper().path.clone(),
        };
        for body in scene.bodies() {
            let half = body.height / 2.0;
            let [ex, ey] = half_extents(&body.footprint).map(|e| e + settings.border);
            let ez = half + settings.border;
            let first = model.pieces.len() as u32;
            for piece in &body.footprint.pieces {
                model.add_piece(piece, body.centre_of_mass, half, settings.border);
            }
            model.bodies.push(Body {
                pieces: (first, model.pieces.len() as u32),
                inverse_mass: (1.0 / body.mass) as Real,
                inverse_inertia: [
                    (3.0 / (body.mass * (ey * ey + ez * ez))) as Real,
                    (3.0 / (body.mass * (ex * ex + ez * ez))) as Real,
                    (1.0 / body.inertia) as Real,
                ],
                centre: flat(body.centre_of_mass),
                half_height: half as Real,
                radius: model.radius_from(first),
                friction: body.friction as Real,
                rolling: settings.rolling as Real,
            });
        }
        model.add_tip(scene, settings);
        for (i, body) in model.bodies.iter().enumerate() {
            for piece in &mut model.pieces[body.pieces.0 as usize..body.pieces.1 as usize] {
                piece.body = i as u32;
            }
        }
        model
    }

    /// Index of the tip among the bodies.
    pub fn tip(&self) -> usize {
        self.bodies.len() - 1
    }

    fn radius_from(&self, first: u32) -> Real {
        self.pieces[first as usize..].iter().fold(0.0, |r, p| r.max(p.radius + p.round))
    }

    fn add_piece(&mut self, piece: &Piece, centre: Vec2, half_height: f64, border: f64) {
        let first = self.corners.len() as u32;
        let (points, disc, round): (Vec<Vec2>, Option<Vec2>, f64) = match piece {
            Piece::Convex(points) => (points.iter().map(|p| p - centre).collect(), None, border),
            Piece::Disc { centre: c, radius } => {
                let step = std::f64::consts::TAU / DISC_CORNERS as f64;
                let corner = |i: usize| {
                    let a = i as f64 * step;
                    c - centre + Vec2::new(a.cos(), a.sin()) * *radius
                };
                ((0..DISC_CORNERS).map(corner).collect(), Some(c - centre), radius + border)
            }
        };
        let (mut low, mut high) = (points[0], points[0]);
        for p in &points {
            (low, high) = (low.inf(p), high.sup(p));
        }
        let half = (high - low) / 2.0;
        let offset = ((high + low) / 2.0).norm();
        let box_half = [half.x + border, half.y + border, half_height + border];
        let motion_disc = box_half.iter().map(|e| e * e).sum::<f64>().sqrt() + offset;
        let radius = match disc {
            Some(c) => c.norm(),
            None => points.iter().map(|p| p.norm()).fold(0.0, f64::max),
        };
        for (i, p) in points.iter().enumerate() {
            let along = points[(i + 1) % points.len()] - p;
            let length = along.norm().max(f64::MIN_POSITIVE);
            self.corners.push(flat(*p));
            self.normals.push([(along.y / length) as Real, (-along.x / length) as Real]);
        }
        self.pieces.push(Shape {
            body: 0,
            corners: (first, self.corners.len() as u32),
            round: round as Real,
            border: border as Real,
            is_disc: disc.is_some(),
            middle: flat(disc.unwrap_or(points.iter().sum::<Vec2>() / points.len() as f64)),
            radius: radius as Real,
            motion_disc: motion_disc as Real,
        });
    }

    /// The tip: a rectangle with rounded corners, whose whole extent is the gripper's.
    fn add_tip(&mut self, scene: &Scene, settings: &PrismSettings) {
        let tip = &scene.gripper().push;
        let border = settings.border.min(0.25 * tip.width.min(tip.thickness));
        let (x, y) = (tip.thickness / 2.0 - border, tip.width / 2.0 - border);
        let points = vec![Vec2::new(-x, -y), Vec2::new(x, -y), Vec2::new(x, y), Vec2::new(-x, y)];
        let first = self.pieces.len() as u32;
        let half_height = (settings.tip_high - settings.tip_low) / 2.0;
        self.add_piece(&Piece::Convex(points), Vec2::zeros(), half_height, border);
        self.bodies.push(Body {
            pieces: (first, first + 1),
            inverse_mass: 0.0,
            inverse_inertia: [0.0; 3],
            centre: [0.0; 2],
            half_height: half_height as Real,
            radius: self.radius_from(first),
            friction: scene.friction().tip as Real,
            rolling: 0.0,
        });
    }
}

fn half_extents(footprint: &Footprint) -> [f64; 2] {
    let (low, high) = footprint.bounds();
    [(high.x - low.x) / 2.0, (high.y - low.y) / 2.0]
}

fn flat(v: Vec2) -> Flat {
    [v.x as Real, v.y as Real]
}
