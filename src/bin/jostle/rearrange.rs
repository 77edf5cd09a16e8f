//! Rearrangements on the command line: `plan`, `run`, `generate rearrange` and `render` of scenes with goals.

use std::fmt::Write as _;
use std::sync::Mutex;

use jostle::Error;
use jostle::action::Move;
use jostle::eval::arrange::{ArrangeLevel, Arranger};
use jostle::eval::{RearrangeEnd, RearrangeReport, RearrangeTrials, Refused, certificate, rearrange_suite};
use jostle::files::json;
use jostle::geom::Pose2;
use jostle::plan::rearrange::{REARRANGE_PLANNERS, RearrangeOptions, RearrangePlan, RearrangePlanner};
use jostle::plan::{Control, Outcome as PlanOutcome, PlanStatistics, Variant, WrittenReason};
use jostle::record::{rearrangement_animation, rearrangement_svg};
use jostle::run::{Budget, Pool};
use jostle::scene::{Input, Rearrangement, check_pose};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::args::{GenerateRearrangeArgs, PlanArgs, PlannerArgs, RunArgs, cores};
use crate::output::{self, Failure, Machine, Outcome};
use crate::plan::write_reasons;
use crate::plan_file::check_version;
use crate::progress;
use crate::table::{Table, number, percent};

/// The version of the plan document.
const VERSION: u64 = 1;

/// A plan with the problem it was made for. The field `rearrange_plan_version` tells it from other documents.
#[derive(Debug, Serialize, Deserialize)]
pub struct RearrangePlanFile {
    rearrange_plan_version: u64,
    planner: String,
    seed: u64,
    outcome: PlanOutcome,
    #[serde(default)]
    reasons: Vec<WrittenReason>,
    /// A scene file's object.
    problem: Value,
    moves: Vec<MoveEntry>,
    /// Metres.
    cost: f64,
    /// Seconds of robot time.
    robot_s: f64,
    /// Equal for equal plans, bit for bit.
    hash: String,
    statistics: PlanStatistics,
}

/// A move: two poses for a pick-and-place, the waypoints of a drag.
#[derive(Debug, Serialize, Deserialize)]
struct MoveEntry {
    kind: MoveKind,
    /// Index of the body.
    body: usize,
    name: String,
    poses: Vec<Pose2>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum MoveKind {
    PickPlace,
    Drag,
}

impl MoveEntry {
    fn new(problem: &Rearrangement, action: &Move) -> MoveEntry {
        let kind = if matches!(action, Move::Drag { .. }) { MoveKind::Drag } else { MoveKind::PickPlace };
        let name = problem.scene.bodies().get(action.body()).map(|b| b.name.clone()).unwrap_or_default();
        MoveEntry { kind, body: action.body(), name, poses: action.poses() }
    }

    fn action(&self, index: usize, bodies: usize) -> Result<Move, Error> {
        if self.body >= bodies {
            return Err(Error::not_found(format!("moves[{index}].body"), format!("there is no body {}", self.body)));
        }
        for (i, pose) in self.poses.iter().enumerate() {
            check_pose(&format!("moves[{index}].poses[{i}]"), pose)?;
        }
        match (self.kind, self.poses.as_slice()) {
            (MoveKind::PickPlace, &[pick, place]) => Ok(Move::PickPlace { body: self.body, pick, place }),
            (MoveKind::Drag, poses) if poses.len() >= 2 => Ok(Move::Drag { body: self.body, waypoints: poses.into() }),
            _ => {
                let reason = "a pick-and-place has two poses, a drag at least two";
                Err(Error::argument(format!("moves[{index}].poses"), reason))
            }
        }
    }
}

/// The planner's options. `hedge`, the default of the command line, stands for the default of rearrangements.
fn options(args: &PlannerArgs, seeds: usize) -> Outcome<RearrangeOptions> {
    let planner = if args.planner == "hedge" { REARRANGE_PLANNERS[0] } else { args.planner.as_str() };
    let options = RearrangeOptions {
        planner: planner.to_owned(),
        variant: match args.variant.as_str() {
            "dissertation" => Variant::Dissertation,
            "code" => Variant::Code,
            _ => Variant::Tuned,
        },
        budget: Budget { iterations: args.iterations, seconds: args.seconds, bytes: None },
        seed: args.seed,
        threads: args.threads.unwrap_or_else(cores),
        lanes: args.lanes,
        max_depth: args.max_depth,
        seeds,
        ..RearrangeOptions::default()
    };
    options.validate()?;
    Ok(options)
}

pub fn plan(args: &PlanArgs, problem: &Rearrangement) -> Outcome<()> {
    let plan = RearrangePlanner::new(options(&args.planner, 1)?)?.solve(problem, &Control::default())?;
    let moves: Vec<Move> = plan.moves.iter().map(|step| step.action.clone()).collect();
    if let Some(path) = &args.svg {
        output::write_file(path, &rearrangement_svg(problem, &moves))?;
    }
    let document: Value =
        serde_json::from_str(&problem.to_json()?).map_err(|e| Failure::failed(format!("the library's JSON: {e}")))?;
    let file = RearrangePlanFile {
        rearrange_plan_version: VERSION,
        planner: plan.planner.clone(),
        seed: plan.seed,
        outcome: plan.outcome,
        reasons: plan.reasons.iter().map(WrittenReason::from).collect(),
        problem: document,
        moves: moves.iter().map(|action| MoveEntry::new(problem, action)).collect(),
        cost: plan.cost,
        robot_s: plan.robot_seconds,
        hash: format!("{:016x}", plan.hash_bits()),
        statistics: plan.statistics,
    };
    output::report(args.json.json.as_deref(), &file, &text(problem, &plan)?)
}

/// The plan for people.
fn text(problem: &Rearrangement, plan: &RearrangePlan) -> Outcome<String> {
    let mut out = String::new();
    let drags = problem.scene.bodies().iter().filter(|b| !b.pickable && b.pushable).count();
    // Writing to a string does not fail.
    let _ = writeln!(out, "scene   {}: {} bodies, {drags} of them to be dragged", problem.name, problem.scene.len());
    let outcome = match plan.outcome {
        PlanOutcome::Solved => "solved",
        PlanOutcome::Partial => "partial: the search ended short of the goals; the best moves found",
        PlanOutcome::Infeasible => "infeasible",
        PlanOutcome::Budget => "budget used up; the best moves found",
        PlanOutcome::Cancelled => "cancelled",
    };
    let _ = writeln!(out, "outcome {outcome}");
    write_reasons(&mut out, &plan.reasons);
    for (i, step) in plan.moves.iter().enumerate() {
        let entry = MoveEntry::new(problem, &step.action);
        let what = match entry.kind {
            MoveKind::PickPlace => "pick ".to_owned(),
            MoveKind::Drag => "drag ".to_owned(),
        };
        let (from, to) = (step.action.from(), step.action.to());
        let by =
            if entry.kind == MoveKind::Drag { format!(" by {} waypoints", entry.poses.len()) } else { String::new() };
        let _ = writeln!(
            out,
            "  {}. {what} \"{}\" from ({:.3}, {:.3}, {:.0} deg) to ({:.3}, {:.3}, {:.0} deg){by}",
            i + 1,
            entry.name,
            from.x,
            from.y,
            from.theta.to_degrees(),
            to.x,
            to.y,
            to.theta.to_degrees()
        );
    }
    let actions = plan.moves.iter().map(|step| &step.action);
    let checked = match plan.outcome {
        PlanOutcome::Solved => certificate::certify(problem, actions).err(),
        _ => certificate::certify_moves(problem, actions).err(),
    };
    let checked = checked.map_or_else(|| "passes the check".to_owned(), |violation| format!("fails: {violation}"));
    let _ = writeln!(
        out,
        "plan    {} moves, cost {:.2} m, {:.1} s of robot time; {checked}",
        plan.moves.len(),
        plan.cost,
        plan.robot_seconds
    );
    let s = &plan.statistics;
    let _ = writeln!(
        out,
        "search  {}, seed {}: {:.1} ms, {} iterations",
        plan.planner,
        plan.seed,
        s.seconds * 1e3,
        s.iterations
    );
    Ok(out)
}

/// The report and what it was made on.
#[derive(Serialize)]
struct Document {
    #[serde(flatten)]
    report: RearrangeReport,
    suite: String,
    seed: u64,
    seconds: Option<f64>,
    iterations: Option<u64>,
    seeds: usize,
    threads: usize,
    open_loop: bool,
    trials: u64,
    max_actions: usize,
    version: &'static str,
    machine: Machine,
    refused: Vec<Refused>,
}

/// Runs a suite of rearrangements.
pub fn run(args: &RunArgs, problems: &[Rearrangement], refused: Vec<Refused>) -> Outcome<()> {
    let defaults = RearrangeTrials::default();
    let mut options = options(&args.planner, args.seeds)?;
    options.reward.base = !args.no_base_reward;
    let config = RearrangeTrials {
        options,
        trials: args.trials,
        // As many as the source allows, or enough to move every body thrice.
        max_actions: args
            .max_actions
            .unwrap_or_else(|| problems.iter().map(|p| 3 * p.scene.len()).max().unwrap_or(0).max(defaults.max_actions)),
        open_loop: args.open_loop,
    };
    let bar = progress::bar(problems.len() as u64, "cases");
    let report = rearrange_suite(problems, &config, &Control::default(), |case| {
        bar.set_message(case.name.clone());
        bar.inc(1);
    });
    bar.finish_and_clear();
    let report = report?;
    let text = run_text(&report) + &output::refused_lines(&refused);
    let o = &config.options;
    let document = Document {
        suite: args.suite().to_owned(),
        seed: o.seed,
        seconds: o.budget.seconds,
        iterations: o.budget.iterations,
        seeds: o.seeds,
        threads: o.threads,
        open_loop: config.open_loop,
        trials: config.trials,
        max_actions: config.max_actions,
        version: env!("CARGO_PKG_VERSION"),
        machine: Machine::this(),
        refused,
        report,
    };
    output::report(args.json.json.as_deref(), &document, &text)?;
    output::complete(&document.refused)
}

fn run_text(report: &RearrangeReport) -> String {
    let mut table = Table::new(["case", "bodies", "done", "actions", "robot s", "planning s"]);
    for case in &report.cases {
        table.row([
            case.name.clone(),
            case.bodies.to_string(),
            percent(Some(case.completion)),
            number(case.actions, 2),
            number(case.robot_s, 1),
            number(Some(case.planning_s), 3),
        ]);
    }
    table.row([
        "total".into(),
        String::new(),
        percent(Some(report.completion)),
        number(report.actions_completed, 2),
        number(report.robot_s, 1),
        number(Some(report.planning_s), 3),
    ]);
    let trials: Vec<_> = report.cases.iter().flat_map(|case| &case.trials).collect();
    let ended = |end: RearrangeEnd| trials.iter().filter(|trial| trial.end == end).count();
    format!(
        "{table}\n{}: {} cases, {} trials; {} at the cap on actions, {} without a move, {} plans refused by the check; \
         actions with failed trials at the cap: {:.2}\n",
        report.planner,
        report.cases.len(),
        trials.len(),
        ended(RearrangeEnd::ActionCap),
        ended(RearrangeEnd::NoAction),
        report.invalid,
        report.actions
    )
}

#[derive(Serialize)]
struct Generated {
    version: &'static str,
    seed: u64,
    level: String,
    files: Vec<String>,
}

pub fn generate(args: &GenerateRearrangeArgs) -> Outcome<()> {
    let mut params = ArrangeLevel::by_name(&args.level)?.params();
    if let Some((least, most)) = args.bodies {
        params.bodies = least..=most;
    }
    if let Some([low, high]) = args.fill {
        params.fill = [low, high];
    }
    let arranger = Arranger::new(params, args.seed)?;
    std::fs::create_dir_all(&args.folder).map_err(|e| Failure::failed(format!("{}: {e}", args.folder.display())))?;
    let mut report =
        Generated { version: env!("CARGO_PKG_VERSION"), seed: args.seed, level: args.level.clone(), files: Vec::new() };
    let mut text = String::new();
    let bar = progress::bar(args.count, "problems");
    // A problem is the same on every thread.
    let pool = Pool::new(cores(), "jostle")?;
    let scratches: Vec<Mutex<()>> = (0..pool.workers()).map(|_| Mutex::default()).collect();
    let at_once = 4 * pool.workers();
    for first in (0..args.count).step_by(at_once) {
        let indices = first..args.count.min(first + at_once as u64);
        let mut batch: Vec<_> = indices.map(|index| (index, None)).collect();
        pool.for_each_group(&mut batch, 1, &scratches, |(), batch| {
            batch.iter_mut().for_each(|(index, problem)| *problem = Some(arranger.problem(*index)));
        })?;
        for problem in batch.into_iter().filter_map(|(_, problem)| problem) {
            let problem = problem?;
            let path = args.folder.join(format!("{}.json", problem.name));
            output::write_file(&path, &problem.to_json()?)?;
            let drags = problem.scene.bodies().iter().filter(|b| !b.pickable).count();
            let _ = writeln!(text, "{}: {} bodies, {drags} to be dragged", path.display(), problem.scene.len());
            report.files.push(path.display().to_string());
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    output::report(args.json.json.as_deref(), &report, &text)
}

/// Draws a rearrangement, or a plan of one.
pub fn picture(problem: &Rearrangement, moves: &[Move], animated: bool) -> String {
    if animated { rearrangement_animation(problem, moves) } else { rearrangement_svg(problem, moves) }
}

/// The problem and the moves of a plan's file.
pub fn read_plan(input: &Input) -> Outcome<(Rearrangement, Vec<Move>)> {
    check_version(input, "rearrange_plan_version", VERSION)?;
    let file: RearrangePlanFile = json::parse(&input.text, "plan").map_err(|e| input.error(e))?;
    let placed = |error: Error| input.error(json::located(&input.text, error));
    let problem = Rearrangement::from_json(&file.problem.to_string()).map_err(|e| placed(e.within("problem")))?;
    let bodies = problem.scene.len();
    let actions = file.moves.iter().enumerate().map(|(i, entry)| entry.action(i, bodies).map_err(placed));
    Ok((problem, actions.collect::<Result<_, _>>()?))
}
