//! Whether the grasp that a network names holds, where some grasp does.
//!
//! Held-out states and targets as the training data has them. What grasps there are follows from the geometric test on
//! the network's own grid; an engine with a third dimension tries out the network's grasp, the grid's best and the
//! test's own best.

use std::sync::Arc;

use serde::Serialize;

use super::super::grasp::{GRASP_ANGLES, GRASP_CELLS, GRASP_PIXEL, GraspDataParams, PUSHES, choose};
use super::super::push::{PushWorker, run};
use super::super::scenes::SceneMaker;
use super::super::shapes::ShapeFamily;
use super::{EngineMaker, HeldOut};
use crate::action::Grasp;
use crate::error::{Error, Result, check_range};
use crate::grasp::{GraspAssessment, GraspGrid, GraspParams, GraspScratch, GraspTest};
use crate::physics::{self, PhysicsOptions, Purpose, PushStatus, Transition};
use crate::plan::GraspDecision;
use crate::run::Stop;
use crate::scene::{Scene, State};
use crate::vision::centre_of;

/// What grasps to try out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GraspTrialParams {
    /// Scenes, and states and targets of each.
    pub data: GraspDataParams,
    /// Targets that some grasp of the grid can take.
    pub targets: usize,
    pub seed: u64,
}

impl Default for GraspTrialParams {
    fn default() -> Self {
        GraspTrialParams { data: GraspDataParams { targets: 2, ..GraspDataParams::default() }, targets: 300, seed: 0 }
    }
}

/// Grasps of one origin.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct GraspTally {
    /// Targets.
    pub targets: usize,
    /// Of them, those for which a grasp was named.
    pub named: usize,
    /// Grasps that hold by the geometric test.
    pub valid: usize,
    /// Grasps that took the target, and nothing else, in the engine.
    pub succeeded: usize,
    /// `succeeded / targets` and `valid / targets`.
    pub success: f64,
    pub validity: f64,
}

/// Grasps tried out over the same targets.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct GraspTrials {
    pub judge: String,
    /// Targets looked at, and those that some grasp of the grid can take: the others are not counted below.
    pub looked_at: usize,
    pub graspable: usize,
    /// What the network names, the best of the grid, and the best of the geometric test's own search.
    pub network: GraspTally,
    pub grid: GraspTally,
    pub geometric: GraspTally,
    /// What the network names where the grid's best scores at least as much as planners ask for to execute a grasp.
    pub network_where_good: GraspTally,
    /// What the network names where the grid's best succeeded in the engine.
    pub network_where_grid_succeeds: GraspTally,
}

impl GraspTally {
    fn add(&mut self, valid: bool, succeeded: bool, named: bool) {
        self.targets += 1;
        self.named += usize::from(named);
        self.valid += usize::from(valid);
        self.succeeded += usize::from(succeeded);
        self.success = self.succeeded as f64 / self.targets as f64;
        self.validity = self.valid as f64 / self.targets as f64;
    }
}

/// Names the best grasp of a target, good or bad.
pub type NamedGrasp<'a> = &'a mut dyn FnMut(&Scene, &State, usize) -> Result<Option<Grasp>>;

/// Tries out a network's grasps in an engine that can grasp. A requested stop ends with what is known by then. `progress`
/// hears the number of targets.
pub fn try_grasps(
    params: &GraspTrialParams,
    family: &Arc<ShapeFamily>,
    judge: EngineMaker<'_>,
    network: NamedGrasp<'_>,
    stop: &Stop,
    progress: &mut dyn FnMut(usize),
) -> Result<GraspTrials> {
    check_range("targets", params.targets as f64, 1.0..=1e6)?;
    params.data.validate()?;
    let maker = SceneMaker::new(params.data.scenes.clone(), Arc::clone(family))?;
    let mut held_out = HeldOut::new(maker, params.seed, params.targets);
    let quick = PhysicsOptions::named("planar", Some("fast"), Purpose::Planning)?;
    let mut worker = PushWorker::new()?;
    let mut trials = GraspTrials::default();
    let mut scratch = GraspScratch::default();
    'scenes: while !stop.requested() {
        let (made, key) = held_out.scene()?;
        let scene = &made.scene;
        let engine = judge(Arc::clone(scene))?;
        trials.judge = engine.name().to_string();
        let moves = physics::engine(&quick, Arc::clone(scene))?;
        let mut moving = moves.scratch();
        let test = GraspTest::new(GraspParams::default())?.prepared(scene);
        let mut random = key.stream();
        let mut state = made.state.clone();
        for _ in 0..params.data.states {
            let mut assessed: Vec<(usize, GraspAssessment)> =
                (0..scene.len()).map(|body| (body, test.assess(scene, &state, body, &mut scratch))).collect();
            for _ in 0..params.data.targets.min(scene.len()) {
                let Some(place) = choose(&assessed, &mut random) else { continue };
                let (target, assessment) = assessed.swap_remove(place);
                trials.looked_at += 1;
                let Some(best) = best_of_grid(&test, scene, &state, target, &mut scratch) else { continue };
                let mut judged = |grasp: &Grasp| -> Result<(bool, bool)> {
                    let valid = test.check(scene, &state, grasp, &mut scratch).holds();
                    Ok((valid, took(&*engine, &state, grasp, stop)?))
                };
                let (_, best_took) = judged(&best)?;
                let named = network(scene, &state, target)?;
                let (valid, succeeded) = named.as_ref().map_or(Ok((false, false)), &mut judged)?;
                let own = assessment.grasp.as_ref();
                let (own_valid, own_took) = own.map_or(Ok((false, false)), &mut judged)?;
                if stop.requested() {
                    break 'scenes;
                }
                trials.graspable += 1;
                trials.network.add(valid, succeeded, named.is_some());
                trials.grid.add(true, best_took, true);
                trials.geometric.add(own_valid, own_took, own.is_some());
                if best.score >= GraspDecision::default().execute_score {
                    trials.network_where_good.add(valid, succeeded, named.is_some());
                }
                if best_took {
                    trials.network_where_grid_succeeds.add(valid, succeeded, named.is_some());
                }
                progress(trials.graspable);
                if trials.graspable == params.targets {
                    break 'scenes;
                }
            }
            let sampled = random.chance(0.5);
            worker.propose(scene, &state, PUSHES, sampled, &mut random);
            run(&*moves, &mut moving, &state, &worker.pushes, &mut worker.results, stop);
            let count = worker.pushes.len();
            match worker.results[..count].iter().find(|r| r.status == PushStatus::Executed) {
                Some(result) => state.clone_from(&result.state),
                None => break,
            }
        }
    }
    Ok(trials)
}

/// The best grasp on the grid of a grasp map, if there is one.
fn best_of_grid(
    test: &GraspTest,
    scene: &Scene,
    state: &State,
    target: usize,
    scratch: &mut GraspScratch,
) -> Option<Grasp> {
    let centre = centre_of(scene.body(target), &state.pose(target));
    let grid = GraspGrid { centre, side: GRASP_CELLS, cell: 2.0 * GRASP_PIXEL, angles: GRASP_ANGLES };
    let mut best: Option<(f64, usize, usize, usize)> = None;
    test.on_grid(scene, state, target, &grid, scratch, |k, row, col, score| {
        if best.is_none_or(|(most, ..)| score > most) {
            best = Some((score, k, row, col));
        }
    });
    best.map(|(score, k, row, col)| {
        let at = centre + grid.offset(row, col);
        let opening = scene.gripper().grasp.opening;
        Grasp { body: target, position: [at.x, at.y], angle: grid.angle(k), opening, score, ..Grasp::default() }
    })
}

fn took(engine: &dyn Transition, state: &State, grasp: &Grasp, stop: &Stop) -> Result<bool> {
    match engine.grasp(&mut engine.scratch(), state, grasp, stop) {
        Some(result) => Ok(result.took(grasp.body)),
        None => Err(Error::argument("judge", format!("{} cannot grasp; only bullet can", engine.name()))),
    }
}
