//! What the tool says: reports to standard output or a file, one line on errors.

use std::io::{ErrorKind, Write};
use std::path::Path;
use std::process::ExitCode;

use jostle::Error;
use jostle::eval::{Refused, Suite};
use jostle::files;
use serde::Serialize;

/// Exit status of a run that has a result, but not of every file of its folder.
pub const REFUSED: u8 = 3;

/// Why a command ends without a result, or with one of less than was asked for.
#[derive(Debug)]
pub struct Failure {
    code: u8,
    reason: String,
}

pub type Outcome<T> = Result<T, Failure>;

impl Failure {
    /// The command line or a file is wrong.
    pub fn usage(reason: impl Into<String>) -> Failure {
        Failure { code: 2, reason: reason.into() }
    }

    /// Something went wrong that the user could not have known.
    pub fn failed(reason: impl Into<String>) -> Failure {
        Failure { code: 1, reason: reason.into() }
    }

    /// There is a result, but not of every file of a folder.
    fn refused(reason: String) -> Failure {
        Failure { code: REFUSED, reason }
    }

    /// Says it on standard error, in one line.
    pub fn report(&self) -> ExitCode {
        let line = self.reason.split_whitespace().collect::<Vec<_>>().join(" ");
        // There is nowhere left to complain to.
        let _ = writeln!(std::io::stderr(), "error: {line}");
        ExitCode::from(self.code)
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Failure {
        match error {
            Error::Argument { .. }
            | Error::NotFound { .. }
            | Error::Unsupported(_)
            | Error::Io { .. }
            | Error::Model { .. }
            | Error::Runtime(_)
            | Error::Format { .. } => Failure::usage(error.to_string()),
            _ => Failure::failed(error.to_string()),
        }
    }
}

/// Writes text to standard output. A reader that has gone away (such as `head`) is no error.
pub fn emit(text: &str) -> Outcome<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Failure::failed(format!("standard output: {e}"))),
        _ => Ok(()),
    }
}

/// Writes a file, whole or not at all; `-` is standard output.
pub fn write_file(path: &Path, text: &str) -> Outcome<()> {
    if path == Path::new("-") {
        return emit(text);
    }
    files::write(path, text).map_err(|e| Failure::failed(e.to_string()))
}

/// Gives out a report: the text to standard output, and the JSON where it was asked for. JSON on standard output
/// takes the place of the text.
pub fn report(json: Option<&Path>, value: &impl Serialize, text: &str) -> Outcome<()> {
    let Some(path) = json else { return emit(text) };
    let mut document =
        serde_json::to_string_pretty(value).map_err(|e| Failure::failed(format!("the report as JSON: {e}")))?;
    document.push('\n');
    if path == Path::new("-") {
        return emit(&document);
    }
    write_file(path, &document)?;
    emit(text)
}

/// The files that hold no problem, each with its reason, as lines of a report.
pub fn refused_lines(refused: &[Refused]) -> String {
    refused.iter().map(|file| format!("refused {}: {}\n", file.name, file.reason)).collect()
}

/// Refuses a suite of which no file can be used.
pub fn any_case(suite: &Suite) -> Outcome<()> {
    if !suite.problems.is_empty() {
        return Ok(());
    }
    let reasons: Vec<_> = suite.refused.iter().map(|refused| refused.reason.as_str()).collect();
    let count = suite.refused.len();
    Err(Failure::usage(format!("{}: none of its {count} cases can be used: {}", suite.name, reasons.join("; "))))
}

/// The end of a run whose report was given out: a failure of its own where files were refused.
pub fn complete(refused: &[Refused]) -> Outcome<()> {
    if refused.is_empty() {
        return Ok(());
    }
    let names: Vec<_> = refused.iter().map(|file| file.name.as_str()).collect();
    let (files, were) = if names.len() == 1 { ("file", "was") } else { ("files", "were") };
    let reason =
        format!("{} {files} {were} refused and not run: {}; the report has the reasons", names.len(), names.join(", "));
    Err(Failure::refused(reason))
}

/// What a measurement was made on.
#[derive(Debug, Clone, Serialize)]
pub struct Machine {
    pub processor: String,
    pub cores: usize,
    pub os: &'static str,
    pub architecture: &'static str,
}

impl Machine {
    pub fn this() -> Machine {
        let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = info.lines().find_map(|line| line.strip_prefix("model name"));
        let processor = model.map(|m| m.trim_start_matches([' ', '\t', ':']).trim()).filter(|m| !m.is_empty());
        Machine {
            processor: processor.unwrap_or("unknown").into(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            os: std::env::consts::OS,
            architecture: std::env::consts::ARCH,
        }
    }
}
