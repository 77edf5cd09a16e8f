//! One decision of `hedge`: levels one after another, each weighed before the next is begun.

use super::episode::Rules;
use super::expect::{Way, ways, weigh};
use crate::action::Push;
use crate::error::Result;
use crate::physics::{Ensemble, PushStatus, Transition};
use crate::plan::confirm::{Confirmed, SEARCH_SHARE, Verdict, Weighed};
use crate::plan::decision::{Decision, Found, From, asked, both, cancelled};
use crate::plan::retrieval::Retrieval;
use crate::run::{Budget, Stop};
use crate::scene::State;
use crate::search::{Closed, EarlyStop, EndReason, Params, Run, Tree};

/// Levels that are searched whole, whatever it takes.
const WHOLE: u32 = 2;
/// Iterations of a piece of the guided search below them, after which it looks at what it has.
const PIECE: u64 = 512;
/// Iterations of it beyond the piece with which a first solution was known; until then it goes on to the budget's end.
const FURTHER: u64 = 1024;
/// First pushes with a solution that are enough of them.
const ENOUGH: usize = 8;

/// What one search of a level may do: everything down to this level, without rollouts.
pub(in crate::plan) fn level(params: &Params, level: u32) -> Params {
    Params {
        max_depth: level.min(params.max_depth),
        rollout_extra: 0,
        closed: Closed::Skip,
        early_stop: EarlyStop::Never,
        shrink_depth_on_solution: false,
        ..*params
    }
}

/// The guided search below: to the depth of the shortest solution that is known, as far as it may otherwise.
fn below(params: &Params, solution: Option<u32>) -> Params {
    let deepest = solution.filter(|&level| level > WHOLE).unwrap_or(params.max_depth).min(params.max_depth);
    Params {
        max_depth: deepest,
        rollout_extra: if deepest < params.max_depth { 0 } else { params.rollout_extra },
        early_stop: EarlyStop::Never,
        shrink_depth_on_solution: false,
        closed: Closed::Skip,
        ..*params
    }
}

/// Decides by the expected number of actions. `rest` is what is left of the plan whose first push was executed: it is weighed
/// like the plans that are found anew.
pub(in crate::plan) fn make(
    decision: &Decision<'_>,
    ensemble: &Ensemble,
    execute_score: f64,
    tree: &mut Tree<Retrieval>,
    from: From<'_>,
    observed: &State,
    rest: &[Push],
) -> Result<Found> {
    let Decision { domain, params, budget, pool, stop, progress, .. } = *decision;
    let search_stop = stop.sooner(SEARCH_SHARE);
    let run =
        |iterations: Option<u64>| Run { pool, stop: &search_stop, budget: Budget { iterations, ..budget }, progress };
    let rules = Rules { domain, ensemble, execute_score, stop };
    let mut report = match from {
        From::Root(state, seed) => tree.search(domain, state, &level(params, 1), seed, &run(budget.iterations))?,
        From::Tree => tree.resume(domain, &level(params, 1), &run(budget.iterations))?,
    };
    let mut verdict = Verdict::default();
    let mut weighed: Vec<Way> = Vec::new();
    let mut continued = Way::continued(domain, rest, observed, stop);
    let (mut done, mut since) = (1, 0);
    // A root that is a solution ends the first search by itself.
    while !asked(&report, &search_stop) && report.reason != EndReason::Solved {
        let mut fresh = ways(tree, done);
        fresh.retain(|way| !weighed.iter().any(|known| known.pushes.first() == way.pushes.first()));
        if let Some(way) = continued.take().filter(|c| fresh.iter().all(|way| way.pushes.first() != c.pushes.first())) {
            fresh.push(way);
        }
        if done > WHOLE && !(fresh.is_empty() && weighed.is_empty()) {
            since += PIECE;
        }
        let left = budget.iterations.map(|most| most.saturating_sub(report.iterations));
        // A piece that was used up is no end of the search; the budget is.
        let through = report.reason != EndReason::Iterations || left == Some(0) || search_stop.requested();
        if done <= WHOLE || fresh.len() >= ENOUGH || since > FURTHER || through {
            let before = stop.elapsed();
            let mut spent = [0; 2];
            verdict.tried += fresh.len() as u64;
            weigh(&mut fresh, &rules, pool, observed, &mut spent)?;
            verdict.simulations += spent[0];
            report.simulations += spent[1];
            verdict.seconds += (stop.elapsed() - before).as_secs_f64();
            verdict.confirmed += fresh.iter().filter(|way| way.chance() >= 0.5).count() as u64;
            weighed.append(&mut fresh);
            // Stable: of equals the shorter plan stays first.
            weighed.sort_by(|a, b| a.expected().total_cmp(&b.expected()));
            // A longer plan takes at least one action more than the levels that were searched.
            let settled = weighed.first().is_some_and(|way| way.expected() <= f64::from(done) + 2.0);
            if settled || done > WHOLE {
                break;
            }
        }
        let full = report.reason == EndReason::Memory;
        if full || left == Some(0) || search_stop.requested() || done >= params.max_depth && done <= WHOLE {
            break;
        }
        let further = if done < WHOLE {
            done += 1;
            tree.resume(domain, &level(params, done), &run(left))?
        } else {
            done = params.max_depth;
            let piece = Some(left.unwrap_or(PIECE).min(PIECE));
            tree.resume(domain, &below(params, report.solution_level), &run(piece))?
        };
        report = both(&report, further);
    }
    // What is left of an earlier plan may free the target in some worlds only, and in neither model: it cannot be told.
    weighed.retain(|way| !way.costs.is_empty());
    while let Some(way) = weighed.first() {
        verdict.best = as_predicted(domain, decision.confirming.map(|e| &**e), way, observed, stop);
        if let Some(best) = &verdict.best {
            verdict.chance = Some(way.within(best.pushes.len() + 1));
            verdict.expected = Some(way.expected());
            verdict.worlds = way.costs.len() as u64;
            break;
        }
        weighed.remove(0);
    }
    verdict.weighed = weighed
        .iter()
        .filter_map(|way| Some(Weighed { push: *way.pushes.first()?, chance: way.chance(), expected: way.expected() }))
        .collect();
    Ok(Found { cancelled: asked(&report, &search_stop) || cancelled(stop), report, verdict })
}

/// The plan as the faithful engine predicts it, if it frees the target there, else as the search does.
fn as_predicted(
    domain: &Retrieval,
    engine: Option<&dyn Transition>,
    way: &Way,
    observed: &State,
    stop: &Stop,
) -> Option<Confirmed> {
    let mut scratch = domain.new_scratch();
    let faithful = engine.and_then(|engine| {
        let (mut memory, mut states) = (engine.scratch(), Vec::new());
        let mut state = observed.clone();
        for push in &way.pushes {
            let result = engine.step(&mut memory, &state, push, stop);
            if result.status != PushStatus::Executed || domain.harmful(&result) {
                return None;
            }
            state = result.state;
            states.push(state.clone());
            let found = domain.assess(&mut scratch, &state);
            if domain.solves(&found) {
                return Some((states, found));
            }
        }
        None
    });
    let (states, found) = match faithful {
        Some(known) => known,
        None => (way.states.clone(), domain.assess(&mut scratch, way.states.last()?)),
    };
    let pushes = way.pushes.iter().copied().zip(states).collect();
    Some(Confirmed { pushes, grasp: found.grasp?, score: found.score })
}
