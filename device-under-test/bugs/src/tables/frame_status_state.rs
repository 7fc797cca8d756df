//! Deviations of the PROFINET stack with state about LLDP announcements, alarms and interruptions.

use crate::seams::stack::{change_lldp, profinet};
use alloc::vec::Vec;
use device_stack::profinet::{ArEvent, StackCheck, StackHooks, StackView, StationData, StationLoad};
use wire::profinet::alarm::{AlarmPriority, AlarmSpecifier, RtaBody, RtaKind, RtaPdu};

/// The announcements between two that are sent.
const DROPPED: u32 = 6;

/// Sends only each sixth announcement.
#[derive(Default)]
pub struct RareAnnouncements {
    made: u32,
}

impl StackHooks for RareAnnouncements {
    fn sent_frame(&mut self, _: &StackView<'_>, frame: &mut Vec<u8>) {
        change_lldp(frame, |_| {
            self.made += 1;
            self.made % DROPPED == 1
        });
    }
}

/// The alarm PDU in a frame with the offset at which it begins.
fn rta(frame: &[u8]) -> Option<(usize, RtaPdu)> {
    let (_, at, frame_id) = profinet(frame)?;
    AlarmPriority::from_frame_id(frame_id.0)?;
    Some((at + 2, RtaPdu::parse(&frame[at + 2..]).ok()?))
}

/// Drops each alarm with the sequence number of the one before.
#[derive(Default)]
pub struct AlarmsSentOnce {
    last: Option<(u16, u16)>,
}

impl StackHooks for AlarmsSentOnce {
    fn sent_frame(&mut self, _: &StackView<'_>, frame: &mut Vec<u8>) {
        let Some((_, pdu)) = rta(frame).filter(|(_, pdu)| pdu.header.kind == RtaKind::DATA) else { return };
        let number = Some((pdu.header.dst_endpoint, pdu.header.send_seq_num));
        if core::mem::replace(&mut self.last, number) == number {
            frame.clear();
        }
    }
}

/// Sends each alarm with the sequence number 0.
pub struct SameSequence;

impl StackHooks for SameSequence {
    fn sent_frame(&mut self, _: &StackView<'_>, frame: &mut Vec<u8>) {
        let Some((at, mut pdu)) = rta(frame) else { return };
        if let RtaBody::Notification(notification) = &mut pdu.body {
            notification.specifier = AlarmSpecifier::new(0, notification.specifier.0);
            let mut octets = Vec::new();
            pdu.write(&mut octets);
            frame.splice(at..at + octets.len(), octets);
        }
    }
}

/// Refuses every Connect after the second power-up.
#[derive(Default)]
pub struct RefusesAfterPowerLoss {
    starts: u32,
}

impl StackHooks for RefusesAfterPowerLoss {
    fn load_station(&mut self, start: StationLoad, _: &mut StationData) {
        self.starts += u32::from(start == StationLoad::PowerUp);
    }

    fn check(&mut self, check: StackCheck<'_>, verdict: bool) -> bool {
        verdict && !(self.starts > 1 && matches!(check, StackCheck::ConnectionLimit { .. }))
    }
}

/// Answers no DCP Identify while there is a connection.
#[derive(Default)]
pub struct SilentBesideConnection {
    connections: u32,
}

impl StackHooks for SilentBesideConnection {
    fn connection(&mut self, event: ArEvent) {
        self.connections = match event {
            ArEvent::Opened => self.connections + 1,
            ArEvent::Released | ArEvent::Aborted | ArEvent::Ended => self.connections.saturating_sub(1),
        };
    }

    fn load_station(&mut self, _: StationLoad, _: &mut StationData) {
        self.connections = 0;
    }

    fn check(&mut self, check: StackCheck<'_>, verdict: bool) -> bool {
        let is_identify = matches!(check, StackCheck::IdentifyAll | StackCheck::IdentifyName(..));
        verdict && !(self.connections > 0 && is_identify)
    }
}
