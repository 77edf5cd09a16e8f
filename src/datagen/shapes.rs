//! The shapes that training data is made of, and which of them a network may learn from.
//!
//! A family is the library's blocks followed by shapes drawn from a seed. Every measure is a multiple of half a
//! millimetre, so a shape that is drawn twice is the same shape. Which split a shape belongs to follows from its hash
//! alone: a shape of the test set is never learned from, whatever seed or size the family has. The blocks are for
//! training.

use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};

use super::tensors::{Data, Tensor, sha256};
use crate::error::{Error, Result, check_range};
use crate::geom::{Footprint, Shape, Vec2, convex_hull, vec2};
use crate::run::{Key, Stream};
use crate::scene::library;

/// Points that stand for an outline.
pub const OUTLINE_POINTS: usize = 32;
/// Segments of a half circle, as the library's blocks have it.
const ARC_SEGMENTS: usize = 16;
/// No drawn shape is narrower than this in any direction, metres: it would be a blade.
const LEAST_WIDTH: f64 = 0.014;
/// Every measure is a multiple of this, metres.
const GRAIN: f64 = 0.0005;
/// Draws for each shape wanted before the family is held to be impossible.
const DRAWS: u64 = 64;
/// Of ten parts of all drawn shapes, one is for validation and one for tests.
const PARTS: u64 = 10;

/// What samples with a shape are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Split {
    Train = 0,
    Val = 1,
    Test = 2,
}

impl Split {
    pub const ALL: [Split; 3] = [Split::Train, Split::Val, Split::Test];

    pub fn name(self) -> &'static str {
        match self {
            Split::Train => "train",
            Split::Val => "val",
            Split::Test => "test",
        }
    }

    /// The split of a number that is as good as random.
    pub fn of_hash(hash: u64) -> Split {
        match hash % PARTS {
            0 => Split::Val,
            1 => Split::Test,
            _ => Split::Train,
        }
    }
}

/// A shape of a family.
#[derive(Debug, Clone, PartialEq)]
pub struct FamilyShape {
    /// A block's name, or the kind of shape.
    pub kind: &'static str,
    pub footprint: Footprint,
    pub split: Split,
}

/// Shapes by index; a seed makes them.
#[derive(Debug, Clone)]
pub struct ShapeFamily {
    shapes: Vec<FamilyShape>,
    by_split: [Vec<u16>; 3],
}

impl ShapeFamily {
    /// `count` shapes: the blocks, then drawn ones.
    pub fn new(seed: u64, count: usize) -> Result<ShapeFamily> {
        let least = library::BLOCKS.len() + 30;
        check_range("shapes", count as f64, least as f64..=f64::from(u16::MAX))?;
        let mut shapes = Vec::with_capacity(count);
        let mut known = BTreeSet::new();
        for name in library::BLOCKS {
            let shape = library::block(name)?.shape;
            known.insert(shape_hash(&shape)?);
            shapes.push(FamilyShape { kind: name, footprint: Footprint::new(shape)?, split: Split::Train });
        }
        for draw in 0..DRAWS * count as u64 {
            if shapes.len() == count {
                break;
            }
            let (kind, shape) = draw_shape(&mut Key::new(seed).child(draw).stream());
            let Ok(footprint) = Footprint::new(shape) else { continue };
            let hash = shape_hash(&footprint.shape)?;
            if least_width(&footprint) >= LEAST_WIDTH && known.insert(hash) {
                shapes.push(FamilyShape { kind, footprint, split: Split::of_hash(hash) });
            }
        }
        if shapes.len() < count {
            return Err(Error::argument("shapes", format!("is {count}, but only {} differ", shapes.len())));
        }
        let by_split =
            Split::ALL.map(|split| (0..count as u16).filter(|&i| shapes[usize::from(i)].split == split).collect());
        Ok(ShapeFamily { shapes, by_split })
    }

    pub fn shapes(&self) -> &[FamilyShape] {
        &self.shapes
    }

    pub fn shape(&self, index: u16) -> &FamilyShape {
        &self.shapes[usize::from(index)]
    }

    /// Indices of the shapes of a split, ascending.
    pub fn of(&self, split: Split) -> &[u16] {
        &self.by_split[split as usize]
    }

    /// Index of a block of the library.
    pub fn block(&self, name: &str) -> Result<u16> {
        let name = library::canonical(name)?;
        Ok(library::BLOCKS.iter().position(|b| *b == name).unwrap_or_default() as u16)
    }

    /// The tensors and metadata of the file of shapes.
    pub(super) fn tensors(&self) -> (Vec<Tensor>, Vec<(&'static str, String)>) {
        let (mut outline, mut offset) = (Vec::new(), Vec::new());
        for shape in &self.shapes {
            outline.extend(outline_points(&shape.footprint).iter().flat_map(|p| [p.x as f32, p.y as f32]));
            let centre = shape.footprint.centroid;
            offset.extend([centre.x as f32, centre.y as f32]);
        }
        let split = self.shapes.iter().map(|s| s.split as u8).collect();
        let count = self.shapes.len();
        let tensors = vec![
            Tensor::new("outline", [count, OUTLINE_POINTS, 2], Data::F32(outline)),
            Tensor::new("offset", [count, 2], Data::F32(offset)),
            Tensor::new("split", [count], Data::U8(split)),
        ];
        let kinds: Vec<_> = self.shapes.iter().map(|s| s.kind).collect();
        let shapes: Vec<_> = self.shapes.iter().map(|s| &s.footprint.shape).collect();
        let shapes = serde_json::to_string(&shapes).unwrap_or_default();
        (tensors, vec![("format", "jostle/shapes/1".into()), ("kind", kinds.join(",")), ("shapes", shapes)])
    }
}

/// The outline as networks see it: points evenly spaced by arc length on the outer outline, counter-clockwise from its
/// first vertex, relative to the centre of the area. A disc's lie on the circle, from +x; a compound of several parts is
/// seen as its convex hull. Body frame, metres.
pub fn outline_points(footprint: &Footprint) -> [Vec2; OUTLINE_POINTS] {
    footprint.outline_points()
}

/// A number that names the shape: equal for equal corners, whoever drew them.
fn shape_hash(shape: &Shape) -> Result<u64> {
    let text = serde_json::to_string(shape).map_err(|e| Error::Internal(format!("a shape as JSON: {e}")))?;
    let digits = sha256(text.as_bytes());
    u64::from_str_radix(digits.get(..16).unwrap_or_default(), 16).map_err(|e| Error::Internal(e.to_string()))
}

/// Least extent over 36 directions, metres.
fn least_width(footprint: &Footprint) -> f64 {
    (0..36).fold(f64::INFINITY, |least, k| {
        let d = vec2((PI * k as f64 / 36.0).cos(), (PI * k as f64 / 36.0).sin());
        least.min(footprint.support(d) + footprint.support(-d))
    })
}

/// A measure in millimetres, rounded to the grain, in metres.
fn measure(random: &mut Stream, least: f64, most: f64) -> f64 {
    grain(random.uniform(least, most) * 1e-3)
}

fn grain(metres: f64) -> f64 {
    // Divided, not multiplied by the grain: the nearest double to the decimal number, which is short when written.
    (metres / GRAIN).round() / (1.0 / GRAIN)
}

/// How often each kind is drawn, in relation.
const WEIGHTS: [(&str, usize); 10] = [
    ("rectangle", 6),
    ("triangle", 3),
    ("regular", 2),
    ("convex", 5),
    ("l", 2),
    ("t", 2),
    ("u", 2),
    ("notched", 2),
    ("disc", 1),
    ("half_disc", 1),
];

fn draw_shape(random: &mut Stream) -> (&'static str, Shape) {
    let mut ticket = random.index(WEIGHTS.iter().map(|(_, w)| w).sum());
    let mut kind = WEIGHTS[0].0;
    for (name, weight) in WEIGHTS {
        kind = name;
        if ticket < weight {
            break;
        }
        ticket -= weight;
    }
    let shape = match kind {
        "triangle" => triangle(random),
        "regular" => regular(random),
        "convex" => convex(random),
        "l" => corner(random),
        "t" => tee(random),
        "u" => channel(random),
        "notched" => notched(random),
        "disc" => Shape::Disc { radius: measure(random, 10.0, 30.0) },
        "half_disc" => {
            let radius = measure(random, 16.0, 35.0);
            polygon(arc(Vec2::zeros(), radius))
        }
        _ => {
            let long = measure(random, 20.0, 100.0);
            let short = measure(random, 20.0, (long * 1e3).min(60.0));
            Shape::rectangle(long, short)
        }
    };
    (kind, shape)
}

fn triangle(random: &mut Stream) -> Shape {
    let (base, height) = (measure(random, 30.0, 90.0), measure(random, 30.0, 70.0));
    let apex = grain(base * random.unit());
    polygon(vec![vec2(0.0, 0.0), vec2(base, 0.0), vec2(apex, height)])
}

fn regular(random: &mut Stream) -> Shape {
    let corners = 5 + random.index(4);
    let radius = measure(random, 15.0, 35.0);
    let at = |i: usize| {
        let angle = TAU * i as f64 / corners as f64;
        vec2(angle.cos(), angle.sin()) * radius
    };
    polygon((0..corners).map(at).collect())
}

/// Corners on an ellipse at random angles.
fn convex(random: &mut Stream) -> Shape {
    let corners = 4 + random.index(5);
    let (a, b) = (random.uniform(0.016, 0.048), random.uniform(0.016, 0.048));
    let points: Vec<Vec2> = (0..corners)
        .map(|i| {
            let angle = TAU * (i as f64 + random.uniform(-0.4, 0.4)) / corners as f64;
            vec2(grain(a * angle.cos()), grain(b * angle.sin()))
        })
        .collect();
    polygon(convex_hull(&points))
}

fn corner(random: &mut Stream) -> Shape {
    let (x, y) = (measure(random, 40.0, 90.0), measure(random, 40.0, 90.0));
    let (p, q) = (measure(random, 15.0, 30.0), measure(random, 15.0, 30.0));
    let outline = vec![vec2(0.0, 0.0), vec2(x, 0.0), vec2(x, q), vec2(p, q), vec2(p, y), vec2(0.0, y)];
    polygon(outline)
}

fn tee(random: &mut Stream) -> Shape {
    let (bar, thick) = (measure(random, 45.0, 90.0), measure(random, 15.0, 30.0));
    let (stem, length) = (measure(random, 15.0, 28.0), measure(random, 20.0, 50.0));
    // The stem may stand off the middle.
    let left = grain((bar - stem) * random.uniform(0.2, 0.8));
    let outline = vec![
        vec2(left, 0.0),
        vec2(left + stem, 0.0),
        vec2(left + stem, length),
        vec2(bar, length),
        vec2(bar, length + thick),
        vec2(0.0, length + thick),
        vec2(0.0, length),
        vec2(left, length),
    ];
    polygon(outline)
}

fn channel(random: &mut Stream) -> Shape {
    let (x, y) = (measure(random, 55.0, 95.0), measure(random, 35.0, 70.0));
    let (wall, floor) = (measure(random, 14.0, 22.0), measure(random, 14.0, 25.0));
    let outline = vec![
        vec2(0.0, 0.0),
        vec2(x, 0.0),
        vec2(x, y),
        vec2(x - wall, y),
        vec2(x - wall, floor),
        vec2(wall, floor),
        vec2(wall, y),
        vec2(0.0, y),
    ];
    polygon(outline)
}

/// A rectangle less half a disc, as the library's concave block.
fn notched(random: &mut Stream) -> Shape {
    let (x, y) = (measure(random, 50.0, 100.0), measure(random, 30.0, 50.0));
    let most = (x / 2.0 - 0.008).min(y - 0.012) * 1e3;
    let radius = measure(random, 10.0, most);
    let mut outline = vec![vec2(0.0, 0.0), vec2(x, 0.0), vec2(x, y)];
    // The arc runs from left to right; the outline from right to left.
    outline.extend(arc(vec2(grain(x / 2.0), y), radius).into_iter().rev());
    outline.push(vec2(0.0, y));
    polygon(outline)
}

/// The lower half circle from its left end to its right end.
fn arc(centre: Vec2, radius: f64) -> Vec<Vec2> {
    let at = |i: usize| {
        let angle = PI * (1.0 + i as f64 / ARC_SEGMENTS as f64);
        centre + vec2(angle.cos(), angle.sin()) * radius
    };
    (0..=ARC_SEGMENTS).map(at).collect()
}

/// The polygon with its origin amid its bounding box; corners to a hundredth of a millimetre.
fn polygon(corners: Vec<Vec2>) -> Shape {
    let low = corners.iter().copied().reduce(|a, b| a.inf(&b)).unwrap_or_default();
    let high = corners.iter().copied().reduce(|a, b| a.sup(&b)).unwrap_or_default();
    let middle = (low + high) / 2.0;
    let round = |v: f64| (v * 1e5).round() / 1e5;
    let points = corners.into_iter().map(|p| p - middle).map(|p| [round(p.x), round(p.y)]).collect();
    Shape::Polygon(points)
}
