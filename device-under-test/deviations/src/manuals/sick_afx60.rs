//! The bugs that a reference AFS60 or AFM60 can be told to have.

use crate::tables::Table;

/// By the seam at which they are switched on.
pub(super) static BUGS: &[Table] = &[];
