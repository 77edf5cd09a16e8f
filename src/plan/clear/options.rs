//! What can be asked of a planner of clearings. Every field has a default; errors name the field.

use serde::{Deserialize, Serialize};

use super::greedy::{Recipe, recipe};
use crate::action::SamplerParams;
use crate::bounds;
use crate::error::{Error, Result, check_range};
use crate::grasp::check_scorer;
use crate::net::Model;
use crate::physics::{PhysicsOptions, Purpose};
use crate::plan::{Confirm, GraspDecision, PlannerOptions, Variant};
use crate::run::Budget;
use crate::scene::Gripper;

/// Planners of clearings, by id: ours, the same decision by two networks, and two baselines, one that pushes at random
/// where no grasp is good enough, and one that never pushes.
pub const CLEAR_PLANNERS: [&str; 4] = ["greedy", "dipn_gn", "random_push", "grasp_only"];

/// Where the pushes of a decision come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PushChoice {
    /// The one that promises most.
    Judged,
    /// Any legal one, without a look at what it does.
    Random,
    /// There are none.
    Never,
}

/// What the state after a push is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PushWorth {
    /// The mean over the bodies of the best grasp's score (the dissertation's mean grasp reward).
    MeanReward,
    /// How many bodies can be taken one after the other before the next push; of equals, how near the others are to it.
    Freed,
}

/// How a decision is made. [`ClearOptions::own_rule`] has the planner's own. Lengths are those for the published gripper
/// and grow with it ([`crate::scene::Gripper::scale`]).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClearRule {
    pub choice: PushChoice,
    pub worth: PushWorth,
    /// A grasp that scores at least this is executed without a look at pushes (dissertation: 0.7).
    pub direct_score: f64,
    /// Discount of what comes after a push, gamma (dissertation: 0.9).
    pub discount: f64,
    /// The discount holds only where the best grasp now scores at least this (published code: 0.5; else 0).
    pub discount_from: f64,
    /// A push has to raise the greatest score too (published code).
    pub raises_best: bool,
    /// A grasp below the score that is executed is tried all the same where no push frees a body, if it scores at least
    /// this.
    pub last_resort: f64,
    /// Pushes of these shares of the sampler's length are tried, each as a push of its own.
    pub lengths: Vec<f64>,
    /// A push may bring no body nearer to the workspace's edge than this, metres (one that is nearer may move inwards).
    pub edge: f64,
    /// So many of the best pushes are tried in the confirming engine, if there is one,
    pub confirm_pushes: usize,
    /// each in so many worlds: the observed one, and others that differ by the noise of a camera,
    pub confirm_worlds: usize,
    /// whose standard deviations are metres
    pub noise_position: f64,
    /// and radians.
    pub noise_rotation: f64,
}

impl ClearRule {
    /// Checks every field; errors name it.
    pub fn validate(&self) -> Result<()> {
        check_range("rule.direct_score", self.direct_score, 0.0..=1.0)?;
        check_range("rule.discount", self.discount, 0.0..=1.0)?;
        check_range("rule.discount_from", self.discount_from, 0.0..=1.0)?;
        check_range("rule.last_resort", self.last_resort, 0.0..=1.0)?;
        if self.lengths.is_empty() {
            return Err(Error::argument("rule.lengths", "is empty; give at least the share 1"));
        }
        for (i, share) in self.lengths.iter().enumerate() {
            check_range(&format!("rule.lengths[{i}]"), *share, 0.05..=1.0)?;
        }
        check_range("rule.edge", self.edge, 0.0..=1.0)?;
        check_range("rule.confirm_pushes", self.confirm_pushes as f64, 0.0..=1000.0)?;
        check_range("rule.confirm_worlds", self.confirm_worlds as f64, 1.0..=64.0)?;
        check_range("rule.noise_position", self.noise_position, 0.0..=0.02)?;
        check_range("rule.noise_rotation", self.noise_rotation, 0.0..=0.5)
    }
}

/// Everything a planner of clearings can be told.
#[derive(Debug, Clone, PartialEq)]
pub struct ClearOptions {
    /// One of [`CLEAR_PLANNERS`].
    pub planner: String,
    pub variant: Variant,
    /// Engine that predicts pushes; the planner's own if absent.
    pub physics: Option<PhysicsOptions>,
    /// Engine in which the best pushes are tried before the decision.
    pub confirm: Confirm,
    /// Name of a push sampler; the planner's own if absent.
    pub sampler: Option<String>,
    /// Every parameter of the push sampler; takes the place of the named one.
    pub sampler_params: Option<SamplerParams>,
    /// Travel of a push, metres; the sampler's own if absent.
    pub push_length: Option<f64>,
    /// When a grasp is executed (tuned form and baselines), and from which score on a body counts as one that can be
    /// taken after a push.
    pub grasp: GraspDecision,
    /// What says whether a body can be grasped: one of [`crate::grasp::SCORERS`]; the planner's own if absent.
    pub scorer: Option<String>,
    /// The scorer's network; the built-in one of the scorer's name if absent.
    pub scorer_model: Option<Model>,
    /// The network of the engine `dipn`; the one that its preset names if absent.
    pub engine_model: Option<Model>,
    /// The gripper of the scenes that will come: the networks are held to it when the planner is made. Absent: to each scene's
    /// own when it comes, as they are in any case.
    pub gripper: Option<Gripper>,
    /// Limits of one decision: an iteration is one push simulated and judged. Without limits all that are sampled are.
    pub budget: Budget,
    pub seed: u64,
    /// Physical threads; 0 or 1 runs on the caller. Never changes a plan made within an iteration budget.
    pub threads: usize,
    /// Takes the place of the planner's own rule.
    pub rule: Option<ClearRule>,
}

impl Default for ClearOptions {
    fn default() -> Self {
        ClearOptions {
            planner: "greedy".into(),
            variant: Variant::Tuned,
            physics: None,
            confirm: Confirm::Own,
            sampler: None,
            sampler_params: None,
            push_length: None,
            grasp: GraspDecision::default(),
            scorer: None,
            scorer_model: None,
            engine_model: None,
            gripper: None,
            budget: Budget::default(),
            seed: 0,
            threads: 0,
            rule: None,
        }
    }
}

impl ClearOptions {
    /// What options for any planner say to one of clearings.
    pub fn of(options: PlannerOptions) -> ClearOptions {
        ClearOptions {
            planner: options.planner,
            variant: options.variant,
            physics: options.physics,
            confirm: options.confirm,
            sampler: options.sampler,
            sampler_params: options.sampler_params,
            push_length: options.push_length,
            grasp: options.grasp,
            scorer: options.scorer,
            scorer_model: options.scorer_model,
            engine_model: options.engine_model,
            gripper: options.gripper,
            budget: options.budget,
            seed: options.seed,
            threads: options.threads,
            rule: None,
        }
    }

    /// The rule that these options lead to.
    pub fn own_rule(&self) -> Result<ClearRule> {
        Ok(recipe(self)?.rule)
    }

    /// The engine of the planner's model: the one asked for, or the planner's own.
    pub fn model(&self) -> Result<PhysicsOptions> {
        Ok(recipe(self)?.physics)
    }

    /// The engine that the best pushes are tried in, if they are.
    pub fn confirmed_in(&self) -> Result<Option<PhysicsOptions>> {
        Ok(recipe(self)?.confirm)
    }

    /// What says whether a body can be grasped.
    pub fn scored_by(&self) -> Result<String> {
        Ok(recipe(self)?.scorer)
    }

    /// Sets the engine by name; what is absent is the planner's own, or what suits planning.
    pub fn set_physics(&mut self, engine: Option<&str>, preset: Option<&str>) -> Result<()> {
        self.physics = None;
        if engine.is_some() || preset.is_some() {
            let own = self.model()?.engine;
            self.physics = Some(PhysicsOptions::named(engine.unwrap_or(&own), preset, Purpose::Planning)?);
        }
        Ok(())
    }

    /// Checks what can be checked without a scene.
    pub fn validate(&self) -> Result<()> {
        if let Some(physics) = &self.physics {
            physics.validate()?;
        }
        if let Confirm::With(physics) = &self.confirm {
            physics.validate().map_err(|e| e.within("confirm"))?;
        }
        if let Some(gripper) = &self.gripper {
            gripper.validate()?;
        }
        self.budget.validate()?;
        check_range("grasp.execute_score", self.grasp.execute_score, 0.0..=1.0)?;
        check_range("grasp.solved_score", self.grasp.solved_score, 0.0..=1.0)?;
        if let Some(length) = self.push_length {
            bounds::PUSH_LENGTH.check("push_length", length)?;
        }
        check_range("threads", self.threads as f64, 0.0..=1024.0)?;
        let Recipe { rule, scorer, .. } = recipe(self)?;
        check_scorer(&scorer)?;
        rule.validate()
    }
}
