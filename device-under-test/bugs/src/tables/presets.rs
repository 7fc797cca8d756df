//! Deviations of presets.

use super::cyclic_state::{HeldRequests, RaisedByPresets};
use super::parameter_access_state::PresetsAtWrite;
use super::signal_image::{ERROR, EXECUTED, POSITION, is_executed, is_parked, without_transfer};
use super::{Deviation, Group};
use crate::needs::Need;
use crate::seams::Deviations;
use crate::seams::measuring::ShaftStep;
use alloc::rc::Rc;
use core::cell::Cell;
use core::time::Duration;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder::PresetMode;
use encoder_profile::encoder::measuring::{self, PresetBasis};
use encoder_profile::hooks::{EncoderHooks, EncoderView, RetainedEncoderData, WorkingPreset};
use encoder_profile::profidrive::preset_trigger::TRIGGER;
use encoder_profile::profidrive::telegram::{OutputValues, OutputWord, PreviousCycle, SignalImage, Telegram};
use encoder_profile::profidrive::user_parameters::UserParameterData;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[
    Group { needs: &[Need::Output(OutputWord::G1Stw)], deviations: ANYHOW },
    Group { needs: &[Need::Output(OutputWord::G1Stw)], deviations: BY_REQUEST },
    Group {
        needs: &[Need::Profinet, Need::Output(OutputWord::G1Stw)],
        deviations: bugs! {
            "only-first-preset" "Only the first absolute preset has an effect."
                => |d| d.measuring.absolute(|preset| if preset.offset == 0 { preset.new_offset() } else { preset.offset });
            "preset-acknowledged-too-early" "The preset is acknowledged before the position is shifted."
                => |d| d.encoder.image(preset_acknowledged_too_early);
        },
    },
    Group { needs: &[Need::Output(OutputWord::Preset)], deviations: BY_TRIGGER },
];

/// The deviations of presets by any telegram.
pub static ANYHOW: &[Deviation] = bugs! {
    "preset-in-hardware-steps" "The preset value is in hardware steps although scaling is on."
        => |d| d.measuring.preset(preset_in_hardware_steps);
    "preset-adds-instead-of-assigns" "The preset value is added to the position instead of assigned."
        => |d| d.measuring.absolute(|preset| PresetBasis { mode: PresetMode::Relative, ..*preset }.new_offset());
};

/// The deviations of presets by G1_STW.
static BY_REQUEST: &[Deviation] = bugs! {
    // Preset
    "relative-preset-assigns" "A relative preset sets the position instead of shifting it."
        => |d| d.measuring.relative(absolute);
    "second-relative-preset-ignored" "Only the first relative preset has an effect."
        => |d| d.measuring.relative(|preset| preset.value % preset.range);
    "relative-shift-reversed" "A relative preset shifts the position down by its value."
        => |d| d.measuring.relative(relative_shift_reversed);
    "preset-uses-stored-value" "A preset uses the stored value of P65000 instead of the current one."
        => |d| d.encoder.preset_units(preset_uses_stored_value);
    "preset-on-falling-edge" "The preset is carried out when the request is withdrawn."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::BeginsPreset { before, now, parked } => before.home && !now.home && !parked,
            _ => right,
        });
    "preset-repeats-while-requested" "The preset is repeated while the request is set."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::BeginsPreset { now, parked, .. } => now.home && !parked,
            _ => right,
        });
    "mode-change-repeats-preset" "A change of bit 11 during a request makes another preset."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::BeginsPreset { before, now, parked } => now.home && (!before.home || before.relative != now.relative) && !parked,
            _ => right,
        });
    "preset-never-acknowledged" "Bit 12 of G1_ZSW is never set."
        => |d| d.encoder.signals(|_, now| SignalImage { g1_zsw: now.g1_zsw & !EXECUTED, ..now });
    "preset-acknowledgement-is-a-pulse" "Bit 12 of G1_ZSW is set for one frame only."
        => |d| d.encoder.signals(|before, now| SignalImage { g1_zsw: now.g1_zsw & !(before.unhooked.g1_zsw & EXECUTED), ..now });
    "preset-acknowledge-stays" "The acknowledgement of a preset is never cleared."
        => |d| d.encoder.image(preset_acknowledge_stays);
    "preset-mode-alone-shifts" "Bit 11 of G1_STW alone makes a relative preset."
        => |d| d.encoder.control_words(|_, [a, b]| [a, b | (b & 0x0800) << 1]);
    "writing-preset-value-presets" "Writing P65000 sets the position at once."
        => |d| d.encoder.add(PresetsAtWrite::default());
    "preset-on-both-edges" "The preset is repeated when the request is withdrawn."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::BeginsPreset { before, now, parked } => before.home != now.home && !parked,
            _ => right,
        });
    "relative-preset-not-acknowledged" "A relative preset is carried out without bit 12 of G1_ZSW."
        => |d| d.encoder.signals(|_, now| SignalImage { g1_zsw: now.g1_zsw & if now.request.relative { !EXECUTED } else { !0 }, ..now });
    "preset-jump-is-error" "The jump of a preset raises an encoder error."
        => |d| {
            let raised = RaisedByPresets::default();
            d.checks.add(raised.clone());
            d.encoder.add(raised);
        };
    "preset-flashes-error" "Bit 15 of G1_ZSW is set for one frame when a preset is carried out."
        => |d| d.encoder.signals(preset_flashes_error);
    "preset-interrupts-transfer" "The transfer of the position is interrupted for one frame when a preset is carried out."
        => |d| d.encoder.signals(preset_interrupts_transfer);
    "preset-control-inverted" "G1_XIST1 preset control has the inverse polarity: 1 is enabled."
        => |d| d.encoder.user_parameters(|_, user| UserParameterData { preset_acts_on_xist1: !user.preset_acts_on_xist1, ..user });
    "preset-control-gates-all-positions" "G1_XIST1 preset control also acts on G1_XIST2 and G1_XIST3."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::PresetActsOn(_, user) => user.preset_acts_on_xist1,
            _ => right,
        });
    "preset-without-class-4" "A preset is carried out although class 4 is off."
        => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::PresetsAct(_)));
    "position-not-reduced" "The sum of position and offset is not reduced to the measuring range."
        => |d| {
            d.measuring.absolute(absolute_beyond_the_range);
            d.measuring.relative(relative_beyond_the_range);
            d.measuring.shift(|position, offset, _| position.wrapping_add(offset));
            d.checks.check(|check, right| right || matches!(check, EncoderCheck::PresetValue { .. }));
            d.encoder.preset_units(|view, mode, _| match mode {
                PresetMode::Absolute => view.preset_value.into(),
                PresetMode::Relative => i64::from(view.preset_value as i32) as u64,
            });
        };
    "offset-only-at-standstill" "The offset is lost as soon as the shaft moves."
        => |d| d.measuring.slip(|step| if step.movement() == 0 { step.slip } else { -(step.offset as i64) });
    "highest-position-wraps" "A preset to the highest position sets the position to 0."
        => |d| d.measuring.absolute(highest_position_wraps);
    "old-offset-added-again" "After a change of code sequence or scaling the previous offset is added twice."
        => |d| {
            let slip = d.measuring.slip(old_offset_added_again);
            d.measuring.absolute(move |preset| before_the_slip(preset, slip.get()));
        };
    "preset-acknowledged-not-done" "A preset requested during an error is acknowledged but not carried out."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::CarriesOutPreset { has_error: true, .. } => false,
            _ => right,
        });
    "parking-clears-offset" "The offset is 0 after parking."
        => |d| d.encoder.working_preset(after_parking(|_, _| 0));
    "offset-sign-reversed" "P65001 shows the offset with the opposite sign."
        => |d| d.encoder.element(|view, at, right| if at == (65001, 8) { (view.measuring.range() - right) % view.measuring.range() } else { right });
};

/// The deviations of encoders that also have presets by trigger.
static BY_TRIGGER: &[Deviation] = bugs! {
    // By G1_STW and by trigger
    "preset-takes-100-ms" "A preset takes 100 ms."
        => |d| d.encoder.offset_takes(|_| Duration::from_millis(100));
    "position-runs-during-preset" "Positions follow the shaft during a preset, which takes at least 40 ms."
        => |d| {
            d.checks.set(EncoderCheck::PositionIsFrozen, false);
            d.encoder.offset_takes(|takes| takes.max(Duration::from_millis(40)));
        };
    "preset-control-ignored" "A preset acts on G1_XIST1 even if preset control is off."
        => |d| d.encoder.user_parameters(|_, user| UserParameterData { preset_acts_on_xist1: true, ..user });
    "negative-shift-unsigned" "A negative relative preset value is treated as unsigned and limited to the highest position."
        => |d| d.encoder.preset_units(|view, _, _| u64::from(view.preset_value).min(view.positions - 1));
    "highest-position-refused" "The highest position of the range is refused as a preset value."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::PresetValue { value, range } => u64::from((value as i32).unsigned_abs()) + 1 < range,
            _ => right,
        });
    "start-preset-ignored" "The preset value of the start is acknowledged but not used."
        => |d| d.encoder.written(|view, (number, _), values| values.filter(|_| number != 65000 || !view.is_starting));
    "first-preset-value-stays" "After the first preset value in data exchange further values are acknowledged but not used."
        => |d| d.encoder.written(|view, (number, _), values| {
            values.filter(|_| number != 65000 || view.is_starting || view.preset_value == 0)
        });

    "offset-written-while-requested" "While a preset is requested, the offset is written to memory in each cycle."
        => |d| d.encoder.add(WrittenWhileRequested::default());
    "preset-value-not-limited" "A preset value beyond the range is not limited."
        => |d| {
            d.measuring.absolute(absolute_beyond_the_range);
            d.measuring.relative(relative_beyond_the_range);
            d.measuring.shift(|position, offset, range| if offset < range {
                measuring::shift(position, offset, range)
            } else {
                position.wrapping_add(offset)
            });
            d.checks.check(|check, right| right || matches!(check, EncoderCheck::PresetValue { .. }));
            d.encoder.preset_units(|view, mode, _| match mode {
                PresetMode::Absolute => view.preset_value.into(),
                PresetMode::Relative => i64::from(view.preset_value as i32) as u64,
            });
        };
    "preset-mode-inverted" "Bit 11 of G1_STW has the inverse meaning."
        => |d| d.encoder.control_words(|_, [a, b]| [a, b ^ 0x0800]);
    "request-for-position-presets" "Bit 13 of G1_STW makes a preset, like bit 12."
        => |d| d.encoder.control_words(|_, [a, b]| [a, b | (b & POSITION) >> 1]);
    "read-gives-the-offset" "P65000 reads the offset."
        => |d| d.encoder.element(|view, at, right| if at == (65000, 0) { view.measuring.offset % view.measuring.range() } else { right });
    "position-for-offset" "P65001 shows the position instead of the offset."
        => |d| d.encoder.element(|view, at, right| if at == (65001, 8) { view.measuring.shifted() } else { right });
    "preset-value-random" "P65000 is 5A5A5A5Ah until it is written."
        => |d| d.encoder.load(|_, retained| RetainedEncoderData { preset_value: 0x5A5A_5A5A, ..retained });
    "preset-value-used-up" "The first preset sets P65000 to 0."
        => |d| preset_value_used_up(d);
    "start-preset-taken-once" "The preset value of the start is used only in the first connection after power-up."
        => |d| d.encoder.written(|view, (number, _), values| {
            values.filter(|_| number != 65000 || !view.is_starting || view.preset_value == 0)
        });
    "value-little-endian" "The value written to P65000 is read least significant byte first."
        => |d| {
            d.encoder.value(65000, |value| (value as u32).swap_bytes().into());
            // The range is checked before.
            d.checks.check(|check, right| match check {
                EncoderCheck::PresetValue { value, range } => u64::from((value.swap_bytes() as i32).unsigned_abs()) < range,
                _ => right,
            });
        };
    "reset-erases-offset" "The factory reset also erases the offset."
        => |d| d.encoder.reset(|_, _, left| RetainedEncoderData { offset: 0, ..left });

    // By trigger
    "trigger-ignored" "The trigger has no effect."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::TriggersPreset { .. } => false,
            _ => right,
        });
    "preset-trigger-in-last-byte" "The trigger is read from bit 7 of the last byte."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::TriggersPreset { before, now } => before.unwrap_or(0) & 0x80 == 0 && now & 0x80 != 0,
            _ => right,
        });
    "trigger-counts-as-value" "The trigger bit is part of the value, which is then limited."
        => |d| d.trigger.value(|word, range, _| u64::from(word).min(range - 1));
    "preset-at-each-connection" "The first good outputs of a connection make a preset."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::TriggersPreset { before, .. } => right || before.is_none(),
            _ => right,
        });
    "outputs-kept-without-power" "A request that is held across a power cycle is not treated as a new one."
        => |d| d.encoder.add(HeldRequests::over_power());
    "trigger-takes-value-before" "A preset uses the value of the frame before the trigger edge."
        => |d| d.encoder.outputs(trigger_takes_value_before);
    "trigger-is-a-level" "While the trigger is set, the position is set to its value in each frame."
        => |d| {
            d.checks.check(|check, right| match check {
                EncoderCheck::TriggersPreset { now, .. } => now & TRIGGER != 0,
                _ => right,
            });
            d.encoder.offset_takes(|_| Duration::ZERO);
        };
    "trigger-on-both-edges" "The preset is repeated when the trigger is cleared."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::TriggersPreset { before: Some(before), now } => (before ^ now) & TRIGGER != 0,
            _ => right,
        });
    "new-value-triggers" "A new value makes another preset while the trigger is set."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::TriggersPreset { before: Some(before), now } => now & TRIGGER != 0 && before != now,
            _ => right,
        });
    "trigger-works-once" "Only the first trigger in a connection makes a preset."
        => |d| d.checks.check(trigger_works_once());
    "trigger-at-start-blocks" "A trigger that is set in the first outputs blocks every later one of the connection."
        => |d| d.checks.check(trigger_at_start_blocks());
    "value-without-trigger" "A new value sets the position without the trigger."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::TriggersPreset { before: Some(before), now } => right || now & TRIGGER == 0 && (before ^ now) & !TRIGGER != 0,
            _ => right,
        });
    "trigger-limit-one-short" "The preset value is limited to the range minus 2."
        => |d| d.trigger.value(|_, range, right| right.min(range.saturating_sub(2)));
    "trigger-value-wraps" "A preset value beyond the range is reduced modulo the range instead of limited."
        => |d| d.trigger.value(|word, range, _| u64::from(word & VALUE) % range);
    "preset-of-27-bits" "Bit 27 of the value is dropped."
        => |d| d.encoder.preset_word(|word, _| word & !(1 << 27));
    "reserved-preset-bits-double" "The value is doubled if any of the bits 28 to 30 is set."
        => |d| d.encoder.preset_word(|word, _| match word & !VALUE & !TRIGGER {
            0 => word,
            _ => word & !VALUE | word << 1 & VALUE,
        });
    "trigger-uses-parameter" "A preset by trigger uses P65000 instead of its own value."
        => |d| d.encoder.outputs(|view, _, arrived| OutputValues {
            preset: arrived.preset.map(|word| word & !VALUE | view.preset_value & VALUE),
            ..arrived
        });
    "trigger-obeys-mode" "A preset by trigger is relative while bit 11 of G1_STW is set."
        => |d| d.encoder.outputs(trigger_obeys_mode);
    "request-takes-cyclic-value" "A preset by G1_STW uses the cyclic preset value instead of P65000."
        => |d| d.encoder.preset_units(|view, mode, right| match view.outputs.preset {
            Some(word) => view.facts.preset_values.units(mode, word & VALUE, view.positions),
            None => right,
        });
    "trigger-blocks-request" "After a preset by trigger, presets by G1_STW are ignored until the next connection."
        => |d| trigger_blocks_request(d);
    "simultaneous-presets-add" "Two simultaneous presets add both values."
        => |d| d.measuring.preset(simultaneous_presets_add());
};

/// Returns the offset of an absolute preset without limiting a value beyond the range.
pub fn absolute_beyond_the_range(preset: &PresetBasis) -> u64 {
    if preset.value < preset.range { preset.new_offset() } else { preset.value.wrapping_sub(preset.position) }
}

fn relative_beyond_the_range(preset: &PresetBasis) -> u64 {
    let PresetBasis { value, offset, range, .. } = *preset;
    let reduced = (value as i64).rem_euclid(range as i64) as u64;
    if (value as i64).unsigned_abs() < range {
        PresetBasis { value: reduced, ..*preset }.new_offset()
    } else {
        offset.wrapping_add(value)
    }
}

fn absolute(preset: &PresetBasis) -> u64 {
    PresetBasis { mode: PresetMode::Absolute, ..*preset }.new_offset()
}

fn preset_in_hardware_steps(preset: &PresetBasis, _: u64) -> u64 {
    let PresetBasis { value, scaling, hardware, .. } = *preset;
    let value = value * scaling.units_per_revolution / hardware.steps_per_revolution;
    PresetBasis { value, ..*preset }.new_offset()
}

fn highest_position_wraps(preset: &PresetBasis) -> u64 {
    let value = if preset.value == preset.range - 1 { 0 } else { preset.value };
    PresetBasis { value, ..*preset }.new_offset()
}

/// Changes the offset in the cycle in which parking ends, given the position in the cycle before parking began.
pub fn after_parking(
    mut offset: impl FnMut(&EncoderView<'_>, u64) -> u64,
) -> impl FnMut(&EncoderView<'_>, WorkingPreset) -> WorkingPreset {
    let (mut parked_in, mut position) = (None, 0);
    move |view, held| {
        let is_parked = view.sensor.is_parked();
        // Parking can also end with the connection or at power-off.
        let ends = !is_parked && parked_in.is_some() && parked_in == view.data_since;
        parked_in = view.data_since.filter(|_| is_parked);
        let offset = if ends { offset(view, position) } else { held.offset };
        if !is_parked {
            position = view.measuring.shifted();
        }
        WorkingPreset { offset, ..held }
    }
}

fn old_offset_added_again(step: &ShaftStep) -> i64 {
    match step.before {
        Some((_, settings)) if settings != step.settings => step.offset as i64,
        _ => step.slip,
    }
}

fn before_the_slip(preset: &PresetBasis, slip: i64) -> u64 {
    let position = (preset.position as i64 - slip).rem_euclid(preset.range as i64) as u64;
    PresetBasis { position, ..*preset }.new_offset()
}

/// Bits 27 to 0 of the word with the trigger: the value.
const VALUE: u32 = (1 << 28) - 1;

/// Uses the value of the previous frame at the edge of the trigger.
fn trigger_takes_value_before(view: &EncoderView<'_>, _: &Telegram, arrived: OutputValues) -> OutputValues {
    let before = view.previous.unhooked.trigger;
    let rises = |word: u32| word & !before & TRIGGER != 0;
    OutputValues { preset: arrived.preset.map(|word| if rises(word) { TRIGGER | before } else { word }), ..arrived }
}

fn trigger_works_once() -> impl FnMut(EncoderCheck, bool) -> bool {
    let mut was_used = false;
    move |check, right| match check {
        EncoderCheck::TriggersPreset { before, .. } => {
            was_used &= before.is_some();
            let begins = right && !was_used;
            was_used |= begins;
            begins
        }
        _ => right,
    }
}

fn trigger_at_start_blocks() -> impl FnMut(EncoderCheck, bool) -> bool {
    let mut is_blocked = false;
    move |check, right| match check {
        EncoderCheck::TriggersPreset { before, now } => {
            if before.is_none() {
                is_blocked = now & TRIGGER != 0;
            }
            right && !is_blocked
        }
        _ => right,
    }
}

/// Adds the trigger value to the position while bit 11 of G1_STW is set.
fn trigger_obeys_mode(view: &EncoderView<'_>, _: &Telegram, arrived: OutputValues) -> OutputValues {
    let before = &view.previous.unhooked;
    let is_relative = before.outputs[1] & 0x0800 != 0;
    let shifted = |word: u32| (before.position + u64::from(word & VALUE)) % view.positions.max(1);
    let preset = arrived.preset.map(|word| if is_relative { word & !VALUE | shifted(word) as u32 } else { word });
    OutputValues { preset, ..arrived }
}

fn preset_acknowledged_too_early(view: &EncoderView<'_>, before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if view.next_offset.is_some() && (now.request.home || is_executed(&before.sent)) {
        SignalImage { g1_zsw: now.g1_zsw | EXECUTED, ..now }
    } else {
        now
    }
}

fn preset_acknowledge_stays(view: &EncoderView<'_>, before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if is_executed(&before.sent) && view.next_offset.is_none() && !is_parked(&now) {
        SignalImage { g1_zsw: now.g1_zsw | EXECUTED, ..now }
    } else {
        now
    }
}

fn is_carried_out(before: &PreviousCycle, now: &SignalImage) -> bool {
    now.g1_zsw & !before.unhooked.g1_zsw & EXECUTED != 0
}

fn preset_flashes_error(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if is_carried_out(before, &now) { SignalImage { g1_zsw: now.g1_zsw & !POSITION | ERROR, ..now } } else { now }
}

fn preset_interrupts_transfer(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if is_carried_out(before, &now) { without_transfer(now) } else { now }
}

fn relative_shift_reversed(preset: &PresetBasis) -> u64 {
    measuring::shift(preset.offset, preset.range - preset.value % preset.range, preset.range)
}

fn preset_uses_stored_value(view: &EncoderView<'_>, mode: PresetMode, _: u64) -> u64 {
    view.facts.preset_values.units(mode, *view.store.preset_value.stored(), view.positions)
}

#[derive(Default)]
struct WrittenWhileRequested {
    writes: u64,
}

impl EncoderHooks for WrittenWhileRequested {
    fn working_preset(&mut self, view: &EncoderView<'_>, held: WorkingPreset) -> WorkingPreset {
        self.writes += u64::from(view.sensor.request().home);
        held
    }

    fn counter(&mut self, name: &str, count: u64) -> u64 {
        if name == "nvm_writes" { count + self.writes } else { count }
    }
}

fn preset_value_used_up(d: &mut Deviations) {
    let is_used = Rc::new(Cell::new(false));
    let (uses, used) = (is_used.clone(), is_used.clone());
    d.measuring.preset(move |_, right| {
        uses.set(true);
        right
    });
    d.encoder.preset_units(move |_, _, value| if used.get() { 0 } else { value });
    d.encoder
        .working_preset(move |_, held| if is_used.take() { WorkingPreset { preset_value: 0, ..held } } else { held });
}

fn trigger_blocks_request(d: &mut Deviations) {
    let is_blocked = Rc::new(Cell::new(false));
    let blocked = is_blocked.clone();
    let mut since = None;
    d.encoder.outputs(move |view, _, arrived| {
        if since != view.data_since {
            blocked.set(false);
        }
        since = view.data_since;
        arrived
    });
    d.checks.check(move |check, right| match check {
        EncoderCheck::CarriesOutPreset { by_request: true, .. } => right && !is_blocked.get(),
        EncoderCheck::CarriesOutPreset { by_request: false, .. } => {
            is_blocked.set(right || is_blocked.get());
            right
        }
        _ => right,
    });
}

/// Adds the values of two presets if the second begins before the first one is in force.
fn simultaneous_presets_add() -> impl FnMut(&PresetBasis, u64) -> u64 {
    let mut last = None;
    move |preset, right| {
        let given = match last {
            Some((before, given)) if before == preset.offset && given != before => given + right + preset.position,
            _ => right,
        };
        last = Some((preset.offset, given));
        given
    }
}
