//! SICK AFS60 and AFM60 with PROFINET, from their operating instructions.
//!
//! What the manual does not print is said to be invented. Readings, where it is silent or contradicts itself:
//!
//! - Errors are latched until they are acknowledged; warnings follow their cause.
//! - The reset by DCP is not described; it clears name and addresses.
//! - Parameters of the form of the profile are those of the encoder object; what is this encoder's own has a room here.

use crate::application::{ResetScope, Severity, StationData};
use crate::encoder::{Direction, Hardware};
use crate::encoder_object::{
    Cause, Effect, ErrorFact, Facts, Identification, InExchange, Module, Reset, Submodule, Timing, Variant,
    WarningFact, WithoutRecord,
};
use crate::profidrive::telegram::STANDARD;
use crate::profidrive::user_parameters::UserParameters;
use alloc::vec::Vec;
use core::time::Duration;

/// Name and addresses at delivery: the name is printed, in capitals.
pub fn delivered(variant: &str) -> StationData {
    StationData { name: Vec::from(variant), ..StationData::default() }
}

/// What the manual says in words and numbers.
pub static FACTS: Facts = Facts {
    variants: &[
        Variant {
            name: "afs60",
            station_type: "AFS60A",
            order_id: "AFS60A-xxNx262144",
            access_point: 1,
            hardware: Hardware { steps_per_revolution: 1 << 18, revolutions: 1 },
            shift: 14,
        },
        Variant {
            name: "afm60",
            station_type: "AFM60A",
            order_id: "AFM60A-xxNx018x12",
            access_point: 2,
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
    // None of these is printed.
    timing: Timing {
        boot: Duration::from_secs(2),
        ready: Duration::from_millis(5),
        preset: Duration::from_millis(40),
        save: Duration::from_millis(200),
        velocity: Duration::from_millis(100),
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
        922, 964, 965, 971, 975, 979, 980, 1000, 1001, 1002, 1003, 1004, 1005, 1006, 1007, 1009, 1010, 1011, 1012,
        1013, 1014, 61000, 61001, 61002, 61003, 61004, 65000, 65001, 0,
    ],
    status_header: 0x000B_0101,
    errors: ERRORS,
    supported_faults: 0x37,
    warnings: WARNINGS,
    supported_warnings: 0x07,
    default_record,
    without_record: WithoutRecord::Default,
    record_in_exchange: InExchange::Refused,
    stands_still_in_preset: false,
    watches_controller: false,
    // Idents are invented but for the numbers of the telegrams and FFFFh.
    modules: &[Module { ident: 1, access_point: 0xFFFF, submodules: SUBMODULES }],
    resets: |scope| match scope {
        ResetScope::Factory | ResetScope::Communication | ResetScope::AllData | ResetScope::Device => {
            Some(Reset { application: false, station: true })
        }
        ResetScope::ApplicationData | ResetScope::Engineering | ResetScope::FactoryImage | ResetScope::Other(_) => None,
    },
};

const SUBMODULES: &[Submodule] = &[
    Submodule { subslot: 2, ident: 81, telegram: &STANDARD[0] },
    Submodule { subslot: 2, ident: 82, telegram: &STANDARD[1] },
    Submodule { subslot: 2, ident: 83, telegram: &STANDARD[2] },
    Submodule { subslot: 2, ident: 84, telegram: &STANDARD[3] },
];

/// Which faults the stand can bring about; what brings about code 1003h, 1004h and 0F05h the model knows by itself.
const ERRORS: &[ErrorFact] = &[
    ErrorFact {
        causes: &[
            Cause::Stand("sensor_module"),
            Cause::Stand("multiturn_update"),
            Cause::Stand("multiturn_synchronization"),
            Cause::Stand("singleturn_calculation"),
            Cause::Stand("vector_multiturn"),
            Cause::Stand("vector_singleturn"),
            Cause::Stand("amplitude_singleturn"),
            Cause::Stand("amplitude_multiturn"),
            Cause::Stand("main_unit"),
        ],
        code: Some(0x0001),
        fault_bits: 1,
        error_type: Some(0x900A),
        ..BY_THE_MODEL
    },
    ErrorFact {
        causes: &[
            Cause::Stand("eeprom_checksum"),
            Cause::Stand("main_unit"),
            Cause::Stand("area_sensor"),
            Cause::Stand("area_device"),
            Cause::Stand("area_process"),
            Cause::Stand("area_service"),
            Cause::Stand("area_communication"),
            Cause::Stand("area_basic"),
        ],
        code: Some(0x1001),
        fault_bits: 1 << 5,
        error_type: Some(0x9000),
        ..BY_THE_MODEL
    },
    ErrorFact { code: Some(0x1003), fault_bits: 1 << 1, error_type: Some(0x9002), ..BY_THE_MODEL },
    ErrorFact { code: Some(0x1004), fault_bits: 1 << 2, error_type: Some(0x9001), ..BY_THE_MODEL },
    ErrorFact { code: Some(0x0F05), error_type: Some(0x9005), ..BY_THE_MODEL },
    ErrorFact { causes: &[Cause::Stand("unsupported_command")], code: Some(0x0F01), ..BY_THE_MODEL },
    ErrorFact {
        causes: &[Cause::Stand("commissioning"), Cause::WrongParameters],
        fault_bits: 1 << 4,
        error_type: Some(0x9011),
        ..BY_THE_MODEL
    },
];

const BY_THE_MODEL: ErrorFact = ErrorFact {
    causes: &[Cause::Model],
    code: None,
    fault_bits: 0,
    error_type: None,
    severity: Severity::Fault,
    is_persistent: true,
    effect: Effect::Nothing,
};

const WARNINGS: &[WarningFact] = &[
    WarningFact { cause: None, bit: 1, error_type: Some(0x9010), severity: Severity::MaintenanceRequired },
    WarningFact { cause: None, bit: 2, error_type: Some(0x9005), severity: Severity::MaintenanceRequired },
    WarningFact {
        cause: Some("led_current"),
        bit: 4,
        error_type: Some(0x9006),
        severity: Severity::MaintenanceRequired,
    },
];

/// 0x36 with 262144 units a revolution; the unit is revolutions a minute.
fn default_record(hardware: &Hardware) -> UserParameters {
    UserParameters {
        bits: 0x36,
        direction: Direction::Clockwise,
        class_4: true,
        preset_acts_on_xist1: false,
        scaling: false,
        alarm_channel: true,
        compatible: false,
        units_per_revolution: hardware.steps_per_revolution,
        range: hardware.range(),
        life_sign_failures: 1,
        speed_unit: 3,
    }
}
