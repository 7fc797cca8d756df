//! Bugs of presets by bit 31 of a vendor telegram, and of presets by G1_STW that are in force at once.

use super::Group;
use super::cyclic_state::{KeptTrigger, RestedTrigger};
use super::presets::absolute_beyond_the_range;
use crate::needs::Need;
use crate::seams::Deviations;
use alloc::collections::VecDeque;
use alloc::rc::Rc;
use core::cell::{Cell, RefCell};
use core::mem;
use core::time::Duration;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder::measuring;
use encoder_profile::encoder::{Measuring, PresetMode};
use encoder_profile::encoder_object::PoweredEncoder;
use encoder_profile::hooks::{EncoderHooks, EncoderView};
use encoder_profile::profidrive::preset_trigger::TRIGGER;
use encoder_profile::profidrive::telegram::{OutputValues, OutputWord, SignalImage, Telegram};
use reference_devices::manuals;
use reference_devices::models::sick_a3m60::A3m60State;
use reference_devices::models::sick_a3m60::hooks::{A3m60Event, A3m60Hooks, A3m60Memory};
use slave_bugs::slave_state::ZeroInputsInClear;
use station::Time;

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Of(&manuals::SICK_A3M60)],
    deviations: bugs! {
        // By bit 31
        "preset-with-bit-31" "Bit 31 is part of the preset value."
            => |d| {
                d.trigger.value(|word, _, _| word.into());
                d.measuring.absolute(|preset| preset.value.wrapping_sub(preset.position));
                d.measuring.shift(|position, offset, _| position.wrapping_add(offset));
            };
        "preset-in-io-04-only" "The trigger works only in the telegram of four bytes."
            => |d| d.encoder.preset_word(|word, unused| if unused.is_some() { word & !TRIGGER } else { word });
        "preset-resets-the-time-stamp" "A preset sets the time stamp to 0."
            => |d| d.a3m60.add(StampOfPreset::default());
        "edge-needs-several-cycles" "The trigger has to be 0 for three cycles before it can trigger again."
            => |d| d.checks.add(RestedTrigger::default());
        "highest-preset-is-an-error" "A preset to 7FFFFFFFh is not carried out."
            => |d| d.checks.check(|check, right| match check {
                EncoderCheck::TriggersPreset { now: u32::MAX, .. } => false,
                _ => right,
            });
        "preset-beyond-the-range-taken" "A preset value beyond the range is carried out and not reduced."
            => |d| {
                d.trigger.value(|word, _, _| (word & !TRIGGER).into());
                d.measuring.absolute(absolute_beyond_the_range);
                d.measuring.shift(|position, offset, range| if offset < range {
                    measuring::shift(position, offset, range)
                } else {
                    position.wrapping_add(offset)
                });
            };
        "preset-undone-by-the-falling-edge" "When the trigger is cleared, the offset from before the preset is restored."
            => |d| undone_by_the_falling_edge(d);
        "clear-keeps-the-edge-memory" "Cleared outputs do not clear the trigger."
            => |d| d.encoder.add(KeptTrigger::default());
        "inputs-0-in-clear" "During Clear the inputs are 0."
            => |d| d.slave.add(ZeroInputsInClear::default());

        // By bit 31 and by G1_STW
        "preset-from-old-place" "The offset is computed from the position of the shaft 50 ms before."
            => |d| d.a3m60.add(PresetFromOldPosition::default());
        "presets-queue-up" "Each preset takes 20 ms for the memory, and following presets are queued."
            => |d| delayed(d, Duration::from_millis(20));
        "preset-acknowledged-too-early" "The position is set 100 ms after the acknowledgement."
            => |d| delayed(d, Duration::from_millis(100));

        // By G1_STW
        "absolute-preset-is-relative" "Every preset is relative."
            => |d| d.encoder.control_words(|_, [a, b]| [a, b | 0x0800]);
        "preset-of-xist1-not-shifted" "A preset sets G1_XIST1 to the unshifted value."
            => |d| d.a3m60.add(NotShifted::default());
        "preset-value-of-erased-memory" "A preset value of 0 is treated as an erased memory: 7FFFFFFFh."
            => |d| d.encoder.preset_units(|view, mode, right| match view.preset_value {
                0 => view.facts.preset_values.units(mode, 0x7FFF_FFFF, view.positions),
                _ => right,
            });
        "relative-preset-unsigned" "The value of a relative preset is unsigned and limited to half the range."
            => |d| d.encoder.preset_units(|view, mode, right| match mode {
                PresetMode::Absolute => right,
                PresetMode::Relative => u64::from(view.preset_value).min(view.positions / 2),
            });
        "only-first-preset" "Only two presets by G1_STW are carried out after power-up."
            => |d| d.encoder.add(FirstTwo::default());
        "preset-control-enables-presets" "With class 4 off presets are still made if the preset control is active."
            => |d| d.checks.check(|check, right| match check {
                EncoderCheck::PresetsAct(user) => right || user.preset_acts_on_xist1,
                _ => right,
            });
        "preset-needs-the-absolute-value" "A preset by G1_STW is carried out only while the position is requested."
            => |d| d.encoder.outputs(|_, _, arrived| {
                let words = arrived.words.map(|[a, b]| [a, if b & TRANSFER == 0 { b & !PRESET } else { b }]);
                OutputValues { words, ..arrived }
            });
    },
}];

/// Bit of G1_STW that requests a preset.
const PRESET: u16 = 1 << 12;
/// Bit of G1_STW that requests the position in G1_XIST2.
const TRANSFER: u16 = 1 << 13;

/// Adds `by` to the positions of the signals, modulo the range.
fn displaced(encoder: &PoweredEncoder<'_, A3m60State>, image: SignalImage, by: u64) -> SignalImage {
    let range = encoder.ram.measuring.range().max(1);
    let moved = |position: u32| ((u64::from(position) + by % range) % range) as u32;
    let has_code = image.plain_position & TRIGGER != 0;
    let shows_position = image.g1_zsw & TRANSFER != 0;
    SignalImage {
        position: (image.position + by % range) % range,
        plain_position: if has_code { image.plain_position } else { moved(image.plain_position) },
        g1_xist1: if encoder.ram.user.preset_acts_on_xist1 { moved(image.g1_xist1) } else { image.g1_xist1 },
        g1_xist2: if shows_position { moved(image.g1_xist2) } else { image.g1_xist2 },
        ..image
    }
}

/// A queue of presets that are carried out later than requested, one after the other.
struct DelayedPresets {
    by: Duration,
    /// The previous word with the trigger; `None` before the first word of a data exchange.
    word: Option<u32>,
    /// Due time, mode and value of each preset.
    queue: VecDeque<(Time, PresetMode, u64)>,
}

impl DelayedPresets {
    fn add(&mut self, now: Time, mode: PresetMode, value: u64) {
        let begins = self.queue.back().map_or(now, |(due, ..)| *due);
        self.queue.push_back((begins + self.by, mode, value));
    }
}

/// Delays presets: presets by bit 31 are hidden from the encoder, others are undone and repeated later.
fn delayed(d: &mut Deviations, by: Duration) {
    let waiting = Rc::new(RefCell::new(DelayedPresets { by, word: None, queue: VecDeque::new() }));
    let commands = waiting.clone();
    d.encoder.outputs(move |view, telegram, arrived| {
        if !telegram.outputs.contains(&OutputWord::Preset) {
            return arrived;
        }
        let word = arrived.preset.unwrap_or(0);
        let mut waiting = commands.borrow_mut();
        let before = waiting.word.replace(word);
        if before.is_some_and(|before| before & TRIGGER == 0) && word & TRIGGER != 0 && view.user.class_4 {
            waiting.add(view.now, PresetMode::Absolute, u64::from(word & !TRIGGER) % view.measuring.range().max(1));
        }
        OutputValues { preset: arrived.preset.map(|word| word & !TRIGGER), ..arrived }
    });
    d.a3m60.add(PresetDelayHook { waiting, offset: None, noticed: None });
}

struct PresetDelayHook {
    waiting: Rc<RefCell<DelayedPresets>>,
    /// The offset in force; `None` until it is known.
    offset: Option<u64>,
    /// The offset of a detected preset that has not been undone yet.
    noticed: Option<u64>,
}

impl PresetDelayHook {
    /// Detects a preset, and returns by how much it has raised the position.
    fn notice(&mut self, now: Time, measuring: &Measuring, mode: PresetMode) -> u64 {
        let before = *self.offset.get_or_insert(measuring.offset);
        if before == measuring.offset {
            return 0;
        }
        let range = measuring.range().max(1);
        let by = (measuring.offset % range + range - before % range) % range;
        if self.noticed.replace(measuring.offset) != Some(measuring.offset) {
            let [_, position] = measuring.positions();
            let value = if mode == PresetMode::Absolute { position } else { by };
            self.waiting.borrow_mut().add(now, mode, value);
        }
        by
    }
}

impl A3m60Hooks for PresetDelayHook {
    fn happens(&mut self, event: A3m60Event, memory: &mut A3m60Memory<'_>) {
        match event {
            A3m60Event::PowerUp => {
                (self.offset, self.noticed) = (None, None);
                self.waiting.borrow_mut().queue.clear();
            }
            A3m60Event::Start => self.waiting.borrow_mut().word = None,
            A3m60Event::PowerDown => {}
            A3m60Event::Advance => {
                self.notice(memory.now, memory.measuring, PresetMode::Absolute);
                memory.measuring.offset = self.offset.unwrap_or(memory.measuring.offset);
                self.noticed = None;
                let mut waiting = self.waiting.borrow_mut();
                while waiting.queue.front().is_some_and(|(due, ..)| *due <= memory.now) {
                    let Some((_, mode, value)) = waiting.queue.pop_front() else { break };
                    let offset = memory.measuring.preset(mode, value);
                    memory.measuring.offset = offset;
                    memory.store.offset.replace(offset);
                    self.offset = Some(offset);
                }
            }
        }
    }

    fn image(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, image: SignalImage) -> SignalImage {
        let by = self.notice(encoder.now, &encoder.ram.measuring, image.request.mode());
        displaced(encoder, image, encoder.ram.measuring.range().max(1) - by)
    }
}

/// Computes absolute presets from an old position of the shaft.
#[derive(Default)]
struct PresetFromOldPosition {
    offset: Option<u64>,
    by: u64,
}

impl A3m60Hooks for PresetFromOldPosition {
    fn image(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, image: SignalImage) -> SignalImage {
        let before = self.offset.replace(image.offset).unwrap_or(image.offset);
        if before != image.offset {
            let measuring = &encoder.ram.measuring;
            let range = measuring.range().max(1);
            let mut old = measuring.clone();
            old.sample(encoder.hardware.sense(encoder.shaft.position(encoder.now - Duration::from_millis(50))));
            let moved = measuring.position() + range - old.position() % range;
            self.by = if image.request.home && image.request.relative { 0 } else { moved % range };
        }
        displaced(encoder, image, self.by)
    }
}

/// Undoes a preset when the trigger is cleared.
fn undone_by_the_falling_edge(d: &mut Deviations) {
    let undone: Rc<Cell<Option<u64>>> = Rc::default();
    let falls = undone.clone();
    let (mut word, mut before) = (0, 0);
    d.encoder.outputs(move |view, _, arrived| {
        let last = mem::replace(&mut word, arrived.preset.unwrap_or(0));
        match (last & TRIGGER != 0, word & TRIGGER != 0) {
            (false, true) => before = view.measuring.offset,
            (true, false) => falls.set(Some(before)),
            _ => {}
        }
        arrived
    });
    d.a3m60.happens(move |_, memory| {
        if let Some(offset) = undone.take() {
            memory.measuring.offset = offset;
        }
    });
}

/// The time stamp counts from the last trigger of a preset.
#[derive(Default)]
struct StampOfPreset {
    word: u32,
    since: Option<Time>,
}

impl A3m60Hooks for StampOfPreset {
    fn happens(&mut self, event: A3m60Event, _: &mut A3m60Memory<'_>) {
        match event {
            A3m60Event::PowerUp => self.since = None,
            A3m60Event::Start => self.word = TRIGGER,
            A3m60Event::PowerDown | A3m60Event::Advance => {}
        }
    }

    fn image(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, image: SignalImage) -> SignalImage {
        let before = mem::replace(&mut self.word, image.trigger);
        if before & TRIGGER == 0 && image.trigger & TRIGGER != 0 {
            self.since = Some(encoder.now);
        }
        match self.since {
            Some(since) => SignalImage { time_stamp: encoder.now.since(since).as_secs() as u16, ..image },
            None => image,
        }
    }
}

/// Subtracts from G1_XIST1 what the shift adds to the value of the last absolute preset.
#[derive(Default)]
struct NotShifted {
    offset: Option<u64>,
    value: u64,
}

impl A3m60Hooks for NotShifted {
    fn image(&mut self, _: &PoweredEncoder<'_, A3m60State>, image: SignalImage) -> SignalImage {
        let before = self.offset.replace(image.offset).unwrap_or(image.offset);
        if before != image.offset && !(image.request.home && image.request.relative) {
            self.value = image.position;
        }
        let shifted = image.g1_xist1 << image.shift;
        SignalImage { g1_xist1: shifted.wrapping_sub(self.value as u32), shift: 0, ..image }
    }
}

/// Hides all presets by G1_STW from the encoder except for the first two.
#[derive(Default)]
struct FirstTwo {
    is_requested: bool,
    count: u32,
}

impl EncoderHooks for FirstTwo {
    fn outputs(&mut self, _: &EncoderView<'_>, _: &Telegram, arrived: OutputValues) -> OutputValues {
        let is_requested = arrived.words.is_some_and(|[_, g1_stw]| g1_stw & PRESET != 0);
        let was_requested = mem::replace(&mut self.is_requested, is_requested);
        self.count += u32::from(is_requested && !was_requested);
        match self.count {
            0..=2 => arrived,
            _ => OutputValues { words: arrived.words.map(|[a, b]| [a, b & !PRESET]), ..arrived },
        }
    }
}
