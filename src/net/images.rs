//! GC and GN: networks on the image of a target.

use super::info::ModelInfo;
use super::kind::{GRASP_ANGLES, Kind};
use super::model::Model;
use crate::error::Result;
use crate::geom::{Pose2, Vec2, vec2};
use crate::run::Stop;
use crate::scene::{Scene, State};
use crate::vision::{Frame, Rasteriser};

/// Working memory for one thread.
#[derive(Debug, Default)]
pub struct ImageScratch {
    rasteriser: Rasteriser,
    image: Vec<f32>,
    outputs: [Vec<f32>; 1],
}

/// A network of kind `gc`: the probability that the target can be grasped where it is.
#[derive(Debug, Clone)]
pub struct Gc {
    model: Model,
}

/// A network of kind `gn`: the expected score of a grasp at every place and angle.
#[derive(Debug, Clone)]
pub struct Gn {
    model: Model,
}

/// What says whether a target can be grasped: a network, or a stand-in of a test.
pub trait TargetProbability: Send + Sync {
    /// The probability in [0, 1] that the target can be grasped where it is. A requested stop makes it an error or any number.
    fn probability(
        &self,
        scratch: &mut ImageScratch,
        scene: &Scene,
        state: &State,
        target: usize,
        stop: &Stop,
    ) -> Result<f64>;

    /// The probability from which on the answer is yes.
    fn threshold(&self) -> f64;

    /// What its file says, if it has one: planners hold it to its gripper.
    fn info(&self) -> Option<&ModelInfo> {
        None
    }
}

/// What finds grasps of a target: a network, or a stand-in of a test.
pub trait GraspMap: Send + Sync {
    /// The best grasps of a target, best first, at most so many; equal ones in a fixed order. A requested stop makes it an
    /// error or any grasps.
    #[allow(clippy::too_many_arguments)]
    fn best(
        &self,
        scratch: &mut ImageScratch,
        scene: &Scene,
        state: &State,
        target: usize,
        most: usize,
        found: &mut Vec<MapGrasp>,
        stop: &Stop,
    ) -> Result<()>;

    /// The score from which on a grasp counts.
    fn threshold(&self) -> f64;

    /// What its file says, if it has one: planners hold it to its gripper.
    fn info(&self) -> Option<&ModelInfo> {
        None
    }
}

/// The best grasp of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapGrasp {
    /// Midpoint between the pads, world frame, metres.
    pub position: Vec2,
    /// Closing direction from +x of the world, radians in [0, pi).
    pub angle: f64,
    /// Expected score in [0, 1].
    pub quality: f64,
}

/// Paints the target's view and runs the network on it.
fn look(
    model: &Model,
    scratch: &mut ImageScratch,
    scene: &Scene,
    state: &State,
    target: usize,
    stop: &Stop,
) -> Result<Frame> {
    let side = model.info().side.unwrap_or(0);
    let frame = Frame::around(scene, state, target, 0.0, model.info().pixel(), side)?;
    let ImageScratch { rasteriser, image, outputs } = scratch;
    image.resize(2 * side * side, 0.0);
    rasteriser.target_view(scene, state, target, &frame, image)?;
    model.run_until(1, 1, &[image.as_slice()], outputs, stop)?;
    Ok(frame)
}

impl Gc {
    /// Refuses a network of another kind.
    pub fn new(model: Model) -> Result<Gc> {
        model.expect(Kind::Gc)?;
        Ok(Gc { model })
    }

    pub fn model(&self) -> &Model {
        &self.model
    }
}

impl TargetProbability for Gc {
    fn info(&self) -> Option<&ModelInfo> {
        Some(self.model.info())
    }

    fn threshold(&self) -> f64 {
        self.model.info().threshold()
    }

    fn probability(
        &self,
        scratch: &mut ImageScratch,
        scene: &Scene,
        state: &State,
        target: usize,
        stop: &Stop,
    ) -> Result<f64> {
        look(&self.model, scratch, scene, state, target, stop)?;
        Ok(scratch.outputs[0].first().map_or(0.0, |p| f64::from(*p).clamp(0.0, 1.0)))
    }
}

impl Gn {
    /// Refuses a network of another kind.
    pub fn new(model: Model) -> Result<Gn> {
        model.expect(Kind::Gn)?;
        Ok(Gn { model })
    }

    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The map of a target: `quality[(angle * half + row) * half + col]`, with the frame of its cells.
    pub fn map<'a>(
        &self,
        scratch: &'a mut ImageScratch,
        scene: &Scene,
        state: &State,
        target: usize,
        stop: &Stop,
    ) -> Result<(Frame, &'a [f32])> {
        let frame = look(&self.model, scratch, scene, state, target, stop)?;
        let half = frame.rows / 2;
        Ok((Frame::new(frame.pose, 2.0 * frame.pixel, half, half), &scratch.outputs[0]))
    }
}

impl GraspMap for Gn {
    fn info(&self) -> Option<&ModelInfo> {
        Some(self.model.info())
    }

    fn threshold(&self) -> f64 {
        self.model.info().threshold()
    }

    /// Equal ones by their place in the map.
    fn best(
        &self,
        scratch: &mut ImageScratch,
        scene: &Scene,
        state: &State,
        target: usize,
        most: usize,
        found: &mut Vec<MapGrasp>,
        stop: &Stop,
    ) -> Result<()> {
        found.clear();
        let (cells, quality) = self.map(scratch, scene, state, target, stop)?;
        // Ascending by quality; the list is short.
        let mut best: Vec<(f32, usize)> = Vec::with_capacity(most + 1);
        for (index, &q) in quality.iter().enumerate() {
            if best.len() == most && best.first().is_none_or(|least| q <= least.0) {
                continue;
            }
            let at = best.partition_point(|(other, _)| *other < q);
            best.insert(at, (q, index));
            if best.len() > most {
                best.remove(0);
            }
        }
        found.extend(best.iter().rev().map(|&(q, index)| to_grasp(&cells, index, q)));
        Ok(())
    }
}

/// The grasp of a cell.
fn to_grasp(cells: &Frame, index: usize, quality: f32) -> MapGrasp {
    let (plane, cell) = (index / cells.len(), index % cells.len());
    let (row, col) = (cell / cells.cols, cell % cells.cols);
    let at = vec2(
        (col as f64 + 0.5 - cells.cols as f64 / 2.0) * cells.pixel,
        (row as f64 + 0.5 - cells.rows as f64 / 2.0) * cells.pixel,
    );
    let pose: Pose2 = cells.pose;
    let angle =
        (pose.theta + plane as f64 * std::f64::consts::PI / GRASP_ANGLES as f64).rem_euclid(std::f64::consts::PI);
    MapGrasp { position: pose.transform_point(at), angle, quality: f64::from(quality).clamp(0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_is_a_place_and_an_angle() {
        let cells = Frame::new(Pose2::new(0.5, 0.1, 0.0), 0.004, 4, 4);
        let grasp = to_grasp(&cells, 8 * 16 + 4 + 3, 0.7);
        assert!((grasp.position - vec2(0.506, 0.098)).norm() < 1e-12);
        assert!((grasp.angle - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert!((grasp.quality - 0.7).abs() < 1e-7);
    }
}
