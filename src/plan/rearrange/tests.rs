//! Outcomes of random problems, ended at many places: infeasible is only what is, and whatever is of use is kept.

use std::sync::Arc;

use super::certain;
use super::mover::{Mover, MoverScratch};
use super::planner::Begin;
use super::table::Layout;
use super::{REARRANGE_PLANNERS, RearrangeOptions, RearrangePlan, RearrangePlanner};
use crate::geom::{Pose2, Shape, vec2};
use crate::plan::{Control, Outcome, Reason};
use crate::run::{Budget, Key, Stop, Stream};
use crate::scene::{BodyDef, Goal, LeaveRule, Rearrangement, SceneBuilder, State, Workspace};

const TABLE: [f64; 2] = [0.6, 0.4];

/// Bodies of a problem with where they are and where they are wanted.
#[derive(Default)]
struct Draft {
    bodies: Vec<(BodyDef, Pose2, Option<Goal>)>,
}

impl Draft {
    fn problem(&self) -> crate::Result<Rearrangement> {
        let mut builder = SceneBuilder::new();
        builder.workspace(Workspace {
            leave_rule: LeaveRule::Footprint,
            ..Workspace::rectangle(vec2(0.0, 0.0), vec2(TABLE[0], TABLE[1]))
        });
        for (def, ..) in &self.bodies {
            builder.add_body(def.clone())?;
        }
        let scene = Arc::new(builder.build()?);
        let poses = self.bodies.iter().map(|(_, pose, _)| *pose);
        let state = State::new(poses);
        Rearrangement::new("drawn", scene, state, self.bodies.iter().map(|(.., goal)| *goal).collect())
    }

    /// Adds a body where there is room for it at both ends.
    fn add(&mut self, stream: &mut Stream, draw: impl Fn(&mut Stream) -> (BodyDef, Pose2, Option<Goal>)) {
        for _ in 0..200 {
            self.bodies.push(draw(stream));
            if self.problem().is_ok() {
                return;
            }
            self.bodies.pop();
        }
    }
}

fn anywhere(stream: &mut Stream, x: (f64, f64)) -> Pose2 {
    Pose2::new(stream.uniform(x.0, x.1), stream.uniform(0.04, TABLE[1] - 0.04), stream.uniform(-3.1, 3.1))
}

fn body(stream: &mut Stream, dragged: bool) -> BodyDef {
    let shape = if stream.chance(0.3) {
        Shape::Disc { radius: stream.uniform(0.015, 0.03) }
    } else {
        Shape::rectangle(stream.uniform(0.03, 0.08), stream.uniform(0.03, 0.06))
    };
    BodyDef { pickable: !dragged, ..BodyDef::new(shape) }
}

fn wall(name: &str, size: [f64; 2], at: [f64; 2]) -> (BodyDef, Pose2, Option<Goal>) {
    let def = BodyDef { pickable: false, pushable: false, ..BodyDef::new(Shape::rectangle(size[0], size[1])) };
    (def.named(name), Pose2::new(at[0], at[1], 0.0), None)
}

/// Bodies that are picked and bodies that are dragged, most with goals, some among obstacles.
fn mixed(seed: u64) -> Rearrangement {
    let mut stream = Key::new(seed).child(1).stream();
    let mut draft = Draft::default();
    if stream.chance(0.5) {
        draft.bodies.push(wall("wall", [0.02, stream.uniform(0.05, 0.25)], [0.3, 0.2]));
    }
    for _ in 0..2 + stream.index(5) {
        draft.add(&mut stream, |stream| {
            let dragged = stream.chance(0.4);
            let goal = stream.chance(0.9).then(|| Goal::at(anywhere(stream, (0.04, 0.56))));
            (body(stream, dragged), anywhere(stream, (0.04, 0.56)), goal)
        });
    }
    draft.problem().expect("each body was added to a problem that is valid")
}

/// A wall from edge to edge, at most with gaps too small for the body that has to be dragged to the other side.
fn walled(seed: u64) -> Rearrangement {
    let mut stream = Key::new(seed).child(2).stream();
    let mut draft = Draft::default();
    let thick = stream.uniform(0.01, 0.05);
    let gap = stream.uniform(0.0, 0.012);
    let split = stream.uniform(0.1, 0.3);
    draft.bodies.push(wall("wall", [thick, split - gap], [0.3, (split - gap) / 2.0]));
    draft.bodies.push(wall("wall too", [thick, TABLE[1] - split], [0.3, (TABLE[1] + split) / 2.0]));
    let goal = |stream: &mut Stream| {
        let symmetry = [0, 1, 2, 4][stream.index(4)];
        Some(Goal { symmetry, ..Goal::at(anywhere(stream, (0.4, 0.56))) })
    };
    draft.add(&mut stream, |stream| {
        let def = BodyDef { pickable: false, ..BodyDef::new(Shape::rectangle(0.05, stream.uniform(0.04, 0.07))) };
        (def.named("box"), anywhere(stream, (0.04, 0.2)), goal(stream))
    });
    for _ in 0..stream.index(4) {
        draft.add(&mut stream, |stream| {
            let goal = stream.chance(0.7).then(|| Goal::at(anywhere(stream, (0.04, 0.56))));
            (body(stream, false), anywhere(stream, (0.04, 0.56)), goal)
        });
    }
    draft.problem().expect("each body was added to a problem that is valid")
}

fn planner(id: &str, budget: Budget) -> RearrangePlanner {
    RearrangePlanner::new(RearrangeOptions { planner: id.into(), budget, ..RearrangeOptions::default() }).unwrap()
}

fn solve(problem: &Rearrangement, id: &str, iterations: u64) -> RearrangePlan {
    planner(id, Budget::iterations(iterations)).solve(problem, &Control::default()).unwrap()
}

/// Ends after so many looks at the stop.
fn cut(problem: &Rearrangement, id: &str, looks: u64) -> RearrangePlan {
    let budget = Budget::seconds(1.0);
    let stop = Stop::after_looks(looks);
    planner(id, budget).decide_until(problem, budget, Begin::Afresh, &stop, &Control::default()).unwrap()
}

/// The plan's outcome fits the rest of it, and its moves lead where it says.
fn check(problem: &Rearrangement, plan: &RearrangePlan, what: &str) {
    assert_eq!(plan.reasons.is_empty(), plan.outcome == Outcome::Solved, "{what}: {:?}", plan.reasons);
    let mut state = problem.start.clone();
    for step in &plan.moves {
        assert_eq!(step.action.from(), state.pose(step.action.body()), "{what}");
        state.set_pose(step.action.body(), step.action.to());
        assert_eq!(step.predicted, state, "{what}");
    }
    assert_eq!(problem.solved(&state), plan.outcome == Outcome::Solved, "{what}");
    if plan.outcome == Outcome::Infeasible {
        assert!(plan.moves.is_empty(), "{what}");
    }
}

#[test]
fn what_a_larger_budget_solves_is_never_infeasible_and_what_is_of_use_is_kept() {
    let mut solved = 0;
    for seed in 0..24 {
        let problem = mixed(seed);
        let mover = Mover::new(&problem, RearrangeOptions::default().paths, Default::default()).unwrap();
        let start = Layout::new(&problem.start);
        let stop = Stop::after_looks(0);
        let useful = !certain::useful(&mover, &start, &mut MoverScratch::default(), &stop).is_empty();
        let solvable = solve(&problem, "untangle", 64).outcome == Outcome::Solved;
        solved += usize::from(solvable);
        for id in REARRANGE_PLANNERS {
            let mut plans: Vec<(String, RearrangePlan)> = Vec::new();
            for iterations in [1, 2, 5] {
                plans.push((format!("{id} {seed}, {iterations} iterations"), solve(&problem, id, iterations)));
            }
            for looks in [0, 1, 2, 5, 20, 100, 1000] {
                plans.push((format!("{id} {seed}, {looks} looks"), cut(&problem, id, looks)));
            }
            for (what, plan) in plans {
                check(&problem, &plan, &what);
                assert!(!solvable || plan.outcome != Outcome::Infeasible, "{what}: {:?}", plan.reasons);
                let nothing = plan.moves.is_empty() && !problem.solved(&problem.start);
                assert!(plan.outcome == Outcome::Infeasible || !(useful && nothing), "{what}: a move is of use");
            }
        }
    }
    assert!(solved >= 18, "the problems are to be solvable for the most part: {solved} of 24");
}

/// However fast the machine is: a limit of time is the reason, or there was none.
#[test]
fn a_limit_of_time_is_the_reason_where_it_ended_the_search() {
    for seed in 0..12 {
        let problem = mixed(seed);
        for id in ["untangle", "pmmr"] {
            for seconds in [1e-9, 1e-5, 1e-4, 1e-3] {
                let budget = Budget::seconds(seconds);
                let plan = planner(id, budget).solve(&problem, &Control::default()).unwrap();
                let limited = matches!(plan.reasons[..], [Reason::Seconds { .. }]);
                assert!(plan.outcome == Outcome::Solved || limited, "{seed} {id} {seconds}: {:?}", plan.reasons);
            }
        }
    }
}

#[test]
fn a_body_behind_a_wall_is_infeasible_for_every_planner_with_the_walls_named() {
    for seed in 0..24 {
        let problem = walled(seed);
        for id in REARRANGE_PLANNERS {
            for iterations in [1, 2, 5] {
                let plan = solve(&problem, id, iterations);
                let what = format!("{id} {seed}, {iterations} iterations: {:?}", plan.reasons);
                check(&problem, &plan, &what);
                assert_eq!(plan.outcome, Outcome::Infeasible, "{what}");
                let walls = vec!["wall".to_owned(), "wall too".to_owned()];
                assert_eq!(plan.reasons, [Reason::Enclosed { body: "box".into(), by: walls }], "{what}");
            }
        }
        // Ended early nothing is known, and later what was known stays so.
        let mut last = Outcome::Budget;
        for looks in [0, 1, 10, 50, 200, 1000, 5000] {
            let plan = cut(&problem, "untangle", looks);
            check(&problem, &plan, &format!("{seed}, {looks} looks"));
            let known = [Outcome::Budget, Outcome::Infeasible].contains(&plan.outcome);
            assert!(known && (last == Outcome::Budget || plan.outcome == last), "{seed}, {looks}: {:?}", plan.outcome);
            last = plan.outcome;
        }
        assert_eq!(last, Outcome::Infeasible, "{seed}");
    }
}

#[test]
fn a_goal_that_is_reached_within_its_tolerance_is_not_behind_a_wall() {
    // The wall stands on the goal's far side within the tolerance: from the near side the goal is reached.
    let mut draft = Draft::default();
    draft.bodies.push(wall("wall", [0.02, TABLE[1]], [0.3, 0.2]));
    let def = BodyDef { pickable: false, ..BodyDef::new(Shape::rectangle(0.05, 0.05)) };
    let goal = |x: f64, position_tolerance: f64| Goal { position_tolerance, ..Goal::at(Pose2::new(x, 0.2, 0.0)) };
    for (tolerance, outcome) in [(0.005, Outcome::Infeasible), (0.13, Outcome::Budget)] {
        draft.bodies.truncate(1);
        draft.bodies.push((def.clone().named("box"), Pose2::new(0.1, 0.2, 0.0), Some(goal(0.36, tolerance))));
        let plan = solve(&draft.problem().unwrap(), "untangle", 1);
        let known = plan.outcome == outcome || outcome == Outcome::Budget && plan.outcome == Outcome::Solved;
        assert!(known, "{tolerance}: {:?} {:?}", plan.outcome, plan.reasons);
    }
}

#[test]
fn what_is_kept_of_paths_and_trees_is_counted_and_limited() {
    for id in REARRANGE_PLANNERS {
        let mut counted = 0;
        for seed in 0..6 {
            let problem = mixed(seed);
            let run = |bytes: Option<usize>| {
                let mut planner = planner(id, Budget { bytes, ..Budget::iterations(24) });
                assert_eq!(planner.memory_bytes(), 0, "{id} {seed}");
                let plan = planner.solve(&problem, &Control::default()).unwrap();
                (planner.memory_bytes(), plan)
            };
            let (free, plan) = run(None);
            for bytes in [1_000, 20_000, 200_000] {
                let (used, limited) = run(Some(bytes));
                // A tree holds its root and the wave in progress whatever the limit, and other plans.
                assert!(id == "pmmr" || used <= bytes, "{id} {seed}: {used} of {bytes}");
                assert!(id == "pmmr" || limited.hash_bits() == plan.hash_bits(), "{id} {seed}: paths are found again");
            }
            counted += usize::from(free > 0);
        }
        assert!(counted > 0, "{id}");
    }
}
