//! The engine: runs trials against a device under test and judges them.
//!
//! It drives our controllers and the stand, and looks at nothing but the frames on the wire. It must not know which kind of
//! wire that is ([`segment`]), nor how its results are shown.

mod access;
mod block;
pub mod dut;
mod evidence;
mod expect;
mod failure;
mod looks;
mod outputs;
mod requirements;
mod run;
mod scan;
pub mod segment;
mod settings;
mod startup;
mod trial;
mod verbs;
mod world;

pub use dut::{DutKind, DutSpec, Nobody};
pub use run::{BenchError, Progress, RuleSeen, RunOptions, TrialOutcome, run, run_trial, selects};
