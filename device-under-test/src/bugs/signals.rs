//! Bugs of telegrams, their signals, Control by PLC and signs of life.

use super::Bug;
use super::image::{ERROR, PARKED, POSITION, has_error, is_lost, is_parked, without_transfer};
use crate::profidrive::telegram::{self, Before, Image, Signal, Telegram};
use alloc::vec::Vec;
use wire::octets::Append;

pub(crate) static BUGS: &[Bug] = bugs! {
    // Telegrams
    "control-words-swapped" "STW2_ENC and G1_STW are exchanged on reception."
        => |b| b.telegram.control_words = |[a, b]| [b, a];
    "positions-swapped" "G1_XIST1 and G1_XIST2 change places in the telegrams 81 to 83."
        => |b| b.telegram.order = positions_swapped;
    "velocity-before-xist2" "NIST_B stands before G1_XIST2 in the telegrams 83 and 84."
        => |b| b.telegram.order = velocity_before_xist2;
    "xist3-halves-swapped" "The two halves of G1_XIST3 are exchanged."
        => |b| b.telegram.put = xist3_halves_swapped;
    "position-little-endian" "The positions are sent least significant octet first."
        => |b| b.telegram.put = position_little_endian;
    "nist-a-from-upper-half" "NIST_A is the upper half of the 32-bit velocity."
        => |b| b.telegram.put = nist_a_from_upper_half;
    "nist-b-not-sign-extended" "A negative velocity has zeros in the upper half of NIST_B."
        => |b| b.telegram.put = nist_b_not_sign_extended;
    "error-code-in-upper-word" "Error codes stand in the upper half of G1_XIST2."
        => |b| b.telegram.emit = |_, now| Image { g1_xist2: if has_error(&now) { now.g1_xist2 << 16 } else { now.g1_xist2 }, ..now };
    "inputs-bad-with-sensor-error" "The provider status is bad while a sensor error is shown."
        => |b| b.telegram.emit = |_, now| Image { good: !has_error(&now), ..now };

    "reserved-bit-acts" "The reserved bit 10 of G1_STW parks the encoder as bit 14 does."
        => |b| b.telegram.control_words = |[a, b]| [a, b | (b & 0x0400) << 4];
    "status-bit-3-shows-error" "The unused bit 3 of ZSW2_ENC shows that there is an error."
        => |b| b.telegram.emit = |_, now| Image { zsw2_enc: now.zsw2_enc | if has_error(&now) { 0x0008 } else { 0 }, ..now };
    "status-bit-10-shows-motion" "The reserved bit 10 of G1_ZSW shows that the shaft turns."
        => |b| b.telegram.emit = |_, now| Image { g1_zsw: now.g1_zsw | if now.velocity == 0 { 0 } else { 0x0400 }, ..now };
    "xist1-shows-error" "The error code stands in G1_XIST1 as well."
        => |b| b.telegram.emit = |_, now| Image { g1_xist1: if has_error(&now) { now.g1_xist2 } else { now.g1_xist1 }, ..now };

    // Control by PLC
    "control-by-plc-ignored" "G1_STW is obeyed without Control by PLC."
        => |b| b.control.is_valid = |_, _| true;
    "control-by-plc-needed-in-compatibility-mode" "Control by PLC is demanded in compatibility mode too."
        => |b| b.control.is_valid = |_, by_plc| by_plc;
    "control-requested-always-set" "Bit 9 of ZSW2_ENC is always 1 without compatibility mode."
        => |b| b.control.is_requested = |compatible, _| !compatible;
    "control-requested-never-set" "Bit 9 of ZSW2_ENC is always 0."
        => |b| b.control.is_requested = |_, _| false;
    "control-requested-in-compatibility-mode" "Bit 9 of ZSW2_ENC follows Control by PLC in compatibility mode too."
        => |b| b.control.is_requested = |_, by_plc| by_plc;

    // Signs of life
    "sign-of-life-through-zero" "The sign of life counts 0 to 15."
        => |b| b.life_sign.next = |sign| (sign + 1) % 16;
    "sign-of-life-stops-in-park" "The sign of life of the encoder stands still while it is parked."
        => |b| b.life_sign.counts_while_parked = false;
    "sign-of-life-stops-on-error" "The sign of life of the encoder stands still while it shows an error."
        => |b| b.life_sign.counts_with_error = false;
    "zero-life-sign-is-failure" "A controller that sends 0 all the time raises an error."
        => |b| b.life_sign.begins = |_| true;
    "life-sign-tolerance-off-by-one" "The error comes one failure too early."
        => |b| b.life_sign.tolerated = |number| i32::from(number) - 1;
    "life-sign-255-is-minus-one" "A tolerance of 255 counts as -1."
        => |b| b.life_sign.tolerated = |number| i32::from(number as i8);
    "life-sign-failures-add-up" "Tolerated failures are never forgotten."
        => |b| b.life_sign.good = 0;
    "life-sign-needs-control" "The sign of life of the controller is monitored under Control by PLC only."
        => |b| b.life_sign.watches_without_control = false;
    "life-sign-tolerance-in-v41-mode" "Octet 17 of the start-up record counts without compatibility mode too."
        => |b| b.life_sign.tolerated_without_compatibility = |number| number;

    // G1_XIST2
    "xist2-always-shows-position" "G1_XIST2 shows the position although it is not requested."
        => |b| b.telegram.emit = xist2_always_shows_position;
    "xist2-keeps-last-value" "G1_XIST2 keeps its last value when neither position nor error is shown."
        => |b| b.telegram.emit = xist2_keeps_last_value;
    "xist2-one-frame-late" "G1_XIST2 shows the position of the frame before."
        => |b| b.telegram.emit = xist2_one_frame_late;
    "absolute-value-not-served" "The request for the position in G1_XIST2 has no effect."
        => |b| b.telegram.emit = |_, now| without_transfer(now);
    "absolute-value-never-ends" "The transfer of the position goes on when the request is taken back."
        => |b| b.telegram.emit = absolute_value_never_ends;
    "position-bit-stays-with-error" "Bit 13 of G1_ZSW stays set when an error displaces the position."
        => |b| b.telegram.emit = position_bit_stays_with_error;
    "position-bit-lost-after-error" "After an error the position has to be requested anew."
        => |b| b.telegram.emit = position_bit_lost_after_error;
    "position-unrequested-after-error" "After an error the position is shown although it is not requested."
        => |b| b.telegram.emit = position_unrequested_after_error;
};

fn positions_swapped(telegram: &Telegram) -> &'static [Signal] {
    use Signal::{G1Xist1, G1Xist2, G1Zsw, NistA, NistB, Zsw2Enc};
    match telegram.number {
        81 => &[Zsw2Enc, G1Zsw, G1Xist2, G1Xist1],
        82 => &[Zsw2Enc, G1Zsw, G1Xist2, G1Xist1, NistA],
        83 => &[Zsw2Enc, G1Zsw, G1Xist2, G1Xist1, NistB],
        _ => telegram.inputs,
    }
}

fn velocity_before_xist2(telegram: &Telegram) -> &'static [Signal] {
    use Signal::{G1Xist1, G1Xist2, G1Xist3, G1Zsw, NistB, Zsw2Enc};
    match telegram.number {
        83 => &[Zsw2Enc, G1Zsw, G1Xist1, NistB, G1Xist2],
        84 => &[Zsw2Enc, G1Zsw, G1Xist3, NistB, G1Xist2],
        _ => telegram.inputs,
    }
}

fn xist3_halves_swapped(signal: Signal, image: &Image, out: &mut Vec<u8>) {
    telegram::put(signal, &Image { g1_xist3: image.g1_xist3.rotate_right(32), ..*image }, out);
}

fn position_little_endian(signal: Signal, image: &Image, out: &mut Vec<u8>) {
    let Image { g1_xist1, g1_xist2, g1_xist3, .. } = *image;
    let swapped = Image {
        g1_xist1: g1_xist1.swap_bytes(),
        g1_xist2: g1_xist2.swap_bytes(),
        g1_xist3: g1_xist3.swap_bytes(),
        ..*image
    };
    telegram::put(signal, &swapped, out);
}

fn nist_a_from_upper_half(signal: Signal, image: &Image, out: &mut Vec<u8>) {
    match signal {
        Signal::NistA => out.put_u16((image.velocity >> 16) as u16),
        other => telegram::put(other, image, out),
    }
}

fn nist_b_not_sign_extended(signal: Signal, image: &Image, out: &mut Vec<u8>) {
    match signal {
        Signal::NistB if image.velocity < 0 => out.put_u32((image.velocity as u16).into()),
        other => telegram::put(other, image, out),
    }
}

fn xist2_always_shows_position(_: &Before, now: Image) -> Image {
    match now.g1_zsw & (POSITION | PARKED | ERROR) {
        0 => Image { g1_xist2: now.position as u32, ..now },
        _ => now,
    }
}

fn xist2_keeps_last_value(before: &Before, now: Image) -> Image {
    match now.g1_zsw & (POSITION | PARKED | ERROR) {
        0 => Image { g1_xist2: before.sent.g1_xist2, ..now },
        _ => now,
    }
}

fn position_bit_stays_with_error(_: &Before, now: Image) -> Image {
    match has_error(&now) && now.request.absolute {
        true => Image { g1_zsw: now.g1_zsw | POSITION, ..now },
        false => now,
    }
}

fn position_bit_lost_after_error(before: &Before, now: Image) -> Image {
    match is_lost(before) && !is_parked(&before.truth) {
        true => without_transfer(now),
        false => now,
    }
}

fn with_transfer(image: Image) -> Image {
    match image.g1_zsw & (PARKED | ERROR) {
        0 => Image { g1_zsw: image.g1_zsw | POSITION, g1_xist2: image.position as u32, ..image },
        _ => image,
    }
}

fn absolute_value_never_ends(before: &Before, now: Image) -> Image {
    match before.sent.g1_zsw & POSITION != 0 {
        true => with_transfer(now),
        false => now,
    }
}

fn position_unrequested_after_error(before: &Before, now: Image) -> Image {
    let goes_on = before.sent.g1_zsw & !before.truth.g1_zsw & POSITION != 0;
    match has_error(&before.truth) || goes_on {
        true => with_transfer(now),
        false => now,
    }
}

fn xist2_one_frame_late(before: &Before, now: Image) -> Image {
    match now.g1_zsw & before.truth.g1_zsw & POSITION != 0 {
        true => Image { g1_xist2: before.truth.g1_xist2, ..now },
        false => now,
    }
}
