//! Runs rows as processes of their own, several side by side, so that one that breaks or hangs takes no other with it.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::output;

/// One process to run.
#[derive(Debug, Clone)]
pub struct Job {
    /// The caller's number for it.
    pub index: usize,
    /// The tool's arguments, without those of the report.
    pub arguments: Vec<String>,
    /// Where the report goes.
    pub report: PathBuf,
    /// Processors that it keeps busy.
    pub threads: usize,
    /// Seconds that it should take.
    pub expected_s: f64,
}

/// Why a row has no report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Fault {
    /// The tool refused it: something it asks for is not there.
    Refused(String),
    /// It broke or took far too long.
    Failed(String),
}

/// How far a run has come.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    pub done: usize,
    pub of: usize,
    /// Seconds that what is left will take, judged by what was done.
    pub left_s: f64,
}

/// A process that takes this many times as long as expected, and some minutes, is ended.
const PATIENCE: (f64, f64) = (8.0, 300.0);
const POLL: Duration = Duration::from_millis(50);
/// Weight of the expectation against what was measured, in seconds.
const TRUST_S: f64 = 60.0;

struct Running {
    job: Job,
    child: Child,
    since: Instant,
}

/// Runs the jobs in their order on so many processors; `done` hears of each with its seconds. An error of `done` ends
/// what still runs.
pub fn run(
    program: &Path,
    jobs: Vec<Job>,
    processors: usize,
    mut done: impl FnMut(&Job, Result<f64, Fault>, Progress) -> Result<(), String>,
) -> Result<(), String> {
    let of = jobs.len();
    let mut waiting: std::collections::VecDeque<Job> = jobs.into();
    let mut running: Vec<Running> = Vec::new();
    let (mut finished, mut expected, mut taken) = (0, TRUST_S, TRUST_S);
    let outcome = loop {
        let busy: usize = running.iter().map(|r| r.job.threads.min(processors)).sum();
        if let Some(job) = waiting.front().filter(|job| busy + job.threads.min(processors) <= processors) {
            let job = job.clone();
            waiting.pop_front();
            match start(program, &job) {
                Ok(child) => running.push(Running { job, child, since: Instant::now() }),
                Err(error) => break Err(format!("{}: {error}", program.display())),
            }
            continue;
        }
        let Some(at) = running.iter_mut().position(ended) else {
            if running.is_empty() {
                break Ok(());
            }
            std::thread::sleep(POLL);
            continue;
        };
        let mut ready = running.swap_remove(at);
        let seconds = ready.since.elapsed().as_secs_f64();
        let result = result_of(&mut ready);
        finished += 1;
        if result.is_ok() {
            expected += ready.job.expected_s;
            taken += seconds;
        }
        let pace = taken / expected;
        let rest = waiting.iter().map(|job| job.expected_s * pace * job.threads.min(processors) as f64).sum::<f64>();
        let now = |r: &Running| (r.job.expected_s * pace - r.since.elapsed().as_secs_f64()).max(0.0);
        let left_s = (rest + running.iter().map(now).sum::<f64>()) / processors as f64 + 0.0;
        if let Err(error) = done(&ready.job, result.map(|()| seconds), Progress { done: finished, of, left_s }) {
            break Err(error);
        }
    };
    for mut left in running {
        // It may have ended by itself meanwhile.
        let _ = left.child.kill();
        let _ = left.child.wait();
    }
    outcome
}

fn start(program: &Path, job: &Job) -> std::io::Result<Child> {
    Command::new(program)
        .args(&job.arguments)
        .arg("--json")
        .arg(&job.report)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
}

fn late(running: &Running) -> bool {
    running.since.elapsed().as_secs_f64() > running.job.expected_s * PATIENCE.0 + PATIENCE.1
}

fn ended(running: &mut Running) -> bool {
    !matches!(running.child.try_wait(), Ok(None)) || late(running)
}

fn result_of(running: &mut Running) -> Result<(), Fault> {
    let status = match running.child.try_wait() {
        Ok(Some(status)) => status,
        other => {
            let _ = running.child.kill();
            let _ = running.child.wait();
            return Err(Fault::Failed(match other {
                Err(error) => error.to_string(),
                _ => format!("ended after {:.0} s", running.since.elapsed().as_secs_f64()),
            }));
        }
    };
    // Refused files stand in the report: a case that is not planar is one.
    if status.success() || status.code() == Some(i32::from(output::REFUSED)) {
        return Ok(());
    }
    let mut line = String::new();
    if let Some(mut stream) = running.child.stderr.take() {
        let _ = stream.read_to_string(&mut line);
    }
    let line = line.lines().rev().find_map(|line| line.strip_prefix("error: ")).unwrap_or_default().to_string();
    Err(match status.code() {
        Some(2) => Fault::Refused(line),
        Some(code) => Fault::Failed(format!("status {code}: {line}")),
        None => Fault::Failed(format!("broke off ({status})")),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job(index: usize, script: &str) -> Job {
        let arguments = vec!["-c".into(), script.into()];
        Job { index, arguments, report: "/dev/null".into(), threads: 1, expected_s: 1.0 }
    }

    #[test]
    fn every_job_is_heard_of_with_what_became_of_it() {
        let jobs = vec![
            job(0, "exit 0"),
            job(1, "echo noise >&2; echo 'error: planner: no planner is named `x`' >&2; exit 2"),
            Job { threads: 5, ..job(2, "echo 'error: it broke' >&2; exit 1") },
            job(3, "kill -9 $$"),
        ];
        let mut heard: Vec<(usize, Option<Fault>)> = Vec::new();
        let mut counts = Vec::new();
        run(Path::new("/bin/sh"), jobs, 2, |job, result, progress| {
            heard.push((job.index, result.err()));
            counts.push((progress.done, progress.of));
            Ok(())
        })
        .unwrap();
        heard.sort_by_key(|(index, _)| *index);
        assert_eq!(counts, [(1, 4), (2, 4), (3, 4), (4, 4)]);
        assert_eq!(heard[0], (0, None));
        assert_eq!(heard[1], (1, Some(Fault::Refused("planner: no planner is named `x`".into()))));
        assert_eq!(heard[2], (2, Some(Fault::Failed("status 1: it broke".into()))));
        assert!(matches!(&heard[3].1, Some(Fault::Failed(what)) if what.starts_with("broke off")), "{heard:?}");
    }

    #[test]
    fn an_error_of_the_listener_ends_the_run() {
        let mut heard = 0;
        let jobs = vec![job(0, "exit 0"), job(1, "exec sleep 1000"), job(2, "exit 0")];
        let outcome = run(Path::new("/bin/sh"), jobs, 2, |_, _, _| {
            heard += 1;
            Err("the disk is full".into())
        });
        assert_eq!((outcome, heard), (Err("the disk is full".into()), 1));
    }
}
