//! LLDP: the device tells its neighbour who it is, and remembers who the neighbour is.

use super::StackBehaviour;
use crate::application::StationData;
use alloc::vec::Vec;
use station::{Duration, Outbox, Time};
use wire::ethernet::Mac;
use wire::lldp::{Lldp, Tlv};

/// Sends announcements, and keeps what the neighbour has announced.
#[derive(Debug)]
pub(super) struct Announcer {
    due: Time,
    neighbour: Option<Vec<u8>>,
}

impl Announcer {
    /// From announcement to announcement.
    const INTERVAL: Duration = Duration::from_secs(5);
    /// How long an announcement is true, in seconds.
    const TIME_TO_LIVE: u16 = 20;
    /// dot3MauType 100BASE-TX full duplex.
    const FAST_ETHERNET: u16 = 16;

    /// Announces from `now` on.
    pub(super) fn new(now: Time) -> Announcer {
        Announcer { due: now, neighbour: None }
    }

    /// When the next announcement is due.
    pub(super) fn due(&self) -> Time {
        self.due
    }

    /// Announces at `now` again; the neighbour may be another one.
    pub(super) fn restart(&mut self, now: Time) {
        *self = Announcer::new(now);
    }

    /// The name of the device by its position: port and name of the neighbour.
    pub(super) fn alias(&self) -> Option<&[u8]> {
        self.neighbour.as_deref()
    }

    /// Takes the announcement of a neighbour; what is none is passed over.
    pub(super) fn hear(&mut self, payload: &[u8]) {
        let Ok(lldp) = Lldp::parse(payload) else { return };
        let chassis = lldp.tlvs.iter().find_map(|tlv| match tlv {
            Tlv::ChassisId { subtype: Tlv::LOCALLY_ASSIGNED, id } => Some(id),
            _ => None,
        });
        let port = lldp.tlvs.iter().find_map(|tlv| match tlv {
            Tlv::PortId { subtype: Tlv::LOCALLY_ASSIGNED, id } => Some(id),
            _ => None,
        });
        self.neighbour = match (port, chassis) {
            (Some(port), _) if port.contains(&b'.') => Some(port.clone()),
            (Some(port), Some(chassis)) => Some([port, &b"."[..], chassis].concat()),
            (Some(_) | None, _) => None,
        };
    }

    /// Sends the announcement if it is due.
    pub(super) fn wake(
        &mut self,
        now: Time,
        mac: Mac,
        station: &StationData,
        behaviour: &StackBehaviour,
        out: &mut Outbox,
    ) {
        if now < self.due {
            return;
        }
        self.due = now + Announcer::INTERVAL;
        if !behaviour.announces_itself {
            return;
        }
        let locally_assigned = Tlv::LOCALLY_ASSIGNED;
        let (chassis, port) = if station.name.is_empty() {
            (Tlv::ChassisId { subtype: Tlv::CHASSIS_MAC_ADDRESS, id: mac.0.into() }, b"port-001".to_vec())
        } else {
            let chassis = Tlv::ChassisId { subtype: locally_assigned, id: station.name.clone() };
            (chassis, [b"port-001.", &station.name[..]].concat())
        };
        let lldp = Lldp {
            tlvs: [
                chassis,
                Tlv::PortId { subtype: locally_assigned, id: port },
                Tlv::TimeToLive(Announcer::TIME_TO_LIVE),
                Tlv::PortStatus { rt_class_2: 0, rt_class_3: 0 },
                Tlv::ChassisMac(mac),
                Tlv::MacPhy { autonegotiation: 3, advertised: 0x0C00, mau_type: Announcer::FAST_ETHERNET },
            ]
            .into(),
        };
        out.push_with(|frame| lldp.write_frame(mac, frame));
    }
}
