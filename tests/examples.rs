//! The programs of examples_c, built as users build them, run, and their output checked.

mod common;

use std::process::Command;

use common::{Link, build, output, root, run};

/// The output without the line on the build and without lines that begin with `#`, which are measurements.
fn told(source: &str, name: &str, link: Link) -> String {
    without_measurements(&run(&build(&[source], name, link, &[])))
}

fn without_measurements(text: &str) -> String {
    let mut lines = text.lines();
    let first = lines.next().unwrap_or_default();
    assert!(first.starts_with(concat!("jostle ", env!("CARGO_PKG_VERSION"), " abi ")), "{first}");
    lines.filter(|line| !line.starts_with('#')).map(|line| format!("{line}\n")).collect()
}

#[test]
fn retrieve_gets_the_target_the_same_way_every_time() {
    let shared = told("examples_c/retrieve.c", "retrieve", Link::Shared);
    assert!(shared.ends_with("grasped\nretrieved\n"), "{shared}");
    assert!(shared.contains(" 1  push  "), "the scene is meant to need a push:\n{shared}");
    assert_eq!(shared, told("examples_c/retrieve.c", "retrieve", Link::Static));
    assert_eq!(shared, told("examples_c/retrieve.c", "retrieve", Link::Static));
}

#[test]
fn rearrange_brings_every_body_to_its_goal_the_same_way_every_time() {
    let shared = told("examples_c/rearrange.c", "rearrange", Link::Shared);
    assert!(shared.ends_with("arranged\n") && !shared.contains("not arranged"), "{shared}");
    // The exchange takes three picks, the tray at least one drag.
    assert!(shared.matches("  pick  ").count() == 3 && shared.matches("  drag  tray").count() >= 1, "{shared}");
    assert_eq!(shared, told("examples_c/rearrange.c", "rearrange", Link::Static));
}

#[test]
fn a_block_known_from_images_alone_is_retrieved() {
    let shared = told("examples_c/camera_scene.c", "camera_scene", Link::Shared);
    assert!(shared.contains(" 1  5 bodies seen\n    push   pushed\n"), "{shared}");
    assert!(shared.ends_with("    grasp  grasped\n4 blocks matched, all within a pixel\nretrieved\n"), "{shared}");
    assert_eq!(shared, told("examples_c/camera_scene.c", "camera_scene", Link::Static));
}

#[test]
fn clear_table_takes_every_body_the_same_way_every_time() {
    let shared = told("examples_c/clear_table.c", "clear_table", Link::Shared);
    assert!(shared.contains(" 1  push  ") && shared.contains("\ncleared: 9 bodies by "), "{shared}");
    assert_eq!(shared.matches("  grasped\n").count(), 9, "{shared}");
    assert_eq!(shared, told("examples_c/clear_table.c", "clear_table", Link::Static));
}

#[test]
fn learned_retrieve_gets_the_target_and_says_why_or_what_is_missing() {
    // A program that is linked statically does not lie in this project, and would not find the project's runtime.
    let own = root().join("third_party/onnxruntime/lib/libonnxruntime.so.1");
    let told = |link: Link| {
        let program = build(&["examples_c/learned_retrieve.c"], "learned_retrieve", link, &[]);
        let mut command = Command::new(&program);
        if std::env::var_os("ORT_DYLIB_PATH").is_none() && own.exists() {
            command.env("ORT_DYLIB_PATH", &own);
        }
        let done = output(&mut command, &program);
        assert!(done.status.success(), "{done:?}");
        without_measurements(&String::from_utf8_lossy(&done.stdout))
    };
    let shared = told(Link::Shared);
    assert_eq!(shared, told(Link::Static));
    if shared.starts_with("nothing runs networks here: ") || shared.starts_with("this build has no network: ") {
        println!("skipped: {shared}");
        return;
    }
    assert!(shared.ends_with("grasped\nretrieved\n"), "{shared}");
    assert!(shared.contains(" 1  push  ") && shared.contains("\n    1. ("), "a push, and why:\n{shared}");
}

#[test]
fn async_cancel_stops_in_time() {
    for link in [Link::Shared, Link::Static] {
        let text = told("examples_c/async_cancel.c", "async_cancel", link);
        let wanted = "outcome: cancelled, 0 actions\nprogress went forward: yes\ncancel to return: below 100 ms\n";
        assert_eq!(text, wanted);
    }
}

#[test]
fn a_plan_of_one_engine_is_checked_in_every_engine() {
    let text = told("examples_c/crosscheck.c", "crosscheck", Link::Shared);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 5, "{text}");
    assert_eq!(lines[0], "planned with rapier: 2 actions");
    assert!(lines[1].starts_with("rapier   target grasped; the farthest body is within "), "{text}");
    for (line, engine) in lines[2..].iter().zip(["planar", "prism", "bullet"]) {
        let built = engine != "bullet" || cfg!(feature = "bullet");
        let wanted = if built { "target " } else { "not in this build" };
        assert!(line.starts_with(&format!("{engine:8} {wanted}")), "{text}");
    }
    assert_eq!(text, told("examples_c/crosscheck.c", "crosscheck", Link::Static));
}

#[test]
fn the_controller_gets_its_target() {
    for link in [Link::Shared, Link::Static] {
        let text = told("examples_c/controller.cpp", "controller", link);
        assert!(text.ends_with("held\ndone\n"), "{text}");
    }
}
