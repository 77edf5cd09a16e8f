//! `pmbs`: parallel Monte Carlo tree search with batched simulation (dissertation, chapter PMBS).
//!
//! Waves of lanes with virtual loss and leaf parallelism; mean returns, c = 0.3, discount 0.8, depth 7 with at least 3
//! more rollout steps, reward `[solved] + 0.1 q`, early stop by level. With one lane it is the chapter's serial search.
//! Pushes are simulated by `planar`, which is quickest where many run side by side. The published 1000 environments suit a graphics card; here a lane is a push on a processor core, so a wave is 64.
//!
//! * `Dissertation`: as above, with the eight directions that its code samples, and 60 s a decision.
//! * `Code`: exploration 0.3 times the root of 2, the root expanded in one batch first, rollouts ended when a tenth of
//!   the lanes is left, 30 s.
//! * `Tuned`, the default: as the text, but solutions that rollouts meet become nodes of the tree, so that a plan is known
//!   early and bounds the depth; it does not stop early before 256 iterations, so that the means tell the plans that
//!   survive a disturbance from those that do not; the final choice is among the actions that lead to a shortest known
//!   plan; up to four more directions from an object's corners are sampled; plans are confirmed in `prism` before the
//!   decision; 8 s, which few decisions need.

use super::options::{PlannerOptions, Variant};
use super::recipe::Recipe;
use super::retrieval::Reward;
use crate::error::Result;
use crate::physics::{PhysicsOptions, Purpose};
use crate::run::Budget;
use crate::search::{EarlyStop, Mean, Params, Selection};

/// Lanes where the user sets none.
const LANES: usize = 64;
/// Seconds of a decision: published (T_max), of the published scripts, and what a robot may wait for.
const SECONDS: f64 = 60.0;
const SECONDS_CODE: f64 = 30.0;
const SECONDS_TUNED: f64 = 8.0;
/// Iterations of the tuned form before it stops early.
const MIN_ITERATIONS: u64 = 256;

pub fn recipe(options: &PlannerOptions) -> Result<Recipe> {
    let lanes = options.lanes.unwrap_or(LANES) as u32;
    let text = Params::pmbs(lanes);
    let (search, sampler, seconds) = match options.variant {
        Variant::Tuned => (
            Params { adopt_solutions: true, prefer_solution: true, min_iterations: MIN_ITERATIONS, ..text },
            "pmbs_contour",
            SECONDS_TUNED,
        ),
        Variant::Dissertation => (text, "pmbs", SECONDS),
        Variant::Code => (code(text), "pmbs", SECONDS_CODE),
    };
    let confirm = match options.variant {
        Variant::Tuned => Some(PhysicsOptions::named("prism", None, Purpose::Planning)?),
        Variant::Dissertation | Variant::Code => None,
    };
    Ok(Recipe {
        confirm,
        ..Recipe::new(
            search,
            PhysicsOptions::named("planar", None, Purpose::Planning)?,
            sampler,
            Reward { shaping: 0.1, solved_score: options.grasp.solved_score },
            Budget::seconds(seconds),
        )
    })
}

fn code(text: Params) -> Params {
    let exploration = 0.3 * std::f64::consts::SQRT_2;
    let serial = Params { selection: Selection::Ucb { mean: Mean::All, exploration }, ..text };
    if serial.lanes == 1 {
        return serial;
    }
    Params {
        first_expand: true,
        early_stop: EarlyStop::LevelComplete { first: 2, last: None },
        rollout_cutoff: 0.1,
        ..serial
    }
}
