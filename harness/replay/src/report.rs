//! The result of a replay as plain data. Its JSON form is a contract: keys may be added, none is renamed or removed.

use super::against::AgainstReport;
use super::clock::wall_clock;
use super::finding::CaptureFinding;
use super::layout_guess::StationIdentity;
use judge::observe::{Address, ArStage, CyclicStream, ObservedAr, Party, Role};
use serde::{Serialize, Serializer};
use station::Time;

/// The result of all captures of one call.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReplayReport {
    /// One entry for each file, in the order in which the user named them.
    pub captures: Vec<CaptureReport>,
}

/// The result of one capture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CaptureReport {
    /// The file as the user named it.
    pub file: String,
    /// Frames read.
    pub frames: u64,
    /// The damages of the file.
    pub damage: Vec<DamageReport>,
    /// The recordings of which the capture consists; a merged capture has several, with clocks that have nothing in common.
    pub recordings: Vec<RecordingReport>,
    /// What was judged.
    #[serde(rename = "judged")]
    pub coverage: JudgedReport,
    /// The cyclic frames that were not judged in full, because their Connect is not in the capture; in JSON they are in `judged`.
    #[serde(skip)]
    pub judged: Vec<StreamCoverage>,
    /// The stations whose identity the capture shows too late, for which it was read again.
    #[serde(skip)]
    pub(crate) identities: Vec<StationIdentity>,
    /// The number of findings that a [`ReportFilter`](crate::ReportFilter) has removed.
    #[serde(skip_serializing_if = "is_zero")]
    pub hidden_findings: u64,
    /// The connections, in the order of their first frame.
    pub ars: Vec<ConnectionReport>,
    /// The events, by frame.
    pub events: Vec<CaptureEvent>,
    /// The findings, by frame.
    pub findings: Vec<CaptureFinding>,
    /// The verdicts on the rules of each recognised device.
    pub rules: Vec<RuleReport>,
    /// The result of a comparison with a device, if requested.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub against: Option<AgainstReport>,
}

/// A recording: frames of one clock.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordingReport {
    /// The time of its first frame, RFC 3339 in UTC, if the clock of the recorder was set.
    pub from: Option<String>,
    /// The time of its last frame.
    pub to: Option<String>,
    /// The seconds between both.
    pub seconds: f64,
}

/// What of a capture was judged.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct JudgedReport {
    /// The number of connections that were judged.
    pub connections: usize,
    /// The number of frames that were read.
    pub frames: u64,
    /// What was not judged in full.
    pub not_judged: Vec<NotJudged>,
}

/// Something that was not judged in full.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NotJudged {
    /// What it is, for people.
    pub what: String,
    /// Why it was not judged.
    pub why: String,
    /// The stream, if it is one.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub stream: Option<StreamCoverage>,
}

/// What was judged of cyclic frames whose Connect is not in the capture.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct StreamCoverage {
    /// MAC address of the sender.
    pub source: String,
    /// MAC address of the receiver.
    pub destination: String,
    pub frame_id: u16,
    /// Number of frames.
    pub frames: u64,
    /// `status`: DataStatus and cycle counter; `nothing`.
    pub judged: &'static str,
    /// Why not more.
    #[serde(skip)]
    pub why: String,
    /// What the capture shows of the sender: station name, vendor and device ID, or what it announces by LLDP.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sender: Option<String>,
}

/// A damage of the file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DamageReport {
    /// Where it begins, in bytes from the start of the file.
    pub at: u64,
    /// What is wrong there.
    pub what: String,
    /// What it means: which frames may be missing or wrong, and what is undecided because of it.
    pub meaning: String,
}

/// A connection.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ConnectionReport {
    /// Its AR UUID; zeros if only its cyclic frames are in the capture.
    pub ar_uuid: String,
    /// Its purpose: `exchange` or `access`.
    pub role: &'static str,
    /// Its last state: `asked`, `refused`, `connected`, `parameterised`, `ready`, `released`, `aborted`, `starved` or `left`.
    pub stage: &'static str,
    /// The controller or master.
    pub controller: ControllerReport,
    /// The device or slave.
    pub device: DeviceReport,
    /// Whether the capture shows which of both is the controller; otherwise the names of the roles are a guess.
    #[serde(skip_serializing_if = "is_so")]
    pub roles_known: bool,
    /// Frame of the Connect request.
    pub connect_frame: Option<u64>,
    /// Frame of the controller's end of parameters.
    pub parameter_end_frame: Option<u64>,
    /// Frame of the device's ApplicationReady.
    pub application_ready_frame: Option<u64>,
    /// Frame of the Release request.
    pub release_frame: Option<u64>,
    /// The ERR-RTA that ended it.
    pub abort: Option<AbortReport>,
    /// The manual and module by which the cyclic frames are read, if the Connect is not in the capture and they were recognised.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layout: Option<String>,
    /// Frames to the controller.
    pub rt_in: StreamReport,
    /// Frames to the device.
    pub rt_out: StreamReport,
}

/// The controller or master of a connection.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ControllerReport {
    /// Its MAC address; none on PROFIBUS.
    pub mac: Option<String>,
    /// Its PROFIBUS address; `None` on PROFINET.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub address: Option<u8>,
    /// Its station name, escaped.
    pub station: Option<String>,
}

/// The device or slave of a connection.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DeviceReport {
    /// Its MAC address; none on PROFIBUS.
    pub mac: Option<String>,
    /// Its PROFIBUS address; `None` on PROFINET.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub address: Option<u8>,
    /// Its ident number, if the capture shows it; on PROFIBUS only.
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
pub struct AbortReport {
    /// Its frame.
    pub frame: u64,
    /// PNIO status as one number, ErrorCode first.
    pub code: u32,
}

/// The cyclic frames of one direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct StreamReport {
    /// Frames captured, each counted once.
    pub frames: u64,
    /// Missing frames by the cycle counter.
    pub lost: u64,
    /// The longest time between two frames, in nanoseconds.
    pub max_gap_ns: u64,
}

/// An event in a capture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CaptureEvent {
    /// Its frame.
    pub frame: u64,
    /// Seconds since the first frame of the same recording; negative where the clock stepped back.
    pub time: f64,
    /// Its time in the calendar, RFC 3339 in UTC, if the clock of the recorder was set.
    pub wall_clock: Option<String>,
    pub kind: EventKind,
    /// What happened, for people.
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
    ConnectUnanswered "connect_unanswered" "No station answered a Connect.",
    ParameterEnd "parameter_end" "A device accepted the end of the parameters.",
    ApplicationReady "application_ready" "A device sent ApplicationReady.",
    WriteRefused "write_refused" "A device refused to write a record.",
    ReadRefused "read_refused" "A device refused to read a record.",
    CallFailed "call_failed" "Another call was refused or failed.",
    Alarm "alarm" "A device sent an alarm.",
    AlarmRefused "alarm_refused" "A controller refused an alarm.",
    Abort "abort" "One side ended a connection with an ERR-RTA.",
    Release "release" "A controller released a connection.",
    Starved "starved" "One direction fell silent for longer than its watchdog.",
    DcpSet "dcp_set" "A DCP Set changed an element of a station.",
    DcpRefused "dcp_refused" "A station refused a DCP Set.",
    DcpReset "dcp_reset" "A station was reset by DCP.",
    DcpSignal "dcp_signal" "A station was made to flash its LED.",
    Rename "rename" "A station was given a name.",
    SetPrm "set_prm" "A slave accepted parameters.",
    ChkCfg "chk_cfg" "A slave accepted a configuration (Chk_Cfg).",
    Diagnosis "diagnosis" "A slave reported a diagnosis different from its last one.",
    GlobalControl "global_control" "A master sent a Global_Control command.",
    SlaveAddress "set_slave_address" "A slave accepted another address.",
    Left "left" "A slave left the data exchange by itself, or did not start it.",
    Unassigned "unassigned" "Cyclic frames belong to no connection whose start-up is in the capture.",
    Unreadable "unreadable" "A frame could not be read.",
    OtherLink "other_link" "The frames of this link are not read.",
}

impl Serialize for EventKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.word())
    }
}

/// The verdict on a rule.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RuleReport {
    /// `<manual>/<suite>/<id>`.
    pub id: String,
    /// The verdict: `pass`, `fail`, `inconclusive` (the variants disagree), `not-run` (its premise never occurred).
    pub verdict: &'static str,
    /// Number of decided premises.
    pub premises: u64,
    /// Number of premises that stayed undecided.
    pub undecided: u64,
    /// Number of frames and events checked.
    pub looked_at: u64,
    /// The reason for `inconclusive` or `not-run`.
    pub reason: Option<String>,
    /// What came later than the limit of the rule, if that is ours: it is no finding.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

impl From<&(Time, Time)> for RecordingReport {
    fn from((first, last): &(Time, Time)) -> RecordingReport {
        let seconds = last.since(*first).as_secs_f64();
        RecordingReport { from: wall_clock(*first), to: wall_clock(*last), seconds }
    }
}

impl JudgedReport {
    pub(super) fn new(connections: usize, frames: u64, streams: &[StreamCoverage]) -> JudgedReport {
        let of = |stream: &StreamCoverage| {
            let StreamCoverage { source, destination, frame_id, frames, judged, why, .. } = stream;
            let part = if *judged == "nothing" { "everything" } else { "the contents" };
            let what = format!("{part} of {frames} cyclic frames 0x{frame_id:04X} from {source} to {destination}");
            NotJudged { what, why: why.clone(), stream: Some(stream.clone()) }
        };
        JudgedReport { connections, frames, not_judged: streams.iter().map(of).collect() }
    }
}

impl From<&ObservedAr> for ConnectionReport {
    fn from(ar: &ObservedAr) -> ConnectionReport {
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
            roles_known: ar.roles_known,
            connect_frame: ar.connect_frame,
            parameter_end_frame: ar.parameter_end_frame,
            application_ready_frame: ar.application_ready_frame,
            release_frame: ar.release_frame,
            abort: ar.abort.map(|(frame, code)| AbortReport { frame, code }),
            layout: None,
            rt_in: StreamReport::from(&ar.inputs),
            rt_out: StreamReport::from(&ar.outputs),
        }
    }
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(count: &u64) -> bool {
    *count == 0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_so(known: &bool) -> bool {
    *known
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

impl From<&CyclicStream> for StreamReport {
    fn from(stream: &CyclicStream) -> StreamReport {
        StreamReport { frames: stream.frames, lost: stream.lost, max_gap_ns: stream.max_gap_ns }
    }
}

fn stage(stage: ArStage) -> &'static str {
    match stage {
        ArStage::Asked => "asked",
        ArStage::Refused => "refused",
        ArStage::Connected => "connected",
        ArStage::Parameterised => "parameterised",
        ArStage::Ready => "ready",
        ArStage::Released => "released",
        ArStage::Aborted => "aborted",
        ArStage::Starved => "starved",
        ArStage::Left => "left",
    }
}
