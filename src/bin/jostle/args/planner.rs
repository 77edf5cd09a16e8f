//! How planners and judges are set up, and the library's options made of it.

use std::path::Path;

use clap::Args;
use jostle::Error;
use jostle::eval::{Executor, JudgeOptions};
use jostle::files::json;
use jostle::grasp::check_scorer;
use jostle::net::{Kind, LoadOptions, Model};
use jostle::physics::{EngineInfo, PhysicsOptions, Purpose};
use jostle::plan::{PlannerOptions, Variant};
use jostle::run::Budget;
use jostle::scene::{Gripper, Keeping};
use jostle::search::{Params, Selection};

use crate::output::{Failure, Outcome};

/// How a planner is set up.
#[derive(Debug, Clone, Args)]
pub struct PlannerArgs {
    /// The planner: hedge (fewest actions on average), pmbs (parallel waves), mcts (serial), more (guided by ppn), ppn (that
    /// network alone), vft (foresight by dipn), dipn (one push ahead); for rearrangements untangle, pmmr or hbfs; to clear a
    /// table greedy, dipn_gn (the same by two networks), or a baseline: random_push or grasp_only
    #[arg(long, default_value = "hedge", value_name = "NAME")]
    pub planner: String,
    #[command(flatten)]
    pub physics: PhysicsArgs,
    /// Engine in which the plan found and its best rivals are tried before the decision: none, ENGINE or ENGINE:PRESET
    /// [default: the planner's own choice]
    #[arg(long, value_name = "ENGINE[:PRESET]")]
    pub confirm: Option<String>,
    /// What says how good a state is: geometric, or the networks gc or gn, with SCORER:FILE a network of one's own
    /// [default: the planner's own]
    #[arg(long, value_name = "SCORER[:FILE]")]
    pub scorer: Option<String>,
    /// What values pushes before they are tried: ppn, ppn:FILE, or none [default: the planner's own]
    #[arg(long, value_name = "PRIOR[:FILE]")]
    pub prior: Option<String>,
    /// A gripper to take the place of the scene's: robotiq_2f85, robotiq_2f85_kept (scores grasps by the chance that it
    /// keeps the body), robotiq_2f85_ur5e (that one, whose tip goes as a UR5e moves it) or dissertation_mask; with NAME:FILE it scores by the chance that FILE of `jostle fit grasp` has
    #[arg(long, value_name = "NAME[:FILE]")]
    pub gripper: Option<String>,
    /// Wall-clock seconds of a decision [default: the planner's published budget]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub seconds: Option<f64>,
    /// Search iterations of a decision; a budget of iterations alone makes plans reproducible
    #[arg(long, value_name = "N")]
    pub iterations: Option<u64>,
    /// Seed of everything random
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub seed: u64,
    /// Worker threads; they never change the plan of an iteration budget [default: one for each core]
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Logical lanes of the parallel search; they do change plans [default: the planner's own]
    #[arg(long, value_name = "N")]
    pub lanes: Option<usize>,
    /// Form of the planner: tuned, or as the dissertation's text or its published code has it
    #[arg(long, value_name = "VARIANT", default_value = "tuned", value_parser = ["tuned", "dissertation", "code"])]
    pub variant: String,
    /// Push sampler [default: the planner's own]
    #[arg(long, value_name = "NAME")]
    pub sampler: Option<String>,
    /// Travel of a push in metres [default: by the profile of an original test case, else the sampler's own]
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    pub push_length: Option<f64>,
    /// Greatest number of pushes in a plan [default: the planner's own]
    #[arg(long, value_name = "N")]
    pub max_depth: Option<u32>,
    /// Weight of exploration, c in the search's upper confidence bounds: 0 trusts the returns alone, inf the visits
    /// alone [default: the planner's own]
    #[arg(long, value_name = "C", allow_negative_numbers = true)]
    pub exploration: Option<f64>,
}

/// The engine of the planner's model.
#[derive(Debug, Clone, Args)]
pub struct PhysicsArgs {
    /// Engine that predicts pushes: rapier, planar, prism, bullet or dipn [default: the planner's own; rapier to compare]
    #[arg(long, value_name = "ENGINE")]
    pub physics: Option<String>,
    /// Preset of the engine, such as fast or fine; for dipn a network's file or name [default: the one that suits planning]
    #[arg(long, value_name = "NAME")]
    pub preset: Option<String>,
}

impl PhysicsArgs {
    /// The engine on its own, outside of a planner.
    pub fn options(&self) -> Outcome<PhysicsOptions> {
        let engine = self.physics.as_deref().unwrap_or("rapier");
        Ok(PhysicsOptions::named(engine, self.preset.as_deref(), Purpose::Planning)?)
    }

    /// The same with the preset that suits judging where none is named.
    pub fn judging(&self) -> Outcome<PhysicsOptions> {
        let engine = self.physics.as_deref().unwrap_or("rapier");
        Ok(PhysicsOptions::named(engine, self.preset.as_deref(), Purpose::Judging)?)
    }
}

impl PlannerArgs {
    pub fn options(&self) -> Outcome<PlannerOptions> {
        let mut options = PlannerOptions {
            planner: self.planner.clone(),
            sampler: self.sampler.clone(),
            push_length: self.push_length,
            budget: Budget { iterations: self.iterations, seconds: self.seconds, bytes: None },
            seed: self.seed,
            threads: self.threads.unwrap_or_else(cores),
            variant: match self.variant.as_str() {
                "dissertation" => Variant::Dissertation,
                "code" => Variant::Code,
                _ => Variant::Tuned,
            },
            lanes: self.lanes,
            max_depth: self.max_depth,
            ..PlannerOptions::default()
        };
        options.set_physics(self.physics.physics.as_deref(), self.physics.preset.as_deref())?;
        options.set_confirm(self.confirm.as_deref())?;
        (options.scorer, options.scorer_model) = self.scorer()?;
        if let Some(prior) = &self.prior {
            let (name, file) = name_and_file(prior);
            options.prior = Some(name.into());
            options.prior_model = file.map(|file| network("prior", name, file)).transpose()?;
        }
        if let Some(exploration) = self.exploration {
            options.search = Some(with_exploration(options.search_params()?, exploration)?);
        }
        options.validate()?;
        Ok(options)
    }

    /// The scorer's name, and a network of one's own for it.
    pub fn scorer(&self) -> Outcome<(Option<String>, Option<Model>)> {
        let Some(scorer) = &self.scorer else { return Ok((None, None)) };
        let (name, file) = name_and_file(scorer);
        check_scorer(name)?;
        Ok((Some(name.into()), file.map(|file| network("scorer", name, file)).transpose()?))
    }

    pub fn gripper(&self) -> Outcome<Option<Gripper>> {
        self.gripper.as_deref().map(gripper).transpose()
    }
}

/// A gripper of the library, NAME or NAME:FILE, FILE with the chance that it keeps a body.
pub fn gripper(named: &str) -> Outcome<Gripper> {
    let (name, file) = name_and_file(named);
    let mut gripper = Gripper::by_name(name)?;
    if let Some(file) = file {
        let path = Path::new(file);
        let keeping: Keeping = json::read(path, "keeping")?;
        keeping.validate().map_err(|error| Error::format(path, error))?;
        (gripper.name, gripper.keeping) = (named.into(), Some(keeping));
    }
    Ok(gripper)
}

/// The search with another weight of exploration.
fn with_exploration(mut search: Params, exploration: f64) -> Outcome<Params> {
    match &mut search.selection {
        // Beside this weight no return shows.
        Selection::Ucb { exploration: own, .. } => *own = if exploration == f64::INFINITY { 1e9 } else { exploration },
        Selection::Guided { .. } => {
            return Err(Failure::usage("exploration: this planner is guided by its prior and explores by no weight"));
        }
    }
    Ok(search)
}

fn name_and_file(text: &str) -> (&str, Option<&str>) {
    text.split_once(':').map_or((text, None), |(name, file)| (name, Some(file)))
}

/// A network of one's own for a part of a planner that is named as its kind.
fn network(part: &str, name: &str, file: &str) -> Outcome<Model> {
    let kind = Kind::by_name(name).map_err(|_| Failure::usage(format!("{part}: `{name}` has no network")))?;
    Ok(Model::open(file, Some(kind), &LoadOptions::default())?)
}

pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// The world that a planner is judged in.
#[derive(Debug, Clone, Args)]
pub struct JudgeArgs {
    /// The judge: ENGINE, ENGINE:PRESET, or a preset of rapier; or robot, robot:ENGINE, robot:ENGINE:PRESET, where the
    /// recorded robot executes: its tip sinks and lifts on the way, its hand keeps and loses bodies as recorded
    /// [default: bullet where it is built, else rapier:fine; of robot: bullet where it is built, else prism]
    #[arg(long, value_name = "[robot:]ENGINE[:PRESET]")]
    pub judge: Option<String>,
    /// Every friction is scaled by up to this share up or down, drawn anew for each trial
    #[arg(long, default_value_t = 0.2, value_name = "SHARE", allow_negative_numbers = true)]
    pub friction_spread: f64,
    /// Standard deviation of observed positions in millimetres
    #[arg(long, default_value_t = 1.0, value_name = "MM", allow_negative_numbers = true)]
    pub noise_mm: f64,
    /// Standard deviation of observed headings in degrees
    #[arg(long, default_value_t = 1.0, value_name = "DEG", allow_negative_numbers = true)]
    pub noise_deg: f64,
}

/// The engine named for judging, or bullet where this build has it.
pub(super) fn judging_engine(name: Option<&str>) -> Outcome<PhysicsOptions> {
    let usual = EngineInfo::available().find(|e| e.id == "bullet").map_or("rapier", |e| e.id);
    Ok(PhysicsOptions::parse(name.unwrap_or(usual), Purpose::Judging).map_err(|e| e.within("judge"))?)
}

/// The engine named for a judge, and what executes in it.
fn judge_named(name: Option<&str>) -> Outcome<(PhysicsOptions, Executor)> {
    let Some(rest) = name.and_then(|name| name.strip_prefix("robot")) else {
        return Ok((judging_engine(name)?, Executor::Engine));
    };
    let usual = EngineInfo::available().find(|e| e.id == "bullet").map_or("prism", |e| e.id);
    let engine = match rest.strip_prefix(':') {
        Some(engine) => engine,
        None if rest.is_empty() => usual,
        None => return Ok((judging_engine(name)?, Executor::Engine)),
    };
    Ok((judging_engine(Some(engine))?, Executor::Robot))
}

impl JudgeArgs {
    pub fn options(&self, seed: u64) -> Outcome<JudgeOptions> {
        let (physics, executor) = judge_named(self.judge.as_deref())?;
        let options = JudgeOptions {
            physics,
            executor,
            friction_spread: self.friction_spread,
            noise_position_m: self.noise_mm * 1e-3,
            noise_rotation_rad: self.noise_deg.to_radians(),
            seed,
        };
        options.validate()?;
        Ok(options)
    }
}
