//! The PROFINET IO controller.
//!
//! A [`Controller`] accepts one [`Request`] at a time and returns one [`Outcome`] for it: finding stations, DCP, the start-up of
//! an AR, records, base mode parameters, web pages, release, abort. While an AR is established it exchanges cyclic data,
//! acknowledges alarms and monitors the data hold time. It does not report what the device does: observers read that from the
//! frames.

mod alarms;
mod broken;
mod call;
mod connect;
mod connection;
mod context;
mod controller;
mod exchange;
mod http;
mod ids;
mod jobs;
mod layout;
mod limits;
mod outcome;
mod presence;
mod record;
mod request;
mod search;
mod server;
mod startup;
mod state;

pub use alarms::AlarmAcknowledge;
pub use broken::{Broken, broken_frames};
pub use connect::connect_blocks;
pub use connection::{ConnectPart, Connection, DeviceAddress, Reconnect, Record, StartUpMode, Submodule, Target};
pub use controller::Controller;
pub use http::{LONGEST_ANSWER, PageOutcome};
pub use layout::{FrameLayout, Layout, Place};
pub use limits::LimitError;
pub use outcome::{
    ArEnd, CallError, ConnectOutcome, ControlOutcome, DcpOutcome, Ended, Failure, FailureReason, Outcome,
    ParameterOutcome, RecordOutcome, StartUp, StationSeen,
};
pub use request::{Busy, IdentifyBy, Partner, Request, Reset, Settings};
pub use state::{ArState, Stage, Wait, Waiting};
