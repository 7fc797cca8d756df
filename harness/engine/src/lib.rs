//! The engine runs trials against a device under test and judges them.
//!
//! It drives the controllers of the harness and the stand, and judges only the frames on the wire. It must not know which kind of
//! wire that is ([`segment`]), nor how its results are reported.

#![allow(missing_docs, reason = "an internal crate; names that say everything have no sentence")]

mod block;
mod bus;
mod causes;
mod described;
pub mod dut;
mod environment;
mod evidence;
pub mod exchangeable_device;
mod expect;
mod likely_reading;
pub mod live;
mod live_run;
pub mod needs;
mod one_trial;
mod options;
mod outcome;
mod outputs;
mod persona;
mod plan;
mod profibus;
mod profinet;
mod record;
mod requirements;
mod run;
pub mod segment;
mod selection;
mod stations;
pub mod step_log;
mod trial;
mod world;

pub use causes::causes;
pub use described::described;
pub use dut::{DutKind, DutSpec, NullPeer};
pub use environment::{DpLine, TrialEnvironment};
pub use live::{
    DeviceBackup, LiveDevice, RestoreOutcome, SequenceLimits, SharedLiveDevice, TrialExclusion, VirtualStart,
};
pub use live_run::{
    identify_live_variant, note_restored, restore_device, sensor_format, variant_readings, with_claimed_device,
    with_restored_device,
};
pub use one_trial::{dp_line, run_trial, run_trial_on};
pub use options::{FailFast, RunOptions, RunProgress, STALL_REPEATS, TrialPart};
pub use outcome::{BenchError, Disturbance, Stall, TrialOutcome, TrialRuleResult};
pub use profibus::{ISOCHRONOUS_GROUP, isochronous_times};
pub use profinet::{apply_persona, usual_connection};
pub use run::run;
pub use selection::{NotGreen, Selection};
pub use stations::HarnessStations;
pub use suite::scan;
