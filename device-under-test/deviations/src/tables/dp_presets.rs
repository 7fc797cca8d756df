//! Bugs of presets by bit 31 of a telegram of the vendor, and of those by G1_STW that are in force at once.

use super::Deviation;
use super::presets::absolute_beyond_the_range;
use super::sensor_memory::{KeptTrigger, RestedTrigger};
use super::slave_memory::Zeroes;
use core::time::Duration;
use encoder_profile::checks::Check;
use encoder_profile::encoder::PresetMode;
use encoder_profile::encoder::measuring;
use encoder_profile::profidrive::preset_trigger::TRIGGER;
use encoder_profile::profidrive::telegram::Image;
use reference_devices::models::sick_a3m60::knobs::{Known, Origin};

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    // By bit 31
    "preset-with-bit-31" "Bit 31 counts as part of the preset value."
        => |b| {
            b.trigger.value(|word, _, _| word.into());
            b.measuring.absolute(|preset| preset.value.wrapping_sub(preset.position));
            b.measuring.shift(|position, offset, _| position.wrapping_add(offset));
        };
    "preset-in-io-04-only" "The trigger works in the telegram of four octets only."
        => |b| b.at_encoder.preset_word(|word, unused| if unused.is_some() { word & !TRIGGER } else { word });
    "preset-resets-the-time-stamp" "A preset sets the time stamp to 0."
        => |b| b.a3m60.time_stamp = |seconds| (seconds.preset / 1000) as u16;
    "trigger-is-a-level" "While the trigger stands the position is set to the value beside it in each cycle."
        => |b| b.checks.check(|check, right| match check {
            Check::TriggersPreset { now, .. } => now & TRIGGER != 0,
            _ => right,
        });
    "trigger-on-both-edges" "A preset is carried out once more when the trigger falls."
        => |b| b.checks.check(|check, right| match check {
            Check::TriggersPreset { before: Some(before), now } => (before ^ now) & TRIGGER != 0,
            _ => right,
        });
    "new-value-triggers" "Another value beside a trigger that stands makes another preset."
        => |b| b.checks.check(|check, right| match check {
            Check::TriggersPreset { before: Some(before), now } => now & TRIGGER != 0 && before != now,
            _ => right,
        });
    "value-without-trigger" "Another value sets the position without the trigger."
        => |b| b.checks.check(|check, right| match check {
            Check::TriggersPreset { before: Some(before), now } => right || now & TRIGGER == 0 && (before ^ now) & !TRIGGER != 0,
            _ => right,
        });
    "edge-needs-several-cycles" "The trigger has to be 0 for three cycles before it counts again."
        => |b| b.checks.add(RestedTrigger::default());
    "first-outputs-are-an-edge" "A trigger in the first outputs makes a preset."
        => |b| b.checks.check(|check, right| match check {
            Check::TriggersPreset { before: None, now } => now & TRIGGER != 0,
            _ => right,
        });
    "preset-of-26-bits" "The value of a preset has 26 bits."
        => |b| b.at_encoder.preset_word(|word, _| word & (TRIGGER | 0x03FF_FFFF));
    "highest-preset-is-an-error" "A preset to 7FFFFFFFh is not carried out."
        => |b| b.checks.check(|check, right| match check {
            Check::TriggersPreset { now: u32::MAX, .. } => false,
            _ => right,
        });
    "preset-beyond-the-range-taken" "A preset beyond the range is carried out, and the position shows it."
        => |b| {
            b.trigger.value(|word, _, _| (word & !TRIGGER).into());
            b.measuring.absolute(absolute_beyond_the_range);
            b.measuring.shift(|position, offset, range| match offset < range {
                true => measuring::shift(position, offset, range),
                false => position.wrapping_add(offset),
            });
        };
    "preset-undone-by-the-falling-edge" "When the trigger falls the position is the one before the preset again."
        => |b| b.a3m60.undoes_presets = true;
    "clear-keeps-the-edge-memory" "Outputs that are cleared leave the trigger what it was."
        => |b| b.at_encoder.add(KeptTrigger::default());
    "inputs-0-in-clear" "During Clear the inputs are 0."
        => |b| b.slave.add(Zeroes::default());

    // By either
    "preset-from-old-place" "The offset is computed from the place of the shaft 50 ms before."
        => |b| b.a3m60.presets_from_before = Some(Duration::from_millis(50));
    "presets-queue-up" "Each preset waits 20 ms for the memory, and the next ones wait for it."
        => |b| b.a3m60.queues_presets = Some(Duration::from_millis(20));
    "preset-acknowledged-too-early" "The position is set 100 ms after the acknowledgement."
        => |b| b.a3m60.queues_presets = Some(Duration::from_millis(100));

    // By G1_STW
    "absolute-preset-is-relative" "Each preset is relative."
        => |b| b.at_encoder.control_words(|_, [a, b]| [a, b | 0x0800]);
    "preset-of-xist1-not-shifted" "A preset sets G1_XIST1 to its value without the shift."
        => |b| b.a3m60.image = preset_of_xist1_not_shifted;
    "preset-value-of-erased-memory" "A preset value of 0 is taken for that of an erased memory."
        => |b| b.at_encoder.preset_units(|view, mode, right| match view.preset_value {
            0 => view.facts.preset_values.units(mode, 0x7FFF_FFFF, view.positions),
            _ => right,
        });
    "relative-preset-unsigned" "The value of a relative preset has no sign, and goes to the end of the range at most."
        => |b| b.at_encoder.preset_units(|view, mode, right| match mode {
            PresetMode::Absolute => right,
            PresetMode::Relative => u64::from(view.preset_value).min(view.positions / 2),
        });
    "only-first-preset" "After power-up two presets by G1_STW are carried out."
        => |b| b.a3m60.presets = |asked| asked.origin != Origin::Request || asked.count < 2;
    "preset-control-enables-presets" "With class 4 off presets are made if the preset control is active."
        => |b| b.checks.check(|check, right| match check {
            Check::PresetsAct(user) => right || user.preset_acts_on_xist1,
            _ => right,
        });
    "preset-needs-the-absolute-value" "A preset by G1_STW is not carried out while the position is not asked for."
        => |b| b.a3m60.presets = |asked| asked.origin != Origin::Request || asked.is_transferred;
};

/// What the shift makes more of the value of the last preset is taken away again.
fn preset_of_xist1_not_shifted(known: &Known, image: Image) -> Image {
    let shifted = image.g1_xist1 << image.shift;
    Image { g1_xist1: shifted.wrapping_sub(known.last_preset as u32), shift: 0, ..image }
}
