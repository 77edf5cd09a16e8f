//! The C and C++ tests once more, under valgrind and under the sanitizers of gcc.

mod common;

use std::path::PathBuf;
use std::process::Command;

use common::calls::bad_input;
use common::{Link, build, has, output, scratch};

/// The programs and how each ends when all is well.
fn programs(prefix: &str, link: Link, flags: &[&str]) -> Vec<(PathBuf, &'static str)> {
    let flags = &[flags, &["-DLIGHT"]].concat();
    vec![
        (bad_input(&format!("{prefix}_bad_input"), link, flags), "bad input: all refused\n"),
        (build(&["tests/capi/behaviour.c"], &format!("{prefix}_behaviour"), link, flags), "behaviour: as promised\n"),
        (build(&["tests/capi/grasps.c"], &format!("{prefix}_grasps"), link, flags), "grasps: as promised\n"),
        (build(&["tests/capi/wrapper.cpp"], &format!("{prefix}_wrapper"), link, flags), "wrapper: as promised\n"),
    ]
}

fn check(command: &mut Command, program: &std::path::Path, end: &str) {
    let output = output(command, program);
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && out.ends_with(end), "{}: {}\n{out}\n{err}", program.display(), output.status);
}

#[test]
fn valgrind_finds_nothing() {
    if !has("valgrind") {
        return println!("skipped: valgrind is not installed");
    }
    for (program, end) in programs("valgrind", Link::Shared, &[]) {
        let mut command = Command::new("valgrind");
        command.args(["--quiet", "--error-exitcode=99", "--leak-check=full", "--show-leak-kinds=definite,indirect"]);
        command.args(["--errors-for-leak-kinds=definite,indirect", "--fair-sched=yes"]).arg(&program);
        check(&mut command, &program, end);
    }
}

#[test]
fn sanitizers_find_nothing() {
    // The compiler may be there without its run-time libraries.
    let source = scratch("sanitizers").join("probe.c");
    std::fs::write(&source, "int main(void) { return 0; }\n").expect("the source can be written");
    let flags = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer"];
    let mut probe = common::compiler(&source);
    let works = probe.args(flags).arg(&source).arg("-o").arg(source.with_extension("")).output();
    if !works.is_ok_and(|o| o.status.success()) {
        return println!("skipped: the compiler has no address and undefined-behaviour sanitizers");
    }
    for (program, end) in programs("sanitized", Link::Static, &flags) {
        let mut command = Command::new(&program);
        command.env("ASAN_OPTIONS", "detect_leaks=1:detect_stack_use_after_return=1");
        check(&mut command, &program, end);
    }
}
