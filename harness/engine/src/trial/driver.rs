//! The interface of a trial to its bus.
//!
//! Each bus implements [`BusDriver`]; a trial uses a bus only through it and does not know which one it is.

use super::RunningTrial;
use super::access::AccessAnswer;
use super::step_error::{BoxedStepError, StepResult};
use crate::environment::TrialEnvironment;
use crate::live::{DeviceBackup, RestoreOutcome};
use crate::stations::HarnessStations;
use expression::Program;
use judge::answer::ReceivedReply;
use results::journal::{InitialDevice, InitialImRecord};
use suite::device::DeviceRecord;
use suite::model::{AcyclicAccess, AcyclicService, AnswerMatcher, ConnectionStart, Manual, Trial};

/// A bus: how a device is found, connected, read and written, and restored.
pub trait BusDriver {
    /// The stations of the harness, new for each trial.
    fn stations(&self, manual: &Manual, place: &TrialEnvironment, trial: &Trial) -> HarnessStations;

    /// Checks that the device answers with the identity that the bench claims; otherwise the trial is inconclusive.
    fn check_identity(&self, run: &mut RunningTrial<'_>) -> StepResult;

    /// Checks that the device answers after the trial.
    fn check_presence(&self, run: &mut RunningTrial<'_>) -> StepResult;

    /// Restores the station name or address that a trial may have changed; `has_read`: the device has started with switches or faults
    /// that no longer apply.
    fn restore_station(&self, run: &mut RunningTrial<'_>, has_read: bool) -> StepResult;

    /// Undoes the settings that a trial made at the harness's own station.
    fn undo_settings(&self, run: &mut RunningTrial<'_>);

    /// The identity that the device reported, for the report.
    fn identity(&self, run: &RunningTrial<'_>) -> Option<String>;

    /// Whether the sender of a frame is the device under test.
    fn is_from_device(&self, run: &RunningTrial<'_>, frame: &[u8]) -> bool;

    /// Why an answer of the device did not fit the request before it, if there was one that no step judged.
    fn misfit(&self, _: &RunningTrial<'_>) -> Option<String> {
        None
    }

    /// What the device sent that it must not send whatever a step asks, if it did.
    fn misconduct(&self, _: &RunningTrial<'_>) -> Option<String> {
        None
    }

    /// Establishes a connection and judges `answer`.
    fn connect<'a>(
        &self,
        run: &mut RunningTrial<'a>,
        start: &'a ConnectionStart,
        answer: Option<&'a AnswerMatcher>,
        second: bool,
        to: Option<&'a Program>,
    ) -> StepResult;

    /// Ends the present connection.
    fn release(&self, run: &mut RunningTrial<'_>, second: bool) -> StepResult;

    /// Waits until this many cycles have ended.
    fn cycles(&self, run: &mut RunningTrial<'_>, count: u64) -> StepResult;

    /// Waits until a frame with the present outputs has been sent.
    fn wait_for_outputs(&self, run: &mut RunningTrial<'_>) -> StepResult;

    /// Sends a service and judges its answer; each frame is sent `repeats` times again.
    fn send<'a>(
        &self,
        run: &mut RunningTrial<'a>,
        service: &'a AcyclicService,
        answer: Option<&'a AnswerMatcher>,
        second: bool,
        to: Option<&'a Program>,
        repeats: u8,
    ) -> StepResult;

    /// Reads or writes names whose access depends on the bus: records, the station, diagnosis, configuration, web pages.
    fn access<'a>(
        &self,
        run: &mut RunningTrial<'a>,
        access: &'a AcyclicAccess,
        write: bool,
    ) -> Result<AccessAnswer, BoxedStepError>;

    /// Sends a parameter request; returns the response, or why there is none.
    fn parameters<'a>(
        &self,
        run: &mut RunningTrial<'a>,
        access: &'a AcyclicAccess,
        request: Vec<u8>,
    ) -> Result<Result<Vec<u8>, ReceivedReply>, BoxedStepError>;

    /// The response to a parameter request in the present connection, outside of a trial.
    fn parameter_response(&self, run: &mut RunningTrial<'_>, request: Vec<u8>) -> Option<Vec<u8>>;

    /// Whether there is a connection after this start-up; `None` if the device neither accepts nor refuses it.
    fn connects_with(
        &self,
        run: &mut RunningTrial<'_>,
        start: &ConnectionStart,
    ) -> Result<Option<bool>, BoxedStepError>;

    /// Whether the device accepts reading a record; `None` if the bus cannot read it alone.
    fn has_record(&self, run: &mut RunningTrial<'_>, record: &DeviceRecord) -> Option<bool>;

    /// Whether devices report their firmware in a connection.
    fn names_firmware(&self) -> bool;

    /// The firmware that the device reports in the present connection.
    fn firmware(&self, run: &mut RunningTrial<'_>) -> Option<String>;

    /// What the device reports about itself in the present connection, as name and value.
    fn identification(&self, run: &mut RunningTrial<'_>) -> Vec<(String, String)>;

    /// The order number that the device reports in the present connection.
    fn order_number(&self, run: &mut RunningTrial<'_>) -> Option<String>;

    /// The diagnosis that the device sends on request; `None` if the bus has none.
    fn diagnosis_octets(&self, run: &mut RunningTrial<'_>) -> Option<Vec<u8>>;

    /// Reads I&M1 to I&M4, in the present connection or without one; what the device refuses is left out.
    fn im_records(&self, run: &mut RunningTrial<'_>) -> Vec<InitialImRecord>;

    /// Writes one of I&M1 to I&M4 in the present connection, unless it is as before; the error says why it differs.
    fn restore_im_record(&self, run: &mut RunningTrial<'_>, record: &InitialImRecord) -> Result<(), String>;

    /// Restores the state of a live device before the run.
    fn restore(&self, run: &mut RunningTrial<'_>, found: &InitialDevice, kept: &DeviceBackup<'_>) -> RestoreOutcome;
}
