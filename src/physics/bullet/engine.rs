//! The engine prepared for a scene, and what it does with a push.

use std::sync::Arc;

use super::grasp::{GraspMotion, GraspTrial};
use super::native;
use super::settings::BulletSettings;
use super::world::PushWorld;
use crate::action::Grasp;
use crate::error::Result;
use crate::geom::{Vec2, vec2};
use crate::physics::approach::Approach;
use crate::physics::transition::{
    GraspResult, GraspStatus, PushJob, PushResult, PushStatus, Scratch, Stance, Transition,
};
use crate::run::Stop;
use crate::scene::{Mask, Scene, State};

/// The engine prepared for one scene.
pub struct Bullet {
    name: String,
    pub(super) scene: Arc<Scene>,
    pub(super) settings: BulletSettings,
    pub(super) inertias: Vec<[f64; 3]>,
}

/// How a body stands after a push.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BodyDetail {
    /// Angle of its axis from the vertical, radians.
    pub tilt: f64,
    /// How far its centre rose from where it rests, metres.
    pub rise: f64,
}

impl Bullet {
    /// Prepares the scene. Fails where another build of Bullet stands in this process in the place of ours.
    pub fn new(scene: Arc<Scene>, settings: BulletSettings) -> Result<Bullet> {
        Self::with_name("bullet".into(), scene, settings)
    }

    pub(in crate::physics) fn with_name(name: String, scene: Arc<Scene>, settings: BulletSettings) -> Result<Bullet> {
        settings.validate()?;
        native::check_library()?;
        let inertias = scene
            .bodies()
            .iter()
            .map(|body| {
                // As Bullet does for a compound: that of a box round the shape, with its margins (3 on each side). The
                // moment about the vertical is the body's own, which for the originals' blocks is the same.
                let (low, high) = body.footprint.bounds();
                let size: Vec2 = high - low + vec2(1.0, 1.0) * (6.0 * settings.margin);
                let height = body.height + 6.0 * settings.margin;
                let about = |a: f64| body.mass / 12.0 * (a * a + height * height);
                [about(size.y), about(size.x), body.inertia]
            })
            .collect();
        Ok(Bullet { name, scene, settings, inertias })
    }

    pub fn settings(&self) -> &BulletSettings {
        &self.settings
    }

    /// A push with what became of every body (in the order of the scene; absent bodies stay as they are).
    pub fn push_in_detail(&self, job: &PushJob<'_>, stop: &Stop) -> (PushResult, Vec<BodyDetail>) {
        let mut result = PushResult::default();
        let mut details = vec![BodyDetail::default(); self.scene.len()];
        self.push(job, &[], &mut result, &mut details, stop);
        (result, details)
    }

    fn push(
        &self,
        job: &PushJob<'_>,
        stances: &[Stance],
        result: &mut PushResult,
        details: &mut [BodyDetail],
        stop: &Stop,
    ) {
        let BulletSettings { landing_tolerance, margin, tip_bottom, .. } = self.settings;
        let approach = Approach { landing_tolerance, border: margin, tip_low: tip_bottom, flat: false };
        let Some(travel) = approach.begin(&self.scene, job, result) else { return };
        let from = (travel - self.settings.approach).max(0.0);
        match self.simulate(job, stances, from, result, details, stop) {
            Ok(true) => approach.end(&self.scene, job, result),
            Ok(false) => result.status = PushStatus::Interrupted,
            // Out of memory, or a world that burst: the push is not to be used.
            Err(_) => {
                result.state.clone_from(job.state);
                (result.touched, result.toppled) = (Mask::EMPTY, Mask::EMPTY);
                result.status = PushStatus::Illegal { body: None };
            }
        }
    }

    /// False if the stop was requested on the way.
    fn simulate(
        &self,
        job: &PushJob<'_>,
        stances: &[Stance],
        from: f64,
        result: &mut PushResult,
        details: &mut [BodyDetail],
        stop: &Stop,
    ) -> Result<bool> {
        let mut world = PushWorld::new(self, job.state, stances, &job.push, from)?;
        if !world.run(stop)? {
            return Ok(false);
        }
        result.touched = world.touched();
        result.toppled = world.read(&mut result.state, details)?;
        Ok(true)
    }
}

impl Transition for Bullet {
    fn name(&self) -> &str {
        &self.name
    }

    fn scene(&self) -> &Scene {
        &self.scene
    }

    fn scratch(&self) -> Scratch {
        Box::new(vec![BodyDetail::default(); self.scene.len()])
    }

    fn step_batch(&self, scratch: &mut Scratch, jobs: &[PushJob<'_>], results: &mut [PushResult], stop: &Stop) {
        let mut spare = Vec::new();
        let details = scratch.downcast_mut::<Vec<BodyDetail>>().unwrap_or(&mut spare);
        details.resize(self.scene.len(), BodyDetail::default());
        for (job, result) in jobs.iter().zip(results) {
            if stop.requested() {
                result.status = PushStatus::Interrupted;
            } else {
                self.push(job, &[], result, details, stop);
            }
        }
    }

    fn grasp(&self, _: &mut Scratch, state: &State, grasp: &Grasp, stop: &Stop) -> Option<GraspResult> {
        let trial: GraspTrial = match Bullet::grasp(self, state, grasp, &GraspMotion::default(), stop) {
            Ok(trial) => trial,
            // Not a grasp, or no memory to try it in: nothing was lifted.
            Err(_) => {
                let status = GraspStatus::Blocked { body: None };
                return Some(GraspResult { status, state: state.clone(), ..GraspResult::default() });
            }
        };
        let status = match (trial.interrupted, trial.blocked_by) {
            (true, _) => GraspStatus::Interrupted,
            (false, Some(body)) => GraspStatus::Blocked { body: Some(body) },
            (false, None) => GraspStatus::Executed,
        };
        let mut state = trial.after;
        if trial.success {
            state.set_present(grasp.body, false);
        }
        let GraspTrial { held, lifted, gap, toppled, .. } = trial;
        Some(GraspResult { status, held, lifted, gap, state, toppled })
    }

    fn step_standing(&self, _: &mut Scratch, job: &PushJob<'_>, stances: &[Stance], stop: &Stop) -> PushResult {
        let mut result = PushResult::default();
        let mut details = vec![BodyDetail::default(); self.scene.len()];
        self.push(job, stances, &mut result, &mut details, stop);
        result
    }
}
