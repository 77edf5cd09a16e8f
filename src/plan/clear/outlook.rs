//! What a state promises: which bodies can be taken, and how well.
//!
//! Taking a body never hinders the grasp of another, for bodies are in each other's way only. So which bodies can be
//! taken one after the other does not depend on the order (but for a hair where a score is just good enough); best first
//! gives every grasp the most room it can have.

use std::any::Any;

use super::parts::ClearParts;
use crate::action::Grasp;
use crate::grasp::GraspAssessment;
use crate::run::Stop;
use crate::scene::{Mask, State};

/// What can be taken from a state.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Outlook {
    /// Bodies to be taken.
    pub remaining: usize,
    /// Mean over them of the best grasp's score, 0 for one that cannot be grasped as it stands.
    pub mean: f64,
    /// Greatest of the scores.
    pub greatest: f64,
    /// Bodies that can be taken one after the other without a push.
    pub freed: usize,
    /// Mean score of their grasps when their turn comes, but not above what they had when they first could be grasped.
    pub freed_score: f64,
    /// Mean nearness of the others, in [0, 1).
    pub nearness: f64,
}

impl Outlook {
    /// Of a state whose bodies `which` have these assessments; `state` is worked on, and holds what is left at the end. With a
    /// requested stop it is not to be used.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn new(
        parts: &ClearParts,
        scorer: &mut (dyn Any + Send),
        state: &mut State,
        which: Mask,
        enough: f64,
        mut of: impl FnMut(usize) -> GraspAssessment,
        stop: &Stop,
    ) -> Outlook {
        let mut outlook = Outlook { remaining: which.count(), ..Outlook::default() };
        let mut near = [0.0f64; crate::scene::MAX_BODIES];
        let mut open = Mask::EMPTY;
        let mut stuck = Mask::EMPTY;
        let (mut sum, mut taken_sum) = (0.0, 0.0);
        for body in which.iter() {
            let found = of(body);
            let score = if found.grasp.is_some() { found.score } else { 0.0 };
            sum += score;
            outlook.greatest = outlook.greatest.max(score);
            near[body] = rank(&found, enough);
            if found.grasp.is_some() && score >= enough {
                taken_sum += score;
                open.insert(body);
            } else {
                stuck.insert(body);
            }
        }
        while let Some(body) = open.iter().next() {
            open.remove(body);
            state.set_present(body, false);
            outlook.freed += 1;
            for other in stuck.iter() {
                if !parts.near(state, other, body) {
                    continue;
                }
                let found = parts.assess(scorer, state, other, stop);
                near[other] = rank(&found, enough);
                if found.grasp.is_some() && found.score >= enough {
                    taken_sum += found.score;
                    stuck.remove(other);
                    open.insert(other);
                }
            }
        }
        let mean = |sum: f64, n: usize| if n > 0 { sum / n as f64 } else { 0.0 };
        outlook.mean = mean(sum, outlook.remaining);
        outlook.freed_score = mean(taken_sum, outlook.freed);
        outlook.nearness = mean(stuck.iter().map(|b| near[b]).sum(), stuck.count());
        outlook
    }

    /// Every body can be taken.
    pub fn clears(&self) -> bool {
        self.freed == self.remaining
    }

    /// The share of the bodies that can be taken before the next push, in [0, 1]. Of equals, those with better grasps are
    /// worth more, and those whose other bodies are nearer to a grasp.
    pub fn freed_value(&self) -> f64 {
        let rest = (self.remaining - self.freed) as f64;
        let worth = self.freed as f64 * (0.85 + 0.15 * self.freed_score) + 0.6 * rest * self.nearness;
        if self.remaining > 0 { worth / self.remaining as f64 } else { 1.0 }
    }
}

/// How near a body is to a grasp that is good enough, below 1.
fn rank(found: &GraspAssessment, enough: f64) -> f64 {
    if found.grasp.is_some() { 0.5 + 0.49 * (found.score / enough.max(1e-9)).min(1.0) } else { 0.5 * found.nearness }
}

/// The grasps that take body after body, the best first, and the state after each. Ends where no body scores `enough`,
/// which may differ between bodies. `found` holds the bodies' assessments in `state`.
///
/// A body is assessed anew when its turn comes, or when nothing else can be taken, and not whenever a neighbour is taken:
/// a network takes milliseconds for each. Until then its earlier score stands, which more room can only raise. With a
/// requested stop the list ends where a body would have to be assessed anew.
pub(super) fn take_in_turn(
    parts: &ClearParts,
    scorer: &mut (dyn Any + Send),
    state: &State,
    which: Mask,
    enough: impl Fn(usize) -> f64,
    found: &mut [GraspAssessment],
    stop: &Stop,
) -> Vec<(Grasp, State)> {
    let mut state = state.clone();
    let mut left = which;
    // Bodies of which a neighbour was taken since they were assessed.
    let mut stale = Mask::EMPTY;
    let mut taken = Vec::new();
    loop {
        let next = best(left, &enough, found);
        match next {
            Some((body, grasp)) if !stale.contains(body) => {
                left.remove(body);
                state.set_present(body, false);
                taken.push((grasp, state.clone()));
                left.iter().filter(|&other| parts.near(&state, other, body)).for_each(|other| stale.insert(other));
            }
            _ => {
                let Some(body) = next.map(|(body, _)| body).or_else(|| left.iter().find(|&b| stale.contains(b))) else {
                    return taken;
                };
                let anew = parts.assess(scorer, &state, body, stop);
                if stop.requested() {
                    return taken;
                }
                stale.remove(body);
                found[body] = anew;
            }
        }
    }
}

/// The best grasp of those that are good enough; of equals that of the first body.
pub(super) fn best(which: Mask, enough: &impl Fn(usize) -> f64, found: &[GraspAssessment]) -> Option<(usize, Grasp)> {
    let mut best: Option<(usize, Grasp, f64)> = None;
    for body in which.iter() {
        let GraspAssessment { grasp: Some(grasp), score, .. } = found[body] else { continue };
        if score >= enough(body) && best.is_none_or(|(.., greatest)| score > greatest) {
            best = Some((body, grasp, score));
        }
    }
    best.map(|(body, grasp, _)| (body, grasp))
}
