//! The search of `untangle`: many attempts, of which the best plan is kept and improved piece by piece.
//!
//! An attempt solves the whole problem, forwards or backwards (moves can be undone), or, once there is a plan, the piece
//! of it between two of its states, with fewer moves or in less time than the piece takes. Fewer moves come first, then
//! robot time. A batch of attempts starts from the same plan and is looked at in order, so that threads change nothing.

use std::sync::{Arc, Mutex, PoisonError};

use super::bridge::{Bridge, Span};
use super::mover::Mover;
use super::table::Layout;
use super::untangle::{Course, Worker, attempt, least_seconds, lower_bound, reversed};
use crate::action::Move;
use crate::error::Result;
use crate::geom::footprints_apart;
use crate::run::{Budget, Key, Pool, Progress, ProgressSnapshot, Stop, Stream};
use crate::scene::{PLACE_SLACK, Rearrangement, State};

/// Batches without a better plan after which the search ends, where the plan cannot have fewer moves and where it may.
const PATIENCE_PROVEN: u32 = 8;
const PATIENCE: u32 = 200;
/// The latter for a plan that an earlier decision has made and improved.
const PATIENCE_KNOWN: u32 = 8;
/// Robot times that differ by no more are the same, seconds.
const SAME_SECONDS: f64 = 1e-9;
/// Chance that an attempt starts afresh although there is a plan.
const AFRESH: f64 = 0.15;

/// Batches without a plan after which attempts lead from one state to another that earlier ones have come to, most of them:
/// how likely, after how many moves such an attempt ends, and the chance that it makes room.
const ALONE: u64 = 8;
const BRIDGES: f64 = 0.75;
const BRIDGE_MOVES: usize = 3;
const BRIDGE_ROOM: f64 = 0.3;

/// A plan in the making.
#[derive(Debug, Clone, Default)]
pub struct Candidate {
    pub moves: Vec<Move>,
    pub seconds: f64,
    /// Every body is home at its end.
    pub solved: bool,
    /// Bodies that are not.
    pub misplaced: usize,
}

/// What a search may use.
pub struct Limits<'a> {
    pub pool: &'a Pool,
    pub stop: &'a Stop,
    pub budget: Budget,
    pub progress: Option<&'a Progress>,
    pub lanes: usize,
    pub max_moves: usize,
    pub seed: u64,
}

/// What came of it.
#[derive(Debug, Clone, Default)]
pub struct Found {
    pub best: Candidate,
    pub attempts: u64,
    /// Fewest moves that any plan has.
    pub at_least: usize,
    /// The search ended by itself.
    pub settled: bool,
    /// Its memory ended it.
    pub full: bool,
}

/// A piece of work for one worker.
struct Task {
    mover: Arc<Mover>,
    start: Layout,
    course: Course,
    backwards: bool,
    /// It leads from a state of one tree to one of the other.
    span: Option<Span>,
    /// The piece of the best plan to be replaced.
    piece: std::ops::Range<usize>,
    key: Key,
    /// To be filled: moves, forwards, and bodies left misplaced; `None` if it was interrupted.
    moves: Vec<Move>,
    /// Where an attempt between the trees has come to.
    end: State,
    solved: bool,
    misplaced: usize,
}

/// Searches from the problem's start; `known` is a plan to begin with.
pub fn search(
    mover: &Arc<Mover>,
    workers: &mut Vec<Mutex<Worker>>,
    known: Option<Vec<Move>>,
    limits: &Limits,
) -> Result<Found> {
    workers.resize_with(limits.pool.workers(), Mutex::default);
    let start = Layout::new(&mover.table.problem.start);
    let backwards = backwards(mover);
    let at_least = lower_bound(mover, &start, limits.stop);
    let least_seconds = least_seconds(mover, &start);
    let mut found = Found { at_least, ..Found::default() };
    found.best.misplaced = usize::MAX;
    let mut idle = 0;
    if let Some(moves) = known {
        found.best = candidate(mover, &start, moves);
        idle = PATIENCE - PATIENCE_KNOWN;
    }
    let key = Key::new(limits.seed).child(2);
    let mut stream = Key::new(limits.seed).child(3).stream();
    let mut bridge = None;
    loop {
        let left = limits.budget.iterations.map_or(u64::MAX, |most| most.saturating_sub(found.attempts));
        let count = left.min(limits.lanes as u64) as usize;
        let proven = found.best.solved && found.best.moves.len() <= at_least;
        let patience = if proven { PATIENCE_PROVEN } else { PATIENCE };
        // Where the robot's time is the least too, nothing is left to be gained.
        // A single move is the same whenever it is asked for: there is nothing to put in another order.
        let least = found.best.moves.len() == 1 || found.best.seconds <= least_seconds + SAME_SECONDS;
        let optimal = proven && least;
        found.settled = found.best.solved && (optimal || idle >= patience);
        if count == 0 || limits.stop.requested() || found.settled {
            return Ok(found);
        }
        if found.best.solved {
            bridge = None;
        } else if bridge.is_none() && found.attempts >= ALONE * limits.lanes as u64 {
            let goal = backwards.as_ref().map(|back| &back.table.problem.start);
            bridge = goal.map(|goal| Bridge::new(&start.state, goal, mover.table.movable.count(), limits.max_moves));
        }
        let states = states(&start, &found.best);
        let mut tasks: Vec<Task> = (0..count as u64)
            .map(|lane| {
                let key = key.child(found.attempts + lane);
                if let Some(bridge) = bridge.as_ref().filter(|_| stream.chance(BRIDGES)) {
                    return Task::across(mover, bridge, key, &mut stream);
                }
                let limits = (at_least, limits.max_moves);
                task(mover, backwards.as_ref(), &found.best, &states, limits, key, &mut stream)
            })
            .collect();
        limits.pool.for_each_group(&mut tasks, 1, workers, |worker, tasks| {
            tasks.iter_mut().for_each(|task| run(task, worker, limits.stop));
        })?;
        idle += 1;
        // Every task replaced a piece of the same plan: of two good pieces only one can be taken.
        let before = found.best.clone();
        for mut task in tasks.drain(..) {
            if let (Some(bridge), Some(span)) = (&mut bridge, task.span) {
                if !task.solved {
                    bridge.add(span, task.end, task.moves);
                    continue;
                }
                task.moves = shortened(mover, &mut workers[0], &start, bridge.whole(span, &task.moves), limits.stop);
            }
            if better(mover, &start, &before, &mut found.best, task) {
                idle = 0;
            }
        }
        found.attempts += count as u64;
        publish(&found, limits);
    }
}

fn publish(found: &Found, limits: &Limits) {
    let Some(progress) = limits.progress else { return };
    let now = ProgressSnapshot {
        iterations: found.attempts,
        nodes: found.attempts,
        simulations: found.attempts,
        best_value: -found.best.seconds,
        solution_level: found.best.solved.then_some(found.best.moves.len() as u32),
        elapsed_us: 0,
    };
    progress.publish(&now, limits.stop);
}

/// The problem from goal to start, if every body that moves has a goal and they can all stand there at once.
fn backwards(mover: &Arc<Mover>) -> Option<Arc<Mover>> {
    let table = &mover.table;
    let mut end = table.problem.start.clone();
    for body in table.movable.iter() {
        let now = end.pose(body);
        if !table.problem.at_goal(body, &now) {
            end.set_pose(body, table.goal_pose(body, &now)?);
        } else {
            table.goal(body)?;
        }
    }
    let frames: Vec<_> = (0..table.len()).map(|body| end.pose(body).frame()).collect();
    let apart = (0..table.len()).all(|i| {
        (0..i).all(|j| footprints_apart(table.footprint(i), &frames[i], table.footprint(j), &frames[j], -PLACE_SLACK))
    });
    apart.then(|| Arc::new(mover.with_table(table.between(&end, &table.problem.start))))
}

/// The states of a plan, from its start to its end.
fn states(start: &Layout, best: &Candidate) -> Vec<State> {
    let mut state = start.state.clone();
    let mut states = vec![state.clone()];
    for action in &best.moves {
        state.set_pose(action.body(), action.to());
        states.push(state.clone());
    }
    states
}

/// Draws what to attempt next.
fn task(
    mover: &Arc<Mover>,
    backwards: Option<&Arc<Mover>>,
    best: &Candidate,
    states: &[State],
    (at_least, max_moves): (usize, usize),
    key: Key,
    stream: &mut Stream,
) -> Task {
    let all = best.moves.len();
    let whole = |limit: usize, back: bool| {
        let mover = Arc::clone(backwards.filter(|_| back).unwrap_or(mover));
        let start = Layout::new(&mover.table.problem.start);
        Task::new(mover, start, limit, back, 0..all, key)
    };
    let back = backwards.is_some() && stream.chance(0.5);
    if !best.solved {
        // Short attempts are soon given up, long ones find what is hard to find.
        let more = stream.index(max_moves.saturating_sub(at_least) + 1);
        return whole(at_least + more, back);
    }
    // A piece with as many moves may take less time.
    let fewer = usize::from(stream.chance(0.5));
    if stream.chance(AFRESH) {
        return whole(all - fewer.min(all), back);
    }
    let length = 2 + stream.index(all.saturating_sub(1));
    let first = stream.index((all + 1).saturating_sub(length).max(1));
    let last = (first + length).min(all);
    let limit = last - first - fewer.min(last - first);
    let (from, to) = (&states[first], &states[last]);
    if last == all && !back {
        // The end is not a certain state: goals have tolerances.
        let mover = Arc::new(mover.with_table(mover.table.starting_at(from)));
        return Task::new(mover, Layout::new(from), limit, false, first..last, key);
    }
    let (from, to) = if back { (to, from) } else { (from, to) };
    let mover = Arc::new(mover.with_table(mover.table.between(from, to)));
    Task::new(mover, Layout::new(from), limit, back, first..last, key)
}

impl Task {
    /// An attempt between the trees.
    fn across(mover: &Mover, bridge: &Bridge, key: Key, stream: &mut Stream) -> Task {
        let (span, limit) = bridge.draw(mover, stream);
        let (mover, start) = bridge.mover(mover, span);
        let course = Course { limit, soon: BRIDGE_MOVES, room: BRIDGE_ROOM };
        Task { course, span: Some(span), ..Task::new(mover, start, limit, false, 0..0, key) }
    }

    fn new(
        mover: Arc<Mover>,
        start: Layout,
        limit: usize,
        backwards: bool,
        piece: std::ops::Range<usize>,
        key: Key,
    ) -> Task {
        Task {
            mover,
            start,
            course: Course::whole(limit),
            backwards,
            span: None,
            piece,
            key,
            moves: Vec::new(),
            end: State::default(),
            solved: false,
            misplaced: usize::MAX,
        }
    }
}

fn run(task: &mut Task, worker: &mut Worker, stop: &Stop) {
    let mut stream = task.key.stream();
    task.solved = attempt(&task.mover, worker, &task.start, task.course, &mut stream, stop);
    task.misplaced = task.mover.table.misplaced(&worker.layout.state).count();
    task.moves.clear();
    if task.span.is_some() {
        task.end.clone_from(&worker.layout.state);
        task.moves.clone_from(&worker.moves);
    } else if task.backwards {
        if task.solved {
            task.moves = reversed(&worker.moves);
        }
    } else {
        task.moves.clone_from(&worker.moves);
    }
}

/// The moves of a plan without those that it can do without.
fn shortened(mover: &Mover, worker: &mut Mutex<Worker>, start: &Layout, moves: Vec<Move>, stop: &Stop) -> Vec<Move> {
    let worker = worker.get_mut().unwrap_or_else(PoisonError::into_inner);
    worker.shorten(mover, start, moves, stop)
}

/// Takes what the task found if that makes a better plan.
fn better(mover: &Mover, start: &Layout, before: &Candidate, best: &mut Candidate, task: Task) -> bool {
    let moves = if before.solved {
        if !task.solved {
            return false;
        }
        let mut moves = before.moves.clone();
        moves.splice(task.piece.clone(), task.moves);
        moves
    } else {
        if task.backwards && !task.solved {
            return false;
        }
        task.moves
    };
    let new = candidate(mover, start, moves);
    let wins = if best.solved {
        new.solved && (new.moves.len(), new.seconds) < (best.moves.len(), best.seconds - SAME_SECONDS)
    } else {
        new.solved || new.misplaced < best.misplaced
    };
    if wins {
        *best = new;
    }
    wins
}

/// The moves as a plan; those that do not bring every body home are cut where the most are.
pub fn candidate(mover: &Mover, start: &Layout, mut moves: Vec<Move>) -> Candidate {
    let problem: &Rearrangement = &mover.table.problem;
    let mut state = start.state.clone();
    // The fewest misplaced bodies after a move, and after which; at least one move is kept.
    let mut best = (usize::MAX, 0);
    for (index, action) in moves.iter().enumerate() {
        state.set_pose(action.body(), action.to());
        let misplaced = mover.table.misplaced(&state).count();
        if misplaced < best.0 {
            best = (misplaced, index + 1);
        }
    }
    let solved = problem.solved(&state);
    let misplaced = if moves.is_empty() { mover.table.misplaced(&state).count() } else { best.0 };
    if !solved {
        moves.truncate(best.1);
    }
    let seconds = moves.iter().fold(0.0, |sum, action| sum + mover.costs.seconds(action));
    Candidate { solved, moves, seconds, misplaced }
}
