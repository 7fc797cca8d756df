//! Why a link is of no use.

use thiserror::Error;

/// Why a link cannot be used; each is one sentence that says where, what, and what to do.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LinkError {
    /// It cannot be opened: absent, down, or without the privilege.
    #[error("{0}")]
    Unusable(String),
    /// It was open and is lost: the peer has closed, the interface has vanished or was taken down.
    #[error("{0}")]
    Gone(String),
}

impl LinkError {
    /// Whether the link was open before, so that [`recover`](crate::Port::recover) may bring it back.
    pub fn is_gone(&self) -> bool {
        matches!(self, LinkError::Gone(_))
    }
}
