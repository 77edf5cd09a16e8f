//! `jostle`: the library on the command line. `docs/cli.md` holds its help.
//!
//! A command reads its arguments (`args`), does its work (a file each) and reports (`output`). Mistakes in arguments
//! and files end with exit status 2, failures with 1, both with one line on standard error.

mod args;
mod assess;
mod assess_robot;
mod bench_image;
mod bench_limits;
mod bench_net;
mod bench_path;
mod bench_push;
mod bench_search;
mod clear;
mod clear_suite;
mod crosscheck;
mod datagen;
mod fidelity;
mod fit;
mod generate;
mod grasps;
mod model;
mod observe;
mod output;
mod plan;
mod plan_file;
mod progress;
mod rearrange;
mod rearrange_suite;
mod record;
mod render;
mod results;
mod run;
mod suites;
mod table;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;

use args::{BenchCommand, Command};
use output::{Failure, Outcome};

fn main() -> ExitCode {
    // A defect is reported in one line like any other failure.
    std::panic::set_hook(Box::new(|_| ()));
    let outcome = catch_unwind(AssertUnwindSafe(command)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<&str>().map(|s| (*s).to_string());
        let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
        Err(Failure::failed(format!("internal error: {text}; please report it")))
    });
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

fn command() -> Outcome<()> {
    let Some(cli) = args::parse()? else { return Ok(()) };
    match cli.command {
        Command::Plan(args) => plan::run(&args),
        Command::Grasps(args) => grasps::run(&args),
        Command::Run(args) => run::run(&args),
        Command::Results(args) => results::run(&args),
        Command::Generate(args) => generate::run(&args),
        Command::Fidelity(args) => fidelity::run(&args),
        Command::Record(args) => record::run(&args),
        Command::Crosscheck(args) => crosscheck::run(&args),
        Command::Bench(BenchCommand::Push(args)) => bench_push::run(&args),
        Command::Bench(BenchCommand::Search(args)) => bench_search::run(&args),
        Command::Bench(BenchCommand::Path(args)) => bench_path::run(&args),
        Command::Bench(BenchCommand::Net(args)) => bench_net::run(&args),
        Command::Bench(BenchCommand::Image(args)) => bench_image::run(&args),
        Command::Render(args) => render::run(&args),
        Command::Assess(command) => assess::run(&command),
        Command::Fit(command) => fit::run(&command),
        Command::Datagen(command) => datagen::run(&command),
        Command::Model(args) => model::run(&args),
        Command::Observe(args) => observe::run(&args),
    }
}
