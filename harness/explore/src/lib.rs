//! Random sequences of steps for a device, made from a seed and what its manual names.
//!
//! `names` collects the names and values of a manual, `sequence` draws activities from them, `schedule` puts these in order
//! and makes steps of them, and [`topic`] writes sequences as a topic file. A sequence expects nothing: only rules judge the device. This
//! crate must not run anything.

#![allow(missing_docs, reason = "an internal crate; names that say everything have no sentence")]

mod activity;
mod draw;
mod names;
mod schedule;
mod sequence;
mod stand;
pub mod topic;

pub use sequence::{SequencePart, SequenceSource};
