//! Contact between convex pieces in the plane, in single precision: separating axes with eight edges in a register,
//! and manifolds of one or two points.
//!
//! A piece is kept once in its body's frame ([`Outline`]) and placed in the world whenever its body has moved
//! ([`Placed`]). [`contact`] answers for two placed pieces.

mod manifold;
mod outline;

pub use manifold::{Manifold, Point, contact};
pub use outline::{Frame2, Octet, Outline, Placed};
