//! Backup: every pair's return goes up to the root, in the order of the lanes.

use super::Search;
use super::arena::NONE;
use super::domain::Domain;
use super::params::{Backup, Mean, Params, Selection};

impl<D: Domain> Search<'_, D> {
    /// Backs up all pairs of the wave; each is one iteration.
    pub(super) fn back_up(&mut self) {
        let counted = counted(&self.params);
        for pair in &self.work.pairs {
            let (mut node, mut value, mut plain) = (pair.child, pair.value, pair.plain);
            loop {
                let own = self.arena.node(node).value;
                match self.params.backup {
                    Backup::AsIs => {}
                    Backup::GreatestWithOwn => value = value.max(own),
                    Backup::OwnIfBestPlain => {
                        if plain <= own {
                            (value, plain) = (own, own);
                        }
                    }
                }
                self.arena.add_return(node, value, counted);
                let parent = self.arena.node(node).parent;
                if parent == NONE {
                    break;
                }
                value *= self.arena.node(node).discount;
                node = parent;
            }
            self.iterations += 1;
        }
    }
}

/// How many of the best returns enter the score of a child in selection.
pub(super) fn counted(params: &Params) -> usize {
    match params.selection {
        Selection::Ucb { mean: Mean::Top(m), .. } => m as usize,
        Selection::Ucb { mean: Mean::All, .. } => 0,
        Selection::Guided { top, .. } => top as usize,
    }
}
