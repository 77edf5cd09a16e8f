//! States and what each push from them is worth: the data of PPN.
//!
//! The value of a push is that of the best plan that begins with it, as far as a search of a fixed number of iterations
//! knows. With `v(s) = [graspable] + 0.2 j(s)` the published reward of MORE (`j`: half of one plus the grasp's score
//! where there is a grasp, half of the nearness where there is none) it is
//! `q = max over plans and k of discount^k v(s_k) / 1.2`, `s_0` being the state after the push. A push that is illegal,
//! moves nothing or takes a body out of the workspace is worth 0. The search may be guided by a network that learned from
//! earlier data; what it says of a push is no part of the value.

use std::path::Path;
use std::sync::Arc;

use serde::Serialize;
use serde_json::{Value, json};

use super::columns::{Bodies, Columns};
use super::push::{note, push_row, tip_row};
use super::scenes::{SceneMaker, SceneParams, WIDTH};
use super::shapes::ShapeFamily;
use super::store::{self, Made, Manifest, SceneRows, StoreParams, Task};
use super::tensors::{Data, Tensor};
use crate::action::ContourSampler;
use crate::error::{Error, Result, check_range};
use crate::grasp::{GeometricScorer, GraspParams};
use crate::net::{Model, Ppn, PushValue};
use crate::physics::{self, PhysicsOptions, Purpose};
use crate::plan::{FailedPushes, GraspDecision, Retrieval, Reward};
use crate::run::{Budget, Key, Pool, Stop};
use crate::scene::State;
use crate::search::{Closed, EarlyStop, Params, Run, Tree};

/// Weight of the judgement of a state beside the 1 for a solution (MORE).
const SHAPING: f64 = 0.2;
/// Share of the generator's scenes whose target is its own choice, the body most enclosed; in the others and in scenes
/// of other kinds any body is the target.
const ENCLOSED: f64 = 0.7;

/// What to search, and how long.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PpnParams {
    /// The engine of the search.
    pub physics: PhysicsOptions,
    pub scenes: SceneParams,
    /// States of a scene, each led to by a push from the one before.
    pub states: usize,
    /// Iterations of a search.
    pub iterations: u64,
    /// Name of the push sampler.
    pub sampler: String,
    /// Iterations that run side by side.
    pub lanes: u32,
    /// A network of kind `ppn` that guides the search, as it does in the planner `more`; `mcts` searches if absent.
    #[serde(skip)]
    pub prior: Option<Model>,
}

impl PpnParams {
    /// Searches of 300 iterations with the pushes of MORE in the quick planar engine, in scenes of 5 to 11 bodies.
    pub fn new() -> Result<Self> {
        Ok(PpnParams {
            physics: PhysicsOptions::named("planar", Some("fast"), Purpose::Planning)?,
            scenes: SceneParams::generated(5..=11),
            states: 2,
            iterations: 300,
            sampler: "more".into(),
            lanes: 16,
            prior: None,
        })
    }

    fn validate(&self) -> Result<()> {
        self.physics.validate()?;
        check_range("states", self.states as f64, 1.0..=64.0)?;
        check_range("iterations", self.iterations as f64, 1.0..=1e6)?;
        ContourSampler::preset(&self.sampler)?;
        self.search().validate().map_err(|e| e.within("search"))
    }

    /// The search of chapter MORE, guided where there is a network, without an early end, so that every push gets its value,
    /// and without counting solutions again and again.
    fn search(&self) -> Params {
        let published = if self.prior.is_some() { Params::guided() } else { Params::mcts() };
        Params { early_stop: EarlyStop::Never, closed: Closed::Skip, lanes: self.lanes, ..published }
    }
}

/// Makes or completes a folder of valued pushes.
pub fn ppn(
    params: &PpnParams,
    family: &Arc<ShapeFamily>,
    shape_seed: u64,
    folder: &Path,
    to: &StoreParams,
    stop: &Stop,
    progress: &mut dyn FnMut(Made),
) -> Result<Manifest> {
    params.validate()?;
    let maker = SceneMaker::new(params.scenes.clone(), Arc::clone(family))?;
    let prior = match &params.prior {
        Some(model) => Some(Arc::new(Ppn::new(model.clone())?) as Arc<dyn PushValue>),
        None => None,
    };
    store::make(&PpnTask { params: params.clone(), maker, prior }, family, shape_seed, folder, to, stop, progress)
}

/// A state with its valued pushes.
pub(super) struct PpnRow {
    bodies: Bodies,
    target: u8,
    tip: [f32; 3],
    pushes: Vec<ValuedPush>,
}

struct ValuedPush {
    push: [f32; 4],
    q: f32,
    visits: u32,
}

struct PpnTask {
    params: PpnParams,
    maker: SceneMaker,
    prior: Option<Arc<dyn PushValue>>,
}

/// Working memory of a thread.
pub(super) struct PpnWorker {
    tree: Tree<Retrieval>,
    /// Without threads: each scene is one thread's.
    pool: Pool,
}

impl Task for PpnTask {
    type Row = PpnRow;
    type Worker = PpnWorker;

    fn kind(&self) -> &'static str {
        "ppn"
    }

    fn configuration(&self) -> Result<Value> {
        let params = serde_json::to_value(&self.params).map_err(|e| Error::Internal(e.to_string()))?;
        let search = self.params.search();
        let mut configuration = json!({
            "ppn": params,
            "width": WIDTH,
            "search": {
                "planner": "mcts", "discount": search.discount, "max_depth": search.max_depth, "lanes": search.lanes,
                "early_stop": "never", "closed": "skip",
            },
            "reward": {
                "shaping": SHAPING, "solved_score": GraspDecision::default().solved_score,
                "gripper": "robotiq_2f85", "grasp": "geometric",
            },
            "label": "greatest discounted value of the plans that begin with the push, over 1.2: max_k 0.5^k v(s_k) / 1.2, \
                      v = [grasp score >= solved_score] + 0.2 j, j = 0.5 + 0.5 score with a grasp, 0.5 nearness without; \
                      s_0 is the state after the push; 0 for a push that is illegal, idle or takes a body out",
        });
        // Only where there is one: folders of unguided searches stay what they were.
        if let Some(prior) = &self.params.prior {
            configuration["search"]["planner"] = "more".into();
            configuration["search"]["prior_sha256"] = prior.info().sha256.clone().into();
        }
        Ok(configuration)
    }

    fn worker(&self) -> Result<PpnWorker> {
        Ok(PpnWorker { tree: Tree::new(), pool: Pool::inline() })
    }

    fn rows_of_scene(&self) -> usize {
        self.params.states
    }

    fn scene(&self, worker: &mut PpnWorker, key: Key, number: i64, stop: &Stop) -> Result<SceneRows<PpnRow>> {
        let made = self.maker.scene(key.child(0))?;
        let mut random = key.child(1).stream();
        let scene = &made.scene;
        let given = made.kind == "generated" && random.chance(ENCLOSED);
        // The generator makes its target body 0.
        let target = if given { 0 } else { random.index(scene.len()) };
        let domain = Retrieval {
            prior: self.prior.clone(),
            scene: Arc::clone(scene),
            target,
            engine: physics::engine(&self.params.physics, Arc::clone(scene))?,
            sampler: Box::new(ContourSampler::preset(&self.params.sampler)?.prepared(scene)),
            scorer: Box::new(GeometricScorer::new(scene, GraspParams::default())?),
            reward: Reward { shaping: SHAPING, solved_score: GraspDecision::default().solved_score },
            grasp: GraspDecision::default(),
            present: None,
            demand: 0.0,
            failed: FailedPushes::default(),
            unsolved: Default::default(),
        };
        let search = self.params.search();
        let mut out = SceneRows::default();
        let mut state: State = made.state.clone();
        for step in 0..self.params.states {
            let run =
                Run { pool: &worker.pool, stop, budget: Budget::iterations(self.params.iterations), progress: None };
            let seed = key.child(2).child(step as u64).bits();
            let report = worker.tree.search(&domain, &state, &search, seed, &run)?;
            note(&mut out.statistics, "searches", 1.0);
            note(&mut out.statistics, "iterations", report.iterations as f64);
            note(&mut out.statistics, "simulations", report.simulations as f64);
            let mut pushes = Vec::new();
            let mut next: Option<State> = None;
            let (mut alive, mut dead, mut best) = (0, 0, 0.0f64);
            for child in worker.tree.root_children() {
                let (q, visits) = match &child.node {
                    Some(node) => (node.best / (1.0 + SHAPING), node.visits),
                    None if child.illegal => (0.0, 0),
                    // The budget did not reach it: nothing is known.
                    None => {
                        note(&mut out.statistics, "pushes_untried", 1.0);
                        continue;
                    }
                };
                best = best.max(q);
                pushes.push(ValuedPush { push: push_row(child.action), q: q.clamp(0.0, 1.0) as f32, visits });
                match child.node {
                    Some(node) if !node.terminal => {
                        alive += 1;
                        // One of the states leads on, each as likely.
                        if random.index(alive) == 0 {
                            next = Some(node.state.clone());
                        }
                    }
                    Some(_) => {}
                    None => dead += 1,
                }
            }
            if pushes.is_empty() {
                // Graspable as it is, or without a legal push.
                note(&mut out.statistics, "states_without_pushes", 1.0);
            } else {
                note(&mut out.statistics, "rows", 1.0);
                note(&mut out.statistics, &format!("rows_{}", made.split.name()), 1.0);
                note(&mut out.statistics, "pushes", pushes.len() as f64);
                note(&mut out.statistics, "pushes_dead", f64::from(dead));
                note(&mut out.statistics, "best_q", best);
                let solved = f64::from(u8::from(report.solution_level.is_some()));
                note(&mut out.statistics, "rows_solved", solved);
                let first = f64::from(u8::from(report.solution_level == Some(1)));
                note(&mut out.statistics, "rows_solved_by_one_push", first);
                out.rows.push(PpnRow {
                    bodies: Bodies::new(scene, &state, &made.shapes, number, made.split),
                    target: target as u8,
                    tip: tip_row(scene),
                    pushes,
                });
            }
            match next {
                Some(next) => state = next,
                None => break,
            }
        }
        note(&mut out.statistics, "scenes", 1.0);
        Ok(out)
    }

    fn tensors(&self, rows: Vec<PpnRow>) -> Vec<Tensor> {
        let count = rows.len();
        let mut columns = Columns::new("pose", count);
        let (mut target, mut tip, mut start) = (Vec::new(), Vec::new(), vec![0i64]);
        let (mut push, mut q, mut visits) = (Vec::new(), Vec::new(), Vec::new());
        for row in &rows {
            columns.push(&row.bodies);
            target.push(row.target);
            tip.extend(row.tip);
            for valued in &row.pushes {
                push.extend(valued.push);
                q.push(valued.q);
                visits.push(valued.visits);
            }
            start.push(q.len() as i64);
        }
        let mut tensors = columns.finish();
        let total = q.len();
        tensors.extend([
            Tensor::new("target", [count], Data::U8(target)),
            Tensor::new("tip", [count, 3], Data::F32(tip)),
            Tensor::new("push_start", [count + 1], Data::I64(start)),
            Tensor::new("push", [total, 4], Data::F32(push)),
            Tensor::new("q", [total], Data::F32(q)),
            Tensor::new("visits", [total], Data::U32(visits)),
        ]);
        tensors
    }
}
