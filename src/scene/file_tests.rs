use super::super::workspace::{LeaveRule, LeaveScope};
use super::*;

/// The example in the documentation.
fn example() -> String {
    let docs = include_str!("../../docs/scene-format.md");
    let start = docs.find("```json\n").unwrap() + 8;
    docs[start..start + docs[start..].find("```").unwrap()].to_owned()
}

fn minimal(body: &str, rest: &str) -> String {
    format!("{{\"version\": 1, \"target\": 0,\n \"bodies\": [\n  {body}\n ]{rest}}}")
}

const CUBE: &str = r#"{"block": "cube", "pose": {"x": 0.5, "y": 0}}"#;

#[test]
fn the_documented_example_is_read() {
    let problem = Problem::from_json(&example()).unwrap();
    assert_eq!(problem.name, "three blocks");
    let scene = &problem.scene;
    let names: Vec<_> = scene.bodies().iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names, ["wanted", "concave 1", "bottle", "angle", "dumbbell"]);
    assert_eq!((problem.target, scene.body(1).mass, scene.body(2).height), (0, 0.075, 0.18));
    assert!(!scene.body(2).pickable && !scene.body(4).pushable && !problem.state.is_present(4));
    assert_eq!(scene.body(3).def().inertia, Some(0.000_08));
    assert_eq!(scene.body(4).footprint.pieces.len(), 3);
    assert_eq!((scene.gripper().grasp.opening, scene.gripper().grasp.fit), (0.085, 0.00125));
}

#[test]
fn what_is_written_is_read_back_bit_for_bit() {
    let mut problem = Problem::from_json(&example()).unwrap();
    for round in 0..200u32 {
        let again = Problem::from_json(&problem.to_json().unwrap()).unwrap();
        assert_eq!(again.scene, problem.scene);
        assert_eq!(again.state, problem.state);
        assert_eq!((&again.name, again.target), (&problem.name, problem.target));
        // Poses with all bits in use.
        let v = f64::from(round) * 0.618_033_988_749_895 % 1.0 - 0.5;
        problem.state.set_pose(4, Pose2::new(v * 1.1, v / 3.0, v * std::f64::consts::TAU));
    }
    let mut b = problem.scene.to_builder();
    b.gripper(Gripper::dissertation_mask()).workspace(Workspace {
        leave_rule: LeaveRule::Footprint,
        leave_scope: LeaveScope::TargetOnly,
        ..Workspace::default()
    });
    b.friction(Friction { ground: 0.1 + 0.2, tip: 1.0 / 3.0 }).overlap_tolerance(0.001);
    problem.scene = Arc::new(b.build().unwrap());
    let text = problem.to_json().unwrap();
    assert!(text.contains("\"gripper\": \"dissertation_mask\""), "{text}");
    let again = Problem::from_json(&text).unwrap();
    assert!(again.scene == problem.scene && again.to_json().unwrap() == text);
}

#[test]
fn what_is_written_is_easy_to_read() {
    let text = Problem::from_json(&minimal(CUBE, "")).unwrap().to_json().unwrap();
    let body = r#"    {"name": "cube 0", "block": "cube", "pose": {"x": 0.5, "y": 0.0, "theta": 0.0}}"#;
    assert_eq!(text.lines().nth(4), Some(body), "{text}");
}

/// Every way in which a text can be wrong, and what the message must say.
#[test]
fn errors_name_the_field_and_its_place() {
    let body = |fields: &str| minimal(&format!("{{{fields}}}"), "");
    let pose = r#""pose": {"x": 0.5, "y": 0}"#;
    let with = |fields: &str| body(&format!("{pose}, {fields}"));
    let mut wrong = String::new();
    let two = |second: &str| minimal(&format!("{CUBE},\n  {second}"), "");
    for (text, wanted) in [
        (String::new(), "scene: EOF while parsing a value (line 1, column 0)"),
        ("[]".into(), "scene: invalid length 0, expected an object with `version`, `bodies` and `target`"),
        ("{\"version\": 1".into(), "version: EOF while parsing an object (line 1, column 13)"),
        ("{\"version\": 2, \"new\": 3}".into(), "version: is 2; this library reads version 1 (line 1, column 13)"),
        ("{\"bodies\": []}".into(), "version: is missing; write `\"version\": 1`"),
        ("{\"version\": \"1\"}".into(), "version: invalid type: string \"1\", expected u64"),
        ("{\"version\": 1}".into(), "scene: missing field `bodies` (line 1, column 14)"),
        ("{\"version\": 1, \"bodies\": []}".into(), "scene: missing field `target`"),
        ("{\"version\": 1, \"bodies\": [], \"target\": 0}".into(), "bodies: the scene has no bodies"),
        (minimal(CUBE, ", \"colour\": 1"), "colour: unknown field `colour`, expected one of"),
        (with("\"colour\": 1"), "bodies[0].colour: unknown field `colour`, expected one of `name`, `block`"),
        (with("\"block\": \"ball\""), "bodies[0].block: no block is named `ball`; known: cube,"),
        (with("\"block\": 7"), "bodies[0].block: invalid type: integer `7`, expected a string (line 3, column 41)"),
        (body(pose), "bodies[0]: has neither a `block` nor a `shape`; give one of them (line 3, column 3)"),
        (with("\"block\": \"cube\", \"shape\": {\"disc\": {\"radius\": 1}}"), "bodies[0]: has a `block` and a `shape`"),
        (
            with("\"block\": \"cube\", \"mass\": -1"),
            "bodies[0].mass: is -1; it must lie in 1e-9 to 1000 kg (from a microgram to a tonne) (line 3, column 57)",
        ),
        (
            with("\"block\": \"cube\", \"mass\": \"1 kg\""),
            "bodies[0].mass: invalid type: string \"1 kg\", expected f64",
        ),
        (with("\"block\": \"cube\", \"mass\": 1e999"), "bodies[0].mass: number out of range"),
        (with("\"block\": \"cube\", \"height\": 0"), "bodies[0].height: is 0; it must lie in 1e-4 to 10 m"),
        (with("\"block\": \"cube\", \"friction\": 11"), "bodies[0].friction: is 11; it must lie in 0 to 10 (no"),
        (with("\"block\": \"cube\", \"inertia\": 0"), "bodies[0].inertia: is 0"),
        (with("\"block\": \"cube\", \"centre_of_mass\": [1]"), "bodies[0].centre_of_mass: invalid length 1"),
        (with("\"shape\": {\"ball\": {\"radius\": 1}}"), "bodies[0].shape.ball: unknown variant `ball`"),
        (with("\"shape\": {\"disc\": {\"radius\": 0}}"), "bodies[0].shape.disc.radius: is 0"),
        (with("\"shape\": {\"disc\": {\"radius\": 1, \"r\": 1}}"), "bodies[0].shape.disc.r: unknown field `r`"),
        (with("\"shape\": {\"polygon\": [[0, 0], [1, 0]]}"), "bodies[0].shape.polygon: has 2 corners"),
        (
            with("\"shape\": {\"compound\": [{\"shape\": {\"disc\": {\"radius\": -1}}}]}"),
            "bodies[0].shape.compound[0].disc.radius: is -1; it must lie in 6e-4 to 10 m",
        ),
        (
            with("\"shape\": {\"compound\": [{\"pose\": {\"x\": 1}, \"shape\": {\"disc\": {\"radius\": 1}}}]}"),
            "bodies[0].shape.compound[0].pose: missing field `y`",
        ),
        (body("\"block\": \"cube\""), "bodies[0]: missing field `pose`"),
        (body("\"block\": \"cube\", \"pose\": {\"x\": 1}"), "bodies[0].pose: missing field `y`"),
        (body("\"block\": \"cube\", \"pose\": {\"x\": 1, \"y\": null}"), "bodies[0].pose.y: invalid type: null"),
        (body("\"block\": \"cube\", \"pose\": {\"x\": 1, \"y\": 1, \"z\": 1}"), "bodies[0].pose.z: unknown field `z`"),
        (
            body("\"block\": \"cube\", \"pose\": {\"x\": 1, \"y\": 1e60}"),
            "bodies[0].pose.y: is 1e60; it must lie in -100 to 100 m",
        ),
        (
            two("{\"name\": \"cube 0\", \"block\": \"cube\", \"pose\": {\"x\": 1, \"y\": 0}}"),
            "bodies[1].name: `cube 0` is taken (line 4, column 12)",
        ),
        (
            two("{\"block\": \"cube\", \"pose\": {\"x\": 0.52, \"y\": 0}}"),
            "bodies[1].pose: `cube 1` overlaps `cube 0` by 25.0 mm; at most 6.0 mm is taken as measuring noise \
             (line 4, column 29)",
        ),
        (minimal(CUBE, ", \"gripper\": \"hand\""), "gripper: no gripper is named `hand`; known: robotiq_2f85"),
        (minimal(CUBE, ", \"gripper\": 1"), "gripper: invalid type: integer `1`, expected the name of a gripper or"),
        (minimal(CUBE, ", \"gripper\": {\"grasp\": {\"width\": 1}}"), "gripper.grasp.width: unknown field `width`"),
        (minimal(CUBE, ", \"gripper\": {\"grasp\": {\"opening\": 0}}"), "gripper.grasp.opening: is 0"),
        (minimal(CUBE, ", \"workspace\": {\"min\": [0, 0], \"max\": [1, 0]}"), "workspace.y: max 0 must be greater"),
        (
            minimal(CUBE, ", \"workspace\": {\"min\": [0, 0], \"max\": [1, 1], \"leave_rule\": \"some\"}"),
            "workspace.leave_rule: unknown variant `some`, expected `centre` or `footprint`",
        ),
        (minimal(CUBE, ", \"friction\": {\"ground\": -1}"), "friction.ground: is -1; it must lie in 0 to 10 (no"),
        (minimal(CUBE, ", \"overlap_tolerance\": 1"), "overlap_tolerance: is 1; it must lie in 0 to 0.05 m"),
        (minimal(CUBE, "").replace("\"target\": 0", "\"target\": 1"), "target: there is no body 1; the scene has 1"),
        (minimal(CUBE, "").replace("\"target\": 0", "\"target\": -1"), "target: invalid type: integer `-1`, expected"),
        (
            minimal(CUBE, "").replace("\"target\": 0", "\"target\": \"x\""),
            "target: no body is named `x`; the bodies are cube 0 (line 1, column 26)",
        ),
        (
            minimal(&CUBE.replace("}}", "}, \"pickable\": false}"), ""),
            "target: `cube 0` is not pickable; set its flag (line 1, column 26)",
        ),
        (minimal(&CUBE.replace("}}", "}, \"present\": false}"), ""), "target: `cube 0` is not present"),
        (with("\"block\": \"cube\", \"block\": \"cube\""), "bodies[0].block: duplicate field `block`"),
    ] {
        let error = Problem::from_json(&text).expect_err(&text).to_string();
        if !error.starts_with(wanted) {
            wrong += &format!("{text}\n got {error}\nwant {wanted}\n\n");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn files_are_written_and_read_and_errors_name_them() {
    let folder = std::env::temp_dir().join(format!("jostle-scene-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("my table.json");
    let mut problem = Problem::from_json(&minimal(CUBE, "")).unwrap();
    problem.write(&path).unwrap();
    let again = Problem::read(&path).unwrap();
    assert_eq!((again.name.as_str(), &again.state, &again.scene), ("my table", &problem.state, &problem.scene));

    std::fs::write(&path, minimal(CUBE, ", \"x\": 1")).unwrap();
    let error = Problem::read(&path).unwrap_err();
    assert!(matches!(error, Error::Format { .. }), "{error:?}");
    assert!(error.to_string().contains("my table.json: x: unknown field `x`"), "{error}");
    assert!(matches!(Problem::read(folder.join("none.json")), Err(Error::Io { .. })));
    problem.state.set_pose(0, Pose2::new(f64::NAN, 0.0, 0.0));
    assert!(problem.write(&path).unwrap_err().to_string().starts_with("poses[0]: is not finite"));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn observed_poses_replace_the_state() {
    let text = minimal(&format!("{CUBE},\n{}", CUBE.replace("0.5", "0.6")), "");
    let problem = Problem::from_json(&text).unwrap();
    let moved = problem.with_poses_json(r#"[{"x": 0.45, "y": 0.1, "theta": 0.25}, null]"#).unwrap();
    assert_eq!(moved.state.pose(0), Pose2::from(BodyPose { x: 0.45, y: 0.1, theta: 0.25 }));
    assert!(!moved.state.is_present(1) && Arc::ptr_eq(&moved.scene, &problem.scene));
    assert_eq!(problem.with_poses_json(&moved.state.to_json().unwrap()).unwrap().state, moved.state);
    for (text, wanted) in [
        ("[null]", "poses: has 1 poses for 2 bodies"),
        ("[null, {\"x\": 1, \"y\": 2}]", "target: `cube 0` is not present"),
        ("[{\"x\": 1}, null]", "poses[0]: missing field `y` (line 1, column 9)"),
        ("[{\"x\": 1, \"y\": true}, null]", "poses[0].y: invalid type: boolean `true`, expected f64"),
        ("{}", "poses: invalid type: map, expected a sequence"),
        ("[{\"x\": 1, \"y\": 2}, {\"x\": 1, \"y\": 2}]", "poses[1]: `cube 1` overlaps `cube 0`"),
    ] {
        let error = problem.with_poses_json(text).unwrap_err().to_string();
        assert!(error.starts_with(wanted), "{text}\n got {error}\nwant {wanted}");
    }
}

/// The second example in the documentation.
fn example_of_goals() -> String {
    let docs = include_str!("../../docs/scene-format.md");
    let from = docs.find("## Goals").unwrap();
    let start = from + docs[from..].find("```json\n").unwrap() + 8;
    docs[start..start + docs[start..].find("```").unwrap()].to_owned()
}

#[test]
fn the_documented_rearrangement_is_read_and_written_bit_for_bit() {
    let problem = Rearrangement::from_json(&example_of_goals()).unwrap();
    let goal = problem.goals[0].unwrap();
    assert_eq!((goal.symmetry, goal.position_tolerance, goal.pose.theta), (4, 0.005, 1.57));
    assert_eq!(problem.goals[1].unwrap().position_tolerance, 0.01);
    assert!(!problem.scene.body(1).pickable);
    let again = Rearrangement::from_json(&problem.to_json().unwrap()).unwrap();
    assert_eq!(again, problem);
    assert!(matches!(AnyProblem::from_json(&example_of_goals()), Ok(AnyProblem::Rearrangement(_))));
    assert!(matches!(AnyProblem::from_json(&example()), Ok(AnyProblem::Retrieval(_))));
}

#[test]
fn a_file_is_either_a_retrieval_or_a_rearrangement() {
    let with_goal = |rest: &str, goal: &str| {
        format!("{{\"version\": 1,{rest} \"bodies\": [\n  {{{}, \"goal\": {goal}}}]}}", &CUBE[1..CUBE.len() - 1])
    };
    let good = "{\"pose\": {\"x\": 0.4, \"y\": 0}}";
    assert!(Rearrangement::from_json(&with_goal("", good)).is_ok());
    for (error, wanted) in [
        (Problem::from_json(&with_goal(" \"target\": 0,", good)).err(), "bodies[0].goal: belongs to a rearrangement"),
        (Rearrangement::from_json(&with_goal(" \"target\": 0,", good)).err(), "target: belongs to a retrieval problem"),
        (
            Rearrangement::from_json(&minimal(CUBE, "").replace(" \"target\": 0,", "")).err(),
            "bodies: none has a `goal`",
        ),
        (
            AnyProblem::from_json(&minimal(CUBE, "").replace(" \"target\": 0,", "")).err(),
            "scene: missing field `target`",
        ),
        (
            Rearrangement::from_json(&with_goal("", "{\"pose\": {\"x\": 0.27, \"y\": 0}}")).err(),
            "bodies[0].goal: `cube 0` reaches 28.5 mm out of the workspace; move it inside (line 2, column 57)",
        ),
        (
            Rearrangement::from_json(&with_goal("", "{\"pose\": {\"x\": 0.4, \"y\": 0}, \"symmetry\": 99}")).err(),
            "bodies[0].goal.symmetry: is 99",
        ),
    ] {
        let error = error.map(|e| e.to_string()).unwrap_or_default();
        assert!(error.starts_with(wanted), "{error}\n{wanted}");
    }
}

#[test]
fn a_table_to_be_cleared_is_read_back_bit_for_bit_and_refuses_what_belongs_to_other_problems() {
    let clear = |text: &str| minimal(CUBE, "").replace(" \"target\": 0,", text);
    let problem = Clearing::from_json(&clear(" \"clear\": true,")).unwrap();
    let text = problem.to_json().unwrap();
    let AnyProblem::Clearing(again) = AnyProblem::from_json(&text).unwrap() else { panic!("{text}") };
    assert_eq!((&again.state, &*again.scene), (&problem.state, &*problem.scene));
    assert_eq!(again.to_json().unwrap(), text);
    for (error, wanted) in [
        (Clearing::from_json(&clear(" \"clear\": false,")).err(), "clear: is not true"),
        (Clearing::from_json(&clear("")).err(), "clear: is not true"),
        (
            Clearing::from_json(&clear(" \"clear\": true, \"target\": 0,")).err(),
            "target: belongs to a retrieval problem",
        ),
        (Problem::from_json(&clear(" \"clear\": true,")).err(), "clear: belongs to a clearing problem"),
        (AnyProblem::from_json(&clear(" \"clear\": false,")).err(), "scene: missing field `target`"),
        (
            Clearing::from_json(
                &clear(" \"clear\": true,")
                    .replace("\"pose\"", "\"goal\": {\"pose\": {\"x\": 0.4, \"y\": 0}}, \"pose\""),
            )
            .err(),
            "bodies[0].goal: belongs to a rearrangement",
        ),
    ] {
        let error = error.map(|e| e.to_string()).unwrap_or_default();
        assert!(error.starts_with(wanted), "{error}\n{wanted}");
    }
}
