//! The sensor status S_STAT-A and S_STAT-B, and what else tells it: blocks of the diagnosis, codes in place of the position,
//! faults and warnings of P65001. Manual, 5.4.
//!
//! Readings: all of these follow the cause; only the code in G1_XIST2 stays until it is acknowledged. An error of the position
//! is any of bits 14 to 6 of S_STAT-A. Which code stands for invalid parameters in the EEPROM, for a linearization that is
//! wrong and for a large deviation is not printed.

use super::knobs::Known;
use super::own;
use super::parameters;
use super::{Live, State, is_of_vendor};
use alloc::vec::Vec;
use device_stack::profinet::Severity;
use encoder_profile::checks::Check;
use encoder_profile::encoder_object::Phase;

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
const OVERSPEED: u16 = 1 << 5;

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
pub fn blocks(numbers: &[u8]) -> Vec<u8> {
    numbers.iter().flat_map(|number| [0x81, 0x40, *number]).collect()
}

/// What a code in place of the position is made of.
#[derive(Clone, Copy, Debug)]
pub struct Causes<'a> {
    /// The codes of the causes that are there, in the order of the table.
    pub codes: &'a [i32],
    /// What is known besides.
    pub known: &'a Known,
}

/// The code in place of the position, from those of the causes; none without a cause.
pub fn code(codes: &[i32]) -> Option<i32> {
    let first = codes.first().copied()?;
    Some(if codes.iter().all(|code| *code == first) { first } else { SEVERAL })
}

/// The code of several causes, or that of one of them.
fn are_several(codes: &[i32]) -> bool {
    code(codes) == Some(SEVERAL)
}

/// S_STAT-A and S_STAT-B.
pub fn words(live: &Live<'_, State>) -> Words {
    let a = noticed(live).fold(0, |bits, fault| bits | (live.rules.own.status_bit)(fault.name, 1 << fault.bit));
    let wrong = live.model.clock.wrong(&live.rules.own);
    let bit = |n: u32, set: bool| u16::from(set) << n;
    let is_watched = live.model.clock.times().is_some();
    let b = bit(4, is_watched && live.ram.watch.has_failed()) | bit(5, wrong.is_missing) | bit(6, wrong.is_deviating);
    Words { a: a | bit(5, is_too_fast(live)), b }
}

/// The causes that are there and noticed, in the order of the table.
fn noticed(live: &Live<'_, State>) -> impl Iterator<Item = &'static Fault> {
    let all = if live.faults.are_none() { &[] } else { FAULTS };
    all.iter().filter(|fault| notices(live, fault))
}

fn notices(live: &Live<'_, State>, fault: &Fault) -> bool {
    live.faults.has(fault.name) && {
        let was_there = live.model.faults_at_power_up.contains(&fault.name);
        (live.rules.own.notices)(fault.name, was_there)
    }
}

/// Keeps in mind which faults are there while the supply comes.
pub fn note_faults(live: &mut Live<'_, State>) {
    let here = FAULTS.iter().map(|fault| fault.name).filter(|name| live.faults.has(name));
    live.model.faults_at_power_up = here.collect();
}

/// What the status is shown from.
pub fn known(live: &Live<'_, State>) -> Known {
    let model = &*live.model;
    Known {
        words: words(live),
        seen: model.seen,
        at_start: model.at_start,
        last_preset: model.presets.last_value,
        had_several: model.had_several,
        fields: model.fields,
        is_isochronous: model.clock.times().is_some(),
        is_of_vendor: is_of_vendor(live.ram.telegram()),
        is_connected: live.ram.phase != Phase::Alone,
        powered: own::powered(live),
    }
}

/// Keeps in mind what is wrong, which `words` tell.
pub fn note_status(live: &mut Live<'_, State>, words: Words) {
    let seen = &mut live.model.seen;
    (seen.a, seen.b) = (seen.a | words.a, seen.b | words.b);
    let codes = codes(live);
    live.model.had_several |= are_several(&codes);
}

fn codes(live: &Live<'_, State>) -> Vec<i32> {
    noticed(live).filter_map(|fault| (live.rules.own.fault_code)(fault.name, fault.code)).collect()
}

/// The numbers of the diagnosis with their severity, from what is known; only a speed that is too high is no error.
pub fn diagnoses(live: &Live<'_, State>, known: &Known) -> Vec<(u16, Severity)> {
    if !live.reports_diagnoses() {
        return Vec::new();
    }
    let severity = |number| if number == TOO_FAST { Severity::MaintenanceRequired } else { Severity::Fault };
    let diagnoses = numbers((live.rules.own.told)(known)).into_iter().map(|number| (number.into(), severity(number)));
    live.reported(diagnoses.collect())
}

/// The code that takes the place of the position in the telegrams of the vendor, from what is known.
pub fn shown_code(live: &Live<'_, State>, known: &Known) -> Option<i32> {
    if !(live.rules.own.shows_codes)(live.model.fields.shows_codes()) {
        return None;
    }
    (live.rules.own.code)(&Causes { codes: &codes(live), known })
}

/// Whether the speed is above its limit: manual, table 37, bit 5.
pub fn is_too_fast(live: &Live<'_, State>) -> bool {
    let rpm = parameters::rpm(live);
    live.behaviour.checks.check(Check::TooFast(rpm), rpm.abs() > super::HIGHEST_SPEED)
}
