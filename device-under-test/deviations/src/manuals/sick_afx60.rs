//! The bugs that a reference AFS60 or AFM60 can be told to have.

use crate::tables::{self, Table};

/// By the seam at which they are switched on.
pub(super) static BUGS: &[Table] = &[
    Table::Only(tables::handshakes::BUGS, HANDSHAKES),
    Table::Only(tables::measuring::BUGS, MEASURING),
    Table::Only(tables::memory::BUGS, MEMORY),
    Table::Only(tables::presets::BUGS, PRESETS),
    Table::Only(tables::reset::BUGS, RESET),
    Table::Only(tables::velocity::BUGS, VELOCITY),
];

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

const MEASURING: &[&str] = &[
    "position-counts-from-zero",
    "revolution-of-13-bits",
    "extended-counter",
    "position-before-parking-shown",
    "only-xist1-scaled",
    "code-sequence-on-xist1-only",
    "range-ignored",
    "range-one-too-long",
    "unit-of-whole-steps",
    "jump-at-every-zero",
];

const MEMORY: &[&str] = &[
    "offset-only-in-ram",
    "relative-preset-not-stored",
    "offset-used-up",
    "offset-from-preset-value",
    "position-restored-from-memory",
    "every-write-is-stored",
    "p971-takes-any-value",
    "p971-confirms-too-early",
    "save-never-ends",
    "only-first-save",
    "save-restores-old-offset",
    "name-lost-at-power-off",
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

const RESET: &[&str] =
    &["reset-keeps-preset-value", "reset-keeps-offset-unseen", "reset-keeps-name", "reset-gives-a-name"];

const VELOCITY: &[&str] = &[
    "speed-per-minute",
    "speed-units-exchanged",
    "rpm-from-scaled-steps",
    "speed-in-hardware-steps",
    "speed-held-at-standstill",
    "speed-modulo-a-revolution",
    "preset-shows-as-speed",
    "wrap-shows-as-speed",
    "speed-without-sign",
    "speed-ignores-code-sequence",
    "speed-overflows",
];
