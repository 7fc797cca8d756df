//! A connection (application relation) as observed on the wire.

use super::FrameDirection;
use station::{Duration, Time};
use std::fmt;
use std::ops::Range;
use wire::ethernet::Mac;
use wire::profinet::rpc::Uuid;

/// The number of a connection in order of observation, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ArId(pub u32);

/// The address of a station on its bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Address {
    /// MAC address (PROFINET).
    Mac(Mac),
    /// Station address, 0 to 126 (PROFIBUS).
    Fdl(u8),
}

impl Default for Address {
    fn default() -> Address {
        Address::Mac(Mac::ZERO)
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Address::Mac(mac) => mac.fmt(f),
            Address::Fdl(number) => write!(f, "station {number}"),
        }
    }
}

/// One end of a connection.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Party {
    pub address: Address,
    /// Station name, escaped, if known.
    pub station: Option<String>,
    /// Vendor ID and device ID, if known (PROFINET).
    pub ids: Option<(u16, u16)>,
    /// Ident number, if known (PROFIBUS).
    pub ident: Option<u16>,
}

impl Party {
    /// A party with a known address only.
    pub fn at(address: Address) -> Party {
        Party { address, ..Party::default() }
    }

    /// The MAC address; zero on PROFIBUS.
    pub fn mac(&self) -> Mac {
        match self.address {
            Address::Mac(mac) => mac,
            Address::Fdl(_) => Mac::ZERO,
        }
    }
}

/// The purpose of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Cyclic exchange.
    Exchange,
    /// A supervisor AR, or acyclic access only.
    Access,
}

/// The state of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArStage {
    /// Connect was sent.
    Asked,
    /// Connect was refused.
    Refused,
    /// Connect was accepted.
    Connected,
    /// PrmEnd was accepted.
    Parameterised,
    /// ApplicationReady was sent; on PROFIBUS data exchange has begun.
    Ready,
    /// It was released.
    Released,
    /// It was aborted by an ERR-RTA.
    Aborted,
    /// No frame was received for the watchdog time.
    Starved,
    /// The slave left data exchange (PROFIBUS).
    Left,
}

impl ArStage {
    /// Whether cyclic data of the connection are valid.
    pub fn stands(self) -> bool {
        match self {
            ArStage::Connected | ArStage::Parameterised | ArStage::Ready => true,
            ArStage::Asked
            | ArStage::Refused
            | ArStage::Released
            | ArStage::Aborted
            | ArStage::Starved
            | ArStage::Left => false,
        }
    }
}

/// A submodule of a connection and its offsets in the data areas of the cyclic frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SubmodulePlacement {
    pub api: u32,
    pub slot: u16,
    pub subslot: u16,
    /// Ident number of the module that the controller expects.
    pub module_ident: u32,
    /// Ident number of the submodule that the controller expects.
    pub submodule_ident: u32,
    /// Input data in the frames to the controller.
    pub input: Option<Range<usize>>,
    /// IOPS of the inputs in the frames to the controller.
    pub input_status: Option<usize>,
    /// IOCS of the inputs in the frames to the device.
    pub input_consumer: Option<usize>,
    /// Output data in the frames to the device.
    pub output: Option<Range<usize>>,
    /// IOPS of the outputs in the frames to the device.
    pub output_status: Option<usize>,
    /// IOCS of the outputs in the frames to the controller.
    pub output_consumer: Option<usize>,
}

impl SubmodulePlacement {
    /// A submodule at API, slot and subslot whose module and offsets are unknown.
    pub fn bare((api, slot, subslot): (u32, u16, u16), submodule_ident: u32) -> SubmodulePlacement {
        SubmodulePlacement {
            api,
            slot,
            subslot,
            module_ident: 0,
            submodule_ident,
            input: None,
            input_status: None,
            input_consumer: None,
            output: None,
            output_status: None,
            output_consumer: None,
        }
    }
}

/// A record that was written during the start-up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StartRecord {
    /// API, slot, subslot, index.
    pub target: (u32, u16, u16, u16),
    pub data: Vec<u8>,
    /// Whether the device accepted it.
    pub accepted: bool,
}

/// Start-up data of a slave (PROFIBUS), as far as they are in the trace.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SlaveStartData {
    /// The complete data of Set_Prm.
    pub parameters: Option<Vec<u8>>,
    /// The data of Chk_Cfg, or of Get_Cfg if the capture begins later.
    pub configuration: Option<Vec<u8>>,
    /// The last diagnosis before the connection was established.
    pub diagnosis: Option<DiagnosisFrame>,
}

/// A diagnosis and its position on the wire.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DiagnosisFrame {
    /// The data of Slave_Diag.
    pub octets: Vec<u8>,
    /// Number of the frame.
    pub frame: u64,
    /// Time of the frame.
    pub time: Time,
    /// Offset of the data in the frame, in bytes.
    pub at: usize,
}

/// The frames of one direction.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CyclicStream {
    pub frame_id: u16,
    /// Length of the data area in bytes.
    pub data_length: usize,
    /// Agreed cycle time.
    pub cycle: Duration,
    /// Watchdog time.
    pub watchdog: Duration,
    /// Number of frames.
    pub frames: u64,
    /// Number of missing frames, from the cycle counter.
    pub lost: u64,
    /// Number of frames that came twice.
    pub repeated: u64,
    /// Number of frames that came behind one that was sent later.
    pub out_of_order: u64,
    /// The longest time between two frames, in nanoseconds.
    pub max_gap_ns: u64,
    /// Time of the last frame.
    pub last: Option<Time>,
    /// Cycle counter of the last frame.
    pub last_counter: Option<u16>,
    /// Number of the first frame.
    pub first_frame: Option<u64>,
    /// Whether frames may be missing in the capture since the last frame.
    pub unsure: bool,
}

/// A connection that was established before the trace began, with a layout found by the caller.
#[derive(Clone, Debug)]
pub struct AdoptedConnection {
    pub controller: Mac,
    pub device: Mac,
    /// Vendor ID and device ID of the device.
    pub ids: (u16, u16),
    /// The frames to the controller: frame id, length of data in bytes, steps of the cycle counter (31.25 us) between two frames.
    pub inputs: (u16, usize, u16),
    /// The same for the frames to the device; frame id 0 if there are none.
    pub outputs: (u16, usize, u16),
    /// The submodules with their offsets.
    pub submodules: Vec<SubmodulePlacement>,
}

/// A connection (application relation).
#[derive(Clone, Debug)]
pub struct ObservedAr {
    pub uuid: Uuid,
    pub role: Role,
    /// Whether the trace shows which side is the controller; an ERR-RTA alone does not.
    pub roles_known: bool,
    pub controller: Party,
    pub device: Party,
    /// The submodules; empty for a connection without cyclic exchange.
    pub submodules: Vec<SubmodulePlacement>,
    pub stage: ArStage,
    /// Frame number of the Connect request.
    pub connect_frame: Option<u64>,
    /// Time of the Connect request.
    pub connect_time: Option<Time>,
    /// Frame number of the PrmEnd request.
    pub parameter_end_frame: Option<u64>,
    /// Frame number of the ApplicationReady request.
    pub application_ready_frame: Option<u64>,
    /// Frame number of the Release request.
    pub release_frame: Option<u64>,
    /// Frame number and PNIO status (as one number, ErrorCode first) of the ERR-RTA that ended it.
    pub abort: Option<(u64, u32)>,
    /// The frames to the controller.
    pub inputs: CyclicStream,
    /// The frames to the device.
    pub outputs: CyclicStream,
    /// The records that were written before PrmEnd.
    pub start_records: Vec<StartRecord>,
    /// Start-up data of the slave (PROFIBUS).
    pub slave: Option<Box<SlaveStartData>>,
}

impl ObservedAr {
    /// A connection that was established before its first frame; only the parties are known.
    pub(super) fn between(controller: Party, device: Party) -> ObservedAr {
        ObservedAr {
            uuid: Uuid::NIL,
            role: Role::Exchange,
            roles_known: true,
            controller,
            device,
            submodules: Vec::new(),
            stage: ArStage::Connected,
            connect_frame: None,
            connect_time: None,
            parameter_end_frame: None,
            application_ready_frame: None,
            release_frame: None,
            abort: None,
            inputs: CyclicStream::default(),
            outputs: CyclicStream::default(),
            start_records: Vec::new(),
            slave: None,
        }
    }

    /// What stands in the place of a forgotten connection.
    pub(super) fn forgotten() -> ObservedAr {
        let unknown = || Party::at(Address::Mac(Mac::ZERO));
        ObservedAr { role: Role::Access, stage: ArStage::Released, ..ObservedAr::between(unknown(), unknown()) }
    }

    /// The frames of a direction.
    pub fn stream(&self, direction: FrameDirection) -> &CyclicStream {
        match direction {
            FrameDirection::ToController => &self.inputs,
            FrameDirection::ToDevice => &self.outputs,
        }
    }
}
