//! Images of whole scenes with the body at each pixel: the data of segmentation.

use std::path::Path;
use std::sync::Arc;

use serde::Serialize;
use serde_json::{Value, json};

use super::columns::{Bodies, Columns};
use super::grasp::heights;
use super::push::{PushWorker, note, run};
use super::scenes::{SceneMaker, SceneParams, WIDTH};
use super::shapes::ShapeFamily;
use super::store::{self, Made, Manifest, SceneRows, StoreParams, Task};
use super::tensors::{Data, Tensor};
use crate::error::{Error, Result, check_range};
use crate::geom::Pose2;
use crate::physics::{self, PhysicsOptions, Purpose, PushStatus};
use crate::run::{Key, Stop};
use crate::vision::{Frame, ImageMut, Rasteriser};

/// Pixels on each side.
pub const SEGMENT_SIZE: usize = 224;
/// Metres.
pub const SEGMENT_PIXEL: f64 = 0.002;
/// Middle of the image: that of the originals' workspace, metres.
const MIDDLE: Pose2 = Pose2 { x: 0.5, y: 0.0, theta: 0.0 };
/// Pushes of which one makes the next state.
const PUSHES: usize = 4;

/// What states to picture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SegmentParams {
    pub scenes: SceneParams,
    /// States of a scene, each led to by a push from the one before.
    pub states: usize,
}

impl Default for SegmentParams {
    fn default() -> Self {
        SegmentParams { scenes: SceneParams::default(), states: 2 }
    }
}

/// Makes or completes a folder of label maps.
pub fn segment(
    params: &SegmentParams,
    family: &Arc<ShapeFamily>,
    shape_seed: u64,
    folder: &Path,
    to: &StoreParams,
    stop: &Stop,
    progress: &mut dyn FnMut(Made),
) -> Result<Manifest> {
    check_range("states", params.states as f64, 1.0..=64.0)?;
    let maker = SceneMaker::new(params.scenes.clone(), Arc::clone(family))?;
    let quick = PhysicsOptions::named("planar", Some("fast"), Purpose::Planning)?;
    let task = SegmentTask { params: params.clone(), maker, quick };
    store::make(&task, family, shape_seed, folder, to, stop, progress)
}

/// A state and its picture.
pub(super) struct SegmentRow {
    bodies: Bodies,
    label_map: Vec<u8>,
    heights: [f32; WIDTH],
}

struct SegmentTask {
    params: SegmentParams,
    maker: SceneMaker,
    quick: PhysicsOptions,
}

/// Working memory of a thread.
pub(super) struct SegmentWorker {
    pushes: PushWorker,
    raster: Rasteriser,
}

impl Task for SegmentTask {
    type Row = SegmentRow;
    type Worker = SegmentWorker;

    fn kind(&self) -> &'static str {
        "segment"
    }

    fn configuration(&self) -> Result<Value> {
        let params = serde_json::to_value(&self.params).map_err(|e| Error::Internal(e.to_string()))?;
        Ok(json!({
            "segment": params, "width": WIDTH, "size": SEGMENT_SIZE, "pixel": SEGMENT_PIXEL,
            "middle": [MIDDLE.x, MIDDLE.y], "pushes": "planar fast",
        }))
    }

    fn worker(&self) -> Result<SegmentWorker> {
        Ok(SegmentWorker { pushes: PushWorker::new()?, raster: Rasteriser::new() })
    }

    fn rows_of_scene(&self) -> usize {
        self.params.states
    }

    fn scene(&self, worker: &mut SegmentWorker, key: Key, number: i64, stop: &Stop) -> Result<SceneRows<SegmentRow>> {
        let made = self.maker.scene(key.child(0))?;
        let scene = &made.scene;
        let quick = physics::engine(&self.quick, Arc::clone(scene))?;
        let mut scratch = quick.scratch();
        let mut random = key.child(1).stream();
        let mut out = SceneRows::default();
        let mut state = made.state.clone();
        for step in 0..self.params.states {
            let mut label_map = vec![0; SEGMENT_SIZE * SEGMENT_SIZE];
            let frame = Frame::new(MIDDLE, SEGMENT_PIXEL, SEGMENT_SIZE, SEGMENT_SIZE);
            let mut image = ImageMut::packed(&mut label_map, SEGMENT_SIZE, SEGMENT_SIZE)?;
            worker.raster.labels(scene, &state, &frame, &mut image)?;
            let bodies = Bodies::new(scene, &state, &made.shapes, number, made.split);
            out.rows.push(SegmentRow { bodies, label_map, heights: heights(scene) });
            note(&mut out.statistics, &format!("rows_{}", made.split.name()), 1.0);
            if step + 1 == self.params.states {
                break;
            }
            let sampled = random.chance(0.5);
            worker.pushes.propose(scene, &state, PUSHES, sampled, &mut random);
            run(&*quick, &mut scratch, &state, &worker.pushes.pushes, &mut worker.pushes.results, stop);
            let made = worker.pushes.pushes.len();
            match worker.pushes.results[..made].iter().find(|r| r.status == PushStatus::Executed) {
                Some(result) => state.clone_from(&result.state),
                None => break,
            }
        }
        note(&mut out.statistics, "scenes", 1.0);
        Ok(out)
    }

    fn tensors(&self, rows: Vec<SegmentRow>) -> Vec<Tensor> {
        let count = rows.len();
        let mut columns = Columns::new("pose", count);
        let mut label_map = Vec::with_capacity(count * SEGMENT_SIZE * SEGMENT_SIZE);
        let mut heights = Vec::with_capacity(count * WIDTH);
        for row in &rows {
            columns.push(&row.bodies);
            label_map.extend_from_slice(&row.label_map);
            heights.extend(row.heights);
        }
        let mut tensors = columns.finish();
        tensors.extend([
            Tensor::new("label_map", [count, SEGMENT_SIZE, SEGMENT_SIZE], Data::U8(label_map)),
            Tensor::new("heights", [count, WIDTH], Data::F32(heights)),
        ]);
        tensors
    }
}
