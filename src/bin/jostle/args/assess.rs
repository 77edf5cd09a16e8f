//! How networks are held against engines.

use clap::{Args, Subcommand};

use super::{ExecutingArgs, JsonArgs, parse_range};

#[derive(Debug, Subcommand)]
pub enum AssessCommand {
    /// Several pushes in a row, each predicted on the prediction before: how far engines stray from a reference
    Chain(AssessChainArgs),
    /// What a network says of grasps, where or whether, against grasps tried out in an engine with a third dimension
    Grasp(AssessGraspArgs),
}

/// Scenes that training data of the same family of shapes holds back.
#[derive(Debug, Clone, Args)]
pub struct HeldOutArgs {
    /// Shapes of the family
    #[arg(long, default_value_t = 4096, value_name = "N")]
    pub shapes: usize,
    /// Seed of the family
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub shape_seed: u64,
    /// Seed of the scenes
    #[arg(long, default_value_t = 1000, value_name = "N")]
    pub seed: u64,
}

#[derive(Debug, Args)]
pub struct AssessChainArgs {
    /// Engines that predict, with commas between: ENGINE, ENGINE:PRESET, dipn:FILE
    #[arg(long, default_value = "dipn,planar,rapier", value_delimiter = ',', value_name = "ENGINES")]
    pub physics: Vec<String>,
    #[command(flatten)]
    pub judge: ExecutingArgs,
    /// Number of chains
    #[arg(long, short = 'n', default_value_t = 100, value_name = "N")]
    pub count: usize,
    /// Pushes in a row
    #[arg(long, default_value_t = 4, value_name = "N")]
    pub pushes: usize,
    /// Least and greatest number of bodies, as in 5..9 (both included), at most 12 [default: 3..12]
    #[arg(long, value_name = "A..B", value_parser = parse_range)]
    pub bodies: Option<(usize, usize)>,
    #[command(flatten)]
    pub scenes: HeldOutArgs,
    #[command(flatten)]
    pub json: JsonArgs,
}

#[derive(Debug, Args)]
pub struct AssessGraspArgs {
    /// A network of kind gn (where to grasp) or gc (whether): the name of a built-in one or a file
    #[arg(default_value = "gn", value_name = "MODEL")]
    pub model: String,
    #[command(flatten)]
    pub judge: ExecutingArgs,
    /// Number of targets; for gn of those that some grasp can take
    #[arg(long, short = 'n', default_value_t = 300, value_name = "N")]
    pub count: usize,
    #[command(flatten)]
    pub scenes: HeldOutArgs,
    #[command(flatten)]
    pub json: JsonArgs,
}
