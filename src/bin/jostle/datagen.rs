//! `jostle datagen`: training data for the networks.

use std::sync::Arc;

use jostle::datagen::{self, Manifest, PushParams, SceneParams, ShapeFamily, StoreParams};
use jostle::physics::{PhysicsOptions, Purpose};
use jostle::run::Stop;

use crate::args::{DatagenArgs, DatagenCommand, DatagenPushArgs};
use crate::output::{self, Outcome};
use crate::progress;

pub fn run(command: &DatagenCommand) -> Outcome<()> {
    match command {
        DatagenCommand::Push(args) => push(args),
    }
}

fn push(args: &DatagenPushArgs) -> Outcome<()> {
    let physics = PhysicsOptions::parse(&args.physics, Purpose::Judging)?;
    let defaults = PushParams::new(physics);
    let params = PushParams {
        scenes: SceneParams { bodies: bodies(&args.data).unwrap_or(defaults.scenes.bodies), ..defaults.scenes },
        pushes: args.pushes,
        states: args.states,
        ..defaults
    };
    make(&args.data, |family, store, progress| {
        datagen::push(&params, family, args.data.shape_seed, &args.data.folder, store, &Stop::never(), progress)
    })
}

fn bodies(args: &DatagenArgs) -> Option<std::ops::RangeInclusive<usize>> {
    args.bodies.map(|(least, most)| least..=most)
}

/// Makes the data with a bar, and says what came of it.
fn make(
    args: &DatagenArgs,
    work: impl FnOnce(&Arc<ShapeFamily>, &StoreParams, &mut dyn FnMut(datagen::Made)) -> jostle::Result<Manifest>,
) -> Outcome<()> {
    let family = Arc::new(ShapeFamily::new(args.shape_seed, args.shapes)?);
    let store = StoreParams {
        count: args.count,
        shard: args.shard,
        seed: args.seed,
        threads: args.threads.unwrap_or_else(crate::args::cores),
    };
    let bar = progress::bar(args.count as u64, "rows");
    let manifest = work(&family, &store, &mut |made| bar.set_position(made.rows as u64))?;
    bar.finish_and_clear();
    let rows: usize = manifest.shards.iter().map(|s| s.count).sum();
    let mut text =
        format!("{}: {rows} rows in {} shards ({})\n", args.folder.display(), manifest.shards.len(), manifest.format);
    for (name, value) in &manifest.statistics {
        text.push_str(&format!("  {name}: {}\n", (value * 1e3).round() / 1e3));
    }
    output::report(args.json.json.as_deref(), &manifest, &text)
}
