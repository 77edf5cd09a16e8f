//! The parameters of the search: one set of them is one published algorithm.
//!
//! | | [`vft`](Params::vft) | [`mcts`](Params::mcts) | [`guided`](Params::guided) | [`pmbs`](Params::pmbs) | [`pmmr`](Params::pmmr) |
//! |---|---|---|---|---|---|
//! | chapter | VFT | MORE, MCTS | MORE, guided | PMBS | REMP |
//! | selection | top 3, c = √2 | top 10, c = √2 | top 3 + prior, c = 0 | mean, c = 0.3 | top 100, c = 1.5 |
//! | depth, extra | 4, 0 | 4, 0 | 3, 0 | 7, 3 | 2 N + 2, 0 |
//! | discount | 0.8 | 0.5 | 0.5 | 0.8 | 0.9 |
//! | rollout | uniform | uniform | best prior | uniform | best prior or any, by depth |
//! | return | greatest discounted | greatest discounted | greatest discounted | greatest discounted | last, or half the greatest earlier |
//! | backup | greatest with own | as is | as is | greatest with own | as is |
//! | final | greatest return | greatest return | greatest return + prior | mean | mean of the top 100 |
//! | early stop | none | level complete | level complete | level complete | none |

use crate::error::{Error, Result, check_range};

/// How the value of a child is read from its returns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mean {
    /// Mean of all returns (PMBS, Eq. pmbs-ucb1).
    All,
    /// Mean of the best so many (VFT, Eq. vft-uct: 3; MORE, Eq. more-pi: 10; REMP: 100). While there are fewer, the
    /// mean of those.
    Top(u32),
}

/// Which child of a node without untried actions is entered. `N` and `n` count visits of the node and of the child,
/// virtual ones included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Selection {
    /// `mean + exploration * sqrt(2 ln N / n)` (PMBS, Eq. pmbs-ucb1 and pmbs-ucb2).
    ///
    /// VFT and MORE write `C sqrt(ln N / n)`; then `exploration = C / √2`. Values: VFT and MORE C = 2, so √2; PMBS 0.3
    /// in the dissertation, 0.3 √2 = 0.424 in its published code; REMP 1.5.
    Ucb { mean: Mean, exploration: f64 },
    /// `(prior + sum of the best top returns) / (1 + n)`, the prior clipped to `0..=limit`, without exploration (guided
    /// MORE: "N is initialized to 1").
    Guided { top: u32, limit: f64 },
}

/// Which untried action of a node is tried next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Expansion {
    /// Any, with equal probability (VFT, MORE, PMBS).
    Uniform,
    /// The first in the domain's order (the published code of VFT sorts its actions so).
    InOrder,
    /// The one with the greatest prior, the first of equals (guided MORE).
    BestPrior,
    /// As `BestPrior`, but a node's children are entered before all its actions were tried if they score higher than
    /// the untried action's prior (a reading of guided MORE's "for all state-action pairs"; needs
    /// [`Selection::Guided`]).
    Compete,
}

/// Which action a rollout takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RolloutPolicy {
    /// Any, with equal probability.
    Uniform,
    /// The one with the greatest prior, the first of equals.
    BestPrior,
    /// Any with probability `max(floor, a + b d + c d²)` at level `d`, else the one with the greatest prior. REMP:
    /// `polynomial = [-0.106, 0.231, -0.013]`, `floor = 0.2`.
    Mix { polynomial: [f64; 3], floor: f64 },
}

/// What a rollout does when its action turns out to be illegal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RolloutFailure {
    /// It ends ("until a grasp is possible or a failure is encountered", MORE).
    End,
    /// It tries another action of the same state.
    Retry,
}

/// How far rollouts go; `level` is that of the new node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RolloutDepth {
    /// To level `max(max_depth, level + extra)`: at least `extra` steps (PMBS, text and code).
    AtLeast,
    /// To level `max_depth + extra` (PMBS, "the maximum depth reached").
    Sum,
}

/// The return of one iteration: a number made from the values `v_0` of the new node and `v_1 ... v_m` of the rollout's
/// states, with `g_j` the product of the discounts of the actions between state 0 and state j.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Return {
    /// `max_j g_j v_j` (VFT; published code of MORE and PMBS).
    Greatest,
    /// `g_j v_j` with j the state of the greatest plain value, the first of equals (published code of VFT).
    BestPlain,
    /// `g_m max(v_m, earlier * max_{j<m} v_j)`. 0 takes the last state alone (MORE, text); REMP: 0.5.
    Last { earlier: f64 },
}

/// What each ancestor of the new node receives, given the return of its child discounted by the action between.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Backup {
    /// That number (MORE).
    AsIs,
    /// The greater of that number and the node's own value (VFT, PMBS).
    GreatestWithOwn,
    /// That number, or the node's own value if no plain value below was greater (published code of VFT).
    OwnIfBestPlain,
}

/// How the root's action is chosen in the end. Ties go to the shorter solution, the better quality, the lower cost and
/// the lower index, in this order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FinalChoice {
    /// By its returns. `Top(1)`: the greatest single return (VFT, MORE); `All`: the mean (PMBS, c = 0).
    Returns(Mean),
    /// Greatest return plus prior, clipped to `0..=limit` (guided MORE, Q_best).
    ReturnsAndPrior { limit: f64 },
    /// Most visits.
    Visits,
    /// Greatest prior of those that turned out to be legal: the domain's expectation alone (MORE, PPN as a policy).
    Prior,
}

/// What happens when selection arrives at a node with nothing left to try: a solution, the depth limit, a dead end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Closed {
    /// Its return counts once more (plain UCT; VFT, MORE, serial PMBS).
    Revisit,
    /// It receives a virtual visit, which turns later selections of the wave away (parallel PMBS).
    Repel,
    /// Selection never goes there (not published; wastes nothing).
    Skip,
}

/// When the search ends before its budget.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EarlyStop {
    /// Never.
    Never,
    /// When a solution has level `<= stop`, where `stop` starts at `first` and grows while every node at level
    /// `stop - 1` is terminal or fully expanded (PMBS, Algorithm Parallel-MCTS: first = 1, or 2 after `first_expand`;
    /// MORE, condition 2), but not beyond `last` (published code of MORE: 2).
    LevelComplete { first: u32, last: Option<u32> },
}

/// Parameters of the search. Plain data; start from a constructor and change what differs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Params {
    /// Which child is entered.
    pub selection: Selection,
    /// Which untried action is tried.
    pub expansion: Expansion,
    /// How the root's action is chosen.
    pub final_choice: FinalChoice,
    /// Choose among the root's actions that lead to a shortest known solution, if there is one. Published: false.
    pub prefer_solution: bool,
    /// Discount per action, 0 to 1. VFT 0.8 (code 0.6), MORE 0.5, PMBS 0.8, REMP 0.9.
    pub discount: f64,
    /// Greatest level of a node, `d_T`. VFT and MORE 4, guided MORE 3 (code 2), PMBS 7, REMP 2N + 2.
    pub max_depth: u32,
    /// How far rollouts go beyond, `d_s`: PMBS 3.
    pub rollout_extra: u32,
    /// How `max_depth` and `rollout_extra` combine.
    pub rollout_depth: RolloutDepth,
    /// Which action a rollout takes.
    pub rollout_policy: RolloutPolicy,
    /// What an illegal action does to a rollout.
    pub rollout_failure: RolloutFailure,
    /// Rollouts of a wave end when at most this fraction of the lanes is active. 0: never (dissertation); published code
    /// of PMBS: 0.1.
    pub rollout_cutoff: f64,
    /// Keep simulated rollout states in the tree, so that expanding them later costs no simulation. A pure cache:
    /// decisions are the same without.
    pub reuse_rollouts: bool,
    /// Make the best solution that the rollouts of a pair meet a node of the tree, with the way to it, if it is within
    /// `max_depth`: the search then knows a whole plan, and `shrink_depth_on_solution` applies to it ("an identified
    /// terminal node", PMBS). Needs `reuse_rollouts`.
    pub adopt_solutions: bool,
    /// When a solution of level d is found, `max_depth` becomes d and `rollout_extra` 0 (PMBS).
    pub shrink_depth_on_solution: bool,
    /// The return of an iteration.
    pub returns: Return,
    /// What ancestors receive.
    pub backup: Backup,
    /// What happens at nodes with nothing left to try.
    pub closed: Closed,
    /// When the search ends before its budget.
    pub early_stop: EarlyStop,
    /// Iterations before `early_stop` counts. MORE: 50 when it collects training data.
    pub min_iterations: u64,
    /// Pairs of node and action selected, and rollouts run, at once; 1 is serial search. Lanes change the result, threads
    /// never do. PMBS: the number of environments, 1000.
    pub lanes: u32,
    /// Visits a selected pair counts for while its wave is selected, per lane (PMBS, Eq. pmbs-ucb2: 1).
    pub virtual_loss: f64,
    /// Before the first wave, try every action of the root once without rollouts (published code of PMBS).
    pub first_expand: bool,
    /// Where there are more lanes than rollouts, run several rollouts of one node and keep the greatest return (PMBS).
    pub leaf_parallel: bool,
}

impl Params {
    /// The search of chapter VFT, Algorithm vft, with the dissertation's values.
    pub fn vft() -> Self {
        Params {
            selection: Selection::Ucb { mean: Mean::Top(3), exploration: std::f64::consts::SQRT_2 },
            expansion: Expansion::Uniform,
            final_choice: FinalChoice::Returns(Mean::Top(1)),
            prefer_solution: false,
            discount: 0.8,
            max_depth: 4,
            rollout_extra: 0,
            rollout_depth: RolloutDepth::AtLeast,
            rollout_policy: RolloutPolicy::Uniform,
            rollout_failure: RolloutFailure::End,
            rollout_cutoff: 0.0,
            reuse_rollouts: true,
            adopt_solutions: false,
            shrink_depth_on_solution: false,
            returns: Return::Greatest,
            backup: Backup::GreatestWithOwn,
            closed: Closed::Revisit,
            early_stop: EarlyStop::Never,
            min_iterations: 0,
            lanes: 1,
            virtual_loss: 1.0,
            first_expand: false,
            leaf_parallel: false,
        }
    }

    /// The unguided search of chapter MORE. The return is the published code's, `Return::Greatest`; the text's (the
    /// last state alone) is `Return::Last { earlier: 0.0 }`.
    pub fn mcts() -> Self {
        Params {
            selection: Selection::Ucb { mean: Mean::Top(10), exploration: std::f64::consts::SQRT_2 },
            discount: 0.5,
            backup: Backup::AsIs,
            early_stop: EarlyStop::LevelComplete { first: 1, last: None },
            ..Params::vft()
        }
    }

    /// The guided search of chapter MORE: the domain's priors are the push prediction network's values.
    pub fn guided() -> Self {
        Params {
            selection: Selection::Guided { top: 3, limit: 1.2 },
            expansion: Expansion::BestPrior,
            final_choice: FinalChoice::ReturnsAndPrior { limit: 1.2 },
            max_depth: 3,
            rollout_policy: RolloutPolicy::BestPrior,
            ..Params::mcts()
        }
    }

    /// The search of chapter PMBS with `lanes` environments; 1 is its serial form.
    pub fn pmbs(lanes: u32) -> Self {
        Params {
            selection: Selection::Ucb { mean: Mean::All, exploration: 0.3 },
            final_choice: FinalChoice::Returns(Mean::All),
            max_depth: 7,
            rollout_extra: 3,
            shrink_depth_on_solution: true,
            closed: if lanes > 1 { Closed::Repel } else { Closed::Revisit },
            early_stop: EarlyStop::LevelComplete { first: 1, last: None },
            lanes,
            leaf_parallel: lanes > 1,
            ..Params::vft()
        }
    }

    /// The search of chapter REMP for so many objects, with ten lanes (the source's machine had ten cores). The domain
    /// gives moves to a goal a greater prior than the others. The text counts the discount per step of a rollout; here,
    /// as everywhere, each action from the root on counts.
    pub fn pmmr(objects: usize) -> Self {
        Params {
            selection: Selection::Ucb { mean: Mean::Top(100), exploration: 1.5 },
            expansion: Expansion::BestPrior,
            final_choice: FinalChoice::Returns(Mean::Top(100)),
            discount: 0.9,
            max_depth: 2 * u32::try_from(objects).unwrap_or(MAX_DEPTH).min(MAX_DEPTH / 2 - 1) + 2,
            rollout_policy: RolloutPolicy::Mix { polynomial: [-0.106, 0.231, -0.013], floor: 0.2 },
            rollout_failure: RolloutFailure::Retry,
            returns: Return::Last { earlier: 0.5 },
            backup: Backup::AsIs,
            lanes: 10,
            ..Params::vft()
        }
    }

    /// Refuses parameters that cannot be used, by name.
    pub fn validate(&self) -> Result<()> {
        match self.selection {
            Selection::Ucb { mean, exploration } => {
                check_mean("selection.mean", mean)?;
                check_range("selection.exploration", exploration, 0.0..=1e9)?;
            }
            Selection::Guided { top, limit } => {
                check_mean("selection.top", Mean::Top(top))?;
                check_range("selection.limit", limit, 0.0..=1e9)?;
            }
        }
        if self.expansion == Expansion::Compete && !matches!(self.selection, Selection::Guided { .. }) {
            let reason = "is Compete, which compares priors with scores; it needs Selection::Guided";
            return Err(Error::argument("expansion", reason));
        }
        match self.final_choice {
            FinalChoice::Returns(mean) => check_mean("final_choice", mean)?,
            FinalChoice::ReturnsAndPrior { limit } => check_range("final_choice.limit", limit, 0.0..=1e9)?,
            FinalChoice::Visits | FinalChoice::Prior => {}
        }
        check_range("discount", self.discount, 0.0..=1.0)?;
        check_count("max_depth", self.max_depth, 1, MAX_DEPTH)?;
        check_count("rollout_extra", self.rollout_extra, 0, MAX_DEPTH)?;
        if let RolloutPolicy::Mix { polynomial, floor } = self.rollout_policy {
            for (index, value) in polynomial.into_iter().enumerate() {
                check_range(&format!("rollout_policy.polynomial[{index}]"), value, -1e9..=1e9)?;
            }
            check_range("rollout_policy.floor", floor, 0.0..=1.0)?;
        }
        check_range("rollout_cutoff", self.rollout_cutoff, 0.0..=1.0)?;
        if let Return::Last { earlier } = self.returns {
            check_range("returns.earlier", earlier, 0.0..=1.0)?;
        }
        if self.adopt_solutions && !self.reuse_rollouts {
            return Err(Error::argument("adopt_solutions", "needs the states of rollouts; set reuse_rollouts"));
        }
        if let EarlyStop::LevelComplete { first, last } = self.early_stop {
            check_count("early_stop.first", first, 1, MAX_DEPTH)?;
            if let Some(last) = last {
                check_count("early_stop.last", last, first, MAX_DEPTH)?;
            }
        }
        check_count("lanes", self.lanes, 1, MAX_LANES)?;
        check_range("virtual_loss", self.virtual_loss, 0.0..=1e9)
    }

    /// How many best returns every node has to remember.
    pub(super) fn remembered(&self) -> usize {
        let of = |mean| if let Mean::Top(m) = mean { m } else { 1 };
        let selection = match self.selection {
            Selection::Ucb { mean, .. } => of(mean),
            Selection::Guided { top, .. } => top,
        };
        let choice = if let FinalChoice::Returns(mean) = self.final_choice { of(mean) } else { 1 };
        selection.max(choice) as usize
    }
}

/// Far deeper than any plan, and shallow enough that nothing overflows.
const MAX_DEPTH: u32 = 1000;
const MAX_LANES: u32 = 1 << 20;
const MAX_TOP: u32 = 10_000;

fn check_mean(field: &str, mean: Mean) -> Result<()> {
    match mean {
        Mean::All => Ok(()),
        Mean::Top(m) => check_count(field, m, 1, MAX_TOP),
    }
}

fn check_count(field: &str, value: u32, least: u32, most: u32) -> Result<()> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(Error::argument(field, format!("is {value}; it must lie in {least} to {most}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_sets_are_valid() {
        for params in [
            Params::vft(),
            Params::mcts(),
            Params::guided(),
            Params::pmbs(1),
            Params::pmbs(1000),
            Params::pmmr(8),
            Params::pmmr(usize::MAX),
        ] {
            params.validate().unwrap();
        }
        assert_eq!(Params::mcts().remembered(), 10);
        assert_eq!(Params::pmbs(8).remembered(), 1);
    }

    #[test]
    fn every_bad_number_is_refused_by_its_name() {
        let ok = Params::pmbs(8);
        let ucb = |mean, exploration| Selection::Ucb { mean, exploration };
        let mix = |a, floor| RolloutPolicy::Mix { polynomial: [0.0, a, 0.0], floor };
        let level = |first, last| EarlyStop::LevelComplete { first, last };
        let cases = [
            ("selection.mean", Params { selection: ucb(Mean::Top(0), 1.0), ..ok }),
            ("selection.exploration", Params { selection: ucb(Mean::All, -1.0), ..ok }),
            ("selection.exploration", Params { selection: ucb(Mean::All, f64::INFINITY), ..ok }),
            ("selection.top", Params { selection: Selection::Guided { top: 0, limit: 1.0 }, ..ok }),
            ("selection.limit", Params { selection: Selection::Guided { top: 1, limit: f64::NAN }, ..ok }),
            ("expansion", Params { expansion: Expansion::Compete, ..ok }),
            ("final_choice", Params { final_choice: FinalChoice::Returns(Mean::Top(0)), ..ok }),
            ("final_choice.limit", Params { final_choice: FinalChoice::ReturnsAndPrior { limit: -1.0 }, ..ok }),
            ("discount", Params { discount: 1.5, ..ok }),
            ("discount", Params { discount: f64::NAN, ..ok }),
            ("max_depth", Params { max_depth: 0, ..ok }),
            ("rollout_extra", Params { rollout_extra: u32::MAX, ..ok }),
            ("rollout_policy.polynomial[1]", Params { rollout_policy: mix(f64::NAN, 0.2), ..ok }),
            ("rollout_policy.floor", Params { rollout_policy: mix(0.0, 1.2), ..ok }),
            ("rollout_cutoff", Params { rollout_cutoff: -0.1, ..ok }),
            ("returns.earlier", Params { returns: Return::Last { earlier: 2.0 }, ..ok }),
            ("early_stop.first", Params { early_stop: level(0, None), ..ok }),
            ("early_stop.last", Params { early_stop: level(2, Some(1)), ..ok }),
            ("lanes", Params { lanes: 0, ..ok }),
            ("virtual_loss", Params { virtual_loss: f64::NAN, ..ok }),
        ];
        for (name, params) in cases {
            match params.validate() {
                Err(Error::Argument { field, .. }) => assert_eq!(field, name),
                other => panic!("{name}: {other:?}"),
            }
        }
    }
}
