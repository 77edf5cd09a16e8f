//! Rigid motions of the plane.

use nalgebra::{Isometry2, Vector2};

/// A point or a vector in the plane, metres.
pub type Vec2 = Vector2<f64>;

/// Shorthand for [`Vec2::new`].
#[inline]
pub fn vec2(x: f64, y: f64) -> Vec2 {
    Vec2::new(x, y)
}

/// Brings an angle into (-pi, pi].
#[inline]
pub fn normalize_angle(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let a = angle % TAU;
    if a > PI {
        a - TAU
    } else if a <= -PI {
        a + TAU
    } else {
        a
    }
}

/// Position (m) and heading (rad, counter-clockwise from +x) of a body frame in the world frame.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose2 {
    pub x: f64,
    pub y: f64,
    #[serde(default)]
    pub theta: f64,
}

impl Pose2 {
    pub const IDENTITY: Pose2 = Pose2 { x: 0.0, y: 0.0, theta: 0.0 };

    #[inline]
    pub fn new(x: f64, y: f64, theta: f64) -> Self {
        Self { x, y, theta }
    }

    #[inline]
    pub fn at(position: Vec2, theta: f64) -> Self {
        Self { x: position.x, y: position.y, theta }
    }

    #[inline]
    pub fn position(&self) -> Vec2 {
        vec2(self.x, self.y)
    }

    /// The world direction of the body's x axis.
    #[inline]
    pub fn heading(&self) -> Vec2 {
        let (s, c) = self.theta.sin_cos();
        vec2(c, s)
    }

    pub fn is_finite(&self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.theta.is_finite()
    }

    /// The motion with its sine and cosine worked out, for transforming many points.
    #[inline]
    pub fn frame(&self) -> Frame {
        let (sin, cos) = self.theta.sin_cos();
        Frame { origin: self.position(), sin, cos }
    }

    /// A body-frame point in the world frame.
    #[inline]
    pub fn transform_point(&self, p: Vec2) -> Vec2 {
        self.frame().point(p)
    }

    /// A world-frame point in the body frame.
    #[inline]
    pub fn inverse_transform_point(&self, p: Vec2) -> Vec2 {
        self.frame().inverse_point(p)
    }

    /// The same heading where every length is times `factor`.
    #[inline]
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Pose2 {
        Pose2 { x: factor * self.x, y: factor * self.y, theta: self.theta }
    }

    /// `self * other`: `other` given in the frame of `self`.
    pub fn compose(&self, other: &Pose2) -> Pose2 {
        Pose2::at(self.transform_point(other.position()), normalize_angle(self.theta + other.theta))
    }

    /// The motion that undoes this one.
    pub fn inverse(&self) -> Pose2 {
        let (s, c) = self.theta.sin_cos();
        Pose2::new(-c * self.x - s * self.y, s * self.x - c * self.y, -self.theta)
    }

    pub fn to_isometry(&self) -> Isometry2<f64> {
        Isometry2::new(self.position(), self.theta)
    }
}

/// A pose with its rotation worked out.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    pub origin: Vec2,
    pub sin: f64,
    pub cos: f64,
}

impl Frame {
    #[inline]
    pub fn vector(&self, v: Vec2) -> Vec2 {
        vec2(self.cos * v.x - self.sin * v.y, self.sin * v.x + self.cos * v.y)
    }

    #[inline]
    pub fn point(&self, p: Vec2) -> Vec2 {
        self.origin + self.vector(p)
    }

    #[inline]
    pub fn inverse_vector(&self, v: Vec2) -> Vec2 {
        vec2(self.cos * v.x + self.sin * v.y, -self.sin * v.x + self.cos * v.y)
    }

    #[inline]
    pub fn inverse_point(&self, p: Vec2) -> Vec2 {
        self.inverse_vector(p - self.origin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compose_and_inverse_cancel() {
        let a = Pose2::new(0.3, -0.2, 2.5);
        let e = a.compose(&a.inverse());
        assert!(e.position().norm() < 1e-15 && e.theta.abs() < 1e-15, "{e:?}");
        let p = vec2(0.1, 0.7);
        assert!((a.inverse_transform_point(a.transform_point(p)) - p).norm() < 1e-15);
    }

    #[test]
    fn angles_are_normalized_to_the_half_open_turn() {
        use std::f64::consts::PI;
        for (given, wanted) in [(3.0 * PI, PI), (-PI, PI), (2.0 * PI, 0.0), (-7.0, -7.0 + 2.0 * PI)] {
            assert!((normalize_angle(given) - wanted).abs() < 1e-12, "{given}");
        }
    }
}
