//! The committed C header is what `src/ffi` generates, and every function in it is documented in full.
//!
//! `UPDATE_HEADER=1 cargo test --test header` writes it anew.

mod common;

use common::{header, root};

/// Held by every test: one of them may write the header.
static CURRENT: std::sync::Mutex<()> = std::sync::Mutex::new(());

/// The files of the C API, in the header's order.
const FILES: [&str; 22] = [
    "status.rs",
    "version.rs",
    "log.rs",
    "context.rs",
    "abi.rs",
    "body.rs",
    "action.rs",
    "scene.rs",
    "tip_path.rs",
    "grasp.rs",
    "options.rs",
    "goal.rs",
    "image.rs",
    "camera.rs",
    "scene_file.rs",
    "cancel.rs",
    "progress.rs",
    "model.rs",
    "planner.rs",
    "job.rs",
    "plan.rs",
    "simulator.rs",
];

/// The header as it should be: cbindgen's output and the hand-written end.
fn generated() -> String {
    let config = cbindgen::Config::from_file(root().join("cbindgen.toml")).expect("cbindgen.toml");
    let builder = FILES
        .iter()
        .fold(cbindgen::Builder::new().with_config(config), |b, file| b.with_src(root().join("src/ffi").join(file)));
    let mut text = Vec::new();
    builder.generate().expect("the header is generated").write(&mut text);
    let text = String::from_utf8(text).expect("the header is UTF-8");
    // Negative numbers in parentheses, so that `-JOSTLE_ERROR_BUSY` is not two minus signs.
    let text: String = text
        .lines()
        .map(|line| match line.rsplit_once(' ') {
            Some((head, number)) if line.starts_with("#define ") && number.starts_with('-') => {
                format!("{head} ({number})\n")
            }
            _ => format!("{line}\n"),
        })
        .collect();
    let split = |text: &str| -> (String, String) {
        let end = text.rfind("#ifdef __cplusplus\n}").expect("the header ends its extern \"C\" block");
        (text[..end].to_string(), text[end..].to_string())
    };
    let (body, close) = split(&text);
    let (major, minor, patch) =
        (env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR"), env!("CARGO_PKG_VERSION_PATCH"));
    let number = format!("{major} * 10000 + {minor} * 100 + {patch}");
    let template = std::fs::read_to_string(root().join("src/ffi/header_end.h.in")).expect("the header's end");
    let defaults: String = template
        .lines()
        .find_map(|line| line.strip_prefix("@DEFAULTS@ "))
        .expect("the list of structs with defaults")
        .split_whitespace()
        .map(|name| {
            format!(
                "\n/// All defaults, with the size that this header knows.\n\
                 static inline {name} {name}_default(void) {{\n    {name} value;\n    \
                 {name}_init(&value, sizeof value);\n    return value;\n}}\n"
            )
        })
        .collect();
    let end: String = template
        .lines()
        .map(|line| if line.starts_with("@DEFAULTS@") { defaults.clone() } else { format!("{line}\n") })
        .collect();
    let end = end
        .replace("@VERSION@", env!("CARGO_PKG_VERSION"))
        .replace("@MAJOR@", major)
        .replace("@MINOR@", minor)
        .replace("@PATCH@", patch)
        .replace("@NUMBER@", &number);
    format!("{body}{end}\n{close}")
}

#[test]
fn the_committed_header_is_the_generated_one() {
    let _current = CURRENT.lock();
    let path = root().join("include/jostle/jostle.h");
    let wanted = generated();
    if std::env::var_os("UPDATE_HEADER").is_some() {
        std::fs::write(&path, &wanted).expect("the header can be written");
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    if committed != wanted {
        let line = committed.lines().zip(wanted.lines()).position(|(a, b)| a != b);
        panic!(
            "{} is out of date (first at line {line:?}); run UPDATE_HEADER=1 cargo test --test header",
            path.display()
        );
    }
}

#[test]
fn every_function_is_documented_in_full() {
    let _current = CURRENT.lock();
    let mut gaps = Vec::new();
    for function in header().functions {
        let sentence = function.docs.first().is_some_and(|line| line.len() > 10 && line.contains(char::is_whitespace));
        if !sentence {
            gaps.push(format!("{}: no sentence", function.name));
        }
        let mut last = 0;
        for tag in ["Thread:", "RT:", "Nullable:", "Owns:", "Errors:"] {
            match function.docs.iter().position(|line| line.starts_with(tag)) {
                Some(at) if at < last => gaps.push(format!("{}: {tag} is out of order", function.name)),
                Some(at) if function.docs[at].len() > tag.len() + 2 => last = at,
                _ => gaps.push(format!("{}: no {tag} line", function.name)),
            }
        }
        let rt = function.docs.iter().find(|line| line.starts_with("RT:")).cloned().unwrap_or_default();
        if !(rt.starts_with("RT: yes") || rt.starts_with("RT: no")) {
            gaps.push(format!("{}: `{rt}` begins with neither yes nor no", function.name));
        }
        // Every pointer that may be null is one of the parameters.
        let nullable = function.docs.iter().find(|line| line.starts_with("Nullable:")).cloned().unwrap_or_default();
        let names = nullable.trim_start_matches("Nullable:").split(['(', '.']).next().unwrap_or("").to_string();
        for name in names.split(',').map(str::trim).filter(|n| !n.is_empty()) {
            let known = name == "none" || name == "never returns null" || function.parameters.iter().any(|p| p == name);
            if !known {
                gaps.push(format!("{}: Nullable names `{name}`, which is no parameter", function.name));
            }
        }
        let fallible = function.returns == "jostle_status";
        let errors = function.docs.iter().find(|line| line.starts_with("Errors:")).cloned().unwrap_or_default();
        if fallible == errors.starts_with("Errors: none") {
            gaps.push(format!("{}: `{errors}` does not fit its return type", function.name));
        }
    }
    assert!(gaps.is_empty(), "the documentation has gaps:\n{}", gaps.join("\n"));
}

#[test]
fn every_struct_field_and_constant_is_documented() {
    let _current = CURRENT.lock();
    let text = std::fs::read_to_string(root().join("include/jostle/jostle.h")).expect("the header");
    let mut before = "";
    let mut gaps = Vec::new();
    for line in text.lines() {
        let constant =
            line.starts_with("#define JOSTLE_") && !line.contains("_H") && line.split_whitespace().count() > 2;
        let own = line.contains("JOSTLE_VERSION") || line.contains("JOSTLE_BODY_EQ");
        let named = line.starts_with("typedef struct") || line.starts_with("typedef int32_t");
        if ((constant && !own) || named) && !before.starts_with("///") {
            gaps.push(line.to_string());
        }
        before = line;
    }
    assert!(gaps.is_empty(), "without a comment:\n{}", gaps.join("\n"));
}

#[test]
fn the_version_in_the_header_is_the_manifests() {
    let _current = CURRENT.lock();
    let text = std::fs::read_to_string(root().join("include/jostle/jostle.h")).expect("the header");
    assert!(text.contains(&format!("#define JOSTLE_VERSION \"{}\"", env!("CARGO_PKG_VERSION"))));
    // The soname ends with the number of the binary interface.
    let build = std::fs::read_to_string(root().join("build.rs")).expect("build.rs");
    assert!(build.contains(&format!("-soname,libjostle.so.{}", jostle::ffi::version::JOSTLE_ABI_VERSION)));
}
