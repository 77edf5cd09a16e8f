use std::path::Path;
use std::sync::Arc;

use super::super::testing::Slide;
use super::*;
use crate::error::Result;
use crate::geom::Pose2;
use crate::grasp::{GraspParams, GraspScratch, GraspTest};
use crate::scene::Gripper;

const BODIES: &str = r#""bodies": [
    {"shape": "cube", "mass": 0.1, "height": 0.045, "pose": [0.5, 0, 0, 0.0225, 0],
     "pieces": [[[-0.0225, -0.0225], [0.0225, -0.0225], [0.0225, 0.0225], [-0.0225, 0.0225]]]},
    {"shape": "cube", "mass": 0.1, "height": 0.045, "pose": [0.5, 0.12, 0, 0.0225, 0],
     "pieces": [[[-0.0225, -0.0225], [0.0225, -0.0225], [0.0225, 0.0225], [-0.0225, 0.0225]]]}]"#;

fn grasp() -> String {
    let rest = r#""target": 0, "grasp": [0.5, 0, 0], "proposer": "jostle", "held": true, "in_hand_at_home": false, "success": false"#;
    format!(r#"{{"id": "a/0", "split": "fit", {BODIES}, {rest}}}"#).replace('\n', " ")
}

fn push() -> String {
    let rest = r#""command": [0.4, 0, 0.48, 0], "aborted": false, "after": [[0.52, 0, 0, 0.0225, 0], [0.5, 0.12, 0, 0.0225, 0]]"#;
    let friction = r#""friction": {"body": 0.5, "table": 1.1, "finger_pad": 0.9}"#;
    format!(r#"{{"id": "b/0", "split": "report", {BODIES}, {rest}, {friction}}}"#).replace('\n', " ")
}

fn read(text: &str) -> Result<RobotRecords> {
    let mut records = RobotRecords::default();
    records.add(Path::new("robot.jsonl"), text)?;
    Ok(records)
}

#[test]
fn a_line_is_a_grasp_or_a_push_by_what_it_holds() {
    let records = read(&format!("{}\n\n{}\n", push(), grasp())).unwrap();
    assert_eq!((records.grasps.len(), records.pushes.len()), (1, 1));
    let fit = records.clone().of_split("fit");
    assert_eq!((fit.grasps.len(), fit.pushes.len()), (1, 0));
    let attempt = &records.grasps[0];
    assert!(attempt.went_well(GraspOutcome::Kept) && !attempt.went_well(GraspOutcome::Counted));
    let refused = read(&grasp().replace(r#""held": true"#, r#""held": null"#)).unwrap();
    assert!(!refused.grasps[0].went_well(GraspOutcome::Kept), "it was not in the hand at home");

    let problem = attempt.problem(&Gripper::robotiq_2f85()).unwrap();
    let test = GraspTest::new(GraspParams::default()).unwrap();
    let grasp = attempt.grasp(&Gripper::robotiq_2f85());
    let check = test.check(&problem.scene, &problem.state, &grasp, &mut GraspScratch::default());
    assert!(check.holds() && (check.width - 0.045).abs() < 1e-9, "{check:?}");
}

#[test]
fn a_bad_line_is_named_with_its_field() {
    for (text, wanted) in [
        (grasp().replace("\"target\": 0", "\"target\": 2"), "target: is 2; there are 2 bodies, counted from 0"),
        (
            grasp().replace("\"held\": true, \"in_hand_at_home\": false", "\"held\": null"),
            "held: is null and `in_hand_at_home` is missing",
        ),
        (grasp().replacen("\"mass\": 0.1", "\"mass\": -1", 1), "bodies[0].mass: is -1"),
        (grasp().replacen("\"height\": 0.045", "\"height\": \"tall\"", 1), "bodies[0].height: invalid type"),
        (grasp().replacen("[[-0.0225, -0.0225], [0.0225, -0.0225],", "[", 1), "bodies[0].pieces"),
        (grasp().replace("[0.5, 0, 0], \"prop", "[0.5, 0, 1e9], \"prop"), "grasp: is 1e9"),
        (push().replace("\"command\": [0.4,", "\"command\": [4e9,"), "command: is 4e9"),
        (push().replace("\"table\": 1.1", "\"table\": -1"), "friction.table: is -1"),
        (push().replace("[[0.52, 0, 0, 0.0225, 0], ", "["), "after: has 1 poses for 2 bodies"),
        (push().replace("\"command\"", "\"comand\""), "neither `grasp` nor `command`"),
        (push().replace("\"aborted\": false", "\"grasp\": [0, 0, 0]"), "stands beside `command`"),
        ("[1, 2]".to_string(), "neither `grasp` nor `command`"),
        ("{".to_string(), "EOF while parsing"),
    ] {
        let error = read(&format!("{}\n{text}", push())).unwrap_err().to_string();
        assert!(error.contains("robot.jsonl") && error.contains("line 2") && error.contains(wanted), "{error}");
    }
    assert!(read("\n").unwrap_err().to_string().contains("holds no recorded grasps or pushes"));
}

#[test]
fn reliability_by_hand() {
    let scores = [(0.9, true), (0.9, false), (0.2, false), (1.0, true), (0.1, true)];
    let found = grasp_reliability(&scores, 0.5).unwrap();
    assert_eq!((found.count, found.held), (5, 3));
    assert!((found.accuracy - 0.6).abs() < 1e-12);
    // Of the six pairs the score puts 0.9 and 1.0 above 0.2, 1.0 above 0.9; one is of equals, two are wrong.
    assert!((found.auc.unwrap() - 3.5 / 6.0).abs() < 1e-12, "{found:?}");
    let wanted = -(0.9f64.ln() + 0.1f64.ln() + 0.8f64.ln() + (1.0 - 1e-6f64).ln() + 0.1f64.ln()) / 5.0;
    assert!((found.log_loss - wanted).abs() < 1e-12, "{found:?}");
    let band = found.bands[9];
    assert_eq!((band.count, band.held), (3, 2));
    assert_eq!(found.bands.iter().map(|b| b.count).collect::<Vec<_>>(), [0, 1, 1, 0, 0, 0, 0, 0, 0, 3]);
    assert!(grasp_reliability(&[(0.4, true)], 0.5).unwrap().auc.is_none());
    assert!(grasp_reliability(&[(f64::NAN, true)], 0.5).unwrap_err().to_string().contains("scores: one is NaN"));
}

#[test]
fn pushes_are_compared_where_bodies_moved() {
    let text = format!("{}\n{}\n", push(), push().replace("\"aborted\": false", "\"aborted\": true"));
    let records = read(&text).unwrap();
    let slide = |by: f64| {
        push_accuracy(&records.pushes, &Gripper::robotiq_2f85(), &|scene| {
            Ok(Arc::new(Slide { scene, offset: Pose2::new(by, 0.0, 0.0) }))
        })
    };
    let found = slide(0.017).unwrap();
    assert_eq!((found.count, found.left_out, found.moved, found.engine.as_str()), (1, 1, 1, "slide"));
    assert!((found.median_position_mm - 3.0).abs() < 1e-4, "{found:?}");
    assert!((slide(0.0).unwrap().median_position_mm - 20.0).abs() < 1e-4);
}
