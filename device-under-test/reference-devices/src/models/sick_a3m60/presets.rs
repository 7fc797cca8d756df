//! Presets: where one comes from, and what is kept of it. A healthy encoder leaves all of them to the encoder object.

use super::is_of_vendor;
use super::knobs::{AskedPreset, Origin};
use super::own::State;
use alloc::collections::VecDeque;
use encoder_profile::encoder::PresetMode;
use encoder_profile::encoder_object::Live;
use encoder_profile::profidrive::preset_trigger::TRIGGER;
use station::Time;

/// What is kept of presets.
#[derive(Clone, Debug, Default)]
pub struct Presets {
    /// Whether the one that begins is asked for by the button.
    pub is_pressed: bool,
    /// The value of the last absolute one, and when it was.
    pub last_value: u64,
    pub(super) since: Time,
    /// How many were asked for by G1_STW since power-up.
    requests: u32,
    /// The offset to which one falls back that does not outlast the power.
    pub(super) kept_offset: Option<u64>,
    offset_before: u64,
    /// The word with the trigger in the cycle before.
    pub(super) word: u32,
    /// Those that wait, with when they are due.
    queue: VecDeque<(Time, PresetMode, u64)>,
}

impl Presets {
    /// The supply has come.
    pub fn power_up(&mut self, now: Time) {
        *self = Presets { since: now, last_value: self.last_value, ..Presets::default() };
    }
}

/// Whether the encoder object carries out this preset; what is done otherwise is done here.
pub fn begin_preset(live: &mut Live<'_, State>, mode: PresetMode, value: u64) -> bool {
    let origin = match (live.model.presets.is_pressed, is_of_vendor(live.ram.telegram())) {
        (true, _) => Origin::Button,
        (false, true) => Origin::Word,
        (false, false) => Origin::Request,
    };
    let rules = &live.rules.own;
    let is_transferred = live.ram.sensor.request().absolute;
    let asked = AskedPreset { origin, count: live.model.presets.requests, is_transferred };
    live.model.presets.requests += u32::from(origin == Origin::Request);
    if !(rules.presets)(&asked) {
        live.ram.sensor.preset_done(origin == Origin::Request);
        return false;
    }
    live.model.presets.since = live.now;
    if mode == PresetMode::Absolute {
        live.model.presets.last_value = value % live.positions().max(1);
    }
    live.model.presets.offset_before = live.ram.measuring.offset;
    let stored = *live.store.offset.stored();
    live.model.presets.kept_offset = (!(rules.keeps_offset)(origin)).then_some(stored);
    if let Some(waits) = rules.queues_presets {
        let after = live.model.presets.queue.back().map_or(live.now, |(due, ..)| *due);
        live.model.presets.queue.push_back((after + waits, mode, value));
        live.ram.sensor.preset_done(origin == Origin::Request);
        return false;
    }
    if let Some(before) = rules.presets_from_before {
        let mut measuring = live.ram.measuring.clone();
        measuring.sample(live.hardware.sense(live.shaft.place(live.now - before)));
        live.ram.measuring.offset = measuring.preset(mode, value);
        live.store.offset.replace(live.ram.measuring.offset);
        live.ram.sensor.preset_done(origin == Origin::Request);
        return false;
    }
    true
}

/// Carries out the presets that have waited for long enough.
pub fn carry_out_queue(live: &mut Live<'_, State>) {
    while live.model.presets.queue.front().is_some_and(|(due, ..)| *due <= live.now) {
        let Some((_, mode, value)) = live.model.presets.queue.pop_front() else { return };
        let offset = live.ram.measuring.preset(mode, value);
        live.ram.measuring.offset = offset;
        live.store.offset.replace(offset);
    }
}

/// Looks whether bit 31 has fallen.
pub fn look_for_falling_edge(live: &mut Live<'_, State>) {
    let word = live.ram.outputs.preset.unwrap_or(0);
    let before = core::mem::replace(&mut live.model.presets.word, word);
    if live.rules.own.undoes_presets && before & TRIGGER != 0 && word & TRIGGER == 0 {
        live.ram.measuring.offset = live.model.presets.offset_before;
    }
}
