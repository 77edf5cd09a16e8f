//! Why an action was chosen: the best first actions side by side, as small multiples.

use super::svg::SvgPicture;
use crate::action::Action;
use crate::plan::{Plan, RankedAction};
use crate::scene::Problem;

/// Panels at most.
const PANELS: usize = 9;

/// A panel for each of the best first actions of a decision: the push, where the bodies are expected after it, and a bar
/// of its value: the chance of success where plans were weighed in perturbed worlds, else its value in relation to the
/// best. A plan that considered nothing (a grasp at once) shows its first action.
pub fn explanation(problem: &Problem, plan: &Plan) -> SvgPicture {
    let mut picture = SvgPicture::new();
    let chosen = plan.actions.first().map(|step| step.action);
    let title = format!("{}: {} first actions considered by {}", problem.name, plan.considered.len(), plan.planner);
    picture.title(&title);
    let greatest = plan.considered.iter().map(|a| a.value).fold(f64::MIN_POSITIVE, f64::max);
    for (rank, ranked) in plan.considered.iter().take(PANELS).enumerate() {
        let mark = if chosen.is_some_and(|action| action == ranked.action) { ", chosen" } else { "" };
        let caption = format!("{}{mark}: {}", rank + 1, numbers(ranked));
        let (state, target) = (&problem.state, Some(problem.target));
        picture.panel(&problem.scene, state, target, Some(&ranked.action), Some(&ranked.predicted), &caption);
        match ranked.success_chance {
            Some(chance) => picture.gauge(chance, &format!("chance {:.0} %", chance * 100.0)),
            None => picture.gauge(ranked.value / greatest, &format!("value {:.3}", ranked.value)),
        };
    }
    if plan.considered.is_empty() {
        let step = plan.actions.first();
        let (action, after) = (step.map(|s| &s.action), step.map(|s| &s.predicted));
        let caption = if matches!(action, Some(Action::Grasp(_))) { "grasped at once" } else { "nothing considered" };
        picture.panel(&problem.scene, &problem.state, Some(problem.target), action, after, caption);
    }
    picture
}

fn numbers(ranked: &RankedAction) -> String {
    let mut text = String::new();
    if let Some(expected) = ranked.expected_actions {
        text.push_str(&format!("{expected:.2} actions expected, "));
    }
    text.push_str(&format!("value {:.3}, {} visits", ranked.value, ranked.visits));
    if ranked.prior != 0.0 {
        text.push_str(&format!(", prior {:.2}", ranked.prior));
    }
    if let Some(level) = ranked.solution_level {
        text.push_str(&format!(", a plan of {level}"));
    }
    text
}
