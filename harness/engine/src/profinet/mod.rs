//! Trials on PROFINET: the verbs for an IO device and the harness's controller.
//!
//! The presence of the device ([`presence`]), connections ([`connection`], [`startup`], [`mod@persona`]), reading and writing
//! ([`records`], [`station`], [`web`]), the services of `send` ([`services`]), reading a live device ([`probe`]) and restoring it
//! ([`restore`]).
//! Windows, rules and the stand are common to all buses; this module must not know them.

mod connection;
mod misconduct;
mod persona;
mod presence;
mod probe;
mod records;
mod restore;
mod services;
mod startup;
mod station;
mod web;

pub use persona::apply_persona;
pub use startup::usual_connection;

use super::environment::TrialEnvironment;
use super::live::{DeviceBackup, RestoreOutcome};
use super::stations::HarnessStations;
use super::trial::RunningTrial;
use super::trial::access::AccessAnswer;
use super::trial::driver::BusDriver;
use super::trial::step_error::{BoxedStepError, StepError, StepResult, other_bus};
use ::station::Duration;
use controllers::profinet_io::{
    AlarmAcknowledge, Controller, ControllerOutcome, ControllerSettings, IdentifiedStation,
};
use expression::Program;
use judge::answer::ReceivedReply;
use results::journal::{InitialDevice, InitialImRecord};
use results::outcome::FailureCause;
use results::verdict::Verdict;
use std::net::Ipv4Addr;
use suite::device::DeviceRecord;
use suite::model::{AccessChannel, AcyclicAccess, AcyclicService, AnswerMatcher, ConnectionStart, Manual, Trial};

/// How long answers to an Identify to all stations are collected.
const IDENTIFY: Duration = Duration::from_millis(1300);

/// PROFINET IO.
pub struct ProfinetDriver;

impl BusDriver for ProfinetDriver {
    fn stations(&self, _: &Manual, place: &TrialEnvironment, trial: &Trial) -> HarnessStations {
        HarnessStations::Controllers(controllers(place, &trial.id))
    }

    fn check_identity(&self, run: &mut RunningTrial<'_>) -> StepResult {
        match run.environment.mac {
            Some(mac) => run.check_same_device(mac),
            None => run.find_device(),
        }
    }

    fn check_presence(&self, run: &mut RunningTrial<'_>) -> StepResult {
        run.check_presence()
    }

    fn restore_station(&self, run: &mut RunningTrial<'_>, _: bool) -> StepResult {
        run.restore_station_name()
    }

    fn undo_settings(&self, run: &mut RunningTrial<'_>) {
        if let Some(controller) = run.world.stations.controller_mut(0) {
            controller.acknowledge_alarms(AlarmAcknowledge::Given);
        }
    }

    fn identity(&self, run: &RunningTrial<'_>) -> Option<String> {
        run.identity.as_ref().map(identity)
    }

    fn is_from_device(&self, run: &RunningTrial<'_>, frame: &[u8]) -> bool {
        frame.get(6..12) == Some(&run.mac.0)
    }

    fn misconduct(&self, run: &RunningTrial<'_>) -> Option<String> {
        misconduct::misconduct(run)
    }

    fn connect<'a>(
        &self,
        run: &mut RunningTrial<'a>,
        start: &'a ConnectionStart,
        answer: Option<&'a AnswerMatcher>,
        second: bool,
        _: Option<&'a Program>,
    ) -> StepResult {
        run.open(start, answer, second)
    }

    fn release(&self, run: &mut RunningTrial<'_>, second: bool) -> StepResult {
        run.release_ar(second)
    }

    fn cycles(&self, run: &mut RunningTrial<'_>, count: u64) -> StepResult {
        run.cyclic_frames(count)
    }

    fn wait_for_outputs(&self, run: &mut RunningTrial<'_>) -> StepResult {
        run.cyclic_frames(1)
    }

    fn send<'a>(
        &self,
        run: &mut RunningTrial<'a>,
        service: &'a AcyclicService,
        answer: Option<&'a AnswerMatcher>,
        second: bool,
        _: Option<&'a Program>,
        _: u8,
    ) -> StepResult {
        run.send(service, answer, second)
    }

    fn access<'a>(
        &self,
        run: &mut RunningTrial<'a>,
        access: &'a AcyclicAccess,
        write: bool,
    ) -> Result<AccessAnswer, BoxedStepError> {
        match access.via {
            AccessChannel::Record(record) => run.record(access, record, write),
            AccessChannel::Station => run.station(access, write),
            AccessChannel::Pages => run.pages(access),
            AccessChannel::Diagnosis
            | AccessChannel::Configuration
            | AccessChannel::Parameters
            | AccessChannel::Stand => Err(other_bus()),
        }
    }

    fn parameters<'a>(
        &self,
        run: &mut RunningTrial<'a>,
        access: &'a AcyclicAccess,
        request: Vec<u8>,
    ) -> Result<Result<Vec<u8>, ReceivedReply>, BoxedStepError> {
        run.parameter_record(access, request)
    }

    fn parameter_response(&self, run: &mut RunningTrial<'_>, request: Vec<u8>) -> Option<Vec<u8>> {
        run.record_response(request)
    }

    fn connects_with(
        &self,
        run: &mut RunningTrial<'_>,
        start: &ConnectionStart,
    ) -> Result<Option<bool>, BoxedStepError> {
        run.connects_with(start)
    }

    fn has_record(&self, run: &mut RunningTrial<'_>, record: &DeviceRecord) -> Option<bool> {
        run.answers_record(record)
    }

    fn names_firmware(&self) -> bool {
        true
    }

    fn identification(&self, run: &mut RunningTrial<'_>) -> Vec<(String, String)> {
        run.identification_in_im0()
    }

    fn firmware(&self, run: &mut RunningTrial<'_>) -> Option<String> {
        run.firmware_in_im0()
    }

    fn order_number(&self, run: &mut RunningTrial<'_>) -> Option<String> {
        run.order_number_in_im0()
    }

    fn diagnosis_octets(&self, _: &mut RunningTrial<'_>) -> Option<Vec<u8>> {
        None
    }

    fn im_records(&self, run: &mut RunningTrial<'_>) -> Vec<InitialImRecord> {
        run.im_records_now()
    }

    fn restore_im_record(&self, run: &mut RunningTrial<'_>, record: &InitialImRecord) -> Result<(), String> {
        run.write_back_im_record(record)
    }

    fn restore(&self, run: &mut RunningTrial<'_>, found: &InitialDevice, kept: &DeviceBackup<'_>) -> RestoreOutcome {
        run.restore_device(found, kept)
    }
}

fn controllers(place: &TrialEnvironment, id: &str) -> Vec<Controller> {
    // Devices tell controllers apart by their object UUID, so each has its own device id.
    [("controller-1", 0x0001), ("controller-2", 0x0002)]
        .into_iter()
        .zip(place.controllers)
        .map(|((name, device_id), (mac, ip))| {
            let seed = place.seed.wrapping_add(mac.0[5].into());
            let settings = ControllerSettings {
                mac,
                ip,
                mask: place.ip.mask,
                gateway: Ipv4Addr::UNSPECIFIED,
                station_name: name.as_bytes().to_vec(),
                vendor_id: 0xFEED,
                device_id,
                seed: id.bytes().fold(seed, |seed, octet| seed.wrapping_mul(31).wrapping_add(octet.into())),
            };
            Controller::new(settings)
        })
        .collect()
}

/// The trouble with an outcome that does not belong to the request.
fn unexpected(outcome: &ControllerOutcome) -> BoxedStepError {
    let what = match outcome {
        ControllerOutcome::Impossible(why) => format!("The controller cannot send the request: {why}."),
        outcome => format!(
            "The controller of encspec returned an outcome of another request; this is a bug of encspec: {outcome:?}."
        ),
    };
    StepError::other(FailureCause::Harness, Verdict::Error, what)
}

fn identity(station: &IdentifiedStation) -> String {
    let (vendor, device) = station.id.unwrap_or_default();
    let text = |octets: &[u8]| String::from_utf8_lossy(octets).escape_debug().to_string();
    format!("{} (vendor 0x{vendor:04X}, device 0x{device:04X})", text(&station.station_type))
}
