//! A simulation of upright prisms that rock: six degrees of freedom a body, collision of footprints at two heights,
//! contacts that live as Bullet's do. Most of Bullet's fidelity at the cost of a planar engine.
//!
//! A planar model (x, y, theta) stops short of a simulation in space whatever its numerics: blocks rock while they are
//! pushed, and the rocking decides which of the bottom corners carry the load. Here a body has its place, its heading and
//! a small lean. Two bodies touch where their footprints do, at the lower or the upper end of the heights they share; the
//! lean shifts the footprints at these heights. `docs/engines-prism.md` has the model, its fidelity and its limits.

mod collide;
mod contact;
mod kernel;
mod model;
mod momentum;
mod near;
mod pool;
mod settings;
mod solver;
#[cfg(test)]
mod tests;
mod wide;
mod world;

use std::sync::Arc;

pub use settings::PrismSettings;

use self::model::Model;
use self::pool::Pool;
use self::world::World;
use super::approach::Approach;
use super::transition::{PushJob, PushResult, Scratch, Transition};
use crate::error::Result;
use crate::run::Stop;
use crate::scene::Scene;

/// The engine prepared for one scene.
pub struct Prism {
    name: String,
    scene: Arc<Scene>,
    settings: PrismSettings,
    model: Model,
}

impl Prism {
    /// Prepares the scene.
    pub fn new(scene: Arc<Scene>, settings: PrismSettings) -> Result<Prism> {
        Self::with_name("prism".into(), scene, settings)
    }

    pub(super) fn with_name(name: String, scene: Arc<Scene>, settings: PrismSettings) -> Result<Prism> {
        settings.validate()?;
        let model = Model::new(&scene, &settings);
        Ok(Prism { name, scene, settings, model })
    }

    pub fn settings(&self) -> &PrismSettings {
        &self.settings
    }

    fn approach(&self) -> Approach {
        let PrismSettings { landing_tolerance, border, .. } = self.settings;
        Approach { landing_tolerance, border, tip_low: 0.0, flat: false }
    }

    /// Puts the job's start into the result and the world. False if the result is final already.
    fn begin(&self, world: &mut World, job: &PushJob<'_>, result: &mut PushResult) -> bool {
        let Some(travel) = self.approach().begin(&self.scene, job, result) else { return false };
        world.fill(&self.model, &self.settings, job.state, &job.push, travel);
        true
    }

    /// Reads the result out of a world whose push is over.
    fn finish(&self, world: &World, job: &PushJob<'_>, result: &mut PushResult) {
        if world.is_unsolved(&self.settings) {
            return result.take_back(job.state);
        }
        result.touched = world.touched();
        result.toppled = world.toppled();
        world.read(&self.model, &mut result.state);
        // The world knows its bodies apart, borders included; only where it does not are the outlines asked.
        Approach { flat: world.is_deep(), ..self.approach() }.end(&self.scene, job, result);
    }
}

impl Transition for Prism {
    fn name(&self) -> &str {
        &self.name
    }

    fn scene(&self) -> &Scene {
        &self.scene
    }

    fn scratch(&self) -> Scratch {
        Box::new(Pool::default())
    }

    fn batch_size(&self) -> usize {
        pool::WORLDS
    }

    fn step_batch(&self, scratch: &mut Scratch, jobs: &[PushJob<'_>], results: &mut [PushResult], stop: &Stop) {
        let mut spare;
        let pool = match scratch.downcast_mut::<Pool>() {
            Some(pool) => pool,
            None => {
                // A scratch of another engine: work without it.
                spare = Pool::default();
                &mut spare
            }
        };
        pool.run(self, jobs, results, stop);
    }
}
