//! Tensor files in the safetensors format, written with the same bytes for the same content.
//!
//! A file is the length of its header (8 bytes, little-endian), the header (JSON, padded with blanks to a multiple of
//! 8) and the tensors one after the other. The format's own library writes the entries of `__metadata__` in random
//! order, so that equal data would have unequal hashes; tests read the files with that library.

use std::fmt::Write as _;

use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};

/// A named array, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct Tensor {
    pub name: &'static str,
    pub shape: Vec<usize>,
    pub data: Data,
}

/// The numbers of a tensor.
#[derive(Debug, Clone, PartialEq)]
pub enum Data {
    U8(Vec<u8>),
    U16(Vec<u16>),
    U32(Vec<u32>),
    I64(Vec<i64>),
    F32(Vec<f32>),
}

impl Data {
    fn type_name(&self) -> &'static str {
        match self {
            Data::U8(_) => "U8",
            Data::U16(_) => "U16",
            Data::U32(_) => "U32",
            Data::I64(_) => "I64",
            Data::F32(_) => "F32",
        }
    }

    fn bytes(&self) -> usize {
        match self {
            Data::U8(v) => v.len(),
            Data::U16(v) => v.len() * 2,
            Data::U32(v) => v.len() * 4,
            Data::I64(v) => v.len() * 8,
            Data::F32(v) => v.len() * 4,
        }
    }

    /// Bytes of a number: the alignment it is stored with.
    fn width(&self) -> usize {
        match self {
            Data::U8(_) => 1,
            Data::U16(_) => 2,
            Data::U32(_) | Data::F32(_) => 4,
            Data::I64(_) => 8,
        }
    }

    fn append_to(&self, out: &mut Vec<u8>) {
        match self {
            Data::U8(v) => out.extend_from_slice(v),
            Data::U16(v) => v.iter().for_each(|n| out.extend_from_slice(&n.to_le_bytes())),
            Data::U32(v) => v.iter().for_each(|n| out.extend_from_slice(&n.to_le_bytes())),
            Data::I64(v) => v.iter().for_each(|n| out.extend_from_slice(&n.to_le_bytes())),
            Data::F32(v) => v.iter().for_each(|n| out.extend_from_slice(&n.to_le_bytes())),
        }
    }
}

impl Tensor {
    pub fn new(name: &'static str, shape: impl Into<Vec<usize>>, data: Data) -> Tensor {
        Tensor { name, shape: shape.into(), data }
    }
}

/// The bytes of a file. Wide numbers come first, so that all are aligned. `metadata` is text by name.
pub fn file(mut tensors: Vec<Tensor>, metadata: &[(&str, String)]) -> Vec<u8> {
    tensors.sort_by(|a, b| b.data.width().cmp(&a.data.width()).then(a.name.cmp(b.name)));
    let mut header = Map::new();
    let notes: Map<String, Value> = metadata.iter().map(|(k, v)| (String::from(*k), json!(v))).collect();
    header.insert("__metadata__".into(), Value::Object(notes));
    let mut end = 0;
    for tensor in &tensors {
        let begin = end;
        end += tensor.data.bytes();
        let entry = json!({"dtype": tensor.data.type_name(), "shape": tensor.shape, "data_offsets": [begin, end]});
        header.insert(tensor.name.into(), entry);
    }
    let mut text = Value::Object(header).to_string();
    while !text.len().is_multiple_of(8) {
        text.push(' ');
    }
    let mut out = Vec::with_capacity(8 + text.len() + end);
    out.extend_from_slice(&(text.len() as u64).to_le_bytes());
    out.extend_from_slice(text.as_bytes());
    tensors.iter().for_each(|t| t.data.append_to(&mut out));
    out
}

/// SHA-256 in lower-case hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(64);
    for byte in Sha256::digest(bytes) {
        let _ = write!(text, "{byte:02x}");
    }
    text
}

#[cfg(test)]
mod tests {
    use safetensors::{Dtype, SafeTensors};

    use super::*;

    #[test]
    fn the_formats_own_library_reads_what_is_written() {
        let tensors = vec![
            Tensor::new("flags", [3], Data::U8(vec![1, 2, 3])),
            Tensor::new("index", [1, 2], Data::U16(vec![7, 65535])),
            Tensor::new("count", [1], Data::U32(vec![4_000_000_000])),
            Tensor::new("long", [2], Data::I64(vec![-1, 1 << 40])),
            Tensor::new("real", [2, 1], Data::F32(vec![0.5, -1.25])),
        ];
        let bytes = file(tensors.clone(), &[("format", "a/1".into()), ("note", "b".into())]);
        assert_eq!(bytes, file(tensors, &[("format", "a/1".into()), ("note", "b".into())]));
        let (_, header) = SafeTensors::read_metadata(&bytes).unwrap();
        assert_eq!(header.metadata().as_ref().unwrap()["format"], "a/1");
        let read = SafeTensors::deserialize(&bytes).unwrap();
        let real = read.tensor("real").unwrap();
        assert_eq!((real.dtype(), real.shape()), (Dtype::F32, &[2, 1][..]));
        assert_eq!(real.data(), [0.5f32.to_le_bytes(), (-1.25f32).to_le_bytes()].concat());
        assert_eq!(read.tensor("long").unwrap().data()[..8], (-1i64).to_le_bytes());
        assert_eq!(read.tensor("index").unwrap().data()[2..], 65535u16.to_le_bytes());
    }

    #[test]
    fn the_hash_is_the_published_one() {
        assert_eq!(sha256(b"abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }
}
