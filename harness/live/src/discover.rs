//! Which stations there are on a segment.
//!
//! All are asked twice by DCP who they are; nothing else is sent. This room must not know suites.

use controllers::profinet_io::{Controller, IdentifyBy, Outcome, Request, Settings, StationSeen};
use link::{LinkError, Step, Wire};
use plain_text::escaped;
use station::Duration;
use std::net::Ipv4Addr;
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::rt::{FrameId, FrameKind};

/// How often all stations are asked.
const ROUNDS: u32 = 2;
/// The name under which we ask.
const OWN_NAME: &str = "encspec";
/// Bits of the role of a station, as DCP numbers them.
const ROLES: [&str; 4] = ["device", "controller", "multidevice", "supervisor"];

/// A station that has answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// Its MAC address.
    pub mac: Mac,
    /// Its name of station as it was sent; empty where it has none.
    pub name: Vec<u8>,
    /// Its address; none where it has none.
    pub ip: Option<IpParameter>,
    /// Its vendor and device number, where it told them.
    pub ids: Option<(u16, u16)>,
    /// Its type in the words of its vendor, safe to show.
    pub station_type: String,
    /// What it is: `device`, `controller`, `multidevice`, `supervisor`.
    pub roles: Vec<&'static str>,
}

impl Found {
    /// Its name, safe to show; `-` where it has none.
    pub fn shown_name(&self) -> String {
        if self.name.is_empty() { "-".into() } else { escaped(&self.name) }
    }
}

impl From<&StationSeen> for Found {
    fn from(seen: &StationSeen) -> Found {
        let role = seen.role.unwrap_or(0);
        let roles = ROLES.iter().enumerate().filter(|(bit, _)| role & (1 << bit) != 0).map(|(_, word)| *word);
        Found {
            mac: seen.mac,
            name: seen.name.clone(),
            ip: Some(seen.ip).filter(|ip| ip.address != Ipv4Addr::UNSPECIFIED),
            ids: seen.id,
            station_type: escaped(&seen.station_type),
            roles: roles.collect(),
        }
    }
}

/// What a discovery has found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Survey {
    /// The stations, by MAC address.
    pub stations: Vec<Found>,
    /// What is wrong with them, one sentence each: names or addresses that several of them have.
    pub remarks: Vec<String>,
}

impl Survey {
    /// The survey of these stations; one that answered twice counts once.
    pub fn of(seen: &[StationSeen]) -> Survey {
        let mut stations: Vec<Found> = Vec::new();
        for found in seen.iter().map(Found::from) {
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

/// A sentence for each thing that several stations have.
fn same(stations: &[Found], of: impl Fn(&Found) -> Option<String>) -> Vec<String> {
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

/// Asks all stations on `wire` who they are and waits for their answers for `wait` in all.
///
/// We ask from the address `own`, which must be nobody else's. `stop` is asked now and then whether to give up.
pub fn discover(
    wire: &mut Wire,
    own: Mac,
    wait: Duration,
    stop: &mut dyn FnMut() -> bool,
) -> Result<Survey, LinkError> {
    let mut controller = Controller::new(Settings {
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
        let request = Request::Identify { by: IdentifyBy::All, wait: wait / ROUNDS };
        // A controller that has given its outcome is free.
        let _ = controller.request(now, request);
        while controller.is_busy() && !stop() {
            let until = wire.clock().now() + Duration::from_millis(50);
            let mut stations: [([u8; 6], &mut dyn station::Station); 1] = [(own.0, &mut controller)];
            while wire.step(&mut stations, until, &mut is_question, &mut |_, _| {})? == Step::Worked {}
        }
        if let Some(Outcome::Stations(stations)) = controller.take_outcome() {
            seen.extend(stations);
        }
    }
    Ok(Survey::of(&seen))
}

/// Whether a frame of ours is the question for all stations: no other one leaves.
fn is_question(frame: &[u8]) -> bool {
    FrameHeader::parse(frame).is_ok_and(|(header, payload)| {
        header.ether_type == EtherType::PROFINET
            && FrameId::peek(payload).is_ok_and(|id| id.kind() == FrameKind::DcpIdentifyRequest)
    })
}

/// Our address on a segment: a locally administered one made of the interface's, so that we are nobody else on it; a
/// fixed one on a socket.
pub fn own_mac(of_port: Option<[u8; 6]>) -> Mac {
    let Some(mut octets) = of_port else { return Mac([2, 0, 0, 0, 0, 1]) };
    octets[0] = if octets[0] & 2 == 0 { octets[0] | 2 } else { octets[0] ^ 4 } & !1;
    Mac(octets)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(last: u8, name: &str, address: [u8; 4]) -> StationSeen {
        StationSeen {
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
    fn stations_stand_by_address_and_what_several_have_is_said() {
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
            (first.shown_name(), first.ip, &*first.roles),
            ("press".into(), None, &["device", "controller"][..])
        );
        assert_eq!(survey.stations[1].shown_name(), "-");
        assert_eq!(first.station_type, "TYPE\\x1b[2J");
    }

    #[test]
    fn only_the_question_leaves() {
        use wire::profinet::dcp::{Dcp, Value};
        let mut question = Vec::new();
        Dcp::identify(1, 1, [Value::AllSelector].into()).write_frame(Mac::DCP_MULTICAST, own_mac(None), &mut question);
        assert!(is_question(&question));
        let mut signal = Vec::new();
        Dcp::signal(1).write_frame(Mac([2, 0, 0, 0, 1, 0]), own_mac(None), &mut signal);
        assert!(!is_question(&signal));
        assert!((0..16).all(|end| !is_question(&question[..end])));
    }

    #[test]
    fn our_address_is_not_the_interfaces() {
        assert_eq!(own_mac(Some([0x00, 0x1B, 0x1B, 1, 2, 3])), Mac([0x02, 0x1B, 0x1B, 1, 2, 3]));
        assert_eq!(own_mac(Some([0x02, 0, 0, 1, 2, 3])), Mac([0x06, 0, 0, 1, 2, 3]));
    }
}
