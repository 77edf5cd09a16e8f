//! The lines of recordings of a robot: one JSON object each, a grasp or a push by what it holds.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Deserialize;

use crate::action::{Grasp, Push};
use crate::bounds;
use crate::error::{Error, Result};
use crate::files::{self, json};
use crate::geom::{Footprint, Pose2, convex_hull, vec2};
use crate::scene::{BodyDef, Friction, Gripper, Problem, Scene, SceneBuilder, State, check_pose};

/// A body as it lay before the attempt.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct RobotBody {
    /// Kilograms.
    pub mass: f64,
    /// Highest point above the table, metres.
    pub height: f64,
    /// Convex pieces of its projection, corners in the body's frame, metres.
    pub pieces: Vec<Vec<[f64; 2]>>,
    /// x, y, theta; then height of the origin and tilt, which a scene in the plane does not know.
    pub pose: [f64; 5],
}

/// A grasp that was tried.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct RobotGrasp {
    pub id: String,
    /// What the line is for: `fit`, `report` or another name.
    pub split: String,
    /// Lines of one group are not independent of each other.
    #[serde(default)]
    pub group: String,
    pub bodies: Vec<RobotBody>,
    pub target: usize,
    /// Midpoint between the fingers and closing direction: x, y, angle.
    pub grasp: [f64; 3],
    /// Who chose it.
    #[serde(default)]
    pub proposer: String,
    /// The target was still in the hand after the swing; absent where the robot refused the swing.
    pub held: Option<bool>,
    /// What `held` says where it is absent.
    #[serde(default)]
    pub in_hand_at_home: Option<bool>,
    /// What the robot's own count says.
    pub success: bool,
}

/// Coefficients of the surfaces in a recorded push.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct RobotSurfaces {
    pub body: f64,
    pub table: f64,
    pub finger_pad: f64,
}

/// A push that was made.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct RobotPush {
    pub id: String,
    pub split: String,
    pub bodies: Vec<RobotBody>,
    /// Start and end of the tip's middle: x0, y0, x1, y1.
    pub command: [f64; 4],
    /// The robot broke it off.
    #[serde(default)]
    pub aborted: bool,
    pub friction: RobotSurfaces,
    /// Poses at rest, as [`RobotBody::pose`].
    pub after: Vec<[f64; 5]>,
}

/// What counts as a grasp that went well.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GraspOutcome {
    /// The target was still in the hand at the end.
    #[default]
    Kept,
    /// The robot's own count, which may want more.
    Counted,
}

/// The lines of some files.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RobotRecords {
    pub grasps: Vec<RobotGrasp>,
    pub pushes: Vec<RobotPush>,
}

impl RobotRecords {
    /// Reads files of recordings, grasps and pushes in any order. Errors name file, line and field.
    pub fn read(paths: &[PathBuf]) -> Result<RobotRecords> {
        let mut records = RobotRecords::default();
        for path in paths {
            records.add(path, &files::read_text(path)?)?;
        }
        Ok(records)
    }

    pub(super) fn add(&mut self, path: &Path, text: &str) -> Result<()> {
        let mut any = false;
        for (i, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
            any = true;
            let placed = |error| Error::format(path, json::on_line(json::located(line, error), i + 1));
            self.add_line(line).map_err(placed)?;
        }
        if any {
            return Ok(());
        }
        Err(Error::format(path, "holds no recorded grasps or pushes; it should have one JSON object a line"))
    }

    fn add_line(&mut self, line: &str) -> Result<()> {
        let keys = json::top_keys(line);
        let has = |key: &str| keys.iter().any(|k| k == key);
        match (has("grasp"), has("command")) {
            (true, false) => {
                let grasp: RobotGrasp = json::parse(line, "grasp")?;
                grasp.check()?;
                self.grasps.push(grasp);
            }
            (false, true) => {
                let push: RobotPush = json::parse(line, "push")?;
                push.check()?;
                self.pushes.push(push);
            }
            (true, true) => return Err(Error::argument("grasp", "stands beside `command`; a line has one of the two")),
            (false, false) => {
                // A line that is no object has its fault named by the parser.
                json::parse::<serde::de::IgnoredAny>(line, "line")?;
                return Err(Error::argument(
                    "line",
                    "has neither `grasp` nor `command`; one of them says what was done",
                ));
            }
        }
        Ok(())
    }

    /// The lines of a split only.
    #[must_use]
    pub fn of_split(mut self, split: &str) -> RobotRecords {
        self.grasps.retain(|grasp| grasp.split == split);
        self.pushes.retain(|push| push.split == split);
        self
    }
}

impl RobotGrasp {
    /// The grasp went well.
    pub fn went_well(&self, outcome: GraspOutcome) -> bool {
        match outcome {
            GraspOutcome::Kept => self.held.or(self.in_hand_at_home).unwrap_or(false),
            GraspOutcome::Counted => self.success,
        }
    }

    fn check(&self) -> Result<()> {
        check_bodies(&self.bodies)?;
        if self.target >= self.bodies.len() {
            let reason = format!("is {}; there are {} bodies, counted from 0", self.target, self.bodies.len());
            return Err(Error::argument("target", reason));
        }
        if self.held.is_none() && self.in_hand_at_home.is_none() {
            return Err(Error::argument(
                "held",
                "is null and `in_hand_at_home` is missing; one of them says how it ended",
            ));
        }
        let [x, y, angle] = self.grasp;
        bounds::POSITION.check_all("grasp", [x, y])?;
        bounds::HEADING.check("grasp", angle)?;
        self.problem(&Gripper::default()).map(|_| ())
    }

    /// The scene before the grasp, to be grasped in by a gripper.
    pub fn problem(&self, gripper: &Gripper) -> Result<Problem> {
        let surfaces = RobotSurfaces { body: 0.5, table: 1.1, finger_pad: 0.9 };
        let scene = Arc::new(scene(&self.bodies, surfaces, gripper)?);
        Ok(Problem { name: self.id.clone(), scene, state: state(&self.bodies), target: self.target })
    }

    /// The grasp with a gripper that opens fully.
    pub fn grasp(&self, gripper: &Gripper) -> Grasp {
        let [x, y, angle] = self.grasp;
        let opening = gripper.grasp.opening;
        Grasp { body: self.target, position: [x, y], angle, opening, ..Grasp::default() }
    }
}

impl RobotPush {
    fn check(&self) -> Result<()> {
        check_bodies(&self.bodies)?;
        if self.after.len() != self.bodies.len() {
            let reason = format!("has {} poses for {} bodies; give one for each", self.after.len(), self.bodies.len());
            return Err(Error::argument("after", reason));
        }
        for (i, after) in self.after.iter().enumerate() {
            check_pose(&format!("after[{i}]"), &pose(after))?;
        }
        bounds::POSITION.check_all("command", self.command)?;
        for (field, value) in [("body", self.friction.body), ("table", self.friction.table)] {
            bounds::FRICTION.check(&format!("friction.{field}"), value)?;
        }
        bounds::FRICTION.check("friction.finger_pad", self.friction.finger_pad)?;
        self.scene(&Gripper::default()).map(|_| ())
    }

    pub fn scene(&self, gripper: &Gripper) -> Result<Scene> {
        scene(&self.bodies, self.friction, gripper)
    }

    /// Where the bodies were.
    pub fn state(&self) -> State {
        state(&self.bodies)
    }

    pub fn push(&self) -> Push {
        let [x0, y0, x1, y1] = self.command;
        Push::new(vec2(x0, y0), vec2(x1, y1))
    }
}

fn check_bodies(bodies: &[RobotBody]) -> Result<()> {
    for (i, body) in bodies.iter().enumerate() {
        check_pose(&format!("bodies[{i}].pose"), &pose(&body.pose))?;
    }
    Ok(())
}

pub(super) fn pose(p: &[f64; 5]) -> Pose2 {
    Pose2::new(p[0], p[1], p[2])
}

fn state(bodies: &[RobotBody]) -> State {
    State::new(bodies.iter().map(|body| pose(&body.pose)))
}

/// Origins are centres of mass; moments of inertia are those of the boxes round the pieces, as in the recording
/// simulator.
fn scene(bodies: &[RobotBody], surfaces: RobotSurfaces, gripper: &Gripper) -> Result<Scene> {
    let mut builder = SceneBuilder::new();
    for (i, body) in bodies.iter().enumerate() {
        let named = |error: Error| match error.within(&format!("bodies[{i}]")) {
            Error::Argument { field, reason } => {
                Error::argument(field.replace(".shape.compound", ".pieces").replace(".shape", ".pieces"), reason)
            }
            other => other,
        };
        // Rounding of the recorded corners may have bent a straight edge inwards: hence the hulls.
        let hull = |piece: &Vec<[f64; 2]>| convex_hull(&piece.iter().map(|p| vec2(p[0], p[1])).collect::<Vec<_>>());
        let footprint = Footprint::from_convex_pieces(body.pieces.iter().map(hull).collect()).map_err(named)?;
        let (low, high) = footprint.bounds();
        let def = BodyDef {
            mass: body.mass,
            height: body.height,
            friction: surfaces.body,
            centre_of_mass: Some([0.0, 0.0]),
            inertia: Some(body.mass * (high - low).norm_squared() / 12.0),
            // The corners are the recording simulator's own.
            outline_tolerance: Some(0.0),
            ..BodyDef::new(footprint.shape)
        };
        builder.add_body(def)?;
    }
    builder.gripper(gripper.clone());
    builder.friction(Friction { ground: surfaces.table, tip: surfaces.finger_pad });
    builder.build()
}
