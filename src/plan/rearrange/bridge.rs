//! Two trees of states, one from the start and one from the goal, for problems whose attempts all fail.
//!
//! Where there is hardly any room, no attempt gets from the start to the goal in one go. As in TRLB (Gao et al. 2022) the
//! states that attempts have come to are kept, and new attempts lead from one of a tree to one of the other. An attempt
//! puts few bodies aside before it ends in a new state, so that a bad choice costs little, and makes room by pushing
//! bodies together.

use std::sync::Arc;

use super::mover::Mover;
use super::table::Layout;
use super::untangle::reversed;
use crate::action::Move;
use crate::geom::footprints_apart;
use crate::run::Stream;
use crate::scene::{PLACE_SLACK, State};

/// Poses kept in all states of a tree.
const MOST_POSES: usize = 400_000;
/// Chance that an attempt starts from, or leads to, the root of its tree.
const ROOT: f64 = 0.2;
/// States of the other tree of which the one with the fewest bodies in the way is taken: at most, and fewer where to look
/// at this many pairs of bodies takes fewer.
const RIVALS: usize = 20;
const PAIRS: usize = 2000;
/// Moves that an attempt has to have left besides one for each body.
const SPARE: usize = 2;

#[derive(Debug)]
struct Node {
    state: State,
    parent: usize,
    /// From the parent's state to this one.
    moves: Vec<Move>,
    /// Moves from the root.
    depth: usize,
}

/// States that the bodies can be brought to from a root.
#[derive(Debug)]
struct Tree {
    nodes: Vec<Node>,
}

impl Tree {
    fn new(root: State) -> Tree {
        Tree { nodes: vec![Node { state: root, parent: 0, moves: Vec::new(), depth: 0 }] }
    }

    fn draw(&self, stream: &mut Stream) -> usize {
        if stream.chance(ROOT) { 0 } else { stream.index(self.nodes.len()) }
    }

    /// The moves from the root to a node.
    fn moves_to(&self, node: usize) -> Vec<Move> {
        let mut pieces = Vec::new();
        let mut at = node;
        while at != 0 {
            pieces.push(&self.nodes[at].moves);
            at = self.nodes[at].parent;
        }
        pieces.into_iter().rev().flatten().cloned().collect()
    }
}

/// Where an attempt leads from and to: a node of one tree, and one of the other.
#[derive(Debug, Clone, Copy)]
pub struct Span {
    backwards: bool,
    from: usize,
    to: usize,
}

/// Both trees.
#[derive(Debug)]
pub struct Bridge {
    /// From the start, and from the goal.
    trees: [Tree; 2],
    max_moves: usize,
    /// Most moves to the states of a span together, so that enough are left to lead from the one to the other.
    deepest: usize,
}

impl Bridge {
    pub fn new(start: &State, goal: &State, bodies: usize, max_moves: usize) -> Bridge {
        let deepest = max_moves.saturating_sub(bodies + SPARE);
        Bridge { trees: [Tree::new(start.clone()), Tree::new(goal.clone())], max_moves, deepest }
    }

    /// Draws what to attempt next, and the most moves that it may take.
    pub fn draw(&self, mover: &Mover, stream: &mut Stream) -> (Span, usize) {
        let backwards = stream.chance(0.5);
        let (own, other) = (&self.trees[usize::from(backwards)], &self.trees[usize::from(!backwards)]);
        let from = own.draw(stream);
        let bodies = mover.table.len();
        let rivals = (PAIRS / (bodies * bodies)).clamp(2, RIVALS);
        let state = Layout::new(&own.nodes[from].state);
        let mut best = (usize::MAX, 0);
        for _ in 0..rivals {
            let to = other.draw(stream);
            if own.nodes[from].depth + other.nodes[to].depth <= self.deepest {
                best = best.min((conflicts(mover, &state, &Layout::new(&other.nodes[to].state)), to));
            }
        }
        let span = Span { backwards, from, to: best.1 };
        (span, self.max_moves.saturating_sub(own.nodes[from].depth + other.nodes[best.1].depth))
    }

    /// The problem of a span.
    pub fn mover(&self, mover: &Mover, span: Span) -> (Arc<Mover>, Layout) {
        let (own, other) = (&self.trees[usize::from(span.backwards)], &self.trees[usize::from(!span.backwards)]);
        let (from, to) = (&own.nodes[span.from].state, &other.nodes[span.to].state);
        (Arc::new(mover.with_table(mover.table.between(from, to))), Layout::new(from))
    }

    /// The moves of the whole plan if those of the attempt lead from one end of the span to the other.
    pub fn whole(&self, span: Span, moves: &[Move]) -> Vec<Move> {
        let there = |from: usize, to: usize, moves: &[Move]| {
            let mut whole = self.trees[0].moves_to(from);
            whole.extend_from_slice(moves);
            whole.extend(reversed(&self.trees[1].moves_to(to)));
            whole
        };
        if span.backwards { there(span.to, span.from, &reversed(moves)) } else { there(span.from, span.to, moves) }
    }

    /// Keeps the state that an attempt has come to.
    pub fn add(&mut self, span: Span, state: State, moves: Vec<Move>) {
        let tree = &mut self.trees[usize::from(span.backwards)];
        let depth = tree.nodes[span.from].depth + moves.len();
        let room = (tree.nodes.len() + 1) * state.len() <= MOST_POSES;
        if !moves.is_empty() && depth <= self.deepest && room {
            tree.nodes.push(Node { state, parent: span.from, moves, depth });
        }
    }
}

/// How often a body stands where another one shall.
fn conflicts(mover: &Mover, from: &Layout, to: &Layout) -> usize {
    let table = &mover.table;
    let mut count = 0;
    for body in table.movable.iter() {
        let (footprint, frame) = (table.footprint(body), to.frame(body));
        let stands = |other: &usize| {
            let other = *other;
            other != body
                && !footprints_apart(footprint, frame, table.footprint(other), from.frame(other), -PLACE_SLACK)
        };
        count += (0..table.len()).filter(stands).count();
    }
    count
}
