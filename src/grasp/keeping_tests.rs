//! Grasps scored by the chance that the gripper keeps them.

use std::sync::Arc;

use super::*;
use crate::action::Grasp;
use crate::geom::{Pose2, Shape};
use crate::scene::generate::{Generator, GeneratorParams};
use crate::scene::{BodyDef, Gripper, Keeping, Problem, Scene, SceneBuilder, State};

fn alone(def: BodyDef, gripper: Gripper) -> (Scene, State) {
    let mut builder = SceneBuilder::new();
    builder.add_body(def).unwrap();
    builder.gripper(gripper);
    (builder.build().unwrap(), State::new([Pose2::new(0.5, 0.1, 0.3)]))
}

fn half_cube() -> BodyDef {
    BodyDef::new(Shape::rectangle(0.0225, 0.045))
}

fn best(def: BodyDef, gripper: Gripper) -> Grasp {
    let (scene, state) = alone(def, gripper);
    let test = GraspTest::new(GraspParams::default()).unwrap();
    test.best(&scene, &state, 0, &mut GraspScratch::default()).unwrap()
}

#[test]
fn a_half_cube_is_gripped_across_its_long_side_square() {
    let by_shape = best(half_cube(), Gripper::robotiq_2f85());
    assert!((by_shape.width - 0.0225).abs() < 1e-6, "{by_shape:?}");
    let kept = best(half_cube(), Gripper::robotiq_2f85_kept());
    assert!((kept.width - 0.045).abs() < 1e-6 && kept.score > 0.9, "{kept:?}");
    // What is flat is kept less surely, what is high no less.
    let of_height = |height| best(BodyDef { height, ..half_cube() }, Gripper::robotiq_2f85_kept()).score;
    assert!(of_height(0.0235) < kept.score - 0.2 && of_height(0.07) >= kept.score);
}

#[test]
fn the_features_of_a_grasp_are_those_of_the_eye() {
    let (scene, state) = alone(half_cube(), Gripper::robotiq_2f85());
    let test = GraspTest::new(GraspParams::default()).unwrap();
    let features = |x: f64, y: f64, angle: f64| {
        let at = Pose2::new(0.5, 0.1, 0.3).transform_point(crate::geom::vec2(x, y));
        let grasp = Grasp { body: 0, position: [at.x, at.y], angle: 0.3 + angle, opening: 0.0807, ..Grasp::default() };
        test.features(&scene, &state, &grasp, &mut GraspScratch::default())
    };
    let square = features(0.0, 0.0, 0.0).unwrap();
    for (found, wanted) in [
        (square.width, 0.0225),
        (square.touch, 0.022),
        (square.turn, 0.0),
        (square.end, 0.0225),
        (square.clearance, 0.0807 / 2.0 - 0.01125),
        (square.height, 0.045),
        (square.mass, 0.1),
    ] {
        // Poses are kept in single precision.
        assert!((found - wanted).abs() < 1e-7, "{found} {wanted}: {square:?}");
    }
    // Off the middle both ways: less room on one side, an end between the pads.
    let off = features(0.005, 0.02, 0.0).unwrap();
    assert!((off.clearance - square.clearance + 0.005).abs() < 1e-7 && (off.end - 0.0025).abs() < 1e-7, "{off:?}");
    assert!((off.touch - 0.0135).abs() < 1e-7, "{off:?}");
    // Turned by 30 degrees a face's 2 mm are 2 / tan 30 long.
    let turned = features(0.0, 0.0, 30f64.to_radians()).unwrap();
    assert!(
        (turned.turn - 30f64.to_radians()).abs() < 1e-6 && (turned.touch - 0.002 / 0.57735).abs() < 1e-4,
        "{turned:?}"
    );
    assert!(features(0.0, 0.04, 0.0).is_none(), "nothing between the pads");
}

/// In clutter too the best grasp's score is what an examination of that grasp says, and no grasp of the test's own kind
/// that an examination allows scores more.
#[test]
fn the_best_grasp_scores_what_its_examination_says() {
    let generator = Generator::new(GeneratorParams { bodies: 4..=7, ..GeneratorParams::default() }, 9).unwrap();
    let (test, mut scratch, mut found) = (GraspTest::new(GraspParams::default()).unwrap(), GraspScratch::default(), 0);
    for index in 0..12 {
        let Problem { scene, state, .. } = generator.problem(index).unwrap();
        let mut builder = scene.to_builder();
        builder.gripper(Gripper::robotiq_2f85_kept());
        let scene = Arc::new(builder.build().unwrap());
        let prepared = test.prepared(&scene);
        for body in 0..scene.len() {
            let Some(grasp) = prepared.best(&scene, &state, body, &mut scratch) else { continue };
            assert_eq!(Some(grasp), test.best(&scene, &state, body, &mut scratch), "prepared or not");
            let check = test.check(&scene, &state, &grasp, &mut scratch);
            assert!(check.margin > -1e-9, "{check:?}");
            let chance = check.chance.unwrap();
            assert!((grasp.score - chance).abs() < 1e-6, "{index} {body}: {grasp:?} {check:?}");
            assert!(grasp.score <= prepared.greatest_score(&scene, body).unwrap() + 1e-9);
            found += 1;
        }
    }
    assert!(found > 20, "{found}");
}

#[test]
fn a_grasp_that_is_not_allowed_has_a_chance_but_no_score() {
    let (scene, state) = alone(half_cube(), Gripper::robotiq_2f85_kept());
    let test = GraspTest::new(GraspParams::default()).unwrap();
    // A finger comes down on the body.
    let at = Pose2::new(0.5, 0.1, 0.3).transform_point(crate::geom::vec2(0.032, 0.0));
    let grasp = Grasp { body: 0, position: [at.x, at.y], angle: 0.3, opening: 0.0807, ..Grasp::default() };
    let check = test.check(&scene, &state, &grasp, &mut GraspScratch::default());
    assert!(!check.holds() && check.score == 0.0);
    assert!(check.chance.is_some_and(|chance| chance > 0.0 && chance < 0.8), "{check:?}");
    let far = Grasp { position: [0.9, 0.9], ..grasp };
    let check = test.check(&scene, &state, &far, &mut GraspScratch::default());
    assert_eq!((check.limit, check.chance), (Limit::Missing, Some(0.0)));
}

#[test]
fn what_was_prepared_for_another_model_is_not_used() {
    let (scene, state) = alone(half_cube(), Gripper::robotiq_2f85_kept());
    let test = GraspTest::new(GraspParams::default()).unwrap().prepared(&scene);
    let mut other = Keeping::robotiq_2f85();
    other.bias -= 1.0;
    let mut builder = scene.to_builder();
    builder.gripper(Gripper { keeping: Some(other), ..Gripper::robotiq_2f85_kept() });
    let other = builder.build().unwrap();
    let mut scratch = GraspScratch::default();
    let best = |scene: &Scene, scratch: &mut GraspScratch| test.best(scene, &state, 0, scratch).unwrap().score;
    assert!(best(&other, &mut scratch) < best(&scene, &mut scratch));
}
