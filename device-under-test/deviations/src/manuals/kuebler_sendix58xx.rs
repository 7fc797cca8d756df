//! The bugs that a reference Sendix can be told to have.

use crate::tables::Table;

/// By the seam at which they are switched on.
pub(super) static BUGS: &[Table] = &[];
