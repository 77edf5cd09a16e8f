//! What is kept of planning for people to look at.

mod drawing;
mod svg;
mod xml;

pub use svg::{Labels, SvgPicture};
