//! Results of a run, the ledger of known failures, and the bench file: plain data that the engine fills and reports read.
//!
//! This crate does not depend on frames, engines, links or report formats.

#![allow(missing_docs, reason = "internal crate: self-explanatory items need no comment")]

pub mod bench_file;
pub mod journal;
pub mod ledger;
pub mod merge;
pub mod outcome;
mod schema;
mod time_stamp;
pub mod verdict;

pub use schema::schema;
pub use time_stamp::time_stamp;
