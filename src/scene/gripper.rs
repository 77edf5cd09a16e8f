//! The parametric two-finger gripper: the tip it pushes with, the jaw it grasps with.

use serde::{Deserialize, Serialize};

use crate::bounds;
use crate::error::{Error, Result, check_range};

/// The closed fingers as a rectangular push tip. Metres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PushTip {
    /// Extent across the push.
    pub width: f64,
    /// Extent along the push.
    pub thickness: f64,
    /// Free gap needed round the tip where it comes down.
    pub clearance: f64,
}

/// A parallel jaw coming down vertically. Metres and radians.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Grasper {
    /// Free distance between the pads when open.
    pub opening: f64,
    /// Extent of a finger across the closing direction (the pad's width).
    pub finger_width: f64,
    /// Extent of a finger along the closing direction.
    pub finger_thickness: f64,
    /// Free gap needed on every side of a finger.
    pub finger_clearance: f64,
    /// Free gap needed between each pad and the target before closing.
    pub fit: f64,
    /// Strip at either end of the pads that may be blocked by another body while closing.
    pub pad_edge: f64,
    /// Least length of the target that the pads must cover.
    pub min_cover: f64,
    /// Greatest angle between the two gripped faces.
    pub max_wedge: f64,
}

/// A gripper by name and measures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gripper {
    #[serde(default)]
    pub name: String,
    #[serde(default)]
    pub push: PushTip,
    #[serde(default)]
    pub grasp: Grasper,
}

impl Default for PushTip {
    /// The closed Robotiq 2F-85 of MORE and PMBS: 30 mm across the push, 22 mm along it.
    fn default() -> Self {
        Self { width: 0.030, thickness: 0.022, clearance: 0.002 }
    }
}

impl Default for Grasper {
    /// The jaw of [`Gripper::robotiq_2f85`].
    fn default() -> Self {
        Self {
            opening: 0.0807,
            finger_width: 0.022,
            finger_thickness: 0.015,
            finger_clearance: 0.001,
            fit: 0.00125,
            pad_edge: 0.003,
            min_cover: 0.012,
            max_wedge: 35f64.to_radians(),
        }
    }
}

impl Default for Gripper {
    fn default() -> Self {
        Self::robotiq_2f85()
    }
}

impl Gripper {
    /// The Robotiq 2F-85 as the originals simulate it: opening 80.7 mm, fingers 15 mm thick and 22 mm wide.
    pub fn robotiq_2f85() -> Self {
        Self { name: "robotiq_2f85".into(), push: PushTip::default(), grasp: Grasper::default() }
    }

    /// The footprint that the originals' image masks use: opening 70 mm, 125 mm over the fingers.
    pub fn dissertation_mask() -> Self {
        Self {
            name: "dissertation_mask".into(),
            push: PushTip::default(),
            grasp: Grasper { opening: 0.070, finger_thickness: 0.0275, ..Grasper::default() },
        }
    }

    /// The names that [`Gripper::by_name`] knows.
    pub const NAMES: [&'static str; 2] = ["robotiq_2f85", "dissertation_mask"];

    /// A gripper of the library.
    pub fn by_name(name: &str) -> Result<Self> {
        match name {
            "robotiq_2f85" => Ok(Self::robotiq_2f85()),
            "dissertation_mask" => Ok(Self::dissertation_mask()),
            _ => Err(Error::not_found(
                "gripper",
                format!("no gripper is named `{name}`; known: {}", Self::NAMES.join(", ")),
            )),
        }
    }

    /// Checks every measure; errors name the field.
    pub fn validate(&self) -> Result<()> {
        bounds::FINGER.check("gripper.push.width", self.push.width)?;
        bounds::FINGER.check("gripper.push.thickness", self.push.thickness)?;
        bounds::GAP.check("gripper.push.clearance", self.push.clearance)?;
        let g = &self.grasp;
        bounds::FINGER.check("gripper.grasp.opening", g.opening)?;
        bounds::FINGER.check("gripper.grasp.finger_width", g.finger_width)?;
        bounds::FINGER.check("gripper.grasp.finger_thickness", g.finger_thickness)?;
        bounds::GAP.check("gripper.grasp.finger_clearance", g.finger_clearance)?;
        bounds::GAP.check("gripper.grasp.fit", g.fit)?;
        check_range("gripper.grasp.pad_edge", g.pad_edge, 0.0..=g.finger_width / 2.0)?;
        check_range("gripper.grasp.min_cover", g.min_cover, 0.0..=g.finger_width)?;
        check_range("gripper.grasp.max_wedge", g.max_wedge, 0.0..=std::f64::consts::FRAC_PI_2)?;
        if 2.0 * g.fit >= g.opening {
            return Err(Error::argument("gripper.grasp.fit", "leaves no room for an object within the opening"));
        }
        Ok(())
    }
}
