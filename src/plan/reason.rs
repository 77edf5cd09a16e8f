//! Why a decision ended as it did: what a plan says beside its outcome, and the one rule that both come from.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::outcome::Outcome;
use crate::grasp::{Scorer, Unholdable};
use crate::run::{Budget, StopReason};
use crate::scene::Scene;

/// Why a plan is not solved. Data for programs; [`Display`](fmt::Display) is a sentence for people that says what is so
/// and what to change. Bodies have their names in the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Reason {
    /// Of so many pushes that were proposed none is legal and of use.
    NoLegalPush { proposed: u64 },
    /// Wherever the jaw could hold the target, the target is at least so wide, the jaw opens no farther than this, and
    /// needs so much room on either side, metres.
    TooWide { body: String, width: f64, opening: f64, gap: f64 },
    /// The pads never cover enough of the target, or meet faces that are too far out of parallel.
    NoHold { body: String },
    /// The target's top lies so much too low for the fingers, which come no nearer to the table than this, metres.
    TooLow { body: String, missing: f64, lowest: f64 },
    /// No body that is left can be grasped as it lies. Of so many, a grasp was tried and failed.
    NoGrasp { failed: u64 },
    /// So many grasps and pushes were tried here and failed; they are not offered again.
    Failed { grasps: u64, pushes: u64 },
    /// A body that can only be dragged cannot come to its goal: bodies that stay where they are, or the workspace's edge
    /// alone, leave no way.
    Enclosed { body: String, by: Vec<String> },
    /// A body that can only be dragged stands too near to one that stays where it is, or over the workspace's edge: no
    /// drag begins.
    Stuck { body: String },
    /// No push is known to be of use, and of some the engine left open what they do.
    Unsolved,
    /// The search ended by itself: it tried every sequence of at most so many actions.
    TriedAll { actions: u32 },
    /// The search ended by itself, with plans of at most so many moves.
    NoPlanFound { most_moves: u32 },
    /// After the plan's actions so many bodies are left; what to do with them is decided when they were executed.
    Left { bodies: u64 },
    /// The limit of iterations was reached.
    Iterations { limit: u64 },
    /// The time limit was reached, seconds.
    Seconds { limit: f64 },
    /// The limit of memory was reached, bytes.
    Memory { limit: u64 },
}

impl Reason {
    /// What is not offered again, if anything.
    pub(crate) fn failed(grasps: u64, pushes: u64) -> Option<Reason> {
        (grasps + pushes > 0).then_some(Reason::Failed { grasps, pushes })
    }

    /// The limit of a budget that a stop was asked for, or else of its iterations.
    pub(crate) fn limit(budget: &Budget, stopped: Option<StopReason>) -> Option<Reason> {
        let iterations = budget.iterations.map(|limit| Reason::Iterations { limit });
        match stopped {
            Some(StopReason::Deadline) => budget.seconds.map(|limit| Reason::Seconds { limit }).or(iterations),
            _ => iterations,
        }
    }

    /// Why no push can make the body graspable, where its shape alone tells.
    pub(crate) fn unholdable(scorer: &dyn Scorer, scene: &Scene, body: usize) -> Option<Reason> {
        let name = scene.body(body).name.clone();
        Some(match scorer.unholdable(scene, body)? {
            Unholdable::TooWide { width } => {
                let jaw = &scene.gripper().grasp;
                let gap = jaw.fit.max(jaw.finger_clearance);
                Reason::TooWide { body: name, width, opening: jaw.opening, gap }
            }
            Unholdable::NoFaces => Reason::NoHold { body: name },
            Unholdable::TooLow { missing } => {
                Reason::TooLow { body: name, missing, lowest: scene.gripper().grasp.lowest }
            }
        })
    }

    /// The limit of a budget's memory.
    pub(crate) fn memory(budget: &Budget) -> Reason {
        // Without a limit of its own a search holds as many nodes as it can number and the system has memory for.
        Reason::Memory { limit: budget.bytes.map_or(u64::MAX, |bytes| bytes as u64) }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reason::NoLegalPush { proposed: 0 } => f.write_str(
                "no push starts clear of the bodies and inside the workspace; choose another `sampler` or a smaller \
                 gripper, or make room",
            ),
            Reason::NoLegalPush { proposed } => write!(
                f,
                "of {proposed} pushes proposed none is legal and of use: each touches a body before it should, moves \
                 nothing, or drives a body out of the workspace; choose another `sampler` or `push_length`, or make room"
            ),
            Reason::TooWide { body, width, opening, gap } => write!(
                f,
                "\"{body}\" is {:.1} mm wide where it is narrowest, and the jaw opens {:.1} mm and needs a gap of {:.1} mm on \
                 either side; use a wider gripper, or choose another target",
                width * 1e3,
                opening * 1e3,
                gap * 1e3
            ),
            Reason::Unsolved => f.write_str(
                "no push is known to be of use, and what some do is open: a body toppled, or the engine left the tip or a body in \
                 another body; use a finer `preset` or another engine",
            ),
            Reason::NoHold { body } => write!(
                f,
                "\"{body}\" cannot be held from any side: the pads cover less of it than `min_cover`, or meet faces farther \
                 out of parallel than `max_wedge`; use another gripper, or choose another target"
            ),
            Reason::TooLow { body, missing, lowest } => write!(
                f,
                "\"{body}\" is {:.1} mm too low for fingers that come no nearer to the table than {:.1} mm; use another \
                 gripper, or choose another target",
                missing * 1e3,
                lowest * 1e3
            ),
            Reason::NoGrasp { failed: 0 } => f.write_str(
                "no body that is left can be grasped as it lies; use a planner that pushes, or a wider gripper",
            ),
            Reason::NoGrasp { failed } => write!(
                f,
                "no body that is left can be grasped as it lies, but for {failed} whose grasps were tried and failed; \
                 push the bodies, or reset the planner to have those grasps offered again"
            ),
            Reason::Failed { grasps, pushes } => {
                let tried = match (grasps, pushes) {
                    (grasps, 0) => format!("{grasps} grasps"),
                    (0, pushes) => format!("{pushes} pushes"),
                    (grasps, pushes) => format!("{grasps} grasps and {pushes} pushes"),
                };
                write!(
                    f,
                    "{tried} were tried here and failed; move the bodies, or reset the planner to have them offered again"
                )
            }
            Reason::Enclosed { body, by } if by.is_empty() => write!(
                f,
                "\"{body}\" can only be dragged, and the workspace leaves it no way to its goal; enlarge the workspace, \
                 move the goal, or let the body be picked"
            ),
            Reason::Enclosed { body, by } => write!(
                f,
                "\"{body}\" can only be dragged, and no way leads it to its goal: {} in between cannot be moved; make a \
                 gap, move the goal, or let one of them be moved",
                named(by)
            ),
            Reason::Stuck { body } => write!(
                f,
                "\"{body}\" can only be dragged, and stands so near to a body that cannot be moved, or to the workspace's \
                 edge, that no drag begins; move it 0.2 mm away, or let it be picked"
            ),
            Reason::TriedAll { actions } => write!(
                f,
                "every sequence of at most {actions} actions was tried; allow deeper plans (`max_depth`), or another \
                 `sampler`"
            ),
            Reason::NoPlanFound { most_moves } => write!(
                f,
                "no plan of at most {most_moves} moves was found; allow more moves (`max_moves`), or use another planner \
                 or seed"
            ),
            Reason::Left { bodies } => {
                write!(f, "{bodies} bodies are left after these actions; execute the first, observe, and plan again")
            }
            Reason::Iterations { limit } => {
                write!(f, "the limit of {limit} iterations was reached first; allow more iterations")
            }
            Reason::Seconds { limit } => {
                write!(f, "the time limit of {limit} s was reached first; allow more seconds or threads")
            }
            Reason::Memory { limit: u64::MAX } => {
                f.write_str(
                    "the search holds as many nodes as it can number, or the system gives no more memory; execute the first \
                     action and plan again, or set a limit of bytes",
                )
            }
            Reason::Memory { limit } => {
                write!(f, "the memory limit of {limit} bytes was reached first; allow more bytes")
            }
        }
    }
}

/// The first of the names, quoted.
fn named(names: &[String]) -> String {
    /// More than these are only counted.
    const LISTED: usize = 4;
    let mut text: Vec<String> = names.iter().take(LISTED).map(|name| format!("\"{name}\"")).collect();
    if names.len() > LISTED {
        text.push(format!("{} more", names.len() - LISTED));
    }
    let last = text.pop().unwrap_or_default();
    if text.is_empty() { last } else { format!("{} and {last}", text.join(", ")) }
}

/// A reason as documents hold it: its data and the sentence.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WrittenReason {
    #[serde(flatten)]
    pub reason: Reason,
    #[serde(default)]
    pub text: String,
}

impl From<&Reason> for WrittenReason {
    fn from(reason: &Reason) -> Self {
        WrittenReason { reason: reason.clone(), text: reason.to_string() }
    }
}

/// What is known when a decision ends.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ending {
    /// The end was asked for from outside.
    pub cancelled: bool,
    /// The plan does all that is asked, in the planner's model.
    pub solved: bool,
    /// Why nothing can be done: by a certificate, or because all was tried. Never a guess.
    pub shown: Vec<Reason>,
    /// The limit that ended the search before it had done what it would do.
    pub limit: Option<Reason>,
    /// Why a search that ended by itself came to no more.
    pub short: Vec<Reason>,
}

impl Ending {
    /// The outcome and its reasons, of every planner.
    pub fn conclude(self) -> (Outcome, Vec<Reason>) {
        if self.cancelled {
            (Outcome::Cancelled, Vec::new())
        } else if self.solved {
            (Outcome::Solved, Vec::new())
        } else if !self.shown.is_empty() {
            (Outcome::Infeasible, self.shown)
        } else if let Some(limit) = self.limit {
            (Outcome::Budget, vec![limit])
        } else {
            (Outcome::Partial, self.short)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> Vec<Reason> {
        let by = (1..6).map(|i| format!("wall {i}")).collect::<Vec<_>>();
        vec![
            Reason::NoLegalPush { proposed: 0 },
            Reason::NoLegalPush { proposed: 44 },
            Reason::NoGrasp { failed: 0 },
            Reason::NoGrasp { failed: 2 },
            Reason::TooWide { body: "box".into(), width: 0.045, opening: 0.03, gap: 0.003 },
            Reason::NoHold { body: "box".into() },
            Reason::Enclosed { body: "box".into(), by: Vec::new() },
            Reason::Enclosed { body: "box".into(), by: by[..1].to_vec() },
            Reason::Enclosed { body: "box".into(), by },
            Reason::Stuck { body: "box".into() },
            Reason::Unsolved,
            Reason::TriedAll { actions: 4 },
            Reason::NoPlanFound { most_moves: 20 },
            Reason::Left { bodies: 3 },
            Reason::Iterations { limit: 1 },
            Reason::Seconds { limit: 0.5 },
            Reason::Memory { limit: 1 << 20 },
            Reason::Failed { grasps: 1, pushes: 3 },
            Reason::TooLow { body: "box".into(), missing: 0.017, lowest: 0.035 },
        ]
    }

    #[test]
    fn what_is_written_of_a_reason_is_read_back_and_says_what_to_change() {
        for reason in all() {
            let written = WrittenReason::from(&reason);
            let text = serde_json::to_string(&written).expect("it can be written");
            assert_eq!(serde_json::from_str::<WrittenReason>(&text).expect("it can be read"), written);
            assert!(written.text.contains(';'), "what is so; what to change: {}", written.text);
            assert!(!written.text.contains('\n'));
        }
        let listed = all()[8].to_string();
        assert!(listed.contains("\"wall 1\", \"wall 2\", \"wall 3\", \"wall 4\" and 1 more"), "{listed}");
    }

    #[test]
    fn infeasible_is_only_what_was_shown() {
        let shown = vec![Reason::NoLegalPush { proposed: 1 }];
        let short = vec![Reason::TriedAll { actions: 4 }];
        let limit = Reason::Iterations { limit: 1 };
        for bits in 0..32u32 {
            let on = |bit: u32| bits & 1 << bit != 0;
            let ending = Ending {
                cancelled: on(0),
                solved: on(1),
                shown: if on(2) { shown.clone() } else { Vec::new() },
                limit: on(3).then(|| limit.clone()),
                short: if on(4) { short.clone() } else { Vec::new() },
            };
            let (outcome, reasons) = ending.conclude();
            assert_eq!(outcome == Outcome::Infeasible, on(2) && !on(0) && !on(1), "{bits:b}");
            assert_eq!(outcome == Outcome::Budget, on(3) && !on(0) && !on(1) && !on(2), "{bits:b}");
            assert_eq!(outcome == Outcome::Cancelled, on(0), "{bits:b}");
            assert_eq!(outcome == Outcome::Solved, on(1) && !on(0), "{bits:b}");
            let expected = match outcome {
                Outcome::Infeasible => shown.clone(),
                Outcome::Budget => vec![limit.clone()],
                Outcome::Partial if on(4) => short.clone(),
                _ => Vec::new(),
            };
            assert_eq!(reasons, expected, "{bits:b}");
        }
    }
}
