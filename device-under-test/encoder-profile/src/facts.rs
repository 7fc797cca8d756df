//! The data of a manual about its encoders, one set for each model.

use crate::encoder::{Hardware, PresetMode};
use crate::profidrive::control::ControlFacts;
use crate::profidrive::life_sign::LifeSignPace;
use crate::profidrive::preset_trigger::TriggerFacts;
use crate::profidrive::sensor::SensorFacts;
use crate::profidrive::telegram::Telegram;
use crate::profidrive::user_parameters::{StartLimits, UserParameterData};
use core::time::Duration;
use device_stack::profinet::{DiagnosisSeverity, ResetScope};

/// The facts of one manual.
#[derive(Debug)]
pub struct ManualFacts {
    /// The encoders of the manual.
    pub variants: &'static [EncoderVariant],
    /// The identification data that all variants share.
    pub identity: Identification,
    pub timing: TimingFacts,
    /// Version, year, day and month of the software, as in P964 and P975.
    pub software: [u16; 3],
    /// Type of the unit in P964 and P975.
    pub unit_type: u16,
    /// The words after the software in P975: type class, classes and, if the manual has it, the number of the object.
    pub object_class: &'static [u16],
    /// P979: header, type, steps per revolution, two shift factors, revolutions.
    pub sensor_format: fn(&EncoderVariant) -> [u64; 6],
    /// The supported parameters.
    pub parameters: &'static [u16],
    /// The parameters in the list of P980.
    pub listed: &'static [u16],
    /// Header of the operating status.
    pub status_header: u32,
    /// The errors. If several occur at once, they are raised in this order. Codes are unique.
    pub errors: &'static [ErrorFact],
    /// The fault bits that the operating status announces.
    pub supported_faults: u32,
    /// The warnings.
    pub warnings: &'static [WarningFact],
    /// The warning bits that the operating status announces.
    pub supported_warnings: u32,
    /// The user parameters in factory state.
    pub default_record: fn(&Hardware) -> UserParameterData,
    /// The limits of user parameters.
    pub limits: StartLimits,
    /// Index of the record for parameter access.
    pub parameter_access: u16,
    /// The effect of a start without a user parameter record.
    pub without_record: MissingRecordEffect,
    /// The effect of such a record during data exchange.
    pub record_in_exchange: LateRecordEffect,
    /// Whether the position is frozen while a preset is carried out.
    pub freezes_position_in_preset: bool,
    pub preset_values: PresetValues,
    pub sensor: SensorFacts,
    /// The preset without a handshake; `None` if no telegram has it.
    pub preset_trigger: Option<TriggerFacts>,
    pub control: ControlFacts,
    /// When the sign of life of the encoder is incremented.
    pub sign_of_life: LifeSignPace,
    /// `true`: a preset takes effect when its offset is stored. `false`: it takes effect at once and is stored
    /// afterwards.
    pub preset_waits_for_memory: bool,
    /// Whether the encoder monitors the sign of life of the controller.
    pub monitors_controller: bool,
    /// How many characters a station name may have; PROFINET allows 240.
    pub longest_name: usize,
    /// Whether parameter requests for every axis or drive object are answered, not only for 0 and 1.
    pub serves_any_axis: bool,
    /// The modules for the slot of the encoder object, the default one first.
    pub modules: &'static [ModuleFacts],
    /// What a factory reset clears; `None` if the device does not support this kind.
    pub resets: fn(ResetScope) -> Option<ClearedData>,
}

/// How the number of a preset value is interpreted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PresetValues {
    /// A relative preset shifts by the signed number. An absolute preset uses it as unsigned. Encoder profile.
    Signed,
    /// The same, but an absolute preset is limited to the range of positions.
    Limited,
    /// Both presets use the number as unsigned.
    Unsigned,
}

impl PresetValues {
    /// The position, or the shift, that a preset value results in, in units. There are `range` positions.
    pub fn units(self, mode: PresetMode, value: u32, range: u64) -> u64 {
        let range = range.max(1) as i64;
        let signed = i64::from(value as i32);
        match (self, mode) {
            (PresetValues::Signed | PresetValues::Limited, PresetMode::Relative) => signed.rem_euclid(range) as u64,
            (PresetValues::Limited, PresetMode::Absolute) => signed.clamp(0, range - 1) as u64,
            (PresetValues::Signed, PresetMode::Absolute) | (PresetValues::Unsigned, _) => value.into(),
        }
    }
}

/// One encoder of a manual.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncoderVariant {
    /// Name of the variant in the suites.
    pub name: &'static str,
    /// TypeOfStation (manufacturer specific string) of DCP.
    pub station_type: &'static str,
    pub order_id: &'static str,
    /// Ident of the module in slot 0.
    pub access_point: u32,
    /// Resolution of the sensor.
    pub hardware: Hardware,
    /// Left shift of G1_XIST1 in bits.
    pub shift: u32,
}

/// The identification data that all encoders of a manual share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identification {
    /// Vendor number assigned by PI.
    pub vendor_id: u16,
    /// Number of the device family.
    pub device_id: u16,
    /// Number of Ethernet ports.
    pub ports: u16,
    /// Hardware revision.
    pub hardware_revision: u16,
    /// Software revision: prefix letter and three numbers.
    pub software_revision: [u8; 4],
    /// Bit n is set if I&M n is supported; 0 with I&M0 only.
    pub im_supported: u16,
}

/// The times of an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimingFacts {
    /// From power-up to the first answer.
    pub boot: Duration,
    /// From PrmEnd to the first good data.
    pub ready: Duration,
    /// Time to store the offset of a preset. The preset is acknowledged afterwards.
    pub preset: Duration,
    /// Time to save parameters by P971.
    pub save: Duration,
    /// Measuring window of the velocity.
    pub velocity: Duration,
}

/// An error of the encoder object.
#[derive(Clone, Copy, Debug)]
pub struct ErrorFact {
    /// The causes, any of which raises the error.
    pub causes: &'static [ErrorCause],
    /// The code in G1_XIST2. An error without a code is shown neither there nor by bit 15 of G1_ZSW.
    pub code: Option<u16>,
    /// Its bits in the faults of the operating status.
    pub fault_bits: u32,
    /// ChannelErrorType of its diagnosis; `None` without a diagnosis.
    pub error_type: Option<u16>,
    /// Severity of its diagnosis.
    pub severity: DiagnosisSeverity,
    /// Whether the cause can persist and the error cannot be acknowledged while it does.
    pub is_persistent: bool,
    /// The effect of its stand causes on the encoder.
    pub effect: FaultEffect,
}

/// An error without causes and without a report: a base for the description of other errors.
pub const NO_DIAGNOSIS: ErrorFact = ErrorFact {
    causes: &[],
    code: None,
    fault_bits: 0,
    error_type: None,
    severity: DiagnosisSeverity::Fault,
    is_persistent: false,
    effect: FaultEffect::Nothing,
};

/// A cause of an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorCause {
    /// A fault injected by the stand, by name.
    Stand(&'static str),
    /// The sign of life of the controller failed.
    LifeSign,
    /// The user parameters are invalid.
    WrongParameters,
    /// A cause that the model detects.
    Model,
}

/// The effect of a stand fault on the encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultEffect {
    /// No effect except the error.
    Nothing,
    /// The memory cannot be read or written.
    NoMemory,
    /// The scanning unit gives no reading: the position does not change.
    NoReading,
}

/// A warning of the encoder object. It is present as long as its cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WarningFact {
    /// The stand fault that causes it; `None` if the model detects the cause.
    pub cause: Option<&'static str>,
    /// Its bit in the warnings of the operating status.
    pub bit: u32,
    /// ChannelErrorType of its diagnosis; `None` without a diagnosis.
    pub error_type: Option<u16>,
    /// Severity of its diagnosis.
    pub severity: DiagnosisSeverity,
}

/// The effect of a start without a user parameter record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissingRecordEffect {
    /// The factory parameters take effect.
    Default,
    /// The factory parameters take effect, and a parameter error is reported.
    Error,
}

/// The effect of a user parameter record during data exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LateRecordEffect {
    /// The record is refused.
    Refused,
    /// The record takes effect at once.
    InForce,
}

/// A module for the slot of the encoder object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModuleFacts {
    pub ident: u32,
    /// Submodule ident of its parameter access point.
    pub access_point: u32,
    /// Its submodules with data. Those of one subslot are alternatives, the default one first.
    pub submodules: &'static [SubmoduleFacts],
}

/// A submodule with data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SubmoduleFacts {
    pub subslot: u16,
    pub ident: u32,
    pub telegram: &'static Telegram,
}

/// What a factory reset clears.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClearedData {
    /// The data that the encoder object stores.
    pub application: bool,
    /// Name and addresses.
    pub station: bool,
}

impl ClearedData {
    /// What each kind of reset clears, unless the manual says otherwise: the data of its name, and all data for a
    /// factory reset.
    pub fn of(scope: ResetScope) -> Option<ClearedData> {
        match scope {
            ResetScope::Factory | ResetScope::AllData | ResetScope::Device => {
                Some(ClearedData { application: true, station: true })
            }
            ResetScope::ApplicationData => Some(ClearedData { application: true, station: false }),
            ResetScope::Communication => Some(ClearedData { application: false, station: true }),
            ResetScope::Engineering | ResetScope::FactoryImage | ResetScope::Other(_) => None,
        }
    }
}
