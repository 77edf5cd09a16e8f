//! The graph of an ONNX file: operators, weights by their shapes, and small constants by their values; without running or
//! building anything.
//!
//! As in `onnx`, any bytes are accepted, and memory grows with the file at most. What is understood is what `sizes` needs
//! to tell how big a network becomes; what it must not have (weights in other files, graphs within operators, functions,
//! sparse weights) is noted.

use std::collections::HashMap;

use super::onnx::{Fields, Read, Value, text};

/// Greatest number of values of a constant that are kept: constants of this size say sizes, greater ones are weights.
const KEPT: usize = 4096;

/// Of a `ModelProto`.
#[derive(Debug, Clone, Default)]
pub(super) struct Graph {
    pub nodes: Vec<Node>,
    pub weights: HashMap<String, Tensor>,
    /// Functions of the file's own.
    pub functions: usize,
    /// Weights that are given by the values that are not zero.
    pub sparse: usize,
}

/// `NodeProto`: an operator.
#[derive(Debug, Clone, Default)]
pub(super) struct Node {
    pub operator: String,
    pub domain: String,
    /// An absent one has no name.
    pub inputs: Vec<String>,
    pub outputs: Vec<String>,
    pub attributes: HashMap<String, Attribute>,
    /// It has a graph of its own.
    pub nested: bool,
}

/// `AttributeProto`.
#[derive(Debug, Clone, Default)]
pub(super) struct Attribute {
    pub int: i64,
    pub ints: Vec<i64>,
    pub float: f32,
    pub floats: Vec<f32>,
    pub text: String,
    pub tensor: Option<Tensor>,
}

/// `TensorProto`.
#[derive(Debug, Clone, Default)]
pub(super) struct Tensor {
    pub name: String,
    pub dims: Vec<u64>,
    pub dtype: i32,
    /// Bytes of its values within the file.
    pub bytes: usize,
    /// The values are in another file.
    pub external: bool,
    /// The values, where there are few and they are numbers.
    pub values: Option<Vec<f64>>,
}

impl Graph {
    /// Reads a `ModelProto`.
    pub fn read(bytes: &[u8]) -> Read<Graph> {
        let mut graph = Graph::default();
        let mut fields = Fields::new(bytes, 0);
        while let Some((number, value)) = fields.next()? {
            match (number, value) {
                (7, Value::Bytes(inner, base)) => graph.extend(inner, base)?,
                (25, _) => graph.functions += 1,
                _ => {}
            }
        }
        Ok(graph)
    }

    /// `GraphProto`.
    fn extend(&mut self, bytes: &[u8], base: usize) -> Read<()> {
        let mut fields = Fields::new(bytes, base);
        while let Some((number, value)) = fields.next()? {
            match (number, value) {
                (1, Value::Bytes(inner, base)) => self.nodes.push(node(inner, base)?),
                (5, Value::Bytes(inner, base)) => {
                    let mut tensor = Tensor::default();
                    tensor.extend(inner, base)?;
                    self.weights.insert(tensor.name.clone(), tensor);
                }
                (15, _) => self.sparse += 1,
                _ => {}
            }
        }
        Ok(())
    }

    /// All constants: weights and those within operators.
    pub fn constants(&self) -> impl Iterator<Item = &Tensor> {
        let within = self.nodes.iter().flat_map(|node| node.attributes.values()).filter_map(|a| a.tensor.as_ref());
        self.weights.values().chain(within)
    }
}

impl Node {
    pub fn int(&self, name: &str, usual: i64) -> i64 {
        self.attributes.get(name).map_or(usual, |attribute| attribute.int)
    }

    pub fn ints(&self, name: &str) -> Option<&[i64]> {
        self.attributes.get(name).map(|attribute| attribute.ints.as_slice())
    }

    pub fn text(&self, name: &str) -> &str {
        self.attributes.get(name).map_or("", |attribute| &attribute.text)
    }
}

fn node(bytes: &[u8], base: usize) -> Read<Node> {
    let mut node = Node::default();
    let mut fields = Fields::new(bytes, base);
    while let Some((number, value)) = fields.next()? {
        match (number, value) {
            (1, Value::Bytes(name, _)) => node.inputs.push(text(name)),
            (2, Value::Bytes(name, _)) => node.outputs.push(text(name)),
            (4, Value::Bytes(name, _)) => node.operator = text(name),
            (5, Value::Bytes(inner, base)) => {
                let (name, attribute, nested) = attribute(inner, base)?;
                node.nested |= nested;
                node.attributes.insert(name, attribute);
            }
            (7, Value::Bytes(name, _)) => node.domain = text(name),
            _ => {}
        }
    }
    Ok(node)
}

/// Name, content, and whether it is a graph.
fn attribute(bytes: &[u8], base: usize) -> Read<(String, Attribute, bool)> {
    let (mut name, mut attribute, mut nested) = (String::new(), Attribute::default(), false);
    let mut fields = Fields::new(bytes, base);
    while let Some((number, value)) = fields.next()? {
        match (number, value) {
            (1, Value::Bytes(bytes, _)) => name = text(bytes),
            (2, Value::Bytes(bytes, _)) => attribute.float = floats(bytes).next().unwrap_or(0.0),
            (3, Value::Number(n)) => attribute.int = n as i64,
            (4, Value::Bytes(bytes, _)) => attribute.text = text(bytes),
            (5, Value::Bytes(inner, base)) => attribute.tensor.get_or_insert_default().extend(inner, base)?,
            (7, Value::Bytes(bytes, _)) => attribute.floats.extend(floats(bytes)),
            (8, value) => each_number(value, |n| attribute.ints.push(n as i64))?,
            // A graph, or several; a tensor of few values, tensors: no operator that is taken has any.
            (6 | 10 | 11 | 22 | 23, _) => nested = true,
            _ => {}
        }
    }
    Ok((name, attribute, nested))
}

impl Tensor {
    /// A message that occurs twice goes on where the first ended, as every reader of protocol buffers has it.
    fn extend(&mut self, bytes: &[u8], base: usize) -> Read<()> {
        let mut given: Vec<f64> = Vec::new();
        let mut raw: &[u8] = &[];
        let mut fields = Fields::new(bytes, base);
        while let Some((number, value)) = fields.next()? {
            match (number, value) {
                (1, value) => each_number(value, |n| self.dims.push(n))?,
                (2, Value::Number(dtype)) => self.dtype = i32::try_from(dtype).unwrap_or(-1),
                (4, Value::Bytes(bytes, _)) => {
                    self.bytes += bytes.len();
                    given.extend(floats(bytes).take(KEPT + 1 - given.len().min(KEPT + 1)).map(f64::from));
                }
                (5 | 7 | 11, value) => each_number(value, |n| {
                    // A number takes a byte at least in the file, and up to eight in memory.
                    self.bytes += 8;
                    if given.len() <= KEPT {
                        given.push(n as i64 as f64);
                    }
                })?,
                (6, Value::Bytes(bytes, _)) => self.bytes += bytes.len().max(1),
                (8, Value::Bytes(name, _)) => self.name = text(name),
                (9, Value::Bytes(bytes, _)) => {
                    self.bytes = bytes.len();
                    raw = bytes;
                }
                (10, Value::Bytes(bytes, _)) => self.bytes += bytes.len(),
                (13, _) => self.external = true,
                (14, Value::Number(place)) => self.external |= place != 0,
                _ => {}
            }
        }
        if !raw.is_empty() {
            given = raw_values(raw, self.dtype);
        }
        let count = self.count();
        self.values = (count <= KEPT as u64 && given.len() as u64 == count).then_some(given);
        Ok(())
    }

    /// Values it says it has.
    pub fn count(&self) -> u64 {
        self.dims.iter().fold(1, |product, dim| product.saturating_mul(*dim))
    }
}

/// A number, or several in one field.
fn each_number(value: Value<'_>, mut take: impl FnMut(u64)) -> Read<()> {
    match value {
        Value::Number(n) => take(n),
        Value::Bytes(bytes, base) => {
            let mut fields = Fields::new(bytes, base);
            while !fields.ended() {
                take(fields.varint()?);
            }
        }
    }
    Ok(())
}

fn floats(bytes: &[u8]) -> impl Iterator<Item = f32> + '_ {
    bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b))
}

/// The first values of a weight's bytes, where they are numbers that say sizes.
fn raw_values(raw: &[u8], dtype: i32) -> Vec<f64> {
    match dtype {
        1 => floats(raw).take(KEPT + 1).map(f64::from).collect(),
        6 => raw.as_chunks::<4>().0.iter().take(KEPT + 1).map(|b| f64::from(i32::from_le_bytes(*b))).collect(),
        7 => raw.as_chunks::<8>().0.iter().take(KEPT + 1).map(|b| i64::from_le_bytes(*b) as f64).collect(),
        9 => raw.iter().take(KEPT + 1).map(|b| f64::from(*b)).collect(),
        _ => Vec::new(),
    }
}
