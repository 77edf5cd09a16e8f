//! `dipn_gn`: the same decision by the two networks of the dissertation (chapter on DIPN, "the complete pipeline"): DIPN
//! predicts what every sampled push does, and GN says how well each body can be grasped before and after it.
//!
//! It is `greedy` in its published forms with other parts: the engine `dipn` in the place of `planar`, the scorer `gn` in
//! that of the geometric test. A grasp of at least 0.7 is executed at once; a push has to raise the mean grasp reward even
//! when it is discounted by 0.9. A grasp counts only if its fingers come down on the table, as the published code asks after
//! the network ("zero if any foreground lies in the two finger rectangles"). The text's pushes of 10 cm begin at every
//! fifteenth point of a contour; here they are those of `dense`.
//!
//! `Tuned`, the default, keeps all published numbers and adds that no push may bring a body near the workspace's edge. It is
//! not confirmed in a second engine, so that it stays the system of the two networks; `confirm` may ask for it.

use super::greedy::{Recipe, greedy};
use super::options::{ClearOptions, ClearRule};
use crate::error::Result;
use crate::physics::{PhysicsOptions, Purpose};
use crate::plan::Variant;

/// How near to the workspace's edge a push may bring a body, metres; that of tuned `greedy`.
const EDGE: f64 = 0.03;

pub(super) fn recipe(options: &ClearOptions) -> Result<Recipe> {
    let variant = match options.variant {
        Variant::Code => Variant::Code,
        Variant::Tuned | Variant::Dissertation => Variant::Dissertation,
    };
    let published = greedy(&ClearOptions { variant, ..options.clone() })?;
    let edge = if options.variant == Variant::Tuned { EDGE } else { published.rule.edge };
    Ok(Recipe {
        rule: ClearRule { edge, ..published.rule },
        physics: PhysicsOptions::named("dipn", None, Purpose::Planning)?,
        scorer: "gn".into(),
        ..published
    })
}
