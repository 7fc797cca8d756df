//! The preset by bits 11 and 12 of G1_STW (chapter 10, G1_STW, and 16.2).

use super::{ParkingEffect, Sensor, SensorRequest};
use crate::encoder::PresetMode;
use crate::profidrive::checks::EncoderCheck;

/// The state of the preset handshake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// No preset is requested, or the last one was not carried out.
    Idle,
    /// The preset is being carried out.
    Running,
    /// The preset was carried out and the request is still set: bit 12 of G1_ZSW is set.
    Executed,
}

impl Sensor {
    /// Starts a preset on a new request, and clears bit 12 of G1_ZSW with the request (16.2).
    ///
    /// A parked encoder carries out no preset, and parking clears bit 12 of G1_ZSW (16.3).
    pub(super) fn begin_preset(&mut self, before: SensorRequest) -> Option<PresetMode> {
        let (now, parked) = (self.request, self.is_parked());
        let is_new = now.home && !before.home;
        let begins = self.checks.check(EncoderCheck::BeginsPreset { before, now, parked }, is_new && !parked);
        let ends = !now.home || parked && self.facts.parks == ParkingEffect::Zeroes;
        match self.preset {
            Preset::Idle | Preset::Executed if begins => {
                self.preset = Preset::Running;
                Some(now.mode())
            }
            Preset::Executed if ends => {
                self.preset = Preset::Idle;
                None
            }
            Preset::Idle | Preset::Running | Preset::Executed => None,
        }
    }

    /// Reports the result of the running preset. It is acknowledged only if its request is still set.
    pub fn preset_done(&mut self, carried_out: bool) {
        let (requested, parked) = (self.request.home, self.is_parked());
        let check = EncoderCheck::AnswersPreset { carried_out, requested, parked };
        let is_answered = self.checks.check(check, carried_out && requested && !parked);
        self.preset = match self.preset {
            Preset::Running if is_answered => Preset::Executed,
            Preset::Running => Preset::Idle,
            other @ (Preset::Idle | Preset::Executed) => other,
        };
    }

    /// Stores a preset request that was not valid in this cycle: if it is still set when it becomes valid, it is not
    /// a new one.
    pub fn note_invalid_preset(&mut self, requested: bool) {
        self.held.home |= requested;
    }
}
