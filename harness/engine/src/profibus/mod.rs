//! Trials on PROFIBUS: the verbs for a slave and the harness's master.
//!
//! The presence of the slave ([`presence`]), reading and restoring a live one ([`probe`]), start-ups ([`start`]), reading and writing
//! ([`access`]) and the services of `send` ([`services`]). Windows, rules and the stand are common to all buses; this module must
//! not know them.

mod access;
mod presence;
mod probe;
mod services;
mod start;

pub use start::{ISOCHRONOUS_GROUP, isochronous_times};

use super::environment::TrialEnvironment;
use super::live::{DeviceBackup, RestoreOutcome};
use super::stations::{HarnessStations, sender};
use super::trial::RunningTrial;
use super::trial::access::AccessAnswer;
use super::trial::driver::BusDriver;
use super::trial::step_error::{BoxedStepError, StepError, StepResult, other_bus};
use controllers::profibus_dp::{
    AcyclicError, DataLinkAnswer, MasterOutcome, MasterRequest, MasterSettings, ProfibusMaster,
};
use expression::{HistoryState, Program};
use judge::answer::{NegativeResponse, ReceivedReply};
use judge::observe::Address;
use results::journal::{InitialDevice, InitialImRecord};
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
pub struct ProfibusDriver;

impl BusDriver for ProfibusDriver {
    fn stations(&self, manual: &Manual, place: &TrialEnvironment, trial: &Trial) -> HarnessStations {
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
        HarnessStations::Masters(place.line.masters.into_iter().take(count).map(master).collect())
    }

    fn check_identity(&self, run: &mut RunningTrial<'_>) -> StepResult {
        run.check_slave_identity()
    }

    fn check_presence(&self, run: &mut RunningTrial<'_>) -> StepResult {
        run.check_slave_presence()
    }

    fn restore_station(&self, run: &mut RunningTrial<'_>, has_read: bool) -> StepResult {
        run.restore_slave_address(has_read)
    }

    fn undo_settings(&self, run: &mut RunningTrial<'_>) {
        run.clock(Some(false), Some(Duration::ZERO));
        run.close_ms2(false);
        run.close_ms2(true);
    }

    fn identity(&self, run: &RunningTrial<'_>) -> Option<String> {
        run.slave.identity()
    }

    fn is_from_device(&self, run: &RunningTrial<'_>, frame: &[u8]) -> bool {
        sender(frame, Address::Fdl(0)).is_some_and(|by| run.slave.is_at(by))
    }

    fn misfit(&self, run: &RunningTrial<'_>) -> Option<String> {
        let masters = (0..2).filter_map(|which| run.world.stations.master(which));
        let mut misfits = masters.flat_map(ProfibusMaster::misfits);
        misfits.find(|(asked, _)| run.slave.is_at(Address::Fdl(*asked))).map(|(_, why)| why.clone())
    }

    fn connect<'a>(
        &self,
        run: &mut RunningTrial<'a>,
        start: &'a ConnectionStart,
        answer: Option<&'a ExpectedAnswer>,
        second: bool,
        to: Option<&'a Program>,
    ) -> StepResult {
        run.parameterise(start, answer, second, to)
    }

    fn release(&self, run: &mut RunningTrial<'_>, second: bool) -> StepResult {
        run.release(second)
    }

    fn cycles(&self, run: &mut RunningTrial<'_>, count: u64) -> StepResult {
        run.whole_cycles(count)
    }

    fn wait_for_outputs(&self, run: &mut RunningTrial<'_>) -> StepResult {
        run.wait_for_outputs()
    }

    fn send<'a>(
        &self,
        run: &mut RunningTrial<'a>,
        service: &'a DeviceService,
        answer: Option<&'a ExpectedAnswer>,
        second: bool,
        to: Option<&'a Program>,
        repeats: u8,
    ) -> StepResult {
        match service {
            DeviceService::Dp(service) => run.serve(service, answer, second, to, repeats),
            DeviceService::Broken(word) => run.broken_frame(word, answer, second, to),
            _ => Err(other_bus()),
        }
    }

    fn access<'a>(
        &self,
        run: &mut RunningTrial<'a>,
        access: &'a AcyclicAccess,
        _: bool,
    ) -> Result<AccessAnswer, BoxedStepError> {
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
        run: &mut RunningTrial<'a>,
        access: &'a AcyclicAccess,
        request: Vec<u8>,
    ) -> Result<Result<Vec<u8>, ReceivedReply>, BoxedStepError> {
        run.data_set(access, request)
    }

    fn parameter_response(&self, run: &mut RunningTrial<'_>, request: Vec<u8>) -> Option<Vec<u8>> {
        run.slave_parameter(request)
    }

    fn connects_with(
        &self,
        run: &mut RunningTrial<'_>,
        start: &ConnectionStart,
    ) -> Result<Option<bool>, BoxedStepError> {
        run.slave_connects_with(start)
    }

    fn has_record(&self, _: &mut RunningTrial<'_>, _: &DeviceRecord) -> Option<bool> {
        None
    }

    fn names_firmware(&self) -> bool {
        false
    }

    fn identification(&self, _: &mut RunningTrial<'_>) -> Vec<(String, String)> {
        Vec::new()
    }

    fn firmware(&self, _: &mut RunningTrial<'_>) -> Option<String> {
        None
    }

    fn order_number(&self, _: &mut RunningTrial<'_>) -> Option<String> {
        None
    }

    fn diagnosis_octets(&self, run: &mut RunningTrial<'_>) -> Option<Vec<u8>> {
        let answer = run.diagnose(false, run.slave.address).ok()?;
        answer.diagnosis()?;
        answer.data().map(<[u8]>::to_vec)
    }

    fn im_records(&self, _: &mut RunningTrial<'_>) -> Vec<InitialImRecord> {
        Vec::new()
    }

    fn restore_im_record(&self, _: &mut RunningTrial<'_>, _: &InitialImRecord) -> Result<(), String> {
        Err("I&M is not read on PROFIBUS".to_owned())
    }

    fn restore(&self, run: &mut RunningTrial<'_>, found: &InitialDevice, kept: &DeviceBackup<'_>) -> RestoreOutcome {
        run.restore_slave(found, kept)
    }
}

impl RunningTrial<'_> {
    /// Sends a request by one of the harness's masters and waits for its outcome.
    fn ask_master(&mut self, second: bool, request: MasterRequest) -> Result<MasterOutcome, BoxedStepError> {
        let which = usize::from(second);
        let now = self.world.now();
        let begin = |ours: &mut HarnessStations| {
            let master = ours.master_mut(which).ok_or("This bench has no second master.")?;
            master.request(now, request).map_err(|why| format!("The harness's master cannot send the request: {why}."))
        };
        self.request(begin, |ours| ours.master_mut(which)?.take_outcome())
    }

    /// Sends a request that the data link layer answers.
    fn ask_link(&mut self, second: bool, request: MasterRequest) -> Result<DataLinkAnswer, BoxedStepError> {
        match self.ask_master(second, request)? {
            MasterOutcome::Answer(answer) => Ok(answer),
            outcome => Err(unexpected(&outcome)),
        }
    }

    /// The station address of a step, else that of the device.
    fn station_of(&mut self, to: Option<&Program>) -> Result<u8, BoxedStepError> {
        let address = match to {
            None => Some(self.slave.address),
            Some(program) => {
                let value = program.eval(&self.world.view(), &HistoryState::default()).as_whole();
                value.and_then(|number| u8::try_from(number).ok()).filter(|number| *number <= 127)
            }
        };
        let unknown = || StepError::other(FailureCause::Suite, Verdict::Error, "The station address is unknown.");
        let address = address.ok_or_else(unknown)?;
        self.slave.remember(address);
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
fn unexpected(outcome: &MasterOutcome) -> BoxedStepError {
    match outcome {
        // It has no token, or another station keeps the bus busy.
        MasterOutcome::Impossible(why) => {
            let what = format!("The master cannot send the request: {why}.");
            StepError::other(FailureCause::Environment, Verdict::Inconclusive, what)
        }
        outcome => {
            let what = format!(
                "The master of encspec returned an outcome of another request; this is a bug of encspec: {outcome:?}."
            );
            StepError::other(FailureCause::Harness, Verdict::Error, what)
        }
    }
}
