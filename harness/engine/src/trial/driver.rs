//! What a trial asks of the bus that it runs on.
//!
//! Each bus implements [`BusDriver`]; a trial talks to a bus through it alone and does not know which one it is.

use super::Run;
use super::access::Answered;
use super::trouble::{Done, Trouble};
use crate::live::Kept;
use crate::ours::Ours;
use crate::place::Place;
use expression::Program;
use judge::answer::Reply;
use results::journal::Found;
use suite::device::Record;
use suite::model::{Access, Answer, Manual, Service, Start, Trial};

/// A bus: how a device is found, connected with, asked, and put back there.
pub trait BusDriver {
    /// Our stations, fresh for a trial.
    fn stations(&self, manual: &Manual, place: &Place, trial: &Trial) -> Ours;

    /// The device answers and is what the bench claims; anything else says nothing about it.
    fn prove_life(&self, run: &mut Run<'_>) -> Done;

    /// The device answers when the trial is over.
    fn still_lives(&self, run: &mut Run<'_>) -> Done;

    /// Gives the station the name or the address back that a trial may have changed; `has_read` says whether the device has
    /// started with switches or faults that are not there any more.
    fn put_station_back(&self, run: &mut Run<'_>, has_read: bool) -> Done;

    /// Takes back what a trial has set of our own station.
    fn undo_settings(&self, run: &mut Run<'_>);

    /// Who the device said that it is, for the report.
    fn identity(&self, run: &Run<'_>) -> Option<String>;

    /// Whether a frame says that the device under test has sent it.
    fn is_from_device(&self, run: &Run<'_>, frame: &[u8]) -> bool;

    /// Makes a connection and judges `answer`.
    fn connect<'a>(
        &self,
        run: &mut Run<'a>,
        start: &'a Start,
        answer: Option<&'a Answer>,
        second: bool,
        to: Option<&'a Program>,
    ) -> Done;

    /// Ends the connection that stands.
    fn release(&self, run: &mut Run<'_>, second: bool) -> Done;

    /// Waits until so many cycles are over.
    fn cycles(&self, run: &mut Run<'_>, count: u64) -> Done;

    /// Waits until a frame with the outputs that are set now has left.
    fn outputs_leave(&self, run: &mut Run<'_>) -> Done;

    /// Sends a service and judges its answer.
    fn send<'a>(
        &self,
        run: &mut Run<'a>,
        service: &'a Service,
        answer: Option<&'a Answer>,
        second: bool,
        to: Option<&'a Program>,
    ) -> Done;

    /// Reads or writes what is reached in another way on each bus: records, the station, diagnosis, configuration, web pages.
    fn access<'a>(&self, run: &mut Run<'a>, access: &'a Access, write: bool) -> Result<Answered, Trouble>;

    /// Sends a parameter request; its response, or why there is none.
    fn parameters<'a>(
        &self,
        run: &mut Run<'a>,
        access: &'a Access,
        request: Vec<u8>,
    ) -> Result<Result<Vec<u8>, Reply>, Trouble>;

    /// The response to a parameter request in the connection that stands, outside a trial.
    fn parameter_response(&self, run: &mut Run<'_>, request: Vec<u8>) -> Option<Vec<u8>>;

    /// Whether a connection stands after this start-up; none where the device neither accepts nor refuses it.
    fn stands_with(&self, run: &mut Run<'_>, start: &Start) -> Result<Option<bool>, Trouble>;

    /// Whether the device answers when a record is read; none where it cannot be read alone.
    fn has_record(&self, run: &mut Run<'_>, record: &Record) -> Option<bool>;

    /// Whether devices name their firmware in a connection.
    fn names_firmware(&self) -> bool;

    /// The firmware that the device names in the connection that stands.
    fn firmware(&self, run: &mut Run<'_>) -> Option<String>;

    /// Gives a live device back what it was found with; what did not go back, in words.
    fn put_back(&self, run: &mut Run<'_>, found: &Found, kept: &Kept<'_>) -> Vec<String>;
}
