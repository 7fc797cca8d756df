//! The seam between a PROFINET device stack and the encoder behind it.
//!
//! The stack speaks PROFINET and owns everything that all devices share: DCP, start-up, frames, alarms, LLDP, the
//! records of identification, I&M and diagnosis, interface and port submodules. The application is what one manual
//! describes: submodules and their data, records of its own, diagnoses, what is stored, which names are allowed.
//!
//! This module must not know frames, blocks or sockets, nor any particular encoder.

use alloc::string::String;
use alloc::vec::Vec;
use station::{StandAction, Time};
use wire::http::{Request, Response};

/// The encoder behind a PROFINET device stack.
///
/// Every call says what time it is; time never goes backwards. What the application wants to tell of its own accord is
/// taken from it by [`next_diagnosis`](Application::next_diagnosis) after each other call.
pub trait Application {
    /// What the device says of itself; it never changes.
    fn identity(&self) -> &Identity;

    /// Every submodule that can be plugged, the alternatives for one subslot one after the other, the default one first.
    ///
    /// Interface (subslot 0x8000) and ports are not among them: they belong to the stack.
    fn plugs(&self) -> &[Plug];

    /// The name and the addresses as they are stored; the stack takes them when it starts and after a reset.
    fn stored_station(&self) -> StationData;

    /// Takes note of a changed name or address and stores `stored`.
    ///
    /// After a permanent DCP Set both are equal; after a temporary one what was set is blank in `stored`. When the call
    /// returns the storing is done: the stack answers the DCP Set afterwards.
    fn set_station(&mut self, now: Time, current: &StationData, stored: &StationData);

    /// Whether the device may be given this name; the octets come from the wire as they are, the empty name is blank.
    fn accepts_name(&self, name: &[u8]) -> bool;

    /// Resets what `scope` says to the state at delivery and says whether the device knows this kind of reset.
    ///
    /// The stack then ends its connections, takes the station anew from [`stored_station`](Application::stored_station)
    /// and goes on living without a power cycle.
    fn factory_reset(&mut self, now: Time, scope: ResetScope) -> bool;

    /// The supply has come: memory is read, everything volatile is as at the beginning.
    ///
    /// The stack stays silent for [`Identity::boot_time`] from here on.
    fn power_up(&mut self, now: Time);

    /// The supply has gone: what is volatile is lost, what is being written to memory is not written.
    ///
    /// Connections and diagnoses are forgotten on both sides; `ended` is not called for them.
    fn power_down(&mut self, now: Time);

    /// A connection with cyclic data begins: the Connect was accepted with these submodules, parameters follow.
    fn started(&mut self, now: Time, ar: ArKey, plugged: &[Plug]);

    /// All parameters of the connection were sent; the time given is when the application is ready, `now` or later.
    ///
    /// Until ApplicationReady the stack sends its inputs as bad.
    fn parameter_end(&mut self, now: Time, ar: ArKey) -> Time;

    /// A connection of any kind has ended, whatever ended it: what it left unread is forgotten.
    fn ended(&mut self, now: Time, ar: ArKey);

    /// Writes a record of the application.
    ///
    /// The place is one that is plugged; the stack refuses other places by itself, and serves its own records.
    fn write_record(&mut self, now: Time, access: Access, data: &[u8]) -> Result<(), RecordRefusal>;

    /// Reads a record of the application and appends it to `out`, complete; the stack cuts it to the length asked for.
    fn read_record(&mut self, now: Time, access: Access, out: &mut Vec<u8>) -> Result<(), RecordRefusal>;

    /// Takes the outputs of a submodule: once for each new frame, or `None` once they have become bad or missing.
    fn outputs(&mut self, now: Time, slot: u16, subslot: u16, data: Option<&[u8]>);

    /// A cyclic frame is about to be sent: what its submodules tell together is settled here, once for the frame.
    ///
    /// [`inputs`](Application::inputs) follows for each of its submodules that is plugged and has data, all at the same
    /// `now`, so that two submodules of one frame never tell of two moments. Nothing is called between them.
    fn frame(&mut self, now: Time) {
        let _ = now;
    }

    /// Fills in the inputs of a submodule, exactly once for each frame sent, and says whether they are good.
    ///
    /// `data` has the input length of the plugged submodule; all of it is written.
    fn inputs(&mut self, now: Time, slot: u16, subslot: u16, data: &mut [u8]) -> bool;

    /// The next diagnosis that came or went since the last call, oldest first.
    ///
    /// Changes come whether or not there is a connection. The stack keeps the list of what is pending for the diagnosis
    /// records, sends an alarm for each change while connected, and tells a new connection what is pending already.
    fn next_diagnosis(&mut self) -> Option<DiagnosisChange>;

    /// Does at `now` what the stand does to the sensor, and says when it will be done; `None` if it has no means for it.
    ///
    /// Power and link are the stack's and never come here. Without supply it is called too, for hands can turn a shaft
    /// and a voltage can rise all the same.
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time>;

    /// Whether what is fed to the device is enough for it to work; asked after [`act`](Application::act) and whenever
    /// time has gone on.
    ///
    /// While it is not, the device is as if its supply were cut: [`power_down`](Application::power_down) comes once it is
    /// found, and [`power_up`](Application::power_up) once there is enough again.
    fn is_alive(&self) -> bool {
        true
    }

    /// What the LED `name` shows at `now` to who has `seen` what the stack knows, in a word of `device.yaml`; `None` if
    /// the encoder has none of this name.
    ///
    /// It is asked without supply too, when an encoder that has LEDs says that they are dark.
    fn led(&mut self, now: Time, name: &str, seen: &Seen) -> Option<&'static str>;

    /// How often the counter `name` has counted; `None` if there is none of this name.
    fn counter(&mut self, now: Time, name: &str) -> Option<u64>;

    /// Whether the web server takes connections; a device without one never does.
    fn serves_pages(&self) -> bool {
        false
    }

    /// Answers a request to the web server.
    fn page(&mut self, now: Time, request: &Request) -> Response {
        let (_, _) = (now, request);
        Response::page(404, "")
    }

    /// The next time at which [`advance`](Application::advance) has something to do.
    fn deadline(&self) -> Option<Time>;

    /// Does what is due at `now`; called early or late it does what is due and nothing else.
    fn advance(&mut self, now: Time);
}

/// What the stack knows of itself that an LED may show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// Whether there is power, and enough of it.
    pub has_supply: bool,
    /// Whether the device has power and does not answer yet.
    pub is_booting: bool,
    /// Whether the cable is plugged; the bench has one, and it is at port 1.
    pub is_linked: bool,
    /// Whether there is a connection with cyclic data, be it on its way only.
    pub has_connection: bool,
    /// Whether such a connection has come to the exchange of data, and outputs come.
    pub exchanges_data: bool,
    /// Whether a connection expects something else than what is plugged.
    pub module_differs: bool,
    /// Whether the light that DCP Signal asks for is flashing: for 3 s from the Set on, once a second.
    pub is_signalling: bool,
}

/// What a device says of itself in DCP, in the blocks of the start-up and in I&M0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Vendor number assigned by PI.
    pub vendor_id: u16,
    /// Number of the device family, assigned by the vendor.
    pub device_id: u16,
    /// Manufacturer specific string of DCP, which tools show as type of the device.
    pub station_type: &'static str,
    /// Order number, at most 20 characters, not padded.
    pub order_id: &'static str,
    /// Serial number, at most 16 characters, not padded.
    pub serial_number: String,
    /// Number of Ethernet ports.
    pub ports: u16,
    /// Hardware revision.
    pub hardware_revision: u16,
    /// Software revision: a letter (V, R, P, U, T), then functional enhancement, bug fix, internal change.
    pub software_revision: [u8; 4],
    /// Counts changes of what is plugged.
    pub revision_counter: u16,
    /// Profile id of I&M0.
    pub profile_id: u16,
    /// Profile specific type of I&M0.
    pub profile_specific_type: u16,
    /// Version of the I&M functions, high and low.
    pub im_version: [u8; 2],
    /// Bit n is set if I&M n is supported; 0 with I&M0 alone.
    pub im_supported: u16,
    /// How long the device is silent after power-up.
    pub boot_time: core::time::Duration,
}

/// A submodule that can be plugged, with the module that it is part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plug {
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
    /// Octets that the device sends, without status.
    pub input_octets: u16,
    /// Octets that the controller sends, without status.
    pub output_octets: u16,
}

/// A connection, as the stack numbers it; a number is not used again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ArKey(pub u32);

/// Who accesses which record where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Access {
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

/// Why a record was refused: the ErrorCode1 that goes with ErrorDecode PNIORW (0x80).
///
/// ErrorCode is 0xDE for a read and 0xDF for a write, ErrorCode2 is 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum RecordRefusal {
    /// There is no such record at this place.
    InvalidIndex = 0xB0,
    /// The record has another length.
    WriteLength = 0xB1,
    /// There is nothing at this place.
    InvalidSlot = 0xB2,
    /// The record does not fit the state of the device.
    StateConflict = 0xB5,
    /// The record may not be accessed in this way.
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

/// The name of a device and its addresses; all blank at delivery.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StationData {
    /// Name of station, in octets as they were set; empty if it has none.
    pub name: Vec<u8>,
    /// IP address, 0.0.0.0 if it has none.
    pub ip: [u8; 4],
    /// Subnet mask.
    pub mask: [u8; 4],
    /// Standard gateway, 0.0.0.0 or the own address for none.
    pub gateway: [u8; 4],
}

/// What a reset through DCP concerns.
///
/// The first is the older suboption FactoryReset (5), the others are the modes of ResetToFactory (6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResetScope {
    /// Everything that was ever set (suboption 5).
    Factory,
    /// Mode 1: what the application has stored.
    ApplicationData,
    /// Mode 2: name and addresses.
    Communication,
    /// Mode 3: what engineering has stored.
    Engineering,
    /// Mode 4: all that is stored.
    AllData,
    /// Mode 8: the device as a whole.
    Device,
    /// Mode 9: the firmware of delivery.
    FactoryImage,
    /// A mode that the standard does not know.
    Other(u16),
}

/// A diagnosis that comes or goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DiagnosisChange {
    /// Whether it comes (`true`) or goes.
    pub appears: bool,
    /// What it says.
    pub diagnosis: Diagnosis,
}

/// A channel diagnosis of a submodule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Diagnosis {
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
    /// How bad it is.
    pub severity: Severity,
}

/// How bad a diagnosis is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// A fault.
    Fault,
    /// Maintenance is demanded.
    MaintenanceDemanded,
    /// Maintenance is required.
    MaintenanceRequired,
}
