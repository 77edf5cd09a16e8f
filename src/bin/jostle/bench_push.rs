//! `jostle bench push`: pushes a second of an engine's presets.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use jostle::action::{ContourSampler, Push, PushSampler, SamplerScratch};
use jostle::eval::{read_recordings, statistics};
use jostle::physics::{self, PhysicsOptions, RapierSettings, Scratch, Transition};
use jostle::run::{Key, Pool, Stop};
use jostle::scene::generate::{Generator, GeneratorParams};
use jostle::scene::{Scene, State};
use serde::Serialize;

use crate::args::BenchPushArgs;
use crate::output::{self, Failure, Machine, Outcome};
use crate::table::{Table, number};

/// Times that every push runs in one timed run: a run has to be long against the waking of an idle core.
const PASSES: usize = 8;
/// Every variant runs at least this often.
const ROUNDS: usize = 3;
const THREADS: [usize; 2] = [1, 2];

#[derive(Serialize)]
struct Report {
    version: &'static str,
    machine: Machine,
    engine: String,
    /// Where the pushes come from.
    source: String,
    pushes: usize,
    /// Times that every variant ran; rates are of the median time.
    rounds: usize,
    presets: BTreeMap<String, Rates>,
}

#[derive(Serialize, Default)]
struct Rates {
    #[serde(flatten)]
    all: Rate,
    /// By the number of bodies in the scene.
    by_bodies: BTreeMap<usize, Rate>,
}

#[derive(Serialize, Default)]
struct Rate {
    pushes: usize,
    ms_per_push_1_thread: f64,
    pushes_per_second_1_thread: f64,
    pushes_per_second_2_threads: f64,
}

impl Rate {
    fn new(pushes: usize, seconds: [f64; 2]) -> Rate {
        let rate = |s: f64| if s > 0.0 { pushes as f64 / s } else { 0.0 };
        Rate {
            pushes,
            ms_per_push_1_thread: seconds[0] * 1e3 / pushes.max(1) as f64,
            pushes_per_second_1_thread: rate(seconds[0]),
            pushes_per_second_2_threads: rate(seconds[1]),
        }
    }
}

/// A push to be repeated.
struct Source {
    scene: Arc<Scene>,
    state: State,
    push: Push,
}

/// A push with the engine of one preset.
struct Item {
    engine: Arc<dyn Transition>,
    scratch: Scratch,
    state: State,
    push: Push,
}

/// Everything that is timed together: one preset, one number of bodies, one number of threads.
struct Variant {
    preset: usize,
    bodies: usize,
    threads: usize,
    seconds: Vec<f64>,
}

pub fn run(args: &BenchPushArgs) -> Outcome<()> {
    if !(args.seconds.is_finite() && args.seconds > 0.0) {
        return Err(Failure::usage(format!("seconds: is {}; it must be greater than 0", args.seconds)));
    }
    let presets: Vec<String> = match &args.preset {
        Some(preset) => vec![preset.clone()],
        None => RapierSettings::PRESETS.map(String::from).to_vec(),
    };
    let (source, pushes) = match &args.file {
        Some(path) => (path.display().to_string(), recorded(args)?),
        None => (format!("pushes sampled in generated scenes, seed {}", args.seed), generated(args.seed)?),
    };
    let mut groups: BTreeMap<(usize, usize), Vec<Item>> = BTreeMap::new();
    for (p, preset) in presets.iter().enumerate() {
        let options =
            PhysicsOptions { engine: args.physics.clone(), preset: preset.clone(), ..PhysicsOptions::default() };
        for source in std::iter::repeat_n(&pushes, PASSES).flatten() {
            let engine = physics::engine(&options, Arc::clone(&source.scene))?;
            let item = Item { scratch: engine.scratch(), engine, state: source.state.clone(), push: source.push };
            groups.entry((p, source.scene.len())).or_default().push(item);
        }
    }
    let (variants, rounds) = measure(&mut groups, args.seconds)?;

    let mut report = Report {
        version: env!("CARGO_PKG_VERSION"),
        machine: Machine::this(),
        engine: args.physics.clone(),
        source,
        pushes: pushes.len(),
        rounds,
        presets: BTreeMap::new(),
    };
    for (p, preset) in presets.iter().enumerate() {
        let mut rates = Rates::default();
        let mut total = [0.0; 2];
        for (&(_, bodies), items) in groups.iter().filter(|((q, _), _)| *q == p) {
            let seconds = THREADS.map(|threads| {
                let variant = variants.iter().find(|v| v.preset == p && v.bodies == bodies && v.threads == threads);
                variant.map_or(0.0, |v| statistics::median(&v.seconds))
            });
            total.iter_mut().zip(seconds).for_each(|(t, s)| *t += s);
            rates.by_bodies.insert(bodies, Rate::new(items.len(), seconds));
        }
        rates.all = Rate::new(pushes.len() * PASSES, total);
        report.presets.insert(preset.clone(), rates);
    }
    output::report(args.json.json.as_deref(), &report, &text(&report, &presets))
}

/// Times the variants in turn, so that a machine that is busy for a while is busy for all of them.
fn measure(groups: &mut BTreeMap<(usize, usize), Vec<Item>>, seconds: f64) -> Outcome<(Vec<Variant>, usize)> {
    let mut pools = Vec::new();
    for threads in THREADS {
        let pool = Pool::new(threads, "jostle-bench")?;
        let scratches: Vec<Mutex<()>> = (0..pool.workers()).map(|_| Mutex::new(())).collect();
        pools.push((threads, pool, scratches));
    }
    let mut variants: Vec<Variant> = groups
        .keys()
        .flat_map(|&(preset, bodies)| THREADS.map(|threads| Variant { preset, bodies, threads, seconds: Vec::new() }))
        .collect();
    let begin = Instant::now();
    let mut rounds = 0;
    let stop = Stop::never();
    while rounds < ROUNDS || begin.elapsed().as_secs_f64() < seconds {
        for variant in &mut variants {
            let Some(items) = groups.get_mut(&(variant.preset, variant.bodies)) else { continue };
            let Some((_, pool, scratches)) = pools.iter().find(|(threads, ..)| *threads == variant.threads) else {
                continue;
            };
            let start = Instant::now();
            pool.for_each_group(items, 1, scratches, |(), group| {
                for item in group {
                    std::hint::black_box(item.engine.step(&mut item.scratch, &item.state, &item.push, &stop));
                }
            })?;
            variant.seconds.push(start.elapsed().as_secs_f64());
        }
        rounds += 1;
    }
    Ok((variants, rounds))
}

fn recorded(args: &BenchPushArgs) -> Outcome<Vec<Source>> {
    let Some(path) = &args.file else { return Ok(Vec::new()) };
    let recordings = read_recordings(path)?;
    let planar = recordings.iter().filter(|r| r.is_planar());
    let sources: Vec<Source> = planar
        .map(|r| Ok(Source { scene: Arc::new(r.scene()?), state: r.state(), push: r.push() }))
        .collect::<Outcome<_>>()?;
    if sources.is_empty() {
        return Err(Failure::usage(format!("{}: holds no planar push", path.display())));
    }
    Ok(sources)
}

fn text(report: &Report, presets: &[String]) -> String {
    let mut table = Table::new(["preset", "bodies", "ms/push", "pushes/s, 1 thread", "2 threads"]);
    let cells = |name: &str, bodies: String, rate: &Rate| {
        [
            name.to_string(),
            bodies,
            number(Some(rate.ms_per_push_1_thread), 3),
            number(Some(rate.pushes_per_second_1_thread), 0),
            number(Some(rate.pushes_per_second_2_threads), 0),
        ]
    };
    for preset in presets {
        let Some(rates) = report.presets.get(preset) else { continue };
        table.row(cells(preset, "all".into(), &rates.all));
        for (bodies, rate) in &rates.by_bodies {
            table.row(cells("", bodies.to_string(), rate));
        }
    }
    format!(
        "{}: {} pushes, {}; median of {} rounds\n\n{table}",
        report.engine, report.pushes, report.source, report.rounds
    )
}

/// Pushes that a planner might try: a dozen in each of 24 packed scenes.
fn generated(seed: u64) -> Outcome<Vec<Source>> {
    let generator = Generator::new(GeneratorParams::default(), seed)?;
    let sampler = ContourSampler::preset("more")?;
    let mut scratch = SamplerScratch::default();
    let mut sources = Vec::new();
    for index in 0..24 {
        let problem = generator.problem(index)?;
        let mut pushes = Vec::new();
        let mut order = Key::new(seed).child(index).stream();
        sampler.sample(&problem.scene, &problem.state, problem.target, None, &mut order, &mut scratch, &mut pushes);
        sources.extend(pushes.into_iter().take(12).map(|push| Source {
            scene: Arc::clone(&problem.scene),
            state: problem.state.clone(),
            push,
        }));
    }
    Ok(sources)
}
