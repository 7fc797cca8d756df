//! The PROFIBUS DP master.
//!
//! A [`ProfibusMaster`] accepts one [`MasterRequest`] at a time and returns one [`MasterOutcome`] for it. It waits for the token, or claims it on a
//! bus without one, passes it on, and searches for other masters. While a [`SlaveConfig`] runs it exchanges data with its slave
//! each cycle, reads the diagnosis when an answer of high priority signals one, and sends the clock of isochronous mode. It does
//! not report what the slave does: observers read that from the frames. Source: IEC 61158-4-3 and IEC 61158-6-3.

mod access;
mod acyclic;
mod broken;
mod connection;
mod exchange;
mod holding;
mod job;
mod live_timing;
mod master;
mod medium;
mod message;
mod ms2;
mod ms2_outcome;
mod ms2_state;
mod outcome;
mod repetition;
mod request;
mod ring;
mod settings;
mod startup;

pub use connection::{ClearOutputs, IsoModeClock, SlaveConfig, StartUpService};
pub use live_timing::LiveBusTiming;
pub use master::ProfibusMaster;
pub use ms2_outcome::{Ms2End, Ms2Opened, Ms2Outcome};
pub use outcome::{
    AcyclicError, ConnectionState, DataLinkAnswer, DpParameterOutcome, DpRecordOutcome, MasterOutcome, RepeatedAnswers,
    SlaveConnectionEnd, SlaveFailureReason, SlaveReleaseOutcome, SlaveStartUpFailure, SlaveStartUpResult,
    SlaveStartUpStage,
};
pub use request::{DamagedDpFrame, MasterBusy, MasterRequest, Ms2Parameters, Ms2Service, broken_frames};
pub use settings::MasterSettings;

/// The slot of the outputs of a slave in [`CyclicOutputs`](crate::outputs::CyclicOutputs); a DP slave has one image.
pub const OUTPUT_SLOT: u16 = 1;
/// The subslot of the outputs of a slave in [`CyclicOutputs`](crate::outputs::CyclicOutputs).
pub const OUTPUT_SUBSLOT: u16 = 1;
