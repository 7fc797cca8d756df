//! `send` on PROFIBUS: one service, sent once and unchanged.

use super::access::{record, refused};
use super::{failed, reply, unexpected};
use crate::trial::RunningTrial;
use crate::trial::step_error::{BoxedStepError, StepError, StepResult};
use controllers::profibus_dp::{
    DamagedDpFrame, DataLinkAnswer, DpRecordOutcome, MasterOutcome, MasterRequest, Ms2Opened, Ms2Outcome,
    Ms2Parameters, Ms2Service, ProfibusMaster, RepeatedAnswers,
};
use expression::{HistoryState, Program, Value};
use judge::answer::{NegativeResponse, ReceivedReply};
use results::outcome::{FailureCause, JudgedPart};
use results::verdict::Verdict;
use suite::device::DeviceModule;
use suite::model::{AnswerMatcher, AnswerPart, DpService};
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::call::FunctionIndex;
use wire::profibus::diag::Specifier;
use wire::profibus::dpv1::{Dpv1AbortReason, Dpv1Pdu, Endpoint, InitiateFeatures, Subnet};
use wire::profibus::fdl::BROADCAST;
use wire::profibus::global_control::{GlobalCommand, GlobalControl};
use wire::profibus::sap::{MasterSap, SlaveSap};

/// Instance and reason of an Abort: the user, without a reason.
const BY_THE_USER: Dpv1AbortReason = Dpv1AbortReason(0x20);

/// The service of the master for one of the suite; another service than those of MS2 is none.
fn ms2_service(service: &DpService) -> Ms2Service {
    match service {
        DpService::Ms2Initiate { send_timeout, features, profile_features, profile, source, destination } => {
            let end = |(kind, address): &(u8, Vec<u8>)| Endpoint { kind: *kind, address: address.clone() };
            let abilities = InitiateFeatures {
                features: *features,
                profile_features: *profile_features,
                profile: *profile,
                source: end(source),
                destination: end(destination),
            };
            Ms2Service::Initiate(Ms2Parameters { send_timeout: *send_timeout, abilities })
        }
        DpService::Ms2Read { slot, index, length } => Ms2Service::Read { slot: *slot, index: *index, length: *length },
        DpService::Ms2Write { slot, index, bytes } => {
            Ms2Service::Write { slot: *slot, index: *index, data: bytes.clone() }
        }
        DpService::Ms2Abort { subnet, reason } => {
            Ms2Service::Abort { subnet: Subnet(*subnet), reason: Dpv1AbortReason(*reason) }
        }
        _ => Ms2Service::Abort { subnet: Subnet::NO, reason: BY_THE_USER },
    }
}

/// The answer to a request on MS2; `replies` gets its bytes: of a record, or of the response to Initiate.
fn ms2(outcome: &Ms2Outcome, replies: &mut Vec<(AnswerPart, ReceivedReply)>) -> ReceivedReply {
    let mut bytes = |octets: &[u8]| replies.push((AnswerPart::Bytes, ReceivedReply::Value(Value::bytes(octets))));
    match outcome {
        Ms2Outcome::Opened(opened) => {
            let Ms2Opened { most_data, abilities, .. } = opened;
            let response = Dpv1Pdu::InitiateResponse { most_data: *most_data, abilities: abilities.clone() };
            let mut octets = Vec::new();
            response.write(&mut octets);
            bytes(octets.get(1..).unwrap_or_default());
            ReceivedReply::Accepted
        }
        Ms2Outcome::Record(outcome) => {
            if let DpRecordOutcome::Accepted { data } = outcome {
                bytes(data);
            }
            record(outcome)
        }
        Ms2Outcome::Kept => ReceivedReply::Accepted,
        Ms2Outcome::Refused(refusal) => refused(refusal),
        Ms2Outcome::Ended(end) => ReceivedReply::Refused(NegativeResponse::Abort(end.reason.0)),
        Ms2Outcome::Aborted(answer) => reply(answer),
        Ms2Outcome::Failed(error) => failed(error),
    }
}

impl<'a> RunningTrial<'a> {
    /// Sends a service and judges its answer, and the answers to its repetitions.
    pub(super) fn serve(
        &mut self,
        service: &'a DpService,
        answer: Option<&'a AnswerMatcher>,
        second: bool,
        to: Option<&'a Program>,
        repeats: u8,
    ) -> StepResult {
        let all = matches!(service, DpService::GlobalControl { .. }) && to.is_none();
        let to = if all { BROADCAST } else { self.station_of(to)? };
        let request = self.service_request(service, to)?;
        self.may_end |= matches!(
            service,
            DpService::SetPrm(_)
                | DpService::AccessPoint { .. }
                | DpService::ChkCfg(_)
                | DpService::DataExchange(_)
                | DpService::SetSlaveAddress { .. }
        );
        let mut replies = Vec::new();
        let outcome = match repeats {
            0 => self.ask_master(second, request)?,
            times => self.repeated(second, request, times)?,
        };
        let whole = match outcome {
            MasterOutcome::Answer(answer) => {
                if let Some(octets) = answer.data() {
                    replies.push((AnswerPart::Bytes, ReceivedReply::Value(Value::bytes(octets))));
                }
                reply(&answer)
            }
            MasterOutcome::Record(outcome) => {
                if let DpRecordOutcome::Accepted { data } = &outcome {
                    replies.push((AnswerPart::Bytes, ReceivedReply::Value(Value::bytes(data.as_slice()))));
                }
                record(&outcome)
            }
            MasterOutcome::Ms2(outcome) => ms2(&outcome, &mut replies),
            // These have no answer, so they say nothing about the device.
            MasterOutcome::Sent => return Ok(()),
            outcome => return Err(unexpected(&outcome)),
        };
        replies.push((AnswerPart::Whole, whole));
        self.world.scene.notebook_mut().answers = replies;
        self.judge_answer(answer.unwrap_or(&AnswerMatcher::Accepted))
    }

    /// Sends a request whose frames are each sent again; fails if a repetition is answered differently, or if nothing was repeated.
    fn repeated(&mut self, second: bool, request: MasterRequest, times: u8) -> Result<MasterOutcome, BoxedStepError> {
        let request = MasterRequest::Repeated { request: Box::new(request), times };
        let RepeatedAnswers { outcome, answered, difference } = match self.ask_master(second, request)? {
            MasterOutcome::Repeated(answers) => *answers,
            outcome => return Err(unexpected(&outcome)),
        };
        self.checks += 1;
        if let Some((first, again)) = difference {
            let text = "the answer to the repeated request".into();
            let part = JudgedPart { text, expected: first.to_string(), observed: again.to_string(), held: false };
            let what = "The same request with the same frame count bit got another answer.";
            return Err(StepError::device(what, vec![part]).at(self.world.trace.len() as u64));
        }
        let is_answered = match &outcome {
            MasterOutcome::Answer(answer) => answer.is_frame(),
            MasterOutcome::Ms2(outcome) => !matches!(outcome, Ms2Outcome::Failed(_)),
            outcome => matches!(outcome, MasterOutcome::Record(DpRecordOutcome::Accepted { .. })),
        };
        if answered == 0 && is_answered {
            let what = "The request was not repeated: another master took the token.";
            return Err(StepError::other(FailureCause::Environment, Verdict::Inconclusive, what));
        }
        Ok(outcome)
    }

    fn service_request(&mut self, service: &DpService, to: u8) -> Result<MasterRequest, BoxedStepError> {
        Ok(match service {
            DpService::SetSlaveAddress { new, ident, lock, length } => {
                let address = self.octet_of(new, "The new station address is unknown.")?;
                self.slave.assign(address);
                let set = SetSlaveAddress { address, ident: *ident, no_change: *lock, slave_data: Vec::new() };
                match length {
                    None => MasterRequest::SetSlaveAddress { to, set },
                    Some(length) => {
                        let mut octets = Vec::new();
                        set.write(&mut octets);
                        octets.resize(*length, 0);
                        let (dsap, ssap) = (Some(SlaveSap::SET_SLAVE_ADDRESS.0), Some(MasterSap::MS0.0));
                        MasterRequest::Service { to, dsap, ssap, octets }
                    }
                }
            }
            DpService::GlobalControl { command, groups } => {
                let control = GlobalControl { command: GlobalCommand(*command), groups: *groups };
                MasterRequest::GlobalControl { to, control }
            }
            DpService::FdlStatus => MasterRequest::FdlStatus { to },
            DpService::SlaveDiag => MasterRequest::Diagnosis { to },
            DpService::GetCfg => MasterRequest::Configuration { to },
            DpService::SetPrm(octets) => MasterRequest::SetPrm { to, octets: octets.clone() },
            DpService::ChkCfg(octets) => {
                let own = || self.module_in_use().map_or_else(Vec::new, |module| module.cfg().to_vec());
                MasterRequest::CheckConfiguration { to, octets: octets.clone().unwrap_or_else(own) }
            }
            DpService::DataExchange(octets) => {
                let octets = octets.clone().unwrap_or_else(|| vec![0; self.output_octets()]);
                MasterRequest::DataExchange { to, octets }
            }
            DpService::AccessPoint { sap, source, bytes } => {
                MasterRequest::Service { to, dsap: Some(*sap), ssap: Some(*source), octets: bytes.clone() }
            }
            DpService::ReadInputs => MasterRequest::ReadInputs { to },
            DpService::ReadOutputs => MasterRequest::ReadOutputs { to },
            DpService::Read { slot, index, length } => {
                MasterRequest::Read { to, slot: *slot, index: *index, length: *length }
            }
            DpService::Write { slot, index, bytes } => {
                MasterRequest::Write { to, slot: *slot, index: *index, data: bytes.clone() }
            }
            DpService::AlarmAck { own_access_point, alarm } => MasterRequest::AcknowledgeAlarm {
                to,
                own_access_point: *own_access_point,
                slot: self
                    .octet_of(&alarm.slot, "The slot of the alarm is unknown: no diagnosis with an alarm was read.")?,
                alarm_type: self
                    .octet_of(&alarm.alarm_type, "The type of the alarm is unknown: no diagnosis was read.")?,
                specifier: Specifier(
                    self.octet_of(&alarm.specifier, "The specifier is unknown: no diagnosis with an alarm was read.")?,
                ),
            },
            DpService::ImRead { slot, number, class_2 } => {
                let index = FunctionIndex::im(*number).unwrap_or(FunctionIndex::IM0);
                match class_2 {
                    true => MasterRequest::Ms2 { to, service: Ms2Service::Call { slot: *slot, index } },
                    false => MasterRequest::Call { to, slot: *slot, index },
                }
            }
            DpService::Ms2Initiate { .. }
            | DpService::Ms2Read { .. }
            | DpService::Ms2Write { .. }
            | DpService::Ms2Abort { .. } => MasterRequest::Ms2 { to, service: ms2_service(service) },
        })
    }

    /// The value of an expression as a byte; `what` is the sentence for one that has none.
    fn octet_of(&self, program: &Program, what: &'static str) -> Result<u8, BoxedStepError> {
        let number = program.eval(&self.world.view(), &HistoryState::default()).as_whole();
        let octet = number.and_then(|number| u8::try_from(number).ok());
        octet.ok_or_else(|| StepError::other(FailureCause::Suite, Verdict::Error, what))
    }

    fn module_in_use(&self) -> Option<&DeviceModule> {
        self.world.manual.device.modules.get(self.module?)
    }

    /// The number of output bytes of the module in use.
    fn output_octets(&self) -> usize {
        let submodules = self.module_in_use().into_iter().flat_map(|module| &module.submodules);
        let lengths = submodules.filter_map(|&index| self.world.manual.device.submodules.get(index));
        lengths.map(|of| usize::from(of.output_octets)).sum()
    }

    /// Closes the MS2 connection of a master, if one stands.
    pub(super) fn close_ms2(&mut self, second: bool) {
        let master = self.world.stations.master(usize::from(second));
        if let Some(to) = master.and_then(ProfibusMaster::ms2_slave) {
            let service = Ms2Service::Abort { subnet: Subnet::NO, reason: BY_THE_USER };
            // A slave that does not answer closes the connection by itself after its timeout.
            let _ = self.ask_master(second, MasterRequest::Ms2 { to, service });
        }
    }

    /// Sends a frame that is damaged on purpose, and judges what comes within the slot time if the suite says what is right.
    pub(super) fn broken_frame(
        &mut self,
        word: &str,
        answer: Option<&'a AnswerMatcher>,
        second: bool,
        to: Option<&'a Program>,
    ) -> StepResult {
        let to = self.station_of(to)?;
        let Some(broken) = DamagedDpFrame::by_word(word) else {
            return Err(StepError::other(FailureCause::Suite, Verdict::Error, format!("Unknown broken frame {word}.")));
        };
        let before = self.world.trace.len();
        self.may_end = true;
        let (octets, received) = match self.ask_master(second, MasterRequest::Broken { to, broken })? {
            MasterOutcome::Broken { octets, answer } => (octets, answer),
            outcome => return Err(unexpected(&outcome)),
        };
        let is_sent = (before + 1..=self.world.trace.len())
            .any(|number| self.world.trace.get(number).is_some_and(|frame| frame.octets == octets));
        if is_sent {
            self.world.mark_damaged(before, &octets);
        } else {
            self.world.expect_broken(&octets);
        }
        let Some(answer) = answer else { return Ok(()) };
        let mut replies = Vec::new();
        if let Some(octets) = received.data() {
            replies.push((AnswerPart::Bytes, ReceivedReply::Value(Value::bytes(octets))));
        }
        let whole = match received {
            DataLinkAnswer::None => ReceivedReply::Silent("no answer within the slot time".into()),
            received => reply(&received),
        };
        replies.push((AnswerPart::Whole, whole));
        self.world.scene.notebook_mut().answers = replies;
        self.judge_answer(answer)
    }
}
