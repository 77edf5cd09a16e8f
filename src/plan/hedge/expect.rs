//! The expected number of actions of every plan that is worth it, over the worlds of the ensemble.

use std::collections::HashMap;
use std::sync::Mutex;

use super::episode::{Bench, End, Rules, World};
use crate::action::Push;
use crate::error::Result;
use crate::physics::{PushJob, PushResult, PushStatus};
use crate::plan::retrieval::Retrieval;
use crate::run::{Pool, Stop};
use crate::scene::State;
use crate::search::Tree;

/// Plans that are tried at once, at most: one for each first push.
pub(super) const PLANS: usize = 12;
/// Worlds of each round, and the share of the plans that enters the next.
const ROUNDS: [(usize, usize); 3] = [(4, 2), (4, 2), (8, 1)];
/// Worlds of all rounds.
pub(super) const WORLDS: usize = 16;
/// Plans that enter the next round at least.
const LEAST: usize = 3;

/// A plan of the tree.
#[derive(Debug, Clone)]
pub(super) struct Way {
    pub pushes: Vec<Push>,
    /// The state after each push in the model of the search.
    pub states: Vec<State>,
    /// How it ended in each world that it was tried in.
    pub ends: Vec<End>,
}

impl Way {
    /// Mean number of actions; infinite where the plan was not tried.
    pub fn expected(&self) -> f64 {
        self.mean(End::cost)
    }

    fn mean(&self, of: impl Fn(&End) -> f64) -> f64 {
        let n = self.ends.len();
        if n == 0 { f64::INFINITY } else { self.ends.iter().map(of).sum::<f64>() / n as f64 }
    }

    /// Share of the worlds in which the target was out after no more actions than the plan has.
    pub fn chance(&self) -> f64 {
        self.within(self.pushes.len() + 1)
    }

    /// Share of the worlds in which the target was out after no more than so many actions.
    pub fn within(&self, actions: usize) -> f64 {
        self.ends.iter().map(|end| end.within(actions as f64)).sum::<f64>() / self.ends.len().max(1) as f64
    }

    /// What is left of an earlier plan, from the state that is now observed. None where a push of it is not possible there.
    /// Whether it frees the target the worlds will tell: what the cheap engine does not see may well be true.
    pub fn continued(domain: &Retrieval, rest: &[Push], observed: &State, stop: &Stop) -> Option<Way> {
        let mut scratch = domain.new_scratch();
        let mut states: Vec<State> = Vec::new();
        for push in rest {
            let mut results = [PushResult::default()];
            let jobs = [PushJob { state: states.last().unwrap_or(observed), push: *push }];
            domain.simulate(&mut scratch, &jobs, &mut results, stop);
            let [result] = results;
            if result.status != PushStatus::Executed || domain.harmful(&result) {
                return None;
            }
            states.push(result.state);
        }
        (!states.is_empty()).then(|| Way { pushes: rest.to_vec(), states, ends: Vec::new() })
    }
}

/// One plan for every first push that leads to a solution of at most `longest` pushes: the shortest, of these the one
/// with the best grasp. In the order in which they are worth trying: shorter first, then those with more solutions of
/// that length below their first push, then the better grasp.
pub(super) fn ways(tree: &Tree<Retrieval>, longest: u32) -> Vec<Way> {
    let nodes: Vec<_> = tree.nodes().collect();
    let place: HashMap<usize, usize> = nodes.iter().enumerate().map(|(at, n)| (n.id, at)).collect();
    // Node of level 1 -> (level, quality, place) of its best solution, and how many there are of that level.
    let mut best: Vec<(usize, u32, f64, usize, usize)> = Vec::new();
    for (at, node) in nodes.iter().enumerate().filter(|(_, n)| n.terminal && n.level > 0 && n.level <= longest) {
        let mut first = node;
        while first.level > 1 {
            match first.parent.and_then(|p| place.get(&p)) {
                Some(&up) => first = &nodes[up],
                None => break,
            }
        }
        match best.iter_mut().find(|b| b.0 == first.id) {
            Some(b) if node.level > b.1 => {}
            Some(b) if node.level == b.1 => {
                b.4 += 1;
                if node.quality > b.2 {
                    (b.2, b.3) = (node.quality, at);
                }
            }
            Some(b) => *b = (first.id, node.level, node.quality, at, 1),
            None => best.push((first.id, node.level, node.quality, at, 1)),
        }
    }
    best.sort_by(|a, b| a.1.cmp(&b.1).then(b.4.cmp(&a.4)).then(b.2.total_cmp(&a.2)).then(a.0.cmp(&b.0)));
    let way = |&(_, level, _, at, _): &(usize, u32, f64, usize, usize)| {
        let (mut pushes, mut states) = (Vec::new(), Vec::new());
        let mut here = Some(&nodes[at]);
        while let Some((node, (_, push))) = here.and_then(|n| Some((n, n.action?))) {
            pushes.push(*push);
            states.push(node.state.clone());
            here = node.parent.and_then(|p| place.get(&p)).map(|&up| &nodes[up]);
        }
        pushes.reverse();
        states.reverse();
        (pushes.len() == level as usize).then_some(Way { pushes, states, ends: Vec::new() })
    };
    best.iter().filter_map(way).take(PLANS).collect()
}

/// Tries the plans in the ensemble, the better ones in more worlds; leaves those that were tried in most, best first.
/// With a requested stop a world that is not through counts for none of them.
pub(super) fn weigh(
    ways: &mut Vec<Way>,
    rules: &Rules<'_>,
    pool: &Pool,
    observed: &State,
    simulations: &mut [u64; 2],
) -> Result<()> {
    if ways.is_empty() || rules.stop.requested() {
        return Ok(());
    }
    let benches = (0..pool.workers()).map(|_| Bench::new(rules).map(Mutex::new)).collect::<Result<Vec<_>>>()?;
    let mut from = 0;
    for (count, keep) in ROUNDS {
        let to = (from + count).min(rules.ensemble.len());
        if ways.is_empty() || rules.stop.requested() || to == from {
            break;
        }
        let ends = {
            let plans: Vec<&[Push]> = ways.iter().map(|w| w.pushes.as_slice()).collect();
            let mut worlds: Vec<World> = (from..to)
                .map(|index| World { index, plans: plans.clone(), ends: Vec::new(), simulations: [0; 2] })
                .collect();
            pool.for_each_group(&mut worlds, 1, &benches, |bench, group| {
                group.iter_mut().for_each(|world| world.play(rules, bench, observed));
            })?;
            worlds.into_iter().map(|w| (w.ends, w.simulations)).collect::<Vec<_>>()
        };
        for (ends, spent) in ends {
            (simulations[0], simulations[1]) = (simulations[0] + spent[0], simulations[1] + spent[1]);
            if ends.len() == ways.len() {
                ways.iter_mut().zip(ends).for_each(|(way, end)| way.ends.push(end));
            }
        }
        // Stable: of equals the one that was worth more beforehand stays first.
        ways.sort_by(|a, b| a.expected().total_cmp(&b.expected()));
        // More worlds do not dispel the doubt about grasps that hold.
        let sure = ways.first().is_some_and(|w| w.expected() - w.mean(End::doubt) <= w.pushes.len() as f64 + 1.0);
        from = to;
        if sure && from >= ROUNDS[0].0 + ROUNDS[1].0 {
            break;
        }
        let most = ways.len().div_ceil(keep).max(LEAST);
        ways.truncate(most);
    }
    Ok(())
}
