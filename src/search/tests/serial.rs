//! One lane against a plain implementation of the published loop, written for clarity alone.

use super::*;
use crate::run::{Key, Stop, Stream};
use crate::search::toy::ToyState;

struct Plain {
    state: ToyState,
    /// Action, and whether rollouts leave it out.
    actions: Vec<(u32, bool)>,
    untried: Vec<usize>,
    dead: Vec<usize>,
    children: Vec<(usize, Plain)>,
    returns: Vec<f64>,
    level: u32,
    key: Key,
}

struct Rules<'a> {
    toy: &'a Toy,
    top: usize,
    exploration: f64,
    discount: f64,
    depth: u32,
}

impl Rules<'_> {
    /// The domain's answer for one state, by way of the domain's own code.
    fn node(&self, state: ToyState, level: u32, key: Key) -> Plain {
        let mut out = Outcome::default();
        self.toy.root(&mut 0, &state, key, &mut out, &Stop::never());
        let listed = if out.terminal { Vec::new() } else { out.candidates };
        let actions: Vec<_> = listed.iter().map(|c| (c.action, c.expansion_only)).collect();
        let untried = (0..actions.len()).collect();
        Plain { state, actions, untried, dead: vec![], children: vec![], returns: vec![], level, key }
    }

    /// One attempt at an iteration: the return at `node`, or nothing if the action was illegal.
    fn visit(&self, node: &mut Plain, stream: &mut Stream) -> Option<f64> {
        let own = self.toy.value(&node.state);
        let ended = self.toy.terminal(&node.state) || node.level >= self.depth;
        let result = if !ended && !node.untried.is_empty() {
            let place = node.untried.remove(stream.index(node.untried.len()));
            let Some(state) = self.toy.next(&node.state, node.actions[place].0) else {
                node.dead.push(place);
                return None;
            };
            let mut child = self.node(state, node.level + 1, node.key.child(place as u64));
            let result = self.roll_out(&child, stream);
            child.returns.push(result);
            node.children.push((place, child));
            node.children.sort_by_key(|(place, _)| *place);
            Some(result)
        } else if !ended && !node.children.is_empty() {
            let log = 2.0 * (node.returns.len() as f64).ln();
            let mut best = (0, f64::NEG_INFINITY);
            for (index, (_, child)) in node.children.iter().enumerate() {
                let mut returns = child.returns.clone();
                returns.sort_by(|a, b| b.total_cmp(a));
                returns.truncate(self.top);
                let visits = child.returns.len() as f64;
                let mean = returns.iter().sum::<f64>() / returns.len() as f64;
                let score = mean + self.exploration * (log / visits).sqrt();
                if score > best.1 {
                    best = (index, score);
                }
            }
            Some(self.visit(&mut node.children[best.0].1, stream)?)
        } else {
            None
        };
        let result = match result {
            Some(result) => (result * self.discount).max(own),
            // Visited again: nothing can be done here, so the state itself is the return.
            None => own,
        };
        node.returns.push(result);
        Some(result)
    }

    fn roll_out(&self, from: &Plain, stream: &mut Stream) -> f64 {
        let mut best = self.toy.value(&from.state);
        let mut factor = 1.0;
        let mut here = self.node(from.state.clone(), from.level, from.key);
        while !self.toy.terminal(&here.state) && here.level < self.depth {
            let free: Vec<usize> = (0..here.actions.len()).filter(|&place| !here.actions[place].1).collect();
            if free.is_empty() {
                break;
            }
            let place = free[stream.index(free.len())];
            let Some(state) = self.toy.next(&here.state, here.actions[place].0) else { break };
            here = self.node(state, here.level + 1, here.key.child(place as u64));
            factor *= self.discount;
            best = f64::max(best, factor * self.toy.value(&here.state));
        }
        best
    }
}

fn dump_plain(node: &Plain, place: usize, top: usize, toy: &Toy, text: &mut String) {
    let mut best = node.returns.clone();
    best.sort_by(|a, b| b.total_cmp(a));
    best.truncate(top);
    // The tree adds returns in the order of their arrival.
    let sum = node.returns.iter().fold(0.0, |sum, value| sum + value);
    let indent = node.level as usize * 2;
    let first = best.first().copied().unwrap_or(f64::NEG_INFINITY);
    let _ = write!(text, "{:indent$}{place} n={} sum={sum:?} best={first:?}", "", node.returns.len());
    let _ = write!(text, " top={best:?} value={:?}", toy.value(&node.state));
    if toy.terminal(&node.state) {
        text.push_str(" solution");
    }
    let mut dead = node.dead.clone();
    dead.sort_unstable();
    let _ = writeln!(text, " untried={:?} dead={dead:?}", node.untried);
    for (place, child) in &node.children {
        dump_plain(child, *place, top, toy, text);
    }
}

#[test]
fn one_lane_is_plain_uct() {
    for seed in 0..20 {
        let toy = Toy { seed, branching: 3 + seed as u32 % 4, ..Toy::default() };
        let params = Params::vft();
        let (tree, report) = search(&toy, &params, seed, 150, 1);
        let rules =
            Rules { toy: &toy, top: 3, exploration: std::f64::consts::SQRT_2, discount: 0.8, depth: params.max_depth };
        let mut root = rules.node(toy.start(), 0, Key::new(seed).child(0));
        let mut done = 0;
        for ordinal in 0..tree.ordinal {
            let mut stream = Key::new(seed).child(1).child(ordinal).stream();
            done += u64::from(rules.visit(&mut root, &mut stream).is_some());
        }
        let mut text = String::new();
        dump_plain(&root, 0, 3, &toy, &mut text);
        assert_eq!(dump(&tree), text, "seed {seed}");
        assert_eq!(done, report.iterations);
        assert!(report.iterations == 150 || report.reason == EndReason::Exhausted);
    }
}
