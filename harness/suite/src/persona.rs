//! A persona: the manner in which a controller addresses a device.
//!
//! Everything that a persona does not say is as our controller does it anyway, and what a case says wins over both. This
//! module must not know how a Connect is built, nor who plays the controller.

use std::time::Duration;

/// The unit of the send clock: 31.25 us in nanoseconds.
const SEND_CLOCK_UNIT_NANOS: u64 = 31_250;

/// The manner of a controller. A field without a value leaves it as it is without a persona.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Persona {
    /// The name, which `--persona` takes.
    pub name: String,
    /// What is special about it, in one sentence.
    pub why: String,
    /// Where it was seen.
    pub source: String,
    /// The name of the controller's station in the Connect.
    pub station_name: Option<String>,
    /// Whether it asks for advanced start-up.
    pub advanced: Option<bool>,
    /// Whether its RPC is little-endian.
    pub little_endian: Option<bool>,
    /// The order of the blocks after the ARBlockReq.
    pub order: Option<Vec<ConnectBlock>>,
    /// Blocks that are passed along, headers included.
    pub extra: Vec<u8>,
    /// Whether start-up records go in one Write.
    pub write_multiple: Option<bool>,
    /// Whether start-up records go in the reverse order.
    pub records_reversed: bool,
    /// Which submodules it expects besides those of the module.
    pub expects: Expects,
    /// The cycle of connections that say none.
    pub cycle: Option<BusCycle>,
    /// Watchdog factor and data hold factor.
    pub factors: Option<(u16, u16)>,
    /// The class of the cyclic frames, with the frame ids of inputs and outputs.
    pub class: Option<FrameClass>,
    /// Whether frames carry tags.
    pub tagged: Option<bool>,
    /// The tags of cyclic frames, of alarms of high and of low priority.
    pub tags: [Option<u16>; 3],
    /// The IOCRReferences of inputs and outputs.
    pub iocr_references: Option<(u16, u16)>,
    /// The LocalAlarmReference.
    pub alarm_reference: Option<u16>,
    /// RTATimeoutFactor, in units of 100 ms.
    pub rta_timeout: Option<u16>,
    /// RTARetries.
    pub rta_retries: Option<u16>,
    /// MaxAlarmDataLength, in octets.
    pub max_alarm: Option<u16>,
    /// CMInitiatorActivityTimeoutFactor, in units of 100 ms.
    pub activity_timeout: Option<u16>,
    /// ARArgsMaximum of the Connect, in octets.
    pub args_max: Option<u32>,
    /// What it does after a loss.
    pub reconnect: Option<Again>,
}

/// A block of the Connect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConnectBlock {
    /// The cyclic connection of the inputs.
    Inputs,
    /// The cyclic connection of the outputs.
    Outputs,
    /// The submodules that are expected.
    Submodules,
    /// The alarms.
    Alarms,
    /// What is passed along.
    Extra,
}

/// Which submodules a controller expects besides those of the module.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Expects {
    /// None.
    Module,
    /// Those of the device access point that `device.yaml` lists.
    #[default]
    AccessPoint,
    /// Those, and the interface and the ports that `device.yaml` lists under `network`.
    InterfaceAndPorts,
}

/// The cycle of a persona.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusCycle {
    /// The send clock in units of 31.25 us.
    pub send_clock: u16,
    /// A frame in each n-th send clock.
    pub reduction: u16,
    /// The phase of the inputs.
    pub phase_in: u16,
    /// The phase of the outputs.
    pub phase_out: u16,
}

impl BusCycle {
    /// The time between two frames.
    pub fn time(self) -> Duration {
        Duration::from_nanos(u64::from(self.send_clock) * u64::from(self.reduction) * SEND_CLOCK_UNIT_NANOS)
    }
}

/// The class of the cyclic frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameClass {
    /// 1 or 2.
    pub rt: u8,
    /// The frame id that is proposed for the inputs.
    pub frame_id_in: u16,
    /// The frame id that is proposed for the outputs; 0xFFFF leaves it to the device.
    pub frame_id_out: u16,
}

/// What a controller does after a connection was lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Again {
    /// How long after the loss it connects again.
    pub after: Duration,
    /// Whether the connection has the same ARUUID again.
    pub same_uuid: bool,
}
