//! `jostle bench net`: milliseconds of a call and of an item, for each network and batch size.

use std::collections::BTreeMap;
use std::time::Instant;

use jostle::net::{Axis, BUILTINS, Backend, LoadOptions, Model, RuntimeOptions};
use serde::Serialize;
use serde_json::Value;

use crate::args::BenchNetArgs;
use crate::output::{self, Failure, Machine, Outcome};

#[derive(Serialize)]
struct Report {
    version: &'static str,
    machine: Machine,
    runtime: Value,
    /// What the times of calls are: "thread" (processor time of the thread) or, where the system does not count it, "wall".
    clock: &'static str,
    /// Bodies of a scene, for networks that know bodies.
    objects: usize,
    networks: BTreeMap<String, Network>,
}

#[derive(Serialize)]
struct Network {
    kind: &'static str,
    bytes: usize,
    batches: Vec<Batch>,
}

#[derive(Serialize)]
struct Batch {
    items: usize,
    calls: usize,
    /// Mean time of a call and of an item, by the report's clock.
    call_ms: f64,
    item_ms: f64,
    /// Least and median wall-clock time of a call.
    wall_ms: f64,
    wall_median_ms: f64,
}

pub fn run(args: &BenchNetArgs) -> Outcome<()> {
    let backend = args.backend.as_deref().map(Backend::by_name).transpose()?;
    let options = LoadOptions {
        runtime: RuntimeOptions { library: args.runtime.clone(), backend },
        threads: args.threads,
        ..LoadOptions::default()
    };
    let mut names = args.models.clone();
    if names.is_empty() {
        names = BUILTINS.iter().map(|b| b.name.to_string()).collect();
    }
    if names.is_empty() {
        return Err(Failure::usage("models: this build has no networks of its own; name files"));
    }
    let mut report = Report {
        version: env!("CARGO_PKG_VERSION"),
        machine: Machine::this(),
        runtime: Value::Null,
        clock: if thread_time().is_some() { "thread" } else { "wall" },
        objects: args.objects,
        networks: BTreeMap::new(),
    };
    for name in names {
        let model = Model::open(&name, None, &options)?;
        report.runtime = model.runtime().to_json();
        if model.info().interface.inputs.iter().any(|spec| spec.axes.contains(&Axis::Free)) {
            return Err(Failure::usage(format!("{name}: takes pictures of any size; it is not measured")));
        }
        let batches = args.batches.iter().map(|&items| measure(&model, items, args)).collect::<Outcome<_>>()?;
        let network = Network { kind: model.info().kind.id(), bytes: model.info().bytes, batches };
        report.networks.insert(name, network);
    }
    output::report(args.json.json.as_deref(), &report, &text(&report))
}

/// Runs a batch again and again.
fn measure(model: &Model, items: usize, args: &BenchNetArgs) -> Outcome<Batch> {
    let info = model.info();
    let (objects, side) = (args.objects, info.side.unwrap_or(0));
    let mut seed = 1_u64;
    let mut value = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f32 / (1 << 24) as f32 * 0.1
    };
    let inputs: Vec<Vec<f32>> = info
        .interface
        .inputs
        .iter()
        .map(|spec| {
            let extents = spec.axes.iter().map(|axis| match axis {
                Axis::Batch => items,
                Axis::Objects => objects,
                Axis::Fixed(n) => *n,
                Axis::Side | Axis::Free => side,
                Axis::HalfSide => side / 2,
                Axis::Found => 0,
            });
            let count = extents.product();
            if spec.name == "present" { vec![1.0; count] } else { (0..count).map(|_| value()).collect() }
        })
        .collect();
    let inputs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
    let mut outputs = vec![Vec::new(); info.interface.outputs.len()];
    let mut wall = Vec::new();
    model.run(items, objects, &inputs, &mut outputs)?;
    // Over all calls: some systems count a thread's time in steps longer than a call.
    let (clock, began) = (thread_time(), Instant::now());
    while wall.len() < 5 || began.elapsed().as_secs_f64() < args.seconds {
        let instant = Instant::now();
        model.run(items, objects, &inputs, &mut outputs)?;
        wall.push(instant.elapsed().as_secs_f64() * 1e3);
    }
    let whole = began.elapsed().as_secs_f64();
    let own = thread_time().zip(clock).map_or(whole, |(now, before)| now - before);
    wall.sort_by(f64::total_cmp);
    let call_ms = own * 1e3 / wall.len() as f64;
    Ok(Batch {
        items,
        calls: wall.len(),
        call_ms,
        item_ms: call_ms / items as f64,
        wall_ms: wall[0],
        wall_median_ms: wall[wall.len() / 2],
    })
}

/// Seconds that this thread has run on a processor so far, by the scheduler's count.
fn thread_time() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds = text.split_whitespace().next()?.parse::<f64>().ok()?;
    (nanoseconds > 0.0).then_some(nanoseconds * 1e-9)
}

fn text(report: &Report) -> String {
    let mut text = format!(
        "{} {}, {} bodies, milliseconds ({} time)\n{:<24} {:>6} {:>10} {:>10} {:>11}\n",
        report.runtime["backend"].as_str().unwrap_or("?"),
        report.runtime["version"].as_str().unwrap_or("?"),
        report.objects,
        report.clock,
        "network",
        "batch",
        "call",
        "item",
        "least wall",
    );
    for (name, network) in &report.networks {
        for batch in &network.batches {
            text += &format!(
                "{:<24} {:>6} {:>10.3} {:>10.3} {:>11.3}\n",
                name, batch.items, batch.call_ms, batch.item_ms, batch.wall_ms
            );
        }
    }
    text
}
