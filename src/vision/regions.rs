//! Regions of a label image: connected pixels of one label, and their outlines between the pixels.

use super::image::Image;
use super::pixel_map::PixelMap;
use crate::error::{Result, reserve};
use crate::geom::{Vec2, area_moments};

/// Width of the band of pixels on either side of a border.
const BAND: i64 = 2;

/// One crossing of a region's border between two neighbouring pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Centre of the pixel that belongs to the region, world frame.
    pub inside: Vec2,
    /// Centre of its neighbour that does not.
    pub outside: Vec2,
}

impl Crossing {
    /// The place between the two centres. The border crosses there, give or take half a pixel, without bias.
    #[inline]
    pub fn middle(&self) -> Vec2 {
        (self.inside + self.outside) * 0.5
    }
}

/// The largest connected part of a label, without its holes.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// The pixels' value; of a stack of masks, the plane's number + 1.
    pub label: u32,
    /// Number of pixels.
    pub pixels: usize,
    /// Number of pixels of its holes.
    pub hole_pixels: usize,
    /// Further connected parts of the label, which were dropped.
    pub dropped_parts: usize,
    /// Number of pixels of these.
    pub dropped_pixels: usize,
    /// It reaches the image's border, beyond which it may go on.
    pub at_border: bool,
    /// Its outer border, counter-clockwise in the world frame.
    pub border: Vec<Crossing>,
    /// All pixels of the image within [`BAND`] rows and columns of the border, and whether they have the label.
    pub(super) band: Vec<(Vec2, bool)>,
    /// With its holes filled, square metres.
    pub area: f64,
    /// Centroid of that area, world frame.
    pub centroid: Vec2,
    /// Side of a pixel, metres.
    pub pixel: f64,
    /// Its number in the map of parts, and its first and last row.
    pub(super) part: usize,
    pub(super) rows: [usize; 2],
}

/// Finds regions. Keeps its working memory.
#[derive(Debug, Default)]
pub struct RegionFinder {
    /// For each pixel the number of its connected part, 0 for the background.
    parts: Vec<u32>,
    /// The part whose band a pixel was put into last.
    marks: Vec<u32>,
    stack: Vec<u32>,
    middles: Vec<Vec2>,
    /// Column and row of the pixels inside the border that is being followed.
    beside: Vec<(i64, i64)>,
}

struct Part {
    label: u32,
    pixels: usize,
    first: usize,
    last_row: usize,
    at_border: bool,
}

impl RegionFinder {
    pub fn new() -> Self {
        Self::default()
    }

    /// The regions of a label image, 0 being the background; by label.
    pub fn labels(&mut self, image: &Image<u8>, map: &PixelMap) -> Result<Vec<Region>> {
        map.validate()?;
        let mut regions = self.find(image, map, u32::from)?;
        regions.sort_by_key(|region| region.label);
        Ok(regions)
    }

    /// The region of a mask, whose pixels are those that are not 0; none where all are.
    pub fn mask(&mut self, image: &Image<u8>, map: &PixelMap) -> Result<Option<Region>> {
        map.validate()?;
        Ok(self.find(image, map, |value| u32::from(value != 0))?.pop())
    }

    /// Calls `visit(row, col)` for the pixels of a region of the image that was searched last.
    pub(super) fn pixels_of(&self, region: &Region, cols: usize, mut visit: impl FnMut(usize, usize)) {
        for row in region.rows[0]..=region.rows[1] {
            for (col, &part) in self.parts[row * cols..][..cols].iter().enumerate() {
                if part as usize == region.part {
                    visit(row, col);
                }
            }
        }
    }

    fn find(&mut self, image: &Image<u8>, map: &PixelMap, label_of: impl Fn(u8) -> u32) -> Result<Vec<Region>> {
        let (rows, cols) = (image.rows(), image.cols());
        self.parts.clear();
        reserve(&mut self.parts, rows * cols, "image")?;
        self.parts.resize(rows * cols, 0);
        self.marks.clear();
        reserve(&mut self.marks, rows * cols, "image")?;
        self.marks.resize(rows * cols, 0);
        let mut parts: Vec<Part> = Vec::new();
        for row in 0..rows {
            for (col, &value) in image.row(row).iter().enumerate() {
                let label = label_of(value);
                if label == 0 || self.parts[row * cols + col] != 0 {
                    continue;
                }
                let mut part = Part { label, pixels: 0, first: row * cols + col, last_row: row, at_border: false };
                self.flood(image, &label_of, &mut part, parts.len() as u32 + 1);
                parts.push(part);
            }
        }
        let mut regions: Vec<Region> = Vec::new();
        let mut order: Vec<usize> = (0..parts.len()).collect();
        order.sort_by_key(|&i| (parts[i].label, std::cmp::Reverse(parts[i].pixels), i));
        for index in order {
            let part = &parts[index];
            match regions.last_mut() {
                Some(last) if last.label == part.label => {
                    last.dropped_parts += 1;
                    last.dropped_pixels += part.pixels;
                }
                _ => {
                    let mut region = self.trace(part, index + 1, rows, cols, map);
                    self.band(image, &label_of, map, &mut region);
                    regions.push(region);
                }
            }
        }
        Ok(regions)
    }

    /// Marks the connected part that begins at `part.first`; pixels that share a side are connected.
    fn flood(&mut self, image: &Image<u8>, label_of: &impl Fn(u8) -> u32, part: &mut Part, number: u32) {
        let (rows, cols) = (image.rows(), image.cols());
        self.stack.clear();
        self.stack.push(part.first as u32);
        self.parts[part.first] = number;
        while let Some(index) = self.stack.pop() {
            let (row, col) = (index as usize / cols, index as usize % cols);
            part.pixels += 1;
            part.last_row = part.last_row.max(row);
            part.at_border |= row == 0 || col == 0 || row + 1 == rows || col + 1 == cols;
            let mut visit = |row: usize, col: usize| {
                let at = row * cols + col;
                if self.parts[at] == 0 && label_of(image.row(row)[col]) == part.label {
                    self.parts[at] = number;
                    self.stack.push(at as u32);
                }
            };
            if row > 0 {
                visit(row - 1, col);
            }
            if row + 1 < rows {
                visit(row + 1, col);
            }
            if col > 0 {
                visit(row, col - 1);
            }
            if col + 1 < cols {
                visit(row, col + 1);
            }
        }
    }

    /// Collects the pixels about the border, in the order of the border.
    fn band(&mut self, image: &Image<u8>, label_of: &impl Fn(u8) -> u32, map: &PixelMap, region: &mut Region) {
        let (rows, cols) = (image.rows() as i64, image.cols() as i64);
        for &(x, y) in &self.beside {
            for row in (y - BAND).max(0)..(y + BAND + 1).min(rows) {
                let line = image.row(row as usize);
                for col in (x - BAND).max(0)..(x + BAND + 1).min(cols) {
                    let mark = &mut self.marks[(row * cols + col) as usize];
                    if *mark != region.part as u32 {
                        *mark = region.part as u32;
                        let inside = label_of(line[col as usize]) == region.label;
                        region.band.push((map.point(row as f64, col as f64), inside));
                    }
                }
            }
        }
    }

    /// Follows the outer border along the sides of the pixels, the region on the left (in columns and rows).
    fn trace(&mut self, part: &Part, number: usize, rows: usize, cols: usize, map: &PixelMap) -> Region {
        const STEPS: [(i64, i64); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];
        let belongs = |col: i64, row: i64| {
            let there = col >= 0 && row >= 0 && col < cols as i64 && row < rows as i64;
            there && self.parts[row as usize * cols + col as usize] as usize == number
        };
        // Of a corner of pixels, the pixel to the left and to the right ahead.
        let ahead = |x: i64, y: i64, heading: usize| match heading {
            0 => ((x, y), (x, y - 1)),
            1 => ((x - 1, y), (x, y)),
            2 => ((x - 1, y - 1), (x - 1, y)),
            _ => ((x, y - 1), (x - 1, y - 1)),
        };
        let start = ((part.first % cols) as i64, (part.first / cols) as i64);
        let (mut x, mut y, mut heading) = (start.0, start.1, 0);
        let mut border = Vec::new();
        self.beside.clear();
        loop {
            let (inside, outside) = ahead(x, y, heading);
            let centre = |(col, row): (i64, i64)| map.point(row as f64, col as f64);
            border.push(Crossing { inside: centre(inside), outside: centre(outside) });
            self.beside.push(inside);
            x += STEPS[heading].0;
            y += STEPS[heading].1;
            let (left, right) = ahead(x, y, heading);
            if !belongs(left.0, left.1) {
                heading = (heading + 1) % 4;
            } else if belongs(right.0, right.1) {
                heading = (heading + 3) % 4;
            }
            if (x, y) == start && heading == 0 {
                break;
            }
        }
        if map.determinant() < 0.0 {
            border.reverse();
        }
        self.middles.clear();
        self.middles.extend(border.iter().map(Crossing::middle));
        let pixel = map.pixel();
        let (cut, centroid) = match self.middles.len() {
            0..=4 => (0.0, self.middles.iter().sum::<Vec2>() / self.middles.len().max(1) as f64),
            _ => {
                let (area, centroid, _) = area_moments(&self.middles);
                (area, centroid)
            }
        };
        // The line through the middles cuts an eighth of a pixel at every turn; there are four more to the left.
        let area = if cut > 0.0 { cut + 0.5 * pixel * pixel } else { part.pixels as f64 * pixel * pixel };
        let filled = (area / (pixel * pixel)).round() as usize;
        Region {
            label: part.label,
            pixels: part.pixels,
            hole_pixels: filled.saturating_sub(part.pixels),
            dropped_parts: 0,
            dropped_pixels: 0,
            at_border: part.at_border,
            border,
            band: Vec::new(),
            area,
            centroid,
            pixel,
            part: number,
            rows: [part.first / cols, part.last_row],
        }
    }
}

impl Region {
    /// The outline between the pixels, counter-clockwise, world frame.
    pub fn outline(&self) -> Vec<Vec2> {
        self.border.iter().map(Crossing::middle).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::Frame;
    use super::*;
    use crate::geom::{Pose2, vec2};

    fn read(text: &str) -> (Vec<u8>, usize, usize) {
        let lines: Vec<&str> = text.split_whitespace().collect();
        let data = lines.iter().flat_map(|l| l.bytes().map(|b| if b == b'.' { 0 } else { b - b'0' })).collect();
        (data, lines.len(), lines[0].len())
    }

    fn find(text: &str, map: &PixelMap) -> Vec<Region> {
        let (data, rows, cols) = read(text);
        RegionFinder::new().labels(&Image::packed(&data, rows, cols).unwrap(), map).unwrap()
    }

    const UNIT: PixelMap = PixelMap { x: [1.0, 0.0, 0.0], y: [0.0, 1.0, 0.0] };

    #[test]
    fn the_largest_part_of_each_label_is_kept_and_the_rest_reported() {
        let regions = find("....... .22.1.. .22..1. .....11 33..... 3.3....", &UNIT);
        let seen: Vec<_> = regions
            .iter()
            .map(|r| (r.label, r.pixels, r.dropped_parts, r.dropped_pixels, r.at_border, r.hole_pixels))
            .collect();
        assert_eq!(seen, [(1, 3, 1, 1, true, 0), (2, 4, 0, 0, false, 0), (3, 3, 1, 1, true, 0)]);
        assert_eq!((regions[1].area, regions[1].centroid), (4.0, vec2(1.5, 1.5)));
        assert_eq!(regions[1].border.len(), 8);
    }

    #[test]
    fn holes_are_counted_and_filled() {
        let regions = find("11111 1..11 1.111 11111", &UNIT);
        assert_eq!((regions[0].pixels, regions[0].hole_pixels, regions[0].border.len()), (17, 3, 18));
        assert_eq!(regions[0].area, 20.0);
    }

    #[test]
    fn a_single_pixel_has_its_area_and_place() {
        let regions = find("... .1. ...", &UNIT);
        assert_eq!((regions[0].area, regions[0].centroid), (1.0, vec2(1.0, 1.0)));
    }

    #[test]
    fn a_mirrored_camera_sees_the_same_outline_the_right_way_round() {
        let frame = Frame::new(Pose2::new(0.4, 0.1, 0.5), 0.002, 5, 6);
        let there = PixelMap::from(&frame);
        // The same picture with its rows from top to bottom.
        let flipped = PixelMap {
            x: [there.x[0], -there.x[1], there.x[2] + 4.0 * there.x[1]],
            y: [there.y[0], -there.y[1], there.y[2] + 4.0 * there.y[1]],
        };
        let a = find("...... .111.. .1.... .1.... ......", &there);
        let b = find("...... .1.... .1.... .111.. ......", &flipped);
        assert!((a[0].centroid - b[0].centroid).norm() < 1e-12 && (a[0].area - b[0].area).abs() < 1e-15);
        assert!((a[0].area - 5.0 * 4e-6).abs() < 1e-12, "{}", a[0].area);
        assert!(crate::geom::area(&b[0].outline()) > 0.0 && crate::geom::area(&a[0].outline()) > 0.0);
    }

    #[test]
    fn a_map_that_is_no_plane_is_refused() {
        for map in [
            PixelMap { x: [1.0, 1.0, 0.0], y: [1.0, 1.0, 0.0] },
            PixelMap { x: [0.0; 3], y: [0.0; 3] },
            PixelMap { x: [f64::NAN, 0.0, 0.0], y: [0.0, 1.0, 0.0] },
            PixelMap { x: [5.0, 0.0, 0.0], y: [0.0, 1.0, 0.0] },
        ] {
            assert!(map.validate().is_err(), "{map:?}");
        }
    }
}
