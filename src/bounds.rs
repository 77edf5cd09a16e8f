//! What a number may be: the one table of bounds that every entrance asks (builders, scene files, the originals' cases,
//! arrangements, recordings, images, options, the C API).
//!
//! `docs/scene-format.md` and the C header state the ranges; a test holds them to this table.

use std::fmt;

use crate::error::{Error, Result};

/// A number that is printed short: `1e-9` rather than nine zeros.
struct Short(f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size != 0.0 && size.is_finite() && !(1e-3..1e6).contains(&size) {
            write!(f, "{:e}", self.0)
        } else {
            write!(f, "{}", self.0)
        }
    }
}

/// The least and the greatest value of a quantity, both allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// What it is, in words.
    pub name: &'static str,
    /// Empty for a pure number.
    pub unit: &'static str,
    pub least: f64,
    pub greatest: f64,
    /// Why not less and not more.
    pub why: &'static str,
}

impl Bound {
    /// Refuses a value that is not a number or out of bounds. `field` is the value's name at the entrance.
    pub fn check(&self, field: &str, value: f64) -> Result<()> {
        if (self.least..=self.greatest).contains(&value) {
            return Ok(());
        }
        let reason = if value.is_finite() {
            format!("is {}; it must lie in {} ({})", Short(value), self.range(), self.why)
        } else {
            format!("is {value}; it must be a finite number, in {}", self.range())
        };
        Err(Error::argument(field, reason))
    }

    /// The same for a value of which there are several in a field.
    pub fn check_all(&self, field: &str, values: impl IntoIterator<Item = f64>) -> Result<()> {
        values.into_iter().try_for_each(|value| self.check(field, value))
    }

    /// The range as the documents write it: `1e-9 to 1000 kg`.
    pub fn range(&self) -> String {
        let space = if self.unit.is_empty() { "" } else { " " };
        format!("{} to {}{space}{}", Short(self.least), Short(self.greatest), self.unit)
    }
}

macro_rules! bounds {
    ($($(#[$doc:meta])* $id:ident = $name:literal, $least:expr, $greatest:expr, $unit:literal, $why:literal;)*) => {
        $($(#[$doc])* pub const $id: Bound =
            Bound { name: $name, unit: $unit, least: $least, greatest: $greatest, why: $why };)*
        /// The whole table.
        pub const BOUNDS: &[Bound] = &[$($id),*];
    };
}

bounds! {
    /// Of a body, a goal, an image or the end of a push in the world. At 128 m single precision is 0.015 mm apart.
    POSITION = "a position in the world", -100.0, 100.0, "m",
        "poses are stored in single precision, which within 100 m of the origin is finer than 0.01 mm; \
         move the origin near the workspace";
    /// In the world, before it is brought into a turn.
    HEADING = "a heading", -1e6, 1e6, "rad", "in larger ones double precision loses the angle";
    /// Of a shape's corners and parts and of the centre of mass, in the body frame.
    LOCAL = "a coordinate in the body frame", -10.0, 10.0, "m", "larger things are no tabletop objects";
    /// Of any point of a body from the origin of its frame, with all parts of a compound in place.
    REACH = "a body's reach from its origin", 0.0, 15.0, "m", "larger things are no tabletop objects";
    /// Of a disc: one of 0.6 mm has a little more than a square millimetre.
    RADIUS = "a disc's radius", 6e-4, 10.0, "m", "from a square millimetre to what a table holds";
    /// Of a polygon.
    AREA = "a polygon's area", 1e-6, 400.0, "m^2", "from a square millimetre to what a table holds";
    /// Of a polygon: the least distance between two parallel lines with the polygon between them.
    WIDTH = "a polygon's width", 1e-4, 30.0, "m", "contacts are resolved to hundredths of a millimetre";
    /// Of one polygon, as it is given, before it is simplified.
    CORNERS = "corners of a polygon", 3.0, 4096.0, "corners", "an outline needs no more, and its check takes their square";
    /// Of a compound, however deep.
    PARTS = "parts of a compound", 1.0, 256.0, "parts", "every pair of parts of two bodies is compared";
    /// Of the outlines of a body.
    OUTLINE_TOLERANCE = "an outline's tolerance", 0.0, 0.01, "m", "more would be another shape";
    HEIGHT = "a body's height", 1e-4, 10.0, "m", "from a sheet to what stands on a table";
    MASS = "a body's mass", 1e-9, 1000.0, "kg", "from a microgram to a tonne";
    /// The square root of inertia over mass.
    GYRATION = "a radius of gyration", 1e-4, 10.0, "m", "the mass lies within the body, and not in one point";
    FRICTION = "a coefficient of friction", 0.0, 10.0, "", "no surface grips harder";
    /// Of the workspace, along x and along y.
    SIDE = "a side of the workspace", 1e-3, 200.0, "m", "there must be room for a body, and positions end there";
    /// The measures of tip and fingers, and the opening.
    FINGER = "a measure of the gripper", 1e-4, 10.0, "m", "from a needle to a crane";
    /// Free gaps that the gripper needs.
    GAP = "a free gap of the gripper", 0.0, 0.1, "m", "it is a margin beside the gripper's measures";
    OVERLAP = "an overlap tolerance", 0.0, 0.05, "m", "more is no measuring noise";
    POSITION_TOLERANCE = "a goal's tolerance of position", 0.0, 1.0, "m", "a body so far away is not there";
    ROTATION_TOLERANCE = "a goal's tolerance of heading", 0.0, std::f64::consts::TAU, "rad", "there is no more than a turn";
    SYMMETRY = "a goal's symmetry", 0.0, 64.0, "", "a shape that turns into itself more often is a disc: 0";
    PUSH_LENGTH = "the travel of a push", 1e-4, 1.0, "m", "from a nudge by the smallest gripper to an arm's reach";
    TIP_HEIGHT = "a height of the tip", 0.0, 10.0, "m", "it is above the table and in the arm's reach";
    SHORTFALL = "a shortfall of the tip", 0.0, 1.0, "m", "an arm that lifts earlier pushes nothing";
    PIXEL = "the side of a pixel", 1e-5, 1.0, "m", "what is seen is a table";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_allowed_from_the_least_to_the_greatest_and_no_further() {
        for bound in BOUNDS {
            let beyond = |value: f64, by: f64| value + by * value.abs().max(f64::MIN_POSITIVE) * 1e-15;
            for good in [bound.least, bound.greatest, (bound.least + bound.greatest) / 2.0] {
                bound.check("x", good).unwrap();
            }
            for bad in [beyond(bound.least, -1.0), beyond(bound.greatest, 1.0), f64::NAN, f64::INFINITY, -f64::INFINITY]
            {
                let error = bound.check("some.field", bad).unwrap_err().to_string();
                assert!(error.starts_with("some.field: is ") && error.contains(&bound.range()), "{error}");
            }
        }
        let error = MASS.check("mass", 1e39).unwrap_err().to_string();
        assert_eq!(error, "mass: is 1e39; it must lie in 1e-9 to 1000 kg (from a microgram to a tonne)");
    }

    /// The words need not be the same, the ranges must be.
    #[test]
    fn the_documents_state_every_bound() {
        let page = include_str!("../docs/scene-format.md");
        for bound in BOUNDS {
            let row = format!("| {} | {} | {} |", bound.name, bound.range(), bound.why);
            assert!(page.contains(&row), "docs/scene-format.md lacks the row\n{row}");
        }
        let header = include_str!("../include/jostle/jostle.h");
        for bound in [POSITION, LOCAL, RADIUS, CORNERS, PARTS, HEIGHT, MASS, GYRATION, FRICTION, SIDE, FINGER, GAP] {
            assert!(header.contains(&bound.range()), "jostle.h does not state {}", bound.range());
        }
    }
}
