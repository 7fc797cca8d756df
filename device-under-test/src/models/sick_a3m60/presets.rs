//! Presets: where one comes from, and what is kept of it. A healthy encoder leaves all of them to the encoder object.

use super::is_of_vendor;
use super::knobs::{AskedPreset, Origin};
use super::own::State;
use crate::encoder::PresetMode;
use crate::encoder_object::Live;
use crate::profidrive::mantel::TRIGGER;
use alloc::collections::VecDeque;
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

impl Live<'_, State> {
    /// Whether the encoder object carries out this preset; what is done otherwise is done here.
    pub fn begin_preset(&mut self, mode: PresetMode, value: u64) -> bool {
        let origin = match (self.model.presets.is_pressed, is_of_vendor(self.ram.telegram())) {
            (true, _) => Origin::Button,
            (false, true) => Origin::Word,
            (false, false) => Origin::Request,
        };
        let rules = &self.behaviour.a3m60;
        let is_transferred = self.ram.sensor.request().absolute;
        let asked = AskedPreset { origin, count: self.model.presets.requests, is_transferred };
        self.model.presets.requests += u32::from(origin == Origin::Request);
        if !(rules.presets)(&asked) {
            self.ram.sensor.preset_done(origin == Origin::Request);
            return false;
        }
        self.model.presets.since = self.now;
        if mode == PresetMode::Absolute {
            self.model.presets.last_value = value % self.positions().max(1);
        }
        self.model.presets.offset_before = self.ram.measuring.offset;
        let stored = *self.store.offset.stored();
        self.model.presets.kept_offset = (!(rules.keeps_offset)(origin)).then_some(stored);
        if let Some(waits) = rules.queues_presets {
            let after = self.model.presets.queue.back().map_or(self.now, |(due, ..)| *due);
            self.model.presets.queue.push_back((after + waits, mode, value));
            self.ram.sensor.preset_done(origin == Origin::Request);
            return false;
        }
        if let Some(before) = rules.presets_from_before {
            let mut measuring = self.ram.measuring.clone();
            measuring.sample(self.hardware.sense(self.shaft.place(self.now - before)));
            self.ram.measuring.offset = measuring.preset(mode, value);
            self.store.offset.replace(self.ram.measuring.offset);
            self.ram.sensor.preset_done(origin == Origin::Request);
            return false;
        }
        true
    }

    /// Carries out the presets that have waited for long enough.
    pub fn carry_out_queue(&mut self) {
        while self.model.presets.queue.front().is_some_and(|(due, ..)| *due <= self.now) {
            let Some((_, mode, value)) = self.model.presets.queue.pop_front() else { return };
            let offset = self.ram.measuring.preset(mode, value);
            self.ram.measuring.offset = offset;
            self.store.offset.replace(offset);
        }
    }

    /// Looks whether bit 31 has fallen.
    pub fn look_for_falling_edge(&mut self) {
        let word = self.ram.outputs.preset.unwrap_or(0);
        let before = core::mem::replace(&mut self.model.presets.word, word);
        if self.behaviour.a3m60.undoes_presets && before & TRIGGER != 0 && word & TRIGGER == 0 {
            self.ram.measuring.offset = self.model.presets.offset_before;
        }
    }
}
