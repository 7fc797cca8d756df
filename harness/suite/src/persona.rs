//! A persona: how a controller addresses a device.
//!
//! A setting that the persona leaves open has the default of the harness; settings of a case override both.

use std::time::Duration;

/// The unit of the send clock: 31.25 us in nanoseconds.
const SEND_CLOCK_UNIT_NANOS: u64 = 31_250;

/// The behaviour of a controller. A field without a value keeps the default of the harness.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Persona {
    /// The name, as in `--persona`.
    pub name: String,
    /// Its characteristics in one sentence.
    pub why: String,
    /// The capture or document that it is taken from.
    pub source: String,
    /// CMInitiatorStationName of the Connect.
    pub station_name: Option<String>,
    /// Whether it requests advanced start-up.
    pub advanced: Option<bool>,
    /// Whether its RPC is little-endian.
    pub little_endian: Option<bool>,
    /// The order of the blocks after the ARBlockReq.
    pub order: Option<Vec<PersonaBlock>>,
    /// Additional blocks of the Connect, including headers.
    pub extra: Vec<u8>,
    /// Whether all start-up records are sent in one Write.
    pub write_multiple: Option<bool>,
    /// Whether start-up records are sent in reverse order.
    pub records_reversed: bool,
    /// Which submodules it expects in addition to those of the module.
    pub expects: ExpectedSubmodules,
    /// Default cycle of connections.
    pub cycle: Option<BusCycle>,
    /// Watchdog factor and data hold factor.
    pub factors: Option<(u16, u16)>,
    /// RT class of the cyclic frames, with the frame ids of inputs and outputs.
    pub class: Option<FrameClass>,
    /// Whether frames have VLAN tags.
    pub tagged: Option<bool>,
    /// The VLAN tags of cyclic frames, high-priority alarms and low-priority alarms.
    pub tags: [Option<u16>; 3],
    /// The IOCRReferences of inputs and outputs.
    pub iocr_references: Option<(u16, u16)>,
    /// The LocalAlarmReference.
    pub alarm_reference: Option<u16>,
    /// RTATimeoutFactor, in units of 100 ms.
    pub rta_timeout: Option<u16>,
    /// RTARetries.
    pub rta_retries: Option<u16>,
    /// MaxAlarmDataLength, in bytes.
    pub max_alarm: Option<u16>,
    /// CMInitiatorActivityTimeoutFactor, in units of 100 ms.
    pub activity_timeout: Option<u16>,
    /// ARArgsMaximum of the Connect, in bytes.
    pub args_max: Option<u32>,
    /// How it reconnects after a connection loss.
    pub reconnect: Option<ReconnectBehavior>,
}

/// A block of the Connect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PersonaBlock {
    /// IOCRBlockReq of the inputs.
    Inputs,
    /// IOCRBlockReq of the outputs.
    Outputs,
    /// ExpectedSubmoduleBlockReq.
    Submodules,
    /// AlarmCRBlockReq.
    Alarms,
    /// The additional blocks of the persona.
    Extra,
}

/// Which submodules a controller expects in addition to those of the module.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExpectedSubmodules {
    /// No others.
    Module,
    /// Those of the device access point that `device.yaml` lists.
    #[default]
    AccessPoint,
    /// Those of the access point, and the interface and the ports that `device.yaml` lists under `network`.
    InterfaceAndPorts,
}

/// The cycle of a persona.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusCycle {
    /// The send clock in units of 31.25 us.
    pub send_clock: u16,
    /// Reduction ratio: one frame in every n-th send clock.
    pub reduction: u16,
    /// Phase of the inputs.
    pub phase_in: u16,
    /// Phase of the outputs.
    pub phase_out: u16,
}

impl BusCycle {
    /// The time between two frames.
    pub fn time(self) -> Duration {
        Duration::from_nanos(u64::from(self.send_clock) * u64::from(self.reduction) * SEND_CLOCK_UNIT_NANOS)
    }
}

/// RT class of the cyclic frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameClass {
    /// RT class 1 or 2.
    pub rt: u8,
    /// Frame id proposed for the inputs.
    pub frame_id_in: u16,
    /// Frame id proposed for the outputs; with 0xFFFF the device chooses it.
    pub frame_id_out: u16,
}

/// How a controller reconnects after a connection loss.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReconnectBehavior {
    /// Time from the loss to the next Connect.
    pub after: Duration,
    /// Whether the new connection has the same ARUUID.
    pub same_uuid: bool,
}
