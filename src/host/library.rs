//! Shared libraries of ONNX Runtime, asked for their version before anything relies on them.
//!
//! The binding (`ort` 2.0.0-rc.14) keeps the first library that it was given for good, whether it could be used or not: what
//! it is asked of afterwards is memory that was never set. So it is only ever given one that this file has tried.
#![allow(unsafe_code)]

use std::ffi::CStr;
use std::path::{Path, PathBuf};

use libloading::Library;
use ort::sys::OrtApiBase;

type GetApiBase = unsafe extern "system" fn() -> *const OrtApiBase;

/// A library that can be used. It stays loaded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    pub version: String,
    /// The file that it was loaded from, where the system's search path was asked.
    pub file: PathBuf,
}

/// Loads the library and asks it for its version; refuses, and unloads, what is not ONNX Runtime 1.`minor` or newer, with
/// the end of a sentence that begins with the file's name. `path` is absolute, or a bare name for the system's search path.
///
/// Loading a library runs code of it: that is what a user who names one asks for.
pub fn probe(path: &Path, minor: u32) -> Result<Found, String> {
    // SAFETY: the initialisers of a shared library run; whoever named it answers for them, as for every program started.
    let library = unsafe { Library::new(path) }.map_err(|error| {
        let source = std::error::Error::source(&error).map(ToString::to_string);
        let reason = source.unwrap_or_else(|| error.to_string());
        format!("cannot be loaded ({reason})")
    })?;
    let none = || "is not ONNX Runtime (it has no OrtGetApiBase)".to_string();
    // SAFETY: the function of this name has this type in every version (onnxruntime_c_api.h).
    let get = unsafe { library.get::<GetApiBase>(b"OrtGetApiBase\0") }.map_err(|_| none())?;
    let address = *get as usize;
    // SAFETY: called as the header has it; the table it gives lives as long as the library, which is held here.
    let base = unsafe { get().as_ref() }.ok_or_else(none)?;
    // SAFETY: as above.
    let text = unsafe { (base.GetVersionString)() };
    if text.is_null() {
        return Err("does not say its version".into());
    }
    // SAFETY: a text that ends with a zero and belongs to the library.
    let version = unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned();
    if !suits(&version, minor) {
        return Err(format!("is version {version}; 1.{minor} or newer is needed"));
    }
    // SAFETY: as above.
    if unsafe { (base.GetApi)(minor) }.is_null() {
        return Err(format!("is version {version} without the interface of 1.{minor}, which is needed"));
    }
    let file = if path.is_absolute() { path.to_path_buf() } else { mapped(address).unwrap_or(path.to_path_buf()) };
    // What is used from now on is never unloaded.
    std::mem::forget(library);
    Ok(Found { version, file })
}

/// The first version that differs in its first number is one that nobody has seen.
fn suits(version: &str, minor: u32) -> bool {
    let mut numbers = version.split('.').map(str::parse::<u32>);
    matches!((numbers.next(), numbers.next()), (Some(Ok(1)), Some(Ok(found))) if found >= minor)
}

/// The file that the code at this address was loaded from.
fn mapped(address: usize) -> Option<PathBuf> {
    let maps = std::fs::read_to_string("/proc/self/maps").ok()?;
    maps.lines().find_map(|line| {
        let (range, path) = mapping(line)?;
        range.contains(&address).then_some(path)
    })
}

/// A line of `/proc/self/maps`: addresses and file.
fn mapping(line: &str) -> Option<(std::ops::Range<usize>, PathBuf)> {
    let (range, rest) = line.split_once(' ')?;
    let (from, to) = range.split_once('-')?;
    let path = rest.find('/').map(|at| PathBuf::from(&rest[at..]))?;
    Some((usize::from_str_radix(from, 16).ok()?..usize::from_str_radix(to, 16).ok()?, path))
}

/// The file that this code was loaded from: jostle's shared library, or the program it is linked into.
pub fn own_file() -> Option<PathBuf> {
    mapped(own_file as *const () as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_of_this_code_is_found() {
        let own = own_file().unwrap().canonicalize().unwrap();
        assert_eq!(own, std::env::current_exe().unwrap().canonicalize().unwrap());
    }

    #[test]
    fn versions_are_numbers() {
        for (version, fits) in [
            ("1.24.0", true),
            ("1.24", true),
            ("1.100.1", true),
            ("1.9.0", false),
            ("1.23.9", false),
            ("2.30.0", false),
            ("", false),
            ("main", false),
        ] {
            assert_eq!(suits(version, 24), fits, "{version}");
        }
    }
}
