//! What a reference device does at the places where it can be told to do something else.
//!
//! A [`Behaviour`] is plain data: flags, numbers and functions, each read at one seam. The healthy one is its default.
//! A [`Bug`] is a name, a sentence and what it changes in a behaviour; no code of a device ever asks for a bug.

use crate::application::Severity;
use crate::encoder::{Hardware, measuring};
use crate::models::plain;
use crate::profidrive::{life_sign, parameters, sensor, telegram, user_parameters};
use crate::profinet::StackBehaviour;

/// A deliberate deviation of a reference device from its manual.
pub struct Bug {
    /// Its name, as the suites name it under `catches`.
    pub name: &'static str,
    /// What the device does wrong, in one sentence.
    pub sentence: &'static str,
    /// What it changes in a behaviour.
    pub apply: fn(&mut Behaviour),
}

/// How a reference device behaves.
#[derive(Clone, Copy, Debug, Default)]
pub struct Behaviour {
    /// Positions and presets.
    pub measuring: measuring::Rules,
    /// Handshakes and errors of the sensor interface.
    pub sensor: sensor::Rules,
    /// Telegrams and their signals.
    pub telegram: telegram::Rules,
    /// Signs of life.
    pub life_sign: life_sign::Rules,
    /// Parameter manager.
    pub parameters: parameters::Rules,
    /// User parameters of the start-up.
    pub user_parameters: user_parameters::Rules,
    /// Control by PLC.
    pub control: Control,
    /// Values of single parameters.
    pub values: Values,
    /// What goes to memory, and when.
    pub memory: Memory,
    /// What survives a factory reset.
    pub reset: Reset,
    /// Diagnoses.
    pub diagnosis: Diagnosis,
    /// Station names.
    pub names: Names,
    /// The PROFINET stack.
    pub stack: StackBehaviour,
    /// The device after no manual.
    pub plain: plain::Rules,
}

/// Control by PLC, from whether compatibility mode is on and whether bit 10 of STW2_ENC is set.
#[derive(Clone, Copy, Debug)]
pub struct Control {
    /// Whether G1_STW is obeyed.
    pub is_valid: fn(bool, bool) -> bool,
    /// Whether bit 9 of ZSW2_ENC is set.
    pub is_requested: fn(bool, bool) -> bool,
}

impl Default for Control {
    fn default() -> Control {
        Control {
            is_valid: |compatible, by_plc| compatible || by_plc,
            is_requested: |compatible, by_plc| !compatible && by_plc,
        }
    }
}

/// Values of single parameters.
#[derive(Clone, Copy, Debug)]
pub struct Values {
    /// What P922 says of the telegram in use.
    pub telegram: fn(u16) -> u16,
    /// The version in P965, from whether compatibility mode is on.
    pub profile_version: fn(bool) -> u8,
    /// The vendor in P964 and P975.
    pub vendor: fn(u16) -> u16,
    /// The hardware that P979 describes.
    pub sensor_format: fn(Hardware) -> Hardware,
    /// How many of its numbers P980 lists.
    pub listed: usize,
    /// The operating status in P65001.
    pub operating_status: fn(u8) -> u8,
    /// The offset in P65001, from the offset and the range.
    pub offset: fn(u64, u64) -> u64,
    /// The fault word in P65001.
    pub faults: fn(u32) -> u32,
    /// Whether a value starts a save when it is written to P971; none if it is refused.
    pub saves: fn(u64) -> Option<bool>,
    /// Whether P971 stays at 1 until the save is done.
    pub save_is_shown: bool,
    /// What P65000 becomes when it is written.
    pub preset_value: fn(u32) -> u32,
    /// Whether writing P65000 carries out a preset.
    pub preset_value_presets: bool,
}

impl Default for Values {
    fn default() -> Values {
        Values {
            telegram: |number| number,
            profile_version: |compatible| if compatible { 31 } else { 41 },
            vendor: |vendor| vendor,
            sensor_format: |hardware| hardware,
            listed: usize::MAX,
            operating_status: |bits| bits,
            offset: |offset, _| offset,
            faults: |faults| faults,
            saves: |value| (value <= 1).then_some(value == 1),
            save_is_shown: true,
            preset_value: |value| value,
            preset_value_presets: false,
        }
    }
}

/// What goes to memory, and when.
#[derive(Clone, Copy, Debug)]
pub struct Memory {
    /// Whether a preset stores its offset.
    pub stores_offset: bool,
    /// Whether a preset is carried out when its offset is stored, and not before.
    pub waits_for_store: bool,
    /// Whether a preset whose offset could not be stored is given up.
    pub heeds_failure: bool,
    /// Whether P65000 is stored whenever it is written.
    pub stores_every_write: bool,
    /// Whether a preset takes P65000 as it is stored, and not as it is.
    pub presets_stored_value: bool,
    /// Whether a save comes to an end.
    pub ends_save: bool,
    /// Whether the station name is stored.
    pub stores_name: bool,
    /// Whether the user parameters survive a loss of power.
    pub keeps_user_parameters: bool,
    /// Whether the position after power-up is the one before, wherever the shaft is.
    pub keeps_position: bool,
    /// Whether a memory that cannot be read at power-up is a fault.
    pub reports_unreadable: bool,
}

impl Default for Memory {
    fn default() -> Memory {
        Memory {
            stores_offset: true,
            waits_for_store: true,
            heeds_failure: true,
            stores_every_write: false,
            presets_stored_value: false,
            ends_save: true,
            stores_name: true,
            keeps_user_parameters: false,
            keeps_position: false,
            reports_unreadable: true,
        }
    }
}

/// What a factory reset leaves alone; nothing, if healthy, whenever it comes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reset {
    /// The preset value P65000.
    pub keeps_preset_value: bool,
    /// The offset.
    pub keeps_offset: bool,
    /// The station name.
    pub keeps_name: bool,
    /// The gateway.
    pub keeps_gateway: bool,
    /// Everything while a connection exchanges data, where the reset is refused.
    pub refused_while_connected: bool,
}

/// Diagnoses in the alarm channel.
#[derive(Clone, Copy, Debug)]
pub struct Diagnosis {
    /// Whether they are sent, from compatibility mode and alarm channel control.
    pub are_sent: fn(bool, bool) -> bool,
    /// Whether several stand side by side.
    pub side_by_side: bool,
    /// Whether they go with their fault.
    pub disappear: bool,
    /// How bad they are.
    pub severity: Severity,
}

impl Default for Diagnosis {
    fn default() -> Diagnosis {
        Diagnosis {
            are_sent: |compatible, alarm_channel| !compatible || alarm_channel,
            side_by_side: true,
            disappear: true,
            severity: Severity::Fault,
        }
    }
}

/// Station names.
#[derive(Clone, Copy, Debug)]
pub struct Names {
    /// Whether an octet may stand in a label.
    pub is_allowed: fn(u8) -> bool,
    /// Whether an octet may stand at the beginning of a label.
    pub may_begin: fn(u8) -> bool,
    /// Whether an octet may stand at the end of a label.
    pub may_end: fn(u8) -> bool,
    /// Whether the labels are looked at, and not the total length alone.
    pub checks_labels: bool,
}

impl Default for Names {
    fn default() -> Names {
        Names {
            is_allowed: |octet| octet.is_ascii_alphanumeric() || octet == b'-',
            may_begin: |octet| octet != b'-',
            may_end: |octet| octet != b'-',
            checks_labels: true,
        }
    }
}
