//! Check 10: the network gives on this machine what it gave where it was exported.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::file;
use super::kind::{Axis, TensorSpec};
use super::model::Model;
use super::onnx::Dim;
use crate::error::{Error, ModelFault, Result};
use crate::run::Stop;

/// Most items, bodies and values of a self-test: it is a test, not a load.
const MOST: usize = 64;
/// Numbers of bodies that fill no vector.
const ODD_BODIES: [usize; 2] = [1, 7];
const USUAL_TOLERANCE: f64 = 1e-3;
/// Side of the picture where the file leaves it open.
const BLANK: i64 = file::BLANK as i64;

/// Metadata `selftest`.
#[derive(Debug, Clone, Deserialize)]
struct SelfTest {
    seed: u64,
    #[serde(default = "two")]
    batch: usize,
    #[serde(default = "three")]
    num_objects: usize,
    #[serde(default)]
    inputs: Inputs,
    /// Values of each output: those at the positions `at`, or the first.
    #[serde(default)]
    expected: BTreeMap<String, Vec<f64>>,
    /// Positions in the flattened outputs.
    #[serde(default)]
    at: BTreeMap<String, Vec<usize>>,
    #[serde(default = "usual")]
    atol: f64,
}

/// What the numbers of the stream become.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Inputs {
    /// The inputs.
    #[default]
    Plain,
    /// Bodies, pushes and pictures as they occur, which a trained network has more to say of than of noise.
    Scene,
}

/// Factor and summand that make a number of the stream one that occurs; metres, kilograms, radians.
const RANGES: [(&str, f64, f64); 5] = [
    ("outline", 0.08, -0.04),
    ("centre", 0.3, -0.15),
    ("body", 0.5, 0.0),
    ("push", 0.1, 0.02),
    ("guess", 0.05, -0.025),
];
/// Pictures of a scene: fields a side, the part of them on which a block stands, and its height in metres.
const FIELDS: usize = 5;
const STANDING: f64 = 0.4;
const HEIGHT: f32 = 0.045;

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
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / f64::from(1 << 24)
    }

    fn plain(&mut self, count: usize) -> Vec<f32> {
        (0..count).map(|_| self.next() as f32).collect()
    }

    /// An input of `count` values in `items` items, as it occurs.
    fn scene(&mut self, name: &str, count: usize, items: usize, side: usize) -> Vec<f32> {
        match name {
            "image" => (0..items).flat_map(|_| self.blocks(count / items, side)).collect(),
            // The first body of each.
            "target" => (0..count).map(|i| if i % (count / items) == 0 { 1.0 } else { 0.0 }).collect(),
            _ => {
                let range = RANGES.iter().find(|range| range.0 == name);
                let (factor, summand) = range.map_or((1.0, 0.0), |range| (range.1, range.2));
                (0..count).map(|_| (self.next() * factor + summand) as f32).collect()
            }
        }
    }

    /// A picture of fields with a block where the number is small, and one in the middle, which is the target (the second
    /// channel).
    fn blocks(&mut self, count: usize, side: usize) -> Vec<f32> {
        let middle = FIELDS / 2 * FIELDS + FIELDS / 2;
        let standing: Vec<bool> = (0..FIELDS * FIELDS).map(|i| (self.next() < STANDING) | (i == middle)).collect();
        let field = |pixel: usize| {
            let (row, col) = (pixel % (side * side) / side, pixel % side);
            row / side.div_ceil(FIELDS) * FIELDS + col / side.div_ceil(FIELDS)
        };
        let plane = side * side;
        let value = |pixel: usize| match pixel < plane {
            true if standing[field(pixel)] => HEIGHT,
            false if field(pixel) == middle => 1.0,
            _ => 0.0,
        };
        (0..count).map(value).collect()
    }
}

/// Runs it once: finite numbers of the right shape, and within the file's tolerance of what it expects.
pub(super) fn run(model: &Model, stop: &Stop) -> Result<()> {
    let info = model.info();
    let text = info.property("selftest");
    let failed = |expected: String, found: String| Error::model(&info.path, ModelFault::SelfTest, expected, found);
    let test: SelfTest = if text.is_empty() {
        SelfTest {
            seed: 1,
            batch: 2,
            num_objects: 3,
            inputs: Inputs::Plain,
            expected: BTreeMap::new(),
            at: BTreeMap::new(),
            atol: USUAL_TOLERANCE,
        }
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
        return model.run_free(&[("image", shape, &blank)], Some(stop)).map(drop);
    }
    let inputs: Vec<Vec<f32>> = interface
        .inputs
        .iter()
        .map(|spec| {
            let side = info.side.unwrap_or(0);
            let count = values(spec, &test, side);
            match spec.name {
                // A mask: everything is there.
                "present" => vec![1.0; count],
                name if !model.has_input(name) => Vec::new(),
                _ if test.inputs == Inputs::Plain => stream.plain(count),
                name => stream.scene(name, count, test.batch, side),
            }
        })
        .collect();
    let inputs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
    let mut outputs = vec![Vec::new(); interface.outputs.len()];
    model.run_until(test.batch, test.num_objects, &inputs, &mut outputs, stop).map_err(failed_run)?;
    for (name, expected) in &test.expected {
        let Some(at) = interface.outputs.iter().position(|spec| spec.name == name) else {
            return Err(failed("expected values of its outputs".into(), format!("some of `{name}`")));
        };
        let places = test.at.get(name);
        if places.is_some_and(|places| places.len() != expected.len()) {
            return Err(failed(format!("as many positions as values of `{name}`"), "another number of them".into()));
        }
        for (k, wanted) in expected.iter().enumerate() {
            let i = places.map_or(k, |places| places[k]);
            let found = outputs[at].get(i).copied().map_or(f64::NAN, f64::from);
            // Not `> atol`: what is no number fails as well.
            let near = (found - wanted).abs() <= test.atol;
            if !near {
                return Err(failed(format!("`{name}`[{i}] = {wanted} within {}", test.atol), found.to_string()));
            }
        }
    }
    if model.repeats_bits() && interface.chunk > 1 { alone_and_in_company(model, stop) } else { Ok(()) }
}

/// What goes wrong when the self-test runs is the self-test's.
fn failed_run(error: Error) -> Error {
    match error {
        Error::Model { path, expected, found, .. } => {
            Error::Model { path, fault: ModelFault::SelfTest, expected, found }
        }
        other => other,
    }
}

/// An item has the same bits alone, beside others, and in every place of a call. Some functions of a runtime compute the
/// last few values of a tensor, which fill no vector, with other instructions than the rest (`Sin`, `Cos`, `Log` and
/// `Softplus` of ONNX Runtime 1.32): a network that mixes up its items, or whose tensors come to such an end within an
/// item, shows it here.
fn alone_and_in_company(model: &Model, stop: &Stop) -> Result<()> {
    let (info, chunk) = (model.info(), model.info().interface.chunk);
    for objects in ODD_BODIES {
        let mut stream = Lcg(objects as u64);
        let strides: Vec<usize> = info.interface.inputs.iter().map(|spec| model.stride(spec, objects)).collect();
        let items: Vec<Vec<Vec<f32>>> = (0..chunk)
            .map(|_| {
                let of = |(spec, stride): (&TensorSpec, &usize)| match spec.name {
                    "present" => vec![1.0; *stride],
                    name if !model.has_input(name) => Vec::new(),
                    name => stream.scene(name, *stride, 1, info.side.unwrap_or(0)),
                };
                info.interface.inputs.iter().zip(&strides).map(of).collect()
            })
            .collect();
        let answer = |order: &[usize]| -> Result<Vec<Vec<u32>>> {
            let gathered: Vec<Vec<f32>> = (0..strides.len())
                .map(|input| order.iter().flat_map(|item| items[*item][input].iter().copied()).collect())
                .collect();
            let inputs: Vec<&[f32]> = gathered.iter().map(Vec::as_slice).collect();
            let mut outputs = vec![Vec::new(); info.interface.outputs.len()];
            model.run_until(order.len(), objects, &inputs, &mut outputs, stop).map_err(failed_run)?;
            let part = |item: usize, output: &Vec<f32>| {
                let size = output.len() / order.len();
                output[item * size..(item + 1) * size].iter().map(|v| v.to_bits()).collect::<Vec<_>>()
            };
            Ok((0..order.len()).map(|item| outputs.iter().flat_map(|output| part(item, output)).collect()).collect())
        };
        let together = answer(&(0..chunk).collect::<Vec<_>>())?;
        for (item, among) in together.iter().enumerate() {
            // Turned, so that it lies in another place beside others; and alone.
            let turned: Vec<usize> = (0..chunk).map(|k| (item + k) % chunk).collect();
            if answer(&turned)?[0] != *among || answer(&[item])?[0] != *among {
                let found = format!("item {item} of {objects} bodies with others where the others or its place differ");
                let expected = "the same bits for an item alone, in any company and in any place";
                return Err(Error::model(&info.path, ModelFault::SelfTest, expected, found));
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
        assert_eq!(stream.plain(3), [0.568_230_3, 0.225_463_39, 0.412_838_28]);
    }

    #[test]
    fn a_scene_is_the_one_that_the_exporter_makes() {
        let mut stream = Lcg(42);
        let outline = stream.scene("outline", 3, 1, 0);
        for (found, wanted) in outline.iter().zip([0.568_230_3, 0.225_463_39, 0.412_838_28]) {
            assert!((found - (wanted * 0.08 - 0.04)).abs() < 1e-7);
        }
        assert_eq!(stream.scene("target", 6, 2, 0), [1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
        let (side, mut again) = (12, Lcg(42));
        let image = again.scene("image", 2 * 2 * side * side, 2, side);
        // Fields of three pixels: 0.568, 0.225 and 0.413 are the first, and the second alone has a block.
        assert_eq!(image[..9], [0.0, 0.0, 0.0, HEIGHT, HEIGHT, HEIGHT, 0.0, 0.0, 0.0]);
        let target = &image[side * side..2 * side * side];
        let mass: f32 = target.iter().sum();
        assert_eq!((mass, target[6 * side + 6]), (9.0, 1.0));
        assert_ne!(image[..side * side], image[2 * side * side..3 * side * side]);
    }
}
