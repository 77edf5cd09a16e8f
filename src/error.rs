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
    /// A network's file was refused by a check, or the network gave what no network of its kind may give.
    #[error("{}: {fault}: expected {expected}; found {found}", path.display())]
    Model { path: PathBuf, fault: ModelFault, expected: String, found: String },
    /// Nothing that runs networks was found, or it cannot be used; the message says what was tried and how to get it.
    #[error("{0}")]
    Runtime(String),
    /// The memory budget does not suffice.
    #[error("{0}")]
    Memory(String),
    /// A defect of the library itself, caught before it reached the host.
    #[error("internal error: {0}")]
    Internal(String),
}

/// What is wrong with a network, in the order in which it is checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum ModelFault {
    #[error("there is no such file")]
    Missing,
    #[error("the file is empty")]
    Empty,
    #[error("the file is too big")]
    TooBig,
    #[error("the file is a Git LFS pointer, not the network itself")]
    LfsPointer,
    #[error("the file is no ONNX model, or is cut off")]
    NotOnnx,
    #[error("the SHA-256 differs")]
    Hash,
    #[error("the weights are in another file")]
    External,
    #[error("an operator is not taken")]
    Operator,
    #[error("the network is of another kind")]
    Kind,
    #[error("the network has another interface")]
    Interface,
    #[error("an input or output differs")]
    Tensors,
    #[error("the network was made for another configuration")]
    Spec,
    #[error("the network becomes too big, or how big cannot be told")]
    Size,
    #[error("the runtime refuses the network")]
    Session,
    #[error("the time for loading and testing the network was used up")]
    Deadline,
    #[error("the self-test failed")]
    SelfTest,
    #[error("running the network failed")]
    Run,
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

    /// A network that a check refuses.
    pub fn model(
        path: impl Into<PathBuf>,
        fault: ModelFault,
        expected: impl std::fmt::Display,
        found: impl std::fmt::Display,
    ) -> Self {
        Error::Model { path: path.into(), fault, expected: expected.to_string(), found: found.to_string() }
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

/// Room for `more` values in memory whose size a user's input decides; `what` names it.
pub fn reserve<T>(list: &mut Vec<T>, more: usize, what: &str) -> Result<()> {
    list.try_reserve(more).map_err(|_| {
        let bytes = more.saturating_mul(size_of::<T>());
        Error::Memory(format!("{what}: takes {bytes} bytes of memory, which the system does not give"))
    })
}

/// Refuses a number that is not finite or not in `range`.
pub fn check_range(field: &str, value: f64, range: std::ops::RangeInclusive<f64>) -> Result<()> {
    if !value.is_finite() {
        return Err(Error::argument(field, format!("is {value}; it must be a finite number")));
    }
    if !range.contains(&value) {
        return Err(Error::argument(field, format!("is {value}; it must lie in {} to {}", range.start(), range.end())));
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
