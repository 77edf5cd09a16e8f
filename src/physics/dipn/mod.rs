//! A learned engine: what a push does, predicted by a network of kind `dipn`.
//!
//! What does not need a network is done as the other engines do it: whether the tip may come down, whether it meets
//! anything, which bodies have left the workspace. A network that corrects the planar engine (`"guess": "planar"`) is given
//! the prediction of its preset `fast` for the same pushes.

mod settings;

use std::sync::Arc;

pub use settings::DipnSettings;

use super::approach::Approach;
use super::planar::{Planar, PlanarSettings};
use super::transition::{PushJob, PushResult, PushStatus, Scratch, Transition};
use crate::action::Push;
use crate::error::Result;
use crate::geom::Obb;
use crate::net::{self, Kind, LoadOptions, Model, MotionModel, ObjectBatch, ObjectTable};
use crate::run::Stop;
use crate::scene::{Mask, Scene, State};

/// Whether this build has a network of its own; if not, what to do.
#[cfg(jostle_dipn)]
pub const AVAILABLE: std::result::Result<(), &'static str> = Ok(());
#[cfg(not(jostle_dipn))]
pub const AVAILABLE: std::result::Result<(), &'static str> =
    Err("it has no trained network for it; name the file of one as the preset");

/// Jobs of a call at which the planar engine's lanes and the network are busy.
const BATCH: usize = 64;

/// The engine prepared for one scene.
pub struct Dipn {
    name: String,
    scene: Arc<Scene>,
    settings: DipnSettings,
    model: Arc<dyn MotionModel>,
    /// Makes the guess, if the network wants one.
    planar: Option<Planar>,
    table: ObjectTable,
}

/// Working memory of a thread.
#[derive(Default)]
struct Workspace {
    batch: ObjectBatch,
    motions: Vec<[f32; 3]>,
    /// The jobs whose tip meets something.
    active: Vec<usize>,
    planar: Option<Scratch>,
    guesses: Vec<PushResult>,
}

impl Dipn {
    /// Prepares the scene. `model` is a [`net::Dipn`], or a stand-in.
    pub fn new(scene: Arc<Scene>, settings: DipnSettings, model: Arc<dyn MotionModel>) -> Result<Dipn> {
        settings.validate()?;
        let planar = match model.wants_guess() {
            true => Some(Planar::new(Arc::clone(&scene), PlanarSettings::fast())?),
            false => None,
        };
        let table = ObjectTable::new(&scene);
        Ok(Dipn { name: format!("dipn {}", model.name()), scene, settings, model, planar, table })
    }

    /// The network that a preset names: a built-in one, or a file.
    pub fn load(preset: &str) -> Result<Arc<dyn MotionModel>> {
        let model = Model::open(preset, Some(Kind::Dipn), &LoadOptions::default())?;
        Ok(Arc::new(net::Dipn::new(model)?))
    }

    fn approach(&self) -> Approach {
        let DipnSettings { landing_tolerance, border, .. } = self.settings;
        // A network does not know how near bodies may come to each other.
        Approach { landing_tolerance, border, tip_low: 0.0, flat: false }
    }

    /// The planar engine's prediction of the active jobs, in their order.
    fn guess(&self, memory: &mut Workspace, jobs: &[PushJob<'_>], stop: &Stop) {
        let Some(planar) = &self.planar else { return };
        let scratch = memory.planar.get_or_insert_with(|| planar.scratch());
        let pushes: Vec<PushJob<'_>> = memory.active.iter().map(|&i| jobs[i]).collect();
        memory.guesses.resize_with(pushes.len().max(memory.guesses.len()), PushResult::default);
        planar.step_batch(scratch, &pushes, &mut memory.guesses[..pushes.len()], stop);
    }

    /// Asks the network about some of the active jobs and moves the bodies.
    fn predict(
        &self,
        memory: &mut Workspace,
        range: std::ops::Range<usize>,
        jobs: &[PushJob<'_>],
        results: &mut [PushResult],
        stop: &Stop,
    ) {
        let approach = self.approach();
        let Workspace { batch, motions, active, guesses, .. } = memory;
        batch.clear(self.table.len());
        for k in range.clone() {
            let job = &jobs[active[k]];
            let guess = self.planar.as_ref().map(|_| &guesses[k].state);
            batch.add(&self.table, &self.scene, job.state, &job.push, guess, None);
        }
        let answered =
            self.model.predict(batch, motions, stop).is_ok() && motions.len() == range.len() * self.table.len();
        for (k, motions) in range.zip(motions.chunks(self.table.len().max(1))) {
            let (job, result) = (&jobs[active[k]], &mut results[active[k]]);
            if !answered {
                continue;
            }
            for (body, pose) in job.state.iter() {
                let motion = motions[body];
                let still = f64::from(motion[0].hypot(motion[1])) < self.settings.still_position
                    && f64::from(motion[2].abs()) < self.settings.still_angle;
                if !still {
                    result.state.set_pose(body, net::moved(&self.scene, body, &pose, &job.push, motion));
                }
            }
            result.touched = match &self.planar {
                Some(_) => guesses[k].touched,
                None => self.in_the_way(job.state, &job.push),
            };
            approach.end(&self.scene, job, result);
        }
    }

    /// The bodies that lie where the tip will be.
    fn in_the_way(&self, state: &State, push: &Push) -> Mask {
        let tip = push.tip_at_start(&self.scene.gripper().push);
        let length = push.length();
        let swept = Obb {
            centre: tip.centre + push.direction() * (length / 2.0),
            half: [tip.half[0] + length / 2.0 + self.settings.border, tip.half[1]],
            ..tip
        };
        let mut touched = Mask::EMPTY;
        for (i, pose) in state.iter() {
            if swept.overlaps(&self.scene.body(i).footprint, &pose.frame()) {
                touched.insert(i);
            }
        }
        touched
    }
}

impl Transition for Dipn {
    fn name(&self) -> &str {
        &self.name
    }

    fn scene(&self) -> &Scene {
        &self.scene
    }

    fn scratch(&self) -> Scratch {
        Box::<Workspace>::default()
    }

    fn batch_size(&self) -> usize {
        BATCH
    }

    /// A network that cannot be run after it was loaded leaves a push `Illegal` without a body.
    fn step_batch(&self, scratch: &mut Scratch, jobs: &[PushJob<'_>], results: &mut [PushResult], stop: &Stop) {
        let mut own;
        let memory = match scratch.downcast_mut::<Workspace>() {
            Some(memory) => memory,
            // Another engine's scratch: slower, not wrong.
            None => {
                own = Workspace::default();
                &mut own
            }
        };
        memory.active.clear();
        let approach = self.approach();
        for (i, (job, result)) in jobs.iter().zip(results.iter_mut()).enumerate() {
            if stop.requested() {
                result.status = PushStatus::Interrupted;
            } else if approach.begin(&self.scene, job, result).is_some() {
                memory.active.push(i);
                // Until it is predicted.
                result.status = PushStatus::Illegal { body: None };
            }
        }
        self.guess(memory, jobs, stop);
        let chunk = self.model.chunk().max(1);
        let count = memory.active.len();
        for first in (0..count).step_by(chunk) {
            if !stop.requested() {
                self.predict(memory, first..(first + chunk).min(count), jobs, results, stop);
            }
            // Also of a chunk in whose midst the network was stopped.
            if stop.requested() {
                memory.active[first..].iter().for_each(|&i| results[i].status = PushStatus::Interrupted);
                return;
            }
        }
    }
}
