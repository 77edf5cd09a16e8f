//! The search tree as its user sees it.

use super::arena::{Arena, NONE, Tried, UNSOLVED};
use super::backup::counted;
use super::choose;
use super::domain::Domain;
use super::engine::{Search, renew_scratches};
use super::frontier::Frontier;
use super::params::Params;
use super::report::{ActionInfo, EndReason, NodeInfo, Run, SearchReport};
use super::wave::Workspace;
use crate::error::{Error, Result};
use crate::run::Key;

/// A search tree and the memory of its searches.
///
/// Keep one per planner and search with it again and again: a search of a size that the tree has held before allocates
/// nothing. The tree stays readable until the next search.
pub struct Tree<D: Domain> {
    pub(super) arena: Arena<D>,
    pub(super) frontier: Frontier,
    pub(super) work: Workspace<D>,
    pub(super) params: Params,
    /// Of the randomness of the search itself; states have keys of their own.
    key: Key,
    pub(super) ordinal: u64,
    wave: u32,
    /// False between the start of a search and its end without error.
    pub(super) valid: bool,
}

impl<D: Domain> Default for Tree<D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<D: Domain> std::fmt::Debug for Tree<D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Tree").field("stored", &self.arena.len()).field("valid", &self.valid).finish_non_exhaustive()
    }
}

impl<D: Domain> Tree<D> {
    /// An empty tree.
    pub fn new() -> Self {
        Tree {
            arena: Arena::default(),
            frontier: Frontier::default(),
            work: Workspace::default(),
            params: Params::vft(),
            key: Key::default(),
            ordinal: 0,
            wave: 0,
            valid: false,
        }
    }

    /// Empties the tree; its memory is kept for the next search.
    pub fn reset(&mut self) {
        self.arena.clear(1);
        self.valid = false;
    }

    /// Searches from `root` with an empty tree. The same (domain, root, parameters, seed, budget of iterations) gives
    /// bitwise the same tree at any number of threads.
    ///
    /// # Errors
    /// Parameters or a budget that cannot be used, by name; a root state that the domain refuses; a panic in the
    /// domain, or a number of it that is not finite. After an error the tree is empty.
    pub fn search(
        &mut self,
        domain: &D,
        root: &D::State,
        params: &Params,
        seed: u64,
        run: &Run<'_>,
    ) -> Result<SearchReport> {
        params.validate()?;
        run.budget.validate().map_err(|error| error.within("budget"))?;
        self.reset();
        self.arena.clear(params.remembered());
        self.key = Key::new(seed).child(1);
        self.ordinal = 0;
        self.wave = 0;
        self.go(domain, params, run, Some((root, Key::new(seed).child(0))))
    }

    /// Searches on in the tree as it is: after a search that ended for any reason, or after [`advance`](Self::advance).
    /// The random numbers go on where they were. Parameters may differ; what is in the tree stays as it was found.
    ///
    /// # Errors
    /// As [`search`](Self::search), and [`Error::State`] where there is no tree to go on with.
    pub fn resume(&mut self, domain: &D, params: &Params, run: &Run<'_>) -> Result<SearchReport> {
        params.validate()?;
        run.budget.validate().map_err(|error| error.within("budget"))?;
        if !self.valid {
            return Err(Error::State("there is no search to resume; call `search` first".into()));
        }
        self.arena.restride(params.remembered(), counted(params));
        self.go(domain, params, run, None)
    }

    fn go(
        &mut self,
        domain: &D,
        params: &Params,
        run: &Run<'_>,
        root: Option<(&D::State, Key)>,
    ) -> Result<SearchReport> {
        let begin = run.stop.elapsed();
        self.params = *params;
        self.valid = false;
        let report = self.try_go(domain, run, root, begin);
        match &report {
            Ok(_) => self.valid = self.arena.len() > 0,
            Err(_) => self.reset(),
        }
        report
    }

    fn try_go(
        &mut self,
        domain: &D,
        run: &Run<'_>,
        root: Option<(&D::State, Key)>,
        begin: std::time::Duration,
    ) -> Result<SearchReport> {
        renew_scratches(&mut self.work.scratches, domain, run);
        self.frontier.begin(&self.params, &mut self.arena);
        let mut search = Search {
            domain,
            params: self.params,
            run,
            key: self.key,
            arena: &mut self.arena,
            frontier: &mut self.frontier,
            work: &mut self.work,
            ordinal: &mut self.ordinal,
            wave: &mut self.wave,
            iterations: 0,
            simulations: 0,
            reused: 0,
            waves: 0,
            step_time: std::time::Duration::ZERO,
            full: false,
        };
        let planted = match root {
            Some((state, key)) => search.plant(state, key)?,
            None => Some(()),
        };
        let reason = match planted {
            Some(()) => search.search()?,
            None => run.stop.reason().map_or(EndReason::Interrupted, EndReason::from),
        };
        Ok(search.report(reason, begin))
    }

    /// Estimated bytes that the tree holds: what a byte budget limits.
    pub fn bytes(&self, domain: &D) -> usize {
        self.arena.bytes(domain.state_bytes(), domain.action_bytes())
    }

    /// The state at the root; `None` while the tree is empty.
    pub fn root_state(&self) -> Option<&D::State> {
        (self.arena.len() > 0).then(|| &self.arena.node(0).state)
    }

    /// The root's actions in the domain's order, tried or not.
    pub fn root_children(&self) -> impl Iterator<Item = ActionInfo<'_, D>> {
        let edges = if self.arena.len() > 0 { self.arena.edges_of(0) } else { 0..0 };
        edges.enumerate().map(|(index, id)| {
            let edge = self.arena.edge(id);
            let child = (edge.tried == Tried::Yes && self.arena.stat(edge.child).visits > 0).then_some(edge.child);
            ActionInfo {
                index,
                action: &edge.action,
                prior: edge.prior,
                illegal: edge.tried == Tried::Dead,
                node: child.map(|child| self.info(child)),
                score: child.map(|child| choose::score(&self.arena, &self.params, child, edge.prior)),
            }
        })
    }

    /// The best plan: the final choice at the root, then the way to the shallowest solution below it, or along the best
    /// children where there is none. Every element is the node that its action leads to. Empty where no action was
    /// finished.
    pub fn best_path(&self) -> Vec<NodeInfo<'_, D>> {
        choose::best_path(&self.arena, &self.params).into_iter().map(|node| self.info(node)).collect()
    }

    /// All nodes, parents before their children; without states that only rollouts have seen.
    pub fn nodes(&self) -> impl Iterator<Item = NodeInfo<'_, D>> {
        (0..self.arena.len() as u32).filter(|&node| self.arena.node(node).real).map(|node| self.info(node))
    }

    fn info(&self, id: u32) -> NodeInfo<'_, D> {
        let (node, stats) = (self.arena.node(id), self.arena.stat(id));
        let edge = (node.edge != NONE).then(|| self.arena.edge(node.edge));
        NodeInfo {
            id: id as usize,
            parent: (node.parent != NONE).then_some(node.parent as usize),
            action: edge.map(|edge| ((node.edge - self.arena.node(node.parent).first) as usize, &edge.action)),
            prior: edge.map_or(0.0, |edge| edge.prior),
            state: &node.state,
            level: node.level,
            value: node.value,
            terminal: node.terminal,
            quality: node.quality,
            cost: node.cost,
            visits: stats.visits,
            mean: if stats.visits > 0 { stats.sum / f64::from(stats.visits) } else { 0.0 },
            best: if stats.visits > 0 { stats.best } else { 0.0 },
            untried: stats.untried as usize,
            solved_level: (stats.solved != UNSOLVED).then_some(stats.solved),
        }
    }
}
