//! The scorers of networks, with scripted stand-ins in the networks' place.

use std::sync::Arc;

use super::{GraspAssessment, GraspabilityScorer, MapScorer, Scorer};
use crate::error::{Error, Result};
use crate::geom::{Pose2, Shape, vec2};
use crate::net::{GraspMap, ImageScratch, MapGrasp, TargetProbability};
use crate::run::Stop;
use crate::scene::{BodyDef, Scene, SceneBuilder, State};

/// Says the same of every state.
struct Says(f64);

impl TargetProbability for Says {
    fn probability(&self, _: &mut ImageScratch, _: &Scene, _: &State, _: usize, _: &Stop) -> Result<f64> {
        if self.0.is_nan() { Err(Error::Internal("broken".into())) } else { Ok(self.0) }
    }

    fn threshold(&self) -> f64 {
        0.6
    }
}

/// Offers these grasps, whatever it sees.
struct Offers(Vec<MapGrasp>);

impl GraspMap for Offers {
    fn best(
        &self,
        _: &mut ImageScratch,
        _: &Scene,
        _: &State,
        _: usize,
        most: usize,
        found: &mut Vec<MapGrasp>,
        _: &Stop,
    ) -> Result<()> {
        found.clear();
        found.extend(self.0.iter().take(most));
        Ok(())
    }

    fn threshold(&self) -> f64 {
        0.4
    }
}

/// A free block at (0.5, 0) and one beside it, touching.
fn scene(pitch: f64) -> (Scene, State) {
    let mut builder = SceneBuilder::new();
    for _ in 0..2 {
        builder.add_body(BodyDef::new(Shape::rectangle(0.045, 0.045))).unwrap();
    }
    let state = State::new([Pose2::new(0.5, 0.0, 0.0), Pose2::new(0.5 + pitch, 0.0, 0.0)]);
    (builder.build().unwrap(), state)
}

fn assess(scorer: &dyn Scorer, scene: &Scene, state: &State, target: usize) -> GraspAssessment {
    let mut out = [GraspAssessment::default()];
    scorer.assess(scorer.scratch().as_mut(), scene, &[state], target, &mut out, &Stop::never());
    out[0]
}

#[test]
fn a_probability_above_the_threshold_comes_with_a_geometric_grasp() {
    let (scene, state) = scene(0.2);
    let scorer = GraspabilityScorer::new(&scene, Arc::new(Says(0.8))).unwrap();
    let found = assess(&scorer, &scene, &state, 0);
    let grasp = found.grasp.expect("a free block");
    assert_eq!((found.score, found.nearness, grasp.score, grasp.body), (0.8, 1.0, 0.8, 0));
}

#[test]
fn a_probability_below_the_threshold_ranks_states_without_a_grasp() {
    let (scene, state) = scene(0.2);
    let near = |p: f64| assess(&GraspabilityScorer::new(&scene, Arc::new(Says(p))).unwrap(), &scene, &state, 0);
    let (low, high) = (near(0.1), near(0.59));
    assert!(low.grasp.is_none() && high.grasp.is_none());
    assert!(low.nearness < high.nearness && high.nearness < 1.0, "{low:?} {high:?}");
    // A network that fails, and a target that is not there.
    assert_eq!(near(f64::NAN), GraspAssessment::default());
    let scorer = GraspabilityScorer::new(&scene, Arc::new(Says(1.0))).unwrap();
    let mut gone = state.clone();
    gone.set_present(0, false);
    assert_eq!(assess(&scorer, &scene, &gone, 0), GraspAssessment::default());
    assert_eq!(assess(&scorer, &scene, &state, 9), GraspAssessment::default());
}

#[test]
fn the_best_cell_of_a_map_is_the_grasp_and_a_checked_one_keeps_clearances() {
    // The second block leaves no room for a finger along x.
    let (scene, state) = scene(0.05);
    let at = |angle: f64, quality: f64| MapGrasp { position: vec2(0.5, 0.0), angle, quality };
    let offers = Arc::new(Offers(vec![at(0.0, 0.9), at(std::f64::consts::FRAC_PI_2, 0.7), at(0.3, 0.2)]));
    let trusting = assess(&MapScorer::new(offers.clone()).unwrap(), &scene, &state, 0);
    let grasp = trusting.grasp.expect("the map's best");
    assert_eq!((trusting.score, grasp.angle), (0.9, 0.0));
    assert!(grasp.margin < 0.0, "the rule says no: {}", grasp.margin);
    let checked = assess(&MapScorer::new(offers).unwrap().checked(), &scene, &state, 0);
    let grasp = checked.grasp.expect("the second best");
    assert_eq!((checked.score, grasp.angle), (0.7, std::f64::consts::FRAC_PI_2));
    assert!((grasp.width - 0.045).abs() < 1e-9 && grasp.margin >= 0.0);
    let poor = assess(&MapScorer::new(Arc::new(Offers(vec![at(0.0, 0.2)]))).unwrap(), &scene, &state, 0);
    assert!(poor.grasp.is_none() && (poor.nearness - 0.4995).abs() < 1e-12);
}
