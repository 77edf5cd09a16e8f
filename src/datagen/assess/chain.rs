//! Several pushes in a row, predicted on predictions.
//!
//! The pushes are chosen in the world of a reference engine, in which each moves something. Every other engine executes
//! them from the same start, on its own states.

use std::sync::Arc;

use serde::Serialize;

use super::super::columns::centre_pose;
use super::super::push::{PushWorker, moved};
use super::super::scenes::{SceneMaker, SceneParams};
use super::super::shapes::ShapeFamily;
use super::{EngineMaker, HeldOut};
use crate::action::Push;
use crate::error::{Result, check_range};
use crate::geom::normalize_angle;
use crate::physics::{PushStatus, Transition};
use crate::run::{Key, Stop};
use crate::scene::{Scene, State};

/// Pushes proposed for each one wanted.
const PROPOSED: usize = 8;

/// What chains to compare.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChainParams {
    pub scenes: SceneParams,
    pub chains: usize,
    /// Pushes in a row.
    pub pushes: usize,
    pub seed: u64,
}

impl Default for ChainParams {
    fn default() -> Self {
        ChainParams {
            scenes: SceneParams { bodies: 3..=12, ..SceneParams::default() },
            chains: 100,
            pushes: 4,
            seed: 0,
        }
    }
}

/// After so many pushes, the mean over bodies of all chains.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct ChainStep {
    /// Pushes so far.
    pub push: usize,
    /// Bodies that the reference has moved since the start of their chain, by more than 2 mm or 2 degrees.
    pub moved: usize,
    /// 1 - IoU of those bodies with where the reference has them.
    pub moved_one_minus_iou: f64,
    /// Distance of their centres, millimetres.
    pub moved_position_mm: f64,
    /// Difference of their headings, degrees.
    pub moved_rotation_deg: f64,
    /// 1 - IoU of all bodies.
    pub one_minus_iou: f64,
    /// Pushes so far that the engine refused, because the tip would have come down on a body where it has that.
    pub refused: usize,
}

/// How far an engine strays.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChainEngine {
    /// Its name for itself; `static` has every body where it began.
    pub engine: String,
    pub steps: Vec<ChainStep>,
}

/// How far engines stray from a reference over several pushes.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ChainReport {
    pub reference: String,
    pub chains: usize,
    pub bodies: usize,
    /// `static` first, then the engines in their order.
    pub engines: Vec<ChainEngine>,
}

/// A chain as the reference has it.
struct Chain {
    pushes: Vec<Push>,
    states: Vec<State>,
}

/// Compares engines with a reference in held-out scenes. A requested stop ends with what is known by then. `progress`
/// hears the number of chains.
pub fn chains(
    params: &ChainParams,
    family: &Arc<ShapeFamily>,
    reference: EngineMaker<'_>,
    engines: &[EngineMaker<'_>],
    stop: &Stop,
    progress: &mut dyn FnMut(usize),
) -> Result<ChainReport> {
    check_range("chains", params.chains as f64, 1.0..=1e6)?;
    check_range("pushes", params.pushes as f64, 1.0..=64.0)?;
    let maker = SceneMaker::new(params.scenes.clone(), Arc::clone(family))?;
    let mut held_out = HeldOut::new(maker, params.seed, params.chains);
    let mut worker = PushWorker::new()?;
    let mut sums = vec![vec![Sum::default(); params.pushes]; engines.len() + 1];
    let mut names = vec!["static".to_string(); engines.len() + 1];
    let mut report = ChainReport::default();
    while report.chains < params.chains && !stop.requested() {
        let (made, key) = held_out.scene()?;
        let scene = &made.scene;
        let engine = reference(Arc::clone(scene))?;
        report.reference = engine.name().to_string();
        let Some(chain) = chain(&*engine, &made.state, params.pushes, &mut worker, key, stop) else { continue };
        let mut predicted = Vec::with_capacity(engines.len() + 1);
        predicted.push(vec![(made.state.clone(), 0); params.pushes]);
        for (make, name) in engines.iter().zip(&mut names[1..]) {
            let engine = make(Arc::clone(scene))?;
            *name = engine.name().to_string();
            let mut scratch = engine.scratch();
            let (mut state, mut refused) = (made.state.clone(), 0);
            let mut states = Vec::with_capacity(params.pushes);
            for push in &chain.pushes {
                let result = engine.step(&mut scratch, &state, push, stop);
                match result.status {
                    PushStatus::Executed => state = result.state,
                    _ => refused += 1,
                }
                states.push((state.clone(), refused));
            }
            predicted.push(states);
        }
        if stop.requested() {
            break;
        }
        for (sums, states) in sums.iter_mut().zip(&predicted) {
            for ((sum, (state, refused)), wanted) in sums.iter_mut().zip(states).zip(&chain.states) {
                sum.add(scene, &made.state, wanted, state, *refused);
            }
        }
        report.chains += 1;
        report.bodies += scene.len();
        progress(report.chains);
    }
    report.engines = names
        .into_iter()
        .zip(&sums)
        .map(|(engine, sums)| {
            let steps = sums.iter().enumerate().map(|(k, sum)| sum.finish(k + 1)).collect();
            ChainEngine { engine, steps }
        })
        .collect();
    Ok(report)
}

/// Pushes of which each moves something and topples nothing; nothing where too few are found.
fn chain(
    engine: &dyn Transition,
    start: &State,
    pushes: usize,
    worker: &mut PushWorker,
    key: Key,
    stop: &Stop,
) -> Option<Chain> {
    let scene = engine.scene();
    let mut random = key.stream();
    let mut scratch = engine.scratch();
    let mut chain = Chain { pushes: Vec::new(), states: Vec::new() };
    for _ in 0..pushes {
        let state = chain.states.last().unwrap_or(start);
        let sampled = random.chance(0.5);
        worker.propose(scene, state, PROPOSED, sampled, &mut random);
        let (push, after) = worker.pushes.iter().find_map(|push| {
            let result = engine.step(&mut scratch, state, push, stop);
            let of_use = result.status == PushStatus::Executed && result.toppled.is_empty();
            let moves = |after: &State| (0..scene.len()).any(|i| moved(scene, i, state, after));
            (of_use && moves(&result.state)).then_some((*push, result.state))
        })?;
        chain.pushes.push(push);
        chain.states.push(after);
    }
    Some(chain)
}

#[derive(Debug, Clone, Default)]
struct Sum {
    moved: usize,
    bodies: usize,
    moved_error: f64,
    error: f64,
    position: f64,
    rotation: f64,
    refused: usize,
}

impl Sum {
    fn add(&mut self, scene: &Scene, start: &State, wanted: &State, got: &State, refused: usize) {
        for i in 0..scene.len() {
            let footprint = &scene.body(i).footprint;
            let (want, have) = (wanted.pose(i), got.pose(i));
            let error = (1.0 - footprint.iou(&want, &have)).max(0.0);
            self.bodies += 1;
            self.error += error;
            if moved(scene, i, start, wanted) {
                let [a, b] = [centre_pose(footprint, &want), centre_pose(footprint, &have)];
                self.moved += 1;
                self.moved_error += error;
                self.position += (a.position() - b.position()).norm();
                self.rotation += normalize_angle(a.theta - b.theta).abs();
            }
        }
        self.refused += refused;
    }

    fn finish(&self, push: usize) -> ChainStep {
        let (moved, bodies) = (self.moved.max(1) as f64, self.bodies.max(1) as f64);
        ChainStep {
            push,
            moved: self.moved,
            moved_one_minus_iou: self.moved_error / moved,
            moved_position_mm: self.position / moved * 1e3,
            moved_rotation_deg: (self.rotation / moved).to_degrees(),
            one_minus_iou: self.error / bodies,
            refused: self.refused,
        }
    }
}
