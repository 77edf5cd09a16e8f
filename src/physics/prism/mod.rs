//! A simulation of upright prisms that rock: six degrees of freedom a body, collision of footprints at two heights,
//! contacts that live as Bullet's do. Most of Bullet's fidelity at the cost of a planar engine.
//!
//! A planar model (x, y, theta) stops short of a simulation in space whatever its numerics: blocks rock while they are
//! pushed, and the rocking decides which of the bottom corners carry the load. Here a body has its place, its heading and
//! a small lean. Two bodies touch where their footprints do, at the lower or the upper end of the heights they share; the
//! lean shifts the footprints at these heights. `docs/engines-prism.md` has the model, its fidelity and its limits.

mod collide;
mod contact;
mod model;
mod settings;
mod solver;
mod world;

use std::sync::Arc;

pub use settings::PrismSettings;

use self::model::Model;
use self::world::{End, World};
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

    fn push(&self, world: &mut World, job: &PushJob<'_>, result: &mut PushResult, stop: &Stop) {
        result.state.clone_from(job.state);
        result.touched = Mask::EMPTY;
        result.left = Mask::EMPTY;
        let push = &job.push;
        if !push.is_finite() || push.length() < 1e-6 {
            result.status = PushStatus::Illegal { body: None };
            return;
        }
        if let Some(body) = self.landed_on(job.state, push) {
            result.status = PushStatus::Illegal { body: Some(body) };
            return;
        }
        let Some(travel) = self.free_travel(job.state, push) else {
            // The tip meets nothing: the world stays as it is, to the bit.
            result.status = PushStatus::Executed;
            return;
        };
        let steps = world.fill(&self.model, &self.settings, job.state, push, travel);
        if world.run(&self.model, &self.settings, steps, stop) == End::Interrupted {
            result.status = PushStatus::Interrupted;
            return;
        }
        result.touched = world.touched();
        world.read(&self.model, &mut result.state);
        result.status = PushStatus::Executed;
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
        Box::new(World::default())
    }

    fn step_batch(&self, scratch: &mut Scratch, jobs: &[PushJob<'_>], results: &mut [PushResult], stop: &Stop) {
        let mut spare;
        let world = match scratch.downcast_mut::<World>() {
            Some(world) => world,
            None => {
                // A scratch of another engine: work without it.
                spare = World::default();
                &mut spare
            }
        };
        for (job, result) in jobs.iter().zip(results) {
            if stop.requested() {
                result.status = PushStatus::Interrupted;
            } else {
                self.push(world, job, result, stop);
            }
        }
    }
}
