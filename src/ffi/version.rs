//! Versions, features and build information.

use std::ffi::{CStr, c_char};

use super::guard::guard;
use super::handle;
use super::status::{Failure, JOSTLE_ERROR_ABI, jostle_status};
use crate::net::BUILTINS;
use crate::physics::EngineInfo;

/// Version of the binary interface: the number at the end of the shared library's name (soname). It rises only when
/// programs have to be compiled again.
pub const JOSTLE_ABI_VERSION: u32 = 0;

/// The engine `rapier`.
pub const JOSTLE_FEATURE_RAPIER: i32 = 1;
/// The engine `bullet`.
pub const JOSTLE_FEATURE_BULLET: i32 = 2;
/// Trained networks are built in. Files can be loaded in any build, where there is a runtime.
pub const JOSTLE_FEATURE_NETWORKS: i32 = 3;
/// The engine `planar`.
pub const JOSTLE_FEATURE_PLANAR: i32 = 4;
/// The engine `prism`.
pub const JOSTLE_FEATURE_PRISM: i32 = 5;

const VERSION: &CStr = match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
    Ok(text) => text,
    Err(_) => c"",
};

const BUILD_INFO: &CStr = match CStr::from_bytes_with_nul(
    concat!("jostle ", env!("CARGO_PKG_VERSION"), " abi 0 ", env!("JOSTLE_BUILD"), "\0").as_bytes(),
) {
    Ok(text) => text,
    Err(_) => c"",
};

const fn number(text: &str) -> u32 {
    let (bytes, mut value, mut i) = (text.as_bytes(), 0, 0);
    while i < bytes.len() {
        value = value * 10 + (bytes[i] - b'0') as u32;
        i += 1;
    }
    value
}

/// The number of the binary interface that the library was built with.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn jostle_abi_version() -> u32 {
    JOSTLE_ABI_VERSION
}

/// Refuses a library that does not fit the header: call jostle_abi_check(JOSTLE_ABI_VERSION) before anything else.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ABI (the caller was compiled with the header of another binary interface).
#[unsafe(no_mangle)]
pub extern "C" fn jostle_abi_check(version: u32) -> jostle_status {
    guard("jostle_abi_check", |_| {
        if version == JOSTLE_ABI_VERSION {
            return Ok(());
        }
        Err(Failure::new(
            JOSTLE_ERROR_ABI,
            format!("version: is {version}, the library's is {JOSTLE_ABI_VERSION}; compile with the library's header"),
        ))
    })
}

/// The library's version, such as "0.1.0".
///
/// Thread: any.
/// RT: yes.
/// Nullable: never returns null.
/// Owns: the library, for ever.
/// Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn jostle_version() -> *const c_char {
    VERSION.as_ptr()
}

/// The library's version as major * 10000 + minor * 100 + patch, to compare with JOSTLE_VERSION_NUMBER.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn jostle_version_number() -> u32 {
    const NUMBER: u32 = number(env!("CARGO_PKG_VERSION_MAJOR")) * 10000
        + number(env!("CARGO_PKG_VERSION_MINOR")) * 100
        + number(env!("CARGO_PKG_VERSION_PATCH"));
    NUMBER
}

/// Version, target, profile and compiler of the library, for bug reports.
///
/// Thread: any.
/// RT: yes.
/// Nullable: never returns null.
/// Owns: the library, for ever.
/// Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn jostle_build_info() -> *const c_char {
    BUILD_INFO.as_ptr()
}

/// 1 if this build has the JOSTLE_FEATURE_ of that number, 0 if not or if the number is unknown. Every function exists
/// in every build; what needs an absent feature returns JOSTLE_ERROR_UNSUPPORTED.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn jostle_feature(feature: i32) -> u32 {
    if feature == JOSTLE_FEATURE_NETWORKS {
        return u32::from(!BUILTINS.is_empty());
    }
    let engine = match feature {
        JOSTLE_FEATURE_RAPIER => "rapier",
        JOSTLE_FEATURE_BULLET => "bullet",
        JOSTLE_FEATURE_PLANAR => "planar",
        JOSTLE_FEATURE_PRISM => "prism",
        _ => return 0,
    };
    u32::from(EngineInfo::available().any(|info| info.id == engine))
}

/// How many handles of all types are alive in the process: 0 once everything was freed.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn jostle_handle_count() -> u64 {
    handle::live()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_version_is_the_manifests() {
        assert_eq!(VERSION.to_str().unwrap(), env!("CARGO_PKG_VERSION"));
        assert_eq!(jostle_version_number(), 100);
        let info = BUILD_INFO.to_str().unwrap();
        assert!(info.starts_with("jostle 0.1.0 abi 0 ") && info.contains("rustc"), "{info}");
        assert_eq!(number("120"), 120);
    }
}
