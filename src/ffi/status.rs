//! Status codes, failures and the last error of a thread.

use std::cell::UnsafeCell;
use std::ffi::{CStr, c_char};
use std::fmt::{self, Write};

use crate::error::{Error, ModelFault};

/// What a call returns: 0 or one of the negative `JOSTLE_ERROR_` numbers. Numbers are never given a new meaning.
pub type jostle_status = i32;

/// Done.
pub const JOSTLE_OK: jostle_status = 0;
/// A value that cannot be used: null, not finite, out of range, degenerate, inconsistent.
pub const JOSTLE_ERROR_ARGUMENT: jostle_status = -1;
/// Not a live handle of the wanted type: freed already, or not made by this library.
pub const JOSTLE_ERROR_HANDLE: jostle_status = -2;
/// The object is not in a state that allows the call.
pub const JOSTLE_ERROR_STATE: jostle_status = -3;
/// Another call is using the object.
pub const JOSTLE_ERROR_BUSY: jostle_status = -4;
/// The buffer is too small; the needed count was written, nothing else.
pub const JOSTLE_ERROR_BUFFER: jostle_status = -5;
/// A name, an index or a body that does not exist.
pub const JOSTLE_ERROR_NOT_FOUND: jostle_status = -6;
/// This build, or this combination of options, cannot do it.
pub const JOSTLE_ERROR_UNSUPPORTED: jostle_status = -7;
/// A file could not be read or written.
pub const JOSTLE_ERROR_IO: jostle_status = -8;
/// A file or text was read but does not say what it should.
pub const JOSTLE_ERROR_FORMAT: jostle_status = -9;
/// A network could not be run: it or its runtime gave what no network of its kind may give.
pub const JOSTLE_ERROR_MODEL: jostle_status = -10;
/// The memory limit does not suffice.
pub const JOSTLE_ERROR_MEMORY: jostle_status = -11;
/// A callback broke its contract. (Kept; no call returns it yet.)
pub const JOSTLE_ERROR_CALLBACK: jostle_status = -12;
/// A defect of the library, caught before it reached the host. Objects that the call could change are poisoned.
pub const JOSTLE_ERROR_PANIC: jostle_status = -13;
/// An earlier call on this object ended in JOSTLE_ERROR_PANIC; it can only be freed.
pub const JOSTLE_ERROR_POISONED: jostle_status = -14;
/// Header and library, or a struct and the library, do not fit together.
pub const JOSTLE_ERROR_ABI: jostle_status = -15;
/// A network's file is empty.
pub const JOSTLE_ERROR_MODEL_EMPTY: jostle_status = -16;
/// A network's file is too big.
pub const JOSTLE_ERROR_MODEL_TOO_BIG: jostle_status = -17;
/// A network's file is a Git LFS pointer; fetch the file itself with `git lfs pull`.
pub const JOSTLE_ERROR_MODEL_LFS_POINTER: jostle_status = -18;
/// A network's file is no ONNX model, or is cut off.
pub const JOSTLE_ERROR_MODEL_PARSE: jostle_status = -19;
/// Nothing that runs networks was found, or it is too old; the message says where it was looked for.
pub const JOSTLE_ERROR_MODEL_RUNTIME: jostle_status = -20;
/// The runtime refuses the network; the message has its reason.
pub const JOSTLE_ERROR_MODEL_SESSION: jostle_status = -21;
/// A network's file is not the one that its SHA-256 names.
pub const JOSTLE_ERROR_MODEL_HASH: jostle_status = -22;
/// A network is of another kind than asked for, or does not say of which.
pub const JOSTLE_ERROR_MODEL_KIND: jostle_status = -23;
/// A network has an interface that this version does not know.
pub const JOSTLE_ERROR_MODEL_INTERFACE: jostle_status = -24;
/// An input or output of a network has another name, type or shape than its interface.
pub const JOSTLE_ERROR_MODEL_IO_MISMATCH: jostle_status = -25;
/// A network was made for another configuration: gripper, pixel, image size, angles.
pub const JOSTLE_ERROR_MODEL_SPEC_MISMATCH: jostle_status = -26;
/// A network does not give what it gave where it was exported.
pub const JOSTLE_ERROR_MODEL_SELFTEST: jostle_status = -27;
/// A network's weights are in another file; save it as one file.
pub const JOSTLE_ERROR_MODEL_EXTERNAL: jostle_status = -28;
/// A network has an operator that is not taken: one that controls the flow, or whose results may have any size.
pub const JOSTLE_ERROR_MODEL_OPERATOR: jostle_status = -29;
/// A network would need more memory or work than the limits in docs/networks.md allow, or how much cannot be told.
pub const JOSTLE_ERROR_MODEL_SIZE: jostle_status = -30;
/// Loading and testing a network took longer than the limit in docs/networks.md.
pub const JOSTLE_ERROR_MODEL_DEADLINE: jostle_status = -31;

/// Why a call failed.
#[derive(Debug)]
pub(super) struct Failure {
    pub status: jostle_status,
    pub message: String,
}

pub(super) type Outcome<T = ()> = Result<T, Failure>;

impl Failure {
    pub fn new(status: jostle_status, message: impl Into<String>) -> Self {
        Failure { status, message: message.into() }
    }

    pub fn argument(field: &str, reason: impl fmt::Display) -> Self {
        Failure::new(JOSTLE_ERROR_ARGUMENT, format!("{field}: {reason}"))
    }

    pub fn null(field: &str) -> Self {
        Failure::argument(field, "is null")
    }

    pub fn busy(field: &str) -> Self {
        Failure::new(JOSTLE_ERROR_BUSY, format!("{field}: is in use by another call"))
    }

    pub fn poisoned(field: &str) -> Self {
        Failure::new(
            JOSTLE_ERROR_POISONED,
            format!("{field}: was left unfinished by an internal error; free it and make a new one"),
        )
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let status = match &error {
            Error::Argument { .. } => JOSTLE_ERROR_ARGUMENT,
            Error::NotFound { .. } => JOSTLE_ERROR_NOT_FOUND,
            Error::State(_) => JOSTLE_ERROR_STATE,
            Error::Unsupported(_) => JOSTLE_ERROR_UNSUPPORTED,
            Error::Io { .. } => JOSTLE_ERROR_IO,
            Error::Format { .. } => JOSTLE_ERROR_FORMAT,
            Error::Memory(_) => JOSTLE_ERROR_MEMORY,
            Error::Runtime(_) => JOSTLE_ERROR_MODEL_RUNTIME,
            Error::Model { fault, .. } => match fault {
                ModelFault::Missing => JOSTLE_ERROR_NOT_FOUND,
                ModelFault::Empty => JOSTLE_ERROR_MODEL_EMPTY,
                ModelFault::TooBig => JOSTLE_ERROR_MODEL_TOO_BIG,
                ModelFault::LfsPointer => JOSTLE_ERROR_MODEL_LFS_POINTER,
                ModelFault::NotOnnx => JOSTLE_ERROR_MODEL_PARSE,
                ModelFault::Session => JOSTLE_ERROR_MODEL_SESSION,
                ModelFault::Hash => JOSTLE_ERROR_MODEL_HASH,
                ModelFault::Kind => JOSTLE_ERROR_MODEL_KIND,
                ModelFault::Interface => JOSTLE_ERROR_MODEL_INTERFACE,
                ModelFault::Tensors => JOSTLE_ERROR_MODEL_IO_MISMATCH,
                ModelFault::Spec => JOSTLE_ERROR_MODEL_SPEC_MISMATCH,
                ModelFault::SelfTest => JOSTLE_ERROR_MODEL_SELFTEST,
                ModelFault::Run => JOSTLE_ERROR_MODEL,
                ModelFault::External => JOSTLE_ERROR_MODEL_EXTERNAL,
                ModelFault::Operator => JOSTLE_ERROR_MODEL_OPERATOR,
                ModelFault::Size => JOSTLE_ERROR_MODEL_SIZE,
                ModelFault::Deadline => JOSTLE_ERROR_MODEL_DEADLINE,
            },
            Error::Internal(_) => JOSTLE_ERROR_PANIC,
        };
        Failure { status, message: error.to_string() }
    }
}

const CAPACITY: usize = 1024;

/// A thread's last message: fixed memory without a destructor, so that neither a thread's end nor unloading matters.
struct LastError(UnsafeCell<[u8; CAPACITY]>);

thread_local! {
    static LAST: LastError = const { LastError(UnsafeCell::new([0; CAPACITY])) };
}

/// Writes text into fixed memory, cut at the end between characters, and always ends it with a zero.
struct Fixed<'a> {
    bytes: &'a mut [u8; CAPACITY],
    length: usize,
}

impl Write for Fixed<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let mut take = text.len().min(CAPACITY - 1 - self.length);
        while !text.is_char_boundary(take) {
            take -= 1;
        }
        for &byte in &text.as_bytes()[..take] {
            // A zero within the text would end it early.
            self.bytes[self.length] = if byte == 0 { b'?' } else { byte };
            self.length += 1;
        }
        Ok(())
    }
}

/// Keeps `message` as the thread's last error.
pub(super) fn set_last_error(message: fmt::Arguments<'_>) {
    // During a thread's end there is nobody left to read it.
    let _ = LAST.try_with(|last| {
        // SAFETY: only this thread reaches its buffer, and no reference to it outlives this closure.
        let bytes = unsafe { &mut *last.0.get() };
        let mut fixed = Fixed { bytes, length: 0 };
        let _ = fixed.write_fmt(message);
        let end = fixed.length;
        bytes[end] = 0;
    });
}

/// The message of the last call that failed on this thread: which field, what is wrong, what to change.
/// Empty if none has failed. It says something only just after a failure; later failures overwrite it.
///
/// Thread: any; every thread has its own message.
/// RT: yes.
/// Nullable: never returns null.
/// Owns: the library; valid until the thread's next failing call or its end.
/// Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn jostle_last_error() -> *const c_char {
    LAST.try_with(|last| last.0.get() as *const c_char).unwrap_or(c"".as_ptr())
}

/// The name of a status, such as "JOSTLE_ERROR_BUSY"; "unknown status" for other numbers.
///
/// Thread: any.
/// RT: yes.
/// Nullable: never returns null.
/// Owns: the library, for ever.
/// Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn jostle_status_name(status: jostle_status) -> *const c_char {
    let name: &'static CStr = match status {
        JOSTLE_OK => c"JOSTLE_OK",
        JOSTLE_ERROR_ARGUMENT => c"JOSTLE_ERROR_ARGUMENT",
        JOSTLE_ERROR_HANDLE => c"JOSTLE_ERROR_HANDLE",
        JOSTLE_ERROR_STATE => c"JOSTLE_ERROR_STATE",
        JOSTLE_ERROR_BUSY => c"JOSTLE_ERROR_BUSY",
        JOSTLE_ERROR_BUFFER => c"JOSTLE_ERROR_BUFFER",
        JOSTLE_ERROR_NOT_FOUND => c"JOSTLE_ERROR_NOT_FOUND",
        JOSTLE_ERROR_UNSUPPORTED => c"JOSTLE_ERROR_UNSUPPORTED",
        JOSTLE_ERROR_IO => c"JOSTLE_ERROR_IO",
        JOSTLE_ERROR_FORMAT => c"JOSTLE_ERROR_FORMAT",
        JOSTLE_ERROR_MODEL => c"JOSTLE_ERROR_MODEL",
        JOSTLE_ERROR_MEMORY => c"JOSTLE_ERROR_MEMORY",
        JOSTLE_ERROR_CALLBACK => c"JOSTLE_ERROR_CALLBACK",
        JOSTLE_ERROR_PANIC => c"JOSTLE_ERROR_PANIC",
        JOSTLE_ERROR_POISONED => c"JOSTLE_ERROR_POISONED",
        JOSTLE_ERROR_ABI => c"JOSTLE_ERROR_ABI",
        JOSTLE_ERROR_MODEL_EMPTY => c"JOSTLE_ERROR_MODEL_EMPTY",
        JOSTLE_ERROR_MODEL_TOO_BIG => c"JOSTLE_ERROR_MODEL_TOO_BIG",
        JOSTLE_ERROR_MODEL_LFS_POINTER => c"JOSTLE_ERROR_MODEL_LFS_POINTER",
        JOSTLE_ERROR_MODEL_PARSE => c"JOSTLE_ERROR_MODEL_PARSE",
        JOSTLE_ERROR_MODEL_RUNTIME => c"JOSTLE_ERROR_MODEL_RUNTIME",
        JOSTLE_ERROR_MODEL_SESSION => c"JOSTLE_ERROR_MODEL_SESSION",
        JOSTLE_ERROR_MODEL_HASH => c"JOSTLE_ERROR_MODEL_HASH",
        JOSTLE_ERROR_MODEL_KIND => c"JOSTLE_ERROR_MODEL_KIND",
        JOSTLE_ERROR_MODEL_INTERFACE => c"JOSTLE_ERROR_MODEL_INTERFACE",
        JOSTLE_ERROR_MODEL_IO_MISMATCH => c"JOSTLE_ERROR_MODEL_IO_MISMATCH",
        JOSTLE_ERROR_MODEL_SPEC_MISMATCH => c"JOSTLE_ERROR_MODEL_SPEC_MISMATCH",
        JOSTLE_ERROR_MODEL_SELFTEST => c"JOSTLE_ERROR_MODEL_SELFTEST",
        JOSTLE_ERROR_MODEL_EXTERNAL => c"JOSTLE_ERROR_MODEL_EXTERNAL",
        JOSTLE_ERROR_MODEL_OPERATOR => c"JOSTLE_ERROR_MODEL_OPERATOR",
        JOSTLE_ERROR_MODEL_SIZE => c"JOSTLE_ERROR_MODEL_SIZE",
        JOSTLE_ERROR_MODEL_DEADLINE => c"JOSTLE_ERROR_MODEL_DEADLINE",
        _ => c"unknown status",
    };
    name.as_ptr()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn last() -> String {
        // SAFETY: the pointer is never null and the text ends with a zero.
        unsafe { CStr::from_ptr(jostle_last_error()) }.to_str().unwrap().to_string()
    }

    #[test]
    fn a_message_is_cut_between_characters_and_holds_no_zero() {
        set_last_error(format_args!("a\0b"));
        assert_eq!(last(), "a?b");
        set_last_error(format_args!("{}", "\u{e9}".repeat(2000)));
        assert_eq!(last().chars().count(), (CAPACITY - 1) / 2);
        set_last_error(format_args!("short"));
        assert_eq!(last(), "short");
        std::thread::spawn(|| assert_eq!(last(), "")).join().unwrap();
    }

    #[test]
    fn every_error_has_a_status_and_every_status_a_name() {
        assert_eq!(Failure::from(Error::argument("a", "b")).message, "a: b");
        for status in -31..=0 {
            // SAFETY: the names are literals.
            let name = unsafe { CStr::from_ptr(jostle_status_name(status)) };
            assert!(name.to_str().unwrap().starts_with("JOSTLE_"), "{status}");
        }
    }
}
