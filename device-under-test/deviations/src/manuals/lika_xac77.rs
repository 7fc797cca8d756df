//! The bugs that a reference XAC77 can be told to have.

use crate::tables::{self, Table};

/// Every bug that a reference XAC77 can be told to have.
pub(super) static BUGS: &[Table] = &[Table::All(tables::handshakes::BUGS), Table::All(tables::presets::BUGS)];
