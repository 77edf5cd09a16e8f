//! The C API: everything that crosses the boundary, and nothing else.
//!
//! The rules are in `docs/c-api.md`. The header `include/jostle/jostle.h` is generated from this module by
//! `UPDATE_HEADER=1 cargo test --test header`; the doc comments here are the C documentation.
//!
//! | file | holds |
//! |---|---|
//! | `handle` | the table of live handles: a dead or foreign handle is found without touching memory behind it |
//! | `guard` | what every function runs in: panics, last error, log |
//! | `abi` | sized structs, strings, arrays, outputs |
//! | `status`, `log`, `version` | status codes, log messages, versions and features |
//! | `context`, `scene`, `body`, `planner`, `job`, `plan`, `cancel`, `progress`, `simulator`, `model` | one noun each |
//! | `options`, `goal`, `scene_file` | more of scenes: gripper, workspace, friction; goals; files and the generator |
//! | `image`, `camera` | images of scenes; scenes and poses from images |
//! | `grasp` | grasps of a scene's bodies: the best few, and any one examined |
//! | `action` | actions, which plans and simulators share |
//! | `decider` | the two kinds of planners behind a planner's handle |

#![allow(non_camel_case_types)]
// What a caller has to keep is the header's `Thread`, `Nullable` and `Owns` lines, the same for every function.
#![allow(clippy::missing_safety_doc)]

pub mod abi;
pub mod action;
pub mod body;
pub mod camera;
pub mod cancel;
pub mod context;
mod decider;
pub mod goal;
pub mod grasp;
mod guard;
mod handle;
pub mod image;
pub mod job;
pub mod log;
pub mod model;
pub mod options;
pub mod plan;
mod plan_json;
pub mod planner;
pub mod progress;
pub mod scene;
pub mod scene_file;
pub mod simulator;
pub mod status;
pub mod tip_path;
pub mod version;

#[cfg(target_pointer_width = "32")]
compile_error!("the C API's handles need 64-bit pointers");
