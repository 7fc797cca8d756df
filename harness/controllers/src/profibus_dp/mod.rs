//! The PROFIBUS DP master.
//!
//! A [`Master`] takes one [`Request`] at a time and gives one [`Outcome`] for it. It waits for the token, or claims it on a bus where
//! there is none, hands it on, and looks for other masters. While a [`Connection`] stands it exchanges data with its slave each cycle, reads
//! the diagnosis when an answer of high priority asks for it, and gives the clock of isochronous mode. What the slave does is not
//! reported here but read from the frames by whoever watches the bus. Source: IEC 61158-4-3 and IEC 61158-6-3.

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

/// The slot of the outputs of a slave in [`Outputs`](crate::outputs::Outputs); a slave of DP has one image.
pub const OUTPUT_SLOT: u16 = 1;
/// The subslot of the outputs of a slave in [`Outputs`](crate::outputs::Outputs).
pub const OUTPUT_SUBSLOT: u16 = 1;
