//! The calls of tests/capi/bad_input.c that follow from the header alone.

use std::fmt::Write;
use std::path::PathBuf;

use super::{Function, Link, build, header, scratch};

/// A good value for a parameter, by its type and name.
fn good(function: &Function, kind: &str, name: &str) -> String {
    let kind = kind.replace("struct ", "");
    if let Some(handle) = kind.strip_prefix("jostle_").and_then(|k| k.strip_suffix(" **")) {
        return format!("&new_{handle}");
    }
    let plain = kind.trim_start_matches("const ").trim_end_matches(" *").trim_end_matches('*').trim();
    let pointer = kind.ends_with('*');
    match (plain, pointer) {
        ("char", true) if name == "buffer" => "text".into(),
        ("char", true) if name == "path" => "\"bad_input_never_written.json\"".into(),
        ("char", true) => "\"robotiq_2f85\"".into(),
        ("jostle_body_pose", true) if name == "buffer" => "poses".into(),
        ("jostle_action" | "jostle_ranked_action" | "jostle_progress" | "jostle_body_pose", true) => {
            format!("&good_{plain}")
        }
        (kind, true) if HANDLES.contains(&kind) => kind.trim_start_matches("jostle_").into(),
        (kind, true) if kind.starts_with("jostle_") => format!("&good_{kind}"),
        ("jostle_body", false) => "target".into(),
        ("size_t", true) => "&good_count".into(),
        ("uint8_t", true) => "good_labels".into(),
        ("float", true) => "good_heights".into(),
        ("uint64_t", true) => "&good_u64".into(),
        ("uint32_t", true) => "&good_u32".into(),
        ("double", true) => "&good_double".into(),
        ("int32_t", true) => "&good_i32".into(),
        ("size_t", false) if name == "capacity" => "64".into(),
        ("size_t", false) if name == "size" => {
            format!("sizeof(good_{})", function.types[0].replace("struct ", "").trim_end_matches(" *"))
        }
        ("size_t" | "uint64_t" | "uint32_t" | "int32_t", false) => "1".into(),
        ("double", false) => "0.01".into(),
        (other, _) => panic!("{}: no good value for `{other}` {name}; add one here", function.name),
    }
}

const HANDLES: [&str; 8] = [
    "jostle_context",
    "jostle_scene",
    "jostle_planner",
    "jostle_job",
    "jostle_plan",
    "jostle_cancel",
    "jostle_simulator",
    "jostle_model",
];

/// A call for every pointer of every function: null where that is not allowed, dead and mistaken where it is a handle.
pub fn generated_calls() -> String {
    let mut calls = String::new();
    for function in header().functions.iter().filter(|f| f.returns == "jostle_status") {
        let nullable = function.docs.iter().find(|l| l.starts_with("Nullable:")).expect("a tested line");
        let nullable: Vec<&str> = nullable["Nullable:".len()..].split(&[',', '(', ' ', '.'][..]).collect();
        for (i, (kind, name)) in function.types.iter().zip(&function.parameters).enumerate() {
            if !kind.ends_with('*') {
                continue;
            }
            let plain = kind.replace("struct ", "").replace("const ", "");
            let handle = plain.strip_suffix(" *").filter(|k| HANDLES.contains(k));
            let mut call = |bad: &str, status: &str| {
                let arguments: Vec<String> = (function.types.iter().zip(&function.parameters).enumerate())
                    .map(|(j, (kind, name))| if i == j { bad.to_string() } else { good(function, kind, name) })
                    .collect();
                let _ =
                    writeln!(calls, "    BAD({}({}), {status}, \"{name}: \");", function.name, arguments.join(", "));
            };
            if !nullable.contains(&name.as_str()) {
                call("NULL", "JOSTLE_ERROR_ARGUMENT");
            }
            if let Some(handle) = handle {
                let short = handle.trim_start_matches("jostle_");
                call(&format!("dead_{short}"), "JOSTLE_ERROR_HANDLE");
                call("(void *)&good_u64", "JOSTLE_ERROR_HANDLE");
                let other = if short == "context" { "scene" } else { "context" };
                call(&format!("(void *){other}"), "JOSTLE_ERROR_HANDLE");
            }
        }
    }
    calls
}

/// The program of tests/capi/bad_input.c.
pub fn bad_input(name: &str, link: Link, flags: &[&str]) -> PathBuf {
    let calls = generated_calls();
    assert!(calls.lines().count() > 150, "only {} calls", calls.lines().count());
    let folder = scratch(name);
    std::fs::write(folder.join("bad_input_calls.h"), calls).expect("the calls can be written");
    let include = format!("-I{}", folder.display());
    build(&["tests/capi/bad_input.c"], name, link, &[&[include.as_str()], flags].concat())
}
