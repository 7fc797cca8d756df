//! SICK AFS60 and AFM60 with PROFINET, from their operating instructions.
//!
//! Whatever is not printed in the manual is marked as invented. Interpretations, where it is silent or contradicts itself:
//!
//! - Errors are latched until they are acknowledged; warnings follow their cause.
//! - The reset by DCP is not described; modes 1, 2, 4 and 8 reset the part that they name.
//! - Parameters with the format of the profile are those of the encoder object; parameters that only this encoder has are here.

mod controls;
mod encoder;
pub mod hooks;
mod leds;
mod limits;
mod parameters;
mod round_axis;
mod sensor_status;
mod service_log;
pub mod start_record;
#[cfg(test)]
mod tests;

pub use self::encoder::Afx60State;
pub use self::limits::{Limits, MonitoredSpeed};
pub use self::round_axis::RoundAxisState;
pub use self::service_log::{ServiceLog, ServiceLogBook};
pub use self::start_record::StartRecordFields;

use self::hooks::RetainedVendorData;

use crate::models::sick::settings::serves;
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profinet::{DiagnosisSeverity, StationData};
use encoder_profile::encoder::{Hardware, Scaling};
use encoder_profile::encoder_object::PoweredEncoder;
use encoder_profile::facts::{
    ClearedData, EncoderVariant, ErrorCause, ErrorFact, Identification, LateRecordEffect, ManualFacts,
    MissingRecordEffect, ModuleFacts, NO_DIAGNOSIS, PresetValues, SubmoduleFacts, TimingFacts, WarningFact,
};
use encoder_profile::profidrive::control::{ControlFacts, ControlRequested};
use encoder_profile::profidrive::life_sign::LifeSignPace;
use encoder_profile::profidrive::sensor::SensorFacts;
use encoder_profile::profidrive::telegram::STANDARD;
use encoder_profile::profidrive::user_parameters::{StartLimits, UserParameterData, VELOCITY_UNITS};

/// Returns the factory name and addresses. The name is printed in capitals, which PROFINET names cannot have.
pub fn delivered(variant: &str) -> StationData {
    let name = match variant {
        "afs60" => "afs60a",
        _ => "afm60a",
    };
    StationData { name: Vec::from(name), ..StationData::default() }
}

/// The facts of the manual.
pub static FACTS: ManualFacts = ManualFacts {
    variants: &[
        EncoderVariant {
            name: "afs60",
            station_type: "AFx60A",
            order_id: "AFS60A-xxNx262144",
            access_point: 2,
            hardware: Hardware { steps_per_revolution: 1 << 18, revolutions: 1 },
            shift: 14,
        },
        EncoderVariant {
            name: "afm60",
            station_type: "AFx60A",
            order_id: "AFM60A-xxNx018x12",
            access_point: 3,
            hardware: Hardware { steps_per_revolution: 1 << 18, revolutions: 1 << 12 },
            shift: 2,
        },
    ],
    // Vendor, device and number of ports are printed; revisions are invented.
    identity: Identification {
        vendor_id: 0x0101,
        device_id: 0x7701,
        ports: 2,
        hardware_revision: 1,
        software_revision: [b'V', 1, 4, 0],
        im_supported: 0,
    },
    // Invented: none of these is printed.
    timing: TimingFacts {
        boot: Duration::from_secs(2),
        ready: Duration::from_millis(5),
        preset: Duration::from_millis(40),
        save: Duration::from_millis(200),
        velocity: Duration::from_millis(20),
    },
    // Invented.
    software: [0x0104, 2017, 1503],
    unit_type: 0x4146,
    // Encoder interface, class 3.
    object_class: &[5, 0x4000],
    sensor_format: |variant| {
        let Hardware { steps_per_revolution, revolutions } = variant.hardware;
        [0x5111, 0x8000_0002, steps_per_revolution, variant.shift.into(), 0, revolutions]
    },
    parameters: &[922, 964, 971, 975, 979, 980, 61001, 65000, 65001],
    listed: &[
        922, 964, 965, 971, 975, 979, 1000, 1001, 1002, 1003, 1004, 1005, 1006, 1007, 1009, 1010, 1011, 1012, 1013,
        1014, 61000, 61001, 61002, 61003, 61004, 65000, 65001, 0,
    ],
    status_header: 0x000B_0101,
    errors: ERRORS,
    supported_faults: 0x37,
    warnings: WARNINGS,
    supported_warnings: 0x07,
    default_record,
    // Scaling: manual, 3.6.7 and 3.6.8.
    limits: StartLimits { serves, velocity_units: VELOCITY_UNITS, tolerated_failures: 0..=u8::MAX },
    parameter_access: 0xB02E,
    without_record: MissingRecordEffect::Default,
    record_in_exchange: LateRecordEffect::Refused,
    freezes_position_in_preset: false,
    preset_values: PresetValues::Unsigned,
    // Manual, 3.4.3, G1_STW and G1_ZSW: silent about errors and about a turning shaft while parked.
    sensor: SensorFacts {
        parks_while_turning: true,
        parking_clears_errors: false,
        raises_while_parked: true,
        acknowledges_while_parked: true,
        ..SensorFacts::PROFILE
    },
    preset_trigger: None,
    // Manual, 3.4.3, STW2_ENC and ZSW2_ENC.
    control: ControlFacts {
        requested: ControlRequested::WithoutCompatibility,
        accepts_held_preset: false,
        ..ControlFacts::PROFILE
    },
    sign_of_life: LifeSignPace::EachFrame,
    preset_waits_for_memory: true,
    monitors_controller: false,
    longest_name: 240,
    serves_any_axis: true,
    // Idents are invented, except for the numbers of the telegrams and FFFFh.
    modules: &[ModuleFacts { ident: 1, access_point: 0xFFFF, submodules: SUBMODULES }],
    resets: ClearedData::of,
};

const SUBMODULES: &[SubmoduleFacts] = &[
    SubmoduleFacts { subslot: 2, ident: 81, telegram: &STANDARD[0] },
    SubmoduleFacts { subslot: 2, ident: 82, telegram: &STANDARD[1] },
    SubmoduleFacts { subslot: 2, ident: 83, telegram: &STANDARD[2] },
    SubmoduleFacts { subslot: 2, ident: 84, telegram: &STANDARD[3] },
];

/// Fault bits that turn the LED of the encoder red.
const POSITION_OR_MEMORY: u32 = 1 | 1 << 5;

/// The errors. The model checks the causes of the supply and temperature codes itself.
const ERRORS: &[ErrorFact] = &[
    ErrorFact {
        causes: &[
            // What a bench calls a fault of the scanning unit without knowing the manual.
            ErrorCause::Stand("sensor"),
            ErrorCause::Stand("sensor_module"),
            ErrorCause::Stand("multiturn_update"),
            ErrorCause::Stand("multiturn_synchronization"),
            ErrorCause::Stand("singleturn_calculation"),
            ErrorCause::Stand("vector_multiturn"),
            ErrorCause::Stand("vector_singleturn"),
            ErrorCause::Stand("amplitude_singleturn"),
            ErrorCause::Stand("amplitude_multiturn"),
            ErrorCause::Stand("main_unit"),
            ErrorCause::Model,
        ],
        code: Some(0x0001),
        fault_bits: 1,
        error_type: Some(0x900A),
        ..LASTING
    },
    ErrorFact {
        causes: &[
            ErrorCause::Stand("eeprom_checksum"),
            ErrorCause::Stand("main_unit"),
            ErrorCause::Stand("area_sensor"),
            ErrorCause::Stand("area_device"),
            ErrorCause::Stand("area_process"),
            ErrorCause::Stand("area_service"),
            ErrorCause::Stand("area_communication"),
            ErrorCause::Stand("area_basic"),
        ],
        code: Some(0x1001),
        fault_bits: 1 << 5,
        error_type: Some(0x9000),
        ..LASTING
    },
    ErrorFact {
        causes: &[ErrorCause::Model],
        code: Some(UNDERVOLTAGE),
        fault_bits: 1 << 1,
        error_type: Some(0x9002),
        ..LASTING
    },
    ErrorFact {
        causes: &[ErrorCause::Model],
        code: Some(OVERVOLTAGE),
        fault_bits: 1 << 2,
        error_type: Some(0x9001),
        ..LASTING
    },
    // On the alarm channel it is only a warning.
    ErrorFact { causes: &[ErrorCause::Model], code: Some(HOT), ..LASTING },
    // Not in the manual: only raised by deviations that monitor the sign of life.
    ErrorFact { causes: &[ErrorCause::LifeSign], code: Some(0x0F02), ..LASTING },
    ErrorFact { causes: &[ErrorCause::Stand("unsupported_command")], code: Some(0x0F01), ..LASTING },
    ErrorFact {
        causes: &[ErrorCause::Stand("commissioning")],
        fault_bits: 1 << 4,
        error_type: Some(0x9011),
        ..LASTING
    },
];

const LASTING: ErrorFact = ErrorFact { is_persistent: true, ..NO_DIAGNOSIS };
const UNDERVOLTAGE: u16 = 0x1003;
const OVERVOLTAGE: u16 = 0x1004;
const HOT: u16 = 0x0F05;

/// Bits of the warnings that the model raises itself.
const FREQUENCY: u32 = 1;
const TEMPERATURE: u32 = 1 << 1;

const WARNINGS: &[WarningFact] = &[
    WarningFact {
        cause: None,
        bit: FREQUENCY,
        error_type: Some(0x9010),
        severity: DiagnosisSeverity::MaintenanceRequired,
    },
    WarningFact {
        cause: None,
        bit: TEMPERATURE,
        error_type: Some(0x9005),
        severity: DiagnosisSeverity::MaintenanceRequired,
    },
    WarningFact {
        cause: Some("led_current"),
        bit: 1 << 2,
        error_type: Some(0x9006),
        severity: DiagnosisSeverity::MaintenanceRequired,
    },
];

/// 0x36 with 262144 units per revolution; the velocity unit is revolutions per minute (figure 13).
fn default_record(hardware: &Hardware) -> UserParameterData {
    UserParameterData::of(0x36, Scaling::hardware(hardware), 1, 3)
}
