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

    let compiler = env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let version = Command::new(compiler).arg("--version").output();
    let version = version.ok().and_then(|o| String::from_utf8(o.stdout).ok()).unwrap_or_else(|| "rustc unknown".into());
    let target = env::var("TARGET").unwrap_or_default();
    let optimised = env::var("OPT_LEVEL").unwrap_or_default();
    println!("cargo::rustc-env=JOSTLE_BUILD={target} opt-level {optimised} {}", version.trim());
}
