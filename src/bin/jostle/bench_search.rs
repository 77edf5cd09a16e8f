use crate::args::BenchSearchArgs;
use crate::output::{Failure, Outcome};

pub fn run(_: &BenchSearchArgs) -> Outcome<()> {
    Err(Failure::usage("not yet"))
}
