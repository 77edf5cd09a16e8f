//! `jostle crosscheck`: plans of one engine executed in another.

use jostle::eval::{Crosscheck, CrosscheckRow, Refused, Suite, crosscheck, push_travel};
use jostle::physics;
use jostle::plan::Control;
use serde::Serialize;

use crate::args::CrosscheckArgs;
use crate::output::{self, Machine, Outcome};
use crate::progress;
use crate::table::{Table, number, percent};

#[derive(Serialize)]
struct Report {
    version: &'static str,
    machine: Machine,
    suite: String,
    seed: u64,
    #[serde(flatten)]
    crosscheck: Crosscheck,
    refused: Vec<Refused>,
}

pub fn run(args: &CrosscheckArgs) -> Outcome<()> {
    let mut planner = args.planner.options()?;
    let against = args.judge.physics()?;
    let mut suite = Suite::open(&args.suite, args.profile.profile())?;
    if let Some(gripper) = args.planner.gripper()? {
        suite.set_gripper(&gripper)?;
    }
    if let Some(profile) = suite.profile {
        planner.push_length.get_or_insert(push_travel(profile));
    }
    output::any_case(&suite)?;
    let bar = progress::bar(suite.problems.len() as u64, "problems");
    let network = physics::network(&against)?;
    let engine = |scene| physics::engine_with(&against, scene, network.as_ref());
    let result = crosscheck(&suite.problems, &planner, &engine, &Control::default(), &mut |done| {
        bar.set_position(done as u64);
        true
    });
    bar.finish_and_clear();
    let crosscheck = result?;
    let text = text(&crosscheck) + &output::refused_lines(&suite.refused);
    let report = Report {
        version: env!("CARGO_PKG_VERSION"),
        machine: Machine::this(),
        suite: suite.name,
        seed: planner.seed,
        crosscheck,
        refused: suite.refused,
    };
    output::report(args.json.json.as_deref(), &report, &text)?;
    output::complete(&report.refused)
}

fn text(c: &Crosscheck) -> String {
    let mut table = Table::new(["plans", "number", "succeed", "share", "blocked"]);
    let row = |name: String, r: &CrosscheckRow| {
        [name, r.plans.to_string(), r.succeeded.to_string(), percent(Some(r.share)), r.blocked.to_string()]
    };
    table.row(row("all".into(), &c.total));
    for (pushes, r) in &c.by_pushes {
        table.row(row(format!("of {pushes} pushes"), r));
    }
    for (bodies, r) in &c.by_bodies_moved {
        table.row(row(format!("that move {bodies} bodies at once"), r));
    }
    format!(
        "planned in {}, executed in {}; {} problems left out (no push needed, or no plan)\n\n{table}",
        c.planned_in,
        c.executed_in,
        number(Some(c.left_out as f64), 0)
    )
}
