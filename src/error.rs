//! The one error type of the library.
//!
//! Every message names the field (with its index where there is one), says what is wrong and what to change.
//! Outcomes of planning (infeasible, budget used up, cancelled) are not errors: see `plan::Outcome`.

use std::path::PathBuf;

/// What can go wrong at the library's boundary.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A value that cannot be used: not finite, out of range, degenerate, inconsistent.
    #[error("{field}: {reason}")]
    Argument { field: String, reason: String },
    /// A name or an index that does not exist.
    #[error("{field}: {reason}")]
    NotFound { field: String, reason: String },
    /// The object is not in a state that allows the call.
    #[error("{0}")]
    State(String),
    /// This build, or this combination of options, cannot do it; the message says how to get it.
    #[error("{0}")]
    Unsupported(String),
    /// A file could not be read or written.
    #[error("{}: {reason}", path.display())]
    Io { path: PathBuf, reason: String },
    /// A file was read but does not say what it should.
    #[error("{}: {reason}", path.display())]
    Format { path: PathBuf, reason: String },
    /// The memory budget does not suffice.
    #[error("{0}")]
    Memory(String),
    /// A defect of the library itself, caught before it reached the host.
    #[error("internal error: {0}")]
    Internal(String),
}

/// The library's result type.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// A value that cannot be used. `field` is the path of the option as the user wrote it.
    pub fn argument(field: impl Into<String>, reason: impl Into<String>) -> Self {
        Error::Argument { field: field.into(), reason: reason.into() }
    }

    /// A name or an index that does not exist.
    pub fn not_found(field: impl Into<String>, reason: impl Into<String>) -> Self {
        Error::NotFound { field: field.into(), reason: reason.into() }
    }

    /// A file that could not be read or written.
    pub fn io(path: impl Into<PathBuf>, reason: impl std::fmt::Display) -> Self {
        Error::Io { path: path.into(), reason: reason.to_string() }
    }

    /// A file that does not say what it should.
    pub fn format(path: impl Into<PathBuf>, reason: impl std::fmt::Display) -> Self {
        Error::Format { path: path.into(), reason: reason.to_string() }
    }

    /// Puts `prefix` before the field, so that a nested check names the whole path.
    #[must_use]
    pub fn within(self, prefix: &str) -> Self {
        match self {
            Error::Argument { field, reason } => Error::Argument { field: format!("{prefix}.{field}"), reason },
            Error::NotFound { field, reason } => Error::NotFound { field: format!("{prefix}.{field}"), reason },
            other => other,
        }
    }
}

/// Refuses a number that is not finite or not in `range`.
pub fn check_range(field: &str, value: f64, range: std::ops::RangeInclusive<f64>) -> Result<()> {
    if !value.is_finite() {
        return Err(Error::argument(field, format!("is {value}; it must be a finite number")));
    }
    if !range.contains(&value) {
        return Err(Error::argument(field, format!("is {value}; it must lie in {}..={}", range.start(), range.end())));
    }
    Ok(())
}

/// Refuses a number that is not finite or not greater than zero.
pub fn check_positive(field: &str, value: f64) -> Result<()> {
    if !value.is_finite() {
        return Err(Error::argument(field, format!("is {value}; it must be a finite number")));
    }
    if value <= 0.0 {
        return Err(Error::argument(field, format!("is {value}; it must be greater than 0")));
    }
    Ok(())
}
