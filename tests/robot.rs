//! What is foretold of a robot's grasps, on its recordings (which are not part of the repository).

use std::path::{Path, PathBuf};

use jostle::action::Action;
use jostle::eval::robot::{
    GraspOutcome, GraspReliability, RobotGrasp, RobotRecords, fit_keeping, grasp_reliability, push_accuracy,
};
use jostle::eval::{Effect, Executor, Judge, JudgeOptions};
use jostle::grasp::{GraspParams, GraspScratch, GraspTest};
use jostle::physics::{EngineInfo, PhysicsOptions, Purpose, engine};
use jostle::scene::{GraspFeatures, Gripper, Keeping};

fn recorded(split: &str) -> Option<Vec<RobotGrasp>> {
    records("grasps.jsonl", split).map(|records| records.grasps)
}

fn records(file: &str, split: &str) -> Option<RobotRecords> {
    let root = std::env::var_os("JOSTLE_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let path = root.join("data/robot").join(file);
    if !path.exists() {
        println!("skipped: {} is not there (set JOSTLE_SHARED)", path.display());
        return None;
    }
    Some(RobotRecords::read(&[path]).unwrap().of_split(split))
}

fn features(grasps: &[RobotGrasp]) -> Vec<(GraspFeatures, bool)> {
    let (gripper, mut scratch) = (Gripper::robotiq_2f85(), GraspScratch::default());
    let test = GraspTest::new(GraspParams::default()).unwrap();
    let mut all = Vec::new();
    for attempt in grasps {
        let problem = attempt.problem(&gripper).unwrap();
        let found = test.features(&problem.scene, &problem.state, &attempt.grasp(&gripper), &mut scratch);
        all.extend(found.map(|found| (found, attempt.went_well(GraspOutcome::Kept))));
    }
    all
}

/// Scores of all, and of the library's own choices.
fn reliability(gripper: &Gripper, grasps: &[RobotGrasp]) -> [GraspReliability; 2] {
    let (test, mut scratch) = (GraspTest::new(GraspParams::default()).unwrap(), GraspScratch::default());
    let mut scores = [Vec::new(), Vec::new()];
    for attempt in grasps {
        let problem = attempt.problem(gripper).unwrap();
        let check = test.check(&problem.scene, &problem.state, &attempt.grasp(gripper), &mut scratch);
        let pair = (check.chance.unwrap_or(check.score), attempt.went_well(GraspOutcome::Kept));
        scores[0].push(pair);
        if attempt.proposer == "jostle" {
            scores[1].push(pair);
        }
    }
    scores.map(|scores| grasp_reliability(&scores, 0.5).unwrap())
}

/// Fitted on `fit`, looked at on `report`.
#[test]
fn the_chance_of_keeping_is_what_the_robot_kept() {
    let Some(grasps) = recorded("report") else { return };
    let [all, own] = reliability(&Gripper::robotiq_2f85_kept(), &grasps);
    println!("{all:#?}\n{own:#?}");
    assert!(all.count == 1009 && all.log_loss <= 0.35 && all.accuracy >= 0.84, "{all:?}");
    assert!(own.auc.unwrap() >= 0.85, "{own:?}");
    let [_, by_shape] = reliability(&Gripper::robotiq_2f85(), &grasps);
    assert!(by_shape.auc.unwrap() < own.auc.unwrap() - 0.15, "the shape of the grip says little: {by_shape:?}");
}

#[test]
fn the_tables_of_the_2f85_are_what_the_fit_gives_and_the_same_each_time() {
    let Some(grasps) = recorded("fit") else { return };
    let base = Keeping::robotiq_2f85();
    let fitted = fit_keeping(&base, &features(&grasps)).unwrap();
    assert_eq!(fitted, fit_keeping(&base, &features(&grasps)).unwrap());
    let values = |k: &Keeping| -> Vec<[f64; 2]> {
        let tables = [&k.width, &k.touch, &k.turn, &k.end, &k.clearance, &k.depth, &k.mass];
        tables.iter().flat_map(|table| table.points.clone()).chain([[0.0, k.bias]]).collect()
    };
    for (ours, theirs) in values(&base).iter().zip(values(&fitted)) {
        assert!(ours[0] == theirs[0] && (ours[1] - theirs[1]).abs() < 2e-3, "{ours:?} {theirs:?}");
    }
}

/// The path was fitted on `fit`, and so was what `planar` makes of it.
#[test]
fn with_the_path_of_the_tip_pushes_go_where_the_robot_s_went() {
    let Some(records) = records("pushes.jsonl", "report") else { return };
    let median = |name: &str, gripper: Gripper| {
        let options = PhysicsOptions::named(name, Some("fast"), Purpose::Planning).unwrap();
        let found = push_accuracy(&records.pushes, &gripper, &|scene| engine(&options, scene)).unwrap();
        println!("{} {}: {found:?}", name, gripper.name);
        assert!(found.count == 132 && found.refused <= 6, "{found:?}");
        found.median_position_mm
    };
    let bullet = EngineInfo::find("bullet").unwrap().available.is_ok().then_some(("bullet", 3.3));
    for (name, most) in [("planar", 7.0), ("prism", 4.0)].into_iter().chain(bullet) {
        let (with, without) = (median(name, Gripper::robotiq_2f85_ur5e()), median(name, Gripper::robotiq_2f85()));
        assert!(with <= most && with < without - 1.5, "{name}: {with} with the path, {without} without");
    }
}

/// Over repeated worlds.
#[test]
fn the_robot_as_judge_keeps_what_the_robot_kept() {
    let Some(grasps) = recorded("report") else { return };
    let options = JudgeOptions {
        executor: Executor::Robot,
        ..JudgeOptions::exact(PhysicsOptions::named("planar", None, Purpose::Planning).unwrap())
    };
    let (worlds, mut scores) = (40u32, Vec::new());
    for attempt in grasps.iter().step_by(3) {
        let problem = attempt.problem(&Gripper::robotiq_2f85()).unwrap();
        let kept = (0..worlds)
            .filter(|world| {
                let mut judge = Judge::new(&problem, &options, u64::from(*world)).unwrap();
                let grasp = Action::Grasp(attempt.grasp(&Gripper::robotiq_2f85()));
                judge.execute(&grasp).unwrap() == Effect::Grasped
            })
            .count();
        let share = (kept as f64 + 0.5) / (f64::from(worlds) + 1.0);
        scores.push((share, attempt.went_well(GraspOutcome::Kept)));
    }
    let found = grasp_reliability(&scores, 0.5).unwrap();
    println!("{found:#?}");
    assert!(found.accuracy >= 0.84 && found.log_loss <= 0.36, "{found:?}");
}

/// No file is needed for this.
#[test]
fn a_fit_wants_grasps_of_either_outcome() {
    let one = GraspFeatures { width: 0.045, touch: 0.022, height: 0.045, mass: 0.1, ..GraspFeatures::default() };
    let base = Keeping::robotiq_2f85();
    for grasps in [vec![(one, true); 49], vec![(one, true); 60], vec![(one, false); 60]] {
        let error = fit_keeping(&base, &grasps).unwrap_err().to_string();
        assert!(error.starts_with("grasps: ") && error.contains("went well"), "{error}");
    }
    // Where width alone tells kept from lost the fitted chance says so, and is level beyond what was recorded.
    let made: Vec<_> =
        (0..400).map(|i| (GraspFeatures { width: 0.01 + 0.06 * f64::from(i) / 400.0, ..one }, i >= 200)).collect();
    let fitted = fit_keeping(&base, &made).unwrap();
    let chance = |width: f64| fitted.chance(&GraspFeatures { width, ..one });
    assert!(chance(0.02) < 0.1 && chance(0.06) > 0.9, "{} {}", chance(0.02), chance(0.06));
    assert_eq!(chance(0.09), chance(0.3));
}
