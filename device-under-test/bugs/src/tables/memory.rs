//! Bugs of non-volatile memory.

use super::Group;
use super::start::first_record;
use crate::needs::Need;
use crate::seams::Deviations;
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::Cell;
use device_stack::profinet::StationData;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder::PresetMode;
use encoder_profile::facts::{ClearedData, ErrorFact, FaultEffect};
use encoder_profile::hooks::{EncoderHooks, EncoderView, MemoryWrite, RetainedEncoderData, WorkingPreset};
use encoder_profile::profidrive::sensor::SensorError;
use encoder_profile::profidrive::telegram::{OutputValues, OutputWord, Telegram};

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::EncoderProfile],
        deviations: bugs! {
            "offset-only-in-ram" "The offset is lost at power-off."
                => |d| d.encoder.load(|_, retained| RetainedEncoderData { offset: 0, ..retained });
            "relative-preset-not-stored" "The offset of a relative preset is lost at power-off."
                => |d| relative_preset_not_stored(d);
            "memory-error-swallowed" "A preset whose offset could not be stored is acknowledged."
                => |d| d.checks.set(EncoderCheck::PresetIsCarriedOut, true);
            "offset-used-up" "A stored offset is restored at one power-up only."
                => |d| d.encoder.add(OffsetUsedUp::default());
            "offset-from-preset-value" "At power-up the offset is computed from the stored P65000."
                => |d| d.encoder.add(OffsetFromPresetValue::default());
            "position-restored-from-memory" "After power-up the position is the one before power-off, wherever the shaft is."
                => |d| d.encoder.add(PositionRestored::default());
            "scaling-remembered" "The first record 0xBF00 stays in force permanently, even after a power cycle."
                => |d| d.encoder.user_parameters(first_record(Default::default()));
            "memory-fault-ignored-at-power-up" "A memory that cannot be read at power-up is treated as an empty one."
                => |d| d.encoder.add(FaultIgnoredAtPowerUp::default());
            "empty-memory-is-a-fault" "A memory in which nothing was ever stored is a fault."
                => |d| d.encoder.causes(empty_memory_is_a_fault);
        },
    },
    Group {
        needs: &[Need::Profinet, Need::EncoderProfile],
        deviations: bugs! {
            "preset-acknowledged-before-stored" "The preset is acknowledged while the offset is still being written."
                => |d| d.checks.set(EncoderCheck::PresetTakesEffect, true);
            "every-write-is-stored" "P65000 is stored at each write, without P971."
                => |d| d.encoder.add(EveryWriteIsStored::default());
            "name-lost-at-power-off" "The station name is lost at power-off."
                => |d| d.encoder.add(StationLost::new(|station| StationData { name: [].into(), ..station }));
            "address-lost-at-power-off" "The IP address is lost at power-off."
                => |d| d.encoder.add(StationLost::new(|station| StationData { name: station.name, ..StationData::default() }));
        },
    },
    Group {
        needs: &[Need::Output(OutputWord::Stw2Enc)],
        deviations: bugs! {
            "parking-survives-power-off" "An encoder that was parked at power-off is parked after power-up."
                => |d| d.encoder.add(ParkingSurvives::default());
        },
    },
    Group {
        needs: &[Need::Parameter(971)],
        deviations: bugs! {
            "p971-takes-any-value" "Any value written to P971 starts a save."
                => |d| d.encoder.value(971, |_| 1);
            "p971-confirms-too-early" "P971 reads 0 before the save is done."
                => |d| d.encoder.element(|_, at, right| if at == (971, 0) { 0 } else { right });
            "p971-is-stored" "P971 reads 1 after power-up if it was written before."
                => |d| d.encoder.add(SavingIsStored::default());
            "save-never-ends" "P971 always reads 1 after it was written."
                => |d| d.encoder.add(SaveNeverEnds::default());
            "failed-save-confirmed" "P971 reads 0 after a save that failed."
                => |d| d.encoder.element(failed_save_confirmed);
            "only-first-save" "Only the first save after power-up has an effect."
                => |d| d.encoder.add(OnlyFirstSave::default());
            "save-during-save-lost" "A save requested during another save is acknowledged but not carried out."
                => |d| d.encoder.store(save_during_save_lost);
            "save-restores-old-offset" "P971 stores the offset of the last power-up again."
                => |d| d.encoder.add(SaveRestoresOldOffset::default());
        },
    },
];

/// Stores only the offset of absolute presets.
fn relative_preset_not_stored(d: &mut Deviations) {
    let stored = Rc::new(Cell::new(0));
    let known = stored.clone();
    d.measuring.preset(move |preset, right| {
        if preset.mode == PresetMode::Absolute {
            known.set(right);
        }
        right
    });
    let left = stored.clone();
    d.encoder.reset(move |_, clears, retained| {
        if clears.application {
            left.set(retained.offset);
        }
        retained
    });
    d.encoder.load(move |_, retained| RetainedEncoderData { offset: stored.get(), ..retained });
}

#[derive(Default)]
struct OffsetUsedUp {
    was_taken: bool,
}

impl EncoderHooks for OffsetUsedUp {
    fn store(&mut self, _: &EncoderView<'_>, write: Option<MemoryWrite>) -> Option<MemoryWrite> {
        self.was_taken &= !matches!(write, Some(MemoryWrite::Offset { .. }));
        write
    }

    fn load(&mut self, _: &EncoderView<'_>, retained: RetainedEncoderData) -> RetainedEncoderData {
        let was_taken = core::mem::replace(&mut self.was_taken, true);
        RetainedEncoderData { offset: if was_taken { 0 } else { retained.offset }, ..retained }
    }
}

#[derive(Default)]
struct OffsetFromPresetValue {
    was_off: bool,
}

impl EncoderHooks for OffsetFromPresetValue {
    fn power_down(&mut self, _: &EncoderView<'_>) {
        self.was_off = true;
    }

    fn load(&mut self, view: &EncoderView<'_>, retained: RetainedEncoderData) -> RetainedEncoderData {
        let offset = view.measuring.preset(PresetMode::Absolute, retained.preset_value.into());
        RetainedEncoderData { offset: if self.was_off { offset } else { retained.offset }, ..retained }
    }
}

#[derive(Default)]
struct PositionRestored {
    position: Option<u64>,
}

impl EncoderHooks for PositionRestored {
    fn power_down(&mut self, view: &EncoderView<'_>) {
        self.position = Some(view.measuring.shifted());
    }

    fn load(&mut self, view: &EncoderView<'_>, retained: RetainedEncoderData) -> RetainedEncoderData {
        let as_before = self.position.map(|position| view.measuring.preset(PresetMode::Absolute, position));
        RetainedEncoderData { offset: as_before.unwrap_or(retained.offset), ..retained }
    }
}

#[derive(Default)]
struct EveryWriteIsStored {
    value: u32,
    writes: u64,
}

impl EncoderHooks for EveryWriteIsStored {
    fn working_preset(&mut self, _: &EncoderView<'_>, held: WorkingPreset) -> WorkingPreset {
        self.writes += u64::from(held.preset_value != self.value);
        self.value = held.preset_value;
        held
    }

    fn power_down(&mut self, view: &EncoderView<'_>) {
        self.value = view.preset_value;
    }

    fn reset(&mut self, _: &EncoderView<'_>, _: ClearedData, left: RetainedEncoderData) -> RetainedEncoderData {
        self.value = left.preset_value;
        left
    }

    fn load(&mut self, _: &EncoderView<'_>, retained: RetainedEncoderData) -> RetainedEncoderData {
        RetainedEncoderData { preset_value: self.value, ..retained }
    }

    fn counter(&mut self, name: &str, count: u64) -> u64 {
        if name == "nvm_writes" { count + self.writes } else { count }
    }
}

fn is_save(write: &Option<MemoryWrite>) -> bool {
    matches!(write, Some(MemoryWrite::PresetValue { .. }))
}

#[derive(Default)]
struct SavingIsStored {
    reads_1: bool,
}

impl EncoderHooks for SavingIsStored {
    fn store(&mut self, _: &EncoderView<'_>, write: Option<MemoryWrite>) -> Option<MemoryWrite> {
        self.reads_1 &= !is_save(&write);
        write
    }

    fn load(&mut self, view: &EncoderView<'_>, retained: RetainedEncoderData) -> RetainedEncoderData {
        self.reads_1 = view.store.preset_value.writes() > 0;
        retained
    }

    fn element(&mut self, _: &EncoderView<'_>, at: (u16, usize), right: u64) -> u64 {
        if at == (971, 0) && self.reads_1 { 1 } else { right }
    }
}

#[derive(Default)]
struct SaveNeverEnds {
    was_begun: bool,
}

impl EncoderHooks for SaveNeverEnds {
    fn store(&mut self, _: &EncoderView<'_>, write: Option<MemoryWrite>) -> Option<MemoryWrite> {
        self.was_begun |= is_save(&write);
        write
    }

    fn load(&mut self, _: &EncoderView<'_>, retained: RetainedEncoderData) -> RetainedEncoderData {
        self.was_begun = false;
        retained
    }

    fn element(&mut self, _: &EncoderView<'_>, at: (u16, usize), right: u64) -> u64 {
        if at == (971, 0) && self.was_begun { 1 } else { right }
    }
}

fn failed_save_confirmed(view: &EncoderView<'_>, at: (u16, usize), right: u64) -> u64 {
    if at == (971, 0) && view.store.preset_value.deadline().is_none() { 0 } else { right }
}

#[derive(Default)]
struct OnlyFirstSave {
    was_saved: bool,
}

impl EncoderHooks for OnlyFirstSave {
    fn store(&mut self, _: &EncoderView<'_>, write: Option<MemoryWrite>) -> Option<MemoryWrite> {
        let saves = is_save(&write);
        let is_lost = saves && self.was_saved;
        self.was_saved |= saves;
        write.filter(|_| !is_lost)
    }

    fn load(&mut self, _: &EncoderView<'_>, retained: RetainedEncoderData) -> RetainedEncoderData {
        self.was_saved = false;
        retained
    }
}

fn save_during_save_lost(view: &EncoderView<'_>, write: Option<MemoryWrite>) -> Option<MemoryWrite> {
    let is_lost = is_save(&write) && view.store.preset_value.deadline().is_some();
    write.filter(|_| !is_lost)
}

#[derive(Default)]
struct SaveRestoresOldOffset {
    at_power_up: u64,
    is_restored: bool,
}

impl EncoderHooks for SaveRestoresOldOffset {
    fn store(&mut self, _: &EncoderView<'_>, write: Option<MemoryWrite>) -> Option<MemoryWrite> {
        match write {
            Some(MemoryWrite::PresetValue { .. }) => self.is_restored = true,
            Some(MemoryWrite::Offset { .. }) => self.is_restored = false,
            None => {}
        }
        write
    }

    fn load(&mut self, _: &EncoderView<'_>, retained: RetainedEncoderData) -> RetainedEncoderData {
        let is_restored = core::mem::take(&mut self.is_restored);
        self.at_power_up = if is_restored { self.at_power_up } else { retained.offset };
        RetainedEncoderData { offset: self.at_power_up, ..retained }
    }
}

const PARK: u16 = 0x4000;

/// Keeps requesting parking after power-up, until the controller requests it.
#[derive(Default)]
struct ParkingSurvives {
    was_parked: bool,
    is_requested: bool,
}

impl EncoderHooks for ParkingSurvives {
    fn power_down(&mut self, view: &EncoderView<'_>) {
        self.was_parked = view.sensor.is_parked();
    }

    fn load(&mut self, _: &EncoderView<'_>, retained: RetainedEncoderData) -> RetainedEncoderData {
        self.is_requested = self.was_parked;
        retained
    }

    fn outputs(&mut self, _: &EncoderView<'_>, _: &Telegram, arrived: OutputValues) -> OutputValues {
        let Some([stw2_enc, g1_stw]) = arrived.words else { return arrived };
        self.is_requested &= g1_stw & PARK == 0;
        let park = if self.is_requested { PARK } else { 0 };
        OutputValues { words: Some([stw2_enc, g1_stw | park]), ..arrived }
    }
}

/// Changes the stored station data at power-off as `keeps` says.
struct StationLost {
    was_off: bool,
    keeps: fn(StationData) -> StationData,
}

impl StationLost {
    fn new(keeps: fn(StationData) -> StationData) -> StationLost {
        StationLost { was_off: false, keeps }
    }
}

impl EncoderHooks for StationLost {
    fn power_down(&mut self, _: &EncoderView<'_>) {
        self.was_off = true;
    }

    fn load(&mut self, _: &EncoderView<'_>, retained: RetainedEncoderData) -> RetainedEncoderData {
        if self.was_off {
            RetainedEncoderData { station: (self.keeps)(retained.station), ..retained }
        } else {
            retained
        }
    }
}

/// The memory errors, with their numbers.
fn of_memory(view: &EncoderView<'_>) -> impl Iterator<Item = (u16, &'static ErrorFact)> {
    let errors = view.facts.errors.iter().enumerate().filter(|(_, error)| error.effect == FaultEffect::NoMemory);
    errors.map(|(number, error)| (number as u16, error))
}

fn is_of_memory(view: &EncoderView<'_>, error: &SensorError) -> bool {
    of_memory(view).any(|(number, _)| number == error.number)
}

#[derive(Default)]
struct FaultIgnoredAtPowerUp {
    has_begun: bool,
    is_ignored: bool,
}

impl EncoderHooks for FaultIgnoredAtPowerUp {
    fn load(&mut self, _: &EncoderView<'_>, retained: RetainedEncoderData) -> RetainedEncoderData {
        self.has_begun = true;
        retained
    }

    fn causes(&mut self, view: &EncoderView<'_>, right: Vec<SensorError>) -> Vec<SensorError> {
        if core::mem::take(&mut self.has_begun) {
            self.is_ignored = right.iter().any(|error| is_of_memory(view, error));
        }
        right.into_iter().filter(|error| !self.is_ignored || !is_of_memory(view, error)).collect()
    }
}

fn empty_memory_is_a_fault(view: &EncoderView<'_>, mut right: Vec<SensorError>) -> Vec<SensorError> {
    if view.store.offset.writes() + view.store.preset_value.writes() == 0 {
        for (number, error) in of_memory(view) {
            if right.iter().all(|known| known.number != number) {
                right.push(SensorError { number, code: error.code });
            }
        }
        right.sort_by_key(|error| error.number);
    }
    right
}
