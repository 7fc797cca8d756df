//! Names and device IDs that stations report in DCP.

use super::tracker::{ReceivedFrame, Sink, Tracker};
use super::{Observation, Party, Traffic};
use plain_text::escaped;
use rustc_hash::FxHashMap;
use wire::ethernet::Mac;
use wire::profinet::dcp::{Dcp, DcpValue, ServiceId, ServiceType};
use wire::profinet::rt::{FrameId, FrameKind};

/// Maximum number of stored stations.
const MOST_STATIONS: usize = 4_096;

/// Stations by MAC address.
#[derive(Debug, Default)]
pub(super) struct StationTable(FxHashMap<Mac, StationEntry>);

#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct StationEntry {
    name: Option<String>,
    ids: Option<(u16, u16)>,
}

impl StationTable {
    /// Stores the values in a DCP frame; returns whether they are new.
    fn learn(&mut self, mac: Mac, pdu: &Dcp) -> bool {
        if self.0.len() >= MOST_STATIONS && !self.0.contains_key(&mac) {
            return false;
        }
        let known = self.0.entry(mac).or_default();
        let before = known.clone();
        for block in pdu.blocks() {
            match &block.value {
                DcpValue::NameOfStation(name) => known.name = Some(escaped(name)),
                DcpValue::DeviceId { vendor_id, device_id } => known.ids = Some((*vendor_id, *device_id)),
                _ => {}
            }
        }
        *known != before
    }

    /// Stores the identity of a station that a later frame of the trace shows.
    pub fn know(&mut self, mac: Mac, ids: (u16, u16)) {
        if self.0.len() < MOST_STATIONS {
            self.0.entry(mac).or_default().ids = Some(ids);
        }
    }

    /// Fills in missing values of a party.
    pub fn complete(&self, party: &mut Party) {
        if let Some(known) = self.0.get(&party.mac()) {
            let name = || known.name.clone().filter(|name| !name.is_empty());
            party.station = party.station.take().or_else(name);
            party.ids = party.ids.or(known.ids);
        }
    }

    /// Whether the station has reported a device ID.
    pub fn is_device(&self, mac: Mac) -> bool {
        self.0.get(&mac).is_some_and(|known| known.ids.is_some())
    }
}

impl Tracker {
    pub(super) fn dcp(&mut self, received: &ReceivedFrame<'_>, sink: Sink<'_>) {
        let pdu = match Dcp::parse(received.payload) {
            Ok(pdu) => pdu,
            Err(error) => {
                let is_answer = FrameId::peek(received.payload)
                    .is_ok_and(|id| id.kind() == FrameKind::DcpIdentifyResponse)
                    || received.payload.get(3) == Some(&ServiceType::RESPONSE.0);
                if is_answer && self.is_recorded {
                    let (source, destination) = (received.header.source, received.header.destination);
                    let (service, is_proven, why) = ("DCP", false, error.to_string());
                    let why = why.as_str();
                    let answer = Traffic::AnswerMalformed { ar: None, service, source, destination, is_proven, why };
                    sink(&self.ars, Observation::Traffic(answer));
                }
                return self.unreadable(error.at_offset(received.at()), sink);
            }
        };
        let (source, destination) = (received.header.source, received.header.destination);
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
