//! `hbfs`: hierarchical best-first search (REMP, Algorithm HBFS).
//!
//! Each step takes the cheapest move that brings a body to its goal; if there is none, the cheapest that moves a body
//! off another's goal, towards its own goal or else at random; if there is none either, a random move. Several runs
//! with different seeds go on in parallel, and the best of their plans is the answer.
//!
//! The text leaves open how far "towards its goal" is: here, to the farthest free place on the straight way there that
//! is off the goal in question.

use super::mover::{Mover, MoverScratch};
use super::samplers::{SampleCounts, anywhere, direct};
use super::table::{Layout, stored};
use crate::action::Move;
use crate::geom::{Pose2, footprints_apart, normalize_angle};
use crate::run::{Stop, Stream};

/// Places tried on the straight way to a goal.
const STEPS: u32 = 20;
/// Of the free ones, how many are tried by a path.
const PATHS: usize = 4;
/// Random moves tried before a run gives up.
const RANDOM_MOVES: usize = 50;

/// One run: the moves from the start until every body is at its goal, or until there are `max_moves`.
pub fn run(
    mover: &Mover,
    samples: &SampleCounts,
    scratch: &mut MoverScratch,
    start: &Layout,
    max_moves: u32,
    stream: &mut Stream,
    stop: &Stop,
) -> Vec<Move> {
    let mut layout = start.clone();
    let mut moves = Vec::new();
    while moves.len() < max_moves as usize && !mover.table.problem.solved(&layout.state) && !stop.requested() {
        let Some(next) = step(mover, samples, scratch, &layout, stream, stop) else { break };
        layout.place(next.body(), next.to());
        moves.push(next);
    }
    moves
}

/// The next move; `None` where even random ones fail.
fn step(
    mover: &Mover,
    samples: &SampleCounts,
    scratch: &mut MoverScratch,
    layout: &Layout,
    stream: &mut Stream,
    stop: &Stop,
) -> Option<Move> {
    let table = &mover.table;
    let misplaced = table.misplaced(&layout.state);
    let mut best = Cheapest::default();
    for body in misplaced.iter() {
        if let Some(place) = direct(table, layout, body) {
            best.offer(mover, mover.attempt(scratch, layout, body, place.pose, stop));
        }
    }
    if best.action.is_some() {
        return best.action;
    }
    for body in misplaced.iter() {
        if stop.requested() {
            return best.action;
        }
        let Some(goal) = table.goal_pose(body, &layout.pose(body)) else { continue };
        for other in table.goal_blockers(layout, body).iter().filter(|&other| table.movable.contains(other)) {
            let clear = |pose: &Pose2| {
                let (owner, frame) = (table.footprint(body), goal.frame());
                footprints_apart(table.footprint(other), &pose.frame(), owner, &frame, table.clearance)
            };
            let action = towards_goal(mover, scratch, layout, other, &clear, stop)
                .or_else(|| random(mover, samples, scratch, layout, other, &clear, stream, stop));
            best.offer(mover, action);
        }
    }
    if best.action.is_some() {
        return best.action;
    }
    let bodies: Vec<usize> = table.movable.iter().collect();
    (0..RANDOM_MOVES).find_map(|_| {
        let body = *bodies.get(stream.index(bodies.len()))?;
        random(mover, samples, scratch, layout, body, &|_| true, stream, stop)
    })
}

/// The cheapest move so far, the first of equals.
#[derive(Default)]
struct Cheapest {
    action: Option<Move>,
    cost: f64,
}

impl Cheapest {
    fn offer(&mut self, mover: &Mover, action: Option<Move>) {
        let Some(action) = action else { return };
        let cost = mover.costs.metres(&action);
        if self.action.is_none() || cost < self.cost {
            (self.action, self.cost) = (Some(action), cost);
        }
    }
}

/// The farthest free place on the straight way to the body's goal.
fn towards_goal(
    mover: &Mover,
    scratch: &mut MoverScratch,
    layout: &Layout,
    body: usize,
    clear: &dyn Fn(&Pose2) -> bool,
    stop: &Stop,
) -> Option<Move> {
    let table = &mover.table;
    let now = layout.pose(body);
    if table.problem.at_goal(body, &now) {
        return None;
    }
    let goal = table.goal_pose(body, &now)?;
    let turn = normalize_angle(goal.theta - now.theta);
    let between =
        |t: f64| stored(Pose2::new(now.x + t * (goal.x - now.x), now.y + t * (goal.y - now.y), now.theta + t * turn));
    (1..=STEPS)
        .rev()
        .map(|step| between(f64::from(step) / f64::from(STEPS)))
        .take_while(|_| !stop.requested())
        .filter(|pose| clear(pose) && table.is_free(layout, body, pose))
        .take(PATHS)
        .find_map(|pose| mover.attempt(scratch, layout, body, pose, stop))
}

/// A move of the body to a random free place.
#[allow(clippy::too_many_arguments)]
fn random(
    mover: &Mover,
    samples: &SampleCounts,
    scratch: &mut MoverScratch,
    layout: &Layout,
    body: usize,
    clear: &dyn Fn(&Pose2) -> bool,
    stream: &mut Stream,
    stop: &Stop,
) -> Option<Move> {
    let table = &mover.table;
    let free = (0..samples.tries)
        .take_while(|_| !stop.requested())
        .map(|_| stored(anywhere(table, body, stream)))
        .find(|pose| clear(pose) && table.is_free(layout, body, pose))?;
    mover.attempt(scratch, layout, body, free, stop)
}
