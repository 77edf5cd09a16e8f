//! A network is refused another gripper when the planner is made where the options name it, else by the first call with a
//! scene; and nothing is changed by that. Stand-ins have what a file would say; files are loaded where there is a runtime.

#[path = "common/onnx.rs"]
mod onnx;

use std::sync::Arc;

use jostle::action::Push;
use jostle::error::{Error, Result};
use jostle::geom::{Pose2, Shape};
use jostle::net::{
    Configuration, GraspMap, ImageScratch, LoadOptions, MapGrasp, Model, ModelInfo, MotionModel, ObjectBatch,
    PushValue, PushValueScratch, TargetProbability, inspect,
};
use jostle::plan::clear::{ClearOptions, ClearPlanner};
use jostle::plan::{Control, OwnNetworks, Plan, Planner, PlannerOptions};
use jostle::run::{Budget, Stop};
use jostle::scene::{BodyDef, Clearing, Gripper, Problem, Scene, SceneBuilder, State};
use onnx::{bytes, net, runs, with_property};

/// A network of any kind that was made for a gripper.
struct StandIn(ModelInfo);

impl StandIn {
    fn made_for(kind: &str, gripper: &str) -> Arc<StandIn> {
        let mut info = inspect(&net(kind), None, &LoadOptions::default()).unwrap();
        info.spec.gripper = Some(gripper.into());
        Arc::new(StandIn(info))
    }
}

impl MotionModel for StandIn {
    fn name(&self) -> &str {
        "stand-in"
    }

    fn wants_guess(&self) -> bool {
        false
    }

    fn chunk(&self) -> usize {
        4
    }

    fn predict(&self, batch: &ObjectBatch, motions: &mut Vec<[f32; 3]>, _: &Stop) -> Result<()> {
        motions.clear();
        motions.resize(batch.items() * batch.objects(), [0.03, 0.0, 0.0]);
        Ok(())
    }

    fn info(&self) -> Option<&ModelInfo> {
        Some(&self.0)
    }
}

impl PushValue for StandIn {
    fn name(&self) -> &str {
        "stand-in"
    }

    fn values(
        &self,
        _: &mut PushValueScratch,
        _: &Scene,
        _: &State,
        _: usize,
        pushes: &[Push],
        values: &mut Vec<f32>,
        _: &Stop,
    ) -> Result<()> {
        values.clear();
        values.extend(pushes.iter().map(|push| push.start[0] as f32));
        Ok(())
    }

    fn info(&self) -> Option<&ModelInfo> {
        Some(&self.0)
    }
}

impl TargetProbability for StandIn {
    fn probability(&self, _: &mut ImageScratch, _: &Scene, _: &State, _: usize, _: &Stop) -> Result<f64> {
        Ok(0.1)
    }

    fn threshold(&self) -> f64 {
        0.5
    }

    fn info(&self) -> Option<&ModelInfo> {
        Some(&self.0)
    }
}

impl GraspMap for StandIn {
    fn best(
        &self,
        _: &mut ImageScratch,
        _: &Scene,
        _: &State,
        _: usize,
        _: usize,
        found: &mut Vec<MapGrasp>,
        _: &Stop,
    ) -> Result<()> {
        found.clear();
        Ok(())
    }

    fn threshold(&self) -> f64 {
        0.5
    }

    fn info(&self) -> Option<&ModelInfo> {
        Some(&self.0)
    }
}

/// The target between four squares that leave no room for a finger.
fn walled(gripper: &Gripper) -> Problem {
    let offsets = [[0.0, 0.0], [0.046, 0.0], [-0.046, 0.0], [0.0, 0.046], [0.0, -0.046]];
    let mut builder = SceneBuilder::new();
    builder.gripper(gripper.clone());
    for _ in &offsets {
        builder.add_body(BodyDef::new(Shape::rectangle(0.045, 0.045))).unwrap();
    }
    let state = State::new(offsets.iter().map(|o| Pose2::new(0.5 + o[0], o[1], 0.0)));
    Problem::new("walled", Arc::new(builder.build().unwrap()), state, 0).unwrap()
}

/// The published gripper with a tip half as wide again.
fn paddle() -> Gripper {
    let mut gripper = Gripper { name: "paddle".into(), ..Gripper::robotiq_2f85() };
    gripper.push.width *= 1.5;
    gripper
}

fn field(error: &Error) -> &str {
    match error {
        Error::Argument { field, .. } => field,
        other => panic!("{other:?}"),
    }
}

const MADE_FOR: &str = "robotiq_2f85";

/// Networks in the parts of a planner, the planner's options, and a gripper that each is not made for.
fn cases() -> Vec<(&'static str, PlannerOptions, OwnNetworks, Gripper)> {
    let options = |planner: &str| PlannerOptions {
        planner: planner.into(),
        budget: Budget::iterations(8),
        ..PlannerOptions::default()
    };
    let own = OwnNetworks::default;
    vec![
        ("dipn", options("vft"), OwnNetworks { motion: Some(StandIn::made_for("dipn", MADE_FOR)), ..own() }, paddle()),
        (
            "ppn",
            options("more"),
            OwnNetworks { push_value: Some(StandIn::made_for("ppn", MADE_FOR)), ..own() },
            paddle(),
        ),
        (
            "gc",
            options("pmbs"),
            OwnNetworks { graspability: Some(StandIn::made_for("gc", MADE_FOR)), ..own() },
            Gripper::dissertation_mask(),
        ),
        (
            "gn",
            options("pmbs"),
            OwnNetworks { grasp_map: Some(StandIn::made_for("gn", MADE_FOR)), ..own() },
            Gripper::robotiq_2f85_kept(),
        ),
    ]
}

#[test]
fn a_network_refuses_another_gripper_when_the_planner_is_made() {
    for (kind, options, own, other) in cases() {
        let with = |gripper: &Gripper| PlannerOptions { gripper: Some(gripper.clone()), ..options.clone() };
        let error = Planner::with_networks(with(&other), own.clone()).unwrap_err();
        assert_eq!(field(&error), "gripper", "{error}");
        let text = error.to_string();
        assert!(text.contains(&format!("is `{}` (", other.name)), "{kind}: {text}");
        assert!(text.contains(&format!("the {kind} network ")) && text.contains("made for `robotiq_2f85` ("), "{text}");
        // The same hand without its name, and measured anew.
        let mut near = Gripper { name: String::new(), ..Gripper::robotiq_2f85() };
        near.grasp.opening += 0.0003;
        near.push.width -= 0.0002;
        Planner::with_networks(with(&near), own.clone()).unwrap();
    }
}

#[test]
fn a_network_refuses_the_gripper_of_a_scene_and_nothing_is_changed() {
    let bits = |plan: &Plan| (plan.outcome, plan.hash_bits());
    for (kind, options, own, other) in cases() {
        let (good, bad) = (walled(&Gripper::robotiq_2f85()), walled(&other));
        let made = || Planner::with_networks(options.clone(), own.clone()).unwrap();
        let mut planner = made();
        let control = Control::default();
        planner.check(&good).unwrap();
        let first = planner.step(&good, 4, &control).unwrap();
        for error in [
            planner.check(&bad).unwrap_err(),
            planner.solve(&bad, &control).unwrap_err(),
            planner.step(&bad, 4, &control).unwrap_err(),
        ] {
            assert_eq!(field(&error), "scene.gripper", "{kind}: {error}");
            assert!(error.to_string().contains("made for `robotiq_2f85` ("), "{error}");
        }
        // It goes on as one that was never asked.
        let mut unasked = made();
        assert_eq!(bits(&first), bits(&unasked.step(&good, 4, &control).unwrap()), "{kind}");
        let (next, wanted) = (planner.step(&good, 4, &control).unwrap(), unasked.step(&good, 4, &control).unwrap());
        assert_eq!(bits(&next), bits(&wanted), "{kind}");
    }
}

#[test]
fn a_planner_of_clearings_refuses_another_gripper_too() {
    let own = OwnNetworks {
        motion: Some(StandIn::made_for("dipn", MADE_FOR)),
        grasp_map: Some(StandIn::made_for("gn", MADE_FOR)),
        ..OwnNetworks::default()
    };
    let options = ClearOptions { planner: "dipn_gn".into(), ..ClearOptions::default() };
    for other in [Gripper::dissertation_mask(), paddle()] {
        let named = ClearOptions { gripper: Some(other.clone()), ..options.clone() };
        let error = ClearPlanner::with_networks(named, own.clone()).unwrap_err();
        assert_eq!(field(&error), "gripper", "{error}");
        let mut planner = ClearPlanner::with_networks(options.clone(), own.clone()).unwrap();
        let Problem { name, scene, state, .. } = walled(&other);
        let table = Clearing::new(name, scene, state).unwrap();
        let error = planner.solve(&table, &Control::default()).unwrap_err();
        assert_eq!((field(&error), field(&planner.check(&table).unwrap_err())), ("scene.gripper", "scene.gripper"));
    }
}

/// Files: the scorers by their own metadata, the others with a gripper written into it; one that is tolerated passes.
#[test]
fn loaded_networks_refuse_another_gripper() {
    if !runs() {
        return;
    }
    let folder = std::env::temp_dir().join(format!("jostle-grippers-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let load = |kind: &str, tolerate: bool| {
        let path = folder.join(kind).with_extension("onnx");
        std::fs::write(&path, with_property(&bytes(kind), "gripper", Some(MADE_FOR))).unwrap();
        let configuration = Configuration { tolerate, ..Configuration::default() };
        Some(Model::load(path, None, &LoadOptions { configuration, ..LoadOptions::default() }).unwrap())
    };
    for (kind, other) in [
        ("gc", Gripper::dissertation_mask()),
        ("gn", Gripper::dissertation_mask()),
        ("dipn", paddle()),
        ("ppn", paddle()),
    ] {
        let options = |tolerate: bool, gripper: Option<Gripper>| {
            let mut options =
                PlannerOptions { budget: Budget::iterations(8), gripper, planner: "pmbs".into(), ..Default::default() };
            match kind {
                "dipn" => {
                    options.set_physics(Some("dipn"), None).unwrap();
                    options.engine_model = load(kind, tolerate);
                }
                "ppn" => {
                    options.planner = "more".into();
                    options.prior_model = load(kind, tolerate);
                }
                _ => (options.scorer, options.scorer_model) = (Some(kind.into()), load(kind, tolerate)),
            }
            options
        };
        let error = Planner::new(options(false, Some(other.clone()))).unwrap_err();
        assert_eq!(field(&error), "gripper", "{error}");
        let error =
            Planner::new(options(false, None)).unwrap().solve(&walled(&other), &Control::default()).unwrap_err();
        assert_eq!(field(&error), "scene.gripper", "{error}");
        Planner::new(options(false, Some(Gripper::robotiq_2f85()))).unwrap();
        let mut tolerant = Planner::new(options(true, Some(other.clone()))).unwrap();
        tolerant.solve(&walled(&other), &Control::default()).unwrap();
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
