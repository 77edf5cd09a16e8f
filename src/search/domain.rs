//! What the search asks of the thing it searches.

use std::fmt;

use crate::run::{Key, Stop};

/// What is searched: states, the actions they allow, what an action does, how good a state is.
///
/// The search calls it in batches. It is shared by all threads; what changes lives in a [`Scratch`](Self::Scratch),
/// one per worker and search.
///
/// **Contract.** An [`Outcome`] is a function of the job's state, action, key and level alone: not of the scratch's
/// history, of how jobs are grouped, or of the thread. The search relies on it to give the same tree at any number of
/// threads and to use a simulation wherever it is needed again.
pub trait Domain: Sized + Sync {
    /// What a node holds of the world. `clone_from` should reuse memory: the search then allocates nothing.
    type State: Clone + Default + Send + Sync;
    /// What can be done in a state.
    type Action: Clone + Default + Send + Sync;
    /// What one worker needs to run [`step`](Self::step).
    type Scratch: Send;

    /// A scratch for one worker; made once per worker at the start of each search.
    fn scratch(&self) -> Self::Scratch;

    /// Evaluates the state a search starts from and lists its actions. `out` comes empty, as for a job; when asked to end
    /// its status stays [`Interrupted`](Status::Interrupted).
    fn root(&self, scratch: &mut Self::Scratch, state: &Self::State, key: Key, out: &mut Outcome<Self>, stop: &Stop);

    /// Executes every job of a group: applies `job.action` to `job.from` and fills `job.outcome`, which comes empty with
    /// status [`Interrupted`](Status::Interrupted). Long work polls `stop` and leaves the rest of the group as it is
    /// when asked to end.
    fn step(&self, scratch: &mut Self::Scratch, jobs: &mut [Job<Self>], stop: &Stop);

    /// Jobs per call of [`step`](Self::step) that suit the domain best: 1 for scalar engines, 8 or more for engines
    /// that simulate several worlds at once. Groups may be smaller.
    fn group_size(&self) -> usize {
        1
    }

    /// Bytes of one state including what it owns, for the memory budget.
    fn state_bytes(&self) -> usize {
        size_of::<Self::State>()
    }

    /// Bytes of one action including what it owns, for the memory budget.
    fn action_bytes(&self) -> usize {
        size_of::<Self::Action>()
    }
}

/// What became of an action.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Status {
    /// The action was executed; the outcome is filled.
    Legal,
    /// The action cannot be executed, or must not be: it is removed from its node.
    Illegal,
    /// The work was asked to end before the action was done: as if it had not been tried.
    #[default]
    Interrupted,
}

/// An action that a state allows.
#[derive(Debug, Clone, Default)]
pub struct Candidate<A> {
    /// The action.
    pub action: A,
    /// What is expected of it before it is tried; 0 where nothing is known. Finite.
    pub prior: f32,
    /// Whether rollouts leave this action out ("action space bias", chapter REMP).
    pub expansion_only: bool,
}

impl<A> Candidate<A> {
    /// An action about which nothing is known.
    pub fn new(action: A) -> Self {
        Candidate { action, prior: 0.0, expansion_only: false }
    }

    /// An action with an expected return.
    pub fn with_prior(action: A, prior: f32) -> Self {
        Candidate { action, prior, expansion_only: false }
    }
}

/// What an action led to: a state, how good it is, and what can be done in it.
pub struct Outcome<D: Domain> {
    /// What became of the action; the other fields count only if it is [`Legal`](Status::Legal).
    pub status: Status,
    /// The state. For [`Domain::root`] it is copied from the given state beforehand.
    pub state: D::State,
    /// The state's own value, finite. Solutions should have the greatest values.
    pub value: f64,
    /// The state is a solution; nothing is done from it.
    pub terminal: bool,
    /// How good a solution is, to decide between solutions of equal length (a grasp's raw score, say).
    pub quality: f64,
    /// What the action costs, to decide between equal returns. The search adds it up along paths and does not subtract
    /// it from values: a domain with costs in its reward keeps their sum in the state.
    pub cost: f64,
    /// Discount of this action instead of the search's own (the published code of chapter VFT discounts consecutive
    /// pushes less).
    pub discount: Option<f64>,
    /// What can be done in the state, in an order that is the same every time.
    pub candidates: Vec<Candidate<D::Action>>,
}

impl<D: Domain> Outcome<D> {
    /// Makes the outcome empty and keeps its memory.
    pub fn clear(&mut self) {
        self.status = Status::Interrupted;
        self.value = 0.0;
        self.terminal = false;
        self.quality = 0.0;
        self.cost = 0.0;
        self.discount = None;
        self.candidates.clear();
    }
}

impl<D: Domain> Default for Outcome<D> {
    fn default() -> Self {
        Outcome {
            status: Status::Interrupted,
            state: D::State::default(),
            value: 0.0,
            terminal: false,
            quality: 0.0,
            cost: 0.0,
            discount: None,
            candidates: Vec::new(),
        }
    }
}

impl<D: Domain> fmt::Debug for Outcome<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Outcome")
            .field("status", &self.status)
            .field("value", &self.value)
            .field("terminal", &self.terminal)
            .field("quality", &self.quality)
            .field("candidates", &self.candidates.len())
            .finish_non_exhaustive()
    }
}

/// One action to execute. Jobs own copies of what they need, so their memory is used again for later ones.
pub struct Job<D: Domain> {
    /// The state to start from.
    pub from: D::State,
    /// What to do.
    pub action: D::Action,
    /// Names the new node: a function of the seed and of the path from the root. All randomness of the outcome (an
    /// action sampler's order, say) comes from here.
    pub key: Key,
    /// Level of the new node: the number of actions from the root of the search that simulates it first.
    pub level: u32,
    /// To be filled.
    pub outcome: Outcome<D>,
}

impl<D: Domain> Default for Job<D> {
    fn default() -> Self {
        Job {
            from: D::State::default(),
            action: D::Action::default(),
            key: Key::default(),
            level: 0,
            outcome: Outcome::default(),
        }
    }
}

impl<D: Domain> fmt::Debug for Job<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Job")
            .field("key", &self.key)
            .field("level", &self.level)
            .field("outcome", &self.outcome)
            .finish_non_exhaustive()
    }
}
