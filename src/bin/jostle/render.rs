use crate::args::RenderArgs;
use crate::output::{Failure, Outcome};

pub fn run(_: &RenderArgs) -> Outcome<()> {
    Err(Failure::usage("not yet"))
}
pub fn plan_picture(_: &jostle::scene::Problem, _: &jostle::plan::Plan) -> Outcome<String> {
    Err(Failure::usage("not yet"))
}
