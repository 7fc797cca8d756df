//! The effects of DCP frames on stations: names, addresses, resets.

use super::report::EventKind;
use plain_text::escaped;
use rustc_hash::FxHashMap;
use wire::ethernet::Mac;
use wire::profinet::dcp::{BlockError, Dcp, DcpValue, ServiceId, ServiceType};

/// Upper limit of the remembered stations.
const MOST_STATIONS: usize = 4_096;

/// The names of the stations.
#[derive(Debug, Default)]
pub(super) struct StationNames {
    names: FxHashMap<Mac, String>,
}

impl StationNames {
    /// Takes in a frame.
    pub fn observe(&mut self, source: Mac, destination: Mac, pdu: &Dcp) -> Vec<(EventKind, String)> {
        let mut events = Vec::new();
        match (pdu.service_id, pdu.service_type) {
            (ServiceId::SET, ServiceType::REQUEST) => {
                events = pdu.blocks().iter().filter_map(|block| self.set(source, destination, block)).collect();
            }
            (ServiceId::SET, ServiceType::RESPONSE) => {
                for block in pdu.blocks() {
                    if let DcpValue::Response { element, error } = &block.value
                        && *error != BlockError::OK
                    {
                        let of = element.word().map_or_else(
                            || format!("element {}/{}", element.option, element.suboption),
                            |word| word.replace('_', " "),
                        );
                        let why = error.sentence().map_or_else(|| format!("block error {}", error.0), str::to_owned);
                        let text = format!("{source} refuses to set {of}: {}", why.trim_end_matches('.'));
                        events.push((EventKind::DcpRefused, text));
                    }
                }
            }
            (ServiceId::SET, _) => {
                events.push((EventKind::DcpRefused, format!("{source} does not support DCP Set")));
            }
            (ServiceId::IDENTIFY | ServiceId::GET, ServiceType::RESPONSE) | (ServiceId::HELLO, _) => {
                for block in pdu.blocks() {
                    if let DcpValue::NameOfStation(name) = &block.value {
                        self.named(source, escaped(name));
                    }
                }
            }
            _ => {}
        }
        events
    }

    /// The event of a DCP Set of one element.
    fn set(&mut self, source: Mac, station: Mac, block: &wire::profinet::dcp::DcpBlock) -> Option<(EventKind, String)> {
        let lasting = if block.qualifier().is_permanent() { "permanently" } else { "until power-off" };
        Some(match &block.value {
            DcpValue::NameOfStation(name) => {
                let name = escaped(name);
                let before = match self.names.get(&station).map(String::as_str) {
                    None => String::new(),
                    Some("") => "; it had no name before".to_owned(),
                    Some(before) => format!("; its name was '{before}' before"),
                };
                let text = format!("{source} gives {station} the name '{name}' {lasting}{before}");
                (EventKind::Rename, text)
            }
            DcpValue::IpParameter(ip) | DcpValue::FullIpSuite(ip, _) => {
                let text = format!(
                    "{source} gives {station} the IP address {}, mask {}, gateway {} {lasting}",
                    ip.address, ip.mask, ip.gateway
                );
                (EventKind::DcpSet, text)
            }
            DcpValue::ResetToFactory => {
                let mode = block.qualifier().reset_mode();
                let what = mode.word().map_or_else(|| format!("mode {}", mode.0), |word| word.replace('_', " "));
                (EventKind::DcpReset, format!("{source} resets {station} to factory settings: {what}"))
            }
            DcpValue::FactoryReset => (EventKind::DcpReset, format!("{source} resets {station} (suboption 5)")),
            DcpValue::Signal(_) => (EventKind::DcpSignal, format!("{source} makes {station} flash its LED")),
            DcpValue::Start | DcpValue::Stop => return None,
            other => {
                let element = other.element();
                let of = element.word().map_or_else(
                    || format!("element {}/{}", element.option, element.suboption),
                    |word| word.replace('_', " "),
                );
                (EventKind::DcpSet, format!("{source} sets {of} of {station} {lasting}"))
            }
        })
    }

    /// Notes the name that a station reports.
    fn named(&mut self, station: Mac, name: String) {
        if self.names.len() < MOST_STATIONS || self.names.contains_key(&station) {
            self.names.insert(station, name);
        }
    }
}
