//! What is left to expand: open actions per subtree, complete levels, solutions, and the depth limit they lower.

use super::arena::{Arena, NONE, Tried, UNSOLVED};
use super::domain::Domain;
use super::params::{EarlyStop, Params, RolloutDepth};

/// The search's bookkeeping across the whole tree ("PMBS bookkeeping").
#[derive(Debug, Default)]
pub(super) struct Frontier {
    /// Greatest level of a node; lowered by solutions.
    pub max_depth: u32,
    pub rollout_extra: u32,
    shrink: bool,
    /// Level of the shallowest solution, or `UNSOLVED`.
    pub solution: u32,
    /// Leading levels of which every node is terminal or fully expanded.
    complete: u32,
    /// Nodes per level with actions that are untried or pending.
    unfinished: Vec<u32>,
    /// Greatest level of a node in the tree.
    pub depth: u32,
    /// Real nodes.
    pub nodes: u64,
}

impl Frontier {
    /// Reads everything anew from the tree: at the start of a search, or for one that goes on.
    pub fn begin<D: Domain>(&mut self, params: &Params, arena: &mut Arena<D>) {
        self.max_depth = params.max_depth;
        self.rollout_extra = params.rollout_extra;
        self.shrink = params.shrink_depth_on_solution;
        self.solution = UNSOLVED;
        self.complete = 0;
        self.depth = 0;
        self.nodes = 0;
        self.unfinished.clear();
        for node in 0..arena.len() as u32 {
            let (real, level) = (arena.node(node).real, arena.node(node).level);
            let unfinished = arena.stat(node).untried + arena.stat(node).pending > 0;
            arena.stat_mut(node).solved = UNSOLVED;
            if real {
                self.depth = self.depth.max(level);
                self.nodes += 1;
                *self.level(level) += u32::from(unfinished);
            }
        }
        for node in 0..arena.len() as u32 {
            if arena.node(node).real && arena.node(node).terminal {
                self.solve(arena, node);
            }
        }
        self.recount(arena);
        if arena.len() > 0 {
            self.complete_levels();
        }
    }

    /// Selects an untried action.
    pub fn take<D: Domain>(&self, arena: &mut Arena<D>, node: u32, edge: u32) {
        arena.edge_mut(edge).tried = Tried::Pending;
        arena.stat_mut(node).untried -= 1;
        arena.stat_mut(node).pending += 1;
        self.add_open(arena, node, 1, false);
    }

    /// Takes a selection back: the action could not be finished.
    pub fn untake<D: Domain>(&self, arena: &mut Arena<D>, node: u32, edge: u32) {
        arena.edge_mut(edge).tried = Tried::No;
        arena.stat_mut(node).untried += 1;
        arena.stat_mut(node).pending -= 1;
        if arena.node(node).level < self.max_depth {
            self.add_open(arena, node, 1, true);
        }
    }

    /// Removes a selected action that is illegal.
    pub fn kill<D: Domain>(&mut self, arena: &mut Arena<D>, node: u32, edge: u32) {
        arena.edge_mut(edge).tried = Tried::Dead;
        self.resolve(arena, node);
    }

    /// Makes the child of a selected action a node of the tree.
    pub fn attach<D: Domain>(&mut self, arena: &mut Arena<D>, child: u32) {
        let (parent, edge, level) = (arena.node(child).parent, arena.node(child).edge, arena.node(child).level);
        if parent != NONE {
            arena.edge_mut(edge).tried = Tried::Yes;
            self.resolve(arena, parent);
        }
        arena.node_mut(child).real = true;
        self.depth = self.depth.max(level);
        self.nodes += 1;
        let untried = arena.stat(child).untried;
        *self.level(level) += u32::from(untried > 0);
        if level < self.max_depth {
            self.add_open(arena, child, untried, true);
        }
        if arena.node(child).terminal {
            self.solve(arena, child);
            if self.shrink && level > 0 && level < self.max_depth {
                self.recount(arena);
            }
        }
    }

    /// Counts the leading complete levels. Called between waves, when nothing is pending.
    pub fn complete_levels(&mut self) {
        while self.complete < self.max_depth && self.unfinished.get(self.complete as usize).copied().unwrap_or(0) == 0 {
            self.complete += 1;
        }
    }

    /// Whether the shallowest solution is as shallow as the rule wants it.
    pub fn solved(&self, rule: EarlyStop) -> bool {
        match rule {
            EarlyStop::Never => false,
            EarlyStop::LevelComplete { first, last } => {
                let stop = first.max(self.complete + 1).min(last.unwrap_or(u32::MAX));
                self.solution <= stop
            }
        }
    }

    /// No sequence of fewer actions solves the problem, with the actions that the domain listed.
    pub fn proved(&self) -> u32 {
        self.solution.min(self.complete + 1)
    }

    /// Level down to which a rollout from a node of `level` goes.
    pub fn rollout_limit(&self, params: &Params, level: u32) -> u32 {
        match params.rollout_depth {
            RolloutDepth::AtLeast => self.max_depth.max(level + self.rollout_extra),
            RolloutDepth::Sum => self.max_depth + self.rollout_extra,
        }
    }

    /// One pending action less.
    fn resolve<D: Domain>(&mut self, arena: &mut Arena<D>, node: u32) {
        let level = arena.node(node).level;
        let stats = arena.stat_mut(node);
        stats.pending -= 1;
        if stats.untried + stats.pending == 0 {
            *self.level(level) -= 1;
        }
    }

    /// Tells a solution to its ancestors. The recount that a lower limit needs is the caller's.
    fn solve<D: Domain>(&mut self, arena: &mut Arena<D>, solution: u32) {
        let (level, quality, cost) =
            (arena.node(solution).level, arena.node(solution).quality, arena.node(solution).cost);
        let mut node = solution;
        while node != NONE {
            let stats = arena.stat_mut(node);
            let better = level < stats.solved
                || (level == stats.solved
                    && (quality > stats.solved_quality
                        || (quality == stats.solved_quality && cost < stats.solved_cost)));
            if !better {
                break;
            }
            (stats.solved, stats.solved_quality, stats.solved_cost) = (level, quality, cost);
            node = arena.node(node).parent;
        }
        self.solution = self.solution.min(level);
    }

    /// Applies the depth limit and counts the open actions of every subtree: children come after their parents, so one
    /// pass from the back suffices.
    fn recount<D: Domain>(&mut self, arena: &mut Arena<D>) {
        if self.shrink && self.solution < self.max_depth && self.solution > 0 {
            self.max_depth = self.solution;
            self.rollout_extra = 0;
        }
        for node in 0..arena.len() as u32 {
            let counts = arena.node(node).real && arena.node(node).level < self.max_depth;
            let stats = arena.stat_mut(node);
            stats.open = if counts { stats.untried } else { 0 };
        }
        for node in (1..arena.len() as u32).rev() {
            let (parent, open) = (arena.node(node).parent, arena.stat(node).open);
            arena.stat_mut(parent).open += open;
        }
    }

    fn add_open<D: Domain>(&self, arena: &mut Arena<D>, from: u32, count: u32, more: bool) {
        let mut node = from;
        while node != NONE {
            let open = &mut arena.stat_mut(node).open;
            *open = if more { *open + count } else { *open - count };
            node = arena.node(node).parent;
        }
    }

    fn level(&mut self, level: u32) -> &mut u32 {
        let level = level as usize;
        if self.unfinished.len() <= level {
            self.unfinished.resize(level + 1, 0);
        }
        &mut self.unfinished[level]
    }
}
