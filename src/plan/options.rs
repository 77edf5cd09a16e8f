//! What can be asked of a planner. Every field has a default; errors name the field.

use serde::{Deserialize, Serialize};

use super::recipe::recipe;
use crate::action::SamplerParams;
use crate::error::{Result, check_range};
use crate::physics::PhysicsOptions;
use crate::run::Budget;
use crate::search::Params;

/// When a grasp is executed and when a state counts as solved, by the grasp's score in [0, 1].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GraspDecision {
    /// An observed state whose best grasp scores at least this is grasped (the originals' 0.75-0.8 of a network); one
    /// that counts as a solution is grasped as well.
    pub execute_score: f64,
    /// A simulated state whose best grasp scores at least this is a solution.
    pub solved_score: f64,
}

impl Default for GraspDecision {
    fn default() -> Self {
        Self { execute_score: 0.3, solved_score: 0.5 }
    }
}

/// Everything a planner can be told.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannerOptions {
    /// One of [`super::PLANNERS`].
    pub planner: String,
    pub physics: PhysicsOptions,
    /// Name of a push sampler; the planner's own if absent.
    pub sampler: Option<String>,
    /// Every parameter of the push sampler; takes the place of the named one.
    pub sampler_params: Option<SamplerParams>,
    /// Travel of a push, metres; the sampler's own if absent.
    pub push_length: Option<f64>,
    pub grasp: GraspDecision,
    /// Limits of one decision. Without iterations and seconds the planner's published budget is used.
    pub budget: Budget,
    pub seed: u64,
    /// Physical threads; 0 or 1 runs on the caller. Never changes a plan made within an iteration budget.
    pub threads: usize,
    /// Logical lanes of a parallel search; the planner's own if absent. Changes plans.
    pub lanes: Option<usize>,
    /// Greatest number of pushes in a plan; the planner's own if absent.
    pub max_depth: Option<u32>,
    /// Which form of the planner.
    pub variant: Variant,
    /// Every parameter of the search; takes the place of the planner's own, of `lanes` and of `max_depth`.
    /// Start from [`PlannerOptions::search_params`].
    pub search: Option<Params>,
}

/// Which form of a planner: text and published code of the dissertation disagree, and both can be bettered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Variant {
    /// The published parameters with what measures better here; the planner's page says what. The default.
    #[default]
    Tuned,
    /// As the text says.
    Dissertation,
    /// As the published code does.
    Code,
}

impl Default for PlannerOptions {
    fn default() -> Self {
        Self {
            planner: "pmbs".into(),
            physics: PhysicsOptions::default(),
            sampler: None,
            sampler_params: None,
            push_length: None,
            grasp: GraspDecision::default(),
            budget: Budget::default(),
            seed: 0,
            threads: 0,
            lanes: None,
            max_depth: None,
            variant: Variant::Tuned,
            search: None,
        }
    }
}

impl PlannerOptions {
    /// The parameters of the search that these options lead to.
    pub fn search_params(&self) -> Result<Params> {
        Ok(recipe(self)?.search)
    }

    /// Checks what can be checked without a scene.
    pub fn validate(&self) -> Result<()> {
        self.physics.validate()?;
        self.budget.validate()?;
        check_range("grasp.execute_score", self.grasp.execute_score, 0.0..=1.0)?;
        check_range("grasp.solved_score", self.grasp.solved_score, 0.0..=1.0)?;
        if let Some(length) = self.push_length {
            check_range("push_length", length, 0.005..=0.5)?;
        }
        if let Some(lanes) = self.lanes {
            check_range("lanes", lanes as f64, 1.0..=65536.0)?;
        }
        if let Some(depth) = self.max_depth {
            check_range("max_depth", f64::from(depth), 1.0..=64.0)?;
        }
        check_range("threads", self.threads as f64, 0.0..=1024.0)?;
        recipe(self).map(drop)
    }
}
