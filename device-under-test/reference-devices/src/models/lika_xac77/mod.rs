//! Lika XAC7718/1PT and XAC7716/16384PT with PROFINET, from the user guide MAN XAC77 PT E 1.3.
//!
//! Interpretations, where the manual is silent or contradicts itself. Those of the encoder profile are in `encoder-profile`.
//!
//! - A record 0xBF00 of another length is refused and changes nothing. A record of the right length is accepted; invalid
//!   values in it are reported as a parametrization fault (0x1002, P65001, diagnosis 0x9011), and instead of an invalid
//!   scaling the hardware resolution is used. The record belongs to the start-up: in data exchange it is refused.
//! - Each connection begins with the default parameters; the record of this start overrides them.
//! - A preset is carried out when its offset is stored in memory: then, in one frame, the position is shifted and bit 12
//!   is set. With class 4 off the handshake runs and nothing is shifted. The offset is reduced to the range,
//!   0 to range - 1. Presets work during an alarm.
//! - With G1_XIST1 preset control off, G1_XIST1 is the position without any offset.
//! - While parked, G1_XIST3 and the velocity are 0, like the other positions. A preset request that is held through
//!   parking is not a new request. Parking is refused (0x0003) while the shaft turns.
//! - Withdrawing Control by PLC voids all requests of G1_STW, including parking; positions continue.
//! - A failed save leaves P971 at 1. P971 accepts 0 and 1.
//! - The factory reset of the manual is suboption 5; of suboption 6, modes 1, 2, 4 and 8 reset the part that they name.
//! - P979 has elements of 32 bits, as its values require; its resolution and revolutions are those of the hardware.
//! - P925 does not exist, since P980 does not list it. LEDs are not described.

pub mod hooks;
#[cfg(test)]
mod tests;
pub mod web;

pub use web::Xac77State;

use core::time::Duration;
use encoder_profile::encoder::{Hardware, Scaling};
use encoder_profile::facts::{
    ClearedData, EncoderVariant, ErrorCause, ErrorFact, FaultEffect, Identification, LateRecordEffect, ManualFacts,
    MissingRecordEffect, ModuleFacts, NO_DIAGNOSIS, PresetValues, SubmoduleFacts, TimingFacts,
};
use encoder_profile::profidrive::control::ControlFacts;
use encoder_profile::profidrive::life_sign::LifeSignPace;
use encoder_profile::profidrive::sensor::SensorFacts;
use encoder_profile::profidrive::telegram::STANDARD;
use encoder_profile::profidrive::user_parameters::{self, StartLimits, UserParameterData, VELOCITY_UNITS};

/// The facts of the manual.
pub static FACTS: ManualFacts = ManualFacts {
    variants: &[
        EncoderVariant {
            name: "xac7718",
            station_type: "LIKA ROTACOD",
            order_id: "XAC7718/1PT",
            access_point: 2,
            hardware: Hardware { steps_per_revolution: 1 << 18, revolutions: 1 },
            shift: 0,
        },
        EncoderVariant {
            name: "xac7716-16384",
            station_type: "LIKA ROTACOD",
            order_id: "XAC7716/16384PT",
            access_point: 3,
            hardware: Hardware { steps_per_revolution: 1 << 16, revolutions: 1 << 14 },
            shift: 0,
        },
    ],
    // The device ID is not printed in the manual; invented.
    identity: Identification {
        vendor_id: 0x0239,
        device_id: 1,
        ports: 1,
        hardware_revision: 1,
        software_revision: [b'V', 1, 1, 0],
        im_supported: 0,
    },
    // The manual prints 100 ms for the velocity (10.1); the rest is invented.
    timing: TimingFacts {
        boot: Duration::from_secs(2),
        ready: Duration::from_millis(5),
        preset: Duration::from_millis(40),
        save: Duration::from_millis(200),
        velocity: Duration::from_millis(100),
    },
    // Software 1.10 of 24 October 2013: version table on p. 43, date of the first description file.
    software: [110, 2013, 2410],
    unit_type: 1,
    // Encoder interface, class 4, number of this object.
    object_class: &[5, 0x8000, 1],
    // Rotary and valid.
    sensor_format: |variant| {
        let Hardware { steps_per_revolution, revolutions } = variant.hardware;
        [0x5011, 0x8000_0000, steps_per_revolution, 0, 0, revolutions]
    },
    parameters: &[922, 964, 965, 971, 975, 979, 980, 61001, 65000, 65001],
    listed: &[922, 964, 965, 971, 975, 979, 61001, 65000, 65001],
    status_header: 0x000C_0101,
    errors: ERRORS,
    supported_faults: MEMORY | COMMISSIONING,
    warnings: &[],
    supported_warnings: 0,
    default_record,
    limits: StartLimits {
        serves: user_parameters::serves,
        velocity_units: VELOCITY_UNITS,
        tolerated_failures: 1..=u8::MAX,
    },
    parameter_access: 0xB02E,
    without_record: MissingRecordEffect::Default,
    record_in_exchange: LateRecordEffect::Refused,
    freezes_position_in_preset: false,
    preset_values: PresetValues::Signed,
    sensor: SensorFacts::PROFILE,
    preset_trigger: None,
    control: ControlFacts::PROFILE,
    sign_of_life: LifeSignPace::EachFrame,
    preset_waits_for_memory: true,
    monitors_controller: true,
    longest_name: 127,
    serves_any_axis: false,
    modules: &[ModuleFacts { ident: 1, access_point: 2, submodules: SUBMODULES }],
    resets: ClearedData::of,
};

/// Fault bit of the memory.
const MEMORY: u32 = 1 << 5;
/// Fault bit of the parametrization.
const COMMISSIONING: u32 = 1 << 4;

/// Codes: manual, 16.4; error types: 12.2.1. The code of the sensor is that of the profile, since the manual prints none.
const ERRORS: &[ErrorFact] = &[
    ErrorFact { causes: &[ErrorCause::LifeSign], code: Some(0x0F02), ..NO_DIAGNOSIS },
    ErrorFact {
        causes: &[ErrorCause::Stand("memory")],
        code: Some(0x1001),
        fault_bits: MEMORY,
        error_type: Some(0x9000),
        is_persistent: true,
        effect: FaultEffect::NoMemory,
        ..NO_DIAGNOSIS
    },
    ErrorFact {
        causes: &[ErrorCause::Stand("sensor")],
        code: Some(0x0001),
        effect: FaultEffect::NoReading,
        ..NO_DIAGNOSIS
    },
    ErrorFact {
        causes: &[ErrorCause::Stand("commissioning"), ErrorCause::WrongParameters],
        code: Some(0x1002),
        fault_bits: COMMISSIONING,
        error_type: Some(0x9011),
        is_persistent: true,
        ..NO_DIAGNOSIS
    },
];

/// The manual prints no idents, only the numbers of the access points, which are used as their idents. All other idents and the
/// API of slot 0 are invented.
const SUBMODULES: &[SubmoduleFacts] = &[
    SubmoduleFacts { subslot: 2, ident: 81, telegram: &STANDARD[0] },
    SubmoduleFacts { subslot: 2, ident: 82, telegram: &STANDARD[1] },
    SubmoduleFacts { subslot: 2, ident: 83, telegram: &STANDARD[2] },
    SubmoduleFacts { subslot: 2, ident: 84, telegram: &STANDARD[3] },
];

/// The default user parameters for this hardware (manual, chapter 18): byte 0 is 0x22.
fn default_record(hardware: &Hardware) -> UserParameterData {
    UserParameterData::of(0x22, Scaling::hardware(hardware), 1, 0)
}
