//! `send` on PROFINET: one request, sent once and unchanged.

use super::station::dcp;
use super::{IDENTIFY, startup, unexpected, web};
use crate::trial::Run;
use crate::trial::access::is_request;
use crate::trial::trouble::{Done, Facts, other_bus};
use controllers::profinet_io::{Broken, IdentifyBy, Outcome, RecordOutcome, Request, Reset, Target};
use expression::{State, Value};
use judge::answer::Reply;
use results::outcome::Blame;
use results::verdict::Verdict;
use station::Duration;
use std::net::Ipv4Addr;
use suite::model::{Answer, AnswerPart, Service, Sought};
use wire::profinet::status::AbortReason;

/// How long the answer to an Identify by name or alias may take.
const NAME_WAIT: Duration = Duration::from_secs(1);
/// How long answers to an ARP request are collected.
const ARP_WAIT: Duration = Duration::from_millis(500);

impl<'a> Run<'a> {
    /// Sends a service and judges its answer.
    pub(super) fn send(&mut self, service: &'a Service, answer: Option<&'a Answer>, second: bool) -> Done {
        let to = self.mac;
        let request = match service {
            Service::DcpReset { suboption: 5, .. } => Request::DcpReset { to, reset: Reset::Factory },
            Service::DcpReset { qualifier, .. } => {
                Request::DcpReset { to, reset: Reset::ToFactory { qualifier: *qualifier } }
            }
            Service::DcpSignal => Request::DcpSignal { to },
            Service::DcpIdentify(sought) => {
                let by = match sought {
                    Sought::All => IdentifyBy::All,
                    Sought::OwnName => IdentifyBy::Name(self.place.name.clone().into_bytes()),
                    Sought::Name(name) => IdentifyBy::Name(name.clone().into_bytes()),
                    Sought::Alias(alias) => IdentifyBy::Alias(alias.clone().into_bytes()),
                };
                let wait = if by == IdentifyBy::All { IDENTIFY } else { NAME_WAIT };
                Request::Identify { by, wait }
            }
            Service::RecordRead { slot, subslot, index, length } => {
                self.record_read(second, self.target(*slot, *subslot, *index), *length)
            }
            Service::RecordWrite { slot, subslot, index, bytes } => {
                Request::Write { target: self.target(*slot, *subslot, *index), data: bytes.clone() }
            }
            Service::Lldp { chassis, port } => {
                Request::Lldp { chassis: chassis.clone().into_bytes(), port: port.clone().into_bytes() }
            }
            Service::Arp { ip, probe } => {
                let target = match ip.as_ref().map(|ip| ip.eval(&self.world.view(), &State::default())) {
                    None => self.station_ip.address,
                    Some(Value::Address(octets)) => Ipv4Addr::from(octets),
                    Some(_) => {
                        return Err(Facts::other(Blame::Suite, Verdict::Error, "The requested IP address is unknown."));
                    }
                };
                Request::Arp { target, probe: *probe, wait: ARP_WAIT }
            }
            Service::Abort => Request::Abort { code: AbortReason::RELEASE_RECEIVED },
            Service::Broken(word) => {
                let broken = Broken::TABLE.iter().find(|(_, known, _)| known == word).map(|(broken, ..)| *broken);
                let Some(broken) = broken else {
                    return Err(Facts::other(Blame::Suite, Verdict::Error, format!("Unknown broken frame {word}.")));
                };
                Request::Broken { broken, partner: None }
            }
            Service::Dp(_) => return Err(other_bus()),
            Service::HttpGet { page } => self.page_request(*page, None)?,
            Service::HttpPost { page, fields } => self.page_request(*page, Some(fields))?,
        };
        self.may_end |= matches!(service, Service::DcpReset { .. } | Service::Abort | Service::Broken(_));
        self.renamed |= match service {
            Service::DcpReset { .. } => true,
            // A device that does not detect the damage accepts the name.
            Service::Broken(word) => word.starts_with("dcp") && !self.world.segment.is_model(),
            _ => false,
        };
        let before = self.world.trace.len();
        let outcome = match service {
            Service::RecordRead { .. } | Service::RecordWrite { .. } => self.ask_in_connection(second, request)?,
            _ => self.ask(second, request)?,
        };
        if let Outcome::Broken(broken) = &outcome {
            // On a real wire the frame was observed already, on the virtual one it has not arrived yet.
            if self.world.segment.is_model() {
                self.world.expect_broken(broken);
            } else {
                self.world.mark_broken(before, |frame| frame.starts_with(broken) || broken.starts_with(frame));
            }
        }
        let is_refused = !matches!(answer, None | Some(Answer::Accepted));
        if is_refused && matches!(service, Service::RecordWrite { .. }) {
            self.world.mark_broken(before, is_request);
        }
        let mut replies = Vec::new();
        let whole = match &outcome {
            Outcome::Dcp(outcome) => dcp(outcome),
            Outcome::Stations(stations) if stations.iter().any(|station| station.mac == to) => Reply::Accepted,
            Outcome::Owners(owners) if owners.contains(&to) => Reply::Accepted,
            Outcome::Owners(_) => Reply::Silent("the device did not answer".into()),
            Outcome::Stations(_) => Reply::Silent("the device did not answer".into()),
            Outcome::Record(outcome) => {
                if let RecordOutcome::Accepted { data } = outcome {
                    replies.push((AnswerPart::Bytes, Reply::Value(Value::bytes(data.as_slice()))));
                }
                startup::record(outcome, matches!(service, Service::RecordWrite { .. }))
            }
            Outcome::Page(outcome) => {
                let (whole, parts) = web::replies(outcome);
                replies.extend(parts);
                whole
            }
            // These have no answer, so they say nothing about the device.
            Outcome::Sent | Outcome::Ended(_) | Outcome::Broken(_) => return Ok(()),
            outcome => return Err(unexpected(outcome)),
        };
        replies.push((AnswerPart::Whole, whole));
        self.world.scene.notebook_mut().answers = replies;
        self.judge_answer(answer.unwrap_or(&Answer::Accepted))
    }

    fn target(&self, slot: u16, subslot: u16, index: u16) -> Target {
        let submodules = &self.world.manual.device.submodules;
        let known = submodules.iter().find(|submodule| (submodule.slot, submodule.subslot) == (slot, subslot));
        Target { api: known.map_or(0, |submodule| submodule.api), slot, subslot, index }
    }
}
