//! Images of a [`State`](crate::scene::State) as an orthographic camera above the table sees it.
//!
//! A [`Frame`] says where the image lies and how large its pixels are; the [`Rasteriser`] paints labels, heights and
//! masks into the caller's buffers.

mod frame;
mod image;
mod raster;
#[cfg(test)]
mod raster_tests;

pub use frame::{Frame, MAX_SIDE, centre_of};
pub use image::{Image, ImageMut};
pub use raster::Rasteriser;
