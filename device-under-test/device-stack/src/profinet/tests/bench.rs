//! A scripted controller: it sends the frames of a test, collects received frames, and answers ARP.

pub use super::blocks::*;
use super::toy::ToyIoApplication;
use crate::attached::Attached;
use crate::profinet::{IoDevice, StackHooks};
use alloc::string::String;
use alloc::vec::Vec;
use core::net::{Ipv4Addr, SocketAddrV4};
use station::{Duration, Outbox, Station, Time};
use std::io::Write;
use std::process::{Command, Stdio};
use wire::datagram::arp::{Arp, ArpOperation};
use wire::datagram::{Datagram, write_udp};
use wire::ethernet::{EtherType, FrameHeader, Mac, Vlan};
use wire::octets::{Append, ByteOrder};
use wire::profinet::blocks::connect::Connect;
use wire::profinet::blocks::control::{ControlBlock, ControlBlocks};
use wire::profinet::dcp::Dcp;
use wire::profinet::rpc::{
    Flags1, NdrRequest, NdrResponse, ObjectUuid, Opnum, PacketType, Reassembler, RpcHeader, RpcPdu, Uuid, fragments,
};
use wire::profinet::rt::{ApduStatus, CyclicFrame, DataStatus, FrameId};
use wire::profinet::status::PnioStatus;

pub const CONTROLLER: Mac = Mac([2, 0, 0, 0, 0, 1]);
pub const DEVICE: Mac = Mac([2, 0, 0, 0, 1, 0]);
pub const CONTROLLER_IP: Ipv4Addr = Ipv4Addr::new(192, 168, 0, 1);
pub const DEVICE_IP: Ipv4Addr = Ipv4Addr::new(192, 168, 0, 10);
pub const AR: Uuid = Uuid([7; 16]);
pub const CYCLE: Duration = Duration::from_millis(2);
/// How long the bench waits for answers to a DCP request: longer than one step of the response delay, 10 ms.
const DCP_WAIT: Duration = Duration::from_millis(20);

/// A device, a clock, and a log of all frames.
pub struct StackBench {
    pub device: IoDevice<ToyIoApplication>,
    pub now: Time,
    pub order: ByteOrder,
    pub frames: Vec<Vec<u8>>,
    log: Vec<(Time, bool, Vec<u8>)>,
    sequence: u32,
    counter: u16,
}

impl StackBench {
    pub fn new() -> StackBench {
        StackBench::of(ToyIoApplication::new())
    }

    /// A bench with this application.
    pub fn of(toy: ToyIoApplication) -> StackBench {
        StackBench::with(toy, Attached::NONE)
    }

    /// A bench with this application and a stack with deviations.
    pub fn with(toy: ToyIoApplication, hooks: Attached<dyn StackHooks>) -> StackBench {
        StackBench {
            device: IoDevice::new(toy, DEVICE, hooks),
            now: Time::from_nanos(1_000_000),
            order: ByteOrder::Big,
            frames: Vec::new(),
            log: Vec::new(),
            sequence: 0,
            counter: 0,
        }
    }

    fn collect(&mut self, out: &Outbox) {
        for frame in out.frames() {
            self.log.push((self.now, false, frame.to_vec()));
            self.frames.push(frame.to_vec());
            let arp = FrameHeader::parse(frame).ok().filter(|(header, _)| header.ether_type == EtherType::ARP);
            if let Some(request) = arp.and_then(|(_, payload)| Arp::parse(payload).ok())
                && (request.operation, request.target_ip) == (ArpOperation::REQUEST, CONTROLLER_IP)
            {
                let mut answer = Vec::new();
                request.reply(CONTROLLER).write_frame(&mut answer);
                self.send(&answer);
            }
        }
    }

    /// Sends a frame to the device.
    pub fn send(&mut self, frame: &[u8]) {
        self.log.push((self.now, true, frame.to_vec()));
        let mut out = Outbox::new();
        self.device.receive(self.now, frame, &mut out);
        self.collect(&out);
    }

    /// Advances time and wakes the device at each deadline.
    pub fn run(&mut self, duration: Duration) {
        let end = self.now + duration;
        let mut wakes = 0;
        while let Some(due) = self.device.deadline().filter(|due| *due <= end) {
            self.now = self.now.max(due);
            let mut out = Outbox::new();
            self.device.wake(self.now, &mut out);
            self.collect(&out);
            wakes += 1;
            assert!(wakes < 100_000, "the deadline of the device does not advance: {}", self.now);
        }
        self.now = end;
    }

    /// The frames received since the last call.
    pub fn take(&mut self) -> Vec<Vec<u8>> {
        core::mem::take(&mut self.frames)
    }

    /// Sends a DCP request and returns the answers within [`DCP_WAIT`].
    pub fn dcp(&mut self, request: &Dcp, destination: Mac) -> Vec<Dcp> {
        self.take();
        let mut frame = Vec::new();
        request.write_frame(destination, CONTROLLER, &mut frame);
        self.send(&frame);
        self.run(DCP_WAIT);
        let profinet = |frame: &Vec<u8>| {
            let (header, payload) = FrameHeader::parse(frame).unwrap();
            let dcp = (header.ether_type == EtherType::PROFINET).then(|| Dcp::parse(payload).ok()).flatten();
            dcp.filter(|dcp| header.destination == CONTROLLER && dcp.xid == request.xid)
        };
        self.take().iter().filter_map(profinet).collect()
    }

    pub fn header(&mut self, opnum: Opnum) -> RpcHeader {
        self.sequence += 1;
        RpcHeader {
            flags1: Flags1::IDEMPOTENT,
            object: ObjectUuid { instance: 1, device_id: 1, vendor_id: 0x0239 }.into(),
            interface: Uuid::DEVICE_INTERFACE,
            activity: Uuid([9; 16]),
            sequence: self.sequence,
            opnum,
            ..RpcHeader::new(PacketType::REQUEST, self.order)
        }
    }

    /// Sends PDUs and returns the PDUs that came back to port 50000.
    pub fn pdus(&mut self, pdus: &[Vec<u8>]) -> Vec<Vec<u8>> {
        self.take();
        for pdu in pdus {
            let mut frame = Vec::new();
            let from = (CONTROLLER, SocketAddrV4::new(CONTROLLER_IP, 50_000));
            write_udp(from, (DEVICE, SocketAddrV4::new(DEVICE_IP, 0x8894)), pdu, &mut frame).unwrap();
            self.send(&frame);
        }
        let mut answers = Vec::new();
        for frame in self.take() {
            match Datagram::parse(&frame) {
                Ok(datagram) if datagram.destination.port() == 50_000 => {
                    assert!(datagram.checksum_ok() && datagram.source.port() == 0x8894);
                    answers.push(datagram.payload.to_vec());
                }
                _ => self.frames.push(frame),
            }
        }
        answers
    }

    /// Sends a request and returns header and body of the answer.
    pub fn call(&mut self, header: &RpcHeader, body: &[u8]) -> Option<(RpcHeader, Vec<u8>)> {
        let answers = self.pdus(&fragments(header, body, 1392));
        let mut reassembler = Reassembler::new(1, 1 << 20);
        answers.iter().find_map(|answer| {
            let pdu = RpcPdu::parse(answer).unwrap();
            assert_eq!((pdu.header.activity, pdu.header.sequence), (header.activity, header.sequence));
            match (pdu.header.packet_type, reassembler.take(&pdu)) {
                (PacketType::FACK, _) => None,
                (_, wire::profinet::rpc::Assembled::Whole(body)) => Some((pdu.header, body)),
                _ => None,
            }
        })
    }

    /// Carries out an operation and returns its status and its blocks.
    pub fn operate(&mut self, opnum: Opnum, blocks: &[u8]) -> (PnioStatus, Vec<u8>) {
        let header = self.header(opnum);
        let body = NdrRequest::body(self.order, 16_384, blocks);
        let (answer, body) = self.call(&header, &body).expect("an answer");
        assert_eq!(answer.packet_type, PacketType::RESPONSE);
        let (ndr, blocks) = NdrResponse::parse(answer.order(), &body).unwrap();
        assert_eq!(ndr.args_length as usize, blocks.len());
        (ndr.status, blocks.to_vec())
    }

    pub fn connect(&mut self, connect: &Connect) -> (PnioStatus, Connect) {
        let (status, blocks) = self.operate(Opnum::CONNECT, &connect.to_vec());
        (status, Connect::parse(&blocks).unwrap())
    }

    pub fn prm_end(&mut self) -> PnioStatus {
        self.operate(Opnum::CONTROL, &ControlBlocks::from(ControlBlock::prm_end(AR, 1)).to_vec()).0
    }

    pub fn release(&mut self) -> PnioStatus {
        self.operate(Opnum::RELEASE, &ControlBlocks::from(ControlBlock::release(AR, 1)).to_vec()).0
    }

    /// The calls of the device to port 34964 since frames were last taken.
    pub fn ready_calls(&mut self) -> Vec<Vec<u8>> {
        let frames = self.take();
        let calls = frames.iter().filter_map(|frame| {
            let datagram = Datagram::parse(frame).ok()?;
            let is_call = (datagram.source.port(), datagram.destination.port()) == (49_153, 0x8894);
            is_call.then(|| datagram.payload.to_vec())
        });
        calls.collect()
    }

    /// Answers a call of the device with `status`.
    pub fn answer_ready(&mut self, call: &[u8], status: PnioStatus) {
        let pdu = RpcPdu::parse(call).unwrap();
        let (ndr, blocks) = NdrRequest::parse(pdu.header.order(), pdu.body).unwrap();
        let control = ControlBlocks::parse(blocks).unwrap();
        let done = ControlBlocks::from(control.block.done()).to_vec();
        let body = NdrResponse::body(ByteOrder::Little, status, ndr.args_maximum, &done);
        self.answer_call(&pdu.header, PacketType::RESPONSE, &body);
    }

    pub fn answer_call(&mut self, call: &RpcHeader, kind: PacketType, body: &[u8]) {
        let answer = RpcPdu::new(call.answer(kind, ByteOrder::Little), body).to_vec();
        let mut frame = Vec::new();
        let from = (CONTROLLER, SocketAddrV4::new(CONTROLLER_IP, 0x8894));
        write_udp(from, (DEVICE, SocketAddrV4::new(DEVICE_IP, 49_153)), &answer, &mut frame).unwrap();
        self.send(&frame);
    }

    /// Sends one frame of outputs. The bytes of the telegram are at offset 0, and every status is good.
    pub fn outputs(&mut self, octets: [u8; 4]) {
        let mut data = [0; 40];
        data[..4].copy_from_slice(&octets);
        data[4..16].fill(0x80);
        self.output_frame(&data, DataStatus::NORMAL, 0);
    }

    pub fn output_frame(&mut self, data: &[u8], data_status: DataStatus, padding: usize) {
        self.counter = self.counter.wrapping_add(64);
        let status = ApduStatus { cycle_counter: self.counter, data_status, transfer_status: 0 };
        let padding = alloc::vec![0; padding];
        let mut frame = Vec::new();
        FrameHeader::new(DEVICE, CONTROLLER, EtherType::PROFINET).tagged(Vlan::RT).write(&mut frame);
        CyclicFrame { frame_id: FrameId(0x8000), data, status, padding: &padding }.write(&mut frame);
        self.send(&frame);
    }

    /// Exchanges data for `cycles` cycles.
    pub fn exchange(&mut self, cycles: usize) {
        for _ in 0..cycles {
            self.outputs([1, 2, 3, 4]);
            self.run(CYCLE);
        }
    }

    /// Connects and completes the start-up until data are exchanged.
    pub fn start(&mut self) {
        let (status, _) = self.connect(&full_connect());
        assert_eq!(status, PnioStatus::OK);
        self.exchange(2);
        assert_eq!(self.prm_end(), PnioStatus::OK);
        self.take();
        self.exchange(3);
        let calls = self.ready_calls();
        assert_eq!(calls.len(), 1, "ApplicationReady");
        self.answer_ready(&calls[0], PnioStatus::OK);
        self.exchange(3);
        self.take();
    }

    /// Data and status of the cyclic frames of the device among `frames`.
    pub fn inputs(frames: &[Vec<u8>]) -> Vec<(Vec<u8>, ApduStatus)> {
        let cyclic = |frame: &Vec<u8>| {
            let (header, payload) = FrameHeader::parse(frame).ok()?;
            let is_cyclic = header.ether_type == EtherType::PROFINET && FrameId::peek(payload).ok()?.is_cyclic();
            let frame = CyclicFrame::parse(payload, 40).ok().filter(|_| is_cyclic)?;
            assert_eq!((header.tag, header.destination), (Some(Vlan::RT), CONTROLLER));
            Some((frame.data.to_vec(), frame.status))
        };
        frames.iter().filter_map(cyclic).collect()
    }

    /// The frames that were sent to the device.
    pub fn sent(&self) -> Vec<Vec<u8>> {
        self.log.iter().filter(|(_, is_sent, _)| *is_sent).map(|(_, _, frame)| frame.clone()).collect()
    }

    /// Checks all frames with tshark: no malformed frame and no warning.
    ///
    /// Without tshark the check is skipped, and a line on the terminal says so.
    pub fn check_with_tshark(&self) {
        let mut capture = Vec::new();
        for word in [0xA1B2_3C4D_u32, 0x0002_0004, 0, 0, 65_535, 1] {
            capture.put_u32(word);
        }
        for (time, _, frame) in &self.log {
            let (nanos, length) = (time.as_nanos(), frame.len() as u32);
            for word in [(nanos / 1_000_000_000) as u32, (nanos % 1_000_000_000) as u32, length, length] {
                capture.put_u32(word);
            }
            capture.put(frame);
        }
        let filter = "_ws.malformed || _ws.expert.severity >= 6291456";
        let tshark = Command::new("tshark")
            .args(["--disable-protocol", "wg", "-r", "-", "-Y", filter])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let Ok(mut tshark) = tshark else {
            testing::skip("tshark is not installed");
            return;
        };
        tshark.stdin.take().unwrap().write_all(&capture).unwrap();
        let output = tshark.wait_with_output().unwrap();
        assert!(output.status.success(), "tshark failed to read the frames");
        assert_eq!(String::from_utf8_lossy(&output.stdout), "");
    }
}
