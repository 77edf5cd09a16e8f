//! A quasi-static engine of our own that runs sixteen pushes side by side.

mod found;
mod lane;
mod model;
mod settings;
mod sweep;
mod trig;
mod uneven;

use std::sync::Arc;

pub use settings::PlanarSettings;

use self::lane::{Lane, Shared};
use self::model::Model;
use self::sweep::{Constants, Cursor, Impulse, PUSHES, Record, SLOTS, sweep};
use super::lanes::simd::WithSimd;
use super::lanes::{self, Group, InstructionSet, LANES, LaneWork, One, Simd8};
use super::transition::{PushJob, PushResult, PushStatus, Scratch, Transition};
use crate::error::Result;
use crate::run::Stop;
use crate::scene::Scene;

/// Jobs of a call at which the lanes are busy almost all of the time.
const BATCH: usize = 64;

/// The engine prepared for one scene.
pub struct Planar {
    name: String,
    scene: Arc<Scene>,
    settings: PlanarSettings,
    instruction_set: InstructionSet,
    model: Model,
}

/// Working memory of a thread. It serves every engine of this kind, one after the other.
struct Workspace {
    lanes: Vec<Lane>,
    impulses: Vec<Impulse>,
    idle: [[Record; 1]; PUSHES],
    /// The jobs of a call in the order in which they are begun, with what each is likely to cost.
    order: Vec<(f32, usize)>,
}

impl Workspace {
    fn new() -> Workspace {
        Workspace {
            lanes: (0..PUSHES).map(Lane::new).collect(),
            impulses: vec![[0.0; 4]; SLOTS],
            idle: [[Record::idle()]; PUSHES],
            order: Vec::new(),
        }
    }
}

impl Planar {
    /// Prepares the scene.
    pub fn new(scene: Arc<Scene>, settings: PlanarSettings) -> Result<Planar> {
        Self::with_name("planar".into(), scene, settings)
    }

    pub(super) fn with_name(name: String, scene: Arc<Scene>, settings: PlanarSettings) -> Result<Planar> {
        settings.validate()?;
        scene.check_simulated()?;
        let model = Model::new(&scene, &settings);
        let instruction_set = settings.instruction_set.unwrap_or_else(InstructionSet::best);
        Ok(Planar { name, scene, settings, instruction_set, model })
    }

    pub fn settings(&self) -> &PlanarSettings {
        &self.settings
    }
}

impl Transition for Planar {
    fn name(&self) -> &str {
        &self.name
    }

    fn scene(&self) -> &Scene {
        &self.scene
    }

    fn scratch(&self) -> Scratch {
        Box::new(Workspace::new())
    }

    fn batch_size(&self) -> usize {
        BATCH
    }

    fn step_batch(&self, scratch: &mut Scratch, jobs: &[PushJob<'_>], results: &mut [PushResult], stop: &Stop) {
        let count = jobs.len().min(results.len());
        let mut own;
        let workspace = match scratch.downcast_mut::<Workspace>() {
            Some(workspace) => workspace,
            // Another engine's scratch: slower, not wrong.
            None => {
                own = Workspace::new();
                &mut own
            }
        };
        let call = Call { engine: self, workspace, jobs: &jobs[..count], results: &mut results[..count], stop };
        self.instruction_set.with(call);
    }
}

/// A call of [`Transition::step_batch`], for any instruction set.
struct Call<'a> {
    engine: &'a Planar,
    workspace: &'a mut Workspace,
    jobs: &'a [PushJob<'a>],
    results: &'a mut [PushResult],
    stop: &'a Stop,
}

impl WithSimd for Call<'_> {
    type Output = ();

    fn run<S: Simd8>(self, simd: S) {
        let Workspace { lanes, impulses, idle, order } = self.workspace;
        // Both are made with these lengths.
        let (Some(lanes), Some(impulses)) = (lanes.first_chunk_mut::<PUSHES>(), impulses.first_chunk_mut::<SLOTS>())
        else {
            return;
        };
        let engine = self.engine;
        order.clear();
        order.extend(self.jobs.iter().enumerate().map(|(i, job)| (engine.model.effort(job.state, &job.push), i)));
        // A long push that is begun last would keep one lane busy while the others have nothing to do.
        order.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut work = Work {
            simd,
            shared: Shared { scene: &engine.scene, model: &engine.model, settings: &engine.settings, stop: self.stop },
            constants: Constants {
                least_slope: engine.settings.least_slope as f32,
                partial: engine.settings.partial_sweeps as u32,
            },
            lanes,
            impulses,
            idle,
            cursors: [Cursor::default(); PUSHES],
            busy: 0,
            held: [0; PUSHES],
            order,
            jobs: self.jobs,
            results: self.results,
        };
        lanes::run(&mut work, self.jobs.len(), self.stop);
    }
}

struct Work<'a, S> {
    simd: S,
    shared: Shared<'a>,
    constants: Constants,
    lanes: &'a mut [Lane; PUSHES],
    impulses: &'a mut [Impulse; SLOTS],
    idle: &'a mut [[Record; 1]; PUSHES],
    cursors: [Cursor; PUSHES],
    /// The lanes that have a list of contacts, one bit each.
    busy: u32,
    held: [usize; PUSHES],
    order: &'a [(f32, usize)],
    jobs: &'a [PushJob<'a>],
    results: &'a mut [PushResult],
}

impl<S: Simd8> Work<'_, S> {
    /// Sweeps the busy lanes, of which there are at most `N`.
    #[inline(always)]
    fn sweep_group<const N: usize, G: Group<N>>(&mut self, group: G) -> u32 {
        let mut idle = self.idle.iter_mut();
        let mut lists: [&mut [Record]; N] =
            std::array::from_fn(|_| idle.next().map_or(Default::default(), |i| i.as_mut_slice()));
        let mut cursors = [Cursor::default(); N];
        let mut lane_of = [0; N];
        let mut next = 0;
        for (l, lane) in self.lanes.iter_mut().enumerate() {
            if self.busy >> l & 1 == 0 {
                continue;
            }
            let k = if N == PUSHES { l } else { next };
            next += 1;
            if k < N {
                (lists[k], cursors[k], lane_of[k]) = (lane.contacts.as_mut_slice(), self.cursors[l], l);
            }
        }
        let finished = sweep(group, self.constants, &mut lists, &mut cursors, self.impulses);
        let mut lanes = 0;
        for (k, cursor) in cursors.iter().enumerate().filter(|(_, cursor)| cursor.len > 0) {
            self.cursors[lane_of[k]] = *cursor;
            lanes |= (finished >> k & 1) << lane_of[k];
        }
        lanes
    }
}

impl<S: Simd8> LaneWork for Work<'_, S> {
    const LANES: usize = PUSHES;

    fn begin(&mut self, lane: usize, job: usize) -> bool {
        let job = self.order[job].1;
        self.held[lane] = job;
        let (s, shared, jobs) = (self.simd, &self.shared, self.jobs);
        let (this, cursor) = (&mut self.lanes[lane], &mut self.cursors[lane]);
        let begun = this.begin(s, shared, &jobs[job], &mut self.results[job], self.impulses, cursor);
        self.busy |= u32::from(begun) << lane;
        begun
    }

    fn sweep(&mut self) -> u32 {
        let s = self.simd;
        // A lane costs the same wherever it is swept; few lanes cost less in a narrow group.
        match self.busy.count_ones() as usize {
            0 => 0,
            1 => s.vectorize(
                #[inline(always)]
                || self.sweep_group::<1, _>(One),
            ),
            2..=LANES => s.vectorize(
                #[inline(always)]
                || self.sweep_group::<LANES, _>(s),
            ),
            _ => s.vectorize(
                #[inline(always)]
                || self.sweep_group::<PUSHES, _>(s.wide()),
            ),
        }
    }

    fn advance(&mut self, lane: usize) -> bool {
        let (s, shared, jobs, job) = (self.simd, &self.shared, self.jobs, self.held[lane]);
        let (this, cursor) = (&mut self.lanes[lane], &mut self.cursors[lane]);
        this.advance(s, shared, &jobs[job], &mut self.results[job], self.impulses, cursor)
    }

    fn idle(&mut self, lane: usize) {
        self.cursors[lane] = Cursor::default();
        self.busy &= !(1 << lane);
    }

    fn interrupt(&mut self, job: usize) {
        self.results[self.order[job].1].status = PushStatus::Interrupted;
    }
}
