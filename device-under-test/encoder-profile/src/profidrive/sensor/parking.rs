//! Parking by bit 14 of G1_STW (chapter 10, G1_STW, and 16.3).

use super::{ParkingEffect, Sensor, SensorError};
use crate::profidrive::checks::EncoderCheck;

/// The error code of a parking request that was refused because the shaft turns.
pub const PARKING_REFUSED: u16 = 0x0003;

/// The state of parking.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parking {
    /// The encoder measures.
    Off,
    /// The encoder is parked.
    On,
    /// Parking was refused and the request is still set.
    Refused,
}

impl Sensor {
    /// Parks on request and clears all errors, unless the shaft turns. Parking ends with the request (16.3).
    pub(super) fn park(&mut self, moving: bool) -> Parking {
        match (self.parking, self.request.park) {
            (Parking::Off | Parking::On | Parking::Refused, false) => Parking::Off,
            (Parking::Off, true) => {
                let check = EncoderCheck::Parks { moving, has_error: !self.errors.is_empty() };
                if !self.checks.check(check, !moving || self.facts.parks_while_turning) {
                    self.raise(SensorError::of(PARKING_REFUSED));
                    return Parking::Refused;
                }
                if self.checks.check(EncoderCheck::ParkingClearsErrors, self.facts.parking_clears_errors) {
                    self.errors.clear();
                }
                Parking::On
            }
            (held @ (Parking::On | Parking::Refused), true) => held,
        }
    }

    /// Whether the encoder is parked.
    pub fn is_parked(&self) -> bool {
        self.parking == Parking::On
    }

    /// Whether parking freezes the positions now.
    pub fn is_frozen(&self) -> bool {
        self.is_parked() && self.facts.parks == ParkingEffect::Freezes
    }

    /// Whether parking sets positions and velocity to 0 now.
    pub fn is_zeroed(&self) -> bool {
        self.is_parked() && self.facts.parks == ParkingEffect::Zeroes
    }
}
