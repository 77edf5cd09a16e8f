//! Storage of the tree: nodes, their statistics and their actions in flat arrays.
//!
//! A node's index is greater than its parent's, and the actions of nodes lie in the order of the nodes. Removing nodes
//! only shortens the logical length: slots keep what they own, so a later search of the same size allocates nothing.

use crate::run::Key;

use super::domain::{Domain, Outcome};

/// No node, no action.
pub(super) const NONE: u32 = u32::MAX;
/// Level of a solution where there is none.
pub(super) const UNSOLVED: u32 = u32::MAX;

/// What does not change once the node exists.
pub(super) struct Node<D: Domain> {
    pub state: D::State,
    pub key: Key,
    pub parent: u32,
    /// The action that led here, as an index into all actions; `NONE` at the root.
    pub edge: u32,
    pub level: u32,
    /// The node's actions are `first .. first + count`.
    pub first: u32,
    pub count: u32,
    pub terminal: bool,
    /// False for a ghost: a state that only rollouts have seen, kept so that it need not be simulated again.
    pub real: bool,
    pub value: f64,
    pub quality: f64,
    /// Sum along the path from the root.
    pub cost: f64,
    /// Discount of the action that led here.
    pub discount: f64,
}

impl<D: Domain> Default for Node<D> {
    fn default() -> Self {
        Node {
            state: D::State::default(),
            key: Key::default(),
            parent: NONE,
            edge: NONE,
            level: 0,
            first: 0,
            count: 0,
            terminal: false,
            real: false,
            value: 0.0,
            quality: 0.0,
            cost: 0.0,
            discount: 1.0,
        }
    }
}

/// What the search learns about a node. Apart from the nodes, so that selection reads little memory.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stats {
    pub visits: u32,
    /// Selected but not yet backed up, below or here; zero outside of selection.
    pub virtual_visits: u32,
    /// Returns remembered of the best.
    pub kept: u32,
    /// Actions that were not tried.
    pub untried: u32,
    /// Actions that were selected in this wave.
    pub pending: u32,
    /// Untried actions of all nodes from here down that may still be expanded.
    pub open: u32,
    /// Level of the shallowest solution from here down, with the quality and cost of the best of that level.
    pub solved: u32,
    pub solved_quality: f64,
    pub solved_cost: f64,
    pub sum: f64,
    /// Sum of the best returns that selection counts.
    pub top_sum: f64,
    pub best: f64,
}

const UNKNOWN: Stats = Stats {
    visits: 0,
    virtual_visits: 0,
    kept: 0,
    untried: 0,
    pending: 0,
    open: 0,
    solved: UNSOLVED,
    solved_quality: 0.0,
    solved_cost: 0.0,
    sum: 0.0,
    top_sum: 0.0,
    best: f64::NEG_INFINITY,
};

/// What has been done with an action.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Tried {
    #[default]
    No,
    /// Selected in this wave.
    Pending,
    /// It has a real child.
    Yes,
    /// It is illegal.
    Dead,
}

/// An action of a node.
#[derive(Default)]
pub(super) struct Edge<A> {
    pub action: A,
    pub prior: f32,
    pub expansion_only: bool,
    pub tried: Tried,
    /// A rollout has found it illegal. Expansion need not simulate it, and must not know before it selects it.
    pub known_dead: bool,
    /// The real child, or the ghost.
    pub child: u32,
    /// The last wave whose rollouts took it: within a wave they take an action once.
    pub taken: u32,
}

/// The flat arrays. Logical lengths; what lies beyond is memory to use again.
pub(super) struct Arena<D: Domain> {
    nodes: Vec<Node<D>>,
    edges: Vec<Edge<D::Action>>,
    pub stats: Vec<Stats>,
    /// The best returns of every node, best first, `stride` places each.
    top: Vec<f64>,
    stride: usize,
    node_count: usize,
    edge_count: usize,
}

impl<D: Domain> Default for Arena<D> {
    fn default() -> Self {
        Arena {
            nodes: Vec::new(),
            edges: Vec::new(),
            stats: Vec::new(),
            top: Vec::new(),
            stride: 1,
            node_count: 0,
            edge_count: 0,
        }
    }
}

impl<D: Domain> Arena<D> {
    pub fn len(&self) -> usize {
        self.node_count
    }

    pub fn edge_len(&self) -> usize {
        self.edge_count
    }

    pub fn node(&self, node: u32) -> &Node<D> {
        &self.nodes[node as usize]
    }

    pub fn node_mut(&mut self, node: u32) -> &mut Node<D> {
        &mut self.nodes[node as usize]
    }

    pub fn stat(&self, node: u32) -> &Stats {
        &self.stats[node as usize]
    }

    pub fn stat_mut(&mut self, node: u32) -> &mut Stats {
        &mut self.stats[node as usize]
    }

    pub fn edge(&self, edge: u32) -> &Edge<D::Action> {
        &self.edges[edge as usize]
    }

    pub fn edge_mut(&mut self, edge: u32) -> &mut Edge<D::Action> {
        &mut self.edges[edge as usize]
    }

    /// The indices of a node's actions.
    pub fn edges_of(&self, node: u32) -> std::ops::Range<u32> {
        let node = self.node(node);
        node.first..node.first + node.count
    }

    /// The best returns of a node, best first.
    pub fn top(&self, node: u32) -> &[f64] {
        let start = node as usize * self.stride;
        &self.top[start..start + self.stat(node).kept as usize]
    }

    /// Removes everything and remembers `stride` best returns per node from now on.
    pub fn clear(&mut self, stride: usize) {
        self.truncate(0, 0);
        self.stride = stride;
    }

    /// Keeps the first nodes and actions.
    pub fn truncate(&mut self, nodes: usize, edges: usize) {
        self.node_count = nodes;
        self.edge_count = edges;
        self.stats.truncate(nodes);
        self.top.truncate(nodes * self.stride);
    }

    /// Remembers `stride` best returns per node from now on, of which `counted` enter `top_sum`; what was remembered
    /// beyond is forgotten.
    pub fn restride(&mut self, stride: usize, counted: usize) {
        if stride != self.stride {
            self.move_top(stride);
        }
        for node in 0..self.node_count as u32 {
            let top = self.top(node);
            let sum = top[..top.len().min(counted)].iter().sum();
            self.stat_mut(node).top_sum = sum;
        }
    }

    fn move_top(&mut self, stride: usize) {
        let mut top = vec![f64::NEG_INFINITY; self.node_count * stride];
        for node in 0..self.node_count {
            let kept = (self.stats[node].kept as usize).min(stride);
            let start = node * self.stride;
            top[node * stride..node * stride + kept].copy_from_slice(&self.top[start..start + kept]);
            self.stats[node].kept = kept as u32;
        }
        self.top = top;
        self.stride = stride;
    }

    /// Room for another node with so many actions; false where the system does not give the memory. These arrays are what
    /// grows, and by so much at a time that there is still room for what is small where they get none.
    pub fn reserve(&mut self, actions: usize) -> bool {
        fn room<T>(slots: &mut Vec<T>, used: usize, more: usize) -> bool {
            slots.try_reserve((used + more).saturating_sub(slots.len())).is_ok()
        }
        room(&mut self.nodes, self.node_count, 1)
            && room(&mut self.edges, self.edge_count, actions)
            && room(&mut self.stats, self.node_count, 1)
            && room(&mut self.top, self.node_count * self.stride, self.stride)
    }

    /// Adds a ghost with the outcome's contents; the outcome is left with memory to use again. The action that leads
    /// to it is told.
    pub fn push(&mut self, parent: u32, edge: u32, key: Key, discount: f64, outcome: &mut Outcome<D>) -> u32 {
        let index = self.node_count as u32;
        let (level, cost) =
            if parent == NONE { (0, 0.0) } else { (self.node(parent).level + 1, self.node(parent).cost) };
        if self.node_count == self.nodes.len() {
            self.nodes.push(Node::default());
        }
        self.node_count += 1;
        let first = self.edge_count as u32;
        // A solution's actions are of no interest: nothing is done from there.
        let candidates = if outcome.terminal { &mut [][..] } else { &mut outcome.candidates[..] };
        for candidate in candidates.iter_mut() {
            if self.edge_count == self.edges.len() {
                self.edges.push(Edge::default());
            }
            let slot = &mut self.edges[self.edge_count];
            std::mem::swap(&mut slot.action, &mut candidate.action);
            slot.prior = candidate.prior;
            slot.expansion_only = candidate.expansion_only;
            slot.tried = Tried::No;
            slot.known_dead = false;
            slot.child = NONE;
            slot.taken = 0;
            self.edge_count += 1;
        }
        let count = self.edge_count as u32 - first;
        let node = &mut self.nodes[index as usize];
        std::mem::swap(&mut node.state, &mut outcome.state);
        node.key = key;
        node.parent = parent;
        node.edge = edge;
        node.level = level;
        node.first = first;
        node.count = count;
        node.terminal = outcome.terminal;
        node.real = false;
        node.value = outcome.value;
        node.quality = outcome.quality;
        node.cost = cost + outcome.cost;
        node.discount = outcome.discount.unwrap_or(discount);
        self.stats.push(Stats { untried: count, ..UNKNOWN });
        self.top.resize(self.node_count * self.stride, f64::NEG_INFINITY);
        if edge != NONE {
            self.edge_mut(edge).child = index;
        }
        index
    }

    /// Records a return. `counted` of the best enter `top_sum`.
    pub fn add_return(&mut self, node: u32, value: f64, counted: usize) {
        let stats = &mut self.stats[node as usize];
        stats.visits += 1;
        stats.sum += value;
        stats.best = stats.best.max(value);
        let start = node as usize * self.stride;
        let slots = &mut self.top[start..start + self.stride];
        let kept = stats.kept as usize;
        let place = slots[..kept].partition_point(|&other| other >= value);
        if place == slots.len() {
            return;
        }
        let kept = (kept + 1).min(slots.len());
        slots.copy_within(place..kept - 1, place + 1);
        slots[place] = value;
        stats.kept = kept as u32;
        if place < counted {
            stats.top_sum = slots[..kept.min(counted)].iter().sum();
        }
    }

    /// Makes `root` the root: keeps it and what is below, in the same order. `map` is a buffer.
    pub fn keep_below(&mut self, root: u32, map: &mut Vec<u32>) {
        map.clear();
        map.resize(self.node_count, NONE);
        let lift = self.node(root).level;
        let (mut nodes, mut edges) = (0usize, 0usize);
        for old in root as usize..self.node_count {
            let parent = self.nodes[old].parent;
            if old != root as usize && (parent == NONE || map[parent as usize] == NONE) {
                continue;
            }
            map[old] = nodes as u32;
            let (first, count) = (self.nodes[old].first as usize, self.nodes[old].count as usize);
            for offset in 0..count {
                self.edges.swap(edges + offset, first + offset);
            }
            self.nodes.swap(nodes, old);
            self.stats[nodes] = self.stats[old];
            let (from, to) = (old * self.stride, nodes * self.stride);
            self.top.copy_within(from..from + self.stride, to);
            let node = &mut self.nodes[nodes];
            node.first = edges as u32;
            node.level -= lift;
            if nodes == 0 {
                (node.parent, node.edge) = (NONE, NONE);
            } else {
                node.parent = map[node.parent as usize];
            }
            nodes += 1;
            edges += count;
        }
        self.truncate(nodes, edges);
        for edge in &mut self.edges[..edges] {
            if edge.child != NONE {
                edge.child = map[edge.child as usize];
            }
        }
        // Every child learns its action's new place from its parent.
        for node in 0..nodes as u32 {
            for edge in self.edges_of(node) {
                let child = self.edge(edge).child;
                if child != NONE {
                    self.node_mut(child).edge = edge;
                }
            }
        }
    }

    /// Estimated bytes of everything stored, given those of one state and of one action.
    pub fn bytes(&self, state: usize, action: usize) -> usize {
        let node = size_of::<Node<D>>() - size_of::<D::State>() + size_of::<Stats>() + self.stride * size_of::<f64>();
        let edge = size_of::<Edge<D::Action>>() - size_of::<D::Action>();
        self.node_count * (node + state) + self.edge_count * (edge + action)
    }

    /// The same with another node that has so many edges.
    pub fn bytes_with(&self, edges: usize, state: usize, action: usize) -> usize {
        let node = size_of::<Node<D>>() - size_of::<D::State>() + size_of::<Stats>() + self.stride * size_of::<f64>();
        let edge = size_of::<Edge<D::Action>>() - size_of::<D::Action>();
        self.bytes(state, action) + node + state + edges * (edge + action)
    }
}
