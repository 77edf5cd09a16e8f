//! `jostle bench push`: pushes a second of engines and their presets.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use jostle::action::{ContourSampler, Push, PushSampler, SamplerScratch};
use jostle::eval::{read_recordings, statistics};
use jostle::geom::{Pose2, Shape};
use jostle::physics::{self, EngineInfo, PhysicsOptions, PushJob, PushResult, Scratch, Transition};
use jostle::run::{Key, Pool, Stop};
use jostle::scene::generate::{Generator, GeneratorParams};
use jostle::scene::{BodyDef, Problem, Scene, SceneBuilder, State};
use serde::Serialize;

use crate::args::BenchPushArgs;
use crate::output::{self, Failure, Machine, Outcome};
use crate::table::{Table, number};

/// Times that every push runs in one timed run, if the time allows: a run has to be long against the waking of an idle core.
const PASSES: usize = 8;
/// Calls that are timed together, if the time allows: fewer cannot be dealt out evenly to two threads, as a call stays on one.
const CALLS: usize = 128;
/// Every variant runs at least this often.
const ROUNDS: usize = 3;
const THREADS: [usize; 2] = [1, 2];
/// Scenes that are generated, and most pushes tried in each.
const SCENES: u64 = 24;
const PUSHES: usize = 64;

#[derive(Serialize)]
struct Report {
    version: &'static str,
    machine: Machine,
    /// The engines, as given.
    engine: String,
    /// Where the pushes come from.
    source: String,
    pushes: usize,
    /// Times that every variant ran; rates are of the median time.
    rounds: usize,
    /// By preset; by engine and preset where there are several engines.
    presets: BTreeMap<String, Rates>,
}

#[derive(Serialize, Default)]
struct Rates {
    engine: String,
    preset: String,
    /// Pushes in a call.
    batch: usize,
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

/// Pushes to be repeated, in states of one scene.
struct Source {
    scene: Arc<Scene>,
    pushes: Vec<(State, Push)>,
}

/// An engine and a preset.
struct Model {
    options: PhysicsOptions,
    batch: usize,
}

/// One call: pushes of one scene with the engine of one model.
struct Call {
    engine: Arc<dyn Transition>,
    /// The engine's number: each worker has a scratch for it.
    number: usize,
    pushes: Vec<(State, Push)>,
    results: Vec<PushResult>,
}

/// Everything that is timed together: one model, one number of bodies, one number of threads.
struct Variant {
    model: usize,
    bodies: usize,
    threads: usize,
    seconds: Vec<f64>,
}

/// Calls by model and number of bodies.
type Calls = BTreeMap<(usize, usize), Vec<Call>>;

pub fn run(args: &BenchPushArgs) -> Outcome<()> {
    if !(args.seconds.is_finite() && args.seconds > 0.0) {
        return Err(Failure::usage(format!("seconds: is {}; it must be greater than 0", args.seconds)));
    }
    if args.batch == Some(0) {
        return Err(Failure::usage("batch: is 0; it must be at least 1"));
    }
    let (source, sources) = match (&args.file, args.bodies) {
        (Some(path), _) => (path.display().to_string(), recorded(args)?),
        (None, Some(bodies)) => (format!("dense packs of {bodies}, seed {}", args.seed), dense(bodies, args.seed)?),
        (None, None) => (format!("pushes sampled in generated scenes, seed {}", args.seed), generated(args.seed)?),
    };
    let mut models = models(args)?;
    let mut groups = Calls::new();
    let mut engines = 0;
    // Of an engine's pushes on one thread, so that all rounds end in about the time given: two threads take half of that.
    let seconds = args.seconds / (models.len() * ROUNDS) as f64 / 1.5;
    for (m, model) in models.iter_mut().enumerate() {
        let network = physics::network(&model.options)?;
        let of_source = |s: &Source| physics::engine_with(&model.options, Arc::clone(&s.scene), network.as_ref());
        let engines_of = sources.iter().map(of_source).collect::<Result<Vec<_>, _>>()?;
        let Some(first) = engines_of.first() else { continue };
        model.batch = args.batch.unwrap_or(first.batch_size()).max(1);
        // As many in every scene: fewer of dear ones would make the mean cheaper.
        let once: f64 = sources.iter().zip(&engines_of).map(|(s, e)| push_time(e.as_ref(), s, model.batch)).sum();
        let affordable = (seconds / once.max(1e-9)) as usize + 1;
        for (source, engine) in sources.iter().zip(engines_of) {
            // Whole calls only: a short one at the end would be of another kind.
            let alike = sources.iter().filter(|other| other.scene.len() == source.scene.len()).count();
            let least = CALLS.div_ceil(alike.max(1)) * model.batch;
            let wanted = (PASSES * source.pushes.len()).max(least).min(affordable).next_multiple_of(model.batch);
            let pushes: Vec<_> = source.pushes.iter().cycle().take(wanted).cloned().collect();
            let calls = groups.entry((m, source.scene.len())).or_default();
            calls.extend(pushes.chunks(model.batch).map(|pushes| Call {
                engine: Arc::clone(&engine),
                number: engines,
                pushes: pushes.to_vec(),
                results: vec![PushResult::default(); pushes.len()],
            }));
            engines += 1;
        }
    }
    let (variants, rounds) = measure(&mut groups, engines, args.seconds)?;

    let several = models.iter().any(|m| m.options.engine != models[0].options.engine);
    let mut names = Vec::new();
    let mut report = Report {
        version: env!("CARGO_PKG_VERSION"),
        machine: Machine::this(),
        engine: args.physics.clone(),
        source,
        pushes: sources.iter().map(|s| s.pushes.len()).sum(),
        rounds,
        presets: BTreeMap::new(),
    };
    for (m, model) in models.iter().enumerate() {
        let PhysicsOptions { engine, preset, .. } = &model.options;
        let mut rates =
            Rates { engine: engine.clone(), preset: preset.clone(), batch: model.batch, ..Rates::default() };
        let (mut total, mut pushes) = ([0.0; 2], 0);
        for (&(_, bodies), calls) in groups.iter().filter(|((n, _), _)| *n == m) {
            let seconds = THREADS.map(|threads| {
                let variant = variants.iter().find(|v| v.model == m && v.bodies == bodies && v.threads == threads);
                variant.map_or(0.0, |v| statistics::median(&v.seconds))
            });
            let count: usize = calls.iter().map(|c| c.pushes.len()).sum();
            // Every push of the source counts once, however often its group was repeated.
            let own: usize = sources.iter().filter(|s| s.scene.len() == bodies).map(|s| s.pushes.len()).sum();
            let share = own as f64 / count.max(1) as f64;
            total.iter_mut().zip(seconds).for_each(|(t, s)| *t += s * share);
            pushes += own;
            rates.by_bodies.insert(bodies, Rate::new(count, seconds));
        }
        rates.all = Rate::new(pushes, total);
        let name = if several { format!("{engine} {preset}") } else { preset.clone() };
        names.push(name.clone());
        report.presets.insert(name, rates);
    }
    output::report(args.json.json.as_deref(), &report, &text(&report, &names))
}

/// What a push of the source takes about, in a call of so many; the first call warms the engine.
fn push_time(engine: &dyn Transition, source: &Source, batch: usize) -> f64 {
    let mut scratch = engine.scratch();
    let jobs = source.pushes.iter().cycle().take(batch).map(|(state, push)| PushJob { state, push: *push });
    let jobs: Vec<PushJob<'_>> = jobs.collect();
    let mut results = vec![PushResult::default(); jobs.len()];
    let mut seconds = 0.0;
    for _ in 0..2 {
        let start = Instant::now();
        engine.step_batch(&mut scratch, &jobs, &mut results, &Stop::never());
        seconds = start.elapsed().as_secs_f64();
    }
    seconds / batch as f64
}

/// The engines that were asked for, with the presets that are wanted of them.
fn models(args: &BenchPushArgs) -> Outcome<Vec<Model>> {
    let mut models = Vec::new();
    for name in args.physics.split(',').map(str::trim).filter(|name| !name.is_empty()) {
        let info = EngineInfo::find(name)?;
        for preset in info.presets {
            if args.preset.as_deref().is_none_or(|wanted| wanted == *preset) {
                let options =
                    PhysicsOptions { engine: name.into(), preset: (*preset).into(), ..PhysicsOptions::default() };
                models.push(Model { options, batch: 1 });
            }
        }
    }
    match (&args.preset, models.is_empty()) {
        (Some(preset), true) => Err(Failure::usage(format!("preset: no engine of `{}` has `{preset}`", args.physics))),
        (None, true) => Err(Failure::usage("physics: names no engine")),
        _ => Ok(models),
    }
}

/// Times the variants in turn, so that a machine that is busy for a while is busy for all of them.
fn measure(groups: &mut Calls, engines: usize, seconds: f64) -> Outcome<(Vec<Variant>, usize)> {
    let mut pools = Vec::new();
    for threads in THREADS {
        let pool = Pool::new(threads, "jostle-bench")?;
        let scratches: Vec<Mutex<Vec<Option<Scratch>>>> =
            (0..pool.workers()).map(|_| Mutex::new((0..engines).map(|_| None).collect())).collect();
        pools.push((threads, pool, scratches));
    }
    let mut variants: Vec<Variant> = groups
        .keys()
        .flat_map(|&(model, bodies)| THREADS.map(|threads| Variant { model, bodies, threads, seconds: Vec::new() }))
        .collect();
    let begin = Instant::now();
    let mut rounds = 0;
    let stop = Stop::never();
    while rounds < ROUNDS || begin.elapsed().as_secs_f64() < seconds {
        for variant in &mut variants {
            let Some(calls) = groups.get_mut(&(variant.model, variant.bodies)) else { continue };
            let Some((_, pool, scratches)) = pools.iter().find(|(threads, ..)| *threads == variant.threads) else {
                continue;
            };
            let start = Instant::now();
            pool.for_each_group(calls, 1, scratches, |scratches, calls| {
                for call in calls {
                    let Some(slot) = scratches.get_mut(call.number) else { continue };
                    let scratch = slot.get_or_insert_with(|| call.engine.scratch());
                    let jobs: Vec<PushJob<'_>> =
                        call.pushes.iter().map(|(state, push)| PushJob { state, push: *push }).collect();
                    call.engine.step_batch(scratch, &jobs, &mut call.results, &stop);
                    std::hint::black_box(&mut call.results);
                }
            })?;
            variant.seconds.push(start.elapsed().as_secs_f64());
        }
        rounds += 1;
    }
    Ok((variants, rounds))
}

/// The planar pushes of a file. Pushes of equal scenes are run together.
fn recorded(args: &BenchPushArgs) -> Outcome<Vec<Source>> {
    let Some(path) = &args.file else { return Ok(Vec::new()) };
    let mut sources: Vec<Source> = Vec::new();
    for recording in read_recordings(path)?.iter().filter(|r| r.is_planar()) {
        let scene = recording.scene()?;
        let push = (recording.state(), recording.push());
        match sources.iter_mut().find(|s| *s.scene == scene) {
            Some(source) => source.pushes.push(push),
            None => sources.push(Source { scene: Arc::new(scene), pushes: vec![push] }),
        }
    }
    if sources.is_empty() {
        return Err(Failure::usage(format!("{}: holds no planar push", path.display())));
    }
    Ok(sources)
}

fn text(report: &Report, names: &[String]) -> String {
    let mut table = Table::new(["preset", "batch", "bodies", "ms/push", "pushes/s, 1 thread", "2 threads"]);
    let cells = |name: &str, batch: String, bodies: String, rate: &Rate| {
        [
            name.to_string(),
            batch,
            bodies,
            number(Some(rate.ms_per_push_1_thread), 3),
            number(Some(rate.pushes_per_second_1_thread), 0),
            number(Some(rate.pushes_per_second_2_threads), 0),
        ]
    };
    for name in names {
        let Some(rates) = report.presets.get(name) else { continue };
        table.row(cells(name, rates.batch.to_string(), "all".into(), &rates.all));
        for (bodies, rate) in &rates.by_bodies {
            table.row(cells("", String::new(), bodies.to_string(), rate));
        }
    }
    format!(
        "{}: {} pushes, {}; median of {} rounds\n\n{table}",
        report.engine, report.pushes, report.source, report.rounds
    )
}

/// Pushes that a planner might try: up to 64 in each of 24 packed scenes, so that a batch is of different ones.
fn generated(seed: u64) -> Outcome<Vec<Source>> {
    let generator = Generator::new(GeneratorParams::default(), seed)?;
    let problems = (0..SCENES).map(|index| generator.problem(index)).collect::<Result<Vec<_>, _>>()?;
    sampled(problems, seed)
}

fn sampled(problems: Vec<Problem>, seed: u64) -> Outcome<Vec<Source>> {
    let sampler = ContourSampler::preset("more")?;
    let mut scratch = SamplerScratch::default();
    let sources = problems.into_iter().enumerate().map(|(index, problem)| {
        let mut pushes = Vec::new();
        let mut order = Key::new(seed).child(index as u64).stream();
        sampler.sample(&problem.scene, &problem.state, problem.target, None, &mut order, &mut scratch, &mut pushes);
        let pushes = pushes.into_iter().take(PUSHES).map(|push| (problem.state.clone(), push)).collect();
        Source { scene: problem.scene, pushes }
    });
    Ok(sources.filter(|source| !source.pushes.is_empty()).collect())
}

/// Packs without gaps: blocks of several shapes in rows, 2 mm between their bounding boxes, so that a push moves many.
fn dense(bodies: usize, seed: u64) -> Outcome<Vec<Source>> {
    const GAP: f64 = 0.002;
    let side = 0.045;
    let shapes = [
        (Shape::rectangle(side, side), [side, side]),
        (Shape::rectangle(2.0 * side, side), [2.0 * side, side]),
        (Shape::rectangle(side / 2.0, side), [side / 2.0, side]),
        (Shape::Disc { radius: side / 2.0 }, [side, side]),
        (
            Shape::ConvexPolygon(vec![[side / 2.0, side / 2.0], [-side / 2.0, side / 2.0], [-side / 2.0, -side / 2.0]]),
            [side, side],
        ),
    ];
    // About square: a block is 1.2 sides wide in the mean.
    let width = (bodies as f64 * 1.2).sqrt() * side;
    let mut problems = Vec::new();
    for index in 0..SCENES {
        let mut random = Key::new(seed).child(index).stream();
        let mut builder = SceneBuilder::new();
        let (mut poses, mut x, mut y) = (Vec::new(), 0.0, 0.0);
        for _ in 0..bodies {
            let (shape, size) = &shapes[random.index(shapes.len())];
            if x + size[0] > width && x > 0.0 {
                (x, y) = (0.0, y + side + GAP);
            }
            builder.add_body(BodyDef::new(shape.clone()))?;
            poses.push(Pose2::new(0.5 + x + size[0] / 2.0 - width / 2.0, y - width / 2.0, 0.0));
            x += size[0] + GAP;
        }
        let scene = Arc::new(builder.build()?);
        problems.push(Problem::new(format!("pack {index}"), scene, State::new(poses), 0)?);
    }
    sampled(problems, seed)
}
