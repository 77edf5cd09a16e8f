//! What the tool says: reports to standard output or a file, one line on errors.

use std::io::{ErrorKind, Write};
use std::path::Path;
use std::process::ExitCode;

use jostle::Error;
use serde::Serialize;

/// Why a command ends without a result.
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

    /// The same with the place before the reason.
    pub fn within(self, place: &str) -> Failure {
        Failure { reason: format!("{place}: {}", self.reason), ..self }
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

/// Writes a file.
pub fn write_file(path: &Path, text: &str) -> Outcome<()> {
    std::fs::write(path, text).map_err(|e| Failure::failed(format!("{}: {e}", path.display())))
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
