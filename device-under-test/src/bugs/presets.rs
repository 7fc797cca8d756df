//! Bugs of presets.

use super::Bug;
use super::image::{ERROR, POSITION, without_transfer};
use crate::encoder::measuring::{self, Step};
use crate::profidrive::sensor::{Preset, Request};
use crate::profidrive::telegram::{Before, Image};
use crate::profidrive::user_parameters::UserParameters;

/// The bugs of this seam.
pub static BUGS: &[Bug] = bugs! {
    // Preset
    "relative-preset-assigns" "A relative preset sets the position instead of shifting it."
        => |b| b.measuring.relative = measuring::absolute;
    "second-relative-preset-ignored" "Only the first relative preset has an effect."
        => |b| b.measuring.relative = |preset| preset.value % preset.range;
    "relative-shift-reversed" "A relative preset shifts the position down by its value."
        => |b| b.measuring.relative = relative_shift_reversed;
    "only-first-preset" "Only the first absolute preset has an effect."
        => |b| b.measuring.absolute = |preset| if preset.offset == 0 { measuring::absolute(preset) } else { preset.offset };
    "preset-in-hardware-steps" "The preset value counts steps of the hardware although scaling is on."
        => |b| b.measuring.value = |value, steps, units| value * units / steps;
    "preset-uses-stored-value" "A preset takes P65000 as it was saved and not as it is."
        => |b| b.memory.presets_stored_value = true;
    "preset-adds-instead-of-assigns" "An absolute preset adds its value to the position."
        => |b| b.measuring.absolute = measuring::relative;
    "preset-on-falling-edge" "The preset is carried out when the request is taken back."
        => |b| b.sensor.begins_preset = |before, now| before.home && !now.home;
    "preset-repeats-while-requested" "The preset is carried out again and again while the request is held."
        => |b| b.sensor.begins_preset = |_, now| now.home;
    "mode-change-repeats-preset" "A change of bit 11 during a request carries out another preset."
        => |b| b.sensor.begins_preset = |before, now| now.home && (!before.home || before.relative != now.relative);
    "preset-never-acknowledged" "Bit 12 of G1_ZSW is never set."
        => |b| b.sensor.acknowledges_preset = |_, _| false;
    "preset-acknowledgement-is-a-pulse" "Bit 12 of G1_ZSW is set for one frame only."
        => |b| b.telegram.emit = |before, now| Image { g1_zsw: now.g1_zsw & !(before.truth.g1_zsw & EXECUTED), ..now };
    "preset-acknowledged-too-early" "The preset is acknowledged before the position is shifted."
        => |b| b.sensor.acknowledges_preset = |preset, _| preset != Preset::Idle;
    "preset-acknowledge-stays" "The acknowledgement of a preset is never taken back."
        => |b| b.sensor.releases_preset = false;
    "preset-mode-alone-shifts" "Bit 11 of G1_STW carries out a relative preset by itself."
        => |b| (b.sensor.asks_for_preset, b.sensor.begins_preset) = (has_mode, mode_begins);
    "writing-preset-value-presets" "Writing P65000 sets the position at once."
        => |b| b.values.preset_value_presets = true;
    "preset-on-both-edges" "The preset is carried out once more when the request is taken back."
        => |b| b.sensor.begins_preset = |before, now| before.home != now.home;
    "relative-preset-not-acknowledged" "A relative preset is carried out without bit 12 of G1_ZSW."
        => |b| b.sensor.acknowledges_preset = |preset, request| preset == Preset::Executed && !request.relative;
    "preset-jump-is-error" "The jump of a preset is taken for a fault of the encoder."
        => |b| b.sensor.preset_raises = Some(0x1001);
    "preset-flashes-error" "Bit 15 of G1_ZSW is set for one frame when a preset is carried out."
        => |b| b.telegram.emit = preset_flashes_error;
    "preset-interrupts-transfer" "The transfer of the position is interrupted for one frame when a preset is carried out."
        => |b| b.telegram.emit = preset_interrupts_transfer;
    "preset-control-inverted" "G1_XIST1 preset control has the natural polarity: 1 is enabled."
        => |b| b.user_parameters.understand = |_, user| UserParameters { preset_acts_on_xist1: !user.preset_acts_on_xist1, ..user };
    "preset-control-gates-all-positions" "G1_XIST1 preset control acts on G1_XIST2 and G1_XIST3 as well."
        => |b| b.user_parameters.presets_xist2 = |user| user.preset_acts_on_xist1;
    "preset-without-class-4" "A preset is carried out although class 4 is off."
        => |b| b.user_parameters.presets = |_| true;
    "position-not-reduced" "The sum of position and offset is not reduced to the measuring range."
        => |b| b.measuring.shift = |position, offset, _| position + offset;
    "offset-only-at-standstill" "The offset is gone as soon as the shaft moves."
        => |b| b.measuring.slip = |step| if step.way() == 0 { step.slip } else { -(step.offset as i64) };
    "highest-position-wraps" "A preset to the highest position makes 0 of it."
        => |b| b.measuring.absolute = highest_position_wraps;
    "old-offset-added-again" "After a change of code sequence or scaling the old offset is added a second time."
        => |b| (b.measuring.slip, b.measuring.absolute) = (old_offset_added_again, before_the_slip);
    "preset-acknowledged-not-done" "A preset that is asked for during an error is acknowledged and not carried out."
        => |b| b.sensor.presets_with_errors = false;
    "parking-clears-offset" "The offset is 0 after parking."
        => |b| b.measuring.resume = |_| 0;
    "offset-sign-reversed" "P65001 shows the offset with the opposite sign."
        => |b| b.values.element = |view, at, right| if at == (65001, 8) { (view.measuring.range() - right) % view.measuring.range() } else { right };
};

fn highest_position_wraps(preset: measuring::Preset) -> u64 {
    let value = if preset.value == preset.range - 1 { 0 } else { preset.value };
    measuring::absolute(measuring::Preset { value, ..preset })
}

fn old_offset_added_again(step: &Step) -> i64 {
    match step.before {
        Some((_, settings)) if settings != step.settings => step.offset as i64,
        _ => step.slip,
    }
}

fn before_the_slip(preset: measuring::Preset) -> u64 {
    let position = (preset.position as i64 - preset.slip).rem_euclid(preset.range as i64) as u64;
    measuring::absolute(measuring::Preset { position, ..preset })
}

const EXECUTED: u16 = 0x1000;

fn is_carried_out(before: &Before, now: &Image) -> bool {
    now.g1_zsw & !before.truth.g1_zsw & EXECUTED != 0
}

fn preset_flashes_error(before: &Before, now: Image) -> Image {
    match is_carried_out(before, &now) {
        true => Image { g1_zsw: now.g1_zsw & !POSITION | ERROR, ..now },
        false => now,
    }
}

fn preset_interrupts_transfer(before: &Before, now: Image) -> Image {
    match is_carried_out(before, &now) {
        true => without_transfer(now),
        false => now,
    }
}

fn has_mode(request: Request) -> bool {
    request.home || request.relative
}

fn mode_begins(before: Request, now: Request) -> bool {
    !has_mode(before) && has_mode(now)
}

fn relative_shift_reversed(preset: measuring::Preset) -> u64 {
    measuring::shift(preset.offset, preset.range - preset.value % preset.range, preset.range)
}
