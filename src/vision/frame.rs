//! Where an image lies over the table.

use crate::action::Push;
use crate::bounds;
use crate::error::{Error, Result};
use crate::geom::{Pose2, Vec2, vec2};
use crate::scene::{Body, Scene, State, check_pose};

/// Greatest number of rows and of columns of an image.
pub const MAX_SIDE: usize = 16_384;

/// Position, heading, pixel size and extent of an orthographic image of the table.
///
/// Columns run along +x of the image frame and rows along +y, so that row 0 has the least y. The image frame's origin is
/// the middle of the image, and pixel (r, c) has its centre at x = (c + 1/2 - cols/2) pixel, y = (r + 1/2 - rows/2) pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// World pose of the image's middle.
    pub pose: Pose2,
    /// Side of a pixel, metres.
    pub pixel: f64,
    pub rows: usize,
    pub cols: usize,
}

/// World position of the centroid of a body's footprint.
pub fn centre_of(body: &Body, pose: &Pose2) -> Vec2 {
    pose.transform_point(body.footprint.centroid)
}

impl Frame {
    pub fn new(pose: Pose2, pixel: f64, rows: usize, cols: usize) -> Self {
        Self { pose, pixel, rows, cols }
    }

    /// A square crop about the centre of a body's footprint, its x axis at `heading` (radians) in the world.
    pub fn around(scene: &Scene, state: &State, body: usize, heading: f64, pixel: f64, side: usize) -> Result<Self> {
        if body >= scene.len() || body >= state.len() {
            return Err(Error::not_found("body", format!("there is no body {body}; the scene has {}", scene.len())));
        }
        let centre = centre_of(scene.body(body), &state.pose(body));
        Ok(Self::new(Pose2::at(centre, heading), pixel, side, side))
    }

    /// An image whose x axis runs along a push and whose middle lies `ahead` metres along it from its start.
    pub fn along(push: &Push, ahead: f64, pixel: f64, rows: usize, cols: usize) -> Self {
        Self::new(Pose2::at(push.start() + push.direction() * ahead, push.angle()), pixel, rows, cols)
    }

    /// Refuses a frame that is not finite, has no pixels or more than [`MAX_SIDE`] on a side.
    pub fn validate(&self) -> Result<()> {
        check_pose("frame.pose", &self.pose)?;
        bounds::PIXEL.check("frame.pixel", self.pixel)?;
        for (name, side) in [("frame.rows", self.rows), ("frame.cols", self.cols)] {
            if !(1..=MAX_SIDE).contains(&side) {
                return Err(Error::argument(name, format!("is {side}; it must lie in 1 to {MAX_SIDE}")));
            }
        }
        Ok(())
    }

    /// Number of pixels.
    pub fn len(&self) -> usize {
        self.rows * self.cols
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// World position of a place in the image, in pixels: whole numbers are the pixels' centres.
    pub fn point(&self, row: f64, col: f64) -> Vec2 {
        let (r, c) = (self.rows as f64 / 2.0, self.cols as f64 / 2.0);
        self.pose.transform_point(vec2(col + 0.5 - c, row + 0.5 - r) * self.pixel)
    }

    /// Place of a world point in the image: (row, column) in pixels, whole numbers at the pixels' centres.
    pub fn place(&self, point: Vec2) -> (f64, f64) {
        let p = self.pose.inverse_transform_point(point) / self.pixel;
        (p.y + self.rows as f64 / 2.0 - 0.5, p.x + self.cols as f64 / 2.0 - 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_points_undo_each_other_and_row_zero_has_the_least_y() {
        let frame = Frame::new(Pose2::new(0.5, -0.1, 0.7), 0.002, 112, 60);
        let (r, c) = frame.place(frame.point(3.0, 41.5));
        assert!((r - 3.0).abs() < 1e-10 && (c - 41.5).abs() < 1e-10, "{r} {c}");
        let straight = Frame::new(Pose2::new(1.0, 2.0, 0.0), 0.1, 2, 4);
        assert!((straight.point(0.0, 0.0) - vec2(0.85, 1.95)).norm() < 1e-12);
        assert!((straight.point(1.0, 3.0) - vec2(1.15, 2.05)).norm() < 1e-12);
    }

    #[test]
    fn a_frame_along_a_push_has_the_push_on_its_x_axis() {
        let push = Push::new(vec2(0.4, 0.1), vec2(0.4, 0.2));
        let frame = Frame::along(&push, 0.05, 0.002, 20, 100);
        let (row, from) = frame.place(push.start());
        let (same, to) = frame.place(push.end());
        assert!((row - 9.5).abs() < 1e-9 && (same - row).abs() < 1e-9, "{row} {same}");
        assert!((from - 24.5).abs() < 1e-9 && (to - 74.5).abs() < 1e-9, "{from} {to}");
    }

    #[test]
    fn bad_frames_name_the_field() {
        let good = Frame::new(Pose2::IDENTITY, 0.002, 4, 4);
        good.validate().unwrap();
        for (frame, field) in [
            (Frame { pixel: 0.0, ..good }, "frame.pixel"),
            (Frame { pixel: f64::NAN, ..good }, "frame.pixel"),
            (Frame { rows: 0, ..good }, "frame.rows"),
            (Frame { cols: MAX_SIDE + 1, ..good }, "frame.cols"),
            (Frame { pose: Pose2::new(f64::NAN, 0.0, 0.0), ..good }, "frame.pose.x"),
        ] {
            let error = frame.validate().unwrap_err().to_string();
            assert!(error.starts_with(&format!("{field}: ")), "{error}");
        }
    }
}
