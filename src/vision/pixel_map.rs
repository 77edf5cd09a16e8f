//! Where the pixels of a camera's image lie on the table.

use super::frame::Frame;
use crate::error::{Error, Result};
use crate::geom::{Vec2, vec2};

/// From the place in an image to the table, affine: world x = `x[0]` column + `x[1]` row + `x[2]`, the same for y.
/// Whole numbers are the pixels' centres. Any axes and origin will do, mirrored ones too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelMap {
    pub x: [f64; 3],
    pub y: [f64; 3],
}

impl From<&Frame> for PixelMap {
    fn from(frame: &Frame) -> Self {
        let origin = frame.point(0.0, 0.0);
        let (col, row) = (frame.point(0.0, 1.0) - origin, frame.point(1.0, 0.0) - origin);
        Self { x: [col.x, row.x, origin.x], y: [col.y, row.y, origin.y] }
    }
}

impl PixelMap {
    /// Refuses a map that is not finite or makes the image a line, or whose pixels are over four times as long as wide.
    pub fn validate(&self) -> Result<()> {
        if !self.x.iter().chain(&self.y).all(|v| v.is_finite()) {
            return Err(Error::argument("map", "is not finite"));
        }
        let (col, row) = (vec2(self.x[0], self.y[0]), vec2(self.x[1], self.y[1]));
        let (short, long) = (col.norm().min(row.norm()), col.norm().max(row.norm()));
        if short <= 0.0 || self.determinant().abs() < 0.25 * short * long || long > 4.0 * short {
            return Err(Error::argument("map", "its columns and rows do not span pixels that are about square"));
        }
        Ok(())
    }

    /// The table's point at a place in the image.
    #[inline]
    pub fn point(&self, row: f64, col: f64) -> Vec2 {
        vec2(self.x[0] * col + self.x[1] * row + self.x[2], self.y[0] * col + self.y[1] * row + self.y[2])
    }

    /// Signed area of a pixel, square metres: negative if the image is mirrored.
    pub fn determinant(&self) -> f64 {
        self.x[0] * self.y[1] - self.x[1] * self.y[0]
    }

    /// Side of a square as large as a pixel, metres.
    pub fn pixel(&self) -> f64 {
        self.determinant().abs().sqrt()
    }
}
