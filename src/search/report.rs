//! What a search is given besides its problem, and what it tells.

use std::time::Duration;

use crate::run::{Budget, Pool, Progress, Stop, StopReason};

use super::Domain;

/// The surroundings of a search.
#[derive(Debug, Clone, Copy)]
pub struct Run<'a> {
    /// Where actions are executed.
    pub pool: &'a Pool,
    /// When to end before the budget is used.
    pub stop: &'a Stop,
    /// Iterations and bytes; the seconds are `stop`'s.
    pub budget: Budget,
    /// Where to tell how far the search is; published after every wave.
    pub progress: Option<Told<'a>>,
}

/// Where a search tells how far it is, and what earlier searches of the same decision did: to those who watch, a decision
/// that searches several times goes forward.
#[derive(Debug, Clone, Copy)]
pub struct Told<'a> {
    pub progress: &'a Progress,
    /// Iterations of the earlier searches.
    pub iterations: u64,
    /// Actions that they simulated.
    pub simulations: u64,
}

impl<'a> From<&'a Progress> for Told<'a> {
    fn from(progress: &'a Progress) -> Self {
        Told { progress, iterations: 0, simulations: 0 }
    }
}

impl<'a> Told<'a> {
    /// For the search after that of the report.
    pub fn and(self, report: &SearchReport) -> Self {
        Told {
            iterations: self.iterations + report.iterations,
            simulations: self.simulations + report.simulations,
            ..self
        }
    }
}

/// Why a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndReason {
    /// A solution that satisfies `early_stop` was found, or the root is one.
    Solved,
    /// Everything within the depth limit was tried.
    Exhausted,
    /// The budget of iterations is used.
    Iterations,
    /// The budget of memory would be exceeded.
    Memory,
    /// The time is up.
    Deadline,
    /// A cancel token was triggered.
    Cancelled,
    /// The progress callback asked for the end.
    Interrupted,
}

impl From<StopReason> for EndReason {
    fn from(reason: StopReason) -> Self {
        match reason {
            StopReason::Deadline => EndReason::Deadline,
            StopReason::Cancelled => EndReason::Cancelled,
            StopReason::Interrupted => EndReason::Interrupted,
        }
    }
}

/// The result of a search in numbers. The counts are this search's, the levels and nodes the tree's.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchReport {
    /// Why the search ended.
    pub reason: EndReason,
    /// Backed-up pairs of node and action.
    pub iterations: u64,
    /// Actions executed by the domain.
    pub simulations: u64,
    /// Actions whose outcome an earlier rollout had found.
    pub reused: u64,
    /// Waves of selection, expansion, rollout and backup.
    pub waves: u64,
    /// Nodes of the tree, without states that only rollouts have seen.
    pub nodes: u64,
    /// Nodes of the tree and states kept of rollouts.
    pub stored: u64,
    /// Estimated bytes of both.
    pub bytes: usize,
    /// Level of the deepest node.
    pub depth: u32,
    /// Level of the shallowest solution among the nodes.
    pub solution_level: Option<u32>,
    /// No solution has fewer actions than this, of those that the domain listed: every node of all shallower levels is
    /// fully expanded. A solution of this level is shortest.
    pub proved_level: u32,
    /// Index of the action chosen at the root; `None` where no action was finished.
    pub best_action: Option<usize>,
    /// Score of that action, by `final_choice`.
    pub best_value: f64,
    /// The whole search.
    pub time: Duration,
    /// The part spent in the domain, as seen by the searching thread. The rest is the search's own.
    pub step_time: Duration,
}

/// An action of the root, for explanations.
pub struct ActionInfo<'a, D: Domain> {
    /// Its place in the domain's list.
    pub index: usize,
    /// The action.
    pub action: &'a D::Action,
    /// What was expected of it.
    pub prior: f32,
    /// It is illegal.
    pub illegal: bool,
    /// The node it leads to; `None` where it was not tried or is illegal.
    pub node: Option<NodeInfo<'a, D>>,
    /// Its score by `final_choice`; `None` where there is no node.
    pub score: Option<f64>,
}

/// A node, for explanations and training data.
pub struct NodeInfo<'a, D: Domain> {
    /// Names the node within this tree, until the tree changes.
    pub id: usize,
    /// The node before; `None` at the root.
    pub parent: Option<usize>,
    /// The action that led here, and its place in the parent's list; `None` at the root.
    pub action: Option<(usize, &'a D::Action)>,
    /// What was expected of that action; 0 at the root.
    pub prior: f32,
    /// The state.
    pub state: &'a D::State,
    /// Number of actions from the root.
    pub level: u32,
    /// The state's own value.
    pub value: f64,
    /// It is a solution.
    pub terminal: bool,
    /// How good a solution it is.
    pub quality: f64,
    /// Cost of the path, from the root that was searched first.
    pub cost: f64,
    /// Iterations through the node.
    pub visits: u32,
    /// Mean of all its returns.
    pub mean: f64,
    /// Greatest of them; 0 before the first.
    pub best: f64,
    /// Actions that were not tried.
    pub untried: usize,
    /// Level of the shallowest solution from here down.
    pub solved_level: Option<u32>,
}
