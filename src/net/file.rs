//! The checks of a network's file, in their order, each with its own [`ModelFault`].
//!
//! 1. the file: there, not empty, not too big, no Git LFS pointer, ONNX;
//! 2. the SHA-256, where one is known;
//! 3. the weights are in the file, and the operators are those that are taken (`sizes`);
//! 4. kind and interface;
//! 5. inputs and outputs by name: element type, rank, every dimension;
//! 6. the settings it was made for;
//! 7. how big it becomes in the greatest call (`sizes`);
//! 8. a runtime (`runtime`); 9. the runtime accepts the network (`model`);
//! 10. the self-test (`self_test`).
//!
//! A network is code from outside: no runtime sees a file that has not passed the first seven, which [`inspect`] makes alone.

use std::io::Read;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::graph::Graph;
use super::info::{ModelInfo, check_configuration, read_spec};
use super::kind::{Axis, Interface, Kind, TensorSpec};
use super::model::LoadOptions;
use super::onnx::{Dim, FLOAT, OnnxInfo, TensorInfo};
use super::sizes;
use crate::error::{Error, ModelFault, Result};
use crate::scene::MAX_SIMULATED;

/// Greatest size of a file. torchvision's Mask R-CNN, the biggest network that has an interface here, has 176 MB.
pub const MAX_BYTES: u64 = 512 << 20;
/// `TensorProto.DataType` of 64-bit integers.
const INT64: i32 = 7;
const WANTED: &str = "a network in ONNX format";
/// Side of a picture for which a network is tried that leaves it open.
pub(super) const BLANK: u64 = 64;
const LFS: &[u8] = b"version https://git-lfs";

/// Check 1, as far as it needs the file system.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    let file = match std::fs::File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Err(Error::model(path, ModelFault::Missing, WANTED, "nothing"));
        }
        Err(error) => return Err(Error::io(path, error)),
    };
    let size = file.metadata().map_err(|e| Error::io(path, e))?;
    if size.is_dir() {
        return Err(Error::io(path, "is a folder; name the file"));
    }
    if size.len() > MAX_BYTES {
        let (most, found) = (format!("at most {MAX_BYTES} bytes"), format!("{} bytes", size.len()));
        return Err(Error::model(path, ModelFault::TooBig, most, found));
    }
    let mut bytes = Vec::new();
    // What grows while it is read, or has no size, is bounded as well.
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(|e| match e.kind() {
        std::io::ErrorKind::OutOfMemory => Error::Memory(format!(
            "{}: takes {} bytes of memory, which the system does not give",
            path.display(),
            size.len()
        )),
        _ => Error::io(path, e),
    })?;
    Ok(bytes)
}

/// Check 1: what the bytes are.
pub fn check_bytes(path: &Path, bytes: &[u8]) -> Result<OnnxInfo> {
    if bytes.is_empty() {
        return Err(Error::model(path, ModelFault::Empty, WANTED, "0 bytes"));
    }
    if bytes.len() as u64 > MAX_BYTES {
        let (most, found) = (format!("at most {MAX_BYTES} bytes"), format!("{} bytes", bytes.len()));
        return Err(Error::model(path, ModelFault::TooBig, most, found));
    }
    if bytes.starts_with(LFS) {
        let found = format!("a pointer of {} bytes; fetch the file with `git lfs pull`", bytes.len());
        return Err(Error::model(path, ModelFault::LfsPointer, WANTED, found));
    }
    OnnxInfo::read(bytes).map_err(|error| Error::model(path, ModelFault::NotOnnx, WANTED, error))
}

/// The SHA-256 in hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Checks 2 to 7.
pub(super) fn check(
    path: &Path,
    bytes: &[u8],
    onnx: OnnxInfo,
    kind: Option<Kind>,
    options: &LoadOptions,
) -> Result<ModelInfo> {
    let sha256 = sha256(bytes);
    if let Some(wanted) = options.sha256.as_ref().filter(|wanted| !wanted.eq_ignore_ascii_case(&sha256)) {
        return Err(Error::model(path, ModelFault::Hash, wanted, sha256));
    }
    let graph = Graph::read(bytes).map_err(|error| Error::model(path, ModelFault::NotOnnx, WANTED, error))?;
    sizes::check_operators(path, &graph)?;
    let interface = check_interface(path, &onnx, kind)?;
    let side = check_tensors(path, &onnx, interface)?;
    let spec = read_spec(path, interface.kind, &onnx, side)?;
    sizes::check_sizes(path, &graph, &greatest_call(&onnx, interface, side))?;
    let mut info = ModelInfo {
        path: path.to_path_buf(),
        bytes: bytes.len(),
        sha256,
        kind: interface.kind,
        interface,
        spec,
        onnx,
        side,
        warnings: Vec::new(),
        tolerated: false,
    };
    check_configuration(&mut info, &options.configuration)?;
    if info.property("selftest").is_empty() {
        info.warnings.push("the file has no self-test; only the shape of its answers was tested".into());
    }
    Ok(info)
}

/// The inputs' sizes in the greatest call there is. Pictures of any size are looked at again in every call.
fn greatest_call<'a>(onnx: &'a OnnxInfo, interface: &Interface, side: Option<usize>) -> Vec<(&'a str, Vec<u64>)> {
    let side = side.unwrap_or(0) as u64;
    let extent = |(axis, dim): (&Axis, &Dim)| match (axis, dim) {
        (_, Dim::Fixed(n)) => *n,
        (Axis::Batch, _) => interface.chunk as u64,
        (Axis::Objects, _) => MAX_SIMULATED as u64,
        (Axis::Fixed(n), _) => *n as u64,
        (Axis::Side, _) => side,
        (Axis::HalfSide, _) => side / 2,
        (Axis::Found | Axis::Free, _) => BLANK,
    };
    let dims = |input: &TensorInfo| {
        let spec = interface.inputs.iter().find(|spec| spec.name == input.name)?;
        Some(spec.axes.iter().zip(input.dims.as_ref()?).map(extent).collect())
    };
    onnx.inputs.iter().map(|input| (input.name.as_str(), dims(input).unwrap_or_default())).collect()
}

/// All checks that need no runtime.
pub fn inspect(path: &Path, kind: Option<Kind>, options: &LoadOptions) -> Result<ModelInfo> {
    inspect_bytes(path, &read(path)?, kind, options)
}

/// The same of a file that is in memory. `path` is its name in messages.
pub fn inspect_bytes(path: &Path, bytes: &[u8], kind: Option<Kind>, options: &LoadOptions) -> Result<ModelInfo> {
    let onnx = check_bytes(path, bytes)?;
    check(path, bytes, onnx, kind, options)
}

/// Check 7 for a call with inputs of these sizes.
pub(super) fn check_call(path: &Path, bytes: &[u8], inputs: &[(&str, Vec<u64>)]) -> Result<()> {
    let graph = Graph::read(bytes).map_err(|error| Error::model(path, ModelFault::NotOnnx, WANTED, error))?;
    sizes::check_sizes(path, &graph, inputs)
}

/// Check 4.
fn check_interface(path: &Path, onnx: &OnnxInfo, wanted: Option<Kind>) -> Result<&'static Interface> {
    let known: Vec<_> = Kind::ALL.iter().map(|kind| kind.id()).collect();
    let Some(name) = onnx.metadata.get("kind") else {
        let expected = match wanted {
            Some(kind) => format!("metadata `kind` \"{kind}\""),
            None => format!("metadata `kind`, one of {}", known.join(", ")),
        };
        let found = "none; the file was not made by this project's export (docs/networks.md says what it needs)";
        return Err(Error::model(path, ModelFault::Kind, expected, found));
    };
    let kind = Kind::by_name(name).map_err(|_| {
        Error::model(path, ModelFault::Kind, format!("one of {}", known.join(", ")), format!("`{name}`"))
    })?;
    if let Some(wanted) = wanted.filter(|wanted| *wanted != kind) {
        return Err(Error::model(path, ModelFault::Kind, format!("`{wanted}`"), format!("`{kind}`")));
    }
    let numbers: Vec<_> = kind.interfaces().map(|i| i.number.to_string()).collect();
    let expected = format!("interface {} of `{kind}`", numbers.join(" or "));
    let Some(number) = onnx.metadata.get("interface") else {
        return Err(Error::model(path, ModelFault::Interface, expected, "no metadata `interface`"));
    };
    kind.interfaces()
        .find(|interface| interface.number.to_string() == number.trim())
        .ok_or_else(|| Error::model(path, ModelFault::Interface, expected, format!("`{number}`")))
}

/// Check 5. Gives the side of images.
fn check_tensors(path: &Path, onnx: &OnnxInfo, interface: &Interface) -> Result<Option<usize>> {
    let mut side = None;
    check_list(path, "an input", &onnx.inputs, interface.inputs, &mut side)?;
    check_list(path, "an output", &onnx.outputs, interface.outputs, &mut side)?;
    // What a call would have to be given is known by now.
    if let Some(extra) = onnx.inputs.iter().find(|input| interface.inputs.iter().all(|spec| spec.name != input.name)) {
        let names: Vec<_> = interface.inputs.iter().map(|spec| format!("`{}`", spec.name)).collect();
        let expected = format!("no inputs but {}", names.join(", "));
        return Err(Error::model(path, ModelFault::Tensors, expected, format!("an input {extra}")));
    }
    Ok(side)
}

fn check_list(
    path: &Path,
    what: &str,
    found: &[TensorInfo],
    specs: &[TensorSpec],
    side: &mut Option<usize>,
) -> Result<()> {
    for spec in specs {
        let Some(tensor) = found.iter().find(|tensor| tensor.name == spec.name) else {
            if spec.optional {
                continue;
            }
            let names: Vec<_> = found.iter().map(|tensor| format!("`{}`", tensor.name)).collect();
            let names = if names.is_empty() { "none".into() } else { names.join(", ") };
            let expected = format!("{what} {}", spec.describe(*side));
            return Err(Error::model(path, ModelFault::Tensors, expected, names));
        };
        let before = *side;
        if !fits(tensor, spec, side) {
            let expected = format!("{what} {}", spec.describe(before));
            let found = format!("{tensor}{}", advice(tensor, spec));
            return Err(Error::model(path, ModelFault::Tensors, expected, found));
        }
    }
    Ok(())
}

/// What to change where a tensor has what exporters do unasked.
fn advice(tensor: &TensorInfo, spec: &TensorSpec) -> &'static str {
    let dims = tensor.dims.as_deref().unwrap_or_default();
    let open = |axis: &Axis| matches!(axis, Axis::Batch | Axis::Objects);
    let fixed = dims.iter().zip(spec.axes).any(|(dim, axis)| open(axis) && matches!(dim, Dim::Fixed(_)));
    if fixed && dims.len() == spec.axes.len() {
        "; a dimension that differs from call to call must have a name: export with dynamic shapes (`dynamic_shapes` of \
         torch.onnx.export)"
    } else {
        ""
    }
}

/// The tensor is what the interface asks for.
fn fits(tensor: &TensorInfo, spec: &TensorSpec, side: &mut Option<usize>) -> bool {
    let Some(dims) = &tensor.dims else { return false };
    let dtype = if spec.integer { INT64 } else { FLOAT };
    if tensor.dtype != dtype || dims.len() != spec.axes.len() {
        return false;
    }
    dims.iter().zip(spec.axes).all(|(dim, axis)| match (axis, dim) {
        (Axis::Batch | Axis::Objects, Dim::Named(_) | Dim::Unknown) => true,
        (Axis::Batch | Axis::Objects, Dim::Fixed(_)) => false,
        (Axis::Fixed(wanted), Dim::Fixed(n)) => *n == *wanted as u64,
        (Axis::Side | Axis::HalfSide, Dim::Fixed(n)) => {
            let whole = if *axis == Axis::HalfSide { n.saturating_mul(2) } else { *n };
            let whole = usize::try_from(whole).unwrap_or(0);
            (8..=4096).contains(&whole) && *side.get_or_insert(whole) == whole
        }
        (Axis::Found | Axis::Free, _) => true,
        _ => false,
    })
}
