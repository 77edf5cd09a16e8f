//! What the C API promises, from C; and the headers as strict compilers see them.

mod common;
#[path = "common/onnx.rs"]
mod onnx;

use common::{Link, build, compiler, root, run, scratch};

#[test]
fn it_behaves_as_promised() {
    for link in [Link::Shared, Link::Static] {
        let text = run(&build(&["tests/capi/behaviour.c"], "behaviour", link, &[]));
        assert!(text.ends_with("behaviour: as promised\n"), "{text}");
    }
}

#[test]
fn the_cpp_header_owns_throws_and_converts() {
    let text = run(&build(&["tests/capi/wrapper.cpp"], "wrapper", Link::Shared, &[]));
    assert!(text.ends_with("wrapper: as promised\n"), "{text}");
    let text = run(&build(&["tests/capi/no_exceptions.cpp"], "no_exceptions", Link::Shared, &["-fno-exceptions"]));
    assert_eq!(text, "def.mass: is -1; it must lie in 1e-9 to 1000 kg (from a microgram to a tonne)\n");
}

/// Every spoilt file has its status; a good one is used for a plan.
#[test]
fn networks_are_refused_by_status_and_used_by_planners() {
    use onnx::{bytes, net, with_dims, with_dtype, with_property};
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
    let loaded: [(&str, Vec<u8>, &str, &str); 7] = [
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
        ("dtype", with_dtype(&gc, "image", 10), "JOSTLE_ERROR_MODEL_SESSION", "found"),
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
                for (name, content, status, says) in &loaded {
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
