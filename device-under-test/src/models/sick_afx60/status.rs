//! The sensor status in P1000 and P1001 and what is behind it. Manual, 5.4.1.
//!
//! Readings: a bit follows its cause, whatever of it is latched as an error elsewhere. An invalid preset and an accepted one
//! are told until the next preset or the next start, an invalid parameter until the next start.

use super::{Live, State};
use crate::encoder::PresetMode;
use station::Time;

/// The faults of the stand that bits of S_STAT_A tell, by bit.
pub const FAULTS_A: &[(&str, u32)] = &[
    ("led_current", 2),
    ("amplitude_multiturn", 4),
    ("amplitude_singleturn", 6),
    ("main_unit", 7),
    ("vector_singleturn", 8),
    ("vector_multiturn", 9),
    ("singleturn_calculation", 10),
    ("multiturn_synchronization", 11),
    ("multiturn_update", 12),
    ("sensor_module", 14),
    ("eeprom_checksum", 15),
];

/// The faults of the stand that bits of S_STAT_B tell, by bit.
const FAULTS_B: &[(&str, u32)] = &[
    ("area_basic", 8),
    ("area_communication", 11),
    ("area_service", 12),
    ("area_process", 13),
    ("area_device", 14),
    ("area_sensor", 15),
];

/// What a save has come to, as bits 1 and 0 of S_STAT_C tell it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Saving {
    /// There was none.
    #[default]
    None,
    /// It goes on.
    Running,
    /// It is complete.
    Complete,
}

impl Saving {
    /// Bits 1 and 0.
    pub fn bits(self) -> u16 {
        match self {
            Saving::None => 0,
            Saving::Running => 1,
            Saving::Complete => 2,
        }
    }
}

/// What the status tells that is neither a fault nor a limit.
#[derive(Clone, Copy, Debug, Default)]
pub struct Status {
    /// Whether the start-up brought parameters that cannot be served.
    pub has_invalid_parameter: bool,
    /// Whether the value of the last preset was outside the measuring range.
    pub has_invalid_preset: bool,
    /// Whether the last preset was accepted.
    pub has_accepted_preset: bool,
    /// The fault bits that were there since the connection began.
    pub faults_seen: u64,
    /// The save by P971.
    pub saving: Saving,
    /// The save of the diagnostic data: when it is done.
    pub diagnosis_saved_at: Option<Time>,
}

impl Live<'_, State> {
    /// S_STAT_A.
    pub fn status_a(&self) -> u16 {
        let bit = |n: u32, set: bool| u16::from(set) << n;
        self.faults_in(FAULTS_A)
            | bit(0, self.model.around.has_start_up_error)
            | bit(1, self.temperature_is_outside())
            | bit(3, self.voltage_is_outside().contains(&true))
            | bit(5, self.speed_is_outside())
    }

    /// S_STAT_B.
    pub fn status_b(&self) -> u16 {
        let bit = |n: u32, set: bool| u16::from(set) << n;
        let status = &self.model.status;
        self.faults_in(FAULTS_B)
            | bit(1, status.has_invalid_parameter)
            | bit(4, status.has_invalid_preset)
            | bit(5, self.is_too_fast() || self.behaviour.afx60.tells_low_frequency && self.is_too_slow())
    }

    /// S_STAT_C: there is no synchronous operation.
    pub fn status_c(&self) -> u16 {
        let status = &self.model.status;
        let diagnosis = match status.diagnosis_saved_at {
            None => Saving::None,
            Some(done) if done > self.now => Saving::Running,
            Some(_) => Saving::Complete,
        };
        1 << 14 | u16::from(status.has_accepted_preset) << 12 | diagnosis.bits() << 2 | status.saving.bits()
    }

    /// The three words as they are shown.
    pub fn status_words(&self) -> [u16; 3] {
        let right = [self.status_a(), self.status_b(), self.status_c()];
        (self.behaviour.afx60.words)(right, self.operating_status()[2])
    }

    fn faults_in(&self, faults: &[(&str, u32)]) -> u16 {
        faults.iter().filter(|(name, _)| self.faults.has(name)).fold(0, |bits, (_, bit)| bits | 1 << bit)
    }

    /// Whether a preset is carried out with this value: it is in the measuring range.
    pub fn judge_preset(&mut self, _: PresetMode, value: u64) -> bool {
        let is_right = (self.behaviour.afx60.takes_preset)(value, self.positions(), &self.hardware);
        let status = &mut self.model.status;
        (status.has_invalid_preset, status.has_accepted_preset) = (!is_right, is_right);
        is_right
    }

    /// Ends the saves that are done.
    pub fn end_saves(&mut self) {
        self.model.limits.memory.settle(self.now, false);
        let is_writing = self.store.preset_value.deadline().is_some() || self.model.limits.memory.deadline().is_some();
        if self.model.status.saving == Saving::Running && !is_writing {
            self.model.status.saving = Saving::Complete;
        }
    }
}
