//! What the C API promises, from C; and the headers as strict compilers see them.

mod common;

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
    assert_eq!(text, "def.mass: is -1; it must be greater than 0\n");
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
