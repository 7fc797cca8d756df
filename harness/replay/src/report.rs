//! What was found in captures, as plain data; its JSON form is a contract: keys may be added, none is renamed or left out.

use super::against::AgainstReport;
use super::finding::Finding;
use judge::observe::{Address, Ar, Party, Role, Stage, Stream};
use serde::{Serialize, Serializer};

/// What was found in all captures of one call.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReplayReport {
    /// One entry for each file, in the order in which they were named.
    pub captures: Vec<CaptureReport>,
}

/// What was found in a capture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CaptureReport {
    /// The file as it was named.
    pub file: String,
    /// Frames read.
    pub frames: u64,
    /// Where the file is not as it should be.
    pub damage: Vec<DamageReport>,
    /// The connections in the order in which they were first seen.
    pub ars: Vec<ConnectionReport>,
    /// What happened, by frame.
    pub events: Vec<Event>,
    /// What is wrong, by frame.
    pub findings: Vec<Finding>,
    /// What became of each rule of each device that was recognised.
    pub rules: Vec<RuleReport>,
    /// What a comparison with a device came to, where one was asked for.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub against: Option<AgainstReport>,
}

/// A place where a file is not as it should be.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DamageReport {
    /// Where it begins, in octets from the start of the file.
    pub at: u64,
    /// What is wrong there.
    pub what: String,
    /// What it means: which frames may be missing or wrong, and what is undecided for that.
    pub meaning: String,
}

/// A connection.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ConnectionReport {
    /// Its UUID; zeros where only its frames say that there is one.
    pub ar_uuid: String,
    /// What it is for: `exchange` or `access`.
    pub role: &'static str,
    /// How far it came: `asked`, `refused`, `connected`, `parameterised`, `ready`, `released`, `aborted`, `starved`,
    /// `left`.
    pub stage: &'static str,
    /// Who asked for it.
    pub controller: ControllerReport,
    /// Who was asked.
    pub device: DeviceReport,
    /// Frame of the Connect request.
    pub connect_frame: Option<u64>,
    /// Frame in which the controller ended the parameters.
    pub parameter_end_frame: Option<u64>,
    /// Frame in which the device said that it is ready.
    pub application_ready_frame: Option<u64>,
    /// Frame of the Release request.
    pub release_frame: Option<u64>,
    /// The ERR-RTA that ended it.
    pub abort: Option<Abort>,
    /// By which manual and module the cyclic frames are read, where the Connect was not seen and they were recognised.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layout: Option<String>,
    /// Frames to the controller.
    pub rt_in: StreamReport,
    /// Frames to the device.
    pub rt_out: StreamReport,
}

/// Who asked for a connection.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ControllerReport {
    /// Its MAC address; none on PROFIBUS.
    pub mac: Option<String>,
    /// Its station address; there on PROFIBUS only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub address: Option<u8>,
    /// Its station name, escaped.
    pub station: Option<String>,
}

/// Who was asked for a connection.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DeviceReport {
    /// Its MAC address; none on PROFIBUS.
    pub mac: Option<String>,
    /// Its station address; there on PROFIBUS only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub address: Option<u8>,
    /// Its ident number; on PROFIBUS only, where it was seen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ident: Option<u16>,
    /// Its station name, escaped.
    pub station: Option<String>,
    /// Vendor ID.
    pub vendor_id: Option<u16>,
    /// Device ID.
    pub device_id: Option<u16>,
}

/// The ERR-RTA that ended a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Abort {
    /// Its frame.
    pub frame: u64,
    /// PNIO status as one number, ErrorCode first.
    pub code: u32,
}

/// The cyclic frames of one direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct StreamReport {
    /// Frames seen, each once.
    pub frames: u64,
    /// Frames missing, by the cycle counter.
    pub lost: u64,
    /// The longest time between two frames, in nanoseconds.
    pub max_gap_ns: u64,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Event {
    /// Its frame.
    pub frame: u64,
    /// Seconds since the first frame of the capture; less than 0 where time went backwards.
    pub time: f64,
    /// What it is.
    pub kind: EventKind,
    /// What it is, for people.
    pub text: String,
}

macro_rules! event_kinds {
    ($($Kind:ident $word:literal $sentence:literal,)*) => {
        /// The kinds of events.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum EventKind {
            $(#[doc = $sentence] $Kind,)*
        }

        impl EventKind {
            /// The word in reports.
            pub fn word(self) -> &'static str {
                match self { $(EventKind::$Kind => $word,)* }
            }
        }
    };
}

event_kinds! {
    Connect "connect" "A device accepted a connection.",
    ConnectRefused "connect_refused" "A device refused a connection.",
    ConnectUnanswered "connect_unanswered" "Nobody answered a Connect.",
    ParameterEnd "parameter_end" "A device took the end of the parameters.",
    ApplicationReady "application_ready" "A device said that it is ready.",
    WriteRefused "write_refused" "A device refused to write a record.",
    ReadRefused "read_refused" "A device refused to read a record.",
    CallFailed "call_failed" "Another call was refused or failed.",
    Alarm "alarm" "A device sent an alarm.",
    AlarmRefused "alarm_refused" "A controller refused an alarm.",
    Abort "abort" "One side ended a connection with an ERR-RTA.",
    Release "release" "A controller released a connection.",
    Starved "starved" "One direction fell silent for longer than its watchdog.",
    DcpSet "dcp_set" "Somebody set an element of a station.",
    DcpRefused "dcp_refused" "A station refused what somebody set.",
    DcpReset "dcp_reset" "Somebody reset a station.",
    DcpSignal "dcp_signal" "Somebody let a station flash.",
    Rename "rename" "Somebody gave a station a name.",
    SetPrm "set_prm" "A slave took parameters.",
    ChkCfg "chk_cfg" "A slave took a configuration to be checked.",
    Diagnosis "diagnosis" "A slave told another diagnosis than before.",
    GlobalControl "global_control" "A master commanded slaves.",
    SlaveAddress "set_slave_address" "A slave took another address.",
    Left "left" "A slave left the exchange of data by itself, or did not let it come about.",
    Unassigned "unassigned" "Cyclic frames belong to no connection that was seen to be made.",
    Unreadable "unreadable" "A frame could not be read.",
    OtherLink "other_link" "The frames of this link are not read.",
}

impl Serialize for EventKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.word())
    }
}

/// What became of a rule.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RuleReport {
    /// `<manual>/<suite>/<id>`.
    pub id: String,
    /// The verdict: `pass`, `fail`, `inconclusive` (the variants disagree), `not-run` (its premise was never seen).
    pub verdict: &'static str,
    /// Decided premises.
    pub premises: u64,
    /// Premises that stayed undecided.
    pub undecided: u64,
    /// Frames and events looked at.
    pub looked_at: u64,
    /// Why it is inconclusive or not run.
    pub reason: Option<String>,
}

impl From<&Ar> for ConnectionReport {
    fn from(ar: &Ar) -> ConnectionReport {
        ConnectionReport {
            ar_uuid: ar.uuid.to_string(),
            role: match ar.role {
                Role::Exchange => "exchange",
                Role::Access => "access",
            },
            stage: stage(ar.stage),
            controller: ControllerReport {
                mac: mac(&ar.controller),
                address: number(&ar.controller),
                station: ar.controller.station.clone(),
            },
            device: DeviceReport {
                mac: mac(&ar.device),
                address: number(&ar.device),
                ident: ar.device.ident,
                station: ar.device.station.clone(),
                vendor_id: ar.device.ids.map(|ids| ids.0),
                device_id: ar.device.ids.map(|ids| ids.1),
            },
            connect_frame: ar.connect_frame,
            parameter_end_frame: ar.parameter_end_frame,
            application_ready_frame: ar.application_ready_frame,
            release_frame: ar.release_frame,
            abort: ar.abort.map(|(frame, code)| Abort { frame, code }),
            layout: None,
            rt_in: StreamReport::from(&ar.inputs),
            rt_out: StreamReport::from(&ar.outputs),
        }
    }
}

fn mac(party: &Party) -> Option<String> {
    match party.address {
        Address::Mac(mac) => Some(mac.to_string()),
        Address::Fdl(_) => None,
    }
}

fn number(party: &Party) -> Option<u8> {
    match party.address {
        Address::Fdl(number) => Some(number),
        Address::Mac(_) => None,
    }
}

impl From<&Stream> for StreamReport {
    fn from(stream: &Stream) -> StreamReport {
        StreamReport { frames: stream.frames, lost: stream.lost, max_gap_ns: stream.max_gap_ns }
    }
}

fn stage(stage: Stage) -> &'static str {
    match stage {
        Stage::Asked => "asked",
        Stage::Refused => "refused",
        Stage::Connected => "connected",
        Stage::Parameterised => "parameterised",
        Stage::Ready => "ready",
        Stage::Released => "released",
        Stage::Aborted => "aborted",
        Stage::Starved => "starved",
        Stage::Left => "left",
    }
}
