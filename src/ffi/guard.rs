//! What every function of the C API runs in: a panic becomes a status, a failure becomes the thread's last error and a
//! log message, nothing is printed, and the host's floating-point state is as it was.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, Once, RwLock, RwLockReadGuard, RwLockWriteGuard, TryLockError};

use super::handle::{self, Object, Pin};
use super::log::{JOSTLE_LOG_ERROR, Log};
use super::status::{Failure, JOSTLE_ERROR_PANIC, JOSTLE_OK, Outcome, jostle_status, set_last_error};
use crate::host::Standard;

/// Threads of the library are named so; panics on them are not printed.
pub(super) const THREAD_PREFIX: &str = "jostle";

thread_local! {
    /// Calls of the API that this thread is inside of.
    static DEPTH: Cell<u32> = const { Cell::new(0) };
}

struct Depth;

impl Depth {
    fn enter() -> Depth {
        let _ = DEPTH.try_with(|depth| depth.set(depth.get() + 1));
        Depth
    }
}

impl Drop for Depth {
    fn drop(&mut self) {
        let _ = DEPTH.try_with(|depth| depth.set(depth.get() - 1));
    }
}

/// Takes over the reporting of panics inside the library, once. Panics elsewhere (where this is a part of a larger
/// Rust program) go where they went before.
pub(super) fn install_hook() {
    static ONCE: Once = Once::new();
    // A thread that is panicking may not change the hook; the next call does.
    if ONCE.is_completed() || std::thread::panicking() {
        return;
    }
    ONCE.call_once(|| {
        let previous = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info: &PanicHookInfo<'_>| {
            let inside = DEPTH.try_with(Cell::get).unwrap_or(0) > 0;
            let thread = std::thread::current();
            let ours = inside || thread.name().is_some_and(|name| name.starts_with(THREAD_PREFIX));
            if !ours {
                previous(info);
            }
        }));
    });
}

/// The call in progress: opens handles and remembers whom to tell of a failure.
pub(super) struct Call {
    log: Option<Arc<Log>>,
}

impl Call {
    /// The object of a handle. The first one's log receives the call's failure.
    pub fn open<T: Object>(&mut self, handle: *const T::Handle, field: &str) -> Outcome<Pin<T>> {
        let pin = handle::open::<T>(handle, field)?;
        if self.log.is_none() {
            self.log = Some(Arc::clone(pin.log()));
        }
        Ok(pin)
    }
}

/// Runs the body of an API function.
pub(super) fn guard(function: &'static str, body: impl FnOnce(&mut Call) -> Outcome) -> jostle_status {
    install_hook();
    // Plans do not depend on how the host rounds, and no operation traps within.
    let standard = Standard::enter();
    let depth = Depth::enter();
    let mut call = Call { log: None };
    let result = catch_unwind(AssertUnwindSafe(|| body(&mut call)));
    let failure = match result {
        Ok(Ok(())) => return JOSTLE_OK,
        Ok(Err(failure)) => failure,
        Err(panic) => Failure::new(JOSTLE_ERROR_PANIC, format!("internal error: {}", panic_text(&*panic))),
    };
    drop(depth);
    set_last_error(format_args!("{}", failure.message));
    if let Some(log) = call.log {
        drop(standard);
        log.emit(JOSTLE_LOG_ERROR, function, &failure.message);
        // The callback may have called the API.
        set_last_error(format_args!("{}", failure.message));
    }
    failure.status
}

/// Frees a handle; null does nothing.
pub(super) fn free<T: Object>(function: &'static str, handle: *mut T::Handle, field: &str, wait: bool) {
    if !handle.is_null() {
        guard(function, |_| handle::close::<T>(handle, field, wait));
    }
}

/// What a panic said.
pub(super) fn panic_text(panic: &(dyn Any + Send)) -> &str {
    panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("a panic without text")
}

/// Shared use of an object: any number at once, unless one has it for itself.
pub(super) fn read<'a, T>(lock: &'a RwLock<T>, field: &str) -> Outcome<RwLockReadGuard<'a, T>> {
    lock.try_read().map_err(|error| refusal(&error, field))
}

/// Exclusive use of an object. A panic during it poisons the object.
pub(super) fn write<'a, T>(lock: &'a RwLock<T>, field: &str) -> Outcome<RwLockWriteGuard<'a, T>> {
    lock.try_write().map_err(|error| refusal(&error, field))
}

/// Exclusive use of an object that has no shared use.
pub(super) fn lock<'a, T>(mutex: &'a Mutex<T>, field: &str) -> Outcome<MutexGuard<'a, T>> {
    mutex.try_lock().map_err(|error| refusal(&error, field))
}

fn refusal<G>(error: &TryLockError<G>, field: &str) -> Failure {
    match error {
        TryLockError::WouldBlock => Failure::busy(field),
        TryLockError::Poisoned(_) => Failure::poisoned(field),
    }
}

#[cfg(test)]
mod tests {
    use std::ffi::{CStr, c_void};

    use super::super::log::{JOSTLE_LOG_ALL, jostle_log_message};
    use super::super::status::{JOSTLE_ERROR_BUSY, JOSTLE_ERROR_POISONED, jostle_last_error};
    use super::*;

    fn last() -> String {
        // SAFETY: never null, ended by a zero.
        unsafe { CStr::from_ptr(jostle_last_error()) }.to_str().unwrap().to_string()
    }

    #[test]
    fn a_panic_becomes_a_status_and_poisons_what_was_being_changed() {
        install_hook();
        let object = RwLock::new(1);
        let status = guard("f", |_| {
            let mut changing = write(&object, "object")?;
            *changing = 2;
            panic!("boom {}", 3)
        });
        assert_eq!((status, last().as_str()), (JOSTLE_ERROR_PANIC, "internal error: boom 3"));
        assert_eq!(guard("f", |_| read(&object, "object").map(drop)), JOSTLE_ERROR_POISONED);
        assert!(last().starts_with("object: was left unfinished"));
        // Reading poisons nothing.
        let object = RwLock::new(1);
        guard("f", |_| {
            let _shared = read(&object, "object")?;
            panic!("boom")
        });
        assert_eq!(guard("f", |_| write(&object, "object").map(drop)), JOSTLE_OK);
    }

    #[test]
    fn exclusive_use_is_refused_while_shared() {
        let object = RwLock::new(1);
        let _shared = object.read().unwrap();
        assert_eq!(guard("f", |_| read(&object, "o").map(drop)), JOSTLE_OK);
        assert_eq!(guard("f", |_| write(&object, "o").map(drop)), JOSTLE_ERROR_BUSY);
        assert_eq!(last(), "o: is in use by another call");
    }

    #[test]
    fn a_failure_is_logged_with_its_function() {
        unsafe extern "C" fn keep(message: *const jostle_log_message, user: *mut c_void) {
            // SAFETY: the test passes a Vec, the library a valid message.
            unsafe {
                let (m, seen) = (&*message, &mut *user.cast::<Vec<String>>());
                let text = |p| CStr::from_ptr(p).to_str().unwrap().to_string();
                seen.push(format!("{} {} {}", m.level, text(m.function), text(m.text)));
            }
            // A failing call from within the callback does not hide the message.
            guard("inner", |_| Err(Failure::null("inner")));
        }
        let mut seen: Vec<String> = Vec::new();
        let log = Arc::new(Log { mask: JOSTLE_LOG_ALL, callback: Some(keep), user: (&raw mut seen).cast() });
        let status = guard("jostle_f", |call| {
            call.log = Some(log.clone());
            Err(Failure::null("thing"))
        });
        assert_eq!((status, last().as_str()), (-1, "thing: is null"));
        assert_eq!(seen, ["1 jostle_f thing: is null"]);
    }
}
