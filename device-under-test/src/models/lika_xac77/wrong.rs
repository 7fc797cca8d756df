//! Wrong functions that take more than a line, each named after its bug.
//!
//! This room must not hold healthy behaviour: that stands at the seam which reads the knob.

use super::VARIANTS;
use super::parameters::{COMMISSIONING, MEMORY};
use crate::encoder::measuring::{self, Crossing};
use crate::encoder::{Hardware, Scaling, Unit};
use crate::profidrive::sensor::Request;
use crate::profidrive::telegram::{self, Before, Image, Signal, Telegram};
use crate::profidrive::user_parameters::{UserParameters, unit};
use alloc::vec::Vec;
use wire::octets::Append;

/// Bits of G1_ZSW.
pub const IN_PROCESS: u16 = 0x0800;
pub const EXECUTED: u16 = 0x1000;
const POSITION: u16 = 0x2000;
pub const PARKED: u16 = 0x4000;
const ERROR: u16 = 0x8000;

pub fn has_error(image: &Image) -> bool {
    image.g1_zsw & ERROR != 0
}

pub fn is_parked(image: &Image) -> bool {
    image.g1_zsw & PARKED != 0
}

pub fn without_positions(image: Image) -> Image {
    Image { g1_xist1: 0, g1_xist2: 0, g1_xist3: 0, ..image }
}

pub fn positions_swapped(telegram: &Telegram) -> &'static [Signal] {
    use Signal::{G1Xist1, G1Xist2, G1Zsw, NistA, NistB, Zsw2Enc};
    match telegram.number {
        81 => &[Zsw2Enc, G1Zsw, G1Xist2, G1Xist1],
        82 => &[Zsw2Enc, G1Zsw, G1Xist2, G1Xist1, NistA],
        83 => &[Zsw2Enc, G1Zsw, G1Xist2, G1Xist1, NistB],
        _ => telegram.inputs,
    }
}

pub fn velocity_before_xist2(telegram: &Telegram) -> &'static [Signal] {
    use Signal::{G1Xist1, G1Xist2, G1Xist3, G1Zsw, NistB, Zsw2Enc};
    match telegram.number {
        83 => &[Zsw2Enc, G1Zsw, G1Xist1, NistB, G1Xist2],
        84 => &[Zsw2Enc, G1Zsw, G1Xist3, NistB, G1Xist2],
        _ => telegram.inputs,
    }
}

pub fn xist3_halves_swapped(signal: Signal, image: &Image, out: &mut Vec<u8>) {
    telegram::put(signal, &Image { g1_xist3: image.g1_xist3.rotate_right(32), ..*image }, out);
}

pub fn position_little_endian(signal: Signal, image: &Image, out: &mut Vec<u8>) {
    let Image { g1_xist1, g1_xist2, g1_xist3, .. } = *image;
    let swapped = Image {
        g1_xist1: g1_xist1.swap_bytes(),
        g1_xist2: g1_xist2.swap_bytes(),
        g1_xist3: g1_xist3.swap_bytes(),
        ..*image
    };
    telegram::put(signal, &swapped, out);
}

pub fn nist_a_from_upper_half(signal: Signal, image: &Image, out: &mut Vec<u8>) {
    match signal {
        Signal::NistA => out.put_u16((image.velocity >> 16) as u16),
        other => telegram::put(other, image, out),
    }
}

pub fn nist_b_not_sign_extended(signal: Signal, image: &Image, out: &mut Vec<u8>) {
    match signal {
        Signal::NistB if image.velocity < 0 => out.put_u32((image.velocity as u16).into()),
        other => telegram::put(other, image, out),
    }
}

pub fn speed_overflows(signal: Signal, image: &Image, out: &mut Vec<u8>) {
    match signal {
        Signal::NistA => out.put_u16(image.velocity as u16),
        other => telegram::put(other, image, out),
    }
}

pub fn speed_units_exchanged(number: u8) -> Option<Unit> {
    match number {
        1 => unit(2),
        2 => unit(1),
        other => unit(other),
    }
}

pub fn park_clears_position_first(before: &Before, now: Image) -> Image {
    match is_parked(&now) && !is_parked(&before.truth) {
        true => without_positions(Image { g1_zsw: before.truth.g1_zsw, ..now }),
        false => now,
    }
}

pub fn unpark_status_first(before: &Before, now: Image) -> Image {
    match !is_parked(&now) && is_parked(&before.truth) {
        true => without_positions(now),
        false => now,
    }
}

pub fn park_freezes_position(before: &Before, now: Image) -> Image {
    match is_parked(&now) {
        true => Image { g1_xist1: before.sent.g1_xist1, g1_xist3: before.sent.g1_xist3, ..now },
        false => now,
    }
}

pub fn sensor_error_drops_for_a_frame(before: &Before, now: Image) -> Image {
    match before.truth.g1_zsw & !now.g1_zsw & IN_PROCESS != 0 {
        true => Image { g1_zsw: now.g1_zsw & !ERROR, ..now },
        false => now,
    }
}

pub fn error_bit_one_frame_late(before: &Before, now: Image) -> Image {
    match has_error(&now) && !has_error(&before.truth) {
        true => Image { g1_zsw: now.g1_zsw & !ERROR, ..now },
        false => now,
    }
}

pub fn xist2_always_shows_position(_: &Before, now: Image) -> Image {
    match now.g1_zsw & (POSITION | PARKED | ERROR) {
        0 => Image { g1_xist2: now.position as u32, ..now },
        _ => now,
    }
}

pub fn xist2_keeps_last_value(before: &Before, now: Image) -> Image {
    match now.g1_zsw & (POSITION | PARKED | ERROR) {
        0 => Image { g1_xist2: before.sent.g1_xist2, ..now },
        _ => now,
    }
}

pub fn position_bit_stays_with_error(_: &Before, now: Image) -> Image {
    match has_error(&now) && now.request.absolute {
        true => Image { g1_zsw: now.g1_zsw | POSITION, ..now },
        false => now,
    }
}

pub fn position_bit_lost_after_error(before: &Before, now: Image) -> Image {
    match is_lost(before) && !is_parked(&before.truth) {
        true => without_transfer(now),
        false => now,
    }
}

pub fn upper_scaling_octets_ignored(user: UserParameters) -> UserParameters {
    let UserParameters { units_per_revolution, range, .. } = user;
    UserParameters { units_per_revolution: units_per_revolution & 0xFFFF_FFFF, range: range & 0xFFFF_FFFF, ..user }
}

/// Goes on counting below the physical zero, until it is passed forward again.
pub fn red_zone_forward_only(crossing: Crossing) -> i64 {
    let Crossing { before, now, range, beyond } = crossing;
    match now.abs_diff(before) > range / 2 {
        true if now > before => -1,
        true => 0,
        false => beyond,
    }
}

/// Takes the physical zero, reached from below, as one more place of the range that has ended.
pub fn red_zone_one_late(crossing: Crossing) -> i64 {
    match crossing {
        Crossing { now: 0, before, range, .. } if before > range / 2 => 1,
        Crossing { now: 0, beyond, .. } => beyond,
        _ => 0,
    }
}

pub fn fault_bits_exchanged(faults: u32) -> u32 {
    faults << 1 & MEMORY.1 | faults >> 1 & COMMISSIONING.1
}

fn is_lost(before: &Before) -> bool {
    before.truth.request.absolute && before.sent.g1_zsw & POSITION == 0
}

pub fn without_transfer(image: Image) -> Image {
    match image.g1_zsw & POSITION != 0 {
        true => Image { g1_zsw: image.g1_zsw & !POSITION, g1_xist2: 0, ..image },
        false => image,
    }
}

fn with_transfer(image: Image) -> Image {
    match image.g1_zsw & (PARKED | ERROR) {
        0 => Image { g1_zsw: image.g1_zsw | POSITION, g1_xist2: image.position as u32, ..image },
        _ => image,
    }
}

pub fn absolute_value_lost_in_park(before: &Before, now: Image) -> Image {
    match is_lost(before) && !has_error(&before.truth) {
        true => without_transfer(now),
        false => now,
    }
}

pub fn absolute_value_never_ends(before: &Before, now: Image) -> Image {
    match before.sent.g1_zsw & POSITION != 0 {
        true => with_transfer(now),
        false => now,
    }
}

pub fn position_unrequested_after_error(before: &Before, now: Image) -> Image {
    let goes_on = before.sent.g1_zsw & !before.truth.g1_zsw & POSITION != 0;
    match has_error(&before.truth) || goes_on {
        true => with_transfer(now),
        false => now,
    }
}

pub fn xist2_one_frame_late(before: &Before, now: Image) -> Image {
    match now.g1_zsw & before.truth.g1_zsw & POSITION != 0 {
        true => Image { g1_xist2: before.truth.g1_xist2, ..now },
        false => now,
    }
}

pub fn error_needs_request(_: &Before, now: Image) -> Image {
    match has_error(&now) && !now.request.absolute {
        true => Image { g1_xist2: 0, ..now },
        false => now,
    }
}

pub fn park_never_ends(before: &Before, now: Image) -> Image {
    match is_parked(&before.sent) {
        true => without_positions(Image { g1_zsw: PARKED, ..now }),
        false => now,
    }
}

pub fn has_mode(request: Request) -> bool {
    request.home || request.relative
}

pub fn mode_begins(before: Request, now: Request) -> bool {
    !has_mode(before) && has_mode(now)
}

pub fn relative_shift_reversed(preset: measuring::Preset) -> u64 {
    measuring::shift(preset.offset, preset.range - preset.value % preset.range, preset.range)
}

pub fn units_and_range_exchanged(user: UserParameters) -> UserParameters {
    UserParameters { units_per_revolution: user.range, range: user.units_per_revolution, ..user }
}

pub fn range_of_one_revolution(hardware: &Hardware) -> Scaling {
    Scaling { range: hardware.steps_per_revolution, ..Scaling::hardware(hardware) }
}

pub fn default_speed_unit_rpm(hardware: &Hardware) -> UserParameters {
    UserParameters { speed_unit: Unit::Rpm as u8, ..UserParameters::xac77_default(hardware) }
}

pub fn sensor_format_of_the_other_variant(hardware: Hardware) -> Hardware {
    VARIANTS.iter().map(|variant| variant.hardware).find(|other| *other != hardware).unwrap_or(hardware)
}
