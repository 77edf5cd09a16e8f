//! `hedge`: the planner of our own. Shortest plans are cheap to find, plans that survive are not.
//!
//! 1. Level 1, then level 2, are searched whole in the cheap engine (`planar`): every push of every state. What the
//!    search says of them is a proof: no plan of fewer pushes exists in the action set and the model.
//! 2. Where their plans do not last, level 3 is searched in the same way, whole if that takes no more than some ten
//!    thousand pushes. Where it frees the target by no plan, a guided search goes on below (the tree search of `pmbs`, in
//!    the same tree), as long as it takes.
//! 3. For every first push with a solution, simulated episodes in an ensemble of perturbed worlds (`episode`) tell how
//!    many actions it takes *on average* until the target is out, when the robot looks and plans again after every push.
//!    The first push with the least expectation is chosen; the better ones meet more worlds (`expect`).
//! 4. A level is searched only if its plans could be better: a plan of more than `n` pushes takes at least `n + 2`
//!    actions, so the decision ends with the level `n` whose best plan is expected to take no more.
//!
//! The pushes are those of `rich`: more of them cost a search that is fast anyway, and save about a quarter of an action on
//! `hard` and half of one on `confined` beside the published ones.
//!
//! The worlds: friction of the tip and of every body off by up to 20 %, bodies 1 mm (in proportion to the gripper's size)
//! and 1 degree from where they were seen, `prism` as engine, `fast` and `fine` in turn: a plan that works at one step length only is not to be trusted.
//! They are the same for all plans.

mod decision;
mod episode;
mod expect;

pub(super) use decision::{level, make};

use super::networks::Networks;
use super::options::PlannerOptions;
use super::recipe::Recipe;
use super::retrieval::Reward;
use crate::error::Result;
use crate::physics::{Ensemble, PhysicsOptions, Purpose};
use crate::run::{Budget, Key};
use crate::scene::{Problem, Uncertainty};
use crate::search::Params;

/// Lanes where the user sets none.
const LANES: usize = 64;
/// Limits of a decision. Where a plan is found, the caps on the work end it long before; the iterations come before the
/// seconds, so that what is decided does not depend on how busy the machine is.
const ITERATIONS: u64 = 65_536;
const SECONDS: f64 = 2.8;

pub fn recipe(options: &PlannerOptions) -> Result<Recipe> {
    let lanes = options.lanes.unwrap_or(LANES) as u32;
    let search =
        Params { adopt_solutions: true, prefer_solution: true, shrink_depth_on_solution: false, ..Params::pmbs(lanes) };
    Ok(Recipe {
        confirm: Some(PhysicsOptions::named("prism", None, Purpose::Planning)?),
        hedges: true,
        ..Recipe::new(
            search,
            PhysicsOptions::named("planar", None, Purpose::Planning)?,
            "rich",
            Reward { shaping: 0.1, solved_score: options.grasp.solved_score },
            Budget { iterations: Some(ITERATIONS), seconds: Some(SECONDS), bytes: None },
        )
    })
}

/// The worlds of a problem. Of the confirming engine, or of the search's where nothing is confirmed; every other one with
/// the finer preset, where the engine has one.
pub(super) fn ensemble(recipe: &Recipe, networks: &Networks, problem: &Problem, seed: u64) -> Result<Ensemble> {
    let (engine, network) = networks.worlds(recipe);
    let key = Key::new(seed).child(2);
    let finer = engine.finer();
    let engines: Vec<PhysicsOptions> = [engine].into_iter().chain(finer).collect();
    let usual = Uncertainty::default();
    // A cell for smaller things sees them the better.
    let scale = problem.scene.gripper().scale();
    let uncertainty = Uncertainty { position: scale * usual.position, border: scale * usual.border, ..usual };
    Ensemble::new(&problem.scene, &engines, network, uncertainty, expect::WORLDS, key)
}
