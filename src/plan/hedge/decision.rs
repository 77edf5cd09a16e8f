//! One decision of `hedge`: levels one after another, each weighed before the next is begun.

use super::episode::Rules;
use super::expect::{Way, ways, weigh};
use crate::error::Result;
use crate::physics::{Ensemble, PushStatus, Transition};
use crate::plan::confirm::{Confirmed, SEARCH_SHARE, Verdict};
use crate::plan::decision::{Decision, Found, From, asked, both, cancelled};
use crate::plan::retrieval::Retrieval;
use crate::run::Budget;
use crate::scene::State;
use crate::search::{Closed, EarlyStop, EndReason, Params, Run, Tree};

/// Levels that are searched whole, whatever it takes.
const WHOLE: u32 = 2;
/// Iterations of the guided search below them, and of each piece of it, after which it looks at what it has.
const GUIDED: u64 = 8192;
const PIECE: u64 = 1024;
/// First pushes with a solution that are enough of them.
const ENOUGH: usize = 8;

/// What one search of a level may do: everything down to this level, without rollouts.
fn level(params: &Params, level: u32) -> Params {
    Params {
        max_depth: level.min(params.max_depth),
        rollout_extra: 0,
        closed: Closed::Skip,
        early_stop: EarlyStop::Never,
        shrink_depth_on_solution: false,
        ..*params
    }
}

/// Decides by the expected number of actions.
pub(in crate::plan) fn make(
    decision: &Decision<'_>,
    ensemble: &Ensemble,
    execute_score: f64,
    tree: &mut Tree<Retrieval>,
    from: From<'_>,
    observed: &State,
) -> Result<Found> {
    let Decision { domain, params, budget, pool, stop, progress, .. } = *decision;
    let search_stop = stop.sooner(SEARCH_SHARE);
    let run =
        |iterations: Option<u64>| Run { pool, stop: &search_stop, budget: Budget { iterations, ..budget }, progress };
    let rules = Rules { domain, ensemble, execute_score, stop };
    let (mut verdict, mut best): (Verdict, Option<Way>) = (Verdict::default(), None);
    let mut done = 1;
    let mut report = match from {
        From::Root(state, seed) => tree.search(domain, state, &level(params, 1), seed, &run(budget.iterations))?,
        From::Tree => tree.resume(domain, &level(params, 1), &run(budget.iterations))?,
    };
    let mut guided = 0;
    loop {
        if asked(&report, &search_stop) || report.reason == EndReason::Solved {
            break;
        }
        let mut found = ways(tree, done);
        let enough =
            done <= WHOLE || found.len() >= ENOUGH || guided >= GUIDED || report.reason != EndReason::Iterations;
        if enough && !found.is_empty() {
            let before = stop.elapsed();
            let mut spent = [0; 2];
            verdict.tried += found.len() as u64;
            weigh(&mut found, &rules, pool, observed, &mut spent)?;
            verdict.simulations += spent[0];
            report.simulations += spent[1];
            verdict.seconds += (stop.elapsed() - before).as_secs_f64();
            verdict.confirmed += found.iter().filter(|w| w.chance() >= 0.5).count() as u64;
            if let Some(way) = found.into_iter().next()
                && best.as_ref().is_none_or(|b| way.expected() < b.expected())
            {
                best = Some(way);
            }
            // A longer plan takes at least one action more than the levels that were searched.
            if best.as_ref().is_some_and(|b| b.expected() <= f64::from(done) + 2.0) {
                break;
            }
        }
        let left = budget.iterations.map(|most| most.saturating_sub(report.iterations));
        if left == Some(0) || search_stop.requested() || done > WHOLE && enough {
            break;
        }
        let (params, most) = if done < WHOLE {
            done += 1;
            (level(params, done), left)
        } else {
            done = params.max_depth;
            guided += PIECE;
            (*params, Some(left.unwrap_or(PIECE).min(PIECE)))
        };
        if done > params.max_depth {
            break;
        }
        let further = tree.resume(domain, &params, &run(most))?;
        report = both(&report, further);
        // A piece that was used up is no reason to end; the budget is looked at above.
    }
    if let Some(way) = best {
        verdict.chance = Some(way.chance());
        verdict.expected = Some(way.expected());
        verdict.worlds = way.costs.len() as u64;
        verdict.best = as_predicted(domain, decision.confirming.map(|e| &**e), &way, observed, stop);
    }
    Ok(Found { cancelled: asked(&report, &search_stop) || cancelled(stop), report, verdict })
}

/// The plan as the faithful engine predicts it, if it frees the target there, else as the search does.
fn as_predicted(
    domain: &Retrieval,
    engine: Option<&dyn Transition>,
    way: &Way,
    observed: &State,
    stop: &crate::run::Stop,
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
