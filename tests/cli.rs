//! The command-line tool as its users see it: reports, exit status, error lines, and the help in `docs/cli.md`.

#[path = "common/tool.rs"]
mod tool;

use std::path::Path;

use serde_json::Value;
use tool::{Folder, failure, jostle, json, shared, stdout};

#[test]
fn a_plan_is_told_written_and_drawn() {
    let folder = Folder::new();
    let (scene, svg, plan) = (folder.scene("two.json"), folder.path("plan.svg"), folder.path("plan.json"));
    let text = stdout(&["plan", &scene, "--iterations", "20", "--threads", "1", "--svg", &svg, "--json", &plan]);
    assert!(text.contains("outcome solved") && text.contains("1. grasp \"body 0\""), "{text}");
    assert!(std::fs::read_to_string(&svg).unwrap().starts_with("<svg"));
    let document: Value = serde_json::from_str(&std::fs::read_to_string(&plan).unwrap()).unwrap();
    assert_eq!(document["outcome"], "solved");
    assert_eq!(document["actions"][0]["kind"], "grasp");
    assert_eq!(document["actions"][0]["predicted"][0], Value::Null, "the target is gone");
    assert_eq!(document["problem"]["target"], "body 0");
    let hash = document["hash"].clone();
    assert_eq!(json(&["plan", &scene, "--iterations", "20", "--threads", "3", "--json"])["hash"], hash);

    let (again, drawn) = (folder.path("again.svg"), folder.path("scene.svg"));
    stdout(&["render", &plan, "-o", &again]);
    assert_eq!(std::fs::read_to_string(&svg).unwrap(), std::fs::read_to_string(&again).unwrap());
    stdout(&["render", &scene, "--output", &drawn]);
    assert!(std::fs::read_to_string(&drawn).unwrap().starts_with("<svg"));
}

#[test]
fn grasps_are_listed_examined_and_drawn() {
    let folder = Folder::new();
    let (scene, svg, list) = (folder.scene("two.json"), folder.path("grasps.svg"), folder.path("grasps.json"));
    let text = stdout(&["grasps", &scene, "--k", "3", "--svg", &svg, "--json", &list]);
    assert!(
        text.contains("gripper robotiq_2f85") && text.contains("chance") && text.contains("\n3. it is allowed"),
        "{text}"
    );
    assert!(std::fs::read_to_string(&svg).unwrap().matches("score ").count() >= 3);
    let report: Value = serde_json::from_str(&std::fs::read_to_string(&list).unwrap()).unwrap();
    let grasps = report["grasps"].as_array().unwrap();
    assert_eq!((grasps.len(), &report["target"]), (3, &"body 0".into()));
    // The first is what the planner does, and each is what an examination of it says, to the bit.
    let plan = json(&["plan", &scene, "--iterations", "20", "--threads", "1", "--json"]);
    assert_eq!(
        (&plan["actions"][0]["position"], &plan["actions"][0]["angle"]),
        (&grasps[0]["position"], &grasps[0]["angle"])
    );
    let place = |g: &Value| format!("{},{},{}", g["position"][0], g["position"][1], g["angle"]);
    let places: Vec<String> = grasps.iter().map(place).collect();
    let again = json(&["grasps", &scene, "--at", &places[0], "--at", &places[1], "--at", &places[2], "--json"]);
    assert_eq!(again["grasps"], report["grasps"]);
    for field in ["width", "margin", "score", "wedge", "spares", "features"] {
        assert!(!grasps[0][field].is_null(), "{field}");
    }
    assert!(grasps[0]["chance"].is_null() && grasps[0]["features"]["touch"].is_number());
    let kept = json(&["grasps", &scene, "--gripper", "robotiq_2f85_kept", "--target", "1", "--k", "1", "--json"]);
    assert_eq!((&kept["target"], kept["grasps"].as_array().unwrap().len()), (&"body 1".into(), 1));
    assert_eq!(kept["grasps"][0]["chance"], kept["grasps"][0]["score"]);

    let far = stdout(&["grasps", &scene, "--at", "-0.9,0,0"]);
    assert!(far.contains("no: nothing between") && far.contains("no part of `body 0` is between the pads"), "{far}");
}

#[test]
fn a_run_reports_every_named_number() {
    let folder = Folder::new();
    folder.scene("a.json");
    let suite = folder.path("");
    let args = ["run", &suite, "--iterations", "20", "--trials", "2", "--seed", "3", "--threads", "1", "--json", "-"];
    let report = json(&args);
    let case = &report["cases"][0];
    assert_eq!(case["name"], "a");
    assert_eq!(case["trials"].as_array().unwrap().len(), 2);
    assert_eq!(case["trials"][0]["decisions"][0]["action"]["kind"], "grasp");
    for number in ["mean_actions", "completion"] {
        assert!(case[number].is_number(), "{number}");
    }
    assert_eq!(report["refused"], Value::Array(Vec::new()));
    let total = &report["total"];
    assert_eq!(total["completion"], 1.0);
    for path in [
        "/mean_actions",
        "/actions_per_success",
        "/grasp_success",
        "/decisions",
        "/decision_ms/median",
        "/decision_ms/p99",
        "/decision_ms/max",
        "/planning_s_per_case/mean",
    ] {
        assert!(total.pointer(path).is_some_and(Value::is_number), "{path}: {total}");
    }
    let configuration = &report["configuration"];
    assert_eq!(configuration["planner"], "hedge");
    assert_eq!(configuration["gripper"], "robotiq_2f85");
    assert_eq!((&configuration["seed"], &configuration["trials"]), (&3.into(), &2.into()));
    assert_eq!(configuration["budget"]["iterations"], 20);
    assert_eq!(configuration["physics"]["preset"], "fast");
    let judge = if cfg!(feature = "bullet") { ["bullet", "reference"] } else { ["rapier", "fine"] };
    assert_eq!(configuration["judge"]["physics"]["engine"], judge[0]);
    assert_eq!(configuration["judge"]["physics"]["preset"], judge[1]);
    assert_eq!(configuration["judge"]["friction_spread"], 0.2);
    assert_eq!(configuration["judge"]["noise_position_m"], 0.001);
    assert_eq!(configuration["version"], env!("CARGO_PKG_VERSION"));
    assert!(report["machine"]["cores"].is_number());

    let text = stdout(&args[..10]);
    assert!(text.contains("total") && !text.contains("refused"), "{text}");
}

#[test]
fn a_run_with_a_budget_of_iterations_is_the_same_again() {
    let run = |threads: &str| {
        let mut report = json(&[
            "run",
            "--suite",
            "generated:1:4",
            "--iterations",
            "10",
            "--trials",
            "1",
            "--max-actions",
            "2",
            "--threads",
            threads,
            "--lanes",
            "4",
            "--gripper",
            "dissertation_mask",
            "--judge",
            "rapier:fast",
            "--friction-spread",
            "0.1",
            "--noise-mm",
            "0.5",
            "--noise-deg",
            "0.5",
            "--profile",
            "pmbs",
            "--json",
        ]);
        assert_eq!(report["configuration"]["gripper"], "dissertation_mask");
        assert_eq!(report["configuration"]["push_length"], 0.05);
        let decisions = report["cases"][0]["trials"][0]["decisions"].as_array_mut().unwrap();
        for decision in &mut *decisions {
            decision["milliseconds"] = Value::Null;
        }
        assert!(!decisions.is_empty());
        Value::Array(decisions.clone())
    };
    assert_eq!(run("1"), run("2"));
}

#[test]
fn generated_problems_can_be_read_again() {
    let folder = Folder::new();
    let out = folder.path("made");
    let args = ["generate", &out, "--count", "2", "--bodies", "4..6", "--profile", "more", "--seed", "5", "--json"];
    let report = json(&args);
    let files = report["files"].as_array().unwrap();
    assert_eq!(files.len(), 2);
    for file in files {
        assert!((4..=6).contains(&file["bodies"].as_u64().unwrap()));
        let path = file["file"].as_str().unwrap();
        let first = std::fs::read_to_string(path).unwrap();
        stdout(&["render", path, "-o", &folder.path("x.svg")]);
        stdout(&args);
        assert_eq!(first, std::fs::read_to_string(path).unwrap(), "the same seed writes the same file");
    }
}

#[test]
fn mistakes_end_with_status_2_and_one_line() {
    let folder = Folder::new();
    let scene = folder.scene("two.json");
    let broken = folder.path("broken.json");
    std::fs::write(&broken, "{\"version\": 1,\n \"bodies\": [}").unwrap();
    let empty = folder.path("empty");
    std::fs::create_dir(&empty).unwrap();
    for (args, wanted) in [
        (&[][..], "error: a command is missing; see --help"),
        (&["plan"], "error: the following required arguments were not provided: <SCENE>; see --help"),
        (&["plan", "no such.json"], "no such.json: "),
        (&["plan", &broken], "line 2"),
        (&["plan", &scene, "--planner", "best"], "planner: no planner is named `best`; known: hedge, pmbs, mcts"),
        (&["plan", &scene, "--physics", "box"], "physics.engine: no engine is named `box`"),
        (&["plan", &scene, "--preset", "finest"], "physics.preset: planar has no preset `finest`"),
        (&["plan", &scene, "--gripper", "hand"], "gripper: no gripper is named `hand`"),
        (&["plan", &scene, "--seconds", "0"], "seconds: is 0; it must be greater than 0"),
        (&["plan", &scene, "--iterations", "0"], "iterations: is 0"),
        (&["plan", &scene, "--seconds", "soon"], "invalid value 'soon' for '--seconds <SECONDS>'"),
        (&["plan", &scene, "--colour"], "unexpected argument '--colour' found"),
        (&["grasps", &scene, "--k", "0"], "k: is 0"),
        (&["grasps", &scene, "--target", "cup"], "target: no body has the number or name `cup`; known: "),
        (&["grasps", &scene, "--at", "1,2"], "2 numbers; write X,Y,ANGLE as three"),
        (&["grasps", &scene, "--at", "nan,0,0"], "grasp.position[0]: is NaN"),
        (&["run", &empty], "holds no scenes"),
        (&["run", "generated:none"], "generated:none: N is not a count"),
        (&["run", &scene, "--noise-mm", "-1"], "judge.noise_position_m"),
        (&["run", &scene, "--trials", "0"], "trials: is 0"),
        (&["run", &scene, "--judge", "rapier:finest"], "judge.physics.preset"),
        (&["generate", &empty, "--bodies", "9..5"], "9..5 is no range of body counts"),
        (&["fidelity", &scene], "line 1"),
        (&["bench", "push", &scene], "line 1"),
        (&["render", &scene], "--output <FILE>"),
    ] {
        let line = failure(2, args);
        assert!(line.contains(wanted), "{args:?}: {line}");
    }
    let line = failure(1, &["render", &scene, "-o", &folder.path("no/such/folder.svg")]);
    assert!(line.contains("folder.svg"), "{line}");
}

#[test]
fn recorded_pushes_are_compared() {
    let folder = Folder::new();
    let pushes = folder.path("pushes.jsonl");
    let square = "[[[-0.02,-0.02],[0.02,-0.02],[0.02,0.02],[-0.02,0.02]]]";
    let line = format!(
        r#"{{"id":"a","case":"x","push":[0.44,0,0.49,0],"tip":{{"w":0.03,"t":0.022}},"shapes":[{{"pieces":{square},"mass":0.1,"izz":3e-5}}],"before":[[0.5,0,0]],"after":[[0.521,0,0]]}}"#
    );
    std::fs::write(&pushes, format!("{line}\n")).unwrap();
    let report = json(&["fidelity", &pushes, "--preset", "balanced", "--json"]);
    for path in [
        "/moved/mean_iou",
        "/moved/median_position_mm",
        "/moved/p90_position_mm",
        "/moved/median_rotation_deg",
        "/all/mean_iou",
        "/count",
    ] {
        assert!(report.pointer(path).is_some_and(Value::is_number), "{path}: {report}");
    }
    assert_eq!((&report["pushes"], &report["count"]), (&1.into(), &1.into()));
    assert!(report["moved"]["mean_iou"].as_f64().unwrap() > 0.8, "{report}");
    let line = failure(2, &["fidelity", &pushes, "--against", "fresh"]);
    assert!(line.contains("none of them can be compared with"), "{line}");

    let bench = json(&["bench", "push", &pushes, "--seconds", "0.01", "--json"]);
    for preset in ["fast", "balanced", "fine"] {
        let rates = &bench["presets"][preset];
        for name in ["pushes_per_second_1_thread", "pushes_per_second_2_threads"] {
            assert!(rates[name].as_f64().unwrap() > 0.0, "{rates}");
            assert!(rates["by_bodies"]["1"][name].as_f64().unwrap() > 0.0, "{rates}");
        }
    }
}

#[test]
fn the_search_benchmark_reports_every_number() {
    let folder = Folder::new();
    let scene = folder.scene("two.json");
    let few = ["--planners", "pmbs,untangle,greedy", "--bodies", "5", "--each", "8"];
    let report =
        json(&[&["bench", "search", &scene, "--decisions", "5", "--iterations", "5", "--json"], &few[..]].concat());
    for path in [
        "/bookkeeping/pmbs/us_per_simulation",
        "/bookkeeping/mcts/us_per_simulation",
        "/deadline/overrun_ms/p50_ms",
        "/deadline/overrun_ms/p99_ms",
        "/deadline/overrun_ms/max_ms",
        "/cancel/p99_ms",
        "/cancel/max_ms",
        "/first_plan/process_ms/p50_ms",
    ] {
        assert!(report.pointer(path).is_some_and(Value::is_number), "{path}: {report}");
    }
    assert_eq!(report["same_plan"]["equal"], true);
}

#[test]
fn the_originals_agree_as_far_as_they_are_here() {
    if let Some(pushes) = shared("fidelity/pybullet_pushes.jsonl") {
        let report = json(&["fidelity", &pushes, "--json"]);
        assert!(report["moved"]["mean_iou"].as_f64().unwrap() > 0.7, "{report}");
    }
    if let Some(case) = shared("cases/arc/hard/test01.txt") {
        let plan = json(&["plan", &case, "--iterations", "30", "--json"]);
        assert_eq!(plan["problem"]["name"], "test01");
        assert!(!plan["actions"].as_array().unwrap().is_empty());
    }
    if let Some(case) = shared("cases/arc/simple/testo09.txt") {
        let line = failure(2, &["plan", &case]);
        assert!(line.contains("rests on another body"), "{line}");
    }
}

/// Two squares that change places, one of them to be dragged.
fn exchange(folder: &Folder) -> String {
    let square = r#""shape": {"convex_polygon": [[-0.03, -0.03], [0.03, -0.03], [0.03, 0.03], [-0.03, 0.03]]}"#;
    let text = format!(
        r#"{{"version": 1, "bodies": [
            {{"name": "a", {square}, "pose": {{"x": 0.2, "y": 0.2}}, "goal": {{"pose": {{"x": 0.4, "y": 0.2}}}}}},
            {{"name": "b", {square}, "pickable": false, "pose": {{"x": 0.4, "y": 0.2}},
              "goal": {{"pose": {{"x": 0.2, "y": 0.2}}}}}}],
            "workspace": {{"min": [0, 0], "max": [0.78, 0.52]}}}}"#
    );
    let path = folder.path("exchange.json");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn a_rearrangement_is_planned_drawn_and_run() {
    let folder = Folder::new();
    let scene = exchange(&folder);
    let (plan, still, moving) = (folder.path("plan.json"), folder.path("a.svg"), folder.path("b.svg"));
    let planned = stdout(&["plan", &scene, "--iterations", "50", "--json", &plan, "--svg", &still]);
    assert!(planned.contains("outcome solved") && planned.contains("passes the check"), "{planned}");
    let document: Value = serde_json::from_str(&std::fs::read_to_string(&plan).unwrap()).unwrap();
    assert_eq!(document["rearrange_plan_version"], 1);
    let moves = document["moves"].as_array().unwrap();
    assert!(moves.len() >= 3 && moves.iter().any(|m| m["kind"] == "drag" && m["name"] == "b"), "{document}");
    assert!(std::fs::read_to_string(&still).unwrap().contains("exchange: start"));
    stdout(&["render", &plan, "-o", &moving, "--animated"]);
    assert!(std::fs::read_to_string(&moving).unwrap().contains("<animateTransform"));
    stdout(&["render", &scene, "-o", &still]);
    for planner in ["untangle", "hbfs"] {
        let args =
            ["run", &scene, "--planner", planner, "--iterations", "50", "--trials", "2", "--open-loop", "--json"];
        let report = json(&args);
        assert_eq!(report["completion"], 1.0, "{report}");
        assert_eq!((&report["invalid"], &report["cases"][0]["name"]), (&Value::from(0), &Value::from("exchange")));
    }
    let wrong = failure(2, &["plan", &scene, "--planner", "nobody"]);
    assert!(wrong.contains("planner: there is no `nobody`"), "{wrong}");
}

#[test]
fn generated_rearrangements_are_the_same_for_a_seed_and_can_be_read() {
    let folder = Folder::new();
    let make = |name: &str| {
        let to = folder.path(name);
        stdout(&["generate", "rearrange", &to, "-n", "1", "--level", "easy", "--seed", "3"]);
        std::fs::read_to_string(Path::new(&to).join("rearrange-3-00.json")).unwrap()
    };
    let first = make("one");
    assert_eq!(first, make("two"));
    let report = json(&["run", &folder.path("one"), "--iterations", "64", "--trials", "1", "--open-loop", "--json"]);
    assert_eq!(report["completion"], 1.0, "{report}");
    let wrong = failure(2, &["generate", "rearrange", &folder.path("x"), "--level", "odd"]);
    assert!(wrong.contains("invalid value 'odd'"), "{wrong}");
}

#[test]
fn the_suite_of_rearrangements_is_the_folder_of_its_files() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/suites/rearrange");
    let options = ["--iterations", "1", "--planner", "hbfs", "--trials", "1", "--max-actions", "1", "--json"];
    let names = |suite: &str| -> Vec<String> {
        let report = json(&[&["run", "--suite", suite], &options[..]].concat());
        report["cases"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap().to_owned()).collect()
    };
    let built_in = names("rearrange");
    assert_eq!(built_in.len(), 40);
    assert_eq!(built_in, names(folder));
}

#[test]
fn a_table_is_cleared_drawn_run_and_generated_again() {
    let folder = Folder::new();
    let made =
        json(&["generate", "clear", &folder.path("made"), "--kind", "packed", "-n", "1", "--seed", "3", "--json"]);
    let scene = made["files"][0].as_str().unwrap().to_owned();
    let again =
        json(&["generate", "clear", &folder.path("again"), "--kind", "packed", "-n", "1", "--seed", "3", "--json"]);
    let read = |path: &str| std::fs::read_to_string(path).unwrap();
    assert_eq!(read(&scene), read(again["files"][0].as_str().unwrap()));
    assert!(read(&scene).contains("\"clear\": true"), "{}", read(&scene));

    let (picture, plan_file) = (folder.path("plan.svg"), folder.path("plan.json"));
    let text = stdout(&["plan", &scene, "--threads", "0", "--svg", &picture, "--json", &plan_file]);
    assert!(text.contains("to be taken off the table") && text.contains("search  greedy, seed 0"), "{text}");
    assert!(read(&picture).starts_with("<svg "));
    let (drawn, table) = (folder.path("drawn.svg"), folder.path("table.svg"));
    stdout(&["render", &plan_file, "-o", &drawn]);
    assert_eq!(read(&drawn), read(&picture), "a written plan is drawn as the plan itself");
    stdout(&["render", &scene, "-o", &table]);
    assert!(read(&table).starts_with("<svg "));

    let run = |planner: &str| {
        json(&["run", &scene, "--planner", planner, "--judge", "fast", "--trials", "1", "--threads", "1", "--json"])
    };
    let report = run("greedy");
    for field in ["completion", "nothing_left", "grasp_success", "efficiency", "actions", "taken", "runs"] {
        assert!(report["total"][field].is_number(), "{field}: {}", report["total"]);
    }
    assert_eq!(report["cases"][0]["trials"][0]["actions"], report["total"]["actions"]);
    assert_eq!(
        (&report["confirm"]["engine"], &report["judge"]["physics"]["engine"]),
        (&"prism".into(), &"rapier".into())
    );
    assert_eq!(run("grasp_only")["total"]["pushes"], 0);
    let error = failure(2, &["run", &scene, "--planner", "oracle"]);
    assert!(error.contains("no planner of clearings is named `oracle`"), "{error}");
}

#[test]
fn the_suites_of_tables_are_the_folders_of_their_files() {
    for name in ["clear-random", "clear-packed"] {
        let folder = format!("{}/suites/{name}", env!("CARGO_MANIFEST_DIR"));
        let run = |suite: &str| {
            let report = json(&[
                "run",
                suite,
                "--planner",
                "grasp_only",
                "--judge",
                "fast",
                "--trials",
                "1",
                "--max-actions",
                "1",
                "--json",
            ]);
            let names = report["cases"].as_array().unwrap().iter().map(|c| (c["name"].clone(), c["bodies"].clone()));
            names.collect::<Vec<_>>()
        };
        let (own, files) = (run(name), run(&folder));
        assert_eq!(own, files);
        assert_eq!(own.len(), if name == "clear-random" { 30 } else { 10 });
    }
}

#[test]
fn path_queries_are_written_once_and_answered_the_same() {
    let folder = Folder::new();
    let file = folder.path("queries.json");
    let lengths = || json(&["bench", "path", &file, "-n", "12", "--rounds", "1", "--json"])["lengths"].clone();
    let first = lengths();
    assert_eq!(first.as_array().unwrap().len(), 12);
    assert_eq!(first, lengths());
}

#[test]
fn the_image_benchmark_finds_what_it_drew() {
    let report = json(&["bench", "image", "-n", "2", "--rounds", "1", "--json"]);
    for time in ["crop_us", "labels_us", "shapes_ms", "matching_ms"] {
        assert!(report[time].as_f64().unwrap() > 0.0, "{time}: {report}");
    }
    assert_eq!((report["in_images"].as_u64(), report["shapes_found"].as_u64()), (Some(20), Some(20)), "{report}");
    assert_eq!((report["wrong"].as_u64(), report["missed"].as_u64()), (Some(0), Some(0)), "{report}");
}

#[test]
fn a_scene_is_observed_as_an_image() {
    let folder = Folder::new();
    stdout(&["generate", &folder.path("scenes"), "--count", "1", "--seed", "3"]);
    let scene = std::fs::read_dir(folder.path("scenes")).unwrap().next().unwrap().unwrap().path();
    let (scene, image) = (scene.to_str().unwrap().to_owned(), folder.path("image.pgm"));
    stdout(&["observe", &scene, "-o", &image]);
    let labels = std::fs::read(&image).unwrap();
    assert!(labels.starts_with(b"P5\n224 224\n255\n") && labels.len() == 15 + 224 * 224);
    stdout(&["observe", &scene, "-o", &image, "--image", "heights", "--crop", "112", "--heading", "-0.3"]);
    let heights = std::fs::read(&image).unwrap();
    assert!(heights.starts_with(b"P5\n112 112\n65535\n") && heights.len() == 17 + 2 * 112 * 112);
    // The middle of the crop is the target, 45 mm high.
    let at = 17 + 2 * (56 * 112 + 56);
    assert_eq!(u16::from_be_bytes([heights[at], heights[at + 1]]), 450);
}

#[test]
fn a_list_of_experiments_becomes_a_document_and_goes_on_where_it_ended() {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.path("suite")).unwrap();
    folder.scene("suite/two.json");
    let row = |id: &str, planner: &str, more: &str| {
        format!(
            "[[row]]\nid = \"{id}\"\nsection = \"s\"\nsuite = \"two\"\nplanner = \"{planner}\"\ntrials = 2\nseconds = 1\n\
             options = \"--iterations 20 --judge rapier\"\n{more}\n"
        )
    };
    let list = format!(
        "[[suite]]\nid = \"two\"\npath = \"{}\"\nof = 3\n[[suite]]\nid = \"away\"\npath = \"{}\"\n\
         [[section]]\nid = \"s\"\ntitle = \"Two\"\nkind = \"retrieval\"\n\
         [[plot]]\nid = \"p\"\nsection = \"s\"\ntitle = \"Two\"\nx = \"n\"\ny = \"actions\"\n{}{}{}",
        folder.path("suite"),
        folder.path("away"),
        row("a", "mcts", "published = { of = \"X\", actions = 1.25 }\npoint = { series = \"a\", x = 20 }"),
        row("b", "no_such_planner", ""),
        row("c", "mcts", "").replace("suite = \"two\"", "suite = \"away\""),
    );
    let (file, document) = (folder.path("list.toml"), folder.path("RESULTS.md"));
    std::fs::write(&file, &list).unwrap();
    let (kept, plots) = (folder.path("kept"), folder.path("plots"));
    let args = |more: &[&'static str]| -> Vec<String> {
        let own = ["results", "--list", &file, "-o", &document, "--kept", &kept, "--plots", &plots];
        own.into_iter().chain(more.iter().copied()).map(String::from).collect()
    };
    let run = |more: &[&'static str]| {
        let args = args(more);
        let output = jostle(&args.iter().map(String::as_str).collect::<Vec<_>>());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let (plan, _) = run(&["--dry-run"]);
    assert!(plan.contains("2 rows to measure") && plan.contains("the suite away is not here"), "{plan}");
    assert!(!Path::new(&document).exists());

    let (_, progress) = run(&[]);
    assert!(progress.contains("a: actions 1.00, completed 100 %") && progress.contains("[2/2]"), "{progress}");
    let text = std::fs::read_to_string(&document).unwrap();
    assert!(text.contains("1 of 3 rows are measured") && text.contains("| X | 1.00 | 1.25 | 100 % |"), "{text}");
    assert!(text.contains("*not available: planner: no planner is named `no_such_planner`"), "{text}");
    assert!(std::fs::read_to_string(folder.path("plots/p.svg")).unwrap().starts_with("<svg"));

    // The row that is there is kept; the one that was refused is tried again.
    let (_, progress) = run(&[]);
    assert!(progress.contains("1 rows to measure") && progress.contains("[1/1] b: not available"), "{progress}");
    assert_eq!(std::fs::read_to_string(&document).unwrap(), text);
    std::fs::remove_file(&document).unwrap();
    run(&["--document"]);
    assert!(std::fs::read_to_string(&document).unwrap().contains("| X | 1.00 | 1.25 | 100 % |"));

    std::fs::write(&file, list.replace("trials = 2", "trials = true")).unwrap();
    let args = args(&[]);
    let line = failure(2, &args.iter().map(String::as_str).collect::<Vec<_>>());
    assert!(line.ends_with("list.toml: row `a`: trials: is true or false; it must be a number"), "{line}");
}

/// `docs/cli.md` is this text; run with `UPDATE_DOCS=1` to write it anew.
#[test]
fn the_document_holds_the_help() {
    let mut document = String::from(
        "# The command-line tool\n\nThe output of `jostle --help` and of `jostle COMMAND --help` (generated; a test \
         checks it).\n\nExit status: 0 for a result (a problem without a solution is one), 2 for a mistake in the \
         arguments or the files, 1\nfor a failure, 3 for a result of a folder some of whose files were refused (the report \
         lists each with its reason).\nMistakes, failures and refusals say one line on standard error.\n\nA file is known \
         by its content, whatever its name, and `/dev/stdin` is one. Of a folder the files named `.json` or\n`.txt`, in \
         letters of either case, are meant. A run is of problems of one kind: rearrangements where there are any,\nelse \
         tables to be cleared, else retrieval problems; the others are refused. At most 64 MiB are read of a file. A\n\
         file is written whole or not at all; `-` is standard output.\n",
    );
    let commands = [
        "",
        "plan",
        "grasps",
        "run",
        "results",
        "generate",
        "generate rearrange",
        "fidelity",
        "bench push",
        "bench search",
        "bench path",
        "bench image",
        "bench net",
        "assess chain",
        "assess grasp",
        "assess robot",
        "fit grasp",
        "render",
        "datagen push",
        "datagen ppn",
        "datagen grasp",
        "datagen segment",
        "observe",
        "model",
    ];
    for command in commands {
        let words: Vec<&str> = command.split_whitespace().chain(["--help"]).collect();
        let title = ["jostle", command].join(" ");
        document.push_str(&format!("\n## {}\n\n```text\n{}\n```\n", title.trim(), stdout(&words).trim_end()));
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/cli.md");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, document).unwrap();
        return;
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(written == document, "docs/cli.md is out of date: run UPDATE_DOCS=1 cargo test --features cli --test cli");
}

/// What the Makefile sets a variable to, as words.
fn make_variable(name: &str) -> Vec<String> {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Makefile")).unwrap();
    let value = text.lines().find_map(|line| line.strip_prefix(&format!("{name} ?= ")));
    value.unwrap_or_else(|| panic!("the Makefile sets no {name}")).split_whitespace().map(String::from).collect()
}

#[test]
fn the_demo_is_solved_by_two_pushes_and_its_picture_is_that_of_the_readme() {
    let folder = Folder::new();
    let (scenes, picture) = (folder.path("scenes"), folder.path("demo.svg"));
    let (generated, planned) = (make_variable("DEMO_SCENE"), make_variable("DEMO_PLAN"));
    let words = |extra: &[&str], set: &[String]| -> Vec<String> {
        extra.iter().map(|w| w.to_string()).chain(set.iter().cloned()).collect()
    };
    let run = |args: Vec<String>| stdout(&args.iter().map(String::as_str).collect::<Vec<_>>());
    run(words(&["generate", &scenes], &generated));
    let scene = std::fs::read_dir(&scenes).unwrap().next().unwrap().unwrap().path().to_string_lossy().into_owned();
    let text = run(words(&["plan", &scene, "--svg", &picture], &planned));
    assert!(text.contains("outcome solved") && text.contains("search  hedge,"), "{text}");
    let plan: Value = serde_json::from_str(&run(words(&["plan", &scene, "--json", "-"], &planned))).unwrap();
    let kinds: Vec<_> = plan["actions"].as_array().unwrap().iter().map(|a| a["kind"].as_str().unwrap()).collect();
    assert_eq!((plan["outcome"].as_str(), &kinds[..]), (Some("solved"), &["push", "push", "grasp"][..]));

    let captions = |path: &Path| -> Vec<String> {
        let text = std::fs::read_to_string(path).unwrap();
        text.lines().filter(|line| line.starts_with("<text x=\"0\"")).map(String::from).collect()
    };
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/img/demo.svg");
    assert_eq!(
        captions(&committed),
        captions(Path::new(&picture)),
        "docs/img/demo.svg is another plan; `make demo` draws it"
    );
}
