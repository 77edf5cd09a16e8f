//! A world to try plans in: it does what a robot would, and observes as a camera would.

use std::ffi::c_char;
use std::sync::{Arc, Mutex};

use super::abi::{
    Sized32, fill, init_sized, jostle_body, jostle_body_pose, optional_text, out, out_handle, read_sized_or_default,
};
use super::action::{jostle_action, read_action};
use super::cancel::{Cancel, jostle_cancel};
use super::context::{Context, jostle_context};
use super::guard::{self, Call, free, guard};
use super::handle::{Kind, Object};
use super::log::Log;
use super::scene::{Bodies, Scene, jostle_scene};
use super::status::{Failure, Outcome, jostle_status};
use crate::error::Error;
use crate::eval::{Effect, Executor, Judge, JudgeOptions};
use crate::physics::{PhysicsOptions, Purpose};
use crate::run::{Budget, Stop};

/// A world to try plans in. It may differ from the planner's model as a real table does. Opaque.
pub struct jostle_simulator(());

/// What an action did: one of the JOSTLE_EFFECT_ values.
pub type jostle_effect = i32;
/// The push was executed.
pub const JOSTLE_EFFECT_PUSHED: jostle_effect = 1;
/// The fingers would come down on a body, or the engine could not solve the push; nothing was executed.
pub const JOSTLE_EFFECT_BLOCKED: jostle_effect = 2;
/// The target, or in a world without one the body of the grasp, was grasped and taken away.
pub const JOSTLE_EFFECT_GRASPED: jostle_effect = 3;
/// The grasp does not hold where the bodies really are, or is not one of the target; nothing changed, or with
/// JOSTLE_EXECUTOR_ROBOT the body was shoved or lost: look before you go on.
pub const JOSTLE_EFFECT_MISSED: jostle_effect = 4;

/// The action was not finished: its limit was reached, or it was cancelled. Nothing changed.
pub const JOSTLE_EFFECT_INTERRUPTED: jostle_effect = 5;
/// The push was executed and a body fell over or leans on something: its outline is no longer what it was, so look before
/// you go on. "prism" ends the push where that happens, with the tip short of its end.
pub const JOSTLE_EFFECT_TOPPLED: jostle_effect = 6;

/// What executes actions in a simulator's world: one of the JOSTLE_EXECUTOR_ values.
pub type jostle_executor = i32;
/// The tip goes straight where it is sent, or as the gripper's tip path says; the engine's trial of a grasp, or where it has
/// none geometry, says what is taken.
pub const JOSTLE_EXECUTOR_ENGINE: jostle_executor = 0;
/// The recorded robot, a UR5e with a 2F-85 (docs/robot.md): its tip sinks and lifts on the way, and its hand keeps, shoves
/// and loses bodies by the chance fitted to recorded grasps, or by the gripper's own. Needs an engine that follows tip
/// paths: "planar", "prism" or "bullet".
pub const JOSTLE_EXECUTOR_ROBOT: jostle_executor = 1;

/// How the world differs from the planner's model: not at all by default, but for the finer preset.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct jostle_simulator_options {
    /// Set by jostle_simulator_options_default().
    pub struct_size: u32,
    /// What executes actions: one of the JOSTLE_EXECUTOR_ values.
    pub executor: jostle_executor,
    /// Engine: "rapier", "planar", "prism" or "bullet"; null (the default) for "rapier", or with JOSTLE_EXECUTOR_ROBOT or a
    /// gripper that has a tip path for "prism".
    pub engine: *const c_char,
    /// The engine's preset, "fine" among others; null (the default) for the one that suits judging.
    pub preset: *const c_char,
    /// Of friction and noise: the same seed is the same world. 0 by default.
    pub seed: u64,
    /// The friction of the fingertips and of every body is scaled by a factor of its own, drawn between 1 - this and
    /// 1 + this: 0 by default, at most 0.9.
    pub friction_spread: f64,
    /// Standard deviation of observed positions, metres: 0 by default, at most 0.02.
    pub position_noise: f64,
    /// Standard deviation of observed headings, radians: 0 by default, at most 0.5.
    pub angle_noise: f64,
}

// SAFETY: repr(C), struct_size first, numbers and pointers without padding.
unsafe impl Sized32 for jostle_simulator_options {
    const NAME: &'static str = "jostle_simulator_options";
    const FIRST_SIZE: usize = 56;
    fn defaults() -> Self {
        jostle_simulator_options {
            struct_size: size_of::<Self>() as u32,
            executor: JOSTLE_EXECUTOR_ENGINE,
            engine: std::ptr::null(),
            preset: std::ptr::null(),
            seed: 0,
            friction_spread: 0.0,
            position_noise: 0.0,
            angle_noise: 0.0,
        }
    }
}

/// What one action is told.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct jostle_execute_options {
    /// Set by jostle_execute_options_default().
    pub struct_size: u32,
    /// 0.
    pub reserved: u32,
    /// Wall-clock limit, seconds; infinity (the default) for none.
    pub max_seconds: f64,
    /// Ends the action when triggered; null (the default) for none. It may be freed while the action runs.
    pub cancel: *const jostle_cancel,
}

// SAFETY: repr(C), struct_size first, numbers and pointers without padding.
unsafe impl Sized32 for jostle_execute_options {
    const NAME: &'static str = "jostle_execute_options";
    const FIRST_SIZE: usize = 24;
    fn defaults() -> Self {
        jostle_execute_options {
            struct_size: size_of::<Self>() as u32,
            reserved: 0,
            max_seconds: f64::INFINITY,
            cancel: std::ptr::null(),
        }
    }
}

pub(super) struct Simulator {
    log: Arc<Log>,
    bodies: Bodies,
    world: Mutex<Judge>,
}

impl Object for Simulator {
    const KIND: Kind = Kind::Simulator;
    type Handle = jostle_simulator;
    fn log(&self) -> &Arc<Log> {
        &self.log
    }
}

fn with(
    function: &'static str,
    simulator: *mut jostle_simulator,
    body: impl FnOnce(&mut Judge, &Bodies) -> Outcome,
) -> jostle_status {
    guard(function, |call| {
        let simulator = call.open::<Simulator>(simulator, "simulator")?;
        let mut world = guard::lock(&simulator.world, "simulator")?;
        body(&mut world, &simulator.bodies)
    })
}

/// When an action is to end.
///
/// # Safety
/// `options` is null or a struct of its size.
unsafe fn until(call: &mut Call, options: *const jostle_execute_options) -> Outcome<Stop> {
    // SAFETY: as promised by the caller.
    let o = unsafe { read_sized_or_default(options, "options") }?;
    if o.max_seconds.is_nan() || o.max_seconds <= 0.0 {
        let reason = format!("is {}; it must be greater than 0, or infinity for no limit", o.max_seconds);
        return Err(Failure::argument("options.max_seconds", reason));
    }
    let mut tokens = Vec::new();
    if !o.cancel.is_null() {
        tokens.push(call.open::<Cancel>(o.cancel, "options.cancel")?.token.clone());
    }
    let seconds = o.max_seconds.is_finite().then_some(o.max_seconds);
    Ok(Budget { seconds, ..Budget::default() }.start(&tokens))
}

/// Sets every field to its default; `size` is sizeof(jostle_simulator_options) as the caller was compiled.
/// jostle_simulator_options_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_simulator_options_init(
    options: *mut jostle_simulator_options,
    size: usize,
) -> jostle_status {
    // SAFETY: the caller promises `size` writable bytes.
    guard("jostle_simulator_options_init", |_| unsafe { init_sized(options, "options", size) })
}

/// Makes a world that begins where `scene` is; later changes of the scene do not reach it. With a zero target every
/// pickable body may be taken.
///
/// Thread: any; shared use of scene for a moment.
/// RT: no.
/// Nullable: options (all defaults).
/// Owns: the caller owns *simulator and frees it with jostle_simulator_free; `options` is copied.
/// Errors: ARGUMENT (null, an option: the message names it, target absent or not pickable, bodies that overlap), HANDLE, BUSY, NOT_FOUND (target, engine, preset), UNSUPPORTED, POISONED, MEMORY, ABI.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_simulator_new(
    context: *const jostle_context,
    scene: *const jostle_scene,
    target: jostle_body,
    options: *const jostle_simulator_options,
    simulator: *mut *mut jostle_simulator,
) -> jostle_status {
    guard("jostle_simulator_new", |call| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out_handle(simulator, "simulator") }?;
        let context = call.open::<Context>(context, "context")?;
        // SAFETY: the caller promises an initialised struct and texts.
        let (o, engine, preset) = unsafe {
            let o = read_sized_or_default(options, "options")?;
            (o, optional_text(o.engine, "options.engine")?, optional_text(o.preset, "options.preset")?)
        };
        for (field, value, most) in [
            ("options.friction_spread", o.friction_spread, 0.9),
            ("options.position_noise", o.position_noise, 0.02),
            ("options.angle_noise", o.angle_noise, 0.5),
        ] {
            // Not `> most`: a NaN is refused as well.
            if !(0.0..=most).contains(&value) {
                return Err(Failure::argument(field, format!("is {value}; it must lie in 0..={most}")));
            }
        }
        let executor = match o.executor {
            JOSTLE_EXECUTOR_ENGINE => Executor::Engine,
            JOSTLE_EXECUTOR_ROBOT => Executor::Robot,
            other => {
                let reason = format!("is {other}; it must be a JOSTLE_EXECUTOR_ value");
                return Err(Failure::argument("options.executor", reason));
            }
        };
        let scene = call.open::<Scene>(scene, "scene")?;
        let content = guard::read(&scene.content, "scene")?;
        let path = executor == Executor::Robot || content.gripper.path.is_some();
        let engine = engine.unwrap_or(if path { "prism" } else { "rapier" });
        let physics = PhysicsOptions::named(engine, preset, Purpose::Judging).map_err(c_field)?;
        let options = JudgeOptions {
            physics,
            executor,
            friction_spread: o.friction_spread,
            noise_position_m: o.position_noise,
            noise_rotation_rad: o.angle_noise,
            seed: o.seed,
        };
        let (world, bodies) = if target.id == 0 {
            let (problem, bodies) = content.clearing()?;
            (Judge::of_clearing(&problem, &options, 0).map_err(judge_field)?, bodies)
        } else {
            let (problem, bodies) = content.problem(target)?;
            (Judge::new(&problem, &options, 0).map_err(judge_field)?, bodies)
        };
        drop(content);
        out.give(Simulator { log: Arc::clone(&context.log), bodies, world: Mutex::new(world) })
    })
}

/// Errors of a judge's options, by the names that they have in C.
fn judge_field(error: Error) -> Error {
    match error {
        Error::Argument { field, reason } => {
            Error::Argument { field: field.replace("judge.physics.", "options."), reason }
        }
        other => other,
    }
}

fn c_field(error: Error) -> Failure {
    let rename = |field: String| format!("options.{}", field.trim_start_matches("physics."));
    match error {
        Error::NotFound { field, reason } => Error::NotFound { field: rename(field), reason }.into(),
        Error::Argument { field, reason } => Error::Argument { field: rename(field), reason }.into(),
        other => other.into(),
    }
}

/// Frees a simulator.
///
/// Thread: any.
/// RT: no.
/// Nullable: simulator (does nothing).
/// Owns: the handle is dead afterwards.
/// Errors: none returned; a dead handle leaves a message in jostle_last_error().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_simulator_free(simulator: *mut jostle_simulator) {
    free::<Simulator>("jostle_simulator_free", simulator, "simulator", false);
}

/// Sets every field to its default; `size` is sizeof(jostle_execute_options) as the caller was compiled.
/// jostle_execute_options_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_execute_options_init(
    options: *mut jostle_execute_options,
    size: usize,
) -> jostle_status {
    // SAFETY: the caller promises `size` writable bytes.
    guard("jostle_execute_options_init", |_| unsafe { init_sized(options, "options", size) })
}

/// Executes an action and says what it did. It takes as long as the engine needs (in "bullet" seconds with many bodies):
/// jostle_simulator_execute_within() has a limit and can be cancelled.
///
/// Thread: exclusive use of simulator.
/// RT: no.
/// Nullable: none.
/// Owns: `action` is copied.
/// Errors: ARGUMENT (null, not finite, unknown kind), HANDLE, BUSY, NOT_FOUND (action.body), UNSUPPORTED, PANIC,
/// POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_simulator_execute(
    simulator: *mut jostle_simulator,
    action: *const jostle_action,
    effect: *mut jostle_effect,
) -> jostle_status {
    // SAFETY: the caller's promises are passed on; there are no options.
    unsafe { execute("jostle_simulator_execute", simulator, action, std::ptr::null(), effect) }
}

/// The same within a limit: where the action is not finished when the time is up, or when it is cancelled, the effect is
/// JOSTLE_EFFECT_INTERRUPTED and the world is as it was before.
///
/// Thread: exclusive use of simulator.
/// RT: no.
/// Nullable: options (all defaults: no limit).
/// Owns: `action` and `options` are copied.
/// Errors: ARGUMENT (null, not finite, unknown kind, an option: the message names it), HANDLE, BUSY, NOT_FOUND
/// (action.body), UNSUPPORTED, PANIC, POISONED, ABI. Running into the limit and being cancelled are effects.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_simulator_execute_within(
    simulator: *mut jostle_simulator,
    action: *const jostle_action,
    options: *const jostle_execute_options,
    effect: *mut jostle_effect,
) -> jostle_status {
    // SAFETY: the caller's promises are passed on.
    unsafe { execute("jostle_simulator_execute_within", simulator, action, options, effect) }
}

/// What both do.
///
/// # Safety
/// As for [`jostle_simulator_execute_within`].
unsafe fn execute(
    function: &'static str,
    simulator: *mut jostle_simulator,
    action: *const jostle_action,
    options: *const jostle_execute_options,
    effect: *mut jostle_effect,
) -> jostle_status {
    guard(function, |call| {
        // SAFETY: the caller promises options of their size.
        let stop = unsafe { until(call, options) }?;
        let simulator = call.open::<Simulator>(simulator, "simulator")?;
        let mut world = guard::lock(&simulator.world, "simulator")?;
        // SAFETY: the caller promises a writable place and a readable action.
        let (out, action) = unsafe { (out(effect, "effect")?, read_action(action, &simulator.bodies)?) };
        out.set(match world.execute_until(&action, &stop)? {
            Some(Effect::Pushed) => JOSTLE_EFFECT_PUSHED,
            Some(Effect::Toppled) => JOSTLE_EFFECT_TOPPLED,
            Some(Effect::Blocked) => JOSTLE_EFFECT_BLOCKED,
            Some(Effect::Grasped) => JOSTLE_EFFECT_GRASPED,
            Some(Effect::Missed) => JOSTLE_EFFECT_MISSED,
            None => JOSTLE_EFFECT_INTERRUPTED,
        });
        Ok(())
    })
}

/// The name of an effect, such as "pushed"; "unknown effect" for other numbers.
///
/// Thread: any.
/// RT: yes.
/// Nullable: never returns null.
/// Owns: the library, for ever.
/// Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn jostle_effect_name(effect: jostle_effect) -> *const c_char {
    match effect {
        JOSTLE_EFFECT_PUSHED => c"pushed",
        JOSTLE_EFFECT_BLOCKED => c"blocked",
        JOSTLE_EFFECT_GRASPED => c"grasped",
        JOSTLE_EFFECT_MISSED => c"missed",
        JOSTLE_EFFECT_INTERRUPTED => c"interrupted",
        JOSTLE_EFFECT_TOPPLED => c"toppled",
        _ => c"unknown effect",
    }
    .as_ptr()
}

/// Copies what a camera reports now: the poses of all bodies, with new noise in every call. It fits
/// jostle_scene_update.
///
/// Thread: exclusive use of simulator.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count, and takes no look).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUSY, BUFFER (count was written), POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_simulator_observe(
    simulator: *mut jostle_simulator,
    buffer: *mut jostle_body_pose,
    capacity: usize,
    count: *mut usize,
) -> jostle_status {
    with("jostle_simulator_observe", simulator, |world, bodies| {
        let poses = if capacity < bodies.len() {
            // Only the count matters: the next look is the same as if this call had not been.
            bodies.poses(world.truth())
        } else {
            bodies.poses(&world.observe())
        };
        // SAFETY: the caller promises room for `capacity` poses.
        unsafe { fill(buffer, capacity, count, &poses) }
    })
}

/// Copies where all bodies really are.
///
/// Thread: exclusive use of simulator.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUSY, BUFFER (count was written), POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_simulator_poses(
    simulator: *mut jostle_simulator,
    buffer: *mut jostle_body_pose,
    capacity: usize,
    count: *mut usize,
) -> jostle_status {
    // SAFETY: the caller promises room for `capacity` poses.
    with("jostle_simulator_poses", simulator, |world, bodies| unsafe {
        fill(buffer, capacity, count, &bodies.poses(world.truth()))
    })
}

/// Writes 1 to *left if the target, or in a world without one any body, is outside of the workspace, by the workspace's
/// rule, else 0.
///
/// Thread: exclusive use of simulator.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE, BUSY, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_simulator_target_left(
    simulator: *mut jostle_simulator,
    left: *mut u32,
) -> jostle_status {
    with("jostle_simulator_target_left", simulator, |world, _| {
        // SAFETY: the caller promises a writable place.
        unsafe { out(left, "left") }?.set(u32::from(world.target_left()));
        Ok(())
    })
}
