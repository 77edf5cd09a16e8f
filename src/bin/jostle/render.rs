//! `jostle render`: pictures.

use std::path::Path;

use jostle::Error;
use jostle::eval::{is_original, read_problem};
use jostle::plan::Plan;
use jostle::record::SvgPicture;
use jostle::scene::{AnyProblem, Problem};

use crate::args::RenderArgs;
use crate::clear;
use crate::output::{self, Failure, Outcome};
use crate::plan_file::PlanFile;
use crate::rearrange;

pub fn run(args: &RenderArgs) -> Outcome<()> {
    if rearrange::render(&args.input, &args.output, args.animated)? {
        return Ok(());
    }
    let picture = match read_plan(&args.input)? {
        Some((AnyProblem::Clearing(problem), plan)) => clear::plan_picture(&problem, &plan),
        Some((AnyProblem::Retrieval(problem), plan)) => plan_picture(&problem, &plan),
        Some((AnyProblem::Rearrangement(_), _)) => return Err(Failure::usage("problem: is a rearrangement")),
        None => match clear::read(&args.input)? {
            Some(problem) => clear::picture(&problem),
            None => SvgPicture::of_problem(&read_problem(&args.input, args.profile.profile())?),
        },
    };
    output::write_file(&args.output, &picture.render())
}

/// The plan that a file holds; none if it holds something else.
fn read_plan(path: &Path) -> Outcome<Option<(AnyProblem, Plan)>> {
    if is_original(path) {
        return Ok(None);
    }
    let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, e))?;
    match serde_json::from_str(&text) {
        Ok(document) if PlanFile::is_plan(&document) => {
            PlanFile::read(document).map(Some).map_err(|e| e.within(&path.display().to_string()))
        }
        // The reader of scenes knows best what is wrong with it.
        _ => Ok(None),
    }
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
