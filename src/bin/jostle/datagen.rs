//! `jostle datagen`: training data for the networks.

use std::sync::Arc;

use jostle::datagen::{
    self, GraspDataParams, Manifest, PpnParams, PushParams, SceneParams, SegmentParams, ShapeFamily, StoreParams,
};
use jostle::net::{Kind, LoadOptions, Model};
use jostle::physics::{PhysicsOptions, Purpose};
use jostle::run::Stop;

use crate::args::{
    DatagenArgs, DatagenCommand, DatagenGraspArgs, DatagenPpnArgs, DatagenPushArgs, DatagenSegmentArgs, FromArg,
};
use crate::output::{self, Outcome};
use crate::progress;

pub fn run(command: &DatagenCommand) -> Outcome<()> {
    match command {
        DatagenCommand::Push(args) => push(args),
        DatagenCommand::Ppn(args) => ppn(args),
        DatagenCommand::Grasp(args) => grasp(args),
        DatagenCommand::Segment(args) => segment(args),
    }
}

fn push(args: &DatagenPushArgs) -> Outcome<()> {
    let defaults = PushParams::new(PhysicsOptions::parse(&args.physics, Purpose::Judging)?);
    let scenes = scenes(&args.data, defaults.scenes);
    let params = PushParams { scenes, pushes: args.pushes, states: args.states, ..defaults };
    make(&args.data, |family, store, progress| {
        datagen::push(&params, family, args.data.shape_seed, &args.data.folder, store, &Stop::never(), progress)
    })
}

fn ppn(args: &DatagenPpnArgs) -> Outcome<()> {
    let defaults = PpnParams::new()?;
    let bodies = defaults.scenes.bodies.clone();
    let from = match args.from {
        FromArg::Generated => defaults.scenes,
        FromArg::Mixed => SceneParams { bodies, ..SceneParams::default() },
    };
    let (sampler, scenes) = (args.sampler.clone(), scenes(&args.data, from));
    let prior = args.prior.as_deref();
    let prior = prior.map(|file| Model::open(file, Some(Kind::Ppn), &LoadOptions::default())).transpose()?;
    let params = PpnParams { scenes, states: args.states, iterations: args.iterations, sampler, prior, ..defaults };
    make(&args.data, |family, store, progress| {
        datagen::ppn(&params, family, args.data.shape_seed, &args.data.folder, store, &Stop::never(), progress)
    })
}

fn grasp(args: &DatagenGraspArgs) -> Outcome<()> {
    let trials = match args.label.as_str() {
        "geometric" => None,
        engine => Some(PhysicsOptions::parse(engine, Purpose::Judging).map_err(|e| e.within("label"))?),
    };
    let defaults = GraspDataParams::default();
    let params = GraspDataParams {
        scenes: scenes(&args.data, defaults.scenes),
        states: args.states,
        targets: args.targets,
        trials,
        trial_share: args.trial_share,
    };
    make(&args.data, |family, store, progress| {
        datagen::grasp(&params, family, args.data.shape_seed, &args.data.folder, store, &Stop::never(), progress)
    })
}

fn segment(args: &DatagenSegmentArgs) -> Outcome<()> {
    let params = SegmentParams { scenes: scenes(&args.data, SceneParams::default()), states: args.states };
    make(&args.data, |family, store, progress| {
        datagen::segment(&params, family, args.data.shape_seed, &args.data.folder, store, &Stop::never(), progress)
    })
}

/// The scenes with the number of bodies that was asked for.
fn scenes(args: &DatagenArgs, scenes: SceneParams) -> SceneParams {
    match args.bodies {
        Some((least, most)) => SceneParams { bodies: least..=most, ..scenes },
        None => scenes,
    }
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
