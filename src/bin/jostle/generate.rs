//! `jostle generate`: random problems as scene files.

use jostle::eval::{needs_pushes, push_travel, with_gripper};
use jostle::scene::Gripper;
use jostle::scene::generate::{Generator, GeneratorParams};
use serde::Serialize;

use crate::args::{GenerateArgs, GenerateKind};
use crate::clear;
use crate::output::{self, Failure, Outcome};
use crate::rearrange;

#[derive(Serialize)]
struct Report {
    version: &'static str,
    seed: u64,
    gripper: String,
    files: Vec<Written>,
}

#[derive(Serialize)]
struct Written {
    file: String,
    bodies: usize,
}

pub fn run(args: &GenerateArgs) -> Outcome<()> {
    match &args.kind {
        Some(GenerateKind::Rearrange(args)) => return rearrange::generate(args),
        Some(GenerateKind::Clear(args)) => return clear::generate(args),
        None => {}
    }
    let folder = args.folder.as_deref().ok_or_else(|| Failure::usage("FOLDER is missing; see --help"))?;
    let defaults = GeneratorParams::default();
    let params = GeneratorParams {
        bodies: args.bodies.map_or(defaults.bodies, |(least, most)| least..=most),
        profile: args.profile.profile().unwrap_or_default(),
        ..defaults
    };
    let gripper = args.gripper.as_deref().map_or_else(|| Ok(Gripper::default()), Gripper::by_name)?;
    let generator = Generator::new(params, args.seed)?;
    // Whether a push is needed depends on the gripper, so it is changed before the test.
    let length = push_travel(args.profile.profile().unwrap_or_default());
    let problems = generator.generate_filtered(args.count, |problem| {
        with_gripper(problem, &gripper).and_then(|problem| needs_pushes(&problem, args.pushes, length)).unwrap_or(false)
    })?;
    std::fs::create_dir_all(folder).map_err(|e| Failure::failed(format!("{}: {e}", folder.display())))?;
    let mut report = Report {
        version: env!("CARGO_PKG_VERSION"),
        seed: args.seed,
        gripper: gripper.name.clone(),
        files: Vec::new(),
    };
    let mut text = String::new();
    for problem in problems {
        let problem = with_gripper(&problem, &gripper)?;
        let path = folder.join(format!("{}.json", problem.name));
        output::write_file(&path, &problem.to_json()?)?;
        text.push_str(&format!("{}: {} bodies\n", path.display(), problem.scene.len()));
        report.files.push(Written { file: path.display().to_string(), bodies: problem.scene.len() });
    }
    output::report(args.json.json.as_deref(), &report, &text)
}
