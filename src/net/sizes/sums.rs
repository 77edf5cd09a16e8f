//! The operators that multiply and add over windows, rows and columns.

use super::rules::{
    Inputs, Made, Shaped, axis, broadcast_dims, extent, input, misfit, optional, product, values, working,
};
use crate::net::graph::Node;

/// A window that slides along a dimension.
struct Window {
    kernel: u64,
    stride: u64,
    dilation: u64,
    /// Before and after.
    pad: i64,
    extra: i64,
}

/// The windows of a convolution or pool over `rank` dimensions.
fn windows(node: &Node, kernel: &[u64]) -> Result<Vec<Window>, String> {
    let rank = kernel.len();
    let list = |name: &str, usual: i64, count: usize| match node.ints(name) {
        Some(list) if list.len() == count => Ok(list.to_vec()),
        Some(_) => Err(format!("has `{name}` of another number of dimensions")),
        None => Ok(vec![usual; count]),
    };
    let (strides, dilations) = (list("strides", 1, rank)?, list("dilations", 1, rank)?);
    let (pads, extra) = (list("pads", 0, 2 * rank)?, list("output_padding", 0, rank)?);
    (0..rank)
        .map(|k| {
            let least = |name: &str, value: i64| {
                u64::try_from(value).ok().filter(|v| *v > 0).ok_or_else(|| format!("has `{name}` of {value}"))
            };
            let (stride, dilation) = (least("strides", strides[k])?, least("dilations", dilations[k])?);
            let pad = pads[k].saturating_add(pads[k + rank]);
            Ok(Window { kernel: kernel[k], stride, dilation, pad, extra: extra[k] })
        })
        .collect()
}

impl Window {
    fn reach(&self) -> i128 {
        (i128::from(self.kernel) - 1) * i128::from(self.dilation) + 1
    }

    fn slid(&self, node: &Node, size: u64) -> Result<u64, String> {
        let (size, stride) = (i128::from(size), i128::from(self.stride));
        let made = match node.text("auto_pad") {
            "SAME_UPPER" | "SAME_LOWER" => (size + stride - 1) / stride,
            kind => {
                let pad = if kind == "VALID" { 0 } else { i128::from(self.pad) };
                let room = size + pad - self.reach();
                if room < 0 {
                    return misfit();
                }
                let up = if node.int("ceil_mode", 0) != 0 { stride - 1 } else { 0 };
                (room + up) / stride + 1
            }
        };
        u64::try_from(made).or_else(|_| misfit())
    }

    fn spread(&self, node: &Node, size: u64) -> Result<u64, String> {
        let (size, stride) = (i128::from(size), i128::from(self.stride));
        let made = match node.text("auto_pad") {
            "SAME_UPPER" | "SAME_LOWER" => size * stride,
            kind => {
                let pad = if kind == "VALID" { 0 } else { i128::from(self.pad) };
                stride * (size - 1) + i128::from(self.extra) + self.reach() - pad
            }
        };
        u64::try_from(made).or_else(|_| misfit())
    }
}

/// Channels of a picture, and the rest of its dimensions.
fn picture(shaped: &Shaped) -> Result<(u64, u64, &[u64]), String> {
    match shaped.dims.as_slice() {
        [items, channels, rest @ ..] if !rest.is_empty() => Ok((*items, *channels, rest)),
        _ => misfit(),
    }
}

pub(super) fn conv(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let (items, _, sides) = picture(input(inputs, 0)?)?;
    let (outer, inner, kernel) = picture(input(inputs, 1)?)?;
    if kernel.len() != sides.len() {
        return misfit();
    }
    let mut dims = vec![items, outer];
    for (window, side) in windows(node, kernel)?.iter().zip(sides) {
        dims.push(window.slid(node, *side)?);
    }
    let work = product(&dims).saturating_mul(inner.saturating_mul(product(kernel)));
    working(dims, work)
}

pub(super) fn conv_transpose(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let from = input(inputs, 0)?;
    let (items, _, sides) = picture(from)?;
    let (_, outer, kernel) = picture(input(inputs, 1)?)?;
    if kernel.len() != sides.len() {
        return misfit();
    }
    let group = u64::try_from(node.int("group", 1)).or_else(|_| misfit())?;
    let mut dims = vec![items, outer.saturating_mul(group)];
    match node.ints("output_shape") {
        Some(wanted) => dims.extend(wanted.iter().rev().take(sides.len()).rev().map(|n| n.unsigned_abs())),
        None => {
            for (window, side) in windows(node, kernel)?.iter().zip(sides) {
                dims.push(window.spread(node, *side)?);
            }
        }
    }
    let work = from.count().saturating_mul(outer.saturating_mul(product(kernel)));
    working(dims, work.max(from.count()))
}

pub(super) fn pool(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let (items, channels, sides) = picture(input(inputs, 0)?)?;
    let kernel = node.ints("kernel_shape").ok_or("has no `kernel_shape`")?;
    let kernel: Vec<u64> = kernel.iter().map(|n| n.unsigned_abs()).collect();
    if kernel.len() != sides.len() {
        return misfit();
    }
    let mut dims = vec![items, channels];
    for (window, side) in windows(node, &kernel)?.iter().zip(sides) {
        dims.push(window.slid(node, *side)?);
    }
    let work = product(&dims).saturating_mul(product(&kernel));
    Ok(Made { outputs: vec![Shaped::of(dims); node.outputs.len().max(1)], work })
}

pub(super) fn global_pool(_: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let from = input(inputs, 0)?;
    let (items, channels, sides) = picture(from)?;
    let dims = [items, channels].into_iter().chain(sides.iter().map(|_| 1)).collect();
    working(dims, from.count())
}

pub(super) fn matmul(_: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let (a, b) = (&input(inputs, 0)?.dims, &input(inputs, 1)?.dims);
    if a.is_empty() || b.is_empty() {
        return misfit();
    }
    let (inner, rows) = (a[a.len() - 1], a.len().checked_sub(2).map(|k| a[k]));
    let columns = (b.len() > 1).then(|| b[b.len() - 1]);
    let other = if b.len() > 1 { b[b.len() - 2] } else { b[0] };
    if inner != other {
        return misfit();
    }
    let mut dims = broadcast_dims(&a[..a.len().saturating_sub(2)], &b[..b.len().saturating_sub(2)])?;
    dims.extend(rows.into_iter().chain(columns));
    let work = product(&dims).saturating_mul(inner);
    working(dims, work)
}

pub(super) fn gemm(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let ([a, b], [c, d]) = (input(inputs, 0)?.dims.as_slice(), input(inputs, 1)?.dims.as_slice()) else {
        return misfit();
    };
    let (rows, inner) = if node.int("transA", 0) != 0 { (*b, *a) } else { (*a, *b) };
    let (other, columns) = if node.int("transB", 0) != 0 { (*d, *c) } else { (*c, *d) };
    if inner != other {
        return misfit();
    }
    let dims = vec![rows, columns];
    let work = product(&dims).saturating_mul(inner);
    working(dims, work)
}

pub(super) fn einsum(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let equation: String = node.text("equation").chars().filter(|c| !c.is_whitespace()).collect();
    let (left, right) = equation.split_once("->").ok_or("has no `->` in its equation")?;
    let mut sizes = std::collections::BTreeMap::new();
    let terms: Vec<&str> = left.split(',').collect();
    if terms.len() != inputs.len() || !equation.chars().all(|c| c.is_ascii_alphabetic() || ",->".contains(c)) {
        return misfit();
    }
    for (at, term) in terms.iter().enumerate() {
        let dims = &input(inputs, at)?.dims;
        if dims.len() != term.chars().count() {
            return misfit();
        }
        for (letter, dim) in term.chars().zip(dims) {
            let size = sizes.entry(letter).or_insert(*dim);
            *size = (*size).max(*dim);
        }
    }
    let dims = right.chars().map(|c| sizes.get(&c).copied()).collect::<Option<Vec<_>>>();
    let work = sizes.values().fold(1_u64, |work, size| work.saturating_mul(*size));
    working(dims.ok_or("names a dimension that no input has")?, work)
}

pub(super) fn resize(node: &Node, inputs: &Inputs<'_>) -> Result<Made, String> {
    let from = input(inputs, 0)?;
    let rank = from.dims.len();
    let plain = matches!(node.text("keep_aspect_ratio_policy"), "" | "stretch")
        && node.text("coordinate_transformation_mode") != "tf_crop_and_resize";
    if !plain {
        return Err("keeps an aspect ratio or crops, which is not followed".into());
    }
    let axes = match node.ints("axes") {
        Some(axes) => axes.iter().map(|at| axis(*at, rank)).collect::<Result<Vec<_>, _>>()?,
        None => (0..rank).collect(),
    };
    let given = |at: usize| optional(inputs, at).filter(|shaped| shaped.count() > 0);
    // Version 10 has the factors where later ones have the region.
    let (factors, sizes) = if inputs.len() == 2 { (given(1), None) } else { (given(2), given(3)) };
    let list = values(sizes.or(factors).ok_or("has neither sizes nor factors")?)?;
    if list.len() != axes.len() {
        return misfit();
    }
    let mut dims = from.dims.clone();
    for (at, value) in axes.iter().zip(list) {
        dims[*at] =
            extent(if sizes.is_some() { *value } else { f64::from((dims[*at] as f32 * *value as f32).floor()) })?;
    }
    // Four values are mixed for each.
    let work = product(&dims).saturating_mul(4);
    working(dims, work)
}
