//! Kübler Sendix 58xx absolute encoders, singleturn and multiturn, with PROFINET, from their manual for firmware 3.0.
//!
//! Whatever is not printed in the manual is marked as invented. Interpretations, where it is silent or contradicts itself:
//!
//! - Errors are not latched and cannot be acknowledged; they follow their cause. Bit 11 of G1_ZSW echoes the request.
//!   A sensor error takes precedence over a memory error.
//! - A preset is carried out within 40 ms; the position is frozen until then. With class 4 off it is not answered.
//! - Parking freezes all positions, not the velocity. It is never refused, not even while the shaft turns.
//! - A record 0xBF00 is also accepted in data exchange and is in force at once. A record of another length is refused. Invalid
//!   values in a record of the right length are reported (0x1002), as is a start without a record. Then the resolution of
//!   the hardware is used instead of the scaling.
//! - The ratio of total range and units has to be a power of two, unless preset control of G1_XIST1 is off: then
//!   positions beyond the range stay at its last value, and G1_XIST1 continues over all revolutions.
//! - Compatibility mode is not supported: bits 4 and 5 and byte 17 are shown and have no effect.
//! - Any DO-ID is answered: the example has a placeholder for it.
//! - Parameter requests have the byte order of PROFIdrive; the printed example swaps the bytes of each pair.
//! - A preset value is refused (0x02) if neither it nor its complement is in the range. A value that is still beyond the range
//!   when the preset is made is limited to the range.
//! - The factory reset is that of the PROFINET interface: the offset remains.

mod leds;
mod modules;
mod records;
#[cfg(test)]
mod tests;

use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profinet::{DiagnosisSeverity, RecordAccess, RecordRefusal, ResetScope, StackStatus};
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder::{Hardware, MeasuringSettings, Scaling};
use encoder_profile::encoder_object::{EncoderModel, PoweredEncoder};
use encoder_profile::facts::{
    ClearedData, EncoderVariant, ErrorCause, ErrorFact, FaultEffect, Identification, LateRecordEffect, ManualFacts,
    MissingRecordEffect, NO_DIAGNOSIS, PresetValues, TimingFacts, WarningFact,
};
use encoder_profile::profidrive::control::{ControlFacts, ControlRequested};
use encoder_profile::profidrive::life_sign::LifeSignPace;
use encoder_profile::profidrive::preset_trigger::{BeyondRange, TriggerFacts};
use encoder_profile::profidrive::sensor::{AcknowledgeAnswer, ParkingEffect, PositionTransfer, SensorFacts};
use encoder_profile::profidrive::user_parameters::{StartLimits, UserParameterData, VELOCITY_UNITS};
use station::{StandAction, Time};
use wire::profidrive::ErrorNumber;

/// The facts of the manual.
pub static FACTS: ManualFacts = ManualFacts {
    variants: &[
        EncoderVariant {
            name: "sendix-singleturn",
            hardware: Hardware { steps_per_revolution: 65536, revolutions: 1 },
            ..SENDIX
        },
        EncoderVariant {
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
    timing: TimingFacts {
        boot: Duration::from_secs(2),
        ready: Duration::from_millis(5),
        preset: Duration::from_millis(30),
        save: Duration::from_millis(200),
        velocity: Duration::from_secs(1),
    },
    // No parameter reports these.
    software: [300, 0, 0],
    unit_type: 0,
    object_class: &[],
    sensor_format: |_| [0; 6],
    // The number of the preset value is printed in the manual, that of the operating status in the profile.
    parameters: &[65000, 65001],
    listed: &[],
    status_header: 0x000B_0101,
    errors: ERRORS,
    supported_faults: 0x21,
    warnings: WARNINGS,
    supported_warnings: 0x07,
    default_record,
    limits: StartLimits { serves, velocity_units: VELOCITY_UNITS, tolerated_failures: 0..=u8::MAX },
    parameter_access: 0xB02E,
    without_record: MissingRecordEffect::Error,
    record_in_exchange: LateRecordEffect::InForce,
    freezes_position_in_preset: true,
    preset_values: PresetValues::Limited,
    // Manual, 8.2, G1_STW and G1_ZSW: the request for the position is ignored, there are no errors to acknowledge, and parking
    // freezes the reported position.
    sensor: SensorFacts {
        transfers: PositionTransfer::Always,
        parks: ParkingEffect::Freezes,
        answers: AcknowledgeAnswer::Echo,
        latches_errors: false,
        parks_while_turning: true,
        parking_clears_errors: false,
        raises_while_parked: true,
        acknowledges_while_parked: true,
        answers_blocked_preset: false,
    },
    // Manual, 8.1: 28 bits, limited to the highest position.
    preset_trigger: Some(TriggerFacts {
        value: (1 << 28) - 1,
        beyond_range: BeyondRange::Limited,
        first_word_counts: true,
    }),
    // Manual, 8.2, STW2_ENC and ZSW2_ENC.
    control: ControlFacts {
        optional_in_compatibility: false,
        requested: ControlRequested::Always,
        accepts_held_preset: true,
        shows_fault: true,
    },
    // Manual, 8.2, ZSW2_ENC.
    sign_of_life: LifeSignPace::EachSendClock,
    preset_waits_for_memory: true,
    monitors_controller: false,
    longest_name: 240,
    serves_any_axis: true,
    modules: modules::MODULES,
    resets: |scope| match scope {
        ResetScope::Factory | ResetScope::Communication | ResetScope::AllData | ResetScope::Device => {
            Some(ClearedData { application: false, station: true })
        }
        ResetScope::ApplicationData | ResetScope::Engineering | ResetScope::FactoryImage | ResetScope::Other(_) => None,
    },
};

const SENDIX: EncoderVariant = EncoderVariant {
    name: "",
    station_type: "KUEBLER",
    // The pattern is printed, not its digits.
    order_id: "8.58X8.XXCX.C2XX",
    access_point: 3,
    hardware: Hardware { steps_per_revolution: 65536, revolutions: 1 },
    shift: 0,
};

/// Codes of chapter 8.2, fault bits of chapter 9.3.
const ERRORS: &[ErrorFact] = &[
    ErrorFact {
        causes: &[ErrorCause::Stand("sensor")],
        code: Some(0x0001),
        fault_bits: 1,
        effect: FaultEffect::NoReading,
        ..NO_DIAGNOSIS
    },
    ErrorFact {
        causes: &[ErrorCause::Stand("memory")],
        code: Some(0x0020),
        fault_bits: 1 << 5,
        effect: FaultEffect::NoMemory,
        ..NO_DIAGNOSIS
    },
    ErrorFact { causes: &[ErrorCause::WrongParameters], code: Some(0x1002), ..NO_DIAGNOSIS },
    // Not monitored. The code is that of the profile.
    ErrorFact { causes: &[ErrorCause::LifeSign], code: Some(0x0F02), ..NO_DIAGNOSIS },
];

/// Bit of the speed warning, which the model raises itself.
const SPEED: u32 = 1;
/// Speed limit of the warning in revolutions per minute.
const HIGHEST_SPEED: u64 = 9000;

const WARNINGS: &[WarningFact] =
    &[warning(None, SPEED), warning(Some("temperature"), 1 << 1), warning(Some("led_current"), 1 << 2)];

const fn warning(cause: Option<&'static str>, bit: u32) -> WarningFact {
    WarningFact { cause, bit, error_type: None, severity: DiagnosisSeverity::MaintenanceRequired }
}

/// Singleturn with 8192 units, as printed. The rest is the example 0x2A of the manual; the velocity unit is invented.
fn default_record(_: &Hardware) -> UserParameterData {
    UserParameterData::of(0x2A, Scaling { units_per_revolution: 8192, range: 8192 }, 1, 0)
}

/// Whether the hardware can serve a scaling: chapter 7.
fn serves(user: &UserParameterData, hardware: &Hardware) -> bool {
    let (units, range) = (user.units_per_revolution, user.range);
    (1..=hardware.steps_per_revolution).contains(&units)
        && (1..=hardware.range()).contains(&range)
        && range <= units * hardware.revolutions
        && (!user.preset_acts_on_xist1 || is_cyclic_ratio(units, range))
}

/// Whether the ratio of both is a power of two.
fn is_cyclic_ratio(units: u64, range: u64) -> bool {
    let (small, great) = (units.min(range).max(1), units.max(range));
    great % small == 0 && (great / small).is_power_of_two()
}

/// The lowest supply voltage at which the encoder works. Manual, 3.2: from 10 V; the reserve is invented.
const LOWEST_SUPPLY: f64 = 8.0;

/// The parts of the Sendix that the encoder object does not have.
#[derive(Default)]
pub struct Sendix {
    /// Whether the supply voltage is too low.
    lacks_supply: bool,
}

impl EncoderModel for Sendix {
    fn write(
        live: &mut PoweredEncoder<'_, Self>,
        number: u16,
        _: u16,
        values: &[u64],
    ) -> Option<Result<(), ErrorNumber>> {
        records::write(live, number, values)
    }

    fn read_record(
        live: &mut PoweredEncoder<'_, Self>,
        access: RecordAccess,
        out: &mut Vec<u8>,
    ) -> Option<Result<(), RecordRefusal>> {
        records::read(live, access, out)
    }

    fn warnings(live: &PoweredEncoder<'_, Self>) -> u32 {
        let rpm = live.shaft.rounded_rpm(live.now);
        let is_too_fast = rpm.unsigned_abs() > HIGHEST_SPEED;
        if live.deviations.checks.check(EncoderCheck::TooFast(rpm), is_too_fast) { SPEED } else { 0 }
    }

    fn settings(live: &PoweredEncoder<'_, Self>, settings: MeasuringSettings) -> MeasuringSettings {
        let Scaling { units_per_revolution: units, range } = settings.scaling;
        let stands = !live.ram.user.preset_acts_on_xist1 && !is_cyclic_ratio(units, range);
        let stands = live.deviations.checks.check(EncoderCheck::PositionSaturates(live.ram.user), stands);
        MeasuringSettings { saturates_at: stands.then_some(range), ..settings }
    }

    fn act(live: &mut PoweredEncoder<'_, Self>, action: &StandAction<'_>) -> Option<Time> {
        let StandAction::SupplyVoltage(volts) = *action else { return None };
        let check = EncoderCheck::SupplySuffices((volts * 1000.0).max(0.0) as u64);
        live.model.lacks_supply = !live.deviations.checks.check(check, volts >= LOWEST_SUPPLY);
        Some(live.now)
    }

    fn is_alive(&self) -> bool {
        !self.lacks_supply
    }

    fn led(live: &PoweredEncoder<'_, Self>, name: &str, status: &StackStatus) -> Option<&'static str> {
        leds::led(live, name, status)
    }
}
