//! Planners: scenes in, plans out.

use std::ffi::{c_char, c_void};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use super::abi::{
    Sized32, init_sized, jostle_body, optional_text, out, out_handle, read_sized_or_default, write_sized,
};
use super::action::jostle_action;
use super::cancel::{Cancel, jostle_cancel};
use super::context::{Context, MAX_THREADS, jostle_context};
use super::decider::{Asks, Decider};
use super::guard::{self, Call, free, guard};
use super::handle::{Kind, Object};
use super::log::Log;
use super::model::{LoadedModel, jostle_model};
use super::options::{jostle_gripper, read_gripper};
use super::plan::{Plan, jostle_plan};
use super::progress::{Listener, Publisher, jostle_progress, jostle_progress_callback};
use super::scene::{Bodies, Scene, jostle_scene};
use super::status::{Failure, Outcome, jostle_status};
use crate::error::Error;
use crate::plan::clear::ClearOptions;
use crate::plan::{Control, GraspDecision, PlannerOptions, Variant};
use crate::run::Budget;
use crate::scene::AnyProblem;

/// Decides what a robot does next: options in, plans out, a search tree kept between decisions. Opaque.
pub struct jostle_planner(());

/// No limit of iterations or bytes.
pub const JOSTLE_NO_LIMIT: u64 = 0xffff_ffff_ffff_ffff;
/// As many threads as the context's options say.
pub const JOSTLE_THREADS_OF_CONTEXT: u32 = 0xffff_ffff;

/// Which form of a planner: one of the JOSTLE_VARIANT_ values.
pub type jostle_variant = i32;
/// As the text of the dissertation says.
pub const JOSTLE_VARIANT_DISSERTATION: jostle_variant = 1;
/// As the published code does.
pub const JOSTLE_VARIANT_CODE: jostle_variant = 2;
/// The published parameters with what measures better here.
pub const JOSTLE_VARIANT_TUNED: jostle_variant = 3;

/// What a planner is told once. Texts are copied.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct jostle_planner_options {
    /// Set by jostle_planner_options_default().
    pub struct_size: u32,
    /// Worker threads; 0 runs everything on the caller. Never changes a plan made within a limit of iterations.
    /// JOSTLE_THREADS_OF_CONTEXT by default.
    pub threads: u32,
    /// "hedge", "pmbs", "mcts", "more", "ppn", "vft" or "dipn" to retrieve a target, "untangle", "pmmr" or "hbfs" to bring
    /// bodies to the scene's goals, "greedy" or "dipn_gn" (or a baseline, "random_push" or "grasp_only") to take everything off
    /// the table; null (the default) for "hedge". The options on pushes, grasps and engines are not for rearrangements.
    pub planner: *const c_char,
    /// Engine that predicts what a push does: "rapier", "planar", "prism", "bullet" or the network "dipn"; null (the
    /// default) for the planner's own.
    pub engine: *const c_char,
    /// The engine's preset, "fast" or "fine" among others; null (the default) for the one that suits planning.
    pub preset: *const c_char,
    /// Push sampler: "vft", "more", "pmbs" or "dense"; null (the default) for the planner's own.
    pub sampler: *const c_char,
    /// 0 by default.
    pub seed: u64,
    /// Iterations of one decision, at least 1; JOSTLE_NO_LIMIT (the default) for no such limit. With neither this nor
    /// max_seconds the planner's published number of iterations is used.
    pub max_iterations: u64,
    /// Wall-clock seconds of one decision, greater than 0; infinity (HUGE_VAL, the default) for no such limit.
    pub max_seconds: f64,
    /// Bytes of the search tree, or of the pushes that a planner of clearings judges, at least 1; JOSTLE_NO_LIMIT (the default)
    /// for no such limit. Planners of rearrangements other than "pmmr" do not count theirs.
    pub max_bytes: u64,
    /// Travel of a push, metres; 0 (the default) for the sampler's own.
    pub push_length: f64,
    /// A grasp is executed if its score is at least this, in [0, 1]; the default is the library's.
    pub execute_score: f64,
    /// A simulated state is a solution if its best grasp's score is at least this, in [0, 1]; the default is the library's.
    pub solved_score: f64,
    /// Logical lanes of a parallel search; changes plans. 0 (the default) for the planner's own.
    pub lanes: u32,
    /// Greatest number of pushes in a plan; 0 (the default) for the planner's own.
    pub max_depth: u32,
    /// Which form of the planner: JOSTLE_VARIANT_TUNED by default.
    pub variant: jostle_variant,
    /// 0.
    pub reserved: u32,
    /// Engine in which the plan found and its best rivals are tried before the decision, a more faithful one than the
    /// search can afford: "ENGINE" or "ENGINE:PRESET", such as "prism:fine"; "none" for no trying; null (the default)
    /// for the planner's own choice.
    pub confirm: *const c_char,
    /// What says how good a state is: "geometric", or the networks "gc" (graspable or not) or "gn" (grasp map); null (the
    /// default) for the planner's own.
    pub scorer: *const c_char,
    /// The scorer's network; null (the default) for the built-in one. The planner keeps it.
    pub scorer_model: *const jostle_model,
    /// The network of the engine "dipn"; null (the default) for the one that `preset` names: a built-in network or a file.
    /// The planner keeps it.
    pub engine_model: *const jostle_model,
    /// What values pushes before they are tried: "ppn", a network, or "none"; null (the default) for the planner's own.
    pub prior: *const c_char,
    /// The network that values pushes; null (the default) for the built-in one. The planner keeps it.
    pub prior_model: *const jostle_model,
    /// The gripper of the scenes that will come: a network that was made for another one is refused by jostle_planner_new. Null
    /// (the default): by the first call with a scene, as it is in any case.
    pub gripper: *const jostle_gripper,
}

// SAFETY: repr(C), struct_size first, numbers and pointers without padding.
unsafe impl Sized32 for jostle_planner_options {
    const NAME: &'static str = "jostle_planner_options";
    const FIRST_SIZE: usize = 112;
    fn defaults() -> Self {
        let grasp = GraspDecision::default();
        jostle_planner_options {
            struct_size: size_of::<Self>() as u32,
            threads: JOSTLE_THREADS_OF_CONTEXT,
            planner: std::ptr::null(),
            engine: std::ptr::null(),
            preset: std::ptr::null(),
            sampler: std::ptr::null(),
            seed: 0,
            max_iterations: JOSTLE_NO_LIMIT,
            max_seconds: f64::INFINITY,
            max_bytes: JOSTLE_NO_LIMIT,
            push_length: 0.0,
            execute_score: grasp.execute_score,
            solved_score: grasp.solved_score,
            lanes: 0,
            max_depth: 0,
            variant: JOSTLE_VARIANT_TUNED,
            reserved: 0,
            confirm: std::ptr::null(),
            scorer: std::ptr::null(),
            scorer_model: std::ptr::null(),
            engine_model: std::ptr::null(),
            prior: std::ptr::null(),
            prior_model: std::ptr::null(),
            gripper: std::ptr::null(),
        }
    }
}

/// What one decision is told.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct jostle_solve_options {
    /// Set by jostle_solve_options_default().
    pub struct_size: u32,
    /// 0.
    pub reserved: u32,
    /// Ends the decision when triggered; null (the default) for none. It may be freed while the decision runs.
    pub cancel: *const jostle_cancel,
    /// Told how far the decision is; null (the default) for none.
    pub progress: jostle_progress_callback,
    /// Passed to `progress`.
    pub user: *mut c_void,
    /// Least time between two calls of `progress`, seconds: 0.1 by default.
    pub progress_seconds: f64,
}

// SAFETY: repr(C), struct_size first, no padding; a null callback is a value, and a callback that is not one is the
// caller's breach of contract.
unsafe impl Sized32 for jostle_solve_options {
    const NAME: &'static str = "jostle_solve_options";
    const FIRST_SIZE: usize = 40;
    fn defaults() -> Self {
        jostle_solve_options {
            struct_size: size_of::<Self>() as u32,
            reserved: 0,
            cancel: std::ptr::null(),
            progress: None,
            user: std::ptr::null_mut(),
            progress_seconds: 0.1,
        }
    }
}

pub(super) struct Planner {
    log: Arc<Log>,
    pub shared: Arc<Shared>,
}

/// What a planner's jobs hold on to.
pub(super) struct Shared {
    pub deciding: Mutex<Deciding>,
    pub publisher: Publisher,
    /// What it takes.
    asks: Asks,
}

pub(super) struct Deciding {
    engine: Decider,
    /// Of the last problem, to understand actions by.
    bodies: Bodies,
    /// A worker panicked: the tree may be half made.
    broken: bool,
}

/// One decision, made ready: nothing in it belongs to the caller but the callback.
pub(super) struct Request {
    pub problem: AnyProblem,
    pub bodies: Bodies,
    pub control: Control,
    pub listener: Option<Listener>,
    /// Of a step.
    pub iterations: Option<u64>,
}

impl Object for Planner {
    const KIND: Kind = Kind::Planner;
    type Handle = jostle_planner;
    fn log(&self) -> &Arc<Log> {
        &self.log
    }
}

impl Request {
    /// Reads what `solve`, `step` and `job_start` are given.
    ///
    /// # Safety
    /// `options` is null or a struct of its size.
    pub unsafe fn read(
        call: &mut Call,
        shared: &Shared,
        scene: *const jostle_scene,
        target: jostle_body,
        options: *const jostle_solve_options,
    ) -> Outcome<Request> {
        // SAFETY: as promised by the caller.
        let options = unsafe { read_sized_or_default(options, "options") }?;
        let seconds = options.progress_seconds;
        if !(0.0..=3600.0).contains(&seconds) {
            return Err(Failure::argument(
                "options.progress_seconds",
                format!("is {seconds}; it must lie in 0..=3600"),
            ));
        }
        let mut control = Control { cancel: Vec::new(), progress: Some(Arc::clone(&shared.publisher.progress)) };
        if !options.cancel.is_null() {
            control.cancel.push(call.open::<Cancel>(options.cancel, "options.cancel")?.token.clone());
        }
        let scene = call.open::<Scene>(scene, "scene")?;
        let content = guard::read(&scene.content, "scene")?;
        let (problem, bodies) = match shared.asks {
            Asks::Target => content.problem(target).map(|(problem, bodies)| (AnyProblem::Retrieval(problem), bodies)),
            _ if target.id != 0 => {
                let reason = match shared.asks {
                    Asks::Goals => "is a body; a planner of rearrangements takes a zero target and the scene's goals",
                    _ => "is a body; a planner that clears the table takes a zero target",
                };
                Err(Failure::argument("target", reason))
            }
            Asks::Goals => {
                content.rearrangement().map(|(problem, bodies)| (AnyProblem::Rearrangement(problem), bodies))
            }
            Asks::All => content.clearing().map(|(problem, bodies)| (AnyProblem::Clearing(problem), bodies)),
        }?;
        drop(content);
        let listener = options.progress.map(|callback| Listener {
            callback: Some(callback),
            user: options.user,
            interval: Duration::from_secs_f64(seconds),
        });
        Ok(Request { problem, bodies, control, listener, iterations: None })
    }
}

impl Deciding {
    /// The planner, if no panic left it half made.
    pub fn whole(&mut self) -> Outcome<&mut Self> {
        if self.broken { Err(Failure::poisoned("planner")) } else { Ok(self) }
    }

    /// Refuses a problem that no decision can be made for.
    pub fn check(&self, problem: &AnyProblem) -> Outcome {
        Ok(self.engine.check(problem)?)
    }

    /// A panic left it half made.
    pub fn break_off(&mut self) {
        self.broken = true;
    }

    /// Makes the decision; the caller has the planner for itself.
    pub fn decide(&mut self, shared: &Shared, request: &Request, log: &Arc<Log>) -> Outcome<Plan> {
        self.whole()?;
        shared.publisher.listen(request.listener);
        let result = self.engine.decide(request, log);
        shared.publisher.listen(None);
        self.broken = matches!(result, Err(Error::Internal(_)));
        let plan = result?;
        self.bodies = request.bodies.clone();
        Ok(plan)
    }
}

/// Sets every field to its default; `size` is sizeof(jostle_planner_options) as the caller was compiled.
/// jostle_planner_options_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_planner_options_init(
    options: *mut jostle_planner_options,
    size: usize,
) -> jostle_status {
    // SAFETY: the caller promises `size` writable bytes.
    guard("jostle_planner_options_init", |_| unsafe { init_sized(options, "options", size) })
}

/// Sets every field to its default; `size` is sizeof(jostle_solve_options) as the caller was compiled.
/// jostle_solve_options_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_solve_options_init(options: *mut jostle_solve_options, size: usize) -> jostle_status {
    // SAFETY: the caller promises `size` writable bytes.
    guard("jostle_solve_options_init", |_| unsafe { init_sized(options, "options", size) })
}

unsafe fn engine_options(
    call: &mut Call,
    options: *const jostle_planner_options,
    context: &Context,
) -> Outcome<PlannerOptions> {
    // SAFETY: the caller promises an initialised struct and texts.
    let (o, planner, engine, preset, sampler, confirm, scorer, prior) = unsafe {
        let o = read_sized_or_default(options, "options")?;
        (
            o,
            optional_text(o.planner, "options.planner")?,
            optional_text(o.engine, "options.engine")?,
            optional_text(o.preset, "options.preset")?,
            optional_text(o.sampler, "options.sampler")?,
            optional_text(o.confirm, "options.confirm")?,
            optional_text(o.scorer, "options.scorer")?,
            optional_text(o.prior, "options.prior")?,
        )
    };
    let threads = if o.threads == JOSTLE_THREADS_OF_CONTEXT { context.threads } else { o.threads };
    if threads > MAX_THREADS {
        return Err(Failure::argument("options.threads", format!("is {threads}; at most {MAX_THREADS}")));
    }
    let variant = match o.variant {
        JOSTLE_VARIANT_DISSERTATION => Variant::Dissertation,
        JOSTLE_VARIANT_CODE => Variant::Code,
        JOSTLE_VARIANT_TUNED => Variant::Tuned,
        other => return Err(Failure::argument("options.variant", format!("is {other}; no variant has this number"))),
    };
    let mut network = |handle: *const jostle_model, field: &str| match handle.is_null() {
        true => Ok(None),
        false => call.open::<LoadedModel>(handle, field).map(|loaded| Some(loaded.model.clone())),
    };
    let scorer_model = network(o.scorer_model, "options.scorer_model")?;
    let engine_model = network(o.engine_model, "options.engine_model")?;
    let prior_model = network(o.prior_model, "options.prior_model")?;
    let gripper = match o.gripper.is_null() {
        true => None,
        // SAFETY: the caller promises an initialised struct.
        false => Some(unsafe { read_gripper(o.gripper, "options.gripper", None) }?),
    };
    // The model takes the preset's place.
    let preset = preset.or((engine == Some("dipn") && engine_model.is_some()).then_some("given"));
    let limit = |value: u64| (value != JOSTLE_NO_LIMIT).then_some(value);
    let usual = PlannerOptions::default();
    let mut options = PlannerOptions {
        planner: planner.map_or(usual.planner, String::from),
        sampler: sampler.map(String::from),
        push_length: (o.push_length != 0.0).then_some(o.push_length),
        grasp: GraspDecision { execute_score: o.execute_score, solved_score: o.solved_score },
        budget: Budget {
            iterations: limit(o.max_iterations),
            seconds: (o.max_seconds != f64::INFINITY).then_some(o.max_seconds),
            bytes: limit(o.max_bytes).map(|bytes| usize::try_from(bytes).unwrap_or(usize::MAX)),
        },
        scorer: scorer.map(String::from),
        scorer_model,
        engine_model,
        prior: prior.map(String::from),
        prior_model,
        gripper,
        seed: o.seed,
        threads: threads as usize,
        lanes: (o.lanes != 0).then_some(o.lanes as usize),
        max_depth: (o.max_depth != 0).then_some(o.max_depth),
        variant,
        ..usual
    };
    match (Asks::of(&options.planner), engine, preset) {
        // A preset alone is one of the planner's own engine.
        (Asks::All, None, Some(_)) => {
            ClearOptions::of(options.clone()).model().and_then(|own| options.set_physics(Some(&own.engine), preset))
        }
        (_, engine, preset) => options.set_physics(engine, preset),
    }
    .map_err(c_field)?;
    options.set_confirm(confirm).map_err(c_field)?;
    // Those of the other planners are checked when the planner is made.
    if Asks::of(&options.planner) == Asks::Target {
        options.validate().map_err(c_field)?;
    }
    Ok(options)
}

/// Puts the C names of options in place of the Rust ones.
fn c_field(error: Error) -> Failure {
    let rename = |field: String| {
        let field = match field.as_str() {
            "iterations" | "budget.iterations" => "max_iterations",
            "seconds" | "budget.seconds" => "max_seconds",
            "bytes" | "budget.bytes" => "max_bytes",
            confirm if confirm.starts_with("confirm.") => "confirm",
            other => other.trim_start_matches("physics.").trim_start_matches("grasp."),
        };
        format!("options.{field}")
    };
    match error {
        Error::Argument { field, reason } => Error::Argument { field: rename(field), reason }.into(),
        Error::NotFound { field, reason } => Error::NotFound { field: rename(field), reason }.into(),
        other => other.into(),
    }
}

/// Makes a planner.
///
/// Thread: any.
/// RT: no.
/// Nullable: options (all defaults).
/// Owns: the caller owns *planner and frees it with jostle_planner_free; `options` is copied.
/// Errors: ARGUMENT (null, an option: the message names it; a network made for another gripper than options.gripper),
/// HANDLE, NOT_FOUND (an unknown planner, engine, preset, sampler or scorer: the message lists the known), UNSUPPORTED,
/// MEMORY, ABI, and what jostle_model_load returns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_planner_new(
    context: *const jostle_context,
    options: *const jostle_planner_options,
    planner: *mut *mut jostle_planner,
) -> jostle_status {
    guard("jostle_planner_new", |call| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out_handle(planner, "planner") }?;
        let context = call.open::<Context>(context, "context")?;
        // SAFETY: the caller promises an initialised struct and texts.
        let options = unsafe { engine_options(call, options, &context) }?;
        let engine = Decider::new(options).map_err(c_field)?;
        let asks = engine.asks();
        let deciding = Deciding { engine, bodies: Bodies::default(), broken: false };
        let shared = Shared { deciding: Mutex::new(deciding), publisher: Publisher::new(), asks };
        out.give(Planner { log: Arc::clone(&context.log), shared: Arc::new(shared) })
    })
}

/// Frees a planner and ends its worker threads. If a job of the planner still runs, they end with the job.
///
/// Thread: any.
/// RT: no.
/// Nullable: planner (does nothing).
/// Owns: the handle is dead afterwards.
/// Errors: none returned; a dead handle leaves a message in jostle_last_error().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_planner_free(planner: *mut jostle_planner) {
    free::<Planner>("jostle_planner_free", planner, "planner", false);
}

unsafe fn decide(
    function: &'static str,
    planner: *mut jostle_planner,
    scene: *const jostle_scene,
    target: jostle_body,
    iterations: Option<u64>,
    options: *const jostle_solve_options,
    plan: *mut *mut jostle_plan,
) -> jostle_status {
    guard(function, |call| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out_handle(plan, "plan") }?;
        let planner = call.open::<Planner>(planner, "planner")?;
        let shared = &planner.shared;
        let mut deciding = guard::lock(&shared.deciding, "planner")?;
        deciding.whole()?;
        if iterations == Some(0) {
            return Err(Failure::argument("iterations", "is 0; it must be at least 1"));
        }
        // SAFETY: the caller promises an initialised struct.
        let request = Request { iterations, ..unsafe { Request::read(call, shared, scene, target, options) }? };
        out.give(deciding.decide(shared, &request, &planner.log)?)
    })
}

/// Decides what to do to retrieve `target`, within the planner's limits, and waits for it. A planner of rearrangements
/// is given a zero target, and brings the scene's bodies to their goals; so is one that clears the table, whose answer is
/// solved and without actions when nothing is left to be taken. The search tree that
/// jostle_planner_advance kept is used if the scene is the one that was expected. The same scene and target again give the
/// same plan again, until an action was executed or failed (a deadline may end the same search sooner or later);
/// jostle_planner_step goes on instead. The scene may be changed by other threads meanwhile: the planner has its own copy.
///
/// Thread: exclusive use of planner, shared use of scene for a moment.
/// RT: no (for real-time threads: jostle_planner_job_start from another thread, jostle_job_poll from any).
/// Nullable: options (all defaults).
/// Owns: the caller owns *plan and frees it with jostle_plan_free.
/// Errors: ARGUMENT (null, an option, zero target, target absent or not pickable, bodies that overlap, a gripper that a
/// network of the planner was not made for), HANDLE, BUSY, NOT_FOUND (target), UNSUPPORTED, MEMORY, PANIC, POISONED, ABI.
/// Running into a limit and being cancelled are outcomes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_planner_solve(
    planner: *mut jostle_planner,
    scene: *const jostle_scene,
    target: jostle_body,
    options: *const jostle_solve_options,
    plan: *mut *mut jostle_plan,
) -> jostle_status {
    // SAFETY: the caller's promises are passed on.
    unsafe { decide("jostle_planner_solve", planner, scene, target, None, options, plan) }
}

/// Does at most `iterations` iterations of the decision on the calling thread and gives the best plan so far; called
/// again with the same scene and target it goes on where it was.
///
/// Thread: exclusive use of planner, shared use of scene for a moment.
/// RT: no.
/// Nullable: options (all defaults).
/// Owns: the caller owns *plan and frees it with jostle_plan_free.
/// Errors: ARGUMENT (null, an option, zero iterations, zero target, target absent or not pickable, bodies that overlap, a
/// gripper that a network of the planner was not made for), HANDLE, BUSY, NOT_FOUND (target), UNSUPPORTED, MEMORY, PANIC,
/// POISONED, ABI.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_planner_step(
    planner: *mut jostle_planner,
    scene: *const jostle_scene,
    target: jostle_body,
    iterations: u64,
    options: *const jostle_solve_options,
    plan: *mut *mut jostle_plan,
) -> jostle_status {
    // SAFETY: the caller's promises are passed on.
    unsafe { decide("jostle_planner_step", planner, scene, target, Some(iterations), options, plan) }
}

/// Tells the planner that the first action of its last plan was executed: the part of the search tree below it is
/// kept. *kept is 1 if there was one, else 0.
///
/// Thread: exclusive use of planner.
/// RT: no.
/// Nullable: kept.
/// Owns: `action` is copied.
/// Errors: ARGUMENT (null, not finite, unknown kind), HANDLE, BUSY, NOT_FOUND (action.body), PANIC, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_planner_advance(
    planner: *mut jostle_planner,
    action: *const jostle_action,
    kept: *mut u32,
) -> jostle_status {
    guard("jostle_planner_advance", |call| {
        let planner = call.open::<Planner>(planner, "planner")?;
        let mut deciding = guard::lock(&planner.shared.deciding, "planner")?;
        let deciding = deciding.whole()?;
        // SAFETY: the caller promises a readable action, and a writable place if it is not null.
        let (was_kept, kept) = unsafe {
            let kept = if kept.is_null() { None } else { Some(out(kept, "kept")?) };
            (deciding.engine.advance(action, &deciding.bodies)?, kept)
        };
        if let Some(kept) = kept {
            kept.set(u32::from(was_kept));
        }
        Ok(())
    })
}

/// Tells the planner that the first action of its last plan was tried and failed: the fingers would have come down on a
/// body, or the target was not in the gripper. Grasps of the target like it score less from now on (docs/c-api.md), so that
/// another side of it is tried first; the same push is not offered before another was executed. Both hold also where the next
/// scene is another one that shows the same bodies, outlines that differ a little where the bodies may be. The search tree is
/// forgotten. jostle_planner_reset forgets what failed.
///
/// Thread: exclusive use of planner.
/// RT: no.
/// Nullable: none.
/// Owns: `action` is copied.
/// Errors: ARGUMENT (null, not finite, unknown kind), HANDLE, BUSY, NOT_FOUND (action.body), PANIC, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_planner_failed(
    planner: *mut jostle_planner,
    action: *const jostle_action,
) -> jostle_status {
    guard("jostle_planner_failed", |call| {
        let planner = call.open::<Planner>(planner, "planner")?;
        let mut deciding = guard::lock(&planner.shared.deciding, "planner")?;
        let deciding = deciding.whole()?;
        // SAFETY: the caller promises a readable action.
        unsafe { deciding.engine.failed(action, &deciding.bodies) }
    })
}

/// Forgets the search tree and what failed.
///
/// Thread: exclusive use of planner.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE, BUSY, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_planner_reset(planner: *mut jostle_planner) -> jostle_status {
    guard("jostle_planner_reset", |call| {
        let planner = call.open::<Planner>(planner, "planner")?;
        guard::lock(&planner.shared.deciding, "planner")?.whole()?.engine.reset();
        Ok(())
    })
}

/// Bytes that the search tree holds, or the pushes that a planner of clearings judged last; for a rearrangement the tree
/// and the paths that are known.
///
/// Thread: exclusive use of planner.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE, BUSY, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_planner_memory(planner: *mut jostle_planner, bytes: *mut u64) -> jostle_status {
    guard("jostle_planner_memory", |call| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out(bytes, "bytes") }?;
        let planner = call.open::<Planner>(planner, "planner")?;
        out.set(guard::lock(&planner.shared.deciding, "planner")?.whole()?.engine.memory_bytes() as u64);
        Ok(())
    })
}

/// How far the planner's decision is, whichever thread makes it; the last numbers if none is being made.
///
/// Thread: any, at any time.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller; progress->struct_size says how much is written.
/// Errors: ARGUMENT (null, progress not initialised), HANDLE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_planner_progress(
    planner: *const jostle_planner,
    progress: *mut jostle_progress,
) -> jostle_status {
    guard("jostle_planner_progress", |call| {
        let planner = call.open::<Planner>(planner, "planner")?;
        let now = planner.shared.publisher.progress.snapshot().into();
        // SAFETY: the caller promises an initialised struct.
        unsafe { write_sized(progress, "progress", &now) }
    })
}
