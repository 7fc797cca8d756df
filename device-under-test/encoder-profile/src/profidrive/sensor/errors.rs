//! The errors of the encoder, latched in the order in which they came.

use super::Sensor;
use crate::profidrive::checks::Check;
use alloc::vec::Vec;

/// An error of the encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Error {
    /// Which one it is: its index in the facts, or [`Error::OWN`] and more for one that is not there. Errors with different numbers
    /// may share a code.
    pub number: u16,
    /// Its code in G1_XIST2; an error without one is neither shown there nor by bit 15 of G1_ZSW.
    pub code: Option<u16>,
}

impl Error {
    /// The number of an error that is not in the facts is this and its code.
    pub const OWN: u16 = 0x8000;

    /// The error that has a code of its own.
    pub const fn of(code: u16) -> Error {
        Error { number: Error::OWN | code, code: Some(code) }
    }
}

impl Sensor {
    /// Takes the causes of errors that are there now: each new one raises its error, but not while parked (16.3).
    pub fn watch(&mut self, causes: &[Error]) {
        if causes.is_empty() && self.causes.is_empty() && self.errors.is_empty() {
            return;
        }
        let parked = self.is_parked();
        let raises = |error: &&Error| {
            let check = Check::RaisesError { code: error.code, parked };
            self.checks.check(check, !parked || self.facts.raises_while_parked)
        };
        let raised: Vec<Error> = causes.iter().filter(raises).copied().collect();
        let new: Vec<Error> = raised.iter().filter(|error| !self.causes.contains(error)).copied().collect();
        new.into_iter().for_each(|error| self.raise(error));
        let (checks, latches) = (&self.checks, self.facts.latches_errors);
        self.errors
            .retain(|error| causes.contains(error) || checks.check(Check::LatchesError { code: error.code }, latches));
        self.causes = raised;
    }

    /// Latches an error that is not there yet.
    pub(super) fn raise(&mut self, error: Error) {
        if !self.errors.contains(&error) {
            self.errors.push(error);
        }
    }

    /// Latched errors, oldest first.
    pub fn errors(&self) -> &[Error] {
        &self.errors
    }

    /// Whether there is an error that is shown.
    pub fn has_error(&self) -> bool {
        self.errors.iter().any(|error| error.code.is_some())
    }
}
