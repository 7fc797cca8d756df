//! What a manual says of its encoders in words and numbers: plain data, one for each model.

use crate::encoder::{Hardware, PresetMode};
use crate::profidrive::control::ControlFacts;
use crate::profidrive::life_sign::SignOfLife;
use crate::profidrive::preset_trigger::TriggerFacts;
use crate::profidrive::sensor::SensorFacts;
use crate::profidrive::telegram::Telegram;
use crate::profidrive::user_parameters::{StartLimits, UserParameters};
use core::time::Duration;
use device_stack::profinet::{ResetScope, Severity};

/// The facts of a model.
#[derive(Debug)]
pub struct Facts {
    /// The encoders of the manual.
    pub variants: &'static [Variant],
    /// What all of them say of themselves.
    pub identity: Identification,
    /// How long things take.
    pub timing: Timing,
    /// Version, year, day and month of the software, as P964 and P975 have them.
    pub software: [u16; 3],
    /// Type of the unit in P964 and P975.
    pub unit_type: u16,
    /// What follows the software in P975: type class, classes and, where the manual has it, the number of the object.
    pub object_class: &'static [u16],
    /// P979: header, type, steps per revolution, two shift factors, revolutions.
    pub sensor_format: fn(&Variant) -> [u64; 6],
    /// The parameters that it has.
    pub parameters: &'static [u16],
    /// What P980 lists.
    pub listed: &'static [u16],
    /// Header of the operating status.
    pub status_header: u32,
    /// The errors, in the order in which those that come at the same time are raised; no two have the same code.
    pub errors: &'static [ErrorFact],
    /// The fault bits that the operating status announces.
    pub supported_faults: u32,
    /// The warnings.
    pub warnings: &'static [WarningFact],
    /// The warning bits that the operating status announces.
    pub supported_warnings: u32,
    /// The user parameters at delivery.
    pub default_record: fn(&Hardware) -> UserParameters,
    /// What user parameters may ask for.
    pub limits: StartLimits,
    /// Index of the record of the parameter access.
    pub parameter_access: u16,
    /// What a start without a record of user parameters is.
    pub without_record: WithoutRecord,
    /// What such a record is in data exchange.
    pub record_in_exchange: InExchange,
    /// Whether the position stands still while a preset is being carried out.
    pub stands_still_in_preset: bool,
    /// What the number of a preset value means.
    pub preset_values: PresetValues,
    /// The sensor interface.
    pub sensor: SensorFacts,
    /// The preset without a handshake; none if no telegram has it.
    pub preset_trigger: Option<TriggerFacts>,
    /// Control by PLC.
    pub control: ControlFacts,
    /// When the sign of life of the encoder goes on.
    pub sign_of_life: SignOfLife,
    /// Whether a preset is in force when its offset is stored; if not, it is in force at once and stored afterwards.
    pub preset_waits_for_memory: bool,
    /// Whether the sign of life of the controller is watched.
    pub watches_controller: bool,
    /// Whether parameter requests for any axis or drive object are answered, and not only for 0 and 1.
    pub serves_any_axis: bool,
    /// The modules of the slot of the encoder object, the default one first.
    pub modules: &'static [Module],
    /// What a factory reset clears; none if the device does not know this kind.
    pub resets: fn(ResetScope) -> Option<Reset>,
}

/// What the number of a preset value means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PresetValues {
    /// A relative preset shifts by it as a signed number; an absolute one takes it as it is. Encoder profile.
    Signed,
    /// The same, and an absolute preset takes the nearest position of the range.
    Limited,
    /// Either preset takes it as it is.
    Unsigned,
}

impl PresetValues {
    /// The units by which a preset sets or shifts the position, where there are `range` positions.
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

/// One of the encoders of a manual.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    /// Its name in the suites.
    pub name: &'static str,
    /// Manufacturer specific string of DCP.
    pub station_type: &'static str,
    /// Its order code.
    pub order_id: &'static str,
    /// The ident of the module in slot 0.
    pub access_point: u32,
    /// What its sensor tells apart.
    pub hardware: Hardware,
    /// By how many bits G1_XIST1 is aligned to the left.
    pub shift: u32,
}

/// What all encoders of a manual say of themselves.
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
    /// Software revision: a letter and three numbers.
    pub software_revision: [u8; 4],
    /// Bit n is set if I&M n is supported; 0 with I&M0 alone.
    pub im_supported: u16,
}

/// How long things take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    /// From power-up to the first answer.
    pub boot: Duration,
    /// From the end of the parameters to the first good data.
    pub ready: Duration,
    /// Until an offset is safe in memory; a preset is acknowledged afterwards.
    pub preset: Duration,
    /// A save by P971.
    pub save: Duration,
    /// The window of the velocity.
    pub velocity: Duration,
}

/// An error of the encoder object.
#[derive(Clone, Copy, Debug)]
pub struct ErrorFact {
    /// What brings it about: any of these.
    pub causes: &'static [Cause],
    /// The code in G1_XIST2; an error without one is neither shown there nor by bit 15 of G1_ZSW.
    pub code: Option<u16>,
    /// Its bits in the faults of the operating status.
    pub fault_bits: u32,
    /// The error type of its diagnosis; none if it goes without.
    pub error_type: Option<u16>,
    /// How bad its diagnosis is.
    pub severity: Severity,
    /// Whether it cannot be acknowledged while its cause is there, and its cause may last.
    pub is_persistent: bool,
    /// What its causes at the stand do to the encoder.
    pub effect: Effect,
}

/// An error without a cause, of which nothing tells: to begin the description of another one with.
pub const NO_DIAGNOSIS: ErrorFact = ErrorFact {
    causes: &[],
    code: None,
    fault_bits: 0,
    error_type: None,
    severity: Severity::Fault,
    is_persistent: false,
    effect: Effect::Nothing,
};

/// What brings an error about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// A fault of the stand, by its name.
    Stand(&'static str),
    /// The sign of life of the controller.
    LifeSign,
    /// User parameters that cannot be served.
    WrongParameters,
    /// Something that the model itself knows.
    Model,
}

/// What a fault of the stand does to the encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Nothing beside the error.
    Nothing,
    /// The memory can neither be read nor written.
    NoMemory,
    /// The scanning unit gives no reading: the position stands still.
    NoReading,
}

/// A warning of the encoder object; it is there as long as its cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WarningFact {
    /// The fault of the stand that brings it about; without one the model knows when.
    pub cause: Option<&'static str>,
    /// Its bit in the warnings of the operating status.
    pub bit: u32,
    /// The error type of its diagnosis; none if it goes without.
    pub error_type: Option<u16>,
    /// How bad its diagnosis is.
    pub severity: Severity,
}

/// What a start without a record of user parameters is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WithoutRecord {
    /// The parameters at delivery are in force.
    Default,
    /// They are in force, and wrong parameters are reported.
    Error,
}

/// What a record of user parameters is in data exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InExchange {
    /// It is refused.
    Refused,
    /// It is in force at once.
    InForce,
}

/// A module that can be plugged into the slot of the encoder object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Module {
    /// Its ident.
    pub ident: u32,
    /// The ident of its parameter access point.
    pub access_point: u32,
    /// Its submodules with data; those of one subslot are alternatives, the default one first.
    pub submodules: &'static [Submodule],
}

/// A submodule with data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Submodule {
    /// Its subslot.
    pub subslot: u16,
    /// Its ident.
    pub ident: u32,
    /// What it carries.
    pub telegram: &'static Telegram,
}

/// What a factory reset clears.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reset {
    /// What the encoder object has stored.
    pub application: bool,
    /// Name and addresses.
    pub station: bool,
}

impl Reset {
    /// What each kind of reset clears where the manual says nothing else: what its name says, and all of it for a factory reset.
    pub fn of(scope: ResetScope) -> Option<Reset> {
        match scope {
            ResetScope::Factory | ResetScope::AllData | ResetScope::Device => {
                Some(Reset { application: true, station: true })
            }
            ResetScope::ApplicationData => Some(Reset { application: true, station: false }),
            ResetScope::Communication => Some(Reset { application: false, station: true }),
            ResetScope::Engineering | ResetScope::FactoryImage | ResetScope::Other(_) => None,
        }
    }
}
