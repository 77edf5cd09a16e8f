//! One decision of `hedge`: levels one after another, each weighed before the next is begun.

use super::episode::Rules;
use super::expect::{PLANS, Way, ways, weigh};
use crate::action::Push;
use crate::error::Result;
use crate::physics::{Ensemble, PushStatus, Transition};
use crate::plan::confirm::{Confirmed, SEARCH_SHARE, Verdict, Weighed};
use crate::plan::decision::{Decision, Found, From, asked, both, cancelled};
use crate::plan::retrieval::Retrieval;
use crate::run::{Budget, Stop};
use crate::scene::State;
use crate::search::{Closed, EarlyStop, EndReason, Params, Run, Told, Tree};

/// Levels that are searched whole, whatever it takes.
const WHOLE: u32 = 2;
/// The last level that is searched before deeper ones: whole where that takes no more than `LAST_WORK`, else as far, or until
/// [`PLANS`] first pushes that were not weighed before have a solution.
const LAST: u32 = 3;
/// Pushes tried there times bodies. A push of 5 to 11 bodies takes about 10 us a body to find, simulate and grade.
const LAST_WORK: u64 = 200_000;
/// A plan that is expected to take so much more than the least that one of the last level could take is good enough:
/// thousands of pushes are not worth less.
const LAST_GAIN: f64 = 0.25;
/// Iterations of a piece of the last level's search and of the guided search below, after which it looks at what it has.
const PIECE: u64 = 512;
/// Iterations below beyond the piece with which a first solution was known; until then it goes on to the budget's end.
const FURTHER: u64 = 1024;
/// First pushes with a solution that are enough of them, below.
const ENOUGH: usize = 8;

/// What is searched.
#[derive(Clone, Copy, PartialEq)]
enum Stage {
    /// Everything down to this level.
    Level(u32),
    /// The guided search below.
    Below,
}

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
        |iterations, progress| Run { pool, stop: &search_stop, budget: Budget { iterations, ..budget }, progress };
    let first = run(budget.iterations, progress.map(Told::from));
    let rules = Rules { domain, ensemble, execute_score, stop };
    let mut report = match from {
        From::Root(state, seed) => tree.search(domain, state, &level(params, 1), seed, &first)?,
        From::Tree => tree.resume(domain, &level(params, 1), &first)?,
    };
    let mut verdict = Verdict::default();
    let mut weighed: Vec<Way> = Vec::new();
    let mut continued = Way::continued(domain, rest, observed, stop);
    let last_work = (LAST_WORK / domain.scene.len().max(1) as u64).max(PIECE);
    let mut stage = Stage::Level(1);
    // Iterations of the last level, and below since a solution is known.
    let (mut spent_last, mut since) = (0, 0);
    // A root that is a solution ends the first search by itself.
    while !asked(&report, &search_stop) && report.reason != EndReason::Solved {
        let mut fresh = ways(tree, if let Stage::Level(level) = stage { level } else { params.max_depth });
        fresh.retain(|way| !weighed.iter().any(|known| known.pushes.first() == way.pushes.first()));
        if let Some(way) = continued.take().filter(|c| fresh.iter().all(|way| way.pushes.first() != c.pushes.first())) {
            fresh.push(way);
        }
        if stage == Stage::Below && !(fresh.is_empty() && weighed.is_empty()) {
            since += PIECE;
        }
        let left = budget.iterations.map(|most| most.saturating_sub(report.iterations));
        // A piece that was used up is no end of the search; the budget is.
        let through = report.reason != EndReason::Iterations || left == Some(0) || search_stop.requested();
        let over = match stage {
            Stage::Level(level) if level <= WHOLE => true,
            Stage::Level(_) => through || fresh.len() >= PLANS || spent_last >= last_work,
            Stage::Below => through || fresh.len() >= ENOUGH || since > FURTHER,
        };
        if over {
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
            let least = weighed.first().map_or(f64::INFINITY, Way::expected);
            // A longer plan takes at least one action more than the level that was searched.
            let good_enough = match stage {
                Stage::Level(level) if level < WHOLE => f64::from(level) + 2.0,
                Stage::Level(WHOLE) => f64::from(WHOLE) + 2.0 + LAST_GAIN,
                // Deeper plans are for those who have none.
                _ => f64::MAX,
            };
            if least <= good_enough || stage == Stage::Below {
                break;
            }
        }
        let deepest = matches!(stage, Stage::Level(level) if level >= params.max_depth);
        let full = report.reason == EndReason::Memory;
        if full || left == Some(0) || search_stop.requested() || over && deepest {
            break;
        }
        stage = match stage {
            Stage::Level(level) if over && level < LAST => Stage::Level(level + 1),
            Stage::Level(_) if over => Stage::Below,
            same => same,
        };
        let piece = left.unwrap_or(PIECE).min(PIECE);
        let told = progress.map(|progress| Told::from(progress).and(&report));
        let further = match stage {
            Stage::Level(to) if to <= WHOLE => tree.resume(domain, &level(params, to), &run(left, told))?,
            Stage::Level(to) => {
                spent_last += piece;
                tree.resume(domain, &level(params, to), &run(Some(piece), told))?
            }
            Stage::Below => tree.resume(domain, &below(params, report.solution_level), &run(Some(piece), told))?,
        };
        report = both(&report, further);
    }
    // What is left of an earlier plan may free the target in some worlds only, and in neither model: it cannot be told.
    weighed.retain(|way| !way.ends.is_empty());
    while let Some(way) = weighed.first() {
        verdict.best = as_predicted(domain, decision.confirming.map(|e| &**e), way, observed, stop);
        if let Some(best) = &verdict.best {
            verdict.chance = Some(way.within(best.pushes.len() + 1));
            verdict.expected = Some(way.expected());
            verdict.worlds = way.ends.len() as u64;
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
            let found = domain.assess(&mut scratch, &state, stop);
            if domain.solves(&found) {
                return Some((states, found));
            }
        }
        None
    });
    let (states, found) = match faithful {
        Some(known) => known,
        None => (way.states.clone(), domain.assess(&mut scratch, way.states.last()?, &Stop::never())),
    };
    let pushes = way.pushes.iter().copied().zip(states).collect();
    Some(Confirmed { pushes, grasp: found.grasp?, score: found.score })
}
