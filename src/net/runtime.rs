//! Finds what runs networks: ONNX Runtime, looked for when it is first needed, or the embedded backend.
//!
//! One process has one runtime: the first that could be opened; a library that cannot be used is passed over, now and later. Nothing is linked, nothing is downloaded, and a machine without
//! it gets an error that says where it was looked for.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use ort::environment::{Environment, EnvironmentBuilder};

use crate::error::{Error, Result};
use crate::host;

/// The oldest ONNX Runtime that has the interface asked for.
pub const OLDEST: &str = "1.24";
/// Name of the library in the system's own folders.
const SYSTEM_NAME: &str = "libonnxruntime.so.1";
/// Where `scripts/setup.sh --test` puts it, below the project's root.
const PROJECT_FOLDER: &str = "third_party/onnxruntime/lib";
/// The variable that names the library, as other users of ONNX Runtime have it.
const VARIABLE: &str = "ORT_DYLIB_PATH";
/// The origin of a name that the system's search path is asked for.
const SYSTEM: &str = "the system's libraries";

/// What computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Backend {
    /// The shared library ONNX Runtime.
    OnnxRuntime,
    /// tract, embedded by the feature `tract`.
    Tract,
}

impl Backend {
    pub fn id(self) -> &'static str {
        match self {
            Backend::OnnxRuntime => "onnxruntime",
            Backend::Tract => "tract",
        }
    }

    /// The backend with this name.
    pub fn by_name(name: &str) -> Result<Backend> {
        match name {
            "onnxruntime" => Ok(Backend::OnnxRuntime),
            "tract" => Ok(Backend::Tract),
            _ => Err(Error::not_found(
                "runtime.backend",
                format!("no backend is named `{name}`; known: onnxruntime, tract"),
            )),
        }
    }
}

/// Which runtime is wanted.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RuntimeOptions {
    /// The file of ONNX Runtime's library. If given nothing else is tried.
    pub library: Option<PathBuf>,
    /// The one backend to use; by default ONNX Runtime where it is found, else the embedded one if it was built in.
    pub backend: Option<Backend>,
}

/// The runtime of this process.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RuntimeInfo {
    pub backend: Backend,
    /// As far as it says so; "unknown" otherwise.
    pub version: String,
    /// The library's file; none for the embedded backend.
    pub file: Option<PathBuf>,
    /// What the backend says of its own build.
    pub build: String,
}

/// A runtime that works.
pub struct Runtime {
    info: RuntimeInfo,
    environment: Environment,
}

impl std::fmt::Debug for Runtime {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.info.fmt(f)
    }
}

static RUNTIME: OnceLock<Runtime> = OnceLock::new();
/// Held while a runtime is being opened.
static OPENING: Mutex<()> = Mutex::new(());

impl Runtime {
    /// The process's runtime; opens it if it is not open yet.
    ///
    /// # Errors
    /// [`Error::Runtime`] if none can be had, or the process has another one than the options ask for.
    pub fn open(options: &RuntimeOptions) -> Result<&'static Runtime> {
        let _opening = OPENING.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(runtime) = RUNTIME.get() {
            runtime.suits(options)?;
            return Ok(runtime);
        }
        let runtime = open(options)?;
        Ok(RUNTIME.get_or_init(|| runtime))
    }

    /// The process's runtime, if one was opened.
    pub fn current() -> Option<&'static Runtime> {
        RUNTIME.get()
    }

    pub fn info(&self) -> &RuntimeInfo {
        &self.info
    }

    pub(super) fn environment(&self) -> &Environment {
        &self.environment
    }

    fn suits(&self, options: &RuntimeOptions) -> Result<()> {
        let same_backend = options.backend.is_none_or(|wanted| wanted == self.info.backend);
        let same_file = options.library.as_ref().is_none_or(|wanted| {
            let real = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
            self.info.file.as_ref().is_some_and(|file| real(file) == real(wanted))
        });
        if same_backend && same_file {
            return Ok(());
        }
        Err(Error::Runtime(format!(
            "this process runs networks with {}; a process has one runtime, that of the first network it loads",
            self.info
        )))
    }
}

impl RuntimeInfo {
    /// All of it, for reports.
    pub fn to_json(&self) -> serde_json::Value {
        serde_json::json!({
            "backend": self.backend.id(),
            "version": self.version,
            "file": self.file.as_ref().map(|file| file.display().to_string()),
            "build": self.build,
        })
    }
}

impl std::fmt::Display for RuntimeInfo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.backend.id(), self.version)?;
        match &self.file {
            Some(file) => write!(f, " ({})", file.display()),
            None => Ok(()),
        }
    }
}

fn open(options: &RuntimeOptions) -> Result<Runtime> {
    let mut tried = String::new();
    if options.backend != Some(Backend::Tract) {
        for candidate in candidates(options) {
            match open_library(&candidate) {
                Ok(runtime) => return Ok(runtime),
                Err(why) => {
                    let _ = write!(tried, "\n  {}: {}: {why}", candidate.origin, candidate.path.display());
                }
            }
        }
    }
    let embedded = options.backend != Some(Backend::OnnxRuntime) && options.library.is_none();
    if embedded && cfg!(feature = "tract") {
        return open_embedded();
    }
    if options.backend == Some(Backend::Tract) {
        return Err(Error::Runtime("this build has no embedded backend; build with the feature `tract`".into()));
    }
    Err(Error::Runtime(format!(
        "networks need ONNX Runtime {OLDEST} or newer, and none was found. Get it with scripts/setup.sh --test, or name its \
         library in the option `runtime.library` or in {VARIABLE}, or build with the feature `tract`. Tried:{tried}"
    )))
}

/// A place where the library may be.
struct Candidate {
    origin: &'static str,
    path: PathBuf,
}

/// In the order in which they are tried.
fn candidates(options: &RuntimeOptions) -> Vec<Candidate> {
    let mut found = Vec::new();
    let mut add = |origin, path: PathBuf| found.push(Candidate { origin, path });
    if let Some(path) = &options.library {
        add("runtime.library", path.clone());
        return found;
    }
    if let Some(path) = std::env::var_os(VARIABLE).filter(|path| !path.is_empty()) {
        add(VARIABLE, path.into());
    }
    let own = host::own_file();
    let program = std::env::current_exe().ok();
    for (origin, file) in [("beside jostle's library", &own), ("beside the program", &program)] {
        let Some(folder) = file.as_deref().and_then(Path::parent) else { continue };
        let beside = folder.join(SYSTEM_NAME);
        if beside.exists() {
            add(origin, beside);
        }
        // A program in the folder `target` of a project's checkout.
        let root = folder.ancestors().take(3).find(|a| a.file_name().is_some_and(|n| n == "target"));
        let Some(project) = root.and_then(Path::parent).map(|root| root.join(PROJECT_FOLDER).join(SYSTEM_NAME)) else {
            continue;
        };
        if project.exists() {
            add("the checkout", project);
        }
    }
    found.dedup_by(|a, b| a.path == b.path);
    found.push(Candidate { origin: SYSTEM, path: SYSTEM_NAME.into() });
    found
}

fn open_library(candidate: &Candidate) -> std::result::Result<Runtime, String> {
    let path = &candidate.path;
    // A path without a folder would be looked for in the system's.
    let bare = path.components().count() == 1 && candidate.origin == SYSTEM;
    let path = if bare { path.clone() } else { std::path::absolute(path).map_err(|e| e.to_string())? };
    if !bare && !path.is_file() {
        return Err("there is no such file".into());
    }
    let _standard = host::Standard::enter();
    let found = host::probe(&path, ort::MINOR_VERSION)?;
    let builder = ort::init_from(&found.file).map_err(|error| error.to_string())?;
    let environment = environment(builder)?;
    let build = ort::info().to_string();
    let info = RuntimeInfo { backend: Backend::OnnxRuntime, version: found.version, file: Some(found.file), build };
    Ok(Runtime { info, environment })
}

#[cfg(feature = "tract")]
fn open_embedded() -> Result<Runtime> {
    ort::set_api(ort_tract::api());
    let environment = environment(ort::init()).map_err(Error::Runtime)?;
    let build = ort::info().to_string();
    // "... backend=ort-tract, version=0.5.0+0.23": the crate's version and tract's.
    let version = build.split("version=").nth(1).and_then(|rest| rest.split([',', ' ']).next()).map(str::to_string);
    let info = RuntimeInfo {
        backend: Backend::Tract,
        version: version.unwrap_or_else(|| "unknown".into()),
        file: None,
        build,
    };
    Ok(Runtime { info, environment })
}

#[cfg(not(feature = "tract"))]
fn open_embedded() -> Result<Runtime> {
    Err(Error::Internal("the embedded backend is not built but was not refused".into()))
}

/// The environment, which keeps silent: the library prints nothing, and neither must what it loads.
fn environment(builder: EnvironmentBuilder) -> std::result::Result<Environment, String> {
    let silent: ort::logging::LoggerFunction = Arc::new(|_, _, _, _, _| ());
    let builder = builder.with_name("jostle").with_telemetry(false).with_logger(silent);
    builder.build().map_err(|error| error.message().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_library_that_is_none_is_an_error_that_says_what_was_tried() {
        let missing = RuntimeOptions { library: Some("/nowhere/libonnxruntime.so".into()), backend: None };
        let text = open(&missing).unwrap_err().to_string();
        assert!(text.contains("runtime.library: /nowhere/libonnxruntime.so: there is no such file"), "{text}");
        assert!(text.contains("scripts/setup.sh --test") && text.contains(VARIABLE), "{text}");
        let program = RuntimeOptions { library: std::env::current_exe().ok(), backend: None };
        assert!(open(&program).is_err());
    }

    #[test]
    #[cfg(not(feature = "tract"))]
    fn an_embedded_backend_that_was_not_built_is_refused() {
        let options = RuntimeOptions { library: None, backend: Some(Backend::Tract) };
        assert!(open(&options).unwrap_err().to_string().contains("feature `tract`"));
    }
}
