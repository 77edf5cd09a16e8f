//! The seven wooden blocks of the originals (VFT, MORE, PMBS), built from their sizes.
//!
//! All are upright prisms 45 mm tall. A block's frame has its origin at the middle of the footprint's bounding box.
//!
//! | name | footprint, mm (x by y) | PMBS mass, kg |
//! |---|---|---|
//! | `cube` | 45 x 45 | 0.05 |
//! | `half_cube` | 22.5 x 45 | 0.025 |
//! | `rect` | 45 x 90 | 0.1 |
//! | `cylinder` | disc of radius 22 (the original is a 32-gon, 0.6 % smaller in area) | 0.04 |
//! | `half_cylinder` | 44 x 22: half a disc of radius 22, the flat side at y = +11 | 0.02 |
//! | `triangle` | corners (22.5, 45), (-22.5, 0), (22.5, -45) | 0.07 |
//! | `concave` | 90 x 45 less half a disc of radius 23.5 about (0, 22.5) | 0.075 |
//!
//! Arcs have 16 segments with their corners on the circle, as the original meshes do.

use super::body::BodyDef;
use crate::error::{Error, Result};
use crate::geom::{Shape, Vec2, vec2};

/// The names of the blocks. A hyphen is taken for an underscore, as in the original files' `half-cube`.
pub const BLOCKS: [&str; 7] = ["cube", "half_cube", "rect", "cylinder", "half_cylinder", "triangle", "concave"];

/// Height of every block, metres.
pub const BLOCK_HEIGHT: f64 = 0.045;

/// Segments of a half circle.
const ARC_SEGMENTS: usize = 16;
/// The engine of MORE grows a body's bounding box on every side before it takes the box's inertia, metres: by the contact
/// margin of 1 mm three times, since the hull's corners have it, the hull's bounds add it, and those of the compound round
/// the hull add it once more. (A body of a plain box there has none.)
const SIMULATOR_GROWTH: f64 = 0.003;

/// Whose masses and friction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BlockSet {
    /// VFT and MORE: 0.1 kg each, friction 0.5.
    #[default]
    More,
    /// PMBS: masses by size, and the friction whose product for two blocks is that system's 0.3.
    Pmbs,
}

/// Where a block's mass is taken to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BlockConvention {
    /// A uniform prism: centre of mass at the area's centroid, inertia of the footprint.
    #[default]
    TrueCentroid,
    /// As the simulation of VFT and MORE has it: centre of mass at the origin of the block's frame and the inertia of
    /// its bounding box grown by 3 mm on every side (PyBullet's, of a mesh). Wrong for the triangle, the concave block and the half
    /// cylinder, whose centroids lie up to 7.5 mm off; for comparisons with those systems only.
    Simulator,
}

impl BlockSet {
    /// Coefficient of a block's surface; two blocks in contact have the square of it.
    pub fn friction(self) -> f64 {
        match self {
            BlockSet::More => 0.5,
            BlockSet::Pmbs => 0.3f64.sqrt(),
        }
    }

    fn mass(self, name: &str) -> f64 {
        match (self, name) {
            (BlockSet::More, _) => 0.1,
            (BlockSet::Pmbs, "cube") => 0.05,
            (BlockSet::Pmbs, "half_cube") => 0.025,
            (BlockSet::Pmbs, "cylinder") => 0.04,
            (BlockSet::Pmbs, "half_cylinder") => 0.02,
            (BlockSet::Pmbs, "triangle") => 0.07,
            (BlockSet::Pmbs, "concave") => 0.075,
            (BlockSet::Pmbs, _) => 0.1,
        }
    }
}

/// A block with MORE's mass and friction and its true centre of mass. It has no name yet.
pub fn block(name: &str) -> Result<BodyDef> {
    block_of(name, BlockSet::default(), BlockConvention::default())
}

/// A block of a set, by a convention. It has no name yet.
pub fn block_of(name: &str, set: BlockSet, convention: BlockConvention) -> Result<BodyDef> {
    let name = canonical(name)?;
    let mut def = BodyDef::new(shape(name));
    def.height = BLOCK_HEIGHT;
    def.mass = set.mass(name);
    def.friction = set.friction();
    if convention == BlockConvention::Simulator {
        let [x, y, _] = simulator_box(name)?;
        def.centre_of_mass = Some([0.0, 0.0]);
        def.inertia = Some(def.mass / 12.0 * (x * x + y * y));
    }
    Ok(def)
}

/// The name as [`BLOCKS`] has it.
pub fn canonical(name: &str) -> Result<&'static str> {
    let wanted = name.replace('-', "_");
    BLOCKS
        .into_iter()
        .find(|known| *known == wanted)
        .ok_or_else(|| Error::not_found("block", format!("no block is named `{name}`; known: {}", BLOCKS.join(", "))))
}

/// Extent of a block's footprint along x and y, metres.
pub fn block_size(name: &str) -> Result<[f64; 2]> {
    canonical(name).map(size)
}

/// The box whose inertia the simulation of VFT and MORE gives a block: extents in the block's frame, metres.
pub(super) fn simulator_box(name: &str) -> Result<[f64; 3]> {
    let [x, y] = block_size(name)?;
    Ok([x, y, BLOCK_HEIGHT].map(|s| s + 2.0 * SIMULATOR_GROWTH))
}

fn size(name: &str) -> [f64; 2] {
    match name {
        "half_cube" => [0.0225, 0.045],
        "rect" | "triangle" => [0.045, 0.090],
        "cylinder" => [0.044, 0.044],
        "half_cylinder" => [0.044, 0.022],
        "concave" => [0.090, 0.045],
        _ => [0.045, 0.045],
    }
}

fn shape(name: &str) -> Shape {
    let [x, y] = size(name);
    match name {
        "cylinder" => Shape::Disc { radius: x / 2.0 },
        // From one end of the flat side over the arc to the other.
        "half_cylinder" => Shape::ConvexPolygon(points(arc(vec2(0.0, y / 2.0), x / 2.0))),
        "triangle" => Shape::ConvexPolygon(vec![[x / 2.0, y / 2.0], [-x / 2.0, 0.0], [x / 2.0, -y / 2.0]]),
        "concave" => {
            let mut outline = vec![vec2(-x / 2.0, y / 2.0), vec2(-x / 2.0, -y / 2.0)];
            outline.extend([vec2(x / 2.0, -y / 2.0), vec2(x / 2.0, y / 2.0)]);
            // The notch runs from right to left, the block on its left hand.
            outline.extend(arc(vec2(0.0, y / 2.0), 0.0235).into_iter().rev());
            Shape::Polygon(points(outline))
        }
        _ => Shape::rectangle(x, y),
    }
}

/// The lower half circle from its left end to its right end, which runs counter-clockwise.
fn arc(centre: Vec2, radius: f64) -> Vec<Vec2> {
    let corner = |i: usize| {
        let angle = std::f64::consts::PI * (1.0 + i as f64 / ARC_SEGMENTS as f64);
        centre + vec2(angle.cos(), angle.sin()) * radius
    };
    (0..=ARC_SEGMENTS).map(corner).collect()
}

fn points(corners: Vec<Vec2>) -> Vec<[f64; 2]> {
    corners.into_iter().map(|p| [p.x, p.y]).collect()
}

#[cfg(test)]
mod tests {
    use super::super::body::Body;
    use super::*;

    #[test]
    fn every_block_is_a_body_with_its_origin_amid_its_bounding_box() {
        for name in BLOCKS {
            let body = Body::new(block(name).unwrap()).unwrap();
            let [x, y] = block_size(name).unwrap();
            let (low, high) = body.footprint.bounds();
            for (got, want) in [(-low.x, x / 2.0), (high.x, x / 2.0), (-low.y, y / 2.0), (high.y, y / 2.0)] {
                assert!((got - want).abs() < 1e-9, "{name}: {low:?} {high:?}");
            }
            assert!(body.pickable && body.pushable && body.height == 0.045 && body.mass == 0.1);
        }
    }

    #[test]
    fn measures_follow_from_the_formulas() {
        let body = |name| Body::new(block(name).unwrap()).unwrap();
        let triangle = body("triangle");
        assert!((triangle.footprint.area - 0.045 * 0.09 / 2.0).abs() < 1e-12);
        assert!((triangle.centre_of_mass - vec2(0.0075, 0.0)).norm() < 1e-12);
        // A half disc's centroid lies 4 r / (3 pi) from the flat side.
        let half = body("half_cylinder");
        assert!((half.centre_of_mass.y - (0.011 - 4.0 * 0.022 / (3.0 * std::f64::consts::PI))).abs() < 1e-4);
        let concave = body("concave");
        let notch = std::f64::consts::PI * 0.0235 * 0.0235 / 2.0;
        assert!((concave.footprint.area / (0.09 * 0.045 - notch) - 1.0).abs() < 0.003);
        assert!(concave.footprint.pieces.len() > 1, "the notch is real");
    }

    #[test]
    fn the_original_spelling_is_known_and_a_wrong_one_lists_the_known() {
        assert_eq!(block("half-cube").unwrap(), block("half_cube").unwrap());
        let error = block("sphere").unwrap_err().to_string();
        assert!(error.starts_with("block: no block is named `sphere`; known: cube, half_cube, rect,"), "{error}");
    }

    #[test]
    fn the_simulators_convention_is_its_box_about_the_origin() {
        let def = block_of("triangle", BlockSet::More, BlockConvention::Simulator).unwrap();
        assert_eq!(def.centre_of_mass, Some([0.0, 0.0]));
        assert!((def.inertia.unwrap() / 9.8475e-5 - 1.0).abs() < 1e-9, "{:?}", def.inertia);
        let pmbs = block_of("concave", BlockSet::Pmbs, BlockConvention::TrueCentroid).unwrap();
        assert!(pmbs.mass == 0.075 && (pmbs.friction * pmbs.friction - 0.3).abs() < 1e-12);
    }

    /// Against the measures of the original assets, where they are at hand.
    #[test]
    fn measures_agree_with_the_original_assets() {
        let Some(path) = super::super::testing::shared("data/blocks.json") else { return };
        let blocks: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        for name in BLOCKS {
            let want = &blocks[name.replace('_', "-")];
            let number = |v: &serde_json::Value| v.as_f64().unwrap();
            let body = Body::new(block(name).unwrap()).unwrap();
            let f = &body.footprint;
            assert!((f.area / number(&want["area_m2"]) - 1.0).abs() < 0.01, "{name}");
            let centroid = vec2(number(&want["area_centroid_m"][0]), number(&want["area_centroid_m"][1])) - f.centroid;
            assert!(centroid.norm() < 0.01 * f.radius, "{name}: {centroid:?}");
            let gyration = number(&want["radius_of_gyration_sq_about_centroid_m2"]);
            assert!(((f.gyration_squared / gyration).sqrt() - 1.0).abs() < 0.01, "{name}");
            let masses = &want["mass_kg_by_system"];
            for (set, key) in [(BlockSet::More, "more"), (BlockSet::Pmbs, "pmbs")] {
                assert_eq!(set.mass(name), number(&masses[key]), "{name}");
            }
        }
    }

    /// Against the inertias that PyBullet had when pushes were recorded in it, where they are at hand.
    #[test]
    fn the_simulators_inertia_is_the_recorded_one() {
        let Some(path) = super::super::testing::shared("data/fidelity/pybullet_pushes.jsonl") else { return };
        let text = std::fs::read_to_string(path).unwrap();
        let mut seen = std::collections::BTreeSet::new();
        for line in text.lines() {
            let recorded: serde_json::Value = serde_json::from_str(line).unwrap();
            for shape in recorded["shapes"].as_array().unwrap() {
                let name = canonical(shape["name"].as_str().unwrap().trim_end_matches(".urdf")).unwrap();
                let def = block_of(name, BlockSet::More, BlockConvention::Simulator).unwrap();
                let off = def.inertia.unwrap() / shape["izz"].as_f64().unwrap() - 1.0;
                // Bodies that lean have a little more; the cylinder's box is that of its 32 corners.
                assert!(off.abs() < 0.025, "{name}: {off}");
                seen.insert(name);
            }
        }
        assert!(seen.len() > 4, "{seen:?}");
    }
}
