//! Bugs of blocks behind the six octets of a PROFIBUS diagnosis, and of the status that they tell.

use super::Deviation;
use super::image::{ERROR, has_error};
use alloc::vec::Vec;
use encoder_profile::checks::Check;
use encoder_profile::facts::{Cause, ErrorFact};
use encoder_profile::profidrive::telegram::Image;
use reference_devices::models::sick_a3m60::knobs::{Known, Words};

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    // Blocks
    "block-header-wrong" "The first octet of a block is C1h."
        => |b| b.a3m60.blocks = |numbers, _| numbers.iter().flat_map(|number| [0xC1, 0x40, *number]).collect();
    "channel-counts-errors" "The second octet of a block is 41h."
        => |b| b.a3m60.blocks = |numbers, _| numbers.iter().flat_map(|number| [0x81, 0x41, *number]).collect();
    "empty-block-when-healthy" "Behind the last error there is a block with the number 0."
        => |b| b.a3m60.blocks = |numbers, known| {
            let last: &[u8] = if known.fields.switches[0] & ALARM_CHANNEL != 0 { &[0] } else { &[] };
            numbers.iter().chain(last).flat_map(|number| [0x81, 0x40, *number]).collect()
        };
    "one-header-for-two-blocks" "The second block has its number alone."
        => |b| b.a3m60.blocks = |numbers, _| {
            let head: &[u8] = if numbers.is_empty() { &[] } else { &[0x81, 0x40] };
            head.iter().chain(numbers).copied().collect()
        };
    "one-block-per-cause" "Each bit of the status has a block of its own."
        => |b| b.a3m60.blocks = one_block_per_cause;
    "two-blocks-at-most" "There are two blocks at most."
        => |b| b.a3m60.blocks = |numbers, _| numbers.iter().take(2).flat_map(|number| [0x81, 0x40, *number]).collect();
    "position-error-as-memory-error" "An error of the position has the number of one of the memory."
        => |b| b.at_encoder.error_type(|right| Some(if right == 0x36 { 0x38 } else { right }));
    "life-sign-fault-as-missing-clock" "A lost sign of life has the number of a missing clock."
        => |b| b.at_encoder.error_type(|right| Some(if right == 0x3B { 0x3C } else { right }));
    "eeprom-error-not-in-38" "An EEPROM that does not answer is told as an error of the position alone."
        => |b| b.a3m60.told = |known| if known.words.a & 0x80 != 0 { Words { a: known.words.a & !0x80 | 0x40, ..known.words } } else { known.words };
    "eeprom-error-not-in-36" "An EEPROM that does not answer is told as an error of the memory alone."
        => |b| b.a3m60.told = |known| if known.words.a & 0x80 != 0 { Words { a: known.words.a & !0x80 | 0x8000, ..known.words } } else { known.words };
    "overspeed-forward-only" "Only forward a speed is too high."
        => |b| b.checks.check(|check, right| match check { Check::TooFast(rpm) => right && rpm > 0, _ => right });
    "diagnosis-frozen-at-start" "The blocks are those of the moment in which the exchange began."
        => |b| b.a3m60.told = |known| known.at_start;
    "diagnosis-stays" "A block stays when its error has gone."
        => |b| b.a3m60.told = |known| known.seen;
    "diagnosis-in-telegrams-only" "With the telegrams of the vendor there are no blocks."
        => |b| b.a3m60.told = |known| if known.is_of_vendor { Words::default() } else { known.words };
    "show-fault-code-hides-the-diagnosis" "Where fault codes are not shown there are no blocks either."
        => |b| b.a3m60.told = |known| if known.fields.shows_codes() { known.words } else { Words::default() };
    "alarm-channel-ignored" "Blocks are sent whatever the alarm channel is."
        => |b| b.checks.check(|check, right| right || matches!(check, Check::AlarmChannel { .. }));
    "alarm-channel-silences-codes" "Where blocks are not sent the status is 0, and there is no code either."
        => |b| {
            b.a3m60.words = |known| if is_silent(known) { Words::default() } else { known.words };
            b.a3m60.image = alarm_channel_silences_codes;
        };
    "alarm-channel-off-in-v41-mode" "Without compatibility mode the alarm channel can be switched off."
        => |b| b.checks.check(|check, right| match check { Check::AlarmChannel { is_on, .. } => is_on, _ => right });
    "warning-blocks-the-data" "With a speed that is too high the outputs are refused."
        => |b| b.a3m60.takes_outputs = |known| known.words.a & 1 << 5 == 0;

    // S_STAT-A
    "flash-only-checked" "The checksum of the EEPROM is not looked at."
        => |b| {
            b.a3m60.notices = |name, _| name != "eeprom_checksum";
            b.at_encoder.raise(|error| !is_of(error, "eeprom_checksum"));
        };
    "fram-in-bit-7" "An FRAM that does not answer sets bit 7."
        => |b| b.a3m60.status_bit = |name, right| if name == "fram" { 1 << 7 } else { right };
    "synchronization-bits-exchanged" "Bits 11 and 13 are exchanged."
        => |b| b.a3m60.status_bit = |_, right| match right { 0x2000 => 0x0800, 0x0800 => 0x2000, other => other };
    "synchronization-corrected-silently" "Deviations of the counters are not told."
        => |b| {
            b.a3m60.notices = |name, _| !name.starts_with("synchronization");
            b.at_encoder.raise(|error| !SYNCHRONIZATION.iter().any(|name| is_of(error, name)));
        };
    "linearization-not-watched" "A wrong linearization is not noticed."
        => |b| {
            b.a3m60.notices = |name, _| name != "linearization";
            b.at_encoder.raise(|error| !is_of(error, "linearization"));
        };
    "vector-length-low-not-checked" "A vector that is too short is not noticed."
        => |b| {
            b.a3m60.notices = |name, _| name != "vector_length";
            b.at_encoder.raise(|error| !is_of(error, "vector_length"));
        };
    "vector-length-high-not-checked" "A vector that is too long is not noticed."
        => |b| {
            b.a3m60.notices = |name, _| name != "vector_length_long";
            b.at_encoder.raise(|error| !is_of(error, "vector_length_long"));
        };
    "sine-only-watched" "The amplitude of the cosine is not looked at."
        => |b| {
            b.a3m60.notices = |name, _| name != "amplitude_cosine";
            b.at_encoder.raise(|error| !is_of(error, "amplitude_cosine"));
        };
    "eeprom-noticed-at-start-only" "An EEPROM that does not answer is noticed when the supply comes."
        => |b| b.a3m60.notices = |name, was_there| name != "eeprom" || was_there;
    "bit-12-set-with-errors" "Bit 12 is set with each error."
        => |b| b.a3m60.words = |known| Words { a: known.words.a | if known.words.a == 0 { 0 } else { 1 << 12 }, ..known.words };

    // P65001
    "memory-error-in-bit-0" "A fault of the memory is shown as one of the position."
        => |b| b.a3m60.faults = |_, right| u64::from(right != 0);
    "position-error-for-bit-6-only" "Only a wrong amplitude is a fault of the position."
        => |b| b.a3m60.faults = |known, right| if known.words.a & 1 << 6 == 0 { right & !1 } else { right };
    "unsupported-fault-bits-set" "Bit 1 of the faults is set with each of them."
        => |b| b.a3m60.faults = |_, right| if right == 0 { 0 } else { right | 2 };
    "overspeed-as-fault" "A speed that is too high is a fault and no warning."
        => |b| {
            b.a3m60.faults = |known, right| right | u64::from(known.words.a >> 5 & 1) << 1;
            b.a3m60.warnings = |_, _| 0;
        };
    "announced-warning-bit-used" "Bit 1 of the warnings is set while there is a fault."
        => |b| b.a3m60.warnings = |known, right| right | if known.words.a & !0x20 == 0 { 0 } else { 2 };
    "other-fault-bits-in-compatibility-mode" "In compatibility mode a fault of the position stands in bit 4."
        => |b| b.a3m60.faults = |known, right| if known.fields.switches[0] & 0x20 == 0 { right & !1 | (right & 1) << 4 } else { right };
};

/// Bit of the alarm channel among the switches of Set_Prm.
const ALARM_CHANNEL: u8 = 1 << 4;

const SYNCHRONIZATION: [&str; 3] = ["synchronization_large", "synchronization_shutdown", "synchronization_start"];

fn is_of(error: &ErrorFact, name: &'static str) -> bool {
    error.causes.contains(&Cause::Stand(name))
}

/// Whether blocks are not sent: the alarm channel is off, in compatibility mode.
fn is_silent(known: &Known) -> bool {
    known.fields.switches[0] & (ALARM_CHANNEL | 0x20) == 0
}

fn one_block_per_cause(_: &[u8], known: &Known) -> Vec<u8> {
    let Words { a, b } = known.words;
    let of_a = (0..16).rev().filter(|bit| a >> bit & 1 != 0).map(|bit| match bit {
        15 | 7 => 0x38,
        5 => 0x30,
        _ => 0x36,
    });
    let of_b = (4..7).filter(|bit| b >> bit & 1 != 0).map(|bit| 0x3B - 4 + bit as u8);
    match is_silent(known) {
        true => Vec::new(),
        false => of_a.chain(of_b).flat_map(|number| [0x81, 0x40, number]).collect(),
    }
}

fn alarm_channel_silences_codes(known: &Known, image: Image) -> Image {
    match has_error(&image) && is_silent(known) {
        true => {
            let transfers = image.is_transferred;
            let g1_xist2 = if transfers { image.position as u32 } else { 0 };
            Image { g1_zsw: image.g1_zsw & !ERROR | u16::from(transfers) << 13, g1_xist2, ..image }
        }
        false => image,
    }
}
