//! Deviations of the preset offset that have state.

use super::diagnosis::patch;
use super::values::set_position;
use alloc::vec::Vec;
use core::mem;
use core::time::Duration;
use device_stack::profibus::DiagnosisBits;
use encoder_profile::encoder::PresetMode;
use reference_devices::models::datalogic_amt58::hooks::{Amt58Check, Amt58Hooks, Amt58View, NewOffset};
use reference_devices::models::datalogic_amt58::set_prm::EncoderParameters;
use station::Time;

fn place(view: &Amt58View<'_>) -> u64 {
    view.hardware.sense(view.shaft.position(view.now))
}

/// Ignores the offset unless the shaft is at the position of the preset.
#[derive(Default)]
pub(super) struct OffsetAtStandstill {
    place: u64,
}

impl Amt58Hooks for OffsetAtStandstill {
    fn offset(&mut self, view: &Amt58View<'_>, cause: NewOffset, offset: i64) -> i64 {
        if cause == NewOffset::Preset {
            self.place = place(view);
        }
        offset
    }

    fn load(&mut self, view: &Amt58View<'_>, offset: i64) -> i64 {
        self.place = place(view);
        offset
    }

    fn inputs(&mut self, view: &Amt58View<'_>, inputs: &mut [u8]) {
        if place(view) != self.place {
            set_position(inputs, view.measuring.position() as u32);
        }
    }
}

/// Computes the offset from the position of the shaft 50 ms ago.
#[derive(Default)]
pub(super) struct OldShaftPosition {
    value: u64,
}

impl Amt58Hooks for OldShaftPosition {
    fn check(&mut self, _: &Amt58View<'_>, check: Amt58Check<'_>, verdict: bool) -> bool {
        if let Amt58Check::PresetValue(value) = check {
            self.value = value;
        }
        verdict
    }

    fn offset(&mut self, view: &Amt58View<'_>, cause: NewOffset, offset: i64) -> i64 {
        if cause != NewOffset::Preset {
            return offset;
        }
        let mut before = view.measuring.clone();
        before.jump(view.hardware.sense(view.shaft.position(view.now - Duration::from_millis(50))));
        let is_back = self.value < before.position();
        let offset = before.preset(PresetMode::Absolute, self.value) as i64;
        if is_back { offset - before.range() as i64 } else { offset }
    }
}

/// Adds the previous offset to that of the first preset after a change of the scaling.
#[derive(Default)]
pub(super) struct OldOffset {
    is_first: bool,
}

impl Amt58Hooks for OldOffset {
    fn parameters(&mut self, view: &Amt58View<'_>, _: &[u8], parameters: EncoderParameters) -> EncoderParameters {
        self.is_first = parameters.scaling != view.parameters.scaling;
        parameters
    }

    fn offset(&mut self, view: &Amt58View<'_>, cause: NewOffset, offset: i64) -> i64 {
        if cause == NewOffset::Preset && mem::take(&mut self.is_first) { offset + view.offset } else { offset }
    }

    fn load(&mut self, _: &Amt58View<'_>, offset: i64) -> i64 {
        self.is_first = false;
        offset
    }
}

/// Has a separate offset for each class.
#[derive(Default)]
pub(super) struct OffsetPerClass {
    class: usize,
    offsets: [i64; 3],
}

impl Amt58Hooks for OffsetPerClass {
    fn offset(&mut self, view: &Amt58View<'_>, cause: NewOffset, offset: i64) -> i64 {
        if cause == NewOffset::Preset {
            return offset;
        }
        self.offsets[self.class] = view.offset;
        self.class = usize::from(view.parameters.is_class_2) + usize::from(view.parameters.has_velocity);
        self.offsets[self.class]
    }

    fn load(&mut self, _: &Amt58View<'_>, offset: i64) -> i64 {
        *self = OffsetPerClass { class: 0, offsets: [offset; 3] };
        offset
    }
}

/// Writes the offset to the memory some time after the preset.
pub struct LateWrites {
    takes: Duration,
    pending: Option<(Time, i64)>,
    written: i64,
}

impl LateWrites {
    /// Writes this time after the preset.
    pub fn after(takes: Duration) -> LateWrites {
        LateWrites { takes, pending: None, written: 0 }
    }

    fn settle(&mut self, now: Time) {
        if let Some((_, offset)) = self.pending.take_if(|(due, _)| *due <= now) {
            self.written = offset;
        }
    }
}

impl Amt58Hooks for LateWrites {
    fn store(&mut self, view: &Amt58View<'_>, offset: Option<i64>) -> Option<i64> {
        self.settle(view.now);
        self.pending = offset.map(|offset| (view.now + self.takes, offset));
        None
    }

    fn power_down(&mut self, view: &Amt58View<'_>) {
        self.settle(view.now);
        self.pending = None;
    }

    fn load(&mut self, view: &Amt58View<'_>, offset: i64) -> i64 {
        if view.is_unreadable { offset } else { self.written }
    }
}

/// Shows an offset of 0 until the first preset after power-up.
#[derive(Default)]
pub(super) struct OffsetShownFromRam {
    is_preset: bool,
}

impl Amt58Hooks for OffsetShownFromRam {
    fn offset(&mut self, _: &Amt58View<'_>, cause: NewOffset, offset: i64) -> i64 {
        self.is_preset |= cause == NewOffset::Preset;
        offset
    }

    fn load(&mut self, _: &Amt58View<'_>, offset: i64) -> i64 {
        self.is_preset = false;
        offset
    }

    fn diagnosis(&mut self, _: &Amt58View<'_>, octets: &mut Vec<u8>, bits: DiagnosisBits) -> DiagnosisBits {
        if !self.is_preset {
            patch(octets, 31, &[0; 4]);
        }
        bits
    }
}

/// Assumes at power-up that the shaft has not moved since power-off.
#[derive(Default)]
pub(super) struct RestoredShaftPosition {
    shift: i64,
    before: i64,
}

impl Amt58Hooks for RestoredShaftPosition {
    fn place(&mut self, place: i64) -> i64 {
        place.saturating_add(self.shift)
    }

    fn power_down(&mut self, view: &Amt58View<'_>) {
        self.before = view.hardware.sense(view.shaft.position(view.now).saturating_add(self.shift)) as i64;
    }

    fn load(&mut self, view: &Amt58View<'_>, offset: i64) -> i64 {
        self.shift = self.before - place(view) as i64;
        offset
    }
}
