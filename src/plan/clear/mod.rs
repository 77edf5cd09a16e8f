//! Planners of clearings: take everything off the table with grasps, and with pushes where those help.
//!
//! | file | holds |
//! |---|---|
//! | `options` | [`ClearOptions`] and [`ClearRule`]: what a planner is told and how it decides |
//! | `greedy` | the recipes: `greedy` in its variants, and the two baselines |
//! | `dipn_gn` | the recipe of the dissertation's networks |
//! | `networks` | the networks of a recipe, loaded once, or a caller's own |
//! | `parts` | [`ClearParts`]: sampler, engines and grasp scorer, prepared for a scene |
//! | `outlook` | what a state promises: which bodies can be taken, one after the other |
//! | `pushes` | candidate pushes: simulated, judged, and the best of them tried in a second engine |
//! | `planner` | [`ClearPlanner`]: the decision |

mod dipn_gn;
mod greedy;
mod networks;
mod options;
mod outlook;
mod parts;
mod planner;
mod pushes;

pub use options::{CLEAR_PLANNERS, ClearOptions, ClearRule, PushChoice, PushWorth};
pub use outlook::Outlook;
pub use parts::ClearParts;
pub use planner::ClearPlanner;
