//! Single- and double-precision Bullet export the same names. In a process that links the former our calls would reach
//! it and every number be wrong; the engine must refuse instead. Needs g++ and Bullet in both precisions (Debian:
//! libbullet-dev).
#![cfg(feature = "bullet")]

mod common;

use std::process::Command;

use common::{Link, build, has, run};

/// The flags that pkg-config knows for a library.
fn flags(library: &str) -> Option<Vec<String>> {
    let output = Command::new("pkg-config").args(["--cflags", "--libs", library]).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    // As system headers: their warnings are not ours.
    output.status.success().then(|| text.split_whitespace().map(|f| f.replacen("-I", "-isystem", 1)).collect())
}

/// What a host built with these flags prints.
fn host(name: &str, link: Link, flags: &[String]) -> String {
    // The host's libraries come before ours on the line, as they would in a program that had them first.
    let flags: Vec<&str> = ["-Wl,--no-as-needed"].into_iter().chain(flags.iter().map(String::as_str)).collect();
    run(&build(&["tests/capi/clash.cpp"], name, link, &flags))
}

#[test]
fn a_host_with_single_precision_bullet_gets_an_error_and_others_work() {
    let (Some(single), Some(double), true) = (flags("bullet"), flags("bullet-float64"), has("g++")) else {
        println!("skipped: needs g++, pkg-config and Bullet in both precisions");
        return;
    };
    for link in [Link::Shared, Link::Static] {
        let text = host("clash-none", link, &["-DNO_BULLET".to_string()]);
        assert_eq!(text, "own box: fell\nengine: made\n", "{link:?}");
        let text = host("clash-double", link, &double);
        assert_eq!(text, "own box: fell\nengine: made\n", "{link:?}");
        let text = host("clash-single", link, &single);
        assert!(text.starts_with("own box: fell\nengine: refused as unsupported: "), "{link:?}: {text}");
        assert!(text.contains("needs Bullet in double precision") && text.contains(".so"), "{link:?}: {text}");
    }
}
