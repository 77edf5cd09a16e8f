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
use super::transition::{PushJob, PushResult, PushStatus, Scratch, Transition};
use crate::action::Push;
use crate::error::Result;
use crate::geom::Obb;
use crate::run::Stop;
use crate::scene::{Mask, Scene, State};

/// A gap below this ends the free travel of the tip, metres.
const NEAR: f64 = 4e-4;

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

    /// Puts the job's start into the result and the world. False if the result is final already.
    fn begin(&self, world: &mut World, job: &PushJob<'_>, result: &mut PushResult) -> bool {
        result.state.clone_from(job.state);
        result.touched = Mask::EMPTY;
        result.left = Mask::EMPTY;
        result.toppled = Mask::EMPTY;
        let push = &job.push;
        if !push.is_finite() || push.length() < 1e-6 {
            result.status = PushStatus::Illegal { body: None };
            return false;
        }
        if let Some(body) = self.landed_on(job.state, push) {
            result.status = PushStatus::Illegal { body: Some(body) };
            return false;
        }
        result.status = PushStatus::Executed;
        let Some(travel) = self.free_travel(job.state, push) else {
            // The tip meets nothing: the world stays as it is, to the bit.
            return false;
        };
        world.fill(&self.model, &self.settings, job.state, push, travel);
        true
    }

    /// Reads the result out of a world whose push is over.
    fn finish(&self, world: &World, job: &PushJob<'_>, result: &mut PushResult) {
        result.touched = world.touched();
        result.toppled = world.toppled();
        world.read(&self.model, &mut result.state);
        let workspace = self.scene.workspace();
        for (i, pose) in result.state.iter() {
            let footprint = &self.scene.body(i).footprint;
            if !workspace.holds(footprint, &pose) && workspace.holds(footprint, &job.state.pose(i)) {
                result.left.insert(i);
            }
        }
    }

    /// The body that the tip would come down on: the one it overlaps most.
    fn landed_on(&self, state: &State, push: &Push) -> Option<usize> {
        let tip = push.tip_at_start(&self.scene.gripper().push);
        state
            .iter()
            .map(|(i, pose)| (i, tip.gap_below(&self.scene.body(i).footprint, &pose, 0.0)))
            .filter(|(_, gap)| *gap < -self.settings.landing_tolerance)
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(i, _)| i)
    }

    /// How far the tip travels before it comes near a body's border; `None` if it never does.
    /// Conservative advancement: the tip may always move by its gap to the nearest body.
    fn free_travel(&self, state: &State, push: &Push) -> Option<f64> {
        let (length, direction) = (push.length(), push.direction());
        let start = push.tip_at_start(&self.scene.gripper().push);
        let border = self.settings.border;
        let mut travel = 0.0;
        for _ in 0..64 {
            let tip = Obb { centre: start.centre + direction * travel, ..start };
            // Far enough to reach the end is all that has to be known of a gap.
            let gap = state.iter().fold(length - travel + border, |least, (i, pose)| {
                least.min(tip.gap_below(&self.scene.body(i).footprint, &pose, least))
            });
            let free = gap - border;
            if free < NEAR {
                return Some(travel);
            }
            travel += free;
            if travel >= length {
                return None;
            }
        }
        Some(travel)
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
