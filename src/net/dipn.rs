//! DIPN: the motion of every body by a push.

use super::info::ModelInfo;
use super::kind::Kind;
use super::model::Model;
use super::objects::ObjectBatch;
use crate::error::Result;
use crate::run::Stop;

/// What predicts motions: a network, or a stand-in of a test.
pub trait MotionModel: Send + Sync {
    /// Name for reports.
    fn name(&self) -> &str;

    /// It wants the planar engine's prediction as `guess`.
    fn wants_guess(&self) -> bool;

    /// Items of a call at which it is at its best; a call may have any number.
    fn chunk(&self) -> usize;

    /// Motions of all bodies of all items in their push frames: metres, metres, radians; `items * objects` of them. A
    /// requested stop makes it an error or any motions.
    fn predict(&self, batch: &ObjectBatch, motions: &mut Vec<[f32; 3]>, stop: &Stop) -> Result<()>;

    /// What its file says, if it has one: planners hold it to its gripper.
    fn info(&self) -> Option<&ModelInfo> {
        None
    }
}

/// A network of kind `dipn`.
#[derive(Debug, Clone)]
pub struct Dipn {
    model: Model,
    name: String,
    guess: bool,
}

impl Dipn {
    /// Refuses a network of another kind.
    pub fn new(model: Model) -> Result<Dipn> {
        model.expect(Kind::Dipn)?;
        let guess = model.info().spec.guess.as_deref() == Some("planar");
        let stem = model.info().path.file_stem().map_or("dipn".into(), |stem| stem.to_string_lossy().into_owned());
        Ok(Dipn { model, name: stem, guess })
    }

    pub fn model(&self) -> &Model {
        &self.model
    }
}

impl MotionModel for Dipn {
    fn info(&self) -> Option<&ModelInfo> {
        Some(self.model.info())
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn wants_guess(&self) -> bool {
        self.guess
    }

    fn chunk(&self) -> usize {
        self.model.info().interface.chunk
    }

    fn predict(&self, batch: &ObjectBatch, motions: &mut Vec<[f32; 3]>, stop: &Stop) -> Result<()> {
        motions.clear();
        let mut outputs = [Vec::new()];
        let inputs = batch.tensors(self.model.info().interface);
        self.model.run_until(batch.items(), batch.objects(), &inputs, &mut outputs, stop)?;
        motions.extend(outputs[0].as_chunks::<3>().0);
        Ok(())
    }
}
