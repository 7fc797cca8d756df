//! The error of the preflight: a bench cannot be used, and why.

/// Why a bench cannot be used, in one sentence that says what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Unusable(pub String);

impl From<link::LinkError> for Unusable {
    fn from(error: link::LinkError) -> Unusable {
        Unusable(error.to_string())
    }
}

/// The result, or why the bench cannot be used.
pub(super) type PreflightResult<T> = Result<T, Unusable>;

/// Returns an error with this reason.
pub(super) fn unusable<T>(why: impl Into<String>) -> PreflightResult<T> {
    Err(Unusable(why.into()))
}
