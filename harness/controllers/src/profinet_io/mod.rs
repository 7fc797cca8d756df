//! The PROFINET IO controller.
//!
//! A [`Controller`] accepts one [`ControllerRequest`] at a time and returns one [`ControllerOutcome`] for it: finding stations, DCP, the start-up of
//! an AR, records, base mode parameters, web pages, release, abort. While an AR is established it exchanges cyclic data,
//! acknowledges alarms and monitors the data hold time. It does not report what the device does: observers read that from the
//! frames.

mod alarms;
mod broken;
mod call;
mod connect;
mod connect_field;
mod connection;
mod context;
mod controller;
mod exchange;
mod http;
mod ids;
mod jobs;
mod layout;
mod limits;
mod load;
mod outcome;
mod ping;
mod plug;
mod presence;
mod raw;
mod record;
mod request;
mod search;
mod server;
mod snmp;
mod startup;
mod state;

pub use alarms::AlarmAcknowledge;
pub use broken::{DamagedIoFrame, broken_frames};
pub use connect::connect_blocks;
pub use connect_field::ConnectField;
pub use connection::{
    ArConfig, ConnectPart, ConnectSubmodule, DeviceAddress, Reconnect, RecordAddress, StartUpMode, StartUpRecord,
};
pub use controller::Controller;
pub use http::{LONGEST_ANSWER, PageOutcome};
pub use layout::{FrameLayout, IoDataPosition, Layout};
pub use limits::LimitError;
pub use load::{LoadKind, NetLoad};
pub use outcome::{
    ArEnd, ArFailureReason, ArReleaseOutcome, ArStartUpFailure, ArStartUpResult, CallError, ConnectOutcome,
    ControlOutcome, ControllerOutcome, DcpOutcome, IdentifiedStation, IoParameterOutcome, IoRecordOutcome,
};
pub use ping::{FragmentedSending, PingReply, PingRequest};
pub use raw::{RawActivity, RawAnswer, RawBody, RawCall, RawDcpRequest, RawObject};
pub use request::{ControllerBusy, ControllerRequest, ControllerSettings, DcpResetForm, IdentifyBy, Partner};
pub use state::{ArStartUpStage, ArState, AwaitedEvent, Wait};
