//! Trials on PROFINET: the verbs for an IO device and the harness's controller.
//!
//! The presence of the device ([`life`]), connections ([`connection`], [`startup`], [`mod@persona`]), reading and writing
//! ([`records`], [`station`], [`web`]), the services of `send` ([`services`]), reading and restoring a live device ([`probe`]).
//! Windows, rules and the stand are common to all buses; this module must not know them.

mod connection;
mod life;
mod persona;
mod probe;
mod records;
mod services;
mod startup;
mod station;
mod web;

pub use persona::lay_over;

use super::live::Kept;
use super::ours::Ours;
use super::place::Place;
use super::trial::Run;
use super::trial::access::Answered;
use super::trial::driver::BusDriver;
use super::trial::trouble::{Done, Facts, Trouble, other_bus};
use ::station::Duration;
use controllers::profinet_io::{
    AlarmAcknowledge, Controller, ControllerOutcome, ControllerSettings, IdentifiedStation,
};
use expression::Program;
use judge::answer::ReceivedReply;
use results::journal::InitialDevice;
use results::outcome::FailureCause;
use results::verdict::Verdict;
use std::net::Ipv4Addr;
use suite::device::DeviceRecord;
use suite::model::{AccessChannel, AcyclicAccess, AcyclicService, AnswerMatcher, ConnectionStart, Manual, Trial};

/// How long answers to an Identify to all stations are collected.
const IDENTIFY: Duration = Duration::from_millis(1300);

/// PROFINET IO.
pub struct Profinet;

impl BusDriver for Profinet {
    fn stations(&self, _: &Manual, place: &Place, trial: &Trial) -> Ours {
        Ours::Controllers(controllers(place, &trial.id))
    }

    fn prove_life(&self, run: &mut Run<'_>) -> Done {
        match run.place.mac {
            Some(mac) => run.answers_still(mac),
            None => run.is_found(),
        }
    }

    fn still_lives(&self, run: &mut Run<'_>) -> Done {
        run.still_lives()
    }

    fn put_station_back(&self, run: &mut Run<'_>, _: bool) -> Done {
        run.give_name_back()
    }

    fn undo_settings(&self, run: &mut Run<'_>) {
        if let Some(controller) = run.world.ours.controller_mut(0) {
            controller.acknowledge_alarms(AlarmAcknowledge::Given);
        }
    }

    fn identity(&self, run: &Run<'_>) -> Option<String> {
        run.identity.as_ref().map(identity)
    }

    fn is_from_device(&self, run: &Run<'_>, frame: &[u8]) -> bool {
        frame.get(6..12) == Some(&run.mac.0)
    }

    fn connect<'a>(
        &self,
        run: &mut Run<'a>,
        start: &'a ConnectionStart,
        answer: Option<&'a AnswerMatcher>,
        second: bool,
        _: Option<&'a Program>,
    ) -> Done {
        run.open(start, answer, second)
    }

    fn release(&self, run: &mut Run<'_>, second: bool) -> Done {
        run.release_ar(second)
    }

    fn cycles(&self, run: &mut Run<'_>, count: u64) -> Done {
        run.cyclic_frames(count)
    }

    fn outputs_leave(&self, run: &mut Run<'_>) -> Done {
        run.cyclic_frames(1)
    }

    fn send<'a>(
        &self,
        run: &mut Run<'a>,
        service: &'a AcyclicService,
        answer: Option<&'a AnswerMatcher>,
        second: bool,
        _: Option<&'a Program>,
    ) -> Done {
        run.send(service, answer, second)
    }

    fn access<'a>(&self, run: &mut Run<'a>, access: &'a AcyclicAccess, write: bool) -> Result<Answered, Trouble> {
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
        run: &mut Run<'a>,
        access: &'a AcyclicAccess,
        request: Vec<u8>,
    ) -> Result<Result<Vec<u8>, ReceivedReply>, Trouble> {
        run.parameter_record(access, request)
    }

    fn parameter_response(&self, run: &mut Run<'_>, request: Vec<u8>) -> Option<Vec<u8>> {
        run.record_response(request)
    }

    fn stands_with(&self, run: &mut Run<'_>, start: &ConnectionStart) -> Result<Option<bool>, Trouble> {
        run.stands_with(start)
    }

    fn has_record(&self, run: &mut Run<'_>, record: &DeviceRecord) -> Option<bool> {
        run.answers_record(record)
    }

    fn names_firmware(&self) -> bool {
        true
    }

    fn firmware(&self, run: &mut Run<'_>) -> Option<String> {
        run.firmware_in_im0()
    }

    fn put_back(&self, run: &mut Run<'_>, found: &InitialDevice, kept: &Kept<'_>) -> Vec<String> {
        run.put_all_back(found, kept)
    }
}

fn controllers(place: &Place, id: &str) -> Vec<Controller> {
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
fn unexpected(outcome: &ControllerOutcome) -> Trouble {
    let what = match outcome {
        ControllerOutcome::Impossible(why) => format!("The controller cannot send the request: {why}."),
        outcome => format!(
            "The controller of encspec returned an outcome of another request; this is a bug of encspec: {outcome:?}."
        ),
    };
    Facts::other(FailureCause::Harness, Verdict::Error, what)
}

fn identity(station: &IdentifiedStation) -> String {
    let (vendor, device) = station.id.unwrap_or_default();
    let text = |octets: &[u8]| String::from_utf8_lossy(octets).escape_debug().to_string();
    format!("{} (vendor 0x{vendor:04X}, device 0x{device:04X})", text(&station.station_type))
}
