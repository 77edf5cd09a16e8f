//! Finished rows, kept in a folder, so that a run can be interrupted and goes on where it ended.

use std::path::{Path, PathBuf};

use jostle::files;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};

/// What a result depends on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stamp {
    /// As a reader types it.
    pub command: String,
    /// SHA-256 of the suite's files; "built in" for the suites of the tool.
    pub suite: String,
    /// SHA-256 of the tool's program.
    pub tool: String,
}

/// When and on what a row was measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    pub version: String,
    pub commit: String,
    /// Year-month-day, UTC.
    pub date: String,
    pub processor: String,
    pub cores: usize,
    /// Rows that ran side by side.
    pub jobs: usize,
    /// Seconds from start to end.
    pub wall_s: f64,
}

/// A finished row.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    pub stamp: Stamp,
    pub origin: Origin,
    /// The report of `jostle run --json`.
    pub report: Value,
}

pub struct Store {
    folder: PathBuf,
}

impl Store {
    /// The folder is made if it is not there.
    pub fn open(folder: &Path) -> Result<Store, String> {
        std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        Ok(Store { folder: folder.to_path_buf() })
    }

    fn file(&self, command: &str) -> PathBuf {
        self.folder.join(format!("{}.json", &digest([command.as_bytes()])[..16]))
    }

    /// Where a running row writes its report.
    pub fn part(&self, command: &str) -> PathBuf {
        self.file(command).with_extension("part")
    }

    /// The result of this command, suite and tool; of any tool where `any_build`.
    pub fn find(&self, stamp: &Stamp, any_build: bool) -> Option<Kept> {
        // What cannot be read was cut off or is of another version: it is measured again.
        let text = std::fs::read_to_string(self.file(&stamp.command)).ok()?;
        let kept: Kept = serde_json::from_str(&text).ok()?;
        let same = kept.stamp.command == stamp.command
            && kept.stamp.suite == stamp.suite
            && (any_build || kept.stamp.tool == stamp.tool);
        same.then_some(kept)
    }

    /// Keeps a result: all of it or nothing.
    pub fn keep(&self, kept: &Kept) -> Result<(), String> {
        let file = self.file(&kept.stamp.command);
        let text = serde_json::to_string(kept).map_err(|e| e.to_string())?;
        files::write(file, text).map_err(|e| e.to_string())
    }
}

/// SHA-256 in hexadecimal digits.
pub fn digest<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> String {
    let mut hash = Sha256::new();
    for part in parts {
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The digest of a suite's files, in the order of their names.
pub fn suite_digest(path: &str) -> Result<String, String> {
    let path = Path::new(path);
    if !path.is_dir() {
        return Ok("built in".into());
    }
    let read = |path: &Path| std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()));
    let entries = std::fs::read_dir(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(|path| path.is_file()).collect();
    files.sort();
    let mut parts = Vec::new();
    for file in &files {
        parts.push(file.file_name().unwrap_or_default().to_string_lossy().into_owned().into_bytes());
        parts.push(read(file)?);
    }
    Ok(digest(parts.iter().map(Vec::as_slice)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_is_found_again_only_for_the_same_command_suite_and_tool() {
        let folder = std::env::temp_dir().join(format!("jostle-store-{}", std::process::id()));
        let store = Store::open(&folder).unwrap();
        let stamp = Stamp { command: "jostle run deep".into(), suite: "built in".into(), tool: "first".into() };
        let origin = Origin {
            version: "0".into(),
            commit: "c".into(),
            date: "2026-01-02".into(),
            processor: "p".into(),
            cores: 2,
            jobs: 2,
            wall_s: 1.5,
        };
        let kept = Kept { stamp: stamp.clone(), origin, report: serde_json::json!({"cases": [1.25]}) };
        store.keep(&kept).unwrap();
        let found = store.find(&stamp, false);
        let other_tool = Stamp { tool: "second".into(), ..stamp.clone() };
        let other_suite = Stamp { suite: "files".into(), ..stamp.clone() };
        let missing = (store.find(&other_tool, false), store.find(&other_suite, true));
        let any = store.find(&other_tool, true);
        std::fs::write(store.file(&stamp.command), "{\"stamp\":").unwrap();
        let cut_off = store.find(&stamp, false);
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!((found.as_ref(), any.as_ref()), (Some(&kept), Some(&kept)));
        assert_eq!((missing, cut_off), ((None, None), None));
    }

    #[test]
    fn a_suite_has_another_digest_when_a_file_changes_or_is_renamed() {
        let folder = std::env::temp_dir().join(format!("jostle-digest-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let of = |name: &str, text: &str| {
            let file = folder.join(name);
            std::fs::write(&file, text).unwrap();
            let digest = suite_digest(&folder.to_string_lossy()).unwrap();
            std::fs::remove_file(&file).unwrap();
            digest
        };
        let digests = [of("a", "x"), of("a", "y"), of("b", "x"), of("a", "x")];
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(digests[0], digests[3]);
        assert!(digests[0] != digests[1] && digests[0] != digests[2]);
        assert_eq!(suite_digest("deep").unwrap(), "built in");
    }
}
