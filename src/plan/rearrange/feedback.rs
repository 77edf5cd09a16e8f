//! Least feedback sets of the dependency graph: the fewest bodies without which nobody waits in a circle.
//!
//! Each strongly connected part is a problem of its own. Reductions (Levy and Low 1988) solve most of it; the rest is
//! tried for one size after the other, from the number of circles that have no body in common, so that the size is a
//! lower bound wherever the search is cut short.

use super::graph::Graph;
use crate::run::Stop;
use crate::scene::Mask;

/// Where there are at most this many sets of the least size, all are looked at, so that none is left out of the list.
const MOST_SETS: usize = 20_000;
/// Least feedback sets that are listed.
const MOST_LISTED: usize = 64;
/// Steps of the search for those of one part.
const MOST_STEPS: usize = 100;

/// The least sets of bodies without which nobody waits in a circle.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Feedback {
    /// No set has fewer members.
    pub at_least: usize,
    /// Sets of that size; where the search was cut short, one found greedily.
    pub sets: Vec<Mask>,
}

impl Feedback {
    /// Finds those of a graph that is [closed](Graph::close). Where the work is asked to end, what is known by then: a lower
    /// bound on their size, and some sets, not all of them least.
    pub fn find(&mut self, graph: &Graph, stop: &Stop) {
        self.sets.clear();
        let parts: Vec<Feedback> = graph.parts().into_iter().map(|part| Feedback::of_part(graph, part, stop)).collect();
        self.at_least = parts.iter().map(|part| part.at_least).sum();
        if parts.is_empty() {
            return;
        }
        let cyclic = graph.cyclic();
        let known = parts.iter().all(|part| part.sets[0].count() == part.at_least);
        if known && combinations(cyclic.count(), self.at_least) <= MOST_SETS {
            self.list(graph, cyclic, cyclic, Mask::EMPTY, self.at_least, stop);
            if !self.sets.is_empty() {
                return;
            }
        }
        // A set of each part, and what else one part after the other may have.
        let first = parts.iter().fold(Mask::EMPTY, |all, part| all | part.sets[0]);
        self.sets.push(first);
        for part in &parts {
            let rest = first.without(part.sets[0]);
            self.sets.extend(part.sets[1..].iter().map(|&set| rest | set));
        }
        self.sets.truncate(MOST_LISTED);
    }

    /// Lists the feedback sets of `chosen` and `more` members of `from`.
    fn list(&mut self, graph: &Graph, cyclic: Mask, from: Mask, chosen: Mask, more: usize, stop: &Stop) {
        if more == 0 {
            if graph.acyclic(cyclic.without(chosen)) {
                self.sets.push(chosen);
            }
            return;
        }
        let mut left = from;
        for body in from.iter() {
            left.remove(body);
            if left.count() + 1 < more || self.sets.len() >= MOST_LISTED || stop.requested() {
                break;
            }
            let mut with = chosen;
            with.insert(body);
            self.list(graph, cyclic, left, with, more - 1, stop);
        }
    }

    /// Those of a strongly connected part, by a search of one depth after the other.
    fn of_part(graph: &Graph, part: Mask, stop: &Stop) -> Feedback {
        let whole = Rest::of(graph, part);
        let mut steps = 0;
        let mut found = Feedback { at_least: whole.chosen.count() + whole.circles(), sets: Vec::new() };
        while whole.clone().search(found.at_least, &mut steps, &mut found.sets, stop) {
            if !found.sets.is_empty() {
                return found;
            }
            found.at_least += 1;
        }
        // What was not looked at may hold a set of this size; none is smaller.
        if found.sets.is_empty() {
            found.sets.push(whole.greedy());
        }
        found
    }
}

/// The number of sets of `k` of `n`, at most a little over [`MOST_SETS`].
fn combinations(n: usize, k: usize) -> usize {
    let mut count = 1;
    for step in 0..k.min(n - k) {
        count = count * (n - step) / (step + 1);
        if count > MOST_SETS {
            break;
        }
    }
    count
}

/// A part in the course of the search. Some bodies are chosen and gone. Others are passed over: whoever waited for them
/// waits for those that they waited for.
#[derive(Debug, Clone)]
struct Rest {
    left: Mask,
    chosen: Mask,
    blocked_by: Vec<Mask>,
    blocks: Vec<Mask>,
}

impl Rest {
    /// The part, reduced.
    fn of(graph: &Graph, part: Mask) -> Rest {
        let bodies = part.iter().last().map_or(0, |last| last + 1);
        let blockers = |body| if part.contains(body) { graph.blockers(body) & part } else { Mask::EMPTY };
        let blocked_by: Vec<Mask> = (0..bodies).map(blockers).collect();
        let mut blocks = vec![Mask::EMPTY; bodies];
        for body in part.iter() {
            blocked_by[body].iter().for_each(|blocker| blocks[blocker].insert(body));
        }
        let mut rest = Rest { left: part, chosen: Mask::EMPTY, blocked_by, blocks };
        rest.reduce();
        rest
    }

    fn remove(&mut self, body: usize) {
        self.left.remove(body);
        for blocker in self.blocked_by[body].iter() {
            self.blocks[blocker].remove(body);
        }
        for waiting in self.blocks[body].iter() {
            self.blocked_by[waiting].remove(body);
        }
    }

    fn choose(&mut self, body: usize) {
        self.chosen.insert(body);
        self.remove(body);
    }

    /// Leaves a body that does not wait for itself out of the set.
    fn pass(&mut self, body: usize) {
        self.remove(body);
        let (before, after) = (self.blocks[body], self.blocked_by[body]);
        before.iter().for_each(|waiting| self.blocked_by[waiting] = self.blocked_by[waiting] | after);
        after.iter().for_each(|blocker| self.blocks[blocker] = self.blocks[blocker] | before);
    }

    /// Does what needs no choice: a body that waits for itself is in every set, and instead of one with a single way in or
    /// out the body at its other end is as good.
    fn reduce(&mut self) {
        loop {
            let before = self.left;
            for body in before.iter() {
                if self.blocked_by[body].contains(body) {
                    self.choose(body);
                } else if self.blocks[body].count().min(self.blocked_by[body].count()) <= 1 {
                    self.pass(body);
                }
            }
            if self.left == before {
                return;
            }
        }
    }

    /// Lists sets of at most `size` members, or as many as are wanted; false if it was cut short.
    fn search(mut self, size: usize, steps: &mut usize, out: &mut Vec<Mask>, stop: &Stop) -> bool {
        *steps += 1;
        if *steps > MOST_STEPS || stop.requested() {
            return false;
        }
        self.reduce();
        if self.left.is_empty() {
            if self.chosen.count() <= size {
                out.push(self.chosen);
            }
            return true;
        }
        if self.chosen.count() + self.circles() > size || out.len() >= MOST_LISTED {
            return true;
        }
        let body = self.busiest();
        let mut with = self.clone();
        with.choose(body);
        self.pass(body);
        with.search(size, steps, out, stop) && self.search(size, steps, out, stop)
    }

    /// The body with the most ways through it.
    fn busiest(&self) -> usize {
        let ways = |body: &usize| (self.blocks[*body].count() * self.blocked_by[*body].count(), usize::MAX - body);
        self.left.iter().max_by_key(ways).unwrap_or_default()
    }

    /// A set, not always the least: the body with the most ways through it, again and again.
    fn greedy(mut self) -> Mask {
        while !self.left.is_empty() {
            self.choose(self.busiest());
            self.reduce();
        }
        self.chosen
    }

    /// A number of circles that have no body in common, the shortest first; each takes a body of any set.
    fn circles(&self) -> usize {
        let mut left = self.left;
        let mut count = 0;
        for length in 2.. {
            if left.count() < length {
                break;
            }
            for body in left.iter() {
                if left.contains(body)
                    && let Some(circle) = self.circle(body, length, left)
                {
                    left = left.without(circle);
                    count += 1;
                }
            }
        }
        count
    }

    /// A circle of at most `length` bodies of `left` through `body`.
    fn circle(&self, body: usize, length: usize, left: Mask) -> Option<Mask> {
        // Who is met after how many steps, until it is one who waits for the first.
        let mut met = vec![self.blocked_by[body] & left];
        let mut seen = met[0];
        loop {
            let last = met[met.len() - 1];
            let closing = last & self.blocks[body];
            if let Some(mut at) = closing.iter().next() {
                let mut circle = Mask::EMPTY;
                circle.insert(body);
                circle.insert(at);
                for earlier in met.iter().rev().skip(1) {
                    at = (*earlier & self.blocks[at]).iter().next()?;
                    circle.insert(at);
                }
                return Some(circle);
            }
            if met.len() + 2 > length {
                return None;
            }
            let next = last.iter().fold(Mask::EMPTY, |all, at| all | self.blocked_by[at]);
            let next = (next & left).without(seen);
            if next.is_empty() {
                return None;
            }
            seen = seen | next;
            met.push(next);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::graph::tests::graph;
    use super::*;
    use crate::run::Key;

    fn feedback(graph: &Graph) -> Feedback {
        let mut out = Feedback::default();
        out.find(graph, &Stop::never());
        out
    }

    #[test]
    fn a_chain_needs_no_waiting_place_and_a_swap_needs_one() {
        assert_eq!(feedback(&graph(&[(0, 1), (1, 2)], 3)).at_least, 0);
        let swap = feedback(&graph(&[(0, 1), (1, 0), (2, 0)], 3));
        assert_eq!(swap.at_least, 1);
        assert_eq!(swap.sets, [Mask::from(1), Mask::from(2)]);
        // Two circles that share body 1: it is the one to take out.
        assert_eq!(feedback(&graph(&[(0, 1), (1, 0), (1, 2), (2, 1)], 3)).sets, [Mask::from(2)]);
    }

    #[test]
    fn a_least_feedback_set_is_least() {
        for seed in 0..200 {
            let mut stream = Key::new(seed).stream();
            let count = 8 + 2 * stream.index(10);
            let edges: Vec<(usize, usize)> =
                (0..count).map(|_| (stream.index(9), stream.index(9))).filter(|(a, b)| a != b).collect();
            let graph = graph(&edges, 9);
            let found = feedback(&graph);
            let without = |set: Mask| graph.acyclic(Mask::first(9).without(set));
            let mut least: Vec<Mask> = (0..512).map(Mask::from).filter(|set| without(*set)).collect();
            least.sort_by_key(|set| set.count());
            least.retain(|set| set.count() == found.at_least);
            assert!(
                !least.is_empty() && (0..512).map(Mask::from).all(|set| set.count() >= found.at_least || !without(set))
            );
            if found.at_least > 0 {
                assert!(found.sets.iter().all(|set| least.contains(set)) && found.sets.len() == least.len().min(64));
            }
            // What the search finds by itself, without the list.
            for part in graph.parts() {
                let part = Feedback::of_part(&graph, part, &Stop::never());
                assert!(part.sets.iter().all(|set| set.count() == part.at_least), "{edges:?}");
            }
        }
    }

    #[test]
    fn cut_short_at_any_place_it_has_a_bound_and_a_set() {
        let mut stream = Key::new(7).stream();
        let edges: Vec<(usize, usize)> =
            (0..40).map(|_| (stream.index(16), stream.index(16))).filter(|(a, b)| a != b).collect();
        let graph = graph(&edges, 16);
        let whole = feedback(&graph);
        for looks in 0..200 {
            let mut cut = Feedback::default();
            cut.find(&graph, &Stop::after_looks(looks));
            assert!(cut.at_least <= whole.at_least, "{looks}");
            assert!(!cut.sets.is_empty() && cut.sets.iter().all(|set| graph.acyclic(Mask::first(16).without(*set))));
        }
    }

    #[test]
    fn the_bound_of_many_bodies_is_met_by_a_set() {
        for seed in 0..20 {
            let mut stream = Key::new(seed).stream();
            // As dependent on each other as discs that cover 0.3 of the table.
            let edges: Vec<(usize, usize)> =
                (0..180).map(|_| (stream.index(150), stream.index(150))).filter(|(a, b)| a != b).collect();
            let graph = graph(&edges, 150);
            let found = feedback(&graph);
            for set in &found.sets {
                assert!(graph.acyclic(Mask::first(150).without(*set)), "{seed}");
                assert_eq!(set.count(), found.at_least, "{seed}");
            }
        }
    }
}
