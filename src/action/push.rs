//! Push and grasp actions.

use serde::{Deserialize, Serialize};

use crate::bounds;
use crate::error::Result;
use crate::geom::{Obb, Vec2, vec2};
use crate::scene::PushTip;

/// A straight push: the tip comes down at `start`, moves to `end` and lifts. World frame, metres.
/// The points are the centre of the tip's footprint; its width stays across the push.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Push {
    pub start: [f64; 2],
    pub end: [f64; 2],
    /// The body it was aimed at, if a sampler made it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<usize>,
}

impl Push {
    pub fn new(start: Vec2, end: Vec2) -> Self {
        Self { start: [start.x, start.y], end: [end.x, end.y], body: None }
    }

    /// The same push where every length is times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Push {
        Push { start: self.start.map(|v| factor * v), end: self.end.map(|v| factor * v), body: self.body }
    }

    #[inline]
    pub fn start(&self) -> Vec2 {
        vec2(self.start[0], self.start[1])
    }

    #[inline]
    pub fn end(&self) -> Vec2 {
        vec2(self.end[0], self.end[1])
    }

    /// Metres.
    #[inline]
    pub fn length(&self) -> f64 {
        (self.end() - self.start()).norm()
    }

    /// Unit vector of the motion; +x for a push of no length.
    #[inline]
    pub fn direction(&self) -> Vec2 {
        let d = self.end() - self.start();
        let n = d.norm();
        if n > 0.0 { d / n } else { vec2(1.0, 0.0) }
    }

    /// Angle of the motion from +x, radians.
    pub fn angle(&self) -> f64 {
        let d = self.direction();
        d.y.atan2(d.x)
    }

    pub fn is_finite(&self) -> bool {
        self.start.iter().chain(&self.end).all(|v| v.is_finite())
    }

    /// The tip's footprint where it comes down.
    pub fn tip_at_start(&self, tip: &PushTip) -> Obb {
        Obb { centre: self.start(), axis: self.direction(), half: [tip.thickness / 2.0, tip.width / 2.0] }
    }
}

/// A vertical two-finger grasp. World frame, metres and radians.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Grasp {
    /// The body it takes.
    pub body: usize,
    /// Midpoint between the pads.
    pub position: [f64; 2],
    /// Direction along which the fingers close, from +x, in [0, pi).
    pub angle: f64,
    /// Distance between the pads before closing.
    pub opening: f64,
    /// Width of the target between the pads.
    pub width: f64,
    /// Least spare room of all conditions of the grasp, metres; the grasp holds while it is not negative.
    pub margin: f64,
    /// Expected quality in [0, 1].
    pub score: f64,
}

impl Grasp {
    /// The same grasp where every length is times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Grasp {
        Grasp {
            position: self.position.map(|v| factor * v),
            opening: factor * self.opening,
            width: factor * self.width,
            margin: factor * self.margin,
            ..*self
        }
    }
}

/// One action of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Action {
    Push(Push),
    Grasp(Grasp),
}

impl Action {
    /// Refuses what no arm can be told: places beyond the bounds of positions, numbers that are none.
    pub fn validate(&self) -> Result<()> {
        match self {
            Action::Push(push) => {
                bounds::POSITION.check_all("push.start", push.start)?;
                bounds::POSITION.check_all("push.end", push.end)
            }
            Action::Grasp(grasp) => {
                bounds::POSITION.check_all("grasp.position", grasp.position)?;
                bounds::HEADING.check("grasp.angle", grasp.angle)?;
                bounds::LOCAL.check("grasp.opening", grasp.opening)?;
                bounds::LOCAL.check("grasp.width", grasp.width)?;
                bounds::LOCAL.check("grasp.margin", grasp.margin)?;
                bounds::LOCAL.check("grasp.score", grasp.score)
            }
        }
    }
}
