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
