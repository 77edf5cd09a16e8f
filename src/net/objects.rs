//! States and pushes as the networks on objects are told of them: every body's outline and centre in the frame of the push.
//!
//! The push frame has its origin at the tip's centre where the push begins and +x along the push. Absent bodies are rows of
//! zeros, so that a scene always has the same number of rows.

use super::kind::{Interface, OUTLINE_POINTS};
use crate::action::Push;
use crate::geom::{Pose2, Vec2, normalize_angle};
use crate::scene::{Scene, State};
use crate::vision::centre_of;

/// What networks are told of the bodies of a scene wherever they lie.
#[derive(Debug, Clone)]
pub struct ObjectTable {
    /// Body frame, relative to the centre.
    outlines: Vec<[Vec2; OUTLINE_POINTS]>,
    bodies: Vec<[f32; 4]>,
    /// Width and thickness of the tip, its friction on the bodies.
    tip: [f32; 3],
}

/// Mass (kg), friction with the ground, friction with a body of the same surface, height (m).
pub fn body_features(scene: &Scene, body: usize) -> [f32; 4] {
    let b = scene.body(body);
    [b.mass, scene.friction().ground * b.friction, b.friction * b.friction, b.height].map(|v| v as f32)
}

/// Width across the push (m), thickness along it (m), friction on the bodies: the product of the tip's coefficient and the
/// bodies' mean one.
pub fn tip_features(scene: &Scene) -> [f32; 3] {
    let tip = &scene.gripper().push;
    let surface = scene.bodies().iter().map(|b| b.friction).sum::<f64>() / scene.len() as f64;
    [tip.width as f32, tip.thickness as f32, (scene.friction().tip * surface) as f32]
}

/// The frame of a push.
pub fn push_frame(push: &Push) -> Pose2 {
    Pose2::at(push.start(), push.angle())
}

impl ObjectTable {
    pub fn new(scene: &Scene) -> ObjectTable {
        ObjectTable {
            outlines: scene.bodies().iter().map(|b| b.footprint.outline_points()).collect(),
            bodies: (0..scene.len()).map(|i| body_features(scene, i)).collect(),
            tip: tip_features(scene),
        }
    }

    /// Rows of an item.
    pub fn len(&self) -> usize {
        self.outlines.len()
    }

    pub fn is_empty(&self) -> bool {
        self.outlines.is_empty()
    }
}

/// Items of a call, filled one after the other. Keeps its memory.
#[derive(Debug, Clone, Default)]
pub struct ObjectBatch {
    items: usize,
    objects: usize,
    outline: Vec<f32>,
    centre: Vec<f32>,
    body: Vec<f32>,
    push: Vec<f32>,
    guess: Vec<f32>,
    present: Vec<f32>,
    target: Vec<f32>,
}

impl ObjectBatch {
    /// Begins a call for scenes of so many bodies.
    pub fn clear(&mut self, objects: usize) {
        (self.items, self.objects) = (0, objects);
        let Self { outline, centre, body, push, guess, present, target, .. } = self;
        for tensor in [outline, centre, body, push, guess, present, target] {
            tensor.clear();
        }
    }

    pub fn items(&self) -> usize {
        self.items
    }

    pub fn objects(&self) -> usize {
        self.objects
    }

    /// The centre of a body of an item in the frame of its push, metres; zeros for an absent body.
    pub fn centre(&self, item: usize, body: usize) -> [f64; 2] {
        let at = 2 * (item * self.objects + body);
        [0, 1].map(|axis| self.centre.get(at + axis).copied().unwrap_or(0.0).into())
    }

    /// The length of an item's push, metres.
    pub fn push_length(&self, item: usize) -> f64 {
        self.push.get(4 * item).copied().unwrap_or(0.0).into()
    }

    /// Adds a push of a state. `guess`: the state after it as another engine has it.
    pub fn add(
        &mut self,
        table: &ObjectTable,
        scene: &Scene,
        state: &State,
        push: &Push,
        guess: Option<&State>,
        target: Option<usize>,
    ) {
        let frame = push_frame(push).frame();
        for i in 0..self.objects {
            let there = state.is_present(i) && i < state.len() && i < table.len();
            self.present.push(if there { 1.0 } else { 0.0 });
            self.target.push(if there && target == Some(i) { 1.0 } else { 0.0 });
            if !there {
                self.outline.extend([0.0; 2 * OUTLINE_POINTS]);
                self.centre.extend([0.0; 2]);
                self.body.extend([0.0; 4]);
                self.guess.extend([0.0; 3]);
                continue;
            }
            let pose = state.pose(i);
            let turned = pose.frame();
            for point in &table.outlines[i] {
                let p = frame.inverse_vector(turned.vector(*point));
                self.outline.extend([p.x as f32, p.y as f32]);
            }
            let centre = centre_of(scene.body(i), &pose);
            let seen = frame.inverse_point(centre);
            self.centre.extend([seen.x as f32, seen.y as f32]);
            self.body.extend(table.bodies[i]);
            let after = guess.map_or(pose, |guess| guess.pose(i));
            let moved = frame.inverse_vector(centre_of(scene.body(i), &after) - centre);
            let turn = normalize_angle(after.theta - pose.theta);
            self.guess.extend([moved.x as f32, moved.y as f32, turn as f32]);
        }
        let [width, thickness, friction] = table.tip;
        self.push.extend([push.length() as f32, width, thickness, friction]);
        self.items += 1;
    }

    /// The tensors in an interface's order.
    pub(super) fn tensors(&self, interface: &Interface) -> Vec<&[f32]> {
        interface
            .inputs
            .iter()
            .map(|spec| match spec.name {
                "outline" => self.outline.as_slice(),
                "centre" => &self.centre,
                "body" => &self.body,
                "push" => &self.push,
                "guess" => &self.guess,
                "present" => &self.present,
                "target" => &self.target,
                _ => &[],
            })
            .collect()
    }
}

/// Where a body is after its centre moved by so much in the frame of a push and it turned.
pub fn moved(scene: &Scene, body: usize, pose: &Pose2, push: &Push, motion: [f32; 3]) -> Pose2 {
    let [x, y, turn] = motion.map(f64::from);
    let by = push_frame(push).frame().vector(Vec2::new(x, y));
    let b = scene.body(body);
    let centre = centre_of(b, pose) + by;
    let theta = pose.theta + turn;
    let turned = Pose2::at(Vec2::zeros(), theta);
    Pose2::at(centre - turned.transform_point(b.footprint.centroid), theta)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Shape, vec2};
    use crate::scene::{BodyDef, SceneBuilder};

    fn scene() -> Scene {
        let mut builder = SceneBuilder::new();
        // Its centroid is not its origin.
        let corner = Shape::Polygon(vec![[0.0, 0.0], [0.06, 0.0], [0.06, 0.04], [0.0, 0.04]]);
        builder.add_body(BodyDef::new(corner)).unwrap();
        builder.add_body(BodyDef::new(Shape::Disc { radius: 0.02 })).unwrap();
        builder.build().unwrap()
    }

    #[test]
    fn features_turn_and_move_with_the_world() {
        let scene = scene();
        let table = ObjectTable::new(&scene);
        let state = State::new([Pose2::new(0.5, 0.1, 0.4), Pose2::new(0.6, 0.1, 0.0)]);
        let push = Push::new(vec2(0.4, 0.1), vec2(0.5, 0.12));
        let world = Pose2::new(-0.3, 0.7, 1.1);
        let elsewhere = State::new(state.iter().map(|(_, p)| world.compose(&p)));
        let there = Push::new(world.transform_point(push.start()), world.transform_point(push.end()));
        let (mut a, mut b) = (ObjectBatch::default(), ObjectBatch::default());
        a.clear(2);
        b.clear(2);
        a.add(&table, &scene, &state, &push, None, Some(1));
        b.add(&table, &scene, &elsewhere, &there, None, Some(1));
        // A disc's points are its own, so they turn with its heading; the first body's do as well.
        for (x, y) in a.outline[..64].iter().chain(&a.centre).zip(b.outline[..64].iter().chain(&b.centre)) {
            assert!((x - y).abs() < 1e-6, "{x} {y}");
        }
        assert_eq!((&a.target, &a.present), (&vec![0.0, 1.0], &vec![1.0, 1.0]));
        assert!((a.push[0] - 0.101_98).abs() < 1e-5 && a.push[1..] == [0.03, 0.022, 0.45]);
    }

    #[test]
    fn an_absent_body_is_a_row_of_zeros() {
        let scene = scene();
        let mut state = State::new([Pose2::new(0.5, 0.1, 0.4), Pose2::new(0.6, 0.1, 0.0)]);
        state.set_present(0, false);
        let mut batch = ObjectBatch::default();
        batch.clear(2);
        batch.add(&ObjectTable::new(&scene), &scene, &state, &Push::new(vec2(0.4, 0.1), vec2(0.5, 0.1)), None, Some(0));
        assert!(batch.outline[..64].iter().chain(&batch.centre[..2]).chain(&batch.body[..4]).all(|v| *v == 0.0));
        assert_eq!((batch.present, batch.target), (vec![0.0, 1.0], vec![0.0, 0.0]));
    }

    #[test]
    fn a_motion_put_back_gives_the_pose_it_was_read_from() {
        let scene = scene();
        let before = State::new([Pose2::new(0.5, 0.1, 3.0), Pose2::new(0.6, 0.1, 0.0)]);
        let after = State::new([Pose2::new(0.52, 0.13, -3.1), Pose2::new(0.6, 0.1, 0.0)]);
        let push = Push::new(vec2(0.4, 0.1), vec2(0.5, 0.12));
        let mut batch = ObjectBatch::default();
        batch.clear(2);
        batch.add(&ObjectTable::new(&scene), &scene, &before, &push, Some(&after), None);
        let motion = [batch.guess[0], batch.guess[1], batch.guess[2]];
        let (found, wanted) = (moved(&scene, 0, &before.pose(0), &push, motion), after.pose(0));
        assert!((found.position() - wanted.position()).norm() < 1e-6);
        assert!(normalize_angle(found.theta - wanted.theta).abs() < 1e-6);
    }
}
