//! The committed binding of the C interface to Bullet is what bindgen makes of its header.
//!
//! `UPDATE_BINDINGS=1 cargo test --test bullet_bindings` (without the feature, which needs it) writes it anew. Needs libclang (Debian: libclang1-14 and
//! libclang-common-14-dev); without it the test says so and checks nothing.

use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_path_buf()
}

/// bindgen's output, without the lints' and versions' noise at its top. `None` where there is no libclang.
fn generated() -> Option<String> {
    let make = || {
        bindgen::builder()
            .header(root().join("bindings/bullet/shim.h").display().to_string())
            .allowlist_item("(jostle_bt|JOSTLE_BT)_.*")
            .default_enum_style(bindgen::EnumVariation::ModuleConsts)
            .disable_header_comment()
            .derive_default(true)
            .layout_tests(true)
            .merge_extern_blocks(true)
            .generate_comments(false)
            .formatter(bindgen::Formatter::Rustfmt)
            .generate()
    };
    // Without libclang the runtime loader panics.
    std::panic::catch_unwind(make).ok().map(|made| made.expect("the header is C").to_string())
}

#[test]
fn the_committed_binding_is_what_the_header_gives() {
    let Some(text) = generated() else {
        println!("skipped: no libclang here (Debian: libclang1-14 libclang-common-14-dev)");
        return;
    };
    let text = format!("/* Made by bindgen of shim.h; see tests/bullet_bindings.rs. */\n\n{text}");
    let path = root().join("bindings/bullet/bindings.rs");
    if std::env::var_os("UPDATE_BINDINGS").is_some() {
        std::fs::write(&path, &text).expect("the binding is written");
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(committed == text, "{} is old; UPDATE_BINDINGS=1 writes it anew", path.display());
}
