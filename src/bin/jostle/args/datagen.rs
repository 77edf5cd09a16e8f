//! What training data can be asked for.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::{JsonArgs, parse_range};

#[derive(Debug, Subcommand)]
pub enum DatagenCommand {
    /// Pushes in packed and loose scenes, and the motion of every body
    Push(DatagenPushArgs),
    /// States and the value of every push, by a search
    Ppn(DatagenPpnArgs),
    /// Targets, their best grasp, and the score of every grasp on a grid
    Grasp(DatagenGraspArgs),
    /// Label images of whole scenes
    Segment(DatagenSegmentArgs),
}

/// Where training data goes, and what it depends on whatever its kind.
#[derive(Debug, Clone, Args)]
pub struct DatagenArgs {
    /// The folder; made if it does not exist. Whole shards of the same data are kept
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
    /// Rows in all; more than an earlier run asked for completes its folder
    #[arg(long, short = 'n', default_value_t = 16384, value_name = "N")]
    pub count: usize,
    /// Rows of a shard
    #[arg(long, default_value_t = 16384, value_name = "N")]
    pub shard: usize,
    /// Seed of everything random but the shapes
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub seed: u64,
    /// Worker threads; they change nothing but the time [default: one for each core]
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Least and greatest number of bodies, as in 5..9 (both included), at most 12 [default: the kind's]
    #[arg(long, value_name = "A..B", value_parser = parse_range)]
    pub bodies: Option<(usize, usize)>,
    /// Shapes of the family: the seven blocks and drawn ones; a tenth of those drawn is for validation, a tenth for tests
    #[arg(long, default_value_t = 4096, value_name = "N")]
    pub shapes: usize,
    /// Seed of the family
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub shape_seed: u64,
    #[command(flatten)]
    pub json: JsonArgs,
}

#[derive(Debug, Args)]
pub struct DatagenPpnArgs {
    #[command(flatten)]
    pub data: DatagenArgs,
    /// Scenes: the generator's packed blocks, or the mixture that pushes are made in
    #[arg(long, value_enum, default_value = "generated")]
    pub from: FromArg,
    /// Iterations of a search
    #[arg(long, default_value_t = 300, value_name = "N")]
    pub iterations: u64,
    /// A network of kind ppn that guides the search: a file, or the name of a built-in one [default: none guides it]
    #[arg(long, value_name = "NETWORK")]
    pub prior: Option<String>,
    /// Push sampler
    #[arg(long, default_value = "more", value_name = "NAME")]
    pub sampler: String,
    /// States of a scene, each led to by a push from the one before
    #[arg(long, default_value_t = 2, value_name = "N")]
    pub states: usize,
}

/// Scenes of training data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FromArg {
    /// Packed blocks of the library; a tenth of the scenes is for validation, a tenth for tests
    Generated,
    /// Blocks and drawn shapes, packed and loose; the splits share no shape
    Mixed,
}

#[derive(Debug, Args)]
pub struct DatagenGraspArgs {
    #[command(flatten)]
    pub data: DatagenArgs,
    /// States of a scene, each led to by a push from the one before
    #[arg(long, default_value_t = 3, value_name = "N")]
    pub states: usize,
    /// Targets of a state
    #[arg(long, default_value_t = 2, value_name = "N")]
    pub targets: usize,
    /// What the labels come from: geometric, or an engine that tries out a share of the best grasps as well: bullet or
    /// bullet:PRESET
    #[arg(long, default_value = "geometric", value_name = "SOURCE")]
    pub label: String,
    /// Share of the best grasps that the engine tries out
    #[arg(long, default_value_t = 0.1, value_name = "SHARE", allow_negative_numbers = true)]
    pub trial_share: f64,
}

#[derive(Debug, Args)]
pub struct DatagenSegmentArgs {
    #[command(flatten)]
    pub data: DatagenArgs,
    /// States of a scene, each led to by a push from the one before
    #[arg(long, default_value_t = 2, value_name = "N")]
    pub states: usize,
}

#[derive(Debug, Args)]
pub struct DatagenPushArgs {
    #[command(flatten)]
    pub data: DatagenArgs,
    /// Engine that executes the pushes: ENGINE or ENGINE:PRESET
    #[arg(long, default_value = "prism:fine", value_name = "ENGINE[:PRESET]")]
    pub physics: String,
    /// Pushes from each state
    #[arg(long, default_value_t = 8, value_name = "N")]
    pub pushes: usize,
    /// States of a scene, each led to by a push from the one before
    #[arg(long, default_value_t = 3, value_name = "N")]
    pub states: usize,
}
