//! Whether the grasp that a network names holds, where some grasp does.
//!
//! Held-out states and targets as the training data has them. What grasps there are follows from the geometric test on
//! the network's own grid; an engine with a third dimension tries out the network's grasp, the grid's best and the
//! test's own best.

use std::ops::ControlFlow;
use std::sync::Arc;

use serde::Serialize;

use super::super::shapes::ShapeFamily;
use super::EngineMaker;
use super::targets::{GraspTrialParams, each_target};
use crate::action::Grasp;
use crate::error::{Error, Result};
use crate::plan::GraspDecision;
use crate::run::Stop;
use crate::scene::{Scene, State};

/// Grasps of one origin.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct GraspTally {
    /// Targets.
    pub targets: usize,
    /// Of them, those for which a grasp was named.
    pub named: usize,
    /// Grasps that hold by the geometric test.
    pub valid: usize,
    /// Grasps that took the target, and nothing else, in the engine.
    pub succeeded: usize,
    /// `succeeded / targets` and `valid / targets`.
    pub success: f64,
    pub validity: f64,
}

/// Grasps tried out over the same targets.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct GraspTrials {
    pub judge: String,
    /// Targets looked at, and those that some grasp of the grid can take: the others are not counted below.
    pub looked_at: usize,
    pub graspable: usize,
    /// What the network names, the best of the grid, and the best of the geometric test's own search.
    pub network: GraspTally,
    pub grid: GraspTally,
    pub geometric: GraspTally,
    /// What the network names where the grid's best scores at least as much as planners ask for to execute a grasp.
    pub network_where_good: GraspTally,
    /// What the network names where the grid's best succeeded in the engine.
    pub network_where_grid_succeeds: GraspTally,
}

impl GraspTally {
    fn add(&mut self, valid: bool, succeeded: bool, named: bool) {
        self.targets += 1;
        self.named += usize::from(named);
        self.valid += usize::from(valid);
        self.succeeded += usize::from(succeeded);
        self.success = self.succeeded as f64 / self.targets as f64;
        self.validity = self.valid as f64 / self.targets as f64;
    }
}

/// Names the best grasp of a target, good or bad.
pub type NamedGrasp<'a> = &'a mut dyn FnMut(&Scene, &State, usize) -> Result<Option<Grasp>>;

/// Tries out a network's grasps in an engine that can grasp, for so many targets that some grasp of the grid can take. A
/// requested stop ends with what is known by then. `progress` hears the number of targets.
pub fn try_grasps(
    params: &GraspTrialParams,
    family: &Arc<ShapeFamily>,
    judge: EngineMaker<'_>,
    network: NamedGrasp<'_>,
    stop: &Stop,
    progress: &mut dyn FnMut(usize),
) -> Result<GraspTrials> {
    let (mut trials, good) = (GraspTrials::default(), GraspDecision::default().execute_score);
    each_target(params, family, judge, stop, &mut |target| {
        trials.judge = target.engine.name().to_string();
        trials.looked_at += 1;
        let Some(best) = target.best_of_grid() else { return Ok(ControlFlow::Continue(())) };
        let best_took = target.took(&best, stop)?;
        let named = network(target.scene, target.state, target.body)?;
        let own = target.assessment.grasp;
        let mut judged = |grasp: Option<&Grasp>| match grasp {
            Some(grasp) => Ok((target.holds(grasp), target.took(grasp, stop)?)),
            None => Ok::<_, Error>((false, false)),
        };
        let (valid, succeeded) = judged(named.as_ref())?;
        let (own_valid, own_took) = judged(own.as_ref())?;
        if stop.requested() {
            return Ok(ControlFlow::Break(()));
        }
        trials.graspable += 1;
        trials.network.add(valid, succeeded, named.is_some());
        trials.grid.add(true, best_took, true);
        trials.geometric.add(own_valid, own_took, own.is_some());
        if best.score >= good {
            trials.network_where_good.add(valid, succeeded, named.is_some());
        }
        if best_took {
            trials.network_where_grid_succeeds.add(valid, succeeded, named.is_some());
        }
        progress(trials.graspable);
        Ok(if trials.graspable == params.targets { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    })?;
    Ok(trials)
}
