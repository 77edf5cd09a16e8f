//! jostle: planning for robots that work in clutter.
//!
//! The map, in dependency order (`ARCHITECTURE.md` explains it; a test holds the code to it):
//! `error` <- {`bounds`, `files`} <- `geom` <- `scene` <- `action` <- `vision` <- {`physics`, `grasp`, `motion`} <- `plan` <- {`eval`, `record`}
//! <- {`datagen`, `ffi`}.
//! `search`, `run` and `host` stand aside: they know only `error` and each other.

#![deny(unsafe_code)]

pub mod action;
pub mod bounds;
pub mod datagen;
pub mod error;
pub mod eval;
#[allow(unsafe_code)]
pub mod ffi;
pub mod files;
pub mod geom;
pub mod grasp;
pub mod host;
pub mod motion;
pub mod net;
pub mod physics;
pub mod plan;
pub mod record;
pub mod run;
pub mod scene;
pub mod search;
pub mod vision;

pub use error::{Error, Result};

/// The Rust program of the README is compiled and run as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
