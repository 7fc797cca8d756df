//! Bugs of positions that are the mean of samples, of their scaling, and of a round axis that comes with the start.

use super::Deviation;
use super::limits::without_laps;
use super::vendor_parameters::gear_of;
use crate::seams::measuring::Step;
use encoder_profile::checks::Check;
use encoder_profile::encoder::measuring;
use encoder_profile::encoder::{Direction, Gear, Hardware, Scaling, Settings};
use encoder_profile::profidrive::telegram::{Image, Signal};
use reference_devices::models::sick_a3m60::knobs::{Fields, Known};

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    // Samples
    "linearization-not-applied" "The position deviates by a hundred steps within a revolution."
        => |b| b.measuring.scale(linearization_not_applied);
    "no-mean-of-samples" "The position is a single sample, and noise counts three times."
        => |b| (b.a3m60.samples, b.a3m60.noise) = (|_, _| 1, |noise| 3 * noise);
    "sum-not-divided" "The sum of several samples is divided by half of their number."
        => |b| b.a3m60.mean = |places| (places.iter().sum::<i64>()) / (places.len() as i64 / 2).max(1);
    "any-number-of-samples" "Any number of samples is accepted, and one that is none is 1."
        => |b| {
            b.a3m60.judges_samples = |_, _| true;
            b.a3m60.samples = |count, is_isochronous| if !is_isochronous && matches!(count, 2 | 4 | 8) { count } else { 1 };
        };
    "samples-ignored" "A position is the mean of eight samples, whatever is set."
        => |b| b.a3m60.samples = |_, is_isochronous| if is_isochronous { 1 } else { 8 };
    "mean-of-both-ends" "The mean is computed without regard to the end of the range."
        => |b| b.a3m60.mean = mean_of_both_ends;
    "freeze-stops-measuring" "Turns of the shaft while the inputs are frozen are lost."
        => |b| b.a3m60.measures_while_frozen = false;
    "resolution-of-13-bits" "The sensor has 8192 steps, of which each counts twice."
        => |b| b.measuring.scale(|scaling, hardware, place| scaling.position(hardware, place & !1));

    // Scaling
    "xist1-not-scaled" "Scaling does not act on G1_XIST1."
        => |b| b.telegram.acts_on(|signal, hardware, settings| match signal {
            Signal::G1Xist1 => Settings { scaling: Scaling::hardware(hardware), gear: None, ..settings },
            _ => settings,
        });
    "shift-overflows" "Behind the highest position comes one with bit 31 set."
        => |b| {
            b.measuring.range(|scaling, hardware, _| if *scaling == Scaling::hardware(hardware) { 1 << 32 } else { scaling.range });
            b.measuring.slip(|step| step.slip + step.crossing() * step.units());
        };
    "code-sequence-of-the-turn-only" "The code sequence acts within a revolution; whole revolutions count clockwise."
        => |b| b.measuring.slip(code_sequence_of_the_turn_only);
    "scaling-ignored" "Scaling is never in force."
        => |b| b.checks.check(|check, right| right && !matches!(check, Check::ScalingActs(_)));
    "class-4-ignored-by-the-code-sequence" "The code sequence acts although class 4 is off."
        => |b| b.checks.check(|check, right| right || matches!(check, Check::CodeSequenceActs(_)));
    "class-4-inverted" "Class 4 is on where its bit is 0."
        => |b| b.a3m60.understands = |fields| Fields { switches: [fields.switches[0] ^ 2, fields.switches[1]], ..fields };
    "functions-in-telegrams-only" "Scaling and code sequence do not act in the telegrams of the vendor."
        => |b| b.a3m60.settings = |settings, is_of_vendor, hardware| match is_of_vendor {
            true => Settings { offset_acts: settings.offset_acts, ..Settings::hardware(hardware) },
            false => settings,
        };
    "scaling-cuts-off" "Steps of the hardware are cut off at the range and not scaled."
        => |b| b.measuring.scale(|scaling, _, place| place % scaling.range.max(1));
    "scaling-by-shifts" "Steps of the hardware are shifted by whole bits."
        => |b| b.measuring.scale(scaling_by_shifts);
    "revolutions-of-16-bits" "Revolutions are counted by 16 bits."
        => |b| b.measuring.range(|scaling, _, _| scaling.range.min(scaling.units_per_revolution << 16));
    "other-telegram-in-compatibility-mode" "In compatibility mode the two positions change places."
        => |b| b.a3m60.image = other_telegram_in_compatibility_mode;

    // Round axis
    "round-axis-jumps-at-the-physical-zero" "Where the hardware begins anew the position jumps."
        => |b| {
            b.measuring.position(without_laps);
            b.at_encoder.element(|_, at, right| if at == (1009, 4) { 0 } else { right });
            b.measuring.slip(|step| match step.settings.scaling == Scaling::hardware(&step.hardware) {
                true => 0,
                false => step.slip + step.crossing() * (step.settings.scaling.units_per_revolution as i64 / 4 + 1),
            });
        };
    "resolution-scales-round-axis" "The steps per revolution count with the round axis."
        => |b| b.sick.gear = |gear, user| gear_of(user.units_per_revolution, gear.range);
    "overflow-not-stored" "How often the physical end was passed is lost at power-off."
        => |b| b.sick.laps = |_| 0;
    "overflow-without-power-missed" "A physical end that is passed without power is not noticed."
        => |b| b.sick.counts_way_without_power = false;
    "range-of-round-axis-too-small" "The smallest and the largest range of a round axis are refused."
        => |b| b.sick.judges_axis = |right, user| right && user.range != 1 && user.range != 1 << 30;
    "fraction-of-16-bits" "A nominator or divisor of 65536 is refused."
        => |b| b.sick.takes = |at, value, right| right && !matches!((at, value), ((1009, 1 | 2), 0x1_0000));
    "round-axis-range-not-checked" "Range, nominator and divisor of a round axis are taken as they are, and 0 as 1."
        => |b| {
            b.sick.judges_axis = |_, _| true;
            b.sick.takes = |at, _, right| right || at.0 == 1009;
            b.a3m60.understands = without_zeros;
        };
    "round-axis-overflows" "More steps in a revolution than the sensor has are taken, and give positions beyond the range."
        => |b| {
            b.sick.judges_axis = |right, user| right || user.range > 0;
            b.measuring.gear(round_axis_overflows);
            b.measuring.shift(not_reduced_beyond);
        };
    "preset-not-reduced-on-the-round-axis" "After a preset the position of a round axis is not reduced to its range."
        => |b| b.measuring.shift(|position, offset, range| if range < 1 << 31 { position + offset } else { measuring::shift(position, offset, range) });
    "negative-positions" "Positions of a round axis below 0 are sent as such."
        => |b| {
            b.measuring.gear(negative_positions);
            b.measuring.shift(not_reduced_beyond);
        };
    "rounding-errors-add-up" "The steps of a revolution of a round axis are rounded to hundredths."
        => |b| b.measuring.gear(|gear, hardware, place| {
            let hundredths = gear.range * gear.divisor * 100 / gear.nominator.max(1);
            let units = place * i128::from(hundredths) / (100 * i128::from(hardware.steps_per_revolution));
            units.rem_euclid(gear.range.max(1).into()) as u64
        });
};

/// A deviation that is 0 at the ends of each half of a revolution and a hundred steps in their middle.
fn linearization_not_applied(scaling: &Scaling, hardware: &Hardware, place: u64) -> u64 {
    let (revolution, half) = (hardware.steps_per_revolution, hardware.steps_per_revolution / 2);
    let within = place % revolution;
    let at = within % half;
    let deviation = 400 * at * (half - at) / (half * half).max(1);
    let off = if within < half { place + deviation } else { place + hardware.range() - deviation };
    scaling.position(hardware, off % hardware.range())
}

fn mean_of_both_ends(places: &[i64]) -> i64 {
    let reduced = places.iter().map(|place| place.rem_euclid(1 << 31));
    let mean = reduced.sum::<i64>() / (places.len() as i64).max(1);
    // What is far from the end of the range is not touched by it.
    match places.last() {
        Some(last) => last - last.rem_euclid(1 << 31) + mean,
        None => mean,
    }
}

fn code_sequence_of_the_turn_only(step: &Step) -> i64 {
    let revolution = step.hardware.steps_per_revolution;
    if step.settings.direction == Direction::Clockwise || step.settings.scaling != Scaling::hardware(&step.hardware) {
        return 0;
    }
    let clockwise = step.hardware.range() - 1 - step.now;
    let wrong = clockwise / revolution * revolution + step.now % revolution;
    wrong as i64 - step.now as i64
}

fn scaling_by_shifts(scaling: &Scaling, hardware: &Hardware, place: u64) -> u64 {
    let steps = hardware.steps_per_revolution / scaling.units_per_revolution.max(1);
    (place >> steps.max(1).ilog2()) % scaling.range.max(1)
}

fn other_telegram_in_compatibility_mode(known: &Known, image: Image) -> Image {
    match known.fields.switches[0] & 0x20 == 0 && !known.is_of_vendor {
        true => Image { g1_xist1: image.g1_xist2, shift: 0, g1_xist2: image.g1_xist1 << image.shift, ..image },
        false => image,
    }
}

fn without_zeros(fields: Fields) -> Fields {
    let Fields { nominator, divisor, range, .. } = fields;
    match fields.has_axis() {
        true => Fields { nominator: nominator.max(1), divisor: divisor.max(1), range: range.max(1), ..fields },
        false => fields,
    }
}

/// A sum that is reduced only as long as the position is within its range.
fn not_reduced_beyond(position: u64, offset: u64, range: u64) -> u64 {
    if position < range { measuring::shift(position, offset, range) } else { position.wrapping_add(offset) }
}

fn round_axis_overflows(gear: &Gear, hardware: &Hardware, place: i128) -> u64 {
    let position = gear.position(hardware, place);
    match gear.range * gear.divisor > hardware.steps_per_revolution * gear.nominator {
        true => position + gear.range,
        false => position,
    }
}

fn negative_positions(gear: &Gear, hardware: &Hardware, place: i128) -> u64 {
    let position = gear.position(hardware, place);
    if place < 0 { position.wrapping_sub(gear.range) } else { position }
}
