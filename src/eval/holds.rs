//! Whether a commanded grasp holds at given poses.

use crate::action::Grasp;
use crate::geom::{Obb, vec2};
use crate::scene::{Scene, State};

/// The open fingers come down on nothing, and the body lies between the pads.
pub fn holds(scene: &Scene, state: &State, grasp: &Grasp) -> bool {
    let jaw = &scene.gripper().grasp;
    let axis = vec2(grasp.angle.cos(), grasp.angle.sin());
    let centre = vec2(grasp.position[0], grasp.position[1]);
    let half = [jaw.finger_thickness / 2.0, jaw.finger_width / 2.0];
    let offset = (grasp.opening + jaw.finger_thickness) / 2.0;
    let free = [-offset, offset].into_iter().all(|d| {
        let finger = Obb { centre: centre + axis * d, axis, half };
        state.iter().all(|(i, pose)| finger.gap_to(&scene.body(i).footprint, &pose) >= 0.0)
    });
    let between = Obb { centre, axis, half: [grasp.opening / 2.0, half[1]] };
    free && between.gap_to(&scene.body(grasp.body).footprint, &state.pose(grasp.body)) < 0.0
}
