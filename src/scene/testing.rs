//! What the tests of this module share.

use std::path::{Path, PathBuf};

/// A file or folder of the data that lie beside the checkout (`JOSTLE_SHARED`, or `../shared`), or `None` with a note
/// where they are not at hand: they are not part of the project.
pub(crate) fn shared(path: &str) -> Option<PathBuf> {
    let root = std::env::var_os("JOSTLE_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let full = root.join(path);
    if full.exists() {
        return Some(full);
    }
    eprintln!("skipped: {} is not there (set JOSTLE_SHARED)", full.display());
    None
}
