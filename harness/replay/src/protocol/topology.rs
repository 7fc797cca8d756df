//! Neighbours by LLDP: ports that announce themselves, that stop, or that appear later.

use super::coverage::{CaptureCoverage, CapturePosition, FindingList, SettledFrames};
use super::table::TOPOLOGY_CHANGED;
use crate::finding::{CaptureBlame, FindingSeverity};
use plain_text::escaped;
use station::{Duration, Time};
use std::collections::BTreeMap;
use wire::ethernet::Mac;
use wire::lldp::{Lldp, Tlv};

/// Upper limit of the remembered ports.
const MOST: usize = 1_024;
/// How long an announcement is valid if it has no time to live.
const TIME_TO_LIVE: Duration = Duration::from_secs(20);

/// A port that announces itself.
#[derive(Clone, Debug)]
struct AnnouncedPort {
    time_to_live: Duration,
    first: CapturePosition,
    last: CapturePosition,
    said_goodbye: bool,
}

/// The ports of a capture, by source MAC address and the identity in their announcements.
///
/// Two stacks on one host may announce themselves from one address in turns.
#[derive(Clone, Debug, Default)]
pub(super) struct Topology {
    ports: BTreeMap<(Mac, String), AnnouncedPort>,
    /// The time of the first LLDP frame of the capture.
    begun: Option<Time>,
    /// The time of the last one.
    last: Time,
}

impl Topology {
    pub fn observe(&mut self, now: CapturePosition, source: Mac, pdu: &Lldp) {
        self.begun.get_or_insert(now.time);
        self.last = now.time;
        let (mut chassis, mut port, mut time_to_live) = (String::new(), String::new(), TIME_TO_LIVE);
        for tlv in &pdu.tlvs {
            match tlv {
                Tlv::ChassisId { subtype: Tlv::CHASSIS_MAC_ADDRESS, id } => {
                    chassis = <[u8; 6]>::try_from(&id[..]).map_or_else(|_| escaped(id), |mac| Mac(mac).to_string());
                }
                Tlv::ChassisId { id, .. } => chassis = escaped(id),
                Tlv::PortId { id, .. } => port = escaped(id),
                Tlv::TimeToLive(seconds) => time_to_live = Duration::from_secs((*seconds).into()),
                _ => {}
            }
        }
        let name = format!("port '{port}' of '{chassis}'");
        let said_goodbye = time_to_live.is_zero();
        let has_room = self.ports.len() < MOST;
        match self.ports.get_mut(&(source, name.clone())) {
            Some(known) => {
                (known.last, known.said_goodbye) = (now, said_goodbye);
                if !said_goodbye {
                    known.time_to_live = time_to_live;
                }
            }
            None if has_room => {
                self.ports.insert((source, name), AnnouncedPort { time_to_live, first: now, last: now, said_goodbye });
            }
            None => {}
        }
    }

    pub fn end(self, sight: &CaptureCoverage, findings: &mut FindingList) {
        let mut report = |severity, frame: u64, text: String| {
            findings.add(TOPOLOGY_CHANGED.finding(severity, CaptureBlame::Network, frame, text));
        };
        let Some(begun) = self.begun else { return };
        // When any port announced itself last, and when any port of another station did.
        let mut latest: [Option<(Mac, CapturePosition)>; 2] = [None; 2];
        for ((mac, _), port) in &self.ports {
            let later = |than: Option<(Mac, CapturePosition)>| than.is_none_or(|(_, than)| port.last.time > than.time);
            match latest[0] {
                Some((first, _)) if first == *mac && later(latest[0]) => latest[0] = Some((*mac, port.last)),
                Some((first, _)) if first == *mac => {}
                first if later(first) => latest = [Some((*mac, port.last)), first],
                _ if later(latest[1]) => latest[1] = Some((*mac, port.last)),
                _ => {}
            }
        }
        for ((mac, name), port) in &self.ports {
            let of_station = || self.ports.range((*mac, String::new())..).take_while(|((other, _), _)| other == mac);
            let of_mac = |(other, _): &(&(Mac, String), &AnnouncedPort)| other.1 != *name;
            // Another name of the same port, first announced after this one was announced last.
            let became = of_station().filter(of_mac).filter(|(_, other)| other.first.frame > port.last.frame);
            let became = became.min_by_key(|(_, other)| other.first.frame);
            if let Some(((_, after), other)) = became {
                // The port is the same; its station was given another name.
                report(
                    FindingSeverity::Info,
                    other.first.frame,
                    format!("{mac} now announces itself as {after}, before as {name}"),
                );
                continue;
            }
            // A later announcement of another port shows that the capture still had LLDP then.
            let others = latest.into_iter().flatten().find(|(other, _)| other != mac);
            let silent_for = others.map(|(_, last)| last.time.since(port.last.time)).unwrap_or_default();
            if port.said_goodbye {
                report(FindingSeverity::Warning, port.last.frame, format!("{name} ({mac}) announces its shutdown"));
            } else if silent_for > port.time_to_live && sight.now.since(port.last).is_some() {
                report(
                    FindingSeverity::Warning,
                    port.last.frame,
                    format!("{name} ({mac}) is no longer announced after this frame"),
                );
            }
            // Announcements are repeated several times within their time to live, so a port first announced later was connected later.
            let was_other = of_station().any(|of| of_mac(&of));
            let late = port.first.time.since(begun);
            if !was_other
                && late > port.time_to_live
                && port.first.piece == 0
                && self.last.since(begun) > port.time_to_live
            {
                report(
                    FindingSeverity::Warning,
                    port.first.frame,
                    format!("{name} ({mac}) is announced only from this frame on"),
                );
            }
        }
    }
}

impl Topology {
    /// Forgets what a watch that never ends need not remember.
    pub fn forget(&mut self, settled: SettledFrames<'_>) {
        self.ports.retain(|_, port| port.last.frame > settled.old);
    }
}
