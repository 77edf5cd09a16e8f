//! `jostle fidelity`: agreement of an engine with recorded pushes.

use jostle::eval::{Fidelity, compare, read_recordings};
use jostle::physics;
use serde::Serialize;

use crate::args::FidelityArgs;
use crate::output::{self, Outcome};
use crate::table::{Table, number};

#[derive(Serialize)]
struct Report {
    version: &'static str,
    preset: String,
    #[serde(flatten)]
    fidelity: Fidelity,
}

pub fn run(args: &FidelityArgs) -> Outcome<()> {
    let options = args.physics.options()?;
    let recordings = read_recordings(&args.file)?;
    let network = physics::network(&options)?;
    let engine = |scene| physics::engine_with(&options, scene, network.as_ref());
    let fidelity = compare(&recordings, args.against.into(), &engine)?;
    let text = text(&fidelity);
    let report = Report { version: env!("CARGO_PKG_VERSION"), preset: options.preset, fidelity };
    output::report(args.json.json.as_deref(), &report, &text)
}

fn text(f: &Fidelity) -> String {
    let m = &f.moved;
    let mut table = Table::new(["moved bodies", "mean", "median", "tail"]);
    let row = |name: &str, mean: f64, median: f64, tail: &str, digits: usize| {
        [name.to_string(), number(Some(mean), digits), number(Some(median), digits), tail.to_string()]
    };
    table.row(row("overlap (IoU)", m.mean_iou, m.median_iou, &format!("p10 {:.3}", m.p10_iou), 3));
    table.row(row(
        "position, mm",
        m.mean_position_mm,
        m.median_position_mm,
        &format!("p90 {:.2}", m.p90_position_mm),
        2,
    ));
    table.row(row(
        "rotation, deg",
        m.mean_rotation_deg,
        m.median_rotation_deg,
        &format!("p90 {:.2}", m.p90_rotation_deg),
        2,
    ));
    format!(
        "{} on {} pushes ({} left out, {} refused by the engine)\n\n{table}\n{} bodies moved ({} missed, {} ghosts); IoU of \
         all {} bodies {:.3}\n",
        f.engine, f.pushes, f.left_out, f.illegal, m.count, m.missed, m.ghosts, f.all.count, f.all.mean_iou
    )
}
