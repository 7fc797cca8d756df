//! The part of a manual that is code: functions that the encoder object calls. Each has a default.

use super::Live;
use crate::encoder::{PresetMode, Settings};
use crate::facts::{ErrorFact, Reset};
use crate::profidrive::parameters::Parameter;
use crate::profidrive::telegram::Image;
use alloc::vec::Vec;
use device_stack::profinet::{Access, RecordRefusal, Seen};
use station::{StandAction, Time};
use wire::http::{Request, Response};
use wire::profidrive::ErrorNumber;

/// The code of one model. Its value holds state that the encoder object does not know, volatile or stored.
///
/// `()` is a model that needs no code in addition to its facts.
#[allow(unused_variables, reason = "the names document the parameters")]
pub trait Model: Sized {
    /// A parameter of the model, which precedes those of the encoder object. `None` leaves it to the encoder object.
    fn parameter(live: &Live<'_, Self>, number: u16) -> Option<Parameter> {
        None
    }

    /// Writes the elements of a writable parameter from `subindex` on. `None` leaves it to the encoder object.
    fn write(live: &mut Live<'_, Self>, number: u16, subindex: u16, values: &[u64]) -> Option<Result<(), ErrorNumber>> {
        None
    }

    /// Whether the encoder object serves its record with this index now.
    fn serves(live: &Live<'_, Self>, index: u16) -> bool {
        true
    }

    /// Reads a record and appends it to `out`. `None` leaves it to the encoder object.
    fn read_record(live: &mut Live<'_, Self>, access: Access, out: &mut Vec<u8>) -> Option<Result<(), RecordRefusal>> {
        None
    }

    /// Writes a record. `None` leaves it to the encoder object.
    fn write_record(live: &mut Live<'_, Self>, access: Access, data: &[u8]) -> Option<Result<(), RecordRefusal>> {
        None
    }

    /// Whether the cause [`Model`](crate::facts::Cause::Model) of an error is present.
    fn is_caused(live: &Live<'_, Self>, error: &ErrorFact) -> bool {
        false
    }

    /// The bits of the warnings whose cause the model detects, without those of stand faults.
    fn warnings(live: &Live<'_, Self>) -> u32 {
        0
    }

    /// Changes the settings from the user parameters before they take effect.
    fn settings(live: &Live<'_, Self>, settings: Settings) -> Settings {
        settings
    }

    /// Whether a preset with this value, in units, is carried out. A refused preset is not acknowledged.
    fn takes_preset(live: &mut Live<'_, Self>, mode: PresetMode, value: u64) -> bool {
        true
    }

    /// The shaft position that the sensor reads, in hardware steps, unbounded.
    fn place(live: &mut Live<'_, Self>) -> i64 {
        live.shaft.place(live.now)
    }

    /// The stand moved the shaft at once, without passing the positions in between.
    fn placed(live: &mut Live<'_, Self>) {}

    /// Whether the encoder sends a sign of life. While it does not, the sign is 0; afterwards it restarts.
    fn gives_sign_of_life(live: &Live<'_, Self>) -> bool {
        true
    }

    /// Whether the encoder monitors the sign of life of the controller.
    fn watches_controller(live: &Live<'_, Self>) -> bool {
        live.facts.watches_controller
    }

    /// Changes the signals of a frame that the encoder object has computed.
    fn shown(live: &Live<'_, Self>, image: Image) -> Image {
        image
    }

    /// Called after time has advanced to `live.now` and the position was updated.
    fn advance(live: &mut Live<'_, Self>) {}

    /// A connection with cyclic data begins; its parameters follow.
    fn started(live: &mut Live<'_, Self>) {}

    /// The user parameters of the start are in force.
    fn parametrized(live: &mut Live<'_, Self>) {}

    /// Carries out an action of the stand that the encoder object does not support. Returns when it is complete;
    /// `None` if unsupported.
    fn act(live: &mut Live<'_, Self>, action: &StandAction<'_>) -> Option<Time> {
        None
    }

    /// What an LED shows, from the state of the stack; `None` if there is no LED of this name.
    fn led(live: &Live<'_, Self>, name: &str, status: &Seen) -> Option<&'static str> {
        None
    }

    /// The value of a counter; `None` if the model has no counter of this name.
    fn counter(live: &Live<'_, Self>, name: &str) -> Option<u64> {
        None
    }

    /// The supply was switched on: initialise volatile state.
    fn power_up(live: &mut Live<'_, Self>) {}

    /// The supply failed.
    fn power_down(live: &mut Live<'_, Self>) {}

    /// A factory reset cleared the stored data of the encoder object.
    fn reset(live: &mut Live<'_, Self>) {}

    /// The data that a factory reset requested before the loss of power clears now, at power-up.
    fn reset_at_power_up(&mut self) -> Option<Reset> {
        None
    }

    /// Whether the supply suffices for the encoder to work.
    fn is_alive(&self) -> bool {
        true
    }

    /// The next time at which [`advance`](Model::advance) has something to do.
    fn deadline(&self) -> Option<Time> {
        None
    }

    /// Whether the web server accepts connections.
    fn serves_pages(&self) -> bool {
        false
    }

    /// Answers a request to the web server.
    fn page(live: &mut Live<'_, Self>, request: &Request) -> Response {
        Response::page(404, "")
    }
}

impl Model for () {}
