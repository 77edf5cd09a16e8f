//! Whether a target can be grasped: what a network says, held against the geometric test and against grasps tried out.

use std::ops::ControlFlow;
use std::sync::Arc;

use serde::Serialize;

use super::super::shapes::ShapeFamily;
use super::EngineMaker;
use super::targets::{GraspTrialParams, Target, each_target};
use crate::error::Result;
use crate::plan::GraspDecision;
use crate::run::Stop;
use crate::scene::{Scene, State};

/// Bins of the reliability table over [0, 1].
const BINS: usize = 10;

/// How often a yes or no is right.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Agreement {
    pub targets: usize,
    /// Targets for which yes is right, for which yes was said, and for which both hold.
    pub yes: usize,
    pub said: usize,
    pub said_rightly: usize,
    /// Targets for which the right answer was given.
    pub right: usize,
    /// `right / targets`.
    pub accuracy: f64,
    /// `said_rightly / said` and `said_rightly / yes`; 0 where there is none.
    pub precision: f64,
    pub recall: f64,
}

/// The targets to which a network gives a probability of a range.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct ReliabilityBin {
    pub from: f64,
    pub to: f64,
    pub targets: usize,
    /// Mean of the probabilities, and the shares that can be grasped: by the geometric test, and in the engine.
    pub stated: f64,
    pub geometric: f64,
    pub engine: f64,
}

/// A network's answers about the same targets.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ClassifierTrials {
    pub judge: String,
    /// The probability from which on the network says yes.
    pub threshold: f64,
    /// The network against the geometric test: yes is a grasp with a score that planners ask for to execute it.
    pub network: Agreement,
    /// The network against the engine: yes is a grasp, the test's own best or the best of a grasp map's grid, that takes the
    /// target and nothing else. Grasps with a low score are tried as well.
    pub network_in_engine: Agreement,
    /// The geometric test against the engine.
    pub geometric_in_engine: Agreement,
    pub reliability: Vec<ReliabilityBin>,
}

impl Agreement {
    fn add(&mut self, said: bool, yes: bool) {
        self.targets += 1;
        self.yes += usize::from(yes);
        self.said += usize::from(said);
        self.said_rightly += usize::from(said && yes);
        self.right += usize::from(said == yes);
        let share = |part: usize, whole: usize| part as f64 / whole.max(1) as f64;
        self.accuracy = share(self.right, self.targets);
        self.precision = share(self.said_rightly, self.said);
        self.recall = share(self.said_rightly, self.yes);
    }
}

impl ReliabilityBin {
    fn add(&mut self, stated: f64, geometric: bool, engine: bool) {
        self.targets += 1;
        let renew = |mean: &mut f64, value: f64| *mean += (value - *mean) / self.targets as f64;
        renew(&mut self.stated, stated);
        renew(&mut self.geometric, f64::from(u8::from(geometric)));
        renew(&mut self.engine, f64::from(u8::from(engine)));
    }
}

/// Says with what probability a target can be grasped.
pub type StatedProbability<'a> = &'a mut dyn FnMut(&Scene, &State, usize) -> Result<f64>;

/// Holds a network's answers about so many targets against the geometric test and an engine that can grasp. A requested
/// stop ends with what is known by then. `progress` hears the number of targets.
///
/// # Errors
/// [`Error::Argument`](crate::error::Error::Argument) for parameters out of range and for an engine that cannot grasp; what the network fails with.
pub fn try_classifier(
    params: &GraspTrialParams,
    family: &Arc<ShapeFamily>,
    judge: EngineMaker<'_>,
    (network, threshold): (StatedProbability<'_>, f64),
    stop: &Stop,
    progress: &mut dyn FnMut(usize),
) -> Result<ClassifierTrials> {
    let mut trials = ClassifierTrials { threshold, ..ClassifierTrials::default() };
    trials.reliability = (0..BINS)
        .map(|k| ReliabilityBin {
            from: k as f64 / BINS as f64,
            to: (k + 1) as f64 / BINS as f64,
            ..ReliabilityBin::default()
        })
        .collect();
    let executed = GraspDecision::default().execute_score;
    each_target(params, family, judge, stop, &mut |target| {
        let stated = network(target.scene, target.state, target.body)?;
        let geometric = target.assessment.grasp.is_some() && target.assessment.score >= executed;
        let engine = can_be_taken(target, stop)?;
        if stop.requested() {
            return Ok(ControlFlow::Break(()));
        }
        trials.judge = target.engine.name().to_string();
        trials.network.add(stated >= threshold, geometric);
        trials.network_in_engine.add(stated >= threshold, engine);
        trials.geometric_in_engine.add(geometric, engine);
        let bin = ((stated * BINS as f64) as usize).min(BINS - 1);
        trials.reliability[bin].add(stated, geometric, engine);
        progress(trials.network.targets);
        Ok(if trials.network.targets == params.targets { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    })?;
    Ok(trials)
}

/// Whether a grasp that is known takes the target.
fn can_be_taken(target: &mut Target<'_>, stop: &Stop) -> Result<bool> {
    if let Some(own) = target.assessment.grasp
        && target.took(&own, stop)?
    {
        return Ok(true);
    }
    match target.best_of_grid() {
        Some(best) => target.took(&best, stop),
        None => Ok(false),
    }
}
