//! `jostle results`: every experiment of a list, and the document that shows them beside the published figures.
//!
//! A row is one `jostle run`, started as a process of its own; what it reported is kept (`store`), so that a run goes on
//! where it was interrupted. `list` reads the experiments (from `tables`), `schedule` runs them, `metrics` reads the
//! reports, `document` and `plot` write.

mod document;
mod list;
mod metrics;
mod plot;
mod schedule;
mod store;
mod tables;
#[cfg(test)]
mod tests;

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

use jostle::files;
use jostle::net::{Runtime, RuntimeOptions};

use crate::args::{ResultsArgs, cores};
use crate::output::{self, Failure, Machine, Outcome};
use crate::table::Table;
use document::State;
use list::{List, Need, Row, Suite};
use metrics::{Kind, Measured, written};
use schedule::{Fault, Job};
use store::{Kept, Origin, Stamp, Store};

/// Where the original test cases lie below the folder that comes with the project's tests.
const CASES_BELOW_SHARED: &str = "data/cases/arc";

pub fn run(args: &ResultsArgs) -> Outcome<()> {
    let place = args.list.display();
    let text = files::read_text(&args.list)?;
    let list = List::parse(&text).map_err(|e| Failure::usage(format!("{place}: {e}")))?;
    if let Some(unknown) = args.only.iter().find(|id| list.section(id).is_none()) {
        let known: Vec<_> = list.sections.iter().map(|s| s.id.as_str()).collect();
        return Err(Failure::usage(format!("--only: there is no section `{unknown}`; known: {}", known.join(", "))));
    }
    let session = Session::new(args, list)?;
    let wanted: Vec<Wanted> = session.list.rows.iter().map(|row| session.wanted(row)).collect();
    if args.dry_run {
        return output::emit(&session.plan(&wanted));
    }
    let mut states: Vec<State> = wanted.iter().map(|wanted| session.known(wanted)).collect();
    let failed = if args.document { Vec::new() } else { session.measure(&wanted, &mut states)? };
    session.write(&states)?;
    if failed.is_empty() {
        return Ok(());
    }
    Err(Failure::failed(format!("{} rows failed: {}", failed.len(), failed.join("; "))))
}

/// What all rows share.
struct Session<'a> {
    args: &'a ResultsArgs,
    list: List,
    store: Store,
    program: PathBuf,
    /// SHA-256 of the program.
    tool: String,
    /// The folder of the original test cases; none where it is not.
    cases: Option<String>,
    networks: bool,
    jobs: usize,
}

/// A row as it is to be run.
struct Wanted {
    index: usize,
    trials: u64,
    expected_s: f64,
    /// Without the suite's digest if it cannot be run here; why not is in `missing`.
    stamp: Stamp,
    arguments: Vec<String>,
    missing: Option<String>,
    /// Of a section that was asked for.
    asked: bool,
}

impl<'a> Session<'a> {
    fn new(args: &'a ResultsArgs, list: List) -> Outcome<Session<'a>> {
        let program = std::env::current_exe().map_err(|e| Failure::failed(format!("the tool's own file: {e}")))?;
        let bytes = std::fs::read(&program).map_err(|e| Failure::failed(format!("{}: {e}", program.display())))?;
        Ok(Session {
            args,
            list,
            store: Store::open(&args.kept).map_err(Failure::failed)?,
            program,
            tool: store::digest([bytes.as_slice()]),
            cases: cases(),
            networks: Runtime::open(&RuntimeOptions::default()).is_ok(),
            jobs: args.jobs.map_or_else(cores, |jobs| jobs as usize),
        })
    }

    fn wanted(&self, row: &Row) -> Wanted {
        let index = self.list.rows.iter().position(|other| other.id == row.id).unwrap_or_default();
        let trials = self.args.trials.unwrap_or(row.trials);
        let nothing = Suite { id: String::new(), path: String::new(), of: 0 };
        let suite = self.list.suite(&row.suite).unwrap_or(&nothing);
        let (path, mut missing) = match (&self.cases, suite.path.contains("$CASES")) {
            (Some(cases), true) => (suite.path.replace("$CASES", cases), None),
            (None, true) => (suite.path.clone(), Some("the original test cases are not here".to_string())),
            _ => (suite.path.clone(), None),
        };
        if suite.path.contains('/') && missing.is_none() && !Path::new(&path).exists() {
            missing = Some(format!("the suite {} is not here", row.suite));
        }
        if row.needs == Some(Need::Networks) && !self.networks {
            missing.get_or_insert("needs ONNX Runtime".into());
        }
        let digest = store::suite_digest(&path).unwrap_or_else(|error| {
            missing.get_or_insert(error);
            String::new()
        });
        let mut arguments = row.arguments(suite, trials);
        if let Some(place) = arguments.get_mut(1) {
            *place = path;
        }
        Wanted {
            index,
            trials,
            expected_s: row.seconds * trials as f64 / row.trials as f64,
            stamp: Stamp { command: row.command(suite, trials), suite: digest, tool: self.tool.clone() },
            arguments,
            missing,
            asked: self.args.only.is_empty() || self.args.only.contains(&row.section),
        }
    }

    fn row(&self, wanted: &Wanted) -> &Row {
        &self.list.rows[wanted.index]
    }

    fn kind(&self, row: &Row) -> Kind {
        self.list.section(&row.section).map_or(Kind::Retrieval, |section| section.kind)
    }

    /// What is known of a row before anything runs.
    fn known(&self, wanted: &Wanted) -> State {
        let any_build = self.args.any_build || self.args.document || !wanted.asked;
        let kept = if self.args.fresh && wanted.asked { None } else { self.store.find(&wanted.stamp, any_build) };
        match (kept, &wanted.missing) {
            (Some(kept), _) => self.state(wanted, kept).unwrap_or(State::NotRun),
            (None, Some(why)) => State::Missing(why.clone()),
            (None, None) => State::NotRun,
        }
    }

    fn state(&self, wanted: &Wanted, kept: Kept) -> Result<State, String> {
        let measured = Measured::read(self.kind(self.row(wanted)), &kept.report)?;
        Ok(State::Done { measured, origin: Box::new(kept.origin), trials: wanted.trials })
    }

    /// The rows that are to be run, each command once: those that keep several processors busy first, then the longest.
    fn jobs(&self, wanted: &[Wanted], states: &[State]) -> Vec<Job> {
        let mut jobs: Vec<Job> = Vec::new();
        for wanted in wanted.iter().filter(|w| w.asked && matches!(states[w.index], State::NotRun)) {
            let report = self.store.part(&wanted.stamp.command);
            if jobs.iter().all(|job| job.report != report) {
                let threads = self.row(wanted).threads;
                let (index, expected_s) = (wanted.index, wanted.expected_s);
                jobs.push(Job { index, arguments: wanted.arguments.clone(), report, threads, expected_s });
            }
        }
        jobs.sort_by(|a, b| b.threads.cmp(&a.threads).then(b.expected_s.total_cmp(&a.expected_s)));
        jobs
    }

    fn measure(&self, wanted: &[Wanted], states: &mut [State]) -> Outcome<Vec<String>> {
        let jobs = self.jobs(wanted, states);
        if jobs.is_empty() {
            say("nothing is left to be measured");
            return Ok(Vec::new());
        }
        say(&format!(
            "{} rows to measure, {} side by side; about {}",
            jobs.len(),
            self.jobs,
            minutes(self.expected(&jobs))
        ));
        let made = Made::here(self.jobs);
        let mut failed = Vec::new();
        schedule::run(&self.program, jobs, self.jobs, |job, result, progress| {
            let row = self.row(&wanted[job.index]);
            let stamp = &wanted[job.index].stamp;
            let outcome = result.and_then(|seconds| {
                let report = take_report(&job.report).map_err(Fault::Failed)?;
                Ok(Kept { stamp: stamp.clone(), origin: made.origin(seconds), report })
            });
            let what = match outcome {
                Ok(kept) => {
                    self.store.keep(&kept)?;
                    let same = wanted.iter().filter(|w| w.stamp.command == stamp.command && w.asked);
                    for other in same {
                        states[other.index] = self.state(other, kept.clone())?;
                    }
                    self.summary(row, &states[job.index])
                }
                Err(fault) => {
                    let why = match fault {
                        Fault::Refused(why) => format!("not available: {}", self.without_paths(&why)),
                        Fault::Failed(why) => {
                            failed.push(format!("{}: {}", row.id, self.without_paths(&why)));
                            format!("failed: {}", self.without_paths(&why))
                        }
                    };
                    for other in wanted.iter().filter(|w| w.stamp.command == stamp.command && w.asked) {
                        states[other.index] = State::Missing(why.clone());
                    }
                    why
                }
            };
            say(&format!(
                "[{}/{}] {}: {what}; about {} left",
                progress.done,
                progress.of,
                row.id,
                minutes(progress.left_s)
            ));
            Ok(())
        })
        .map_err(Failure::failed)?;
        Ok(failed)
    }

    /// Folders of this machine have no place in the document.
    fn without_paths(&self, text: &str) -> String {
        self.cases.as_ref().map_or_else(|| text.to_string(), |cases| text.replace(cases.as_str(), "$CASES"))
    }

    /// The first two values of a row, for the progress.
    fn summary(&self, row: &Row, state: &State) -> String {
        let State::Done { measured, origin, .. } = state else { return String::new() };
        let metrics = self.kind(row).metrics().iter().take(2);
        let values = metrics.filter_map(|metric| {
            let figure = measured.figure(metric.key)?;
            Some(format!("{} {}", metric.heading, written(figure, metric.form)))
        });
        format!("{} ({:.0} s)", values.collect::<Vec<_>>().join(", "), origin.wall_s)
    }

    /// Seconds that jobs take side by side.
    fn expected(&self, jobs: &[Job]) -> f64 {
        let work = |job: &Job| job.expected_s * job.threads.min(self.jobs) as f64;
        let longest = jobs.iter().map(|job| job.expected_s).fold(0.0, f64::max);
        longest.max(jobs.iter().map(work).sum::<f64>() / self.jobs as f64)
    }

    /// What would be done.
    fn plan(&self, wanted: &[Wanted]) -> String {
        let states: Vec<State> = wanted.iter().map(|wanted| self.known(wanted)).collect();
        let jobs = self.jobs(wanted, &states);
        let mut table = Table::new(["row", "expected s", "state"]);
        for wanted in wanted {
            let state = match &states[wanted.index] {
                State::Done { .. } => "kept".to_string(),
                State::Missing(why) => why.clone(),
                State::NotRun if !wanted.asked => "not asked for".into(),
                State::NotRun if jobs.iter().any(|job| job.index == wanted.index) => "to be measured".into(),
                State::NotRun => "as an earlier row".into(),
            };
            let row = self.row(wanted);
            table.row([row.id.clone(), format!("{:.0}", wanted.expected_s), state]);
        }
        let mut out = table.to_string();
        // Writing to a string does not fail.
        let _ = writeln!(
            out,
            "\n{} rows to measure, {} side by side: about {}",
            jobs.len(),
            self.jobs,
            minutes(self.expected(&jobs))
        );
        out
    }

    fn write(&self, states: &[State]) -> Outcome<()> {
        let plots = self.args.plots.to_string_lossy();
        for plot in &self.list.plots {
            let chart = document::chart(&self.list, plot, states).filter(|chart| !chart.is_empty());
            let Some(chart) = chart else { continue };
            let folder = &self.args.plots;
            std::fs::create_dir_all(folder).map_err(|e| Failure::failed(format!("{}: {e}", folder.display())))?;
            output::write_file(&folder.join(format!("{}.svg", plot.id)), &chart.svg())?;
        }
        output::write_file(&self.args.output, &document::document(&self.list, states, &plots))?;
        say(&format!("{} is written", self.args.output.display()));
        Ok(())
    }
}

/// Reads a report and removes its file.
fn take_report(file: &Path) -> Result<serde_json::Value, String> {
    let text = std::fs::read_to_string(file).map_err(|e| format!("its report: {e}"))?;
    // It is kept elsewhere from here on; a file that stays is overwritten by the next run.
    let _ = std::fs::remove_file(file);
    serde_json::from_str(&text).map_err(|e| format!("its report: {e}"))
}

/// `CASES`, else the folder beside the project that the tests use.
fn cases() -> Option<String> {
    let shared = || {
        let root = std::env::var_os("JOSTLE_SHARED").map_or_else(|| PathBuf::from("../shared"), PathBuf::from);
        root.join(CASES_BELOW_SHARED)
    };
    let folder = std::env::var_os("CASES").filter(|f| !f.is_empty()).map_or_else(shared, PathBuf::from);
    folder.is_dir().then(|| folder.to_string_lossy().into_owned())
}

/// What the rows of one run have in common.
struct Made {
    machine: Machine,
    commit: String,
    date: String,
    jobs: usize,
}

impl Made {
    fn here(jobs: usize) -> Made {
        let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        Made { machine: Machine::this(), commit: commit(), date: date(seconds / 86_400), jobs }
    }

    fn origin(&self, wall_s: f64) -> Origin {
        Origin {
            version: env!("CARGO_PKG_VERSION").into(),
            commit: self.commit.clone(),
            date: self.date.clone(),
            processor: self.machine.processor.clone(),
            cores: self.machine.cores,
            jobs: self.jobs,
            wall_s,
        }
    }
}

/// The commit of the working tree, with `+` if what decides results was changed since.
fn commit() -> String {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_string())
    };
    let Some(commit) = git(&["rev-parse", "--short=10", "HEAD"]) else { return "unknown".into() };
    let changed = git(&["status", "--porcelain", "--", "src", "suites", "models", "bindings", "Cargo.lock"]);
    if changed.is_none_or(|changed| !changed.is_empty()) { format!("{commit}+") } else { commit }
}

/// Year-month-day of a number of days since 1970-01-01 (Gregorian calendar; eras of 400 years from the first of March).
fn date(days: u64) -> String {
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}")
}

fn minutes(seconds: f64) -> String {
    if seconds < 90.0 { format!("{seconds:.0} s") } else { format!("{:.0} min", seconds / 60.0) }
}

/// A line of progress, on standard error.
fn say(line: &str) {
    // Where nobody listens the work goes on.
    let _ = writeln!(std::io::stderr(), "{line}");
}
