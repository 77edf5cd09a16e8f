//! The planner object: options in, plans out, a search tree kept between decisions.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::confirm::{Confirmed, Weighed};
use super::decision::{Decision, Found, From, cancelled};
use super::failures::{BETTER, FailedPushes, seen_before};
use super::hedge;
use super::networks::{Networks, OwnNetworks};
use super::options::{GraspDecision, PlannerOptions};
use super::outcome::{Outcome, Plan, PlanStatistics, PlannedAction, RankedAction};
use super::reason::{Ending, Reason};
use super::recipe::{Recipe, recipe};
use super::retrieval::{Retrieval, Reward};
use crate::action::{Action, ContourSampler, Grasp, Push};
use crate::error::Result;
use crate::geom::normalize_angle;
use crate::grasp::{FailedGrasp, Scorer};
use crate::physics::{Ensemble, Transition};
use crate::run::{Budget, CancelToken, Pool, Progress, Stop, StopReason};
use crate::scene::{Problem, Scene, State};
use crate::search::{EndReason, Tree};

/// How a running decision is watched and ended from outside. Cheap to clone.
#[derive(Debug, Clone, Default)]
pub struct Control {
    /// Triggering any of them ends the decision with [`Outcome::Cancelled`].
    pub cancel: Vec<CancelToken>,
    /// Numbers that any thread may read while it runs; may carry a callback.
    pub progress: Option<Arc<Progress>>,
}

/// A planner with its memory. Thread rule: one thread at a time; it runs its own worker threads inside a call only.
pub struct Planner {
    options: PlannerOptions,
    recipe: Recipe,
    pool: Pool,
    networks: Networks,
    tree: Tree<Retrieval>,
    domain: Option<Retrieval>,
    /// The engine that plans are confirmed in, prepared for the domain's scene.
    confirming: Option<Arc<dyn Transition>>,
    /// The perturbed worlds that plans are weighed in, of the same scene.
    ensemble: Option<Ensemble>,
    /// The state that the tree's root stands for: the one observed, until an action is executed.
    expected: Option<State>,
    /// The tree is what [`Planner::advance`] kept: the next [`Planner::solve`] begins with it, every other one afresh.
    kept: bool,
    /// What was decided with such a tree, which has grown since: the answer to the same question asked again.
    answer: Option<Plan>,
    /// The pushes of the last plan, and those of them that are left after the first one was executed.
    planned: Vec<Push>,
    rest: Vec<Push>,
    /// Grasps that failed, on their bodies; see [`Planner::failed`].
    failed_grasps: Vec<FailedGrasp>,
    /// The domain's scorer believes less in grasps like these.
    avoids: bool,
    /// Where the scorer cannot tell one grasp from another: a grasp has to score at least this, since one that scored less
    /// failed.
    demand: f64,
    /// Pushes that failed since the last that was executed.
    failed: FailedPushes,
    /// The scene, state and target of the last decision, and how far a push since then may have moved the target, metres.
    seen: Option<(Problem, f64)>,
}

impl std::fmt::Debug for Planner {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Planner").field("options", &self.options).finish_non_exhaustive()
    }
}

/// Most first actions that a plan lists.
const CONSIDERED: usize = 16;
/// An observed pose this near the predicted one is the same (metres, for the published gripper; radians): the tree below
/// is used on.
const SAME: (f64, f64) = (1e-4, 1e-3);

impl Planner {
    /// Checks the options and prepares the planner (recipe, worker threads).
    pub fn new(options: PlannerOptions) -> Result<Planner> {
        Planner::with_networks(options, OwnNetworks::default())
    }

    /// The same with learned parts of the caller's own.
    pub fn with_networks(options: PlannerOptions, own: OwnNetworks) -> Result<Planner> {
        options.validate()?;
        let recipe = recipe(&options)?;
        sampler(&options, &recipe)?;
        let networks = Networks::load(&options, &recipe, own)?;
        if let Some(gripper) = &options.gripper {
            networks.check_gripper("gripper", gripper)?;
        }
        let pool = Pool::new(options.threads, "jostle")?;
        Ok(Planner {
            options,
            recipe,
            pool,
            networks,
            tree: Tree::new(),
            domain: None,
            confirming: None,
            ensemble: None,
            expected: None,
            kept: false,
            answer: None,
            planned: Vec::new(),
            rest: Vec::new(),
            failed_grasps: Vec::new(),
            avoids: false,
            demand: 0.0,
            failed: FailedPushes::default(),
            seen: None,
        })
    }

    pub fn options(&self) -> &PlannerOptions {
        &self.options
    }

    /// Refuses a problem whose gripper is not the one that the planner's networks were made for, as a decision would.
    pub fn check(&self, problem: &Problem) -> Result<()> {
        self.networks.check_gripper("scene.gripper", problem.scene.gripper())
    }

    /// Decides what to do for the observed problem, within the options' budget. If the problem is the one that
    /// [`advance`](Self::advance) predicted, the kept part of the tree is used.
    ///
    /// Asked again for the same problem, it gives the same plan (a deadline may end the same search sooner or later):
    /// [`step`](Self::step) goes on instead, and a failed action is told with [`failed`](Self::failed).
    ///
    /// A graspable target is grasped at once; otherwise pushes are searched that make it graspable.
    ///
    /// # Errors
    /// A problem that does not fit ([`Problem::new`] says when). Running out of budget or being cancelled are outcomes.
    pub fn solve(&mut self, problem: &Problem, control: &Control) -> Result<Plan> {
        let mut budget = self.options.budget;
        if budget.iterations.is_none() && budget.seconds.is_none() {
            budget = Budget { bytes: budget.bytes, ..self.recipe.budget };
        }
        let expected = self.expects(problem);
        let known = expected && self.is_ready_for(problem) && !control.cancel.iter().any(CancelToken::is_triggered);
        if let Some(answer) = self.answer.as_ref().filter(|_| known) {
            return Ok(answer.clone());
        }
        let keep = expected && self.kept;
        let plan = self.decide(problem, budget, keep, control)?;
        if keep && plan.outcome != Outcome::Cancelled {
            self.answer = Some(plan.clone());
        }
        Ok(plan)
    }

    /// Like [`solve`](Self::solve), but does at most `iterations` more iterations (the options' seconds hold as well)
    /// and returns the best plan so far; called again with the same problem it goes on where it was.
    pub fn step(&mut self, problem: &Problem, iterations: u64, control: &Control) -> Result<Plan> {
        let budget = Budget { iterations: Some(iterations), ..self.options.budget };
        budget.validate()?;
        let keep = self.expects(problem);
        self.decide(problem, budget, keep, control)
    }

    /// Tells the planner that the first action of its last plan was executed: the part of the tree below it is kept, and
    /// `hedge` weighs the rest of the plan beside what it finds anew. Returns whether there was such a part of the tree.
    pub fn advance(&mut self, action: &Action) -> Result<bool> {
        let Action::Push(push) = action else {
            self.drop_tree();
            return Ok(false);
        };
        let usual = self.domain.as_ref().map_or(self.options.grasp, |domain| domain.grasp).solved_score;
        self.demand = usual + (self.demand - usual).max(0.0) / 2.0;
        self.failed_grasps.iter_mut().for_each(|grasp| *grasp = grasp.halved());
        self.failed.clear();
        if let Some((_, moved)) = &mut self.seen {
            *moved += push.length();
        }
        let index = self.tree.root_children().find(|c| same_push(c.action, push)).map(|c| c.index);
        let kept = index.is_some_and(|index| self.tree.advance(index));
        let rest = match self.planned.split_first() {
            Some((first, rest)) if same_push(first, push) => rest.to_vec(),
            _ => Vec::new(),
        };
        self.answer = None;
        if kept {
            self.expected = self.tree.root_state().cloned();
        } else {
            self.drop_tree();
        }
        self.kept = kept;
        self.rest = rest;
        Ok(kept)
    }

    /// Tells the planner that the first action of its last plan was tried and failed: the push was not executed, or the
    /// target was not in the gripper. The tree is forgotten. Grasps of the target score a quarter less, those near
    /// the failed one down to a fifth, and with every push that is executed the loss halves: so another side is tried
    /// first, then pushes, then the same again. (A scorer that cannot tell one grasp from another asks for a better score
    /// than the failed one's until the bodies are pushed, and for half of what it missed after that.) The same push is not
    /// offered again before another was executed.
    ///
    /// This holds while other targets are asked for, and for a scene made anew: a body is known again by an outline that
    /// differs a little, where the body may be. [`reset`](Self::reset) ends it.
    pub fn failed(&mut self, action: &Action) {
        match action {
            Action::Grasp(grasp) => match (&self.seen, &self.domain) {
                (Some((seen, _)), Some(domain))
                    if grasp.body < seen.scene.len() && domain.scorer.avoiding(&[]).is_some() =>
                {
                    self.failed_grasps.push(FailedGrasp::new(grasp, &seen.state));
                }
                _ => self.demand = self.demand.max(grasp.score + BETTER),
            },
            Action::Push(push) => self.failed.add(*push),
        }
        self.drop_tree();
    }

    /// Forgets the tree, the plan and what failed. Its memory is kept for the next decision.
    pub fn reset(&mut self) {
        self.drop_tree();
        self.forget();
    }

    /// What failed may be offered again.
    fn forget(&mut self) {
        self.failed_grasps.clear();
        self.demand = 0.0;
        self.failed.clear();
    }

    fn drop_tree(&mut self) {
        self.tree.reset();
        self.expected = None;
        self.kept = false;
        self.answer = None;
        self.planned.clear();
        self.rest.clear();
    }

    /// Estimated bytes that the tree holds.
    pub fn memory_bytes(&self) -> usize {
        self.domain.as_ref().map_or(0, |domain| self.tree.bytes(domain))
    }

    /// The tree's root stands for the problem's state.
    fn expects(&self, problem: &Problem) -> bool {
        self.expected.as_ref().is_some_and(|expected| same(expected, problem))
    }

    /// What was prepared is for this scene and target.
    fn is_ready_for(&self, problem: &Problem) -> bool {
        self.domain.as_ref().is_some_and(|d| {
            d.target == problem.target && (Arc::ptr_eq(&d.scene, &problem.scene) || d.scene == problem.scene)
        })
    }

    fn decide(&mut self, problem: &Problem, budget: Budget, keep: bool, control: &Control) -> Result<Plan> {
        let stop = budget.start(&control.cancel);
        problem.validate()?;
        let fits = self.is_ready_for(problem);
        if !fits {
            self.check(problem)?;
            self.drop_tree();
            (self.domain, self.avoids) = (None, false);
            self.know_again(problem);
            self.confirming = self.networks.confirming(&self.recipe, &problem.scene)?;
            let worlds = || hedge::ensemble(&self.recipe, &self.networks, problem, self.options.seed);
            self.ensemble = self.recipe.hedges.then(worlds).transpose()?;
            self.domain = Some(prepare(&self.options, &self.recipe, &self.networks, problem)?);
        }
        let Some(domain) = &mut self.domain else {
            return Ok(Plan::empty(Outcome::Infeasible, &self.options.planner, self.options.seed));
        };
        if self.avoids || !self.failed_grasps.is_empty() {
            let asked = |scorer: &dyn Scorer| thresholds(&self.options, &self.recipe, scorer, problem);
            domain.doubt(&self.failed_grasps, &asked);
            self.avoids = !self.failed_grasps.is_empty();
        }
        domain.demand = self.demand;
        domain.failed.clone_from(&self.failed);
        let domain = &*domain;
        self.seen = Some((problem.clone(), 0.0));
        let mut plan = Plan::empty(Outcome::Infeasible, &self.options.planner, self.options.seed);
        if cancelled(&stop) {
            plan.outcome = Outcome::Cancelled;
            return Ok(plan);
        }

        // A state that would count as a solution is one: from there nothing is searched.
        let enough = domain.grasp.execute_score.min(domain.grasp.solved_score).max(self.demand);
        let now = domain.assess_present(&mut domain.new_scratch(), &problem.state, &stop);
        if let Some(grasp) = now.grasp.filter(|g| g.score >= enough) {
            plan.outcome = Outcome::Solved;
            plan.grasp_score = grasp.score;
            plan.actions.push(grasped(&problem.state, grasp, grasp.score));
            plan.statistics.seconds = stop.elapsed().as_secs_f64();
            plan.statistics.proved_shortest = true;
            return Ok(plan);
        }

        if let Some(reason) = Reason::unholdable(domain.scorer.as_ref(), &domain.scene, domain.target) {
            let ending = Ending { shown: vec![reason], ..Ending::default() };
            (plan.outcome, plan.reasons) = ending.conclude();
            return Ok(plan);
        }
        let decision = Decision {
            domain,
            confirming: self.confirming.as_ref(),
            params: &self.recipe.search,
            budget,
            pool: &self.pool,
            stop: &stop,
            progress: control.progress.as_deref(),
        };
        let resume = keep && fits && self.tree.root_state().is_some();
        if !resume {
            (self.kept, self.answer) = (false, None);
            domain.unsolved.store(false, Ordering::Relaxed);
        }
        let from = if resume { From::Tree } else { From::Root(&problem.state, self.options.seed) };
        let found = match &self.ensemble {
            Some(ensemble) => {
                hedge::make(&decision, ensemble, enough, &mut self.tree, from, &problem.state, &self.rest)
            }
            None => decision.make(&mut self.tree, from, &problem.state),
        }
        .inspect_err(|_| self.expected = None)?;
        if self.expected.is_none() || !keep {
            self.expected = Some(problem.state.clone());
        }
        plan.statistics.seconds = stop.elapsed().as_secs_f64();
        self.fill(&mut plan, found, &budget);
        if plan.outcome == Outcome::Budget && plan.actions.is_empty() {
            self.fall_back(&mut plan, &problem.state, now.grasp);
        }
        let pushes =
            plan.actions.iter().filter_map(|a| if let Action::Push(push) = a.action { Some(push) } else { None });
        self.planned.clear();
        self.planned.extend(pushes);
        Ok(plan)
    }

    /// What failed holds for the bodies of the last decision that are there, also for another target or seen anew.
    fn know_again(&mut self, problem: &Problem) {
        let Some((before, moved)) = &self.seen else { return };
        let (was, is) = ((&*before.scene, &before.state), (&*problem.scene, &problem.state));
        if before.scene == problem.scene {
            if before.target != problem.target {
                self.demand = 0.0;
            }
            return;
        }
        let known: Vec<_> = (0..problem.scene.len()).map(|body| seen_before(was, is, body, *moved)).collect();
        if known.get(problem.target) != Some(&Some(before.target)) {
            self.demand = 0.0;
        }
        if known.iter().all(Option::is_none) {
            self.failed.clear();
        }
        let anew = |grasp: &FailedGrasp| {
            let body = known.iter().position(|before| *before == Some(grasp.body))?;
            Some(grasp.seen_anew(body, &was.1.pose(grasp.body), &is.1.pose(body)))
        };
        self.failed_grasps = self.failed_grasps.iter().filter_map(anew).collect();
    }

    /// Reads the plan out of the tree, or takes the one that was confirmed.
    fn fill(&self, plan: &mut Plan, found: Found, budget: &Budget) {
        let Found { report, verdict, cancelled } = found;
        plan.statistics = PlanStatistics {
            iterations: report.iterations,
            nodes: report.nodes,
            simulations: report.simulations,
            domain_seconds: report.step_time.as_secs_f64(),
            search_seconds: report.time.saturating_sub(report.step_time).as_secs_f64(),
            no_plan_within: report.proved_level.checked_sub(1),
            plans_tried: verdict.tried,
            plans_confirmed: verdict.confirmed,
            confirm_simulations: verdict.simulations,
            confirm_seconds: verdict.seconds,
            success_chance: verdict.chance,
            expected_actions: verdict.expected,
            worlds: verdict.worlds,
            ..plan.statistics
        };
        if cancelled {
            plan.outcome = Outcome::Cancelled;
            return;
        }
        let Some(domain) = &self.domain else { return };
        plan.considered = self.considered(&verdict.weighed);
        let weighed = verdict.best.is_some().then(|| verdict.weighed.first().copied()).flatten();
        match verdict.best {
            Some(confirmed) => self.take_confirmed(plan, confirmed),
            None => self.take_chosen(plan, domain),
        }
        self.name_chosen(plan, weighed);
        // A shorter plan than the search's engine knows of may hold in the confirming one.
        let pushes = plan.actions.iter().filter(|a| matches!(a.action, Action::Push(_))).count() as u32;
        if pushes < plan.actions.len() as u32 {
            let within = plan.statistics.no_plan_within.zip(pushes.checked_sub(1));
            plan.statistics.no_plan_within = within.map(|(proved, shorter)| proved.min(shorter));
        }
        if let Some(join) = &self.recipe.join {
            join.merge(&mut plan.actions, domain.scene.gripper().scale());
        }
        let solved = plan.actions.last().is_some_and(|a| matches!(a.action, Action::Grasp(_)));
        let pushes = plan.actions.iter().filter(|a| matches!(a.action, Action::Push(_))).count();
        plan.statistics.proved_shortest = solved && pushes as u64 <= u64::from(report.proved_level);
        let ending = Ending { solved, ..self.ending(report.reason, budget) };
        (plan.outcome, plan.reasons) = ending.conclude();
    }

    /// What the search's end says where it has no solution.
    fn ending(&self, ended: EndReason, budget: &Budget) -> Ending {
        let limit = match ended {
            EndReason::Iterations => Reason::limit(budget, None),
            EndReason::Memory => Some(Reason::memory(budget)),
            EndReason::Deadline => Reason::limit(budget, Some(StopReason::Deadline)),
            _ => None,
        };
        let nothing = ended == EndReason::Exhausted && self.tree.root_children().all(|child| child.illegal);
        let proposed = self.tree.root_children().count() as u64;
        // A push that the engine could not solve may be of use: that nothing can be done is not shown then.
        let unsolved = self.domain.as_ref().is_some_and(|domain| domain.unsolved.load(Ordering::Relaxed));
        let mut shown = Vec::new();
        if nothing && !unsolved {
            // Where nothing was proposed because it had failed, that is the reason.
            let none = proposed > 0 || self.failed.count() == 0;
            shown.extend(none.then_some(Reason::NoLegalPush { proposed }));
            shown.extend(self.what_failed());
        }
        let tried = Reason::TriedAll { actions: self.recipe.search.max_depth };
        let short = vec![if nothing { Reason::Unsolved } else { tried }];
        Ending { limit, shown, short, ..Ending::default() }
    }

    /// What is not offered because it failed, of the target's grasps and of all pushes.
    fn what_failed(&self) -> Option<Reason> {
        let domain = self.domain.as_ref()?;
        let grasps = self.failed_grasps.iter().filter(|grasp| grasp.body == domain.target).count() as u64;
        // A push that was executed leaves the bar at what is asked of a solution.
        let bar = u64::from(self.demand > domain.grasp.solved_score);
        Reason::failed(grasps + bar, self.failed.count())
    }

    /// The search's own choice, as the model predicts it.
    fn take_chosen(&self, plan: &mut Plan, domain: &Retrieval) {
        for node in self.tree.best_path() {
            if let Some((_, push)) = node.action {
                let action = Action::Push(*push);
                plan.actions.push(PlannedAction { action, predicted: node.state.clone(), value: node.mean });
            }
            if node.terminal {
                let found = domain.assess(&mut domain.new_scratch(), node.state, &Stop::never());
                if let Some(grasp) = found.grasp {
                    plan.grasp_score = grasp.score;
                    plan.actions.push(grasped(node.state, grasp, node.value));
                }
            }
        }
    }

    /// A limit came before a push was tried: the best grasp, however it scores, else the push that is expected to be worth
    /// most, of equals the first. It is legal; what it does is not predicted.
    fn fall_back(&self, plan: &mut Plan, state: &State, grasp: Option<Grasp>) {
        let Some(domain) = &self.domain else { return };
        if let Some(grasp) = grasp.filter(|g| g.score >= self.demand) {
            plan.grasp_score = grasp.score;
            plan.actions.push(grasped(state, grasp, grasp.score));
            return;
        }
        let mut listed: Vec<(f32, Push)> =
            self.tree.root_children().filter(|c| !c.illegal).map(|c| (c.prior, *c.action)).collect();
        if self.tree.root_state().is_none() {
            let mut pushes = Vec::new();
            domain.list(&mut domain.new_scratch(), state, &mut pushes);
            self.failed.take_out(domain.scene.gripper().scale(), &mut pushes);
            listed.extend(pushes.into_iter().map(|push| (0.0, push)));
        }
        let best = listed.into_iter().reduce(|best, other| if other.0 > best.0 { other } else { best });
        plan.actions.extend(best.map(|(_, push)| PlannedAction {
            action: Action::Push(push),
            predicted: state.clone(),
            value: 0.0,
        }));
    }

    /// A plan that succeeds in the confirming engine, as that engine predicts it. The first push has the tree's value,
    /// the others what solving is worth.
    fn take_confirmed(&self, plan: &mut Plan, confirmed: Confirmed) {
        let first = confirmed.pushes.first().map(|(push, _)| *push);
        let node = self.tree.root_children().find(|c| first.is_some_and(|push| same_push(c.action, &push)));
        let mean = node.and_then(|c| c.node).map_or(0.0, |n| n.mean);
        plan.grasp_score = confirmed.score;
        let end = confirmed.pushes.last().map(|(_, state)| grasped(state, confirmed.grasp, confirmed.score));
        for (index, (push, predicted)) in confirmed.pushes.into_iter().enumerate() {
            let value = if index == 0 { mean } else { confirmed.score };
            plan.actions.push(PlannedAction { action: Action::Push(push), predicted, value });
        }
        plan.actions.extend(end);
    }

    /// The first push of an earlier plan's rest need not be among the root's actions; where it is chosen it stands first.
    fn name_chosen(&self, plan: &mut Plan, weighed: Option<Weighed>) {
        let (Some(weighed), Some(first)) = (weighed, plan.actions.first()) else { return };
        let is_first = |a: &RankedAction| matches!(a.action, Action::Push(push) if same_push(&push, &weighed.push));
        if plan.considered.first().is_some_and(is_first) {
            return;
        }
        let chosen = RankedAction {
            action: first.action,
            value: first.value,
            best_return: first.value,
            visits: 0,
            prior: 0.0,
            solution_level: None,
            success_chance: Some(weighed.chance),
            expected_actions: Some(weighed.expected),
            predicted: first.predicted.clone(),
        };
        plan.considered.insert(0, chosen);
        plan.considered.truncate(CONSIDERED);
    }

    /// The root's actions: first those that were weighed in perturbed worlds, by the expected number of actions, then the
    /// others by value.
    fn considered(&self, weighed: &[Weighed]) -> Vec<RankedAction> {
        let mut ranked: Vec<RankedAction> = self
            .tree
            .root_children()
            .filter_map(|child| {
                let node = child.node?;
                let weighed = weighed.iter().find(|w| same_push(&w.push, child.action));
                Some(RankedAction {
                    action: Action::Push(*child.action),
                    value: child.score.unwrap_or(node.mean),
                    best_return: node.best,
                    visits: u64::from(node.visits),
                    prior: f64::from(child.prior),
                    solution_level: node.solved_level,
                    success_chance: weighed.map(|w| w.chance),
                    expected_actions: weighed.map(|w| w.expected),
                    predicted: node.state.clone(),
                })
            })
            .collect();
        // Stable: equal values stay in the sampler's order.
        let place = |a: &RankedAction| {
            let same = |w: &Weighed| matches!(&a.action, Action::Push(push) if same_push(push, &w.push));
            weighed.iter().position(same).unwrap_or(usize::MAX)
        };
        ranked.sort_by(|a, b| place(a).cmp(&place(b)).then(b.value.total_cmp(&a.value)));
        ranked.truncate(CONSIDERED);
        ranked
    }
}

fn grasped(state: &State, grasp: Grasp, value: f64) -> PlannedAction {
    let mut predicted = state.clone();
    predicted.set_present(grasp.body, false);
    PlannedAction { action: Action::Grasp(grasp), predicted, value }
}

fn sampler(options: &PlannerOptions, recipe: &Recipe) -> Result<ContourSampler> {
    let sampler = match &options.sampler_params {
        Some(params) => ContourSampler::new("custom", params.clone())?,
        None => ContourSampler::preset(options.sampler.as_deref().unwrap_or(recipe.sampler))?,
    };
    match options.push_length {
        Some(length) => sampler.with_length(length),
        None => Ok(sampler),
    }
}

/// When a grasp is executed, and what a state is worth: as the options say, or where they say nothing and scores are chances
/// of keeping, by the greatest chance that the target has.
fn thresholds(
    options: &PlannerOptions,
    recipe: &Recipe,
    scorer: &dyn Scorer,
    problem: &Problem,
) -> (GraspDecision, Reward) {
    let scene = &problem.scene;
    let greatest = scorer.greatest_score(scene, problem.target).filter(|_| scene.gripper().keeping.is_some());
    match greatest {
        Some(greatest) if options.grasp == GraspDecision::default() => {
            let kept = GraspDecision::kept(greatest);
            (kept, Reward { solved_score: kept.solved_score, ..recipe.reward })
        }
        _ => (options.grasp, recipe.reward),
    }
}

fn prepare(options: &PlannerOptions, recipe: &Recipe, networks: &Networks, problem: &Problem) -> Result<Retrieval> {
    let scene: &Arc<Scene> = &problem.scene;
    let scorer = networks.scorer(recipe, scene)?;
    let (grasp, reward) = thresholds(options, recipe, scorer.as_ref(), problem);
    Ok(Retrieval {
        scene: Arc::clone(scene),
        target: problem.target,
        grasp,
        engine: networks.engine(recipe, scene)?,
        sampler: Box::new(sampler(options, recipe)?.prepared(scene)),
        scorer,
        prior: networks.prior.clone(),
        reward,
        present: None,
        demand: 0.0,
        failed: FailedPushes::default(),
        unsolved: AtomicBool::new(false),
    })
}

/// The states are the same up to [`SAME`].
fn same(a: &State, problem: &Problem) -> bool {
    let (b, near) = (&problem.state, problem.scene.gripper().scale() * SAME.0);
    a.present() == b.present()
        && a.len() == b.len()
        && a.iter().all(|(i, p)| {
            let q = b.pose(i);
            (p.position() - q.position()).norm() <= near && normalize_angle(p.theta - q.theta).abs() <= SAME.1
        })
}

fn same_push(a: &Push, b: &Push) -> bool {
    a.start == b.start && a.end == b.end
}
