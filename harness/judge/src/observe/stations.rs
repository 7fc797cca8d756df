//! What stations say of themselves in DCP: their names and numbers.

use super::tracker::{Seen, Sink, Tracker};
use super::{Observation, Party};
use plain_text::escaped;
use rustc_hash::FxHashMap;
use wire::ethernet::Mac;
use wire::profinet::dcp::{Dcp, ServiceId, ServiceType, Value};

/// Stations that are remembered.
const MOST_STATIONS: usize = 4_096;

/// The stations that have spoken of themselves.
#[derive(Debug, Default)]
pub(super) struct Stations(FxHashMap<Mac, Known>);

#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Known {
    name: Option<String>,
    ids: Option<(u16, u16)>,
}

impl Stations {
    /// Takes in what a station says; false where it was known.
    fn learn(&mut self, mac: Mac, pdu: &Dcp) -> bool {
        if self.0.len() >= MOST_STATIONS && !self.0.contains_key(&mac) {
            return false;
        }
        let known = self.0.entry(mac).or_default();
        let before = known.clone();
        for block in pdu.blocks() {
            match &block.value {
                Value::NameOfStation(name) => known.name = Some(escaped(name)),
                Value::DeviceId { vendor_id, device_id } => known.ids = Some((*vendor_id, *device_id)),
                _ => {}
            }
        }
        *known != before
    }

    /// Fills in what the party itself has not said.
    pub fn complete(&self, party: &mut Party) {
        if let Some(known) = self.0.get(&party.mac()) {
            let name = || known.name.clone().filter(|name| !name.is_empty());
            party.station = party.station.take().or_else(name);
            party.ids = party.ids.or(known.ids);
        }
    }

    /// Whether the station has said which device it is.
    pub fn is_device(&self, mac: Mac) -> bool {
        self.0.get(&mac).is_some_and(|known| known.ids.is_some())
    }
}

impl Tracker {
    pub(super) fn dcp(&mut self, seen: &Seen<'_>, sink: Sink<'_>) {
        let pdu = match Dcp::parse(seen.payload) {
            Ok(pdu) => pdu,
            Err(error) => return self.unreadable(error.behind(seen.at()), sink),
        };
        let (source, destination) = (seen.header.source, seen.header.destination);
        let speaks_of_itself = matches!(
            (pdu.service_id, pdu.service_type),
            (ServiceId::IDENTIFY | ServiceId::GET, ServiceType::RESPONSE) | (ServiceId::HELLO, _)
        );
        if speaks_of_itself && self.stations.learn(source, &pdu) {
            for ar in &mut self.ars {
                for party in [&mut ar.controller, &mut ar.device] {
                    if party.mac() == source {
                        self.stations.complete(party);
                    }
                }
            }
        }
        sink(&self.ars, Observation::Dcp { source, destination, pdu: &pdu });
    }
}
