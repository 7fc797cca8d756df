//! A connection (application relation) as it was seen on the wire.

use super::Direction;
use station::{Duration, Time};
use std::fmt;
use std::ops::Range;
use wire::ethernet::Mac;
use wire::profinet::rpc::Uuid;

/// The number of a connection in the order in which they were seen, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ArId(pub u32);

/// How a station is addressed on its bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Address {
    /// PROFINET.
    Mac(Mac),
    /// PROFIBUS: the number of the station, 0 to 126.
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
    /// Its address.
    pub address: Address,
    /// Its station name, escaped for showing, where one was seen.
    pub station: Option<String>,
    /// Vendor ID and device ID, where they were seen (PROFINET).
    pub ids: Option<(u16, u16)>,
    /// Ident number, where it was seen (PROFIBUS).
    pub ident: Option<u16>,
}

impl Party {
    /// A party of which nothing but its address is known.
    pub fn at(address: Address) -> Party {
        Party { address, ..Party::default() }
    }

    /// Its MAC address; that of nobody on PROFIBUS, where there is none.
    pub fn mac(&self) -> Mac {
        match self.address {
            Address::Mac(mac) => mac,
            Address::Fdl(_) => Mac::ZERO,
        }
    }
}

/// What a connection is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Cyclic exchange.
    Exchange,
    /// A supervisor's, or acyclic access only.
    Access,
}

/// How far a connection has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Connect was sent.
    Asked,
    /// Connect was refused.
    Refused,
    /// Connect was accepted.
    Connected,
    /// The parameters have ended.
    Parameterised,
    /// The device is ready.
    Ready,
    /// It was released.
    Released,
    /// It was ended by an ERR-RTA.
    Aborted,
    /// It fell silent.
    Starved,
    /// The slave left the data exchange by itself (PROFIBUS).
    Left,
}

impl Stage {
    /// Whether cyclic data of the connection still mean something.
    pub fn stands(self) -> bool {
        match self {
            Stage::Connected | Stage::Parameterised | Stage::Ready => true,
            Stage::Asked | Stage::Refused | Stage::Released | Stage::Aborted | Stage::Starved | Stage::Left => false,
        }
    }
}

/// A submodule of a connection and where its data lie in the data areas of the cyclic frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Placed {
    /// API.
    pub api: u32,
    /// Slot number.
    pub slot: u16,
    /// Subslot number.
    pub subslot: u16,
    /// Ident number of the module, as expected by the controller.
    pub module_ident: u32,
    /// Ident number of the submodule, as expected by the controller.
    pub submodule_ident: u32,
    /// Input data in the frames to the controller.
    pub input: Option<Range<usize>>,
    /// The device's provider status of the inputs, in the frames to the controller.
    pub input_status: Option<usize>,
    /// The controller's consumer status of the inputs, in the frames to the device.
    pub input_consumer: Option<usize>,
    /// Output data in the frames to the device.
    pub output: Option<Range<usize>>,
    /// The controller's provider status of the outputs, in the frames to the device.
    pub output_status: Option<usize>,
    /// The device's consumer status of the outputs, in the frames to the controller.
    pub output_consumer: Option<usize>,
}

impl Placed {
    /// A submodule with its ident number at API, slot and subslot, of whose module and data nothing is known yet.
    pub fn bare((api, slot, subslot): (u32, u16, u16), submodule_ident: u32) -> Placed {
        Placed {
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
    /// What was written.
    pub data: Vec<u8>,
    /// Whether the device took it.
    pub accepted: bool,
}

/// What a master told a slave at the begin of their connection (PROFIBUS); what was not seen is not there.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SlaveTold {
    /// The data of Set_Prm, all of them.
    pub parameters: Option<Vec<u8>>,
    /// The data of Chk_Cfg, or of Get_Cfg where the capture begins later.
    pub configuration: Option<Vec<u8>>,
    /// The last diagnosis before the connection stood.
    pub diagnosis: Option<DiagnosisTold>,
}

/// A diagnosis, and where it stood.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DiagnosisTold {
    /// The data of Slave_Diag.
    pub octets: Vec<u8>,
    /// The number of its frame.
    pub frame: u64,
    /// When it was seen.
    pub time: Time,
    /// Where the data begin in the frame, in octets.
    pub at: usize,
}

/// The frames of one direction.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stream {
    /// Frame id.
    pub frame_id: u16,
    /// Length of the data area in octets.
    pub data_length: usize,
    /// The time between two frames as agreed.
    pub cycle: Duration,
    /// The time without frames after which the connection ends.
    pub watchdog: Duration,
    /// Frames seen.
    pub frames: u64,
    /// Frames missing, by the cycle counter.
    pub lost: u64,
    /// The longest time between two frames, in nanoseconds.
    pub max_gap_ns: u64,
    /// When the last one was seen.
    pub last: Option<Time>,
    /// The cycle counter of the last one.
    pub last_counter: Option<u16>,
    /// The number of the first frame.
    pub first_frame: Option<u64>,
    /// Whether frames may be missing in the capture since the last one.
    pub unsure: bool,
}

/// A connection that was made before the trace began, as somebody else knows it.
#[derive(Clone, Debug)]
pub struct Met {
    /// The controller.
    pub controller: Mac,
    /// The device.
    pub device: Mac,
    /// Vendor ID and device ID of the device.
    pub ids: (u16, u16),
    /// The frames to the controller: frame id, octets of data, steps of the cycle counter (31.25 us) between two frames.
    pub inputs: (u16, usize, u16),
    /// The same of the frames to the device; a frame id of 0 where there are none.
    pub outputs: (u16, usize, u16),
    /// Its submodules and where their data lie.
    pub submodules: Vec<Placed>,
}

/// A connection (application relation).
#[derive(Clone, Debug)]
pub struct Ar {
    /// Its UUID.
    pub uuid: Uuid,
    /// What it is for.
    pub role: Role,
    /// Who asked for it.
    pub controller: Party,
    /// Who was asked.
    pub device: Party,
    /// Its submodules; empty for a connection without cyclic exchange.
    pub submodules: Vec<Placed>,
    /// How far it has come.
    pub stage: Stage,
    /// Frame number of the Connect request.
    pub connect_frame: Option<u64>,
    /// When the Connect request was seen.
    pub connect_time: Option<Time>,
    /// Frame number of the end of parameters.
    pub parameter_end_frame: Option<u64>,
    /// Frame number of the device's ApplicationReady.
    pub application_ready_frame: Option<u64>,
    /// Frame number of the Release request.
    pub release_frame: Option<u64>,
    /// Frame number and PNIO status (as one number, ErrorCode first) of the ERR-RTA that ended it.
    pub abort: Option<(u64, u32)>,
    /// The frames to the controller.
    pub inputs: Stream,
    /// The frames to the device.
    pub outputs: Stream,
    /// The records that were written before the end of parameters.
    pub start_records: Vec<StartRecord>,
    /// What the master told the slave (PROFIBUS).
    pub slave: Option<Box<SlaveTold>>,
}

impl Ar {
    /// A connection that stood before its first frame was seen, of which nothing is known but the parties.
    pub(super) fn between(controller: Party, device: Party) -> Ar {
        Ar {
            uuid: Uuid::NIL,
            role: Role::Exchange,
            controller,
            device,
            submodules: Vec::new(),
            stage: Stage::Connected,
            connect_frame: None,
            connect_time: None,
            parameter_end_frame: None,
            application_ready_frame: None,
            release_frame: None,
            abort: None,
            inputs: Stream::default(),
            outputs: Stream::default(),
            start_records: Vec::new(),
            slave: None,
        }
    }

    /// The frames of a direction.
    pub fn stream(&self, direction: Direction) -> &Stream {
        match direction {
            Direction::ToController => &self.inputs,
            Direction::ToDevice => &self.outputs,
        }
    }
}
