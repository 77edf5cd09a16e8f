//! Recorded pushes: reading them, writing them, and making them with an engine of our own.
//!
//! A recording is a text file with one JSON object a line: `case`, `push` = [x0, y0, x1, y1] of the tip's centre,
//! `tip` = {`w` across, `t` along}, `shapes[i]` = convex `pieces` in the body frame, `mass`, `izz` about the origin,
//! `before` and `after` = [x, y, yaw] of every body, and optionally `after_fresh` (the same push in a fresh world).
//! `before3d` = [x, y, z, qx, qy, qz, qw] says how the bodies leaned and how high they lay, for engines that know a
//! stance. Other fields are ignored. The centre of mass is the body's origin; a body's friction is 0.5, the ground's 1.1 and the
//! tip's 0.9. Metres, kilograms, radians.

use std::path::Path;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::fidelity::Against;
use crate::action::{ContourSampler, Push, PushSampler, SamplerScratch};
use crate::bounds;
use crate::error::{Error, Result};
use crate::files::{self, json};
use crate::geom::{Footprint, Piece, Pose2, convex_hull, vec2};
use crate::physics::{PushStatus, Stance, Transition};
use crate::run::{Key, Stop};
use crate::scene::generate::{Generator, GeneratorParams};
use crate::scene::{BodyDef, Friction, Gripper, Problem, PushTip, Scene, SceneBuilder, State, check_pose};

/// A case whose recordings are not planar (one block lies on another); left out.
pub const NOT_PLANAR: &str = "testo09";

/// Height at which the recorded bodies' lower faces come to rest, metres: ground and collision margin.
const RECORDED_REST: f64 = 0.0005;

/// One recorded push.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recording {
    #[serde(default)]
    pub id: String,
    #[serde(default)]
    pub case: String,
    pub push: [f64; 4],
    pub tip: RecordedTip,
    pub shapes: Vec<RecordedShape>,
    pub before: Vec<[f64; 3]>,
    pub after: Vec<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub after_fresh: Option<Vec<[f64; 3]>>,
    /// Positions and quaternions (x, y, z, w) before the push.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub before3d: Option<Vec<[f64; 7]>>,
}

/// Metres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RecordedTip {
    /// Across the push.
    pub w: f64,
    /// Along the push.
    pub t: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordedShape {
    pub pieces: Vec<Vec<[f64; 2]>>,
    pub mass: f64,
    pub izz: f64,
}

/// Reads a recording file. Errors name the field, line and column.
pub fn read(path: &Path) -> Result<Vec<Recording>> {
    parse(path, &files::read_text(path)?)
}

pub(super) fn parse(path: &Path, text: &str) -> Result<Vec<Recording>> {
    let mut recordings = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        // A line is a document of its own: its place in the file is a matter of counting on.
        let placed = |error| Error::format(path, json::on_line(error, i + 1));
        let recording: Recording = json::parse(line, "recording").map_err(placed)?;
        recording.check().map_err(|e| placed(json::located(line, e)))?;
        recordings.push(recording);
    }
    if recordings.is_empty() {
        return Err(Error::format(path, "holds no recorded pushes; it should have one JSON object a line"));
    }
    Ok(recordings)
}

impl Recording {
    /// Recordings of pushes in the plane can be compared with planar models.
    pub fn is_planar(&self) -> bool {
        !self.case.contains(NOT_PLANAR)
    }

    fn check(&self) -> Result<()> {
        let n = self.shapes.len();
        let same = |field: &str, count: usize| {
            if count == n {
                return Ok(());
            }
            Err(Error::argument(field, format!("has {count} poses for {n} shapes; give one for each")))
        };
        same("before", self.before.len())?;
        same("after", self.after.len())?;
        self.after_fresh.as_ref().map_or(Ok(()), |fresh| same("after_fresh", fresh.len()))?;
        self.before3d.as_ref().map_or(Ok(()), |poses| same("before3d", poses.len()))?;
        bounds::POSITION.check_all("push", self.push)?;
        let after_fresh = self.after_fresh.as_deref().unwrap_or_default();
        for (field, poses) in [("before", &*self.before), ("after", &self.after), ("after_fresh", after_fresh)] {
            for (i, at) in poses.iter().enumerate() {
                check_pose(&format!("{field}[{i}]"), &pose(at))?;
            }
        }
        for (i, values) in self.before3d.iter().flatten().enumerate() {
            bounds::POSITION.check_all(&format!("before3d[{i}]"), *values)?;
        }
        let renamed = |error| match error {
            Error::Argument { field, reason } => {
                let field = field.replacen("poses[", "before[", 1).replacen("bodies[", "shapes[", 1);
                let field = field.replace("gripper.push.width", "tip.w").replace("gripper.push.thickness", "tip.t");
                Error::argument(field.replace(".inertia", ".izz").replace(".shape.compound", ".pieces"), reason)
            }
            other => other,
        };
        let scene = self.scene().map_err(renamed)?;
        // Of what lies on each other a state in the plane cannot say that it does not overlap.
        if self.is_planar() { scene.check_state(&self.state()).map_err(renamed) } else { Ok(()) }
    }

    /// The scene of the recording: friction as in the recording simulator, centre of mass at the origin.
    pub fn scene(&self) -> Result<Scene> {
        let mut builder = SceneBuilder::new();
        for (i, shape) in self.shapes.iter().enumerate() {
            // Rounding of the recorded corners may have bent a straight edge inwards: hence the hulls.
            let hull = |piece: &Vec<[f64; 2]>| convex_hull(&piece.iter().map(|p| vec2(p[0], p[1])).collect::<Vec<_>>());
            let footprint = Footprint::from_convex_pieces(shape.pieces.iter().map(hull).collect())
                .map_err(|error| error.within(&format!("bodies[{i}]")))?;
            builder.add_body(BodyDef {
                mass: shape.mass,
                friction: 0.5,
                centre_of_mass: Some([0.0, 0.0]),
                inertia: Some(shape.izz),
                // The corners are the recording simulator's own.
                outline_tolerance: Some(0.0),
                ..BodyDef::new(footprint.shape)
            })?;
        }
        let push = PushTip { width: self.tip.w, thickness: self.tip.t, clearance: 0.0 };
        builder.gripper(Gripper { name: "recorded tip".into(), push, ..Gripper::default() });
        builder.friction(Friction { ground: 1.1, tip: 0.9 });
        builder.build()
    }

    /// Where the bodies were.
    pub fn state(&self) -> State {
        State::new(self.before.iter().map(pose))
    }

    pub fn push(&self) -> Push {
        let [x0, y0, x1, y1] = self.push;
        Push::new(vec2(x0, y0), vec2(x1, y1))
    }

    /// How the bodies stood; empty where the recording does not say. `scene` is the recording's.
    pub fn stances(&self, scene: &Scene) -> Vec<Stance> {
        let bodies = scene.bodies().iter();
        self.before3d.iter().flatten().zip(bodies).map(|(pose, body)| stance(pose, body.height)).collect()
    }

    pub(super) fn result(&self, against: Against) -> Option<&[[f64; 3]]> {
        match against {
            Against::Recorded => Some(&self.after),
            Against::Fresh => self.after_fresh.as_deref(),
        }
    }
}

/// A block stands on whichever of its sides is nearest to level; it leans by what is left.
fn stance(pose: &[f64; 7], height: f64) -> Stance {
    let [_, _, z, qx, qy, qz, qw] = *pose;
    // The vertical components of the block's axes, and the axis that is nearest to the vertical.
    let third = [2.0 * (qx * qz - qy * qw), 2.0 * (qy * qz + qx * qw), 1.0 - 2.0 * (qx * qx + qy * qy)];
    let axis = (0..3).fold(0, |best, k| if third[k].abs() > third[best].abs() { k } else { best });
    let horizontal = [
        [1.0 - 2.0 * (qy * qy + qz * qz), 2.0 * (qx * qy + qz * qw)],
        [2.0 * (qx * qy - qz * qw), 1.0 - 2.0 * (qx * qx + qz * qz)],
        [2.0 * (qx * qz + qy * qw), 2.0 * (qy * qz - qx * qw)],
    ][axis];
    let [x, y] = horizontal.map(|v| v * third[axis].signum());
    let (sine, cosine) = (x.hypot(y), third[axis].abs());
    // The turn that takes the vertical to the axis: about the horizontal direction across it.
    let scale = if sine > 0.0 { sine.atan2(cosine) / sine } else { 0.0 };
    // A block's origin lies amid its height only if it stands upright.
    let rise = if axis == 2 { z - (RECORDED_REST + height / 2.0) } else { 0.0 };
    Stance { lean: [-y * scale, x * scale], rise }
}

pub(super) fn pose(p: &[f64; 3]) -> Pose2 {
    Pose2::new(p[0], p[1], p[2])
}

/// What to record.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordParams {
    /// The scenes that pushes are made in.
    pub scenes: GeneratorParams,
    /// Pushes wanted.
    pub count: usize,
    /// Of them so many come from each scene.
    pub per_scene: usize,
    /// Travels of the pushes in turn, metres.
    pub lengths: Vec<f64>,
    pub seed: u64,
}

impl Default for RecordParams {
    /// Six pushes in each of many packed scenes, two of three of 0.10 m and one of 0.05 m.
    fn default() -> Self {
        Self { scenes: GeneratorParams::default(), count: 200, per_scene: 6, lengths: vec![0.1, 0.1, 0.05], seed: 0 }
    }
}

/// Executes pushes that a planner might try in generated scenes, and records what the engine that `engine` makes for a
/// scene does. `done` hears of every recorded push and ends the recording by returning false.
pub fn record(
    params: &RecordParams,
    engine: &dyn Fn(Arc<Scene>) -> Result<Arc<dyn Transition>>,
    done: &mut dyn FnMut(usize) -> bool,
) -> Result<Vec<Recording>> {
    if params.per_scene == 0 || params.lengths.is_empty() {
        return Err(Error::argument("per_scene", "and the list of lengths must not be empty"));
    }
    let generator = Generator::new(params.scenes.clone(), params.seed)?;
    let sampler = ContourSampler::preset("more")?;
    let mut scratch = SamplerScratch::default();
    let mut recordings: Vec<Recording> = Vec::with_capacity(params.count);
    let mut index = 0;
    while recordings.len() < params.count {
        let problem = generator.problem(index)?;
        let mut order = Key::new(params.seed).child(1).child(index).stream();
        index += 1;
        let mut pushes = Vec::new();
        let (scene, state) = (&problem.scene, &problem.state);
        sampler.sample(scene, state, problem.target, None, &mut order, &mut scratch, &mut pushes);
        let blank = Recording::blank(&problem);
        let world = engine(Arc::new(blank.scene()?))?;
        let mut memory = world.scratch();
        for push in pushes.into_iter().take(params.per_scene) {
            let length = params.lengths[recordings.len() % params.lengths.len()];
            let push = Push::new(push.start(), push.start() + push.direction() * length);
            let before = blank.state();
            let result = world.step(&mut memory, &before, &push, &Stop::never());
            let moved = (0..before.len()).any(|i| result.state.pose(i) != before.pose(i));
            if result.status != PushStatus::Executed || !moved || recordings.len() == params.count {
                continue;
            }
            recordings.push(Recording {
                id: format!("{}-{}", problem.name, recordings.len()),
                push: [push.start[0], push.start[1], push.end[0], push.end[1]],
                after: poses(&result.state),
                ..blank.clone()
            });
            if !done(recordings.len()) {
                return Ok(recordings);
            }
        }
    }
    Ok(recordings)
}

/// One JSON object a line.
pub fn to_lines(recordings: &[Recording]) -> Result<String> {
    let mut text = String::new();
    for recording in recordings {
        let line = serde_json::to_string(recording).map_err(|e| Error::Internal(format!("recording: {e}")))?;
        text.push_str(&line);
        text.push('\n');
    }
    Ok(text)
}

impl Recording {
    /// The problem's bodies where they are; nothing pushed yet.
    fn blank(problem: &Problem) -> Recording {
        let scene = &problem.scene;
        let corners = |piece: &Piece| crate::geom::corners(piece).iter().map(|p| [p.x, p.y]).collect();
        let shapes = scene.bodies().iter().map(|body| RecordedShape {
            pieces: body.footprint.pieces.iter().map(corners).collect(),
            mass: body.mass,
            // About the origin, as the format has it.
            izz: body.inertia + body.mass * body.centre_of_mass.norm_squared(),
        });
        let before = poses(&problem.state);
        Recording {
            id: String::new(),
            case: problem.name.clone(),
            push: [0.0; 4],
            tip: RecordedTip { w: scene.gripper().push.width, t: scene.gripper().push.thickness },
            shapes: shapes.collect(),
            after: before.clone(),
            before,
            after_fresh: None,
            before3d: None,
        }
    }
}

fn poses(state: &State) -> Vec<[f64; 3]> {
    (0..state.len()).map(|i| state.pose(i)).map(|p| [p.x, p.y, p.theta]).collect()
}

#[cfg(test)]
mod tests {
    use super::super::fidelity::compare;
    use super::*;
    use crate::physics::{self, PhysicsOptions};

    #[test]
    fn what_an_engine_recorded_it_repeats_exactly() {
        let engine = |scene| physics::engine(&PhysicsOptions::preset("fast"), scene);
        let params = RecordParams { count: 8, per_scene: 3, seed: 5, ..RecordParams::default() };
        let recorded = record(&params, &engine, &mut |_| true).unwrap();
        assert_eq!(recorded.len(), 8);
        assert_ne!(recorded[0].case, recorded[7].case, "several scenes");
        let lines = to_lines(&recorded).unwrap();
        let read = parse(Path::new("own.jsonl"), &lines).unwrap();
        assert_eq!(read, recorded);
        let same = compare(&read, Against::Recorded, &engine).unwrap();
        assert!(same.moved.count >= 8 && same.moved.mean_iou > 0.9999, "{same:?}");
        let finer = |scene| physics::engine(&PhysicsOptions::preset("fine"), scene);
        assert!(compare(&read, Against::Recorded, &finer).unwrap().moved.mean_iou < 0.999, "another engine differs");
    }

    #[test]
    fn a_stance_is_the_lean_from_the_nearest_side() {
        let half = 0.002f64.sin();
        let upright = stance(&[0.0, 0.0, 0.0231, half, 0.0, 0.0, 0.002f64.cos()], 0.045);
        assert!((upright.lean[0] - 0.004).abs() < 1e-9 && upright.lean[1].abs() < 1e-12, "{upright:?}");
        assert!((upright.rise - 1e-4).abs() < 1e-12);
        // On its side: turned by a right angle about x, and 4 mrad less.
        let angle: f64 = std::f64::consts::FRAC_PI_4 - 0.002;
        let side = stance(&[0.0, 0.0, 0.03, angle.sin(), 0.0, 0.0, angle.cos()], 0.045);
        assert!((side.lean[0] + 0.004).abs() < 1e-9 && side.rise == 0.0, "{side:?}");
    }

    /// Line, column and field of what is wrong, whichever line it stands in.
    #[test]
    fn what_is_wrong_with_a_recording_has_its_field_and_place() {
        let engine = |scene| physics::engine(&PhysicsOptions::preset("fast"), scene);
        let made = record(&RecordParams { count: 3, ..RecordParams::default() }, &engine, &mut |_| true).unwrap();
        let lines: Vec<String> = to_lines(&made).unwrap().lines().map(str::to_owned).collect();
        let key = |name: &str| format!("\"{name}\":");
        for (at, name, bad, wanted) in [
            (0, "izz", "1e300", "shapes[0].izz: is 1e300; with a mass of"),
            (1, "mass", "-1", "shapes[0].mass: is -1; it must lie in 1e-9 to 1000 kg"),
            (1, "mass", "\"x\"", "shapes[0].mass: invalid type: string \"x\", expected f64"),
            (2, "w", "0", "tip.w: is 0; it must lie in 1e-4 to 10 m"),
            (2, "push", "[1,2,3,4e9],\"x\":0", "push: is 4e9; it must lie in -100 to 100 m"),
        ] {
            let mut spoilt = lines.clone();
            let start = spoilt[at].find(&key(name)).unwrap() + key(name).len();
            let length = if name == "push" {
                spoilt[at][start..].find(']').unwrap() + 1
            } else {
                spoilt[at][start..].find([',', '}']).unwrap()
            };
            spoilt[at].replace_range(start..start + length, bad);
            let error = parse(Path::new("a.jsonl"), &spoilt.join("\n")).unwrap_err().to_string();
            assert!(error.starts_with(&format!("a.jsonl: {wanted}")), "{error}");
            let column = if bad.starts_with('"') { start + bad.len() } else { start + 1 };
            let place = format!("(line {}, column {column})", at + 1);
            assert!(error.ends_with(&place), "{error}\n{place}");
        }
    }

    #[test]
    fn recording_ends_when_asked_to() {
        let engine = |scene| physics::engine(&PhysicsOptions::preset("fast"), scene);
        let some = record(&RecordParams::default(), &engine, &mut |n| n < 2).unwrap();
        assert_eq!(some.len(), 2);
    }
}
