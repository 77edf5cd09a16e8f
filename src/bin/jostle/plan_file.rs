//! A plan as a JSON document: the problem it was made for, what to do, what is expected of it.

use jostle::action::Action;
use jostle::geom::Pose2;
use jostle::plan::{Outcome as PlanOutcome, Plan, PlanStatistics, PlannedAction, RankedAction, WrittenReason};
use jostle::scene::{AnyProblem, State};
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

    /// Whether a JSON document is a plan; a scene otherwise.
    pub fn is_plan(document: &Value) -> bool {
        document.get("plan_version").is_some()
    }

    /// The problem and the plan again.
    pub fn read(document: Value) -> Outcome<(AnyProblem, Plan)> {
        if document["plan_version"] != VERSION {
            return Err(Failure::usage(format!(
                "plan_version: is {}; this tool reads {VERSION}",
                document["plan_version"]
            )));
        }
        let file: PlanFile = serde_json::from_value(document).map_err(|e| Failure::usage(e.to_string()))?;
        let problem = AnyProblem::from_json(&file.problem.to_string())?;
        let step = |(i, step): (usize, &Step)| -> Outcome<PlannedAction> {
            let predicted =
                after(&problem, &step.predicted).map_err(|e| e.within(&format!("actions[{i}].predicted")))?;
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
