//! The engine runs trials against a device under test and judges them.
//!
//! It drives the controllers of the harness and the stand, and judges only the frames on the wire. It must not know which kind of
//! wire that is ([`segment`]), nor how its results are reported.

#![allow(missing_docs, reason = "an internal crate; names that say everything have no sentence")]

mod around;
mod block;
mod bus;
pub mod dut;
mod evidence;
mod expect;
pub mod live;
pub mod needs;
mod one_trial;
mod options;
mod ours;
mod outcome;
mod outputs;
mod persona;
mod place;
mod plan;
mod profibus;
mod profinet;
pub mod reborn;
mod record;
mod requirements;
mod run;
pub mod segment;
mod trial;
mod world;

pub use around::{looked_after, put_back};
pub use dut::{DutKind, DutSpec, Nobody};
pub use live::{Excluded, Kept, LiveDevice, SharedLiveDevice};
pub use one_trial::{line, run_trial, run_trial_on};
pub use options::{Part, Progress, RunOptions, selects};
pub use ours::Ours;
pub use outcome::{BenchError, RuleSeen, TrialOutcome};
pub use place::{DpLine, Place};
pub use profibus::{ISOCHRONOUS_GROUP, isochronous_times};
pub use profinet::lay_over;
pub use run::run;
pub use suite::scan;
