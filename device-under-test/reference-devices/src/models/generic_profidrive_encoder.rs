//! A generic encoder of the PROFIdrive encoder profile on PROFINET, which follows no manual.
//!
//! It has the standard telegrams 81 to 84, 86 and 88, class 4, compatibility mode and the parameters of the profile. Source: encoder
//! profile 3.162, and PROFIdrive for the parameters below 1000. Numbers that the profile leaves to vendors are invented.

use core::time::Duration;
use encoder_profile::encoder::{Hardware, Scaling};
use encoder_profile::encoder_object::{EncoderModel, PoweredEncoder, double_word, octets_of, word, words};
use encoder_profile::facts::{
    ClearedData, EncoderVariant, ErrorCause, ErrorFact, FaultEffect, Identification, LateRecordEffect, ManualFacts,
    MissingRecordEffect, ModuleFacts, NO_DIAGNOSIS, PresetValues, SubmoduleFacts, TimingFacts,
};
use encoder_profile::profidrive::control::ControlFacts;
use encoder_profile::profidrive::life_sign::LifeSignPace;
use encoder_profile::profidrive::parameters::ParameterContent;
use encoder_profile::profidrive::preset_trigger::{BeyondRange, TRIGGER, TriggerFacts};
use encoder_profile::profidrive::sensor::SensorFacts;
use encoder_profile::profidrive::telegram::{InputSignal, OutputWord, STANDARD, Telegram};
use encoder_profile::profidrive::user_parameters::{self, StartLimits, UserParameterData, VELOCITY_UNITS};

/// The facts of the encoder.
pub static FACTS: ManualFacts = ManualFacts {
    variants: &[
        PLAIN,
        EncoderVariant { name: "singleturn", hardware: Hardware { revolutions: 1, ..PLAIN.hardware }, ..PLAIN },
    ],
    identity: Identification {
        vendor_id: 0xFEED,
        device_id: 0x00D1,
        ports: 1,
        hardware_revision: 1,
        software_revision: [b'V', 1, 0, 0],
        im_supported: 0,
    },
    timing: TimingFacts {
        boot: Duration::from_secs(2),
        ready: Duration::from_millis(5),
        preset: Duration::from_millis(20),
        save: Duration::from_millis(200),
        velocity: Duration::from_millis(100),
    },
    software: [100, 2026, 2111],
    unit_type: 1,
    // Encoder interface, class 4, number of this object.
    object_class: &[5, 0x8000, 1],
    sensor_format: |variant| {
        let Hardware { steps_per_revolution, revolutions } = variant.hardware;
        [0x5011, 0x8000_0000, steps_per_revolution, 0, 0, revolutions]
    },
    parameters: &[922, 964, 965, 971, 975, 979, 980, 61001, 65000, 65001],
    listed: &[922, 925, 964, 965, 971, 974, 975, 979, 60000, 61000, 61001, 61002, 61003, 61004, 65000, 65001, 0],
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
    preset_trigger: Some(TriggerFacts {
        value: !TRIGGER,
        beyond_range: BeyondRange::Reduced,
        first_word_counts: false,
    }),
    control: ControlFacts::PROFILE,
    sign_of_life: LifeSignPace::EachFrame,
    preset_waits_for_memory: true,
    monitors_controller: true,
    longest_name: 240,
    serves_any_axis: false,
    modules: &[ModuleFacts { ident: 0x30, access_point: 0x10, submodules: SUBMODULES }],
    resets: ClearedData::of,
};

/// A multiturn encoder; the other variant has a single turn, and so the fewest positions that the suite needs.
const PLAIN: EncoderVariant = EncoderVariant {
    name: "encoder",
    station_type: "PLAIN ENCODER",
    order_id: "PLAIN-ENCODER",
    access_point: 2,
    hardware: Hardware { steps_per_revolution: 1 << 13, revolutions: 1 << 12 },
    shift: 0,
};

/// Fault bit of the memory.
const MEMORY: u32 = 1 << 5;
/// Fault bit of the parametrization.
const COMMISSIONING: u32 = 1 << 4;

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

use InputSignal::{G1Xist1, G1Xist3, NistB, Zsw2Enc};

static TELEGRAM_86: Telegram = Telegram {
    number: 86,
    inputs: &[Zsw2Enc, G1Xist1, NistB],
    input_octets: 10,
    outputs: &[OutputWord::Stw2Enc, OutputWord::Preset],
    output_octets: 6,
};
static TELEGRAM_88: Telegram = Telegram {
    number: 88,
    inputs: &[Zsw2Enc, G1Xist3, NistB],
    input_octets: 14,
    outputs: &[OutputWord::Stw2Enc, OutputWord::LongPreset],
    output_octets: 10,
};

const SUBMODULES: &[SubmoduleFacts] = &[
    SubmoduleFacts { subslot: 2, ident: 81, telegram: &STANDARD[0] },
    SubmoduleFacts { subslot: 2, ident: 82, telegram: &STANDARD[1] },
    SubmoduleFacts { subslot: 2, ident: 83, telegram: &STANDARD[2] },
    SubmoduleFacts { subslot: 2, ident: 84, telegram: &STANDARD[3] },
    SubmoduleFacts { subslot: 2, ident: 86, telegram: &TELEGRAM_86 },
    SubmoduleFacts { subslot: 2, ident: 88, telegram: &TELEGRAM_88 },
];

/// Class 4 without scaling, compatibility mode off.
fn default_record(hardware: &Hardware) -> UserParameterData {
    UserParameterData::of(0x22, Scaling::hardware(hardware), 1, 0)
}

/// The longest parameter request in bytes, and the most parameters in one: P974.
const BASE_MODE: [u64; 3] = [240, 39, 0];
/// The velocity that 100 % stands for in 1/min, as a floating point number: P60000.
const VELOCITY_REFERENCE: f32 = 3000.0;

/// The parameters that the encoder object does not have.
#[derive(Clone, Copy, Debug, Default)]
pub struct GenericEncoder {
    /// The MAC address of the interface.
    pub mac: [u8; 6],
}

impl EncoderModel for GenericEncoder {
    fn parameter(live: &PoweredEncoder<'_, Self>, number: u16) -> Option<ParameterContent> {
        let station = &live.ram.station;
        Some(match number {
            925 => word(live.ram.user.life_sign_failures.into()),
            974 => words(BASE_MODE.to_vec()),
            60000 => octets_of(&VELOCITY_REFERENCE.to_be_bytes()),
            61000 => octets_of(&station.name),
            61002 => octets_of(&live.model.mac),
            61003 => double_word(u32::from_be_bytes(station.gateway).into()),
            61004 => double_word(u32::from_be_bytes(station.mask).into()),
            _ => return None,
        })
    }
}
