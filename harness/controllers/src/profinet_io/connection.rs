//! The description of a start-up: the device, its submodules, the bus settings, the records.
//!
//! This module must not know how anything is sent; `limits` has the value ranges.

use super::connect_field::ConnectField;
use alloc::string::String;
use alloc::vec::Vec;
use core::time::Duration;
use wire::ethernet::{Mac, Vlan};
use wire::profinet::blocks::connect::{ArProperties, ArType, RtClass};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::rt::FrameId;

/// How to find the device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DeviceAddress {
    /// By its name of station: a DCP Identify that one station answers.
    Name(String),
    /// By its MAC address: a DCP Get to this address.
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
    /// The blocks of [`ArConfig::extra_blocks`].
    Extra,
}

/// Automatic reconnect after an AR was lost without a request of the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reconnect {
    /// Time from the end of the AR to the same start-up; zero begins it in the same tick.
    pub after: Duration,
}

/// The start-up mode of an AR: bit 30 of ARProperties.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum StartUpMode {
    /// Legacy start-up.
    #[default]
    Legacy,
    /// Advanced start-up: the response names its station in an ARServerBlock.
    Advanced,
}

/// An expected submodule, with the module that contains it. The list also includes the submodules of the DAP, the interface and
/// the ports; they have no data.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ConnectSubmodule {
    /// API of the submodule, 0 without a profile.
    pub api: u32,
    /// Slot number.
    pub slot: u16,
    /// ModuleIdentNumber of the module in this slot.
    pub module_ident: u32,
    /// Subslot number.
    pub subslot: u16,
    /// SubmoduleIdentNumber.
    pub submodule_ident: u32,
    /// Input data length in bytes (device to controller).
    pub input_octets: u16,
    /// Output data length in bytes (controller to device).
    pub output_octets: u16,
}

/// The address of a record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct RecordAddress {
    /// The API.
    pub api: u32,
    /// The slot.
    pub slot: u16,
    /// The subslot.
    pub subslot: u16,
    /// The index.
    pub index: u16,
}

/// A record to write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StartUpRecord {
    /// Its address.
    pub target: RecordAddress,
    /// Its data.
    pub data: Vec<u8>,
}

/// A start-up from the search for the device to the first valid data. Begin with [`ArConfig::new`], which sets usual values,
/// and change what differs. [`ArConfig::check`] checks the ranges.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ArConfig {
    /// The device.
    pub device: DeviceAddress,
    /// How long to search for it; the Identify or Get request is repeated during this time.
    pub search: Duration,
    /// The temporary address for the device, if it has another one.
    pub ip: IpParameter,
    /// Whether the device gets that address. If not, it is called at its own address, or at `ip` if it has none.
    pub gives_address: bool,
    /// How long to wait before the end of the parameters.
    pub parameter_pause: Duration,
    /// Vendor ID in the object UUID that is called.
    pub vendor_id: u16,
    /// Device ID in the object UUID that is called.
    pub device_id: u16,
    /// Instance in the object UUID that is called, 1 in most devices.
    pub instance: u16,
    /// The type of the AR.
    pub ar_type: ArType,
    /// The start-up mode.
    pub startup: StartUpMode,
    /// Whether the AR is for records only: no cyclic data, no submodules, no parametrization.
    pub device_access: bool,
    /// Additional bits of ARProperties; the other fields set the rest.
    pub properties: ArProperties,
    /// CMInitiatorActivityTimeoutFactor: how long the device waits for the controller's next step; unit 100 ms, 1 to 1000.
    pub activity_timeout_factor: u16,
    /// Order of the blocks after the ARBlockReq in the Connect; a part that is missing here is not sent.
    pub order: Vec<ConnectPart>,
    /// Complete blocks with their headers, added to the Connect unchanged, such as an ARFSUBlock (0x010B).
    pub extra_blocks: Vec<u8>,
    /// Fields of the Connect that have these values instead.
    pub replaced_fields: Vec<(ConnectField, u64)>,
    /// ARArgsMaximum of the Connect: maximum length of an answer; `None`: 4096.
    pub args_maximum: Option<u32>,
    /// Whether to reuse the ARUUID of the last AR, like a controller that resumes the same AR after a loss.
    pub same_uuid: bool,
    /// Whether Connect is repeated while the device has no free AR, which an AR that has just ended may still occupy. Without it the
    /// first refusal is the outcome.
    pub repeats: bool,
    /// Automatic reconnect after the AR was lost; `None`: never.
    pub reconnect: Option<Reconnect>,
    /// CMInitiatorStationName; `None`: the name of the settings. Bytes, because a tester also sends invalid names.
    pub station_name: Option<Vec<u8>>,
    /// The expected submodules in the order of the frame; those of one slot are adjacent.
    pub submodules: Vec<ConnectSubmodule>,
    /// The records written before PrmEnd, in order.
    pub records: Vec<StartUpRecord>,
    /// Whether they are written with one WriteMultiple.
    pub write_multiple: bool,
    /// Send clock; unit 31.25 µs, 1 to 128.
    pub send_clock_factor: u16,
    /// ReductionRatio: one frame in every n-th send clock; 1 to 512, a power of two.
    pub reduction_ratio: u16,
    /// Phase of the input frames in the reduction, 1 to the reduction ratio.
    pub phase_in: u16,
    /// Phase of the output frames in the reduction, 1 to the reduction ratio.
    pub phase_out: u16,
    /// IOCRReference of the inputs and of the outputs; they must differ.
    pub iocr_references: (u16, u16),
    /// The class of frame IDs: RT_CLASS_1 or RT_CLASS_2.
    pub rt_class: RtClass,
    /// Watchdog factor: cycles without a frame until the consumer reports a timeout; 1 to 7680.
    pub watchdog_factor: u16,
    /// Data hold factor: cycles without a frame until a consumer ends the AR, also in the controller; from the watchdog factor to
    /// 7680.
    pub data_hold_factor: u16,
    /// The proposed frame ID of the input frames.
    pub frame_id_in: u16,
    /// The proposed frame ID of the output frames; 0xFFFF lets the device choose.
    pub frame_id_out: u16,
    /// Whether cyclic frames and alarms of the controller carry an 802.1Q tag (priority 6; alarms of low priority 5).
    pub vlan: bool,
    /// IOCRTagHeader of both cyclic connections: priority in the upper three bits, VLAN ID below.
    pub iocr_tag: u16,
    /// AlarmCRTagHeaderHigh and AlarmCRTagHeaderLow, also the tags of the controller's alarms of high and of low priority.
    pub alarm_tags: (u16, u16),
    /// LocalAlarmReference; `None`: a new one for each AR.
    pub alarm_reference: Option<u16>,
    /// RTATimeoutFactor: how long an alarm endpoint waits for an acknowledgement; unit 100 ms, 1 to 100.
    pub rta_timeout_factor: u16,
    /// RTARetries: how often it repeats; 3 to 15.
    pub rta_retries: u16,
    /// MaxAlarmDataLength: longest alarm that the controller accepts, in bytes; 200 to 1432.
    pub max_alarm_data_length: u16,
    /// Whether the controller's RPC headers are little-endian.
    pub little_endian: bool,
    /// Timeout for ApplicationReady after PrmEnd.
    pub application_ready: Duration,
    /// Timeout for the first valid data after ApplicationReady.
    pub first_data: Duration,
    /// Whether to skip the range checks, to test how the device handles values out of range.
    pub unchecked: bool,
}

/// Default timeout of the search for the device; no standard sets it.
const SEARCH_TIMEOUT: Duration = Duration::from_secs(5);
/// Default timeout for ApplicationReady; no standard sets it.
const APPLICATION_READY_TIMEOUT: Duration = Duration::from_secs(10);
/// Default timeout for the first valid data; no standard sets it.
const FIRST_DATA_TIMEOUT: Duration = Duration::from_secs(3);

/// The order in which IEC 61158-6-10 names the blocks; extra blocks come last.
const DEFAULT_ORDER: [ConnectPart; 5] =
    [ConnectPart::Inputs, ConnectPart::Outputs, ConnectPart::Submodules, ConnectPart::Alarms, ConnectPart::Extra];

impl ArConfig {
    /// A connection to `device` with usual values: IO controller, legacy start-up, a cycle of 2 ms, watchdog of ten cycles,
    /// RT_CLASS_1, tagged frames, alarms of up to 200 bytes, no submodules, no records.
    pub fn new(device: DeviceAddress, ip: IpParameter) -> ArConfig {
        ArConfig {
            device,
            search: SEARCH_TIMEOUT,
            ip,
            gives_address: true,
            parameter_pause: Duration::ZERO,
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
            replaced_fields: Vec::new(),
            args_maximum: None,
            same_uuid: false,
            repeats: true,
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
            application_ready: APPLICATION_READY_TIMEOUT,
            first_data: FIRST_DATA_TIMEOUT,
            unchecked: false,
        }
    }

    /// The time between two cyclic frames: send clock times reduction ratio.
    pub fn cycle(&self) -> Duration {
        let clocks = u64::from(self.send_clock_factor) * u64::from(self.reduction_ratio);
        Duration::from_nanos(clocks * SEND_CLOCK_UNIT_NANOS)
    }

    /// Data hold time, after which the controller's consumer ends the AR: cycle times data hold factor.
    pub fn data_hold_time(&self) -> Duration {
        self.cycle() * u32::from(self.data_hold_factor)
    }

    /// Whether the AR has cyclic data and alarms: every AR except device access.
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
