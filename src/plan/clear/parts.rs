//! What a planner of clearings is made of, prepared for a scene.

use std::any::Any;
use std::sync::Arc;

use super::greedy::Recipe;
use super::networks::ClearNetworks;
use super::options::ClearOptions;
use crate::action::{ContourSampler, PushSampler};
use crate::error::Result;
use crate::grasp::{GeometricScorer, GraspAssessment, Scorer};
use crate::physics::{PushResult, Scratch as EngineScratch, Transition};
use crate::run::Stop;
use crate::scene::{Mask, Scene, State};

/// The parts behind the interfaces: a planner with networks has the same with others in their places.
pub struct ClearParts {
    pub scene: Arc<Scene>,
    /// Predicts what a push does to every body: an engine, or DIPN.
    pub engine: Arc<dyn Transition>,
    /// In which the best pushes are tried before the decision.
    pub confirming: Option<Arc<dyn Transition>>,
    pub sampler: Box<dyn PushSampler>,
    /// Says whether a body can be grasped: the geometric test, or a grasp network.
    pub scorer: Box<dyn Scorer>,
}

/// Working memory of one worker.
pub(super) struct Scratch {
    pub engine: EngineScratch,
    pub confirming: Option<EngineScratch>,
    pub scorer: Box<dyn Any + Send>,
    pub results: Vec<PushResult>,
    /// A state that bodies are taken from.
    pub state: State,
    /// For every body of every state of a group.
    pub found: Vec<GraspAssessment>,
}

impl ClearParts {
    pub(super) fn of_recipe(
        options: &ClearOptions,
        recipe: &Recipe,
        networks: &ClearNetworks,
        scene: &Arc<Scene>,
    ) -> Result<ClearParts> {
        Ok(ClearParts {
            scene: Arc::clone(scene),
            engine: networks.engine(&recipe.physics, scene)?,
            confirming: recipe.confirm.as_ref().map(|p| networks.confirming(p, scene)).transpose()?,
            sampler: Box::new(sampler(options, recipe)?.prepared(scene)),
            scorer: match networks.scorer(&recipe.scorer, scene)? {
                Some(learned) => learned,
                None => Box::new(GeometricScorer::new(scene, recipe.grasp.clone())?),
            },
        })
    }

    pub(super) fn new_scratch(&self) -> Scratch {
        Scratch {
            engine: self.engine.scratch(),
            confirming: self.confirming.as_ref().map(|engine| engine.scratch()),
            scorer: self.scorer.scratch(),
            results: Vec::new(),
            state: State::default(),
            found: Vec::new(),
        }
    }

    /// The bodies that are to be taken from a state.
    pub(super) fn remaining(&self, state: &State) -> Mask {
        let mut remaining = Mask::EMPTY;
        state.iter().filter(|(i, _)| self.scene.body(*i).pickable).for_each(|(i, _)| remaining.insert(i));
        remaining
    }

    /// Assesses every body of `which` in every state: `found[body * states + k]` is of state `k`. The others' entries
    /// are empty, and with a requested stop the rest's. Bodies come one after the other, each with all states at once, as
    /// networks want it.
    pub(super) fn assess_all(
        &self,
        scorer: &mut (dyn Any + Send),
        states: &[&State],
        which: Mask,
        found: &mut Vec<GraspAssessment>,
        stop: &Stop,
    ) {
        found.clear();
        found.resize(self.scene.len() * states.len(), GraspAssessment::default());
        for body in which.iter().filter(|&body| body < self.scene.len()) {
            let out = &mut found[body * states.len()..(body + 1) * states.len()];
            if stop.requested() {
                return;
            }
            self.scorer.assess(scorer, &self.scene, states, body, out, stop);
        }
    }

    /// Assesses one body in one state; nothing can be grasped where the stop is requested.
    pub(super) fn assess(
        &self,
        scorer: &mut (dyn Any + Send),
        state: &State,
        body: usize,
        stop: &Stop,
    ) -> GraspAssessment {
        let mut out = [GraspAssessment::default()];
        self.scorer.assess(scorer, &self.scene, &[state], body, &mut out, stop);
        out[0]
    }

    /// Whether a grasp of `body` can depend on where `other` is: no part of a jaw that closes on the body reaches
    /// farther than this says.
    pub(super) fn near(&self, state: &State, body: usize, other: usize) -> bool {
        let grasper = &self.scene.gripper().grasp;
        let jaw = grasper.opening + grasper.finger_thickness + grasper.finger_width + 4.0 * grasper.finger_clearance;
        let reach = 1.5 * self.scene.body(body).footprint.radius + self.scene.body(other).footprint.radius + jaw;
        (state.pose(body).position() - state.pose(other).position()).norm_squared() < reach * reach
    }
}

pub(super) fn sampler(options: &ClearOptions, recipe: &Recipe) -> Result<ContourSampler> {
    let sampler = match &options.sampler_params {
        Some(params) => ContourSampler::new("custom", params.clone())?,
        None => ContourSampler::preset(options.sampler.as_deref().unwrap_or(recipe.sampler))?,
    };
    match options.push_length {
        Some(length) => sampler.with_length(length),
        None => Ok(sampler),
    }
}
