//! PPN: the value of each push.

use super::info::ModelInfo;
use super::kind::Kind;
use super::model::Model;
use super::objects::{ObjectBatch, ObjectTable};
use crate::action::Push;
use crate::error::{Error, Result};
use crate::run::Stop;
use crate::scene::{Scene, State};

/// What tells good pushes from bad ones before any is simulated: a network, or a stand-in of a test.
pub trait PushValue: Send + Sync {
    /// Name for reports.
    fn name(&self) -> &str;

    /// The value in [0, 1] of the best plan that begins with each push, for retrieving `target`. A requested stop leaves
    /// the rest at 0.
    #[allow(clippy::too_many_arguments)]
    fn values(
        &self,
        scratch: &mut PushValueScratch,
        scene: &Scene,
        state: &State,
        target: usize,
        pushes: &[Push],
        values: &mut Vec<f32>,
        stop: &Stop,
    ) -> Result<()>;

    /// What its file says, if it has one: planners hold it to its gripper.
    fn info(&self) -> Option<&ModelInfo> {
        None
    }
}

/// Working memory for one thread, and the table of the scene it was last used on.
#[derive(Debug, Clone, Default)]
pub struct PushValueScratch {
    table: Option<(Scene, ObjectTable)>,
    batch: ObjectBatch,
}

/// A network of kind `ppn`.
#[derive(Debug, Clone)]
pub struct Ppn {
    model: Model,
}

impl Ppn {
    /// Refuses a network of another kind.
    pub fn new(model: Model) -> Result<Ppn> {
        model.expect(Kind::Ppn)?;
        Ok(Ppn { model })
    }

    pub fn model(&self) -> &Model {
        &self.model
    }
}

impl PushValue for Ppn {
    fn info(&self) -> Option<&ModelInfo> {
        Some(self.model.info())
    }

    fn name(&self) -> &str {
        "ppn"
    }

    fn values(
        &self,
        scratch: &mut PushValueScratch,
        scene: &Scene,
        state: &State,
        target: usize,
        pushes: &[Push],
        values: &mut Vec<f32>,
        stop: &Stop,
    ) -> Result<()> {
        if target >= scene.len() {
            return Err(Error::not_found(
                "target",
                format!("there is no body {target}; the scene has {}", scene.len()),
            ));
        }
        let PushValueScratch { table, batch } = scratch;
        let table = match table {
            Some((known, table)) if known == scene => table,
            _ => &table.insert((scene.clone(), ObjectTable::new(scene))).1,
        };
        values.clear();
        let interface = self.model.info().interface;
        let mut outputs = [Vec::new()];
        for pushes in pushes.chunks(interface.chunk) {
            if stop.requested() {
                break;
            }
            batch.clear(scene.len());
            for push in pushes {
                batch.add(table, scene, state, push, None, Some(target));
            }
            self.model.run_until(batch.items(), batch.objects(), &batch.tensors(interface), &mut outputs, stop)?;
            values.extend(outputs[0].iter().map(|v| v.clamp(0.0, 1.0)));
        }
        values.resize(pushes.len(), 0.0);
        Ok(())
    }
}
