//! Training data for the networks: states, what was done and what came of it, in shards with a manifest.
//!
//! | file | holds |
//! |---|---|
//! | `shapes` | the family of shapes, and which of them a network may learn from |
//! | `scenes` | packed, loose and mixed scenes of them |
//! | `push` | pushes and the motion of every body |
//! | `ppn` | states and the value of every push that a search knows of |
//! | `grasp` | targets, their best grasp, and the score of every grasp on a grid |
//! | `segment` | label images of whole scenes |
//! | `assess` | networks held against engines in scenes that no training saw |
//! | `columns` | what all kinds of data have in common |
//! | `store` | shards, manifest, going on where an earlier run ended |
//! | `tensors` | the safetensors format |
//!
//! `docs/training-data.md` describes every field.

mod assess;
mod columns;
mod grasp;
mod ppn;
mod push;
mod scenes;
mod segment;
mod shapes;
mod store;
mod tensors;
#[cfg(test)]
mod tests;

pub use assess::{
    Agreement, ChainEngine, ChainParams, ChainReport, ChainStep, ClassifierTrials, EngineMaker, GraspTally,
    GraspTrialParams, GraspTrials, NamedGrasp, ReliabilityBin, StatedProbability, chains, try_classifier, try_grasps,
};
pub use grasp::{GRASP_ANGLES, GRASP_CELLS, GRASP_PIXEL, GRASP_SIZE, GraspDataParams, grasp};
pub use ppn::{PpnParams, ppn};
pub use push::{PushParams, push};
pub use scenes::{SceneMaker, SceneMix, SceneParams, TrainingScene, WIDTH};
pub use segment::{SEGMENT_PIXEL, SEGMENT_SIZE, SegmentParams, segment};
pub use shapes::{FamilyShape, OUTLINE_POINTS, ShapeFamily, Split, outline_points};
pub use store::{MANIFEST, MAX_SHARD, Made, Manifest, SHAPES, ShapesEntry, ShardEntry, Statistics, StoreParams};
