//! The part of a manual that is code: functions that the encoder object calls. Each has a default.

use super::PoweredEncoder;
use crate::encoder::{MeasuringSettings, PresetMode};
use crate::facts::{ClearedData, ErrorFact};
use crate::profidrive::parameters::ParameterContent;
use crate::profidrive::telegram::SignalImage;
use alloc::vec::Vec;
use device_stack::profinet::{RecordAccess, RecordRefusal, StackStatus};
use station::{StandAction, Time};
use wire::http::{HttpRequest, HttpResponse};
use wire::profidrive::ErrorNumber;

/// The code of one model. Its value holds state that the encoder object does not know, volatile or stored.
///
/// `()` is a model that needs no code in addition to its facts.
#[allow(unused_variables, reason = "the names document the parameters")]
pub trait EncoderModel: Sized {
    /// A parameter of the model, which precedes those of the encoder object. `None` leaves it to the encoder object.
    fn parameter(live: &PoweredEncoder<'_, Self>, number: u16) -> Option<ParameterContent> {
        None
    }

    /// Writes the elements of a writable parameter from `subindex` on. `None` leaves it to the encoder object.
    fn write(
        live: &mut PoweredEncoder<'_, Self>,
        number: u16,
        subindex: u16,
        values: &[u64],
    ) -> Option<Result<(), ErrorNumber>> {
        None
    }

    /// Whether the encoder object serves its record with this index now.
    fn serves(live: &PoweredEncoder<'_, Self>, index: u16) -> bool {
        true
    }

    /// Reads a record and appends it to `out`. `None` leaves it to the encoder object.
    fn read_record(
        live: &mut PoweredEncoder<'_, Self>,
        access: RecordAccess,
        out: &mut Vec<u8>,
    ) -> Option<Result<(), RecordRefusal>> {
        None
    }

    /// Writes a record. `None` leaves it to the encoder object.
    fn write_record(
        live: &mut PoweredEncoder<'_, Self>,
        access: RecordAccess,
        data: &[u8],
    ) -> Option<Result<(), RecordRefusal>> {
        None
    }

    /// Whether the cause [`Model`](crate::facts::ErrorCause::Model) of an error is present.
    fn is_caused(live: &PoweredEncoder<'_, Self>, error: &ErrorFact) -> bool {
        false
    }

    /// The bits of the warnings whose cause the model detects, without those of stand faults.
    fn warnings(live: &PoweredEncoder<'_, Self>) -> u32 {
        0
    }

    /// Changes the settings from the user parameters before they take effect.
    fn settings(live: &PoweredEncoder<'_, Self>, settings: MeasuringSettings) -> MeasuringSettings {
        settings
    }

    /// Whether a preset with this value, in units, is carried out. A refused preset is not acknowledged.
    fn takes_preset(live: &mut PoweredEncoder<'_, Self>, mode: PresetMode, value: u64) -> bool {
        true
    }

    /// The shaft position that the sensor reads, in hardware steps, unbounded.
    fn shaft_position(live: &mut PoweredEncoder<'_, Self>) -> i64 {
        live.shaft.position(live.now)
    }

    /// The stand moved the shaft at once, without passing the positions in between.
    fn shaft_moved(live: &mut PoweredEncoder<'_, Self>) {}

    /// Whether the encoder sends a sign of life. While it does not, the sign is 0; afterwards it restarts.
    fn sends_sign_of_life(live: &PoweredEncoder<'_, Self>) -> bool {
        true
    }

    /// Whether the encoder monitors the sign of life of the controller.
    fn monitors_controller(live: &PoweredEncoder<'_, Self>) -> bool {
        live.facts.monitors_controller
    }

    /// Changes the signals of a frame that the encoder object has computed.
    fn frame_signals(live: &PoweredEncoder<'_, Self>, image: SignalImage) -> SignalImage {
        image
    }

    /// Called after time has advanced to `live.now` and the position was updated.
    fn advance(live: &mut PoweredEncoder<'_, Self>) {}

    /// A connection with cyclic data begins; its parameters follow.
    fn started(live: &mut PoweredEncoder<'_, Self>) {}

    /// The user parameters of the start are in force.
    fn parametrized(live: &mut PoweredEncoder<'_, Self>) {}

    /// Carries out an action of the stand that the encoder object does not support. Returns when it is complete;
    /// `None` if unsupported.
    fn act(live: &mut PoweredEncoder<'_, Self>, action: &StandAction<'_>) -> Option<Time> {
        None
    }

    /// What an LED shows, from the state of the stack; `None` if there is no LED of this name.
    fn led(live: &PoweredEncoder<'_, Self>, name: &str, status: &StackStatus) -> Option<&'static str> {
        None
    }

    /// The value of a counter; `None` if the model has no counter of this name.
    fn counter(live: &PoweredEncoder<'_, Self>, name: &str) -> Option<u64> {
        None
    }

    /// The supply was switched on: initialise volatile state.
    fn power_up(live: &mut PoweredEncoder<'_, Self>) {}

    /// The supply failed.
    fn power_down(live: &mut PoweredEncoder<'_, Self>) {}

    /// A factory reset cleared the stored data of the encoder object.
    fn reset(live: &mut PoweredEncoder<'_, Self>) {}

    /// The data that a factory reset requested before the loss of power clears now, at power-up.
    fn reset_at_power_up(&mut self) -> Option<ClearedData> {
        None
    }

    /// Whether the supply suffices for the encoder to work.
    fn is_alive(&self) -> bool {
        true
    }

    /// The next time at which [`advance`](EncoderModel::advance) has something to do.
    fn deadline(&self) -> Option<Time> {
        None
    }

    /// Whether the web server accepts connections.
    fn serves_pages(&self) -> bool {
        false
    }

    /// Answers a request to the web server.
    fn page(live: &mut PoweredEncoder<'_, Self>, request: &HttpRequest) -> HttpResponse {
        HttpResponse::page(404, "")
    }
}

impl EncoderModel for () {}
