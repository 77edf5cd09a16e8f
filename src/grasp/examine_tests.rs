use super::*;
use crate::action::Grasp;
use crate::geom::{Pose2, Shape, normalize_angle, vec2};
use crate::scene::generate::{Generator, GeneratorParams};
use crate::scene::{BodyDef, Gripper, Problem, Scene, SceneBuilder, State};

fn test() -> GraspTest {
    GraspTest::new(GraspParams::default()).unwrap()
}

/// Squares of 40 mm, the last of which is not pickable.
fn squares(gripper: Gripper, poses: &[Pose2]) -> (Scene, State) {
    let mut builder = SceneBuilder::new();
    builder.gripper(gripper);
    for i in 0..poses.len() {
        let def = BodyDef { pickable: i == 0 || i + 1 < poses.len(), ..BodyDef::new(Shape::rectangle(0.04, 0.04)) };
        builder.add_body(def.named(format!("body {i}"))).unwrap();
    }
    (builder.build().unwrap(), State::new(poses.iter().copied()))
}

fn examine(scene: &Scene, state: &State, body: usize, x: f64, y: f64, angle: f64, opening: f64) -> GraspExamination {
    let grasp = Grasp { body, position: [x, y], angle, opening, ..Grasp::default() };
    test().examine(scene, state, &grasp, &mut GraspScratch::default()).unwrap()
}

#[test]
fn every_condition_is_told_with_its_room_and_what_to_change() {
    let (scene, state) = squares(
        Gripper::robotiq_2f85(),
        &[Pose2::new(0.5, 0.0, 0.0), Pose2::new(0.5, 0.06, 0.0), Pose2::new(0.7, 0.0, 0.0)],
    );
    let quarter = std::f64::consts::FRAC_PI_2;
    let at = |x: f64, y: f64, angle: f64, opening: f64| examine(&scene, &state, 0, x, y, angle, opening);
    let good = at(0.5, 0.0, 0.0, 0.0);
    let spares = good.spares.unwrap();
    assert!(good.allowed && good.grasp.opening == 0.0807 && (good.grasp.width - 0.04).abs() < 1e-7, "{good:?}");
    // Poses are of single precision.
    assert!(
        (spares.fit - (0.02035 - 0.00125)).abs() < 1e-6 && spares.cover > 0.009 && spares.opening == 0.0,
        "{spares:?}"
    );
    assert!((good.grasp.margin - spares.fit.min(spares.cover).min(spares.finger).min(spares.between)).abs() < 1e-12);
    assert_eq!((spares.finger_body, good.chance, good.depth), (Some(1), None, None));
    assert!(good.reason(&scene).starts_with("it is allowed; the least spare room is "), "{}", good.reason(&scene));
    for (wanted, examination, says) in [
        (Limit::Missing, at(0.9, 0.0, 0.0, 0.0), "no part of `body 0` is between the pads"),
        (Limit::Opening, at(0.5, 0.0, 0.0, 0.09), "the opening of 90.00 mm is more than the gripper's 80.70 mm"),
        (
            Limit::Width,
            at(0.5, 0.0, 0.0, 0.04),
            "`body 0` is 40.00 mm wide here, and an opening of 40.00 mm takes 37.50",
        ),
        (Limit::Finger { body: 0 }, at(0.525, 0.0, 0.0, 0.0), "a finger comes down on `body 0` itself"),
        (Limit::Finger { body: 1 }, at(0.5, 0.0, quarter, 0.0), "a finger is "),
        (Limit::Cover, at(0.5, -0.026, 0.0, 0.0), "the pads cover 7.00 mm less of `body 0` than the 12.00 mm"),
        (Limit::NotPickable, examine(&scene, &state, 2, 0.7, 0.0, 0.0, 0.0), "`body 2` is not pickable"),
    ] {
        let reason = examination.reason(&scene);
        assert!(!examination.allowed && examination.limit == wanted, "{wanted:?}: {examination:?}");
        assert!(examination.grasp.score == 0.0 && reason.starts_with(says), "{wanted:?}: {reason}");
    }
    let missing = at(0.9, 0.0, 0.0, 0.0);
    assert_eq!((missing.spares, missing.features, missing.grasp.margin), (None, None, f64::NEG_INFINITY));
    // One beside it, by whose side the pads' ends close.
    let (scene, state) = squares(Gripper::robotiq_2f85(), &[Pose2::new(0.5, 0.0, 0.0), Pose2::new(0.5, 0.041, 0.0)]);
    let beside = examine(&scene, &state, 0, 0.5, 0.018, 0.0, 0.0);
    assert!(!beside.allowed && beside.limit == Limit::Jaw { body: 1 }, "{beside:?}");
    assert!(
        (beside.spares.unwrap().between + 0.005).abs() < 1e-6 && beside.spares.unwrap().finger > 0.01,
        "{beside:?}"
    );
    let reason = beside.reason(&scene);
    assert!(reason.starts_with("`body 1` reaches 5.00 mm into the space between the fingers"), "{reason}");
    // A triangle by its legs.
    let corners = vec![[0.0225, 0.045], [-0.0225, 0.0], [0.0225, -0.045]];
    let mut builder = SceneBuilder::new();
    builder.add_body(BodyDef::new(Shape::ConvexPolygon(corners)).named("wedge")).unwrap();
    let (scene, state) = (builder.build().unwrap(), State::new([Pose2::new(0.5, 0.0, 0.0)]));
    let steep = examine(&scene, &state, 0, 0.492, 0.0, quarter, 0.0);
    assert!(!steep.allowed && steep.limit == Limit::Wedge && steep.spares.unwrap().wedge < 0.0, "{steep:?}");
    assert!(steep.reason(&scene).starts_with("the gripped faces are 90.0 degrees out of parallel"));
    assert_eq!(steep.spares.unwrap().finger, f64::INFINITY);
}

#[test]
fn what_cannot_be_asked_is_refused_by_name() {
    let (scene, mut state) = squares(Gripper::robotiq_2f85(), &[Pose2::new(0.5, 0.0, 0.0), Pose2::new(0.6, 0.0, 0.0)]);
    state.set_present(1, false);
    let good = Grasp { body: 0, position: [0.5, 0.0], ..Grasp::default() };
    for (grasp, says) in [
        (Grasp { body: 2, ..good }, "grasp.body: is 2, but the scene has 2 bodies"),
        (Grasp { body: 1, ..good }, "grasp.body: `body 1` is not present"),
        (Grasp { position: [f64::NAN, 0.0], ..good }, "grasp.position[0]: is NaN"),
        (Grasp { angle: f64::INFINITY, ..good }, "grasp.angle: is inf"),
        (Grasp { opening: -0.01, ..good }, "grasp.opening: is -0.01"),
        (Grasp { opening: f64::NAN, ..good }, "grasp.opening: is NaN"),
    ] {
        let error = test().examine(&scene, &state, &grasp, &mut GraspScratch::default()).unwrap_err().to_string();
        assert!(error.starts_with(says), "{error}");
    }
    for (body, says) in [(2, "grasp.body: is 2"), (1, "grasp.body: `body 1` is not present")] {
        let error = test().best_apart(&scene, &state, body, 3, &mut GraspScratch::default()).unwrap_err().to_string();
        assert!(error.starts_with(says), "{error}");
    }
}

fn problems(gripper: &Gripper) -> Vec<Problem> {
    let generator = Generator::new(GeneratorParams { bodies: 3..=7, ..GeneratorParams::default() }, 21).unwrap();
    let with = |index| {
        let mut problem = generator.problem(index).unwrap();
        problem.scene = std::sync::Arc::new(problem.scene.with_gripper(gripper.clone()).unwrap());
        problem
    };
    (0..8).map(with).collect()
}

fn turned_apart(a: f64, b: f64) -> f64 {
    (0.5 * normalize_angle(2.0 * (a - b))).abs()
}

/// The first is the best of all; every entry is what an examination of it says, to the bit; all are allowed, sorted and
/// unlike each other.
#[test]
fn a_list_is_sorted_apart_and_says_what_examinations_say() {
    let (mut lists, mut entries) = (0, 0);
    for gripper in [Gripper::robotiq_2f85(), Gripper::robotiq_2f85_kept(), Gripper::dissertation_mask()] {
        for problem in problems(&gripper) {
            let (scene, state, mut scratch) = (&*problem.scene, &problem.state, GraspScratch::default());
            let prepared = test().prepared(scene);
            for body in 0..scene.len() {
                let list = prepared.best_apart(scene, state, body, 12, &mut scratch).unwrap();
                let best = prepared.best(scene, state, body, &mut scratch);
                assert_eq!(best.is_some(), !list.is_empty());
                if let (Some(best), Some(first)) = (best, list.first()) {
                    let same =
                        |a: &Grasp, b: &Grasp| (a.position, a.angle, a.opening) == (b.position, b.angle, b.opening);
                    assert!(same(&best, &first.grasp), "{best:?} {first:?}");
                    assert!((best.score - first.grasp.score).abs() < 1e-6, "{best:?} {first:?}");
                    lists += 1;
                }
                assert_eq!(list, test().best_apart(scene, state, body, 12, &mut GraspScratch::default()).unwrap());
                assert_eq!(
                    list[..list.len().min(2)],
                    prepared.best_apart(scene, state, body, 2, &mut scratch).unwrap()
                );
                for (i, entry) in list.iter().enumerate() {
                    assert!(entry.allowed && entry.grasp.margin >= 0.0, "{entry:?}");
                    assert_eq!(entry, &prepared.examine(scene, state, &entry.grasp, &mut scratch).unwrap());
                    for before in &list[..i] {
                        let off = vec2(entry.grasp.position[0], entry.grasp.position[1])
                            - vec2(before.grasp.position[0], before.grasp.position[1]);
                        let turn = turned_apart(entry.grasp.angle, before.grasp.angle);
                        assert!(off.norm() >= APART.0 || turn >= APART.1, "{entry:?} {before:?}");
                        assert!(before.grasp.score >= entry.grasp.score - 1e-6, "{entry:?} {before:?}");
                    }
                    if let Some(chance) = entry.chance {
                        assert!(entry.grasp.score == chance && entry.depth.is_some());
                    }
                    entries += 1;
                }
                assert!(prepared.best_apart(scene, state, body, 0, &mut scratch).unwrap().is_empty());
            }
        }
    }
    assert!(lists > 60 && entries > 4 * lists, "{lists} {entries}");
}

/// A scene that was moved and turned as a whole has the same list, but for what single precision does to poses: grasps of
/// nearly one score may change places, so scores are compared by rank, and the first grasp where it is alone at the top.
#[test]
fn a_list_moves_and_turns_with_its_scene() {
    let (motion, mut alone) = (Pose2::new(0.11, -0.07, 2.3), 0);
    for problem in problems(&Gripper::robotiq_2f85()) {
        let (scene, state, mut scratch) = (&*problem.scene, &problem.state, GraspScratch::default());
        let moved = State::new(state.iter().map(|(_, pose)| motion.compose(&pose)));
        let prepared = test().prepared(scene);
        for body in 0..scene.len() {
            let here = prepared.best_apart(scene, state, body, 6, &mut scratch).unwrap();
            let there = prepared.best_apart(scene, &moved, body, 6, &mut scratch).unwrap();
            assert_eq!(here.is_empty(), there.is_empty(), "{} {body}", problem.name);
            let (Some(a), Some(b)) = (here.first(), there.first()) else { continue };
            assert!((a.grasp.score - b.grasp.score).abs() < 1e-3, "{a:?} {b:?}");
            let ahead = |list: &[GraspExamination]| {
                list.get(1).is_none_or(|next| list[0].grasp.score - next.grasp.score > 0.01)
            };
            if ahead(&here) && ahead(&there) {
                let wanted = motion.transform_point(vec2(a.grasp.position[0], a.grasp.position[1]));
                let off = (wanted - vec2(b.grasp.position[0], b.grasp.position[1])).norm();
                let turn = turned_apart(a.grasp.angle + motion.theta, b.grasp.angle);
                assert!(off < 1e-5 && turn < 1e-5, "{a:?} {b:?}");
                assert!((a.grasp.margin - b.grasp.margin).abs() < 1e-5, "{a:?} {b:?}");
                alone += 1;
            }
        }
    }
    assert!(alone > 8, "{alone}");
}

/// Everything half as large: the same list, half as far apart.
#[test]
fn a_list_is_apart_in_proportion_to_the_gripper() {
    let gripper = Gripper::robotiq_2f85().scaled(0.5);
    let mut builder = SceneBuilder::new();
    builder.gripper(gripper);
    builder.add_body(BodyDef::new(Shape::rectangle(0.02, 0.045))).unwrap();
    let small = (builder.build().unwrap(), State::new([Pose2::new(0.25, 0.0, 0.3)]));
    let mut builder = SceneBuilder::new();
    builder.add_body(BodyDef::new(Shape::rectangle(0.04, 0.09))).unwrap();
    let large = (builder.build().unwrap(), State::new([Pose2::new(0.5, 0.0, 0.3)]));
    let list =
        |(scene, state): &(Scene, State)| test().best_apart(scene, state, 0, 9, &mut GraspScratch::default()).unwrap();
    let (small, large) = (list(&small), list(&large));
    assert!(large.len() > 3 && small.len() == large.len(), "{} {}", small.len(), large.len());
    for (a, b) in small.iter().zip(&large) {
        assert!((a.grasp.score - b.grasp.score).abs() < 1e-6, "{a:?} {b:?}");
        assert!((2.0 * a.grasp.position[0] - b.grasp.position[0]).abs() < 1e-6, "{a:?} {b:?}");
    }
}
