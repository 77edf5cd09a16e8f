//! Check 8: the network gives on this machine what it gave where it was exported.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::kind::{Axis, TensorSpec};
use super::model::Model;
use super::onnx::Dim;
use crate::error::{Error, ModelFault, Result};

/// Most items, bodies and values of a self-test: it is a test, not a load.
const MOST: usize = 64;
const USUAL_TOLERANCE: f64 = 1e-3;
/// Side of the picture where the file leaves it open.
const BLANK: i64 = 64;

/// Metadata `selftest`.
#[derive(Debug, Clone, Deserialize)]
struct SelfTest {
    seed: u64,
    #[serde(default = "two")]
    batch: usize,
    #[serde(default = "three")]
    num_objects: usize,
    /// The first values of each output.
    #[serde(default)]
    expected: BTreeMap<String, Vec<f64>>,
    #[serde(default = "usual")]
    atol: f64,
}

fn two() -> usize {
    2
}
fn three() -> usize {
    3
}
fn usual() -> f64 {
    USUAL_TOLERANCE
}

/// Numbers in [0, 1) by a linear congruential generator (Knuth's MMIX constants).
struct Lcg(u64);

impl Lcg {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }
}

/// Runs it once: finite numbers of the right shape, and within the file's tolerance of what it expects.
pub(super) fn run(model: &Model) -> Result<()> {
    let info = model.info();
    let text = info.property("selftest");
    let failed = |expected: String, found: String| Error::model(&info.path, ModelFault::SelfTest, expected, found);
    let test: SelfTest = if text.is_empty() {
        SelfTest { seed: 1, batch: 2, num_objects: 3, expected: BTreeMap::new(), atol: USUAL_TOLERANCE }
    } else {
        serde_json::from_str(text).map_err(|e| failed("metadata `selftest` that can be read".into(), e.to_string()))?
    };
    if !(1..=MOST).contains(&test.batch) || !(1..=MOST).contains(&test.num_objects) {
        let found = format!("{} items of {} bodies", test.batch, test.num_objects);
        return Err(failed(format!("a self-test of at most {MOST} items and bodies"), found));
    }
    let mut stream = Lcg(test.seed);
    let interface = info.interface;
    if interface.inputs.iter().any(|spec| spec.axes.contains(&Axis::Free)) {
        // Pictures of any size: it runs on a blank one.
        let dims = info.onnx.inputs.first().and_then(|input| input.dims.as_deref()).unwrap_or(&[]);
        let shape: Vec<i64> = dims
            .iter()
            .map(|dim| match dim {
                Dim::Fixed(n) => i64::try_from(*n).map_or(BLANK, |n| n.clamp(1, 4096)),
                Dim::Named(_) | Dim::Unknown => BLANK,
            })
            .collect();
        let blank = vec![0.0; shape.iter().product::<i64>() as usize];
        return model.run_free(&[("image", shape, &blank)]).map(drop);
    }
    let inputs: Vec<Vec<f32>> = interface
        .inputs
        .iter()
        .map(|spec| {
            let count = values(spec, &test, info.side.unwrap_or(0));
            match spec.name {
                // A mask: everything is there.
                "present" => vec![1.0; count],
                name if model.has_input(name) => (0..count).map(|_| stream.next()).collect(),
                _ => Vec::new(),
            }
        })
        .collect();
    let inputs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
    let mut outputs = vec![Vec::new(); interface.outputs.len()];
    model.run(test.batch, test.num_objects, &inputs, &mut outputs).map_err(|error| match error {
        Error::Model { path, expected, found, .. } => {
            Error::Model { path, fault: ModelFault::SelfTest, expected, found }
        }
        other => other,
    })?;
    for (name, expected) in &test.expected {
        let Some(at) = interface.outputs.iter().position(|spec| spec.name == name) else {
            return Err(failed("expected values of its outputs".into(), format!("some of `{name}`")));
        };
        for (i, wanted) in expected.iter().enumerate() {
            let found = outputs[at].get(i).copied().map_or(f64::NAN, f64::from);
            // Not `> atol`: what is no number fails as well.
            let near = (found - wanted).abs() <= test.atol;
            if !near {
                return Err(failed(format!("`{name}`[{i}] = {wanted} within {}", test.atol), found.to_string()));
            }
        }
    }
    Ok(())
}

/// Values of a tensor in the self-test.
fn values(spec: &TensorSpec, test: &SelfTest, side: usize) -> usize {
    spec.axes
        .iter()
        .map(|axis| match axis {
            Axis::Batch => test.batch,
            Axis::Objects => test.num_objects,
            Axis::Fixed(n) => *n,
            Axis::Side | Axis::Free => side,
            Axis::HalfSide => side / 2,
            Axis::Found => 0,
        })
        .product()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stream_is_the_one_that_the_exporter_uses() {
        let mut stream = Lcg(42);
        let first: Vec<f32> = (0..3).map(|_| stream.next()).collect();
        assert_eq!(first, [0.568_230_3, 0.225_463_39, 0.412_838_28]);
    }
}
