//! The planner object: options in, plans out; it remembers what was tried and failed.

use std::sync::{Arc, Mutex};

use super::greedy::{Recipe, recipe};
use super::networks::ClearNetworks;
use super::options::{ClearOptions, PushChoice, PushWorth};
use super::outlook::{best, take_in_turn};
use super::parts::{ClearParts, Scratch, sampler};
use super::pushes::{Candidate, Judged, Judging};
use crate::action::{Action, Grasp, Push, SamplerScratch};
use crate::error::Result;
use crate::grasp::GraspAssessment;
use crate::plan::failures::{BETTER, FailedPushes, seen_before};
use crate::plan::reason::{Ending, Reason};
use crate::plan::{Control, Outcome, OwnNetworks, Plan, PlannedAction, RankedAction};
use crate::run::{Budget, Key, Pool, Stop, StopReason};
use crate::scene::{Clearing, Mask, Scene, State};

/// Most first actions that a plan lists.
const CONSIDERED: usize = 16;
/// Share of a decision's time that the model's pushes may use, where the best are confirmed after that.
const MODEL_SHARE: f64 = 0.7;

type MakeParts = dyn Fn(&Arc<Scene>) -> Result<ClearParts> + Send;

/// A planner of clearings. Thread rule: one thread at a time; it runs its own worker threads inside a call only.
pub struct ClearPlanner {
    options: ClearOptions,
    recipe: Recipe,
    pool: Pool,
    networks: ClearNetworks,
    /// Parts of the caller's own.
    make: Option<Box<MakeParts>>,
    parts: Option<ClearParts>,
    scratches: Vec<Mutex<Scratch>>,
    sampling: SamplerScratch,
    candidates: Vec<Candidate>,
    found: Vec<GraspAssessment>,
    /// For every body: a grasp has to score at least this, since one that scored less failed.
    demand: Vec<f64>,
    /// Pushes that failed since the last that was executed.
    failed: FailedPushes,
    /// What the last decision saw, and how far a push since then may have moved a body, metres.
    seen: Option<(Arc<Scene>, State, f64)>,
}

impl std::fmt::Debug for ClearPlanner {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ClearPlanner").field("options", &self.options).finish_non_exhaustive()
    }
}

/// What the judged pushes came to.
struct Chosen {
    judged: Judged,
    /// The state after the push in the engine that judged it last.
    predicted: State,
    push: Push,
}

impl ClearPlanner {
    /// Checks the options, loads the networks that they name, and starts the worker threads.
    pub fn new(options: ClearOptions) -> Result<ClearPlanner> {
        Self::with_networks(options, OwnNetworks::default())
    }

    /// The same with networks of the caller's own in place of those that the options name: `motion`, `graspability` and
    /// `grasp_map` have a part here.
    pub fn with_networks(options: ClearOptions, own: OwnNetworks) -> Result<ClearPlanner> {
        options.validate()?;
        let recipe = recipe(&options)?;
        sampler(&options, &recipe)?;
        let networks = ClearNetworks::load(&options, &recipe, own)?;
        if let Some(gripper) = &options.gripper {
            networks.check_gripper("gripper", gripper)?;
        }
        let pool = Pool::new(options.threads, "jostle")?;
        Ok(ClearPlanner {
            options,
            recipe,
            pool,
            networks,
            make: None,
            parts: None,
            scratches: Vec::new(),
            sampling: SamplerScratch::default(),
            candidates: Vec::new(),
            found: Vec::new(),
            demand: Vec::new(),
            failed: FailedPushes::default(),
            seen: None,
        })
    }

    /// A planner that decides as the options say with parts of the caller's own, made anew for each scene: a network
    /// that predicts pushes in the place of the engine, one that scores grasps in the place of the geometric test.
    pub fn with_parts(
        options: ClearOptions,
        make: impl Fn(&Arc<Scene>) -> Result<ClearParts> + Send + 'static,
    ) -> Result<ClearPlanner> {
        Ok(ClearPlanner { make: Some(Box::new(make)), ..ClearPlanner::new(options)? })
    }

    pub fn options(&self) -> &ClearOptions {
        &self.options
    }

    /// Refuses a problem whose gripper is not the one that the planner's networks were made for, as a decision would.
    pub fn check(&self, problem: &Clearing) -> Result<()> {
        // Parts of the caller's own are the caller's matter.
        if self.make.is_some() {
            return Ok(());
        }
        self.networks.check_gripper("scene.gripper", problem.scene.gripper())
    }

    /// Decides what to do next, within the options' budget. The plan's first action is what to do; the rest is what the
    /// model expects until the next push: execute the first, observe, and ask again. A table with nothing to take is
    /// [`Outcome::Solved`] without actions; so is, with actions, a plan that leaves nothing in the model.
    ///
    /// Asked again for the same problem, it gives the same plan (a deadline may end the same search sooner or later); a
    /// failed action is told with [`failed`](Self::failed).
    ///
    /// # Errors
    /// A problem that does not fit ([`Clearing::new`] says when). Running out of budget or being cancelled are outcomes.
    pub fn solve(&mut self, problem: &Clearing, control: &Control) -> Result<Plan> {
        self.decide(problem, self.options.budget, control)
    }

    /// Like [`solve`](Self::solve), but judges at most `iterations` pushes (the options' seconds hold as well).
    pub fn step(&mut self, problem: &Clearing, iterations: u64, control: &Control) -> Result<Plan> {
        let budget = Budget { iterations: Some(iterations), ..self.options.budget };
        budget.validate()?;
        self.decide(problem, budget, control)
    }

    /// Tells the planner that the first action of its last plan was executed.
    pub fn advance(&mut self, action: &Action) {
        match action {
            Action::Push(push) => {
                // What failed where the bodies were may hold where they are.
                let usual = self.recipe.rule.direct_score;
                self.demand.iter_mut().for_each(|d| *d = (usual + (*d - usual).max(0.0) / 2.0).min(*d));
                self.failed.clear();
                if let Some((_, _, moved)) = &mut self.seen {
                    *moved += push.length();
                }
            }
            Action::Grasp(grasp) => {
                if let Some(demand) = self.demand.get_mut(grasp.body) {
                    *demand = 0.0;
                }
            }
        }
    }

    /// Tells the planner that the first action of its last plan was tried and failed. The same grasp is not offered
    /// again where it is: until the bodies are pushed a grasp of that body has to score better than the one that failed,
    /// and after that half of what it missed. The same push is not offered again before another was executed. This holds
    /// for the scene and for one made anew, whose bodies are known again by outline and place.
    pub fn failed(&mut self, action: &Action) {
        match action {
            Action::Push(push) => self.failed.add(*push),
            Action::Grasp(grasp) => {
                if self.demand.len() <= grasp.body {
                    self.demand.resize(grasp.body + 1, 0.0);
                }
                self.demand[grasp.body] = self.demand[grasp.body].max(grasp.score + BETTER);
            }
        }
    }

    /// Estimated bytes of the pushes that the last decision judged, which are kept: what a byte budget limits.
    pub fn memory_bytes(&self) -> usize {
        self.candidates.len() * self.parts.as_ref().map_or(0, |parts| Candidate::bytes(&parts.scene))
    }

    /// Forgets what failed.
    pub fn reset(&mut self) {
        self.demand.clear();
        self.failed.clear();
    }

    fn decide(&mut self, problem: &Clearing, budget: Budget, control: &Control) -> Result<Plan> {
        let stop = budget.start(&control.cancel);
        problem.validate()?;
        self.prepare(problem)?;
        let mut plan = Plan::empty(Outcome::Infeasible, &self.options.planner, self.options.seed);
        let Some(parts) = self.parts.take() else { return Ok(plan) };
        let mut ending = Ending::default();
        let decided = self.decide_with(&parts, &problem.state, budget, control, &stop, &mut plan, &mut ending);
        self.parts = Some(parts);
        decided?;
        ending.cancelled = cancelled(&stop);
        if ending.cancelled {
            plan.actions.clear();
            plan.considered.clear();
            plan.grasp_score = 0.0;
        }
        (plan.outcome, plan.reasons) = ending.conclude();
        plan.statistics.seconds = stop.elapsed().as_secs_f64();
        Ok(plan)
    }

    /// The parts for the problem's scene.
    fn prepare(&mut self, problem: &Clearing) -> Result<()> {
        let fits = self
            .parts
            .as_ref()
            .is_some_and(|parts| Arc::ptr_eq(&parts.scene, &problem.scene) || parts.scene == problem.scene);
        if !fits {
            self.check(problem)?;
            self.know_again(problem);
            let parts = match &self.make {
                Some(make) => make(&problem.scene)?,
                None => ClearParts::of_recipe(&self.options, &self.recipe, &self.networks, &problem.scene)?,
            };
            self.scratches = (0..self.pool.workers()).map(|_| Mutex::new(parts.new_scratch())).collect();
            self.parts = Some(parts);
        }
        self.demand.resize(problem.scene.len(), 0.0);
        self.seen = Some((Arc::clone(&problem.scene), problem.state.clone(), 0.0));
        Ok(())
    }

    /// What failed with the bodies of the last decision holds for those of them that a scene made anew shows.
    fn know_again(&mut self, problem: &Clearing) {
        let Some((scene, state, moved)) = &self.seen else { return };
        let (was, is) = ((&**scene, state), (&*problem.scene, &problem.state));
        let known: Vec<_> = (0..problem.scene.len()).map(|body| seen_before(was, is, body, *moved)).collect();
        let demand = |before: &Option<usize>| before.and_then(|i| self.demand.get(i).copied()).unwrap_or(0.0);
        self.demand = known.iter().map(demand).collect();
        if known.iter().all(Option::is_none) {
            self.failed.clear();
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn decide_with(
        &mut self,
        parts: &ClearParts,
        state: &State,
        budget: Budget,
        control: &Control,
        stop: &Stop,
        plan: &mut Plan,
        ending: &mut Ending,
    ) -> Result<()> {
        let remaining = parts.remaining(state);
        if remaining.is_empty() {
            ending.solved = true;
            return Ok(());
        }
        if cancelled(stop) {
            return Ok(());
        }
        // Nothing can be done where none of the bodies can be held; the first that can ends the question.
        let unholdable = |body| Reason::unholdable(parts.scorer.as_ref(), &parts.scene, body);
        if let Some(reasons) = remaining.iter().map(unholdable).collect() {
            ending.shown = reasons;
            return Ok(());
        }
        let mut scorer = parts.scorer.scratch();
        let mut found = std::mem::take(&mut self.found);
        parts.assess_all(scorer.as_mut(), &[state], remaining, &mut found, stop);
        let rule = &self.recipe.rule;
        let demand = &self.demand;
        let now = Now::new(remaining, &found, demand);

        if best(remaining, &|body| rule.direct_score.max(demand[body]), &found).is_some() {
            self.take(parts, state, remaining, rule.direct_score, &mut found, plan, stop);
            self.found = found;
            left(parts, plan, ending);
            return Ok(());
        }
        let chosen = match rule.choice {
            PushChoice::Never => None,
            PushChoice::Random => self.any_push(parts, state),
            PushChoice::Judged => match self.best_push(parts, state, budget, control, stop, plan, ending)? {
                // A limit came before a push was found to be of use: a legal one is better than none.
                None if ending.limit.is_some() => self.candidates.first().map(|c| unjudged(c.push, state)),
                chosen => chosen,
            },
        };
        let rule = &self.recipe.rule;
        let least = match (&chosen, rule.worth) {
            // Whatever is left to try.
            (None, _) => Some(0.0),
            (Some(_), _) if rule.choice == PushChoice::Random => None,
            (Some(c), PushWorth::Freed) => (c.judged.freed < 0.5).then_some(rule.last_resort),
            (Some(c), PushWorth::MeanReward) => {
                let discount = if now.greatest > rule.discount_from { rule.discount } else { 1.0 };
                let betters = discount * c.judged.mean > now.mean;
                let pushes = betters && (!rule.raises_best || c.judged.greatest > now.greatest);
                (!pushes).then_some(0.0)
            }
        };
        if let Some(least) = least
            && best(remaining, &|body| least.max(self.demand[body]), &found).is_some()
        {
            self.take(parts, state, remaining, least, &mut found, plan, stop);
            // What comes after a grasp that is not good enough by itself is decided then.
            plan.actions.truncate(1);
        } else if let Some(chosen) = chosen {
            let Chosen { judged, predicted, push } = chosen;
            plan.actions.push(PlannedAction {
                action: Action::Push(push),
                predicted: predicted.clone(),
                value: judged.value,
            });
            let enough = self.options.grasp.solved_score;
            parts.assess_all(scorer.as_mut(), &[&predicted], remaining, &mut found, stop);
            let taken = take_in_turn(parts, scorer.as_mut(), &predicted, remaining, |_| enough, &mut found, stop);
            list(plan, taken);
        } else if stop.requested() {
            ending.limit = ending.limit.take().or_else(|| Reason::limit(&budget, stop.reason()));
        } else if ending.limit.is_none() {
            // A push that the engine could not solve may be of use.
            if self.candidates.iter().any(|candidate| candidate.result.leaves_open()) {
                ending.short.push(Reason::Unsolved);
            } else {
                ending.shown = self.nothing(remaining);
            }
        }
        self.found = found;
        left(parts, plan, ending);
        Ok(())
    }

    /// Why there is neither a grasp nor a push.
    fn nothing(&self, remaining: Mask) -> Vec<Reason> {
        let failed = remaining.iter().filter(|&body| self.demand[body] > 0.0).count() as u64;
        let no_push = Reason::NoLegalPush { proposed: self.candidates.len() as u64 };
        let pushes = self.recipe.rule.choice != PushChoice::Never;
        let not_again = Reason::failed(0, self.failed.count());
        std::iter::once(Reason::NoGrasp { failed }).chain(pushes.then_some(no_push)).chain(not_again).collect()
    }

    /// The plan to take body after body where each scores `least` and what it has to.
    #[allow(clippy::too_many_arguments)]
    fn take(
        &self,
        parts: &ClearParts,
        state: &State,
        remaining: Mask,
        least: f64,
        found: &mut [GraspAssessment],
        plan: &mut Plan,
        stop: &Stop,
    ) {
        let mut scorer = parts.scorer.scratch();
        let enough = |body: usize| least.max(self.demand[body]);
        list(plan, take_in_turn(parts, scorer.as_mut(), state, remaining, enough, found, stop));
    }

    /// Every push that may be tried, in a random order; those of several lengths side by side.
    fn sample(&mut self, parts: &ClearParts, state: &State) -> Vec<Push> {
        let mut rng = Key::new(self.options.seed).child(state.hash_bits()).stream();
        let mut sampled = Vec::new();
        let target = parts.remaining(state).iter().next().unwrap_or(0);
        parts.sampler.sample(&parts.scene, state, target, None, &mut rng, &mut self.sampling, &mut sampled);
        self.failed.take_out(parts.scene.gripper().scale(), &mut sampled);
        let lengths = &self.recipe.rule.lengths;
        let shortened = |push: &Push, share: f64| {
            let end = push.start() + (push.end() - push.start()) * share;
            Push { end: [end.x, end.y], ..*push }
        };
        sampled.iter().flat_map(|push| lengths.iter().map(move |share| shortened(push, *share))).collect()
    }

    /// The first that is sampled.
    fn any_push(&mut self, parts: &ClearParts, state: &State) -> Option<Chosen> {
        let push = self.sample(parts, state).into_iter().next()?;
        Some(unjudged(push, state))
    }

    /// The push that promises most.
    #[allow(clippy::too_many_arguments)]
    fn best_push(
        &mut self,
        parts: &ClearParts,
        state: &State,
        budget: Budget,
        control: &Control,
        stop: &Stop,
        plan: &mut Plan,
        ending: &mut Ending,
    ) -> Result<Option<Chosen>> {
        let mut pushes = self.sample(parts, state);
        let allowed = budget.iterations.map_or(usize::MAX, |n| usize::try_from(n).unwrap_or(usize::MAX));
        let room = budget.bytes.map_or(usize::MAX, |bytes| bytes / Candidate::bytes(&parts.scene));
        let most = allowed.min(room);
        let limited = pushes.len() > most;
        pushes.truncate(most);
        self.candidates.resize_with(pushes.len().max(self.candidates.len()), || Candidate::new(Push::default(), 0));
        self.candidates.truncate(pushes.len());
        for (candidate, push) in self.candidates.iter_mut().zip(pushes) {
            (candidate.push, candidate.world) = (push, 0);
            (candidate.done, candidate.outlook) = (false, None);
        }
        let confirms = parts.confirming.is_some() && self.recipe.rule.confirm_pushes > 0;
        let sooner = stop.sooner(if confirms { MODEL_SHARE } else { 1.0 });
        let judging = Judging {
            parts,
            rule: &self.recipe.rule,
            enough: self.options.grasp.solved_score,
            pool: &self.pool,
            scratches: &self.scratches,
            stop: &sooner,
            progress: control.progress.as_deref(),
        };
        let done = judging.judge(std::slice::from_ref(state), &mut self.candidates, false)?;
        let s = &mut plan.statistics;
        (s.iterations, s.simulations, s.nodes) = (done, done, done);
        s.domain_seconds = stop.elapsed().as_secs_f64();
        if sooner.reason() == Some(StopReason::Interrupted) {
            stop.interrupt();
        }
        let ranked = judging.ranked(&self.candidates);
        plan.considered = considered(&self.candidates, &ranked);
        if limited || sooner.requested() {
            let full = room < allowed && !sooner.requested();
            ending.limit = if full { Some(Reason::memory(&budget)) } else { Reason::limit(&budget, sooner.reason()) };
        }
        let Some(first) = ranked.first() else { return Ok(None) };
        if confirms && !stop.requested() {
            let from = stop.elapsed();
            let trying = Judging { stop, ..judging };
            let worlds = trying.worlds(state, Key::new(self.options.seed).child(state.hash_bits()).child(1));
            let (mut trials, judged) = trying.confirm(&worlds, &self.candidates, &ranked)?;
            let s = &mut plan.statistics;
            s.plans_tried = ranked.len().min(self.recipe.rule.confirm_pushes) as u64;
            s.plans_confirmed = judged.iter().filter(|j| j.value > 0.0).count() as u64;
            s.confirm_simulations = trials.iter().filter(|t| t.done).count() as u64;
            s.confirm_seconds = (stop.elapsed() - from).as_secs_f64();
            if let Some(judged) = judged.first().filter(|j| j.value > 0.0) {
                let trial = trials.swap_remove(judged.candidate);
                return Ok(Some(Chosen { judged: *judged, predicted: trial.result.state, push: trial.push }));
            }
        }
        let candidate = &self.candidates[first.candidate];
        Ok(Some(Chosen { judged: *first, predicted: candidate.result.state.clone(), push: candidate.push }))
    }
}

/// A push of which nothing is known: what it does is not predicted.
fn unjudged(push: Push, state: &State) -> Chosen {
    let judged = Judged { candidate: 0, value: 0.0, freed: 0.0, mean: 0.0, greatest: 0.0 };
    Chosen { judged, predicted: state.clone(), push }
}

/// The present assessments, without the grasps that failed.
struct Now {
    mean: f64,
    greatest: f64,
}

impl Now {
    fn new(remaining: Mask, found: &[GraspAssessment], demand: &[f64]) -> Now {
        let score = |body: usize| {
            let found = &found[body];
            if found.grasp.is_some() && found.score >= demand[body] { found.score } else { 0.0 }
        };
        let count = remaining.count().max(1) as f64;
        Now {
            mean: remaining.iter().map(score).sum::<f64>() / count,
            greatest: remaining.iter().map(score).fold(0.0, f64::max),
        }
    }
}

/// Appends grasps to a plan.
fn list(plan: &mut Plan, taken: Vec<(Grasp, State)>) {
    if let Some((grasp, _)) = taken.last() {
        plan.grasp_score = grasp.score;
    }
    plan.actions.extend(taken.into_iter().map(|(grasp, predicted)| PlannedAction {
        action: Action::Grasp(grasp),
        predicted,
        value: grasp.score,
    }));
}

/// Whether the plan leaves anything to be taken.
fn left(parts: &ClearParts, plan: &Plan, ending: &mut Ending) {
    let Some(last) = plan.actions.last() else { return };
    let bodies = parts.remaining(&last.predicted).count() as u64;
    ending.solved = bodies == 0;
    ending.short.push(Reason::Left { bodies });
}

fn considered(candidates: &[Candidate], ranked: &[Judged]) -> Vec<RankedAction> {
    let of = |judged: &Judged| RankedAction {
        action: Action::Push(candidates[judged.candidate].push),
        value: judged.value,
        best_return: judged.greatest,
        visits: 1,
        prior: 1.0 / candidates.len() as f64,
        solution_level: None,
        success_chance: None,
        expected_actions: None,
        predicted: candidates[judged.candidate].result.state.clone(),
    };
    ranked.iter().take(CONSIDERED).map(of).collect()
}

/// The end was asked for from outside. A deadline is no such request.
fn cancelled(stop: &Stop) -> bool {
    stop.requested() && stop.reason() != Some(StopReason::Deadline)
}
