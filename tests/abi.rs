//! The binary interface: layouts of structs as Rust and C have them, exported symbols, the library's name.
//!
//! `UPDATE_ABI=1 cargo test --test abi` writes tests/abi anew. A change there that is more than an addition breaks
//! programs that are not compiled again: JOSTLE_ABI_VERSION rises.

mod common;

use std::fmt::Write;
use std::process::Command;

use common::{Link, build, has, header, libraries, root, run, scratch, structs};

/// Compares with the committed file, or writes it.
fn golden(name: &str, now: &str) {
    let path = root().join("tests/abi").join(name);
    if std::env::var_os("UPDATE_ABI").is_some() {
        std::fs::write(&path, now).expect("the file can be written");
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(committed == now, "{} differs; it would be:\n{now}\n(UPDATE_ABI=1 writes it)", path.display());
}

/// Lines `struct size alignment` and `  field offset size`.
fn rust_layout() -> String {
    use jostle::ffi::{
        abi::*, action::*, body::*, camera::*, context::*, goal::*, grasp::*, image::*, log::*, model::*, options::*,
        plan::*, planner::*, progress::*, simulator::*, tip_path::*,
    };
    let mut text = String::new();
    fn size_of_field<S, F>(_: fn(&S) -> &F) -> usize {
        size_of::<F>()
    }
    macro_rules! layout {
        ($($name:ident { $($field:ident),* },)*) => {
            $(
                let _ = writeln!(text, "{} {} {}", stringify!($name), size_of::<$name>(), align_of::<$name>());
                $(
                    let size = size_of_field(|s: &$name| &s.$field);
                    let offset = std::mem::offset_of!($name, $field);
                    let _ = writeln!(text, "  {} {offset} {size}", stringify!($field));
                )*
            )*
        };
    }
    layout! {
        jostle_log_message { struct_size, level, function, text },
        jostle_context_options { struct_size, threads, log_callback, log_user, log_mask, reserved },
        jostle_vec2 { x, y },
        jostle_pose2 { p, theta },
        jostle_shape_part { shape, reserved, pose, points, point_count, radius },
        jostle_body_def { struct_size, shape, pose, points, point_count, radius, parts, part_count, block, name, height, mass, friction, pickable, pushable, present, has_centre_of_mass, centre_of_mass, inertia, outline_tolerance },
        jostle_body { id },
        jostle_body_info { corners, pieces, area, deviation },
        jostle_body_pose { body, pose, present, reserved },
        jostle_tip_path { struct_size, has_base, sink, sink_count, rise, rise_count, shortfall_along, shortfall_across, base },
        jostle_grasp { position, angle, opening, width, margin, score },
        jostle_grasp_features { width, touch, turn, end, clearance, depth, height, mass },
        jostle_grasp_report { grasp, body, allowed, limit, limit_body, chance, wedge, fit_spare, cover_spare, finger_spare, between_spare, opening_spare, wedge_spare, finger_body, between_body, features },
        jostle_gripper { struct_size, grasp_score, push_width, push_thickness, push_clearance, opening, finger_width, finger_thickness, finger_clearance, fit, pad_edge, min_cover, max_wedge, tip_path, reserved, lowest, finger_length },
        jostle_workspace { struct_size, leave_rule, min, max, leave_scope, reserved },
        jostle_goal { struct_size, symmetry, pose, position_tolerance, rotation_tolerance },
        jostle_image_frame { pose, pixel, rows, cols },
        jostle_pixel_map { origin, column, row },
        jostle_camera_image { struct_size, reserved, rows, cols, labels, label_stride, masks, mask_count, mask_stride, mask_plane_stride, heights, height_stride, map },
        jostle_image_options { struct_size, at_border, tolerance, min_area, height_quantile, height, mass, friction, greatest_cost, discs, reserved },
        jostle_seen_body { body, pose, label, seen, deviation, hole_pixels, dropped_pixels },
        jostle_progress { struct_size, solution_actions, iterations, nodes, simulations, best_value, elapsed_seconds },
        jostle_model_options { struct_size, device, threads, self_test, runtime, backend, gripper, sha256, tolerate, reserved },
        jostle_planner_options { struct_size, threads, planner, engine, preset, sampler, seed, max_iterations, max_seconds, max_bytes, push_length, execute_score, solved_score, lanes, max_depth, variant, reserved, confirm, scorer, scorer_model, engine_model, prior, prior_model, gripper },
        jostle_solve_options { struct_size, reserved, cancel, progress, user, progress_seconds },
        jostle_push { start, end },
        jostle_action { kind, reserved, body, push, grasp },
        jostle_ranked_action { action, value, best_return, visits, prior, solution_actions, reserved },
        jostle_plan_statistics { struct_size, no_plan_within, iterations, nodes, simulations, seed, seconds, domain_seconds, search_seconds, grasp_score, plans_tried, plans_confirmed, confirm_simulations, confirm_seconds, proved_shortest, worlds, success_chance, expected_actions },
        jostle_simulator_options { struct_size, executor, engine, preset, seed, friction_spread, position_noise, angle_noise },
        jostle_execute_options { struct_size, reserved, max_seconds, cancel },
    }
    text
}

#[test]
fn rust_c_and_the_committed_layout_agree() {
    let mut program = String::from("#include <jostle/jostle.h>\n#include <stdio.h>\nint main(void)\n{\n");
    for s in structs() {
        let name = &s.name;
        let _ = writeln!(program, "    printf(\"{name} %zu %zu\\n\", sizeof({name}), _Alignof({name}));");
        for field in &s.fields {
            let _ = writeln!(
                program,
                "    printf(\"  {field} %zu %zu\\n\", offsetof({name}, {field}), sizeof((({name} *)0)->{field}));"
            );
        }
    }
    program.push_str("    return 0;\n}\n");
    let source = scratch("layout").join("layout.c");
    std::fs::write(&source, program).expect("the source can be written");
    let c = run(&build(&[&source.display().to_string()], "layout", Link::Static, &[]));
    let rust = rust_layout();
    assert!(c == rust, "C:\n{c}\nRust:\n{rust}");
    golden("layout.txt", &rust);
}

/// Sized structs are read by their bytes: a hole could hide a field that was appended into it.
#[test]
fn no_struct_has_holes() {
    let (mut name, mut end, mut size) = (String::new(), 0, 0);
    for line in rust_layout().lines().chain(["end 0 0"]) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |i: usize| words[i].parse::<usize>().expect("a number");
        if line.starts_with(' ') {
            assert_eq!(number(1), end, "a hole before {name}.{}", words[0]);
            end += number(2);
        } else {
            assert_eq!(end, size, "a hole at the end of {name}");
            (name, end, size) = (words[0].to_string(), 0, number(1));
        }
    }
}

#[test]
fn the_library_exports_its_functions_and_nothing_else() {
    let output = Command::new("nm").args(["-D", "--defined-only"]).arg(libraries().join("libjostle.so")).output();
    let output = output.expect("nm runs");
    let text = String::from_utf8_lossy(&output.stdout);
    let mut exported: Vec<&str> = text.lines().filter_map(|line| line.split_whitespace().last()).collect();
    exported.sort_unstable();
    let mut declared: Vec<String> = header().functions.into_iter().map(|f| f.name).collect();
    declared.sort_unstable();
    assert_eq!(exported, declared, "exported and declared");
    golden("symbols.txt", &(exported.join("\n") + "\n"));
}

#[test]
fn the_library_has_its_name() {
    let output =
        Command::new("readelf").arg("-d").arg(libraries().join("libjostle.so")).output().expect("readelf runs");
    let text = String::from_utf8_lossy(&output.stdout);
    let name = format!("Library soname: [libjostle.so.{}]", jostle::ffi::version::JOSTLE_ABI_VERSION);
    assert!(text.contains(&name), "{text}");
}

/// Compares with the dump of the last release (`abidw --out-file tests/abi/jostle.abi libjostle.so`).
#[test]
fn abidiff_finds_no_break() {
    let dump = root().join("tests/abi/jostle.abi");
    if !has("abidiff") {
        return println!("skipped: abidiff is not installed (Debian: abigail-tools)");
    }
    if !dump.exists() {
        return println!("skipped: there is no release to compare with yet");
    }
    let output = Command::new("abidiff")
        .arg("--suppressions")
        .arg(root().join("tests/abi/grow.abignore"))
        .arg(&dump)
        .arg(libraries().join("libjostle.so"))
        .output()
        .expect("abidiff runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
}
