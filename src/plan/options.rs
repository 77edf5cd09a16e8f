//! What can be asked of a planner. Every field has a default; errors name the field.

use serde::{Deserialize, Serialize};

use super::hedge;
use super::recipe::recipe;
use crate::action::SamplerParams;
use crate::bounds;
use crate::error::{Error, Result, check_range};
use crate::grasp::check_scorer;
use crate::net::Model;
use crate::physics::{PhysicsOptions, Purpose};
use crate::run::Budget;
use crate::scene::Gripper;
use crate::search::{EarlyStop, Params};

/// When a grasp is executed and when a state counts as solved, by the grasp's score in [0, 1].
///
/// For a gripper whose score is the chance that it keeps the body ([`crate::scene::Keeping`]) the default stands for
/// [`GraspDecision::kept`]: these numbers are made for a judgement by the shape of the grip.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GraspDecision {
    /// An observed state whose best grasp scores at least this is grasped (the originals' 0.75-0.8 of a network); one
    /// that counts as a solution is grasped as well.
    pub execute_score: f64,
    /// A simulated state whose best grasp scores at least this is a solution.
    pub solved_score: f64,
}

/// A chance of keeping from which on a grasp is as good as done: a body that is lost costs a look and a grasp at least, and
/// every other one falls where no grasp finds it again.
const KEPT: f64 = 0.95;
/// A body that no grasp keeps so surely is grasped from so much below the best chance that it has anywhere: a push for less
/// costs more than it gains.
const BELOW_BEST: f64 = 0.05;

impl GraspDecision {
    /// For a score that is the chance of keeping, and a body whose grasps score up to `greatest`.
    pub fn kept(greatest: f64) -> GraspDecision {
        let enough = KEPT.min((greatest - BELOW_BEST).max(0.0));
        GraspDecision { execute_score: enough, solved_score: enough }
    }
}

impl Default for GraspDecision {
    fn default() -> Self {
        Self { execute_score: 0.3, solved_score: 0.35 }
    }
}

/// Everything a planner can be told.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannerOptions {
    /// One of [`super::PLANNERS`].
    pub planner: String,
    /// Engine that predicts pushes; the planner's own if absent.
    pub physics: Option<PhysicsOptions>,
    /// Engine in which the plan found and its best rivals are tried before the decision.
    pub confirm: Confirm,
    /// Name of a push sampler; the planner's own if absent.
    pub sampler: Option<String>,
    /// Every parameter of the push sampler; takes the place of the named one.
    pub sampler_params: Option<SamplerParams>,
    /// Travel of a push, metres; the sampler's own if absent.
    pub push_length: Option<f64>,
    pub grasp: GraspDecision,
    /// What says how good a state is: one of [`crate::grasp::SCORERS`]; the planner's own if absent.
    pub scorer: Option<String>,
    /// The scorer's network; the built-in one of the scorer's name if absent.
    pub scorer_model: Option<Model>,
    /// The network of the engine `dipn`; the one that its preset names if absent.
    pub engine_model: Option<Model>,
    /// What values pushes before they are tried: `ppn`, a network, or `none`; the planner's own if absent.
    pub prior: Option<String>,
    /// The network that values pushes; the built-in one if absent.
    pub prior_model: Option<Model>,
    /// The gripper of the scenes that will come: the networks are held to it when the planner is made. Absent: to each scene's
    /// own when it comes, as they are in any case.
    pub gripper: Option<Gripper>,
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

/// Whether plans are tried in a second engine, a more faithful one than the search can afford.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Confirm {
    /// As the planner does by itself. The default.
    #[default]
    Own,
    /// They are not.
    Off,
    /// They are, in this engine.
    With(PhysicsOptions),
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
            planner: "hedge".into(),
            physics: None,
            confirm: Confirm::Own,
            sampler: None,
            sampler_params: None,
            push_length: None,
            grasp: GraspDecision::default(),
            scorer: None,
            scorer_model: None,
            engine_model: None,
            prior: None,
            prior_model: None,
            gripper: None,
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

    /// The same action set and model, and nothing but a search of every plan of at most `pushes` pushes, which ends with
    /// the first that frees the target. Answers whether there is one: see `PlanStatistics::no_plan_within`.
    pub fn search_only(&self, pushes: u32) -> Result<PlannerOptions> {
        let own = recipe(self)?;
        let search = Params {
            early_stop: EarlyStop::LevelComplete { first: pushes, last: Some(pushes) },
            min_iterations: 0,
            ..hedge::level(&Params { max_depth: pushes, ..own.search }, pushes)
        };
        Ok(PlannerOptions {
            planner: "pmbs".into(),
            physics: Some(own.physics),
            confirm: Confirm::Off,
            sampler: self.sampler.clone().or_else(|| Some(own.sampler.into())),
            budget: Budget::iterations(u64::from(u32::MAX)),
            search: Some(search),
            ..self.clone()
        })
    }

    /// Sets the engine by name. An engine without a preset gets the one that suits planning; a preset without an engine is
    /// one of the planner's own engine; with neither the planner's own engine and preset are used.
    pub fn set_physics(&mut self, engine: Option<&str>, preset: Option<&str>) -> Result<()> {
        self.physics = None;
        let own = || Ok(self.model()?.engine);
        self.physics = match (engine, preset) {
            (None, None) => None,
            (Some(engine), preset) => Some(PhysicsOptions::named(engine, preset, Purpose::Planning)?),
            (None, preset) => Some(PhysicsOptions::named(&own()?, preset, Purpose::Planning)?),
        };
        Ok(())
    }

    /// Sets the confirming engine by name: `none`, an engine, or `ENGINE:PRESET`; the planner's own choice if absent.
    pub fn set_confirm(&mut self, engine: Option<&str>) -> Result<()> {
        self.confirm = match engine {
            None => Confirm::Own,
            Some("none") => Confirm::Off,
            Some(engine) => {
                let physics = PhysicsOptions::parse(engine, Purpose::Judging).map_err(|e| e.within("confirm"))?;
                Confirm::With(physics)
            }
        };
        Ok(())
    }

    /// The engine of the planner's model: the one asked for, or the planner's own.
    pub fn model(&self) -> Result<PhysicsOptions> {
        Ok(recipe(self)?.physics)
    }

    /// The engine that plans are confirmed in, if they are.
    pub fn confirmed_in(&self) -> Result<Option<PhysicsOptions>> {
        Ok(recipe(self)?.confirm)
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
        if let Some(lanes) = self.lanes {
            check_range("lanes", lanes as f64, 1.0..=65536.0)?;
        }
        if let Some(depth) = self.max_depth {
            check_range("max_depth", f64::from(depth), 1.0..=64.0)?;
        }
        check_range("threads", self.threads as f64, 0.0..=1024.0)?;
        let scorer = recipe(self)?.scorer;
        check_scorer(&scorer)?;
        if self.scorer_model.is_some() && scorer == "geometric" {
            return Err(Error::argument("scorer_model", "is given, but the scorer `geometric` has no network"));
        }
        Ok(())
    }
}
