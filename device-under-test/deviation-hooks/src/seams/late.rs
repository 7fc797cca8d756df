//! Frames that a PROFINET device sends or processes later than its stack does, and frames that it sends in addition.
//!
//! A rule names the frames by their kind and gives a time. If several rules are about one frame, the one added last decides, so that two
//! variations of one time never add up to more than the longer one. Frames of one kind keep their order.

use super::last_cycles::LastCycles;
use super::stack::{cyclic, profinet};
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profinet::{ArEvent, StackHooks, StackView, StationData, StationLoad};
use station::Time;
use wire::datagram::Datagram;
use wire::ethernet::{EtherType, FrameHeader};
use wire::profinet::alarm::{RtaKind, RtaPdu};
use wire::profinet::dcp::{Dcp, ServiceId};
use wire::profinet::rpc::{Opnum, PacketType, RpcPdu};
use wire::profinet::rt::{ApduStatus, FrameKind};

/// What a frame is about, in either direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameTopic {
    /// DCP Identify, request or response.
    Identify,
    /// Another DCP service, request or response.
    Dcp(ServiceId),
    /// Cyclic data.
    Cyclic,
    /// An alarm notification or its acknowledgement by an application.
    AlarmData,
    /// The transport acknowledgement of an alarm PDU.
    AlarmAck,
    /// An RPC request of this operation.
    Request(Opnum),
    /// An RPC response to this operation, a rejection or a fault.
    Response(Opnum),
    /// LLDP.
    Lldp,
    /// ARP.
    Arp,
    /// Anything else.
    Other,
}

impl FrameTopic {
    /// The topic of a frame.
    pub fn of(frame: &[u8]) -> FrameTopic {
        if let Some((_, at, frame_id)) = profinet(frame) {
            let payload = &frame[at..];
            return match frame_id.kind() {
                _ if frame_id.is_cyclic() => FrameTopic::Cyclic,
                FrameKind::AlarmHigh | FrameKind::AlarmLow => match payload.get(2..).map(RtaPdu::parse) {
                    Some(Ok(pdu)) if pdu.header.kind == RtaKind::DATA => FrameTopic::AlarmData,
                    Some(Ok(pdu)) if pdu.header.kind == RtaKind::ACK => FrameTopic::AlarmAck,
                    _ => FrameTopic::Other,
                },
                FrameKind::DcpIdentifyRequest | FrameKind::DcpIdentifyResponse => FrameTopic::Identify,
                _ => Dcp::parse(payload).map_or(FrameTopic::Other, |dcp| FrameTopic::Dcp(dcp.service_id)),
            };
        }
        match FrameHeader::parse(frame) {
            Ok((header, _)) if header.ether_type == EtherType::LLDP => return FrameTopic::Lldp,
            Ok((header, _)) if header.ether_type == EtherType::ARP => return FrameTopic::Arp,
            _ => {}
        }
        let Ok(datagram) = Datagram::parse(frame) else { return FrameTopic::Other };
        match RpcPdu::parse(datagram.payload).map(|pdu| pdu.header) {
            Ok(header) if header.packet_type == PacketType::REQUEST => FrameTopic::Request(header.opnum),
            Ok(header) => match header.packet_type {
                PacketType::RESPONSE | PacketType::FAULT | PacketType::REJECT => FrameTopic::Response(header.opnum),
                _ => FrameTopic::Other,
            },
            Err(_) => FrameTopic::Other,
        }
    }

    /// Whether frames of both topics keep their order: RPC in one direction, alarms.
    fn keeps_order_with(self, other: FrameTopic) -> bool {
        use FrameTopic as Of;
        match (self, other) {
            (Of::Request(_), Of::Request(_))
            | (Of::Response(_), Of::Response(_))
            | (Of::AlarmData | Of::AlarmAck, Of::AlarmData | Of::AlarmAck) => true,
            (one, other) => one == other,
        }
    }
}

type Delay = Box<dyn FnMut(FrameTopic) -> Option<Duration>>;
type Addition = Box<dyn FnMut(FrameTopic, &[u8]) -> Vec<(Duration, Vec<u8>)>>;

struct DelayedFrame {
    due: Time,
    topic: FrameTopic,
    frame: Vec<u8>,
}

/// The rules for late and additional frames, and the frames that wait. They are lost with the power.
#[derive(Default)]
pub struct LateFrames {
    sent: Vec<Delay>,
    received: Vec<Delay>,
    added: Vec<Addition>,
    to_send: Vec<DelayedFrame>,
    to_receive: Vec<DelayedFrame>,
    /// How old the inputs are, in cycles.
    inputs_old: usize,
    /// The inputs of the last cycles, by destination and FrameID.
    inputs: Vec<(Vec<u8>, LastCycles<Vec<u8>>)>,
}

impl LateFrames {
    /// Sends the frames for which `delay` gives a time so much later.
    pub fn sent(&mut self, delay: impl FnMut(FrameTopic) -> Option<Duration> + 'static) {
        self.sent.push(Box::new(delay));
    }

    /// Processes the received frames for which `delay` gives a time so much later.
    pub fn received(&mut self, delay: impl FnMut(FrameTopic) -> Option<Duration> + 'static) {
        self.received.push(Box::new(delay));
    }

    /// Sends more frames with a sent one, each so much later than the stack sends that one; at 0 they come before it.
    pub fn added(&mut self, add: impl FnMut(FrameTopic, &[u8]) -> Vec<(Duration, Vec<u8>)> + 'static) {
        self.added.push(Box::new(add));
    }

    /// Sends inputs that are this many cycles old, with the cycle counter and the status of the frame itself.
    pub fn inputs(&mut self, cycles: usize) {
        self.inputs_old = cycles;
    }

    /// Whether there are no rules.
    pub fn is_empty(&self) -> bool {
        self.sent.is_empty() && self.received.is_empty() && self.added.is_empty() && self.inputs_old == 0
    }

    /// Replaces the inputs of a cyclic frame by older ones.
    fn send_old_inputs(&mut self, frame: &mut [u8]) {
        let Some(at) = cyclic(frame).filter(|_| self.inputs_old > 0) else { return };
        let Some(end) = frame.len().checked_sub(ApduStatus::LENGTH).filter(|end| *end >= at + 2) else { return };
        let now = frame[at + 2..end].to_vec();
        let stream = [&frame[..6], &frame[at..at + 2]].concat();
        let known = self.inputs.iter().position(|(known, _)| *known == stream);
        let place = known.unwrap_or(self.inputs.len());
        if known.is_none() {
            self.inputs.push((stream, LastCycles::of(self.inputs_old)));
        }
        let Some((_, inputs)) = self.inputs.get_mut(place) else { return };
        inputs.retain(|before| before.len() == now.len());
        if let Some(old) = inputs.oldest_with(now) {
            frame[at + 2..end].copy_from_slice(old);
        }
    }

    fn delay(rules: &mut [Delay], topic: FrameTopic) -> Option<Duration> {
        rules.iter_mut().rev().find_map(|rule| rule(topic))
    }

    /// Holds a frame back until `due`, but not less than the frames before it.
    fn hold(held: &mut Vec<DelayedFrame>, due: Time, topic: FrameTopic, frame: Vec<u8>) {
        let before = held.iter().filter(|one| one.topic.keeps_order_with(topic)).map(|one| one.due).max();
        held.push(DelayedFrame { due: before.map_or(due, |before| before.max(due)), topic, frame });
    }

    /// Moves the frames that are due to `frames`, in the order of their times.
    fn take(held: &mut Vec<DelayedFrame>, now: Time, frames: &mut Vec<Vec<u8>>) {
        let mut due: Vec<DelayedFrame> = held.extract_if(.., |one| one.due <= now).collect();
        due.sort_by_key(|one| one.due);
        frames.extend(due.into_iter().map(|one| one.frame));
    }
}

impl StackHooks for LateFrames {
    fn sent_frame(&mut self, view: &StackView<'_>, frame: &mut Vec<u8>) {
        if frame.is_empty() {
            return;
        }
        self.send_old_inputs(frame);
        let topic = FrameTopic::of(frame);
        let delay = LateFrames::delay(&mut self.sent, topic);
        let added: Vec<_> = self.added.iter_mut().flat_map(|add| add(topic, frame)).collect();
        let waits = self.to_send.iter().any(|one| one.topic.keeps_order_with(topic));
        if delay.is_none() && added.is_empty() && !waits {
            return;
        }
        let (first, later): (Vec<_>, Vec<_>) = added.into_iter().partition(|(after, _)| after.is_zero());
        for (_, before) in first {
            LateFrames::hold(&mut self.to_send, view.now, FrameTopic::of(&before), before);
        }
        let due = view.now + delay.unwrap_or_default();
        LateFrames::hold(&mut self.to_send, due, topic, core::mem::take(frame));
        for (after, more) in later {
            // An added frame does not hold up the frames after it.
            self.to_send.push(DelayedFrame { due: view.now + after, topic: FrameTopic::Other, frame: more });
        }
    }

    fn received_frames(&mut self, view: &StackView<'_>, mut frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        if self.received.is_empty() {
            return frames;
        }
        frames.retain_mut(|frame| {
            let topic = FrameTopic::of(frame);
            let delay = LateFrames::delay(&mut self.received, topic);
            if let Some(delay) = delay {
                LateFrames::hold(&mut self.to_receive, view.now + delay, topic, core::mem::take(frame));
            }
            delay.is_none()
        });
        frames
    }

    fn due(&mut self, due: Option<Time>) -> Option<Time> {
        self.to_send.iter().chain(&self.to_receive).map(|one| one.due).chain(due).min()
    }

    fn late_received(&mut self, now: Time, frames: &mut Vec<Vec<u8>>) {
        LateFrames::take(&mut self.to_receive, now, frames);
    }

    fn late_sent(&mut self, now: Time, frames: &mut Vec<Vec<u8>>) {
        LateFrames::take(&mut self.to_send, now, frames);
    }

    fn connection(&mut self, event: ArEvent) {
        if event == ArEvent::Opened {
            self.inputs.clear();
        }
    }

    fn load_station(&mut self, start: StationLoad, _: &mut StationData) {
        if start == StationLoad::PowerUp {
            self.to_send.clear();
            self.to_receive.clear();
        }
    }
}

/// Times that look random and are the same in each run.
#[derive(Clone, Copy, Debug)]
pub struct Jitter(u64);

impl Jitter {
    /// A sequence of times; another seed gives another one.
    pub const fn new(seed: u64) -> Jitter {
        Jitter(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// The next time, less than `most`, in whole microseconds.
    pub fn next(&mut self, most: Duration) -> Duration {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        Duration::from_micros((self.0 >> 16) % (most.as_micros() as u64).max(1))
    }
}
