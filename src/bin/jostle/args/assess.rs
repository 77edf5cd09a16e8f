//! How networks are held against engines, and what the library foretells against a robot.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::planner::PhysicsArgs;
use super::{ExecutingArgs, JsonArgs, parse_range};

#[derive(Debug, Subcommand)]
pub enum AssessCommand {
    /// Several pushes in a row, each predicted on the prediction before: how far engines stray from a reference
    Chain(AssessChainArgs),
    /// What a network says of grasps, where or whether, against grasps tried out in an engine with a third dimension
    Grasp(AssessGraspArgs),
    /// What is said of grasps, and where pushes are said to bring bodies, against grasps and pushes recorded of a robot
    Robot(AssessRobotArgs),
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

/// Lines of recordings by what they are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SplitArg {
    /// What constants were chosen on
    Fit,
    /// What figures are reported on
    Report,
    All,
}

impl SplitArg {
    /// The name in the files; none for all.
    pub fn name(self) -> Option<&'static str> {
        match self {
            SplitArg::Fit => Some("fit"),
            SplitArg::Report => Some("report"),
            SplitArg::All => None,
        }
    }
}

/// What a grasp has to do to count as one that went well.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum OutcomeArg {
    /// Hold the target up to the end of the swing
    Kept,
    /// Satisfy the robot's own count, which may want more
    Counted,
}

#[derive(Debug, Args)]
pub struct AssessRobotArgs {
    /// Recordings, one JSON object a line: a grasp or a push, by what it holds
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Lines to look at, by their field `split`
    #[arg(long, value_enum, default_value = "report")]
    pub split: SplitArg,
    /// The outcome of grasps that is foretold
    #[arg(long, value_enum, default_value = "kept")]
    pub outcome: OutcomeArg,
    /// The gripper whose score is looked at: robotiq_2f85_kept (the chance that it keeps the body), robotiq_2f85 (by the shape
    /// of the grip), robotiq_2f85_ur5e (whose tip's path counts for pushes) or dissertation_mask; with NAME:FILE the chance that FILE of `jostle fit grasp` has
    #[arg(long, default_value = "robotiq_2f85_kept", value_name = "NAME[:FILE]")]
    pub gripper: String,
    #[command(flatten)]
    pub physics: PhysicsArgs,
    #[command(flatten)]
    pub json: JsonArgs,
}

#[derive(Debug, Subcommand)]
pub enum FitCommand {
    /// The chance that a gripper keeps what it grasps, from recorded grasps
    Grasp(FitGraspArgs),
}

#[derive(Debug, Args)]
pub struct FitGraspArgs {
    /// Recordings, one JSON object a line; pushes among them are left alone
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Lines to fit to, by their field `split`
    #[arg(long, value_enum, default_value = "fit")]
    pub split: SplitArg,
    /// The outcome that is fitted
    #[arg(long, value_enum, default_value = "kept")]
    pub outcome: OutcomeArg,
    /// The gripper that grasped
    #[arg(long, default_value = "robotiq_2f85", value_name = "NAME")]
    pub gripper: String,
    /// Where the tables are written, for --gripper NAME:FILE
    #[arg(long, short = 'o', default_value = "-", value_name = "FILE")]
    pub output: PathBuf,
}
