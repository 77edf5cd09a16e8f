//! The context: what all other objects are made from.

use std::ffi::c_void;
use std::sync::Arc;

use super::abi::{Sized32, init_sized, out_handle, read_sized_or_default};
use super::guard::{free, guard};
use super::handle::{Kind, Object};
use super::log::{JOSTLE_LOG_ERROR, JOSTLE_LOG_WARNING, Log, jostle_log_callback};
use super::status::{Failure, jostle_status};

/// Settings that all objects of a context share.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct jostle_context_options {
    /// Set by jostle_context_options_default().
    pub struct_size: u32,
    /// Worker threads of each planner that does not say otherwise; 0 runs everything on the caller (the default).
    pub threads: u32,
    /// Receives messages; null for none (the default).
    pub log_callback: jostle_log_callback,
    /// Passed to `log_callback`; must stay usable until the context and all objects made from it are freed.
    pub log_user: *mut c_void,
    /// Which messages: JOSTLE_LOG_ values, or-ed. Errors and warnings by default.
    pub log_mask: u32,
    /// 0.
    pub reserved: u32,
}

// SAFETY: repr(C), struct_size first, no padding; a null callback is a value, and a callback that is not one is the
// caller's breach of contract.
unsafe impl Sized32 for jostle_context_options {
    const NAME: &'static str = "jostle_context_options";
    const FIRST_SIZE: usize = 32;
    fn defaults() -> Self {
        jostle_context_options {
            struct_size: size_of::<Self>() as u32,
            threads: 0,
            log_callback: None,
            log_user: std::ptr::null_mut(),
            log_mask: JOSTLE_LOG_ERROR | JOSTLE_LOG_WARNING,
            reserved: 0,
        }
    }
}

/// What all other objects are made from: logging and defaults. Opaque.
pub struct jostle_context(());

pub(super) struct Context {
    pub log: Arc<Log>,
    pub threads: u32,
}

impl Object for Context {
    const KIND: Kind = Kind::Context;
    type Handle = jostle_context;
    fn log(&self) -> &Arc<Log> {
        &self.log
    }
}

pub(super) const MAX_THREADS: u32 = 1024;

/// Sets every field to its default; `size` is sizeof(jostle_context_options) as the caller was compiled.
/// jostle_context_options_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_context_options_init(
    options: *mut jostle_context_options,
    size: usize,
) -> jostle_status {
    // SAFETY: the caller promises `size` writable bytes.
    guard("jostle_context_options_init", |_| unsafe { init_sized(options, "options", size) })
}

/// Makes a context.
///
/// Thread: any.
/// RT: no.
/// Nullable: options (all defaults).
/// Owns: the caller owns *context and frees it with jostle_context_free; `options` is copied.
/// Errors: ARGUMENT (null, threads out of range), ABI (options of a newer header), MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_context_new(
    options: *const jostle_context_options,
    context: *mut *mut jostle_context,
) -> jostle_status {
    guard("jostle_context_new", |_| {
        // SAFETY: the caller promises valid pointers (header: Nullable, Owns).
        let (out, options) = unsafe { (out_handle(context, "context")?, read_sized_or_default(options, "options")?) };
        if options.threads > MAX_THREADS {
            return Err(Failure::argument("options.threads", format!("is {}; at most {MAX_THREADS}", options.threads)));
        }
        let log = Log { mask: options.log_mask, callback: options.log_callback, user: options.log_user };
        out.give(Context { log: Arc::new(log), threads: options.threads })
    })
}

/// Frees a context. Objects made from it stay usable until they are freed themselves.
///
/// Thread: any.
/// RT: no.
/// Nullable: context (does nothing).
/// Owns: the handle is dead afterwards.
/// Errors: none returned; a dead handle leaves a message in jostle_last_error().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_context_free(context: *mut jostle_context) {
    free::<Context>("jostle_context_free", context, "context", false);
}
