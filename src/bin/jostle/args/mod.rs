//! The command line: what can be asked for, and the library's options made of it.

use std::path::{Path, PathBuf};

use clap::error::ErrorKind;
use clap::{Args, Parser, Subcommand, ValueEnum};
use jostle::eval::Against;
use jostle::physics::PhysicsOptions;
use jostle::scene::arc::ArcProfile;

use crate::output::{Failure, Outcome};

mod assess;
mod datagen;
mod grasps;
mod planner;
mod results;

pub use assess::*;
pub use datagen::*;
pub use grasps::*;
pub use planner::*;
pub use results::*;

/// Plans for robots that push and grasp in clutter.
#[derive(Debug, Parser)]
#[command(name = "jostle", version, propagate_version = true, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Decide what to do in one scene
    Plan(PlanArgs),
    /// List the best grasps of a body, or say what there is to know of given ones
    Grasps(GraspsArgs),
    /// Run a planner in closed loop over a suite of problems, against a judge that differs from its model
    Run(RunArgs),
    /// Run a list of experiments and write the results document; goes on where an earlier run ended
    Results(ResultsArgs),
    /// Write random problems that cannot be solved by a grasp alone
    Generate(GenerateArgs),
    /// Compare an engine with recorded pushes
    Fidelity(FidelityArgs),
    /// Record pushes that an engine executes in generated scenes
    Record(RecordArgs),
    /// Execute plans of one engine in another, and say which of them succeed there
    Crosscheck(CrosscheckArgs),
    /// Measure speed
    #[command(subcommand)]
    Bench(BenchCommand),
    /// Draw a scene or a plan
    Render(RenderArgs),
    /// Write what a camera above the table sees, as an image (PGM)
    Observe(ObserveArgs),
    /// Say what a network's file is and check it; without a file, list the built-in networks and what runs them
    Model(ModelArgs),
    /// Hold networks against engines in scenes and shapes that no training saw, and what is foretold against a robot
    #[command(subcommand)]
    Assess(AssessCommand),
    /// Fit what the library foretells to recordings of a robot
    #[command(subcommand)]
    Fit(FitCommand),
    /// Make training data for the networks: shards of tensors and a manifest; goes on where an earlier run ended
    #[command(subcommand)]
    Datagen(DatagenCommand),
}

#[derive(Debug, Subcommand)]
#[allow(clippy::large_enum_variant)] // One of them exists in a run.
pub enum BenchCommand {
    /// Pushes a second of every preset, on one thread and on two
    Push(BenchPushArgs),
    /// The search: cost of its bookkeeping, punctuality, reaction to cancelling, sameness at any number of threads; every
    /// planner's limits and cancels
    Search(BenchSearchArgs),
    /// Path queries of one body among others: answers a second, on one thread
    Path(BenchPathArgs),
    /// Networks: milliseconds of a call and of an item
    Net(BenchNetArgs),
    /// Images of generated tables, and scenes and poses from images: cost and accuracy, on one thread
    Image(BenchImageArgs),
}

#[derive(Debug, Args)]
pub struct ModelArgs {
    /// An ONNX file, or the name of a built-in network
    #[arg(value_name = "MODEL")]
    pub model: Option<String>,
    /// What it must be: dipn, ppn, gc, gn or segmentation [default: any]
    #[arg(long, value_name = "KIND")]
    pub kind: Option<String>,
    /// The library of ONNX Runtime [default: ORT_DYLIB_PATH, beside the program, the system's]
    #[arg(long, value_name = "FILE")]
    pub runtime: Option<PathBuf>,
    #[command(flatten)]
    pub json: JsonArgs,
}

#[derive(Debug, Args)]
pub struct BenchNetArgs {
    /// ONNX files and names of built-in networks [default: all built-in ones]
    #[arg(value_name = "MODEL")]
    pub models: Vec<String>,
    /// Items of a call
    #[arg(long, value_delimiter = ',', default_value = "1,16,64", value_name = "N,...")]
    pub batches: Vec<usize>,
    /// Bodies of a scene, for networks that know bodies
    #[arg(long, default_value_t = 10, value_name = "N")]
    pub objects: usize,
    /// Seconds of each measurement
    #[arg(long, default_value_t = 1.0, value_name = "SECONDS")]
    pub seconds: f64,
    /// Threads of one call
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub threads: usize,
    /// The library of ONNX Runtime [default: ORT_DYLIB_PATH, beside the program, the system's]
    #[arg(long, value_name = "FILE")]
    pub runtime: Option<PathBuf>,
    /// onnxruntime, or tract where it was built in [default: the first that is found]
    #[arg(long, value_name = "NAME")]
    pub backend: Option<String>,
    #[command(flatten)]
    pub json: JsonArgs,
}

/// Where a report goes.
#[derive(Debug, Clone, Args)]
pub struct JsonArgs {
    /// Write the report as JSON to FILE, or to standard output in place of the text (no FILE, or -)
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "-")]
    pub json: Option<PathBuf>,
}

/// Conventions of the original test cases (text files).
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ProfileArg {
    /// By the folder: `confined` is pmbs, anything else is more
    Auto,
    /// Workspace of 0.448 m, pushes of nominal 0.10 m, all blocks 0.1 kg
    More,
    /// Workspace of 0.288 m, pushes of 0.05 m, masses by block, at most 16 actions
    Pmbs,
}

impl ProfileArg {
    /// The profile that was asked for; none for `auto`.
    pub fn profile(self) -> Option<ArcProfile> {
        match self {
            ProfileArg::Auto => None,
            ProfileArg::More => Some(ArcProfile::More),
            ProfileArg::Pmbs => Some(ArcProfile::Pmbs),
        }
    }

    /// The profile of a file.
    pub fn of(self, path: &Path) -> ArcProfile {
        self.profile().unwrap_or_else(|| ArcProfile::of_path(path))
    }
}

#[derive(Debug, Args)]
pub struct PlanArgs {
    /// A scene file (JSON) or an original test case (text)
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    #[command(flatten)]
    pub planner: PlannerArgs,
    /// Conventions for an original test case
    #[arg(long, value_enum, default_value = "auto")]
    pub profile: ProfileArg,
    #[command(flatten)]
    pub json: JsonArgs,
    /// Draw the plan into this file
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Draw why it was chosen: a panel for each of the best first actions
    #[arg(long, value_name = "FILE")]
    pub explain: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct RunArgs {
    /// A folder of scenes, a single scene, generated:N[:SEED], or a suite of this tool: own-hard, own-confined, deep,
    /// rearrange (40 rearrangements), clear-random (30 tables to be cleared) or clear-packed (10)
    #[arg(value_name = "SUITE", required_unless_present = "suite_option")]
    pub suite: Option<String>,
    /// The same by name
    #[arg(long = "suite", id = "suite_option", value_name = "SUITE", conflicts_with = "suite")]
    pub suite_option: Option<String>,
    #[command(flatten)]
    pub planner: PlannerArgs,
    #[command(flatten)]
    pub judge: JudgeArgs,
    /// Trials of each problem
    #[arg(long, default_value_t = 5, value_name = "N")]
    pub trials: u64,
    /// A trial fails after this many actions [default: 16 with the pmbs profile, three for each body of a table to be
    /// cleared, else 30]
    #[arg(long, value_name = "N")]
    pub max_actions: Option<usize>,
    /// Execute every plan to its end instead of planning anew after each action (rearrangements)
    #[arg(long)]
    pub open_loop: bool,
    /// Runs of hbfs with seeds of their own, of which the best counts (rearrangements)
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seeds: usize,
    /// The ablation of pmmr without R_b, the reward of the initial state that is subtracted (rearrangements)
    #[arg(long)]
    pub no_base_reward: bool,
    /// Conventions for original test cases and generated problems
    #[arg(long, value_enum, default_value = "auto")]
    pub profile: ProfileArg,
    #[command(flatten)]
    pub json: JsonArgs,
}

impl RunArgs {
    pub fn suite(&self) -> &str {
        self.suite.as_deref().or(self.suite_option.as_deref()).unwrap_or_default()
    }
}

#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct GenerateArgs {
    #[command(subcommand)]
    pub kind: Option<GenerateKind>,
    /// Folder that the scenes are written to; made if it does not exist
    #[arg(value_name = "FOLDER", required = true)]
    pub folder: Option<PathBuf>,
    /// Number of problems
    #[arg(long, short = 'n', default_value_t = 20, value_name = "N")]
    pub count: usize,
    /// Least and greatest number of bodies, as in 5..9 (both included)
    #[arg(long, value_name = "A..B", value_parser = parse_range)]
    pub bodies: Option<(usize, usize)>,
    /// Workspace and masses
    #[arg(long, value_enum, default_value = "more")]
    pub profile: ProfileArg,
    /// Least number of pushes that every scene needs, proved by trying all shorter plans
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=3))]
    pub pushes: u32,
    /// A gripper to take the place of the profile's
    #[arg(long, value_name = "NAME")]
    pub gripper: Option<String>,
    /// Seed of everything random
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub seed: u64,
    #[command(flatten)]
    pub json: JsonArgs,
}

#[derive(Debug, Subcommand)]
pub enum GenerateKind {
    /// Write random rearrangements that can be solved, but not by bringing one body after the other to its goal
    Rearrange(GenerateRearrangeArgs),
    /// Write random tables to be cleared: clutter, or tight packs in which hardly a grasp is possible at first
    Clear(GenerateClearArgs),
}

#[derive(Debug, Args)]
pub struct GenerateClearArgs {
    /// Folder that the scenes are written to; made if it does not exist
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
    /// What lies on the table
    #[arg(long, default_value = "random", value_name = "KIND", value_parser = ["random", "packed"])]
    pub kind: String,
    /// Number of problems
    #[arg(long, short = 'n', default_value_t = 30, value_name = "N")]
    pub count: usize,
    /// Least and greatest number of bodies, as in 10..30 (both included) [default: the kind's]
    #[arg(long, value_name = "A..B", value_parser = parse_range)]
    pub bodies: Option<(usize, usize)>,
    /// The gripper that can take every body when it is alone [default: robotiq_2f85]
    #[arg(long, value_name = "NAME")]
    pub gripper: Option<String>,
    /// Seed of everything random
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub seed: u64,
    #[command(flatten)]
    pub json: JsonArgs,
}

#[derive(Debug, Args)]
pub struct GenerateRearrangeArgs {
    /// Folder that the scenes are written to; made if it does not exist
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
    /// Number of problems
    #[arg(long, short = 'n', default_value_t = 20, value_name = "N")]
    pub count: u64,
    /// Difficulty
    #[arg(long, default_value = "normal", value_name = "LEVEL", value_parser = ["easy", "normal", "hard"])]
    pub level: String,
    /// Least and greatest number of bodies, as in 4..8 (both included) [default: the level's]
    #[arg(long, value_name = "A..B", value_parser = parse_range)]
    pub bodies: Option<(usize, usize)>,
    /// Least and greatest part of the table that is covered, as in 0.3..0.4 [default: the level's]
    #[arg(long, value_name = "A..B", value_parser = parse_shares)]
    pub fill: Option<[f64; 2]>,
    /// Seed of everything random
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub seed: u64,
    #[command(flatten)]
    pub json: JsonArgs,
}

fn parse_shares(text: &str) -> Result<[f64; 2], String> {
    let number = |part: &str| part.parse::<f64>().map_err(|e| format!("`{part}`: {e}"));
    let (low, high) = text.split_once("..").ok_or("write the least, two dots, the greatest")?;
    Ok([number(low)?, number(high)?])
}

#[derive(Debug, Args)]
pub struct BenchPathArgs {
    /// A file of queries; written first if it does not exist
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Number of queries to write
    #[arg(long, short = 'n', default_value_t = 200, value_name = "N")]
    pub count: usize,
    /// Times that every query is answered; the least time counts
    #[arg(long, default_value_t = 5, value_name = "N")]
    pub rounds: usize,
    /// Seed of the queries
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub seed: u64,
    #[command(flatten)]
    pub json: JsonArgs,
}

#[derive(Debug, Args)]
pub struct BenchImageArgs {
    /// Number of tables
    #[arg(long, short = 'n', default_value_t = 30, value_name = "N")]
    pub count: usize,
    /// Bodies on each
    #[arg(long, default_value_t = 10, value_name = "N")]
    pub bodies: usize,
    /// Share of the pixels at borders that are turned over, in [0, 1]
    #[arg(long, default_value_t = 0.0, value_name = "P")]
    pub noise: f64,
    /// Times that everything is done; the least time counts
    #[arg(long, default_value_t = 5, value_name = "N")]
    pub rounds: usize,
    /// Seed of tables and noise
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub seed: u64,
    #[command(flatten)]
    pub json: JsonArgs,
}

fn parse_range(text: &str) -> Result<(usize, usize), String> {
    let number = |part: &str| part.parse::<usize>().map_err(|e| format!("`{part}`: {e}"));
    let (low, high) = match text.split_once("..") {
        Some((low, high)) => (number(low)?, number(high.strip_prefix('=').unwrap_or(high))?),
        None => (number(text)?, number(text)?),
    };
    if low == 0 || low > high {
        return Err(format!("{low}..{high} is no range of body counts; write the least, two dots, the greatest"));
    }
    Ok((low, high))
}

#[derive(Debug, Args)]
pub struct FidelityArgs {
    /// Recorded pushes, one JSON object a line
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    #[command(flatten)]
    pub physics: PhysicsArgs,
    /// Recorded result to compare with
    #[arg(long, value_enum, default_value = "recorded")]
    pub against: AgainstArg,
    #[command(flatten)]
    pub json: JsonArgs,
}

#[derive(Debug, Args)]
pub struct RecordArgs {
    /// The file that the recorded pushes are written to, one JSON object a line
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    #[command(flatten)]
    pub physics: PhysicsArgs,
    /// Number of pushes
    #[arg(long, short = 'n', default_value_t = 200, value_name = "N")]
    pub count: usize,
    /// Least and greatest number of bodies, as in 5..9 (both included)
    #[arg(long, value_name = "A..B", value_parser = parse_range)]
    pub bodies: Option<(usize, usize)>,
    /// Seed of scenes and pushes
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub seed: u64,
}

#[derive(Debug, Args)]
pub struct CrosscheckArgs {
    /// A folder of scenes, a single scene, or generated:N[:SEED]
    #[arg(value_name = "SUITE")]
    pub suite: String,
    #[command(flatten)]
    pub planner: PlannerArgs,
    #[command(flatten)]
    pub judge: ExecutingArgs,
    /// Conventions for original test cases and generated problems
    #[arg(long, value_enum, default_value = "auto")]
    pub profile: ProfileArg,
    #[command(flatten)]
    pub json: JsonArgs,
}

/// The engine that executes what another one planned.
#[derive(Debug, Clone, Args)]
pub struct ExecutingArgs {
    /// Engine that executes the plans: ENGINE, ENGINE:PRESET, or a preset of rapier [default: bullet where it is built,
    /// else rapier:fine]
    #[arg(long, value_name = "ENGINE[:PRESET]")]
    pub judge: Option<String>,
}

impl ExecutingArgs {
    pub fn physics(&self) -> Outcome<PhysicsOptions> {
        planner::judging_engine(self.judge.as_deref())
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AgainstArg {
    /// The push as it was recorded
    Recorded,
    /// The same push in a fresh world
    Fresh,
}

impl From<AgainstArg> for Against {
    fn from(arg: AgainstArg) -> Against {
        match arg {
            AgainstArg::Recorded => Against::Recorded,
            AgainstArg::Fresh => Against::Fresh,
        }
    }
}

#[derive(Debug, Args)]
pub struct BenchPushArgs {
    /// Recorded pushes to repeat [default: pushes sampled in generated scenes]
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Engines to measure side by side, with commas between
    #[arg(long, default_value = "rapier", value_name = "ENGINES")]
    pub physics: String,
    /// Measure this preset only
    #[arg(long, value_name = "NAME")]
    pub preset: Option<String>,
    /// Pushes in a call of the engine [default: what the engine is best at]
    #[arg(long, value_name = "N")]
    pub batch: Option<usize>,
    /// Dense packs of this many bodies, for speed only [default: generated scenes of 5 to 12]
    #[arg(long, value_name = "N", conflicts_with = "file")]
    pub bodies: Option<usize>,
    /// Time to measure for, in seconds; every variant runs at least three times
    #[arg(long, default_value_t = 20.0, value_name = "SECONDS", allow_negative_numbers = true)]
    pub seconds: f64,
    /// Seed of the generated scenes
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub seed: u64,
    #[command(flatten)]
    pub json: JsonArgs,
}

#[derive(Debug, Args)]
pub struct BenchSearchArgs {
    /// A scene to plan in [default: a generated one of seven bodies]
    #[arg(value_name = "SCENE")]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub planner: PlannerArgs,
    /// Decisions to measure punctuality with
    #[arg(long, default_value_t = 1000, value_name = "N")]
    pub decisions: usize,
    /// Nothing but how every planner keeps limits of 1, 5, 20 and 100 ms and obeys a cancel
    #[arg(long, conflicts_with_all = ["scene", "decisions"])]
    pub limits_only: bool,
    /// The planners of that part [default: all of them]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub planners: Vec<String>,
    /// Its numbers of bodies
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "5,10,20,40,128")]
    pub bodies: Vec<usize>,
    /// Its decisions of every planner with every number of bodies: a quarter at each limit, and as many cancelled ones
    #[arg(long, default_value_t = 300, value_name = "N")]
    pub each: usize,
    #[command(flatten)]
    pub json: JsonArgs,
}

#[derive(Debug, Args)]
pub struct RenderArgs {
    /// A scene file, an original test case, or a plan written by `plan --json`
    #[arg(value_name = "SCENE|PLAN")]
    pub input: PathBuf,
    /// The picture
    #[arg(long, short, value_name = "FILE")]
    pub output: PathBuf,
    /// One picture that moves instead of one for each action (rearrangements)
    #[arg(long)]
    pub animated: bool,
    /// Conventions for an original test case
    #[arg(long, value_enum, default_value = "auto")]
    pub profile: ProfileArg,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ImageArg {
    /// 0 for the table, k + 1 for body k
    Labels,
    /// Tenths of a millimetre above the table, 16 bits
    Heights,
    /// 255 for bodies, 0 for the table
    Foreground,
    /// 255 for the target, 0 for all else
    Target,
}

#[derive(Debug, Args)]
pub struct ObserveArgs {
    /// A scene file or an original test case
    #[arg(value_name = "SCENE")]
    pub input: PathBuf,
    /// The image; its first row is that of the least y
    #[arg(long, short, value_name = "FILE")]
    pub output: PathBuf,
    /// What the pixels say
    #[arg(long, value_enum, default_value = "labels")]
    pub image: ImageArg,
    /// Side of a pixel, metres
    #[arg(long, default_value_t = 0.002, value_name = "M")]
    pub pixel: f64,
    /// About the target instead of the whole workspace: pixels on a side
    #[arg(long, value_name = "N")]
    pub crop: Option<usize>,
    /// Heading of the rows, radians from +x of the world
    #[arg(long, default_value_t = 0.0, value_name = "RAD", allow_negative_numbers = true)]
    pub heading: f64,
    /// Conventions for an original test case
    #[arg(long, value_enum, default_value = "auto")]
    pub profile: ProfileArg,
}

/// Reads the arguments. Help and version go to standard output; a mistake becomes one line.
pub fn parse() -> Outcome<Option<Cli>> {
    match Cli::try_parse() {
        Ok(cli) => Ok(Some(cli)),
        Err(error) if !error.use_stderr() => {
            crate::output::emit(&error.to_string())?;
            Ok(None)
        }
        Err(error) if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            Err(Failure::usage("a command is missing; see --help"))
        }
        Err(error) => {
            let text = error.to_string();
            let text = text.strip_prefix("error: ").unwrap_or(&text);
            let end =
                ["\n\nUsage:", "\n\n  tip:", "\n\nFor more information"].iter().filter_map(|m| text.find(m)).min();
            let reason = text[..end.unwrap_or(text.len())].split_whitespace().collect::<Vec<_>>().join(" ");
            Err(Failure::usage(format!("{reason}; see --help")))
        }
    }
}
