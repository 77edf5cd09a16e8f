//! Decisions that run in the background.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::sync_channel;
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use super::abi::{jostle_body, out, out_handle, write_sized};
use super::guard::{self, THREAD_PREFIX, free, guard, panic_text};
use super::handle::{Kind, Object};
use super::log::{JOSTLE_LOG_ERROR, Log};
use super::plan::{Plan, jostle_plan};
use super::planner::{Planner, Request, Shared, jostle_planner, jostle_solve_options};
use super::progress::jostle_progress;
use super::scene::jostle_scene;
use super::status::{Failure, JOSTLE_ERROR_PANIC, JOSTLE_ERROR_STATE, Outcome, jostle_status};
use crate::host::{Home, Standard};
use crate::run::{CancelToken, ProgressSnapshot};

/// A decision that runs in the background, on a thread of its own. Opaque.
pub struct jostle_job(());

/// Whether a job still runs: one of the JOSTLE_JOB_ values.
pub type jostle_job_state = i32;
/// It runs.
pub const JOSTLE_JOB_RUNNING: jostle_job_state = 1;
/// It ended; jostle_job_take_plan gives its plan, or says why there is none.
pub const JOSTLE_JOB_DONE: jostle_job_state = 2;

pub(super) struct Job {
    log: Arc<Log>,
    planner: Arc<Shared>,
    running: Arc<Running>,
    cancel: CancelToken,
    thread: Mutex<Option<JoinHandle<()>>>,
    /// Where the thread lives.
    home: Home,
}

#[derive(Default)]
struct Running {
    /// Filled at the end; read without a lock.
    ended: OnceLock<ProgressSnapshot>,
    result: Mutex<Answer>,
    wake: Condvar,
}

#[derive(Default)]
enum Answer {
    #[default]
    None,
    Plan(Box<Plan>),
    Taken,
    Failed(Failure),
}

impl Object for Job {
    const KIND: Kind = Kind::Job;
    type Handle = jostle_job;
    fn log(&self) -> &Arc<Log> {
        &self.log
    }
}

impl Running {
    fn end(&self, result: Outcome<Plan>, last: ProgressSnapshot) {
        let mut answer = self.result.lock().unwrap_or_else(PoisonError::into_inner);
        *answer = match result {
            Ok(plan) => Answer::Plan(Box::new(plan)),
            Err(failure) => Answer::Failed(failure),
        };
        let _ = self.ended.set(last);
        drop(answer);
        self.wake.notify_all();
    }

    fn state(&self) -> jostle_job_state {
        if self.ended.get().is_some() { JOSTLE_JOB_DONE } else { JOSTLE_JOB_RUNNING }
    }
}

impl Drop for Job {
    fn drop(&mut self) {
        self.cancel.trigger();
        let thread = self.thread.get_mut().unwrap_or_else(PoisonError::into_inner).take();
        if self.home.check("job").is_err() {
            // A fork took no threads along: there is none to wait for.
            std::mem::forget(thread);
        } else if let Some(thread) = thread {
            // Freed from the job's own callback: it cannot wait for itself.
            if thread.thread().id() != std::thread::current().id() {
                let _ = thread.join();
            }
        }
    }
}

/// The job's thread: takes the planner, says so, decides.
fn run(planner: &Shared, request: &Request, running: &Running, log: &Arc<Log>, ready: impl FnOnce(Outcome)) {
    let mut deciding = match guard::lock(&planner.deciding, "planner") {
        Ok(deciding) => {
            ready(Ok(()));
            deciding
        }
        Err(failure) => return ready(Err(failure)),
    };
    let result = catch_unwind(AssertUnwindSafe(|| deciding.decide(planner, request, log)));
    let result = result.unwrap_or_else(|panic| {
        deciding.break_off();
        Err(Failure::new(JOSTLE_ERROR_PANIC, format!("internal error: {}", panic_text(&*panic))))
    });
    if let Err(failure) = &result {
        log.emit(JOSTLE_LOG_ERROR, "jostle_planner_job_start", &failure.message);
    }
    let last = planner.publisher.progress.snapshot();
    // The planner is free before anyone hears of the end.
    drop(deciding);
    running.end(result, last);
}

/// Starts a decision in the background: as jostle_planner_solve, without waiting. Until it ends, other calls on the
/// planner return JOSTLE_ERROR_BUSY.
///
/// Thread: exclusive use of planner, shared use of scene for a moment.
/// RT: no.
/// Nullable: options (all defaults).
/// Owns: the caller owns *job and frees it with jostle_job_free.
/// Errors: ARGUMENT (null, an option, zero target, target absent or not pickable, bodies that overlap, a gripper that a
/// network of the planner was not made for), HANDLE, BUSY, NOT_FOUND (target), STATE (no thread can be started), MEMORY,
/// POISONED, ABI. Later failures are the job's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_planner_job_start(
    planner: *mut jostle_planner,
    scene: *const jostle_scene,
    target: jostle_body,
    options: *const jostle_solve_options,
    job: *mut *mut jostle_job,
) -> jostle_status {
    guard("jostle_planner_job_start", |call| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out_handle(job, "job") }?;
        let planner = call.open::<Planner>(planner, "planner")?;
        guard::lock(&planner.shared.deciding, "planner")?.whole()?;
        // SAFETY: the caller promises an initialised struct.
        let mut request = unsafe { Request::read(call, &planner.shared, scene, target, options) }?;
        guard::lock(&planner.shared.deciding, "planner")?.whole()?.check(&request.problem)?;
        let cancel = CancelToken::new();
        request.control.cancel.push(cancel.clone());

        let running = Arc::new(Running::default());
        let (ready, started) = sync_channel(1);
        let (shared, log, its) = (Arc::clone(&planner.shared), Arc::clone(planner.log()), Arc::clone(&running));
        let thread = std::thread::Builder::new()
            .name(format!("{THREAD_PREFIX}-job"))
            .spawn(move || {
                let _standard = Standard::enter();
                run(&shared, &request, &its, &log, |outcome| {
                    let _ = ready.send(outcome);
                });
            })
            .map_err(|e| Failure::new(JOSTLE_ERROR_STATE, format!("the job's thread cannot be started: {e}")))?;
        // From here on the job's drop waits for the thread.
        let job = Job {
            log: Arc::clone(planner.log()),
            planner: Arc::clone(&planner.shared),
            running,
            cancel,
            thread: Mutex::new(Some(thread)),
            home: Home::here(),
        };
        started.recv().unwrap_or_else(|_| Err(Failure::new(JOSTLE_ERROR_PANIC, "the job's thread ended early")))?;
        out.give(job)
    })
}

/// Whether the job still runs, and how far it is. Does not wait.
///
/// Thread: any, at any time.
/// RT: yes.
/// Nullable: state, progress.
/// Owns: the caller; progress->struct_size says how much is written.
/// Errors: ARGUMENT (progress not initialised), HANDLE, STATE (it ran in the process that this one was forked from).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_job_poll(
    job: *const jostle_job,
    state: *mut jostle_job_state,
    progress: *mut jostle_progress,
) -> jostle_status {
    guard("jostle_job_poll", |call| {
        let job = call.open::<Job>(job, "job")?;
        // SAFETY: the caller promises writable places if they are not null.
        let state = if state.is_null() { None } else { Some(unsafe { out(state, "state") }?) };
        if job.running.ended.get().is_none() {
            job.home.check("job")?;
        }
        let now = job.running.ended.get().copied().unwrap_or_else(|| job.planner.publisher.progress.snapshot());
        if !progress.is_null() {
            // SAFETY: the caller promises an initialised struct.
            unsafe { write_sized(progress, "progress", &now.into()) }?;
        }
        if let Some(state) = state {
            state.set(job.running.state());
        }
        Ok(())
    })
}

/// Waits at most `seconds` for the job's end; infinity (HUGE_VAL) waits for as long as it takes. Running out of time is
/// not an error: *state says which it was.
///
/// Thread: any, several at once.
/// RT: no (it waits).
/// Nullable: state.
/// Owns: nothing.
/// Errors: ARGUMENT (seconds negative or not a number), HANDLE, STATE (it ran in the process that this one was forked from).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_job_wait(
    job: *const jostle_job,
    seconds: f64,
    state: *mut jostle_job_state,
) -> jostle_status {
    guard("jostle_job_wait", |call| {
        let job = call.open::<Job>(job, "job")?;
        // SAFETY: the caller promises a writable place if it is not null.
        let state = if state.is_null() { None } else { Some(unsafe { out(state, "state") }?) };
        if seconds.is_nan() || seconds < 0.0 {
            return Err(Failure::argument("seconds", format!("is {seconds}; it must be at least 0")));
        }
        let running = &job.running;
        if running.ended.get().is_none() {
            job.home.check("job")?;
        }
        let result = running.result.lock().unwrap_or_else(PoisonError::into_inner);
        let ended = |_: &mut Answer| running.ended.get().is_none();
        match Duration::try_from_secs_f64(seconds) {
            Ok(limit) => drop(running.wake.wait_timeout_while(result, limit, ended)),
            Err(_) => drop(running.wake.wait_while(result, ended)),
        }
        if let Some(state) = state {
            state.set(running.state());
        }
        Ok(())
    })
}

/// Asks the job to end, as a cancel flag would.
///
/// Thread: any, at any time.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_job_cancel(job: *const jostle_job) -> jostle_status {
    guard("jostle_job_cancel", |call| {
        call.open::<Job>(job, "job")?.cancel.trigger();
        Ok(())
    })
}

/// Takes the plan of a job that has ended, or returns the job's failure with its message.
///
/// Thread: any.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns *plan and frees it with jostle_plan_free; a job gives its plan once.
/// Errors: ARGUMENT (null), HANDLE, STATE (it still runs, or the plan was taken), and whatever failed in the job.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_job_take_plan(job: *mut jostle_job, plan: *mut *mut jostle_plan) -> jostle_status {
    guard("jostle_job_take_plan", |call| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out_handle(plan, "plan") }?;
        let job = call.open::<Job>(job, "job")?;
        let mut answer = job.running.result.lock().unwrap_or_else(PoisonError::into_inner);
        match std::mem::replace(&mut *answer, Answer::Taken) {
            Answer::Plan(plan) => out.give(*plan),
            Answer::Taken => Err(Failure::new(JOSTLE_ERROR_STATE, "job: its plan was taken already")),
            Answer::None => {
                *answer = Answer::None;
                Err(Failure::new(JOSTLE_ERROR_STATE, "job: still runs; wait for its end"))
            }
            Answer::Failed(failure) => {
                let again = Failure::new(failure.status, failure.message.clone());
                *answer = Answer::Failed(failure);
                Err(again)
            }
        }
    })
}

/// Frees a job. One that still runs is cancelled, and the call waits for its end.
///
/// Thread: any.
/// RT: no (it may wait for as long as a cancel takes).
/// Nullable: job (does nothing).
/// Owns: the handle is dead afterwards; a plan that was not taken is lost.
/// Errors: none returned; a dead handle leaves a message in jostle_last_error().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_job_free(job: *mut jostle_job) {
    if !job.is_null() {
        // Before the handle goes: another thread may be inside a wait, which then ends soon.
        guard("jostle_job_free", |call| {
            call.open::<Job>(job, "job")?.cancel.trigger();
            Ok(())
        });
    }
    free::<Job>("jostle_job_free", job, "job", false);
}
