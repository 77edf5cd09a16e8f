//! Random scenes and pushes that the tests of our own engines share.

use std::sync::Arc;

use jostle::action::Push;
use jostle::geom::{Pose2, Shape, pieces_gap_below, vec2};
use jostle::run::Key;
use jostle::scene::{BodyDef, Scene, SceneBuilder, State};

pub const SIDE: f64 = 0.045;

/// Bodies of every kind: blocks, a disc, a concave one, one of many corners; masses and frictions of all sorts if wanted.
pub fn scene(bodies: usize, seed: u64, uneven: bool) -> (Arc<Scene>, State) {
    let mut random = Key::new(seed).stream();
    let ring = (0..20).map(|k| f64::from(k) * std::f64::consts::TAU / 20.0).map(|a| [0.02 * a.cos(), 0.02 * a.sin()]);
    let notch = vec![[-0.03, -0.03], [0.03, -0.03], [0.03, 0.0], [0.0, 0.0], [0.0, 0.03], [-0.03, 0.03]];
    let shapes = [
        Shape::rectangle(SIDE, SIDE),
        Shape::rectangle(2.0 * SIDE, SIDE),
        Shape::Disc { radius: SIDE / 2.0 },
        Shape::Polygon(notch),
        Shape::ConvexPolygon(ring.collect()),
    ];
    let mut builder = SceneBuilder::new();
    let mut poses: Vec<Pose2> = Vec::new();
    let mut placed = Vec::new();
    let width = 0.075 * (bodies as f64).sqrt();
    while poses.len() < bodies {
        let mut def = BodyDef::new(shapes[random.index(shapes.len())].clone());
        if uneven {
            def.mass = 0.02 * 50f64.powf(random.unit());
            def.friction = random.uniform(0.1, 1.0);
        }
        let body = jostle::scene::Body::new(def.clone()).unwrap();
        // Somewhere free; tight places are tried often.
        let found = (0..10_000).find_map(|_| {
            let pose = Pose2::new(
                0.5 + random.uniform(-width, width) / 1.6,
                random.uniform(-width, width) / 1.6,
                random.uniform(-3.1, 3.1),
            );
            let free = placed.iter().zip(&poses).all(|(other, at): (&jostle::scene::Body, _)| {
                pieces_gap_below(&body.footprint, &pose, &other.footprint, at, 0.001) >= 0.0005
            });
            free.then_some(pose)
        });
        poses.push(found.expect("there is room"));
        placed.push(body);
        builder.add_body(def).unwrap();
    }
    (Arc::new(builder.build().unwrap()), State::new(poses))
}

/// Pushes from anywhere in the scene to anywhere near: many are illegal, many start close to a body.
pub fn pushes(count: usize, seed: u64, width: f64) -> Vec<Push> {
    let mut random = Key::new(seed).child(1).stream();
    (0..count)
        .map(|_| {
            let from = vec2(0.5 + random.uniform(-width, width), random.uniform(-width, width));
            let angle = random.uniform(-3.2, 3.2);
            Push::new(from, from + vec2(angle.cos(), angle.sin()) * random.uniform(0.02, 0.12))
        })
        .collect()
}
