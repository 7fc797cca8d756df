//! The bugs that a reference Sendix can be told to have.

use crate::tables::{self, Table};

/// By the seam at which they are switched on.
pub(super) static BUGS: &[Table] = &[
    Table::Only(tables::handshakes::BUGS, HANDSHAKES),
    Table::All(tables::handshakes::OTHERS),
    Table::Only(tables::presets::BUGS, PRESETS),
    Table::All(tables::presets::OTHERS),
];

const HANDSHAKES: &[&str] = &[
    "parking-ignored",
    "park-never-ends",
    "parked-bit-never-set",
    "transfer-goes-on-while-parked",
    "error-without-code",
    "error-code-without-bit",
    "acknowledge-clears-persistent",
    "acknowledge-without-answer",
    "acknowledge-answer-stays",
    "acknowledge-answer-without-request",
    "acknowledge-stops-transfer",
];

const PRESETS: &[&str] = &[
    "relative-preset-assigns",
    "second-relative-preset-ignored",
    "relative-shift-reversed",
    "only-first-preset",
    "preset-in-hardware-steps",
    "preset-adds-instead-of-assigns",
    "preset-on-falling-edge",
    "preset-repeats-while-requested",
    "mode-change-repeats-preset",
    "preset-never-acknowledged",
    "preset-acknowledgement-is-a-pulse",
    "preset-acknowledged-too-early",
    "preset-acknowledge-stays",
    "preset-mode-alone-shifts",
    "writing-preset-value-presets",
    "preset-on-both-edges",
    "relative-preset-not-acknowledged",
    "preset-control-inverted",
    "preset-control-gates-all-positions",
    "preset-without-class-4",
    "position-not-reduced",
    "offset-only-at-standstill",
    "highest-position-wraps",
];
