//! `send` on PROFINET: one request, sent once and unchanged.

use super::station::dcp;
use super::{IDENTIFY, startup, unexpected, web};
use crate::trial::RunningTrial;
use crate::trial::access::is_request;
use crate::trial::step_error::{StepError, StepResult, other_bus};
use controllers::profinet_io::{
    ControllerOutcome, ControllerRequest, DamagedIoFrame, DcpResetForm, IdentifyBy, IoRecordOutcome, RecordAddress,
};
use expression::{HistoryState, Value};
use judge::answer::ReceivedReply;
use results::outcome::FailureCause;
use results::verdict::Verdict;
use station::Duration;
use std::net::Ipv4Addr;
use suite::model::{AcyclicService, AnswerMatcher, AnswerPart, IdentifyTarget};
use wire::profinet::status::AbortReason;

/// How long the answer to an Identify by name or alias may take.
const NAME_WAIT: Duration = Duration::from_secs(1);
/// How long answers to an ARP request are collected.
const ARP_WAIT: Duration = Duration::from_millis(500);

impl<'a> RunningTrial<'a> {
    /// Sends a service and judges its answer.
    pub(super) fn send(
        &mut self,
        service: &'a AcyclicService,
        answer: Option<&'a AnswerMatcher>,
        second: bool,
    ) -> StepResult {
        let to = self.mac;
        let request = match service {
            AcyclicService::DcpReset { suboption: 5, .. } => {
                ControllerRequest::DcpReset { to, reset: DcpResetForm::Factory }
            }
            AcyclicService::DcpReset { qualifier, .. } => {
                ControllerRequest::DcpReset { to, reset: DcpResetForm::ToFactory { qualifier: *qualifier } }
            }
            AcyclicService::DcpSignal => ControllerRequest::DcpSignal { to },
            AcyclicService::DcpIdentify(sought) => {
                let by = match sought {
                    IdentifyTarget::All => IdentifyBy::All,
                    IdentifyTarget::OwnName => IdentifyBy::Name(self.environment.name.clone().into_bytes()),
                    IdentifyTarget::Name(name) => IdentifyBy::Name(name.clone().into_bytes()),
                    IdentifyTarget::Alias(alias) => IdentifyBy::Alias(alias.clone().into_bytes()),
                };
                let wait = if by == IdentifyBy::All { IDENTIFY } else { NAME_WAIT };
                ControllerRequest::Identify { by, wait }
            }
            AcyclicService::RecordRead { slot, subslot, index, length } => {
                self.record_read(second, self.target(*slot, *subslot, *index), *length)
            }
            AcyclicService::RecordWrite { slot, subslot, index, bytes } => {
                ControllerRequest::Write { target: self.target(*slot, *subslot, *index), data: bytes.clone() }
            }
            AcyclicService::Lldp { chassis, port } => {
                ControllerRequest::Lldp { chassis: chassis.clone().into_bytes(), port: port.clone().into_bytes() }
            }
            AcyclicService::Arp { ip, probe } => {
                let target = match ip.as_ref().map(|ip| ip.eval(&self.world.view(), &HistoryState::default())) {
                    None => self.station_ip.address,
                    Some(Value::Address(octets)) => Ipv4Addr::from(octets),
                    Some(_) => {
                        return Err(StepError::other(
                            FailureCause::Suite,
                            Verdict::Error,
                            "The requested IP address is unknown.",
                        ));
                    }
                };
                ControllerRequest::Arp { target, probe: *probe, wait: ARP_WAIT }
            }
            AcyclicService::Abort => ControllerRequest::Abort { code: AbortReason::RELEASE_RECEIVED },
            AcyclicService::Broken(word) => {
                let broken =
                    DamagedIoFrame::TABLE.iter().find(|(_, known, _)| known == word).map(|(broken, ..)| *broken);
                let Some(broken) = broken else {
                    return Err(StepError::other(
                        FailureCause::Suite,
                        Verdict::Error,
                        format!("Unknown broken frame {word}."),
                    ));
                };
                ControllerRequest::Broken { broken, partner: None }
            }
            AcyclicService::Dp(_) => return Err(other_bus()),
            AcyclicService::HttpGet { page } => self.page_request(*page, None)?,
            AcyclicService::HttpPost { page, fields } => self.page_request(*page, Some(fields))?,
        };
        self.may_end |=
            matches!(service, AcyclicService::DcpReset { .. } | AcyclicService::Abort | AcyclicService::Broken(_));
        self.renamed |= match service {
            AcyclicService::DcpReset { .. } => true,
            // A device that does not detect the damage accepts the name.
            AcyclicService::Broken(word) => word.starts_with("dcp") && !self.world.segment.is_model(),
            _ => false,
        };
        let before = self.world.trace.len();
        let outcome = match service {
            AcyclicService::RecordRead { .. } | AcyclicService::RecordWrite { .. } => {
                self.ask_in_connection(second, request)?
            }
            _ => self.ask(second, request)?,
        };
        if let ControllerOutcome::Broken(broken) = &outcome {
            // On a real wire the frame was observed already, on the virtual one it has not arrived yet.
            if self.world.segment.is_model() {
                self.world.expect_broken(broken);
            } else {
                self.world.mark_broken(before, |frame| frame.starts_with(broken) || broken.starts_with(frame));
            }
        }
        let is_refused = !matches!(answer, None | Some(AnswerMatcher::Accepted));
        if is_refused && matches!(service, AcyclicService::RecordWrite { .. }) {
            self.world.mark_broken(before, is_request);
        }
        let mut replies = Vec::new();
        let whole = match &outcome {
            ControllerOutcome::Dcp(outcome) => dcp(outcome),
            ControllerOutcome::Stations(stations) if stations.iter().any(|station| station.mac == to) => {
                ReceivedReply::Accepted
            }
            ControllerOutcome::Owners(owners) if owners.contains(&to) => ReceivedReply::Accepted,
            ControllerOutcome::Owners(_) => ReceivedReply::Silent("the device did not answer".into()),
            ControllerOutcome::Stations(_) => ReceivedReply::Silent("the device did not answer".into()),
            ControllerOutcome::Record(outcome) => {
                if let IoRecordOutcome::Accepted { data } = outcome {
                    replies.push((AnswerPart::Bytes, ReceivedReply::Value(Value::bytes(data.as_slice()))));
                }
                startup::record(outcome, matches!(service, AcyclicService::RecordWrite { .. }))
            }
            ControllerOutcome::Page(outcome) => {
                let (whole, parts) = web::replies(outcome);
                replies.extend(parts);
                whole
            }
            // These have no answer, so they say nothing about the device.
            ControllerOutcome::Sent | ControllerOutcome::Ended(_) | ControllerOutcome::Broken(_) => return Ok(()),
            outcome => return Err(unexpected(outcome)),
        };
        replies.push((AnswerPart::Whole, whole));
        self.world.scene.notebook_mut().answers = replies;
        self.judge_answer(answer.unwrap_or(&AnswerMatcher::Accepted))
    }

    fn target(&self, slot: u16, subslot: u16, index: u16) -> RecordAddress {
        let submodules = &self.world.manual.device.submodules;
        let known = submodules.iter().find(|submodule| (submodule.slot, submodule.subslot) == (slot, subslot));
        RecordAddress { api: known.map_or(0, |submodule| submodule.api), slot, subslot, index }
    }
}
