//! A scripted device.
//!
//! It answers like a conforming device unless the hook of the test replaces an answer. It builds all frames with the codecs of
//! `wire`, which are tested against golden bytes from independent sources.

use super::{ALARM_REFERENCE, DEVICE, DEVICE_IP, DEVICE_PORT, NAME, OUTPUT_FRAME_ID, OWN, OWN_IP};
use core::net::SocketAddrV4;
use core::time::Duration;
use station::{Outbox, Station, Time};
use wire::datagram::arp::{Arp, ArpOperation};
use wire::datagram::{Datagram, write_udp};
use wire::ethernet::{EtherType, FrameHeader, Mac, Vlan, pad};
use wire::octets::{Append, ByteOrder};
use wire::profinet::alarm::{AlarmPriority, RtaBody, RtaHeader, RtaKind, RtaPdu};
use wire::profinet::blocks::connect::{
    AlarmCrBlockRes, ArBlockRes, Connect, ConnectContent, IocrBlockReq, IocrBlockRes,
};
use wire::profinet::blocks::control::{ControlBlock, ControlBlocks};
use wire::profinet::blocks::record::{ReadRequest, ReadResponse, WriteRequest, WriteResponse};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockError, BlockInfo, Dcp, DcpBlock, DcpValue, Element, ServiceId, ServiceType};
use wire::profinet::rpc::{
    Assembled, Flags1, NdrRequest, NdrResponse, ObjectUuid, Opnum, PORT, PacketType, Reassembler, RpcHeader, RpcPdu,
    Uuid,
};
use wire::profinet::rt::{ApduStatus, CyclicFrame, DataStatus, FrameId, IoxS};
use wire::profinet::status::{AbortReason, PnioStatus};

/// The reaction of the device to a call.
pub enum Reaction {
    /// The answer of a conforming device.
    Usual,
    /// No answer.
    Silence,
    /// A negative answer with this status.
    Refuse(PnioStatus),
    /// These PDUs instead of the answer.
    Instead(Vec<Vec<u8>>),
    /// The answer of a conforming device with these blocks.
    Blocks(Vec<u8>),
}

/// A call as a hook receives it: header, blocks, and how many calls of this operation preceded it, including repetitions.
pub struct ReceivedCall<'a> {
    pub header: &'a RpcHeader,
    pub blocks: &'a [u8],
    pub before: usize,
}

type CallHook = Box<dyn FnMut(&ReceivedCall) -> Reaction>;

/// What the device knows of its AR.
pub struct ScriptedAr {
    pub uuid: Uuid,
    pub session_key: u16,
    pub controller_reference: u16,
    pub input: IocrBlockReq,
}

pub struct ScriptedDevice {
    pub name: Vec<u8>,
    pub ip: IpParameter,
    pub set_ip_error: BlockError,
    pub hook: CallHook,
    pub order: Option<ByteOrder>,
    pub ar: Option<ScriptedAr>,
    pub calls: Vec<Opnum>,
    pub cyclic: bool,
    pub iops: IoxS,
    pub sends_ready: bool,
    pub ready_answered: Option<PnioStatus>,
    /// Whether a request in fragments gets its facks.
    pub facks: bool,
    /// Answers to the device's own calls, and other PDUs that are not requests: header and body.
    pub replies: Vec<(RpcHeader, Vec<u8>)>,
    pub parameter: Vec<u8>,
    pub outputs: Vec<Vec<u8>>,
    pub rta: Vec<(AlarmPriority, RtaPdu)>,
    reassembler: Reassembler,
    next_cyclic: Time,
}

impl ScriptedDevice {
    pub fn new() -> ScriptedDevice {
        ScriptedDevice {
            name: NAME.into(),
            ip: IpParameter::NONE,
            set_ip_error: BlockError::OK,
            hook: Box::new(|_| Reaction::Usual),
            order: Some(ByteOrder::Big),
            ar: None,
            calls: Vec::new(),
            cyclic: true,
            iops: IoxS::GOOD,
            sends_ready: true,
            ready_answered: None,
            facks: true,
            replies: Vec::new(),
            parameter: Vec::new(),
            outputs: Vec::new(),
            rta: Vec::new(),
            reassembler: Reassembler::new(2, 1 << 16),
            next_cyclic: Time::ZERO,
        }
    }

    fn dcp(&mut self, from: Mac, dcp: &Dcp, out: &mut Outbox) {
        let identity = |device: &ScriptedDevice| {
            vec![
                DcpBlock::report(BlockInfo::NONE, DcpValue::NameOfStation(device.name.clone())),
                DcpBlock::report(BlockInfo::IP_SET, DcpValue::IpParameter(device.ip)),
                DcpBlock::report(BlockInfo::NONE, DcpValue::DeviceId { vendor_id: 0x012A, device_id: 7 }),
                DcpBlock::report(BlockInfo::NONE, DcpValue::DeviceRole { role: 1, reserved: 0 }),
                DcpBlock::report(BlockInfo::NONE, DcpValue::Vendor(b"Encoder".to_vec())),
            ]
        };
        if dcp.service_type != ServiceType::REQUEST {
            return;
        }
        let answer = match dcp.service_id {
            ServiceId::IDENTIFY => {
                let fits = dcp.blocks().iter().all(|block| match &block.value {
                    DcpValue::NameOfStation(name) => *name == self.name,
                    value => *value == DcpValue::AllSelector,
                });
                if !fits {
                    return;
                }
                identity(self)
            }
            ServiceId::GET => identity(self),
            _ => {
                let mut outcomes = Vec::new();
                for block in dcp.blocks() {
                    let element = block.value.element();
                    match (&block.value, self.set_ip_error) {
                        (DcpValue::IpParameter(ip), BlockError::OK) => self.ip = *ip,
                        (DcpValue::NameOfStation(name), _) => self.name.clone_from(name),
                        _ => {}
                    }
                    let error = if element == Element::IP_PARAMETER { self.set_ip_error } else { BlockError::OK };
                    outcomes.push(DcpBlock::outcome(element, error));
                }
                outcomes
            }
        };
        out.push_with(|octets| dcp.response(answer).write_frame(from, DEVICE, octets));
    }

    pub fn send_pdu(&self, pdu: &[u8], port: u16, out: &mut Outbox) {
        let from = (DEVICE, SocketAddrV4::new(DEVICE_IP, PORT));
        let to = (OWN, SocketAddrV4::new(OWN_IP, port));
        out.push_with(|octets| write_udp(from, to, pdu, octets).expect("it fits in a frame"));
    }

    fn answer(&self, header: &RpcHeader, status: PnioStatus, blocks: &[u8]) -> Vec<u8> {
        let order = self.order.unwrap_or(header.order());
        let body = NdrResponse::body(order, status, 4096, blocks);
        RpcPdu::new(header.answer(PacketType::RESPONSE, order), &body).to_vec()
    }

    fn rpc(&mut self, datagram: &Datagram, out: &mut Outbox) {
        let pdu = RpcPdu::parse(datagram.payload).expect("the controller sends whole PDUs");
        let port = datagram.source.port();
        if pdu.header.packet_type != PacketType::REQUEST {
            self.replies.push((pdu.header, pdu.body.to_vec()));
        }
        match pdu.header.packet_type {
            PacketType::REQUEST => {}
            PacketType::RESPONSE => {
                let (ndr, _) = NdrResponse::parse(pdu.header.order(), pdu.body).expect("an NDR header");
                self.ready_answered = Some(ndr.status);
                return;
            }
            _ => return,
        }
        let Assembled::Whole(body) = self.reassembler.take(&pdu) else {
            let header =
                RpcHeader { fragment: pdu.header.fragment, ..pdu.header.answer(PacketType::FACK, ByteOrder::Big) };
            if self.facks {
                self.send_pdu(&RpcPdu::new(header, &[]).to_vec(), port, out);
            }
            return;
        };
        let (_, blocks) = NdrRequest::parse(pdu.header.order(), &body).expect("an NDR header");
        let opnum = pdu.header.opnum;
        let before = self.calls.iter().filter(|known| **known == opnum).count();
        self.calls.push(opnum);
        let reaction = (self.hook)(&ReceivedCall { header: &pdu.header, blocks, before });
        let (status, blocks) = match reaction {
            Reaction::Silence => return,
            Reaction::Instead(pdus) => {
                pdus.iter().for_each(|pdu| self.send_pdu(pdu, port, out));
                return;
            }
            Reaction::Refuse(status) => (status, Vec::new()),
            Reaction::Blocks(answer) => {
                self.carry_out(opnum, blocks);
                (PnioStatus::OK, answer)
            }
            Reaction::Usual => (PnioStatus::OK, self.carry_out(opnum, blocks)),
        };
        let answer = self.answer(&pdu.header, status, &blocks);
        self.send_pdu(&answer, port, out);
        if opnum == Opnum::CONTROL && status.is_ok() && self.sends_ready {
            self.application_ready(out);
        }
    }

    /// Carries out a call like a conforming device; returns the blocks of its answer.
    pub fn carry_out(&mut self, opnum: Opnum, blocks: &[u8]) -> Vec<u8> {
        let mut answer = Vec::new();
        match opnum {
            Opnum::CONNECT => return self.connect(blocks).to_vec(),
            Opnum::WRITE => {
                let request = WriteRequest::parse(blocks).expect("a Write");
                match request.records() {
                    None => {
                        self.parameter.clone_from(&request.data);
                        WriteResponse::to(&request, PnioStatus::OK).write(&mut answer);
                    }
                    Some(records) => {
                        let records = records.expect("whole records");
                        let inner = records.iter().map(|record| WriteResponse::to(record, PnioStatus::OK)).collect();
                        WriteResponse::to_multiple(&request, inner).iter().for_each(|one| one.write(&mut answer));
                    }
                }
            }
            Opnum::READ | Opnum::READ_IMPLICIT => {
                let request = ReadRequest::parse(blocks).expect("a Read");
                ReadResponse::to(&request, self.parameter.clone()).write(&mut answer);
            }
            _ => {
                let control = ControlBlocks::parse(blocks).expect("a control block");
                if opnum == Opnum::RELEASE {
                    self.ar = None;
                }
                return ControlBlocks::from(control.block.done()).to_vec();
            }
        }
        answer
    }

    fn connect(&mut self, blocks: &[u8]) -> Connect {
        let request = Connect::parse(blocks).expect("a Connect");
        let ar = request.ar_req().expect("an ARBlockReq");
        let mut answer = vec![ConnectContent::ArRes(ArBlockRes {
            ar_type: ar.ar_type,
            ar_uuid: ar.ar_uuid,
            session_key: ar.session_key,
            cm_responder_mac_add: DEVICE,
            responder_udp_rt_port: 0x8892,
        })];
        let iocrs: Vec<IocrBlockReq> = request.iocr_requests().cloned().collect();
        if let [input, output] = iocrs.as_slice() {
            let alarms = request.alarm_cr_req().expect("an AlarmCRBlockReq");
            self.ar = Some(ScriptedAr {
                uuid: ar.ar_uuid,
                session_key: ar.session_key,
                controller_reference: alarms.local_alarm_reference,
                input: input.clone(),
            });
            for (iocr, frame_id) in [(input, input.frame_id), (output, OUTPUT_FRAME_ID)] {
                let iocr_reference = iocr.iocr_reference;
                answer.push(ConnectContent::IocrRes(IocrBlockRes {
                    iocr_type: iocr.iocr_type,
                    iocr_reference,
                    frame_id,
                }));
            }
            answer.push(ConnectContent::AlarmCrRes(AlarmCrBlockRes {
                alarm_cr_type: 1,
                local_alarm_reference: ALARM_REFERENCE,
                max_alarm_data_length: 200,
            }));
        }
        Connect::of(answer)
    }

    pub fn application_ready(&self, out: &mut Outbox) {
        let ar = self.ar.as_ref().expect("an AR");
        let control = ControlBlocks::from(ControlBlock::application_ready(ar.uuid, ar.session_key));
        self.call(3, &control.to_vec(), ByteOrder::Little, out);
    }

    /// A call of the device to the controller with its own activity UUID.
    pub fn call(&self, sequence: u32, blocks: &[u8], order: ByteOrder, out: &mut Outbox) {
        let body = NdrRequest::body(order, 4096, blocks);
        self.send_call(&RpcPdu::new(call_header(sequence, order), &body).to_vec(), out);
    }

    /// Sends a PDU to the controller's server from the device's own port.
    pub fn send_call(&self, pdu: &[u8], out: &mut Outbox) {
        let from = (DEVICE, SocketAddrV4::new(DEVICE_IP, DEVICE_PORT));
        let to = (OWN, SocketAddrV4::new(OWN_IP, PORT));
        out.push_with(|octets| write_udp(from, to, pdu, octets).expect("it fits in a frame"));
    }

    pub fn send_rta(&self, priority: AlarmPriority, pdu: &RtaPdu, out: &mut Outbox) {
        out.push_with(|octets| {
            FrameHeader::new(OWN, DEVICE, EtherType::PROFINET).tagged(Vlan::RT).write(octets);
            octets.put_u16(priority.frame_id());
            pdu.write(octets);
            pad(octets, 0);
        });
    }

    /// Sends an ERR-RTA that ends the AR.
    pub fn abort(&self, reason: AbortReason, out: &mut Outbox) {
        let ar = self.ar.as_ref().expect("an AR");
        let header = RtaHeader::new(RtaKind::ERR, ar.controller_reference, ALARM_REFERENCE, 0xFFFF, 0xFFFE);
        let body = RtaBody::Error { status: PnioStatus::abort(reason), more: Vec::new() };
        self.send_rta(AlarmPriority::Low, &RtaPdu { header, body }, out);
    }

    fn cyclic_frame(&self, now: Time, out: &mut Outbox) {
        let Some(ar) = &self.ar else { return };
        let mut data = vec![0; ar.input.data_length.into()];
        for api in &ar.input.apis {
            for object in &api.io_data_objects {
                let octets = if object.slot_number == 1 && object.subslot_number == 2 { 12 } else { 0 };
                data[usize::from(object.frame_offset) + octets] = self.iops.0;
            }
            for iocs in &api.iocs {
                data[usize::from(iocs.frame_offset)] = IoxS::GOOD.0;
            }
        }
        let status = ApduStatus {
            cycle_counter: (now.as_nanos() / 31_250) as u16,
            data_status: DataStatus::NORMAL,
            transfer_status: 0,
        };
        out.push_with(|octets| {
            FrameHeader::new(OWN, DEVICE, EtherType::PROFINET).tagged(Vlan::RT).write(octets);
            CyclicFrame { frame_id: FrameId(ar.input.frame_id), data: &data, status, padding: &[] }.write(octets);
        });
    }

    fn profinet(&mut self, header: &FrameHeader, payload: &[u8], out: &mut Outbox) {
        let frame_id = FrameId::peek(payload).expect("a frame id");
        if let Some(priority) = AlarmPriority::from_frame_id(frame_id.0) {
            self.rta.push((priority, RtaPdu::parse(&payload[2..]).expect("an RTA PDU")));
        } else if frame_id.is_cyclic() {
            self.outputs.push(payload.to_vec());
        } else if let Ok(dcp) = Dcp::parse(payload) {
            self.dcp(header.source, &dcp, out);
        }
    }
}

/// The header of a call of the device to the controller.
pub fn call_header(sequence: u32, order: ByteOrder) -> RpcHeader {
    RpcHeader {
        object: ObjectUuid { instance: 1, device_id: 1, vendor_id: 0xFFFF }.into(),
        interface: Uuid::CONTROLLER_INTERFACE,
        activity: Uuid([0xDE; 16]),
        flags1: Flags1::IDEMPOTENT,
        opnum: Opnum::CONTROL,
        sequence,
        ..RpcHeader::new(PacketType::REQUEST, order)
    }
}

impl Station for ScriptedDevice {
    fn receive(&mut self, _now: Time, frame: &[u8], out: &mut Outbox) {
        let (header, payload) = FrameHeader::parse(frame).expect("a frame");
        if header.destination != DEVICE && !header.destination.is_group() {
            return;
        }
        match header.ether_type {
            EtherType::PROFINET => self.profinet(&header, payload, out),
            EtherType::ARP => {
                let arp = Arp::parse(payload).expect("ARP");
                if arp.operation == ArpOperation::REQUEST && arp.target_ip == self.ip.address {
                    out.push_with(|octets| arp.reply(DEVICE).write_frame(octets));
                }
            }
            EtherType::IPV4 => self.rpc(&Datagram::parse(frame).expect("a datagram"), out),
            _ => {}
        }
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        if now >= self.next_cyclic {
            self.next_cyclic = now + Duration::from_millis(2);
            if self.cyclic {
                self.cyclic_frame(now, out);
            }
        }
    }

    fn deadline(&self) -> Option<Time> {
        Some(self.next_cyclic)
    }
}
