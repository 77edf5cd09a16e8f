//! Keeping the part of the tree below an executed action.

use super::arena::Tried;
use super::domain::Domain;
use super::tree::Tree;

impl<D: Domain> Tree<D> {
    /// Makes the node behind the root's action `index` the root and drops everything else; all levels fall by one. For
    /// an action that was executed and did what was predicted: then [`resume`](Self::resume) goes on with what is known
    /// already. Keys stay, so every state below keeps its list of actions.
    ///
    /// Returns false, and changes nothing, where the action was not tried, is illegal or does not exist.
    pub fn advance(&mut self, index: usize) -> bool {
        if !self.valid || index >= self.arena.node(0).count as usize {
            return false;
        }
        let edge = self.arena.edge(self.arena.node(0).first + index as u32);
        if edge.tried != Tried::Yes {
            return false;
        }
        let child = edge.child;
        self.arena.keep_below(child, &mut self.work.map);
        self.frontier.begin(&self.params, &mut self.arena);
        true
    }
}
