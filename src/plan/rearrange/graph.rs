//! The dependency graph of a rearrangement: which body must leave before which can go home (Han et al. 2018; TRLB).
//!
//! For pick-and-place every body needs one move if the graph has no cycle. The bodies that move twice or more in any
//! plan meet every cycle (a feedback vertex set), so `misplaced bodies + least feedback set` is a lower bound on moves.

use crate::scene::Mask;

/// Sets of vertices looked at before the search for a least feedback set becomes greedy.
const MOST_SETS: usize = 20_000;
/// Least feedback sets that are listed.
const MOST_LISTED: usize = 64;

/// Who waits for whom. An edge from a body to each body in its way.
#[derive(Debug, Clone, Default)]
pub struct Graph {
    blocked_by: Vec<Mask>,
    reach: Vec<Mask>,
}

/// A least set of bodies without which nobody waits in a circle.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Feedback {
    /// No set has fewer members.
    pub at_least: usize,
    /// Sets of that size; where the search was cut short, one found greedily.
    pub sets: Vec<Mask>,
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
                    self.reach[body].0 |= beyond.0;
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
    fn acyclic(&self, bodies: Mask) -> bool {
        let mut left = bodies;
        loop {
            let before = left;
            for body in before.iter() {
                if self.blocked_by[body].0 & left.0 == 0 {
                    left.remove(body);
                }
            }
            if left.is_empty() || left == before {
                return left.is_empty();
            }
        }
    }

    /// The least feedback sets; [`close`](Self::close) must have been called.
    pub fn feedback(&self, out: &mut Feedback) {
        out.sets.clear();
        out.at_least = 0;
        let cyclic = self.cyclic();
        if cyclic.is_empty() {
            return;
        }
        let mut looked = 0;
        for size in 1..=cyclic.count() {
            out.at_least = size;
            if !self.subsets(cyclic, cyclic, Mask::EMPTY, size, &mut looked, &mut out.sets) {
                out.sets.clear();
                out.sets.push(self.greedy(cyclic));
                return;
            }
            if !out.sets.is_empty() {
                return;
            }
        }
    }

    /// Lists the feedback sets of `chosen` and `more` members of `from`; false if there are too many to look at.
    fn subsets(
        &self,
        cyclic: Mask,
        from: Mask,
        chosen: Mask,
        more: usize,
        looked: &mut usize,
        out: &mut Vec<Mask>,
    ) -> bool {
        if more == 0 {
            *looked += 1;
            if self.acyclic(Mask(cyclic.0 & !chosen.0)) && out.len() < MOST_LISTED {
                out.push(chosen);
            }
            return *looked < MOST_SETS;
        }
        let mut left = from;
        for body in from.iter() {
            left.remove(body);
            if left.count() + 1 < more {
                break;
            }
            let mut with = chosen;
            with.insert(body);
            if !self.subsets(cyclic, left, with, more - 1, looked, out) {
                return false;
            }
        }
        true
    }

    /// A feedback set, not always the least: the body with the most ways through it, again and again.
    fn greedy(&self, cyclic: Mask) -> Mask {
        let mut chosen = Mask::EMPTY;
        loop {
            let left = Mask(cyclic.0 & !chosen.0);
            if self.acyclic(left) {
                return chosen;
            }
            let ways = |body: usize| {
                let blocks = left.iter().filter(|&other| self.blocked_by[other].contains(body)).count();
                blocks * (self.blocked_by[body].0 & left.0).count_ones() as usize
            };
            let Some(best) = left.iter().max_by_key(|&body| (ways(body), usize::MAX - body)) else { return chosen };
            chosen.insert(best);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Key;

    fn graph(edges: &[(usize, usize)], bodies: usize) -> Graph {
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

    fn feedback(graph: &Graph) -> Feedback {
        let mut out = Feedback::default();
        graph.feedback(&mut out);
        out
    }

    #[test]
    fn a_chain_needs_no_waiting_place_and_a_swap_needs_one() {
        assert_eq!(feedback(&graph(&[(0, 1), (1, 2)], 3)).at_least, 0);
        let swap = feedback(&graph(&[(0, 1), (1, 0), (2, 0)], 3));
        assert_eq!(swap.at_least, 1);
        assert_eq!(swap.sets, [Mask(1), Mask(2)]);
        // Two circles that share body 1: it is the one to take out.
        assert_eq!(feedback(&graph(&[(0, 1), (1, 0), (1, 2), (2, 1)], 3)).sets, [Mask(2)]);
    }

    #[test]
    fn what_must_move_first_is_found_through_others() {
        let chain = graph(&[(0, 1), (1, 2), (3, 0)], 4);
        assert_eq!(chain.reach(3), Mask(0b111));
        assert!(chain.cyclic().is_empty());
    }

    #[test]
    fn a_least_feedback_set_is_least() {
        for seed in 0..50 {
            let mut stream = Key::new(seed).stream();
            let edges: Vec<(usize, usize)> =
                (0..14).map(|_| (stream.index(8), stream.index(8))).filter(|(a, b)| a != b).collect();
            let graph = graph(&edges, 8);
            let found = feedback(&graph);
            let least = (0u128..256).filter(|set| graph.acyclic(Mask(255 & !set))).map(u128::count_ones).min();
            assert_eq!(Some(found.at_least as u32), least, "{edges:?}");
            assert!(found.sets.iter().all(|set| graph.acyclic(Mask(255 & !set.0))));
            assert!(graph.acyclic(Mask(255 & !graph.greedy(graph.cyclic()).0)));
        }
    }
}
