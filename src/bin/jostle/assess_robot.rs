//! `jostle assess robot`: what the library foretells against what a robot did.

use jostle::eval::robot::{
    GraspOutcome, GraspReliability, PushAccuracy, RobotGrasp, RobotRecords, grasp_reliability, push_accuracy,
};
use jostle::grasp::{GraspParams, GraspScratch, GraspTest};
use jostle::physics;
use jostle::plan::GraspDecision;
use jostle::scene::Gripper;
use serde::Serialize;

use crate::args::{self, AssessRobotArgs, OutcomeArg};
use crate::output::{self, Failure, Outcome};
use crate::table::{Table, number, percent};

/// Who chose the grasps that the library itself chose.
const OWN: &str = "jostle";

impl From<OutcomeArg> for GraspOutcome {
    fn from(outcome: OutcomeArg) -> GraspOutcome {
        match outcome {
            OutcomeArg::Kept => GraspOutcome::Kept,
            OutcomeArg::Counted => GraspOutcome::Counted,
        }
    }
}

#[derive(Serialize)]
struct Report {
    version: &'static str,
    /// `fit`, `report` or `all`.
    split: &'static str,
    outcome: &'static str,
    gripper: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    grasps: Option<Grasps>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pushes: Option<PushAccuracy>,
}

#[derive(Serialize)]
struct Grasps {
    #[serde(flatten)]
    all: GraspReliability,
    /// The grasps that the library itself chose.
    own: GraspReliability,
}

pub fn run(args: &AssessRobotArgs) -> Outcome<()> {
    let gripper = args::gripper(&args.gripper)?;
    let mut records = RobotRecords::read(&args.files)?;
    if let Some(split) = args.split.name() {
        records = records.of_split(split);
    }
    let engine = args.physics.physics.is_some() || args.physics.preset.is_some();
    if engine && records.pushes.is_empty() {
        return Err(Failure::usage("--physics is given, but the files hold no pushes of this split"));
    }
    if !engine && records.grasps.is_empty() {
        return Err(Failure::usage("the files hold no grasps of this split; pushes want an engine, --physics"));
    }
    let grasps = if records.grasps.is_empty() { None } else { Some(grasps(&records.grasps, args, &gripper)?) };
    let pushes = if engine { Some(pushes(&records, args, &gripper)?) } else { None };
    let text = [grasps.as_ref().map(grasps_text), pushes.as_ref().map(pushes_text)];
    let text = text.into_iter().flatten().collect::<Vec<_>>().join("\n");
    let report = Report {
        version: env!("CARGO_PKG_VERSION"),
        split: args.split.name().unwrap_or("all"),
        outcome: match args.outcome {
            OutcomeArg::Kept => "kept",
            OutcomeArg::Counted => "counted",
        },
        gripper: gripper.name.clone(),
        grasps,
        pushes,
    };
    output::report(args.json.json.as_deref(), &report, &text)
}

fn grasps(recorded: &[RobotGrasp], args: &AssessRobotArgs, gripper: &Gripper) -> Outcome<Grasps> {
    let outcome = args.outcome.into();
    let (test, mut scratch) = (GraspTest::new(GraspParams::default())?, GraspScratch::default());
    let (mut all, mut own) = (Vec::with_capacity(recorded.len()), Vec::new());
    for attempt in recorded {
        let problem = attempt.problem(gripper)?;
        let check = test.check(&problem.scene, &problem.state, &attempt.grasp(gripper), &mut scratch);
        // The chance is that of any grasp; the score by shape is 0 where the library would not grasp so.
        let score = check.chance.unwrap_or(check.score);
        all.push((score, attempt.went_well(outcome)));
        if attempt.proposer == OWN {
            own.push((score, attempt.went_well(outcome)));
        }
    }
    let threshold = if gripper.keeping.is_some() { 0.5 } else { GraspDecision::default().execute_score };
    Ok(Grasps { all: grasp_reliability(&all, threshold)?, own: grasp_reliability(&own, threshold)? })
}

fn pushes(records: &RobotRecords, args: &AssessRobotArgs, gripper: &Gripper) -> Outcome<PushAccuracy> {
    let options = args.physics.options()?;
    let network = physics::network(&options)?;
    Ok(push_accuracy(&records.pushes, gripper, &|scene| physics::engine_with(&options, scene, network.as_ref()))?)
}

fn grasps_text(grasps: &Grasps) -> String {
    let mut table = Table::new(["grasps", "count", "held", "accuracy", "log-loss", "area under the curve"]);
    for (name, found) in [("all", &grasps.all), ("the library's own", &grasps.own)] {
        table.row([
            name.to_string(),
            found.count.to_string(),
            found.held.to_string(),
            percent(Some(found.accuracy)),
            number(Some(found.log_loss), 3),
            number(found.auc, 3),
        ]);
    }
    let mut bands = Table::new(["score", "grasps", "held", "share", "mean score", "own", "held", "share"]);
    for (all, own) in grasps.all.bands.iter().zip(&grasps.own.bands) {
        let share = |count: usize, share: f64| number((count > 0).then_some(share), 2);
        bands.row([
            format!("{:.1} to {:.1}", all.from, all.to),
            all.count.to_string(),
            all.held.to_string(),
            share(all.count, all.share),
            share(all.count, all.mean_score),
            own.count.to_string(),
            own.held.to_string(),
            share(own.count, own.share),
        ]);
    }
    format!("held is said from a score of {:.2} on\n\n{table}\n{bands}", grasps.all.threshold)
}

fn pushes_text(found: &PushAccuracy) -> String {
    let mut table = Table::new(["moved bodies", "median", "p90"]);
    let (position, rotation) =
        ((found.median_position_mm, found.p90_position_mm), (found.median_rotation_deg, found.p90_rotation_deg));
    for (name, (median, p90)) in [("position, mm", position), ("rotation, deg", rotation)] {
        table.row([name.to_string(), number(Some(median), 2), number(Some(p90), 2)]);
    }
    format!(
        "{} on {} pushes ({} left out, {} refused by the engine), {} bodies moved\n\n{table}",
        found.engine, found.count, found.left_out, found.refused, found.moved
    )
}
