//! Hand-made frames of one PROFINET connection between a controller and a device.
//!
//! Nothing is answered automatically, so that a test can omit, repeat and damage any frame.

pub mod bus;

use station::{Duration, Time};
use std::net::{Ipv4Addr, SocketAddrV4};
use virtual_wire::PcapngWriter;
use virtual_wire::capture::LinkType;
use wire::datagram::write_udp;
use wire::ethernet::{EtherType, FrameHeader, Mac, Vlan, pad};
use wire::octets::ByteOrder;
use wire::profinet::alarm::{
    AlarmNotification, AlarmPriority, AlarmSpecifier, AlarmType, RtaBody, RtaHeader, RtaKind, RtaPdu,
};
use wire::profinet::blocks::connect::*;
use wire::profinet::blocks::control::{ControlBlock, ControlBlocks};
use wire::profinet::blocks::record::{ReadRequest, ReadResponse, RecordHeader, WriteRequest, WriteResponse};
use wire::profinet::rpc::{NdrRequest, NdrResponse, ObjectUuid, Opnum, PORT, PacketType, RpcHeader, Uuid, fragments};
use wire::profinet::rt::{ApduStatus, CyclicFrame, DataStatus, FrameId};
use wire::profinet::status::PnioStatus;

pub const CONTROLLER: Mac = Mac([2, 0, 0, 0, 0, 1]);
pub const DEVICE: Mac = Mac([2, 0, 0, 0, 1, 0]);
pub const AR: Uuid = Uuid([7; 16]);
/// The frame id of both directions; real connections also use the same one.
pub const FRAME_ID: u16 = 0x8000;
/// 2 ms: send clock 32, reduction 2.
pub const CYCLE: Duration = Duration::from_millis(2);
/// Three cycles: watchdog factor 3.
pub const WATCHDOG: Duration = Duration::from_millis(6);

/// A submodule of the connection; `input` and `output` are lengths in bytes.
#[derive(Clone, Copy)]
pub struct HandmadeSubmodule {
    pub api: u32,
    pub slot: u16,
    pub subslot: u16,
    pub module: u32,
    pub ident: u32,
    pub input: u16,
    pub output: u16,
}

/// A device access point without data, 4 bytes in and out, 12 bytes in.
pub const SUBMODULES: [HandmadeSubmodule; 3] = [
    HandmadeSubmodule { api: 0, slot: 0, subslot: 1, module: 1, ident: 1, input: 0, output: 0 },
    HandmadeSubmodule { api: 0x3D00, slot: 1, subslot: 2, module: 5, ident: 81, input: 4, output: 4 },
    HandmadeSubmodule { api: 0, slot: 2, subslot: 1, module: 6, ident: 7, input: 12, output: 0 },
];

/// Offsets of the data of slot 1 in the frames of [`SUBMODULES`]: the layout has no gaps and follows the order of the submodules.
pub const INPUT: usize = 1;
pub const OUTPUT: usize = 1;

/// Frames with their times.
pub struct ConnectionFrames {
    pub submodules: Vec<HandmadeSubmodule>,
    pub ids: (u16, u16),
    pub device: Mac,
    pub ar: Uuid,
    pub order: ByteOrder,
    pub now: Time,
    pub frames: Vec<(Time, Vec<u8>)>,
    /// Sequence number of the next RPC call of the controller and of the device.
    pub sequence: [u32; 2],
    pub counter: [u16; 2],
    pub activity: u8,
    pub most_fragment: usize,
}

impl ConnectionFrames {
    /// A connection to the XAC77 with telegram 81 and the idents of its suite, which are invented.
    pub fn to_xac77() -> ConnectionFrames {
        let one = |slot, subslot, api, ident, input, output| HandmadeSubmodule {
            api,
            slot,
            subslot,
            module: 1,
            ident,
            input,
            output,
        };
        let submodules = vec![one(0, 1, 0, 1, 0, 0), one(1, 1, 0x3D00, 2, 0, 0), one(1, 2, 0x3D00, 81, 12, 4)];
        ConnectionFrames { submodules, ids: (0x0239, 0x0001), ..ConnectionFrames::new() }
    }

    pub fn new() -> ConnectionFrames {
        ConnectionFrames {
            submodules: SUBMODULES.to_vec(),
            ids: (0x1234, 0x0005),
            device: DEVICE,
            ar: AR,
            order: ByteOrder::Little,
            now: Time::from_nanos(1_000_000_000),
            frames: Vec::new(),
            sequence: [0; 2],
            counter: [0; 2],
            activity: 1,
            most_fragment: 1_400,
        }
    }

    pub fn pass(&mut self, time: Duration) -> &mut ConnectionFrames {
        self.now += time;
        self
    }

    pub fn push(&mut self, frame: Vec<u8>) -> usize {
        self.frames.push((self.now, frame));
        self.now += Duration::from_micros(10);
        self.frames.len()
    }

    /// Repeats the last frame after a pause.
    pub fn again(&mut self, after: Duration) -> usize {
        let frame = self.frames.last().expect("a frame").1.clone();
        self.now += after;
        self.push(frame)
    }

    /// The frames with number (from 1) and time, as the trackers take them.
    pub fn iter(&self) -> impl Iterator<Item = (u64, Time, &[u8])> {
        self.frames.iter().enumerate().map(|(index, (time, frame))| (index as u64 + 1, *time, &frame[..]))
    }

    /// The frames as a capture file.
    pub fn capture(&self) -> Vec<u8> {
        let mut writer = PcapngWriter::new(Vec::new(), "made by a test").expect("a vector takes all");
        let interface = writer.interface("wire", LinkType::ETHERNET).expect("a vector takes all");
        for (_, time, frame) in self.iter() {
            writer.packet(interface, time, frame, None).expect("a vector takes all");
        }
        writer.finish().expect("a vector takes all")
    }

    fn header(&self, from_device: bool, kind: PacketType, opnum: Opnum, sequence: u32) -> RpcHeader {
        let (vendor_id, device_id) = self.ids;
        RpcHeader {
            object: ObjectUuid { instance: 1, device_id, vendor_id }.into(),
            interface: if from_device { Uuid::CONTROLLER_INTERFACE } else { Uuid::DEVICE_INTERFACE },
            activity: Uuid([self.activity + u8::from(from_device); 16]),
            sequence,
            opnum,
            ..RpcHeader::new(kind, self.order)
        }
    }

    /// An RPC request; `calls` is the caller: 0 the controller, 1 the device.
    pub fn request(&mut self, calls: usize, opnum: Opnum, blocks: &[u8]) -> usize {
        let header = self.header(calls == 1, PacketType::REQUEST, opnum, self.sequence[calls]);
        let body = NdrRequest::body(self.order, 4096, blocks);
        self.send(header, &body, calls == 1)
    }

    /// The response to the last request. The next request has the next sequence number.
    pub fn response(&mut self, calls: usize, opnum: Opnum, status: PnioStatus, blocks: &[u8]) -> usize {
        let header = self.header(calls == 1, PacketType::RESPONSE, opnum, self.sequence[calls]);
        self.sequence[calls] += 1;
        let body = NdrResponse::body(self.order, status, 4096, blocks);
        self.send(header, &body, calls == 0)
    }

    pub fn reject(&mut self, calls: usize, opnum: Opnum, status: u32) -> usize {
        let header = self.header(calls == 1, PacketType::REJECT, opnum, self.sequence[calls]);
        self.sequence[calls] += 1;
        let body = match self.order {
            ByteOrder::Little => status.to_le_bytes(),
            ByteOrder::Big => status.to_be_bytes(),
        };
        self.send(header, &body, calls == 0)
    }

    fn send(&mut self, header: RpcHeader, body: &[u8], by_device: bool) -> usize {
        let controller = (CONTROLLER, SocketAddrV4::new(Ipv4Addr::new(192, 168, 0, 1), PORT));
        // A device answers from an ephemeral port.
        let device =
            (self.device, SocketAddrV4::new(Ipv4Addr::new(192, 168, 0, 10), if by_device { 49_153 } else { PORT }));
        let (source, destination) = if by_device { (device, controller) } else { (controller, device) };
        let mut number = 0;
        for payload in fragments(&header, body, self.most_fragment) {
            let mut frame = Vec::new();
            write_udp(source, destination, &payload, &mut frame).expect("a fragment fits");
            number = self.push(frame);
        }
        number
    }

    pub fn connect_blocks(&self, ar_type: ArType) -> Connect {
        let mut contents = vec![ConnectContent::ArReq(ArBlockReq {
            ar_type,
            ar_uuid: self.ar,
            session_key: 1,
            cm_initiator_mac_add: CONTROLLER,
            cm_initiator_object_uuid: ObjectUuid { instance: 1, device_id: 1, vendor_id: 0xFEED }.into(),
            ar_properties: ArProperties(0x11),
            cm_initiator_activity_timeout_factor: 600,
            initiator_udp_rt_port: PORT,
            cm_initiator_station_name: b"controller-1".to_vec(),
        })];
        if ar_type == ArType::IOSAR {
            return Connect::of(contents);
        }
        for (iocr_type, reference) in [(IocrType::INPUT, 1), (IocrType::OUTPUT, 2)] {
            contents.push(ConnectContent::IocrReq(IocrBlockReq {
                iocr_type,
                iocr_reference: reference,
                lt: EtherType::PROFINET.0,
                iocr_properties: RtClass::RT_CLASS_2.into(),
                data_length: 40,
                frame_id: if reference == 1 { FRAME_ID } else { 0xFFFF },
                send_clock_factor: 32,
                reduction_ratio: 2,
                phase: 1,
                frame_send_offset: 0xFFFF_FFFF,
                watchdog_factor: 3,
                data_hold_factor: 3,
                iocr_tag_header: 0xC000,
                apis: self.apis(iocr_type),
                ..IocrBlockReq::default()
            }));
        }
        for one in &self.submodules {
            let kind = match (one.input, one.output) {
                (0, 0) => SubmoduleType::NO_IO,
                (_, 0) => SubmoduleType::INPUT,
                (0, _) => SubmoduleType::OUTPUT,
                _ => SubmoduleType::INPUT_OUTPUT,
            };
            let mut data_descriptions = Vec::new();
            if kind != SubmoduleType::OUTPUT {
                data_descriptions.push(DataDescription::input(one.input));
            }
            if one.output > 0 {
                data_descriptions.push(DataDescription::output(one.output));
            }
            let submodule = ExpectedSubmodule {
                subslot_number: one.subslot,
                submodule_ident_number: one.ident,
                submodule_properties: kind.into(),
                data_descriptions,
            };
            let module = ExpectedModule {
                api: one.api,
                slot_number: one.slot,
                module_ident_number: one.module,
                module_properties: 0,
                submodules: vec![submodule],
            };
            contents.push(ConnectContent::ExpectedSubmodule(ExpectedSubmoduleBlockReq { modules: vec![module] }));
        }
        contents.push(ConnectContent::AlarmCrReq(AlarmCrBlockReq {
            alarm_cr_type: 1,
            lt: EtherType::PROFINET.0,
            rta_timeout_factor: 1,
            rta_retries: 3,
            local_alarm_reference: 3,
            max_alarm_data_length: 200,
            ..AlarmCrBlockReq::default()
        }));
        Connect::of(contents)
    }

    /// A layout without gaps: data and status of each submodule in order; the consumer status follows.
    fn apis(&self, direction: IocrType) -> Vec<IocrApi> {
        let mut apis: Vec<IocrApi> = Vec::new();
        let mut at = 0;
        for one in &self.submodules {
            let object = FrameObject { slot_number: one.slot, subslot_number: one.subslot, frame_offset: at };
            let (own, other) =
                if direction == IocrType::INPUT { (one.input, one.output) } else { (one.output, one.input) };
            let index = apis.iter().position(|api| api.api == one.api).unwrap_or_else(|| {
                apis.push(IocrApi { api: one.api, ..IocrApi::default() });
                apis.len() - 1
            });
            let is_provider = own > 0 || (other == 0 && direction == IocrType::INPUT);
            let is_consumer = other > 0 || (own == 0 && direction == IocrType::OUTPUT);
            if is_provider {
                apis[index].io_data_objects.push(object);
                at += own + 1;
            }
            if is_consumer {
                apis[index].iocs.push(FrameObject { frame_offset: at, ..object });
                at += 1;
            }
        }
        apis
    }

    pub fn connect_request(&mut self) -> usize {
        let blocks = self.connect_blocks(ArType::IOCAR_SINGLE).to_vec();
        self.request(0, Opnum::CONNECT, &blocks)
    }

    pub fn connect_response(&mut self) -> usize {
        let mut contents = vec![ConnectContent::ArRes(ArBlockRes {
            ar_type: ArType::IOCAR_SINGLE,
            ar_uuid: self.ar,
            session_key: 1,
            cm_responder_mac_add: self.device,
            responder_udp_rt_port: PORT,
        })];
        for (iocr_type, iocr_reference) in [(IocrType::INPUT, 1), (IocrType::OUTPUT, 2)] {
            contents.push(ConnectContent::IocrRes(IocrBlockRes { iocr_type, iocr_reference, frame_id: FRAME_ID }));
        }
        contents.push(ConnectContent::AlarmCrRes(AlarmCrBlockRes {
            alarm_cr_type: 1,
            local_alarm_reference: 9,
            max_alarm_data_length: 200,
        }));
        self.response(0, Opnum::CONNECT, PnioStatus::OK, &Connect::of(contents).to_vec())
    }

    /// A complete start-up: Connect, end of parameters, ApplicationReady.
    pub fn start(&mut self) -> &mut ConnectionFrames {
        self.connect_request();
        self.connect_response();
        self.end_parameters();
        self.ready();
        self
    }

    pub fn end_parameters(&mut self) -> usize {
        let block = ControlBlock::prm_end(self.ar, 1);
        self.request(0, Opnum::CONTROL, &ControlBlocks::from(block).to_vec());
        self.response(0, Opnum::CONTROL, PnioStatus::OK, &ControlBlocks::from(block.done()).to_vec())
    }

    pub fn ready(&mut self) -> usize {
        let block = ControlBlock::application_ready(self.ar, 1);
        let number = self.request(1, Opnum::CONTROL, &ControlBlocks::from(block).to_vec());
        self.response(1, Opnum::CONTROL, PnioStatus::OK, &ControlBlocks::from(block.done()).to_vec());
        number
    }

    pub fn release(&mut self) -> usize {
        let block = ControlBlock::release(self.ar, 1);
        let number = self.request(0, Opnum::RELEASE, &ControlBlocks::from(block).to_vec());
        self.response(0, Opnum::RELEASE, PnioStatus::OK, &ControlBlocks::from(block.done()).to_vec());
        number
    }

    /// Writes records, each in its own call or, with `several`, all in one; `answers` are in the same order.
    pub fn write(&mut self, records: &[(u16, u16, u16, &[u8])], several: bool, answers: &[PnioStatus]) -> usize {
        let one = |(number, (slot, subslot, index, data)): (usize, &(u16, u16, u16, &[u8]))| {
            let header = RecordHeader {
                seq_number: number as u16,
                ar_uuid: self.ar,
                slot_number: *slot,
                subslot_number: *subslot,
                index: *index,
                ..RecordHeader::default()
            };
            WriteRequest::of(header, data.to_vec())
        };
        let requests: Vec<WriteRequest> = records.iter().enumerate().map(one).collect();
        let responses: Vec<WriteResponse> =
            requests.iter().zip(answers).map(|(request, status)| WriteResponse::to(request, *status)).collect();
        let (mut blocks, mut answer) = (Vec::new(), Vec::new());
        if several {
            let all = WriteRequest::multiple(self.ar, 9, &requests);
            all.write(&mut blocks);
            WriteResponse::to_multiple(&all, responses).iter().for_each(|response| response.write(&mut answer));
            self.request(0, Opnum::WRITE, &blocks);
            return self.response(0, Opnum::WRITE, PnioStatus::OK, &answer);
        }
        let mut number = 0;
        for (request, response) in requests.iter().zip(responses) {
            let (mut blocks, mut answer) = (Vec::new(), Vec::new());
            request.write(&mut blocks);
            response.write(&mut answer);
            self.request(0, Opnum::WRITE, &blocks);
            number = self.response(0, Opnum::WRITE, response.status, &answer);
        }
        number
    }

    /// Reads a record; `Err` is the status with which the device refuses it.
    pub fn read(&mut self, index: u16, answer: Result<&[u8], PnioStatus>, implicit: bool) -> usize {
        let ar_uuid = if implicit { Uuid::NIL } else { self.ar };
        let header = RecordHeader { ar_uuid, slot_number: 1, subslot_number: 2, index, ..RecordHeader::default() };
        let request = ReadRequest { header, ..ReadRequest::default() };
        let opnum = if implicit { Opnum::READ_IMPLICIT } else { Opnum::READ };
        let (mut blocks, mut response) = (Vec::new(), Vec::new());
        request.write(&mut blocks);
        self.request(0, opnum, &blocks);
        ReadResponse::to(&request, answer.unwrap_or_default().to_vec()).write(&mut response);
        self.response(0, opnum, answer.err().unwrap_or(PnioStatus::OK), &response)
    }

    /// A tagged cyclic frame with 40 bytes of data that begin with `data`. The cycle counter advances by one cycle.
    pub fn cyclic(&mut self, by_device: bool, data: &[u8]) -> usize {
        let counter = &mut self.counter[usize::from(by_device)];
        *counter = counter.wrapping_add(64);
        let frame = cyclic(by_device, *counter, data);
        self.push(frame)
    }

    /// `cycles` cycles with a frame in each direction.
    pub fn exchange(&mut self, cycles: usize) -> &mut ConnectionFrames {
        for _ in 0..cycles {
            self.cyclic(false, &[]);
            self.cyclic(true, &[]);
            self.now += CYCLE - Duration::from_micros(20);
        }
        self
    }

    /// An RTA frame with low alarm priority.
    pub fn rta(&mut self, by_device: bool, kind: RtaKind, sequence: u16, body: RtaBody) -> usize {
        let (source, destination) = if by_device { (self.device, CONTROLLER) } else { (CONTROLLER, self.device) };
        let (own, other) = if by_device { (9, 3) } else { (3, 9) };
        let mut frame = Vec::new();
        FrameHeader::new(destination, source, EtherType::PROFINET).tagged(Vlan::LOW_ALARM).write(&mut frame);
        frame.extend_from_slice(&AlarmPriority::Low.frame_id().to_be_bytes());
        RtaPdu { header: RtaHeader::new(kind, other, own, sequence, 0xFFFE), body }.write(&mut frame);
        pad(&mut frame, 0);
        self.push(frame)
    }

    pub fn alarm(&mut self, sequence: u16) -> usize {
        self.rta(true, RtaKind::DATA, sequence, alarm(sequence))
    }

    pub fn abort(&mut self, by_device: bool, status: PnioStatus) -> usize {
        self.rta(by_device, RtaKind::ERR, 0, RtaBody::Error { status, more: Vec::new() })
    }
}

/// A diagnosis alarm without items.
pub fn alarm(sequence: u16) -> RtaBody {
    RtaBody::Notification(AlarmNotification {
        priority: AlarmPriority::Low,
        alarm_type: AlarmType::DIAGNOSIS,
        api: 0,
        slot: 1,
        subslot: 2,
        module_ident: 5,
        submodule_ident: 81,
        specifier: AlarmSpecifier::new(sequence, 0),
        items: Vec::new(),
    })
}

/// A cyclic frame.
pub fn cyclic(by_device: bool, counter: u16, data: &[u8]) -> Vec<u8> {
    let (source, destination) = if by_device { (DEVICE, CONTROLLER) } else { (CONTROLLER, DEVICE) };
    let mut area = data.to_vec();
    area.resize(40, 0x80);
    let mut frame = Vec::new();
    FrameHeader::new(destination, source, EtherType::PROFINET).tagged(Vlan::RT).write(&mut frame);
    let status = ApduStatus { cycle_counter: counter, data_status: DataStatus::NORMAL, transfer_status: 0 };
    CyclicFrame { frame_id: FrameId(FRAME_ID), data: &area, status, padding: &[] }.write(&mut frame);
    frame
}
