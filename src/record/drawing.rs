//! What a panel shows, in the world frame: bodies, predicted bodies, action. Knows nothing of pixels.

use crate::action::{Action, Grasp, Push};
use crate::geom::{Obb, Piece, Pose2, Vec2, normalize_angle, vec2};
use crate::scene::{Body, PushTip, Scene, State};

/// Moved less than this, a body is not shown a second time: metres and radians.
const MOVED: [f64; 2] = [5e-4, 0.01];
/// A panel shows what lies outside its workspace by at most this part of the workspace's size.
const OUTLOOK: f64 = 0.35;

/// A part of a body's outline.
pub(super) enum Outline {
    Polygon(Vec<Vec2>),
    Disc { centre: Vec2, radius: f64 },
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Target,
    Body,
    /// Neither to be grasped nor to be aimed at.
    Obstacle,
}

pub(super) struct DrawnBody {
    pub index: usize,
    pub name: String,
    pub role: Role,
    pub outlines: Vec<Outline>,
    /// Where a label has most room, and the radius of that room.
    pub label: (Vec2, f64),
}

/// A tool's way.
pub(super) enum DrawnAction {
    Push { tip: [Obb; 2], way: [Vec2; 2] },
    Grasp { fingers: [Obb; 2], closing: [[Vec2; 2]; 2] },
}

/// All that a panel shows.
pub(super) struct Drawing {
    pub caption: String,
    pub details: String,
    /// Corners of the workspace.
    pub workspace: [Vec2; 2],
    /// Corners of what is to be seen.
    pub view: [Vec2; 2],
    pub bodies: Vec<DrawnBody>,
    /// Where the bodies that move are expected to end.
    pub predicted: Vec<DrawnBody>,
    pub action: Option<DrawnAction>,
    /// A bar below the plot: filled to this share, with this text.
    pub gauge: Option<(f64, String)>,
}

impl Drawing {
    pub(super) fn new(
        scene: &Scene,
        state: &State,
        target: Option<usize>,
        action: Option<&Action>,
        after: Option<&State>,
        caption: &str,
    ) -> Drawing {
        let drawn = |state: &State, which: &dyn Fn(usize, &Pose2) -> bool| -> Vec<DrawnBody> {
            let shown = state.iter().filter(|(i, pose)| *i < scene.len() && pose.is_finite() && which(*i, pose));
            shown.map(|(i, pose)| DrawnBody::new(i, scene.body(i), &pose, target == Some(i))).collect()
        };
        let bodies = drawn(state, &|_, _| true);
        let moved = |i: usize, pose: &Pose2| {
            if i >= state.len() || !state.is_present(i) {
                return false;
            }
            let before = state.pose(i);
            (pose.position() - before.position()).norm() > MOVED[0]
                || normalize_angle(pose.theta - before.theta).abs() > MOVED[1]
        };
        let predicted = after.map(|after| drawn(after, &moved)).unwrap_or_default();
        let workspace = scene.workspace();
        let workspace = [vec2(workspace.min[0], workspace.min[1]), vec2(workspace.max[0], workspace.max[1])];
        let mut drawing = Drawing {
            caption: caption.to_owned(),
            details: action.map(|a| details(scene, a)).unwrap_or_default(),
            workspace,
            view: workspace,
            bodies,
            predicted,
            action: action.and_then(|a| DrawnAction::new(scene, a)),
            gauge: None,
        };
        drawing.widen();
        drawing
    }

    /// Takes into view what lies about the workspace.
    fn widen(&mut self) {
        let [low, high] = self.workspace;
        let most = (high - low) * OUTLOOK;
        let mut view = self.workspace;
        let mut see = |p: Vec2| {
            view[0] = view[0].inf(&p).sup(&(low - most));
            view[1] = view[1].sup(&p).inf(&(high + most));
        };
        for body in self.bodies.iter().chain(&self.predicted) {
            for outline in &body.outlines {
                match outline {
                    Outline::Polygon(points) => points.iter().for_each(|p| see(*p)),
                    Outline::Disc { centre, radius } => {
                        see(centre - vec2(*radius, *radius));
                        see(centre + vec2(*radius, *radius));
                    }
                }
            }
        }
        match &self.action {
            Some(DrawnAction::Push { tip: tools, .. } | DrawnAction::Grasp { fingers: tools, .. }) => {
                tools.iter().flat_map(|t| t.corners()).for_each(&mut see);
            }
            None => {}
        }
        self.view = view;
    }
}

impl DrawnBody {
    fn new(index: usize, body: &Body, pose: &Pose2, is_target: bool) -> DrawnBody {
        let frame = pose.frame();
        let footprint = &body.footprint;
        let discs_only = footprint.pieces.iter().all(|p| matches!(p, Piece::Disc { .. }));
        // Discs stay round where all parts are discs; otherwise the outlines say it well enough.
        let outlines: Vec<Outline> = if discs_only {
            let discs = footprint.pieces.iter().filter_map(|p| match p {
                Piece::Disc { centre, radius } => Some(Outline::Disc { centre: frame.point(*centre), radius: *radius }),
                Piece::Convex(_) => None,
            });
            discs.collect()
        } else {
            let at = |o: &Vec<Vec2>| Outline::Polygon(o.iter().map(|p| frame.point(*p)).collect());
            footprint.outlines.iter().map(at).collect()
        };
        let role = match (is_target, body.pickable || body.pushable) {
            (true, _) => Role::Target,
            (false, true) => Role::Body,
            (false, false) => Role::Obstacle,
        };
        let (room, radius) = roomiest(&footprint.outlines);
        DrawnBody { index, name: body.name.clone(), role, outlines, label: (frame.point(room), radius) }
    }
}

impl DrawnAction {
    fn new(scene: &Scene, action: &Action) -> Option<DrawnAction> {
        match action {
            Action::Push(push) => DrawnAction::push(push, &scene.gripper().push),
            Action::Grasp(grasp) => DrawnAction::grasp(grasp, scene),
        }
    }

    fn push(push: &Push, tip: &PushTip) -> Option<DrawnAction> {
        let start = push.tip_at_start(tip);
        push.is_finite().then(|| DrawnAction::Push {
            tip: [start, Obb { centre: push.end(), ..start }],
            way: [push.start(), push.end()],
        })
    }

    fn grasp(grasp: &Grasp, scene: &Scene) -> Option<DrawnAction> {
        let numbers = [grasp.position[0], grasp.position[1], grasp.angle, grasp.opening, grasp.width];
        if !numbers.iter().all(|v| v.is_finite()) {
            return None;
        }
        let jaw = &scene.gripper().grasp;
        let axis = vec2(grasp.angle.cos(), grasp.angle.sin());
        let middle = vec2(grasp.position[0], grasp.position[1]);
        let finger = |sign: f64| Obb {
            centre: middle + axis * (sign * (grasp.opening + jaw.finger_thickness) / 2.0),
            axis,
            half: [jaw.finger_thickness / 2.0, jaw.finger_width / 2.0],
        };
        let closing = |sign: f64| {
            // From amid the finger to the face it will touch.
            let from = middle + axis * (sign * (grasp.opening / 2.0 + jaw.finger_thickness * 0.6));
            [from, middle + axis * (sign * grasp.width.min(grasp.opening) / 2.0)]
        };
        Some(DrawnAction::Grasp { fingers: [finger(1.0), finger(-1.0)], closing: [closing(1.0), closing(-1.0)] })
    }
}

/// An action in words.
fn details(scene: &Scene, action: &Action) -> String {
    let name = |i: usize| scene.bodies().get(i).map_or_else(|| format!("body {i}"), |b| b.name.clone());
    match action {
        Action::Push(push) => {
            let aim = push.body.map(|i| format!("push {}: ", name(i))).unwrap_or_else(|| "push: ".into());
            format!("{aim}{:.0} mm at {:.0}\u{b0}", push.length() * 1e3, push.angle().to_degrees() + 0.0)
        }
        Action::Grasp(grasp) => format!(
            "grasp {}: score {:.2}, margin {:.1} mm, opening {:.0} mm",
            name(grasp.body),
            grasp.score,
            grasp.margin * 1e3,
            grasp.opening * 1e3
        ),
    }
}

/// The point within the outlines that is farthest from their border, on a grid, and that distance.
fn roomiest(outlines: &[Vec<Vec2>]) -> (Vec2, f64) {
    const STEPS: usize = 24;
    let mut best = (Vec2::zeros(), 0.0);
    for outline in outlines {
        let low = outline.iter().copied().reduce(|a, b| a.inf(&b)).unwrap_or_default();
        let high = outline.iter().copied().reduce(|a, b| a.sup(&b)).unwrap_or_default();
        let middle = (low + high) / 2.0;
        for i in 0..=STEPS {
            for j in 0..=STEPS {
                let part = vec2(i as f64, j as f64) / STEPS as f64;
                let p = low + (high - low).component_mul(&part);
                if !crate::geom::contains_point(outline, p) {
                    continue;
                }
                let room = border_distance(outline, p);
                // Among equals the one nearest the middle, so that a long bar has its label amid.
                let better = room > best.1 + 1e-4
                    || (room > best.1 - 1e-4 && (p - middle).norm() < (best.0 - middle).norm() - 1e-6);
                if better {
                    best = (p, room);
                }
            }
        }
    }
    best
}

fn border_distance(outline: &[Vec2], p: Vec2) -> f64 {
    let mut least = f64::INFINITY;
    for i in 0..outline.len() {
        let (a, b) = (outline[i], outline[(i + 1) % outline.len()]);
        let (ab, ap) = (b - a, p - a);
        let t = (ap.dot(&ab) / ab.norm_squared()).clamp(0.0, 1.0);
        least = least.min((ap - ab * t).norm());
    }
    least
}
