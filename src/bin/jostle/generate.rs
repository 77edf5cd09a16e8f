use crate::args::GenerateArgs;
use crate::output::{Failure, Outcome};

pub fn run(_: &GenerateArgs) -> Outcome<()> {
    Err(Failure::usage("not yet"))
}
