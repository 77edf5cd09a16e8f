//! Trained networks: the runtime that computes them, their files and checks, and one narrow interface for each kind.
//!
//! | file | holds |
//! |---|---|
//! | `kind` | [`Kind`], [`Interface`]: which tensors a network of a kind has |
//! | `onnx` | [`OnnxInfo`]: what a file says of itself, read without a runtime |
//! | `graph`, `sizes` | its operators, and how big they make it, told before a runtime sees it |
//! | `info` | [`ModelInfo`], [`ModelSpec`]: the settings that a network was made for; [`Configuration`]: those wanted |
//! | `file` | the checks of a file, in their order |
//! | `self_test` | the last of them |
//! | `runtime` | [`Runtime`]: ONNX Runtime, found when it is needed, or the embedded backend |
//! | `model` | [`Model`]: a network that runs |
//! | `builtin` | the networks that are part of the library |
//! | `objects` | states and pushes as the networks on objects are told of them |
//! | `dipn`, `ppn` | [`Dipn`], a [`MotionModel`]; [`Ppn`], a [`PushValue`] |
//! | `images` | [`Gc`] and [`Gn`], on the image of a target |
//! | `segmentation` | [`Segmentation`]: instances in an image |
//!
//! `docs/networks.md` is the user's page.

mod builtin;
mod dipn;
mod file;
mod graph;
mod gripper;
mod images;
mod info;
mod kind;
mod model;
mod objects;
mod onnx;
mod ppn;
mod runtime;
mod segmentation;
mod self_test;
mod sizes;
mod watch;

pub use builtin::{BUILTINS, Builtin};
pub use dipn::{Dipn, MotionModel};
pub use file::{MAX_BYTES, inspect, inspect_bytes, sha256};
pub use gripper::check_gripper;
pub use images::{Gc, Gn, GraspMap, ImageScratch, MapGrasp, TargetProbability};
pub use info::{Configuration, ModelInfo, ModelSpec};
pub use kind::{Axis, GRASP_ANGLES, INTERFACES, Interface, Kind, OUTLINE_POINTS, TensorSpec};
pub use model::{Device, LoadOptions, Model};
pub use objects::{ObjectBatch, ObjectTable, body_features, moved, push_frame, tip_features};
pub use onnx::{Dim, NotOnnx, OnnxInfo, TensorInfo, dtype_name};
pub use ppn::{Ppn, PushValue, PushValueScratch};
pub use runtime::{Backend, Runtime, RuntimeInfo, RuntimeOptions};
pub use segmentation::{Instances, SegmentOptions, Segmentation};
