//! What a capture says about stations without a Connect: name, type, vendor and device ID by DCP, and what LLDP announces.

use judge::observe::{Observation, ObservedAr};
use plain_text::escaped;
use rustc_hash::FxHashMap;
use wire::ethernet::Mac;
use wire::lldp::{Lldp, Tlv};
use wire::profinet::dcp::{DcpValue, ServiceId, ServiceType};

/// Upper limit of the remembered stations.
const MOST: usize = 4_096;

/// What is known of a station.
#[derive(Clone, Debug, Default)]
pub(super) struct AnnouncedIdentity {
    pub name: Option<String>,
    ids: Option<(u16, u16)>,
    /// The type in DCP, or the description in LLDP.
    kind: Option<String>,
}

/// The stations of a capture.
#[derive(Clone, Debug, Default)]
pub(super) struct StationIdentities(FxHashMap<Mac, AnnouncedIdentity>);

impl StationIdentities {
    /// Takes in an answer of DCP, or LLDP.
    pub fn observe(&mut self, observation: &Observation<'_>) {
        match observation {
            Observation::Dcp { source, pdu, .. } => {
                let speaks_of_itself = matches!(
                    (pdu.service_id, pdu.service_type),
                    (ServiceId::IDENTIFY | ServiceId::GET, ServiceType::RESPONSE) | (ServiceId::HELLO, _)
                );
                let Some(known) = speaks_of_itself.then(|| self.of_mut(*source)).flatten() else { return };
                for block in pdu.blocks() {
                    match &block.value {
                        DcpValue::NameOfStation(name) if !name.is_empty() => known.name = Some(escaped(name)),
                        DcpValue::DeviceId { vendor_id, device_id } => known.ids = Some((*vendor_id, *device_id)),
                        DcpValue::Vendor(kind) if !kind.is_empty() => known.kind = Some(escaped(kind)),
                        _ => {}
                    }
                }
            }
            Observation::Lldp { source, pdu } => self.lldp(*source, pdu),
            _ => {}
        }
    }

    /// Its ports send with addresses of their own; the address of the station is in the announcement.
    fn lldp(&mut self, source: Mac, pdu: &Lldp) {
        let station = pdu.tlvs.iter().find_map(|tlv| match tlv {
            Tlv::ChassisMac(mac) => Some(*mac),
            _ => None,
        });
        let Some(known) = self.of_mut(station.unwrap_or(source)) else { return };
        for tlv in &pdu.tlvs {
            match tlv {
                Tlv::SystemDescription(text) if !text.is_empty() => {
                    known.kind.get_or_insert_with(|| escaped(text));
                }
                Tlv::SystemName(name) if !name.is_empty() => {
                    known.name.get_or_insert_with(|| escaped(name));
                }
                _ => {}
            }
        }
    }

    fn of_mut(&mut self, mac: Mac) -> Option<&mut AnnouncedIdentity> {
        let has_room = self.0.len() < MOST || self.0.contains_key(&mac);
        has_room.then(|| self.0.entry(mac).or_default())
    }

    /// What is known of a station, also from its connections.
    pub fn of(&self, mac: Mac, ars: &[ObservedAr]) -> AnnouncedIdentity {
        let mut identity = self.0.get(&mac).cloned().unwrap_or_default();
        for party in ars.iter().flat_map(|ar| [&ar.device, &ar.controller]).filter(|party| party.mac() == mac) {
            identity.name = identity.name.or_else(|| party.station.clone());
            identity.ids = identity.ids.or(party.ids);
        }
        identity
    }
}

impl AnnouncedIdentity {
    /// In words; `None` if nothing is known.
    pub fn words(&self) -> Option<String> {
        let name = self.name.as_ref().map(|name| format!("'{name}'"));
        let kind = self.kind.as_ref().map(|kind| format!("type '{kind}'"));
        let ids = self.ids.map(|(vendor, device)| format!("vendor 0x{vendor:04X} device 0x{device:04X}"));
        let words: Vec<String> = [name, kind, ids].into_iter().flatten().collect();
        (!words.is_empty()).then(|| words.join(", "))
    }
}
