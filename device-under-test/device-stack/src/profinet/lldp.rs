//! LLDP: the device announces itself to its neighbour and stores the announcement of the neighbour.

use super::physical::port_name;
use super::plugged::PORT_SUBSLOT;
use alloc::borrow::Cow;
use alloc::format;
use alloc::vec::Vec;
use station::{Duration, Outbox, Time};
use wire::ethernet::Mac;
use wire::lldp::{Lldp, Tlv};

/// dot3MauType 100BASE-TX full duplex.
pub(super) const FAST_ETHERNET: u16 = 16;

/// Sends announcements and stores the last announcement of the neighbour.
#[derive(Debug)]
pub(super) struct LldpAgent {
    due: Time,
    neighbour: Option<LldpNeighbour>,
    announcement: Option<ReceivedAnnouncement>,
}

/// The last announcement of the neighbour, for the remote systems of LLDP-MIB.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct ReceivedAnnouncement {
    /// Subtype and content of the chassis ID.
    pub chassis: (u8, Vec<u8>),
    /// Subtype and content of the port ID.
    pub port: (u8, Vec<u8>),
    /// Description of the port; empty without one.
    pub port_description: Vec<u8>,
    /// Name of the system; empty without one.
    pub system_name: Vec<u8>,
    /// Description of the system; empty without one.
    pub system_description: Vec<u8>,
    /// Supported and enabled functions.
    pub capabilities: (u16, u16),
    /// When the announcement is no longer valid.
    until: Time,
}

impl ReceivedAnnouncement {
    /// The announcement that was received at `now`; `None` if it ends the validity at once.
    fn new(now: Time, lldp: &Lldp) -> Option<ReceivedAnnouncement> {
        let mut of = ReceivedAnnouncement::default();
        for tlv in &lldp.tlvs {
            match tlv {
                Tlv::ChassisId { subtype, id } => of.chassis = (*subtype, id.clone()),
                Tlv::PortId { subtype, id } => of.port = (*subtype, id.clone()),
                Tlv::TimeToLive(seconds) => of.until = now + Duration::from_secs(u64::from(*seconds)),
                Tlv::PortDescription(text) => of.port_description.clone_from(text),
                Tlv::SystemName(text) => of.system_name.clone_from(text),
                Tlv::SystemDescription(text) => of.system_description.clone_from(text),
                Tlv::SystemCapabilities { capabilities, enabled } => of.capabilities = (*capabilities, *enabled),
                _ => {}
            }
        }
        (of.until > now).then_some(of)
    }
}

/// The station at the other end of the cable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct LldpNeighbour {
    /// Name of its port.
    pub port: Vec<u8>,
    /// Its name of station; empty without a name.
    pub name: Vec<u8>,
    /// Its MAC address.
    pub mac: Mac,
}

/// The MAC addresses in an announcement.
#[derive(Clone, Copy, Debug)]
pub(super) struct LldpMacs {
    /// The address of the device, in the TLVs.
    pub station: Mac,
    /// The address of the port, the source of the frame.
    pub port: Mac,
}

/// Subtype and content of the chassis ID of the device: its name, or its MAC address without one.
pub(super) fn chassis_id<'a>(station: &'a Mac, name: &'a [u8]) -> (u8, &'a [u8]) {
    match name {
        [] => (Tlv::CHASSIS_MAC_ADDRESS, &station.0),
        name => (Tlv::LOCALLY_ASSIGNED, name),
    }
}

/// The port ID of a port of the device: its name, and behind a dot that of the station if it has one.
pub(super) fn port_id(port: &str, name: &[u8]) -> Vec<u8> {
    if name.is_empty() { port.as_bytes().to_vec() } else { [port.as_bytes(), b".", name].concat() }
}

impl LldpNeighbour {
    /// Its name, or its MAC address as text.
    pub(super) fn chassis(&self) -> Cow<'_, [u8]> {
        if !self.name.is_empty() {
            return Cow::Borrowed(&self.name);
        }
        let [a, b, c, d, e, f] = self.mac.0;
        Cow::Owned(format!("{a:02X}-{b:02X}-{c:02X}-{d:02X}-{e:02X}-{f:02X}").into_bytes())
    }

    /// The alias name of the device: port and name of its neighbour.
    pub(super) fn alias(&self) -> Option<Vec<u8>> {
        (!self.name.is_empty()).then(|| [&self.port, &b"."[..], &self.name].concat())
    }
}

impl LldpAgent {
    /// Interval between announcements.
    pub(super) const INTERVAL: Duration = Duration::from_secs(5);
    /// TimeToLive of an announcement in seconds.
    pub(super) const TIME_TO_LIVE: u16 = 20;

    /// Sends the first announcement at `now`.
    pub(super) fn new(now: Time) -> LldpAgent {
        LldpAgent { due: now, neighbour: None, announcement: None }
    }

    /// When the next announcement is due.
    pub(super) fn due(&self) -> Time {
        self.due
    }

    /// Sends an announcement at `now` and forgets the neighbour, which may have changed.
    pub(super) fn restart(&mut self, now: Time) {
        *self = LldpAgent::new(now);
    }

    /// Sends an announcement at `now` and keeps the neighbour.
    pub(super) fn announce(&mut self, now: Time) {
        self.due = now;
    }

    /// The neighbour, after its first announcement.
    pub(super) fn neighbour(&self) -> Option<&LldpNeighbour> {
        self.neighbour.as_ref()
    }

    /// The last announcement of the neighbour, if it is valid at `now`.
    pub(super) fn announcement(&self, now: Time) -> Option<&ReceivedAnnouncement> {
        self.announcement.as_ref().filter(|of| of.until > now)
    }

    /// Stores the announcement of a neighbour. Other payloads are ignored.
    pub(super) fn receive(&mut self, now: Time, source: Mac, payload: &[u8]) {
        let Ok(lldp) = Lldp::parse(payload) else { return };
        self.announcement = ReceivedAnnouncement::new(now, &lldp);
        let chassis = lldp.tlvs.iter().find_map(|tlv| match tlv {
            Tlv::ChassisId { subtype: Tlv::LOCALLY_ASSIGNED, id } => Some(id),
            _ => None,
        });
        let port = lldp.tlvs.iter().find_map(|tlv| match tlv {
            Tlv::PortId { subtype: Tlv::LOCALLY_ASSIGNED, id } => Some(id),
            _ => None,
        });
        let mac = lldp.tlvs.iter().find_map(|tlv| if let Tlv::ChassisMac(mac) = tlv { Some(*mac) } else { None });
        self.neighbour = port.map(|port| {
            let mut parts = port.splitn(2, |byte| *byte == b'.');
            let port = parts.next().unwrap_or_default().to_vec();
            let name = parts.next().or(chassis.map(Vec::as_slice)).unwrap_or_default().to_vec();
            LldpNeighbour { port, name, mac: mac.unwrap_or(source) }
        });
    }

    /// Sends the announcement from port 1, which has the cable, if it is due.
    pub(super) fn wake(&mut self, now: Time, macs: LldpMacs, name: &[u8], out: &mut Outbox) {
        if now < self.due {
            return;
        }
        self.due = now + LldpAgent::INTERVAL;
        let (subtype, chassis) = chassis_id(&macs.station, name);
        let lldp = Lldp {
            tlvs: [
                Tlv::ChassisId { subtype, id: chassis.to_vec() },
                Tlv::PortId { subtype: Tlv::LOCALLY_ASSIGNED, id: port_id(&port_name(PORT_SUBSLOT), name) },
                Tlv::TimeToLive(LldpAgent::TIME_TO_LIVE),
                Tlv::PortStatus { rt_class_2: 0, rt_class_3: 0 },
                Tlv::ChassisMac(macs.station),
                Tlv::MacPhy { autonegotiation: 3, advertised: 0x0C00, mau_type: FAST_ETHERNET },
            ]
            .into(),
        };
        out.push_with(|frame| lldp.write_frame(macs.port, frame));
    }
}
