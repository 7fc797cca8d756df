//! What DCP frames do to stations: names, addresses, resets.

use super::report::EventKind;
use plain_text::escaped;
use rustc_hash::FxHashMap;
use wire::ethernet::Mac;
use wire::profinet::dcp::{BlockError, Dcp, ServiceId, ServiceType, Value};

/// Stations that are remembered.
const MOST_STATIONS: usize = 4_096;

/// The stations by their names.
#[derive(Debug, Default)]
pub(super) struct Stations {
    names: FxHashMap<Mac, String>,
}

impl Stations {
    /// Takes in a frame.
    pub fn observe(&mut self, source: Mac, destination: Mac, pdu: &Dcp) -> Vec<(EventKind, String)> {
        let mut told = Vec::new();
        match (pdu.service_id, pdu.service_type) {
            (ServiceId::SET, ServiceType::REQUEST) => {
                told = pdu.blocks().iter().filter_map(|block| self.set(source, destination, block)).collect();
            }
            (ServiceId::SET, ServiceType::RESPONSE) => {
                for block in pdu.blocks() {
                    if let Value::Response { element, error } = &block.value
                        && *error != BlockError::OK
                    {
                        let of = element.word().map_or_else(
                            || format!("element {}/{}", element.option, element.suboption),
                            |word| word.replace('_', " "),
                        );
                        let why = error.sentence().map_or_else(|| format!("block error {}", error.0), str::to_owned);
                        let text = format!("{source} refuses to set {of}: {}", why.trim_end_matches('.'));
                        told.push((EventKind::DcpRefused, text));
                    }
                }
            }
            (ServiceId::SET, _) => {
                told.push((EventKind::DcpRefused, format!("{source} does not support to be set by DCP")));
            }
            (ServiceId::IDENTIFY | ServiceId::GET, ServiceType::RESPONSE) | (ServiceId::HELLO, _) => {
                for block in pdu.blocks() {
                    if let Value::NameOfStation(name) = &block.value {
                        self.named(source, escaped(name));
                    }
                }
            }
            _ => {}
        }
        told
    }

    /// Somebody sets an element of a station.
    fn set(&mut self, source: Mac, station: Mac, block: &wire::profinet::dcp::Block) -> Option<(EventKind, String)> {
        let lasting = if block.qualifier().is_permanent() { "for good" } else { "until it is switched off" };
        Some(match &block.value {
            Value::NameOfStation(name) => {
                let name = escaped(name);
                let before = match self.names.get(&station).map(String::as_str) {
                    None => String::new(),
                    Some("") => ", who had no name".to_owned(),
                    Some(before) => format!(", who was '{before}'"),
                };
                let text = format!("{source} names {station}{before}: '{name}' {lasting}");
                (EventKind::Rename, text)
            }
            Value::IpParameter(ip) | Value::FullIpSuite(ip, _) => {
                let text = format!(
                    "{source} gives {station} the address {} / {} via {} {lasting}",
                    ip.address, ip.mask, ip.gateway
                );
                (EventKind::DcpSet, text)
            }
            Value::ResetToFactory => {
                let mode = block.qualifier().reset_mode();
                let what = mode.word().map_or_else(|| format!("mode {}", mode.0), |word| word.replace('_', " "));
                (EventKind::DcpReset, format!("{source} resets {station} to its factory values: {what}"))
            }
            Value::FactoryReset => (EventKind::DcpReset, format!("{source} resets {station} (suboption 5)")),
            Value::Signal(_) => (EventKind::DcpSignal, format!("{source} lets {station} flash")),
            Value::Start | Value::Stop => return None,
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

    /// A station says its name.
    fn named(&mut self, station: Mac, name: String) {
        if self.names.len() < MOST_STATIONS || self.names.contains_key(&station) {
            self.names.insert(station, name);
        }
    }
}
