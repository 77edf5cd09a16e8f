//! The command-line tool as tests run it: its output, its failures, and folders of their own.

#![allow(dead_code)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::{AtomicU32, Ordering};

use serde_json::Value;

pub fn jostle(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_jostle")).args(args).output().expect("the tool starts")
}

pub fn stdout(args: &[&str]) -> String {
    let output = jostle(args);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{args:?}: {error}");
    String::from_utf8(output.stdout).unwrap()
}

pub fn json(args: &[&str]) -> Value {
    serde_json::from_str(&stdout(args)).unwrap()
}

/// Runs a command that must fail with this status, and gives its one line.
pub fn failure(status: i32, args: &[&str]) -> String {
    let output = jostle(args);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(status), "{args:?}: {text}");
    assert!(text.starts_with("error: ") && text.lines().count() == 1, "{args:?}: {text}");
    assert!(output.stdout.is_empty(), "{args:?}");
    text.trim_end().to_string()
}

/// A folder that goes with the value.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new() -> Folder {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let name = format!("jostle-cli-{}-{}", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    pub fn path(&self, name: &str) -> String {
        self.0.join(name).to_string_lossy().into_owned()
    }

    /// Two squares so close side by side that the first cannot be grasped along one direction, but along the other.
    pub fn scene(&self, name: &str) -> String {
        let body = |x: f64| {
            format!(
                r#"{{"shape": {{"convex_polygon": [[-0.02, -0.02], [0.02, -0.02], [0.02, 0.02], [-0.02, 0.02]]}},
                    "pose": {{"x": {x}, "y": 0.0, "theta": 0.0}}}}"#
            )
        };
        let text = format!(r#"{{"version": 1, "bodies": [{}, {}], "target": 0}}"#, body(0.5), body(0.542));
        let path = self.path(name);
        std::fs::write(&path, text).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The original data, which is not part of the repository.
pub fn shared(path: &str) -> Option<String> {
    let root = std::env::var_os("JOSTLE_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let path = root.join("data").join(path);
    if !path.exists() {
        println!("skipped: {} is not there (set JOSTLE_SHARED)", path.display());
        return None;
    }
    Some(path.to_string_lossy().into_owned())
}
