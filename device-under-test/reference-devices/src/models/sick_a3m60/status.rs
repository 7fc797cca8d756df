//! The sensor status S_STAT-A and S_STAT-B, and the reports derived from it: diagnosis blocks, codes instead of the position,
//! faults and warnings of P65001. Manual, 5.4.
//!
//! Interpretation: all of these follow the cause; only the code in G1_XIST2 remains until it is acknowledged. A position error
//! is any of bits 14 to 6 of S_STAT-A. The codes for invalid parameters in the EEPROM, a wrong linearization and a large
//! deviation are not printed; invented.

use super::hooks::A3m60Check;
use super::parameters;
use super::{A3m60State, PoweredEncoder};
use alloc::vec::Vec;
use device_stack::profinet::DiagnosisSeverity;
use encoder_profile::checks::EncoderCheck;

/// A fault that the stand can raise.
#[derive(Debug)]
pub struct A3m60Fault {
    /// The name for the stand.
    pub name: &'static str,
    /// The bit number in S_STAT-A.
    pub bit: u32,
    /// The code that replaces the position.
    pub code: i32,
}

const fn fault(name: &'static str, bit: u32, code: i32) -> A3m60Fault {
    A3m60Fault { name, bit, code }
}

/// The faults: tables 35 and 37.
pub const FAULTS: &[A3m60Fault] = &[
    fault("flash", 15, -12),
    fault("eeprom_checksum", 15, -12),
    fault("fram", 14, -11),
    fault("synchronization_large", 13, -8),
    fault("synchronization_shutdown", 11, -10),
    fault("synchronization_start", 11, -8),
    fault("linearization", 10, -5),
    fault("vector_length", 9, -5),
    fault("vector_length_long", 8, -5),
    fault("eeprom", 7, -4),
    fault("amplitude", 6, -3),
    fault("amplitude_cosine", 6, -3),
];

/// The code for several simultaneous errors.
pub const SEVERAL: i32 = -16;

/// Bits of S_STAT-A for position errors: 14 to 6.
pub const POSITION: u16 = 0x7FC0;
/// Bits of S_STAT-A for memory errors: 15 and 7.
pub const MEMORY: u16 = 0x8080;
/// Bit of S_STAT-A for a speed that is too high.
pub const OVERSPEED: u16 = 1 << 5;
/// Bit of S_STAT-B for a clock that is missing.
pub const CLOCK_MISSING: u16 = 1 << 5;
/// Bit of S_STAT-B for a clock that deviates.
pub const CLOCK_DEVIATING: u16 = 1 << 6;

/// The two words of the sensor status.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SensorStatusWords {
    /// S_STAT-A.
    pub a: u16,
    /// S_STAT-B.
    pub b: u16,
}

/// Diagnosis number of a speed that is too high. All numbers: table 34.
pub const TOO_FAST: u8 = 0x30;
/// Diagnosis number of a position error.
pub const POSITION_ERROR: u8 = 0x36;
/// Diagnosis number of a memory error.
pub const MEMORY_ERROR: u8 = 0x38;
/// Diagnosis number of a failed sign of life of the master.
pub const LIFE_SIGN: u8 = 0x3B;
/// Diagnosis number of a missing clock.
pub const NO_CLOCK: u8 = 0x3C;
/// Diagnosis number of a deviating clock.
pub const CLOCK_DEVIATES: u8 = 0x3D;

/// Returns the diagnosis numbers for a status, in the order of table 34.
pub fn numbers(words: SensorStatusWords) -> Vec<u8> {
    // Fast path: this is called several times in each cycle, mostly without any error.
    if words == SensorStatusWords::default() {
        return Vec::new();
    }
    let all = [
        (words.a & OVERSPEED != 0, TOO_FAST),
        (words.a & POSITION != 0, POSITION_ERROR),
        (words.a & MEMORY != 0, MEMORY_ERROR),
        (words.b & 1 << 4 != 0, LIFE_SIGN),
        (words.b & 1 << 5 != 0, NO_CLOCK),
        (words.b & 1 << 6 != 0, CLOCK_DEVIATES),
    ];
    all.into_iter().filter(|(is_there, _)| *is_there).map(|(_, number)| number).collect()
}

/// Writes the extended diagnosis: a block of three bytes for each number.
pub fn blocks(diagnoses: &[(u16, DiagnosisSeverity)]) -> Vec<u8> {
    diagnoses.iter().flat_map(|(number, _)| [0x81, 0x40, *number as u8]).collect()
}

/// Returns the code that replaces the position, given the codes of the faults; `None` without a fault.
pub fn code(codes: &[i32]) -> Option<i32> {
    let first = codes.first().copied()?;
    Some(if codes.iter().all(|code| *code == first) { first } else { SEVERAL })
}

/// Returns S_STAT-A and S_STAT-B.
pub fn words(live: &PoweredEncoder<'_, A3m60State>) -> SensorStatusWords {
    let sensor = noticed(live).fold(0, |bits, fault| bits | 1 << fault.bit);
    let clock = &live.model.clock;
    let wrong = clock.wrong();
    let bit = |n: u32, set: bool| u16::from(set) << n;
    let life_sign_failed = clock.times().is_some() && live.ram.watch.has_failed();
    let words = SensorStatusWords {
        a: sensor | bit(5, is_too_fast(live)),
        b: bit(4, life_sign_failed) | bit(5, wrong.is_missing) | bit(6, wrong.is_deviating),
    };
    live.model.hooks.0.apply(words, |hooks, words| hooks.status(live, words))
}

/// Returns the faults that are present and detected, in the order of the table.
pub fn noticed(live: &PoweredEncoder<'_, A3m60State>) -> impl Iterator<Item = &'static A3m60Fault> {
    let all = if live.faults.are_none() { &[] } else { FAULTS };
    all.iter().filter(|fault| live.model.hooks.check(A3m60Check::Fault(fault.name), live.faults.has(fault.name)))
}

/// Returns the diagnoses with their severity; a speed that is too high is no error.
pub fn diagnoses(live: &PoweredEncoder<'_, A3m60State>) -> Vec<(u16, DiagnosisSeverity)> {
    if !live.reports_diagnoses() {
        return Vec::new();
    }
    let numbers = numbers(words(live));
    let numbers = live.model.hooks.0.apply(numbers, |hooks, numbers| hooks.diagnosis(live, numbers));
    let severity =
        |number| if number == TOO_FAST { DiagnosisSeverity::MaintenanceRequired } else { DiagnosisSeverity::Fault };
    live.hooked_diagnoses(numbers.into_iter().map(|number| (number.into(), severity(number))).collect())
}

/// Returns the code that replaces the position in the vendor telegrams.
pub fn shown_code(live: &PoweredEncoder<'_, A3m60State>) -> Option<i32> {
    let shows = live.model.fields.shows_codes();
    let code = if shows { code(&noticed(live).map(|fault| fault.code).collect::<Vec<_>>()) } else { None };
    live.model.hooks.0.apply(code, |hooks, code| hooks.fault_code(live, code))
}

/// Returns whether the speed is above its limit: manual, table 37, bit 5.
pub fn is_too_fast(live: &PoweredEncoder<'_, A3m60State>) -> bool {
    let rpm = parameters::rpm(live);
    live.deviations.checks.check(EncoderCheck::TooFast(rpm), rpm.abs() > super::HIGHEST_SPEED)
}
