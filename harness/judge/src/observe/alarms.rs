//! Tracks alarms, their acknowledgements, and the ERR-RTA that ends a connection.

use super::connect::{ArLink, established_connection};
use super::tracker::{ReceivedFrame, Sink, Tracker};
use super::{ArId, ArStage, FrameDirection, Observation, Role, Traffic};
use rustc_hash::FxHasher;
use std::hash::Hasher;
use wire::WireError;
use wire::ethernet::Mac;
use wire::profinet::alarm::{AlarmPriority, RtaBody, RtaHeader, RtaPdu};
use wire::profinet::rpc::Uuid;
use wire::profinet::rt::FrameId;

/// Length from the frame id to the variable part in bytes; a repetition may differ in this part.
const HEAD: usize = 14;

impl Tracker {
    pub(super) fn alarm(&mut self, received: &ReceivedFrame<'_>, FrameId(frame_id): FrameId, sink: Sink<'_>) {
        let pdu = match RtaPdu::parse(received.payload.get(2..).unwrap_or_default()) {
            Ok(pdu) => pdu,
            Err(error) => return self.unreadable(error.at_offset(received.at() + 2), sink),
        };
        let priority = AlarmPriority::from_frame_id(frame_id).unwrap_or(AlarmPriority::Low);
        let block = match &pdu.body {
            RtaBody::Notification(alarm) => Some((alarm.priority, alarm.priority.notification_block())),
            RtaBody::Acknowledgement(of) => Some((of.priority, of.priority.ack_block())),
            RtaBody::Error { .. } | RtaBody::Octets(_) => None,
        };
        // A watch and a capture show what the alarm says all the same.
        if let Some((_, block)) = block.filter(|(of_block, _)| *of_block != priority && !self.is_recorded) {
            let expected = "a block of the same priority as the frame ID";
            let (layer, field, observed) = ("RTA-PDU", "BlockType", block.0.into());
            let error = WireError::Value { layer, offset: HEAD, field, expected, observed };
            return self.unreadable(error.at_offset(received.at()), sink);
        }
        let Some((index, direction)) = self.connection_of(received, &pdu) else { return };
        let ar = ArId(index);
        let rta = |again| {
            let RtaHeader { kind, send_seq_num: sequence, ack_seq_num: acknowledges, .. } = pdu.header;
            let of_block = block.map(|(of_block, _)| of_block);
            Observation::Traffic(Traffic::Rta {
                ar,
                direction,
                priority,
                of_block,
                kind,
                sequence,
                acknowledges,
                again,
            })
        };
        match &pdu.body {
            RtaBody::Notification(notification) => {
                let is_new = self.is_new(index, direction, priority, &pdu.header, received);
                sink(&self.ars, rta(!is_new));
                if is_new {
                    sink(&self.ars, Observation::Alarm { ar, priority, notification });
                }
            }
            RtaBody::Acknowledgement(acknowledgement) => {
                let is_new = self.is_new(index, direction, priority, &pdu.header, received);
                sink(&self.ars, rta(!is_new));
                if is_new {
                    sink(&self.ars, Observation::AlarmAcknowledged { ar, status: acknowledgement.status });
                }
            }
            RtaBody::Error { status, .. } => {
                let Some(known) = self.ars.get_mut(index as usize) else { return };
                if known.abort.is_none() {
                    known.abort = Some((received.number, u32::from(*status)));
                    if known.stage.stands() || known.stage == ArStage::Starved {
                        known.stage = ArStage::Aborted;
                    }
                    sink(&self.ars, Observation::Aborted { ar, direction, status: *status });
                }
            }
            RtaBody::Octets(_) => sink(&self.ars, rta(false)),
        }
    }

    /// The connection between these two with these alarm references, else the last one between them.
    fn connection_of(&mut self, received: &ReceivedFrame<'_>, pdu: &RtaPdu) -> Option<(u32, FrameDirection)> {
        let (source, destination) = (received.header.source, received.header.destination);
        let RtaHeader { src_endpoint: src, dst_endpoint: dst, .. } = pdu.header;
        // An ERR-RTA has to match the alarm references if both are known; otherwise it belongs to another connection.
        let is_end = matches!(pdu.body, RtaBody::Error { .. });
        let find = |pair: (Mac, Mac), references: (u16, u16), exactly: bool| {
            let found = self.by_pair.get(&pair)?.iter().rev().find(|index| {
                // A connection for access to records has no alarms; without references they belong to the data exchange.
                let is_access = self.ars.get(**index as usize).is_some_and(|ar| ar.role == Role::Access);
                if is_access && !exactly {
                    return false;
                }
                let known = self.links.get(**index as usize).map(|link| link.alarm_references);
                match known {
                    Some((Some(one), Some(other))) if exactly || is_end => (one, other) == references,
                    _ => !exactly,
                }
            });
            found.copied()
        };
        for exactly in [true, false] {
            if let Some(index) = find((destination, source), (dst, src), exactly) {
                return Some((index, FrameDirection::ToController));
            }
            if let Some(index) = find((source, destination), (src, dst), exactly) {
                return Some((index, FrameDirection::ToDevice));
            }
        }
        let pairs = [(destination, source), (source, destination)];
        if is_end && pairs.iter().any(|pair| self.by_pair.contains_key(pair)) {
            return None;
        }
        let direction = match &pdu.body {
            RtaBody::Notification(_) => FrameDirection::ToController,
            RtaBody::Acknowledgement(_) => FrameDirection::ToDevice,
            RtaBody::Error { .. } if self.stations.is_device(destination) => FrameDirection::ToDevice,
            RtaBody::Error { .. } => FrameDirection::ToController,
            RtaBody::Octets(_) => return None,
        };
        let (controller, device) = match direction {
            FrameDirection::ToController => (destination, source),
            FrameDirection::ToDevice => (source, destination),
        };
        let index = self.add_established(Uuid::NIL, controller, device)?;
        // Both sides send an ERR-RTA; only one of them answers DCP as a device.
        let shows_roles = !is_end || self.stations.is_device(device) != self.stations.is_device(controller);
        if let Some(ar) = self.ars.get_mut(index as usize) {
            ar.roles_known = shows_roles;
        }
        Some((index, direction))
    }

    /// Adds a connection that was established before the trace began.
    pub(super) fn add_established(&mut self, uuid: Uuid, controller: Mac, device: Mac) -> Option<u32> {
        let mut ar = established_connection(uuid, controller, device);
        self.stations.complete(&mut ar.controller);
        self.stations.complete(&mut ar.device);
        let index = self.add(ar, ArLink { macs: (controller, device), ..ArLink::default() })?;
        self.stands_between(index, [controller; 2], [device; 2]);
        Some(index)
    }

    /// Whether a DATA is new: its sequence number or its bytes differ from the last one of its direction and priority.
    fn is_new(
        &mut self,
        index: u32,
        direction: FrameDirection,
        priority: AlarmPriority,
        header: &RtaHeader,
        received: &ReceivedFrame<'_>,
    ) -> bool {
        let place =
            2 * usize::from(direction == FrameDirection::ToDevice) + usize::from(priority == AlarmPriority::High);
        let Some(link) = self.links.get_mut(index as usize) else { return true };
        let mut hasher = FxHasher::default();
        hasher.write(received.payload.get(HEAD..).unwrap_or_default());
        let now = Some((header.send_seq_num, hasher.finish()));
        let new = link.last_data[place] != now;
        link.last_data[place] = now;
        self.counts.repeated += u64::from(!new);
        new
    }
}
