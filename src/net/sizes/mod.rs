//! How big a network becomes when it runs, told before a runtime sees it.
//!
//! A file of a kilobyte can ask for any memory and any time: by a loop, by weights that are said to be large, by an
//! operator that repeats what it gets. So a network is made of operators whose results have sizes that follow from the
//! sizes of what goes in (`rules`, `sums`), the sizes are worked out for the greatest call there is, and what
//! is beyond the limits below is refused. `docs/networks.md` has the limits and the operators.

mod rules;
mod sums;

use std::collections::HashMap;
use std::path::Path;

use rules::{Shaped, rule};

use super::graph::{Graph, Node, Tensor};
use crate::error::{Error, ModelFault, Result};

/// Most operators of a file.
pub const MOST_OPERATORS: usize = 100_000;
/// Most values of a tensor: 256 MiB of 32-bit floats.
pub const MOST_VALUES: u64 = 1 << 26;
/// Most values that are needed at the same time: 1 GiB of 32-bit floats. The weights, which the file holds, come on top.
pub const MOST_AT_ONCE: u64 = 1 << 28;
/// Most multiplications, or operations of like cost, of one call.
pub const MOST_WORK: u64 = 1 << 41;
/// Most dimensions of a tensor.
const MOST_RANK: usize = 16;

/// What needs no sizes: weights that are in the file, operators that are known, no flow of control.
pub(super) fn check_operators(path: &Path, graph: &Graph) -> Result<()> {
    if let Some(tensor) = graph.constants().find(|tensor| tensor.external) {
        let expected = "a network whose weights are in its own file (save it with them, without `external data`)";
        return Err(Error::model(path, ModelFault::External, expected, format!("`{}` in another file", tensor.name)));
    }
    let refuse = |found: String| {
        let expected = "operators whose sizes follow from those of the inputs; docs/networks.md lists them";
        Err(Error::model(path, ModelFault::Operator, expected, found))
    };
    if graph.functions > 0 {
        return refuse(format!("{} functions of the file's own; export it with functions inlined", graph.functions));
    }
    if graph.sparse > 0 {
        return refuse("sparse weights".into());
    }
    if graph.nodes.len() > MOST_OPERATORS {
        return refuse(format!("{} operators; {MOST_OPERATORS} are the most", graph.nodes.len()));
    }
    for (place, node) in graph.nodes.iter().enumerate() {
        if node.nested || matches!(node.operator.as_str(), "If" | "Loop" | "Scan" | "SequenceMap") {
            return refuse(format!("{}, which controls the flow", named(place, node)));
        }
        if !matches!(node.domain.as_str(), "" | "ai.onnx") || rule(&node.operator).is_none() {
            return refuse(named(place, node));
        }
    }
    let claims = |tensor: &&Tensor| tensor.count() > 8 * (tensor.bytes as u64) || tensor.count() > MOST_VALUES * 8;
    if let Some(tensor) = graph.constants().find(claims) {
        let found = format!("`{}` of {} values in {} bytes", tensor.name, tensor.count(), tensor.bytes);
        return Err(Error::model(path, ModelFault::Size, "weights of as many values as the file holds", found));
    }
    Ok(())
}

/// Every tensor's size in a call with inputs of these sizes, against the limits.
pub(super) fn check_sizes(path: &Path, graph: &Graph, inputs: &[(&str, Vec<u64>)]) -> Result<()> {
    let mut walk = Walk { known: HashMap::new(), at_once: 0, work: 0 };
    let last = last_uses(graph);
    let too_big = |expected: String, found: String| Error::model(path, ModelFault::Size, expected, found);
    for (name, dims) in inputs {
        walk.keep(name, Shaped::of(dims.clone())).map_err(|found| too_big(values_expected(), found))?;
    }
    for (name, tensor) in &graph.weights {
        // They do not count: the file holds them.
        walk.known.insert(name, Shaped::constant(tensor));
    }
    for (place, node) in graph.nodes.iter().enumerate() {
        walk.step(node).map_err(|(expected, found)| too_big(expected, format!("{} {found}", named(place, node))))?;
        for name in last.get(&place).into_iter().flatten() {
            walk.release(name);
        }
    }
    Ok(())
}

fn values_expected() -> String {
    format!("tensors of at most {MOST_VALUES} values")
}

/// An operator in words.
fn named(place: usize, node: &Node) -> String {
    let domain = if node.domain.is_empty() { String::new() } else { format!("{}.", node.domain) };
    format!("operator {place}, `{domain}{}`", node.operator)
}

/// After which operator nothing more is made of a tensor.
fn last_uses(graph: &Graph) -> HashMap<usize, Vec<&str>> {
    let mut last: HashMap<&str, usize> = HashMap::new();
    for (place, node) in graph.nodes.iter().enumerate() {
        for name in node.inputs.iter().chain(&node.outputs) {
            last.insert(name, place);
        }
    }
    let mut at: HashMap<usize, Vec<&str>> = HashMap::new();
    for (name, place) in last {
        at.entry(place).or_default().push(name);
    }
    at
}

/// Goes through the operators in their order.
struct Walk<'a> {
    known: HashMap<&'a str, Shaped>,
    at_once: u64,
    work: u64,
}

impl<'a> Walk<'a> {
    fn step(&mut self, node: &'a Node) -> std::result::Result<(), (String, String)> {
        let follows = || "a size that follows from those of the inputs".to_string();
        let rule = rule(&node.operator).ok_or_else(|| (follows(), "is not known".to_string()))?;
        let mut inputs = Vec::with_capacity(node.inputs.len());
        for name in &node.inputs {
            let found = self.known.get(name.as_str());
            if found.is_none() && !name.is_empty() {
                return Err((follows(), format!("takes `{name}`, which nothing before it makes")));
            }
            inputs.push(found);
        }
        let constant = inputs.iter().flatten().all(|input| input.constant);
        let made = rule(node, &inputs).map_err(|found| (follows(), found))?;
        self.work = self.work.saturating_add(made.work);
        if self.work > MOST_WORK {
            return Err((format!("at most {MOST_WORK} multiplications in a call"), "asks for more".into()));
        }
        for (name, mut shaped) in node.outputs.iter().zip(made.outputs) {
            shaped.constant = constant;
            self.keep(name, shaped).map_err(|found| (values_expected(), found))?;
        }
        if self.at_once > MOST_AT_ONCE {
            let found = format!("needs {} at the same time", self.at_once);
            return Err((format!("at most {MOST_AT_ONCE} values at the same time"), found));
        }
        Ok(())
    }

    fn keep(&mut self, name: &'a str, shaped: Shaped) -> std::result::Result<(), String> {
        let count = shaped.count();
        if count > MOST_VALUES || shaped.dims.len() > MOST_RANK {
            return Err(format!("makes `{name}` of shape {:?}", shaped.dims));
        }
        self.at_once += count;
        self.known.insert(name, shaped);
        Ok(())
    }

    /// What was worked out from constants alone a runtime works out when it loads the network, and keeps.
    fn release(&mut self, name: &str) {
        if self.known.get(name).is_some_and(|shaped| !shaped.constant)
            && let Some(shaped) = self.known.remove(name)
        {
            self.at_once = self.at_once.saturating_sub(shaped.count());
        }
    }
}

#[cfg(test)]
mod tests;
