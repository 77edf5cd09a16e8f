//! `jostle render`: pictures.

use jostle::plan::Plan;
use jostle::record::SvgPicture;
use jostle::scene::arc::ArcOptions;
use jostle::scene::{AnyProblem, Input, InputKind, Problem};

use crate::args::RenderArgs;
use crate::clear;
use crate::output::{self, Failure, Outcome};
use crate::plan_file::PlanFile;
use crate::rearrange;

pub fn run(args: &RenderArgs) -> Outcome<()> {
    let input = Input::read(&args.input)?;
    let drawing = match input.kind {
        InputKind::RearrangementPlan => {
            let (problem, moves) = rearrange::read_plan(&input)?;
            rearrange::picture(&problem, &moves, args.animated)
        }
        InputKind::Plan => match PlanFile::read(&input)? {
            (AnyProblem::Clearing(problem), plan) => clear::plan_picture(&problem, &plan).render(),
            (AnyProblem::Retrieval(problem), plan) => plan_picture(&problem, &plan).render(),
            (AnyProblem::Rearrangement(_), _) => return Err(Failure::usage("problem: is a rearrangement")),
        },
        _ => match input.problem(ArcOptions { profile: args.profile.profile(), ..ArcOptions::default() })? {
            AnyProblem::Rearrangement(problem) => rearrange::picture(&problem, &[], args.animated),
            AnyProblem::Clearing(problem) => clear::picture(&problem).render(),
            AnyProblem::Retrieval(problem) => SvgPicture::of_problem(&problem).render(),
        },
    };
    output::write_file(&args.output, &drawing)
}

/// The problem if there is nothing to do, else a panel for each action.
pub fn plan_picture(problem: &Problem, plan: &Plan) -> SvgPicture {
    if plan.actions.is_empty() {
        return SvgPicture::of_problem(problem);
    }
    let steps: Vec<_> = plan.actions.iter().map(|a| (a.action, Some(a.predicted.clone()))).collect();
    let mut picture = SvgPicture::new();
    picture.title(&problem.name).plan(problem, &steps);
    picture
}
