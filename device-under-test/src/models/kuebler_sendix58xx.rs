//! Kübler Sendix 58xx absolute encoders with PROFINET, from their PROFINET manual.
//!
//! What the manual does not print is said to be invented. Readings, where it is silent or contradicts itself:
//!
//! - Errors are the present state: nothing is latched and nothing is acknowledged.
//! - A preset is carried out within 40 ms; the position stands still until then.
//! - A record 0xBF00 is taken in data exchange too and in force at once; without one in the start the user parameters are
//!   wrong (0x1002), and the connection stands.

use crate::application::{ResetScope, Severity};
use crate::encoder::{Direction, Hardware};
use crate::encoder_object::{
    Cause, Effect, ErrorFact, Facts, Identification, InExchange, Module, Reset, Submodule, Timing, Variant,
    WarningFact, WithoutRecord,
};
use crate::profidrive::telegram::{Control, STANDARD, Signal, Telegram};
use crate::profidrive::user_parameters::UserParameters;
use core::time::Duration;

/// What the manual says in words and numbers.
pub static FACTS: Facts = Facts {
    variants: &[
        Variant {
            name: "sendix-singleturn",
            hardware: Hardware { steps_per_revolution: 65536, revolutions: 1 },
            ..SENDIX
        },
        Variant {
            name: "sendix-multiturn",
            hardware: Hardware { steps_per_revolution: 65536, revolutions: 4096 },
            ..SENDIX
        },
    ],
    identity: Identification {
        vendor_id: 0x0198,
        device_id: 0x0001,
        ports: 2,
        hardware_revision: 2,
        software_revision: [b'V', 3, 0, 0],
        im_supported: 0,
    },
    // 40 ms are printed as the longest preset and 1 s as the window of the velocity; the rest is invented.
    timing: Timing {
        boot: Duration::from_secs(2),
        ready: Duration::from_millis(5),
        preset: Duration::from_millis(38),
        save: Duration::from_millis(200),
        velocity: Duration::from_secs(1),
    },
    // There is no parameter that tells them.
    software: [300, 0, 0],
    unit_type: 0,
    object_class: &[],
    sensor_format: |_| [0; 6],
    parameters: &[65000],
    listed: &[],
    status_header: 0x000B_0101,
    errors: ERRORS,
    supported_faults: 0x21,
    warnings: WARNINGS,
    supported_warnings: 0x07,
    default_record,
    without_record: WithoutRecord::Error,
    record_in_exchange: InExchange::InForce,
    stands_still_in_preset: true,
    watches_controller: false,
    modules: MODULES,
    resets: |scope| match scope {
        ResetScope::Factory | ResetScope::Communication | ResetScope::AllData | ResetScope::Device => {
            Some(Reset { application: false, station: true })
        }
        ResetScope::ApplicationData | ResetScope::Engineering | ResetScope::FactoryImage | ResetScope::Other(_) => None,
    },
};

const SENDIX: Variant = Variant {
    name: "",
    station_type: "KUEBLER",
    // The pattern is printed, its digits are invented.
    order_id: "8.58X8.XXCX.C2XX",
    access_point: 3,
    hardware: Hardware { steps_per_revolution: 65536, revolutions: 1 },
    shift: 0,
};

const ERRORS: &[ErrorFact] = &[
    ErrorFact {
        causes: &[Cause::Stand("sensor")],
        code: Some(0x0001),
        fault_bits: 1,
        effect: Effect::NoReading,
        ..NO_DIAGNOSIS
    },
    ErrorFact {
        causes: &[Cause::Stand("memory")],
        code: Some(0x0020),
        fault_bits: 1 << 5,
        effect: Effect::NoMemory,
        ..NO_DIAGNOSIS
    },
    ErrorFact { causes: &[Cause::WrongParameters], code: Some(0x1002), ..NO_DIAGNOSIS },
];

const NO_DIAGNOSIS: ErrorFact = ErrorFact {
    causes: &[],
    code: None,
    fault_bits: 0,
    error_type: None,
    severity: Severity::Fault,
    is_persistent: true,
    effect: Effect::Nothing,
};

/// Bit 0, the speed, is what the model knows by itself.
const WARNINGS: &[WarningFact] = &[
    WarningFact { cause: None, bit: 1, error_type: None, severity: Severity::MaintenanceRequired },
    WarningFact { cause: Some("temperature"), bit: 2, error_type: None, severity: Severity::MaintenanceRequired },
    WarningFact { cause: Some("led_current"), bit: 4, error_type: None, severity: Severity::MaintenanceRequired },
];

/// 0x2A with 8192 units a revolution and in all; octet 17 is 1. The velocity unit is invented.
fn default_record(_: &Hardware) -> UserParameters {
    UserParameters {
        bits: 0x2A,
        direction: Direction::Clockwise,
        class_4: true,
        preset_acts_on_xist1: true,
        scaling: true,
        alarm_channel: false,
        compatible: false,
        units_per_revolution: 8192,
        range: 8192,
        life_sign_failures: 1,
        speed_unit: 0,
    }
}

static MANTEL: Telegram = Telegram {
    number: 860,
    inputs: &[Signal::Position, Signal::NistB],
    input_octets: 8,
    outputs: &[Control::Preset],
    output_octets: 4,
};
static SPEED: Telegram = part(Signal::NistA, 2);
static SINGLE_TURN: Telegram = part(Signal::SingleTurn, 4);
static MULTI_TURN: Telegram = part(Signal::MultiTurn, 4);
static SEPARATE_G1_ZSW: Telegram = part(Signal::SeparateG1Zsw, 2);
static SEPARATE_G1_STW: Telegram =
    Telegram { number: 0, inputs: &[], input_octets: 0, outputs: &[Control::SeparateG1Stw], output_octets: 2 };

const fn part(signal: Signal, input_octets: u16) -> Telegram {
    let inputs: &'static [Signal] = match signal {
        Signal::NistA => &[Signal::NistA],
        Signal::SingleTurn => &[Signal::SingleTurn],
        Signal::MultiTurn => &[Signal::MultiTurn],
        _ => &[Signal::SeparateG1Zsw],
    };
    Telegram { number: 0, inputs, input_octets, outputs: &[], output_octets: 0 }
}

/// Numbers of modules and submodules are invented, but for the parts that the manual names and their order.
const MODULES: &[Module] = &[
    Module { ident: 0x10, access_point: 1, submodules: &[at(2, 860, &MANTEL)] },
    Module { ident: 0x11, access_point: 1, submodules: &[at(2, 81, &STANDARD[0])] },
    Module {
        ident: 0x12,
        access_point: 1,
        submodules: &[
            at(2, 81, &STANDARD[0]),
            at(3, 0x21, &SPEED),
            at(4, 0x22, &SINGLE_TURN),
            at(5, 0x23, &MULTI_TURN),
        ],
    },
    Module { ident: 0x13, access_point: 1, submodules: &[at(2, 860, &MANTEL), at(3, 0x25, &SEPARATE_G1_ZSW)] },
    Module {
        ident: 0x14,
        access_point: 1,
        submodules: &[
            at(2, 860, &MANTEL),
            at(3, 81, &STANDARD[0]),
            at(4, 0x21, &SPEED),
            at(5, 0x22, &SINGLE_TURN),
            at(6, 0x23, &MULTI_TURN),
            at(7, 0x24, &SEPARATE_G1_STW),
            at(8, 0x25, &SEPARATE_G1_ZSW),
        ],
    },
];

const fn at(subslot: u16, ident: u32, telegram: &'static Telegram) -> Submodule {
    Submodule { subslot, ident, telegram }
}
