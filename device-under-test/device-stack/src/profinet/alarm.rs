//! The alarm endpoint of a connection: a queue for each priority, one alarm at a time, with repetition and acknowledgement.
//!
//! Every alarm of this stack is shorter than 200 bytes, the smallest MaxAlarmDataLength that a controller may set.
//!
//! This module must not know diagnoses: it sends complete notifications.

use super::hooks::{AttachedStackHooks, StackCheck};
use crate::earlier;
use alloc::collections::VecDeque;
use alloc::vec::Vec;
use station::{Duration, Outbox, Time};
use wire::ethernet::{EtherType, FrameHeader, Mac, Vlan, pad};
use wire::octets::Append;
use wire::profinet::alarm::{AlarmNotification, AlarmPriority, AlarmSpecifier, RtaBody, RtaHeader, RtaKind, RtaPdu};
use wire::profinet::blocks::connect::{AlarmCrBlockReq, AlarmCrBlockRes};
use wire::profinet::status::{AbortReason, PnioStatus};

/// Unit of RTATimeoutFactor: 100 ms (IEC 61158-6-10).
const RTA_TIMEOUT_UNIT: Duration = Duration::from_millis(100);

/// The alarm endpoint of the device in one connection.
#[derive(Debug)]
pub(super) struct AlarmEndpoint {
    addresses: AlarmAddresses,
    low: AlarmQueue,
    high: AlarmQueue,
    hooks: AttachedStackHooks,
}

/// Addresses, references and times of both queues.
#[derive(Debug)]
struct AlarmAddresses {
    peer: Mac,
    mac: Mac,
    local: u16,
    remote: u16,
    tags: [u16; 2],
    timeout: Duration,
    retries: u16,
}

/// The alarms of one priority: one at a time, with its own numbers and acknowledgements.
#[derive(Debug)]
struct AlarmQueue {
    priority: AlarmPriority,
    waiting: VecDeque<AlarmNotification>,
    transfer: AlarmTransfer,
    next_sequence: u16,
    received: u16,
    specifier: u16,
}

/// The state of the current alarm.
#[derive(Clone, Debug, PartialEq, Eq)]
enum AlarmTransfer {
    /// No alarm is pending.
    Idle,
    /// The alarm was sent and the transport acknowledgement (RTA ACK) is missing.
    Sent { notification: AlarmNotification, sequence: u16, retries_left: u16, due: Time },
    /// The alarm has arrived; the Alarm Ack of the controller's application is missing.
    Arrived { specifier: AlarmSpecifier },
}

/// The effect of a received PDU or of a timer on the connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AlarmOutcome {
    /// The connection continues.
    GoesOn,
    /// The controller has ended the connection.
    Ended,
    /// The device must end the connection.
    End(AbortReason),
}

impl AlarmEndpoint {
    /// MaxAlarmDataLength of the device, in bytes.
    const MAX_LENGTH: u16 = 200;
    /// SendSeqNum of the first alarm of a queue.
    const FIRST_SEQUENCE: u16 = 0xFFFF;
    /// AckSeqNum before the first received PDU.
    const NOTHING_RECEIVED: u16 = 0xFFFE;

    /// Opens the endpoint with the reference `local` as `request` sets it up.
    pub(super) fn new(
        (peer, mac): (Mac, Mac),
        local: u16,
        request: &AlarmCrBlockReq,
        hooks: AttachedStackHooks,
    ) -> AlarmEndpoint {
        let addresses = AlarmAddresses {
            peer,
            mac,
            local,
            remote: request.local_alarm_reference,
            tags: [request.alarm_cr_tag_header_low, request.alarm_cr_tag_header_high],
            timeout: RTA_TIMEOUT_UNIT * u32::from(request.rta_timeout_factor),
            retries: request.rta_retries,
        };
        let (low, high) = (AlarmQueue::new(AlarmPriority::Low), AlarmQueue::new(AlarmPriority::High));
        AlarmEndpoint { addresses, low, high, hooks }
    }

    /// The AlarmCRBlockRes for the answer to Connect.
    pub(super) fn response(&self) -> AlarmCrBlockRes {
        AlarmCrBlockRes {
            alarm_cr_type: 1,
            local_alarm_reference: self.addresses.local,
            max_alarm_data_length: AlarmEndpoint::MAX_LENGTH,
        }
    }

    /// Queues an alarm and sets its sequence number, which is returned.
    pub(super) fn push(&mut self, mut notification: AlarmNotification) -> u16 {
        let is_sent = self.hooks.apply(true, |hooks, is_sent| hooks.alarm(&mut notification, is_sent));
        let is_high = notification.priority == AlarmPriority::High;
        let counter = if is_high && self.hooks.check(StackCheck::NumbersOfHighAlarms, true) {
            &mut self.high.specifier
        } else {
            &mut self.low.specifier
        };
        let sequence = *counter;
        if is_sent {
            notification.specifier = AlarmSpecifier::new(sequence, notification.specifier.0);
            *counter = (sequence + 1) & 0x07FF;
            let in_high_frames = self.hooks.check(StackCheck::InHighFrames, is_high);
            let queue = if in_high_frames { &mut self.high } else { &mut self.low };
            queue.waiting.push_back(notification);
        }
        sequence
    }

    /// Whether the PDU is for this endpoint.
    pub(super) fn is_for(&self, source: Mac, pdu: &RtaPdu) -> bool {
        let AlarmAddresses { peer, local, remote, .. } = self.addresses;
        source == peer && (pdu.header.dst_endpoint, pdu.header.src_endpoint) == (local, remote)
    }

    /// When the next alarm or repetition is due.
    pub(super) fn due(&self) -> Option<Time> {
        earlier(self.low.due(), self.high.due().filter(|_| self.sends_high()))
    }

    /// Whether an alarm of high priority may be sent now.
    fn sends_high(&self) -> bool {
        self.low.transfer == AlarmTransfer::Idle || self.hooks.check(StackCheck::HighBesideLow, true)
    }

    /// Sends the repetitions that are due, or the next alarms, that of high priority first.
    pub(super) fn wake(&mut self, now: Time, out: &mut Outbox) -> AlarmOutcome {
        if self.sends_high()
            && let outcome @ (AlarmOutcome::End(_) | AlarmOutcome::Ended) = self.high.wake(&self.addresses, now, out)
        {
            return outcome;
        }
        self.low.wake(&self.addresses, now, out)
    }

    /// Processes a PDU that [is for](AlarmEndpoint::is_for) this endpoint.
    pub(super) fn receive(&mut self, priority: AlarmPriority, pdu: &RtaPdu, out: &mut Outbox) -> AlarmOutcome {
        let queue = match priority {
            AlarmPriority::Low => &mut self.low,
            AlarmPriority::High => &mut self.high,
        };
        match (&pdu.body, pdu.header.kind) {
            (RtaBody::Error { .. }, _) => return AlarmOutcome::Ended,
            (_, RtaKind::ACK) => queue.take_acknowledged(pdu.header.ack_seq_num),
            (body, RtaKind::DATA) => queue.receive(&self.addresses, pdu, body, &self.hooks, out),
            _ => {}
        }
        AlarmOutcome::GoesOn
    }

    /// Sends ERR-RTA with `reason` to the controller.
    pub(super) fn abort(&self, reason: AbortReason, out: &mut Outbox) {
        let header = self.low.header(&self.addresses, RtaKind::ERR, self.low.last_sequence());
        let body = RtaBody::Error { status: PnioStatus::abort(reason), more: Vec::new() };
        self.addresses.write(AlarmPriority::Low, header, body, out);
    }
}

impl AlarmQueue {
    fn new(priority: AlarmPriority) -> AlarmQueue {
        AlarmQueue {
            priority,
            waiting: VecDeque::new(),
            transfer: AlarmTransfer::Idle,
            next_sequence: AlarmEndpoint::FIRST_SEQUENCE,
            received: AlarmEndpoint::NOTHING_RECEIVED,
            specifier: 0,
        }
    }

    fn due(&self) -> Option<Time> {
        match &self.transfer {
            AlarmTransfer::Sent { due, .. } => Some(*due),
            AlarmTransfer::Idle if self.waiting.is_empty() => None,
            AlarmTransfer::Idle => Some(Time::ZERO),
            AlarmTransfer::Arrived { .. } => None,
        }
    }

    fn wake(&mut self, addresses: &AlarmAddresses, now: Time, out: &mut Outbox) -> AlarmOutcome {
        match core::mem::replace(&mut self.transfer, AlarmTransfer::Idle) {
            AlarmTransfer::Idle => {
                if let Some(notification) = self.waiting.pop_front() {
                    let sequence = self.next_sequence;
                    self.next_sequence = sequence.wrapping_add(1) & 0x7FFF;
                    self.send(addresses, now, notification, (sequence, addresses.retries), out);
                }
            }
            AlarmTransfer::Sent { retries_left: 0, due, .. } if due <= now => {
                return AlarmOutcome::End(AbortReason::ALARM_SEND);
            }
            AlarmTransfer::Sent { notification, sequence, retries_left, due } if due <= now => {
                self.send(addresses, now, notification, (sequence, retries_left - 1), out);
            }
            other @ (AlarmTransfer::Sent { .. } | AlarmTransfer::Arrived { .. }) => self.transfer = other,
        }
        AlarmOutcome::GoesOn
    }

    fn send(
        &mut self,
        addresses: &AlarmAddresses,
        now: Time,
        notification: AlarmNotification,
        (sequence, retries_left): (u16, u16),
        out: &mut Outbox,
    ) {
        let header = self.header(addresses, RtaKind::DATA, sequence);
        addresses.write(self.priority, header, RtaBody::Notification(notification.clone()), out);
        self.transfer = AlarmTransfer::Sent { notification, sequence, retries_left, due: now + addresses.timeout };
    }

    fn header(&self, addresses: &AlarmAddresses, kind: RtaKind, sequence: u16) -> RtaHeader {
        RtaHeader::new(kind, addresses.remote, addresses.local, sequence, self.received)
    }

    fn receive(
        &mut self,
        addresses: &AlarmAddresses,
        pdu: &RtaPdu,
        body: &RtaBody,
        hooks: &AttachedStackHooks,
        out: &mut Outbox,
    ) {
        let sequence = pdu.header.send_seq_num;
        let expected = if self.received == AlarmEndpoint::NOTHING_RECEIVED {
            0xFFFF
        } else {
            self.received.wrapping_add(1) & 0x7FFF
        };
        let kind = if sequence == expected {
            self.received = sequence;
            self.take_acknowledged(pdu.header.ack_seq_num);
            self.take_data(body, hooks);
            RtaKind::ACK
        } else if sequence == self.received {
            RtaKind::ACK
        } else {
            RtaKind::NACK
        };
        let header = self.header(addresses, kind, self.last_sequence());
        addresses.write(self.priority, header, RtaBody::Octets(Vec::new()), out);
    }

    fn take_acknowledged(&mut self, acknowledged: u16) {
        if let AlarmTransfer::Sent { notification, sequence, .. } = &self.transfer
            && *sequence == acknowledged
        {
            self.transfer = AlarmTransfer::Arrived { specifier: notification.specifier };
        }
    }

    fn take_data(&mut self, body: &RtaBody, hooks: &AttachedStackHooks) {
        let (RtaBody::Acknowledgement(ack), AlarmTransfer::Arrived { specifier }) = (body, &self.transfer) else {
            return;
        };
        let is_for_it = ack.specifier.sequence_number() == specifier.sequence_number();
        if hooks.check(StackCheck::Acknowledgement, is_for_it) {
            self.transfer = AlarmTransfer::Idle;
        }
    }

    /// The sequence number of the alarm sent last.
    fn last_sequence(&self) -> u16 {
        match self.next_sequence {
            0xFFFF => 0xFFFE,
            0 => 0xFFFF,
            next => next - 1,
        }
    }
}

impl AlarmAddresses {
    fn write(&self, priority: AlarmPriority, header: RtaHeader, body: RtaBody, out: &mut Outbox) {
        let [low, high] = self.tags;
        let control = match priority {
            AlarmPriority::Low => low,
            AlarmPriority::High => high,
        };
        let tag = Vlan { protocol: EtherType::VLAN, control };
        out.push_with(|frame| {
            let start = frame.len();
            FrameHeader::new(self.peer, self.mac, EtherType::PROFINET).tagged(tag).write(frame);
            frame.put_u16(priority.frame_id());
            RtaPdu { header, body }.write(frame);
            pad(frame, start);
        });
    }
}
