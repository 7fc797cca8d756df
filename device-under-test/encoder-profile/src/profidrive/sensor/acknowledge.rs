//! The acknowledgement of errors by bit 15 of G1_STW: 16.4.

use super::{Answers, Error, PARKING_REFUSED, Parking, Sensor};
use crate::profidrive::checks::Check;

/// Where the acknowledgement of an error stands; bit 11 of G1_ZSW is set unless it is idle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acknowledge {
    /// Nothing is being acknowledged.
    Idle,
    /// The request was received and is still held.
    Requested,
    /// The request was taken back: errors have gone as far as they can, the answer goes one cycle later.
    Closing,
}

impl Sensor {
    /// Goes one cycle on, from whether the acknowledgement was requested in the cycle before.
    pub(super) fn acknowledge(&mut self, before: bool) -> Acknowledge {
        let parked = self.is_parked();
        let check = Check::Acknowledges { parked };
        match self.checks.check(check, !parked || self.facts.acknowledges_while_parked) {
            true => match self.facts.answers {
                Answers::Handshake => self.handshake(before),
                Answers::Echo => self.echo(),
            },
            false => Acknowledge::Idle,
        }
    }

    /// The errors go when the request is taken back, and the answer goes last (16.4.1); an error whose cause is still there stays
    /// (16.4.2).
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

    /// The answer follows the request while there is an error: Kübler Sendix 58xx, 8.2, G1_ZSW.
    fn echo(&mut self) -> Acknowledge {
        match self.request.acknowledge && self.has_error() {
            true => {
                self.clear_errors();
                Acknowledge::Requested
            }
            false => Acknowledge::Idle,
        }
    }

    /// Clears the errors whose cause has gone; that of a refusal to park is the request that is still held.
    fn clear_errors(&mut self) {
        let (checks, causes) = (&self.checks, &self.causes);
        let is_refused = self.parking == Parking::Refused;
        self.errors.retain(|error| {
            let persists = causes.contains(error) || is_refused && *error == Error::of(PARKING_REFUSED);
            !checks.check(Check::ClearsError { code: error.code, persists }, !persists)
        });
    }
}
