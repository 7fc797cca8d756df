//! The errors of the encoder, latched in the order of their occurrence.

use super::Sensor;
use crate::profidrive::checks::EncoderCheck;
use alloc::vec::Vec;

/// An error of the encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorError {
    /// Its index in the facts, or [`SensorError::OWN`] plus its code if it is not in the facts. Errors with different
    /// numbers may share a code.
    pub number: u16,
    /// Its code in G1_XIST2. An error without a code is shown neither there nor by bit 15 of G1_ZSW.
    pub code: Option<u16>,
}

impl SensorError {
    /// Base for the numbers of errors that are not in the facts.
    pub const OWN: u16 = 0x8000;

    /// The error with this code that is not in the facts.
    pub const fn of(code: u16) -> SensorError {
        SensorError { number: SensorError::OWN | code, code: Some(code) }
    }
}

impl Sensor {
    /// Processes the present causes of errors. Each new one raises its error, except while parked (16.3).
    pub fn watch(&mut self, causes: &[SensorError]) {
        if causes.is_empty() && self.causes.is_empty() && self.errors.is_empty() {
            return;
        }
        let parked = self.is_parked();
        let raises = |error: &&SensorError| {
            let check = EncoderCheck::RaisesError { code: error.code, parked };
            self.checks.check(check, !parked || self.facts.raises_while_parked)
        };
        let raised: Vec<SensorError> = causes.iter().filter(raises).copied().collect();
        let new: Vec<SensorError> = raised.iter().filter(|error| !self.causes.contains(error)).copied().collect();
        new.into_iter().for_each(|error| self.raise(error));
        let (checks, latches) = (&self.checks, self.facts.latches_errors);
        self.errors.retain(|error| {
            causes.contains(error) || checks.check(EncoderCheck::LatchesError { code: error.code }, latches)
        });
        self.causes = raised;
    }

    /// Latches an error, unless it already is.
    pub(super) fn raise(&mut self, error: SensorError) {
        if !self.errors.contains(&error) {
            self.errors.push(error);
        }
    }

    /// Latched errors, oldest first.
    pub fn errors(&self) -> &[SensorError] {
        &self.errors
    }

    /// Whether an error with a code is latched.
    pub fn has_error(&self) -> bool {
        self.errors.iter().any(|error| error.code.is_some())
    }
}
