//! The parameters of the contour sampler, and the presets.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, check_range};
use crate::geom::{Vec2, vec2};
use crate::scene::{Gripper, PushTip, Workspace};

/// Which pushes [`super::ContourSampler`] proposes. Metres and radians.
///
/// Lengths are those for the published gripper; for another the sampler takes [`SamplerParams::fitted`]. So they are
/// right for the blocks that the published gripper handles, and for all that is larger or smaller in proportion.
///
/// A push along direction `d` aims at the centroid `c` of a body's area (the originals: the moments of its mask).
/// Within a strip of half-width `strip` round the line through `c` along `d`, the farthest point of the body behind `c`
/// is the contact; the centre of the tip starts `stand_off` behind it and moves `length * travel` along `d`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SamplerParams {
    /// Both ways along both principal axes of the area ([`crate::geom::Footprint::principal_axes`]; the originals: PCA
    /// of the contour). A shape without a preferred direction, such as a square or a disc, uses its own x and y.
    pub axes: bool,
    /// The four directions halfway between the axes (PMBS; there tabulated for each block, here computed).
    pub diagonals: bool,
    /// From corners towards the centroid.
    pub corners: Option<Corners>,
    /// From points of the contour towards the centroid.
    pub contour: ContourRule,
    /// Half-width of the strip in which the contact is sought (8 px = 16 mm in all originals).
    pub strip: f64,
    /// From the contact back to the centre of the tip (VFT 12 px = 24 mm, MORE 10 px, PMBS 9 px).
    pub stand_off: f64,
    /// Commanded length (VFT 37 px = 74 mm, MORE 50 px = 100 mm, PMBS 25 px = 50 mm).
    pub length: f64,
    /// Further lengths of every push, as shares of `length`. The originals have one length.
    pub lengths: Vec<f64>,
    /// Further pushes along each axis, beside the line through the centroid by these distances to the left of it. The
    /// strip in which the contact is sought moves along. The originals push at the centroid alone.
    pub lateral: Vec<f64>,
    /// Share of `length` that the tip really travels. 1: as commanded. The originals' simulated arm stops when it is
    /// within 0.05 rad of its goal and travels 87 to 94 of 100 mm: 0.91 plays that back.
    pub travel: f64,
    /// The rectangle in which starts and ends must lie.
    pub region: Region,
    /// Least distance of a start from the region's edge.
    pub start_inset: f64,
    /// Least distance of an end from the region's edge; absent: ends are free.
    pub end_inset: Option<f64>,
    /// What must be free of bodies where the tip comes down.
    pub start_box: StartBox,
    /// Where the start is not free or not inside, the whole push is moved back by each of these in turn.
    pub back_off: Vec<f64>,
    /// Which push comes first.
    pub order: Order,
    /// VFT: continue the previous push. The body whose contact along the previous direction lies nearest to the
    /// previous end, within this distance (25 px = 5 cm), gets a push along the same direction, first of all and
    /// without the test of the start box; the border counts. Absent: no continuation.
    pub continue_within: Option<f64>,
}

/// Directions from a body's corners.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Corners {
    /// At most so many, those farthest from the centroid first.
    pub most: usize,
    /// Least angle to the body's other directions.
    pub separation: f64,
}

/// Directions from points of the contour, equally spaced from the outline's first corner on. (The originals walk the
/// contour's pixels from the one with the least row: their points turn with the picture, ours with the body.)
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ContourRule {
    #[default]
    None,
    /// VFT: each point whose direction differs from the axes by more than `separation`.
    OffAxes { points: usize, separation: f64 },
    /// MORE: in order, each point whose direction differs by more than `separation` from every legal push accepted
    /// for this body so far. Where a direction is blocked, the next point is tried, so the directions depend on the
    /// state. (MORE tries every pixel of the contour, about 90 to 135.)
    Greedy { points: usize, separation: f64 },
}

/// A rectangle that borders are measured from.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Region {
    /// The scene's workspace.
    #[default]
    Workspace,
    /// The scene's workspace with every edge moved outwards (inwards where negative).
    Grown { by: f64 },
    /// A rectangle of the world.
    Rectangle { min: [f64; 2], max: [f64; 2] },
}

/// What must be free where the tip comes down, centred at the start and turned with the push.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum StartBox {
    /// The tip grown on every side by `clearance`, or by the gripper's own if absent: 26 mm along and 34 mm across for
    /// the default tip. VFT tests 13 x 17 px, which is the same; MORE and PMBS 15 x 19 px (30 x 38 mm), which is their
    /// tip and clearance rounded up to whole pixels on either side.
    Tip { clearance: Option<f64> },
    /// A rectangle whatever the gripper.
    Fixed { along: f64, across: f64 },
}

/// In which order the pushes come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// Every order equally likely.
    #[default]
    Shuffled,
    /// VFT: pushes along axes before the others, each group shuffled.
    AxesFirst,
}

impl Default for SamplerParams {
    /// `dense`.
    fn default() -> Self {
        Self::dense()
    }
}

impl SamplerParams {
    /// The same pushes for a gripper of another size: every length grows with the gripper ([`Gripper::scale`]), the
    /// strip with the width of the tip, and the stand-off keeps the free way between tip and contact, however thick
    /// the tip is. A region given as a rectangle of the world stays where it is. Nothing changes for the published
    /// gripper.
    #[must_use]
    pub fn fitted(&self, gripper: &Gripper) -> SamplerParams {
        let (scale, published) = (gripper.scale(), PushTip::default());
        let all = |lengths: &[f64]| lengths.iter().map(|v| scale * v).collect();
        let start_box = match self.start_box {
            StartBox::Tip { clearance } => StartBox::Tip { clearance: clearance.map(|c| scale * c) },
            StartBox::Fixed { along, across } => StartBox::Fixed { along: scale * along, across: scale * across },
        };
        let thicker = start_box.half(&gripper.push)[0] - scale * self.start_box.half(&published)[0];
        SamplerParams {
            strip: gripper.push.width / published.width * self.strip,
            stand_off: scale * self.stand_off + thicker,
            length: scale * self.length,
            lateral: all(&self.lateral),
            region: match self.region {
                Region::Grown { by } => Region::Grown { by: scale * by },
                other => other,
            },
            start_inset: scale * self.start_inset,
            end_inset: self.end_inset.map(|inset| scale * inset),
            start_box,
            back_off: all(&self.back_off),
            continue_within: self.continue_within.map(|within| scale * within),
            ..self.clone()
        }
    }

    /// Ours: 4 axes, 4 diagonals and up to 4 corners, 0.10 m, starts anywhere in the workspace.
    pub fn dense() -> Self {
        Self {
            axes: true,
            diagonals: true,
            corners: Some(Corners { most: 4, separation: 0.2 }),
            contour: ContourRule::None,
            strip: 0.016,
            stand_off: 0.020,
            length: 0.10,
            lengths: Vec::new(),
            lateral: Vec::new(),
            travel: 1.0,
            region: Region::Workspace,
            start_inset: 0.0,
            end_inset: None,
            start_box: StartBox::Tip { clearance: None },
            back_off: vec![0.010, 0.020],
            order: Order::Shuffled,
            continue_within: None,
        }
    }

    /// Visual Foresight Trees.
    pub fn vft() -> Self {
        Self {
            diagonals: false,
            corners: None,
            contour: ContourRule::OffAxes { points: 12, separation: 0.3 },
            stand_off: 0.024,
            length: 0.074,
            start_inset: 0.010,
            back_off: Vec::new(),
            order: Order::AxesFirst,
            continue_within: Some(0.05),
            ..Self::dense()
        }
    }

    /// MORE.
    pub fn more() -> Self {
        Self {
            diagonals: false,
            corners: None,
            contour: ContourRule::Greedy { points: 48, separation: 0.75 },
            start_inset: 0.030,
            ..Self::dense()
        }
    }

    /// PMBS, with the border of its code: 28 mm inside the camera's square of 0.448 m, which is the workspace that its
    /// blocks must stay in (0.288 m) grown by 80 mm. For the strict reading set `region` to the workspace and both
    /// insets to 0.
    pub fn pmbs() -> Self {
        Self {
            corners: None,
            stand_off: 0.018,
            length: 0.050,
            region: Region::Grown { by: 0.080 },
            start_inset: 0.028,
            end_inset: Some(0.028),
            back_off: vec![0.010],
            ..Self::dense()
        }
    }

    /// [`SamplerParams::pmbs`] with up to four more directions, from the corners of a body.
    pub fn pmbs_contour() -> Self {
        Self { corners: Some(Corners { most: 4, separation: 0.2 }), ..Self::pmbs() }
    }

    /// [`SamplerParams::pmbs_contour`] with pushes off the centroid and of three lengths: about four times as many.
    pub fn rich() -> Self {
        Self { lengths: vec![0.6, 1.4], lateral: vec![-0.010, 0.010], ..Self::pmbs_contour() }
    }

    /// Checks every field; errors name it.
    pub fn validate(&self) -> Result<()> {
        for (i, share) in self.lengths.iter().enumerate() {
            check_range(&format!("sampler.lengths[{i}]"), *share, 0.05..=10.0)?;
        }
        for (i, offset) in self.lateral.iter().enumerate() {
            check_range(&format!("sampler.lateral[{i}]"), *offset, -1.0..=1.0)?;
        }
        check_range("sampler.strip", self.strip, 0.0..=1.0)?;
        check_range("sampler.stand_off", self.stand_off, 0.0..=1.0)?;
        check_range("sampler.length", self.length, 1e-4..=10.0)?;
        check_range("sampler.travel", self.travel, 1e-4..=10.0)?;
        check_range("sampler.start_inset", self.start_inset, 0.0..=10.0)?;
        if let Some(inset) = self.end_inset {
            check_range("sampler.end_inset", inset, 0.0..=10.0)?;
        }
        for (i, back) in self.back_off.iter().enumerate() {
            check_range(&format!("sampler.back_off[{i}]"), *back, 0.0..=1.0)?;
        }
        if let Some(within) = self.continue_within {
            check_range("sampler.continue_within", within, 0.0..=10.0)?;
        }
        if let Some(Corners { separation, .. }) = self.corners {
            check_range("sampler.corners.separation", separation, 0.0..=std::f64::consts::PI)?;
        }
        if let ContourRule::OffAxes { points, separation } | ContourRule::Greedy { points, separation } = self.contour {
            check_range("sampler.contour.separation", separation, 0.0..=std::f64::consts::PI)?;
            if !(1..=4096).contains(&points) {
                return Err(Error::argument("sampler.contour.points", format!("is {points}; it must lie in 1..=4096")));
            }
        }
        match self.start_box {
            StartBox::Tip { clearance: Some(c) } => check_range("sampler.start_box.tip.clearance", c, 0.0..=1.0)?,
            StartBox::Tip { clearance: None } => {}
            StartBox::Fixed { along, across } => {
                check_range("sampler.start_box.fixed.along", along, 1e-4..=10.0)?;
                check_range("sampler.start_box.fixed.across", across, 1e-4..=10.0)?;
            }
        }
        match self.region {
            Region::Workspace => {}
            Region::Grown { by } => check_range("sampler.region.grown.by", by, -10.0..=10.0)?,
            Region::Rectangle { min, max } => {
                Workspace::rectangle(vec2(min[0], min[1]), vec2(max[0], max[1]))
                    .validate()
                    .map_err(|e| e.within("sampler.region.rectangle"))?;
            }
        }
        if !(self.axes || self.diagonals || self.corners.is_some() || self.contour != ContourRule::None) {
            return Err(Error::argument("sampler.axes", "is off and so is every other source of directions"));
        }
        Ok(())
    }
}

impl Region {
    /// Least and greatest corner in this workspace.
    pub(super) fn resolve(&self, workspace: &Workspace) -> (Vec2, Vec2) {
        let (min, max) = match *self {
            Region::Rectangle { min, max } => (min, max),
            _ => (workspace.min, workspace.max),
        };
        let by = if let Region::Grown { by } = *self { by } else { 0.0 };
        (vec2(min[0] - by, min[1] - by), vec2(max[0] + by, max[1] + by))
    }
}

impl StartBox {
    /// Half extents along the push and across it.
    pub(super) fn half(&self, tip: &PushTip) -> [f64; 2] {
        match *self {
            StartBox::Tip { clearance } => {
                let margin = clearance.unwrap_or(tip.clearance);
                [tip.thickness / 2.0 + margin, tip.width / 2.0 + margin]
            }
            StartBox::Fixed { along, across } => [along / 2.0, across / 2.0],
        }
    }
}
