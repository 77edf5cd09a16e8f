//! Which pushes are worth trying in a state.
//!
//! One mechanism, [`ContourSampler`], with the parameters of named presets:
//!
//! | | `vft` | `more` | `pmbs` | `dense` |
//! |---|---|---|---|---|
//! | directions of a body | 4 axes, contour points > 0.3 rad off them | 4 axes, contour points > 0.75 rad off accepted pushes | 4 axes, 4 diagonals | 4 axes, 4 diagonals, up to 4 corners |
//! | stand-off, mm | 24 | 20 | 18 | 20 |
//! | length, mm | 74 | 100 | 50 | 100 |
//! | start inside, mm | 10 | 30 | 28, end too, in the workspace grown by 80 | 0 |
//! | backs off, mm | - | 10, 20 | 10 | 10, 20 |
//! | order | continuation, axes, others | shuffled | shuffled | shuffled |
//!
//! `pmbs_contour` is `pmbs` with up to four directions from corners, as the text of PMBS reads ("evenly sampled around the
//! contour"; its code has the fixed eight).
//!
//! `rich` is `pmbs_contour` with three lengths of every push and, along the axes, pushes 10 mm beside the centroid.
//!
//! The first three are the samplers of Visual Foresight Trees, MORE and PMBS with exact polygons in place of 2 mm
//! pixels; [`SamplerParams`] says field by field where that makes a difference. `dense` is ours.

mod contour;
mod directions;
mod params;
#[cfg(test)]
mod tests;

pub use contour::ContourSampler;
pub use params::{ContourRule, Corners, Order, Region, SamplerParams, StartBox};

use super::Push;
use crate::error::{Error, Result};
use crate::geom::Frame;
use crate::run::Stream;
use crate::scene::{Scene, State};

/// Proposes pushes.
///
/// Thread rule: shared freely between threads; a scratch is used by one thread at a time. The result depends on the
/// arguments only, not on what the scratch was used for before.
pub trait PushSampler: Send + Sync {
    /// The name that [`by_name`] knows, or that of the preset the sampler was derived from.
    fn name(&self) -> &'static str;

    /// The same sampler with all that does not depend on poses worked out for this scene. The result is the same
    /// without it, and slower. It may be used on any scene with the same footprints (other friction, say).
    fn prepare(&self, scene: &Scene) -> Box<dyn PushSampler>;

    /// Writes the legal pushes of `state` to `out` (what was there is dropped), the first to be tried first; the order
    /// is shuffled by `rng`. `previous` is the push that led to the state: some samplers continue it.
    ///
    /// Pushes are aimed at present bodies that are pushable, and start clear of every present body.
    /// `state` must belong to `scene` ([`Scene::check_state`]). No memory is allocated once `scratch` and `out` are
    /// warm and the sampler is prepared.
    #[allow(clippy::too_many_arguments)]
    fn sample(
        &self,
        scene: &Scene,
        state: &State,
        target: usize,
        previous: Option<&Push>,
        rng: &mut Stream,
        scratch: &mut SamplerScratch,
        out: &mut Vec<Push>,
    );
}

/// Working memory of a sampler for one thread.
#[derive(Debug, Default)]
pub struct SamplerScratch {
    /// The present bodies.
    placed: Vec<Placed>,
    /// Indices into `placed` of the bodies that can be in the way of a push aimed at the body at hand.
    near: Vec<usize>,
    /// Pushes that are not along an axis.
    others: Vec<Push>,
}

/// A present body.
#[derive(Debug, Clone, Copy)]
struct Placed {
    body: usize,
    frame: Frame,
    /// A start box whose centre is at least this far from the body's origin misses it, squared metres.
    far: f64,
    /// One whose centre is nearer than this meets it, squared metres.
    close: f64,
}

/// The names that [`by_name`] knows.
pub const NAMES: [&str; 6] = ["vft", "more", "pmbs", "pmbs_contour", "dense", "rich"];

/// A preset. Prepare it for the scene before use.
pub fn by_name(name: &str) -> Result<Box<dyn PushSampler>> {
    Ok(Box::new(ContourSampler::preset(name)?))
}

fn unknown(name: &str) -> Error {
    Error::not_found("sampler", format!("no sampler is named `{name}`; known: {}", NAMES.join(", ")))
}
