//! The sensor status in P1000 and P1001 and its causes. Manual, 5.4.1.
//!
//! Interpretation: a bit follows its cause, even if an error is latched elsewhere. An invalid preset and an accepted preset
//! are reported until the next preset or the next start, an invalid parameter until the next start.

use super::hooks::Afx60Check;
use super::{Afx60State, PoweredEncoder, limits};
use encoder_profile::encoder::PresetMode;
use station::Time;

/// The stand faults that bits of S_STAT_A report, with their bit numbers.
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
    ("sensor", 8),
    ("eeprom_checksum", 15),
];

/// The stand faults that bits of S_STAT_B report, with their bit numbers.
const FAULTS_B: &[(&str, u32)] = &[
    ("area_basic", 8),
    ("area_communication", 11),
    ("area_service", 12),
    ("area_process", 13),
    ("area_device", 14),
    ("area_sensor", 15),
];

/// The progress of a save, as in bits 1 and 0 of S_STAT_C.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SaveProgress {
    /// No save has been started.
    #[default]
    None,
    /// The save is running.
    Running,
    /// The save is complete.
    Complete,
}

impl SaveProgress {
    /// Returns the value of bits 1 and 0.
    pub fn bits(self) -> u16 {
        match self {
            SaveProgress::None => 0,
            SaveProgress::Running => 1,
            SaveProgress::Complete => 2,
        }
    }
}

/// The parts of the status that are neither faults nor limits.
#[derive(Clone, Copy, Debug, Default)]
pub struct SensorStatusFlags {
    /// Whether the start-up had parameters that cannot be served.
    pub has_invalid_parameter: bool,
    /// Whether the value of the last preset was outside the measuring range.
    pub has_invalid_preset: bool,
    /// Whether the last preset was accepted.
    pub has_accepted_preset: bool,
    /// The progress of the save by P971.
    pub saving: SaveProgress,
    /// When the save of the diagnostic data is complete.
    pub diagnosis_saved_at: Option<Time>,
}

/// Returns S_STAT_A.
pub fn status_a(live: &PoweredEncoder<'_, Afx60State>) -> u16 {
    let bit = |n: u32, set: bool| u16::from(set) << n;
    faults_in(live, FAULTS_A)
        | bit(0, live.model.inputs.has_start_up_error)
        | bit(1, limits::temperature_is_outside(live))
        | bit(3, limits::voltage_is_outside(live).contains(&true))
        | bit(5, limits::speed_is_outside(live))
}

/// Returns S_STAT_B.
pub fn status_b(live: &PoweredEncoder<'_, Afx60State>) -> u16 {
    let bit = |n: u32, set: bool| u16::from(set) << n;
    let status = &live.model.status;
    faults_in(live, FAULTS_B)
        | bit(1, status.has_invalid_parameter)
        | bit(4, status.has_invalid_preset)
        | bit(5, limits::is_too_fast(live))
}

/// Returns S_STAT_C, without synchronous operation.
pub fn status_c(live: &PoweredEncoder<'_, Afx60State>) -> u16 {
    let status = &live.model.status;
    let diagnosis = match status.diagnosis_saved_at {
        None => SaveProgress::None,
        Some(done) if done > live.now => SaveProgress::Running,
        Some(_) => SaveProgress::Complete,
    };
    1 << 14 | u16::from(status.has_accepted_preset) << 12 | diagnosis.bits() << 2 | status.saving.bits()
}

/// Returns the three words of P1001.
pub fn status_words(live: &PoweredEncoder<'_, Afx60State>) -> [u16; 3] {
    [status_a(live), status_b(live), status_c(live)]
}

fn faults_in(live: &PoweredEncoder<'_, Afx60State>, faults: &[(&str, u32)]) -> u16 {
    if live.faults.are_none() {
        return 0;
    }
    faults.iter().filter(|(name, _)| live.faults.has(name)).fold(0, |bits, (_, bit)| bits | 1 << bit)
}

/// Returns whether a preset with this value is carried out: it is in the measuring range.
pub fn check_preset(live: &mut PoweredEncoder<'_, Afx60State>, _: PresetMode, value: u64) -> bool {
    let range = live.positions();
    let check = Afx60Check::PresetValue { value, range, revolutions: live.hardware.revolutions };
    let is_right = live.model.hooks.check(check, value < range);
    let status = &mut live.model.status;
    (status.has_invalid_preset, status.has_accepted_preset) = (!is_right, is_right);
    is_right
}

/// Completes finished saves.
pub fn end_saves(live: &mut PoweredEncoder<'_, Afx60State>) {
    live.model.limits.memory.settle(live.now, false);
    let is_writing = live.store.preset_value.deadline().is_some() || live.model.limits.memory.deadline().is_some();
    if live.model.status.saving == SaveProgress::Running && !is_writing {
        live.model.status.saving = SaveProgress::Complete;
    }
}
