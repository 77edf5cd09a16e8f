//! Instances in an image, as labels that [`crate::vision::ShapeFinder`] makes bodies of.
//!
//! A network of interface 1 says for every pixel of a height image whether an object is there and which way the middle of
//! its own lies. Every pixel of an object votes for the place that it points to; the middles are where the votes gather
//! (Hough voting), and a pixel belongs to the middle next to its vote. The network's own heat of the middles is not asked:
//! many pixels together know a middle better than the pixel on it does. A network of interface 2 (torchvision's Mask R-CNN)
//! gives a mask for each instance.

use super::kind::Kind;
use super::model::Model;
use crate::error::{Error, ModelFault, Result};

/// How pixels become instances.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentOptions {
    /// Probability from which on a pixel belongs to an object.
    pub foreground: f32,
    /// Score from which on an instance counts. In interface 1 the part of its pixels that point to within `radius` of its
    /// middle.
    pub score: f32,
    /// A middle has the most votes within so many pixels.
    pub radius: usize,
    /// Instances of fewer pixels are dropped.
    pub least_pixels: usize,
}

impl Default for SegmentOptions {
    fn default() -> Self {
        Self { foreground: 0.5, score: 0.3, radius: 6, least_pixels: 20 }
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
/// Standard deviation, in pixels, of the Gaussian that votes are spread by, and how far it is followed.
const SPREAD: f32 = 2.0;
const REACH: usize = 6;
/// Spread votes for a pixel from which on it may be a middle: about what 35 pixels give that point within two of it.
const VOTES: f32 = 1.0;

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
        Ok(group(&outputs[0], &outputs[2], side, info.pixel() as f32, &self.options))
    }

    fn masks(&self, image: &[f32], rows: usize, cols: usize) -> Result<Instances> {
        let results = self.model.run_free(&[("image", vec![3, rows as i64, cols as i64], image)], None)?;
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
fn group(foreground: &[f32], offset: &[f32], side: usize, pixel: f32, options: &SegmentOptions) -> Instances {
    let plane = side * side;
    // Where a pixel points to: column and row.
    let aim = |i: usize| {
        let (x, y) = ((i % side) as f32 + offset[i] / pixel, (i / side) as f32 + offset[plane + i] / pixel);
        let most = (side - 1) as f32;
        (x.clamp(0.0, most), y.clamp(0.0, most))
    };
    let there: Vec<usize> = (0..plane).filter(|&i| foreground[i] >= options.foreground).collect();
    let mut votes = vec![0.0; plane];
    for &i in &there {
        let (x, y) = aim(i);
        votes[y.round() as usize * side + x.round() as usize] += 1.0;
    }
    let votes = spread(&spread(&votes, side), side);
    let mut middles: Vec<(f32, usize, usize)> = Vec::new();
    for (i, &own) in votes.iter().enumerate().filter(|vote| *vote.1 >= VOTES) {
        let (row, col) = (i / side, i % side);
        let near = |at: usize| at.saturating_sub(options.radius)..(at + options.radius + 1).min(side);
        let greatest = near(row).all(|r| {
            near(col).all(|c| {
                let other = votes[r * side + c];
                // Of equals the first.
                other < own || (other == own && (r, c) >= (row, col))
            })
        });
        if greatest {
            middles.push((own, row, col));
        }
    }
    middles.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    middles.truncate(MOST);
    let mut labels = vec![0; plane];
    // Of each middle: its pixels, and those of them that point to near it.
    let mut counts = vec![(0_u32, 0_u32); middles.len()];
    let near = (options.radius * options.radius) as f32;
    for &i in &there {
        let (x, y) = aim(i);
        let distance = |m: &(f32, usize, usize)| (x - m.2 as f32).powi(2) + (y - m.1 as f32).powi(2);
        let nearest = middles.iter().map(distance).enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((k, far)) = nearest {
            labels[i] = k as u8 + 1;
            counts[k].0 += 1;
            counts[k].1 += u32::from(far <= near);
        }
    }
    let scores: Vec<f32> = counts.iter().map(|&(all, close)| close as f32 / all.max(1) as f32).collect();
    // The best first; what scores too little goes.
    let mut order: Vec<usize> = (0..scores.len()).filter(|&k| scores[k] >= options.score).collect();
    order.sort_by(|&a, &b| scores[b].total_cmp(&scores[a]).then(a.cmp(&b)));
    let mut new = [0_u8; 256];
    for (rank, &k) in order.iter().enumerate() {
        new[k + 1] = rank as u8 + 1;
    }
    for label in &mut labels {
        *label = new[usize::from(*label)];
    }
    kept(labels, order.iter().map(|&k| scores[k]).collect(), options.least_pixels)
}

/// Spreads along the columns of each row by a Gaussian, and transposes: twice gives the image again, spread both ways.
fn spread(image: &[f32], side: usize) -> Vec<f32> {
    let mut weights: Vec<f32> = (0..=2 * REACH)
        .map(|k| {
            let far = k as f32 - REACH as f32;
            (-far * far / (2.0 * SPREAD * SPREAD)).exp()
        })
        .collect();
    let sum: f32 = weights.iter().sum();
    for weight in &mut weights {
        *weight /= sum;
    }
    let mut out = vec![0.0; image.len()];
    for (row, line) in image.chunks(side).enumerate() {
        for (col, &value) in line.iter().enumerate().filter(|pixel| *pixel.1 > 0.0) {
            for (k, weight) in weights.iter().enumerate() {
                let at = (col + k).wrapping_sub(REACH);
                if at < side {
                    out[at * side + row] += value * weight;
                }
            }
        }
    }
    out
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
        let (mut foreground, mut offset) = (vec![0.0; plane], vec![0.0; 2 * plane]);
        // Two blocks that touch, with their middles at columns 5 and 17. Of the second some pixels point elsewhere.
        for row in 8..16 {
            for col in 1..23 {
                let i = row * side + col;
                let middle = if col < 12 { 5 } else { 17 };
                foreground[i] = 1.0;
                offset[i] = (middle as f32 - col as f32) * 0.002;
                offset[plane + i] = (12.0 - row as f32) * 0.002;
                if col == 22 {
                    offset[plane + i] = -1.0;
                }
            }
        }
        // A speck that has too few votes to be one of its own goes to the next.
        foreground[0] = 1.0;
        let found = group(&foreground, &offset, side, 0.002, &SegmentOptions::default());
        assert_eq!(found.scores, [88.0 / 89.0, 80.0 / 88.0]);
        assert_eq!(found.labels[12 * side + 11], 1);
        assert_eq!(found.labels[12 * side + 12], 2);
        assert_eq!(found.labels.iter().filter(|l| **l == 1).count(), 89);
        // Nothing there, nothing found.
        foreground.fill(0.0);
        assert_eq!(group(&foreground, &offset, side, 0.002, &SegmentOptions::default()).scores, [0.0f32; 0]);
    }

    #[test]
    fn spreading_twice_keeps_the_sum_and_the_place() {
        let side = 40;
        let mut image = vec![0.0; side * side];
        image[12 * side + 25] = 3.0;
        let out = spread(&spread(&image, side), side);
        assert!((out.iter().sum::<f32>() - 3.0).abs() < 1e-4);
        let greatest = (0..out.len()).max_by(|&a, &b| out[a].total_cmp(&out[b]));
        assert_eq!(greatest, Some(12 * side + 25));
        assert!((out[12 * side + 25] - 3.0 / (std::f32::consts::TAU * 4.0)).abs() < 2e-3);
    }
}
