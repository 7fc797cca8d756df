//! That a bench cannot be used, and why: the error of all that looks at a bench before it is tested on.

/// Why a bench cannot be used, in one sentence that says what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Unusable(pub String);

impl From<link::LinkError> for Unusable {
    fn from(error: link::LinkError) -> Unusable {
        Unusable(error.to_string())
    }
}

/// What was asked for, or why the bench cannot be used.
pub(super) type Ready<T> = Result<T, Unusable>;

/// The bench cannot be used.
pub(super) fn unusable<T>(why: impl Into<String>) -> Ready<T> {
    Err(Unusable(why.into()))
}
