//! The PROFIBUS DP master.
//!
//! A [`Master`] accepts one [`Request`] at a time and returns one [`Outcome`] for it. It waits for the token, or claims it on a
//! bus without one, passes it on, and searches for other masters. While a [`Connection`] runs it exchanges data with its slave
//! each cycle, reads the diagnosis when an answer of high priority signals one, and sends the clock of isochronous mode. It does
//! not report what the slave does: observers read that from the frames. Source: IEC 61158-4-3 and IEC 61158-6-3.

mod access;
mod acyclic;
mod broken;
mod connection;
mod exchange;
mod job;
mod master;
mod medium;
mod message;
mod outcome;
mod pace;
mod request;
mod ring;
mod startup;

pub use connection::{ClearOutputs, Clock, Connection, Service};
pub use master::Master;
pub use outcome::{
    AcyclicError, Answer, ConnectionEnd, ConnectionState, Ended, Failure, FailureReason, Outcome, ParameterOutcome,
    RecordOutcome, Stage, StartUp,
};
pub use pace::Pace;
pub use request::{Broken, Busy, Request, Settings, broken_frames};

/// The slot of the outputs of a slave in [`Outputs`](crate::outputs::Outputs); a DP slave has one image.
pub const OUTPUT_SLOT: u16 = 1;
/// The subslot of the outputs of a slave in [`Outputs`](crate::outputs::Outputs).
pub const OUTPUT_SUBSLOT: u16 = 1;
