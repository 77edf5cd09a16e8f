//! What the C API promises, from C; and the headers as strict compilers see them.

mod common;
#[path = "common/onnx.rs"]
mod onnx;

use std::path::PathBuf;
use std::sync::OnceLock;

use common::{Link, build, compiler, output, root, run, scratch};

#[test]
fn it_behaves_as_promised() {
    for link in [Link::Shared, Link::Static] {
        let text = run(&build(&["tests/capi/behaviour.c"], "behaviour", link, &[]));
        assert!(text.ends_with("behaviour: as promised\n"), "{text}");
    }
}

/// Lists of grasps, grasps examined, and plans of scenes of the suites that end with the first of the list.
#[test]
fn grasps_are_listed_and_examined() {
    let scene = |name: &str| root().join("suites").join(name);
    let scenes =
        ["own-hard/generated-122-1.json", "own-hard/generated-122-2.json", "own-confined/generated-120-1.json"];
    for link in [Link::Shared, Link::Static] {
        let program = build(&["tests/capi/grasps.c"], "grasps", link, &[]);
        let mut command = std::process::Command::new(&program);
        let output = output(command.args(scenes.map(scene)), &program);
        let (text, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(
            output.status.success() && text.ends_with("grasps: as promised\n") && said.is_empty(),
            "{text}\n{said}"
        );
    }
}

#[test]
fn the_cpp_header_owns_throws_and_converts() {
    let text = run(&build(&["tests/capi/wrapper.cpp"], "wrapper", Link::Shared, &[]));
    assert!(text.ends_with("wrapper: as promised\n"), "{text}");
    let text = run(&build(&["tests/capi/no_exceptions.cpp"], "no_exceptions", Link::Shared, &["-fno-exceptions"]));
    assert_eq!(text, "def.mass: is -1; it must lie in 1e-9 to 1000 kg (from a microgram to a tonne)\n");
}

/// Runs a program of `hosts.c`, which may print nothing to stderr. It is built once: tests run side by side.
fn host(arguments: &[&str], variables: &[(&str, &str)]) {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    let program = PROGRAM.get_or_init(|| build(&["tests/capi/hosts.c"], "hosts", Link::Shared, &["-ldl"]));
    host_at(program, arguments, variables);
}

fn host_at(program: &std::path::Path, arguments: &[&str], variables: &[(&str, &str)]) {
    let mut command = std::process::Command::new(program);
    let output = output(command.args(arguments).envs(variables.iter().copied()), program);
    let (text, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let promised = text.ends_with(&format!("{}: as promised\n", arguments[0]));
    assert!(output.status.success() && promised && said.is_empty(), "{arguments:?}: {}\n{text}\n{said}", output.status);
}

/// Whatever the rounding, flushing and traps of the host: the same plans, no signal, and the state as it was.
#[test]
fn plans_do_not_depend_on_the_hosts_floating_point_state_which_stays_as_it_is() {
    host(&["floats"], &[]);
}

#[test]
fn the_first_network_of_a_process_leaves_the_floating_point_state_as_it_was() {
    if !onnx::runs() {
        return;
    }
    let net = onnx::net("gc");
    let library = onnx::library();
    // The default, flushing, upwards: the runtime would set or clear what it likes.
    for state in ["1f80", "9fc0", "5f80"] {
        host(&["first-session", state, net.to_str().unwrap()], &[("ORT_DYLIB_PATH", &library)]);
    }
}

#[test]
fn a_library_that_is_no_runtime_is_refused_again_and_again_and_one_that_is_then_opened() {
    let folder = scratch("runtimes");
    let good = if onnx::runs() { onnx::library() } else { String::new() };
    // Away from the checkout, whose runtime would be found: the library is in the program.
    let away = std::env::temp_dir().join(format!("jostle-hosts-{}", std::process::id()));
    std::fs::create_dir_all(&away).expect("a folder");
    let program = away.join("hosts");
    std::fs::copy(build(&["tests/capi/hosts.c"], "hosts", Link::Static, &[]), &program).expect("a copy");
    for (name, source, says) in [
        ("old", FAKE.replace("VERSION", "\"1.22.0\""), "is version 1.22.0; 1.24 or newer is needed"),
        ("next", FAKE.replace("VERSION", "\"2.0.0\""), "is version 2.0.0; 1.24 or newer is needed"),
        ("odd", FAKE.replace("VERSION", "\"\""), "is version ; 1.24 or newer is needed"),
        ("mute", FAKE.replace("VERSION", "0"), "does not say its version"),
        ("hollow", FAKE.replace("VERSION", "\"1.30.0\""), "is version 1.30.0 without the interface of 1.24"),
        ("other", "int nothing;".into(), "is not ONNX Runtime (it has no OrtGetApiBase)"),
    ] {
        let (file, library) = (folder.join(name).with_extension("c"), folder.join(format!("lib{name}.so")));
        std::fs::write(&file, source).expect("the source can be written");
        let mut command = compiler(&file);
        command.args(["-shared", "-fPIC", "-Wno-missing-prototypes", "-Wno-unused"]).arg(&file).arg("-o").arg(&library);
        assert!(command.status().expect("the compiler runs").success());
        let library = library.display().to_string();
        let named = format!("{library}: {says}");
        host_at(&program, &["no-runtime", &named, &good], &[("ORT_DYLIB_PATH", &library)]);
    }
    let text = folder.join("libtext.so");
    std::fs::write(&text, "no library").expect("the file can be written");
    let text = text.display().to_string();
    let says = format!("{text}: cannot be loaded");
    host_at(&program, &["no-runtime", &says, &good], &[("ORT_DYLIB_PATH", &text)]);
    std::fs::remove_dir_all(&away).expect("the folder can be removed");
}

/// As much of ONNX Runtime as is asked for its version.
const FAKE: &str = "
static const char *version(void) { return VERSION; }
static const void *api(unsigned number) { return (void)number, (const void *)0; }
static const struct { const void *(*api)(unsigned); const char *(*version)(void); } base = {api, version};
const void *OrtGetApiBase(void) { return &base; }
";

#[test]
fn a_forked_child_gets_an_error_where_it_would_wait_for_ever() {
    host(&["forks"], &[]);
}

#[test]
fn memory_that_the_system_does_not_give_is_a_status_where_an_input_decides_how_much() {
    host(&["memory"], &[]);
    host(&["memory-of-a-search"], &[]);
}

/// What docs/c-api.md says of the stack.
#[test]
fn a_calling_thread_needs_no_more_stack_than_the_documents_say() {
    let page = std::fs::read_to_string(root().join("docs/c-api.md")).expect("the page");
    let least = page.split(" KiB of stack").next().and_then(|before| before.rsplit(' ').next()).expect("a number");
    let bytes = (least.parse::<usize>().expect("a number") << 10).to_string();
    host(&["stack", &bytes], &[]);
}

#[test]
fn locale_scheduling_unloading_and_a_second_copy_change_nothing() {
    host(&["fifo"], &[]);
    let folder = scratch("copies");
    let (one, other) = (common::libraries().join("libjostle.so"), folder.join("libcopy.so"));
    std::fs::copy(&one, &other).expect("the library can be copied");
    host(&["copies", &one.display().to_string(), &other.display().to_string()], &[]);
    // A locale with a decimal comma, made here.
    let place = folder.join("de_DE.UTF-8");
    let made = std::process::Command::new("localedef").args(["-i", "de_DE", "-f", "UTF-8"]).arg(&place).output();
    if made.is_ok() && place.join("LC_NUMERIC").exists() {
        host(&["locale", "de_DE.UTF-8"], &[("LOCPATH", folder.to_str().unwrap())]);
    } else {
        println!("skipped: no locale with a decimal comma can be made here");
    }
}

/// Every spoilt file has its status; a good one is used for a plan.
#[test]
fn networks_are_refused_by_status_and_used_by_planners() {
    use onnx::{bytes, net, with_dims, with_dtype, with_name, with_property, with_weight};
    let folder = scratch("models");
    let gc = bytes("gc");
    let half = gc[..gc.len() / 2].to_vec();
    let always: [(&str, Vec<u8>, &str, &str); 4] = [
        ("empty", vec![], "JOSTLE_ERROR_MODEL_EMPTY", "0 bytes"),
        (
            "pointer",
            b"version https://git-lfs.github.com/spec/v1".to_vec(),
            "JOSTLE_ERROR_MODEL_LFS_POINTER",
            "git lfs",
        ),
        ("half", half, "JOSTLE_ERROR_MODEL_PARSE", "ends within a field"),
        ("text", b"no network".to_vec(), "JOSTLE_ERROR_MODEL_PARSE", "protocol buffer"),
    ];
    let others: [(&str, Vec<u8>, &str, &str); 10] = [
        ("kind", with_property(&gc, "kind", None), "JOSTLE_ERROR_MODEL_KIND", "none"),
        ("interface", with_property(&gc, "interface", Some("9")), "JOSTLE_ERROR_MODEL_INTERFACE", "found `9`"),
        ("output", with_dims(&gc, "probability", &[0, 7]), "JOSTLE_ERROR_MODEL_IO_MISMATCH", "[batch, 7]"),
        ("spec", with_property(&gc, "spec", Some("{}")), "JOSTLE_ERROR_MODEL_SPEC_MISMATCH", "`size`"),
        (
            "selftest",
            with_property(&gc, "selftest", Some(r#"{"seed":20,"expected":{"probability":[7]}}"#)),
            "JOSTLE_ERROR_MODEL_SELFTEST",
            "`probability`[0] = 7",
        ),
        ("dtype", with_dtype(&gc, "image", 10), "JOSTLE_ERROR_MODEL_IO_MISMATCH", "float16"),
        // An operator that nothing follows is as good as one that loops: neither is given to the runtime.
        ("loop", with_name(&gc, "Relu", "Loop"), "JOSTLE_ERROR_MODEL_OPERATOR", "`Loop`, which controls the flow"),
        ("external", with_weight(&gc, &[0x70, 1]), "JOSTLE_ERROR_MODEL_EXTERNAL", "in another file"),
        // A dimension of 2^34 more than the weight has.
        ("huge", with_weight(&gc, &[8, 128, 128, 128, 128, 64]), "JOSTLE_ERROR_MODEL_SIZE", "values in"),
        ("tensors", with_property(&gc, "kind", Some("gn")), "JOSTLE_ERROR_MODEL_IO_MISMATCH", "`quality`"),
    ];
    let runtime = jostle::net::Runtime::open(&Default::default()).ok().and_then(|r| r.info().file.clone());
    for link in [Link::Shared, Link::Static] {
        let program = build(&["tests/capi/models.c"], "models", link, &[]);
        let mut command = std::process::Command::new(&program);
        let mut add = |name: &str, content: &[u8], status: &str, says: &str| {
            let path = folder.join(name).with_extension("onnx");
            std::fs::write(&path, content).expect("the file can be written");
            command.arg(path).args([status, says]);
        };
        for (name, content, status, says) in &always {
            add(name, content, status, says);
        }
        match &runtime {
            Some(file) => {
                for (name, content, status, says) in &others {
                    add(name, content, status, says);
                }
                command.arg("good").args([net("gc"), net("dipn")]).env("ORT_DYLIB_PATH", file);
            }
            None => println!("skipped: the checks that need ONNX Runtime, which is not here"),
        }
        let output = common::output(&mut command, &program);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success() && text.contains("files refused"), "{text}");
        assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

/// Each header alone and twice, in every standard that it is for.
#[test]
fn the_headers_compile_strictly() {
    let folder = scratch("headers");
    let cases: [(&str, &str, &[&str]); 3] = [
        ("h.c", "jostle.h", &["-std=c11", "-std=c17", "-std=gnu11"]),
        ("h.cpp", "jostle.h", &["-std=c++17", "-std=c++20"]),
        ("hpp.cpp", "jostle.hpp", &["-std=c++17", "-std=c++20", "-fno-exceptions"]),
    ];
    for (file, header, flags) in cases {
        let source = folder.join(file);
        let text = format!("#include <jostle/{header}>\n#include <jostle/{header}>\nint not_empty;\n");
        std::fs::write(&source, text).expect("the source can be written");
        for flag in flags {
            let mut command = compiler(&source);
            command.args([flag, "-Wshadow", "-Wconversion", "-Wold-style-cast", "-fsyntax-only"]).arg(&source);
            if file.ends_with(".c") {
                command.arg("-Wno-old-style-cast").arg("-Wno-error");
            }
            let output = command.output().expect("the compiler runs");
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            let said: Vec<&str> =
                said.lines().filter(|l| !l.contains("is valid for C++/ObjC++ but not for C")).collect();
            assert!(output.status.success() && said.is_empty(), "{command:?}\n{}", said.join("\n"));
        }
    }
}

/// The header in two translation units of one program.
#[test]
fn two_files_may_include_the_header() {
    let folder = scratch("two_files");
    let (a, b) = (folder.join("a.cpp"), folder.join("b.cpp"));
    std::fs::write(
        &a,
        "#include <jostle/jostle.hpp>\nint other();\nint main() { jostle::check_abi(); return other(); }\n",
    )
    .expect("the source can be written");
    std::fs::write(
        &b,
        "#include <jostle/jostle.hpp>\nint other();\nint other() { return jostle::disc(0.1).radius > 0 ? 0 : 1; }\n",
    )
    .expect("the source can be written");
    let relative = |p: &std::path::Path| pathdiff(p);
    let (a, b) = (relative(&a), relative(&b));
    run(&build(&[&a, &b], "two_files", Link::Shared, &[]));
}

/// `build` takes sources relative to the repository; an absolute path stays what it is when joined.
fn pathdiff(path: &std::path::Path) -> String {
    assert!(root().join(path) == path);
    path.display().to_string()
}
