//! `jostle bench search`, its second part: how every planner keeps a time limit and obeys a cancel.
//!
//! Each decision is on another scene than the one before, so that everything that is made for a scene counts. Half of
//! them have no solution (the jaw is too bulky) and last until the limit; the other half are as they come.
//!
//! CPU time is that of the process: on a busy machine the wall clock says more of the machine than of the planner. A
//! second thread sleeps until the limit, or until it cancels, and notes the clock then.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use jostle::Error;
use jostle::geom::{Pose2, Shape};
use jostle::plan::clear::{CLEAR_PLANNERS, ClearOptions, ClearPlanner};
use jostle::plan::rearrange::{REARRANGE_PLANNERS, RearrangeOptions, RearrangePlanner};
use jostle::plan::{Control, Outcome as Ending, PLANNERS, Planner, PlannerOptions};
use jostle::run::{Budget, CancelToken, Key, Stream};
use jostle::scene::{BodyDef, Clearing, Goal, Gripper, Problem, Rearrangement, Scene, SceneBuilder, State, Workspace};
use rustix::time::{ClockId, clock_gettime};
use serde::Serialize;

use crate::args::BenchSearchArgs;
use crate::bench_search::Tail;
use crate::output::{Failure, Outcome};
use crate::table::{Table, number, percent};

/// Time limits, milliseconds.
const LIMITS_MS: [f64; 4] = [1.0, 5.0, 20.0, 100.0];
/// Scenes of each number of bodies, one after the other.
const SCENES: u64 = 8;
/// A cancel comes so long after the beginning, milliseconds.
const CANCEL_MS: [f64; 2] = [0.2, 10.0];
/// The second thread has kept its turn if it triggers within so long of noting the time, milliseconds.
const SLIP_MS: f64 = 0.05;
/// Limit of a decision that is to be cancelled, seconds.
const LONG: f64 = 20.0;
/// Side of the squares that packs are made of and of those that are rearranged, metres.
const PACKED: f64 = 0.05;
const SPREAD: f64 = 0.085;

/// One planner with one number of bodies.
#[derive(Serialize)]
pub struct Kept {
    planner: String,
    bodies: usize,
    /// Over all limits: of the decisions that the limit ended.
    cpu_overrun_ms: Tail,
    overrun_ms: Tail,
    by_limit: Vec<ByLimit>,
    /// From the trigger to the return of the call.
    cancel_cpu_ms: Tail,
    cancel_ms: Tail,
    /// Decisions that ended by themselves before they were cancelled, or whose cancel has no certain time.
    not_cancelled: usize,
}

#[derive(Serialize)]
struct ByLimit {
    limit_ms: f64,
    decisions: usize,
    ended_by_limit: usize,
    /// Share of the decisions with an action, of those that a limit could leave without one.
    had_action: f64,
    cpu_overrun_ms: Tail,
    overrun_ms: Tail,
}

/// What is measured.
#[derive(Serialize)]
pub struct Limits {
    rows: Vec<Kept>,
    /// Planners that this build or machine has not all parts of, with the reason.
    left_out: Vec<String>,
}

pub fn measure(args: &BenchSearchArgs, seed: u64) -> Outcome<Limits> {
    let every = || PLANNERS.iter().chain(&CLEAR_PLANNERS).chain(&REARRANGE_PLANNERS);
    let names: Vec<&str> = match args.planners.is_empty() {
        true => every().copied().collect(),
        false => args.planners.iter().map(String::as_str).collect(),
    };
    if let Some(unknown) = names.iter().find(|name| !every().any(|known| known == *name)) {
        let known = every().copied().collect::<Vec<_>>().join(", ");
        return Err(Failure::usage(format!("planners: there is no `{unknown}`; there are {known}")));
    }
    let mut limits = Limits { rows: Vec::new(), left_out: Vec::new() };
    let watch = Watch::new();
    for name in names {
        match AnyPlanner::new(name, Budget::seconds(1.0), seed) {
            Ok(_) => {}
            Err(error @ (Error::Unsupported(_) | Error::Runtime(_))) => {
                limits.left_out.push(format!("{name}: {}", error.to_string().lines().next().unwrap_or_default()));
                continue;
            }
            Err(error) => return Err(error.into()),
        }
        for &bodies in &args.bodies {
            limits.rows.push(row(name, bodies, args.each, seed, &watch)?);
        }
    }
    Ok(limits)
}

fn row(name: &str, bodies: usize, decisions: usize, seed: u64, watch: &Watch) -> Outcome<Kept> {
    let kind = Kind::of(name);
    let tasks = (0..SCENES)
        .map(|i| Task::new(kind, bodies, i.is_multiple_of(2), Key::new(seed).child(i)))
        .collect::<Outcome<Vec<_>>>()?;
    let (mut cpu, mut wall, mut by_limit) = (Vec::new(), Vec::new(), Vec::new());
    for (at, limit_ms) in LIMITS_MS.into_iter().enumerate() {
        let mut planner = AnyPlanner::new(name, Budget::seconds(limit_ms * 1e-3), seed)?;
        let decisions = (decisions + at) / LIMITS_MS.len();
        let (mut cpu_here, mut wall_here, mut acted) = (Vec::new(), Vec::new(), 0);
        for decision in 0..decisions {
            let task = &tasks[decision % tasks.len()];
            let run = watch.limited(limit_ms * 1e-3, || planner.decide(task, &Control::default()))?;
            acted += usize::from(run.acted);
            if run.wall_ms >= limit_ms {
                wall_here.push(run.wall_ms - limit_ms);
                cpu_here.push(run.over_ms.max(run.cpu_ms - limit_ms).clamp(0.0, run.wall_ms - limit_ms));
            }
        }
        by_limit.push(ByLimit {
            limit_ms,
            decisions,
            ended_by_limit: wall_here.len(),
            had_action: acted as f64 / decisions.max(1) as f64,
            cpu_overrun_ms: Tail::of(&cpu_here),
            overrun_ms: Tail::of(&wall_here),
        });
        cpu.append(&mut cpu_here);
        wall.append(&mut wall_here);
    }
    let mut planner = AnyPlanner::new(name, Budget::seconds(LONG), seed)?;
    let mut draw = Key::new(seed).child(SCENES).stream();
    let (mut cancel_cpu, mut cancel, mut not_cancelled) = (Vec::new(), Vec::new(), 0);
    for decision in 0..decisions {
        let task = &tasks[decision % tasks.len()];
        let token = CancelToken::new();
        let control = Control { cancel: vec![token.clone()], ..Control::default() };
        let after = draw.uniform(CANCEL_MS[0], CANCEL_MS[1]) * 1e-3;
        match watch.cancelled(after, &token, || planner.decide(task, &control))? {
            Some((cpu, wall)) => {
                cancel_cpu.push(cpu);
                cancel.push(wall);
            }
            None => not_cancelled += 1,
        }
    }
    Ok(Kept {
        planner: name.into(),
        bodies,
        cpu_overrun_ms: Tail::of(&cpu),
        overrun_ms: Tail::of(&wall),
        by_limit,
        cancel_cpu_ms: Tail::of(&cancel_cpu),
        cancel_ms: Tail::of(&cancel),
        not_cancelled,
    })
}

/// CPU time of the process, milliseconds.
fn cpu_ms() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 * 1e3 + now.tv_nsec as f64 * 1e-6
}

/// The second thread: sleeps, triggers a token if it was given one, and notes both clocks before and after that.
struct Watch {
    ask: Sender<(Instant, Option<CancelToken>)>,
    noted: Receiver<Noted>,
}

/// Both clocks when the second thread woke up, and how long it then took over its notes.
struct Noted {
    at: Instant,
    cpu_ms: f64,
    wall_ms: f64,
}

/// What a decision with a limit took.
struct Limited {
    acted: bool,
    cpu_ms: f64,
    wall_ms: f64,
    /// CPU time since the second thread saw the limit pass; 0 if the decision had returned by then.
    over_ms: f64,
}

impl Watch {
    fn new() -> Watch {
        let (ask, asked) = channel::<(Instant, Option<CancelToken>)>();
        let (note, noted) = channel();
        // Ends with the sender.
        std::thread::spawn(move || {
            for (at, token) in asked {
                std::thread::sleep(at.saturating_duration_since(Instant::now()));
                let (woken, cpu_ms) = (Instant::now(), cpu_ms());
                if let Some(token) = token {
                    token.trigger();
                }
                let wall_ms = woken.elapsed().as_secs_f64() * 1e3;
                if note.send(Noted { at: woken, cpu_ms, wall_ms }).is_err() {
                    break;
                }
            }
        });
        Watch { ask, noted }
    }

    fn begin(&self, after: f64, token: Option<CancelToken>) -> Outcome<Instant> {
        let start = Instant::now();
        let gone = || Failure::failed("the watching thread ended early");
        self.ask.send((start + Duration::from_secs_f64(after), token)).map_err(|_| gone())?;
        Ok(start)
    }

    fn end(&self) -> Outcome<Noted> {
        self.noted.recv().map_err(|_| Failure::failed("the watching thread ended early"))
    }

    fn limited(&self, limit: f64, decide: impl FnOnce() -> Outcome<Decision>) -> Outcome<Limited> {
        self.begin(limit, None)?;
        let (start, before) = (Instant::now(), cpu_ms());
        let decided = decide()?;
        let (returned, after) = (Instant::now(), cpu_ms());
        let noted = self.end()?;
        Ok(Limited {
            acted: decided.acted,
            cpu_ms: after - before,
            wall_ms: (returned - start).as_secs_f64() * 1e3,
            over_ms: if noted.at < returned { after - noted.cpu_ms } else { 0.0 },
        })
    }

    /// CPU and wall milliseconds from the trigger to the return; none where the decision ended before, or where the second
    /// thread lost its turn between its note of the time and the trigger: how long it waited would count too.
    fn cancelled(
        &self,
        after: f64,
        token: &CancelToken,
        decide: impl FnOnce() -> Outcome<Decision>,
    ) -> Outcome<Option<(f64, f64)>> {
        self.begin(after, Some(token.clone()))?;
        let decided = decide()?;
        let (returned, cpu) = (Instant::now(), cpu_ms());
        let noted = self.end()?;
        let told = decided.cancelled && noted.wall_ms < SLIP_MS;
        let late = returned.checked_duration_since(noted.at).filter(|_| told);
        let late_ms = late.map(|late| late.as_secs_f64() * 1e3);
        // The second thread's note of the first one's time is old by up to a tick of the scheduler; one thread has used no
        // more CPU than time has passed.
        Ok(late_ms.map(|late_ms| ((cpu - noted.cpu_ms).clamp(0.0, late_ms), late_ms)))
    }
}

/// What a decision came to.
struct Decision {
    acted: bool,
    cancelled: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Retrieval,
    Clearing,
    Rearrangement,
}

impl Kind {
    fn of(planner: &str) -> Kind {
        match planner {
            name if CLEAR_PLANNERS.contains(&name) => Kind::Clearing,
            name if REARRANGE_PLANNERS.contains(&name) => Kind::Rearrangement,
            _ => Kind::Retrieval,
        }
    }
}

enum AnyPlanner {
    Retrieval(Box<Planner>),
    Clearing(Box<ClearPlanner>),
    Rearrangement(Box<RearrangePlanner>),
}

impl AnyPlanner {
    fn new(name: &str, budget: Budget, seed: u64) -> Result<AnyPlanner, Error> {
        // One thread: the process's CPU time is the decision's.
        let options = PlannerOptions { planner: name.into(), budget, seed, threads: 1, ..PlannerOptions::default() };
        Ok(match Kind::of(name) {
            Kind::Retrieval => AnyPlanner::Retrieval(Box::new(Planner::new(options)?)),
            Kind::Clearing => AnyPlanner::Clearing(Box::new(ClearPlanner::new(ClearOptions::of(options))?)),
            Kind::Rearrangement => {
                let options =
                    RearrangeOptions { planner: name.into(), budget, seed, threads: 1, ..RearrangeOptions::default() };
                AnyPlanner::Rearrangement(Box::new(RearrangePlanner::new(options)?))
            }
        })
    }

    fn decide(&mut self, task: &Task, control: &Control) -> Outcome<Decision> {
        let (outcome, actions) = match (self, task) {
            (AnyPlanner::Retrieval(planner), Task::Retrieval(problem)) => {
                let plan = planner.solve(problem, control)?;
                (plan.outcome, plan.actions.len())
            }
            (AnyPlanner::Clearing(planner), Task::Clearing(problem)) => {
                let plan = planner.solve(problem, control)?;
                (plan.outcome, plan.actions.len())
            }
            (AnyPlanner::Rearrangement(planner), Task::Rearrangement(problem)) => {
                let plan = planner.solve(problem, control)?;
                (plan.outcome, plan.moves.len())
            }
            _ => return Err(Failure::failed("a planner was given a task of another kind")),
        };
        Ok(Decision {
            acted: actions > 0 || matches!(outcome, Ending::Solved | Ending::Infeasible),
            cancelled: outcome == Ending::Cancelled,
        })
    }
}

enum Task {
    Retrieval(Problem),
    Clearing(Clearing),
    Rearrangement(Rearrangement),
}

impl Task {
    /// `endless`: the jaw is so bulky that nothing can be grasped (a rearrangement knows no such thing).
    fn new(kind: Kind, bodies: usize, endless: bool, key: Key) -> Outcome<Task> {
        let mut draw = key.stream();
        let name = format!("{bodies} bodies");
        if kind == Kind::Rearrangement {
            let (scene, state, slots) = lattice(bodies, SPREAD, false, &mut draw)?;
            let mut order: Vec<usize> = (0..bodies).collect();
            draw.shuffle(&mut order);
            let goals = order.iter().map(|&slot| Some(Goal::at(slots[slot]))).collect();
            return Ok(Task::Rearrangement(Rearrangement::new(name, scene, state, goals)?));
        }
        let (scene, state, slots) = lattice(bodies, PACKED, endless, &mut draw)?;
        if kind == Kind::Clearing {
            return Ok(Task::Clearing(Clearing::new(name, scene, state)?));
        }
        // The body in the middle of the pack.
        let middle = slots.iter().fold([0.0; 2], |sum, p| [sum[0] + p.x, sum[1] + p.y]).map(|s| s / bodies as f64);
        let off = |p: &Pose2| (p.x - middle[0]).hypot(p.y - middle[1]);
        let target = (0..bodies).min_by(|&a, &b| off(&slots[a]).total_cmp(&off(&slots[b]))).unwrap_or(0);
        Ok(Task::Retrieval(Problem::new(name, scene, state, target)?))
    }
}

/// Blocks, discs and concave blocks on a square lattice, a little off their places and headings.
fn lattice(bodies: usize, pitch: f64, bulky: bool, draw: &mut Stream) -> Outcome<(Arc<Scene>, State, Vec<Pose2>)> {
    let columns = (bodies as f64).sqrt().ceil() as usize;
    let rows = bodies.div_ceil(columns);
    let half = 0.5 * pitch * columns as f64 + 0.12;
    let mut builder = SceneBuilder::new();
    builder.workspace(Workspace { min: [-half, -half], max: [half, half], ..Workspace::default() });
    if bulky {
        let mut gripper = Gripper::default();
        // Something is always in their way.
        gripper.grasp.finger_width = 2.0;
        gripper.grasp.finger_thickness = 2.0;
        builder.gripper(gripper);
    }
    let mut poses = Vec::with_capacity(bodies);
    for i in 0..bodies {
        let side = draw.uniform(0.040, 0.046);
        let shape = match draw.index(4) {
            0 | 1 => Shape::rectangle(side, draw.uniform(0.040, 0.046)),
            2 => Shape::Disc { radius: side / 2.0 },
            _ => Shape::Polygon(notched(side)),
        };
        builder.add_body(BodyDef::new(shape))?;
        let (column, row) = ((i % columns) as f64, (i / columns) as f64);
        let (x, y) = (column - (columns - 1) as f64 / 2.0, row - (rows - 1) as f64 / 2.0);
        let mut jitter = || draw.uniform(-0.0005, 0.0005);
        let (dx, dy) = (jitter(), jitter());
        poses.push(Pose2::new(x * pitch + dx, y * pitch + dy, draw.uniform(-0.02, 0.02)));
    }
    let scene = Arc::new(builder.build()?);
    let state = State::new(poses.clone());
    Ok((scene, state, poses))
}

/// A square with a notch in one side: two convex pieces and more.
fn notched(side: f64) -> Vec<[f64; 2]> {
    let (h, n) = (side / 2.0, side / 6.0);
    vec![[-h, -h], [h, -h], [h, h], [n, h], [n, 0.0], [-n, 0.0], [-n, h], [-h, h]]
}

pub fn text(limits: &Limits) -> String {
    let heading = ["planner, bodies", "acted at 1 ms", "5 ms", "20 ms", "100 ms"];
    let tails = ["CPU over p50", "p99", "max", "cancel CPU p50", "p99", "max"];
    let mut table = Table::new(heading.into_iter().chain(tails));
    for row in &limits.rows {
        let mut cells = vec![format!("{} {}", row.planner, row.bodies)];
        cells.extend(row.by_limit.iter().map(|limit| percent(Some(limit.had_action))));
        for tail in [&row.cpu_overrun_ms, &row.cancel_cpu_ms] {
            cells.extend([tail.p50_ms, tail.p99_ms, tail.max_ms].map(|ms| number(Some(ms), 3)));
        }
        table.row(cells);
    }
    let left_out: String = limits.left_out.iter().map(|line| format!("left out: {line}\n")).collect();
    format!("how each planner keeps its limits, milliseconds\n\n{table}{left_out}")
}
