//! A plan as a JSON document: the problem it was made for, what to do, what is expected of it.

use jostle::Error;
use jostle::action::Action;
use jostle::files::json;
use jostle::geom::Pose2;
use jostle::plan::{Outcome as PlanOutcome, Plan, PlanStatistics, PlannedAction, RankedAction, WrittenReason};
use jostle::scene::{AnyProblem, Input, State};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::output::{Failure, Outcome};

/// The version of the document that this tool writes, and the only one it reads.
const VERSION: u64 = 1;

/// The document. Field `plan_version` tells it from a scene file.
#[derive(Debug, Serialize, Deserialize)]
pub struct PlanFile {
    pub plan_version: u64,
    pub planner: String,
    pub seed: u64,
    pub outcome: PlanOutcome,
    #[serde(default)]
    pub reasons: Vec<WrittenReason>,
    /// A scene file's object.
    pub problem: Value,
    pub actions: Vec<Step>,
    pub grasp_score: f64,
    /// Equal for equal plans, bit for bit.
    pub hash: String,
    pub statistics: PlanStatistics,
    #[serde(default)]
    pub considered: Vec<Considered>,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct Step {
    #[serde(flatten)]
    pub action: Action,
    pub value: f64,
    /// A pose for each body, null for one that is not there.
    pub predicted: Value,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct Considered {
    #[serde(flatten)]
    pub action: Action,
    pub value: f64,
    pub best_return: f64,
    pub visits: u64,
    pub prior: f64,
    pub solution_level: Option<u32>,
    #[serde(default)]
    pub success_chance: Option<f64>,
    #[serde(default)]
    pub expected_actions: Option<f64>,
    /// A pose for each body in the search's model; absent in older files.
    #[serde(default)]
    pub predicted: Value,
}

fn parsed(text: &str) -> Outcome<Value> {
    serde_json::from_str(text).map_err(|e| Failure::failed(format!("the library's JSON: {e}")))
}

fn poses(state: &State) -> Outcome<Value> {
    parsed(&state.to_json()?)
}

impl PlanFile {
    /// `problem` is the text of its scene file.
    pub fn new(problem: &str, plan: &Plan) -> Outcome<PlanFile> {
        let step = |a: &PlannedAction| -> Outcome<Step> {
            Ok(Step { action: a.action, value: a.value, predicted: poses(&a.predicted)? })
        };
        let considered = |a: &RankedAction| -> Outcome<Considered> {
            Ok(Considered {
                action: a.action,
                value: a.value,
                best_return: a.best_return,
                visits: a.visits,
                prior: a.prior,
                solution_level: a.solution_level,
                success_chance: a.success_chance,
                expected_actions: a.expected_actions,
                predicted: poses(&a.predicted)?,
            })
        };
        Ok(PlanFile {
            plan_version: VERSION,
            planner: plan.planner.clone(),
            seed: plan.seed,
            outcome: plan.outcome,
            reasons: plan.reasons.iter().map(WrittenReason::from).collect(),
            problem: parsed(problem)?,
            actions: plan.actions.iter().map(step).collect::<Outcome<_>>()?,
            grasp_score: plan.grasp_score,
            hash: format!("{:016x}", plan.hash_bits()),
            statistics: plan.statistics,
            considered: plan.considered.iter().map(considered).collect::<Outcome<_>>()?,
        })
    }

    /// The problem and the plan again.
    pub fn read(input: &Input) -> Outcome<(AnyProblem, Plan)> {
        check_version(input, "plan_version", VERSION)?;
        let file: PlanFile = json::parse(&input.text, "plan").map_err(|e| input.error(e))?;
        let placed = |error: Error| input.error(json::located(&input.text, error));
        let problem = AnyProblem::from_json(&file.problem.to_string()).map_err(|e| placed(e.within("problem")))?;
        let step = |(i, step): (usize, &Step)| -> Outcome<PlannedAction> {
            let field = format!("actions[{i}]");
            step.action.validate().map_err(|e| placed(e.within(&field)))?;
            let predicted =
                after(&problem, &step.predicted).map_err(|e| placed(e.within(&format!("{field}.predicted"))))?;
            Ok(PlannedAction { action: step.action, predicted, value: step.value })
        };
        let actions = file.actions.iter().enumerate().map(step).collect::<Outcome<_>>()?;
        let considered = file.considered.iter().map(|a| RankedAction {
            action: a.action,
            value: a.value,
            best_return: a.best_return,
            visits: a.visits,
            prior: a.prior,
            solution_level: a.solution_level,
            success_chance: a.success_chance,
            expected_actions: a.expected_actions,
            predicted: after(&problem, &a.predicted).unwrap_or_default(),
        });
        let plan = Plan {
            outcome: file.outcome,
            reasons: file.reasons.into_iter().map(|written| written.reason).collect(),
            actions,
            grasp_score: file.grasp_score,
            considered: considered.collect(),
            statistics: file.statistics,
            planner: file.planner,
            seed: file.seed,
        };
        Ok((problem, plan))
    }
}

/// Refuses a plan's file of another version.
pub fn check_version(input: &Input, key: &str, wanted: u64) -> Outcome<()> {
    let document: Value = json::parse(&input.text, "plan").map_err(|e| input.error(e))?;
    if document[key] != wanted {
        let error = Error::argument(key, format!("is {}; this tool reads {wanted}", document[key]));
        return Err(input.error(json::located(&input.text, error)).into());
    }
    Ok(())
}

/// The state of a problem with these poses: `null` for a body that is gone.
fn after(problem: &AnyProblem, predicted: &Value) -> jostle::Result<State> {
    let (scene, before) = match problem {
        AnyProblem::Retrieval(problem) => (&problem.scene, &problem.state),
        AnyProblem::Clearing(problem) => (&problem.scene, &problem.state),
        AnyProblem::Rearrangement(problem) => (&problem.scene, &problem.start),
    };
    let poses: Vec<Option<Pose2>> =
        serde_json::from_value(predicted.clone()).map_err(|e| jostle::Error::argument("poses", e.to_string()))?;
    if poses.len() != scene.len() {
        let reason = format!("has {} poses for {} bodies; give one for each", poses.len(), scene.len());
        return Err(jostle::Error::argument("poses", reason));
    }
    let mut state = before.clone();
    for (i, pose) in poses.iter().enumerate() {
        state.set_present(i, pose.is_some());
        if let Some(pose) = pose {
            state.set_pose(i, *pose);
        }
    }
    scene.check_state(&state)?;
    Ok(state)
}
