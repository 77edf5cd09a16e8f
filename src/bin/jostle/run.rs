//! `jostle run`: a suite in closed loop.

use std::fmt::Write as _;

use jostle::eval::{
    ClosedLoopOptions, DEFAULT_MAX_ACTIONS, Event, Executor, Report, TrialEnd, max_actions, push_travel, run_suite,
};
use jostle::plan::Control;
use serde::Serialize;

use crate::args::RunArgs;
use crate::clear;
use crate::output::{self, Machine, Outcome};
use crate::progress;
use crate::rearrange;
use crate::suites::{self, Opened};
use crate::table::{Table, number, percent};

/// The report and what it was made on.
#[derive(Serialize)]
struct Document {
    #[serde(flatten)]
    report: Report,
    machine: Machine,
}

pub fn run(args: &RunArgs) -> Outcome<()> {
    let mut suite = match suites::open(args.suite(), args.profile.profile())? {
        Opened::Retrievals(suite) => suite,
        Opened::Rearrangements(problems, refused) => return rearrange::run(args, &problems, refused),
        Opened::Clearings(problems, refused) => return clear::run(args, problems, refused),
    };
    let mut planner = args.planner.options()?;
    let judge = args.judge.options(planner.seed)?;
    let gripper = args.planner.gripper()?;
    if let Some(gripper) = &gripper {
        suite.set_gripper(gripper)?;
    }
    if let Some(profile) = suite.profile {
        planner.push_length.get_or_insert(push_travel(profile));
    }
    let cap = suite.profile.map_or(DEFAULT_MAX_ACTIONS, max_actions);
    let options =
        ClosedLoopOptions { planner, judge, trials: args.trials, max_actions: args.max_actions.unwrap_or(cap) };
    options.validate()?;
    output::any_case(&suite)?;
    let bar = progress::bar(suite.problems.len() as u64 * options.trials, "trials");
    let mut name = String::new();
    let report = run_suite(&suite, &options, &Control::default(), &mut |event| match event {
        Event::Case { name: case, .. } => name = case.to_string(),
        Event::Decision { trial, decision } => {
            bar.set_message(format!("{name} trial {trial}: decision of {:.0} ms", decision.milliseconds));
        }
        Event::Trial { .. } => bar.inc(1),
        Event::CaseDone { .. } => {}
    });
    bar.finish_and_clear();
    let report = report?;
    let text = text(&report);
    output::report(args.json.json.as_deref(), &Document { machine: Machine::this(), report }, &text)?;
    output::complete(&suite.refused)
}

fn text(report: &Report) -> String {
    let mut table =
        Table::new(["case", "bodies", "done", "actions", "grasps held", "planning s", "decision ms", "p99", "max"]);
    for case in &report.cases {
        table.row([
            case.name.clone(),
            case.bodies.to_string(),
            percent(Some(case.completion)),
            number(Some(case.mean_actions), 2),
            percent(case.grasp_success),
            number(Some(case.planning_s), 2),
            number(Some(case.decision_ms.median), 1),
            number(Some(case.decision_ms.p99), 1),
            number(Some(case.decision_ms.max), 1),
        ]);
    }
    let t = &report.total;
    table.row([
        "total".into(),
        String::new(),
        percent(Some(t.completion)),
        number(Some(t.mean_actions), 2),
        percent(t.grasp_success),
        number(Some(t.planning_s_per_case.mean), 2),
        number(Some(t.decision_ms.median), 1),
        number(Some(t.decision_ms.p99), 1),
        number(Some(t.decision_ms.max), 1),
    ]);
    let mut out = table.to_string();
    // Writing to a string does not fail.
    let _ = writeln!(
        out,
        "\n{} cases, {} trials: {} actions in all, {} for each success; {} pushes blocked",
        t.cases,
        t.trials,
        t.actions,
        number(t.actions_per_success, 2),
        t.blocked
    );
    let left = report.cases.iter().flat_map(|c| &c.trials).filter(|trial| trial.end == TrialEnd::TargetLeft).count();
    if left > 0 {
        let _ = writeln!(out, "in {left} of the trials the target left the workspace, pushed out or lost by the hand");
    }
    if t.grasp_chance.is_some() {
        let _ = writeln!(out, "of the grasps a real hand keeps {} by its model", percent(t.grasp_chance));
    }
    out += &output::refused_lines(&report.refused);
    let c = &report.configuration;
    let budget = match (c.budget.iterations, c.budget.seconds) {
        (None, None) => "the planner's budget".into(),
        (i, s) => [i.map(|i| format!("{i} iterations")), s.map(|s| format!("{s} s"))]
            .into_iter()
            .flatten()
            .collect::<Vec<_>>()
            .join(", "),
    };
    let confirm = c.confirm.as_ref().map(|p| format!(" confirmed in {} {}", p.engine, p.preset)).unwrap_or_default();
    let j = &c.judge;
    let _ = writeln!(
        out,
        "{} on {} {}{confirm}, {budget} a decision, {} threads, seed {}, gripper {}; judge {}{} {}, friction +-{:.0} %, noise \
         {:.1} mm {:.1} deg; jostle {}",
        c.planner,
        c.physics.engine,
        c.physics.preset,
        c.threads,
        c.seed,
        c.gripper,
        if j.executor == Executor::Robot { "robot in " } else { "" },
        j.physics.engine,
        j.physics.preset,
        j.friction_spread * 100.0,
        j.noise_position_m * 1e3,
        j.noise_rotation_rad.to_degrees(),
        c.version
    );
    out
}
