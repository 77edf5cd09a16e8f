//! `jostle assess`: networks held against engines; `assess_robot` has what is held against a robot.

use std::sync::Arc;

use jostle::action::Grasp;
use jostle::datagen::{
    Agreement, ChainParams, ChainReport, ClassifierTrials, EngineMaker, GraspTally, GraspTrialParams, GraspTrials,
    SceneParams, ShapeFamily, StatedProbability, chains, try_classifier, try_grasps,
};
use jostle::net::{Gc, Gn, GraspMap, ImageScratch, Kind, LoadOptions, Model, TargetProbability, check_gripper};
use jostle::physics::{self, PhysicsOptions, Purpose, Transition};
use jostle::run::Stop;
use jostle::scene::{Scene, State};
use serde::Serialize;

use crate::args::{AssessChainArgs, AssessCommand, AssessGraspArgs, HeldOutArgs};
use crate::assess_robot;
use crate::output::{self, Outcome};
use crate::progress;
use crate::table::{Table, number, percent};

#[derive(Serialize)]
struct Report<T: Serialize> {
    version: &'static str,
    seed: u64,
    shape_seed: u64,
    shapes: usize,
    #[serde(flatten)]
    found: T,
}

pub fn run(command: &AssessCommand) -> Outcome<()> {
    match command {
        AssessCommand::Chain(args) => chain(args),
        AssessCommand::Grasp(args) => grasp(args),
        AssessCommand::Robot(args) => assess_robot::run(args),
    }
}

/// An engine whose network, if it has one, is loaded once.
fn maker(options: PhysicsOptions) -> Outcome<impl Fn(Arc<Scene>) -> jostle::Result<Arc<dyn Transition>>> {
    let network = physics::network(&options)?;
    Ok(move |scene| physics::engine_with(&options, scene, network.as_ref()))
}

fn family(args: &HeldOutArgs) -> Outcome<Arc<ShapeFamily>> {
    Ok(Arc::new(ShapeFamily::new(args.shape_seed, args.shapes)?))
}

fn report<T: Serialize>(args: &HeldOutArgs, found: T) -> Report<T> {
    let version = env!("CARGO_PKG_VERSION");
    Report { version, seed: args.seed, shape_seed: args.shape_seed, shapes: args.shapes, found }
}

fn chain(args: &AssessChainArgs) -> Outcome<()> {
    let parsed: Result<Vec<_>, _> = args.physics.iter().map(|e| PhysicsOptions::parse(e, Purpose::Planning)).collect();
    let engines = parsed?.into_iter().map(maker).collect::<Outcome<Vec<_>>>()?;
    let engines: Vec<EngineMaker<'_>> = engines.iter().map(|e| e as EngineMaker<'_>).collect();
    let reference = maker(args.judge.physics()?)?;
    let defaults = ChainParams::default();
    let scenes = match args.bodies {
        Some((least, most)) => SceneParams { bodies: least..=most, ..defaults.scenes },
        None => defaults.scenes,
    };
    let params = ChainParams { scenes, chains: args.count, pushes: args.pushes, seed: args.scenes.seed };
    let bar = progress::bar(args.count as u64, "chains");
    let done = &mut |n: usize| bar.set_position(n as u64);
    let found = chains(&params, &family(&args.scenes)?, &reference, &engines, &Stop::never(), done)?;
    bar.finish_and_clear();
    let text = chain_text(&found);
    output::report(args.json.json.as_deref(), &report(&args.scenes, found), &text)
}

fn chain_text(found: &ChainReport) -> String {
    let mut table =
        Table::new(["engine", "push", "1 - IoU, moved", "position, mm", "rotation, deg", "1 - IoU", "refused"]);
    for engine in &found.engines {
        for step in &engine.steps {
            table.row([
                engine.engine.clone(),
                step.push.to_string(),
                number(Some(step.moved_one_minus_iou), 3),
                number(Some(step.moved_position_mm), 1),
                number(Some(step.moved_rotation_deg), 1),
                number(Some(step.one_minus_iou), 3),
                step.refused.to_string(),
            ]);
        }
    }
    let moved = found.engines.first().map_or(0, |e| e.steps.last().map_or(0, |s| s.moved));
    format!(
        "against {} in {} chains of held-out scenes; {} bodies, {moved} moved in the end\n\n{table}",
        found.reference, found.chains, found.bodies
    )
}

fn grasp(args: &AssessGraspArgs) -> Outcome<()> {
    let model = Model::open(&args.model, None, &LoadOptions::default())?;
    match model.info().kind {
        Kind::Gc => classifier(args, &Gc::new(model)?),
        _ => map(args, &Gn::new(model)?),
    }
}

fn trials(args: &AssessGraspArgs) -> GraspTrialParams {
    GraspTrialParams { targets: args.count, seed: args.scenes.seed, ..GraspTrialParams::default() }
}

/// Whether a target can be grasped.
fn classifier(args: &AssessGraspArgs, gc: &Gc) -> Outcome<()> {
    let judge = maker(args.judge.physics()?)?;
    let mut scratch = ImageScratch::default();
    let mut stated = |scene: &Scene, state: &State, target: usize| {
        check_gripper("scene.gripper", gc.model().info(), scene.gripper())?;
        gc.probability(&mut scratch, scene, state, target, &Stop::never())
    };
    let bar = progress::bar(args.count as u64, "targets");
    let done = &mut |n: usize| bar.set_position(n as u64);
    let network = (&mut stated as StatedProbability<'_>, gc.threshold());
    let found = try_classifier(&trials(args), &family(&args.scenes)?, &judge, network, &Stop::never(), done)?;
    bar.finish_and_clear();
    let text = classifier_text(&found);
    output::report(args.json.json.as_deref(), &report(&args.scenes, found), &text)
}

/// Where a target is best grasped.
fn map(args: &AssessGraspArgs, gn: &Gn) -> Outcome<()> {
    let judge = maker(args.judge.physics()?)?;
    let (mut scratch, mut best) = (ImageScratch::default(), Vec::new());
    let mut named = |scene: &Scene, state: &State, target: usize| {
        check_gripper("scene.gripper", gn.model().info(), scene.gripper())?;
        gn.best(&mut scratch, scene, state, target, 1, &mut best, &Stop::never())?;
        let opening = scene.gripper().grasp.opening;
        Ok(best.first().map(|b| Grasp {
            body: target,
            position: [b.position.x, b.position.y],
            angle: b.angle,
            opening,
            score: b.quality,
            ..Grasp::default()
        }))
    };
    let bar = progress::bar(args.count as u64, "targets");
    let done = &mut |n: usize| bar.set_position(n as u64);
    let found = try_grasps(&trials(args), &family(&args.scenes)?, &judge, &mut named, &Stop::never(), done)?;
    bar.finish_and_clear();
    let text = grasp_text(&found);
    output::report(args.json.json.as_deref(), &report(&args.scenes, found), &text)
}

fn classifier_text(found: &ClassifierTrials) -> String {
    let mut table = Table::new(["can the target be grasped", "targets", "can", "right", "precision", "recall"]);
    let rows: [(&str, &Agreement); 3] = [
        ("network, against the geometric test", &found.network),
        ("network, against the engine", &found.network_in_engine),
        ("geometric test, against the engine", &found.geometric_in_engine),
    ];
    for (name, agreement) in rows {
        table.row([
            name.to_string(),
            agreement.targets.to_string(),
            agreement.yes.to_string(),
            percent(Some(agreement.accuracy)),
            percent(Some(agreement.precision)),
            percent(Some(agreement.recall)),
        ]);
    }
    let mut bins = Table::new(["probability", "targets", "stated", "by the geometric test", "in the engine"]);
    for bin in found.reliability.iter().filter(|bin| bin.targets > 0) {
        bins.row([
            format!("{:.1} to {:.1}", bin.from, bin.to),
            bin.targets.to_string(),
            number(Some(bin.stated), 2),
            number(Some(bin.geometric), 2),
            number(Some(bin.engine), 2),
        ]);
    }
    format!("{}, yes from {:.2} on\n\n{table}\n{bins}", found.judge, found.threshold)
}

fn grasp_text(found: &GraspTrials) -> String {
    let mut table = Table::new(["grasps", "targets", "named", "valid by geometry", "succeeded"]);
    let rows: [(&str, &GraspTally); 5] = [
        ("network's best", &found.network),
        ("best of the grid", &found.grid),
        ("geometric test's best", &found.geometric),
        ("network's best where the grid's scores enough to be executed", &found.network_where_good),
        ("network's best where the grid's succeeds", &found.network_where_grid_succeeds),
    ];
    for (name, tally) in rows {
        table.row([
            name.to_string(),
            tally.targets.to_string(),
            tally.named.to_string(),
            percent(Some(tally.validity)),
            percent(Some(tally.success)),
        ]);
    }
    format!("{}: {} targets looked at, {} graspable\n\n{table}", found.judge, found.looked_at, found.graspable)
}
