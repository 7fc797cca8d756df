//! The bugs that a plain device can be told to have.

use crate::tables::{self, Table};

/// Every bug that a plain device can be told to have.
pub(super) static BUGS: &[Table] =
    &[Table::Only(tables::stack::BUGS, BUGS_OF_THE_STACK), Table::All(tables::plain::BUGS)];

const BUGS_OF_THE_STACK: &[&str] = &[
    "name-prefix-answered",
    "any-name-answered",
    "type-of-station-empty",
    "mask-ignored",
    "temporary-name-kept",
    "reset-answered-and-not-done",
    "signal-refused",
    "neighbours-not-told",
    "ident-not-checked",
    "module-difference-not-reported",
    "output-length-not-checked",
    "input-length-not-checked",
    "other-frame-id",
    "second-controller-served",
    "good-inputs-before-ready",
    "consumer-status-always-bad",
    "bad-outputs-taken",
    "outputs-not-watched",
    "watch-too-short",
    "watch-too-long",
    "cycle-counter-stands-still",
    "outputs-of-anybody",
    "im0-length-counts-header",
    "im1-not-kept",
    "records-not-cut",
    "unknown-index-answered",
    "unknown-index-written",
    "plugged-not-told",
    "place-not-checked",
    "read-only-record-written",
    "one-error-for-all",
    "pending-diagnosis-not-told",
    "released-connection-kept",
    "aborted-connection-kept",
    "damaged-dcp-ends-connection",
    "damaged-call-ends-connection",
    "short-frame-ends-connection",
    "any-endpoint-ends-connection",
];
