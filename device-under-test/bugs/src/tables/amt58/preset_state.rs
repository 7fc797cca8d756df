//! Deviations of presets that have state.

use super::values::{position, set_position};
use crate::seams::slave::request;
use alloc::rc::Rc;
use alloc::vec;
use alloc::vec::Vec;
use core::cell::Cell;
use core::mem;
use device_stack::profibus::{SlaveApplication, SlaveHooks};
use reference_devices::models::datalogic_amt58::hooks::{Amt58Check, Amt58Hooks, Amt58View, NewOffset};
use reference_devices::models::datalogic_amt58::preset::{CYCLES, TRIGGER, VALUE};
use reference_devices::models::datalogic_amt58::set_prm::{EncoderParameters, RESERVED, RESOLUTION, number};
use wire::profibus::cfg::IoLengths;
use wire::profibus::global_control::{GlobalCommand, GlobalControl};
use wire::profibus::sap::{SapService, SlaveSap};

/// Counts cycles with bit 31, which need not be consecutive.
#[derive(Default)]
pub(super) struct TotalTriggerCycles {
    count: u32,
}

impl Amt58Hooks for TotalTriggerCycles {
    fn check(&mut self, _: &Amt58View<'_>, check: Amt58Check<'_>, verdict: bool) -> bool {
        let Amt58Check::PresetCycles(cycles) = check else { return verdict };
        match (cycles > 0, self.count) {
            (true, count) => self.count = count.saturating_add(1),
            (false, CYCLES..) => self.count = 0,
            (false, _) => {}
        }
        cycles > 0 && self.count == CYCLES
    }

    fn load(&mut self, _: &Amt58View<'_>, offset: i64) -> i64 {
        self.count = 0;
        offset
    }
}

/// Restores the offset from before the preset when bit 31 is cleared.
#[derive(Default)]
pub(super) struct UndoneWithTrigger {
    cycles: u32,
    before: i64,
    is_undoing: bool,
}

impl Amt58Hooks for UndoneWithTrigger {
    fn check(&mut self, _: &Amt58View<'_>, check: Amt58Check<'_>, verdict: bool) -> bool {
        match check {
            Amt58Check::PresetCycles(cycles) => {
                self.is_undoing = cycles == 0 && self.cycles >= CYCLES;
                self.cycles = cycles;
                verdict || self.is_undoing
            }
            Amt58Check::PresetValue(_) => verdict || self.is_undoing,
            _ => verdict,
        }
    }

    fn offset(&mut self, view: &Amt58View<'_>, cause: NewOffset, offset: i64) -> i64 {
        match (cause, self.is_undoing) {
            (NewOffset::Preset, true) => self.before,
            (NewOffset::Preset, false) => {
                self.before = view.offset;
                offset
            }
            (NewOffset::SetPrm, _) => offset,
        }
    }
}

/// Makes a preset with each new value, without bit 31.
#[derive(Default)]
pub(super) struct WithoutTrigger {
    before: u32,
    is_other: bool,
}

impl Amt58Hooks for WithoutTrigger {
    fn check(&mut self, _: &Amt58View<'_>, check: Amt58Check<'_>, verdict: bool) -> bool {
        verdict || self.is_other && matches!(check, Amt58Check::PresetCycles(_))
    }

    fn outputs(&mut self, _: &Amt58View<'_>, outputs: u32) -> u32 {
        let before = mem::replace(&mut self.before, outputs);
        self.is_other = outputs & TRIGGER == 0 && (outputs ^ before) & VALUE != 0;
        outputs
    }

    fn load(&mut self, _: &Amt58View<'_>, offset: i64) -> i64 {
        self.before = 0;
        offset
    }
}

/// Counts cycles from the telegrams on the bus, including refused ones; a pending preset is made in the next exchange.
#[derive(Clone, Default)]
pub(super) struct EarlyOutputs {
    count: Rc<Cell<u32>>,
    due: Rc<Cell<Option<u32>>>,
}

impl SlaveHooks for EarlyOutputs {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        if let Some((frame, SapService::DataExchange)) = request(telegram)
            && let Ok(octets) = frame.data.try_into()
        {
            let outputs = u32::from_be_bytes(octets);
            self.count.set(if outputs & TRIGGER == 0 { 0 } else { self.count.get().saturating_add(1) });
            if self.count.get() == CYCLES {
                self.due.set(Some(outputs));
            }
        }
        vec![telegram.to_vec()]
    }

    fn starts(&mut self) {
        self.count.set(0);
        self.due.set(None);
    }
}

impl Amt58Hooks for EarlyOutputs {
    fn check(&mut self, _: &Amt58View<'_>, check: Amt58Check<'_>, verdict: bool) -> bool {
        match check {
            Amt58Check::PresetCycles(_) => self.due.take().is_some(),
            _ => verdict,
        }
    }

    fn outputs(&mut self, _: &Amt58View<'_>, outputs: u32) -> u32 {
        if outputs & TRIGGER == 0 && self.due.get().is_none() {
            self.count.set(0);
        }
        self.due.get().unwrap_or(outputs)
    }
}

/// Retains the outputs when the data exchange ends, except during Clear, and repeats their preset when the next one begins.
#[derive(Clone, Default)]
pub(super) struct RepeatedOutputs {
    /// The outputs of the last cycle as the encoder received them.
    last: Rc<Cell<u32>>,
    /// The outputs whose preset is pending.
    due: Rc<Cell<Option<u32>>>,
    sent: Option<Vec<u8>>,
    is_clear: bool,
}

impl SlaveHooks for RepeatedOutputs {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        if let Some((frame, SapService::Slave(SlaveSap::GLOBAL_CONTROL))) = request(telegram)
            && let Ok(control) = GlobalControl::parse(frame.data)
        {
            self.is_clear = control.command.has(GlobalCommand::CLEAR_DATA);
        }
        vec![telegram.to_vec()]
    }

    fn configuration(&mut self, _: &dyn SlaveApplication, _: &[u8], right: Option<IoLengths>) -> Option<IoLengths> {
        let has_bit = self.last.get() & TRIGGER != 0;
        self.due.set(right.and(has_bit.then(|| self.last.get())));
        right
    }

    fn outputs(&mut self, outputs: &mut Option<Vec<u8>>) {
        match outputs {
            Some(_) => self.sent.clone_from(outputs),
            None if !self.is_clear => outputs.clone_from(&self.sent),
            None => {}
        }
    }
}

impl Amt58Hooks for RepeatedOutputs {
    fn check(&mut self, _: &Amt58View<'_>, check: Amt58Check<'_>, verdict: bool) -> bool {
        match check {
            Amt58Check::PresetCycles(_) => verdict || self.due.take().is_some(),
            _ => verdict,
        }
    }

    fn outputs(&mut self, _: &Amt58View<'_>, outputs: u32) -> u32 {
        self.last.set(outputs);
        self.due.get().unwrap_or(outputs)
    }

    fn load(&mut self, _: &Amt58View<'_>, offset: i64) -> i64 {
        self.last.set(0);
        self.due.set(None);
        offset
    }
}

/// Makes a preset to 0 when the last byte of Set_Prm is FFh.
#[derive(Default)]
pub(super) struct SetByParameters {
    is_due: bool,
    /// The offset of that preset, until the next preset.
    stored: Option<i64>,
}

impl Amt58Hooks for SetByParameters {
    fn parameters(&mut self, _: &Amt58View<'_>, user: &[u8], parameters: EncoderParameters) -> EncoderParameters {
        self.is_due = user.get(RESERVED) == Some(&0xFF);
        parameters
    }

    fn offset(&mut self, view: &Amt58View<'_>, cause: NewOffset, offset: i64) -> i64 {
        if cause == NewOffset::SetPrm && self.is_due {
            self.stored = Some(-(view.measuring.position() as i64));
        }
        self.stored.filter(|_| cause == NewOffset::SetPrm).unwrap_or(offset)
    }

    fn store(&mut self, _: &Amt58View<'_>, offset: Option<i64>) -> Option<i64> {
        self.stored = None;
        offset
    }

    fn load(&mut self, _: &Amt58View<'_>, offset: i64) -> i64 {
        self.stored.unwrap_or(offset)
    }
}

/// Compares the preset value with the total resolution of Set_Prm although scaling is off.
#[derive(Default)]
pub(super) struct UnusedRange {
    range: u64,
}

impl Amt58Hooks for UnusedRange {
    fn check(&mut self, view: &Amt58View<'_>, check: Amt58Check<'_>, verdict: bool) -> bool {
        match check {
            Amt58Check::PresetValue(value) => verdict && (view.parameters.scales || value < self.range),
            _ => verdict,
        }
    }

    fn parameters(&mut self, _: &Amt58View<'_>, user: &[u8], parameters: EncoderParameters) -> EncoderParameters {
        self.range = number(user, RESOLUTION).into();
        parameters
    }
}

/// Makes only one preset between power-up and power-down.
#[derive(Default)]
pub(super) struct OnePresetOnly {
    is_made: bool,
}

impl Amt58Hooks for OnePresetOnly {
    fn check(&mut self, _: &Amt58View<'_>, check: Amt58Check<'_>, verdict: bool) -> bool {
        match check {
            Amt58Check::PresetValue(_) => verdict && !mem::replace(&mut self.is_made, true),
            _ => verdict,
        }
    }

    fn load(&mut self, _: &Amt58View<'_>, offset: i64) -> i64 {
        self.is_made = false;
        offset
    }
}

/// Shows positions above the range by the part of the preset value that is beyond it.
#[derive(Default)]
pub(super) struct BeyondTheRange {
    requested: u32,
    excess: u32,
}

impl Amt58Hooks for BeyondTheRange {
    fn outputs(&mut self, view: &Amt58View<'_>, outputs: u32) -> u32 {
        let range = view.measuring.range().max(1);
        let value = u64::from(outputs & VALUE);
        self.requested = (value - value % range) as u32;
        outputs & TRIGGER | (value % range) as u32
    }

    fn offset(&mut self, _: &Amt58View<'_>, cause: NewOffset, offset: i64) -> i64 {
        if cause == NewOffset::Preset {
            self.excess = self.requested;
        }
        offset
    }

    fn inputs(&mut self, _: &Amt58View<'_>, inputs: &mut [u8]) {
        set_position(inputs, position(inputs).wrapping_add(self.excess));
    }

    fn load(&mut self, _: &Amt58View<'_>, offset: i64) -> i64 {
        *self = BeyondTheRange::default();
        offset
    }
}
