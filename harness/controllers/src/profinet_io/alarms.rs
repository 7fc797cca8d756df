//! The alarm endpoint of the controller: it receives alarms, acknowledges them twice (transport, then application), and ends the
//! AR with an ERR-RTA.
//!
//! Each priority is a channel with its own sequence numbers. A repeated alarm is acknowledged again but not processed again. This
//! module must not know what an alarm means.

use super::connection::ArConfig;
use super::outcome::ArEnd;
use super::state::{AwaitedEvent, Wait};
use alloc::collections::VecDeque;
use alloc::vec::Vec;
use core::time::Duration;
use station::{Outbox, Time};
use wire::ethernet::{EtherType, FrameHeader, Mac, Vlan, pad};
use wire::octets::Append;
use wire::profinet::alarm::{AlarmAck, AlarmNotification, AlarmPriority, RtaBody, RtaHeader, RtaKind, RtaPdu};
use wire::profinet::status::{AbortReason, PnioStatus};

/// The unit of RTATimeoutFactor.
const RTA_TIMEOUT_UNIT: Duration = Duration::from_millis(100);
/// The sequence number of the first DATA of a channel.
const FIRST: u16 = 0xFFFF;
/// The sequence number that means "none yet".
const BEFORE_FIRST: u16 = 0xFFFE;

/// How far alarms are acknowledged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum AlarmAcknowledge {
    /// By the transport and by the application, as the standard requires.
    #[default]
    Given,
    /// By the transport only: the device knows that the alarm has arrived, and waits for the application.
    Received,
    /// Not at all, as if no alarm had arrived.
    Held,
}

/// The alarm endpoint of an AR.
#[derive(Debug)]
pub(super) struct ControllerAlarms {
    /// How far alarms are acknowledged.
    pub(super) acknowledge: AlarmAcknowledge,
    ends: AlarmCrAddresses,
    channels: [AlarmPriorityChannel; 2],
}

/// Addresses, references and timing of the two alarm endpoints.
#[derive(Clone, Copy, Debug)]
pub(super) struct AlarmCrAddresses {
    pub(super) own: Mac,
    pub(super) device: Mac,
    pub(super) own_reference: u16,
    pub(super) device_reference: u16,
    /// The tags of alarms of high and of low priority; `None`: untagged.
    tags: Option<(u16, u16)>,
    timeout: Duration,
    retries: u16,
}

#[derive(Debug)]
struct AlarmPriorityChannel {
    priority: AlarmPriority,
    /// The sequence number expected in the next DATA of the device.
    expected: u16,
    /// The sequence number of the last DATA accepted.
    taken: u16,
    /// The sequence numbers of the next DATA of the controller and of its last one.
    next: u16,
    sent: u16,
    waiting: VecDeque<AlarmAck>,
    outstanding: Option<Outstanding>,
}

/// An AlarmAck whose transport acknowledgement is awaited.
#[derive(Clone, Copy, Debug)]
struct Outstanding {
    ack: AlarmAck,
    since: Time,
    repeat: Time,
    repeats: u16,
}

impl AlarmCrAddresses {
    pub(super) fn new(connection: &ArConfig, macs: (Mac, Mac), references: (u16, u16)) -> AlarmCrAddresses {
        AlarmCrAddresses {
            own: macs.0,
            device: macs.1,
            own_reference: references.0,
            device_reference: references.1,
            tags: connection.vlan.then_some(connection.alarm_tags),
            timeout: RTA_TIMEOUT_UNIT * u32::from(connection.rta_timeout_factor.max(1)),
            retries: connection.rta_retries,
        }
    }

    fn send(&self, priority: AlarmPriority, pdu: &RtaPdu, out: &mut Outbox) {
        let header = FrameHeader::new(self.device, self.own, EtherType::PROFINET);
        let tag = |control| Vlan { control, ..Vlan::RT };
        let header = match (self.tags, priority) {
            (None, _) => header,
            (Some((high, _)), AlarmPriority::High) => header.tagged(tag(high)),
            (Some((_, low)), AlarmPriority::Low) => header.tagged(tag(low)),
        };
        out.push_with(|octets| {
            let start = octets.len();
            header.write(octets);
            octets.put_u16(priority.frame_id());
            pdu.write(octets);
            pad(octets, start);
        });
    }
}

impl ControllerAlarms {
    pub(super) fn new(ends: AlarmCrAddresses) -> ControllerAlarms {
        ControllerAlarms {
            acknowledge: AlarmAcknowledge::Given,
            ends,
            channels: [AlarmPriorityChannel::new(AlarmPriority::Low), AlarmPriorityChannel::new(AlarmPriority::High)],
        }
    }

    /// When something must be sent: a repetition, or at once the acknowledgements withheld so far.
    pub(super) fn deadline(&self) -> Option<Time> {
        let given = self.acknowledge == AlarmAcknowledge::Given;
        let due = |channel: &AlarmPriorityChannel| match channel.outstanding {
            Some(outstanding) => Some(outstanding.repeat),
            None => (given && !channel.waiting.is_empty()).then_some(Time::ZERO),
        };
        self.channels.iter().filter_map(due).min()
    }

    /// Processes the part after the frame ID of an alarm frame from `from`; returns a new alarm that is acknowledged, or the end of the
    /// AR if the frame ends it.
    pub(super) fn receive(
        &mut self,
        now: Time,
        from: Mac,
        priority: AlarmPriority,
        octets: &[u8],
        out: &mut Outbox,
    ) -> Result<Option<AlarmNotification>, ArEnd> {
        let ControllerAlarms { acknowledge, ends, channels } = self;
        let Some(pdu) = RtaPdu::parse(octets).ok().filter(|_| from == ends.device) else { return Ok(None) };
        // An ERR-RTA counts whatever endpoint it names as its sender: a device that has lost the AR may have lost the number as
        // well.
        let from_peer = pdu.header.src_endpoint == ends.device_reference || pdu.header.kind == RtaKind::ERR;
        if pdu.header.dst_endpoint != ends.own_reference || !from_peer || pdu.header.version != 1 {
            return Ok(None);
        }
        let Some(channel) = channels.iter_mut().find(|channel| channel.priority == priority) else { return Ok(None) };
        let alarm = match (pdu.header.kind, pdu.body) {
            (_, RtaBody::Error { status, .. }) => return Err(ArEnd::Aborted(status)),
            (RtaKind::DATA, _) if *acknowledge == AlarmAcknowledge::Held => return Ok(None),
            (RtaKind::DATA, body) => channel.data(ends, pdu.header.send_seq_num, body, out),
            (RtaKind::ACK, _) => {
                channel.acknowledged(pdu.header.ack_seq_num);
                None
            }
            _ => None,
        };
        if *acknowledge != AlarmAcknowledge::Given {
            return Ok(None);
        }
        channel.send_next(now, ends, out);
        Ok(alarm)
    }

    /// Repeats what is due; returns the end of the AR if the device did not acknowledge in time.
    pub(super) fn wake(&mut self, now: Time, out: &mut Outbox) -> Option<ArEnd> {
        let ControllerAlarms { acknowledge, ends, channels } = self;
        if *acknowledge == AlarmAcknowledge::Given {
            channels.iter_mut().for_each(|channel| channel.send_next(now, ends, out));
        }
        channels.iter_mut().find_map(|channel| channel.wake(now, ends, out)).map(ArEnd::AlarmUnacknowledged)
    }

    /// Sends the device an ERR-RTA that ends the AR.
    pub(super) fn abort(&self, reason: AbortReason, out: &mut Outbox) {
        let [low, _] = &self.channels;
        let body = RtaBody::Error { status: PnioStatus::abort(reason), more: Vec::new() };
        let pdu = RtaPdu { header: low.header(&self.ends, RtaKind::ERR, low.next), body };
        self.ends.send(AlarmPriority::Low, &pdu, out);
    }
}

impl AlarmPriorityChannel {
    fn new(priority: AlarmPriority) -> AlarmPriorityChannel {
        AlarmPriorityChannel {
            priority,
            expected: FIRST,
            taken: BEFORE_FIRST,
            next: FIRST,
            sent: BEFORE_FIRST,
            waiting: VecDeque::new(),
            outstanding: None,
        }
    }

    fn header(&self, ends: &AlarmCrAddresses, kind: RtaKind, send: u16) -> RtaHeader {
        RtaHeader::new(kind, ends.device_reference, ends.own_reference, send, self.taken)
    }

    /// Processes a DATA PDU; returns a new alarm.
    fn data(
        &mut self,
        ends: &AlarmCrAddresses,
        sequence: u16,
        body: RtaBody,
        out: &mut Outbox,
    ) -> Option<AlarmNotification> {
        let new = sequence == self.expected;
        if new {
            (self.taken, self.expected) = (sequence, following(sequence));
        }
        let kind = if new || sequence == self.taken { RtaKind::ACK } else { RtaKind::NACK };
        let pdu = RtaPdu { header: self.header(ends, kind, self.sent), body: RtaBody::Octets(Vec::new()) };
        ends.send(self.priority, &pdu, out);
        let RtaBody::Notification(alarm) = body else { return None };
        if !new {
            return None;
        }
        self.waiting.push_back(alarm.acknowledgement(PnioStatus::OK));
        Some(alarm)
    }

    fn acknowledged(&mut self, sequence: u16) {
        if sequence == self.sent {
            self.outstanding = None;
        }
    }

    fn send_next(&mut self, now: Time, ends: &AlarmCrAddresses, out: &mut Outbox) {
        if self.outstanding.is_some() {
            return;
        }
        let Some(ack) = self.waiting.pop_front() else { return };
        (self.sent, self.next) = (self.next, following(self.next));
        self.outstanding = Some(Outstanding { ack, since: now, repeat: now + ends.timeout, repeats: 0 });
        self.send(ends, ack, out);
    }

    fn send(&self, ends: &AlarmCrAddresses, ack: AlarmAck, out: &mut Outbox) {
        let header = self.header(ends, RtaKind::DATA, self.sent);
        ends.send(self.priority, &RtaPdu { header, body: RtaBody::Acknowledgement(ack) }, out);
    }

    fn wake(&mut self, now: Time, ends: &AlarmCrAddresses, out: &mut Outbox) -> Option<Wait> {
        let outstanding = self.outstanding.as_mut().filter(|outstanding| now >= outstanding.repeat)?;
        if outstanding.repeats >= ends.retries {
            return Some(Wait { what: AwaitedEvent::AlarmAcknowledged, time: now.since(outstanding.since) });
        }
        outstanding.repeats += 1;
        outstanding.repeat = now + ends.timeout;
        let ack = outstanding.ack;
        self.send(ends, ack, out);
        None
    }
}

/// The sequence number after `number`: 0 after the first one, then up to 0x7FFF and back to 0.
fn following(number: u16) -> u16 {
    number.wrapping_add(1) & 0x7FFF
}

#[cfg(test)]
mod tests {
    use super::following;

    /// 0 follows the first number, and also 0x7FFF.
    #[test]
    fn sequence_numbers_wrap_without_the_first_one() {
        let steps = [(0xFFFF, 0), (0, 1), (0x7FFE, 0x7FFF), (0x7FFF, 0)];
        assert!(steps.iter().all(|(number, next)| following(*number) == *next));
    }
}
