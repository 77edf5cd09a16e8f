//! Seeded rearrangement problems: objects of 4 to 25 cm on the table of REMP (dissertation chapter 7), from one random
//! arrangement to another.
//!
//! The source shows its objects and gives no measures. Here an object is a rectangle, a convex polygon or an L; one
//! whose longest side is over 12 cm can only be dragged. A problem is kept if it is solved (by `untangle`, so that it is
//! known to be feasible) and not trivial: it is trivial if bodies can be brought to their goals one after the other
//! without moving any of them twice.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::RangeInclusive;
use std::sync::Arc;

use crate::error::{Error, Result, check_range};
use crate::geom::{Footprint, Pose2, Shape, vec2};
use crate::motion::{PathLimits, PathParams, PathPlanner, PathScratch};
use crate::plan::rearrange::{RearrangeOptions, RearrangePlanner};
use crate::plan::{Control, Outcome};
use crate::run::{Budget, Key, Stream};
use crate::scene::{BodyDef, Goal, LeaveRule, Rearrangement, SceneBuilder, State, Workspace};

/// How full the table is and with how many objects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ArrangeLevel {
    Easy,
    /// As hard for HBFS as the published suite.
    #[default]
    Normal,
    Hard,
}

impl ArrangeLevel {
    pub const NAMES: [&str; 3] = ["easy", "normal", "hard"];

    pub fn by_name(name: &str) -> Result<ArrangeLevel> {
        match name {
            "easy" => Ok(ArrangeLevel::Easy),
            "normal" => Ok(ArrangeLevel::Normal),
            "hard" => Ok(ArrangeLevel::Hard),
            _ => Err(Error::not_found("level", format!("there is no `{name}`; there are easy, normal and hard"))),
        }
    }

    pub fn params(self) -> ArrangeParams {
        let (bodies, fill) = match self {
            ArrangeLevel::Easy => (4..=6, [0.08, 0.14]),
            ArrangeLevel::Normal => (5..=7, [0.15, 0.21]),
            ArrangeLevel::Hard => (6..=8, [0.22, 0.28]),
        };
        ArrangeParams { bodies, fill, ..ArrangeParams::default() }
    }
}

/// What problems to make.
#[derive(Debug, Clone, PartialEq)]
pub struct ArrangeParams {
    /// Least and greatest number of bodies.
    pub bodies: RangeInclusive<usize>,
    /// Least and greatest part of the table that they cover.
    pub fill: [f64; 2],
    /// Extent of the table along x and y, metres.
    pub table: [f64; 2],
    /// Least and greatest longest side of an object, metres.
    pub side: [f64; 2],
    /// An object whose longest side is above this can only be dragged, metres.
    pub drag_above: f64,
    /// Least gap between bodies at start and goal, metres.
    pub gap: f64,
    /// Plans tried to find a solution before a draw is given up.
    pub attempts: u64,
    /// Most moves of a solution.
    pub moves: u32,
}

impl Default for ArrangeParams {
    fn default() -> Self {
        Self {
            bodies: 5..=7,
            fill: [0.15, 0.21],
            table: [0.78, 0.52],
            side: [0.04, 0.25],
            drag_above: 0.12,
            gap: 0.004,
            attempts: 64,
            moves: 20,
        }
    }
}

impl ArrangeParams {
    /// Errors name the field.
    pub fn validate(&self) -> Result<()> {
        let (least, most) = (*self.bodies.start(), *self.bodies.end());
        if least == 0 || most < least || most > 32 {
            let reason = format!("is {least}..={most}; it must be a range within 1..=32");
            return Err(Error::argument("arrange.bodies", reason));
        }
        check_range("arrange.fill[0]", self.fill[0], 0.0..=0.8)?;
        check_range("arrange.fill[1]", self.fill[1], self.fill[0]..=0.8)?;
        check_range("arrange.table[0]", self.table[0], 0.1..=10.0)?;
        check_range("arrange.table[1]", self.table[1], 0.1..=10.0)?;
        check_range("arrange.side[0]", self.side[0], 0.01..=1.0)?;
        check_range("arrange.side[1]", self.side[1], self.side[0]..=1.0)?;
        check_range("arrange.drag_above", self.drag_above, 0.0..=10.0)?;
        check_range("arrange.gap", self.gap, 0.001..=0.05)
    }
}

/// Draws of objects before the fill is held to be impossible.
const SHAPE_DRAWS: usize = 2000;
/// Poses tried for one body, and arrangements begun, before a draw is given up.
const PLACES: usize = 400;
const ARRANGEMENTS: usize = 30;
/// Plans tried to find a solution between two looks whether there is one.
const AT_ONCE: u64 = 4;
/// Draws for each problem that is kept, at most.
const DRAWS_PER_KEPT: u64 = 400;

/// Makes problems: number `i` of a seed is the same whatever was made before, and on every thread.
#[derive(Debug, Clone)]
pub struct Arranger {
    params: ArrangeParams,
    seed: u64,
}

impl Arranger {
    pub fn new(params: ArrangeParams, seed: u64) -> Result<Arranger> {
        params.validate()?;
        Ok(Arranger { params, seed })
    }

    /// Problem `index` of the seed, named `rearrange-SEED-INDEX`: the first of its draws that is kept.
    pub fn problem(&self, index: u64) -> Result<Rearrangement> {
        let key = Key::new(self.seed).child(index);
        for draw in 0..DRAWS_PER_KEPT {
            let key = key.child(draw);
            let Some(problem) = self.draw(key, index)? else { continue };
            if !is_trivial(&problem)? && self.is_solved(&problem, key)? {
                return Ok(problem);
            }
        }
        Err(Error::argument(
            "arrange",
            "hardly any draw of these parameters can be solved; ask for fewer or smaller bodies",
        ))
    }

    /// Start and goal at random, whether or not they make a good problem.
    pub fn draw(&self, key: Key, index: u64) -> Result<Option<Rearrangement>> {
        let mut random = key.stream();
        let Some(shapes) = self.shapes(&mut random)? else { return Ok(None) };
        let mut builder = SceneBuilder::new();
        for (shape, side) in &shapes {
            let pickable = *side <= self.params.drag_above;
            builder.add_body(BodyDef { pickable, ..BodyDef::new(shape.clone()) })?;
        }
        let [x, y] = self.params.table;
        let mut workspace = Workspace::rectangle(vec2(0.0, 0.0), vec2(x, y));
        workspace.leave_rule = LeaveRule::Footprint;
        builder.workspace(workspace);
        let scene = Arc::new(builder.build()?);
        let paths =
            PathPlanner::new(Arc::clone(&scene), PathParams { clearance: self.params.gap, ..PathParams::default() })?;
        let (Some(start), Some(goal)) = (self.arrange(&paths, &mut random), self.arrange(&paths, &mut random)) else {
            return Ok(None);
        };
        let goals = (0..scene.len()).map(|body| {
            let symmetry = if is_rectangle(&shapes[body].0) { 2 } else { 1 };
            Some(Goal { symmetry, ..Goal::at(goal.pose(body)) })
        });
        let name = format!("rearrange-{}-{index:02}", self.seed);
        Rearrangement::new(name, scene.clone(), start, goals.collect()).map(Some)
    }

    /// Objects with their longest sides, that cover as much of the table as they should, the largest first.
    fn shapes(&self, random: &mut Stream) -> Result<Option<Vec<(Shape, f64)>>> {
        let p = &self.params;
        let count = p.bodies.start() + random.index(p.bodies.end() - p.bodies.start() + 1);
        let table = p.table[0] * p.table[1];
        for _ in 0..SHAPE_DRAWS {
            // At least one of either kind, where the sizes allow both.
            let large = 1 + random.index(count.saturating_sub(1).max(1));
            let mut shapes = Vec::with_capacity(count);
            for i in 0..count {
                let limits = if i < large {
                    [p.side[0].max(p.drag_above), p.side[1]]
                } else {
                    [p.side[0], p.side[1].min(p.drag_above)]
                };
                let side = random.uniform(limits[0].min(limits[1]), limits[1].max(limits[0]));
                let shape = shape(side, random);
                let area = Footprint::new(shape.clone())?.area;
                shapes.push((shape, side, area));
            }
            let fill = shapes.iter().map(|s| s.2).sum::<f64>() / table;
            if (p.fill[0]..=p.fill[1]).contains(&fill) {
                shapes.sort_by(|a, b| b.2.total_cmp(&a.2));
                return Ok(Some(shapes.into_iter().map(|(shape, side, _)| (shape, side)).collect()));
            }
        }
        Ok(None)
    }

    /// All bodies at random, none nearer to another than the gap.
    fn arrange(&self, paths: &PathPlanner, random: &mut Stream) -> Option<State> {
        let bodies = paths.scene().len();
        let mut scratch = PathScratch::new();
        for _ in 0..ARRANGEMENTS {
            let mut state = State::new(vec![Pose2::IDENTITY; bodies]);
            (0..bodies).for_each(|body| state.set_present(body, false));
            let placed = (0..bodies).all(|body| {
                (0..PLACES).any(|_| {
                    let theta =
                        if random.chance(0.5) { FRAC_PI_2 * random.index(4) as f64 } else { random.uniform(-PI, PI) };
                    let at = [random.uniform(0.0, self.params.table[0]), random.uniform(0.0, self.params.table[1])];
                    let pose = Pose2::new(at[0], at[1], theta);
                    let free = paths.pose_is_free(&state, body, &pose, &mut scratch);
                    if free {
                        state.set_pose(body, pose);
                        state.set_present(body, true);
                    }
                    free
                })
            });
            if placed {
                return Some(state);
            }
        }
        None
    }

    /// Whether one of the attempts solves it. Few at a time, because after the first plan the rest would only improve it.
    fn is_solved(&self, problem: &Rearrangement, key: Key) -> Result<bool> {
        let options = RearrangeOptions {
            budget: Budget::iterations(AT_ONCE),
            seed: key.bits(),
            max_moves: Some(self.params.moves),
            ..RearrangeOptions::default()
        };
        let mut planner = RearrangePlanner::new(options)?;
        for _ in 0..self.params.attempts.div_ceil(AT_ONCE) {
            if planner.solve(problem, &Control::default())?.outcome == Outcome::Solved {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

fn is_rectangle(shape: &Shape) -> bool {
    matches!(shape, Shape::ConvexPolygon(points) if points.len() == 4)
}

/// A rectangle, a convex polygon or an L whose longest side is `side`, about its middle.
fn shape(side: f64, random: &mut Stream) -> Shape {
    match random.index(3) {
        0 => Shape::rectangle(side, side * random.uniform(0.35, 1.0)),
        1 => {
            let corners = 5 + random.index(3);
            let flat = random.uniform(0.5, 1.0);
            let turn = random.uniform(0.0, TAU);
            let corner = |k: usize| {
                let a = turn + k as f64 * TAU / corners as f64;
                [0.5 * side * a.cos(), 0.5 * side * flat * a.sin()]
            };
            Shape::ConvexPolygon((0..corners).map(corner).collect())
        }
        _ => {
            let other = side * random.uniform(0.6, 1.0);
            let (a, b) = (side * random.uniform(0.3, 0.5), other * random.uniform(0.3, 0.5));
            let (x, y) = (side / 2.0, other / 2.0);
            Shape::Polygon(vec![[-x, -y], [x, -y], [x, b - y], [a - x, b - y], [a - x, y], [-x, y]])
        }
    }
}

/// Whether bodies can be brought to their goals one after the other: whoever can go, goes.
pub fn is_trivial(problem: &Rearrangement) -> Result<bool> {
    let paths = PathPlanner::new(Arc::clone(&problem.scene), PathParams::default())?;
    let mut scratch = PathScratch::new();
    let mut state = problem.start.clone();
    loop {
        let next = (0..problem.scene.len()).find_map(|body| {
            let now = state.pose(body);
            let goal = problem.goals[body].filter(|goal| !goal.reached(&now))?.nearest(&now);
            let goes = if problem.scene.body(body).pickable {
                paths.pose_is_free(&state, body, &goal, &mut scratch)
            } else {
                paths.path(&state, body, &now, &goal, PathLimits::default(), Key::new(0), &mut scratch).path().is_some()
            };
            goes.then_some((body, goal))
        });
        match next {
            Some((body, goal)) => state.set_pose(body, goal),
            None => return Ok(problem.solved(&state)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_problem_is_the_same_whenever_it_is_made() {
        let make = |seed: u64, index: u64| {
            let arranger = Arranger::new(ArrangeLevel::Easy.params(), seed).unwrap();
            arranger.draw(Key::new(seed).child(index), index).unwrap()
        };
        assert_eq!(make(3, 1), make(3, 1));
        assert_ne!(make(3, 1), make(3, 2));
        assert_ne!(make(3, 1), make(4, 1));
    }

    #[test]
    fn objects_are_as_asked_and_stand_apart() {
        let mut drawn = 0;
        for level in [ArrangeLevel::Easy, ArrangeLevel::Normal, ArrangeLevel::Hard] {
            let params = level.params();
            let arranger = Arranger::new(params.clone(), 7).unwrap();
            for index in 0..20 {
                let Some(problem) = arranger.draw(Key::new(index), index).unwrap() else { continue };
                drawn += 1;
                let bodies = problem.scene.bodies();
                assert!(params.bodies.contains(&bodies.len()));
                let fill = bodies.iter().map(|b| b.footprint.area).sum::<f64>() / (0.78 * 0.52);
                assert!((params.fill[0]..=params.fill[1]).contains(&fill), "{fill}");
                assert!(bodies.iter().any(|b| !b.pickable));
                for body in bodies {
                    let (low, high) = body.footprint.bounds();
                    let side = (high - low).max();
                    assert!((0.03..=0.2501).contains(&side), "{side}");
                }
                let paths = PathPlanner::new(Arc::clone(&problem.scene), PathParams::default()).unwrap();
                let mut scratch = PathScratch::new();
                for body in 0..bodies.len() {
                    let gap = paths.pose_gap(&problem.start, body, &problem.start.pose(body), 1.0, &mut scratch);
                    assert!(gap > params.gap - 1e-4, "{gap}");
                }
            }
        }
        assert!(drawn >= 30, "{drawn}");
    }

    #[test]
    fn one_body_on_a_free_table_is_trivial_and_an_exchange_is_not() {
        let problem = |poses: [[f64; 2]; 2], goals: [[f64; 2]; 2]| {
            let mut builder = SceneBuilder::new();
            for _ in 0..2 {
                builder.add_body(BodyDef::new(Shape::rectangle(0.05, 0.05))).unwrap();
            }
            let at = |p: [f64; 2]| Pose2::new(p[0], p[1], 0.0);
            let goals = goals.map(|g| Some(Goal::at(at(g)))).to_vec();
            let scene = Arc::new(builder.build().unwrap());
            Rearrangement::new("two", scene, State::new(poses.map(at)), goals).unwrap()
        };
        let (a, b, c) = ([0.4, 0.0], [0.5, 0.0], [0.6, 0.0]);
        assert!(is_trivial(&problem([a, b], [b, c])).unwrap());
        assert!(!is_trivial(&problem([a, b], [b, a])).unwrap());
    }

    #[test]
    fn parameters_are_refused_by_name() {
        let good = ArrangeParams::default();
        #[allow(clippy::reversed_empty_ranges)]
        let backwards = 5..=4;
        for (params, field) in [
            (ArrangeParams { bodies: backwards, ..good.clone() }, "arrange.bodies"),
            (ArrangeParams { fill: [0.5, 0.4], ..good.clone() }, "arrange.fill[1]"),
            (ArrangeParams { table: [f64::NAN, 0.5], ..good.clone() }, "arrange.table[0]"),
            (ArrangeParams { gap: 0.0, ..good }, "arrange.gap"),
        ] {
            let error = Arranger::new(params, 0).unwrap_err().to_string();
            assert!(error.starts_with(field), "{error}");
        }
    }
}
