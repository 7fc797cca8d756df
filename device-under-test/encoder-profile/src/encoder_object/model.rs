//! What is a model's own: hooks into the encoder object, all of which may be left as they are.

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

/// The own part of a model; its value holds what the encoder object does not know, stored or not.
///
/// `()` is a model whose facts say everything.
#[allow(unused_variables, reason = "the names tell what a hook is given")]
pub trait Model: Sized {
    /// A parameter, asked for before those of the encoder object; none leaves it to them.
    fn parameter(live: &Live<'_, Self>, number: u16) -> Option<Parameter> {
        None
    }

    /// Writes the elements of a writable parameter from `subindex` on; none leaves it to the encoder object.
    fn write(live: &mut Live<'_, Self>, number: u16, subindex: u16, values: &[u64]) -> Option<Result<(), ErrorNumber>> {
        None
    }

    /// Whether the record of this index answers now, where it is one of the encoder object.
    fn serves(live: &Live<'_, Self>, index: u16) -> bool {
        true
    }

    /// Reads a record and appends it to `out`; none leaves it to the encoder object.
    fn read_record(live: &mut Live<'_, Self>, access: Access, out: &mut Vec<u8>) -> Option<Result<(), RecordRefusal>> {
        None
    }

    /// Writes a record; none leaves it to the encoder object.
    fn write_record(live: &mut Live<'_, Self>, access: Access, data: &[u8]) -> Option<Result<(), RecordRefusal>> {
        None
    }

    /// Whether the cause [`Model`](crate::facts::Cause::Model) of an error is there.
    fn is_caused(live: &Live<'_, Self>, error: &ErrorFact) -> bool {
        false
    }

    /// The bits of the warnings whose cause is there, beside those that the stand brings about.
    fn warnings(live: &Live<'_, Self>) -> u32 {
        0
    }

    /// The settings in force, from those of the user parameters.
    fn settings(live: &Live<'_, Self>, settings: Settings) -> Settings {
        settings
    }

    /// Whether a preset is carried out with this value, in units; one that is not goes unanswered.
    fn takes_preset(live: &mut Live<'_, Self>, mode: PresetMode, value: u64) -> bool {
        true
    }

    /// Where the sensor sees the shaft, in hardware steps over all revolutions.
    fn place(live: &mut Live<'_, Self>) -> i64 {
        live.shaft.place(live.now)
    }

    /// The shaft was put elsewhere without a way there.
    fn placed(live: &mut Live<'_, Self>) {}

    /// Whether the encoder gives a sign of life; while it does not the sign is 0, and it begins anew afterwards.
    fn gives_sign_of_life(live: &Live<'_, Self>) -> bool {
        true
    }

    /// Whether the sign of life of the controller is watched.
    fn watches_controller(live: &Live<'_, Self>) -> bool {
        live.facts.watches_controller
    }

    /// The signals of a frame, from those that the encoder object has settled.
    fn shown(live: &Live<'_, Self>, image: Image) -> Image {
        image
    }

    /// The time has come to `live.now`; the position is that of now.
    fn advance(live: &mut Live<'_, Self>) {}

    /// A connection with cyclic data begins; its parameters follow.
    fn started(live: &mut Live<'_, Self>) {}

    /// The user parameters of the start are in force.
    fn parametrized(live: &mut Live<'_, Self>) {}

    /// Does what the stand does, where the encoder object has no means for it; says when it will be done.
    fn act(live: &mut Live<'_, Self>, action: &StandAction<'_>) -> Option<Time> {
        None
    }

    /// What an LED shows, from what the stack knows; none if there is none of this name.
    fn led(live: &Live<'_, Self>, name: &str, seen: &Seen) -> Option<&'static str> {
        None
    }

    /// How often a counter has counted; none if the model has none of this name.
    fn counter(live: &Live<'_, Self>, name: &str) -> Option<u64> {
        None
    }

    /// The supply has come: what is volatile is lost.
    fn power_up(live: &mut Live<'_, Self>) {}

    /// The supply has gone.
    fn power_down(live: &mut Live<'_, Self>) {}

    /// A factory reset clears what the encoder object has stored.
    fn reset(live: &mut Live<'_, Self>) {}

    /// What a factory reset that was asked for before clears now that the supply has come.
    fn reset_at_power_up(&mut self) -> Option<Reset> {
        None
    }

    /// Whether there is enough supply for the encoder to work.
    fn is_alive(&self) -> bool {
        true
    }

    /// The next time at which [`advance`](Model::advance) has something to do.
    fn deadline(&self) -> Option<Time> {
        None
    }

    /// Whether the web server takes connections.
    fn serves_pages(&self) -> bool {
        false
    }

    /// Answers a request to the web server.
    fn page(live: &mut Live<'_, Self>, request: &Request) -> Response {
        Response::page(404, "")
    }
}

impl Model for () {}
