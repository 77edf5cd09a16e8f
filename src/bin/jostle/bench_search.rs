//! `jostle bench search`: what the search costs, and whether it keeps its promises.

use std::collections::BTreeMap;
use std::process::Stdio;
use std::time::{Duration, Instant};

use jostle::eval::{needs_push, push_travel, retrieval_of, statistics, with_gripper};
use jostle::physics::{PhysicsOptions, Purpose};
use jostle::plan::{Control, PLANNERS, Planner, PlannerOptions};
use jostle::run::{Budget, CancelToken, Key};
use jostle::scene::generate::{Generator, GeneratorParams};
use jostle::scene::{Input, InputKind, MAX_BODIES, Problem};
use serde::Serialize;

use crate::args::{BenchSearchArgs, ProfileArg};
use crate::bench_limits::{self, Limits};
use crate::output::{self, Failure, Machine, Outcome};
use crate::table::{Table, number};

/// Runs of every variant where a median is taken.
const ROUNDS: usize = 5;
/// Iterations where the budget is one of iterations and none is asked for.
const ITERATIONS: u64 = 500;
const THREADS: [usize; 3] = [1, 2, 5];
/// Time limits of the punctuality test, milliseconds.
const LIMITS_MS: [f64; 2] = [2.0, 20.0];
/// Budget of a first plan, seconds: as in a controller that wants an answer at once.
const FIRST_PLAN_SECONDS: f64 = 0.025;
/// Starts of the tool that are timed.
const STARTS: usize = 10;

#[derive(Serialize)]
struct Report {
    #[serde(flatten)]
    search: Option<SearchReport>,
    /// Every planner with few and many bodies, at short and long limits, and cancelled.
    limits: Limits,
}

#[derive(Serialize)]
struct SearchReport {
    version: &'static str,
    machine: Machine,
    scene: String,
    bodies: usize,
    seed: u64,
    /// By planner, on one thread.
    bookkeeping: BTreeMap<String, Bookkeeping>,
    deadline: Deadline,
    cancel: Tail,
    same_plan: SamePlan,
    first_plan: FirstPlan,
}

/// Time of the search outside of physics, grasp test and sampling.
#[derive(Serialize)]
struct Bookkeeping {
    us_per_simulation: f64,
    simulations: u64,
    simulations_per_second: f64,
}

/// How late decisions with a time limit return.
#[derive(Serialize)]
struct Deadline {
    decisions: usize,
    /// Decisions that the limit ended; the others found an end of their own before.
    ended_by_limit: usize,
    overrun_ms: Tail,
}

#[derive(Serialize)]
pub struct Tail {
    pub count: usize,
    pub p50_ms: f64,
    pub p99_ms: f64,
    pub max_ms: f64,
}

impl Tail {
    pub fn of(ms: &[f64]) -> Tail {
        Tail {
            count: ms.len(),
            p50_ms: statistics::median(ms),
            p99_ms: statistics::percentile(ms, 0.99),
            max_ms: statistics::max(ms),
        }
    }
}

/// Hashes of the plan at several numbers of threads.
#[derive(Serialize)]
struct SamePlan {
    iterations: u64,
    equal: bool,
    hash_by_threads: BTreeMap<usize, String>,
}

/// From the start of a process to its first plan, within a budget of [`FIRST_PLAN_SECONDS`]: the rest is start-up.
#[derive(Serialize)]
struct FirstPlan {
    /// New process: the library is loaded, the scene read, one iteration planned, the plan written.
    process_ms: Tail,
    /// The same within a running process, from planner and scene to plan.
    call_ms: Tail,
}

pub fn run(args: &BenchSearchArgs) -> Outcome<()> {
    let options = args.planner.options()?;
    if args.decisions == 0 {
        return Err(Failure::usage("decisions: is 0; at least one is needed"));
    }
    if args.each < 4 {
        return Err(Failure::usage(format!("each: is {}; at least 4 are needed, one for each limit", args.each)));
    }
    if let Some(bodies) = args.bodies.iter().find(|n| !(1..=MAX_BODIES).contains(*n)) {
        return Err(Failure::usage(format!("bodies: is {bodies}; it must lie in 1 to {MAX_BODIES}")));
    }
    let search = if args.limits_only { None } else { Some(search(args, &options)?) };
    let report = Report { search, limits: bench_limits::measure(args, options.seed)? };
    let first = report.search.as_ref().map(text).unwrap_or_default();
    output::report(args.json.json.as_deref(), &report, &format!("{first}{}", bench_limits::text(&report.limits)))
}

fn search(args: &BenchSearchArgs, options: &PlannerOptions) -> Outcome<SearchReport> {
    let mut options = options.clone();
    let mut problem = match &args.scene {
        Some(path) => {
            let input = Input::read(path)?;
            if input.kind == InputKind::Original {
                options.push_length.get_or_insert(push_travel(ProfileArg::Auto.of(path)));
            }
            retrieval_of(&input, None)?
        }
        None => seven_bodies(options.seed)?,
    };
    if let Some(gripper) = args.planner.gripper()? {
        problem = with_gripper(&problem, &gripper)?;
    }
    let bench = Bench { endless: unsolvable(&problem)?, problem, options };
    Ok(SearchReport {
        version: env!("CARGO_PKG_VERSION"),
        machine: Machine::this(),
        scene: bench.problem.name.clone(),
        bodies: bench.problem.state.present().count(),
        seed: bench.options.seed,
        bookkeeping: bench.bookkeeping()?,
        deadline: bench.deadline(args.decisions)?,
        cancel: bench.cancel((args.decisions / 5).max(1))?,
        same_plan: bench.same_plan()?,
        first_plan: bench.first_plan()?,
    })
}

/// A generated problem of seven bodies that needs a push.
fn seven_bodies(seed: u64) -> Outcome<Problem> {
    let generator = Generator::new(GeneratorParams { bodies: 7..=7, ..GeneratorParams::default() }, seed)?;
    let problems = generator.generate_filtered(1, |problem| needs_push(problem).unwrap_or(false))?;
    problems.into_iter().next().ok_or_else(|| Failure::failed("the generator made no scene of seven bodies"))
}

/// The problem for a jaw so bulky that no state is a solution: a search in it lasts until its limit, and does the same
/// work on the way.
fn unsolvable(problem: &Problem) -> Outcome<Problem> {
    let mut gripper = problem.scene.gripper().clone();
    // So large that something is always in their way, but for a target that is alone.
    gripper.grasp.finger_width = 2.0;
    gripper.grasp.finger_thickness = 2.0;
    Ok(with_gripper(problem, &gripper)?)
}

struct Bench {
    problem: Problem,
    /// The same without a solution.
    endless: Problem,
    options: PlannerOptions,
}

impl Bench {
    fn iterations(&self) -> u64 {
        self.options.budget.iterations.unwrap_or(ITERATIONS)
    }

    fn planner(&self, budget: Budget, change: impl FnOnce(&mut PlannerOptions)) -> Outcome<Planner> {
        let mut options = PlannerOptions { budget, ..self.options.clone() };
        change(&mut options);
        Ok(Planner::new(options)?)
    }

    fn bookkeeping(&self) -> Outcome<BTreeMap<String, Bookkeeping>> {
        let mut planners = Vec::new();
        for name in PLANNERS {
            let planner = self.planner(Budget::iterations(self.iterations()), |o| {
                o.planner = name.into();
                o.threads = 1;
                // The search is measured, not the networks.
                o.scorer = Some("geometric".into());
                o.prior = Some("none".into());
                if o.physics.is_none() && matches!(name, "vft" | "dipn") {
                    o.physics = PhysicsOptions::named("planar", None, Purpose::Planning).ok();
                }
            })?;
            planners.push((name, planner, Vec::new(), Vec::new(), 0));
        }
        for _ in 0..ROUNDS {
            for (_, planner, bookkeeping, rates, simulations) in &mut planners {
                planner.reset();
                let s = planner.solve(&self.endless, &Control::default())?.statistics;
                *simulations = s.simulations;
                bookkeeping.push(s.search_seconds * 1e6 / s.simulations.max(1) as f64);
                rates.push(if s.seconds > 0.0 { s.simulations as f64 / s.seconds } else { 0.0 });
            }
        }
        let result = planners.into_iter().map(|(name, _, bookkeeping, rates, simulations)| {
            let us_per_simulation = statistics::median(&bookkeeping);
            let simulations_per_second = statistics::median(&rates);
            (name.to_string(), Bookkeeping { us_per_simulation, simulations, simulations_per_second })
        });
        Ok(result.collect())
    }

    fn deadline(&self, decisions: usize) -> Outcome<Deadline> {
        let mut draw = Key::new(self.options.seed).child(1).stream();
        let limits: Vec<f64> = (0..8).map(|_| draw.uniform(LIMITS_MS[0], LIMITS_MS[1])).collect();
        let mut planners = Vec::new();
        for &limit in &limits {
            planners.push((limit, self.planner(Budget::seconds(limit * 1e-3), |_| ())?));
        }
        let mut late = Vec::new();
        for decision in 0..decisions {
            let (limit, planner) = &mut planners[decision % limits.len()];
            planner.reset();
            let start = Instant::now();
            planner.solve(&self.endless, &Control::default())?;
            let overrun = start.elapsed().as_secs_f64() * 1e3 - *limit;
            if overrun >= 0.0 {
                late.push(overrun);
            }
        }
        Ok(Deadline { decisions, ended_by_limit: late.len(), overrun_ms: Tail::of(&late) })
    }

    /// From the trigger, on another thread, to the return of the call.
    fn cancel(&self, decisions: usize) -> Outcome<Tail> {
        let mut planner = self.planner(Budget::seconds(10.0), |_| ())?;
        let mut draw = Key::new(self.options.seed).child(2).stream();
        let mut waits = Vec::new();
        for _ in 0..decisions {
            planner.reset();
            let token = CancelToken::new();
            let control = Control { cancel: vec![token.clone()], ..Control::default() };
            let delay = Duration::from_secs_f64(draw.uniform(1e-3, 10e-3));
            let triggering = std::thread::spawn(move || {
                std::thread::sleep(delay);
                let now = Instant::now();
                token.trigger();
                now
            });
            planner.solve(&self.endless, &control)?;
            let returned = Instant::now();
            let triggered = triggering.join().map_err(|_| Failure::failed("the cancelling thread ended early"))?;
            // A search that ended before it was cancelled says nothing.
            if let Some(wait) = returned.checked_duration_since(triggered) {
                waits.push(wait.as_secs_f64() * 1e3);
            }
        }
        Ok(Tail::of(&waits))
    }

    fn same_plan(&self) -> Outcome<SamePlan> {
        let mut hash_by_threads = BTreeMap::new();
        for threads in THREADS {
            let mut planner = self.planner(Budget::iterations(self.iterations()), |o| o.threads = threads)?;
            let plan = planner.solve(&self.endless, &Control::default())?;
            hash_by_threads.insert(threads, format!("{:016x}", plan.hash_bits()));
        }
        let mut hashes: Vec<&String> = hash_by_threads.values().collect();
        hashes.dedup();
        Ok(SamePlan { iterations: self.iterations(), equal: hashes.len() == 1, hash_by_threads })
    }

    fn first_plan(&self) -> Outcome<FirstPlan> {
        let tool = std::env::current_exe().map_err(|e| Failure::failed(format!("the tool's own file: {e}")))?;
        let scene = std::env::temp_dir().join(format!("jostle-bench-{}.json", std::process::id()));
        output::write_file(&scene, &self.problem.to_json()?)?;
        let (mut process_ms, mut call_ms) = (Vec::new(), Vec::new());
        let mut outcome = Ok(());
        for _ in 0..STARTS {
            let start = Instant::now();
            let status = std::process::Command::new(&tool)
                .arg("plan")
                .arg(&scene)
                .args(["--seconds", &FIRST_PLAN_SECONDS.to_string(), "--threads", "1", "--json", "-"])
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .status();
            process_ms.push(start.elapsed().as_secs_f64() * 1e3);
            if !status.is_ok_and(|s| s.success()) {
                outcome = Err(Failure::failed("the tool could not be started again to time its first plan"));
                break;
            }
            let start = Instant::now();
            let mut planner = self.planner(Budget::seconds(FIRST_PLAN_SECONDS), |o| o.threads = 1)?;
            planner.solve(&self.problem, &Control::default())?;
            call_ms.push(start.elapsed().as_secs_f64() * 1e3);
        }
        // A temporary file that stays behind does no harm.
        let _ = std::fs::remove_file(&scene);
        outcome?;
        Ok(FirstPlan { process_ms: Tail::of(&process_ms), call_ms: Tail::of(&call_ms) })
    }
}

fn text(r: &SearchReport) -> String {
    let mut table = Table::new(["", "p50", "p99", "max"]);
    let mut tail = |name: String, t: &Tail, digits: usize| {
        table.row([
            name,
            number(Some(t.p50_ms), digits),
            number(Some(t.p99_ms), digits),
            number(Some(t.max_ms), digits),
        ]);
    };
    let d = &r.deadline;
    tail(format!("late after a deadline, ms ({} of {} decisions)", d.ended_by_limit, d.decisions), &d.overrun_ms, 3);
    tail(format!("from cancel to return, ms ({})", r.cancel.count), &r.cancel, 3);
    tail("start of the tool to a first plan, ms".into(), &r.first_plan.process_ms, 1);
    tail("new planner to a first plan, ms".into(), &r.first_plan.call_ms, 3);
    let bookkeeping: String = r
        .bookkeeping
        .iter()
        .map(|(name, b)| {
            format!(
                "{name}: {:.2} us of bookkeeping for each of {} simulated pushes, {:.0} pushes/s on one thread\n",
                b.us_per_simulation, b.simulations, b.simulations_per_second
            )
        })
        .collect();
    let same = if r.same_plan.equal { "the same plan" } else { "NOT the same plan" };
    let threads: Vec<String> = r.same_plan.hash_by_threads.keys().map(usize::to_string).collect();
    format!(
        "{}: {} bodies\n\n{table}\n{bookkeeping}{same} at {} threads ({} iterations)\n\n",
        r.scene,
        r.bodies,
        threads.join(", "),
        r.same_plan.iterations
    )
}
