//! SICK A3M60 with PROFIBUS, from its operating instructions.
//!
//! Whatever is not printed in the manual is marked as invented: the bytes of Set_Prm and of the configuration, times, the firmware
//! version. Interpretations, where the manual is silent or contradicts itself:
//!
//! - Positions have 31 bits, as the printed resolution in all places except one.
//! - Errors in G1_XIST2 are latched until they are acknowledged; all other reports follow the cause.
//! - A preset is in force at once and stored afterwards; a value beyond the range is reduced to the range.
//! - The vendor telegrams have the same round axis, diagnosis and isochronous operation as those of the profile.

mod clock;
mod controls;
mod encoder;
pub mod hooks;
mod leds;
mod parameters;
mod samples;
pub mod set_prm;
mod slave;
pub mod status;
#[cfg(test)]
mod tests;

pub use clock::{BusClock, ClockErrors, IsochronousTimes};
pub use encoder::{A3m60State, powered};
pub use parameters::{SpeedCalculation, rpm};
pub use samples::Samples;
pub use slave::Encoder;

use crate::models::sick::settings;
use core::time::Duration;
use device_stack::profinet::DiagnosisSeverity;
use encoder_profile::encoder::Hardware;
use encoder_profile::encoder_object::PoweredEncoder;
use encoder_profile::facts::{
    EncoderVariant, ErrorCause, ErrorFact, Identification, LateRecordEffect, ManualFacts, MissingRecordEffect,
    ModuleFacts, NO_DIAGNOSIS, PresetValues, SubmoduleFacts, TimingFacts, WarningFact,
};
use encoder_profile::profidrive::control::{ControlFacts, ControlRequested};
use encoder_profile::profidrive::life_sign::LifeSignPace;
use encoder_profile::profidrive::preset_trigger::{BeyondRange, TRIGGER, TriggerFacts};
use encoder_profile::profidrive::sensor::SensorFacts;
use encoder_profile::profidrive::telegram::{InputSignal, OutputWord, STANDARD, Telegram};
use encoder_profile::profidrive::user_parameters::StartLimits;

/// The factory address: manual, 4.3.
pub const ADDRESS: u8 = 2;

/// The resolution of the sensor.
const HARDWARE: Hardware = Hardware { steps_per_revolution: 1 << 14, revolutions: 1 << 17 };
/// The highest speed in revolutions per minute: manual, table 37.
const HIGHEST_SPEED: i64 = 9000;

/// The facts of the manual.
pub static FACTS: ManualFacts = ManualFacts {
    variants: &[EncoderVariant {
        name: "a3m60",
        station_type: "A3M60A",
        order_id: "A3M60A-xxPB014X17",
        access_point: 0,
        hardware: HARDWARE,
        shift: 1,
    }],
    identity: Identification {
        vendor_id: 0x0101,
        device_id: 0,
        ports: 0,
        hardware_revision: 1,
        software_revision: [b'V', 1, 3, 0],
        im_supported: 0,
    },
    // Only the velocity is printed; the rest is invented.
    timing: TimingFacts {
        boot: Duration::from_secs(1),
        ready: Duration::ZERO,
        preset: Duration::from_millis(20),
        save: Duration::from_millis(20),
        velocity: Duration::from_secs(1),
    },
    // Invented.
    software: [0x0103, 2012, 1508],
    unit_type: 0x00FF,
    // Encoder, classes 4 and 3.
    object_class: &[5, 0xC000],
    sensor_format: |variant| {
        let Hardware { steps_per_revolution, revolutions } = variant.hardware;
        [0x5111, 0x8000_0002, steps_per_revolution, variant.shift.into(), 0, revolutions]
    },
    parameters: &[922, 964, 975, 979, 65000],
    listed: &[],
    status_header: 0x000B_0101,
    errors: ERRORS,
    supported_faults: 0x37,
    warnings: &[WarningFact {
        cause: None,
        bit: FREQUENCY,
        error_type: Some(0x30),
        severity: DiagnosisSeverity::MaintenanceRequired,
    }],
    supported_warnings: 0x03,
    default_record: |_| set_prm::delivered(),
    // Manual, 3.6.9 to 3.6.11.
    limits: StartLimits {
        serves: settings::serves,
        velocity_units: settings::VELOCITY_UNITS,
        tolerated_failures: 1..=15,
    },
    parameter_access: 0xB02E,
    without_record: MissingRecordEffect::Default,
    record_in_exchange: LateRecordEffect::Refused,
    freezes_position_in_preset: false,
    preset_values: PresetValues::Signed,
    // Manual, 3.4.3, G1_STW and G1_ZSW: silent about parking while the shaft turns.
    sensor: SensorFacts { parks_while_turning: true, ..SensorFacts::PROFILE },
    // Manual, 3.4.2: bit 31 has to be 0 before, so the first word is no edge.
    preset_trigger: Some(TriggerFacts {
        value: !TRIGGER,
        beyond_range: BeyondRange::Reduced,
        first_word_counts: false,
    }),
    // Manual, table 14.
    control: ControlFacts { requested: ControlRequested::Always, ..ControlFacts::PROFILE },
    // Manual, table 14: by 1 in each cycle.
    sign_of_life: LifeSignPace::EachFrame,
    preset_waits_for_memory: false,
    monitors_controller: true,
    longest_name: 240,
    serves_any_axis: false,
    modules: &[ModuleFacts { ident: 1, access_point: 1, submodules: SUBMODULES }],
    resets: |_| None,
};

/// The subslot in which the encoder object has its telegram.
const SUBSLOT: u16 = 2;

const SUBMODULES: &[SubmoduleFacts] = &[
    SubmoduleFacts { subslot: SUBSLOT, ident: 4, telegram: &IO_04 },
    SubmoduleFacts { subslot: SUBSLOT, ident: 8, telegram: &IO_08 },
    SubmoduleFacts { subslot: SUBSLOT, ident: 81, telegram: &STANDARD[0] },
    SubmoduleFacts { subslot: SUBSLOT, ident: 83, telegram: &STANDARD[2] },
];

/// The configuration identifiers of each telegram in Chk_Cfg; invented.
pub const CONFIGURATIONS: [&[u8]; 4] =
    [&[0xF1], &[0xF3], &[0xC3, 0xC1, 0xC5, 0xFD, 0x00, 0x51], &[0xC3, 0xC1, 0xC7, 0xFD, 0x00, 0x53]];

/// Vendor telegram IO 04: tables 4 and 5.
static IO_04: Telegram = Telegram {
    number: 0,
    inputs: &[InputSignal::Position],
    input_octets: 4,
    outputs: &[OutputWord::Preset],
    output_octets: 4,
};

/// Vendor telegram IO 08: tables 6 and 7.
static IO_08: Telegram = Telegram {
    number: 0,
    inputs: &[InputSignal::Position, InputSignal::NistA, InputSignal::TimeStamp],
    input_octets: 8,
    outputs: &[OutputWord::Preset, OutputWord::Unused],
    output_octets: 8,
};

/// Whether a telegram is a vendor telegram, not one of the profile.
fn is_of_vendor(telegram: &Telegram) -> bool {
    telegram.number == 0
}

const ERRORS: &[ErrorFact] = &[
    ErrorFact { causes: &[ErrorCause::Stand("amplitude")], code: Some(ENCODER_SIGNAL), ..POSITION },
    ErrorFact { causes: &[ErrorCause::Stand("amplitude_cosine")], code: Some(ENCODER_SIGNAL), ..POSITION },
    ErrorFact { causes: &[ErrorCause::Stand("vector_length")], code: Some(ENCODER_SIGNAL), ..POSITION },
    ErrorFact { causes: &[ErrorCause::Stand("vector_length_long")], code: Some(ENCODER_SIGNAL), ..POSITION },
    ErrorFact { causes: &[ErrorCause::Stand("synchronization_large")], code: Some(0x0002), ..POSITION },
    ErrorFact { causes: &[ErrorCause::Stand("linearization")], code: Some(0x0004), ..POSITION },
    ErrorFact { causes: &[ErrorCause::Stand("synchronization_shutdown")], code: Some(0x0004), ..POSITION },
    ErrorFact { causes: &[ErrorCause::Stand("synchronization_start")], code: Some(0x0004), ..POSITION },
    ErrorFact { causes: &[ErrorCause::Stand("fram")], code: Some(0x0008), ..POSITION },
    ErrorFact { causes: &[ErrorCause::Stand("flash")], code: Some(0x1001), ..MEMORY },
    ErrorFact { causes: &[ErrorCause::Stand("eeprom_checksum")], code: Some(0x1001), ..MEMORY },
    ErrorFact { causes: &[ErrorCause::Stand("eeprom")], code: Some(0x1002), fault_bits: 1 << 5 | 1, ..MEMORY },
    ErrorFact { causes: &[ErrorCause::LifeSign], code: Some(0x0F02), error_type: Some(0x3B), ..LASTING },
    ErrorFact { causes: &[ErrorCause::Model], code: Some(CLOCK_DEVIATES), error_type: Some(0x3D), ..LASTING },
    ErrorFact { causes: &[ErrorCause::Model], code: Some(NO_CLOCK), error_type: Some(0x3C), ..LASTING },
];

const LASTING: ErrorFact = ErrorFact { is_persistent: true, ..NO_DIAGNOSIS };
const POSITION: ErrorFact = ErrorFact { fault_bits: 1, error_type: Some(0x36), ..LASTING };
const MEMORY: ErrorFact = ErrorFact { fault_bits: 1 << 5, error_type: Some(0x38), ..LASTING };
const ENCODER_SIGNAL: u16 = 0x0001;
const CLOCK_DEVIATES: u16 = 0x0F03;
const NO_CLOCK: u16 = 0x0F04;
/// Warning bit of the frequency.
const FREQUENCY: u32 = 1;
