//! The bugs that a reference A3M60 can be told to have.

use crate::tables::{self, Table};

/// By the seam at which they are switched on.
pub(super) static BUGS: &[Table] = &[
    Table::Only(tables::handshakes::BUGS, HANDSHAKES),
    Table::Only(tables::presets::BUGS, PRESETS),
    Table::Only(tables::presets::OTHERS, PRESETS_OTHERS),
    Table::Only(tables::slave::BUGS, SLAVE),
];

const HANDSHAKES: &[&str] = &[
    "parking-ignored",
    "park-never-ends",
    "errors-while-parked",
    "parked-bit-never-set",
    "parked-bit-is-a-pulse",
    "transfer-goes-on-while-parked",
    "error-without-code",
    "acknowledgement-ignored",
    "acknowledge-clears-persistent",
    "error-bit-one-frame-late",
    "acknowledge-without-answer",
    "acknowledge-answer-stays",
    "acknowledge-stops-transfer",
    "stw2-bit-7-acknowledges",
    "error-needs-request",
];

const PRESETS: &[&str] = &[
    "relative-preset-assigns",
    "preset-repeats-while-requested",
    "preset-never-acknowledged",
    "preset-acknowledge-stays",
    "preset-mode-alone-shifts",
    "writing-preset-value-presets",
    "preset-without-class-4",
    "position-not-reduced",
    "offset-only-at-standstill",
    "highest-position-wraps",
    "parking-clears-offset",
];

const PRESETS_OTHERS: &[&str] = &["preset-control-ignored", "read-gives-the-offset", "trigger-works-once"];

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
