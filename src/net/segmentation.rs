//! Instances in an image, as labels that [`crate::vision::ShapeFinder`] makes bodies of.
//!
//! A network of interface 1 says for every pixel of a height image whether an object is there, whether it is the middle of
//! one, and which way the middle of its own lies. The middles are the local maxima; a pixel belongs to the middle that it
//! points to. A network of interface 2 (torchvision's Mask R-CNN) gives a mask for each instance.

use super::kind::Kind;
use super::model::Model;
use crate::error::{Error, ModelFault, Result};

/// How pixels become instances.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentOptions {
    /// Probability from which on a pixel belongs to an object.
    pub foreground: f32,
    /// Heat from which on a local maximum is a middle; score from which on an instance counts.
    pub score: f32,
    /// A middle is the greatest within so many pixels.
    pub radius: usize,
    /// Instances of fewer pixels are dropped.
    pub least_pixels: usize,
}

impl Default for SegmentOptions {
    fn default() -> Self {
        Self { foreground: 0.5, score: 0.3, radius: 4, least_pixels: 20 }
    }
}

/// What was found.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Instances {
    /// 0 where nothing is, else the instance's number from 1 on.
    pub labels: Vec<u8>,
    /// Of each instance in [0, 1], the best first.
    pub scores: Vec<f32>,
}

/// Most instances: labels are bytes.
const MOST: usize = 254;

/// A network of kind `segmentation`.
#[derive(Debug, Clone)]
pub struct Segmentation {
    model: Model,
    options: SegmentOptions,
}

impl Segmentation {
    /// Refuses a network of another kind.
    pub fn new(model: Model, options: SegmentOptions) -> Result<Segmentation> {
        model.expect(Kind::Segmentation)?;
        Ok(Segmentation { model, options })
    }

    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Segments an image of `rows * cols` pixels: heights in metres (interface 1), or three planes of colours in [0, 1]
    /// (interface 2).
    pub fn segment(&self, image: &[f32], rows: usize, cols: usize) -> Result<Instances> {
        let info = self.model.info();
        let torchvision = info.interface.number == 2;
        let wanted = rows * cols * if torchvision { 3 } else { 1 };
        if image.len() != wanted || wanted == 0 {
            return Err(Error::argument("image", format!("has {} values; {wanted} are needed", image.len())));
        }
        if torchvision {
            return self.masks(image, rows, cols);
        }
        let side = info.side.unwrap_or(0);
        if (rows, cols) != (side, side) {
            let reason = format!("has {rows} rows and {cols} columns; the network takes {side} of each");
            return Err(Error::argument("image", reason));
        }
        let mut outputs = vec![Vec::new(); 3];
        self.model.run(1, 1, &[image], &mut outputs)?;
        Ok(group(&outputs[0], &outputs[1], &outputs[2], side, info.pixel() as f32, &self.options))
    }

    fn masks(&self, image: &[f32], rows: usize, cols: usize) -> Result<Instances> {
        let results = self.model.run_free(&[("image", vec![3, rows as i64, cols as i64], image)])?;
        let [_, _, (_, scores), (shape, masks)] = results.as_slice() else {
            return Err(Error::Internal("an interface has four outputs and gave others".into()));
        };
        let plane = rows * cols;
        if masks.len() != scores.len() * plane {
            let expected = format!("{} masks of {rows} x {cols}", scores.len());
            return Err(Error::model(&self.model.info().path, ModelFault::Run, expected, format!("shape {shape:?}")));
        }
        let mut order: Vec<usize> = (0..scores.len()).filter(|&i| scores[i] >= self.options.score).collect();
        order.sort_by(|&a, &b| scores[b].total_cmp(&scores[a]).then(a.cmp(&b)));
        order.truncate(MOST);
        let mut labels = vec![0; plane];
        // The best last, so that it keeps what others claim as well.
        for (rank, &i) in order.iter().enumerate().rev() {
            for (label, mask) in labels.iter_mut().zip(&masks[i * plane..(i + 1) * plane]) {
                if *mask >= self.options.foreground {
                    *label = rank as u8 + 1;
                }
            }
        }
        Ok(kept(labels, order.iter().map(|&i| scores[i]).collect(), self.options.least_pixels))
    }
}

/// Groups the pixels of interface 1. `offset` has the way to the middle, metres: all x, then all y.
fn group(
    foreground: &[f32],
    heat: &[f32],
    offset: &[f32],
    side: usize,
    pixel: f32,
    options: &SegmentOptions,
) -> Instances {
    let at = |row: usize, col: usize| row * side + col;
    let reach = options.radius;
    let mut middles: Vec<(f32, usize, usize)> = Vec::new();
    for row in 0..side {
        for col in 0..side {
            let own = heat[at(row, col)];
            if own < options.score || foreground[at(row, col)] < options.foreground {
                continue;
            }
            let rows = row.saturating_sub(reach)..(row + reach + 1).min(side);
            let greatest = rows.into_iter().all(|r| {
                (col.saturating_sub(reach)..(col + reach + 1).min(side)).all(|c| {
                    let other = heat[at(r, c)];
                    // Of equals the first.
                    other < own || (other == own && (r, c) >= (row, col))
                })
            });
            if greatest {
                middles.push((own, row, col));
            }
        }
    }
    middles.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    middles.truncate(MOST);
    let mut labels = vec![0; side * side];
    let plane = side * side;
    for row in 0..side {
        for col in 0..side {
            let i = at(row, col);
            if foreground[i] < options.foreground {
                continue;
            }
            let (x, y) = (col as f32 + offset[i] / pixel, row as f32 + offset[plane + i] / pixel);
            let distance = |m: &(f32, usize, usize)| (x - m.2 as f32).powi(2) + (y - m.1 as f32).powi(2);
            let nearest = middles.iter().enumerate().min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
            labels[i] = nearest.map_or(0, |(k, _)| k as u8 + 1);
        }
    }
    kept(labels, middles.iter().map(|m| m.0).collect(), options.least_pixels)
}

/// Drops instances that are too small, and numbers the others anew in their order.
fn kept(mut labels: Vec<u8>, scores: Vec<f32>, least: usize) -> Instances {
    let mut counts = [0_usize; 256];
    for label in &labels {
        counts[usize::from(*label)] += 1;
    }
    let mut new = [0_u8; 256];
    let mut remaining = Vec::new();
    for (k, score) in scores.iter().enumerate() {
        if counts[k + 1] >= least.max(1) {
            remaining.push(*score);
            new[k + 1] = remaining.len() as u8;
        }
    }
    for label in &mut labels {
        *label = new[usize::from(*label)];
    }
    Instances { labels, scores: remaining }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_go_to_the_middle_that_they_point_to() {
        let side = 24;
        let plane = side * side;
        let (mut foreground, mut heat, mut offset) = (vec![0.0; plane], vec![0.0; plane], vec![0.0; 2 * plane]);
        // Two blocks that touch, with their middles at columns 6 and 17.
        for row in 8..16 {
            for col in 1..23 {
                let i = row * side + col;
                let (middle, strength) = if col < 12 { (6, 0.9) } else { (17, 0.6) };
                foreground[i] = 1.0;
                offset[i] = (middle as f32 - col as f32) * 0.002;
                offset[plane + i] = (12.0 - row as f32) * 0.002;
                heat[i] = strength - 0.05 * ((col as f32 - middle as f32).abs() + (row as f32 - 12.0).abs());
            }
        }
        // A speck that is an instance of its own, and too small.
        foreground[0] = 1.0;
        heat[0] = 1.0;
        let found = group(&foreground, &heat, &offset, side, 0.002, &SegmentOptions::default());
        assert_eq!(found.scores, [0.9, 0.6]);
        assert_eq!(found.labels[12 * side + 11], 1);
        assert_eq!(found.labels[12 * side + 12], 2);
        assert_eq!(found.labels[0], 0);
        assert_eq!(found.labels.iter().filter(|l| **l == 1).count(), 11 * 8);
    }
}
