//! Trials on PROFINET: what the verbs mean for an IO device and our controller.
//!
//! Which station is there and still lives ([`life`]), connections ([`connection`]), the services of `send` ([`services`]), what a live
//! device is found and left like ([`probe`]). Windows, rules and the stand are those of every bus; this module must not know them.

mod connection;
mod life;
mod probe;
mod services;

use super::access::Answered;
use super::driver::BusDriver;
use super::ours::Ours;
use super::probe::Kept;
use super::trial::{Done, Place, Run, Trouble};
use controllers::profinet_io::{AlarmAcknowledge, Controller, Settings};
use expression::Program;
use judge::answer::Reply;
use results::journal::Found;
use std::net::Ipv4Addr;
use suite::device::Record;
use suite::model::{Access, Answer, Manual, Service, Start, Trial};

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

    fn is_from_device(&self, run: &Run<'_>, frame: &[u8]) -> bool {
        frame.get(6..12) == Some(&run.mac.0)
    }

    fn connect<'a>(
        &self,
        run: &mut Run<'a>,
        start: &'a Start,
        answer: Option<&'a Answer>,
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
        service: &'a Service,
        answer: Option<&'a Answer>,
        second: bool,
        _: Option<&'a Program>,
    ) -> Done {
        run.send(service, answer, second)
    }

    fn station<'a>(&self, run: &mut Run<'a>, access: &'a Access, write: bool) -> Result<Answered, Trouble> {
        run.station(access, write)
    }

    fn parameters<'a>(
        &self,
        run: &mut Run<'a>,
        access: &'a Access,
        request: Vec<u8>,
    ) -> Result<Result<Vec<u8>, Reply>, Trouble> {
        run.parameter_record(access, request)
    }

    fn parameter_response(&self, run: &mut Run<'_>, request: Vec<u8>) -> Option<Vec<u8>> {
        run.record_response(request)
    }

    fn stands_with(&self, run: &mut Run<'_>, start: &Start) -> Result<Option<bool>, Trouble> {
        run.stands_with(start)
    }

    fn has_record(&self, run: &mut Run<'_>, record: &Record) -> Option<bool> {
        run.answers_record(record)
    }

    fn names_firmware(&self) -> bool {
        true
    }

    fn firmware(&self, run: &mut Run<'_>) -> Option<String> {
        run.firmware_in_im0()
    }

    fn put_back(&self, run: &mut Run<'_>, found: &Found, kept: &Kept<'_>) -> Vec<String> {
        run.put_all_back(found, kept)
    }
}

fn controllers(place: &Place, id: &str) -> Vec<Controller> {
    // Devices tell controllers apart by the object they call as, so each is of a kind of its own.
    [("controller-1", 0x0001), ("controller-2", 0x0002)]
        .into_iter()
        .zip(place.controllers)
        .map(|((name, device_id), (mac, ip))| {
            let seed = place.seed.wrapping_add(mac.0[5].into());
            let settings = Settings {
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
