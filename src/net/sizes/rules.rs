//! For every operator that a network may have: the sizes of its results by those of its inputs, as the ONNX standard has
//! them. Values are followed where they say sizes (`Shape` and what is computed from it).

use super::sums::{conv, conv_transpose, einsum, gemm, global_pool, matmul, pool, resize};
use crate::net::graph::{Node, Tensor};

/// Greatest number of values that are followed.
const FOLLOWED: u64 = 4096;
/// Of `TensorProto.DataType`: the types whose values are followed.
const FLOAT: i64 = 1;
const INT32: i64 = 6;
const INT64: i64 = 7;

/// What is known of a tensor.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Shaped {
    pub dims: Vec<u64>,
    /// Its values, where they are known.
    pub values: Option<Vec<f64>>,
    /// They are integers: division rounds towards zero.
    pub whole: bool,
    /// It is made of constants alone.
    pub constant: bool,
}

/// What an operator makes.
#[derive(Debug)]
pub(super) struct Made {
    pub outputs: Vec<Shaped>,
    /// Multiplications, or operations of like cost.
    pub work: u64,
}

pub(super) type Inputs<'a> = [Option<&'a Shaped>];
pub(super) type Rule = fn(&Node, &Inputs<'_>) -> Result<Made, String>;

impl Shaped {
    pub fn of(dims: Vec<u64>) -> Shaped {
        Shaped { dims, ..Shaped::default() }
    }

    pub fn constant(tensor: &Tensor) -> Shaped {
        let dtype = i64::from(tensor.dtype);
        let values = tensor.values.clone().filter(|_| matches!(dtype, FLOAT | INT32 | INT64));
        Shaped { dims: tensor.dims.clone(), values, whole: dtype == INT32 || dtype == INT64, constant: true }
    }

    pub fn count(&self) -> u64 {
        product(&self.dims)
    }

    fn whole(dims: Vec<u64>, values: Vec<f64>) -> Shaped {
        Shaped { dims, values: Some(values), whole: true, constant: false }
    }
}

pub(super) fn product(dims: &[u64]) -> u64 {
    dims.iter().fold(1, |product, dim| product.saturating_mul(*dim))
}

/// The rule of an operator; none for one that is not taken.
pub(super) fn rule(operator: &str) -> Option<Rule> {
    Some(match operator {
        "Abs"
        | "Acos"
        | "Acosh"
        | "Asin"
        | "Asinh"
        | "Atan"
        | "Atanh"
        | "BatchNormalization"
        | "Cast"
        | "CastLike"
        | "Ceil"
        | "Celu"
        | "Clip"
        | "Cos"
        | "Cosh"
        | "CumSum"
        | "Dropout"
        | "Elu"
        | "Erf"
        | "Exp"
        | "Floor"
        | "Gelu"
        | "GroupNormalization"
        | "HardSigmoid"
        | "HardSwish"
        | "Hardmax"
        | "Identity"
        | "InstanceNormalization"
        | "IsInf"
        | "IsNaN"
        | "LRN"
        | "LayerNormalization"
        | "LeakyRelu"
        | "Log"
        | "LogSoftmax"
        | "LpNormalization"
        | "Mish"
        | "Neg"
        | "Not"
        | "PRelu"
        | "RMSNormalization"
        | "Reciprocal"
        | "Relu"
        | "Round"
        | "ScatterElements"
        | "ScatterND"
        | "Selu"
        | "Sigmoid"
        | "Sign"
        | "Sin"
        | "Sinh"
        | "Softmax"
        | "Softplus"
        | "Softsign"
        | "Sqrt"
        | "Swish"
        | "Tan"
        | "Tanh"
        | "ThresholdedRelu"
        | "Trilu" => same,
        "Add" | "And" | "Div" | "Equal" | "Greater" | "GreaterOrEqual" | "Less" | "LessOrEqual" | "Max" | "Mean"
        | "Min" | "Mod" | "Mul" | "Or" | "Pow" | "Sub" | "Sum" | "Where" | "Xor" => broadcast,
        "ArgMax" | "ArgMin" => argument,
        "ReduceL1" | "ReduceL2" | "ReduceLogSum" | "ReduceLogSumExp" | "ReduceMax" | "ReduceMean" | "ReduceMin"
        | "ReduceProd" | "ReduceSum" | "ReduceSumSquare" => reduce,
        "AveragePool" | "LpPool" | "MaxPool" => pool,
        "GlobalAveragePool" | "GlobalMaxPool" => global_pool,
        "Concat" => concat,
        "Constant" => constant,
        "ConstantOfShape" => constant_of_shape,
        "Conv" => conv,
        "ConvTranspose" => conv_transpose,
        "DepthToSpace" => depth_to_space,
        "Einsum" => einsum,
        "Expand" => expand,
        "Flatten" => flatten,
        "Gather" => gather,
        "GatherElements" => gather_elements,
        "GatherND" => gather_nd,
        "Gemm" => gemm,
        "MatMul" => matmul,
        "OneHot" => one_hot,
        "Pad" => pad,
        "Range" => range,
        "Reshape" => reshape,
        "Resize" => resize,
        "Shape" => shape,
        "Size" => size_of,
        "Slice" => slice,
        "SpaceToDepth" => space_to_depth,
        "Split" => split,
        "Squeeze" => squeeze,
        "Tile" => tile,
        "TopK" => top_k,
        "Transpose" => transpose,
        "Unsqueeze" => unsqueeze,
        _ => return None,
    })
}

pub(super) fn input<'a>(inputs: &Inputs<'a>, at: usize) -> Result<&'a Shaped, String> {
    inputs.get(at).copied().flatten().ok_or_else(|| format!("lacks its input {at}"))
}

pub(super) fn optional<'a>(inputs: &Inputs<'a>, at: usize) -> Option<&'a Shaped> {
    inputs.get(at).copied().flatten()
}

pub(super) fn values(shaped: &Shaped) -> Result<&[f64], String> {
    shaped.values.as_deref().ok_or_else(|| "makes a size that depends on values".to_string())
}

/// Whole numbers of an input, or of the attribute that older versions have in its place.
fn numbers(node: &Node, inputs: &Inputs<'_>, at: usize, name: &str) -> Result<Option<Vec<i64>>, String> {
    match optional(inputs, at) {
        Some(shaped) => Ok(Some(values(shaped)?.iter().map(|v| *v as i64).collect())),
        None => Ok(node.ints(name).map(<[i64]>::to_vec)),
    }
}

fn one(shaped: Shaped) -> Result<Made, String> {
    let work = shaped.count();
    Ok(Made { outputs: vec![shaped], work })
}

pub(super) fn working(dims: Vec<u64>, work: u64) -> Result<Made, String> {
    Ok(Made { outputs: vec![Shaped::of(dims)], work })
}

pub(super) fn misfit<T>() -> Result<T, String> {
    Err("gets inputs whose sizes do not fit".into())
}

pub(super) fn axis(at: i64, rank: usize) -> Result<usize, String> {
    let at = if at < 0 { at.saturating_add(rank as i64) } else { at };
    usize::try_from(at).ok().filter(|at| *at < rank).ok_or_else(|| format!("names dimension {at} of {rank}"))
}

/// A size that was computed.
pub(super) fn extent(value: f64) -> Result<u64, String> {
    if (0.0..=1e12).contains(&value) { Ok(value as u64) } else { Err(format!("makes a dimension of {value}")) }
}

fn extents(values: &[f64]) -> Result<Vec<u64>, String> {
    values.iter().map(|v| extent(*v)).collect()
}

/// A computed value as a runtime has it, in 32-bit floats or in integers of 32 or 64 bits; none where it would depend on
/// which of them: a size is told for certain or not at all.
fn stored(value: f64, whole: bool) -> Option<f64> {
    if whole { (value.abs() < f64::from(i32::MAX)).then_some(value) } else { Some(f64::from(value as f32)) }
}

fn same(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let from = input(inputs, 0)?;
    let to = node.int("to", 0);
    let each: Option<fn(f64) -> f64> = match node.operator.as_str() {
        "Identity" => Some(|v| v),
        "Neg" => Some(|v| -v),
        "Abs" => Some(f64::abs),
        "Floor" => Some(f64::floor),
        "Ceil" => Some(f64::ceil),
        "Cast" if to == FLOAT => Some(|v| v),
        "Cast" if to == INT32 || to == INT64 => Some(f64::trunc),
        _ => None,
    };
    let mut out = Shaped::of(from.dims.clone());
    out.whole = if node.operator == "Cast" { to == INT32 || to == INT64 } else { from.whole };
    let whole = out.whole;
    out.values = each.and_then(|each| from.values.as_ref()?.iter().map(|v| stored(each(*v), whole)).collect());
    let work = out.count();
    // Further results (a mask, statistics) are no greater.
    Ok(Made { outputs: vec![out; node.outputs.len().max(1)], work })
}

/// The dimensions of what is made of both, each as the other where it is 1.
pub(super) fn broadcast_dims(a: &[u64], b: &[u64]) -> Result<Vec<u64>, String> {
    let rank = a.len().max(b.len());
    let at = |dims: &[u64], k: usize| if k + dims.len() < rank { 1 } else { dims[k + dims.len() - rank] };
    (0..rank)
        .map(|k| match (at(a, k), at(b, k)) {
            (1, n) | (n, 1) => Ok(n),
            (n, m) if n == m => Ok(n),
            _ => misfit(),
        })
        .collect()
}

/// Values of `from` as it is repeated to fill `dims`.
fn spread(from: &Shaped, dims: &[u64]) -> Option<Vec<f64>> {
    let (values, count) = (from.values.as_ref()?, product(dims));
    if count > FOLLOWED {
        return None;
    }
    let index = |mut flat: u64| {
        let (mut place, mut stride) = (0, 1);
        for k in (0..dims.len()).rev() {
            let at = flat % dims[k];
            flat /= dims[k];
            if let Some(own) = (k + from.dims.len()).checked_sub(dims.len()) {
                place += stride * if from.dims[own] == 1 { 0 } else { at };
                stride *= from.dims[own];
            }
        }
        place as usize
    };
    (0..count).map(|flat| values.get(index(flat)).copied()).collect()
}

fn broadcast(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let mut dims = Vec::new();
    for at in 0..inputs.len() {
        dims = broadcast_dims(&dims, &input(inputs, at)?.dims)?;
    }
    let mut out = Shaped::of(dims);
    out.whole = inputs.iter().flatten().all(|input| input.whole);
    let all: Option<Vec<Vec<f64>>> = inputs.iter().flatten().map(|input| spread(input, &out.dims)).collect();
    let truth = |yes: bool| if yes { 1.0 } else { 0.0 };
    let (whole, fmod) = (out.whole, node.int("fmod", 0) != 0);
    out.values = all.and_then(|all| {
        let of = |k: usize| -> Option<f64> {
            let v: Vec<f64> = all.iter().map(|values| values[k]).collect();
            Some(match (node.operator.as_str(), v.as_slice()) {
                ("Add" | "Sum", v) => v.iter().sum(),
                ("Sub", [a, b]) => a - b,
                ("Mul", [a, b]) => a * b,
                ("Div", [a, b]) if whole && *b != 0.0 => (a / b).trunc(),
                ("Div", [a, b]) if !whole => a / b,
                // With the sign of the divisor, or by `fmod` of what is divided.
                ("Mod", [a, b]) if whole && *b != 0.0 => match a % b {
                    rest if fmod || rest == 0.0 || (rest < 0.0) == (*b < 0.0) => rest,
                    rest => rest + b,
                },
                ("Min", v) => v.iter().copied().fold(f64::INFINITY, f64::min),
                ("Max", v) => v.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                ("Equal", [a, b]) => truth(a == b),
                ("Less", [a, b]) => truth(a < b),
                ("LessOrEqual", [a, b]) => truth(a <= b),
                ("Greater", [a, b]) => truth(a > b),
                ("GreaterOrEqual", [a, b]) => truth(a >= b),
                ("Where", [yes, a, b]) => {
                    if *yes != 0.0 {
                        *a
                    } else {
                        *b
                    }
                }
                _ => return None,
            })
            .and_then(|value| stored(value, whole))
        };
        (0..out.count() as usize).map(of).collect()
    });
    if node.operator == "Where" {
        // The condition is no number.
        out.whole = inputs.iter().skip(1).flatten().all(|input| input.whole);
    }
    one(out)
}

fn reduced(dims: &[u64], axes: &[usize], keep: bool) -> Vec<u64> {
    let kept = |k: &usize| keep || !axes.contains(k);
    (0..dims.len()).filter(kept).map(|k| if axes.contains(&k) { 1 } else { dims[k] }).collect()
}

fn reduce(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let from = input(inputs, 0)?;
    let rank = from.dims.len();
    let named = numbers(node, inputs, 1, "axes")?.unwrap_or_default();
    let mut axes = named.iter().map(|at| axis(*at, rank)).collect::<Result<Vec<_>, _>>()?;
    if axes.is_empty() && node.int("noop_with_empty_axes", 0) == 0 {
        axes = (0..rank).collect();
    }
    let mut out = Shaped::of(reduced(&from.dims, &axes, node.int("keepdims", 1) != 0));
    if axes.len() == rank {
        let each = from.values.as_deref().map(<[f64]>::iter);
        out.values = match node.operator.as_str() {
            // The order of a sum of floats is the runtime's own.
            "ReduceProd" if from.whole => each.map(Iterator::product),
            "ReduceSum" if from.whole => each.map(Iterator::sum),
            "ReduceMax" => each.map(|v| v.copied().fold(f64::NEG_INFINITY, f64::max)),
            "ReduceMin" => each.map(|v| v.copied().fold(f64::INFINITY, f64::min)),
            _ => None,
        }
        .and_then(|value: f64| Some(vec![stored(value, from.whole)?]));
    }
    out.whole = from.whole;
    Ok(Made { outputs: vec![out], work: from.count() })
}

fn argument(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let from = input(inputs, 0)?;
    let at = axis(node.int("axis", 0), from.dims.len())?;
    working(reduced(&from.dims, &[at], node.int("keepdims", 1) != 0), from.count())
}

fn shape(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let dims = &input(inputs, 0)?.dims;
    let rank = dims.len() as i64;
    let at = |value: i64| (if value < 0 { value.saturating_add(rank) } else { value }).clamp(0, rank) as usize;
    let (from, to) = (at(node.int("start", 0)), at(node.int("end", rank)));
    let values: Vec<f64> = dims[from.min(to)..to].iter().map(|n| *n as f64).collect();
    one(Shaped::whole(vec![values.len() as u64], values))
}

fn size_of(_: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    one(Shaped::whole(vec![], vec![input(inputs, 0)?.count() as f64]))
}

fn constant(node: &Node, _: &Inputs<'_>) -> Result<Made, String> {
    let Some((name, attribute)) = node.attributes.iter().next().filter(|_| node.attributes.len() == 1) else {
        return Err("has not one value".into());
    };
    one(match name.as_str() {
        "value" => Shaped::constant(attribute.tensor.as_ref().ok_or("has no value")?),
        "value_int" => Shaped::whole(vec![], vec![attribute.int as f64]),
        "value_ints" => {
            let values: Vec<f64> = attribute.ints.iter().map(|n| *n as f64).collect();
            Shaped::whole(vec![values.len() as u64], values)
        }
        "value_float" => Shaped { values: Some(vec![f64::from(attribute.float)]), ..Shaped::default() },
        "value_floats" => {
            let values: Vec<f64> = attribute.floats.iter().map(|n| f64::from(*n)).collect();
            Shaped { dims: vec![values.len() as u64], values: Some(values), ..Shaped::default() }
        }
        _ => return Err(format!("has a value of the kind `{name}`")),
    })
}

/// Everywhere the same value, followed where it is small.
fn filled(dims: Vec<u64>, value: Option<f64>, whole: bool) -> Shaped {
    let count = product(&dims);
    let values = value.filter(|_| count <= FOLLOWED).map(|value| vec![value; count as usize]);
    Shaped { dims, values, whole, constant: false }
}

fn constant_of_shape(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let dims = extents(values(input(inputs, 0)?)?)?;
    let value = node.attributes.get("value").and_then(|attribute| attribute.tensor.as_ref());
    let value = value.map_or(Shaped { values: Some(vec![0.0]), ..Shaped::default() }, Shaped::constant);
    let filling = value.values.and_then(|values| values.first().copied());
    one(filled(dims, filling, value.whole))
}

fn expand(_: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let from = input(inputs, 0)?;
    let dims = broadcast_dims(&from.dims, &extents(values(input(inputs, 1)?)?)?)?;
    let values = spread(from, &dims);
    one(Shaped { dims, values, whole: from.whole, constant: false })
}

fn tile(_: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let (from, repeats) = (input(inputs, 0)?, extents(values(input(inputs, 1)?)?)?);
    if repeats.len() != from.dims.len() {
        return misfit();
    }
    one(Shaped::of(from.dims.iter().zip(repeats).map(|(dim, n)| dim.saturating_mul(n)).collect()))
}

fn range(_: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let (start, limit, step) = (input(inputs, 0)?, input(inputs, 1)?, input(inputs, 2)?);
    let ([from], [to], [by]) = (values(start)?, values(limit)?, values(step)?) else { return misfit() };
    if !start.whole {
        return Err("makes a size that depends on the rounding of floats".into());
    }
    let count = extent(((to - from) / by).ceil().max(0.0))?;
    let values = (count <= FOLLOWED).then(|| (0..count).map(|k| from + k as f64 * by).collect());
    one(Shaped { dims: vec![count], values, whole: true, constant: false })
}

fn one_hot(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let (from, depth) = (input(inputs, 0)?, input(inputs, 1)?);
    let [depth] = values(depth)? else { return misfit() };
    let mut dims = from.dims.clone();
    let at = axis(node.int("axis", -1), dims.len() + 1)?;
    dims.insert(at, extent(*depth)?);
    one(Shaped::of(dims))
}

fn concat(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let mut out = input(inputs, 0)?.clone();
    let at = axis(node.int("axis", 0), out.dims.len())?;
    for place in 1..inputs.len() {
        let next = input(inputs, place)?;
        let others_differ = (0..out.dims.len()).any(|k| k != at && out.dims.get(k) != next.dims.get(k));
        if next.dims.len() != out.dims.len() || others_differ {
            return misfit();
        }
        out.dims[at] = out.dims[at].saturating_add(next.dims[at]);
        out.values = match (out.values.take(), &next.values) {
            (Some(mut all), Some(more)) if next.dims.len() == 1 && all.len() + more.len() <= FOLLOWED as usize => {
                all.extend(more);
                Some(all)
            }
            _ => None,
        };
    }
    one(out)
}

fn split(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let from = input(inputs, 0)?;
    let at = axis(node.int("axis", 0), from.dims.len())?;
    let parts = node.outputs.len().max(1) as u64;
    let sizes: Vec<u64> = match numbers(node, inputs, 1, "split")? {
        Some(sizes) => sizes.iter().map(|n| extent(*n as f64)).collect::<Result<_, _>>()?,
        None => {
            let each = from.dims[at].div_ceil(parts);
            (0..parts).map(|k| each.min(from.dims[at].saturating_sub(k * each))).collect()
        }
    };
    let total = sizes.iter().fold(0_u64, |total, size| total.saturating_add(*size));
    if sizes.len() as u64 != parts || total != from.dims[at] {
        return misfit();
    }
    let outputs = sizes.iter().scan(0, |begin, size| {
        let mut out = Shaped::of(from.dims.clone());
        out.dims[at] = *size;
        out.whole = from.whole;
        let part = from.values.as_ref().filter(|_| from.dims.len() == 1);
        out.values = part.map(|values| values[*begin as usize..(*begin + size) as usize].to_vec());
        *begin += size;
        Some(out)
    });
    Ok(Made { outputs: outputs.collect(), work: from.count() })
}

fn slice(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let from = input(inputs, 0)?;
    let wanted = |at, name| numbers(node, inputs, at, name)?.ok_or_else(|| format!("has no `{name}`"));
    let (starts, ends) = (wanted(1, "starts")?, wanted(2, "ends")?);
    let axes = numbers(node, inputs, 3, "axes")?.unwrap_or_else(|| (0..starts.len() as i64).collect());
    let steps = numbers(node, inputs, 4, "steps")?.unwrap_or_else(|| vec![1; starts.len()]);
    if ends.len() != starts.len() || axes.len() != starts.len() || steps.len() != starts.len() {
        return misfit();
    }
    let mut out = from.clone();
    for k in 0..starts.len() {
        let at = axis(axes[k], from.dims.len())?;
        let picked = picked(from.dims[at], starts[k], ends[k], steps[k])?;
        out.dims[at] = picked.1;
        // Values are followed along their one dimension.
        out.values = match (from.dims.len(), &from.values) {
            (1, Some(values)) => {
                let place = |i: u64| picked.0 + i as i128 * i128::from(steps[k]);
                (0..picked.1).map(|i| usize::try_from(place(i)).ok().and_then(|i| values.get(i).copied())).collect()
            }
            _ => None,
        };
    }
    one(out)
}

/// Where a slice begins and how many it takes.
fn picked(size: u64, start: i64, end: i64, step: i64) -> Result<(i128, u64), String> {
    let (size, step) = (i128::from(size), i128::from(step));
    let from_end = |value: i64| if value < 0 { i128::from(value) + size } else { i128::from(value) };
    let (start, end) = match step {
        0 => return misfit(),
        1.. => (from_end(start).clamp(0, size), from_end(end).clamp(0, size)),
        _ => (from_end(start).clamp(0, (size - 1).max(0)), from_end(end).clamp(-1, size - 1)),
    };
    let (room, stride) = if step > 0 { (end - start, step) } else { (start - end, -step) };
    let count = if room <= 0 { 0 } else { (room + stride - 1) / stride };
    Ok((start, u64::try_from(count).unwrap_or(0)))
}

fn pad(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let from = input(inputs, 0)?;
    let rank = from.dims.len();
    let pads = numbers(node, inputs, 1, "pads")?.ok_or("has no `pads`")?;
    let axes = match optional(inputs, 3) {
        Some(axes) => values(axes)?.iter().map(|v| axis(*v as i64, rank)).collect::<Result<Vec<_>, _>>()?,
        None => (0..rank).collect(),
    };
    if pads.len() != 2 * axes.len() {
        return misfit();
    }
    let mut dims = from.dims.clone();
    for (k, at) in axes.iter().enumerate() {
        let padded = i128::from(dims[*at]) + i128::from(pads[k]) + i128::from(pads[k + axes.len()]);
        dims[*at] = u64::try_from(padded).or_else(|_| misfit())?;
    }
    one(Shaped::of(dims))
}

fn gather(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let (from, places) = (input(inputs, 0)?, input(inputs, 1)?);
    let at = axis(node.int("axis", 0), from.dims.len())?;
    let dims = [&from.dims[..at], &places.dims, &from.dims[at + 1..]].concat();
    let mut out = Shaped::of(dims);
    out.whole = from.whole;
    if let (1, Some(values), Some(places)) = (from.dims.len(), &from.values, &places.values) {
        let pick = |place: &f64| {
            let place = if *place < 0.0 { place + values.len() as f64 } else { *place };
            values.get(place as usize).copied()
        };
        out.values = places.iter().map(pick).collect();
    }
    one(out)
}

fn gather_elements(_: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    one(Shaped::of(input(inputs, 1)?.dims.clone()))
}

fn gather_nd(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let (from, places) = (&input(inputs, 0)?.dims, &input(inputs, 1)?.dims);
    let Some((depth, outer)) = places.split_last() else { return misfit() };
    let skipped =
        usize::try_from(node.int("batch_dims", 0)).ok().and_then(|n| n.checked_add(usize::try_from(*depth).ok()?));
    let inner = skipped.and_then(|n| from.get(n..)).ok_or("gets inputs whose sizes do not fit")?;
    one(Shaped::of([outer, inner].concat()))
}

fn reshape(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let from = input(inputs, 0)?;
    let wanted = numbers(node, inputs, 1, "shape")?.ok_or("has no `shape`")?;
    let keep_zero = node.int("allowzero", 0) != 0;
    let mut dims = Vec::with_capacity(wanted.len());
    let mut open = None;
    for (k, size) in wanted.iter().enumerate() {
        dims.push(match size {
            0 if !keep_zero => *from.dims.get(k).ok_or("gets inputs whose sizes do not fit")?,
            -1 if open.is_none() => {
                open = Some(k);
                1
            }
            n => extent(*n as f64)?,
        });
    }
    let (count, rest) = (from.count(), product(&dims));
    if let Some(k) = open {
        dims[k] = count.checked_div(rest).unwrap_or(0);
    }
    if product(&dims) != count {
        return misfit();
    }
    reshaped(from, dims)
}

/// The same values in another shape.
fn reshaped(from: &Shaped, dims: Vec<u64>) -> Result<Made, String> {
    one(Shaped { dims, values: from.values.clone(), whole: from.whole, constant: false })
}

fn flatten(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let from = input(inputs, 0)?;
    let rank = from.dims.len();
    let at = node.int("axis", 1);
    let at = if at == rank as i64 { rank } else { axis(at, rank)? };
    reshaped(from, vec![product(&from.dims[..at]), product(&from.dims[at..])])
}

fn squeeze(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let from = input(inputs, 0)?;
    let rank = from.dims.len();
    let axes = match numbers(node, inputs, 1, "axes")? {
        Some(axes) => axes.iter().map(|at| axis(*at, rank)).collect::<Result<Vec<_>, _>>()?,
        None => (0..rank).filter(|k| from.dims[*k] == 1).collect(),
    };
    if axes.iter().any(|at| from.dims[*at] != 1) {
        return misfit();
    }
    reshaped(from, reduced(&from.dims, &axes, false))
}

fn unsqueeze(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let from = input(inputs, 0)?;
    let axes = numbers(node, inputs, 1, "axes")?.ok_or("has no `axes`")?;
    let rank = from.dims.len() + axes.len();
    let axes = axes.iter().map(|at| axis(*at, rank)).collect::<Result<Vec<_>, _>>()?;
    let mut rest = from.dims.iter();
    let dims: Vec<u64> =
        (0..rank).filter_map(|k| if axes.contains(&k) { Some(1) } else { rest.next().copied() }).collect();
    reshaped(from, dims)
}

fn transpose(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let from = input(inputs, 0)?;
    let rank = from.dims.len();
    let order = match node.ints("perm") {
        Some(order) if order.len() == rank => order.iter().map(|at| axis(*at, rank)).collect::<Result<Vec<_>, _>>()?,
        Some(_) => return misfit(),
        None => (0..rank).rev().collect(),
    };
    let values = from.values.clone().filter(|_| rank < 2);
    let dims = order.iter().map(|k| from.dims[*k]).collect();
    one(Shaped { dims, values, whole: from.whole, constant: false })
}

fn depth_to_space(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let side = u64::try_from(node.int("blocksize", 0)).ok().filter(|side| *side > 0);
    let ([n, c, h, w], Some(side)) = (input(inputs, 0)?.dims.as_slice(), side) else { return misfit() };
    let (h, w) = (h.saturating_mul(side), w.saturating_mul(side));
    one(Shaped::of(vec![*n, c / side.saturating_mul(side), h, w]))
}

fn space_to_depth(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let side = u64::try_from(node.int("blocksize", 0)).ok().filter(|side| *side > 0);
    let ([n, c, h, w], Some(side)) = (input(inputs, 0)?.dims.as_slice(), side) else { return misfit() };
    one(Shaped::of(vec![*n, c.saturating_mul(side.saturating_mul(side)), h / side, w / side]))
}

fn top_k(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let from = input(inputs, 0)?;
    let most = match optional(inputs, 1) {
        Some(most) => values(most)?.first().copied().unwrap_or(-1.0),
        None => node.int("k", -1) as f64,
    };
    let mut dims = from.dims.clone();
    let at = axis(node.int("axis", -1), dims.len())?;
    dims[at] = extent(most)?;
    Ok(Made { outputs: vec![Shaped::of(dims); 2], work: from.count() })
}
