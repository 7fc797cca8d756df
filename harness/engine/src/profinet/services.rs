//! `send` on PROFINET: one request, sent once and unchanged.

use super::station::dcp;
use super::{IDENTIFY, startup, unexpected, web};
use crate::trial::RunningTrial;
use crate::trial::access::is_request;
use crate::trial::step_error::{BoxedStepError, StepError, StepResult, other_bus};
use controllers::profinet_io::{
    ControllerOutcome, ControllerRequest, DamagedIoFrame, DcpResetForm, FragmentedSending, IdentifyBy, IoRecordOutcome,
    LoadKind, NetLoad, PingRequest, RawActivity, RawAnswer, RawBody, RawCall, RawDcpRequest, RawObject, RecordAddress,
    StartUpRecord,
};
use expression::{HistoryState, Value};
use judge::answer::{NegativeResponse, ReceivedReply};
use results::outcome::FailureCause;
use results::verdict::Verdict;
use station::Duration;
use std::net::Ipv4Addr;
use suite::model::{
    AcyclicService, AnswerMatcher, AnswerPart, IdentifyTarget, IpFragments, PingService, RecordPlace, RpcService,
    SnmpService, SoughtStation,
};
use wire::datagram::{Datagram, Ipv4};
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::octets::ByteOrder;
use wire::profinet::dcp::{BlockError, Dcp, DcpValue, ServiceId, ServiceType};
use wire::profinet::rpc::{NdrResponse, ObjectUuid, Opnum, PacketType, Uuid};
use wire::profinet::status::AbortReason;
use wire::snmp::{SnmpMessage, VarBind};

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
            AcyclicService::DcpIdentify(IdentifyTarget::Filters { octets, delay, wait }) => {
                ControllerRequest::Identify {
                    by: IdentifyBy::Filters { octets: octets.clone(), delay: *delay },
                    wait: *wait,
                }
            }
            AcyclicService::DcpIdentify(sought) => {
                let by = match sought {
                    IdentifyTarget::Who(who) => self.sought(*who),
                    IdentifyTarget::Name(name) => IdentifyBy::Name(name.clone().into_bytes()),
                    IdentifyTarget::Alias(alias) => IdentifyBy::Alias(alias.clone().into_bytes()),
                    IdentifyTarget::Filters { .. } => IdentifyBy::All,
                };
                let wait = if matches!(by, IdentifyBy::All | IdentifyBy::Values(_)) { IDENTIFY } else { NAME_WAIT };
                ControllerRequest::Identify { by, wait }
            }
            AcyclicService::RecordRead { at, length, implicit: true } => self.implicit_read(self.target(*at), *length),
            AcyclicService::RecordRead { at, length, .. } => self.record_read(second, self.target(*at), *length),
            AcyclicService::RecordWrite { at, bytes } => {
                ControllerRequest::Write { target: self.target(*at), data: bytes.clone() }
            }
            AcyclicService::RecordsWrite(records) => {
                let record = |(at, data): &(RecordPlace, Vec<u8>)| StartUpRecord {
                    target: self.target(*at),
                    data: data.clone(),
                };
                ControllerRequest::WriteMultiple(records.iter().map(record).collect())
            }
            AcyclicService::DcpGet { elements } => {
                let request = RawDcpRequest { service: ServiceId::GET, octets: elements.clone() };
                ControllerRequest::RawDcp { to, request }
            }
            AcyclicService::DcpSet { blocks } => {
                let request = RawDcpRequest { service: ServiceId::SET, octets: blocks.clone() };
                ControllerRequest::RawDcp { to, request }
            }
            AcyclicService::Rpc(rpc) => {
                let (partner, object) = self.callee();
                ControllerRequest::RawCall { partner, call: call_of(rpc, object) }
            }
            AcyclicService::Load { kind, count, gap } => {
                let unknown = || {
                    let what = format!("There are no frames `{kind}` for a net load.");
                    StepError::other(FailureCause::Suite, Verdict::Error, what)
                };
                let kind = LoadKind::by_word(kind).ok_or_else(unknown)?;
                ControllerRequest::Load(NetLoad { kind, count: *count, gap: *gap })
            }
            AcyclicService::Ping(ping) => {
                let ip = match ping.ip.as_ref().map(|ip| ip.eval(&self.world.view(), &HistoryState::default())) {
                    None => None,
                    Some(Value::Address(octets)) => Some(Ipv4Addr::from(octets)),
                    Some(_) => return Err(unknown_address()),
                };
                ControllerRequest::Ping { partner: self.callee().0, ping: ping_of(ping, ip) }
            }
            AcyclicService::Snmp(snmp) => {
                self.check_snmp()?;
                let SnmpService { octets, is_message } = snmp.clone();
                ControllerRequest::Snmp { partner: self.callee().0, octets, gets_id: is_message }
            }
            AcyclicService::Lldp { chassis, port } => {
                ControllerRequest::Lldp { chassis: chassis.clone().into_bytes(), port: port.clone().into_bytes() }
            }
            AcyclicService::Arp { ip, probe } => {
                let target = match ip.as_ref().map(|ip| ip.eval(&self.world.view(), &HistoryState::default())) {
                    None => self.station_ip.address,
                    Some(Value::Address(octets)) => Ipv4Addr::from(octets),
                    Some(_) => return Err(unknown_address()),
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
        self.may_end |= matches!(service, AcyclicService::DcpSet { .. } | AcyclicService::Rpc(_));
        self.renamed |= match service {
            AcyclicService::DcpReset { .. } => true,
            AcyclicService::DcpSet { blocks } => !blocks.is_empty(),
            // A device that does not detect the damage accepts the name.
            AcyclicService::Broken(word) => word.starts_with("dcp") && !self.world.segment.is_virtual(),
            _ => false,
        };
        let before = self.world.trace.len();
        let outcome = match service {
            AcyclicService::RecordRead { .. }
            | AcyclicService::RecordWrite { .. }
            | AcyclicService::RecordsWrite(_) => self.ask_in_connection(second, request)?,
            _ => self.ask(second, request)?,
        };
        if let ControllerOutcome::Broken(broken) = &outcome {
            // On a real wire the frame was observed already, on the virtual one it has not arrived yet.
            if self.world.segment.is_virtual() {
                self.world.expect_broken(broken);
            } else {
                self.world.mark_broken(before, |frame| frame.starts_with(broken) || broken.starts_with(frame));
            }
        }
        let is_refused = !matches!(answer, None | Some(AnswerMatcher::Accepted));
        let is_free =
            matches!(service, AcyclicService::Rpc(_) | AcyclicService::DcpGet { .. } | AcyclicService::DcpSet { .. });
        if is_free
            || is_refused && matches!(service, AcyclicService::RecordWrite { .. } | AcyclicService::RecordsWrite(_))
        {
            self.world.mark_broken(before, is_request);
        }
        if matches!(service, AcyclicService::Load { .. }) {
            self.world.mark_broken(before, is_dcp_broadcast);
        }
        let is_in_pieces = match service {
            AcyclicService::Ping(ping) => ping.is_damaged || ping.ip_fragments.sent.is_some(),
            AcyclicService::Rpc(rpc) => rpc.ip_fragments.is_some(),
            _ => false,
        };
        if is_in_pieces {
            self.world.mark_broken(before, is_of_broken_packet);
        }
        if matches!(service, AcyclicService::Snmp(snmp) if !snmp.is_message) {
            self.world.mark_broken(before, is_to_agent);
        }
        let mut replies = Vec::new();
        let whole = match &outcome {
            ControllerOutcome::Dcp(outcome) => dcp(outcome),
            ControllerOutcome::DcpAnswer(answer) => {
                replies.push((AnswerPart::Bytes, octets(Dcp::block_octets(answer.blocks()))));
                self.took_address(service);
                dcp_answer(answer)
            }
            ControllerOutcome::Called(Ok(answer)) => {
                replies.push((AnswerPart::Bytes, octets(big_endian(answer))));
                ReceivedReply::Accepted
            }
            ControllerOutcome::Snmp(Ok(response)) => {
                replies.push((AnswerPart::Bytes, octets(of_response(response))));
                let number = response.bindings.last().and_then(VarBind::number).map(Value::whole);
                replies.extend(number.map(|number| (AnswerPart::Number, ReceivedReply::Value(number))));
                ReceivedReply::Accepted
            }
            ControllerOutcome::Ping(Ok(reply)) => {
                replies.push((AnswerPart::Bytes, octets(vec![u8::from(reply.has_same_data)])));
                ReceivedReply::Accepted
            }
            ControllerOutcome::Ping(Err(wait))
            | ControllerOutcome::Snmp(Err(wait))
            | ControllerOutcome::Called(Err(wait)) => ReceivedReply::Silent(wait.to_string()),
            ControllerOutcome::Records(outcomes) => {
                replies.push((AnswerPart::Bytes, octets(statuses(outcomes))));
                let answers = outcomes.iter().map(|outcome| startup::record(outcome, true));
                answers.into_iter().find(|reply| *reply != ReceivedReply::Accepted).unwrap_or(ReceivedReply::Accepted)
            }
            ControllerOutcome::Stations(stations) if stations.iter().any(|station| station.mac == to) => {
                let own = stations.iter().find(|station| station.mac == to);
                let blocks = own.map_or(&[][..], |station| &station.blocks);
                replies.push((AnswerPart::Bytes, octets(Dcp::block_octets(blocks))));
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

    fn target(&self, at: RecordPlace) -> RecordAddress {
        let RecordPlace { api, slot, subslot, index } = at;
        let submodules = &self.world.manual.device.submodules;
        let known = submodules.iter().find(|submodule| (submodule.slot, submodule.subslot) == (slot, subslot));
        let api = api.unwrap_or(known.map_or(0, |submodule| submodule.api));
        RecordAddress { api, slot, subslot, index }
    }

    /// The filters of an Identify for the stations that a word stands for.
    fn sought(&self, who: SoughtStation) -> IdentifyBy {
        let identity = &self.world.manual.device;
        let (vendor_id, device_id) = identity.ids().unwrap_or_default();
        let id = |vendor_id, device_id| DcpValue::DeviceId { vendor_id, device_id };
        let own_type = || {
            DcpValue::Vendor(identity.profinet().map_or("", |facts| &facts.identity.station_type).as_bytes().to_vec())
        };
        let other_type = || DcpValue::Vendor(b"NO SUCH TYPE".to_vec());
        IdentifyBy::Values(match who {
            SoughtStation::All => return IdentifyBy::All,
            SoughtStation::OwnName => return IdentifyBy::Name(self.environment.name.clone().into_bytes()),
            SoughtStation::OwnId => vec![id(vendor_id, device_id)],
            SoughtStation::OtherVendor => vec![id(vendor_id ^ 1, device_id)],
            SoughtStation::OtherDevice => vec![id(vendor_id, device_id ^ 1)],
            SoughtStation::OwnType => vec![own_type()],
            SoughtStation::OtherType => vec![other_type()],
            SoughtStation::OwnIdOtherType => vec![id(vendor_id, device_id), other_type()],
        })
    }

    /// Keeps the address that the device has accepted, since it is called there from now on.
    fn took_address(&mut self, service: &AcyclicService) {
        let AcyclicService::DcpSet { blocks } = service else { return };
        // Option 1, suboption 2, the length of a qualifier and an address.
        if let [1, 2, 0, 14, _, _, address @ ..] = blocks.as_slice()
            && let Some([a, b, c, d]) = address.first_chunk()
            && [*a, *b, *c, *d] != [0; 4]
        {
            self.last_ip = Ipv4Addr::new(*a, *b, *c, *d);
        }
    }
}

fn octets(octets: Vec<u8>) -> ReceivedReply {
    ReceivedReply::Value(Value::bytes(octets.as_slice()))
}

/// The reply in a DCP response: the first element that it refuses, if there is one.
fn dcp_answer(answer: &Dcp) -> ReceivedReply {
    let refused = answer.blocks().iter().find_map(|block| match block.value {
        DcpValue::Response { error, .. } if error != BlockError::OK => Some(NegativeResponse::Dcp(error.0)),
        _ => None,
    });
    match (answer.service_type, refused) {
        (ServiceType::NOT_SUPPORTED, _) => ReceivedReply::Refused(NegativeResponse::NotSupported),
        (_, Some(refused)) => ReceivedReply::Refused(refused),
        (_, None) => ReceivedReply::Accepted,
    }
}

/// The kind and the body of a PDU; its status and its NDR header are big-endian, whatever the byte order of the PDU.
fn big_endian(answer: &RawAnswer) -> Vec<u8> {
    let words = match answer.packet {
        PacketType::RESPONSE => NdrResponse::LENGTH / 4,
        PacketType::REJECT | PacketType::FAULT => 1,
        _ => 0,
    };
    let mut pdu = vec![answer.packet.0];
    for (at, word) in answer.body.chunks(4).enumerate() {
        let is_swapped = answer.order == ByteOrder::Little && at < words;
        if is_swapped { pdu.extend(word.iter().rev()) } else { pdu.extend(word) }
    }
    pdu
}

/// The PNIO statuses of several records, four bytes each; a record without an answer has none.
fn statuses(outcomes: &[IoRecordOutcome]) -> Vec<u8> {
    let status = |outcome: &IoRecordOutcome| match outcome {
        IoRecordOutcome::Accepted { .. } => Some([0; 4]),
        IoRecordOutcome::Refused(status) => Some(u32::from(*status).to_be_bytes()),
        IoRecordOutcome::Failed(_) => None,
    };
    outcomes.iter().filter_map(status).flatten().collect()
}

/// Whether a frame is a DCP frame to all stations, which no right one is.
fn is_dcp_broadcast(frame: &[u8]) -> bool {
    FrameHeader::parse(frame)
        .is_ok_and(|(header, _)| header.ether_type == EtherType::PROFINET && header.destination == Mac([0xFF; 6]))
}

fn unknown_address() -> BoxedStepError {
    StepError::other(FailureCause::Suite, Verdict::Error, "The requested IP address is unknown.")
}

/// The echo request that a suite describes.
fn ping_of(ping: &PingService, ip: Option<Ipv4Addr>) -> PingRequest {
    PingRequest {
        ip,
        data: (0..ping.length).map(|number| number as u8).collect(),
        is_damaged: ping.is_damaged,
        fragments: fragments_of(&ping.ip_fragments),
    }
}

fn fragments_of(fragments: &IpFragments) -> FragmentedSending {
    FragmentedSending { octets: fragments.octets, sent: fragments.sent.clone() }
}

/// Whether a frame is an IPv4 packet with a wrong checksum inside, or a fragment.
fn is_of_broken_packet(frame: &[u8]) -> bool {
    Ipv4::of_frame(frame).is_some_and(|(_, packet)| packet.is_fragment() || packet.protocol == Ipv4::ICMP)
}

/// Whether a frame has a datagram to an SNMP agent.
fn is_to_agent(frame: &[u8]) -> bool {
    Datagram::parse(frame).is_ok_and(|datagram| datagram.destination.port() == wire::snmp::PORT)
}

/// Kind, error-status and error-index of a response, and its objects; the lengths are the shortest.
fn of_response(response: &SnmpMessage) -> Vec<u8> {
    let mut octets = vec![response.kind.0, response.error_status as u8, response.error_index as u8];
    response.bindings.iter().for_each(|binding| binding.put(&mut octets));
    octets
}

/// The PDU that a suite describes.
fn call_of(rpc: &RpcService, device: ObjectUuid) -> RawCall {
    RawCall {
        packet: PacketType(rpc.packet),
        object: rpc.object.map_or(RawObject::Device(device), |object| RawObject::Other(Uuid(object))),
        interface: Uuid(rpc.interface),
        interface_version: rpc.interface_version,
        opnum: Opnum(rpc.opnum),
        activity: if rpc.same_activity { RawActivity::Last } else { RawActivity::New },
        sequence: rpc.sequence,
        server_boot: rpc.server_boot,
        order: if rpc.little_endian { ByteOrder::Little } else { ByteOrder::Big },
        body: match rpc.is_whole_body {
            true => RawBody::Octets(rpc.body.clone()),
            false => RawBody::Blocks(rpc.body.clone()),
        },
        fragment: rpc.fragment,
        sent: rpc.sent.clone(),
        ip: rpc.ip_fragments.as_ref().map(fragments_of),
    }
}
