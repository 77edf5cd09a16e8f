//! Bodies: upright prisms on the table.

use serde::{Deserialize, Serialize};

use crate::bounds;
use crate::error::{Error, Result};
use crate::geom::{Footprint, Shape, Vec2, vec2};

/// Greatest number of bodies in a scene: the width of a [`super::Mask`].
pub const MAX_BODIES: usize = super::Mask::BITS;
/// Greatest number of bodies in a scene that is simulated: the slots of a lane of `planar`. Rearrangements need no engine.
pub const MAX_SIMULATED: usize = 128;

/// What a user says of a body. Every field but the shape has a default.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyDef {
    /// Unique in its scene; empty means "body N".
    #[serde(default)]
    pub name: String,
    pub shape: Shape,
    /// Metres, from the table up.
    #[serde(default = "default_height")]
    pub height: f64,
    /// Kilograms.
    #[serde(default = "default_mass")]
    pub mass: f64,
    /// Coefficient of the body's surface; a contact uses the product of the two surfaces' coefficients.
    #[serde(default = "default_friction")]
    pub friction: f64,
    /// A grasp may take it.
    #[serde(default = "yes")]
    pub pickable: bool,
    /// A push may be aimed at it. (Any body may be moved by the others.)
    #[serde(default = "yes")]
    pub pushable: bool,
    /// Centre of mass in the body frame, metres; the area's centroid if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub centre_of_mass: Option<[f64; 2]>,
    /// Moment of inertia about the centre of mass, kg m^2; that of a uniform prism if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia: Option<f64>,
    /// Corners that lie within so many metres of the outline without them are left out: planning takes longer the more
    /// there are. 0 keeps all; if absent it is 0.1 mm, or a hundredth of the shape's thickness (twice the area over the
    /// perimeter) where that is less. The shape, its area and its moments stay as given;
    /// [`Footprint::deviation`] says how far the outline went.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outline_tolerance: Option<f64>,
}

fn default_height() -> f64 {
    0.045
}
fn default_mass() -> f64 {
    0.1
}
fn default_friction() -> f64 {
    0.5
}
fn yes() -> bool {
    true
}

impl BodyDef {
    /// A body of this shape with the defaults: 45 mm tall, 0.1 kg, friction 0.5, pickable and pushable.
    pub fn new(shape: Shape) -> Self {
        Self {
            name: String::new(),
            shape,
            height: default_height(),
            mass: default_mass(),
            friction: default_friction(),
            pickable: true,
            pushable: true,
            centre_of_mass: None,
            inertia: None,
            outline_tolerance: None,
        }
    }

    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }
}

/// An inertia is possible for a mass if its radius of gyration is.
fn check_inertia(inertia: f64, mass: f64) -> Result<()> {
    let gyration = bounds::GYRATION;
    gyration.check("inertia", (inertia / mass).sqrt()).map_err(|_| {
        let [least, greatest] = [gyration.least, gyration.greatest].map(|radius| mass * radius * radius);
        Error::argument(
            "inertia",
            format!(
                "is {inertia:e}; with a mass of {mass} kg it must lie in {least:e} to {greatest:e} kg m^2, which is a radius \
                 of gyration of {}",
                gyration.range()
            ),
        )
    })
}

/// A body made ready for use.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    pub name: String,
    pub footprint: Footprint,
    /// Metres.
    pub height: f64,
    /// Kilograms.
    pub mass: f64,
    pub friction: f64,
    pub pickable: bool,
    pub pushable: bool,
    /// Body frame, metres.
    pub centre_of_mass: Vec2,
    /// About the centre of mass, kg m^2.
    pub inertia: f64,
    given_centre_of_mass: bool,
    given_inertia: bool,
    outline_tolerance: Option<f64>,
}

impl Body {
    /// Checks the definition and prepares it. Errors name the field of the definition.
    pub fn new(def: BodyDef) -> Result<Body> {
        if let Some(tolerance) = def.outline_tolerance {
            bounds::OUTLINE_TOLERANCE.check("outline_tolerance", tolerance)?;
        }
        let footprint = Footprint::simplified(def.shape, def.outline_tolerance)?;
        bounds::HEIGHT.check("height", def.height)?;
        bounds::MASS.check("mass", def.mass)?;
        bounds::FRICTION.check("friction", def.friction)?;
        let centre_of_mass = def.centre_of_mass.map_or(footprint.centroid, |[x, y]| vec2(x, y));
        bounds::LOCAL.check_all("centre_of_mass", [centre_of_mass.x, centre_of_mass.y])?;
        if let Some(inertia) = def.inertia {
            check_inertia(inertia, def.mass)?;
        }
        let about = footprint.gyration_squared + (centre_of_mass - footprint.centroid).norm_squared();
        Ok(Body {
            name: def.name,
            height: def.height,
            mass: def.mass,
            friction: def.friction,
            pickable: def.pickable,
            pushable: def.pushable,
            centre_of_mass,
            inertia: def.inertia.unwrap_or(def.mass * about),
            given_centre_of_mass: def.centre_of_mass.is_some(),
            given_inertia: def.inertia.is_some(),
            outline_tolerance: def.outline_tolerance,
            footprint,
        })
    }

    /// The same body with every length times `factor`, and the same mass.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Body {
        Body {
            footprint: self.footprint.scaled(factor),
            height: factor * self.height,
            centre_of_mass: self.centre_of_mass * factor,
            inertia: self.inertia * factor * factor,
            outline_tolerance: self.outline_tolerance.map(|t| factor * t),
            ..self.clone()
        }
    }

    /// The definition that makes this body again.
    pub fn def(&self) -> BodyDef {
        BodyDef {
            name: self.name.clone(),
            shape: self.footprint.shape.clone(),
            height: self.height,
            mass: self.mass,
            friction: self.friction,
            pickable: self.pickable,
            pushable: self.pushable,
            centre_of_mass: self.given_centre_of_mass.then_some([self.centre_of_mass.x, self.centre_of_mass.y]),
            inertia: self.given_inertia.then_some(self.inertia),
            outline_tolerance: self.outline_tolerance,
        }
    }
}
