//! What a run found, what it excuses, and what a bench file says: plain data that engines fill and reports read.
//!
//! Nothing here is computed while reporting. This crate must not know frames, engines, links or how anything is shown.

pub mod bench_file;
pub mod journal;
pub mod ledger;
pub mod outcome;
pub mod verdict;
