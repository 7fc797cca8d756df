//! The sensor interface: requests in G1_STW and answers in G1_ZSW.
//!
//! Three handshakes run in parallel: [preset](Preset), [parking](Parking) and [acknowledgement](Acknowledge). Errors
//! are latched until they are acknowledged, cleared by parking, or a new connection starts. Clause numbers are those
//! of the XAC77 manual, whose chapter 16 has a diagram of each handshake. Where it is silent, the PROFIdrive profile
//! applies. [`SensorFacts`] has the differences of other manuals.

mod acknowledge;
mod errors;
mod facts;
mod parking;
mod preset;
mod request;
#[cfg(test)]
mod tests;

pub use acknowledge::Acknowledge;
pub use errors::SensorError;
pub use facts::{AcknowledgeAnswer, ParkingEffect, PositionTransfer, SensorFacts};
pub use parking::{PARKING_REFUSED, Parking};
pub use preset::Preset;
pub use request::SensorRequest;

use crate::encoder::PresetMode;
use crate::profidrive::checks::AttachedChecks;
use alloc::vec::Vec;

/// The content of G1_XIST2.
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
    request: SensorRequest,
    /// The requests that do not count as new ones in the next cycle.
    held: SensorRequest,
    /// Latched errors, oldest first.
    errors: Vec<SensorError>,
    /// The causes of errors that were present in the last cycle.
    causes: Vec<SensorError>,
    facts: SensorFacts,
    checks: AttachedChecks,
}

impl Sensor {
    /// A sensor interface in normal operation.
    pub fn new(facts: SensorFacts, checks: AttachedChecks) -> Sensor {
        Sensor {
            preset: Preset::Idle,
            parking: Parking::Off,
            acknowledge: Acknowledge::Idle,
            request: SensorRequest::default(),
            held: SensorRequest::default(),
            errors: Vec::new(),
            causes: Vec::new(),
            facts,
            checks,
        }
    }

    /// Restarts for a new connection: handshakes are idle, and errors whose cause has gone are cleared.
    pub fn restart(&mut self, causes: &[SensorError]) {
        let mut errors = core::mem::take(&mut self.errors);
        errors.retain(|error| causes.contains(error));
        *self = Sensor { causes: errors.clone(), errors, ..Sensor::new(self.facts, self.checks.clone()) };
    }

    /// Processes the requests of one cycle. Returns the preset to carry out, if one starts.
    ///
    /// Report its result with [`preset_done`](Sensor::preset_done).
    pub fn cycle(&mut self, request: SensorRequest, moving: bool) -> Option<PresetMode> {
        let before = core::mem::replace(&mut self.held, request);
        self.request = request;
        self.parking = self.park(moving);
        self.acknowledge = self.acknowledge(before.acknowledge);
        self.begin_preset(before)
    }

    /// The connection has ended: all requests are withdrawn.
    pub fn ended(&mut self) {
        self.cycle(SensorRequest::default(), false);
    }

    /// The requests of the last cycle.
    pub fn request(&self) -> SensorRequest {
        self.request
    }

    /// Whether G1_XIST2 contains the position, provided that neither an error nor parking prevents it.
    pub fn is_transferred(&self) -> bool {
        self.request.absolute || self.facts.transfers == PositionTransfer::Always
    }

    /// The content of G1_XIST2: the oldest error, otherwise the position, but no position while parking sets it to 0.
    pub fn xist2(&self) -> Xist2 {
        match self.errors.iter().find_map(|error| error.code) {
            Some(code) => Xist2::Error(code),
            None if self.is_transferred() && (!self.is_parked() || self.is_frozen()) => Xist2::Position,
            None => Xist2::Nothing,
        }
    }

    /// G1_ZSW (chapter 10): bit 11 acknowledgement in process, 12 preset executed, 13 position in G1_XIST2, 14
    /// parked, 15 error.
    pub fn g1_zsw(&self) -> u16 {
        let bit = |n: u32, set: bool| u16::from(set) << n;
        bit(11, self.acknowledge != Acknowledge::Idle)
            | bit(12, self.preset == Preset::Executed)
            | bit(13, self.xist2() == Xist2::Position)
            | bit(14, self.is_parked())
            | bit(15, self.has_error())
    }
}
