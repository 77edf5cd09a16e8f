//! What is behind a planner's handle: a planner of retrievals, of rearrangements, or one that clears the table.

use std::sync::Arc;

use super::action::{c_move, jostle_action, read_action};
use super::log::{JOSTLE_LOG_INFO, Log};
use super::plan::Plan;
use super::planner::Request;
use super::scene::Bodies;
use super::status::{Failure, Outcome};
use crate::action::Move;
use crate::error::{Error, Result};
use crate::plan::clear::{CLEAR_PLANNERS, ClearOptions, ClearPlanner};
use crate::plan::rearrange::{REARRANGE_PLANNERS, RearrangeOptions, RearrangePlanner};
use crate::plan::{Planner, PlannerOptions};
use crate::scene::AnyProblem;

/// What a planner wants with a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Asks {
    /// A body to retrieve.
    Target,
    /// Goals of bodies.
    Goals,
    /// Nothing: every body is to be taken.
    All,
}

impl Asks {
    /// By a planner's id; one that does not exist is taken for one of retrievals.
    pub fn of(id: &str) -> Asks {
        if REARRANGE_PLANNERS.contains(&id) {
            Asks::Goals
        } else if CLEAR_PLANNERS.contains(&id) {
            Asks::All
        } else {
            Asks::Target
        }
    }
}

pub(super) enum Decider {
    Retrieve(Box<Planner>),
    Rearrange {
        planner: Box<RearrangePlanner>,
        /// The first move of its last plan, to understand an executed action by.
        first: Option<Move>,
    },
    Clear(Box<ClearPlanner>),
}

impl Decider {
    pub fn new(options: PlannerOptions) -> Result<Decider> {
        match Asks::of(&options.planner) {
            Asks::Target => return Ok(Decider::Retrieve(Box::new(Planner::new(options)?))),
            Asks::All => return Ok(Decider::Clear(Box::new(ClearPlanner::new(ClearOptions::of(options))?))),
            Asks::Goals => {}
        }
        let options = RearrangeOptions {
            planner: options.planner,
            variant: options.variant,
            budget: options.budget,
            seed: options.seed,
            threads: options.threads,
            lanes: options.lanes,
            max_depth: options.max_depth,
            ..RearrangeOptions::default()
        };
        Ok(Decider::Rearrange { planner: Box::new(RearrangePlanner::new(options)?), first: None })
    }

    /// What it wants with a scene.
    pub fn asks(&self) -> Asks {
        match self {
            Decider::Retrieve(_) => Asks::Target,
            Decider::Rearrange { .. } => Asks::Goals,
            Decider::Clear(_) => Asks::All,
        }
    }

    /// Refuses a problem that no decision can be made for.
    pub fn check(&self, problem: &AnyProblem) -> Result<()> {
        match (self, problem) {
            (Decider::Retrieve(planner), AnyProblem::Retrieval(problem)) => planner.check(problem),
            (Decider::Clear(planner), AnyProblem::Clearing(problem)) => planner.check(problem),
            _ => Ok(()),
        }
    }

    /// Makes the decision and says so in the log.
    pub fn decide(&mut self, request: &Request, log: &Arc<Log>) -> Result<Plan> {
        let bodies = request.bodies.clone();
        let (plan, outcome, actions, s) = match (self, &request.problem) {
            (Decider::Retrieve(planner), AnyProblem::Retrieval(problem)) => {
                let plan = match request.iterations {
                    Some(iterations) => planner.step(problem, iterations, &request.control),
                    None => planner.solve(problem, &request.control),
                }?;
                let (outcome, actions, statistics) = (plan.outcome, plan.actions.len(), plan.statistics);
                (Plan::new(log, plan, bodies), outcome, actions, statistics)
            }
            (Decider::Rearrange { planner, first }, AnyProblem::Rearrangement(problem)) => {
                *first = None;
                let plan = match request.iterations {
                    Some(iterations) => planner.step(problem, iterations, &request.control),
                    None => planner.solve(problem, &request.control),
                }?;
                *first = plan.moves.first().map(|step| step.action.clone());
                let (outcome, actions, statistics) = (plan.outcome, plan.moves.len(), plan.statistics);
                (Plan::of_moves(log, plan, bodies), outcome, actions, statistics)
            }
            (Decider::Clear(planner), AnyProblem::Clearing(problem)) => {
                let plan = match request.iterations {
                    Some(iterations) => planner.step(problem, iterations, &request.control),
                    None => planner.solve(problem, &request.control),
                }?;
                let (outcome, actions, statistics) = (plan.outcome, plan.actions.len(), plan.statistics);
                (Plan::new(log, plan, bodies), outcome, actions, statistics)
            }
            _ => return Err(Error::Internal("the problem is not of the planner's kind".into())),
        };
        log.emit(
            JOSTLE_LOG_INFO,
            "jostle_planner_solve",
            &format!(
                "{outcome:?} with {actions} actions after {} iterations, {} simulations, {:.3} s",
                s.iterations, s.simulations, s.seconds
            ),
        );
        Ok(plan)
    }

    /// Tells the planner what was executed.
    ///
    /// # Safety
    /// `action` is null or readable.
    pub unsafe fn advance(&mut self, action: *const jostle_action, bodies: &Bodies) -> Outcome<bool> {
        match self {
            // SAFETY: as promised by the caller.
            Decider::Retrieve(planner) => Ok(planner.advance(&unsafe { read_action(action, bodies) }?)?),
            Decider::Clear(planner) => {
                // SAFETY: as promised by the caller.
                planner.advance(&unsafe { read_action(action, bodies) }?);
                Ok(false)
            }
            Decider::Rearrange { planner, first } => {
                // SAFETY: as promised by the caller.
                let given = unsafe { read_move(action, bodies) }?;
                match first.take() {
                    Some(first) if c_move(&first, bodies) == given => Ok(planner.advance(&first)?),
                    _ => {
                        planner.reset();
                        Ok(false)
                    }
                }
            }
        }
    }

    /// Tells the planner what was tried and failed.
    ///
    /// # Safety
    /// `action` is null or readable.
    pub unsafe fn failed(&mut self, action: *const jostle_action, bodies: &Bodies) -> Outcome {
        match self {
            // SAFETY: as promised by the caller.
            Decider::Retrieve(planner) => planner.failed(&unsafe { read_action(action, bodies) }?),
            // SAFETY: as promised by the caller.
            Decider::Clear(planner) => planner.failed(&unsafe { read_action(action, bodies) }?),
            Decider::Rearrange { planner, first } => {
                // SAFETY: as promised by the caller.
                unsafe { read_move(action, bodies) }?;
                *first = None;
                planner.reset();
            }
        }
        Ok(())
    }

    pub fn reset(&mut self) {
        match self {
            Decider::Retrieve(planner) => planner.reset(),
            Decider::Clear(planner) => planner.reset(),
            Decider::Rearrange { planner, first } => {
                *first = None;
                planner.reset();
            }
        }
    }

    /// Bytes of the search tree, of known paths, or of the pushes that were judged.
    pub fn memory_bytes(&self) -> usize {
        match self {
            Decider::Retrieve(planner) => planner.memory_bytes(),
            Decider::Clear(planner) => planner.memory_bytes(),
            Decider::Rearrange { planner, .. } => planner.memory_bytes(),
        }
    }
}

/// A move of a rearrangement.
///
/// # Safety
/// `action` is null or readable.
unsafe fn read_move(action: *const jostle_action, bodies: &Bodies) -> Outcome<jostle_action> {
    // SAFETY: as promised by the caller.
    let given = unsafe { super::abi::read(action, "action") }?;
    if ![super::action::JOSTLE_ACTION_PICK_PLACE, super::action::JOSTLE_ACTION_DRAG].contains(&given.kind) {
        let reason = format!("is {}; a rearrangement has moves only", given.kind);
        return Err(Failure::argument("action.kind", reason));
    }
    bodies.index(given.body, "action.body")?;
    Ok(given)
}
