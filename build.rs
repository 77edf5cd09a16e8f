//! Names the shared library and records how it was built. Nothing here depends on the time or the place.

use std::env;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");

    // The number is JOSTLE_ABI_VERSION; a test compares the two.
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("linux") {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libjostle.so.0");
        println!("cargo::rustc-cdylib-link-arg=-Wl,-z,defs");
        println!("cargo::rustc-cdylib-link-arg=-Wl,--exclude-libs,ALL");
    }

    #[cfg(feature = "bullet")]
    bullet();
    models();

    let compiler = env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let version = Command::new(compiler).arg("--version").output();
    let version = version.ok().and_then(|o| String::from_utf8(o.stdout).ok()).unwrap_or_else(|| "rustc unknown".into());
    let target = env::var("TARGET").unwrap_or_default();
    let optimised = env::var("OPT_LEVEL").unwrap_or_default();
    println!("cargo::rustc-env=JOSTLE_BUILD={target} opt-level {optimised} {}", version.trim());
}

/// Compiles the C interface to Bullet (`bindings/bullet`) and links the library, in double precision.
#[cfg(feature = "bullet")]
fn bullet() {
    let folder = std::path::Path::new("bindings/bullet");
    println!("cargo::rerun-if-changed={}", folder.display());
    let library = match pkg_config::Config::new().atleast_version("3.20").probe("bullet-float64") {
        Ok(library) => library,
        Err(error) => {
            println!(
                "cargo::error=the feature `bullet` needs Bullet in double precision (Debian: libbullet-dev): {error}"
            );
            return;
        }
    };
    let mut build = cc::Build::new();
    build.cpp(true).std("c++14").flag("-fvisibility=hidden").flag_if_supported("-fvisibility-inlines-hidden");
    // Results are compared bit for bit: no contraction of a product and a sum.
    build.flag_if_supported("-ffp-contract=off").opt_level(2).warnings(true).extra_warnings(true);
    for (name, value) in &library.defines {
        build.define(name, value.as_deref());
    }
    // As system headers, so that their warnings are not ours. The compiler knows /usr/include itself; named here it
    // would come before the C++ library's own and break that.
    for path in library.include_paths.iter().filter(|path| path.as_path() != std::path::Path::new("/usr/include")) {
        build.flag("-isystem").flag(path);
    }
    for file in ["shim", "world", "solver", "guard"] {
        build.file(folder.join(file).with_extension("cpp"));
    }
    build.compile("jostle_bullet");
}

/// Writes the table of the built-in networks (`models/MODELS.toml`) for `src/net/builtin.rs`. Without the feature
/// `models`, and where nothing is listed, it is empty.
fn models() {
    let folder = std::path::Path::new("models");
    let list = folder.join("MODELS.toml");
    println!("cargo::rerun-if-changed={}", list.display());
    let text = match std::fs::read_to_string(&list) {
        Ok(text) if env::var_os("CARGO_FEATURE_MODELS").is_some() => text,
        _ => String::new(),
    };
    let text: String =
        text.lines().filter(|line| !line.trim_start().starts_with('#')).map(|l| format!("{l}\n")).collect();
    let mut table = String::from("&[\n");
    let mut trained = false;
    for entry in text.split("[[model]]").skip(1) {
        // Its own keys end where a table within it begins.
        let own = entry.lines().map(str::trim).take_while(|line| !line.starts_with('['));
        let pairs: Vec<(&str, &str)> =
            own.filter_map(|line| line.split_once('=')).map(|(key, value)| (key.trim(), value.trim())).collect();
        let get = |key: &str| {
            let found = pairs.iter().find(|(k, _)| *k == key).and_then(|(_, v)| v.strip_prefix('"')?.split('"').next());
            found.map(str::to_string)
        };
        let (Some(name), Some(kind), Some(file), Some(sha256)) = (get("name"), get("kind"), get("file"), get("sha256"))
        else {
            println!("cargo::error={}: a [[model]] needs name, kind, file and sha256 as texts", list.display());
            return;
        };
        let path = folder.join(&file);
        println!("cargo::rerun-if-changed={}", path.display());
        if !path.is_file() {
            println!("cargo::error={}: `{name}` names {file}, which is not in models/", list.display());
            return;
        }
        let Ok(path) = path.canonicalize() else { continue };
        trained |= kind == "dipn";
        table += &format!(
            "    Builtin {{ name: {name:?}, kind: {kind:?}, sha256: {sha256:?}, bytes: include_bytes!({path:?}) }},\n"
        );
    }
    table += "]\n";
    println!("cargo::rustc-check-cfg=cfg(jostle_dipn)");
    if trained {
        println!("cargo::rustc-cfg=jostle_dipn");
    }
    let out = std::path::PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default()).join("builtin.rs");
    if let Err(error) = std::fs::write(&out, table) {
        println!("cargo::error={}: {error}", out.display());
    }
}
