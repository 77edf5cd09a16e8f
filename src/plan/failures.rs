//! What was tried and failed, where the bodies are: it is not offered again, also where the scene was made anew.

use crate::action::Push;
use crate::scene::{Body, Scene, State};

/// By how much a grasp has to score better than one that failed.
pub(super) const BETTER: f64 = 0.02;
/// A push that starts this near (metres, for the published gripper) to one that failed, and runs within this angle (its
/// cosine), is the same.
const SAME_PUSH: (f64, f64) = (0.006, 0.985);
/// A body whose area and radius of gyration differ by no more than this share may be one seen before: an outline from a
/// camera is never the same twice.
const ALIKE: f64 = 0.15;

/// Pushes that failed since the bodies were last moved; a [`super::Retrieval`] does not propose them again.
#[derive(Debug, Clone, Default)]
pub struct FailedPushes(Vec<Push>);

impl FailedPushes {
    pub fn add(&mut self, push: Push) {
        self.0.push(push);
    }

    pub fn clear(&mut self) {
        self.0.clear();
    }

    pub fn count(&self) -> u64 {
        self.0.len() as u64
    }

    /// Takes out of the pushes those that failed. `scale` is that of the gripper ([`crate::scene::Gripper::scale`]).
    pub fn take_out(&self, scale: f64, pushes: &mut Vec<Push>) {
        if !self.0.is_empty() {
            pushes.retain(|push| !self.0.iter().any(|failed| same_push(push, failed, scale * SAME_PUSH.0)));
        }
    }
}

fn same_push(a: &Push, b: &Push, near: f64) -> bool {
    (a.start() - b.start()).norm() <= near && a.direction().dot(&b.direction()) >= SAME_PUSH.1
}

/// Which body of an earlier look this one is: the nearest that is alike and lies within its radius and `moved` (metres) of
/// where this one is.
pub(super) fn seen_before(before: (&Scene, &State), now: (&Scene, &State), body: usize, moved: f64) -> Option<usize> {
    let (place, is) = (now.1.pose(body).position(), now.0.body(body));
    let far = is.footprint.radius + moved;
    let distance = |i: usize| (before.1.pose(i).position() - place).norm();
    (0..before.0.len())
        .filter(|&i| before.1.is_present(i) && alike(before.0.body(i), is) && distance(i) <= far)
        .min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
}

fn alike(a: &Body, b: &Body) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= ALIKE * a.max(b);
    let (a, b) = (&a.footprint, &b.footprint);
    near(a.area, b.area) && near(a.gyration_squared.sqrt(), b.gyration_squared.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Pose2, Shape};
    use crate::scene::{BodyDef, SceneBuilder};

    fn scene(sides: &[[f64; 2]]) -> Scene {
        let mut builder = SceneBuilder::new();
        for side in sides {
            builder.add_body(BodyDef::new(Shape::rectangle(side[0], side[1]))).unwrap();
        }
        builder.build().unwrap()
    }

    #[test]
    fn a_push_that_failed_is_known_again_from_a_little_beside() {
        let push = |x: f64, y: f64, angle: f64| {
            let (s, c) = angle.sin_cos();
            Push { start: [x, y], end: [x + 0.1 * c, y + 0.1 * s], ..Push::default() }
        };
        let mut failed = FailedPushes::default();
        let mut pushes = vec![push(0.5, 0.0, 0.3), push(0.503, 0.002, 0.4), push(0.51, 0.0, 0.3), push(0.5, 0.0, 0.6)];
        failed.take_out(1.0, &mut pushes);
        assert_eq!((pushes.len(), failed.count()), (4, 0));
        failed.add(push(0.5, 0.0, 0.3));
        failed.take_out(1.0, &mut pushes);
        assert_eq!(pushes, [push(0.51, 0.0, 0.3), push(0.5, 0.0, 0.6)]);
        failed.take_out(2.0, &mut pushes);
        assert_eq!(pushes, [push(0.5, 0.0, 0.6)], "a gripper twice the size has steps twice as long");
    }

    #[test]
    fn a_body_is_known_again_by_its_outline_and_place() {
        let before = scene(&[[0.04, 0.04], [0.04, 0.06], [0.04, 0.0402]]);
        let seen = State::new([Pose2::new(0.5, 0.0, 0.0), Pose2::new(0.51, 0.0, 0.0), Pose2::new(0.6, 0.0, 0.0)]);
        let now = scene(&[[0.0401, 0.0399]]);
        let known = |x: f64, moved: f64| {
            let state = State::new([Pose2::new(x, 0.0, 0.2)]);
            seen_before((&before, &seen), (&now, &state), 0, moved)
        };
        assert_eq!((known(0.511, 0.0), known(0.59, 0.0)), (Some(0), Some(2)));
        assert_eq!((known(0.4, 0.0), known(0.4, 0.1)), (None, Some(0)), "too far, but for a push between the looks");
        assert_eq!(known(0.56, 0.1), Some(2), "of two the nearer");
    }
}
