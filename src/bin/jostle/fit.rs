//! `jostle fit`: what the library foretells, from recordings of a robot.

use jostle::eval::robot::{RobotRecords, fit_keeping};
use jostle::files::json;
use jostle::grasp::{GraspParams, GraspScratch, GraspTest};
use jostle::scene::{Gripper, Keeping};
use serde_json::Value;

use crate::args::{FitCommand, FitGraspArgs};
use crate::output::{self, Outcome};

pub fn run(command: &FitCommand) -> Outcome<()> {
    match command {
        FitCommand::Grasp(args) => grasp(args),
    }
}

fn grasp(args: &FitGraspArgs) -> Outcome<()> {
    let gripper = Gripper::by_name(&args.gripper)?;
    let mut records = RobotRecords::read(&args.files)?;
    if let Some(split) = args.split.name() {
        records = records.of_split(split);
    }
    let (test, mut scratch) = (GraspTest::new(GraspParams::default())?, GraspScratch::default());
    let mut grasps = Vec::with_capacity(records.grasps.len());
    for attempt in &records.grasps {
        let problem = attempt.problem(&gripper)?;
        let features = test.features(&problem.scene, &problem.state, &attempt.grasp(&gripper), &mut scratch);
        // Where nothing is between the pads there is nothing to keep.
        grasps.extend(features.map(|features| (features, attempt.went_well(args.outcome.into()))));
    }
    let base = Keeping::robotiq_2f85().scaled(gripper.scale());
    output::write_file(&args.output, &lines(&fit_keeping(&base, &grasps)?)?)
}

/// A field a line.
fn lines(keeping: &Keeping) -> Outcome<String> {
    let fields = serde_json::to_value(keeping).map_err(|e| output::Failure::failed(format!("the fit as JSON: {e}")))?;
    let fields = fields.as_object().into_iter().flatten();
    let line = |(name, value): (&String, &Value)| Ok(format!("  \"{name}\": {}", json::one_line(value)?));
    Ok(format!("{{\n{}\n}}\n", fields.map(line).collect::<jostle::Result<Vec<_>>>()?.join(",\n")))
}
