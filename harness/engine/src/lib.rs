//! The engine: runs trials against a device under test and judges them.
//!
//! It drives our controllers and the stand, and looks at nothing but the frames on the wire. It must not know which kind of
//! wire that is ([`segment`]), nor how its results are shown.

mod access;
mod around;
mod block;
mod driver;
pub mod dut;
mod evidence;
mod expect;
mod failure;
pub mod live;
mod looks;
pub mod needs;
mod ours;
mod outputs;
pub mod persona;
mod plan;
mod probe;
mod profibus;
mod profinet;
pub mod reborn;
mod requirements;
mod run;
pub mod segment;
mod settings;
mod startup;
mod station;
mod trial;
mod verbs;
mod web;
mod world;

pub use around::{looked_after, put_back};
pub use dut::{DutKind, DutSpec, Nobody};
pub use live::{Excluded, LiveDevice, SharedLiveDevice};
pub use ours::Ours;
pub use probe::Kept;
pub use profibus::{ISOCHRONOUS_GROUP, isochronous_times};
pub use run::{
    BenchError, Part, Progress, RuleSeen, RunOptions, TrialOutcome, line, run, run_trial, run_trial_on, selects,
};
pub use suite::scan;
pub use trial::{DpLine, Place};
