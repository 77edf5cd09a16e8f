//! How well a model of pushing agrees with recorded pushes.
//!
//! A recording is a text file with one JSON object a line: `case`, `push` = [x0, y0, x1, y1] of the tip's centre,
//! `tip` = {`w` across, `t` along}, `shapes[i]` = convex `pieces` in the body frame, `mass`, `izz` about the origin,
//! `before` and `after` = [x, y, yaw] of every body, and optionally `after_fresh` (the same push in a fresh world).
//! `before3d` = [x, y, z, qx, qy, qz, qw] says how the bodies leaned and how high they lay, for engines that know a
//! stance. Other fields are ignored. The centre of mass is the body's origin.

use std::path::Path;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::statistics::{mean, median, percentile};
use crate::action::Push;
use crate::error::{Error, Result};
use crate::geom::{Footprint, Pose2, convex_hull, normalize_angle, vec2};
use crate::physics::{PushJob, PushStatus, Stance, Transition};
use crate::run::Stop;
use crate::scene::{BodyDef, Friction, Gripper, PushTip, Scene, SceneBuilder, State};

/// A body counts as moved if its origin moved farther than this, metres ...
pub const MOVED_POSITION: f64 = 0.002;
/// ... or if it turned by more than this, radians.
pub const MOVED_ROTATION: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// Height at which the recorded bodies' lower faces come to rest, metres: ground and collision margin.
const RECORDED_REST: f64 = 0.0005;

/// A case whose recordings are not planar (one block lies on another); left out.
pub const NOT_PLANAR: &str = "testo09";

/// Which recorded result is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Against {
    /// The push as it was recorded.
    #[default]
    Recorded,
    /// The same push in a fresh world.
    Fresh,
}

/// One recorded push.
#[derive(Debug, Clone, PartialEq, Deserialize)]
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
    #[serde(default)]
    pub after_fresh: Option<Vec<[f64; 3]>>,
    #[serde(default)]
    pub before3d: Option<Vec<[f64; 7]>>,
}

/// Metres.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct RecordedTip {
    /// Across the push.
    pub w: f64,
    /// Along the push.
    pub t: f64,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct RecordedShape {
    pub pieces: Vec<Vec<[f64; 2]>>,
    pub mass: f64,
    pub izz: f64,
}

/// Reads a recording file. Errors name the line.
pub fn read(path: &Path) -> Result<Vec<Recording>> {
    parse(path, &std::fs::read_to_string(path).map_err(|e| Error::io(path, e))?)
}

fn parse(path: &Path, text: &str) -> Result<Vec<Recording>> {
    let mut recordings = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let recording: Recording =
            serde_json::from_str(line).map_err(|e| Error::format(path, format!("line {}: {e}", i + 1)))?;
        recording.check().map_err(|e| Error::format(path, format!("line {}: {e}", i + 1)))?;
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
        let poses = self.before.iter().chain(&self.after).chain(self.after_fresh.iter().flatten());
        if !poses.flatten().chain(&self.push).all(|v| v.is_finite())
            || !self.before3d.iter().flatten().flatten().all(|v| v.is_finite())
        {
            return Err(Error::argument("recording", "holds a number that is not finite"));
        }
        self.scene().map(|_| ())
    }

    /// The scene of the recording: friction as in the recording simulator, centre of mass at the origin.
    pub fn scene(&self) -> Result<Scene> {
        let mut builder = SceneBuilder::new();
        for shape in &self.shapes {
            // Rounding of the recorded corners may have bent a straight edge inwards: hence the hulls.
            let hull = |piece: &Vec<[f64; 2]>| convex_hull(&piece.iter().map(|p| vec2(p[0], p[1])).collect::<Vec<_>>());
            let footprint = Footprint::from_convex_pieces(shape.pieces.iter().map(hull).collect())?;
            builder.add_body(BodyDef {
                mass: shape.mass,
                friction: 0.5,
                centre_of_mass: Some([0.0, 0.0]),
                inertia: Some(shape.izz),
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

    fn result(&self, against: Against) -> Option<&[[f64; 3]]> {
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

fn pose(p: &[f64; 3]) -> Pose2 {
    Pose2::new(p[0], p[1], p[2])
}

/// Agreement over bodies that moved in either result.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct MovedAgreement {
    pub count: usize,
    /// Intersection over union of the footprints.
    pub mean_iou: f64,
    pub median_iou: f64,
    pub p10_iou: f64,
    pub mean_position_mm: f64,
    pub median_position_mm: f64,
    pub p90_position_mm: f64,
    pub mean_rotation_deg: f64,
    pub median_rotation_deg: f64,
    pub p90_rotation_deg: f64,
    /// Moved in the recording only.
    pub missed: usize,
    /// Moved in the model only.
    pub ghosts: usize,
}

/// Agreement over all bodies.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct AllAgreement {
    pub count: usize,
    pub mean_iou: f64,
}

/// How well an engine agrees with recorded pushes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Fidelity {
    /// The engine's name for itself.
    pub engine: String,
    pub against: Against,
    /// Pushes compared.
    pub pushes: usize,
    /// Pushes left out: not planar, or without the result compared with.
    pub left_out: usize,
    /// Pushes that the engine refused as illegal; counted as if nothing had moved.
    pub illegal: usize,
    /// Moved bodies compared, as in `moved.count`.
    pub count: usize,
    pub moved: MovedAgreement,
    pub all: AllAgreement,
}

/// Runs every planar recording through the engine that `engine` makes for its scene, and compares the results.
pub fn compare(
    recordings: &[Recording],
    against: Against,
    engine: &dyn Fn(Arc<Scene>) -> Result<Arc<dyn Transition>>,
) -> Result<Fidelity> {
    let mut sums = Sums::default();
    let mut name = String::new();
    let (mut pushes, mut illegal) = (0, 0);
    for recording in recordings.iter().filter(|r| r.is_planar()) {
        let Some(wanted) = recording.result(against) else { continue };
        let scene = Arc::new(recording.scene()?);
        let transition = engine(Arc::clone(&scene))?;
        let mut scratch = transition.scratch();
        let state = recording.state();
        let job = PushJob { state: &state, push: recording.push() };
        let result = transition.step_standing(&mut scratch, &job, &recording.stances(&scene), &Stop::never());
        pushes += 1;
        illegal += usize::from(result.status != PushStatus::Executed);
        for (i, (before, wanted)) in recording.before.iter().zip(wanted).enumerate() {
            sums.add(&scene.body(i).footprint, &pose(before), &pose(wanted), &result.state.pose(i));
        }
        name = transition.name().to_string();
    }
    if pushes == 0 {
        return Err(Error::argument("recordings", "none of them can be compared with"));
    }
    let left_out = recordings.len() - pushes;
    let (moved, all) = sums.finish();
    Ok(Fidelity { engine: name, against, pushes, left_out, illegal, count: moved.count, moved, all })
}

#[derive(Default)]
struct Sums {
    all_iou: Vec<f64>,
    iou: Vec<f64>,
    position_mm: Vec<f64>,
    rotation_deg: Vec<f64>,
    missed: usize,
    ghosts: usize,
}

impl Sums {
    fn add(&mut self, footprint: &Footprint, before: &Pose2, wanted: &Pose2, got: &Pose2) {
        let apart =
            |a: &Pose2, b: &Pose2| ((a.position() - b.position()).norm(), normalize_angle(a.theta - b.theta).abs());
        let moved = |to: &Pose2| {
            let (position, rotation) = apart(before, to);
            position > MOVED_POSITION || rotation > MOVED_ROTATION
        };
        let iou = footprint.iou(wanted, got);
        self.all_iou.push(iou);
        let (in_recording, in_model) = (moved(wanted), moved(got));
        if !in_recording && !in_model {
            return;
        }
        self.missed += usize::from(!in_model);
        self.ghosts += usize::from(!in_recording);
        let (position, rotation) = apart(wanted, got);
        self.iou.push(iou);
        self.position_mm.push(position * 1e3);
        self.rotation_deg.push(rotation.to_degrees());
    }

    fn finish(&self) -> (MovedAgreement, AllAgreement) {
        let moved = MovedAgreement {
            count: self.iou.len(),
            mean_iou: mean(&self.iou),
            median_iou: median(&self.iou),
            p10_iou: percentile(&self.iou, 0.1),
            mean_position_mm: mean(&self.position_mm),
            median_position_mm: median(&self.position_mm),
            p90_position_mm: percentile(&self.position_mm, 0.9),
            mean_rotation_deg: mean(&self.rotation_deg),
            median_rotation_deg: median(&self.rotation_deg),
            p90_rotation_deg: percentile(&self.rotation_deg, 0.9),
            missed: self.missed,
            ghosts: self.ghosts,
        };
        (moved, AllAgreement { count: self.all_iou.len(), mean_iou: mean(&self.all_iou) })
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::Slide;
    use super::*;

    /// Two squares of 40 mm; the first one was pushed 20 mm along x, and turned by 10 degrees in the fresh world.
    const LINE: &str = r#"{"id": "a", "case": "hard/test01.txt", "push": [0.44, 0, 0.48, 0], "tip": {"w": 0.03, "t": 0.022},
        "shapes": [{"pieces": [[[-0.02, -0.02], [0.02, -0.02], [0.02, 0.02], [-0.02, 0.02]]], "mass": 0.1, "izz": 3e-5},
                   {"pieces": [[[-0.02, -0.02], [0.02, -0.02], [0.02, 0.02], [-0.02, 0.02]]], "mass": 0.1, "izz": 3e-5}],
        "before": [[0.5, 0, 0], [0.5, 0.1, 0]], "after": [[0.52, 0, 0], [0.5, 0.1, 0]],
        "after_fresh": [[0.5, 0, 0.17453292519943295], [0.5, 0.1, 0]]}"#;

    fn line() -> String {
        LINE.replace('\n', " ")
    }

    fn recordings(text: &str) -> Result<Vec<Recording>> {
        parse(Path::new("pushes.jsonl"), text)
    }

    fn check(offset: Pose2, against: Against, text: &str) -> Fidelity {
        compare(&recordings(text).unwrap(), against, &|scene| Ok(Arc::new(Slide { scene, offset }))).unwrap()
    }

    #[test]
    fn a_perfect_model_agrees_perfectly() {
        let f = check(Pose2::new(0.02, 0.0, 0.0), Against::Recorded, &line());
        assert_eq!((f.pushes, f.count, f.moved.count, f.all.count, f.left_out, f.illegal), (1, 1, 1, 2, 0, 0));
        assert!(f.moved.mean_iou > 0.9999 && f.all.mean_iou > 0.9999, "{f:?}");
        assert!(f.moved.median_position_mm < 1e-4 && f.moved.median_rotation_deg < 1e-4);
        assert_eq!((f.moved.missed, f.moved.ghosts, f.engine.as_str()), (0, 0, "slide"));
    }

    #[test]
    fn a_model_in_which_nothing_moves_misses() {
        let f = check(Pose2::IDENTITY, Against::Recorded, &line());
        // 40 mm squares 20 mm apart: half of one over one and a half.
        assert!((f.moved.mean_iou - 1.0 / 3.0).abs() < 1e-6 && (f.all.mean_iou - 2.0 / 3.0).abs() < 1e-6);
        assert!((f.moved.p90_position_mm - 20.0).abs() < 1e-3);
        assert_eq!((f.moved.missed, f.moved.ghosts), (1, 0));
    }

    #[test]
    fn the_fresh_result_is_another_one() {
        let f = check(Pose2::new(0.0, 0.0, 0.0), Against::Fresh, &line());
        assert!((f.moved.median_rotation_deg - 10.0).abs() < 1e-4 && f.moved.median_position_mm < 1e-4);
    }

    #[test]
    fn what_is_not_planar_is_left_out() {
        let text = format!("{}\n{}\n\n", line(), line().replace("test01", "testo09"));
        let f = check(Pose2::new(0.02, 0.0, 0.0), Against::Recorded, &text);
        assert_eq!((f.pushes, f.left_out), (1, 1));
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

    #[test]
    fn a_bad_line_is_named() {
        for (text, wanted) in [
            (format!("{}\n{{", line()), "line 2: EOF"),
            (line().replace("[[0.52, 0, 0], ", "["), "line 1: after: has 1 poses for 2 shapes"),
            (line().replacen("\"mass\": 0.1", "\"mass\": -1", 1), "line 1: bodies[0].mass: is -1"),
            ("\n".to_string(), "holds no recorded pushes"),
        ] {
            let error = recordings(&text).unwrap_err().to_string();
            assert!(error.contains(wanted), "{error}");
        }
    }
}
