//! `jostle bench path`: path queries a second. `bench/path_queries.py` asks the same queries of Python libraries.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use jostle::eval::arrange::{ArrangeLevel, Arranger};
use jostle::files::json;
use jostle::geom::Pose2;
use jostle::motion::{PathLimits, PathOutcome, PathParams, PathPlanner, PathScratch};
use jostle::run::Key;
use jostle::scene::{BodyDef, LeaveRule, SceneBuilder, State, Workspace};
use serde::{Deserialize, Serialize};

use crate::args::BenchPathArgs;
use crate::output::{self, Failure, Machine, Outcome};

/// The queries, with all that is needed to answer them elsewhere.
#[derive(Serialize, Deserialize)]
struct Queries {
    path_queries_version: u64,
    clearance: f64,
    turn_weight: f64,
    queries: Vec<Query>,
}

#[derive(Serialize, Deserialize)]
struct Query {
    workspace: Workspace,
    bodies: Vec<BodyDef>,
    poses: Vec<Pose2>,
    /// Index of the body that moves, from its pose to this one.
    body: usize,
    to: Pose2,
}

#[derive(Serialize)]
struct Report {
    version: &'static str,
    machine: Machine,
    queries: usize,
    seconds: f64,
    queries_per_second: f64,
    /// Queries and median microseconds of each kind of answer.
    answers: BTreeMap<&'static str, Answer>,
    /// Mean length of the paths found, metres.
    mean_length: f64,
    /// For each query, what it was answered with: a length, or none.
    lengths: Vec<Option<f64>>,
    /// For each query, the kind of answer and its time.
    kinds: Vec<&'static str>,
    times_s: Vec<f64>,
}

#[derive(Default, Serialize)]
struct Answer {
    count: usize,
    median_us: f64,
    max_us: f64,
    #[serde(skip)]
    times: Vec<f64>,
}

/// The start and goal arrangements of random problems: every body that is dragged, to its goal among the others.
fn draw(args: &BenchPathArgs) -> Outcome<Queries> {
    let params = PathParams::default();
    let mut queries = Vec::new();
    for index in 0.. {
        let level = [ArrangeLevel::Easy, ArrangeLevel::Normal, ArrangeLevel::Hard][index as usize % 3];
        let arranger = Arranger::new(level.params(), args.seed)?;
        let Some(problem) = arranger.draw(Key::new(args.seed).child(index), index)? else { continue };
        let planner = PathPlanner::new(Arc::clone(&problem.scene), params)?;
        let mut scratch = PathScratch::new();
        for (body, goal) in problem.goals.iter().enumerate() {
            let Some(goal) = goal.filter(|_| !problem.scene.body(body).pickable) else { continue };
            // What a planner would ask: where the goal itself is free.
            if !planner.pose_is_free(&problem.start, body, &goal.pose, &mut scratch) {
                continue;
            }
            queries.push(Query {
                workspace: *problem.scene.workspace(),
                bodies: problem.scene.bodies().iter().map(|b| b.def()).collect(),
                poses: (0..problem.scene.len()).map(|b| problem.start.pose(b)).collect(),
                body,
                to: goal.pose,
            });
            if queries.len() >= args.count {
                return Ok(Queries {
                    path_queries_version: 1,
                    clearance: params.clearance,
                    turn_weight: params.turn_weight,
                    queries,
                });
            }
        }
    }
    Err(Failure::failed("no queries"))
}

fn read(path: &Path) -> Outcome<Queries> {
    Ok(json::read(path, "queries")?)
}

pub fn run(args: &BenchPathArgs) -> Outcome<()> {
    if !args.file.exists() {
        let queries = draw(args)?;
        let text = serde_json::to_string(&queries).map_err(|e| Failure::failed(format!("the queries: {e}")))?;
        output::write_file(&args.file, &text)?;
    }
    let file = read(&args.file)?;
    let params = PathParams { clearance: file.clearance, turn_weight: file.turn_weight, ..PathParams::default() };
    let mut scratch = PathScratch::new();
    let scenes = file.queries.iter().map(|query| {
        let mut builder = SceneBuilder::new();
        for body in &query.bodies {
            builder.add_body(body.clone())?;
        }
        builder.workspace(Workspace { leave_rule: LeaveRule::Footprint, ..query.workspace });
        Ok((Arc::new(builder.build()?), State::new(query.poses.iter().copied())))
    });
    let scenes = scenes.collect::<jostle::Result<Vec<_>>>()?;
    let mut found = vec![(PathOutcome::NotFound, f64::INFINITY); scenes.len()];
    // Round by round, each time with a planner of its own: nothing is known from the last time.
    for _ in 0..args.rounds.max(1) {
        for ((query, (scene, state)), (answer, time)) in file.queries.iter().zip(&scenes).zip(&mut found) {
            let planner = PathPlanner::new(Arc::clone(scene), params)?;
            let from = state.pose(query.body);
            let start = Instant::now();
            let limits = PathLimits::default();
            *answer = planner.path(state, query.body, &from, &query.to, limits, Key::new(args.seed), &mut scratch);
            // Of several rounds the least: what else the machine did only adds.
            *time = time.min(start.elapsed().as_secs_f64());
        }
    }
    let mut answers: BTreeMap<&'static str, Answer> = BTreeMap::new();
    let (mut lengths, mut kinds, mut times_s) = (Vec::new(), Vec::new(), Vec::new());
    for (answer, time) in found {
        times_s.push(time);
        let kind = match &answer {
            PathOutcome::Found(path) if path.waypoints.len() == 2 => "straight",
            PathOutcome::Found(_) => "path",
            PathOutcome::Enclosed => "enclosed",
            PathOutcome::NotFound => "not found",
            PathOutcome::Interrupted => "interrupted",
        };
        kinds.push(kind);
        lengths.push(answer.path().map(|path| path.length));
        let entry = answers.entry(kind).or_default();
        entry.count += 1;
        entry.times.push(time * 1e6);
    }
    for answer in answers.values_mut() {
        answer.times.sort_by(f64::total_cmp);
        answer.median_us = answer.times[answer.times.len() / 2];
        answer.max_us = answer.times.last().copied().unwrap_or_default();
    }
    let total: f64 = times_s.iter().sum();
    let found: Vec<f64> = lengths.iter().flatten().copied().collect();
    let report = Report {
        version: env!("CARGO_PKG_VERSION"),
        machine: Machine::this(),
        queries: file.queries.len(),
        seconds: total,
        queries_per_second: file.queries.len() as f64 / total,
        mean_length: found.iter().sum::<f64>() / found.len().max(1) as f64,
        answers,
        lengths,
        kinds,
        times_s,
    };
    let mut text = format!("{} queries: {:.0} a second\n", report.queries, report.queries_per_second);
    for (kind, answer) in &report.answers {
        text.push_str(&format!(
            "  {kind}: {} in {:.1} us each (median; most {:.0} us)\n",
            answer.count, answer.median_us, answer.max_us
        ));
    }
    output::report(args.json.json.as_deref(), &report, &text)
}
