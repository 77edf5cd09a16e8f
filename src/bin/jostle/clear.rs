//! Tables to be cleared, on the command line: `plan`, `run`, `generate clear` and `render` of scenes with `clear`.

use std::fmt::Write as _;
use std::sync::Arc;

use jostle::eval::clutter::{ClutterGenerator, ClutterKind};
use jostle::eval::{ClearEnd, ClearReport, ClearTrials, Executor, JudgeOptions, Refused, clear_suite};
use jostle::physics::PhysicsOptions;
use jostle::plan::clear::{CLEAR_PLANNERS, ClearOptions, ClearPlanner, ClearRule};
use jostle::plan::{Control, Plan, PlannerOptions, Variant};
use jostle::record::SvgPicture;
use jostle::run::Budget;
use jostle::scene::{Clearing, Gripper};
use serde::Serialize;

use crate::args::{GenerateClearArgs, PlanArgs, PlannerArgs, RunArgs, cores};
use crate::output::{self, Failure, Machine, Outcome};
use crate::plan::text as plan_text;
use crate::plan_file::PlanFile;
use crate::progress;
use crate::table::{Table, number, percent};

/// The planner's options. `hedge`, the default of the command line, stands for the default of clearings.
fn options(args: &PlannerArgs) -> Outcome<ClearOptions> {
    let planner = if args.planner == "hedge" { CLEAR_PLANNERS[0] } else { args.planner.as_str() };
    let mut engines = PlannerOptions::default();
    engines.set_confirm(args.confirm.as_deref())?;
    let (scorer, scorer_model) = args.scorer()?;
    let mut options = ClearOptions {
        planner: planner.to_owned(),
        variant: match args.variant.as_str() {
            "dissertation" => Variant::Dissertation,
            "code" => Variant::Code,
            _ => Variant::Tuned,
        },
        confirm: engines.confirm,
        sampler: args.sampler.clone(),
        push_length: args.push_length,
        scorer,
        scorer_model,
        budget: Budget { iterations: args.iterations, seconds: args.seconds, bytes: None },
        seed: args.seed,
        threads: args.threads.unwrap_or_else(cores),
        ..ClearOptions::default()
    };
    options.set_physics(args.physics.physics.as_deref(), args.physics.preset.as_deref())?;
    options.validate()?;
    Ok(options)
}

fn with_gripper(problem: Clearing, gripper: Option<&Gripper>) -> Outcome<Clearing> {
    let Some(gripper) = gripper else { return Ok(problem) };
    let mut builder = problem.scene.to_builder();
    builder.gripper(gripper.clone());
    Ok(Clearing { scene: Arc::new(builder.build()?), ..problem })
}

pub fn plan(args: &PlanArgs, problem: &Clearing) -> Outcome<()> {
    let problem = with_gripper(problem.clone(), args.planner.gripper()?.as_ref())?;
    let plan = ClearPlanner::new(options(&args.planner)?)?.solve(&problem, &Control::default())?;
    if let Some(path) = &args.svg {
        output::write_file(path, &plan_picture(&problem, &plan).render())?;
    }
    let text = plan_text(&problem.name, &problem.scene, &problem.state, None, &plan);
    output::report(args.json.json.as_deref(), &PlanFile::new(&problem.to_json()?, &plan)?, &text)
}

pub fn picture(problem: &Clearing) -> SvgPicture {
    let mut picture = SvgPicture::new();
    picture.title(&problem.name).panel(&problem.scene, &problem.state, None, None, None, "");
    picture
}

/// The problem if there is nothing to do, else a panel for each action.
pub fn plan_picture(problem: &Clearing, plan: &Plan) -> SvgPicture {
    if plan.actions.is_empty() {
        return picture(problem);
    }
    let steps: Vec<_> = plan.actions.iter().map(|a| (a.action, Some(a.predicted.clone()))).collect();
    let mut picture = SvgPicture::new();
    picture.title(&problem.name).steps(&problem.scene, &problem.state, None, &steps);
    picture
}

/// The report and what it was made on.
#[derive(Serialize)]
struct Document {
    #[serde(flatten)]
    report: ClearReport,
    suite: String,
    variant: Variant,
    rule: ClearRule,
    physics: PhysicsOptions,
    confirm: Option<PhysicsOptions>,
    scorer: String,
    gripper: String,
    seed: u64,
    seconds: Option<f64>,
    iterations: Option<u64>,
    threads: usize,
    trials_of_each: u64,
    max_actions: Option<usize>,
    judge: JudgeOptions,
    version: &'static str,
    machine: Machine,
    refused: Vec<Refused>,
}

/// Runs a suite of tables to be cleared.
pub fn run(args: &RunArgs, problems: Vec<Clearing>, refused: Vec<Refused>) -> Outcome<()> {
    let gripper = args.planner.gripper()?;
    let problems: Vec<Clearing> =
        problems.into_iter().map(|p| with_gripper(p, gripper.as_ref())).collect::<Outcome<_>>()?;
    let planner = options(&args.planner)?;
    let config = ClearTrials {
        judge: args.judge.options(planner.seed)?,
        planner,
        trials: args.trials,
        max_actions: args.max_actions,
    };
    let bar = progress::bar(problems.len() as u64, "cases");
    let report = clear_suite(&problems, &config, &Control::default(), |case| {
        bar.set_message(case.name.clone());
        bar.inc(1);
    });
    bar.finish_and_clear();
    let report = report?;
    let o = &config.planner;
    let names: std::collections::BTreeSet<_> = problems.iter().map(|p| p.scene.gripper().name.clone()).collect();
    let document = Document {
        suite: args.suite().to_owned(),
        variant: o.variant,
        rule: o.own_rule()?,
        physics: o.model()?,
        confirm: o.confirmed_in()?,
        scorer: o.scored_by()?,
        gripper: names.into_iter().collect::<Vec<_>>().join(", "),
        seed: o.seed,
        seconds: o.budget.seconds,
        iterations: o.budget.iterations,
        threads: o.threads,
        trials_of_each: config.trials,
        max_actions: config.max_actions,
        judge: config.judge.clone(),
        version: env!("CARGO_PKG_VERSION"),
        machine: Machine::this(),
        refused,
        report,
    };
    let text = run_text(&document) + &output::refused_lines(&document.refused);
    output::report(args.json.json.as_deref(), &document, &text)?;
    output::complete(&document.refused)
}

fn run_text(document: &Document) -> String {
    let report = &document.report;
    let mut table = Table::new([
        "case",
        "bodies",
        "done",
        "nothing left",
        "grasps held",
        "efficiency",
        "actions",
        "pushes",
        "planning s",
        "decision ms",
        "max",
    ]);
    let rows = report.cases.iter().map(|c| (c.name.as_str(), c.bodies.to_string(), &c.numbers));
    for (name, bodies, n) in rows.chain([("total", String::new(), &report.total)]) {
        let of_each = |count: usize| number((n.runs > 0).then(|| count as f64 / n.runs as f64), 2);
        table.row([
            name.to_owned(),
            bodies,
            percent(Some(n.completion)),
            percent(Some(n.nothing_left)),
            percent(n.grasp_success),
            percent(n.efficiency),
            of_each(n.actions),
            of_each(n.pushes),
            number(Some(n.planning_s), 2),
            number(Some(n.decision_ms.median), 1),
            number(Some(n.decision_ms.max), 1),
        ]);
    }
    let t = &report.total;
    let ended = |end: ClearEnd| report.cases.iter().flat_map(|c| &c.trials).filter(|trial| trial.end == end).count();
    let j = &document.judge;
    let confirm = document.confirm.as_ref().filter(|_| document.rule.confirm_pushes > 0);
    format!(
        "{table}\n{}: {} cases, {} trials; {} lost a body over the edge, {} at the cap on actions, {} without an action; \
         {} of {} bodies taken by {} grasps and {} pushes, {} of them blocked; of completed trials {} of grasps held, \
         efficiency {}\n{} {} on {} {}{}{}, {} threads, seed {}, gripper {}; judge {}{} {}, friction +-{:.0} %, noise {:.1} mm \
         {:.1} deg; jostle {}\n",
        report.planner,
        report.cases.len(),
        t.runs,
        ended(ClearEnd::BodyLeft),
        ended(ClearEnd::ActionCap),
        ended(ClearEnd::NoAction),
        t.taken,
        report.cases.iter().flat_map(|c| &c.trials).map(|trial| trial.bodies).sum::<usize>(),
        t.grasps,
        t.pushes,
        t.blocked,
        percent(t.grasp_success_completed),
        percent(t.efficiency_completed),
        report.planner,
        format!("{:?}", document.variant).to_lowercase(),
        document.physics.engine,
        document.physics.preset,
        if document.scorer == "geometric" { String::new() } else { format!(" scored by {}", document.scorer) },
        confirm.map(|p| format!(" confirmed in {} {}", p.engine, p.preset)).unwrap_or_default(),
        document.threads,
        document.seed,
        document.gripper,
        if j.executor == Executor::Robot { "robot in " } else { "" },
        j.physics.engine,
        j.physics.preset,
        j.friction_spread * 100.0,
        j.noise_position_m * 1e3,
        j.noise_rotation_rad.to_degrees(),
        document.version
    )
}

#[derive(Serialize)]
struct Generated {
    version: &'static str,
    seed: u64,
    kind: String,
    files: Vec<String>,
}

pub fn generate(args: &GenerateClearArgs) -> Outcome<()> {
    let mut params = ClutterKind::by_name(&args.kind)?.params();
    if let Some((least, most)) = args.bodies {
        params.bodies = least..=most;
    }
    if let Some(name) = &args.gripper {
        params.gripper = Gripper::by_name(name)?;
    }
    let problems = ClutterGenerator::new(params, args.seed)?.problems(args.count)?;
    std::fs::create_dir_all(&args.folder).map_err(|e| Failure::failed(format!("{}: {e}", args.folder.display())))?;
    let mut report =
        Generated { version: env!("CARGO_PKG_VERSION"), seed: args.seed, kind: args.kind.clone(), files: Vec::new() };
    let mut text = String::new();
    for problem in problems {
        let path = args.folder.join(format!("{}.json", problem.name));
        output::write_file(&path, &problem.to_json()?)?;
        // Writing to a string does not fail.
        let _ = writeln!(text, "{}: {} bodies", path.display(), problem.scene.len());
        report.files.push(path.display().to_string());
    }
    output::report(args.json.json.as_deref(), &report, &text)
}
