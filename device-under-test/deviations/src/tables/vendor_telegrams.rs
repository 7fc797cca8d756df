//! Bugs of the telegrams of a vendor: position with a code in its place, preset with its trigger, speed, time stamp.

use super::Deviation;
use super::image::{ERROR, has_error, is_parked};
use super::layouts::swap_words;
use super::sensor_memory::ForgottenInPark;
use super::signals::put;
use crate::seams::encoder::SentSignal;
use alloc::vec::Vec;
use core::time::Duration;
use encoder_profile::encoder::{Sampling, Unit};
use encoder_profile::profidrive::preset_trigger::TRIGGER;
use encoder_profile::profidrive::telegram::{Before, Image, Signal};
use reference_devices::models::sick_a3m60::knobs::{Causes, Known};

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    // Words of the image
    "words-of-the-image-swapped" "The two words of each double word are exchanged, in outputs and inputs."
        => |b| {
            b.at_encoder.signal(|_, octets| swap_words(octets));
            b.at_encoder.preset_word(|word, _| word.rotate_right(16));
        };
    "trigger-in-unused-outputs" "Bit 31 of the unused outputs triggers a preset too."
        => |b| b.at_encoder.preset_word(|word, unused| word | unused.unwrap_or(0) & TRIGGER);
    "preset-in-unused-outputs" "The preset is taken from the unused outputs."
        => |b| b.at_encoder.preset_word(|word, unused| unused.unwrap_or(word));
    "speed-behind-the-time-stamp" "The time stamp stands in front of the speed."
        => |b| b.at_encoder.order(|telegram| match telegram.inputs {
            [Signal::Position, Signal::NistA, Signal::TimeStamp] => &[Signal::Position, Signal::TimeStamp, Signal::NistA],
            right => right,
        });
    "telegram-83-not-shifted" "In telegram 83 G1_XIST1 is not shifted."
        => |b| b.at_encoder.signal(|of, octets| if of.telegram.number == 83 && of.signal == Signal::G1Xist1 { put(octets, of.image.g1_xist1) });
    "position-of-26-bits" "The position has 26 bits."
        => |b| b.at_encoder.image(|_, now| Image { plain_position: if has_code(&now) { now.plain_position } else { now.plain_position & 0x03FF_FFFF }, ..now });
    "trigger-bit-echoed" "While bit 31 of the outputs is set, it is set in the inputs too."
        => |b| b.at_encoder.image(|_, now| Image { plain_position: now.plain_position | now.trigger & TRIGGER, ..now });
    "offset-in-io-04-only" "The offset of presets does not count in the telegram of eight octets."
        => |b| b.at_encoder.signal(offset_in_io_04_only);
    "half-steps-in-xist1" "The lowest bit of G1_XIST1 is 1."
        => |b| b.at_encoder.signal(|of, octets| if of.signal == Signal::G1Xist1 { octets[3] |= 1 });
    "park-and-position-bits-exchanged" "Bits 13 and 14 of G1_STW are exchanged."
        => |b| b.at_encoder.control_words(|_, [a, b]| [a, b & !0x6000 | (b & 0x2000) << 1 | (b & 0x4000) >> 1]);
    "reserved-stw2-bits-act" "Each reserved bit of STW2_ENC takes control away from the PLC, in compatibility mode too."
        => |b| b.at_encoder.control_words(|_, [a, b]| if a & 0x0B7F == 0 { [a, b] } else { [a & !0x0400, 0] });
    "parking-makes-a-speed" "Begin and end of parking show as motion."
        => |b| b.at_encoder.image(|before, now| Image { velocity: if is_parked(&now) != is_parked(&before.truth) { 1000 } else { now.velocity }, ..now });
    "status-bit-10-shows-motion" "The reserved bit 10 of G1_ZSW is set while the shaft stands still."
        => |b| b.at_encoder.image(|_, now| Image { g1_zsw: now.g1_zsw | if now.velocity == 0 { 0x0400 } else { 0 }, ..now });
    "error-after-start" "Each connection begins with an error of the position."
        => |b| b.a3m60.begins_with_error = true;
    "error-lost-in-park" "An error whose cause came while parked is not shown afterwards."
        => |b| b.checks.add(ForgottenInPark::default());

    // A code in place of the position
    "io-code-of-16-bits" "A code has zeros in its upper 16 bits."
        => |b| b.a3m60.image = |_, now| code_as(now, |code| code & 0xFFFF);
    "io-code-without-bit-31" "A code has no bit 31."
        => |b| b.a3m60.image = |_, now| code_as(now, |code| code & !TRIGGER);
    "synchronization-not-checked" "Neither deviation of the counters is noticed."
        => |b| b.a3m60.fault_code = |name, right| (!is_synchronization(name)).then_some(right);
    "io-code-in-decimal-digits" "The code -10 is sent as FFFFFFF0h and -8 as FFFFFFF2h."
        => |b| b.a3m60.fault_code = |_, right| Some(match right { -10 => -16, -8 => -14, other => other });
    "io-codes-ored" "Several codes are combined bit by bit."
        => |b| b.a3m60.code = |causes| causes.codes.iter().copied().reduce(|all, code| all & code);
    "first-error-kept" "Of several codes the first one of the table is shown."
        => |b| b.a3m60.code = |causes| causes.codes.first().copied();
    "code-of-several-stays" "The code -16 stays until power-off."
        => |b| b.a3m60.code = |causes| if causes.known.had_several { Some(-16) } else { single(causes) };
    "io-code-and-position-alternate" "In each second cycle the position stands in place of the code."
        => |b| b.at_encoder.image(io_code_and_position_alternate);
    "io-code-in-the-speed" "The speed is -3 while there is a code."
        => |b| b.at_encoder.image(|_, now| Image { velocity: if has_code(&now) { -3 } else { now.velocity }, ..now });
    "show-fault-code-ignored" "The code is shown whether it should be or not."
        => |b| b.a3m60.shows_codes = |_| true;
    "warning-blocks-the-position" "A speed that is too high has the code -16."
        => |b| b.a3m60.code = |causes| if causes.known.words.a & 1 << 5 != 0 { Some(-16) } else { single(causes) };
    "code-for-a-missing-clock" "A missing clock has the code -16."
        => |b| b.a3m60.code = |causes| if causes.known.words.b & 1 << 5 != 0 { Some(-16) } else { single(causes) };
    "position-with-an-error-without-a-row" "Wrong parameters in the EEPROM and a wrong linearization have no code."
        => |b| b.a3m60.fault_code = |name, right| (!matches!(name, "eeprom_checksum" | "linearization")).then_some(right);
    "undocumented-io-code" "The amplitude of the cosine has the code -6."
        => |b| b.a3m60.fault_code = |name, right| Some(if name == "amplitude_cosine" { -6 } else { right });
    "show-fault-code-hides-all-codes" "Where fault codes are not shown G1_XIST2 has none either."
        => |b| b.a3m60.image = show_fault_code_hides_all_codes;
    "error-code-in-the-speed" "The code of an error stands in NIST_B too."
        => |b| b.at_encoder.image(|_, now| Image { velocity: if has_error(&now) { now.g1_xist2.into() } else { now.velocity }, ..now });
    "synchronization-without-a-code" "A deviation of the counters that is found when the supply comes has no code and no bit 15."
        => |b| b.at_encoder.code(|error| if is_caused_at_start(error) { None } else { error.code });

    // Speed
    "speed-in-steps" "The speed is in steps per second."
        => |b| b.a3m60.vendor_unit = |_| Unit::PerSecond;
    "unit-in-io-08" "The unit of the parameters counts here too."
        => |b| b.a3m60.vendor_unit = |unit| unit;
    "speed-sign-and-magnitude" "A negative speed is a magnitude with the highest bit set."
        => |b| b.at_encoder.signal(speed_sign_and_magnitude);
    "velocity-limited-at-8191" "The speed stops at 8191."
        => |b| b.at_encoder.image(|_, now| Image { velocity: now.velocity.clamp(-8191, 8191), ..now });
    "speed-never-quite-0" "A shaft at rest has the speed 1."
        => |b| b.at_encoder.image(|_, now| Image { velocity: if now.velocity == 0 { 1 } else { now.velocity }, ..now });
    "speed-by-blocks" "The speed is renewed when the time of its mean is over."
        => |b| b.velocity.sampling(|_, right| Sampling { every: right.every * right.of, of: 1 });
    "velocity-every-cycle" "The speed is renewed each millisecond."
        => |b| b.velocity.sampling(|_, right| Sampling { every: Duration::from_millis(1), of: (right.every * right.of).as_millis().max(1) as u32 });
    "speed-calculation-always" "The speed is calculated although it should not be."
        => |b| b.a3m60.measures_speed = |_| true;
    "speed-settings-without-effect" "P1008 has no effect."
        => |b| b.a3m60.speed_is_used = false;
    "isochronous-mean-of-a-second" "The mean is that without a clock in isochronous operation too."
        => |b| b.a3m60.measures_speed_with_clock = false;

    // Time stamp
    "time-stamp-in-milliseconds" "The time stamp counts milliseconds."
        => |b| b.a3m60.time_stamp = |seconds| seconds.powered as u16;
    "time-stamp-by-two" "The time stamp grows by two each two seconds."
        => |b| b.a3m60.time_stamp = |seconds| (seconds.powered / 2000 * 2) as u16;
    "time-stamp-kept" "The time stamp goes on from where it was when the supply went."
        => |b| b.a3m60.time_stamp = |seconds| (seconds.operated / 1000) as u16;
    "time-stamp-reset-by-parameters" "Each start sets the time stamp to 0."
        => |b| b.a3m60.time_stamp = |seconds| (seconds.connected / 1000) as u16;
    "time-stamp-with-motion-only" "The time stamp stands still while the shaft does."
        => |b| b.a3m60.time_stamp = |seconds| (seconds.moved / 1000) as u16;
    "time-stamp-stops-with-an-error" "The time stamp stands still while there is an error."
        => |b| b.a3m60.time_stamp = |seconds| (seconds.healthy / 1000) as u16;
};

/// Whether a code stands in place of the position.
fn has_code(image: &Image) -> bool {
    image.plain_position & TRIGGER != 0
}

fn code_as(image: Image, change: fn(u32) -> u32) -> Image {
    let plain_position = if has_code(&image) { change(image.plain_position) } else { image.plain_position };
    Image { plain_position, ..image }
}

fn single(causes: &Causes<'_>) -> Option<i32> {
    let first = causes.codes.first().copied()?;
    Some(if causes.codes.iter().all(|code| *code == first) { first } else { -16 })
}

fn is_synchronization(name: &str) -> bool {
    matches!(name, "synchronization_shutdown" | "synchronization_start")
}

fn is_caused_at_start(error: &encoder_profile::facts::ErrorFact) -> bool {
    error.causes.contains(&encoder_profile::facts::Cause::Stand("synchronization_start"))
}

fn offset_in_io_04_only(of: &SentSignal<'_>, octets: &mut Vec<u8>) {
    let image = of.image;
    if of.signal == Signal::Position && of.telegram.input_octets == 8 && !has_code(image) {
        let positions = image.positions.max(1);
        put(octets, ((u64::from(image.plain_position) + positions - image.offset % positions) % positions) as u32);
    }
}

fn io_code_and_position_alternate(before: &Before, now: Image) -> Image {
    match has_code(&now) && has_code(&before.sent) {
        true => Image { plain_position: now.position as u32, ..now },
        false => now,
    }
}

fn show_fault_code_hides_all_codes(known: &Known, image: Image) -> Image {
    match has_error(&image) && !known.fields.shows_codes() {
        true => {
            let transfers = image.is_transferred;
            let g1_xist2 = if transfers { image.position as u32 } else { 0 };
            Image { g1_zsw: image.g1_zsw & !ERROR | u16::from(transfers) << 13, g1_xist2, ..image }
        }
        false => image,
    }
}

fn speed_sign_and_magnitude(of: &SentSignal<'_>, octets: &mut Vec<u8>) {
    let magnitude = of.image.velocity.unsigned_abs();
    match of.signal {
        Signal::NistA if of.image.velocity < 0 => *octets = (magnitude as u16 | 0x8000).to_be_bytes().into(),
        Signal::NistB if of.image.velocity < 0 => put(octets, magnitude as u32 | TRIGGER),
        _ => {}
    }
}
