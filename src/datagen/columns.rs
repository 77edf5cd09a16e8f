//! The columns that all kinds of data share: the bodies of a state, padded to a fixed width.

use super::scenes::WIDTH;
use super::shapes::Split;
use super::tensors::{Data, Tensor};
use crate::geom::{Footprint, Pose2};
use crate::scene::{Scene, State};

/// The bodies of a state as they are stored. What lies beyond `count` is zero.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bodies {
    count: u8,
    shape: [u16; WIDTH],
    pose: [[f32; 3]; WIDTH],
    body: [[f32; 4]; WIDTH],
    scene: i64,
    split: Split,
}

/// A body's pose with the centre of its area in place of the frame's origin.
pub(super) fn centre_pose(footprint: &Footprint, pose: &Pose2) -> Pose2 {
    Pose2::at(pose.transform_point(footprint.centroid), pose.theta)
}

/// Mass, friction with the ground, friction with a body of the same surface, height.
pub(super) fn body_row(scene: &Scene, body: usize) -> [f32; 4] {
    let b = scene.body(body);
    [b.mass, scene.friction().ground * b.friction, b.friction * b.friction, b.height].map(|v| v as f32)
}

impl Bodies {
    pub fn new(scene: &Scene, state: &State, shapes: &[u16], number: i64, split: Split) -> Bodies {
        let count = scene.len().min(WIDTH);
        let mut bodies = Bodies {
            count: count as u8,
            shape: [0; WIDTH],
            pose: [[0.0; 3]; WIDTH],
            body: [[0.0; 4]; WIDTH],
            scene: number,
            split,
        };
        for i in 0..count {
            let centre = centre_pose(&scene.body(i).footprint, &state.pose(i));
            bodies.shape[i] = shapes[i];
            bodies.pose[i] = [centre.x as f32, centre.y as f32, centre.theta as f32];
            bodies.body[i] = body_row(scene, i);
        }
        bodies
    }
}

/// Collects rows into tensors.
pub(super) struct Columns {
    pose_name: &'static str,
    n: Vec<u8>,
    shape: Vec<u16>,
    pose: Vec<f32>,
    body: Vec<f32>,
    scene: Vec<i64>,
    split: Vec<u8>,
}

impl Columns {
    /// `pose_name` is what the poses are called: `pose`, or `pose0` where there are others.
    pub fn new(pose_name: &'static str, rows: usize) -> Columns {
        Columns {
            pose_name,
            n: Vec::with_capacity(rows),
            shape: Vec::with_capacity(rows * WIDTH),
            pose: Vec::with_capacity(rows * WIDTH * 3),
            body: Vec::with_capacity(rows * WIDTH * 4),
            scene: Vec::with_capacity(rows),
            split: Vec::with_capacity(rows),
        }
    }

    pub fn push(&mut self, bodies: &Bodies) {
        self.n.push(bodies.count);
        self.shape.extend(bodies.shape);
        self.pose.extend(bodies.pose.as_flattened());
        self.body.extend(bodies.body.as_flattened());
        self.scene.push(bodies.scene);
        self.split.push(bodies.split as u8);
    }

    pub fn finish(self) -> Vec<Tensor> {
        let count = self.n.len();
        vec![
            Tensor::new("n", [count], Data::U8(self.n)),
            Tensor::new("shape", [count, WIDTH], Data::U16(self.shape)),
            Tensor::new(self.pose_name, [count, WIDTH, 3], Data::F32(self.pose)),
            Tensor::new("body", [count, WIDTH, 4], Data::F32(self.body)),
            Tensor::new("scene", [count], Data::I64(self.scene)),
            Tensor::new("split", [count], Data::U8(self.split)),
        ]
    }
}
