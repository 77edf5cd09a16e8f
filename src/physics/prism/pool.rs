//! Many pushes at once: each has a world, and worlds that are to be solved are swept side by side.

use super::Prism;
use super::model::Real;
use super::solver::Solve;
use super::wide::Sweep;
use super::world::World;
use crate::physics::lanes::InstructionSet;
use crate::physics::transition::{PushJob, PushResult, PushStatus};
use crate::run::Stop;

/// Worlds of a pool: three times the lanes, to even out the lengths of their lists.
pub const WORLDS: usize = 24;
/// With fewer worlds than this each is solved by itself.
const FEW: usize = 2;

/// The worlds of one thread. They keep their memory from push to push.
pub struct Pool {
    worlds: Vec<World>,
    /// The job of each world; none for a world at rest.
    jobs: Vec<Option<usize>>,
    set: InstructionSet,
}

impl Default for Pool {
    fn default() -> Self {
        Self { worlds: Vec::new(), jobs: Vec::new(), set: InstructionSet::best() }
    }
}

impl Pool {
    #[cfg(test)]
    pub fn with_set(set: InstructionSet) -> Self {
        Self { set, ..Self::default() }
    }

    /// Runs all jobs. Which jobs share the pool does not show in a result.
    pub fn run(&mut self, engine: &Prism, jobs: &[PushJob<'_>], results: &mut [PushResult], stop: &Stop) {
        let count = jobs.len().min(results.len());
        let wanted = count.min(WORLDS);
        if self.worlds.len() < wanted {
            self.worlds.resize_with(wanted, World::default);
        }
        self.jobs.clear();
        self.jobs.resize(self.worlds.len(), None);
        self.worlds.iter_mut().for_each(|w| w.rows.solving = false);
        let mut next = 0;
        let (model, settings) = (&engine.model, &engine.settings);
        let tolerance = settings.tolerance as Real;
        loop {
            // Looked at before every step of a world: those of many bodies take some tens of microseconds.
            if stop.requested() {
                return self.interrupt(next..count, results);
            }
            let mut solving = 0;
            for (world, held) in self.worlds.iter_mut().zip(&mut self.jobs).take(wanted) {
                if world.rows.solving {
                    solving += 1;
                    continue;
                }
                if stop.requested() {
                    break;
                }
                // The step is solved, or there is none: go on to the next that has something to solve.
                if let Some(job) = *held {
                    world.end_step(model, settings);
                    if world.begin_step(model, settings) {
                        solving += 1;
                        continue;
                    }
                    engine.finish(world, &jobs[job], &mut results[job]);
                    *held = None;
                }
                while next < count && held.is_none() && !stop.requested() {
                    let job = next;
                    next += 1;
                    if !engine.begin(world, &jobs[job], &mut results[job]) {
                        continue;
                    }
                    if world.begin_step(model, settings) {
                        *held = Some(job);
                        solving += 1;
                    } else {
                        engine.finish(world, &jobs[job], &mut results[job]);
                    }
                }
            }
            if stop.requested() {
                continue;
            }
            if solving == 0 {
                return;
            }
            if solving < FEW {
                for world in self.worlds.iter_mut().filter(|w| w.rows.solving) {
                    self.set.with(Solve { rows: &mut world.rows, tolerance });
                }
                continue;
            }
            self.set.with(Sweep { worlds: &mut self.worlds });
            for world in self.worlds.iter_mut().filter(|w| w.rows.solving) {
                world.rows.end_sweep(tolerance);
            }
        }
    }

    /// The jobs that are under way and those that were not begun will not be finished.
    fn interrupt(&mut self, left: std::ops::Range<usize>, results: &mut [PushResult]) {
        let unfinished = self.jobs.iter_mut().filter_map(Option::take).chain(left);
        unfinished.for_each(|job| results[job].status = PushStatus::Interrupted);
    }
}
