//! Paints a state: each convex piece of a footprint becomes one span of pixels a row.

use super::frame::Frame;
use super::image::ImageMut;
use crate::error::{Error, Result};
use crate::geom::{Footprint, Piece, Pose2, Vec2};
use crate::scene::{Mask, Scene, State};

/// A pixel's centre this near to a border lies on it, in pixels. Keeps the border closed after rounding, and seams
/// between the pieces of one footprint without gaps.
const ON_BORDER: f64 = 1e-9;

/// Paints images of states. Keeps its working memory, so that a warm one allocates nothing.
///
/// A pixel shows a body if the pixel's centre lies in the body's footprint, border included. Where footprints overlap
/// the higher body shows, of equally high ones that with the lower index.
#[derive(Debug, Default)]
pub struct Rasteriser {
    /// Bodies from the lowest to the highest.
    order: Vec<usize>,
    /// Corners of a piece, in pixels.
    corners: Vec<Vec2>,
    /// Least and greatest column of a piece on each row.
    spans: Vec<[f64; 2]>,
}

impl Rasteriser {
    pub fn new() -> Self {
        Self::default()
    }

    /// Which body each pixel shows: 0 is the table, k + 1 is body k.
    pub fn labels(&mut self, scene: &Scene, state: &State, frame: &Frame, out: &mut ImageMut<u8>) -> Result<()> {
        check(scene, state, frame)?;
        check_labels(scene)?;
        fits(frame, out.rows(), out.cols())?;
        out.fill(0);
        self.paint(scene, state, frame, |body, row, from, to| out.row_mut(row)[from..to].fill(body as u8 + 1));
        Ok(())
    }

    /// Height of what each pixel shows above the table, metres; 0 is the table. This is what an orthographic depth
    /// camera measures.
    pub fn heights(&mut self, scene: &Scene, state: &State, frame: &Frame, out: &mut ImageMut<f32>) -> Result<()> {
        check(scene, state, frame)?;
        fits(frame, out.rows(), out.cols())?;
        out.fill(0.0);
        self.paint(scene, state, frame, |body, row, from, to| {
            out.row_mut(row)[from..to].fill(scene.body(body).height as f32);
        });
        Ok(())
    }

    /// Labels and heights at once, as [`Rasteriser::labels`] and [`Rasteriser::heights`] paint them.
    pub fn labels_and_heights(
        &mut self,
        scene: &Scene,
        state: &State,
        frame: &Frame,
        labels: &mut ImageMut<u8>,
        heights: &mut ImageMut<f32>,
    ) -> Result<()> {
        check(scene, state, frame)?;
        check_labels(scene)?;
        fits(frame, labels.rows(), labels.cols())?;
        fits(frame, heights.rows(), heights.cols())?;
        labels.fill(0);
        heights.fill(0.0);
        self.paint(scene, state, frame, |body, row, from, to| {
            labels.row_mut(row)[from..to].fill(body as u8 + 1);
            heights.row_mut(row)[from..to].fill(scene.body(body).height as f32);
        });
        Ok(())
    }

    /// 1 where a pixel shows any body, else 0.
    pub fn foreground<T: Copy + From<u8>>(
        &mut self,
        scene: &Scene,
        state: &State,
        frame: &Frame,
        out: &mut ImageMut<T>,
    ) -> Result<()> {
        check(scene, state, frame)?;
        fits(frame, out.rows(), out.cols())?;
        out.fill(T::from(0));
        self.paint(scene, state, frame, |_, row, from, to| out.row_mut(row)[from..to].fill(T::from(1)));
        Ok(())
    }

    /// 1 where a pixel shows the body, else 0.
    pub fn mask<T: Copy + From<u8>>(
        &mut self,
        scene: &Scene,
        state: &State,
        body: usize,
        frame: &Frame,
        out: &mut ImageMut<T>,
    ) -> Result<()> {
        check(scene, state, frame)?;
        check_body(scene, body)?;
        fits(frame, out.rows(), out.cols())?;
        out.fill(T::from(0));
        self.paint(scene, state, frame, |painted, row, from, to| {
            out.row_mut(row)[from..to].fill(T::from(u8::from(painted == body)));
        });
        Ok(())
    }

    /// The masks of all bodies, a plane for each in the order of their indices (absent bodies have an empty one):
    /// `out[(body * rows + row) * cols + col]`.
    pub fn masks<T: Copy + From<u8>>(
        &mut self,
        scene: &Scene,
        state: &State,
        frame: &Frame,
        out: &mut [T],
    ) -> Result<()> {
        check(scene, state, frame)?;
        check_length(out.len(), scene.len(), frame)?;
        out.fill(T::from(0));
        let (plane, cols) = (frame.len(), frame.cols);
        // What was painted before under a span may belong to any of the bodies that are not higher.
        let mut painted = Mask::EMPTY;
        self.paint(scene, state, frame, |body, row, from, to| {
            let at = row * cols;
            for other in painted.iter().filter(|&other| other != body) {
                out[other * plane + at..][from..to].fill(T::from(0));
            }
            painted.insert(body);
            out[body * plane + at..][from..to].fill(T::from(1));
        });
        Ok(())
    }

    /// Two planes, the networks' view of a target: heights (metres), then 1 where a pixel shows the target.
    /// `out[(plane * rows + row) * cols + col]`.
    pub fn target_view(
        &mut self,
        scene: &Scene,
        state: &State,
        target: usize,
        frame: &Frame,
        out: &mut [f32],
    ) -> Result<()> {
        check(scene, state, frame)?;
        check_body(scene, target)?;
        check_length(out.len(), 2, frame)?;
        out.fill(0.0);
        let (heights, mask) = out.split_at_mut(frame.len());
        self.paint(scene, state, frame, |body, row, from, to| {
            let at = row * frame.cols;
            heights[at + from..at + to].fill(scene.body(body).height as f32);
            mask[at + from..at + to].fill(if body == target { 1.0 } else { 0.0 });
        });
        Ok(())
    }

    /// 1 where a pixel's centre lies in a footprint at a pose, whatever else is there; else 0.
    pub fn footprint<T: Copy + From<u8>>(
        &mut self,
        footprint: &Footprint,
        pose: &Pose2,
        frame: &Frame,
        out: &mut ImageMut<T>,
    ) -> Result<()> {
        frame.validate()?;
        if !pose.is_finite() {
            return Err(Error::argument("pose", "is not finite"));
        }
        fits(frame, out.rows(), out.cols())?;
        out.fill(T::from(0));
        self.spans_of(footprint, pose, frame, |row, from, to| out.row_mut(row)[from..to].fill(T::from(1)));
        Ok(())
    }

    /// Calls `span(body, row, from, to)` for the pixels from..to of each row of each piece, the body that shows last.
    fn paint(&mut self, scene: &Scene, state: &State, frame: &Frame, mut span: impl FnMut(usize, usize, usize, usize)) {
        let mut order = std::mem::take(&mut self.order);
        order.clear();
        order.extend(state.iter().map(|(body, _)| body));
        let height = |body: usize| scene.body(body).height;
        order.sort_unstable_by(|&a, &b| height(a).total_cmp(&height(b)).then(b.cmp(&a)));
        for &body in &order {
            let footprint = &scene.body(body).footprint;
            self.spans_of(footprint, &state.pose(body), frame, |row, from, to| span(body, row, from, to));
        }
        self.order = order;
    }

    /// Calls `span(row, from, to)` for the pixels from..to that lie in a piece of the footprint.
    fn spans_of(
        &mut self,
        footprint: &Footprint,
        pose: &Pose2,
        frame: &Frame,
        mut span: impl FnMut(usize, usize, usize),
    ) {
        // From the body's frame to pixels, whole numbers at the pixels' centres.
        let seen = frame.pose.inverse().compose(pose).frame();
        let scale = 1.0 / frame.pixel;
        let (rows, cols) = (frame.rows as f64, frame.cols as f64);
        let middle = Vec2::new(cols / 2.0 - 0.5, rows / 2.0 - 0.5);
        let away = seen.origin * scale + middle;
        let reach = footprint.radius * scale + 1.0;
        if away.x + reach < 0.0 || away.y + reach < 0.0 || away.x - reach > cols || away.y - reach > rows {
            return;
        }
        for piece in &footprint.pieces {
            match piece {
                Piece::Disc { centre, radius } => {
                    let c = seen.point(*centre) * scale + middle;
                    let r = radius * scale + ON_BORDER;
                    let Some((first, last)) = whole(c.y - r, c.y + r, frame.rows) else { continue };
                    for row in first..=last {
                        let dy = row as f64 - c.y;
                        let half = (r * r - dy * dy).max(0.0).sqrt();
                        if let Some((from, to)) = whole(c.x - half, c.x + half, frame.cols) {
                            span(row, from, to + 1);
                        }
                    }
                }
                Piece::Convex(points) => {
                    self.corners.clear();
                    self.corners.extend(points.iter().map(|&p| seen.point(p) * scale + middle));
                    self.convex(frame, &mut span);
                }
            }
        }
    }

    /// The spans of the convex polygon in `corners`.
    fn convex(&mut self, frame: &Frame, span: &mut impl FnMut(usize, usize, usize)) {
        let (low, high) = self
            .corners
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p.y), high.max(p.y)));
        let Some((first, last)) = whole(low - ON_BORDER, high + ON_BORDER, frame.rows) else { return };
        self.spans.clear();
        self.spans.resize(last - first + 1, [f64::INFINITY, f64::NEG_INFINITY]);
        let Some(mut p) = self.corners.last().copied() else { return };
        for &q in &self.corners {
            let (a, b) = if p.y <= q.y { (p, q) } else { (q, p) };
            if let Some((from, to)) = whole(a.y - ON_BORDER, b.y + ON_BORDER, frame.rows) {
                let slope = (b.x - a.x) / (b.y - a.y).max(f64::MIN_POSITIVE);
                let (left, right) = (a.x.min(b.x), a.x.max(b.x));
                // An edge along a row: the neighbours' ends are its ends.
                if b.y - a.y > ON_BORDER {
                    for row in from..=to {
                        let x = (a.x + (row as f64 - a.y) * slope).clamp(left, right);
                        let ends = &mut self.spans[row - first];
                        *ends = [ends[0].min(x), ends[1].max(x)];
                    }
                } else {
                    for row in from..=to {
                        let ends = &mut self.spans[row - first];
                        *ends = [ends[0].min(left), ends[1].max(right)];
                    }
                }
            }
            p = q;
        }
        for (row, ends) in self.spans.iter().enumerate() {
            if let Some((from, to)) = whole(ends[0] - ON_BORDER, ends[1] + ON_BORDER, frame.cols) {
                span(first + row, from, to + 1);
            }
        }
    }
}

/// The whole numbers of 0..count in [low, high], or none.
#[inline]
fn whole(low: f64, high: f64, count: usize) -> Option<(usize, usize)> {
    let first = low.ceil().max(0.0);
    let last = high.floor().min(count as f64 - 1.0);
    (first <= last).then_some((first as usize, last as usize))
}

fn check(scene: &Scene, state: &State, frame: &Frame) -> Result<()> {
    frame.validate()?;
    if state.len() != scene.len() {
        return Err(Error::argument(
            "state",
            format!("has {} poses for {} bodies; give one for each", state.len(), scene.len()),
        ));
    }
    match state.iter().find(|(_, pose)| !pose.is_finite()) {
        Some((body, _)) => Err(Error::argument(format!("state[{body}]"), "is not finite")),
        None => Ok(()),
    }
}

/// Refuses a scene whose bodies a label of a byte cannot tell apart.
fn check_labels(scene: &Scene) -> Result<()> {
    if scene.len() <= usize::from(u8::MAX) {
        return Ok(());
    }
    let reason = format!("has {} bodies; an image of labels tells {} apart", scene.len(), u8::MAX);
    Err(Error::argument("scene", reason))
}

fn check_body(scene: &Scene, body: usize) -> Result<()> {
    if body < scene.len() {
        return Ok(());
    }
    Err(Error::not_found("body", format!("there is no body {body}; the scene has {}", scene.len())))
}

fn fits(frame: &Frame, rows: usize, cols: usize) -> Result<()> {
    if (rows, cols) == (frame.rows, frame.cols) {
        return Ok(());
    }
    Err(Error::argument(
        "image",
        format!("has {rows} rows and {cols} columns; the frame has {} and {}", frame.rows, frame.cols),
    ))
}

fn check_length(length: usize, planes: usize, frame: &Frame) -> Result<()> {
    let needed = planes * frame.len();
    if length == needed {
        return Ok(());
    }
    Err(Error::argument(
        "image",
        format!("its buffer has {length} pixels; {planes} planes of {} by {} need {needed}", frame.rows, frame.cols),
    ))
}
