//! Held-out targets, one after the other, chosen as the training data of GC and GN chooses them.

use std::ops::ControlFlow;
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
use crate::run::Stop;
use crate::scene::{Scene, State};
use crate::vision::centre_of;

/// Which held-out targets to try grasps on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GraspTrialParams {
    /// Scenes, and states and targets of each.
    pub data: GraspDataParams,
    /// Targets that count: all, or those that some grasp can take, as the function says that takes this.
    pub targets: usize,
    pub seed: u64,
}

impl Default for GraspTrialParams {
    fn default() -> Self {
        GraspTrialParams { data: GraspDataParams { targets: 2, ..GraspDataParams::default() }, targets: 300, seed: 0 }
    }
}

/// A target in a state, with what looks for its grasps and what tries them out.
pub(super) struct Target<'a> {
    pub scene: &'a Scene,
    pub state: &'a State,
    pub body: usize,
    /// The geometric test's own search.
    pub assessment: &'a GraspAssessment,
    pub engine: &'a dyn Transition,
    test: &'a GraspTest,
    scratch: &'a mut GraspScratch,
}

impl Target<'_> {
    /// The best grasp on the grid of a grasp map, if there is one.
    pub fn best_of_grid(&mut self) -> Option<Grasp> {
        let centre = centre_of(self.scene.body(self.body), &self.state.pose(self.body));
        let grid = GraspGrid { centre, side: GRASP_CELLS, cell: 2.0 * GRASP_PIXEL, angles: GRASP_ANGLES };
        let mut best: Option<(f64, usize, usize, usize)> = None;
        self.test.on_grid(self.scene, self.state, self.body, &grid, self.scratch, |k, row, col, score| {
            if best.is_none_or(|(most, ..)| score > most) {
                best = Some((score, k, row, col));
            }
        });
        best.map(|(score, k, row, col)| {
            let at = centre + grid.offset(row, col);
            let opening = self.scene.gripper().grasp.opening;
            Grasp { body: self.body, position: [at.x, at.y], angle: grid.angle(k), opening, score, ..Grasp::default() }
        })
    }

    /// Whether a grasp holds by the geometric test.
    pub fn holds(&mut self, grasp: &Grasp) -> bool {
        self.test.check(self.scene, self.state, grasp, self.scratch).holds()
    }

    /// Whether a grasp takes the target, and nothing else, in the engine.
    pub fn took(&self, grasp: &Grasp, stop: &Stop) -> Result<bool> {
        match self.engine.grasp(&mut self.engine.scratch(), self.state, grasp, stop) {
            Some(result) => Ok(result.took(grasp.body)),
            None => Err(Error::argument("judge", format!("{} cannot grasp; only bullet can", self.engine.name()))),
        }
    }
}

/// Shows targets to `visit` until it has enough or a stop is requested.
pub(super) fn each_target(
    params: &GraspTrialParams,
    family: &Arc<ShapeFamily>,
    judge: EngineMaker<'_>,
    stop: &Stop,
    visit: &mut dyn FnMut(&mut Target<'_>) -> Result<ControlFlow<()>>,
) -> Result<()> {
    check_range("targets", params.targets as f64, 1.0..=1e6)?;
    params.data.validate()?;
    let maker = SceneMaker::new(params.data.scenes.clone(), Arc::clone(family))?;
    let mut held_out = HeldOut::new(maker, params.seed, params.targets);
    let quick = PhysicsOptions::named("planar", Some("fast"), Purpose::Planning)?;
    let mut worker = PushWorker::new()?;
    let mut scratch = GraspScratch::default();
    while !stop.requested() {
        let (made, key) = held_out.scene()?;
        let scene = &made.scene;
        let engine = judge(Arc::clone(scene))?;
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
                let (body, assessment) = assessed.swap_remove(place);
                let mut target = Target {
                    scene,
                    state: &state,
                    body,
                    assessment: &assessment,
                    engine: &*engine,
                    test: &test,
                    scratch: &mut scratch,
                };
                if visit(&mut target)?.is_break() {
                    return Ok(());
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
    Ok(())
}
