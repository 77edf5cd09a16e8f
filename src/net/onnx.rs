//! Reads what an ONNX file says of itself: metadata, inputs and outputs, without running or building anything; and copies
//! one with the batch of its inputs fixed ([`with_batch`]).
//!
//! ONNX is a protocol buffer (`onnx.proto`). Only the fields that are needed are understood; the rest is stepped over.
//! The reader accepts any bytes: lengths are checked against what is left, nothing is recursive, and memory grows with the
//! file at most.

use std::collections::{BTreeMap, BTreeSet};

/// An element type of `TensorProto.DataType` that matters here.
pub const FLOAT: i32 = 1;

/// A dimension of a tensor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Dim {
    Fixed(u64),
    /// Decided when the network runs; tensors that name it alike agree.
    Named(String),
    Unknown,
}

impl std::fmt::Display for Dim {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Dim::Fixed(n) => write!(f, "{n}"),
            Dim::Named(name) => f.write_str(name),
            Dim::Unknown => f.write_str("?"),
        }
    }
}

/// An input or output of a network.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TensorInfo {
    pub name: String,
    /// `TensorProto.DataType`; 0 if it is no tensor.
    pub dtype: i32,
    /// `None`: of any rank.
    pub dims: Option<Vec<Dim>>,
}

impl std::fmt::Display for TensorInfo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "`{}` {}", self.name, dtype_name(self.dtype))?;
        match &self.dims {
            None => f.write_str(" of any rank"),
            Some(dims) => {
                let dims: Vec<_> = dims.iter().map(Dim::to_string).collect();
                write!(f, "[{}]", dims.join(", "))
            }
        }
    }
}

/// What ONNX calls an element type.
pub fn dtype_name(dtype: i32) -> &'static str {
    match dtype {
        1 => "float32",
        2 => "uint8",
        3 => "int8",
        4 => "uint16",
        5 => "int16",
        6 => "int32",
        7 => "int64",
        8 => "string",
        9 => "bool",
        10 => "float16",
        11 => "float64",
        12 => "uint32",
        13 => "uint64",
        16 => "bfloat16",
        0 => "no tensor",
        _ => "another element type",
    }
}

/// What an ONNX file says of itself.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct OnnxInfo {
    pub ir_version: u64,
    /// Version of the standard operators.
    pub opset: u64,
    pub producer: String,
    pub metadata: BTreeMap<String, String>,
    /// Without the weights that old files list among the inputs.
    pub inputs: Vec<TensorInfo>,
    pub outputs: Vec<TensorInfo>,
}

/// Why bytes are no ONNX file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NotOnnx {
    #[error("bytes that are no protocol buffer from byte {0} on")]
    Malformed(usize),
    #[error("a file that ends within a field that begins at byte {0}")]
    CutOff(usize),
    #[error("a protocol buffer without the fields of an ONNX model")]
    OtherProtocol,
}

pub(super) type Read<T> = Result<T, NotOnnx>;

/// A field's value.
pub(super) enum Value<'a> {
    Number(u64),
    Bytes(&'a [u8], usize),
}

/// Steps over the fields of one message.
pub(super) struct Fields<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Where the message begins within the file.
    base: usize,
}

impl<'a> Fields<'a> {
    pub fn new(bytes: &'a [u8], base: usize) -> Self {
        Self { bytes, at: 0, base }
    }

    /// Whether all was read.
    pub fn ended(&self) -> bool {
        self.at == self.bytes.len()
    }

    pub fn varint(&mut self) -> Read<u64> {
        let begin = self.at;
        let mut value = 0_u64;
        for shift in (0..64).step_by(7) {
            let Some(&byte) = self.bytes.get(self.at) else { return Err(NotOnnx::CutOff(self.base + begin)) };
            self.at += 1;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err(NotOnnx::Malformed(self.base + begin))
    }

    fn take(&mut self, length: u64, begin: usize) -> Read<&'a [u8]> {
        let left = self.bytes.len() - self.at;
        let Some(length) = usize::try_from(length).ok().filter(|length| *length <= left) else {
            return Err(NotOnnx::CutOff(self.base + begin));
        };
        let taken = &self.bytes[self.at..self.at + length];
        self.at += length;
        Ok(taken)
    }

    /// The next field's number and value.
    pub fn next(&mut self) -> Read<Option<(u64, Value<'a>)>> {
        let begin = self.at;
        if begin == self.bytes.len() {
            return Ok(None);
        }
        let key = self.varint()?;
        let number = key >> 3;
        let value = match key & 7 {
            0 => Value::Number(self.varint()?),
            1 => Value::Bytes(self.take(8, begin)?, 0),
            2 => {
                let length = self.varint()?;
                let from = self.base + self.at;
                Value::Bytes(self.take(length, begin)?, from)
            }
            5 => Value::Bytes(self.take(4, begin)?, 0),
            _ => return Err(NotOnnx::Malformed(self.base + begin)),
        };
        // Field numbers have 29 bits; what is longer other readers cut to fit.
        if number == 0 || number >= 1 << 29 {
            return Err(NotOnnx::Malformed(self.base + begin));
        }
        Ok(Some((number, value)))
    }
}

pub(super) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

impl OnnxInfo {
    /// Reads a `ModelProto`.
    pub fn read(bytes: &[u8]) -> Read<OnnxInfo> {
        let mut info = OnnxInfo::default();
        let mut graph = false;
        let mut fields = Fields::new(bytes, 0);
        while let Some((number, value)) = fields.next()? {
            match (number, value) {
                (1, Value::Number(version)) => info.ir_version = version,
                (2, Value::Bytes(name, _)) => info.producer = text(name),
                (7, Value::Bytes(inner, base)) => {
                    info.graph(inner, base)?;
                    graph = true;
                }
                (8, Value::Bytes(inner, base)) => info.operators(inner, base)?,
                (14, Value::Bytes(inner, base)) => info.property(inner, base)?,
                _ => {}
            }
        }
        if graph && info.ir_version > 0 { Ok(info) } else { Err(NotOnnx::OtherProtocol) }
    }

    /// `OperatorSetIdProto`.
    fn operators(&mut self, bytes: &[u8], base: usize) -> Read<()> {
        let (mut standard, mut version) = (true, 0);
        let mut fields = Fields::new(bytes, base);
        while let Some((number, value)) = fields.next()? {
            match (number, value) {
                (1, Value::Bytes(domain, _)) => standard = domain.is_empty() || domain == b"ai.onnx",
                (2, Value::Number(n)) => version = n,
                _ => {}
            }
        }
        if standard {
            self.opset = self.opset.max(version);
        }
        Ok(())
    }

    /// `StringStringEntryProto`.
    fn property(&mut self, bytes: &[u8], base: usize) -> Read<()> {
        let (mut key, mut content) = (String::new(), String::new());
        let mut fields = Fields::new(bytes, base);
        while let Some((number, value)) = fields.next()? {
            match (number, value) {
                (1, Value::Bytes(bytes, _)) => key = text(bytes),
                (2, Value::Bytes(bytes, _)) => content = text(bytes),
                _ => {}
            }
        }
        self.metadata.insert(key, content);
        Ok(())
    }

    /// `GraphProto`.
    fn graph(&mut self, bytes: &[u8], base: usize) -> Read<()> {
        let mut weights = BTreeSet::new();
        let mut fields = Fields::new(bytes, base);
        while let Some((number, value)) = fields.next()? {
            match (number, value) {
                // `TensorProto`: its name is field 8.
                (5, Value::Bytes(inner, base)) => {
                    let mut fields = Fields::new(inner, base);
                    while let Some((number, value)) = fields.next()? {
                        if let (8, Value::Bytes(name, _)) = (number, value) {
                            weights.insert(text(name));
                        }
                    }
                }
                (11, Value::Bytes(inner, base)) => self.inputs.push(tensor(inner, base)?),
                (12, Value::Bytes(inner, base)) => self.outputs.push(tensor(inner, base)?),
                _ => {}
            }
        }
        self.inputs.retain(|input| !weights.contains(&input.name));
        Ok(())
    }
}

/// `ValueInfoProto`.
fn tensor(bytes: &[u8], base: usize) -> Read<TensorInfo> {
    let mut info = TensorInfo { name: String::new(), dtype: 0, dims: None };
    let mut fields = Fields::new(bytes, base);
    while let Some((number, value)) = fields.next()? {
        match (number, value) {
            (1, Value::Bytes(name, _)) => info.name = text(name),
            // `TypeProto`, of which field 1 is `TypeProto.Tensor`.
            (2, Value::Bytes(inner, base)) => {
                let mut fields = Fields::new(inner, base);
                while let Some((number, value)) = fields.next()? {
                    if let (1, Value::Bytes(inner, base)) = (number, value) {
                        tensor_type(inner, base, &mut info)?;
                    }
                }
            }
            _ => {}
        }
    }
    Ok(info)
}

/// `TypeProto.Tensor`.
fn tensor_type(bytes: &[u8], base: usize, info: &mut TensorInfo) -> Read<()> {
    let mut fields = Fields::new(bytes, base);
    while let Some((number, value)) = fields.next()? {
        match (number, value) {
            (1, Value::Number(dtype)) => info.dtype = i32::try_from(dtype).unwrap_or(-1),
            (2, Value::Bytes(inner, base)) => {
                let mut dims = Vec::new();
                let mut fields = Fields::new(inner, base);
                while let Some((number, value)) = fields.next()? {
                    if let (1, Value::Bytes(inner, base)) = (number, value) {
                        dims.push(dim(inner, base)?);
                    }
                }
                info.dims = Some(dims);
            }
            _ => {}
        }
    }
    Ok(())
}

/// `TensorShapeProto.Dimension`.
fn dim(bytes: &[u8], base: usize) -> Read<Dim> {
    let mut dim = Dim::Unknown;
    let mut fields = Fields::new(bytes, base);
    while let Some((number, value)) = fields.next()? {
        match (number, value) {
            (1, Value::Number(n)) => dim = Dim::Fixed(n),
            (2, Value::Bytes(name, _)) if !name.is_empty() => dim = Dim::Named(text(name)),
            _ => {}
        }
    }
    Ok(dim)
}

/// Fields that lead from a `ModelProto` to a dimension of an input: graph, input, type, tensor type, shape, dimension.
const INPUT_DIMENSION: [u64; 6] = [7, 11, 2, 1, 2, 1];

/// The same file in which every input's first dimension has this size, where it was left open. All else stays as it is,
/// byte for byte.
pub fn with_batch(bytes: &[u8], batch: u64) -> Read<Vec<u8>> {
    let mut out = Vec::with_capacity(bytes.len() + 64);
    copy_with_batch(bytes, 0, &INPUT_DIMENSION, batch, &mut out)?;
    Ok(out)
}

/// Copies a message; `path` leads from it to the dimension.
fn copy_with_batch(bytes: &[u8], base: usize, path: &[u64], batch: u64, out: &mut Vec<u8>) -> Read<()> {
    let [next, rest @ ..] = path else { return Ok(()) };
    let (mut fields, mut first) = (Fields::new(bytes, base), true);
    loop {
        let begin = fields.at;
        let Some((number, value)) = fields.next()? else { return Ok(()) };
        match value {
            // A message within the file has a place; numbers of fixed width, which have no fields, have 0.
            Value::Bytes(inner, base) if number == *next && base > 0 && (first || !rest.is_empty()) => {
                first = false;
                let mut content = Vec::with_capacity(inner.len() + 16);
                if !rest.is_empty() {
                    copy_with_batch(inner, base, rest, batch, &mut content)?;
                } else if let Dim::Fixed(_) = dim(inner, base)? {
                    content.extend_from_slice(inner);
                } else {
                    // `dim_value`, field 1, a number.
                    content.push(1 << 3);
                    write_varint(batch, &mut content);
                }
                write_varint(number << 3 | 2, out);
                write_varint(content.len() as u64, out);
                out.append(&mut content);
            }
            _ => out.extend_from_slice(&bytes[begin..fields.at]),
        }
    }
}

fn write_varint(mut value: u64, out: &mut Vec<u8>) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn net(name: &str) -> Vec<u8> {
        let file = format!("{}/tests/data/nets/{name}.onnx", env!("CARGO_MANIFEST_DIR"));
        std::fs::read(&file).unwrap_or_else(|e| panic!("{file}: {e}"))
    }

    #[test]
    fn a_batch_is_fixed_in_every_input_and_nowhere_else() {
        for name in ["dipn", "ppn", "gc", "gn", "segmentation"] {
            let bytes = net(name);
            let before = OnnxInfo::read(&bytes).unwrap();
            let fixed = with_batch(&bytes, 300).unwrap();
            let mut after = OnnxInfo::read(&fixed).unwrap();
            assert!(!before.inputs.is_empty());
            for (input, was) in after.inputs.iter_mut().zip(&before.inputs) {
                let (dims, was) = (input.dims.as_mut().unwrap(), was.dims.as_ref().unwrap());
                assert_eq!(dims[0], Dim::Fixed(300), "{name}");
                dims[0] = was[0].clone();
            }
            assert_eq!(after, before, "{name}");
            assert_eq!(with_batch(&fixed, 7).unwrap(), fixed, "what has a size keeps it");
        }
    }

    #[test]
    fn bytes_cut_off_anywhere_are_an_error_or_a_shorter_file() {
        let bytes = net("gc");
        for end in 0..bytes.len().min(4000) {
            if let Ok(fixed) = with_batch(&bytes[..end], 1) {
                assert!(fixed.len() <= end + 64, "{end}");
            }
        }
    }
}
