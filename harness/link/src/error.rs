//! The errors of links.

use thiserror::Error;

/// Why a link cannot be used. The text is one sentence: where, what happened, and what to do.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LinkError {
    /// The link cannot be opened: it is absent or down, or the process lacks the privilege.
    #[error("{0}")]
    Unusable(String),
    /// The link was open and is lost: the peer closed it, or the interface was removed or taken down.
    #[error("{0}")]
    Gone(String),
}

impl LinkError {
    /// Whether the link was open before; [`recover`](crate::Port::recover) may then restore it.
    pub fn is_gone(&self) -> bool {
        matches!(self, LinkError::Gone(_))
    }
}
