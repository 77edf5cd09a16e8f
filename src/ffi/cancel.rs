//! Asking a decision to end, from any thread.

use std::sync::Arc;

use super::abi::{out, out_handle};
use super::context::{Context, jostle_context};
use super::guard::{free, guard};
use super::handle::{Kind, Object};
use super::log::Log;
use super::status::jostle_status;
use crate::run::CancelToken;

/// A flag that asks decisions to end; one may serve many decisions, at once or one after the other. Opaque.
pub struct jostle_cancel(());

pub(super) struct Cancel {
    log: Arc<Log>,
    pub token: CancelToken,
}

impl Object for Cancel {
    const KIND: Kind = Kind::Cancel;
    type Handle = jostle_cancel;
    fn log(&self) -> &Arc<Log> {
        &self.log
    }
}

/// Makes a flag that is not triggered.
///
/// Thread: any.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns *cancel and frees it with jostle_cancel_free, whenever it likes: decisions hold on to the flag.
/// Errors: ARGUMENT (null), HANDLE, MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_cancel_new(
    context: *const jostle_context,
    cancel: *mut *mut jostle_cancel,
) -> jostle_status {
    guard("jostle_cancel_new", |call| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out_handle(cancel, "cancel") }?;
        let context = call.open::<Context>(context, "context")?;
        out.give(Cancel { log: Arc::clone(&context.log), token: CancelToken::new() })
    })
}

/// Makes a second handle to the same flag, with a life of its own: give each thread that triggers its own handle, and
/// no thread has to know when another frees.
///
/// Thread: any.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns *copy and frees it with jostle_cancel_free.
/// Errors: ARGUMENT (null), HANDLE, MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_cancel_clone(
    cancel: *const jostle_cancel,
    copy: *mut *mut jostle_cancel,
) -> jostle_status {
    guard("jostle_cancel_clone", |call| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out_handle(copy, "copy") }?;
        let cancel = call.open::<Cancel>(cancel, "cancel")?;
        out.give(Cancel { log: Arc::clone(&cancel.log), token: cancel.token.clone() })
    })
}

/// Asks every decision that was given the flag to end. It ends within the time that docs/c-api.md states, and its plan
/// holds no actions. Triggering twice changes nothing.
///
/// Thread: any, at any time, also from a signal handler or a real-time thread.
/// RT: yes (no lock, no memory, no system call).
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE (also when it was freed: that is safe to try).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_cancel_trigger(cancel: *const jostle_cancel) -> jostle_status {
    guard("jostle_cancel_trigger", |call| {
        call.open::<Cancel>(cancel, "cancel")?.token.trigger();
        Ok(())
    })
}

/// Makes the flag usable for the next decision. A decision that has seen the request already still ends.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_cancel_reset(cancel: *const jostle_cancel) -> jostle_status {
    guard("jostle_cancel_reset", |call| {
        call.open::<Cancel>(cancel, "cancel")?.token.reset();
        Ok(())
    })
}

/// Writes 1 to *triggered if the flag was triggered (and not reset), else 0.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_cancel_triggered(cancel: *const jostle_cancel, triggered: *mut u32) -> jostle_status {
    guard("jostle_cancel_triggered", |call| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out(triggered, "triggered") }?;
        out.set(u32::from(call.open::<Cancel>(cancel, "cancel")?.token.is_triggered()));
        Ok(())
    })
}

/// Frees a handle. The flag itself lives on while a decision or another handle uses it.
///
/// Thread: any, also while another thread triggers this handle.
/// RT: no.
/// Nullable: cancel (does nothing).
/// Owns: the handle is dead afterwards.
/// Errors: none returned; a dead handle leaves a message in jostle_last_error().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_cancel_free(cancel: *mut jostle_cancel) {
    // Waiting for calls on it keeps the last use, and the release of memory, out of a real-time thread.
    free::<Cancel>("jostle_cancel_free", cancel, "cancel", true);
}
