//! Plans as JSON: what jostle_plan_json() writes.

use crate::action::Move;
use crate::plan;
use crate::plan::rearrange::RearrangePlan;

fn reasons(reasons: &[plan::Reason]) -> Vec<plan::WrittenReason> {
    reasons.iter().map(plan::WrittenReason::from).collect()
}

/// A plan of a retrieval or a clearing.
pub(super) fn retrieval(p: &plan::Plan) -> serde_json::Value {
    let steps: Vec<_> = p
        .actions
        .iter()
        .map(|step| {
            let poses: Vec<_> = step.predicted.iter().collect();
            serde_json::json!({ "action": step.action, "value": step.value, "predicted": poses })
        })
        .collect();
    let considered: Vec<_> = p
        .considered
        .iter()
        .map(|r| {
            serde_json::json!({
                "action": r.action, "value": r.value, "best_return": r.best_return, "visits": r.visits,
                "prior": r.prior, "solution_actions": r.solution_level, "success_chance": r.success_chance,
                "expected_actions": r.expected_actions, "predicted": r.predicted.iter().collect::<Vec<_>>(),
            })
        })
        .collect();
    serde_json::json!({
        "planner": p.planner, "seed": p.seed, "outcome": p.outcome, "reasons": reasons(&p.reasons),
        "grasp_score": p.grasp_score,
        "actions": steps, "considered": considered, "statistics": p.statistics,
    })
}

fn move_json(action: &Move) -> serde_json::Value {
    let kind = if matches!(action, Move::Drag { .. }) { "drag" } else { "pick_place" };
    serde_json::json!({ "kind": kind, "body": action.body(), "poses": action.poses() })
}

/// A plan of a rearrangement.
pub(super) fn rearrangement(p: &RearrangePlan) -> serde_json::Value {
    let steps: Vec<_> = p
        .moves
        .iter()
        .map(|step| {
            let poses: Vec<_> = step.predicted.iter().collect();
            serde_json::json!({ "action": move_json(&step.action), "value": step.value, "predicted": poses })
        })
        .collect();
    let considered: Vec<_> = p
        .considered
        .iter()
        .map(|r| {
            serde_json::json!({
                "action": move_json(&r.action), "value": r.value, "best_return": r.best_return, "visits": r.visits,
                "prior": r.prior, "solution_actions": r.solution_level,
            })
        })
        .collect();
    serde_json::json!({
        "planner": p.planner, "seed": p.seed, "outcome": p.outcome, "reasons": reasons(&p.reasons),
        "cost": p.cost, "robot_seconds": p.robot_seconds,
        "actions": steps, "considered": considered, "statistics": p.statistics,
    })
}
