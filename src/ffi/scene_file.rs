//! Scenes from files and from the generator.

use std::ffi::c_char;
use std::sync::Arc;

use super::abi::{jostle_body, out, out_handle, text};
use super::context::{Context, jostle_context};
use super::guard::{Call, guard};
use super::log::Log;
use super::scene::{Content, Scene, jostle_scene, with};
use super::status::{Failure, Outcome, jostle_status};
use crate::error::Error;
use crate::scene::generate::{Generator, GeneratorParams};
use crate::scene::{AnyProblem, MAX_SIMULATED};

/// Hands a problem to the caller as a scene and its target.
///
/// # Safety
/// `scene` and `target` are null or writable.
unsafe fn give(
    call: &mut Call,
    context: *const jostle_context,
    scene: *mut *mut jostle_scene,
    target: *mut jostle_body,
    make: impl FnOnce() -> Outcome<AnyProblem>,
) -> Outcome {
    // SAFETY: as promised by the caller.
    let (handle, target) = unsafe { (out_handle(scene, "scene")?, out(target, "target")?) };
    let log: Arc<Log> = Arc::clone(&call.open::<Context>(context, "context")?.log);
    let (content, id) = match make()? {
        AnyProblem::Retrieval(problem) => {
            let content = Content::of(&problem.name, &problem.scene, &problem.state, &[]);
            let id = content.id(problem.target);
            (content, id)
        }
        AnyProblem::Rearrangement(problem) => {
            (Content::of(&problem.name, &problem.scene, &problem.start, &problem.goals), jostle_body::default())
        }
        AnyProblem::Clearing(problem) => {
            (Content::of(&problem.name, &problem.scene, &problem.state, &[]), jostle_body::default())
        }
    };
    handle.give(Scene::new(&log, content))?;
    target.set(id);
    Ok(())
}

/// Reads a problem's file (JSON, see docs/scene-format.md): the scene, and the body to retrieve. Of a rearrangement, the
/// scene with its goals, and zero; of a table to clear, the scene, and zero.
///
/// Thread: any.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns *scene and frees it with jostle_scene_free.
/// Errors: ARGUMENT (null, not UTF-8), HANDLE, IO, FORMAT (the message names the field and its line), MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_read(
    context: *const jostle_context,
    path: *const c_char,
    scene: *mut *mut jostle_scene,
    target: *mut jostle_body,
) -> jostle_status {
    // SAFETY: the caller promises text and writable places.
    guard("jostle_scene_read", |call| unsafe {
        give(call, context, scene, target, || Ok(AnyProblem::read(text(path, "path")?)?))
    })
}

/// Writes the problem of retrieving `target`, or with a zero target that of bringing the bodies to their goals where
/// one has a goal, else that of taking everything off the table, as a file (JSON) that jostle_scene_read and the
/// command-line tool read.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null, not UTF-8, absent target, bodies that overlap, goals that do not fit), HANDLE, BUSY,
/// NOT_FOUND (target), IO, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_write(
    scene: *const jostle_scene,
    target: jostle_body,
    path: *const c_char,
) -> jostle_status {
    with("jostle_scene_write", scene, |content| {
        // SAFETY: the caller promises text.
        let path = unsafe { text(path, "path") }?;
        if target.id == 0 && content.goals.iter().any(Option::is_some) {
            return Ok(content.rearrangement()?.0.write(path)?);
        }
        if target.id == 0 {
            return Ok(content.clearing()?.0.write(path)?);
        }
        Ok(content.problem(target)?.0.write(path)?)
    })
}

/// Makes a random packed scene of `bodies` blocks and picks the one to retrieve. The same seed, index and number make
/// the same scene.
///
/// Thread: any.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns *scene and frees it with jostle_scene_free.
/// Errors: ARGUMENT (null, bodies out of range or more than find room), HANDLE, MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_generate(
    context: *const jostle_context,
    seed: u64,
    index: u64,
    bodies: usize,
    scene: *mut *mut jostle_scene,
    target: *mut jostle_body,
) -> jostle_status {
    // SAFETY: the caller promises writable places.
    guard("jostle_scene_generate", |call| unsafe {
        give(call, context, scene, target, || {
            if !(1..=MAX_SIMULATED).contains(&bodies) {
                return Err(Failure::argument("bodies", format!("is {bodies}; it must lie in 1..={MAX_SIMULATED}")));
            }
            let params = GeneratorParams { bodies: bodies..=bodies, ..GeneratorParams::default() };
            let made = Generator::new(params, seed).and_then(|generator| generator.problem(index));
            made.map(AnyProblem::Retrieval).map_err(|error| match error {
                Error::Argument { reason, .. } => Failure::argument("bodies", reason),
                other => other.into(),
            })
        })
    })
}
