//! The interface between a PROFINET device stack and its application.
//!
//! The stack implements what all PROFINET devices share: DCP, start-up, cyclic frames, alarms, LLDP, the records of
//! identification, I&M and diagnosis, interface and port submodules. The application implements what one manual
//! describes: submodules and their data, its own records, diagnoses, stored data, accepted station names.
//!
//! This module must not depend on frames, blocks, sockets or a particular encoder.

use alloc::string::String;
use alloc::vec::Vec;
use station::{StandAction, Time};
use wire::http::{HttpRequest, HttpResponse};

/// The application of a PROFINET device, for instance an encoder.
///
/// Every call passes the current time, which never goes backwards. After each other call the stack fetches pending
/// diagnosis changes with [`next_diagnosis`](IoApplication::next_diagnosis).
#[allow(unused_variables, reason = "the names document the parameters")]
pub trait IoApplication {
    /// The identification data of the device; they never change.
    fn identity(&self) -> &IoIdentity;

    /// Every submodule that can be plugged. Alternatives for one subslot follow each other, the default one first.
    ///
    /// The interface (subslot 0x8000) and the ports are not part of the list: the stack adds them.
    fn plugs(&self) -> &[PluggableSubmodule];

    /// The stored name and addresses. The stack reads them at its start and after a reset.
    fn stored_station(&self) -> StationData;

    /// Reports a changed name or address and stores `stored`.
    ///
    /// After a permanent DCP Set both arguments are equal. After a temporary one, the element that was set is blank
    /// in `stored`. The stack answers the DCP Set after this call returns, so storing must be complete then.
    fn set_station(&mut self, now: Time, current: &StationData, stored: &StationData);

    /// Whether the device accepts this station name. `name` is the raw content of the DCP block; an empty name clears
    /// the name.
    fn accepts_name(&self, name: &[u8]) -> bool;

    /// Resets the data of `scope` to factory state. Returns `false` if the device does not support this kind of
    /// reset.
    ///
    /// The stack then ends its connections, reads [`stored_station`](IoApplication::stored_station) again and continues
    /// without a power cycle.
    fn factory_reset(&mut self, now: Time, scope: ResetScope) -> bool;

    /// The supply was switched on: load memory and initialise everything volatile.
    ///
    /// The stack sends nothing during [`IoIdentity::boot_time`] from here on.
    fn power_up(&mut self, now: Time);

    /// The supply failed: volatile data are lost, and a running write to memory is not completed.
    ///
    /// Stack and application drop all connections and diagnoses; `ended` is not called for them.
    fn power_down(&mut self, now: Time);

    /// A connection with cyclic data begins: Connect was accepted with these submodules, parameter records follow.
    fn started(&mut self, now: Time, ar: ArKey, plugged: &[PluggableSubmodule]);

    /// All parameters of the connection were sent (PrmEnd). Returns when the application is ready, `now` or later.
    ///
    /// Until ApplicationReady the stack sends inputs with a bad IOPS.
    fn parameter_end(&mut self, now: Time, ar: ArKey) -> Time;

    /// A connection of any kind has ended, for any reason: drop responses that it did not fetch.
    fn ended(&mut self, now: Time, ar: ArKey);

    /// Writes a record of the application.
    ///
    /// A submodule is plugged at the address of `access`: the stack itself refuses other addresses and serves its own
    /// records.
    fn write_record(&mut self, now: Time, access: RecordAccess, data: &[u8]) -> Result<(), RecordRefusal>;

    /// Reads a record of the application and appends all of it to `out`. The stack truncates it to the requested
    /// length.
    fn read_record(&mut self, now: Time, access: RecordAccess, out: &mut Vec<u8>) -> Result<(), RecordRefusal>;

    /// Receives the outputs of a submodule: once for each new frame, and `None` once when they become bad or missing.
    fn outputs(&mut self, now: Time, slot: u16, subslot: u16, data: Option<&[u8]>);

    /// A cyclic frame is about to be sent: compute here, once per frame, the values that its submodules share.
    ///
    /// The stack then calls [`inputs`](IoApplication::inputs) for each plugged submodule with data in the frame, all
    /// with the same `now` and nothing in between. All submodules of a frame therefore show the same instant.
    fn frame(&mut self, now: Time) {}

    /// Fills in the inputs of a submodule, exactly once for each frame sent. Returns whether they are good (IOPS).
    ///
    /// `data` has the input length of the plugged submodule; write all of it.
    fn inputs(&mut self, now: Time, slot: u16, subslot: u16, data: &mut [u8]) -> bool;

    /// The next diagnosis that appeared or disappeared since the last call, oldest first.
    ///
    /// Report changes with or without a connection. The stack keeps the list of pending diagnoses for the diagnosis
    /// records, sends an alarm for each change while connected, and reports to a new connection what is already
    /// pending.
    fn next_diagnosis(&mut self) -> Option<DiagnosisChange>;

    /// The next submodule that was pulled or plugged since the last call, oldest first.
    ///
    /// The interface and the ports are never pulled. A device without exchangeable modules returns `None`.
    fn next_plug(&mut self) -> Option<PlugChange> {
        None
    }

    /// The slot and subslot of the next event in the process since the last call, oldest first, for a process alarm.
    fn next_event(&mut self) -> Option<(u16, u16)> {
        None
    }

    /// How many controllers can have a connection with cyclic data at the same time (NumberOfAR in the GSDML).
    fn controllers(&self) -> usize {
        1
    }

    /// How many supervisors can have a connection for records at the same time (NumberOfDeviceAccessAR in the GSDML).
    fn supervisors(&self) -> usize {
        2
    }

    /// Carries out an action of the stand on the sensor. Returns when it is complete, or `None` if the application
    /// does not support the action.
    ///
    /// The stack handles power and link itself. The call also occurs without supply, because a shaft can be turned
    /// and a voltage can rise without it.
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time>;

    /// Whether the supply suffices for the device to work. The stack checks it after [`act`](IoApplication::act) and
    /// whenever time has advanced.
    ///
    /// While it does not, the device behaves as with the supply cut: the stack calls
    /// [`power_down`](IoApplication::power_down) when it detects the state, and [`power_up`](IoApplication::power_up)
    /// when the supply suffices again.
    fn is_alive(&self) -> bool {
        true
    }

    /// What the LED `name` shows at `now`, as a word of `device.yaml`; `None` if the application has no LED of this
    /// name. `status` is the state of the stack.
    ///
    /// The call also occurs without supply; an application with LEDs then reports them as dark.
    fn led(&mut self, now: Time, name: &str, status: &StackStatus) -> Option<&'static str> {
        None
    }

    /// The value of the counter `name`; `None` if there is no counter of this name.
    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        None
    }

    /// Whether the web server accepts connections. A device without a web server returns `false`.
    fn serves_pages(&self) -> bool {
        false
    }

    /// Answers a request to the web server.
    fn page(&mut self, now: Time, request: &HttpRequest) -> HttpResponse {
        HttpResponse::page(404, "")
    }

    /// The next time at which [`advance`](IoApplication::advance) has something to do.
    fn deadline(&self) -> Option<Time> {
        None
    }

    /// Does what is due at `now`. An early or late call is allowed.
    fn advance(&mut self, now: Time) {}
}

/// The state of the stack, for LEDs that show it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StackStatus {
    /// Whether the supply is on and sufficient.
    pub has_supply: bool,
    /// Whether the device is booting: it has power and does not answer yet.
    pub is_booting: bool,
    /// Whether the cable is plugged in. The bench has one cable, at port 1.
    pub is_linked: bool,
    /// Whether there is a connection with cyclic data, established or during start-up.
    pub has_connection: bool,
    /// Whether such a connection exchanges data and receives outputs.
    pub exchanges_data: bool,
    /// Whether the expected configuration of a connection differs from the plugged one.
    pub module_differs: bool,
    /// Whether the LED flashes for DCP Signal: once a second for 3 s after the Set.
    pub is_signalling: bool,
}

/// The identification data of a device in DCP, in the start-up blocks and in I&M0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IoIdentity {
    /// Vendor number assigned by PI.
    pub vendor_id: u16,
    /// Number of the device family, assigned by the vendor.
    pub device_id: u16,
    /// TypeOfStation (manufacturer specific string) of DCP, which tools show as the device type.
    pub station_type: &'static str,
    /// Order number, at most 20 characters, not padded.
    pub order_id: &'static str,
    /// Serial number, at most 16 characters, not padded.
    pub serial_number: String,
    /// Number of Ethernet ports.
    pub ports: u16,
    /// Hardware revision.
    pub hardware_revision: u16,
    /// Software revision: prefix letter (V, R, P, U, T), then functional enhancement, bug fix, internal change.
    pub software_revision: [u8; 4],
    /// Counts changes of the plugged modules.
    pub revision_counter: u16,
    /// Profile id of I&M0.
    pub profile_id: u16,
    /// Profile specific type of I&M0.
    pub profile_specific_type: u16,
    /// Version of the I&M functions, high and low.
    pub im_version: [u8; 2],
    /// Bit n is set if I&M n is supported; 0 with I&M0 only.
    pub im_supported: u16,
    /// Time from power-up to the first frame.
    pub boot_time: core::time::Duration,
    /// It has record 0x8090, and says Hello only as that record says; otherwise it says Hello once it is linked.
    pub has_fast_start_up: bool,
}

/// A submodule that can be plugged, with its module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PluggableSubmodule {
    /// Application process.
    pub api: u32,
    /// Slot of the module.
    pub slot: u16,
    /// Ident number of the module.
    pub module_ident: u32,
    /// Subslot of the submodule.
    pub subslot: u16,
    /// Ident number of the submodule.
    pub submodule_ident: u32,
    /// Input data from the device in bytes, without status.
    pub input_octets: u16,
    /// Output data to the device in bytes, without status.
    pub output_octets: u16,
}

/// A submodule that is pulled or plugged while the device has power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlugChange {
    /// It was pulled.
    Pulled(PluggableSubmodule),
    /// It was plugged. If it is none of [`IoApplication::plugs`], it is wrong for its place.
    Plugged(PluggableSubmodule),
}

/// The number that the stack gives to a connection. Numbers are not reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ArKey(pub u32);

/// The record that is accessed, its submodule, and the connection that accesses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordAccess {
    /// The connection, or `None` for a read without one (ReadImplicit).
    pub ar: Option<ArKey>,
    /// Application process.
    pub api: u32,
    /// Slot.
    pub slot: u16,
    /// Subslot.
    pub subslot: u16,
    /// Index of the record.
    pub index: u16,
}

/// Why a record was refused: ErrorCode1 for ErrorDecode PNIORW (0x80).
///
/// ErrorCode is 0xDE for a read and 0xDF for a write, ErrorCode2 is 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum RecordRefusal {
    /// The submodule has no record of this index.
    InvalidIndex = 0xB0,
    /// The data have the wrong length.
    WriteLength = 0xB1,
    /// Nothing is plugged at this slot and subslot.
    InvalidSlot = 0xB2,
    /// The state of the device does not allow the access.
    StateConflict = 0xB5,
    /// The record cannot be read, or cannot be written.
    AccessDenied = 0xB6,
    /// A field is out of its range.
    InvalidRange = 0xB7,
    /// A field has a value that is not allowed.
    InvalidParameter = 0xB8,
}

impl RecordRefusal {
    /// The ErrorCode1 of this refusal.
    pub const fn code1(self) -> u8 {
        self as u8
    }
}

/// The name and the addresses of a device; all are blank in factory state.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StationData {
    /// Name of station, raw bytes as they were set; empty without a name.
    pub name: Vec<u8>,
    /// IP address, 0.0.0.0 without an address.
    pub ip: [u8; 4],
    /// Subnet mask.
    pub mask: [u8; 4],
    /// Standard gateway; 0.0.0.0 or the address of the device itself without a gateway.
    pub gateway: [u8; 4],
}

/// The data that a reset by DCP clears.
///
/// `Factory` is the older suboption FactoryReset (5), the others are the modes of ResetToFactory (6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResetScope {
    /// All stored data (suboption 5).
    Factory,
    /// Mode 1: data stored by the application.
    ApplicationData,
    /// Mode 2: communication parameters, that is name and addresses.
    Communication,
    /// Mode 3: data stored by engineering.
    Engineering,
    /// Mode 4: all stored data.
    AllData,
    /// Mode 8: the device as a whole.
    Device,
    /// Mode 9: the factory firmware image.
    FactoryImage,
    /// A mode that the standard does not define.
    Other(u16),
}

/// A diagnosis that appears or disappears.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DiagnosisChange {
    /// `true` if it appears, `false` if it disappears.
    pub appears: bool,
    /// The diagnosis.
    pub diagnosis: SubmoduleDiagnosis,
}

/// A channel diagnosis of a submodule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SubmoduleDiagnosis {
    /// Application process.
    pub api: u32,
    /// Slot.
    pub slot: u16,
    /// Subslot.
    pub subslot: u16,
    /// Channel, 0x8000 for the submodule as a whole.
    pub channel: u16,
    /// ChannelErrorType.
    pub error_type: u16,
    /// ExtChannelErrorType and its added value, for an extended channel diagnosis.
    pub extended: Option<(u16, u32)>,
    /// The severity.
    pub severity: DiagnosisSeverity,
}

/// The severity of a diagnosis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiagnosisSeverity {
    /// Fault.
    Fault,
    /// Maintenance demanded.
    MaintenanceDemanded,
    /// Maintenance required.
    MaintenanceRequired,
}
