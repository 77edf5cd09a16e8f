//! The dependency graph of a rearrangement: which body must leave before which can go home (Han et al. 2018; TRLB).
//!
//! For pick-and-place every body needs one move if the graph has no cycle. The bodies that move twice or more in any
//! plan meet every cycle (a feedback vertex set), so `misplaced bodies + least feedback set` is a lower bound on moves.

use crate::scene::Mask;

/// Who waits for whom. An edge from a body to each body in its way.
#[derive(Debug, Clone, Default)]
pub struct Graph {
    blocked_by: Vec<Mask>,
    reach: Vec<Mask>,
}

impl Graph {
    /// Becomes a graph of `bodies` bodies that nobody blocks.
    pub fn clear(&mut self, bodies: usize) {
        self.blocked_by.clear();
        self.blocked_by.resize(bodies, Mask::EMPTY);
        self.reach.clear();
    }

    pub fn set(&mut self, body: usize, blockers: Mask) {
        self.blocked_by[body] = blockers;
        self.reach.clear();
    }

    pub fn blockers(&self, body: usize) -> Mask {
        self.blocked_by[body]
    }

    /// Works out which bodies must move before each one, directly or not.
    pub fn close(&mut self) {
        self.reach.clone_from(&self.blocked_by);
        let bodies = self.reach.len();
        for through in 0..bodies {
            let beyond = self.reach[through];
            for body in 0..bodies {
                if self.reach[body].contains(through) {
                    self.reach[body] = self.reach[body] | beyond;
                }
            }
        }
    }

    /// Bodies that must move before `body`; [`close`](Self::close) must have been called.
    pub fn reach(&self, body: usize) -> Mask {
        self.reach.get(body).copied().unwrap_or_default()
    }

    /// Bodies that wait for themselves.
    pub fn cyclic(&self) -> Mask {
        let mut mask = Mask::EMPTY;
        for body in 0..self.reach.len() {
            if self.reach[body].contains(body) {
                mask.insert(body);
            }
        }
        mask
    }

    /// Nobody among `bodies` waits in a circle.
    pub fn acyclic(&self, bodies: Mask) -> bool {
        let mut left = bodies;
        loop {
            let before = left;
            for body in before.iter() {
                if (self.blocked_by[body] & left).is_empty() {
                    left.remove(body);
                }
            }
            if left.is_empty() || left == before {
                return left.is_empty();
            }
        }
    }

    /// The strongly connected parts of the bodies that wait in circles; [`close`](Self::close) must have been called.
    pub fn parts(&self) -> Vec<Mask> {
        let mut parts = Vec::new();
        let mut left = self.cyclic();
        while let Some(body) = left.iter().next() {
            let mut part = Mask::EMPTY;
            let together = |other: &usize| self.reach[body].contains(*other) && self.reach[*other].contains(body);
            left.iter().filter(together).for_each(|other| part.insert(other));
            left = left.without(part);
            parts.push(part);
        }
        parts
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub fn graph(edges: &[(usize, usize)], bodies: usize) -> Graph {
        let mut graph = Graph::default();
        graph.clear(bodies);
        for &(from, to) in edges {
            let mut mask = graph.blockers(from);
            mask.insert(to);
            graph.set(from, mask);
        }
        graph.close();
        graph
    }

    #[test]
    fn what_must_move_first_is_found_through_others() {
        let chain = graph(&[(0, 1), (1, 2), (3, 0)], 4);
        assert_eq!(chain.reach(3), Mask::from(0b111));
        assert!(chain.cyclic().is_empty());
    }
}
