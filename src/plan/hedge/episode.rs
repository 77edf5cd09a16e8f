//! Simulated episodes: what a first push leads to in a perturbed world if the robot looks, and plans on, after every
//! push.
//!
//! An episode starts where the bodies may be for what was observed, and begins with a plan's first push. After every
//! push the robot looks (with noise). It grasps if what it sees allows it, and the grasp holds or not at the true poses.
//! Otherwise it pushes on by a simple policy: it tries every push in the model of the search and takes the one after
//! which the best grasp scores highest; where none frees the target, the next push of the plan, and after the plan the
//! push that comes nearest to a grasp. The length of the episode is what the first push cost in this world.

use crate::action::Push;
use crate::error::Result;
use crate::grasp::Jaw;
use crate::physics::{Ensemble, PushJob, PushResult, PushStatus, Scratch as EngineScratch};
use crate::plan::retrieval::{Retrieval, Scratch};
use crate::run::Stop;
use crate::scene::State;

/// Pushes beyond the plan's after which an episode is given up.
const PATIENCE: usize = 2;
/// Actions that are still to come in an episode that was given up.
const TAIL: f64 = 1.5;
/// Actions that a missed grasp costs besides itself: another look and grasp, or a push before it.
const MISSED: f64 = 1.3;
/// Actions that a grasp costs, besides itself, which closes on the body and yet may lose it. Of such failures that were
/// recorded about half shoved the body, and the others threw it where no grasp reaches it: half a miss, half a harm.
const LOST: f64 = 3.5;
/// Actions that a body outside of the workspace costs, or one that toppled.
const HARM: f64 = 6.0;

/// What episodes are made with.
#[derive(Clone, Copy)]
pub(super) struct Rules<'a> {
    pub domain: &'a Retrieval,
    pub ensemble: &'a Ensemble,
    /// A grasp that is seen to score at least this is executed.
    pub execute_score: f64,
    pub stop: &'a Stop,
}

/// Working memory of one worker.
pub(super) struct Bench {
    engine: EngineScratch,
    model: Scratch,
    jaw: Jaw,
    results: Vec<PushResult>,
    sampled: Vec<Push>,
}

impl Bench {
    pub fn new(rules: &Rules<'_>) -> Result<Bench> {
        // Any world's engine: they differ in preset and friction only, and a scratch of another is slower but not wrong.
        let engine = rules.ensemble.engine(0).map_or_else(|| rules.domain.engine.scratch(), |e| e.scratch());
        let jaw = Jaw::new(&rules.domain.scene)?;
        Ok(Bench { engine, model: rules.domain.new_scratch(), jaw, results: Vec::new(), sampled: Vec::new() })
    }
}

/// How an episode ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct End {
    /// Actions executed, and what was done amiss in actions.
    pub actions: f64,
    /// The chance that the grasp at the end was kept; 1 where the episode ended otherwise.
    pub kept: f64,
}

impl End {
    fn other(actions: f64) -> Option<End> {
        Some(End { actions, kept: 1.0 })
    }

    /// What it costs if the body is not kept.
    fn failure(&self) -> f64 {
        if self.kept > 0.0 { LOST } else { MISSED }
    }

    /// What the episode cost on average, in actions.
    pub fn cost(&self) -> f64 {
        self.actions + (1.0 - self.kept) * self.failure()
    }

    /// What of the cost comes of a grasp that holds and yet may not be kept.
    pub fn doubt(&self) -> f64 {
        if self.kept > 0.0 { (1.0 - self.kept) * LOST } else { 0.0 }
    }

    /// The chance that the episode cost no more than so many actions.
    pub fn within(&self, actions: f64) -> f64 {
        let at_most = |cost: f64| f64::from(u8::from(cost <= actions));
        self.kept * at_most(self.actions) + (1.0 - self.kept) * at_most(self.actions + self.failure())
    }
}

/// One plan in one world.
#[derive(Debug, Clone)]
struct Episode<'a> {
    plan: &'a [Push],
    truth: State,
    seen: State,
    next: Push,
    /// Actions executed.
    taken: usize,
    /// How the episode ended, once it has.
    end: Option<End>,
    /// The push to come, if one was found.
    best: Option<(bool, f64, Push)>,
}

/// The episodes of one world.
pub(super) struct World<'a> {
    pub index: usize,
    /// The plans whose first pushes are tried.
    pub plans: Vec<&'a [Push]>,
    /// The end of each plan's episode; empty if the work was interrupted.
    pub ends: Vec<End>,
    /// Pushes simulated in the world, and in the model of the search.
    pub simulations: [u64; 2],
}

impl<'a> World<'a> {
    /// Plays every episode to its end.
    pub fn play(&mut self, rules: &Rules<'_>, bench: &mut Bench, observed: &State) {
        let truth = rules.ensemble.truth(self.index, observed);
        let mut episodes: Vec<Episode<'a>> = self
            .plans
            .iter()
            .map(|plan| Episode {
                plan,
                truth: truth.clone(),
                seen: State::default(),
                next: plan.first().copied().unwrap_or_default(),
                taken: 0,
                end: None,
                best: None,
            })
            .collect();
        let mut look = 0;
        while episodes.iter().any(|e| e.end.is_none()) {
            if !self.push(rules, bench, &mut episodes) {
                return;
            }
            look += 1;
            for e in episodes.iter_mut().filter(|e| e.end.is_none()) {
                e.seen = rules.ensemble.observe(self.index, &e.truth, look);
                let found = rules.domain.assess(&mut bench.model, &e.seen, rules.stop);
                if rules.stop.requested() {
                    return;
                }
                if let Some(grasp) = found.grasp.filter(|g| g.score >= rules.execute_score) {
                    e.taken += 1;
                    e.end = Some(End { actions: e.taken as f64, kept: bench.jaw.chance(&e.truth, &grasp) });
                } else if e.taken >= e.plan.len() + PATIENCE {
                    e.end = End::other(e.taken as f64 + TAIL);
                }
            }
            if !self.choose(rules, bench, &mut episodes) {
                return;
            }
        }
        self.ends = episodes.iter().filter_map(|e| e.end).collect();
    }

    /// Executes the next push of every episode in the world. False if the work was interrupted.
    fn push(&mut self, rules: &Rules<'_>, bench: &mut Bench, episodes: &mut [Episode<'_>]) -> bool {
        let Some(engine) = rules.ensemble.engine(self.index) else { return false };
        let open: Vec<usize> = (0..episodes.len()).filter(|&i| episodes[i].end.is_none()).collect();
        let jobs: Vec<PushJob> =
            open.iter().map(|&i| PushJob { state: &episodes[i].truth, push: episodes[i].next }).collect();
        bench.results.resize_with(bench.results.len().max(jobs.len()), PushResult::default);
        engine.step_batch(&mut bench.engine, &jobs, &mut bench.results[..jobs.len()], rules.stop);
        self.simulations[0] += jobs.len() as u64;
        for (&i, result) in open.iter().zip(&mut bench.results) {
            let e = &mut episodes[i];
            e.taken += 1;
            match result.status {
                PushStatus::Executed if rules.domain.harmful(result) => e.end = End::other(e.taken as f64 + HARM),
                PushStatus::Executed => std::mem::swap(&mut e.truth, &mut result.state),
                // The tip came down on a body, or nobody knows what it does: nothing moved, and an action is lost.
                PushStatus::Illegal { .. } | PushStatus::Unsolved => {}
                PushStatus::Interrupted => return false,
            }
        }
        true
    }

    /// Chooses the next push of every episode that goes on. False if the work was interrupted.
    fn choose(&mut self, rules: &Rules<'_>, bench: &mut Bench, episodes: &mut [Episode<'_>]) -> bool {
        let domain = rules.domain;
        let mut pushes: Vec<(usize, Push)> = Vec::new();
        for (i, e) in episodes.iter_mut().enumerate().filter(|(_, e)| e.end.is_none()) {
            if rules.stop.requested() {
                return false;
            }
            e.best = None;
            domain.list(&mut bench.model, &e.seen, &mut bench.sampled);
            pushes.extend(bench.sampled.iter().map(|push| (i, *push)));
        }
        let jobs: Vec<PushJob> =
            pushes.iter().map(|(i, push)| PushJob { state: &episodes[*i].seen, push: *push }).collect();
        bench.results.resize_with(bench.results.len().max(jobs.len()), PushResult::default);
        domain.simulate(&mut bench.model, &jobs, &mut bench.results[..jobs.len()], rules.stop);
        self.simulations[1] += jobs.len() as u64;
        for ((i, push), result) in pushes.iter().zip(&bench.results) {
            let e = &mut episodes[*i];
            if result.status == PushStatus::Interrupted {
                return false;
            }
            if result.status != PushStatus::Executed || !domain.useful(&e.seen, result) {
                continue;
            }
            let found = domain.assess(&mut bench.model, &result.state, rules.stop);
            if rules.stop.requested() {
                return false;
            }
            let solved = domain.solves(&found);
            let worth = if found.grasp.is_some() { 1.0 + found.score } else { found.nearness };
            if e.best.is_none_or(|(s, w, _)| (solved, worth) > (s, w)) {
                e.best = Some((solved, worth, *push));
            }
        }
        for e in episodes.iter_mut().filter(|e| e.end.is_none()) {
            let planned = e.plan.get(e.taken).copied();
            e.next = match (e.best, planned) {
                (Some((true, _, push)), _) => push,
                (_, Some(push)) => push,
                (Some((false, _, push)), None) => push,
                (None, None) => {
                    e.end = End::other(e.taken as f64 + TAIL);
                    continue;
                }
            };
        }
        true
    }
}
