//! `send` on PROFIBUS: one service, sent once and unchanged.

use super::access::record;
use super::{reply, unexpected};
use crate::trial::Run;
use crate::trial::trouble::{Done, Facts, Trouble};
use controllers::profibus_dp::{Broken, Outcome, RecordOutcome, Request};
use expression::{Program, State, Value};
use judge::answer::Reply;
use results::outcome::Blame;
use results::verdict::Verdict;
use suite::model::{Answer, AnswerPart, DpService};
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::fdl::BROADCAST;
use wire::profibus::global_control::{ControlCommand, GlobalControl};
use wire::profibus::sap::{MasterSap, SlaveSap};

impl<'a> Run<'a> {
    /// Sends a service and judges its answer.
    pub(super) fn serve(
        &mut self,
        service: &'a DpService,
        answer: Option<&'a Answer>,
        second: bool,
        to: Option<&'a Program>,
    ) -> Done {
        let all = matches!(service, DpService::GlobalControl { .. }) && to.is_none();
        let to = if all { BROADCAST } else { self.station_of(to)? };
        let request = self.service_request(service, to)?;
        self.may_end |= matches!(
            service,
            DpService::SetPrm(_)
                | DpService::ChkCfg(_)
                | DpService::DataExchange(_)
                | DpService::SetSlaveAddress { .. }
        );
        let mut replies = Vec::new();
        let whole = match self.ask_master(second, request)? {
            Outcome::Answer(answer) => {
                if let Some(octets) = answer.data() {
                    replies.push((AnswerPart::Bytes, Reply::Value(Value::bytes(octets))));
                }
                reply(&answer)
            }
            Outcome::Record(outcome) => {
                if let RecordOutcome::Accepted { data } = &outcome {
                    replies.push((AnswerPart::Bytes, Reply::Value(Value::bytes(data.as_slice()))));
                }
                record(&outcome)
            }
            // These have no answer, so they say nothing about the device.
            Outcome::Sent => return Ok(()),
            outcome => return Err(unexpected(&outcome)),
        };
        replies.push((AnswerPart::Whole, whole));
        self.world.scene.notebook_mut().answers = replies;
        self.judge_answer(answer.unwrap_or(&Answer::Accepted))
    }

    fn service_request(&mut self, service: &DpService, to: u8) -> Result<Request, Trouble> {
        Ok(match service {
            DpService::SetSlaveAddress { new, ident, lock, length } => {
                let number = new.eval(&self.world.view(), &State::default()).as_whole();
                let Some(address) = number.and_then(|number| u8::try_from(number).ok()) else {
                    let what = "The new station address is unknown.";
                    return Err(Facts::other(Blame::Suite, Verdict::Error, what));
                };
                self.slave.tell(address);
                let set = SetSlaveAddress { address, ident: *ident, no_change: *lock, kept: Vec::new() };
                match length {
                    None => Request::SetSlaveAddress { to, set },
                    Some(length) => {
                        let mut octets = Vec::new();
                        set.write(&mut octets);
                        octets.resize(*length, 0);
                        let (dsap, ssap) = (Some(SlaveSap::SET_SLAVE_ADDRESS.0), Some(MasterSap::MS0.0));
                        Request::Service { to, dsap, ssap, octets }
                    }
                }
            }
            DpService::GlobalControl { command, groups } => {
                let control = GlobalControl { command: ControlCommand(*command), groups: *groups };
                Request::GlobalControl { to, control }
            }
            DpService::FdlStatus => Request::FdlStatus { to },
            DpService::SlaveDiag => Request::Diagnosis { to },
            DpService::GetCfg => Request::Configuration { to },
            DpService::SetPrm(octets) => Request::SetPrm { to, octets: octets.clone() },
            DpService::ChkCfg(octets) => Request::CheckConfiguration { to, octets: octets.clone() },
            DpService::DataExchange(octets) => Request::DataExchange { to, octets: octets.clone() },
            DpService::ReadInputs => Request::ReadInputs { to },
            DpService::ReadOutputs => Request::ReadOutputs { to },
            DpService::Read { slot, index, length } => {
                Request::Read { to, slot: *slot, index: *index, length: *length }
            }
            DpService::Write { slot, index, bytes } => {
                Request::Write { to, slot: *slot, index: *index, data: bytes.clone() }
            }
        })
    }

    /// Sends a frame that is damaged on purpose.
    pub(super) fn broken_frame(&mut self, word: &str, second: bool, to: Option<&'a Program>) -> Done {
        let to = self.station_of(to)?;
        let Some(broken) = Broken::by_word(word) else {
            return Err(Facts::other(Blame::Suite, Verdict::Error, format!("Unknown broken frame {word}.")));
        };
        let before = self.world.trace.len();
        self.may_end = true;
        match self.ask_master(second, Request::Broken { to, broken })? {
            Outcome::Broken(octets) => {
                let is_sent = (before + 1..=self.world.trace.len())
                    .any(|number| self.world.trace.get(number).is_some_and(|frame| frame.octets == octets));
                if is_sent {
                    self.world.mark_broken(before, |frame| frame == octets);
                } else {
                    self.world.expect_broken(&octets);
                }
                Ok(())
            }
            outcome => Err(unexpected(&outcome)),
        }
    }
}
