//! Bugs of averaged positions, of their scaling, and of the round axis of the A3M60.

use super::Group;
use super::limits::without_laps;
use super::vendor_parameters::gear_of;
use crate::needs::Need;
use crate::seams::measuring::ShaftStep;
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::Cell;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder::measuring;
use encoder_profile::encoder::{CountingDirection, Gear, Hardware, MeasuringSettings, Scaling};
use encoder_profile::encoder_object::PoweredEncoder;
use encoder_profile::profidrive::telegram::{InputSignal, SignalImage};
use reference_devices::manuals;
use reference_devices::models::sick::axis::CountedLaps;
use reference_devices::models::sick_a3m60::A3m60State;
use reference_devices::models::sick_a3m60::hooks::A3m60Hooks;
use reference_devices::models::sick_a3m60::set_prm::UserByteFields;
use wire::profibus::global_control::GlobalCommand;

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Of(&manuals::SICK_A3M60)],
    deviations: bugs! {
        // Samples
        "linearization-not-applied" "The position deviates by up to a hundred steps within a revolution."
            => |d| d.measuring.scale(linearization_not_applied);
        "no-mean-of-samples" "The position is a single sample with five times the noise."
            => |d| d.a3m60.place(|encoder, place| {
                let single = if encoder.model.clock.place().is_some() { place } else { encoder.model.samples.mean(1) };
                let shaft = encoder.shaft.position(encoder.now);
                if encoder.shaft.is_moving(encoder.now) { single } else { shaft + 5 * (single - shaft) }
            });
        "sum-not-divided" "The sum of the samples is divided by half their number."
            => |d| d.a3m60.place(|encoder, place| {
                let places = samples(encoder);
                if places.is_empty() { place } else { places.iter().sum::<i64>() / (places.len() as i64 / 2).max(1) }
            });
        "any-number-of-samples" "Any number of samples is accepted; invalid numbers are treated as 1."
            => |d| d.fields(|fields| UserByteFields { samples: if matches!(fields.samples, 2 | 4 | 8) { fields.samples } else { 1 }, ..fields });
        "samples-ignored" "A position is always the mean of eight samples."
            => |d| d.fields(|fields| UserByteFields { samples: if matches!(fields.samples, 1 | 2 | 4 | 8) { 8 } else { fields.samples }, ..fields });
        "mean-of-both-ends" "The mean is wrong at the end of the range."
            => |d| d.a3m60.place(|encoder, place| {
                let places = samples(encoder);
                let end = i64::from(encoder.model.fields.range).max(1);
                if places.is_empty() { place } else { mean_of_both_ends(&places, end) }
            });
        "freeze-stops-measuring" "Movements of the shaft during Freeze are lost."
            => |d| {
                let is_frozen = Rc::new(Cell::new(false));
                let command = is_frozen.clone();
                d.slave.global_control(move |control| {
                    let has = |bit| control.command.has(bit);
                    command.set((command.get() || has(GlobalCommand::FREEZE)) && !has(GlobalCommand::UNFREEZE));
                });
                d.a3m60.add(LostWhileFrozen { is_frozen, frozen_at: None, lost: 0 });
            };
        "resolution-of-13-bits" "The sensor has 8192 steps per revolution instead of 16384."
            => |d| d.measuring.scale(|scaling, hardware, place| scaling.position(hardware, place & !1));

        // Scaling
        "xist1-not-scaled" "Scaling does not act on G1_XIST1."
            => |d| d.telegram.acts_on(|signal, hardware, settings| match signal {
                InputSignal::G1Xist1 => MeasuringSettings { scaling: Scaling::hardware(hardware), gear: None, ..settings },
                _ => settings,
            });
        "shift-overflows" "Positions beyond the highest position continue with bit 31 set."
            => |d| {
                d.measuring.range(|scaling, hardware, _| if *scaling == Scaling::hardware(hardware) { 1 << 32 } else { scaling.range });
                d.measuring.slip(|step| step.slip + step.crossing() * step.units());
            };
        "code-sequence-of-the-turn-only" "The code sequence acts only within a revolution; whole revolutions count clockwise."
            => |d| d.measuring.slip(code_sequence_of_the_turn_only);
        "scaling-ignored" "Scaling is never in force."
            => |d| d.checks.check(|check, right| right && !matches!(check, EncoderCheck::ScalingActs(_)));
        "class-4-ignored-by-the-code-sequence" "The code sequence acts although class 4 is off."
            => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::CodeSequenceActs(_)));
        "class-4-inverted" "Class 4 is on if its bit is 0."
            => |d| d.fields(|fields| UserByteFields { switches: [fields.switches[0] ^ 2, fields.switches[1]], ..fields });
        "functions-in-telegrams-only" "Scaling and code sequence have no effect in the vendor telegrams."
            => |d| {
                let is_of_vendor = d.track(false, |encoder, _, _| encoder.ram.telegram().number == 0);
                d.telegram.acts_on(|signal, hardware, settings| match signal {
                    InputSignal::Position => MeasuringSettings { offset_acts: settings.offset_acts, ..MeasuringSettings::hardware(hardware) },
                    _ => settings,
                });
                d.encoder.element(move |view, at, right| match at {
                    (65001, 9) if is_of_vendor.get() => view.hardware.steps_per_revolution,
                    (65001, 10) if is_of_vendor.get() => view.hardware.range(),
                    _ => right,
                });
                d.a3m60.image(clockwise_velocity);
            };
        "scaling-cuts-off" "Hardware steps are reduced modulo the range instead of scaled."
            => |d| d.measuring.scale(|scaling, _, place| place % scaling.range.max(1));
        "scaling-by-shifts" "Hardware steps are scaled by shifting whole bits."
            => |d| d.measuring.scale(scaling_by_shifts);
        "revolutions-of-16-bits" "Revolutions are counted in 16 bits."
            => |d| d.measuring.range(|scaling, _, _| scaling.range.min(scaling.units_per_revolution << 16));
        "other-telegram-in-compatibility-mode" "In compatibility mode the two positions are swapped."
            => |d| d.a3m60.image(other_telegram_in_compatibility_mode);

        // Round axis
        "round-axis-jumps-at-the-physical-zero" "The position jumps at the physical zero."
            => |d| {
                d.measuring.position(without_laps);
                d.encoder.element(|_, at, right| if at == (1009, 4) { 0 } else { right });
                d.measuring.slip(|step| if step.settings.scaling == Scaling::hardware(&step.hardware) {
                    0
                } else {
                    step.slip + step.crossing() * (step.settings.scaling.units_per_revolution as i64 / 4 + 1)
                });
            };
        "resolution-scales-round-axis" "The configured steps per revolution are used with the round axis."
            => |d| d.sick_axis.gear(|user, _, gear| gear_of(user.units_per_revolution, gear.range));
        "overflow-not-stored" "The laps of the round axis are lost at power-off."
            => |d| d.sick.laps_loaded(|_, laps| CountedLaps { laps: 0, ..laps });
        "overflow-without-power-missed" "Crossing the physical zero without power is not detected."
            => |d| d.sick.laps_loaded(|now, laps| CountedLaps { place: now, ..laps });
        "range-of-round-axis-too-small" "The smallest and the largest range of a round axis are refused."
            => |d| d.sick.axis_range(|range, _, right| right && range != 1 && range != 1 << 30);
        "fraction-of-16-bits" "A nominator or divisor of 65536 is refused."
            => |d| d.sick.setting(|at, value, right| right && !matches!((at, value), ((1009, 1 | 2), 0x1_0000)));
        "round-axis-range-not-checked" "Range, nominator and divisor of a round axis are not checked; 0 is treated as 1."
            => |d| {
                d.sick.axis_range(|_, _, _| true);
                d.sick.setting(|at, _, right| right || at.0 == 1009);
                d.fields(without_zeros);
            };
        "round-axis-overflows" "More steps per revolution than the sensor has are accepted and result in positions beyond the range."
            => |d| {
                d.sick.axis_range(|range, _, right| right || range > 0);
                d.measuring.gear(round_axis_overflows);
                d.measuring.shift(not_reduced_beyond);
            };
        "preset-not-reduced-on-the-round-axis" "After a preset the position of a round axis is not reduced modulo its range."
            => |d| d.measuring.shift(|position, offset, range| if range < 1 << 31 { position + offset } else { measuring::shift(position, offset, range) });
        "negative-positions" "Positions of a round axis below 0 are sent as negative numbers."
            => |d| {
                d.measuring.gear(negative_positions);
                d.measuring.shift(not_reduced_beyond);
            };
        "rounding-errors-add-up" "The steps per revolution of a round axis are rounded to hundredths, so errors add up."
            => |d| d.measuring.gear(|gear, hardware, place| {
                let hundredths = gear.range * gear.divisor * 100 / gear.nominator.max(1);
                let units = place * i128::from(hundredths) / (100 * i128::from(hardware.steps_per_revolution));
                units.rem_euclid(gear.range.max(1).into()) as u64
            });
    },
}];

/// Adds a deviation that is 0 at the ends of each half revolution and a hundred steps in its middle.
fn linearization_not_applied(scaling: &Scaling, hardware: &Hardware, place: u64) -> u64 {
    let (revolution, half) = (hardware.steps_per_revolution, hardware.steps_per_revolution / 2);
    let within = place % revolution;
    let at = within % half;
    let deviation = 400 * at * (half - at) / (half * half).max(1);
    let off = if within < half { place + deviation } else { place + hardware.range() - deviation };
    scaling.position(hardware, off % hardware.range())
}

/// The samples of a position, the present one first; none in isochronous operation.
fn samples(encoder: &PoweredEncoder<'_, A3m60State>) -> Vec<i64> {
    match encoder.model.clock.times() {
        Some(_) => Vec::new(),
        None => encoder.model.samples.last(encoder.model.fields.samples.into()).collect(),
    }
}

/// The mean of positions that are reduced to the range before, which is wrong at its end.
fn mean_of_both_ends(places: &[i64], end: i64) -> i64 {
    let reduced = places.iter().map(|place| place.rem_euclid(end));
    let mean = reduced.sum::<i64>() / (places.len() as i64).max(1);
    // Only positions near the end of the range are affected.
    match places.first() {
        Some(present) => present - present.rem_euclid(end) + mean,
        None => mean,
    }
}

/// Loses movements of the shaft while the inputs are frozen.
struct LostWhileFrozen {
    is_frozen: Rc<Cell<bool>>,
    frozen_at: Option<i64>,
    lost: i64,
}

impl A3m60Hooks for LostWhileFrozen {
    fn place(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, place: i64) -> i64 {
        let shaft = encoder.shaft.position(encoder.now);
        if self.is_frozen.get() {
            self.frozen_at = self.frozen_at.or(Some(shaft))
        } else {
            self.lost += self.frozen_at.take().map_or(0, |frozen| shaft - frozen)
        }
        self.frozen_at.unwrap_or(place) - self.lost
    }
}

/// Changes the velocity in vendor telegrams to that of a clockwise code sequence.
fn clockwise_velocity(encoder: &PoweredEncoder<'_, A3m60State>, image: SignalImage) -> SignalImage {
    let is_changed = encoder.ram.telegram().number == 0
        && encoder.ram.measuring.settings.direction == CountingDirection::Counterclockwise;
    SignalImage { velocity: if is_changed { -image.velocity } else { image.velocity }, ..image }
}

fn code_sequence_of_the_turn_only(step: &ShaftStep) -> i64 {
    let revolution = step.hardware.steps_per_revolution;
    if step.settings.direction == CountingDirection::Clockwise
        || step.settings.scaling != Scaling::hardware(&step.hardware)
    {
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

fn other_telegram_in_compatibility_mode(encoder: &PoweredEncoder<'_, A3m60State>, image: SignalImage) -> SignalImage {
    if encoder.ram.user.compatible && encoder.ram.telegram().number != 0 {
        SignalImage { g1_xist1: image.g1_xist2, shift: 0, g1_xist2: image.g1_xist1 << image.shift, ..image }
    } else {
        image
    }
}

fn without_zeros(fields: UserByteFields) -> UserByteFields {
    let UserByteFields { nominator, divisor, range, .. } = fields;
    if fields.has_axis() {
        UserByteFields { nominator: nominator.max(1), divisor: divisor.max(1), range: range.max(1), ..fields }
    } else {
        fields
    }
}

/// Adds an offset and reduces the sum only if the position is within its range.
fn not_reduced_beyond(position: u64, offset: u64, range: u64) -> u64 {
    if position < range { measuring::shift(position, offset, range) } else { position.wrapping_add(offset) }
}

fn round_axis_overflows(gear: &Gear, hardware: &Hardware, place: i128) -> u64 {
    let position = gear.position(hardware, place);
    if gear.range * gear.divisor > hardware.steps_per_revolution * gear.nominator {
        position + gear.range
    } else {
        position
    }
}

fn negative_positions(gear: &Gear, hardware: &Hardware, place: i128) -> u64 {
    let position = gear.position(hardware, place);
    if place < 0 { position.wrapping_sub(gear.range) } else { position }
}
