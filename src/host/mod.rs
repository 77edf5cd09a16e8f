//! What the process around the library and the machine below it have in common with it: the floating-point state of a
//! thread, the process that a thread lives in, shared libraries that are found at run time.
//!
//! | file | holds |
//! |---|---|
//! | `float` | [`FloatState`]; [`Standard`]: the default state for as long as it lives, then the caller's again |
//! | `fork` | [`Home`]: the process that something was made in |
//! | `library` | [`probe`]: whether a file is an ONNX Runtime that can be used, asked without using it |
//!
//! Asking for any of it goes past what Rust checks, so `unsafe` has its place here, in functions of a few lines.

mod float;
mod fork;
mod library;

pub use float::{FloatState, Standard};
pub use fork::Home;
pub use library::{Found, own_file, probe};
