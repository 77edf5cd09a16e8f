//! Images of a [`State`](crate::scene::State) as an orthographic camera above the table sees it.
//!
//! A [`Frame`] says where the image lies and how large its pixels are; the [`Rasteriser`] paints labels, heights and
//! masks into the caller's buffers.
//!
//! The other way round, a [`ShapeFinder`] makes bodies of a label image and a height image, and a [`Matcher`] finds the
//! poses of bodies that are known. `docs/images.md` says how well.

mod assign;
mod frame;
mod image;
mod matching;
#[cfg(test)]
mod matching_tests;
mod pixel_map;
mod raster;
#[cfg(test)]
mod raster_tests;
mod regions;
mod shapes;
#[cfg(test)]
mod shapes_tests;
mod simplify;
#[cfg(test)]
mod testing;

pub use frame::{Frame, MAX_SIDE, centre_of};
pub use image::{Image, ImageMut};
pub use matching::{Match, MatchOptions, Matcher};
pub use pixel_map::PixelMap;
pub use raster::Rasteriser;
pub use regions::{Crossing, Region, RegionFinder};
pub use shapes::{AtBorder, FoundBody, ShapeFinder, ShapeOptions, Shapes, SkipReason, SkippedRegion};
