//! The bugs that a reference A3M60 can be told to have.

use crate::tables::{self, Table};

/// By the seam at which they are switched on.
pub(super) static BUGS: &[Table] = &[Table::Only(tables::slave::BUGS, SLAVE)];

const SLAVE: &[&str] = &[
    "ident-not-checked",
    "watchdog-never-expires",
    "watchdog-in-milliseconds",
    "unlock-ignored",
    "second-master-takes-over",
    "new-parameters-need-power-off",
    "short-outputs-taken",
    "diagnosis-never-announced",
    "diagnosis-always-announced",
    "ready-before-parameters",
    "ext-diag-never-set",
    "fixed-bit-missing",
    "watchdog-never-shown",
    "watchdog-always-shown",
    "ident-swapped-in-exchange",
    "own-address-as-master",
    "acyclic-access-without-enable",
];
