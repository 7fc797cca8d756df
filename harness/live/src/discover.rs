//! Discovery: the stations on a segment.
//!
//! Sends DCP Identify to all stations twice and nothing else. This module must not know suites.

use controllers::profinet_io::{
    Controller, ControllerOutcome, ControllerRequest, ControllerSettings, IdentifiedStation, IdentifyBy,
};
use link::{LinkError, Wire, WireStep};
use plain_text::escaped;
use station::Duration;
use std::net::Ipv4Addr;
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::rt::{FrameId, FrameKind};

/// Number of Identify requests.
const ROUNDS: u32 = 2;
/// Interval of the calls to `stop`.
const STOP_INTERVAL: Duration = Duration::from_millis(50);
/// The name of station of the discovering controller.
const OWN_NAME: &str = "encspec";
/// Bits of the device role, as DCP numbers them.
const ROLES: [&str; 4] = ["device", "controller", "multidevice", "supervisor"];

/// A station that has answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DiscoveredStation {
    /// MAC address.
    pub mac: Mac,
    /// Name of station as sent; empty if it has none.
    pub name: Vec<u8>,
    /// IP parameters; `None` if it has none.
    pub ip: Option<IpParameter>,
    /// Vendor ID and device ID, if it sent them.
    pub ids: Option<(u16, u16)>,
    /// Device type as the vendor names it, without control characters.
    pub station_type: String,
    /// Roles: `device`, `controller`, `multidevice`, `supervisor`.
    pub roles: Vec<&'static str>,
}

impl DiscoveredStation {
    /// Its name without control characters; `-` if it has none.
    pub fn printable_name(&self) -> String {
        if self.name.is_empty() { "-".into() } else { escaped(&self.name) }
    }
}

impl From<&IdentifiedStation> for DiscoveredStation {
    fn from(seen: &IdentifiedStation) -> DiscoveredStation {
        let role = seen.role.unwrap_or(0);
        let roles = ROLES.iter().enumerate().filter(|(bit, _)| role & (1 << bit) != 0).map(|(_, word)| *word);
        DiscoveredStation {
            mac: seen.mac,
            name: seen.name.clone(),
            ip: Some(seen.ip).filter(|ip| ip.address != Ipv4Addr::UNSPECIFIED),
            ids: seen.id,
            station_type: escaped(&seen.station_type),
            roles: roles.collect(),
        }
    }
}

/// The result of a discovery.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Survey {
    /// The stations, by MAC address.
    pub stations: Vec<DiscoveredStation>,
    /// Problems, one sentence each: names or addresses that several stations have.
    pub remarks: Vec<String>,
}

impl Survey {
    /// The survey of these stations; one that answered twice counts once.
    pub fn of(seen: &[IdentifiedStation]) -> Survey {
        let mut stations: Vec<DiscoveredStation> = Vec::new();
        for found in seen.iter().map(DiscoveredStation::from) {
            match stations.iter_mut().find(|known| known.mac == found.mac) {
                Some(known) => *known = found,
                None => stations.push(found),
            }
        }
        stations.sort_by_key(|found| found.mac.0);
        let mut remarks = same(&stations, |found| {
            Some(&found.name).filter(|name| !name.is_empty()).map(|name| format!("the name {}", escaped(name)))
        });
        remarks.extend(same(&stations, |found| found.ip.map(|ip| format!("the address {}", ip.address))));
        Survey { stations, remarks }
    }
}

/// A sentence for each value that several stations share.
fn same(stations: &[DiscoveredStation], of: impl Fn(&DiscoveredStation) -> Option<String>) -> Vec<String> {
    let mut things: Vec<String> = stations.iter().filter_map(&of).collect();
    things.sort();
    things.dedup();
    let owners = |thing: &String| -> Vec<String> {
        let has_it = stations.iter().filter(|found| of(found).as_ref() == Some(thing));
        has_it.map(|found| found.mac.to_string()).collect()
    };
    let several = things.iter().map(|thing| (thing, owners(thing))).filter(|(_, owners)| owners.len() > 1);
    several.map(|(thing, owners)| format!("{} stations have {thing}: {}", owners.len(), owners.join(", "))).collect()
}

/// Sends Identify to all stations on `wire` and collects answers for `wait` in total. `own` is the MAC address of the requests,
/// which no other station may have. `stop` is called regularly and ends the discovery if it returns true.
pub fn discover(
    wire: &mut Wire,
    own: Mac,
    wait: Duration,
    stop: &mut dyn FnMut() -> bool,
) -> Result<Survey, LinkError> {
    let mut controller = Controller::new(ControllerSettings {
        mac: own,
        ip: Ipv4Addr::UNSPECIFIED,
        mask: Ipv4Addr::UNSPECIFIED,
        gateway: Ipv4Addr::UNSPECIFIED,
        station_name: OWN_NAME.into(),
        vendor_id: 0,
        device_id: 0,
        seed: u64::from(std::process::id()),
    });
    let mut seen = Vec::new();
    for _ in 0..ROUNDS {
        let now = wire.clock().now();
        let request = ControllerRequest::Identify { by: IdentifyBy::All, wait: wait / ROUNDS };
        // A controller that has returned its outcome is not busy.
        let _ = controller.request(now, request);
        while controller.is_busy() && !stop() {
            let until = wire.clock().now() + STOP_INTERVAL;
            let mut stations: [([u8; 6], &mut dyn station::Station); 1] = [(own.0, &mut controller)];
            while wire.step(&mut stations, until, &mut is_question, &mut |_, _| {})? == WireStep::Worked {}
        }
        if let Some(ControllerOutcome::Stations(stations)) = controller.take_outcome() {
            seen.extend(stations);
        }
    }
    Ok(Survey::of(&seen))
}

/// Whether a frame is the Identify request to all stations; no other frame leaves.
fn is_question(frame: &[u8]) -> bool {
    FrameHeader::parse(frame).is_ok_and(|(header, payload)| {
        header.ether_type == EtherType::PROFINET
            && FrameId::peek(payload).is_ok_and(|id| id.kind() == FrameKind::DcpIdentifyRequest)
    })
}

/// The MAC address of the discovering controller: a locally administered one derived from the interface's, so that it differs
/// from every other station; a fixed one on a socket.
pub fn own_mac(of_port: Option<[u8; 6]>) -> Mac {
    let Some(mut octets) = of_port else { return Mac([2, 0, 0, 0, 0, 1]) };
    octets[0] = if octets[0] & 2 == 0 { octets[0] | 2 } else { octets[0] ^ 4 } & !1;
    Mac(octets)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(last: u8, name: &str, address: [u8; 4]) -> IdentifiedStation {
        IdentifiedStation {
            mac: Mac([2, 0, 0, 0, 1, last]),
            name: name.into(),
            ip: IpParameter { address: address.into(), ..IpParameter::NONE },
            id: Some((0x0239, 1)),
            station_type: b"TYPE\x1b[2J".to_vec(),
            role: Some(0b0011),
            blocks: Vec::new(),
        }
    }

    #[test]
    fn stations_are_sorted_by_address_and_shared_values_are_reported() {
        let survey = Survey::of(&[
            seen(3, "press", [192, 168, 0, 10]),
            seen(1, "press", [0; 4]),
            seen(2, "", [192, 168, 0, 10]),
            seen(4, "", [0; 4]),
            seen(3, "press", [192, 168, 0, 10]),
        ]);
        let macs: Vec<u8> = survey.stations.iter().map(|found| found.mac.0[5]).collect();
        assert_eq!(macs, [1, 2, 3, 4]);
        assert_eq!(
            survey.remarks,
            [
                "2 stations have the name press: 02:00:00:00:01:01, 02:00:00:00:01:03",
                "2 stations have the address 192.168.0.10: 02:00:00:00:01:02, 02:00:00:00:01:03",
            ]
        );
        let first = &survey.stations[0];
        assert_eq!(
            (first.printable_name(), first.ip, &*first.roles),
            ("press".into(), None, &["device", "controller"][..])
        );
        assert_eq!(survey.stations[1].printable_name(), "-");
        assert_eq!(first.station_type, "TYPE\\x1b[2J");
    }

    #[test]
    fn only_the_identify_request_leaves() {
        use wire::profinet::dcp::{Dcp, DcpValue};
        let mut question = Vec::new();
        Dcp::identify(1, 1, [DcpValue::AllSelector].into()).write_frame(
            Mac::DCP_MULTICAST,
            own_mac(None),
            &mut question,
        );
        assert!(is_question(&question));
        let mut signal = Vec::new();
        Dcp::signal(1).write_frame(Mac([2, 0, 0, 0, 1, 0]), own_mac(None), &mut signal);
        assert!(!is_question(&signal));
        assert!((0..16).all(|end| !is_question(&question[..end])));
    }

    #[test]
    fn the_address_of_the_controller_differs_from_the_interface() {
        assert_eq!(own_mac(Some([0x00, 0x1B, 0x1B, 1, 2, 3])), Mac([0x02, 0x1B, 0x1B, 1, 2, 3]));
        assert_eq!(own_mac(Some([0x02, 0, 0, 1, 2, 3])), Mac([0x06, 0, 0, 1, 2, 3]));
    }
}
