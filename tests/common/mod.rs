//! What the tests of the C API share: the header's functions, the library's files, and the C compilers.

#![allow(dead_code)]

pub mod calls;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Mutex;

pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// A function as the header declares it.
#[derive(Debug, Clone)]
pub struct Function {
    pub name: String,
    pub returns: String,
    /// Names of the parameters.
    pub parameters: Vec<String>,
    /// Types of the parameters, as written.
    pub types: Vec<String>,
    /// Lines of the comment before it.
    pub docs: Vec<String>,
}

pub struct Header {
    pub text: String,
    pub functions: Vec<Function>,
}

/// Reads the committed header.
pub fn header() -> Header {
    let text = std::fs::read_to_string(root().join("include/jostle/jostle.h")).expect("the header");
    let mut functions = Vec::new();
    let mut docs: Vec<String> = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if let Some(comment) = line.strip_prefix("///") {
            docs.push(comment.trim().to_string());
            continue;
        }
        let declares = line.contains(" jostle_") || line.contains("*jostle_");
        if declares
            && line.contains('(')
            && !line.starts_with([' ', '#', '}'])
            && !line.starts_with("typedef")
            && !line.starts_with("static")
        {
            let mut whole = line.to_string();
            while !whole.trim_end().ends_with(';') {
                whole.push_str(lines.next().expect("a declaration ends").trim());
            }
            functions.push(parse(&whole, std::mem::take(&mut docs)));
        }
        docs.clear();
    }
    Header { text, functions }
}

fn parse(declaration: &str, docs: Vec<String>) -> Function {
    let (head, tail) = declaration.split_once('(').expect("a declaration has parameters");
    let at = head.rfind([' ', '*']).expect("a declaration has a type") + 1;
    let inner = tail.rsplit_once(')').expect("a declaration closes").0;
    let mut function = Function {
        name: head[at..].to_string(),
        returns: head[..at].trim().to_string(),
        parameters: Vec::new(),
        types: Vec::new(),
        docs,
    };
    for parameter in inner.split(',').map(str::trim).filter(|p| *p != "void") {
        let at = parameter.rfind([' ', '*']).expect("a parameter has a type") + 1;
        function.parameters.push(parameter[at..].to_string());
        function.types.push(parameter[..at].trim().to_string());
    }
    function
}

/// Folder of this build's libraries.
pub fn target_dir() -> PathBuf {
    // target/<profile>/deps/<test>
    let test = std::env::current_exe().expect("the test knows its path");
    test.parent().and_then(Path::parent).expect("the test lies in target/<profile>/deps").to_path_buf()
}

/// The features of this build.
const FEATURES: [&str; 2] =
    [if cfg!(feature = "cli") { "cli" } else { "" }, if cfg!(feature = "bullet") { "bullet" } else { "" }];

/// Makes sure that the shared and the static library of this profile exist and are up to date. `cargo test` builds
/// them along with the tests, but puts them where programs look for them only on `cargo build`.
pub fn libraries() -> PathBuf {
    static DONE: Mutex<bool> = Mutex::new(false);
    let mut done = DONE.lock().unwrap_or_else(|e| e.into_inner());
    let dir = target_dir();
    if !*done {
        let profile = match dir.file_name().and_then(|n| n.to_str()) {
            Some("debug") | None => "dev",
            Some(other) => other,
        };
        let target = dir.parent().expect("the profile's folder lies in target");
        let output = Command::new(env!("CARGO"))
            .current_dir(root())
            .args(["build", "--lib", "--offline", "--quiet", "--profile", profile, "--target-dir"])
            .arg(target)
            // The same features as the tests: another set would build the library anew.
            .args(["--features", &FEATURES.join(",")])
            .output()
            .expect("cargo runs");
        assert!(output.status.success(), "cargo build --lib: {}", String::from_utf8_lossy(&output.stderr));
        let soname = dir.join("libjostle.so.0");
        if !soname.exists() {
            // The name that programs look for at run time. Another test may be making it.
            let _ = std::os::unix::fs::symlink("libjostle.so", &soname);
        }
        *done = true;
    }
    dir
}

/// A folder of this test's own for what it builds.
pub fn scratch(name: &str) -> PathBuf {
    let dir = target_dir().join("capi").join(name);
    std::fs::create_dir_all(&dir).expect("the folder can be made");
    dir
}

/// What the static library needs of Bullet, where it has that engine.
pub const BULLET: &[&str] = if cfg!(feature = "bullet") {
    &["-lBulletDynamics-float64", "-lBulletCollision-float64", "-lLinearMath-float64", "-lstdc++"]
} else {
    &[]
};

/// What a static library of Rust needs of the system.
pub const SYSTEM: [&str; 7] = ["-lgcc_s", "-lutil", "-lrt", "-lpthread", "-lm", "-ldl", "-lc"];

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Link {
    Shared,
    Static,
}

/// The compiler and its flags by a source's ending.
pub fn compiler(source: &Path) -> Command {
    let cpp = source.extension().is_some_and(|e| e == "cpp");
    let (name, usual, std) = if cpp { ("CXX", "g++", "-std=c++17") } else { ("CC", "gcc", "-std=c11") };
    let mut command = Command::new(std::env::var(name).unwrap_or_else(|_| usual.into()));
    command.args([std, "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-g", "-O1", "-pthread"]);
    if !cpp {
        // POSIX for threads and clocks, as a strict C11 hides them.
        command.args(["-D_POSIX_C_SOURCE=200809L", "-Wstrict-prototypes", "-Wmissing-prototypes"]);
    }
    command.arg("-I").arg(root().join("include"));
    command
}

/// Builds a program and gives its path.
pub fn build(sources: &[&str], name: &str, link: Link, flags: &[&str]) -> PathBuf {
    let libraries = libraries();
    let program = scratch(name).join(format!("{name}-{link:?}").to_lowercase());
    let first = root().join(sources[0]);
    let mut command = compiler(&first);
    command.args(flags).args(sources.iter().map(|s| root().join(s))).arg("-o").arg(&program);
    match link {
        Link::Shared => {
            command.arg("-L").arg(&libraries).arg("-ljostle").arg("-lm");
            command.arg(format!("-Wl,-rpath,{}", libraries.display()));
        }
        Link::Static => {
            command.arg(libraries.join("libjostle.a")).args(BULLET).args(SYSTEM);
        }
    }
    let output = command.output().expect("the compiler runs");
    assert!(output.status.success(), "{command:?}\n{}", String::from_utf8_lossy(&output.stderr));
    program
}

/// Runs a program in a folder of its own and wants success.
pub fn run(program: &Path) -> String {
    let output = output(&mut Command::new(program), program);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        output.status.success(),
        "{}: {}\n{text}\n{}",
        program.display(),
        output.status,
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(output.stderr.is_empty(), "stderr of {}: {}", program.display(), String::from_utf8_lossy(&output.stderr));
    text
}

/// Runs a command beside the program, where it may leave files.
pub fn output(command: &mut Command, program: &Path) -> Output {
    let dir = program.parent().expect("a program lies in a folder");
    command.current_dir(dir).output().expect("the program runs")
}

/// A tool is installed.
pub fn has(tool: &str) -> bool {
    Command::new(tool).arg("--version").output().is_ok_and(|o| o.status.success())
}

/// The fields of a struct of the header, in order.
pub struct Struct {
    pub name: String,
    pub fields: Vec<String>,
    /// Types of the fields, as in `const jostle_vec2 *`.
    pub types: Vec<String>,
}

/// The structs whose layout the header gives.
pub fn structs() -> Vec<Struct> {
    let text = header().text;
    let mut structs = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let Some(name) = line.strip_prefix("typedef struct ").and_then(|l| l.strip_suffix(" {")) else { continue };
        let (fields, types) = lines
            .by_ref()
            .take_while(|l| !l.starts_with('}'))
            .map(str::trim)
            .filter(|l| !l.starts_with("///"))
            .filter_map(|l| l.strip_suffix(';'))
            .map(|l| l.split_at(l.rfind([' ', '*']).expect("a field has a type") + 1))
            .map(|(kind, field)| (field.to_string(), kind.trim().replace("struct ", "")))
            .unzip();
        structs.push(Struct { name: name.to_string(), fields, types });
    }
    structs
}
