//! How well a model of pushing agrees with recorded pushes.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::recording::{Recording, pose};
use super::statistics::{mean, median, percentile};
use crate::error::{Error, Result};
use crate::geom::{Footprint, Pose2, normalize_angle};
use crate::physics::{PushJob, PushStatus, Transition};
use crate::run::Stop;
use crate::scene::Scene;

/// A body counts as moved if its origin moved farther than this, metres ...
pub const MOVED_POSITION: f64 = 0.002;
/// ... or if it turned by more than this, radians.
pub const MOVED_ROTATION: f64 = 2.0 * std::f64::consts::PI / 180.0;

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
    /// Pushes that the engine refused as illegal or could not solve; counted as if nothing had moved.
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

/// Collects how far bodies are from where they should be.
#[derive(Default)]
pub(super) struct Sums {
    all_iou: Vec<f64>,
    iou: Vec<f64>,
    position_mm: Vec<f64>,
    rotation_deg: Vec<f64>,
    missed: usize,
    ghosts: usize,
}

impl Sums {
    pub fn add(&mut self, footprint: &Footprint, before: &Pose2, wanted: &Pose2, got: &Pose2) {
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

    pub fn finish(&self) -> (MovedAgreement, AllAgreement) {
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
    use super::super::recording::parse;
    use super::super::testing::Slide;
    use super::*;
    use std::path::Path;

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
    fn a_bad_line_is_named() {
        for (text, wanted, place) in [
            (format!("{}\n{{", line()), "recording: EOF while parsing an object", "(line 2"),
            (line().replace("[[0.52, 0, 0], ", "["), "after: has 1 poses for 2 shapes", "(line 1"),
            (line().replacen("\"mass\": 0.1", "\"mass\": -1", 1), "shapes[0].mass: is -1", "(line 1"),
            ("\n".to_string(), "holds no recorded pushes", ""),
        ] {
            let error = recordings(&text).unwrap_err().to_string();
            assert!(error.contains(wanted) && error.contains(place), "{error}");
        }
    }
}
