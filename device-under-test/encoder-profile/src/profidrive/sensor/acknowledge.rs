//! The acknowledgement of errors by bit 15 of G1_STW (16.4).

use super::{AcknowledgeAnswer, PARKING_REFUSED, Parking, Sensor, SensorError};
use crate::profidrive::checks::EncoderCheck;

/// The state of an acknowledgement. Bit 11 of G1_ZSW is set unless it is idle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acknowledge {
    /// No acknowledgement.
    Idle,
    /// The request was received and is still set.
    Requested,
    /// The request was withdrawn and the errors are cleared. Bit 11 is cleared one cycle later.
    Closing,
}

impl Sensor {
    /// The state after one cycle. `before` is the request of the previous cycle.
    pub(super) fn acknowledge(&mut self, before: bool) -> Acknowledge {
        let parked = self.is_parked();
        let check = EncoderCheck::Acknowledges { parked };
        if !self.checks.check(check, !parked || self.facts.acknowledges_while_parked) {
            return Acknowledge::Idle;
        }
        match self.facts.answers {
            AcknowledgeAnswer::Handshake => self.handshake(before),
            AcknowledgeAnswer::Echo => self.echo(),
        }
    }

    /// Clears the errors when the request is withdrawn, and bit 11 after that (16.4.1). An error whose cause is still
    /// present stays (16.4.2).
    fn handshake(&mut self, before: bool) -> Acknowledge {
        let is_new = self.request.acknowledge && !before && !self.errors.is_empty();
        match self.acknowledge {
            Acknowledge::Idle | Acknowledge::Closing if is_new => Acknowledge::Requested,
            Acknowledge::Idle | Acknowledge::Closing => Acknowledge::Idle,
            Acknowledge::Requested if self.request.acknowledge => Acknowledge::Requested,
            Acknowledge::Requested => {
                self.clear_errors();
                Acknowledge::Closing
            }
        }
    }

    /// Bit 11 follows the request while there is an error (Kübler Sendix 58xx, 8.2, G1_ZSW).
    fn echo(&mut self) -> Acknowledge {
        if !(self.request.acknowledge && self.has_error()) {
            return Acknowledge::Idle;
        }
        self.clear_errors();
        Acknowledge::Requested
    }

    /// Clears the errors whose cause has gone. The cause of a refused parking is the request that is still set.
    fn clear_errors(&mut self) {
        let (checks, causes) = (&self.checks, &self.causes);
        let is_refused = self.parking == Parking::Refused;
        self.errors.retain(|error| {
            let persists = causes.contains(error) || is_refused && *error == SensorError::of(PARKING_REFUSED);
            !checks.check(EncoderCheck::ClearsError { code: error.code, persists }, !persists)
        });
    }
}
