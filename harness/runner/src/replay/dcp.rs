//! What DCP frames do to stations: names, addresses, resets; and two stations with one name.

use super::report::{EventKind, Finding, Severity};
use crate::observe::escaped;
use rustc_hash::{FxHashMap, FxHashSet};
use wire::ethernet::Mac;
use wire::profinet::dcp::{BlockError, Dcp, ServiceId, ServiceType, Value};

/// Stations that are remembered.
const MOST_STATIONS: usize = 4_096;

/// The stations by their names.
#[derive(Debug, Default)]
pub(super) struct Stations {
    names: FxHashMap<Mac, String>,
    owners: FxHashMap<String, Mac>,
    told: FxHashSet<String>,
}

/// What a DCP frame tells.
#[derive(Debug, Default)]
pub(super) struct Told {
    pub events: Vec<(EventKind, String)>,
    pub finding: Option<Finding>,
}

impl Stations {
    /// Takes in a frame.
    pub fn observe(&mut self, frame: u64, source: Mac, destination: Mac, pdu: &Dcp) -> Told {
        let mut told = Told::default();
        match (pdu.service_id, pdu.service_type) {
            (ServiceId::SET, ServiceType::REQUEST) => {
                told.events = pdu.blocks().iter().filter_map(|block| self.set(source, destination, block)).collect();
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
                        told.events.push((EventKind::DcpRefused, text));
                    }
                }
            }
            (ServiceId::SET, _) => {
                told.events.push((EventKind::DcpRefused, format!("{source} does not support to be set by DCP")));
            }
            (ServiceId::IDENTIFY | ServiceId::GET, ServiceType::RESPONSE) | (ServiceId::HELLO, _) => {
                for block in pdu.blocks() {
                    if let Value::NameOfStation(name) = &block.value {
                        told.finding = self.named(frame, source, escaped(name)).or(told.finding);
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

    /// A station says its name; a finding where another station has said the same and neither was renamed in between.
    fn named(&mut self, frame: u64, station: Mac, name: String) -> Option<Finding> {
        if self.names.len() >= MOST_STATIONS && !self.names.contains_key(&station) {
            return None;
        }
        if let Some(before) = self.names.insert(station, name.clone())
            && before != name
            && self.owners.get(&before) == Some(&station)
        {
            self.owners.remove(&before);
        }
        if name.is_empty() {
            return None;
        }
        let owner = *self.owners.entry(name.clone()).or_insert(station);
        if owner == station || !self.told.insert(name.clone()) {
            return None;
        }
        Some(Finding {
            id: "duplicate-station-name".into(),
            severity: Severity::Error,
            frame,
            text: format!(
                "{station} and {owner} both say that they are '{name}': a controller will find neither safely"
            ),
        })
    }
}
