//! What is kept of planning for people to look at.

mod drawing;
mod explain;
mod rearrange_svg;
mod svg;
mod xml;

pub use explain::explanation;
pub use rearrange_svg::{rearrangement_animation, rearrangement_svg};
pub use svg::{Labels, SvgPicture};
