//! Files that the command-line tool is given: what it refuses and how it says so, and that what it writes is whole.

#[path = "common/tool.rs"]
mod tool;

use std::path::Path;
use std::process::Command;

use serde_json::Value;
use tool::{Folder, failure, jostle, stdout};

/// A run over a folder with files that cannot be used has a result, lists them and says so with its exit status.
#[test]
fn refused_files_of_a_folder_are_listed_and_counted_by_every_kind_of_run() {
    let square = r#"{"shape": {"convex_polygon": [[-0.02, -0.02], [0.02, -0.02], [0.02, 0.02], [-0.02, 0.02]]}, "pose": {"x": 0.5, "y": 0}"#;
    let kinds = [
        format!(r#"{{"version": 1, "bodies": [{square}}}], "target": 0}}"#),
        format!(r#"{{"version": 1, "bodies": [{square}}}], "clear": true}}"#),
        format!(r#"{{"version": 1, "bodies": [{square}, "goal": {{"pose": {{"x": 0.4, "y": 0}}}}}}]}}"#),
    ];
    for (k, text) in kinds.iter().enumerate() {
        let folder = Folder::new();
        for (name, text) in [
            ("a.json", text.clone()),
            ("b.JSON", format!("\u{feff}{text}")),
            ("comma.json", text.replace("}]", "},]")),
            ("half.Json", text[..30].to_owned()),
            ("empty.json", String::new()),
        ] {
            std::fs::write(folder.path(name), text).unwrap();
        }
        let suite = folder.path("");
        let options = ["--iterations", "5", "--trials", "1", "--threads", "1"];
        let judge: &[&str] = if k == 2 { &["--open-loop"] } else { &["--judge", "rapier:fast"] };
        let args = [&["run", &suite], &options[..], judge].concat();
        let output = jostle(&[&args[..], &["--json"]].concat());
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(3), "{error}");
        assert_eq!(error, "error: 3 files were refused and not run: comma, empty, half; the report has the reasons\n");
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(report["cases"].as_array().unwrap().len(), 2, "{report}");
        let refused = report["refused"].as_array().unwrap();
        let reason = |i: usize| refused[i]["reason"].as_str().unwrap();
        assert!(reason(0).contains("trailing comma (line 1, column "), "{refused:?}");
        assert!(reason(1).contains("EOF while parsing") && reason(2).contains("(line 1, column 30)"), "{refused:?}");
        let text = String::from_utf8(jostle(&args).stdout).unwrap();
        assert_eq!(text.matches("\nrefused ").count(), 3, "{text}");
        if k == 0 {
            let output = jostle(&["crosscheck", &suite, "--iterations", "5", "--json"]);
            assert_eq!(output.status.code(), Some(3), "{}", String::from_utf8_lossy(&output.stderr));
            let report: Value = serde_json::from_slice(&output.stdout).unwrap();
            assert_eq!(report["refused"].as_array().unwrap().len(), 3, "{report}");
        }

        // One file by name is read whatever its name, also through a pipe.
        let piped = Command::new("sh")
            .args(["-c", "cat \"$1\" | \"$0\" plan /dev/stdin --iterations 5 --json"])
            .args([env!("CARGO_BIN_EXE_jostle"), &folder.path("b.JSON")])
            .output()
            .unwrap();
        let plan: Value = serde_json::from_slice(&piped.stdout).unwrap();
        assert_eq!(plan["outcome"], "solved", "{plan}");
        assert_eq!(plan.get("moves").is_some(), k == 2, "a rearrangement's plan has moves");
    }
}

/// What is read ends, and what is written is whole.
#[test]
fn endless_input_is_refused_and_a_failed_write_leaves_the_old_file() {
    let folder = Folder::new();
    let scene = folder.scene("two.json");
    if Path::new("/dev/zero").exists() {
        let line = failure(2, &["plan", "/dev/zero"]);
        assert!(line.contains("/dev/zero: has more than 67108864 bytes"), "{line}");
    }
    // No file may grow beyond 1 kB: the disk is full as far as the tool can see.
    let before = std::fs::read_to_string(&scene).unwrap();
    let output = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 1; exec \"$0\" plan \"$1\" --iterations 5 --svg \"$1\""])
        .args([env!("CARGO_BIN_EXE_jostle"), &scene])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(std::fs::read_to_string(&scene).unwrap(), before);
    assert_eq!(std::fs::read_dir(folder.path("")).unwrap().count(), 1, "nothing else is left");
    assert!(stdout(&["render", &scene, "-o", "-"]).starts_with("<svg"));
}

/// Plans say what is wrong with them as scenes do: file, field, line and column.
#[test]
fn what_is_wrong_with_a_plan_has_its_field_and_place() {
    let folder = Folder::new();
    let (scene, plan, bad) = (folder.scene("two.json"), folder.path("plan.json"), folder.path("bad.json"));
    stdout(&["plan", &scene, "--iterations", "5", "--json", &plan]);
    let text = std::fs::read_to_string(&plan).unwrap();
    for (what, with, wanted) in [
        ("\"plan_version\": 1", "\"plan_version\": 2", "plan_version: is 2; this tool reads 1 (line 2, column 19)"),
        ("\"seed\": 0", "\"seed\": \"0\"", "seed: invalid type: string \"0\", expected u64 (line "),
        ("\"seed\": 0,", "", "plan: missing field `seed`"),
        ("\"version\": 1", "\"version\": 3", "problem.version: is 3; this library reads version 1 (line "),
        ("\"overlap_tolerance\": 0.006", "\"overlap_tolerance\": 9", "problem.overlap_tolerance: is 9; it must lie in"),
        ("\"outcome\": \"solved\",", "\"outcome\": \"solved\",,", "(line "),
    ] {
        assert!(text.contains(what), "{what}: {text}");
        std::fs::write(&bad, text.replacen(what, with, 1)).unwrap();
        let line = failure(2, &["render", &bad, "-o", &folder.path("x.svg")]);
        assert!(line.contains("bad.json: ") && line.contains(wanted) && line.contains("(line "), "{line}");
    }
}
