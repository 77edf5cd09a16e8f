//! Whether a body certainly cannot be brought to where it is wanted: the certificate that makes a problem infeasible.

use std::f64::consts::PI;

use super::planner::{PathPlanner, PathScratch};
use super::reach::Cells;
use super::sweep::is_inside;
use crate::geom::{Pose2, Vec2};
use crate::run::Stop;
use crate::scene::State;

/// Poses that serve: those near one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Region {
    pub pose: Pose2,
    /// Greatest distance of the body's origin, metres, and of its heading, radians.
    pub position: f64,
    pub heading: f64,
}

/// What is known of a body's way to some regions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Enclosure {
    /// Nothing: there may be a way. So too if the work was asked to end.
    Unknown,
    /// Certainly no drag begins: it stands too near to another body, or over the workspace's edge.
    Stuck,
    /// Certainly there is no way.
    Enclosed,
}

impl PathPlanner {
    /// Whether a body can certainly not be brought from where it stands into any of the regions by any number of drags,
    /// if the other bodies of `state` stay where they are. Places to stop at keep the clearance or lie in a region.
    pub fn enclosure(
        &self,
        state: &State,
        body: usize,
        regions: &[Region],
        stop: &Stop,
        scratch: &mut PathScratch,
    ) -> Enclosure {
        let (shape, workspace) = (self.shape(body), self.scene().workspace());
        let from = state.pose(body);
        self.place(state, body, scratch);
        let PathScratch { obstacles, reach, .. } = scratch;
        if !is_inside(shape, workspace, &from) || !obstacles.keep_as_at(shape, self.params().clearance, [&from, &from])
        {
            return Enclosure::Stuck;
        }
        // How far a point of the body may be from where it is at the region's middle.
        let displacement = |region: &Region| region.position + shape.radius * region.heading.min(PI);
        regions.iter().for_each(|region| obstacles.keep_as_near(shape, &region.pose, displacement(region)));
        // Where the straight way is free no map is needed.
        if regions.iter().any(|region| self.world(body, obstacles).is_free(&from, &region.pose)) {
            return Enclosure::Unknown;
        }
        let made = reach.make(Cells::NotBlocked, shape, obstacles, workspace, self.fitted(body), &from, Some(stop));
        let origin = Pose2::IDENTITY.position();
        let may = |region: &Region| {
            let middle: Vec2 = region.pose.transform_point(shape.middle);
            let half = region.position + (shape.middle - origin).norm() * region.heading.min(PI);
            reach.holds_near(middle, half, region.pose.theta, region.heading)
        };
        if made && !regions.iter().any(may) { Enclosure::Enclosed } else { Enclosure::Unknown }
    }
}
