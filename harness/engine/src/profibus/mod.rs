//! Trials on PROFIBUS: the verbs for a slave and the harness's master.
//!
//! The presence of the slave ([`life`]), reading and restoring a live one ([`probe`]), start-ups ([`start`]), reading and writing
//! ([`access`]) and the services of `send` ([`services`]). Windows, rules and the stand are common to all buses; this module must
//! not know them.

mod access;
mod life;
mod probe;
mod services;
mod start;

pub use start::{ISOCHRONOUS_GROUP, isochronous_times};

use super::live::Kept;
use super::ours::{Ours, sender};
use super::place::Place;
use super::trial::Run;
use super::trial::access::Answered;
use super::trial::driver::BusDriver;
use super::trial::trouble::{Done, Facts, Trouble, other_bus};
use controllers::profibus_dp::{
    AcyclicError, DataLinkAnswer, MasterOutcome, MasterRequest, MasterSettings, ProfibusMaster,
};
use expression::{HistoryState, Program};
use judge::answer::{NegativeResponse, ReceivedReply};
use judge::observe::Address;
use results::journal::InitialDevice;
use results::outcome::FailureCause;
use results::verdict::Verdict;
use station::Duration;
use suite::device::DeviceRecord;
use suite::model::{
    AccessChannel, AcyclicAccess, AcyclicService as DeviceService, AnswerMatcher as ExpectedAnswer, ConnectionStart,
    Manual, Trial,
};
use wire::profibus::fdl::BitTimes;

/// PROFIBUS DP.
pub struct Profibus;

impl BusDriver for Profibus {
    fn stations(&self, manual: &Manual, place: &Place, trial: &Trial) -> Ours {
        // A second master takes part in the token ring all the time, so it is created only if the trial needs it.
        let count = if super::scan::has_second(trial) { 2 } else { 1 };
        let highest = place.line.masters.into_iter().take(count).max().unwrap_or_default();
        let master = |address| {
            if let Some(pace) = place.line.pace {
                return ProfibusMaster::new(pace.settings(address, place.line.baud, highest));
            }
            let mut settings = MasterSettings::new(address, place.line.baud);
            if count == 1 {
                // With a longer slot time a single master passes the token to itself less often.
                settings.slot_time = BitTimes(settings.slot_time.0 * 5 / 2);
                settings.token_pause = BitTimes(settings.token_pause.0 * 5 / 2);
                if place.bench.is_none() {
                    // No other station on a virtual bus can miss the token, so once in a cycle is enough.
                    let cycle = trial.start().map_or(Duration::ZERO, |start| start.cycle(&manual.device));
                    let cycle = u64::try_from(cycle.as_nanos()).unwrap_or(u64::MAX);
                    settings.token_pause = settings.token_pause.max(place.line.baud.bits(cycle));
                }
            }
            ProfibusMaster::new(settings)
        };
        Ours::Masters(place.line.masters.into_iter().take(count).map(master).collect())
    }

    fn prove_life(&self, run: &mut Run<'_>) -> Done {
        run.slave_answers()
    }

    fn still_lives(&self, run: &mut Run<'_>) -> Done {
        run.slave_still_lives()
    }

    fn put_station_back(&self, run: &mut Run<'_>, has_read: bool) -> Done {
        run.put_slave_back(has_read)
    }

    fn undo_settings(&self, run: &mut Run<'_>) {
        run.clock(Some(false), Some(Duration::ZERO));
    }

    fn identity(&self, run: &Run<'_>) -> Option<String> {
        run.slave.identity()
    }

    fn is_from_device(&self, run: &Run<'_>, frame: &[u8]) -> bool {
        sender(frame, Address::Fdl(0)).is_some_and(|by| run.slave.is_at(by))
    }

    fn connect<'a>(
        &self,
        run: &mut Run<'a>,
        start: &'a ConnectionStart,
        answer: Option<&'a ExpectedAnswer>,
        second: bool,
        to: Option<&'a Program>,
    ) -> Done {
        run.parameterise(start, answer, second, to)
    }

    fn release(&self, run: &mut Run<'_>, second: bool) -> Done {
        run.release(second)
    }

    fn cycles(&self, run: &mut Run<'_>, count: u64) -> Done {
        run.whole_cycles(count)
    }

    fn outputs_leave(&self, run: &mut Run<'_>) -> Done {
        run.outputs_leave()
    }

    fn send<'a>(
        &self,
        run: &mut Run<'a>,
        service: &'a DeviceService,
        answer: Option<&'a ExpectedAnswer>,
        second: bool,
        to: Option<&'a Program>,
    ) -> Done {
        match service {
            DeviceService::Dp(service) => run.serve(service, answer, second, to),
            DeviceService::Broken(word) => run.broken_frame(word, second, to),
            _ => Err(other_bus()),
        }
    }

    fn access<'a>(&self, run: &mut Run<'a>, access: &'a AcyclicAccess, _: bool) -> Result<Answered, Trouble> {
        match access.via {
            AccessChannel::Station => run.station_address(access),
            AccessChannel::Diagnosis => run.diagnosis(access),
            AccessChannel::Configuration => run.configuration(access),
            AccessChannel::Record(_) | AccessChannel::Pages | AccessChannel::Parameters | AccessChannel::Stand => {
                Err(other_bus())
            }
        }
    }

    fn parameters<'a>(
        &self,
        run: &mut Run<'a>,
        access: &'a AcyclicAccess,
        request: Vec<u8>,
    ) -> Result<Result<Vec<u8>, ReceivedReply>, Trouble> {
        run.data_set(access, request)
    }

    fn parameter_response(&self, run: &mut Run<'_>, request: Vec<u8>) -> Option<Vec<u8>> {
        run.slave_parameter(request)
    }

    fn stands_with(&self, run: &mut Run<'_>, start: &ConnectionStart) -> Result<Option<bool>, Trouble> {
        run.slave_stands_with(start)
    }

    fn has_record(&self, _: &mut Run<'_>, _: &DeviceRecord) -> Option<bool> {
        None
    }

    fn names_firmware(&self) -> bool {
        false
    }

    fn firmware(&self, _: &mut Run<'_>) -> Option<String> {
        None
    }

    fn put_back(&self, run: &mut Run<'_>, found: &InitialDevice, kept: &Kept<'_>) -> Vec<String> {
        let mut left = Vec::new();
        run.look_for_slave(found, &mut left);
        run.put_kept_back(kept, &mut left);
        left
    }
}

impl Run<'_> {
    /// Sends a request by one of the harness's masters and waits for its outcome.
    fn ask_master(&mut self, second: bool, request: MasterRequest) -> Result<MasterOutcome, Trouble> {
        let which = usize::from(second);
        let now = self.world.now();
        let begin = |ours: &mut Ours| {
            let master = ours.master_mut(which).ok_or("This bench has no second master.")?;
            master.request(now, request).map_err(|why| format!("The harness's master cannot send the request: {why}."))
        };
        self.request(begin, |ours| ours.master_mut(which)?.take_outcome())
    }

    /// Sends a request that the data link layer answers.
    fn ask_link(&mut self, second: bool, request: MasterRequest) -> Result<DataLinkAnswer, Trouble> {
        match self.ask_master(second, request)? {
            MasterOutcome::Answer(answer) => Ok(answer),
            outcome => Err(unexpected(&outcome)),
        }
    }

    /// The station address of a step, else that of the device.
    fn station_of(&mut self, to: Option<&Program>) -> Result<u8, Trouble> {
        let address = match to {
            None => Some(self.slave.address),
            Some(program) => {
                let value = program.eval(&self.world.view(), &HistoryState::default()).as_whole();
                value.and_then(|number| u8::try_from(number).ok()).filter(|number| *number <= 127)
            }
        };
        let unknown = || Facts::other(FailureCause::Suite, Verdict::Error, "The station address is unknown.");
        let address = address.ok_or_else(unknown)?;
        self.slave.meet(address);
        Ok(address)
    }
}

/// The answer of a slave's data link layer.
fn reply(answer: &DataLinkAnswer) -> ReceivedReply {
    match answer {
        answer if answer.is_positive() => ReceivedReply::Accepted,
        DataLinkAnswer::Frame { function, .. } => ReceivedReply::Refused(NegativeResponse::Fdl(function.0)),
        DataLinkAnswer::Unfit(why) => ReceivedReply::Wrong(why.clone()),
        DataLinkAnswer::Short | DataLinkAnswer::None => {
            ReceivedReply::Silent("no answer to the request and its retries".into())
        }
    }
}

/// Why an acyclic service failed.
fn failed(error: &AcyclicError) -> ReceivedReply {
    match error {
        AcyclicError::Link(answer) => match reply(answer) {
            ReceivedReply::Accepted => ReceivedReply::Wrong(error.to_string()),
            reply => reply,
        },
        AcyclicError::Timeout(_) => ReceivedReply::Silent(error.to_string()),
        AcyclicError::Unfit(why) => ReceivedReply::Wrong(why.clone()),
    }
}

/// The trouble with an outcome that does not belong to the request.
fn unexpected(outcome: &MasterOutcome) -> Trouble {
    match outcome {
        // It has no token, or another station keeps the bus busy.
        MasterOutcome::Impossible(why) => {
            let what = format!("The master cannot send the request: {why}.");
            Facts::other(FailureCause::Environment, Verdict::Inconclusive, what)
        }
        outcome => {
            let what = format!(
                "The master of encspec returned an outcome of another request; this is a bug of encspec: {outcome:?}."
            );
            Facts::other(FailureCause::Harness, Verdict::Error, what)
        }
    }
}
