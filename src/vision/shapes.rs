//! Bodies from images: regions of a label image to footprints, heights and poses.

use super::image::Image;
use super::pixel_map::PixelMap;
use super::regions::{Region, RegionFinder};
use super::simplify::{Simple, simplify};
use crate::bounds;
use crate::error::{Error, Result, check_positive, check_range};
use crate::geom::{Footprint, Pose2, Shape, area_moments};
use crate::scene::{BodyDef, SceneBuilder};

/// What to do with a region that reaches the image's border: its body may go on beyond it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AtBorder {
    /// It becomes a body as far as it is seen.
    Keep,
    /// It is left out and reported.
    #[default]
    Skip,
    /// The image is refused.
    Refuse,
}

/// How bodies are made of regions.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeOptions {
    /// Greatest distance of the outline between the pixels from the simplified one, pixels. Below 0.75 the steps of the
    /// pixels themselves become corners.
    pub tolerance: f64,
    /// Smaller regions are left out and reported, square metres.
    pub min_area: f64,
    pub at_border: AtBorder,
    /// A round outline becomes a disc.
    pub discs: bool,
    /// A body's height is this quantile of the heights of its pixels, in (0, 1].
    pub height_quantile: f64,
    /// Mass, friction and flags of the bodies, and their height where there is no height image. Shape and name are
    /// replaced.
    pub body: BodyDef,
}

impl Default for ShapeOptions {
    fn default() -> Self {
        Self {
            tolerance: 1.0,
            min_area: 1e-4,
            at_border: AtBorder::default(),
            discs: true,
            height_quantile: 0.9,
            body: BodyDef::new(Shape::Disc { radius: 1.0 }),
        }
    }
}

/// A body that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundBody {
    /// Its label in the image.
    pub label: u32,
    /// Named "label N"; its frame has its origin at the centroid of the footprint.
    pub def: BodyDef,
    pub pose: Pose2,
    /// Distances of the outline between the pixels from the footprint's, in pixels: greatest and root mean square.
    pub deviation: [f64; 2],
    /// Pixels of holes, which were filled.
    pub hole_pixels: usize,
    /// Parts of the label that do not touch the body, which were dropped, and their pixels.
    pub dropped_parts: usize,
    pub dropped_pixels: usize,
    /// It reaches the image's border.
    pub at_border: bool,
}

/// Why a region became no body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SkipReason {
    /// Its area is less than [`ShapeOptions::min_area`].
    TooSmall,
    /// It reaches the image's border ([`AtBorder::Skip`]).
    AtBorder,
    /// None of its pixels has a height above the table.
    NoHeight,
    /// Its outline has no simple polygon within the tolerance.
    NoOutline,
}

/// A region that was left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SkippedRegion {
    pub label: u32,
    pub pixels: usize,
    pub reason: SkipReason,
}

/// What an image shows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shapes {
    /// By label.
    pub bodies: Vec<FoundBody>,
    pub skipped: Vec<SkippedRegion>,
}

impl Shapes {
    /// Adds the bodies to a scene and gives their poses in the order in which they were added.
    pub fn add_to(&self, builder: &mut SceneBuilder) -> Result<Vec<Pose2>> {
        for body in &self.bodies {
            builder.add_body(body.def.clone())?;
        }
        Ok(self.bodies.iter().map(|body| body.pose).collect())
    }
}

/// Makes bodies of images. Keeps its working memory.
#[derive(Debug, Default)]
pub struct ShapeFinder {
    finder: RegionFinder,
    heights: Vec<f32>,
}

impl ShapeOptions {
    pub fn validate(&self) -> Result<()> {
        check_range("tolerance", self.tolerance, 0.1..=100.0)?;
        check_range("min_area", self.min_area, 0.0..=1.0)?;
        check_range("height_quantile", self.height_quantile, 0.0..=1.0)?;
        check_positive("height_quantile", self.height_quantile)?;
        bounds::HEIGHT.check("body.height", self.body.height)?;
        bounds::MASS.check("body.mass", self.body.mass)?;
        bounds::FRICTION.check("body.friction", self.body.friction)
    }
}

impl ShapeFinder {
    pub fn new() -> Self {
        Self::default()
    }

    /// The bodies of a label image (0 is the table) and the image of heights above the table (metres; what is not
    /// finite or not above 0 is not known).
    pub fn labels(
        &mut self,
        labels: &Image<u8>,
        heights: Option<&Image<f32>>,
        map: &PixelMap,
        options: &ShapeOptions,
    ) -> Result<Shapes> {
        check(labels, heights, options)?;
        let mut shapes = Shapes::default();
        for region in self.finder.labels(labels, map)? {
            self.add(&region, labels, heights, options, &mut shapes)?;
        }
        Ok(shapes)
    }

    /// The bodies of a stack of masks: plane k, whose pixels are those that are not 0, becomes label k + 1. Planes may
    /// overlap.
    pub fn masks(
        &mut self,
        masks: &[Image<u8>],
        heights: Option<&Image<f32>>,
        map: &PixelMap,
        options: &ShapeOptions,
    ) -> Result<Shapes> {
        let mut shapes = Shapes::default();
        for (index, mask) in masks.iter().enumerate() {
            check(mask, heights, options).map_err(|e| e.within(&format!("masks[{index}]")))?;
            if let Some(mut region) = self.finder.mask(mask, map)? {
                region.label = index as u32 + 1;
                self.add(&region, mask, heights, options, &mut shapes)?;
            }
        }
        Ok(shapes)
    }

    fn add(
        &mut self,
        region: &Region,
        image: &Image<u8>,
        heights: Option<&Image<f32>>,
        options: &ShapeOptions,
        shapes: &mut Shapes,
    ) -> Result<()> {
        let mut skip = |reason| {
            shapes.skipped.push(SkippedRegion { label: region.label, pixels: region.pixels, reason });
            Ok(())
        };
        if region.area < options.min_area {
            return skip(SkipReason::TooSmall);
        }
        if region.at_border && options.at_border != AtBorder::Keep {
            if options.at_border == AtBorder::Refuse {
                return Err(Error::argument(
                    format!("labels[{}]", region.label),
                    "reaches the image's border; show the whole body, or keep or skip such regions",
                ));
            }
            return skip(SkipReason::AtBorder);
        }
        let height = match heights {
            None => options.body.height,
            Some(heights) => match self.height(region, image, heights, options.height_quantile) {
                Some(height) => height,
                None => return skip(SkipReason::NoHeight),
            },
        };
        if bounds::HEIGHT.check("height", height).is_err() {
            return skip(SkipReason::NoHeight);
        }
        let outline = region.outline();
        let tolerance = options.tolerance * region.pixel;
        let simple = simplify(&outline, region.centroid, region.area, tolerance, options.discs);
        let Some((simple, off)) = simple else { return skip(SkipReason::NoOutline) };
        let (shape, centre) = match simple {
            Simple::Disc { centre, radius } => (Shape::Disc { radius }, centre),
            Simple::Polygon(corners) => {
                let (_, centre, _) = area_moments(&corners);
                (Shape::Polygon(corners.iter().map(|p| [p.x - centre.x, p.y - centre.y]).collect()), centre)
            }
        };
        if Footprint::new(shape.clone()).is_err() {
            return skip(SkipReason::NoOutline);
        }
        let mut def = BodyDef { shape, height, ..options.body.clone() };
        def.name = format!("label {}", region.label);
        shapes.bodies.push(FoundBody {
            label: region.label,
            def,
            pose: Pose2::at(centre, 0.0),
            deviation: [off.greatest / region.pixel, off.rms / region.pixel],
            hole_pixels: region.hole_pixels,
            dropped_parts: region.dropped_parts,
            dropped_pixels: region.dropped_pixels,
            at_border: region.at_border,
        });
        Ok(())
    }

    fn height(&mut self, region: &Region, image: &Image<u8>, heights: &Image<f32>, quantile: f64) -> Option<f64> {
        self.heights.clear();
        let seen = &mut self.heights;
        self.finder.pixels_of(region, image.cols(), |row, col| {
            let height = heights.row(row)[col];
            if height.is_finite() && height > 0.0 {
                seen.push(height);
            }
        });
        let last = self.heights.len().checked_sub(1)?;
        let at = (quantile * last as f64).round() as usize;
        let (_, height, _) = self.heights.select_nth_unstable_by(at.min(last), f32::total_cmp);
        Some(f64::from(*height))
    }
}

fn check(labels: &Image<u8>, heights: Option<&Image<f32>>, options: &ShapeOptions) -> Result<()> {
    options.validate()?;
    let size = (labels.rows(), labels.cols());
    match heights {
        Some(heights) if (heights.rows(), heights.cols()) != size => Err(Error::argument(
            "heights",
            format!(
                "has {} rows and {} columns; the labels have {} and {}",
                heights.rows(),
                heights.cols(),
                size.0,
                size.1
            ),
        )),
        _ if size.0.saturating_mul(size.1) > u32::MAX as usize => {
            Err(Error::argument("labels", "has more than 2^32 pixels"))
        }
        _ => Ok(()),
    }
}
