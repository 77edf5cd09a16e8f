//! Stand-ins for engines and planners in tests, and a small problem.

use std::sync::Arc;

use crate::action::{Action, Grasp, Push};
use crate::error::Result;
use crate::eval::Policy;
use crate::geom::{Pose2, Shape, vec2};
use crate::physics::{GraspResult, PushJob, PushResult, PushStatus, Scratch, Transition};
use crate::plan::{Control, Outcome, Plan, PlannedAction};
use crate::run::Stop;
use crate::scene::{BodyDef, Mask, Problem, Scene, SceneBuilder, State};

/// An engine in which every push moves the first body by the same offset.
pub struct Slide {
    pub scene: Arc<Scene>,
    pub offset: Pose2,
}

impl Transition for Slide {
    fn name(&self) -> &str {
        "slide"
    }

    fn scene(&self) -> &Scene {
        &self.scene
    }

    fn scratch(&self) -> Scratch {
        Box::new(())
    }

    fn step_batch(&self, _: &mut Scratch, jobs: &[PushJob<'_>], results: &mut [PushResult], _: &Stop) {
        for (job, result) in jobs.iter().zip(results) {
            *result = PushResult {
                status: PushStatus::Executed,
                state: job.state.clone(),
                touched: Mask::from(1),
                left: Mask::EMPTY,
                toppled: Mask::EMPTY,
            };
            let p = job.state.pose(0);
            let o = self.offset;
            result.state.set_pose(0, Pose2::new(p.x + o.x, p.y + o.y, p.theta + o.theta));
        }
    }
}

/// An engine that executes grasps, all with the same result; pushes do nothing.
pub struct Claw {
    pub scene: Arc<Scene>,
    pub result: GraspResult,
}

impl Transition for Claw {
    fn name(&self) -> &str {
        "claw"
    }

    fn scene(&self) -> &Scene {
        &self.scene
    }

    fn scratch(&self) -> Scratch {
        Box::new(())
    }

    fn step_batch(&self, _: &mut Scratch, jobs: &[PushJob<'_>], results: &mut [PushResult], _: &Stop) {
        for (job, result) in jobs.iter().zip(results) {
            *result = PushResult { state: job.state.clone(), ..PushResult::default() };
        }
    }

    fn grasp(&self, _: &mut Scratch, state: &State, _: &Grasp, _: &Stop) -> Option<GraspResult> {
        let mut state = state.clone();
        if let Some(body) = self.result.held.filter(|&body| self.result.took(body)) {
            state.set_present(body, false);
        }
        Some(GraspResult { state, ..self.result.clone() })
    }
}

/// Two squares of 40 mm, 60 mm apart; the first is the target.
pub fn row() -> Problem {
    let mut builder = SceneBuilder::new();
    for _ in 0..2 {
        builder.add_body(BodyDef::new(Shape::rectangle(0.04, 0.04))).unwrap();
    }
    let state = State::new([Pose2::new(0.5, 0.0, 0.0), Pose2::new(0.5, 0.1, 0.0)]);
    Problem::new("row", Arc::new(builder.build().unwrap()), state, 0).unwrap()
}

/// A grasp of the target along x.
pub fn squeeze(problem: &Problem, position: [f64; 2]) -> Grasp {
    Grasp {
        body: problem.target,
        position,
        angle: 0.0,
        opening: problem.scene.gripper().grasp.opening,
        width: 0.04,
        margin: 0.01,
        score: 1.0,
    }
}

/// What a [`Script`] may decide.
#[derive(Clone, Copy)]
pub enum Line {
    Push,
    GoodGrasp,
    BadGrasp,
    Nothing,
    Cancel,
}

/// Decides by a list, whatever it sees; at its end the last line again.
pub struct Script {
    pub lines: Vec<Line>,
    pub next: usize,
    pub executed: usize,
    pub failed: usize,
}

impl Script {
    pub fn new(lines: &[Line]) -> Script {
        Script { lines: lines.to_vec(), next: 0, executed: 0, failed: 0 }
    }
}

impl Policy for Script {
    fn decide(&mut self, problem: &Problem, _: &Control) -> Result<Plan> {
        let line = self.lines[self.next.min(self.lines.len() - 1)];
        self.next += 1;
        let at = problem.state.pose(problem.target);
        let action = match line {
            Line::Push => Some(Action::Push(Push::new(vec2(at.x - 0.06, at.y), vec2(at.x - 0.01, at.y)))),
            Line::GoodGrasp => Some(Action::Grasp(squeeze(problem, [at.x, at.y]))),
            Line::BadGrasp => Some(Action::Grasp(squeeze(problem, [at.x + 0.05, at.y]))),
            Line::Nothing | Line::Cancel => None,
        };
        let outcome = match line {
            Line::Cancel => Outcome::Cancelled,
            Line::Nothing => Outcome::Infeasible,
            _ => Outcome::Budget,
        };
        let mut plan = Plan::empty(outcome, "script", 0);
        plan.actions.extend(action.map(|action| PlannedAction {
            action,
            predicted: problem.state.clone(),
            value: 0.0,
        }));
        Ok(plan)
    }

    fn executed(&mut self, _: &Action) -> Result<()> {
        self.executed += 1;
        Ok(())
    }

    fn failed(&mut self, _: &Action) {
        self.failed += 1;
    }
}
