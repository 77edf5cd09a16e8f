//! `jostle record`: pushes in generated scenes, executed by an engine, as a file of recorded pushes.

use jostle::eval::{RecordParams, record, recording_lines};
use jostle::physics;
use jostle::scene::generate::GeneratorParams;

use crate::args::RecordArgs;
use crate::output::{self, Outcome};
use crate::progress;

pub fn run(args: &RecordArgs) -> Outcome<()> {
    let options = args.physics.judging()?;
    let mut params = RecordParams { count: args.count, seed: args.seed, ..RecordParams::default() };
    if let Some((least, most)) = args.bodies {
        params.scenes = GeneratorParams { bodies: least..=most, ..params.scenes };
    }
    let bar = progress::bar(args.count as u64, "pushes");
    let network = physics::network(&options)?;
    let engine = |scene| physics::engine_with(&options, scene, network.as_ref());
    let recordings = record(&params, &engine, &mut |done| {
        bar.set_position(done as u64);
        true
    })?;
    bar.finish_and_clear();
    output::write_file(&args.file, &recording_lines(&recordings)?)?;
    output::emit(&format!(
        "{}: {} pushes by {} {}, seed {}\n",
        args.file.display(),
        recordings.len(),
        options.engine,
        options.preset,
        args.seed
    ))
}
