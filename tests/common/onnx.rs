//! Networks of the tests, and ways to spoil them: an ONNX file is a protocol buffer, whose fields are edited here.

#![allow(dead_code)]

use std::path::{Path, PathBuf};

use jostle::net::{Runtime, RuntimeOptions};

/// A network of `tests/data/nets`.
pub fn net(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/nets").join(name).with_extension("onnx")
}

pub fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(net(name)).expect("a network of the tests")
}

/// Whether networks can be run here; says so where they cannot.
pub fn runs() -> bool {
    match Runtime::open(&RuntimeOptions::default()) {
        Ok(_) => true,
        Err(error) => {
            println!("skipped: {error}");
            false
        }
    }
}

/// The file of the runtime that is used here; only where [`runs`].
pub fn library() -> String {
    let runtime = Runtime::open(&RuntimeOptions::default()).expect("a runtime");
    runtime.info().file.as_ref().expect("a library").display().to_string()
}

/// One field of a message.
enum Field<'a> {
    Number(u64),
    Bytes(&'a [u8]),
    Fixed(&'a [u8]),
}

fn varint(bytes: &mut &[u8]) -> u64 {
    let mut value = 0;
    for shift in (0..).step_by(7) {
        let byte = bytes[0];
        *bytes = &bytes[1..];
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            break;
        }
    }
    value
}

fn put(value: u64, out: &mut Vec<u8>) {
    let mut rest = value;
    while rest >= 0x80 {
        out.push(rest as u8 | 0x80);
        rest >>= 7;
    }
    out.push(rest as u8);
}

/// Writes a message anew; `edit` gets every field's number and bytes and gives what takes its place.
#[allow(clippy::type_complexity)]
fn rewrite(mut bytes: &[u8], edit: &mut dyn FnMut(u64, &[u8]) -> Option<Vec<u8>>) -> Vec<u8> {
    let mut out = Vec::new();
    while !bytes.is_empty() {
        let key = varint(&mut bytes);
        let field = match key & 7 {
            0 => Field::Number(varint(&mut bytes)),
            2 => {
                let length = varint(&mut bytes) as usize;
                let (field, rest) = bytes.split_at(length);
                bytes = rest;
                Field::Bytes(field)
            }
            wire => {
                let (field, rest) = bytes.split_at(if wire == 1 { 8 } else { 4 });
                bytes = rest;
                Field::Fixed(field)
            }
        };
        match field {
            Field::Number(value) => {
                put(key, &mut out);
                put(value, &mut out);
            }
            Field::Fixed(field) => {
                put(key, &mut out);
                out.extend(field);
            }
            Field::Bytes(field) => {
                if let Some(new) = edit(key >> 3, field) {
                    put(key, &mut out);
                    put(new.len() as u64, &mut out);
                    out.extend(new);
                }
            }
        }
    }
    out
}

/// The file with a property of its metadata set, or taken away.
pub fn with_property(bytes: &[u8], key: &str, value: Option<&str>) -> Vec<u8> {
    let mut out = rewrite(bytes, &mut |number, field| {
        let named = [&[0x0a, key.len() as u8], key.as_bytes()].concat();
        (number != 14 || !field.starts_with(&named)).then(|| field.to_vec())
    });
    if let Some(value) = value {
        let mut entry = vec![0x0a];
        put(key.len() as u64, &mut entry);
        entry.extend(key.as_bytes());
        entry.push(0x12);
        put(value.len() as u64, &mut entry);
        entry.extend(value.as_bytes());
        put(14 << 3 | 2, &mut out);
        put(entry.len() as u64, &mut out);
        out.extend(entry);
    }
    out
}

/// The file with the type of an input or output edited: `TypeProto.Tensor` in, the new one out.
fn with_type(bytes: &[u8], name: &str, edit: &dyn Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let named = [&[0x0a, name.len() as u8], name.as_bytes()].concat();
    rewrite(bytes, &mut |number, model| {
        let graph = |graph: &[u8]| {
            rewrite(graph, &mut |number, value| {
                let wanted = (number == 11 || number == 12) && value.starts_with(&named);
                let edited = |value: &[u8]| {
                    rewrite(value, &mut |number, kind| {
                        Some(match number {
                            2 => rewrite(kind, &mut |_, tensor| Some(edit(tensor))),
                            _ => kind.to_vec(),
                        })
                    })
                };
                Some(if wanted { edited(value) } else { value.to_vec() })
            })
        };
        Some(if number == 7 { graph(model) } else { model.to_vec() })
    })
}

/// The file with another element type for an input or output.
pub fn with_dtype(bytes: &[u8], name: &str, dtype: u8) -> Vec<u8> {
    with_type(bytes, name, &|tensor| {
        assert_eq!(tensor[..2], [0x08, 1], "the element type comes first, and is float");
        [&[0x08, dtype], &tensor[2..]].concat()
    })
}

/// The file with other dimensions for an input or output: a number, or a name for 0.
pub fn with_dims(bytes: &[u8], name: &str, dims: &[u64]) -> Vec<u8> {
    with_type(bytes, name, &|tensor| {
        let mut shape = Vec::new();
        for &dim in dims {
            let mut one = Vec::new();
            if dim == 0 {
                one.extend([0x12, 5]);
                one.extend(b"batch");
            } else {
                one.push(0x08);
                put(dim, &mut one);
            }
            shape.push(0x0a);
            put(one.len() as u64, &mut shape);
            shape.extend(one);
        }
        rewrite(tensor, &mut |number, field| Some(if number == 2 { shape.clone() } else { field.to_vec() }))
    })
}

/// The file with an input or output under another name.
pub fn with_name(bytes: &[u8], name: &str, new: &str) -> Vec<u8> {
    assert_eq!(name.len(), new.len(), "so that no length changes");
    let mut out = bytes.to_vec();
    while let Some(at) =
        out.windows(name.len() + 1).position(|w| w[0] as usize == name.len() && &w[1..] == name.as_bytes())
    {
        out[at + 1..=at + name.len()].copy_from_slice(new.as_bytes());
    }
    out
}

/// The file with fields added to each of its weights (`TensorProto`).
pub fn with_weight(bytes: &[u8], fields: &[u8]) -> Vec<u8> {
    rewrite(bytes, &mut |number, model| {
        let graph = |graph: &[u8]| {
            rewrite(graph, &mut |number, weight| {
                Some(if number == 5 { [weight, fields].concat() } else { weight.to_vec() })
            })
        };
        Some(if number == 7 { graph(model) } else { model.to_vec() })
    })
}
