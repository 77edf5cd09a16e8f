//! Tree search for any domain: one engine for the searches of chapters VFT, MORE, PMBS and REMP.
//!
//! A [`Domain`] says what states and actions are; [`Params`] say how to search; [`Tree`] searches and holds the result.
//! Nothing here knows scenes, physics or networks.
//!
//! # One iteration
//!
//! * **Selection.** From the root, while every action of a node was tried, to the child with the greatest score, for
//!   instance `mean + c sqrt(2 ln N / n)` ([`Selection`]); then to an untried action ([`Expansion`]).
//! * **Expansion.** The action is executed. An illegal one is removed from its node, and the iteration does not count.
//!   A legal one makes a node of level (number of actions from the root) one more than its parent's.
//! * **Rollout.** On from there ([`RolloutPolicy`]) until a solution, an illegal action, a state without actions or the
//!   depth limit. The values seen make the return ([`Return`]).
//! * **Backup.** The return goes up to the root, multiplied by the discount at every action ([`Backup`]).
//!
//! In the end the root's action is chosen ([`FinalChoice`]).
//!
//! # Waves
//!
//! With `lanes > 1` iterations run in lock-step (PMBS, Algorithm Parallel-MCTS): selection for all lanes, one after the
//! other, each adding virtual visits that turn the next away; then all expansions at once; then all rollouts, step by
//! step; then backup, in the order of the lanes. Only executing actions is parallel. All random decisions are functions
//! of the seed and the iteration's number, and a state's key is a function of the seed and its path, so the tree is
//! bitwise the same at any number of threads. Lanes change the result, threads never do.
//!
//! # Rules
//!
//! * A budget of iterations counts backed-up pairs; time and cancelling are polled between the steps of a wave and, by
//!   the domain, within. An interrupted action is as if it had not been tried; an interrupted rollout counts as far as
//!   it went. The tree is valid after every end but an error.
//! * Bookkeeping allocates nothing once a tree has held a search of the same size.
//! * A [`Tree`] is used by one thread at a time (`&mut` searches, `&` reads); the search itself uses the pool's threads.

mod advance;
mod arena;
mod backup;
mod choose;
mod domain;
mod engine;
mod frontier;
mod params;
mod report;
mod rollout;
mod select;
mod tree;
mod wave;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod toy;

pub use domain::{Candidate, Domain, Job, Outcome, Status};
pub use params::{
    Backup, Closed, EarlyStop, Expansion, FinalChoice, Mean, Params, Return, RolloutDepth, RolloutFailure,
    RolloutPolicy, Selection,
};
pub use report::{ActionInfo, EndReason, NodeInfo, Run, SearchReport, Told};
pub use tree::Tree;

use engine::Search;
