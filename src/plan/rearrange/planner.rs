//! The planner object: options in, plans out; what it has found is kept between decisions.

use std::sync::{Arc, Mutex};

use super::certain;
use super::domain::{Proposals, Rearrange};
use super::hbfs;
use super::improve::{self, Candidate, Found, Limits};
use super::mover::{Mover, MoverScratch};
use super::options::RearrangeOptions;
use super::outcome::{PlannedMove, RankedMove, RearrangePlan};
use super::pmmr;
use super::table::Layout;
use super::untangle::Worker;
use crate::action::Move;
use crate::error::Result;
use crate::plan::reason::{Ending, Reason};
use crate::plan::{Control, Outcome, PlanStatistics, Variant};
use crate::run::{Budget, Key, Pool, Stop, StopReason};
use crate::scene::{Rearrangement, State};
use crate::search::Tree;

/// Attempts worked at between two updates of the best plan.
const UNTANGLE_LANES: usize = 16;
/// Budget of `untangle` where none is given, seconds.
const UNTANGLE_SECONDS: f64 = 1.0;
/// Of `pmmr`: PMMR-10, and PMMR-40, the source's choice, for the published form.
const PMMR_SECONDS: f64 = 10.0;
const PUBLISHED_SECONDS: f64 = 40.0;

/// What a decision begins with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Begin {
    /// What is left of the plan whose first move was executed, if anything is.
    Afresh,
    /// The last plan, whatever asked for it.
    FromLast,
}

/// A planner of rearrangements with its memory. Thread rule: one thread at a time; it runs its own worker threads inside
/// a call only.
pub struct RearrangePlanner {
    options: RearrangeOptions,
    pool: Pool,
    mover: Option<Arc<Mover>>,
    workers: Vec<Mutex<Worker>>,
    scratches: Vec<Mutex<MoverScratch>>,
    tree: Tree<Rearrange>,
    /// The last plan that solves the problem and the state it begins at: what [`RearrangePlanner::step`] begins with.
    planned: Option<(State, Vec<Move>)>,
    /// The rest of it after what was executed: what [`RearrangePlanner::solve`] begins with.
    kept: Option<(State, Vec<Move>)>,
    /// Why the problem has no solution, and the state that it is known for.
    impossible: Option<(State, Vec<Reason>)>,
    /// Moves executed since the last reset, and searches since the last of them: what is decided after a move has random
    /// numbers of its own, and so has a step after a search. A decision that is asked for again has the same.
    executed: u64,
    searches: u64,
}

impl std::fmt::Debug for RearrangePlanner {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RearrangePlanner").field("options", &self.options).finish_non_exhaustive()
    }
}

impl RearrangePlanner {
    /// Checks the options and starts the worker threads.
    pub fn new(options: RearrangeOptions) -> Result<RearrangePlanner> {
        options.validate()?;
        let pool = Pool::new(options.threads, "jostle")?;
        Ok(RearrangePlanner {
            options,
            pool,
            mover: None,
            workers: Vec::new(),
            scratches: Vec::new(),
            tree: Tree::new(),
            planned: None,
            kept: None,
            impossible: None,
            executed: 0,
            searches: 0,
        })
    }

    pub fn options(&self) -> &RearrangeOptions {
        &self.options
    }

    /// Decides what to do, within the options' budget. The plan holds all moves that are known to be of use: execute
    /// the first one, call [`advance`](Self::advance), observe and ask again, or execute them all.
    ///
    /// Asked again for the same problem, it gives the same plan (a deadline may end the same search sooner or later):
    /// [`step`](Self::step) goes on instead.
    ///
    /// # Errors
    /// A problem without a solution for a reason that can be named ([`Rearrangement::validate`] says which). Running out
    /// of budget or being cancelled are outcomes.
    pub fn solve(&mut self, problem: &Rearrangement, control: &Control) -> Result<RearrangePlan> {
        self.decide(problem, self.options.budget, Begin::Afresh, control)
    }

    /// Like [`solve`](Self::solve), but does at most `iterations` more iterations (the options' seconds hold as well),
    /// starting from the best plan so far if the problem is the same.
    pub fn step(&mut self, problem: &Rearrangement, iterations: u64, control: &Control) -> Result<RearrangePlan> {
        let budget = Budget { iterations: Some(iterations), ..self.options.budget };
        budget.validate()?;
        self.decide(problem, budget, Begin::FromLast, control)
    }

    /// Tells the planner that this move was executed. If it was the first of the last plan, the rest is kept as a plan
    /// to begin with. Returns whether something was kept.
    pub fn advance(&mut self, action: &Move) -> Result<bool> {
        self.executed += 1;
        self.searches = 0;
        self.kept = self.planned.take().filter(|(_, moves)| moves.first() == Some(action));
        if let Some((state, moves)) = &mut self.kept {
            moves.remove(0);
            state.set_pose(action.body(), action.to());
        }
        self.planned.clone_from(&self.kept);
        Ok(self.kept.is_some())
    }

    /// Forgets what was found.
    pub fn reset(&mut self) {
        self.planned = None;
        self.kept = None;
        self.impossible = None;
        self.executed = 0;
        self.searches = 0;
    }

    /// Estimated bytes that the planner holds: the search tree and the paths known.
    pub fn memory_bytes(&self) -> usize {
        let Some(mover) = &self.mover else { return 0 };
        let counts = Proposals::Sampled(self.options.samples);
        let domain = Rearrange::new(Arc::clone(mover), counts, self.options.reward);
        mover.memory_bytes() + self.tree.bytes(&domain)
    }

    fn decide(
        &mut self,
        problem: &Rearrangement,
        budget: Budget,
        begin: Begin,
        control: &Control,
    ) -> Result<RearrangePlan> {
        let budget = self.effective(budget);
        let stop = budget.start(&control.cancel);
        self.decide_until(problem, budget, begin, &stop, control)
    }

    /// Decides until the stop asks for the end.
    pub(super) fn decide_until(
        &mut self,
        problem: &Rearrangement,
        budget: Budget,
        begin: Begin,
        stop: &Stop,
        control: &Control,
    ) -> Result<RearrangePlan> {
        problem.validate()?;
        let mover = self.prepare(problem)?;
        // Half of the bytes are the paths', half the tree's.
        mover.limit_bytes(budget.bytes.map(|bytes| bytes / 2));
        let halved = Budget { bytes: budget.bytes.map(|bytes| (bytes / 2).max(1)), ..budget };
        let mut plan = RearrangePlan::empty(Outcome::Infeasible, &self.options.planner, self.options.seed);
        let key = Key::new(self.options.seed).child(self.executed);
        let seed = match begin {
            Begin::FromLast if self.searches > 0 => key.child(self.searches),
            _ => key,
        }
        .bits();
        let solved = problem.solved(&problem.start);
        let shown = if solved { Vec::new() } else { self.impossible(&mover, stop) };
        let mut found = Found::default();
        found.best.solved = solved;
        if !solved && shown.is_empty() && !cancelled(stop) {
            self.searches += 1;
            let known = self.known(&mover, begin);
            (found, plan.considered) = self.search(&mover, halved, seed, known, stop, control)?;
            if !found.best.solved && found.best.moves.is_empty() {
                let start = Layout::new(&problem.start);
                let moves = certain::useful(&mover, &start, &mut MoverScratch::default(), stop);
                found.best = improve::candidate(&mover, &start, moves);
            }
        }
        let limit = match &found {
            Found { settled: true, .. } => None,
            Found { full: true, .. } => Some(Reason::memory(&budget)),
            // Parts of the work had stops of their own; this one is asked now.
            _ => Reason::limit(&budget, stop.requested().then(|| stop.reason()).flatten()),
        };
        let short = vec![Reason::NoPlanFound { most_moves: self.max_moves(&mover) }];
        let ending = Ending { cancelled: cancelled(stop), solved: found.best.solved, shown, limit, short };
        (plan.outcome, plan.reasons) = ending.conclude();
        self.fill(&mut plan, &mover, found);
        plan.statistics.seconds = stop.elapsed().as_secs_f64();
        Ok(plan)
    }

    /// The budget with the planner's own in place of none.
    fn effective(&self, budget: Budget) -> Budget {
        let own = match self.options.planner.as_str() {
            _ if budget.iterations.is_some() || budget.seconds.is_some() => return budget,
            "hbfs" => return budget,
            "pmmr" if self.options.variant == Variant::Tuned => PMMR_SECONDS,
            "pmmr" => PUBLISHED_SECONDS,
            _ => UNTANGLE_SECONDS,
        };
        Budget { bytes: budget.bytes, ..Budget::seconds(own) }
    }

    /// The table of the problem; paths found before stay known while the scene is the same.
    fn prepare(&mut self, problem: &Rearrangement) -> Result<Arc<Mover>> {
        let same = self.mover.as_ref().is_some_and(|mover| {
            let old = &mover.table.problem;
            old.goals == problem.goals && (Arc::ptr_eq(&old.scene, &problem.scene) || old.scene == problem.scene)
        });
        if !same {
            self.reset();
        }
        let mover = match &self.mover {
            Some(mover) if same => mover.with_table(mover.table.starting_at(&problem.start)),
            _ => Mover::new(problem, self.options.paths, self.options.costs)?,
        };
        let mover = Arc::new(mover);
        self.mover = Some(Arc::clone(&mover));
        Ok(mover)
    }

    fn search(
        &mut self,
        mover: &Arc<Mover>,
        budget: Budget,
        seed: u64,
        known: Option<Vec<Move>>,
        stop: &Stop,
        control: &Control,
    ) -> Result<(Found, Vec<RankedMove>)> {
        match self.options.planner.as_str() {
            "hbfs" => Ok((self.hbfs(mover, budget, seed, stop)?, Vec::new())),
            "pmmr" => {
                let known = known.filter(|_| self.options.variant == Variant::Tuned);
                let means = pmmr::Means {
                    options: &self.options,
                    pool: &self.pool,
                    stop,
                    budget,
                    progress: control.progress.as_deref(),
                    seed,
                    max_moves: self.max_moves(mover) as usize,
                };
                pmmr::search(&mut self.tree, &mut self.workers, mover, known, &means)
            }
            _ => Ok((self.untangle(mover, budget, seed, known, stop, control)?, Vec::new())),
        }
    }

    /// The plan to begin with, if there is one from where the bodies are.
    fn known(&self, mover: &Mover, begin: Begin) -> Option<Vec<Move>> {
        let plan = match begin {
            Begin::Afresh => &self.kept,
            Begin::FromLast => &self.planned,
        };
        plan.as_ref().filter(|(state, _)| *state == mover.table.problem.start).map(|(_, moves)| moves.clone())
    }

    fn max_moves(&self, mover: &Mover) -> u32 {
        self.options.max_moves.unwrap_or(20.max(3 * mover.table.len() as u32))
    }

    /// Parallel runs with seeds of their own; the best of them.
    fn hbfs(&mut self, mover: &Arc<Mover>, budget: Budget, seed: u64, stop: &Stop) -> Result<Found> {
        self.scratches.resize_with(self.pool.workers(), Mutex::default);
        let start = Layout::new(&mover.table.problem.start);
        let max_moves = self.max_moves(mover);
        let samples = self.options.samples;
        let wanted = self.options.seeds as u64;
        let most = budget.iterations.map_or(wanted, |most| most.min(wanted));
        let mut runs: Vec<(Key, Vec<Move>)> = (0..most).map(|run| (Key::new(seed).child(run), Vec::new())).collect();
        self.pool.for_each_group(&mut runs, 1, &self.scratches, |scratch, runs| {
            for (key, moves) in runs {
                *moves = hbfs::run(mover, &samples, scratch, &start, max_moves, &mut key.stream(), stop);
            }
        })?;
        let attempts = runs.len() as u64;
        let mut best: Option<Candidate> = None;
        for (_, moves) in runs {
            let new = improve::candidate(mover, &start, moves);
            let rank = |c: &Candidate| (!c.solved, if c.solved { c.moves.len() } else { c.misplaced });
            let wins = best
                .as_ref()
                .is_none_or(|old| rank(&new).cmp(&rank(old)).then(new.seconds.total_cmp(&old.seconds)).is_lt());
            if wins {
                best = Some(new);
            }
        }
        let settled = attempts == wanted && !stop.requested();
        Ok(Found { best: best.unwrap_or_default(), attempts, at_least: 0, settled, full: false })
    }

    fn untangle(
        &mut self,
        mover: &Arc<Mover>,
        budget: Budget,
        seed: u64,
        known: Option<Vec<Move>>,
        stop: &Stop,
        control: &Control,
    ) -> Result<Found> {
        let limits = Limits {
            pool: &self.pool,
            stop,
            budget,
            progress: control.progress.as_deref(),
            lanes: self.options.lanes.unwrap_or(UNTANGLE_LANES),
            max_moves: self.max_moves(mover) as usize,
            seed,
        };
        improve::search(mover, &mut self.workers, known, &limits)
    }

    /// Why there is no plan at all; worked out once for where the bodies are.
    fn impossible(&mut self, mover: &Mover, stop: &Stop) -> Vec<Reason> {
        let start = &mover.table.problem.start;
        if let Some((state, known)) = &self.impossible
            && state == start
        {
            return known.clone();
        }
        let reasons = certain::impossible(mover, &Layout::new(start), &mut MoverScratch::default(), stop);
        // What was shown holds, whenever the work was asked to end; that nothing was shown may be for want of time.
        if !reasons.is_empty() || !stop.requested() {
            self.impossible = Some((start.clone(), reasons.clone()));
        }
        reasons
    }

    /// Makes the plan of what was found.
    fn fill(&mut self, plan: &mut RearrangePlan, mover: &Mover, found: Found) {
        plan.statistics = PlanStatistics {
            iterations: found.attempts,
            nodes: found.attempts,
            simulations: found.attempts,
            no_plan_within: found.at_least.checked_sub(1).map(|moves| moves as u32),
            ..PlanStatistics::default()
        };
        if matches!(plan.outcome, Outcome::Cancelled | Outcome::Infeasible) {
            plan.considered.clear();
            return;
        }
        plan.cost = found.best.moves.iter().fold(0.0, |sum, action| sum + mover.costs.metres(action));
        plan.robot_seconds = found.best.seconds;
        let mut predicted = mover.table.problem.start.clone();
        self.planned = found.best.solved.then(|| (predicted.clone(), found.best.moves.clone()));
        plan.moves.extend(found.best.moves.into_iter().map(|action| {
            predicted.set_pose(action.body(), action.to());
            PlannedMove { action, predicted: predicted.clone(), value: 0.0 }
        }));
    }
}

/// The end was asked for from outside. A deadline is no such request.
fn cancelled(stop: &Stop) -> bool {
    stop.requested() && stop.reason() != Some(StopReason::Deadline)
}
