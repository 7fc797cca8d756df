//! The sensor interface: what G1_STW requests and G1_ZSW answers.
//!
//! Three handshakes run side by side: [preset](Preset), [parking](Parking) and [acknowledgement](Acknowledge). Errors are latched
//! until they are acknowledged, parked away or the connection starts anew. The clauses are those of the XAC77 manual, whose diagrams
//! in chapter 16 print each handshake; where they are silent the PROFIdrive profile says it, and [`SensorFacts`] says what other
//! manuals have otherwise.

mod acknowledge;
mod errors;
mod facts;
mod parking;
mod preset;
mod request;
#[cfg(test)]
mod tests;

pub use acknowledge::Acknowledge;
pub use errors::Error;
pub use facts::{Answers, Parks, SensorFacts, Transfers};
pub use parking::{PARKING_REFUSED, Parking};
pub use preset::Preset;
pub use request::Request;

use crate::encoder::PresetMode;
use crate::profidrive::checks::Checks;
use alloc::vec::Vec;

/// What G1_XIST2 has to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Xist2 {
    /// Neither position nor error.
    Nothing,
    /// The position.
    Position,
    /// The code of an error.
    Error(u16),
}

/// The sensor interface of one encoder.
#[derive(Clone, Debug)]
pub struct Sensor {
    preset: Preset,
    parking: Parking,
    acknowledge: Acknowledge,
    /// The requests of the last cycle.
    request: Request,
    /// The requests that are no new ones when they are there in the next cycle.
    held: Request,
    /// Latched errors, oldest first.
    errors: Vec<Error>,
    /// The causes of errors that were there in the last cycle.
    causes: Vec<Error>,
    facts: SensorFacts,
    checks: Checks,
}

impl Sensor {
    /// A sensor interface in normal operation.
    pub fn new(facts: SensorFacts, checks: Checks) -> Sensor {
        Sensor {
            preset: Preset::Idle,
            parking: Parking::Off,
            acknowledge: Acknowledge::Idle,
            request: Request::default(),
            held: Request::default(),
            errors: Vec::new(),
            causes: Vec::new(),
            facts,
            checks,
        }
    }

    /// Begins anew for a new connection: handshakes are idle, and errors whose cause has gone are forgotten.
    pub fn restart(&mut self, causes: &[Error]) {
        let mut errors = core::mem::take(&mut self.errors);
        errors.retain(|error| causes.contains(error));
        *self = Sensor { causes: errors.clone(), errors, ..Sensor::new(self.facts, self.checks.clone()) };
    }

    /// Takes the requests of one cycle; gives the preset that is to be carried out, if one begins.
    ///
    /// Whoever carries it out says so with [`preset_done`](Sensor::preset_done).
    pub fn cycle(&mut self, request: Request, moving: bool) -> Option<PresetMode> {
        let before = core::mem::replace(&mut self.held, request);
        self.request = request;
        self.parking = self.park(moving);
        self.acknowledge = self.acknowledge(before.acknowledge);
        self.begin_preset(before)
    }

    /// The connection has ended, and with it all requests.
    pub fn ended(&mut self) {
        self.cycle(Request::default(), false);
    }

    /// The requests of the last cycle.
    pub fn request(&self) -> Request {
        self.request
    }

    /// Whether the position stands in G1_XIST2 where neither an error nor parking is in its way.
    pub fn is_transferred(&self) -> bool {
        self.request.absolute || self.facts.transfers == Transfers::Always
    }

    /// What G1_XIST2 has to show: errors before the position, of several the oldest, and no position while parking makes it 0.
    pub fn xist2(&self) -> Xist2 {
        match self.errors.iter().find_map(|error| error.code) {
            Some(code) => Xist2::Error(code),
            None if self.is_transferred() && (!self.is_parked() || self.is_frozen()) => Xist2::Position,
            None => Xist2::Nothing,
        }
    }

    /// G1_ZSW, chapter 10: bit 11 acknowledgement in process, 12 preset executed, 13 position in G1_XIST2, 14 parked, 15 error.
    pub fn g1_zsw(&self) -> u16 {
        let bit = |n: u32, set: bool| u16::from(set) << n;
        bit(11, self.acknowledge != Acknowledge::Idle)
            | bit(12, self.preset == Preset::Executed)
            | bit(13, self.xist2() == Xist2::Position)
            | bit(14, self.is_parked())
            | bit(15, self.has_error())
    }
}
