//! The sensor status S_STAT-A and S_STAT-B, and what else tells it: blocks of the diagnosis, codes in place of the position,
//! faults and warnings of P65001. Manual, 5.4.
//!
//! Readings: all of these follow the cause; only the code in G1_XIST2 stays until it is acknowledged. An error of the position
//! is any of bits 14 to 6 of S_STAT-A. Which code stands for invalid parameters in the EEPROM, for a linearization that is
//! wrong and for a large deviation is not printed.

use super::hooks::A3m60Check;
use super::parameters;
use super::{PoweredEncoder, State};
use alloc::vec::Vec;
use device_stack::profinet::DiagnosisSeverity;
use encoder_profile::checks::EncoderCheck;

/// A cause that the stand brings about.
#[derive(Debug)]
pub struct Fault {
    /// Its name.
    pub name: &'static str,
    /// The bit of S_STAT-A.
    pub bit: u32,
    /// The code in place of the position.
    pub code: i32,
}

const fn fault(name: &'static str, bit: u32, code: i32) -> Fault {
    Fault { name, bit, code }
}

/// The causes: tables 35 and 37.
pub const FAULTS: &[Fault] = &[
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

/// The code for several errors at once.
pub const SEVERAL: i32 = -16;

/// Bits of S_STAT-A that are errors of the position: 14 to 6.
pub const POSITION: u16 = 0x7FC0;
/// Bits of S_STAT-A that are errors of the memory: 15 and 7.
pub const MEMORY: u16 = 0x8080;
/// Bit of S_STAT-A for a speed that is too high.
pub const OVERSPEED: u16 = 1 << 5;
/// Bit of S_STAT-B for a clock that is missing.
pub const CLOCK_MISSING: u16 = 1 << 5;
/// Bit of S_STAT-B for a clock that deviates.
pub const CLOCK_DEVIATING: u16 = 1 << 6;

/// What is wrong, as the two words of the status tell it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Words {
    /// S_STAT-A.
    pub a: u16,
    /// S_STAT-B.
    pub b: u16,
}

/// Numbers of the diagnosis: table 34.
pub const TOO_FAST: u8 = 0x30;
/// An error of the position.
pub const POSITION_ERROR: u8 = 0x36;
/// An error of the memory.
pub const MEMORY_ERROR: u8 = 0x38;
/// The sign of life of the master.
pub const LIFE_SIGN: u8 = 0x3B;
/// The clock is missing.
pub const NO_CLOCK: u8 = 0x3C;
/// The clock deviates.
pub const CLOCK_DEVIATES: u8 = 0x3D;

/// What of the diagnosis is there for the words, in the order of table 34.
pub fn numbers(words: Words) -> Vec<u8> {
    // Nearly always nothing is wrong, and this is asked for several times in each cycle.
    if words == Words::default() {
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

/// The blocks behind the six octets of the diagnosis: three octets for each number.
pub fn blocks(diagnoses: &[(u16, DiagnosisSeverity)]) -> Vec<u8> {
    diagnoses.iter().flat_map(|(number, _)| [0x81, 0x40, *number as u8]).collect()
}

/// The code in place of the position, from those of the causes; none without a cause.
pub fn code(codes: &[i32]) -> Option<i32> {
    let first = codes.first().copied()?;
    Some(if codes.iter().all(|code| *code == first) { first } else { SEVERAL })
}

/// S_STAT-A and S_STAT-B.
pub fn words(live: &PoweredEncoder<'_, State>) -> Words {
    let sensor = noticed(live).fold(0, |bits, fault| bits | 1 << fault.bit);
    let clock = &live.model.clock;
    let wrong = clock.wrong();
    let bit = |n: u32, set: bool| u16::from(set) << n;
    let life_sign_failed = clock.times().is_some() && live.ram.watch.has_failed();
    let words = Words {
        a: sensor | bit(5, is_too_fast(live)),
        b: bit(4, life_sign_failed) | bit(5, wrong.is_missing) | bit(6, wrong.is_deviating),
    };
    live.model.hooks.0.apply(words, |hooks, words| hooks.status(live, words))
}

/// The causes that are there and noticed, in the order of the table.
pub fn noticed(live: &PoweredEncoder<'_, State>) -> impl Iterator<Item = &'static Fault> {
    let all = if live.faults.are_none() { &[] } else { FAULTS };
    all.iter().filter(|fault| live.model.hooks.check(A3m60Check::Fault(fault.name), live.faults.has(fault.name)))
}

/// The diagnoses of the blocks with their severity; only a speed that is too high is no error.
pub fn diagnoses(live: &PoweredEncoder<'_, State>) -> Vec<(u16, DiagnosisSeverity)> {
    if !live.reports_diagnoses() {
        return Vec::new();
    }
    let numbers = numbers(words(live));
    let numbers = live.model.hooks.0.apply(numbers, |hooks, numbers| hooks.diagnosis(live, numbers));
    let severity =
        |number| if number == TOO_FAST { DiagnosisSeverity::MaintenanceRequired } else { DiagnosisSeverity::Fault };
    live.hooked_diagnoses(numbers.into_iter().map(|number| (number.into(), severity(number))).collect())
}

/// The code that takes the place of the position in the telegrams of the vendor.
pub fn shown_code(live: &PoweredEncoder<'_, State>) -> Option<i32> {
    let shows = live.model.fields.shows_codes();
    let shown = if shows { code(&noticed(live).map(|fault| fault.code).collect::<Vec<_>>()) } else { None };
    live.model.hooks.0.apply(shown, |hooks, shown| hooks.fault_code(live, shown))
}

/// Whether the speed is above its limit: manual, table 37, bit 5.
pub fn is_too_fast(live: &PoweredEncoder<'_, State>) -> bool {
    let rpm = parameters::rpm(live);
    live.deviations.checks.check(EncoderCheck::TooFast(rpm), rpm.abs() > super::HIGHEST_SPEED)
}
