//! The parametric two-finger gripper: the tip it pushes with, the jaw it grasps with.

use serde::{Deserialize, Serialize};

use super::keeping::Keeping;
use super::tip_path::TipPath;
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
    /// The fingers' ends come no nearer to the table than this. A body that they would not reach down by 5 mm (for the
    /// published gripper) cannot be grasped; one that they end above is in no finger's way.
    #[serde(skip_serializing_if = "is_zero")]
    pub lowest: f64,
    /// Length of the fingers below the palm, which stops at the target's top: over a tall one they end higher up. Infinite:
    /// longer than any body is high.
    #[serde(skip_serializing_if = "is_infinite")]
    pub finger_length: f64,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // As serde calls it.
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_infinite(value: &f64) -> bool {
    *value == f64::INFINITY
}

/// What the fingers must reach down a body that they grasp, for the published gripper, metres.
const LEAST_DEPTH: f64 = 0.005;

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
    /// The chance that it keeps what it grasps, which scores its grasps then. None: a judgement by the shape of the grip
    /// alone scores them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keeping: Option<Keeping>,
    /// How the robot moves the tip when it is told to push. None: straight from the commanded start to the commanded
    /// end, at the height that the engine has.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path: Option<TipPath>,
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
            lowest: 0.0,
            finger_length: f64::INFINITY,
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
        let (push, grasp) = (PushTip::default(), Grasper::default());
        Self { name: "robotiq_2f85".into(), push, grasp, keeping: None, path: None }
    }

    /// The same, whose grasps are scored by the chance that it keeps the body ([`Keeping::robotiq_2f85`]).
    pub fn robotiq_2f85_kept() -> Self {
        Self { name: "robotiq_2f85_kept".into(), keeping: Some(Keeping::robotiq_2f85()), ..Self::robotiq_2f85() }
    }

    /// The footprint that the originals' image masks use: opening 70 mm, 125 mm over the fingers.
    pub fn dissertation_mask() -> Self {
        Self {
            name: "dissertation_mask".into(),
            push: PushTip::default(),
            grasp: Grasper { opening: 0.070, finger_thickness: 0.0275, ..Grasper::default() },
            keeping: None,
            path: None,
        }
    }

    /// The same on the arm of the recordings: [`Gripper::robotiq_2f85_kept`] whose tip goes as a UR5e moves it
    /// ([`TipPath::ur5e`]), its base in the origin.
    pub fn robotiq_2f85_ur5e() -> Self {
        Self { name: "robotiq_2f85_ur5e".into(), path: Some(TipPath::ur5e()), ..Self::robotiq_2f85_kept() }
    }

    /// The names that [`Gripper::by_name`] knows.
    pub const NAMES: [&'static str; 4] =
        ["robotiq_2f85", "robotiq_2f85_kept", "robotiq_2f85_ur5e", "dissertation_mask"];

    /// A gripper of the library.
    pub fn by_name(name: &str) -> Result<Self> {
        match name {
            "robotiq_2f85" => Ok(Self::robotiq_2f85()),
            "robotiq_2f85_kept" => Ok(Self::robotiq_2f85_kept()),
            "robotiq_2f85_ur5e" => Ok(Self::robotiq_2f85_ur5e()),
            "dissertation_mask" => Ok(Self::dissertation_mask()),
            _ => Err(Error::not_found(
                "gripper",
                format!("no gripper is named `{name}`; known: {}", Self::NAMES.join(", ")),
            )),
        }
    }

    /// Height above the table where the fingers end in a grasp of a body of this height, metres.
    pub fn fingers_end(&self, height: f64) -> f64 {
        self.grasp.lowest.max(height - self.grasp.finger_length)
    }

    /// What is missing to the height of a body that the fingers could grasp, metres; none where they reach down far enough.
    pub fn too_low(&self, height: f64) -> Option<f64> {
        let missing = self.grasp.lowest + LEAST_DEPTH * self.scale() - height;
        (self.grasp.lowest > 0.0 && missing > 0.0).then_some(missing)
    }

    /// The name of the library's gripper with these measures.
    pub fn known_name(&self) -> Option<&'static str> {
        let unnamed = |gripper: &Gripper| Gripper { name: String::new(), ..gripper.clone() };
        Self::NAMES.into_iter().find(|name| Self::by_name(name).is_ok_and(|known| unnamed(&known) == unnamed(self)))
    }

    /// How large the gripper is beside the published one, [`Gripper::robotiq_2f85`], which has 1: the middle one of the
    /// ratios of width and thickness of the tip, opening of the jaw, width and thickness of a finger. So a gripper with
    /// one measure out of the ordinary (thick fingers, a paddle to push with) is no larger or smaller for it.
    ///
    /// Lengths that were chosen for the published gripper and its blocks are multiplied by this: stand-off and length
    /// of pushes, what counts as a full face or as clearance, the motion that is none, the constants of engines.
    pub fn scale(&self) -> f64 {
        let (tip, jaw) = (PushTip::default(), Grasper::default());
        let mut ratios = [
            self.push.width / tip.width,
            self.push.thickness / tip.thickness,
            self.grasp.opening / jaw.opening,
            self.grasp.finger_width / jaw.finger_width,
            self.grasp.finger_thickness / jaw.finger_thickness,
        ];
        ratios.sort_unstable_by(f64::total_cmp);
        let scale = ratios[ratios.len() / 2];
        // Measures that went through single precision are the published ones still.
        if (scale - 1.0).abs() < 1e-6 { 1.0 } else { scale }
    }

    /// The same gripper with every length times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Gripper {
        let Gripper { name, push, grasp, keeping, path } = self;
        Gripper {
            name: name.clone(),
            push: PushTip {
                width: factor * push.width,
                thickness: factor * push.thickness,
                clearance: factor * push.clearance,
            },
            grasp: Grasper {
                opening: factor * grasp.opening,
                finger_width: factor * grasp.finger_width,
                finger_thickness: factor * grasp.finger_thickness,
                finger_clearance: factor * grasp.finger_clearance,
                fit: factor * grasp.fit,
                pad_edge: factor * grasp.pad_edge,
                min_cover: factor * grasp.min_cover,
                max_wedge: grasp.max_wedge,
                lowest: factor * grasp.lowest,
                finger_length: factor * grasp.finger_length,
            },
            keeping: keeping.as_ref().map(|keeping| keeping.scaled(factor)),
            path: path.as_ref().map(|path| path.scaled(factor)),
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
        bounds::TIP_HEIGHT.check("gripper.grasp.lowest", g.lowest)?;
        if g.finger_length != f64::INFINITY {
            bounds::FINGER.check("gripper.grasp.finger_length", g.finger_length)?;
            let least = LEAST_DEPTH * self.scale();
            if g.finger_length < least {
                let reason = format!("is {}; fingers must reach at least {least} m down a body", g.finger_length);
                return Err(Error::argument("gripper.grasp.finger_length", reason));
            }
        }
        if 2.0 * g.fit >= g.opening {
            return Err(Error::argument("gripper.grasp.fit", "leaves no room for an object within the opening"));
        }
        let within = |error: Error| error.within("gripper");
        self.keeping.as_ref().map_or(Ok(()), |keeping| keeping.validate().map_err(within))?;
        self.path.as_ref().map_or(Ok(()), |path| path.validate().map_err(within))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gripper_s_scale_is_that_of_most_of_its_measures() {
        for name in Gripper::NAMES {
            let gripper = Gripper::by_name(name).unwrap();
            assert_eq!(gripper.scale(), 1.0, "{name}");
            for factor in [0.05, 0.3, 1.0 / 3.0, 2.0, 10.0] {
                assert!((gripper.scaled(factor).scale() / factor - 1.0).abs() < 1e-12, "{name} {factor}");
            }
        }
        let changes: [fn(&mut Gripper, f64); 5] = [
            |g, f| g.push.width *= f,
            |g, f| g.push.thickness *= f,
            |g, f| g.grasp.opening *= f,
            |g, f| g.grasp.finger_width *= f,
            |g, f| g.grasp.finger_thickness *= f,
        ];
        for change in changes {
            for factor in [0.1, 0.9, 1.5, 10.0] {
                let mut odd = Gripper::robotiq_2f85();
                change(&mut odd, factor);
                assert_eq!(odd.scale(), 1.0, "{odd:?}");
            }
        }
        let mut rounded = Gripper::robotiq_2f85();
        for change in changes {
            change(&mut rounded, 1.0 + 4e-8);
        }
        assert_eq!(rounded.scale(), 1.0, "single precision");
    }
}
