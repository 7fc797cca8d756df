//! What a start-up is to be: the device, its submodules, the bus settings, the records.
//!
//! This room must not know how any of it is sent; the limits stand in `limits`.

use alloc::string::String;
use alloc::vec::Vec;
use core::time::Duration;
use wire::ethernet::{Mac, Vlan};
use wire::profinet::blocks::connect::{ArProperties, ArType, RtClass};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::rt::FrameId;

/// How the device is found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DeviceAddress {
    /// By its name of station: a DCP Identify that one station answers.
    Name(String),
    /// By its MAC address: a DCP Get to it alone.
    Mac(Mac),
}

/// A part of the Connect, for its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ConnectPart {
    /// IOCRBlockReq of the inputs.
    Inputs,
    /// IOCRBlockReq of the outputs.
    Outputs,
    /// The ExpectedSubmoduleBlockReqs, one for each slot.
    Submodules,
    /// AlarmCRBlockReq.
    Alarms,
    /// The blocks that are passed along, [`Connection::extra_blocks`].
    Extra,
}

/// What happens by itself when an AR that stood has ended without our asking.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reconnect {
    /// How long after the end the same start-up begins again; zero begins it in the same tick.
    pub after: Duration,
}

/// How an AR starts up: bit 30 of ARProperties.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum StartUpMode {
    /// The older way.
    #[default]
    Legacy,
    /// The newer way: the response names its station in an ARServerBlock.
    Advanced,
}

/// A submodule that is expected, with the module it stands in.
///
/// Submodules of the DAP, the interface and the ports belong into the list as well; they have no data.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Submodule {
    /// The API it belongs to, 0 without a profile.
    pub api: u32,
    /// Its slot.
    pub slot: u16,
    /// ModuleIdentNumber of the module in this slot.
    pub module_ident: u32,
    /// Its subslot.
    pub subslot: u16,
    /// Its SubmoduleIdentNumber.
    pub submodule_ident: u32,
    /// Octets from the device to the controller.
    pub input_octets: u16,
    /// Octets from the controller to the device.
    pub output_octets: u16,
}

/// Where a record is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Target {
    /// The API.
    pub api: u32,
    /// The slot.
    pub slot: u16,
    /// The subslot.
    pub subslot: u16,
    /// The index.
    pub index: u16,
}

/// A record that is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Record {
    /// Where it goes.
    pub target: Target,
    /// What it says.
    pub data: Vec<u8>,
}

/// A start-up from the search for the device to the first good data.
///
/// Begin with [`Connection::new`], which has usual values, and change what is to be different. The numbers have the ranges
/// that [`Connection::check`] knows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Connection {
    /// Which device.
    pub device: DeviceAddress,
    /// How long it is looked for; the question is repeated that long.
    pub search: Duration,
    /// The address it is given, temporarily, if it has another one.
    pub ip: IpParameter,
    /// Whether it is given that address. If not, it is called at the one that it has, and one that has none at `ip` all the
    /// same.
    pub gives_address: bool,
    /// Vendor number in the object UUID that is called.
    pub vendor_id: u16,
    /// Device number in the object UUID that is called.
    pub device_id: u16,
    /// Instance in the object UUID that is called, 1 in most devices.
    pub instance: u16,
    /// What kind of AR.
    pub ar_type: ArType,
    /// How it starts up.
    pub startup: StartUpMode,
    /// Whether the AR is for records only: no cyclic data, no submodules, no parametrization.
    pub device_access: bool,
    /// Further bits of ARProperties, added to those that the other fields set.
    pub properties: ArProperties,
    /// CMInitiatorActivityTimeoutFactor: how long the device waits for our next step; unit 100 ms, 1 to 1000.
    pub activity_timeout_factor: u16,
    /// In which order the blocks after the ARBlockReq stand in the Connect; a part that is not named is not sent.
    pub order: Vec<ConnectPart>,
    /// Whole blocks with their headers that are passed along in the Connect as they are, such as an ARFSUBlock (0x010B).
    pub extra_blocks: Vec<u8>,
    /// ARArgsMaximum of the Connect: how many octets of an answer we say we can take; none: 4096.
    pub args_maximum: Option<u32>,
    /// Whether the ARUUID is that of the last AR again, as of a controller that takes up the same AR after a loss.
    pub same_uuid: bool,
    /// Whether and when the start-up is repeated by itself after the AR was lost; none: never.
    pub reconnect: Option<Reconnect>,
    /// Our name in the Connect; that of the settings where there is none. Octets, since a tester also sends bad ones.
    pub station_name: Option<Vec<u8>>,
    /// The submodules that are expected, in the order of the frame; those of one slot stand together.
    pub submodules: Vec<Submodule>,
    /// The records that are written before PrmEnd, in order.
    pub records: Vec<Record>,
    /// Whether they go in one Write.
    pub write_multiple: bool,
    /// Send clock; unit 31.25 µs, 1 to 128.
    pub send_clock_factor: u16,
    /// A frame in each n-th send clock; 1 to 512, a power of two.
    pub reduction_ratio: u16,
    /// Phase of the input frames in the reduction, 1 to the reduction ratio.
    pub phase_in: u16,
    /// Phase of the output frames in the reduction, 1 to the reduction ratio.
    pub phase_out: u16,
    /// IOCRReference of the inputs and of the outputs; they differ.
    pub iocr_references: (u16, u16),
    /// Which class of frame ids: RT_CLASS_1 or RT_CLASS_2.
    pub rt_class: RtClass,
    /// Cycles without a frame until a consumer objects; 1 to 7680.
    pub watchdog_factor: u16,
    /// Cycles without a frame until a consumer ends the AR, ours as well; from the watchdog factor to 7680.
    pub data_hold_factor: u16,
    /// The frame id that is proposed for the input frames.
    pub frame_id_in: u16,
    /// The frame id that is proposed for the output frames; 0xFFFF leaves it to the device.
    pub frame_id_out: u16,
    /// Whether our cyclic frames and alarms carry an 802.1Q tag (priority 6; alarms of low priority 5).
    pub vlan: bool,
    /// IOCRTagHeader of both cyclic connections: priority in the upper three bits, VLAN below.
    pub iocr_tag: u16,
    /// AlarmCRTagHeaderHigh and AlarmCRTagHeaderLow, which our alarms of high and of low priority carry too.
    pub alarm_tags: (u16, u16),
    /// LocalAlarmReference; none: a new one for each AR.
    pub alarm_reference: Option<u16>,
    /// RTATimeoutFactor: how long an alarm endpoint waits for an acknowledgement; unit 100 ms, 1 to 100.
    pub rta_timeout_factor: u16,
    /// RTARetries: how often it repeats; 3 to 15.
    pub rta_retries: u16,
    /// MaxAlarmDataLength: most octets of an alarm that we take; 200 to 1432.
    pub max_alarm_data_length: u16,
    /// Whether our RPC headers are little-endian.
    pub little_endian: bool,
    /// How long ApplicationReady is waited for after PrmEnd.
    pub application_ready: Duration,
    /// How long the first good data are waited for after ApplicationReady.
    pub first_data: Duration,
    /// Whether the limits are left unchecked, to see what the device says to values beyond them.
    pub unchecked: bool,
}

/// The order in which IEC 61158-6-10 names the blocks; what is passed along comes last.
const DEFAULT_ORDER: [ConnectPart; 5] =
    [ConnectPart::Inputs, ConnectPart::Outputs, ConnectPart::Submodules, ConnectPart::Alarms, ConnectPart::Extra];

impl Connection {
    /// A connection to `device` with usual values: IO controller, legacy start-up, a cycle of 2 ms, watchdog of ten cycles, RT_CLASS_1,
    /// tagged frames, alarms of up to 200 octets, no submodules, no records.
    pub fn new(device: DeviceAddress, ip: IpParameter) -> Connection {
        Connection {
            device,
            search: Duration::from_secs(5),
            ip,
            gives_address: true,
            vendor_id: 0,
            device_id: 0,
            instance: 1,
            ar_type: ArType::IOCAR_SINGLE,
            startup: StartUpMode::Legacy,
            device_access: false,
            properties: ArProperties(0),
            activity_timeout_factor: 600,
            order: DEFAULT_ORDER.to_vec(),
            extra_blocks: Vec::new(),
            args_maximum: None,
            same_uuid: false,
            reconnect: None,
            station_name: None,
            submodules: Vec::new(),
            records: Vec::new(),
            write_multiple: false,
            send_clock_factor: 32,
            reduction_ratio: 2,
            phase_in: 1,
            phase_out: 1,
            iocr_references: (1, 2),
            rt_class: RtClass::RT_CLASS_1,
            watchdog_factor: 10,
            data_hold_factor: 10,
            frame_id_in: 0xC001,
            frame_id_out: FrameId::DEVICE_CHOOSES.0,
            vlan: true,
            iocr_tag: Vlan::RT.control,
            alarm_tags: (Vlan::RT.control, Vlan::LOW_ALARM.control),
            alarm_reference: None,
            rta_timeout_factor: 1,
            rta_retries: 3,
            max_alarm_data_length: 200,
            little_endian: false,
            application_ready: Duration::from_secs(10),
            first_data: Duration::from_secs(3),
            unchecked: false,
        }
    }

    /// The time between two cyclic frames: send clock times reduction.
    pub fn cycle(&self) -> Duration {
        let clocks = u64::from(self.send_clock_factor) * u64::from(self.reduction_ratio);
        Duration::from_nanos(clocks * SEND_CLOCK_UNIT_NANOS)
    }

    /// The time without a frame after which our consumer ends the AR: cycle times data hold factor.
    pub fn data_hold_time(&self) -> Duration {
        self.cycle() * u32::from(self.data_hold_factor)
    }

    /// Whether the AR has cyclic data and alarms: every AR but one for device access.
    pub fn has_data(&self) -> bool {
        !self.device_access
    }

    /// The bits of ARProperties.
    pub fn ar_properties(&self) -> ArProperties {
        let mut all = self.properties | ArProperties::ACTIVE | ArProperties::PARAMETRIZATION_BY_INITIATOR;
        if self.device_access {
            all = all | ArProperties::DEVICE_ACCESS;
        }
        match self.startup {
            StartUpMode::Legacy => all,
            StartUpMode::Advanced => all | ArProperties::STARTUP_ADVANCED,
        }
    }
}

/// The unit of the send clock and of the cycle counter: 31.25 µs in nanoseconds.
pub(super) const SEND_CLOCK_UNIT_NANOS: u64 = 31_250;
