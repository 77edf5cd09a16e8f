//! Selection: from the root to a pair of node and untried action, for every lane of a wave.

use super::Search;
use super::arena::{NONE, Stats, Tried};
use super::domain::Domain;
use super::params::{Closed, Expansion, Mean, Selection};
use super::wave::Pair;
use crate::run::Stream;

/// So many times in a row selection may end where there is nothing to try before it is led to where there is. Virtual
/// visits turn it away much sooner, except where exploration is 0 and no other child has a positive value.
const MOST_REPELS: u32 = 32;

/// Where a descent ended.
enum Landing {
    /// At an untried action.
    Pair { node: u32, edge: u32 },
    /// At a node with nothing left to try and no children.
    Closed(u32),
    /// At a node whose actions all belong to other lanes of this wave.
    Busy(u32),
}

impl<D: Domain> Search<'_, D> {
    /// Selects up to `wanted` pairs; fewer where the tree has no more. Virtual visits are cleared in the end.
    pub(super) fn select(&mut self, wanted: usize) {
        self.work.pairs.clear();
        self.work.touched.clear();
        let mut repels = 0;
        while self.work.pairs.len() < wanted && self.arena.stat(0).open > 0 {
            let key = self.key.child(*self.ordinal);
            let mut stream = key.stream();
            let only_open = self.params.closed == Closed::Skip || repels > MOST_REPELS;
            let (node, edge) = match self.descend(&mut stream, only_open) {
                Landing::Pair { node, edge } => {
                    self.frontier.take(self.arena, node, edge);
                    (node, Some(edge))
                }
                Landing::Closed(node) if self.params.closed == Closed::Revisit => (node, Some(NONE)),
                Landing::Closed(node) | Landing::Busy(node) => (node, None),
            };
            self.add_virtual_visit(node);
            if let Some(edge) = edge {
                self.work.pairs.push(Pair::new(node, edge, stream));
                *self.ordinal += 1;
                repels = 0;
            } else {
                repels += 1;
            }
        }
        self.clear_virtual_visits();
    }

    fn descend(&self, stream: &mut Stream, only_open: bool) -> Landing {
        let mut node = 0;
        loop {
            if self.arena.node(node).terminal || self.arena.node(node).level >= self.frontier.max_depth {
                return Landing::Closed(node);
            }
            let untried = (self.arena.stat(node).untried > 0).then(|| self.untried(node, stream)).flatten();
            if let Some(edge) = untried
                && self.params.expansion != Expansion::Compete
            {
                return Landing::Pair { node, edge };
            }
            match (self.best_child(node, only_open), untried) {
                (Some((child, score)), Some(edge)) => {
                    let Selection::Guided { limit, .. } = self.params.selection else {
                        return Landing::Pair { node, edge };
                    };
                    if f64::from(self.arena.edge(edge).prior).clamp(0.0, limit) >= score {
                        return Landing::Pair { node, edge };
                    }
                    node = child;
                }
                (Some((child, _)), None) => node = child,
                (None, Some(edge)) => return Landing::Pair { node, edge },
                (None, None) if self.arena.stat(node).pending > 0 => return Landing::Busy(node),
                (None, None) => return Landing::Closed(node),
            }
        }
    }

    /// The untried action whose turn it is.
    fn untried(&self, node: u32, stream: &mut Stream) -> Option<u32> {
        let mut edges = self.arena.edges_of(node).filter(|&edge| self.arena.edge(edge).tried == Tried::No);
        match self.params.expansion {
            Expansion::Uniform => edges.nth(stream.index(self.arena.stat(node).untried as usize)),
            Expansion::InOrder => edges.next(),
            Expansion::BestPrior | Expansion::Compete => {
                let first = edges.next()?;
                let greater = |best, edge| {
                    if self.arena.edge(edge).prior > self.arena.edge(best).prior { edge } else { best }
                };
                Some(edges.fold(first, greater))
            }
        }
    }

    /// The child with the greatest score, the first of equals.
    fn best_child(&self, node: u32, only_open: bool) -> Option<(u32, f64)> {
        let parent = self.arena.stat(node);
        let visits = f64::from(parent.visits) + self.params.virtual_loss * f64::from(parent.virtual_visits);
        let double_log = 2.0 * visits.max(1.0).ln();
        let mut best: Option<(u32, f64)> = None;
        for edge in self.arena.edges_of(node) {
            let edge = self.arena.edge(edge);
            if edge.tried != Tried::Yes {
                continue;
            }
            let child = self.arena.stat(edge.child);
            if only_open && child.open == 0 {
                continue;
            }
            let score = self.score(child, double_log, edge.prior);
            if best.is_none_or(|(_, other)| score > other) {
                best = Some((edge.child, score));
            }
        }
        best
    }

    /// The formulae of [`Selection`].
    fn score(&self, child: &Stats, double_log: f64, prior: f32) -> f64 {
        let visits = f64::from(child.visits) + self.params.virtual_loss * f64::from(child.virtual_visits);
        match self.params.selection {
            Selection::Ucb { mean, exploration } => {
                // Virtual visits are returns of 0: they enter the mean, of the best m until there are m.
                let value = match mean {
                    Mean::All => child.sum / visits,
                    Mean::Top(m) => child.top_sum / visits.min(f64::from(m)),
                };
                value + exploration * (double_log / visits).sqrt()
            }
            Selection::Guided { limit, .. } => (f64::from(prior).clamp(0.0, limit) + child.top_sum) / (1.0 + visits),
        }
    }

    fn add_virtual_visit(&mut self, from: u32) {
        self.work.touched.push(from);
        let mut node = from;
        while node != NONE {
            self.arena.stat_mut(node).virtual_visits += 1;
            node = self.arena.node(node).parent;
        }
    }

    /// Where a node is clear, its ancestors are.
    fn clear_virtual_visits(&mut self) {
        for &from in &self.work.touched {
            let mut node = from;
            while node != NONE && self.arena.stat(node).virtual_visits > 0 {
                self.arena.stat_mut(node).virtual_visits = 0;
                node = self.arena.node(node).parent;
            }
        }
    }
}
