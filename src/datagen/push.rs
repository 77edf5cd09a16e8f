//! Pushes and what they do: the data of DIPN.
//!
//! A scene gives a chain of states; from each, a batch of pushes is executed in the chosen engine, and one of them leads
//! to the next state. Beside each result stands what the quick planar engine predicts.

use std::path::Path;
use std::sync::Arc;

use serde::Serialize;
use serde_json::{Value, json};

use super::columns::{Bodies, Columns, centre_pose};
use super::scenes::{SceneMaker, SceneParams, TrainingScene, WIDTH};
use super::shapes::ShapeFamily;
use super::store::{self, Made, Manifest, SceneRows, Statistics, StoreParams, Task};
use super::tensors::{Data, Tensor};
use crate::action::sampler;
use crate::action::{Push, PushSampler, SamplerScratch};
use crate::error::{Error, Result, check_range};
use crate::geom::{Obb, normalize_angle, vec2};
use crate::physics::{self, PhysicsOptions, PushJob, PushResult, PushStatus, Scratch, Transition};
use crate::run::{Key, Stop, Stream};
use crate::scene::{Scene, State};

/// Shortest and longest random push, metres.
const LENGTHS: [f64; 2] = [0.030, 0.120];
/// Free gap round the tip where a random push begins, metres.
const CLEARANCE: f64 = 0.002;
/// A body has moved if its centre has by more than this, metres, or it has turned by more than [`TURNED`].
const MOVED: f64 = 0.002;
/// Radians.
const TURNED: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Random pushes drawn for each one wanted.
const DRAWS: usize = 30;

/// What pushes to record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PushParams {
    /// The engine whose results are recorded.
    pub physics: PhysicsOptions,
    pub scenes: SceneParams,
    /// Pushes from each state.
    pub pushes: usize,
    /// States of a scene, each led to by a push from the one before.
    pub states: usize,
    /// Share of states whose pushes come from a planner's sampler; from the others they are random.
    pub sampled: f64,
}

impl PushParams {
    pub fn new(physics: PhysicsOptions) -> Self {
        PushParams { physics, scenes: SceneParams::default(), pushes: 8, states: 3, sampled: 0.5 }
    }

    fn validate(&self) -> Result<()> {
        self.physics.validate()?;
        check_range("pushes", self.pushes as f64, 1.0..=1024.0)?;
        check_range("states", self.states as f64, 1.0..=64.0)?;
        check_range("sampled", self.sampled, 0.0..=1.0)
    }
}

/// Makes or completes a folder of pushes.
pub fn push(
    params: &PushParams,
    family: &Arc<ShapeFamily>,
    shape_seed: u64,
    folder: &Path,
    to: &StoreParams,
    stop: &Stop,
    progress: &mut dyn FnMut(Made),
) -> Result<Manifest> {
    params.validate()?;
    let maker = SceneMaker::new(params.scenes.clone(), Arc::clone(family))?;
    let task = PushTask { params: params.clone(), guess: quick()?, maker };
    store::make(&task, family, shape_seed, folder, to, stop, progress)
}

/// The engine of the guess.
fn quick() -> Result<PhysicsOptions> {
    PhysicsOptions::named("planar", Some("fast"), physics::Purpose::Planning)
}

/// A recorded push. Poses are those of the centres.
pub(super) struct PushRow {
    bodies: Bodies,
    after: [[f32; 3]; WIDTH],
    guess: [[f32; 3]; WIDTH],
    push: [f32; 4],
    tip: [f32; 3],
}

struct PushTask {
    params: PushParams,
    guess: PhysicsOptions,
    maker: SceneMaker,
}

/// Working memory of a thread.
pub(super) struct PushWorker {
    samplers: Vec<Box<dyn PushSampler>>,
    sampling: SamplerScratch,
    sampled: Vec<Push>,
    pub pushes: Vec<Push>,
    pub results: Vec<PushResult>,
    guesses: Vec<PushResult>,
    scratches: Option<[Scratch; 2]>,
}

impl PushWorker {
    pub fn new() -> Result<PushWorker> {
        // Together they have all lengths of the published planners: 74, 100, 50 and 100 mm.
        let samplers: Result<Vec<_>> =
            ["vft", "more", "pmbs_contour", "dense"].map(sampler::by_name).into_iter().collect();
        Ok(PushWorker {
            samplers: samplers?,
            sampling: SamplerScratch::default(),
            sampled: Vec::new(),
            pushes: Vec::new(),
            results: Vec::new(),
            guesses: Vec::new(),
            scratches: None,
        })
    }

    /// Fills `pushes`: those of a sampler in random order, completed by random ones.
    pub fn propose(&mut self, scene: &Scene, state: &State, wanted: usize, sampled: bool, random: &mut Stream) {
        self.pushes.clear();
        if sampled {
            let sampler = &self.samplers[random.index(self.samplers.len())];
            let target = random.index(scene.len());
            sampler.sample(scene, state, target, None, random, &mut self.sampling, &mut self.sampled);
            random.shuffle(&mut self.sampled);
            self.pushes.extend(self.sampled.iter().take(wanted));
        }
        while self.pushes.len() < wanted {
            match random_push(scene, state, random) {
                Some(push) => self.pushes.push(push),
                None => break,
            }
        }
    }
}

/// A push that begins beside a body, clear of all, and meets one.
pub(super) fn random_push(scene: &Scene, state: &State, random: &mut Stream) -> Option<Push> {
    let tip = &scene.gripper().push;
    for _ in 0..DRAWS {
        let body = random.index(scene.len());
        let (footprint, pose) = (&scene.body(body).footprint, state.pose(body));
        let angle = random.uniform(-std::f64::consts::PI, std::f64::consts::PI);
        let (direction, side) = (vec2(angle.cos(), angle.sin()), vec2(-angle.sin(), angle.cos()));
        let aside = random.uniform(-1.0, 1.0) * footprint.radius;
        let away = footprint.radius + tip.thickness / 2.0 + random.uniform(0.0, 0.03);
        let start = pose.transform_point(footprint.centroid) + side * aside - direction * away;
        let length = random.uniform(LENGTHS[0], LENGTHS[1]);
        let push = Push { body: Some(body), ..Push::new(start, start + direction * length) };
        let at_start = push.tip_at_start(tip).grown(CLEARANCE);
        let swept = Obb {
            centre: start + direction * (length / 2.0),
            axis: direction,
            half: [(length + tip.thickness) / 2.0, tip.width / 2.0],
        };
        let meets = |tool: &Obb| state.iter().any(|(i, at)| tool.overlaps(&scene.body(i).footprint, &at.frame()));
        if !meets(&at_start) && meets(&swept) {
            return Some(push);
        }
    }
    None
}

impl Task for PushTask {
    type Row = PushRow;
    type Worker = PushWorker;

    fn kind(&self) -> &'static str {
        "push"
    }

    fn configuration(&self) -> Result<Value> {
        let params = serde_json::to_value(&self.params).map_err(|e| Error::Internal(e.to_string()))?;
        Ok(json!({"push": params, "guess": "planar fast", "width": WIDTH}))
    }

    fn worker(&self) -> Result<PushWorker> {
        PushWorker::new()
    }

    fn rows_of_scene(&self) -> usize {
        self.params.pushes * self.params.states
    }

    fn scene(&self, worker: &mut PushWorker, key: Key, scene: i64, stop: &Stop) -> Result<SceneRows<PushRow>> {
        let made = self.maker.scene(key.child(0))?;
        let engine = physics::engine(&self.params.physics, Arc::clone(&made.scene))?;
        let quick = physics::engine(&self.guess, Arc::clone(&made.scene))?;
        // An engine's scratch serves every scene.
        let scratches = worker.scratches.take().unwrap_or_else(|| [engine.scratch(), quick.scratch()]);
        let [mut scratch, mut quick_scratch] = scratches;
        let mut random = key.child(1).stream();
        let mut out = SceneRows::default();
        let mut state = made.state.clone();
        for _ in 0..self.params.states {
            let sampled = random.chance(self.params.sampled);
            worker.propose(&made.scene, &state, self.params.pushes, sampled, &mut random);
            let count = worker.pushes.len();
            run(&*engine, &mut scratch, &state, &worker.pushes, &mut worker.results, stop);
            run(&*quick, &mut quick_scratch, &state, &worker.pushes, &mut worker.guesses, stop);
            let mut next: Option<usize> = None;
            let mut seen = 0;
            for k in 0..count {
                let (result, guess) = (&worker.results[k], &worker.guesses[k]);
                let Some(row) = self.row(&made, &state, &worker.pushes[k], result, guess, scene, &mut out.statistics)
                else {
                    continue;
                };
                out.rows.push(row);
                // One of the results leads on, each as likely.
                seen += 1;
                if random.index(seen) == 0 {
                    next = Some(k);
                }
            }
            match next {
                Some(k) => state.clone_from(&worker.results[k].state),
                None => break,
            }
        }
        worker.scratches = Some([scratch, quick_scratch]);
        note(&mut out.statistics, "scenes", 1.0);
        note(&mut out.statistics, &format!("scenes_{}", made.kind), 1.0);
        note(&mut out.statistics, &format!("rows_{}", made.split.name()), out.rows.len() as f64);
        Ok(out)
    }

    fn tensors(&self, rows: Vec<PushRow>) -> Vec<Tensor> {
        let count = rows.len();
        let mut columns = Columns::new("pose0", count);
        let (mut after, mut guess) = (Vec::new(), Vec::new());
        let (mut push, mut tip) = (Vec::new(), Vec::new());
        for row in &rows {
            columns.push(&row.bodies);
            after.extend(row.after.as_flattened());
            guess.extend(row.guess.as_flattened());
            push.extend(row.push);
            tip.extend(row.tip);
        }
        let mut tensors = columns.finish();
        tensors.extend([
            Tensor::new("pose1", [count, WIDTH, 3], Data::F32(after)),
            Tensor::new("guess", [count, WIDTH, 3], Data::F32(guess)),
            Tensor::new("push", [count, 4], Data::F32(push)),
            Tensor::new("tip", [count, 3], Data::F32(tip)),
        ]);
        tensors
    }
}

/// Executes pushes from one state.
pub(super) fn run(
    engine: &dyn Transition,
    scratch: &mut Scratch,
    state: &State,
    pushes: &[Push],
    results: &mut Vec<PushResult>,
    stop: &Stop,
) {
    let jobs: Vec<_> = pushes.iter().map(|&push| PushJob { state, push }).collect();
    if results.len() < jobs.len() {
        results.resize_with(jobs.len(), PushResult::default);
    }
    for (jobs, results) in jobs.chunks(engine.batch_size()).zip(results.chunks_mut(engine.batch_size())) {
        engine.step_batch(scratch, jobs, &mut results[..jobs.len()], stop);
    }
}

/// The body's centre has moved by more than 2 mm, or it has turned by more than 2 degrees.
pub(super) fn moved(scene: &Scene, body: usize, before: &State, after: &State) -> bool {
    let footprint = &scene.body(body).footprint;
    let [a, b] = [before, after].map(|state| centre_pose(footprint, &state.pose(body)));
    (a.position() - b.position()).norm() > MOVED || normalize_angle(a.theta - b.theta).abs() > TURNED
}

pub(super) fn note(statistics: &mut Statistics, name: &str, value: f64) {
    *statistics.entry(name.to_string()).or_default() += value;
}

/// Friction of the tip on the bodies: the product of the tip's coefficient and the bodies' mean one.
pub(super) fn tip_row(scene: &Scene) -> [f32; 3] {
    let tip = &scene.gripper().push;
    let surface = scene.bodies().iter().map(|b| b.friction).sum::<f64>() / scene.len() as f64;
    [tip.width as f32, tip.thickness as f32, (scene.friction().tip * surface) as f32]
}

/// A push as it is stored: start and end.
pub(super) fn push_row(push: &Push) -> [f32; 4] {
    [push.start[0] as f32, push.start[1] as f32, push.end[0] as f32, push.end[1] as f32]
}

impl PushTask {
    /// The row of a push that was executed; nothing if it was refused, if a body fell, or if a number is not finite.
    #[allow(clippy::too_many_arguments)]
    fn row(
        &self,
        made: &TrainingScene,
        state: &State,
        push: &Push,
        result: &PushResult,
        guess: &PushResult,
        number: i64,
        statistics: &mut Statistics,
    ) -> Option<PushRow> {
        let scene = &made.scene;
        note(statistics, "proposed", 1.0);
        if result.status != PushStatus::Executed || guess.status != PushStatus::Executed {
            note(statistics, "illegal", 1.0);
            return None;
        }
        if !result.toppled.is_empty() {
            note(statistics, "toppled", 1.0);
            return None;
        }
        let bodies = Bodies::new(scene, state, &made.shapes, number, made.split);
        let mut row = PushRow {
            bodies,
            after: [[0.0; 3]; WIDTH],
            guess: [[0.0; 3]; WIDTH],
            push: push_row(push),
            tip: tip_row(scene),
        };
        let (mut moved, mut distance, mut turned) = (0.0, 0.0, 0.0);
        for i in 0..scene.len() {
            let footprint = &scene.body(i).footprint;
            let before = centre_pose(footprint, &state.pose(i));
            let motion = |result: &PushResult| {
                let after = centre_pose(footprint, &result.state.pose(i));
                // Within half a turn: no push turns a body farther.
                [after.x - before.x, after.y - before.y, normalize_angle(after.theta - before.theta)]
            };
            let (real, quick) = (motion(result), motion(guess));
            row.after[i] = [(before.x + real[0]) as f32, (before.y + real[1]) as f32, (before.theta + real[2]) as f32];
            row.guess[i] = quick.map(|v| v as f32);
            let (way, turn) = (real[0].hypot(real[1]), real[2].abs());
            if way > MOVED || turn > TURNED {
                moved += 1.0;
                distance += way;
                turned += turn;
            }
        }
        if !row.after.as_flattened().iter().chain(row.guess.as_flattened()).all(|v| v.is_finite()) {
            note(statistics, "not_finite", 1.0);
            return None;
        }
        note(statistics, "bodies", scene.len() as f64);
        note(statistics, "bodies_moved", moved);
        note(statistics, "moved_distance_m", distance);
        note(statistics, "moved_rotation_rad", turned);
        note(statistics, "rows_in_which_something_moved", f64::from(u8::from(moved > 0.0)));
        Some(row)
    }
}
