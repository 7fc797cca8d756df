//! Bugs of positions, scaling and the red zone.

use super::Group;
use super::signal_image::is_parked;
use super::signals::put;
use crate::needs::Need;
use crate::seams::measuring::ShaftStep;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder::measuring::{self, OffsetSum};
use encoder_profile::encoder::{CountingDirection, Hardware, MeasuringSettings, Scaling};
use encoder_profile::hooks::EncoderView;
use encoder_profile::profidrive::telegram::{InputSignal, PreviousCycle, SignalImage};
use reference_devices::manuals;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Encoder],
        deviations: bugs! {
            "position-counts-from-zero" "After power-up the position starts at 0."
                => |d| d.measuring.slip(|step| if step.before.is_none() { -(units(step, step.now) as i64) } else { step.slip });
            "revolution-of-13-bits" "A revolution without scaling has 13 bits."
                => |d| d.measuring.scale(revolution_of_13_bits);
            "range-ignored" "The position wraps only at the end of the hardware range."
                => |d| d.measuring.range(|scaling, hardware, _| scaling.units_per_revolution * hardware.revolutions);
            "range-one-too-long" "The range has one position too many."
                => |d| d.measuring.range(|scaling, _, _| scaling.range + 1);
            "unit-of-whole-steps" "The hardware steps per unit are rounded down to a whole number."
                => |d| d.measuring.scale(unit_of_whole_steps);
            "jump-at-every-zero" "At the physical zero the position always jumps by a revolution, with or without a red zone."
                => |d| d.measuring.slip(jump_at_every_zero);
        },
    },
    Group {
        needs: &[Need::EncoderProfile],
        deviations: bugs! {
            "extended-counter" "Beyond its range the position continues into the unused bits."
                => |d| {
                    d.measuring.range(|_, _, _| 1 << 32);
                    d.measuring.slip(|step| step.slip + step.crossing() * step.units());
                };
            "position-before-parking-shown" "The first frame after parking shows the position from before parking."
                => |d| d.encoder.signals(position_before_parking_shown);
            "only-xist1-scaled" "Scaling acts only on G1_XIST1."
                => |d| d.telegram.acts_on(only_xist1_scaled);
            "code-sequence-on-xist1-only" "The code sequence acts only on G1_XIST1."
                => |d| d.telegram.acts_on(code_sequence_on_xist1_only);
            "range-rounded-up" "The range is rounded up to a power of 2."
                => |d| d.measuring.range(|scaling, _, _| (scaling.range + 1).next_power_of_two());
            "range-below-a-revolution-ignored" "A range below one revolution counts as one revolution."
                => |d| d.measuring.range(|scaling, _, _| scaling.range.max(scaling.units_per_revolution));
            "red-zone-forward-only" "The jump at the physical zero is missing when turning backwards."
                => |d| d.measuring.slip(red_zone_forward_only);
            "red-zone-one-late" "The jump comes one position late."
                => |d| d.measuring.slip(red_zone_one_late);
            "red-zone-subtracted-once" "The range is subtracted from the hardware position only once."
                => |d| {
                    d.measuring.scale(red_zone_subtracted_once);
                    d.measuring.shift(not_beyond_the_range);
                };
            "red-zone-in-hardware-steps" "The length of the red zone is computed in hardware steps."
                => |d| d.measuring.scale(red_zone_in_hardware_steps);
            "second-range-from-1" "The second pass of the range begins with 1."
                => |d| d.measuring.scale(second_range_from_1);
            "offset-moves-the-zero" "The jump comes where the position including the offset reaches the end of the hardware range."
                => |d| d.measuring.slip(offset_moves_the_zero);
        },
    },
    Group {
        needs: &[Need::Profinet, Need::EncoderProfile],
        deviations: bugs! {
            "rounding-errors-add-up" "Each movement is scaled and rounded separately, so rounding errors add up."
                => |d| d.measuring.slip(rounding_errors_add_up);
        },
    },
    Group {
        needs: &[Need::Input(InputSignal::G1Xist3)],
        deviations: bugs! {
            "class-4-without-xist3" "Code sequence, preset and scaling do not act on G1_XIST3."
                => |d| d.telegram.acts_on(class_4_without_xist3);
        },
    },
    Group {
        needs: &[Need::Input(InputSignal::SingleTurn)],
        deviations: bugs! {
            "st-pos-without-offset" "The position within the revolution does not include the preset offset."
                => |d| d.encoder.signal(|of, octets| if of.signal == InputSignal::SingleTurn {
                    let MeasuringSettings { scaling, .. } = of.view.measuring.settings;
                    let place = of.view.measuring.with_settings(MeasuringSettings::hardware(&of.view.hardware)).position();
                    put(octets, (scaling.position(&of.view.hardware, place) % scaling.units_per_revolution.max(1)) as u32);
                });
        },
    },
    Group {
        needs: &[Need::Of(&manuals::KUEBLER_SENDIX58XX)],
        deviations: bugs! {
            "second-position-wraps" "Positions that should stay at the highest position wrap at both ends of the range."
                => |d| d.measuring.shifted(|sum, right| sum.saturates_at.map_or(right, |range| signed(sum).rem_euclid(range as i64) as u64));
            "second-position-runs-below-0" "Positions that should stay at the highest position become negative below 0."
                => |d| d.measuring.shifted(second_position_runs_below_0);
            "first-position-limited" "G1_XIST1 is limited to the highest position of the range, like G1_XIST2."
                => |d| d.encoder.image(first_position_limited);
            "stays-at-the-end-when-cyclic" "Positions stay at the highest position beyond their range where they should wrap."
                => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::PositionSaturates(_)));
            "xist1-of-16-bits" "G1_XIST1 has 16 bits only."
                => |d| d.encoder.signals(|_, now| SignalImage { g1_xist1: now.g1_xist1 & 0xFFFF, ..now });
        },
    },
];

/// The position as a signed number, negative in the upper half of the range.
fn signed(sum: &OffsetSum) -> i64 {
    let position = OffsetSum { saturates_at: None, ..*sum }.position();
    if position < sum.range / 2 { position as i64 } else { position as i64 - sum.range as i64 }
}

fn second_position_runs_below_0(sum: &OffsetSum, right: u64) -> u64 {
    match (sum.saturates_at, signed(sum)) {
        (Some(_), below @ ..0) => below as u64,
        _ => right,
    }
}

fn first_position_limited(view: &EncoderView<'_>, _: &PreviousCycle, now: SignalImage) -> SignalImage {
    SignalImage { g1_xist1: u64::from(now.g1_xist1).min(view.positions - 1) as u32, ..now }
}

fn unit_of_whole_steps(scaling: &Scaling, hardware: &Hardware, place: u64) -> u64 {
    let steps = hardware.steps_per_revolution / scaling.units_per_revolution.max(1);
    place / steps.max(1) % scaling.range
}

/// The units from the physical zero to a shaft position.
fn units(step: &ShaftStep, place: u64) -> u64 {
    step.settings.scaling.units(&step.hardware, place) as u64
}

fn revolution_of_13_bits(scaling: &Scaling, hardware: &Hardware, place: u64) -> u64 {
    if scaling.units_per_revolution == hardware.steps_per_revolution {
        place / (hardware.steps_per_revolution >> 13) % scaling.range
    } else {
        scaling.position(hardware, place)
    }
}

/// Stores the position from before parking in the sent image, where no telegram shows it.
fn position_before_parking_shown(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    let position = before.sent.position;
    match (is_parked(&before.unhooked), is_parked(&now)) {
        (true, true) => SignalImage { position, ..now },
        (true, false) => SignalImage { g1_xist1: position as u32, g1_xist3: position, ..now },
        _ => now,
    }
}

fn only_xist1_scaled(signal: InputSignal, hardware: &Hardware, settings: MeasuringSettings) -> MeasuringSettings {
    match signal {
        InputSignal::G1Xist1 | InputSignal::NistB => settings,
        _ => MeasuringSettings { scaling: Scaling::hardware(hardware), ..settings },
    }
}

fn code_sequence_on_xist1_only(signal: InputSignal, _: &Hardware, settings: MeasuringSettings) -> MeasuringSettings {
    match signal {
        InputSignal::G1Xist1 | InputSignal::NistB => settings,
        _ => MeasuringSettings { direction: CountingDirection::Clockwise, ..settings },
    }
}

fn class_4_without_xist3(signal: InputSignal, hardware: &Hardware, settings: MeasuringSettings) -> MeasuringSettings {
    match signal {
        InputSignal::G1Xist3 => MeasuringSettings::hardware(hardware),
        _ => settings,
    }
}

fn rounding_errors_add_up(step: &ShaftStep) -> i64 {
    let Some((before, _)) = step.before else { return 0 };
    let (steps, per_revolution) = (step.hardware.steps_per_revolution, step.settings.scaling.units_per_revolution);
    let rounded = (step.movement() * per_revolution as i64).div_euclid(steps as i64);
    let moved = units(step, step.now) as i64 - units(step, before) as i64 + step.crossing() * step.units();
    step.slip + rounded - moved
}

/// Continues counting below the physical zero, until it is crossed forward again.
fn red_zone_forward_only(step: &ShaftStep) -> i64 {
    match step.crossing() {
        -1 => -step.units(),
        1 => 0,
        _ => step.slip,
    }
}

/// Counts the physical zero, reached from below, as one more position of the previous range.
fn red_zone_one_late(step: &ShaftStep) -> i64 {
    match (step.now, step.crossing()) {
        (0, 1) => step.units(),
        (0, _) => step.slip,
        _ => 0,
    }
}

fn jump_at_every_zero(step: &ShaftStep) -> i64 {
    step.slip + step.crossing() * step.settings.scaling.units_per_revolution as i64
}

fn red_zone_subtracted_once(scaling: &Scaling, hardware: &Hardware, place: u64) -> u64 {
    let units = scaling.units(hardware, place) as u64;
    if units < scaling.range { units } else { units - scaling.range }
}

fn not_beyond_the_range(position: u64, offset: u64, range: u64) -> u64 {
    if position < range { measuring::shift(position, offset, range) } else { position + offset }
}

/// Computes the length of the last range before the physical zero as if a unit were a hardware step.
fn red_zone_in_hardware_steps(scaling: &Scaling, hardware: &Hardware, place: u64) -> u64 {
    let units = scaling.units(hardware, place) as u64;
    let begins = scaling.units_per_revolution * hardware.revolutions - hardware.range() % scaling.range;
    if units < begins { units % scaling.range } else { units - begins }
}

fn second_range_from_1(scaling: &Scaling, hardware: &Hardware, place: u64) -> u64 {
    let units = scaling.units(hardware, place) as u64;
    match units / scaling.range {
        1 => units % scaling.range + 1,
        _ => units % scaling.range,
    }
}

fn offset_moves_the_zero(step: &ShaftStep) -> i64 {
    if units(step, step.now) as i64 + step.offset as i64 >= step.units() { -step.units() } else { 0 }
}
