//! Random sequences of steps for a device, made from a seed and what its manual names.
//!
//! `names` collects the names and values of a manual, `sequence` draws activities from them, `schedule` puts these in order
//! and makes steps of them, and [`topic`] writes sequences as a topic file. A sequence expects nothing.
//!
//! [`mod@bench`] runs a sequence on a device and records what it does, [`difference`] compares that with the reference device, [`learn`]
//! finds the permitted variations that explain a difference, [`mod@minimise`] shortens the sequence, [`case`] writes it as a case, and
//! [`campaign`] does all of it until its limit.

#![allow(missing_docs, reason = "an internal crate; names that say everything have no sentence")]

mod activity;
pub mod bench;
pub mod campaign;
pub mod case;
mod described;
pub mod difference;
mod distance;
mod draw;
pub mod learn;
mod literal;
pub mod live_campaign;
mod live_steps;
pub mod minimise;
mod names;
mod requests;
mod retention;
mod schedule;
mod sequence;
pub mod sequence_log;
pub mod settled;
mod stand;
pub mod states;
pub mod step;
pub mod topic;

pub use sequence::{SequencePart, SequenceSource};
pub use step::SequenceStep;
