//! Messages to the host: silent unless asked for, never to stdout, stderr or a file.

use std::ffi::{CString, c_char, c_void};

/// A call failed.
pub const JOSTLE_LOG_ERROR: u32 = 1;
/// Something is unusual and probably not meant.
pub const JOSTLE_LOG_WARNING: u32 = 2;
/// What was done, a line per decision.
pub const JOSTLE_LOG_INFO: u32 = 4;
/// Every message.
pub const JOSTLE_LOG_ALL: u32 = 0xffff_ffff;

/// One message of the library. Made by the library, valid during the callback.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct jostle_log_message {
    /// Size of the struct as the library knows it; later versions append.
    pub struct_size: u32,
    /// One of JOSTLE_LOG_ERROR, JOSTLE_LOG_WARNING, JOSTLE_LOG_INFO.
    pub level: u32,
    /// The function of the API that the message comes from.
    pub function: *const c_char,
    /// UTF-8.
    pub text: *const c_char,
}

/// Receives messages. It may be called from every thread that calls the library and from jobs' threads, from several
/// at once; no lock is held. It must not throw or longjmp.
pub type jostle_log_callback = Option<unsafe extern "C" fn(message: *const jostle_log_message, user: *mut c_void)>;

/// Where a context's messages go.
pub(super) struct Log {
    pub mask: u32,
    pub callback: jostle_log_callback,
    pub user: *mut c_void,
}

// SAFETY: the host promises that the callback may be called from any thread with `user` (see `jostle_log_callback`).
unsafe impl Send for Log {}
// SAFETY: as above.
unsafe impl Sync for Log {}

impl Log {
    /// Says nothing.
    #[cfg(test)]
    pub fn silent() -> std::sync::Arc<Log> {
        std::sync::Arc::new(Log { mask: 0, callback: None, user: std::ptr::null_mut() })
    }

    pub fn emit(&self, level: u32, function: &str, text: &str) {
        let Some(callback) = self.callback else { return };
        if self.mask & level == 0 {
            return;
        }
        let clean = |text: &str| CString::new(text.replace('\0', "?")).unwrap_or_default();
        let (function, text) = (clean(function), clean(text));
        let message = jostle_log_message {
            struct_size: size_of::<jostle_log_message>() as u32,
            level,
            function: function.as_ptr(),
            text: text.as_ptr(),
        };
        // SAFETY: the host gave the callback for this; the message lives until it returns.
        unsafe { callback(&message, self.user) };
    }
}
