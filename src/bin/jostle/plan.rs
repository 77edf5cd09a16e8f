//! `jostle plan`: one decision.

use std::fmt::Write as _;

use jostle::action::Action;
use jostle::eval::{push_travel, with_gripper};
use jostle::plan::{Control, Outcome as PlanOutcome, Plan, Planner, Reason};
use jostle::record::explanation;
use jostle::scene::arc::ArcOptions;
use jostle::scene::{AnyProblem, Input, InputKind, Scene, State};

use crate::args::PlanArgs;
use crate::clear;
use crate::output::{self, Outcome};
use crate::plan_file::PlanFile;
use crate::rearrange;
use crate::render;

pub fn run(args: &PlanArgs) -> Outcome<()> {
    let input = Input::read(&args.scene)?;
    let mut problem = match input.problem(ArcOptions { profile: args.profile.profile(), ..ArcOptions::default() })? {
        AnyProblem::Retrieval(problem) => problem,
        AnyProblem::Rearrangement(problem) => return rearrange::plan(args, &problem),
        AnyProblem::Clearing(problem) => return clear::plan(args, &problem),
    };
    let mut options = args.planner.options()?;
    if let Some(gripper) = args.planner.gripper()? {
        problem = with_gripper(&problem, &gripper)?;
    }
    if input.kind == InputKind::Original {
        options.push_length.get_or_insert(push_travel(args.profile.of(&args.scene)));
    }
    options.gripper = Some(problem.scene.gripper().clone());
    let plan = Planner::new(options)?.solve(&problem, &Control::default())?;
    if let Some(path) = &args.svg {
        output::write_file(path, &render::plan_picture(&problem, &plan).render())?;
    }
    if let Some(path) = &args.explain {
        output::write_file(path, &explanation(&problem, &plan).render())?;
    }
    let target = Some(problem.target);
    let text = text(&problem.name, &problem.scene, &problem.state, target, &plan);
    output::report(args.json.json.as_deref(), &PlanFile::new(&problem.to_json()?, &plan)?, &text)
}

/// Why a plan is not solved, below its outcome.
pub fn write_reasons(out: &mut String, reasons: &[Reason]) {
    for reason in reasons {
        let _ = writeln!(out, "        {reason}");
    }
}

/// The plan for people. Without a target everything is to be taken.
pub fn text(title: &str, scene: &Scene, state: &State, target: Option<usize>, plan: &Plan) -> String {
    let name = |body: usize| scene.bodies().get(body).map_or("?", |b| b.name.as_str());
    let mut out = String::new();
    // Writing to a string does not fail.
    let _ = writeln!(
        out,
        "scene   {title}: {} bodies, {}, gripper {}",
        state.present().count(),
        target.map_or("to be taken off the table".into(), |target| format!("target \"{}\"", name(target))),
        scene.gripper().name
    );
    let outcome = match plan.outcome {
        PlanOutcome::Solved => "solved",
        PlanOutcome::Partial => "partial: the search ended without a grasp; the best pushes found",
        PlanOutcome::Infeasible => "infeasible",
        PlanOutcome::Budget => "budget used up; the best pushes found",
        PlanOutcome::Cancelled => "cancelled",
    };
    let _ = writeln!(out, "outcome {outcome}");
    write_reasons(&mut out, &plan.reasons);
    for (i, step) in plan.actions.iter().enumerate() {
        let _ = match &step.action {
            Action::Push(p) => writeln!(
                out,
                "  {}. push  {}from ({:.3}, {:.3}) to ({:.3}, {:.3}) m: {:.0} mm along {:.0} deg, value {:.3}",
                i + 1,
                p.body.map_or(String::new(), |b| format!("\"{}\" ", name(b))),
                p.start[0],
                p.start[1],
                p.end[0],
                p.end[1],
                p.length() * 1e3,
                p.angle().to_degrees(),
                step.value
            ),
            Action::Grasp(g) => writeln!(
                out,
                "  {}. grasp \"{}\" at ({:.3}, {:.3}) m, closing along {:.0} deg: opening {:.1} mm, width {:.1} mm, \
                 margin {:.1} mm, score {:.2}",
                i + 1,
                name(g.body),
                g.position[0],
                g.position[1],
                g.angle.to_degrees(),
                g.opening * 1e3,
                g.width * 1e3,
                g.margin * 1e3,
                g.score
            ),
        };
    }
    let s = &plan.statistics;
    let _ = writeln!(
        out,
        "search  {}, seed {}: {:.1} ms, {} iterations, {} nodes, {} pushes simulated",
        plan.planner,
        plan.seed,
        s.seconds * 1e3,
        s.iterations,
        s.nodes,
        s.simulations
    );
    if let Some(depth) = s.no_plan_within {
        let _ = writeln!(out, "        every plan of at most {depth} pushes was tried: none ends in a grasp");
    }
    if let (Some(chance), Some(expected)) = (s.success_chance, s.expected_actions) {
        let _ = writeln!(
            out,
            "        {} perturbed worlds: done in {} actions with {:.0} %, in {expected:.2} on average",
            s.worlds,
            plan.actions.len(),
            chance * 100.0
        );
    }
    if s.proved_shortest {
        let _ = writeln!(out, "        no shorter plan exists in this action set");
    }
    out
}
