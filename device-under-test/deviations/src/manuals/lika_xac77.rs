//! The bugs that a reference XAC77 can be told to have.

use crate::tables::Table;

/// Every bug that a reference XAC77 can be told to have.
pub(super) static BUGS: &[Table] = &[];
