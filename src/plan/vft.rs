//! `vft`: Visual Foresight Trees (dissertation, chapter VFT), and `dipn`, its baseline that looks one push ahead.
//!
//! Pushes are predicted by the network DIPN and states are judged by the network GC, whose grasps come from the geometric
//! test; both can be exchanged by name, so `vft` runs on every engine and scorer.
//!
//! Serial UCT with the mean of the three best returns, depth 4, 150 iterations, 74 mm pushes. The published reward is
//! the grasp network's value itself, unbounded above; here it is that value in [0, 1], and 1 more where it solves.
//! Pushes that go on in one line are executed as one motion: two whose directions differ by less than 0.2 rad, the second
//! beginning within 5 cm of the first one's end.
//!
//! * `Dissertation`: as above; discount 0.8.
//! * `Code`: discount 0.6, pushes in the sampler's order, and the returns of the published code: the greatest plain value's,
//!   replaced by a node's own.
//! * `Tuned`, the default: as the text, with a shortest known plan preferred, an end as soon as a level that has a solution
//!   is complete, a tree that does not visit what is settled again, and plans confirmed in `prism` before the decision.
//!
//! `dipn` tries every push of the root and takes the one after which the target is graspable best.

use super::options::{PlannerOptions, Variant};
use super::recipe::{Join, Recipe};
use super::retrieval::Reward;
use crate::error::Result;
use crate::physics::{PhysicsOptions, Purpose};
use crate::run::Budget;
use crate::search::{Backup, Closed, EarlyStop, Expansion, Params, Return};

/// Published iterations of a decision.
const ITERATIONS: u64 = 150;
/// More than a root has pushes.
const EVERY_PUSH: u64 = 512;
/// When two pushes are one motion.
const JOIN: Join = Join { angle: 0.2, distance: 0.05 };

pub fn recipe(options: &PlannerOptions) -> Result<Recipe> {
    let text = Params::vft();
    let search = match options.variant {
        Variant::Tuned => Params {
            prefer_solution: true,
            early_stop: EarlyStop::LevelComplete { first: 1, last: None },
            closed: Closed::Skip,
            shrink_depth_on_solution: true,
            ..text
        },
        Variant::Dissertation => text,
        Variant::Code => Params {
            discount: 0.6,
            expansion: Expansion::InOrder,
            returns: Return::BestPlain,
            backup: Backup::OwnIfBestPlain,
            ..text
        },
    };
    let confirm = match options.variant {
        Variant::Tuned => Some(PhysicsOptions::named("prism", None, Purpose::Planning)?),
        Variant::Dissertation | Variant::Code => None,
    };
    Ok(Recipe { confirm, ..with(options, search, ITERATIONS)? })
}

/// One push ahead.
pub fn greedy(options: &PlannerOptions) -> Result<Recipe> {
    let search = Params { max_depth: 1, closed: Closed::Skip, ..Params::vft() };
    with(options, search, EVERY_PUSH)
}

fn with(options: &PlannerOptions, search: Params, iterations: u64) -> Result<Recipe> {
    Ok(Recipe {
        scorer: "gc".into(),
        join: Some(JOIN),
        ..Recipe::new(
            search,
            // Not looked up by name: a build without the network can be given another.
            PhysicsOptions { engine: "dipn".into(), preset: "dipn".into(), settings: None },
            "vft",
            Reward { shaping: 1.0, solved_score: options.grasp.solved_score },
            Budget::iterations(iterations),
        )
    })
}
