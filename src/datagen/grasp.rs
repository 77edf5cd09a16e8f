//! Can the target be grasped, and how well at which place: the data of GC and GN.
//!
//! The labels are those of the geometric test. Where an engine with a third dimension is named, the best grasp of a share
//! of the samples is tried out in it as well.

use std::path::Path;
use std::sync::Arc;

use serde::Serialize;
use serde_json::{Value, json};

use super::columns::{Bodies, Columns};
use super::push::{PushWorker, note, run};
use super::scenes::{SceneMaker, SceneMix, SceneParams, TrainingScene, WIDTH};
use super::shapes::ShapeFamily;
use super::store::{self, Made, Manifest, SceneRows, Statistics, StoreParams, Task};
use super::tensors::{Data, Tensor};
use crate::action::Grasp;
use crate::error::{Error, Result, check_range};
use crate::grasp::{GraspAssessment, GraspGrid, GraspParams, GraspScratch, GraspTest};
use crate::physics::{self, PhysicsOptions, Purpose, PushStatus, Scratch, Transition};
use crate::plan::GraspDecision;
use crate::run::{Key, Stop, Stream};
use crate::scene::{Scene, State};
use crate::vision::{Frame, ImageMut, Rasteriser, centre_of};

/// Pixels on each side of the label map.
pub const GRASP_SIZE: usize = 112;
/// Metres.
pub const GRASP_PIXEL: f64 = 0.002;
/// Closing directions over half a turn.
pub const GRASP_ANGLES: usize = 16;
/// Cells on each side of the grasp map, each of two by two pixels.
pub const GRASP_CELLS: usize = GRASP_SIZE / 2;
/// Share of the choices that ask for a target that cannot be grasped: most can, and half of the rows should not.
const HELD: f64 = 0.7;
/// Share of the choices of a target that go to the more doubtful of two.
const DOUBTFUL: f64 = 0.6;
/// Pushes of which one makes the next state.
pub(super) const PUSHES: usize = 4;

/// What states to label.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GraspDataParams {
    pub scenes: SceneParams,
    /// States of a scene, each led to by a push from the one before.
    pub states: usize,
    /// Targets of a state.
    pub targets: usize,
    /// The engine that tries grasps out.
    pub trials: Option<PhysicsOptions>,
    /// Share of the samples with a grasp whose best grasp is tried out.
    pub trial_share: f64,
}

impl Default for GraspDataParams {
    /// Mostly packs: in loose scenes nearly every body can be grasped.
    fn default() -> Self {
        let usual = SceneParams::default();
        let mix = SceneMix { generated: 0.45, packed: 0.35, loose: 0.08, mixed: 0.12, ..usual.mix };
        let scenes = SceneParams { bodies: 2..=WIDTH, mix, ..usual };
        GraspDataParams { scenes, states: 3, targets: 3, trials: None, trial_share: 0.1 }
    }
}

impl GraspDataParams {
    pub(super) fn validate(&self) -> Result<()> {
        check_range("states", self.states as f64, 1.0..=64.0)?;
        check_range("targets", self.targets as f64, 1.0..=WIDTH as f64)?;
        check_range("trial_share", self.trial_share, 0.0..=1.0)?;
        match &self.trials {
            None => Ok(()),
            Some(physics) => {
                physics.validate().map_err(|e| e.within("label"))?;
                if physics.engine == "bullet" {
                    return Ok(());
                }
                Err(Error::argument("label", format!("{} cannot grasp; only bullet can", physics.engine)))
            }
        }
    }
}

/// Makes or completes a folder of labelled grasps.
pub fn grasp(
    params: &GraspDataParams,
    family: &Arc<ShapeFamily>,
    shape_seed: u64,
    folder: &Path,
    to: &StoreParams,
    stop: &Stop,
    progress: &mut dyn FnMut(Made),
) -> Result<Manifest> {
    params.validate()?;
    let maker = SceneMaker::new(params.scenes.clone(), Arc::clone(family))?;
    let quick = PhysicsOptions::named("planar", Some("fast"), Purpose::Planning)?;
    let task = GraspTask { params: params.clone(), maker, quick };
    store::make(&task, family, shape_seed, folder, to, stop, progress)
}

/// A target in a state.
pub(super) struct GraspRow {
    bodies: Bodies,
    target: u8,
    label_map: Vec<u8>,
    heights: [f32; WIDTH],
    score: f32,
    cells: Vec<(u32, f32)>,
    /// 0: not tried out; 1: failed; 2: the target and nothing else was lifted.
    trial: u8,
}

struct GraspTask {
    params: GraspDataParams,
    maker: SceneMaker,
    quick: PhysicsOptions,
}

/// Working memory of a thread.
pub(super) struct GraspWorker {
    pushes: PushWorker,
    raster: Rasteriser,
    grasps: GraspScratch,
    quick: Option<Scratch>,
}

/// What a scene is labelled with.
struct Tools<'a> {
    made: &'a TrainingScene,
    test: GraspTest,
    trials: Option<Arc<dyn Transition>>,
}

impl Task for GraspTask {
    type Row = GraspRow;
    type Worker = GraspWorker;

    fn kind(&self) -> &'static str {
        "grasp"
    }

    fn configuration(&self) -> Result<Value> {
        let params = serde_json::to_value(&self.params).map_err(|e| Error::Internal(e.to_string()))?;
        let test = serde_json::to_value(GraspParams::default()).map_err(|e| Error::Internal(e.to_string()))?;
        Ok(json!({
            "grasp": params, "width": WIDTH, "gripper": "robotiq_2f85", "size": GRASP_SIZE, "pixel": GRASP_PIXEL,
            "angles": GRASP_ANGLES, "cells": GRASP_CELLS, "test": test,
            "label": "geometric: best score of the target, and the score of the grasp at each cell's centre at full opening",
            "threshold": GraspDecision::default().execute_score, "pushes": "planar fast",
        }))
    }

    fn worker(&self) -> Result<GraspWorker> {
        Ok(GraspWorker {
            pushes: PushWorker::new()?,
            raster: Rasteriser::new(),
            grasps: GraspScratch::default(),
            quick: None,
        })
    }

    fn rows_of_scene(&self) -> usize {
        self.params.states * self.params.targets
    }

    fn scene(&self, worker: &mut GraspWorker, key: Key, number: i64, stop: &Stop) -> Result<SceneRows<GraspRow>> {
        let made = self.maker.scene(key.child(0))?;
        let scene = &made.scene;
        let quick = physics::engine(&self.quick, Arc::clone(scene))?;
        let mut scratch = worker.quick.take().unwrap_or_else(|| quick.scratch());
        let trials = self.params.trials.as_ref().map(|p| physics::engine(p, Arc::clone(scene))).transpose()?;
        let test = GraspTest::new(GraspParams::default())?.prepared(scene);
        let tools = Tools { made: &made, test, trials };
        let mut random = key.child(1).stream();
        let mut out = SceneRows::default();
        let mut state = made.state.clone();
        for step in 0..self.params.states {
            let mut assessed: Vec<(usize, GraspAssessment)> = (0..scene.len())
                .map(|body| (body, tools.test.assess(scene, &state, body, &mut worker.grasps)))
                .collect();
            for _ in 0..self.params.targets.min(scene.len()) {
                let Some(place) = choose(&assessed, &mut random) else { continue };
                let (target, assessment) = assessed.swap_remove(place);
                let row = self.row(&tools, worker, &state, target, &assessment, number, &mut random, stop)?;
                count(&mut out.statistics, &row, &assessment, made.split.name());
                out.rows.push(row);
            }
            if step + 1 == self.params.states {
                break;
            }
            let sampled = random.chance(0.5);
            worker.pushes.propose(scene, &state, PUSHES, sampled, &mut random);
            run(&*quick, &mut scratch, &state, &worker.pushes.pushes, &mut worker.pushes.results, stop);
            let made = worker.pushes.pushes.len();
            let next = worker.pushes.results[..made].iter().find(|r| r.status == PushStatus::Executed);
            match next {
                Some(result) => state.clone_from(&result.state),
                None => break,
            }
        }
        worker.quick = Some(scratch);
        note(&mut out.statistics, "scenes", 1.0);
        note(&mut out.statistics, &format!("scenes_{}", made.kind), 1.0);
        Ok(out)
    }

    fn tensors(&self, rows: Vec<GraspRow>) -> Vec<Tensor> {
        let count = rows.len();
        let mut columns = Columns::new("pose", count);
        let mut label_map = Vec::with_capacity(count * GRASP_SIZE * GRASP_SIZE);
        let (mut target, mut heights, mut score, mut trial) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (mut start, mut cell, mut cell_score) = (vec![0i64], Vec::new(), Vec::new());
        for row in rows {
            columns.push(&row.bodies);
            target.push(row.target);
            label_map.extend_from_slice(&row.label_map);
            heights.extend(row.heights);
            score.push(row.score);
            trial.push(row.trial);
            for (index, value) in row.cells {
                cell.push(index);
                cell_score.push(value);
            }
            start.push(cell.len() as i64);
        }
        let mut tensors = columns.finish();
        let total = cell.len();
        tensors.extend([
            Tensor::new("target", [count], Data::U8(target)),
            Tensor::new("label_map", [count, GRASP_SIZE, GRASP_SIZE], Data::U8(label_map)),
            Tensor::new("heights", [count, WIDTH], Data::F32(heights)),
            Tensor::new("score", [count], Data::F32(score)),
            Tensor::new("cell_start", [count + 1], Data::I64(start)),
            Tensor::new("cell", [total], Data::U32(cell)),
            Tensor::new("cell_score", [total], Data::F32(cell_score)),
        ]);
        if self.params.trials.is_some() {
            tensors.push(Tensor::new("trial", [count], Data::U8(trial)));
        }
        tensors
    }
}

impl GraspTask {
    #[allow(clippy::too_many_arguments)]
    fn row(
        &self,
        tools: &Tools<'_>,
        worker: &mut GraspWorker,
        state: &State,
        target: usize,
        assessment: &GraspAssessment,
        number: i64,
        random: &mut Stream,
        stop: &Stop,
    ) -> Result<GraspRow> {
        let scene = &*tools.made.scene;
        let mut label_map = vec![0; GRASP_SIZE * GRASP_SIZE];
        let frame = Frame::around(scene, state, target, 0.0, GRASP_PIXEL, GRASP_SIZE)?;
        let mut image = ImageMut::packed(&mut label_map, GRASP_SIZE, GRASP_SIZE)?;
        worker.raster.labels(scene, state, &frame, &mut image)?;
        let grid = GraspGrid {
            centre: centre_of(scene.body(target), &state.pose(target)),
            side: GRASP_CELLS,
            cell: 2.0 * GRASP_PIXEL,
            angles: GRASP_ANGLES,
        };
        let mut cells = Vec::new();
        tools.test.on_grid(scene, state, target, &grid, &mut worker.grasps, |k, row, col, score| {
            cells.push((((k * GRASP_CELLS + row) * GRASP_CELLS + col) as u32, score as f32));
        });
        // Drawn whether or not it is used, so that trials change nothing else.
        let tried = random.chance(self.params.trial_share);
        let trial = match (&tools.trials, assessment.grasp) {
            (Some(engine), Some(grasp)) if tried => try_out(&**engine, state, &grasp, stop),
            _ => 0,
        };
        Ok(GraspRow {
            bodies: Bodies::new(scene, state, &tools.made.shapes, number, tools.made.split),
            target: target as u8,
            label_map,
            heights: heights(scene),
            score: if assessment.grasp.is_some() { assessment.score as f32 } else { 0.0 },
            cells,
            trial,
        })
    }
}

fn try_out(engine: &dyn Transition, state: &State, grasp: &Grasp, stop: &Stop) -> u8 {
    match engine.grasp(&mut engine.scratch(), state, grasp, stop) {
        Some(result) if result.took(grasp.body) => 2,
        Some(_) => 1,
        None => 0,
    }
}

/// Heights of the bodies, metres; 0 beyond them.
pub(super) fn heights(scene: &Scene) -> [f32; WIDTH] {
    let mut heights = [0.0; WIDTH];
    heights.iter_mut().zip(scene.bodies()).for_each(|(h, body)| *h = body.height as f32);
    heights
}

/// Place of the next target: one that can be grasped or one that cannot, whichever is drawn, and rather one that is nearly
/// the other. None where there is no such body.
pub(super) fn choose(assessed: &[(usize, GraspAssessment)], random: &mut Stream) -> Option<usize> {
    let threshold = GraspDecision::default().execute_score;
    let wanted = !random.chance(HELD);
    let places: Vec<usize> = (0..assessed.len()).filter(|&i| (assessed[i].1.score >= threshold) == wanted).collect();
    if places.is_empty() {
        return None;
    }
    let (a, b) = (places[random.index(places.len())], places[random.index(places.len())]);
    // How far from the border between the two: by the margin where there is a grasp, by what is in the way where there
    // is none.
    let certainty = |i: usize| match assessed[i].1.grasp {
        Some(grasp) => (assessed[i].1.score - threshold).abs().min(grasp.margin * 50.0),
        None => 1.0 - assessed[i].1.nearness,
    };
    let (near, far) = if certainty(a) <= certainty(b) { (a, b) } else { (b, a) };
    Some(if random.chance(DOUBTFUL) { near } else { far })
}

fn count(statistics: &mut Statistics, row: &GraspRow, assessment: &GraspAssessment, split: &str) {
    let threshold = GraspDecision::default().execute_score;
    note(statistics, "rows", 1.0);
    note(statistics, &format!("rows_{split}"), 1.0);
    let graspable = assessment.grasp.is_some() && assessment.score >= threshold;
    note(statistics, "graspable", f64::from(u8::from(graspable)));
    let near = match assessment.grasp {
        Some(grasp) => (assessment.score - threshold).abs() < 0.1 || grasp.margin < 0.002,
        None => assessment.nearness > 0.8,
    };
    note(statistics, "near_the_border", f64::from(u8::from(near)));
    note(statistics, "cells", row.cells.len() as f64);
    note(statistics, "trials", f64::from(u8::from(row.trial > 0)));
    note(statistics, "trials_that_succeeded", f64::from(u8::from(row.trial == 2)));
}
