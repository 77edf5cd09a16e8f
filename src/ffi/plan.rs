//! Plans: what a planner answered.

use std::ffi::c_char;
use std::sync::Arc;

use super::abi::{Sized32, fill, fill_text, init_sized, jostle_body_pose, jostle_pose2, out, write_sized};
use super::action::{c_action, c_move, jostle_action};
use super::guard::{free, guard};
use super::handle::{Kind, Object};
use super::log::Log;
use super::plan_json;
use super::scene::Bodies;
use super::status::{Failure, JOSTLE_ERROR_NOT_FOUND, Outcome, jostle_status};
use crate::error::Error;
use crate::plan;
use crate::plan::rearrange::RearrangePlan;
use crate::scene::State;

/// The answer of a planner. It never changes. Opaque.
pub struct jostle_plan(());

/// How a decision ended: one of the JOSTLE_OUTCOME_ values. None of them is an error.
pub type jostle_outcome = i32;
/// The plan ends with the target grasped, or with every body at its goal, in the planner's model.
pub const JOSTLE_OUTCOME_SOLVED: jostle_outcome = 1;
/// The search ended by itself without a grasp, or short of the goals; the plan holds the best actions found.
pub const JOSTLE_OUTCOME_PARTIAL: jostle_outcome = 2;
/// It was shown that the planner's actions do not solve the problem: there is no grasp and no legal push, or a body that has
/// to be dragged is enclosed by what stays. The plan holds no actions; jostle_plan_reason() says why.
pub const JOSTLE_OUTCOME_INFEASIBLE: jostle_outcome = 3;
/// A limit was reached first; the plan holds the best found so far.
pub const JOSTLE_OUTCOME_BUDGET: jostle_outcome = 4;
/// Cancelled. The plan holds no actions, so that an outcome that nobody reads moves no robot.
pub const JOSTLE_OUTCOME_CANCELLED: jostle_outcome = 5;

/// `no_plan_within` where nothing is known.
pub const JOSTLE_UNKNOWN: u32 = 0xffff_ffff;

/// What a decision took.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct jostle_plan_statistics {
    /// Set by jostle_plan_statistics_default().
    pub struct_size: u32,
    /// No plan of this many pushes or fewer exists in the planner's actions and model (all were tried);
    /// JOSTLE_UNKNOWN if that is not known.
    pub no_plan_within: u32,
    /// Iterations of the search; as a limit, the same number makes the same plan again.
    pub iterations: u64,
    /// Nodes of the search tree.
    pub nodes: u64,
    /// Pushes simulated.
    pub simulations: u64,
    /// The planner's seed.
    pub seed: u64,
    /// Wall-clock time of the decision.
    pub seconds: f64,
    /// Time of all threads in physics, grasp test and sampling.
    pub domain_seconds: f64,
    /// Time of the deciding thread outside of them.
    pub search_seconds: f64,
    /// Score of the plan's last grasp in the model, 0 without one.
    pub grasp_score: f64,
    /// Plans tried in the confirming engine before the decision; 0 where plans are not confirmed.
    pub plans_tried: u64,
    /// Of these, plans that succeed there too.
    pub plans_confirmed: u64,
    /// Pushes simulated in the confirming engine.
    pub confirm_simulations: u64,
    /// Wall-clock time of it, contained in `seconds`.
    pub confirm_seconds: f64,
    /// 1 if no shorter plan exists in the planner's actions and model: every push of every state that fewer pushes lead
    /// to was tried; else 0.
    pub proved_shortest: u32,
    /// Perturbed worlds that the next two are estimated from; 0 if the planner weighs no plans in such worlds, or had no
    /// need to.
    pub worlds: u32,
    /// Probability that the target is out after no more actions than the plan has, if the robot looks and plans again
    /// after every action.
    pub success_chance: f64,
    /// Mean number of actions until then.
    pub expected_actions: f64,
}

// SAFETY: repr(C), struct_size first, numbers without padding.
unsafe impl Sized32 for jostle_plan_statistics {
    const NAME: &'static str = "jostle_plan_statistics";
    const FIRST_SIZE: usize = 72;
    fn defaults() -> Self {
        jostle_plan_statistics {
            struct_size: size_of::<Self>() as u32,
            no_plan_within: JOSTLE_UNKNOWN,
            iterations: 0,
            nodes: 0,
            simulations: 0,
            seed: 0,
            seconds: 0.0,
            domain_seconds: 0.0,
            search_seconds: 0.0,
            grasp_score: 0.0,
            plans_tried: 0,
            plans_confirmed: 0,
            confirm_simulations: 0,
            confirm_seconds: 0.0,
            proved_shortest: 0,
            worlds: 0,
            success_chance: 0.0,
            expected_actions: 0.0,
        }
    }
}

/// A first action that was considered, for explaining a decision. Frozen: never changes.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct jostle_ranked_action {
    pub action: jostle_action,
    /// Mean of the returns.
    pub value: f64,
    /// Greatest return.
    pub best_return: f64,
    pub visits: u64,
    pub prior: f64,
    /// Fewest actions to a solution below it, JOSTLE_NO_SOLUTION if none was found.
    pub solution_actions: u32,
    /// 0.
    pub reserved: u32,
}

pub(super) struct Plan {
    log: Arc<Log>,
    made: Made,
    /// The actions of either, as C has them.
    actions: Vec<jostle_action>,
    bodies: Bodies,
}

/// What kind of plan it is.
enum Made {
    Retrieval(plan::Plan),
    Rearrangement(RearrangePlan),
}

impl Plan {
    pub fn new(log: &Arc<Log>, plan: plan::Plan, bodies: Bodies) -> Plan {
        let actions = plan.actions.iter().map(|step| c_action(&step.action, &bodies)).collect();
        Plan { log: Arc::clone(log), made: Made::Retrieval(plan), actions, bodies }
    }

    pub fn of_moves(log: &Arc<Log>, plan: RearrangePlan, bodies: Bodies) -> Plan {
        let actions = plan.moves.iter().map(|step| c_move(&step.action, &bodies)).collect();
        Plan { log: Arc::clone(log), made: Made::Rearrangement(plan), actions, bodies }
    }

    fn outcome(&self) -> plan::Outcome {
        match &self.made {
            Made::Retrieval(plan) => plan.outcome,
            Made::Rearrangement(plan) => plan.outcome,
        }
    }

    fn reasons(&self) -> &[plan::Reason] {
        match &self.made {
            Made::Retrieval(plan) => &plan.reasons,
            Made::Rearrangement(plan) => &plan.reasons,
        }
    }

    /// One action's value and the state after it.
    fn step(&self, index: usize) -> Outcome<(f64, &State)> {
        let step = match &self.made {
            Made::Retrieval(plan) => plan.actions.get(index).map(|step| (step.value, &step.predicted)),
            Made::Rearrangement(plan) => plan.moves.get(index).map(|step| (step.value, &step.predicted)),
        };
        step.ok_or_else(|| self.no_action(index))
    }

    fn action(&self, index: usize) -> Outcome<jostle_action> {
        self.actions.get(index).copied().ok_or_else(|| self.no_action(index))
    }

    fn no_action(&self, index: usize) -> Failure {
        let count = self.actions.len();
        Failure::new(JOSTLE_ERROR_NOT_FOUND, format!("index: is {index}; the plan has {count} actions"))
    }
}

impl Object for Plan {
    const KIND: Kind = Kind::Plan;
    type Handle = jostle_plan;
    fn log(&self) -> &Arc<Log> {
        &self.log
    }
}

pub(super) fn c_outcome(outcome: plan::Outcome) -> jostle_outcome {
    match outcome {
        plan::Outcome::Solved => JOSTLE_OUTCOME_SOLVED,
        plan::Outcome::Partial => JOSTLE_OUTCOME_PARTIAL,
        plan::Outcome::Infeasible => JOSTLE_OUTCOME_INFEASIBLE,
        plan::Outcome::Budget => JOSTLE_OUTCOME_BUDGET,
        plan::Outcome::Cancelled => JOSTLE_OUTCOME_CANCELLED,
    }
}

fn with(function: &'static str, plan: *const jostle_plan, body: impl FnOnce(&Plan) -> Outcome) -> jostle_status {
    guard(function, |call| body(&*call.open::<Plan>(plan, "plan")?))
}

/// Frees a plan.
///
/// Thread: any.
/// RT: no.
/// Nullable: plan (does nothing).
/// Owns: the handle is dead afterwards.
/// Errors: none returned; a dead handle leaves a message in jostle_last_error().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_plan_free(plan: *mut jostle_plan) {
    free::<Plan>("jostle_plan_free", plan, "plan", false);
}

/// How the decision ended. Read it before anything else.
///
/// Thread: shared use of plan.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_plan_outcome(plan: *const jostle_plan, outcome: *mut jostle_outcome) -> jostle_status {
    with("jostle_plan_outcome", plan, |plan| {
        // SAFETY: the caller promises a writable place.
        unsafe { out(outcome, "outcome") }?.set(c_outcome(plan.outcome()));
        Ok(())
    })
}

/// The name of an outcome, such as "solved"; "unknown outcome" for other numbers.
///
/// Thread: any.
/// RT: yes.
/// Nullable: never returns null.
/// Owns: the library, for ever.
/// Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn jostle_outcome_name(outcome: jostle_outcome) -> *const c_char {
    match outcome {
        JOSTLE_OUTCOME_SOLVED => c"solved",
        JOSTLE_OUTCOME_PARTIAL => c"partial",
        JOSTLE_OUTCOME_INFEASIBLE => c"infeasible",
        JOSTLE_OUTCOME_BUDGET => c"budget",
        JOSTLE_OUTCOME_CANCELLED => c"cancelled",
        _ => c"unknown outcome",
    }
    .as_ptr()
}

/// Number of reasons why the plan is not solved; 0 for one that is, and for one that was cancelled.
///
/// Thread: shared use of plan.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_plan_reason_count(plan: *const jostle_plan, count: *mut usize) -> jostle_status {
    with("jostle_plan_reason_count", plan, |plan| {
        // SAFETY: the caller promises a writable place.
        unsafe { out(count, "count") }?.set(plan.reasons().len());
        Ok(())
    })
}

/// Copies one of the reasons why the plan is not solved, from 0: a sentence that says what is so and what to change;
/// `length` counts the closing zero. jostle_plan_json() has the same with its numbers.
///
/// Thread: shared use of plan.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the length).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUFFER (length was written), NOT_FOUND (the plan has no such reason).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_plan_reason(
    plan: *const jostle_plan,
    index: usize,
    buffer: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> jostle_status {
    with("jostle_plan_reason", plan, |plan| {
        // SAFETY: the caller promises a writable place.
        unsafe { out(length, "length") }?;
        let reasons = plan.reasons();
        let reason = reasons.get(index).ok_or_else(|| {
            let text = format!("index: is {index}; the plan has {} reasons", reasons.len());
            Failure::new(JOSTLE_ERROR_NOT_FOUND, text)
        })?;
        // SAFETY: the caller promises room for `capacity` characters.
        unsafe { fill_text(buffer, capacity, length, &reason.to_string()) }
    })
}

/// Number of actions.
///
/// Thread: shared use of plan.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_plan_action_count(plan: *const jostle_plan, count: *mut usize) -> jostle_status {
    with("jostle_plan_action_count", plan, |plan| {
        // SAFETY: the caller promises a writable place.
        unsafe { out(count, "count") }?.set(plan.actions.len());
        Ok(())
    })
}

/// One action, from 0. Execute the first, observe, and plan again.
///
/// Thread: shared use of plan.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE, NOT_FOUND (the plan has no such action).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_plan_action(
    plan: *const jostle_plan,
    index: usize,
    action: *mut jostle_action,
) -> jostle_status {
    with("jostle_plan_action", plan, |plan| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out(action, "action") }?;
        out.set(plan.action(index)?);
        Ok(())
    })
}

/// Copies all actions, in order.
///
/// Thread: shared use of plan.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUFFER (count was written).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_plan_actions(
    plan: *const jostle_plan,
    buffer: *mut jostle_action,
    capacity: usize,
    count: *mut usize,
) -> jostle_status {
    with("jostle_plan_actions", plan, |plan| {
        // SAFETY: the caller promises room for `capacity` actions.
        unsafe { fill(buffer, capacity, count, &plan.actions) }
    })
}

/// Copies the poses of one action of a rearrangement, from 0: where the body is picked and where it is placed, or all
/// waypoints of a drag. Between two of them the body moves straight and turns the shorter way round.
///
/// Thread: shared use of plan.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUFFER (count was written), NOT_FOUND (the plan has no such action, or it is a push
/// or a grasp).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_plan_waypoints(
    plan: *const jostle_plan,
    index: usize,
    buffer: *mut jostle_pose2,
    capacity: usize,
    count: *mut usize,
) -> jostle_status {
    with("jostle_plan_waypoints", plan, |plan| {
        // SAFETY: the caller promises a writable place.
        unsafe { out(count, "count") }?;
        plan.action(index)?;
        let Made::Rearrangement(made) = &plan.made else {
            return Err(Failure::new(JOSTLE_ERROR_NOT_FOUND, "index: pushes and grasps have no waypoints"));
        };
        let poses = made.moves.get(index).map(|step| step.action.poses()).unwrap_or_default();
        let poses: Vec<jostle_pose2> = poses.into_iter().map(jostle_pose2::from).collect();
        // SAFETY: the caller promises room for `capacity` poses.
        unsafe { fill(buffer, capacity, count, &poses) }
    })
}

/// What the moves of a rearrangement cost: the way with its fixed parts in metres, and the robot's time in seconds.
///
/// Thread: shared use of plan.
/// RT: yes.
/// Nullable: metres, seconds.
/// Owns: nothing.
/// Errors: ARGUMENT (null plan), HANDLE, NOT_FOUND (a plan of a retrieval).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_plan_cost(
    plan: *const jostle_plan,
    metres: *mut f64,
    seconds: *mut f64,
) -> jostle_status {
    with("jostle_plan_cost", plan, |plan| {
        let Made::Rearrangement(made) = &plan.made else {
            return Err(Failure::new(JOSTLE_ERROR_NOT_FOUND, "plan: only a rearrangement's has a cost"));
        };
        for (place, name, value) in [(metres, "metres", made.cost), (seconds, "seconds", made.robot_seconds)] {
            if !place.is_null() {
                // SAFETY: the caller promises writable places if they are not null.
                unsafe { out(place, name) }?.set(value);
            }
        }
        Ok(())
    })
}

/// The search's value of one action, from 0.
///
/// Thread: shared use of plan.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE, NOT_FOUND (the plan has no such action).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_plan_value(plan: *const jostle_plan, index: usize, value: *mut f64) -> jostle_status {
    with("jostle_plan_value", plan, |plan| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out(value, "value") }?;
        out.set(plan.step(index)?.0);
        Ok(())
    })
}

/// Copies the poses that the planner expects of all bodies after one action; after a grasp the grasped body is absent.
///
/// Thread: shared use of plan.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUFFER (count was written), NOT_FOUND (the plan has no such action).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_plan_predicted(
    plan: *const jostle_plan,
    index: usize,
    buffer: *mut jostle_body_pose,
    capacity: usize,
    count: *mut usize,
) -> jostle_status {
    with("jostle_plan_predicted", plan, |plan| {
        // SAFETY: the caller promises a writable place, and room for `capacity` poses.
        unsafe {
            out(count, "count")?;
            fill(buffer, capacity, count, &plan.bodies.poses(plan.step(index)?.1))
        }
    })
}

/// Copies the first actions that were considered, best first.
///
/// Thread: shared use of plan.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUFFER (count was written).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_plan_considered(
    plan: *const jostle_plan,
    buffer: *mut jostle_ranked_action,
    capacity: usize,
    count: *mut usize,
) -> jostle_status {
    with("jostle_plan_considered", plan, |plan| {
        macro_rules! ranked {
            ($list:expr, $action:expr) => {
                $list
                    .iter()
                    .map(|r| jostle_ranked_action {
                        action: $action(&r.action, &plan.bodies),
                        value: r.value,
                        best_return: r.best_return,
                        visits: r.visits,
                        prior: r.prior,
                        solution_actions: r.solution_level.unwrap_or(super::progress::JOSTLE_NO_SOLUTION),
                        reserved: 0,
                    })
                    .collect()
            };
        }
        let considered: Vec<jostle_ranked_action> = match &plan.made {
            Made::Retrieval(made) => ranked!(made.considered, c_action),
            Made::Rearrangement(made) => ranked!(made.considered, c_move),
        };
        // SAFETY: the caller promises room for `capacity` actions.
        unsafe { fill(buffer, capacity, count, &considered) }
    })
}

/// Where the bodies are expected after a first action that was considered (`index` as in jostle_plan_considered()), and
/// what it came to in perturbed worlds: the probability that the target is out after no more actions than the best plan
/// that begins so, and the mean number of actions. Both are 0 for an action that was not weighed in such worlds.
///
/// Thread: shared use of plan.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count), success_chance, expected_actions.
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUFFER (count was written), NOT_FOUND (no such action, or a plan that moves bodies to
/// goals).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_plan_explain(
    plan: *const jostle_plan,
    index: usize,
    success_chance: *mut f64,
    expected_actions: *mut f64,
    buffer: *mut jostle_body_pose,
    capacity: usize,
    count: *mut usize,
) -> jostle_status {
    with("jostle_plan_explain", plan, |plan| {
        // SAFETY: the caller promises a writable place.
        unsafe { out(count, "count") }?;
        let considered = match &plan.made {
            Made::Retrieval(made) => made.considered.get(index),
            Made::Rearrangement(_) => None,
        };
        let action = considered.ok_or_else(|| {
            Failure::new(JOSTLE_ERROR_NOT_FOUND, format!("index: is {index}; no such action is explained"))
        })?;
        // SAFETY: the caller promises writable places where they are not null, and room for `capacity` poses.
        unsafe {
            for (place, value) in [(success_chance, action.success_chance), (expected_actions, action.expected_actions)]
            {
                if !place.is_null() {
                    out(place, "number")?.set(value.unwrap_or(0.0));
                }
            }
            fill(buffer, capacity, count, &plan.bodies.poses(&action.predicted))
        }
    })
}

/// Sets every field to its default; `size` is sizeof(jostle_plan_statistics) as the caller was compiled.
/// jostle_plan_statistics_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_plan_statistics_init(
    statistics: *mut jostle_plan_statistics,
    size: usize,
) -> jostle_status {
    // SAFETY: the caller promises `size` writable bytes.
    guard("jostle_plan_statistics_init", |_| unsafe { init_sized(statistics, "statistics", size) })
}

/// What the decision took.
///
/// Thread: shared use of plan.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller; statistics->struct_size says how much is written.
/// Errors: ARGUMENT (null, statistics not initialised), HANDLE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_plan_get_statistics(
    plan: *const jostle_plan,
    statistics: *mut jostle_plan_statistics,
) -> jostle_status {
    with("jostle_plan_get_statistics", plan, |plan| {
        let (s, seed, grasp_score) = match &plan.made {
            Made::Retrieval(made) => (&made.statistics, made.seed, made.grasp_score),
            Made::Rearrangement(made) => (&made.statistics, made.seed, 0.0),
        };
        let value = jostle_plan_statistics {
            struct_size: 0,
            no_plan_within: s.no_plan_within.unwrap_or(JOSTLE_UNKNOWN),
            iterations: s.iterations,
            nodes: s.nodes,
            simulations: s.simulations,
            seed,
            seconds: s.seconds,
            domain_seconds: s.domain_seconds,
            search_seconds: s.search_seconds,
            grasp_score,
            plans_tried: s.plans_tried,
            plans_confirmed: s.plans_confirmed,
            confirm_simulations: s.confirm_simulations,
            confirm_seconds: s.confirm_seconds,
            proved_shortest: u32::from(s.proved_shortest),
            worlds: s.worlds.try_into().unwrap_or(u32::MAX),
            success_chance: s.success_chance.unwrap_or(0.0),
            expected_actions: s.expected_actions.unwrap_or(0.0),
        };
        // SAFETY: the caller promises an initialised struct.
        unsafe { write_sized(statistics, "statistics", &value) }
    })
}

/// A hash of outcome, actions and predicted poses: equal plans have equal hashes. Within a limit of iterations it is
/// the same at any number of threads.
///
/// Thread: shared use of plan.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_plan_hash(plan: *const jostle_plan, hash: *mut u64) -> jostle_status {
    with("jostle_plan_hash", plan, |plan| {
        // SAFETY: the caller promises a writable place.
        unsafe { out(hash, "hash") }?.set(match &plan.made {
            Made::Retrieval(made) => made.hash_bits(),
            Made::Rearrangement(made) => made.hash_bits(),
        });
        Ok(())
    })
}

/// Copies the plan as JSON text; `length` counts the closing zero. Bodies are named by their indices in the scene.
///
/// Thread: shared use of plan.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the length).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUFFER (length was written).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_plan_json(
    plan: *const jostle_plan,
    buffer: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> jostle_status {
    with("jostle_plan_json", plan, |plan| {
        let value = match &plan.made {
            Made::Retrieval(made) => plan_json::retrieval(made),
            Made::Rearrangement(made) => plan_json::rearrangement(made),
        };
        let text = serde_json::to_string(&value)
            .map_err(|e| Failure::from(Error::Internal(format!("a plan cannot be written: {e}"))))?;
        // SAFETY: the caller promises room for `capacity` characters.
        unsafe { fill_text(buffer, capacity, length, &text) }
    })
}
