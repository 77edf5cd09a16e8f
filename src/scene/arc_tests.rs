use super::super::testing::shared;
use super::*;
use crate::geom::pieces_gap;

const LINE: &str = "cube.urdf 0.3 0.4 0.6 0.5 0.0 0.0235 0 0 0.1";

fn parsed(text: &str) -> Result<ArcCase> {
    parse(text, "test", ArcProfile::More, BlockConvention::TrueCentroid)
}

#[test]
fn a_case_has_names_poses_and_the_profile() {
    let text = format!("{LINE}\n\n  half-cube 1 1 1 4.0e-01 -1e-1 0.0235 1e-4 -1e-4 -3.0 \r\n");
    let case = parsed(&text).unwrap();
    let Problem { name, scene, state, target } = &case.problem;
    assert_eq!((name.as_str(), *target, scene.len()), ("test", 0, 2));
    assert_eq!((scene.body(0).name.as_str(), scene.body(1).name.as_str()), ("cube 0", "half_cube 1"));
    assert_eq!(state.pose(1), State::new([Pose2::new(0.4, -0.1, -3.0)]).pose(0));
    assert_eq!((scene.friction().ground, scene.body(1).mass, case.push_length()), (1.1, 0.1, 0.10));
    assert_eq!((scene.workspace().min, scene.workspace().max), ([0.276, -0.224], [0.724, 0.224]));

    let pmbs = parse(LINE, "", ArcProfile::Pmbs, BlockConvention::Simulator).unwrap();
    let scene = &pmbs.problem.scene;
    let block = scene.body(0).friction;
    for (got, want) in
        [(block * block, 0.3), (block * scene.friction().ground, 0.7), (block * scene.friction().tip, 0.45)]
    {
        assert!((got - want).abs() < 1e-12);
    }
    assert_eq!((scene.workspace().min, scene.workspace().max), ([0.356, -0.144], [0.644, 0.144]));
    assert_eq!((pmbs.push_length(), scene.body(0).mass, scene.body(0).centre_of_mass), (0.05, 0.05, vec2(0.0, 0.0)));
}

#[test]
fn errors_name_the_line_and_the_column() {
    let wrong = |from: &str, to: &str| format!("{LINE}\n\n{}", LINE.replace("0.5 0.0", "0.6 0.1").replace(from, to));
    for (text, wanted) in [
        (String::new(), "bodies: the scene has no bodies"),
        (wrong("cube", "sphere"), "line 3: mesh: no block is named `sphere`; known: cube, half_cube"),
        (wrong(" 0 0 0.1", " 0 0"), "line 3: has 9 columns; 10 are needed: mesh r g b x y z roll pitch yaw"),
        (wrong("0.1", "0.1 1"), "line 3: has 12 columns"),
        (wrong("0.0235", "NaN"), "line 3: z: is NaN; it must be a finite number"),
        (wrong("0.6", "1e999"), "line 3: b: is 1e999; it must be a finite number"),
        (wrong("0 0 0.1", "0 zero 0.1"), "line 3: pitch: `zero` is not a number"),
        (wrong("0.0235", "0.07"), "line 3: the `cube` hangs 48 mm above the table, so it rests on another body"),
        (wrong("0.0235", "0.0"), "line 3: the `cube` reaches 22 mm below the table; check z"),
        (format!("{LINE}\n{LINE}"), "line 2: `cube 1` overlaps `cube 0` by 45.0 mm"),
    ] {
        let error = parsed(&text).unwrap_err().to_string();
        assert!(error.starts_with(wanted), "{text}\n got {error}\nwant {wanted}");
    }
    let error = read("/no/such/file.txt", ArcOptions::default()).unwrap_err();
    assert!(matches!(error, Error::Io { .. }), "{error:?}");
}

#[test]
fn the_folder_tells_the_profile() {
    assert_eq!(ArcProfile::of_path("cases/confined/test01.txt"), ArcProfile::Pmbs);
    assert_eq!(ArcProfile::of_path("cases/hard/confined.txt"), ArcProfile::More);
    assert_eq!(ArcProfile::of_path("test01.txt"), ArcProfile::More);
}

#[test]
fn the_original_cases_are_read() {
    let Some(cases) = shared("data/cases/arc") else { return };
    let mut count = 0;
    let mut laid_down = Vec::new();
    for suite in ["simple", "hard", "confined"] {
        for entry in std::fs::read_dir(cases.join(suite)).unwrap() {
            let path = entry.unwrap().path();
            let which = format!("{suite}/{}", path.file_stem().unwrap().to_string_lossy());
            let result = read(&path, ArcOptions::default());
            if which == "simple/testo09" {
                let error = result.unwrap_err().to_string();
                assert!(error.ends_with(
                    "testo09.txt: line 4: the `cylinder` hangs 27 mm above the table, so it rests on another body; a \
                     planar scene has no place for it"
                ), "{error}");
                continue;
            }
            let case = result.unwrap_or_else(|e| panic!("{e}"));
            count += 1;
            assert_eq!(case.profile == ArcProfile::Pmbs, suite == "confined");
            let Problem { scene, state, .. } = &case.problem;
            for (i, pose) in state.iter() {
                assert!(scene.workspace().holds(&scene.body(i).footprint, &pose), "{which} {i}");
                for (j, other) in state.iter().filter(|(j, _)| *j > i) {
                    let gap = pieces_gap(&scene.body(i).footprint, &pose, &scene.body(j).footprint, &other);
                    let most = if case.laid_down.is_empty() { 0.002 } else { 0.005 };
                    assert!(gap > -most, "{which}: {i} and {j} overlap by {:.2} mm", -gap * 1e3);
                }
            }
            if !case.laid_down.is_empty() {
                laid_down.push((which, case.laid_down.clone()));
            }
            // A case survives being written as a scene file.
            let again = Problem::from_json(&case.problem.to_json().unwrap()).unwrap();
            assert!(again.scene == case.problem.scene && again.state == case.problem.state);
        }
    }
    assert!(count >= 30, "{count} cases");
    laid_down.sort();
    let wanted = [("confined/test11", 0), ("hard/test04", 0), ("simple/testo07", 3), ("simple/testo08", 2)];
    assert_eq!(laid_down, wanted.map(|(case, body)| (case.to_owned(), vec![body])));
}

#[test]
fn laid_down_bodies_of_the_original_cases_have_their_silhouettes() {
    let Some(cases) = shared("data/cases/arc") else { return };
    let read = |case: &str| read(cases.join(case), ArcOptions::default()).unwrap().problem;
    let side = read("simple/testo07.txt");
    let concave = side.scene.body(3);
    assert!((concave.footprint.area - 0.09 * 0.045).abs() < 1e-9 && concave.height == 0.045);
    let target = read("hard/test04.txt");
    assert_eq!(target.scene.body(0).def(), library::block("half_cube").unwrap().named("half_cube 0"));
    // Upside down, the notch is where y is negative in the block's frame.
    let over = read("simple/testo08.txt");
    let (pose, body) = (over.state.pose(2), over.scene.body(2));
    assert!(!body.footprint.contains(&pose, pose.transform_point(vec2(0.0, -0.01))));
    assert!(body.footprint.contains(&pose, pose.transform_point(vec2(0.0, 0.01))));
}
