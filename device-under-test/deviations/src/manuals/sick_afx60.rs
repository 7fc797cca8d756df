//! The bugs that a reference AFS60 or AFM60 can be told to have.

use crate::tables::{self, Table};

/// By the seam at which they are switched on.
pub(super) static BUGS: &[Table] =
    &[Table::Only(tables::handshakes::BUGS, HANDSHAKES), Table::Only(tables::presets::BUGS, PRESETS)];

const HANDSHAKES: &[&str] = &[
    "parking-ignored",
    "park-never-ends",
    "transfer-goes-on-while-parked",
    "error-without-code",
    "position-before-error",
    "persistent-error-not-cyclic",
    "acknowledgement-ignored",
    "code-stays-after-acknowledgement",
    "acknowledge-clears-persistent",
    "acknowledge-without-answer",
    "acknowledge-answer-stays",
    "acknowledge-answer-without-request",
    "acknowledge-stops-transfer",
    "stw2-bit-7-acknowledges",
    "error-clears-itself",
    "error-needs-request",
];

const PRESETS: &[&str] = &[
    "relative-preset-assigns",
    "second-relative-preset-ignored",
    "relative-shift-reversed",
    "only-first-preset",
    "preset-in-hardware-steps",
    "preset-uses-stored-value",
    "preset-adds-instead-of-assigns",
    "preset-on-falling-edge",
    "preset-repeats-while-requested",
    "mode-change-repeats-preset",
    "preset-never-acknowledged",
    "preset-acknowledged-too-early",
    "preset-acknowledge-stays",
    "preset-mode-alone-shifts",
    "writing-preset-value-presets",
    "preset-on-both-edges",
    "preset-control-inverted",
    "preset-control-gates-all-positions",
    "preset-without-class-4",
    "position-not-reduced",
    "offset-only-at-standstill",
    "highest-position-wraps",
    "offset-sign-reversed",
];
