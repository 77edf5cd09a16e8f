//! Stand-ins for engines in tests.

use std::sync::Arc;

use crate::geom::Pose2;
use crate::physics::{PushJob, PushResult, PushStatus, Scratch, Transition};
use crate::run::Stop;
use crate::scene::{Mask, Scene};

/// An engine in which every push moves the first body by the same offset.
pub struct Slide {
    pub scene: Arc<Scene>,
    pub offset: Pose2,
}

impl Transition for Slide {
    fn name(&self) -> &str {
        "slide"
    }

    fn scene(&self) -> &Scene {
        &self.scene
    }

    fn scratch(&self) -> Scratch {
        Box::new(())
    }

    fn step_batch(&self, _: &mut Scratch, jobs: &[PushJob<'_>], results: &mut [PushResult], _: &Stop) {
        for (job, result) in jobs.iter().zip(results) {
            *result =
                PushResult { status: PushStatus::Executed, state: job.state.clone(), touched: Mask(1), left: Mask(0) };
            let p = job.state.pose(0);
            let o = self.offset;
            result.state.set_pose(0, Pose2::new(p.x + o.x, p.y + o.y, p.theta + o.theta));
        }
    }
}
