//! Names and addresses: duplicates, names that no station answers to, and stations that are set or reset while connected.

use super::coverage::{CaptureCoverage, CapturePosition, FindingList, SettledFrames};
use super::table::{
    ADDRESS_DUPLICATE, DCP_REFUSED, DCP_UNANSWERED, NAME_DUPLICATE, NAME_INVALID, NAME_UNKNOWN, ONE_SIDED,
    RESET_RUNNING, SET_RUNNING,
};
use super::text::{party, times};
use crate::finding::{CaptureBlame, FindingSeverity};
use judge::observe::{ArId, Observation, ObservedAr};
use plain_text::escaped;
use rustc_hash::FxHashMap;
use station::Duration;
use std::collections::{BTreeMap, BTreeSet};
use std::net::Ipv4Addr;
use wire::datagram::arp::Arp;
use wire::ethernet::Mac;
use wire::profinet::dcp::station_name::{self, NameProblem};
use wire::profinet::dcp::{BlockError, Dcp, DcpValue, ServiceId, ServiceType};

/// Two stations that claim the same name or address within this time are both present.
const TOGETHER: Duration = Duration::from_secs(2);
/// A request without an answer for this time counts as unanswered.
const PATIENCE: Duration = Duration::from_secs(3);
/// A name requested this often is reported as missing.
const OFTEN: u64 = 2;
/// Upper limit of the remembered names, addresses and requests.
const MOST: usize = 4_096;

/// The stations that claim a name or an address: the last one and the one before.
#[derive(Clone, Debug)]
struct AddressClaim {
    last: (Mac, CapturePosition),
    before: Option<(Mac, CapturePosition)>,
    reported: bool,
}

/// A search for a name, and whether a station answered.
#[derive(Clone, Debug)]
struct NameSearch {
    first: CapturePosition,
    last: CapturePosition,
    count: u64,
    answered: bool,
}

/// A request to one station.
#[derive(Clone, Copy, Debug)]
struct PendingDcpRequest {
    first: CapturePosition,
    last: CapturePosition,
    count: u64,
}

/// Refusals of one kind: how often, the first and the last frame, the reason.
type DcpRefusals = (u64, u64, u64, String);

/// The stations of a capture.
#[derive(Clone, Debug, Default)]
pub(super) struct StationCheck {
    names: FxHashMap<String, AddressClaim>,
    addresses: FxHashMap<Ipv4Addr, AddressClaim>,
    searches: BTreeMap<(Mac, String), NameSearch>,
    /// The name searched for, by requester and transaction ID (Xid).
    numbers: FxHashMap<(Mac, u32), String>,
    /// Requests since the last answer of a station, by requester, station, and whether it is a Set.
    asked: BTreeMap<(Mac, Mac, bool), PendingDcpRequest>,
    refused: BTreeMap<(Mac, String, u8), DcpRefusals>,
    /// Names given to a station: an engineering tool first checks that they are free.
    given: BTreeSet<String>,
    /// Requesters that received an answer to a search.
    answered: BTreeSet<Mac>,
    /// Invalid names, by the station that has them.
    wrong: BTreeSet<(Mac, String)>,
}

impl StationCheck {
    /// Takes in an ARP packet; returns the other station that claims the address, the first time that both do.
    pub fn arp(&mut self, now: CapturePosition, arp: &Arp, findings: &mut FindingList) -> Option<Mac> {
        if arp.sender_ip.is_unspecified() || arp.sender_mac.is_group() {
            return None;
        }
        self.address(now, arp.sender_mac, arp.sender_ip, findings)
    }

    fn address(&mut self, now: CapturePosition, mac: Mac, ip: Ipv4Addr, findings: &mut FindingList) -> Option<Mac> {
        let claimed = claim(&mut self.addresses, ip, mac, now);
        if let Some((other, frame)) = claimed {
            let text = format!("{mac} (frame {}) and {other} (frame {frame}) both use the IP address {ip}", now.frame);
            findings.add(ADDRESS_DUPLICATE.finding(FindingSeverity::Error, CaptureBlame::Network, now.frame, text));
        }
        claimed.map(|(other, _)| other)
    }

    pub fn observe(
        &mut self,
        now: CapturePosition,
        ars: &[ObservedAr],
        observation: &Observation<'_>,
        findings: &mut FindingList,
    ) {
        let Observation::Dcp { source, destination, pdu } = observation else { return };
        let (source, destination) = (*source, *destination);
        match (pdu.service_id, pdu.service_type) {
            (ServiceId::IDENTIFY, ServiceType::REQUEST) => self.search(now, source, pdu),
            (ServiceId::IDENTIFY | ServiceId::GET, ServiceType::RESPONSE) | (ServiceId::HELLO, _) => {
                if pdu.service_id == ServiceId::GET {
                    self.asked.remove(&(destination, source, false));
                }
                if pdu.service_id == ServiceId::IDENTIFY {
                    self.found(destination, pdu.xid);
                }
                for block in pdu.blocks() {
                    match &block.value {
                        DcpValue::NameOfStation(name) if !name.is_empty() => self.name(now, source, name, findings),
                        DcpValue::IpParameter(ip) | DcpValue::FullIpSuite(ip, _) if !ip.address.is_unspecified() => {
                            self.address(now, source, ip.address, findings);
                        }
                        _ => {}
                    }
                }
            }
            (ServiceId::GET | ServiceId::SET, ServiceType::REQUEST) => {
                let set = pdu.service_id == ServiceId::SET;
                if set {
                    self.touch(now, ars, (source, destination), pdu, findings);
                }
                if !destination.is_group() && (self.asked.len() < MOST) {
                    let asked = self.asked.entry((source, destination, set)).or_insert(PendingDcpRequest {
                        first: now,
                        last: now,
                        count: 0,
                    });
                    (asked.last, asked.count) = (now, asked.count + 1);
                }
            }
            (ServiceId::GET | ServiceId::SET, _) => {
                self.asked.remove(&(destination, source, pdu.service_id == ServiceId::SET));
                if pdu.service_id == ServiceId::SET {
                    self.answered(now, source, pdu);
                }
            }
            _ => {}
        }
    }

    fn name(&mut self, now: CapturePosition, mac: Mac, octets: &[u8], findings: &mut FindingList) {
        let name = escaped(octets);
        if let Some(why) = wrong_name(octets).filter(|_| self.wrong.len() < MOST)
            && self.wrong.insert((mac, name.clone()))
        {
            let text = format!("{mac} has the name '{name}', which is not a valid station name: {why}");
            findings.add(NAME_INVALID.finding(FindingSeverity::Warning, CaptureBlame::Controller, now.frame, text));
        }
        if let Some((other, frame)) = claim(&mut self.names, name.clone(), mac, now) {
            let text = format!(
                "{mac} (frame {}) and {other} (frame {frame}) both have the name '{name}': a controller cannot connect to either \
     of them reliably",
                now.frame
            );
            findings.add(NAME_DUPLICATE.finding(FindingSeverity::Error, CaptureBlame::Network, now.frame, text));
        }
    }

    fn search(&mut self, now: CapturePosition, source: Mac, pdu: &Dcp) {
        let name = pdu.blocks().iter().find_map(|block| match &block.value {
            DcpValue::NameOfStation(name) => Some(escaped(name)),
            _ => None,
        });
        let Some(name) = name.filter(|_| self.searches.len() < MOST && self.numbers.len() < MOST) else { return };
        let fresh = self.numbers.insert((source, pdu.xid), name.clone()).is_none_or(|before| before != name);
        let search = self.searches.entry((source, name)).or_insert(NameSearch {
            first: now,
            last: now,
            count: 0,
            answered: false,
        });
        search.last = now;
        search.count += u64::from(fresh);
    }

    fn found(&mut self, requester: Mac, xid: u32) {
        if self.answered.len() < MOST {
            self.answered.insert(requester);
        }
        if let Some(name) = self.numbers.get(&(requester, xid))
            && let Some(search) = self.searches.get_mut(&(requester, name.clone()))
        {
            search.answered = true;
        }
    }

    /// A DCP Set that ends a connection which the station has.
    fn touch(
        &mut self,
        now: CapturePosition,
        ars: &[ObservedAr],
        (source, station): (Mac, Mac),
        pdu: &Dcp,
        findings: &mut FindingList,
    ) {
        for block in pdu.blocks() {
            if let DcpValue::NameOfStation(name) = &block.value
                && self.given.len() < MOST
            {
                self.given.insert(escaped(name));
            }
        }
        let stands = |ar: &&(usize, &ObservedAr)| ar.1.stage.stands() && ar.1.device.mac() == station;
        let Some((index, ar)) = ars.iter().enumerate().rfind(|of| stands(&of)) else { return };
        if ar.controller.mac() == source {
            return;
        }
        for block in pdu.blocks() {
            let (check, what) = match &block.value {
                DcpValue::NameOfStation(name) => (SET_RUNNING, format!("the name '{}'", escaped(name))),
                DcpValue::IpParameter(ip) | DcpValue::FullIpSuite(ip, _) => {
                    (SET_RUNNING, format!("the address {}", ip.address))
                }
                DcpValue::ResetToFactory | DcpValue::FactoryReset => (RESET_RUNNING, String::new()),
                _ => continue,
            };
            let verb = if what.is_empty() { "resets".to_owned() } else { format!("gives {what} to") };
            let text = format!(
                "{source} {verb} device {} while it is connected to controller {}",
                party(&ar.device),
                party(&ar.controller)
            );
            findings.add(
                check.finding(FindingSeverity::Error, CaptureBlame::Network, now.frame, text).ar(ArId(index as u32)),
            );
        }
    }

    fn answered(&mut self, now: CapturePosition, station: Mac, pdu: &Dcp) {
        for block in pdu.blocks() {
            let DcpValue::Response { element, error } = &block.value else { continue };
            if *error == BlockError::OK || self.refused.len() >= MOST {
                continue;
            }
            let of = element.word().map_or_else(
                || format!("element {}/{}", element.option, element.suboption),
                |word| word.replace('_', " "),
            );
            let why = error.sentence().map_or_else(|| format!("block error {}", error.0), str::to_owned);
            let entry = self.refused.entry((station, of, error.0)).or_insert((0, now.frame, 0, why));
            (entry.0, entry.2) = (entry.0 + 1, now.frame);
        }
    }

    pub fn end(self, sight: &CaptureCoverage, findings: &mut FindingList) {
        let mut blind: BTreeMap<Mac, (u64, u64, &str)> = BTreeMap::new();
        for ((source, name), search) in self.searches.iter().filter(|(_, search)| !search.answered) {
            let waited = sight.now.since(search.last).is_some_and(|waited| waited >= PATIENCE);
            if name.is_empty() || !waited {
                continue;
            }
            if search.count < OFTEN {
                // A single request may check that the name is free, or its answer may be lost in the capture.
                if self.answered.contains(source) && !self.given.contains(name) {
                    let text = format!(
                        "{source} requests the station '{name}' once; the capture has no answer, though other stations answered"
                    );
                    findings.add(NAME_UNKNOWN.finding(
                        FindingSeverity::Info,
                        CaptureBlame::Network,
                        search.first.frame,
                        text,
                    ));
                }
                continue;
            }
            if !sight.shows_to(*source) {
                let of = blind.entry(*source).or_insert((0, search.first.frame, name));
                *of = (of.0 + 1, of.1.min(search.first.frame), of.2);
                continue;
            }
            let text = format!(
                "{source} requests the station '{name}'; no station answers{}",
                times(search.count, search.last.frame)
            );
            findings.add(NAME_UNKNOWN.finding(
                FindingSeverity::Warning,
                CaptureBlame::Network,
                search.first.frame,
                text,
            ));
        }
        for (source, (count, frame, name)) in blind {
            let more = if count == 1 { String::new() } else { format!(" and {} more", count - 1) };
            let text = format!(
                "{source} requests the station '{name}'{more}, but the capture has no frame to {source}: whether a station \
     answers is not known (a station that checks its own name gets no answer if the name is free)"
            );
            findings.add(ONE_SIDED.finding(FindingSeverity::Info, CaptureBlame::Capture, frame, text));
        }
        for ((source, destination, set), asked) in self.asked {
            // A requester that misses an answer repeats its request.
            if sight.now.since(asked.last).is_none_or(|waited| waited < PATIENCE) || asked.count < OFTEN {
                continue;
            }
            let what = if set { "set" } else { "get" };
            if sight.shows(destination, source) {
                let text = format!("{destination} does not answer {} DCP requests ({what}) from {source}", asked.count);
                findings.add(DCP_UNANSWERED.finding(
                    FindingSeverity::Warning,
                    CaptureBlame::Device,
                    asked.first.frame,
                    text,
                ));
            } else if !sight.shows_to(source) || !sight.shows_from(destination) {
                let text = format!(
                    "{source} sends a DCP {what} to {destination}, but the capture has no frame from {destination} to {source}: \
     whether it answers is not known"
                );
                findings.add(ONE_SIDED.finding(FindingSeverity::Info, CaptureBlame::Capture, asked.first.frame, text));
            }
        }
        for ((station, element, _), (count, first, last, why)) in self.refused {
            let why = why.trim_end_matches('.');
            let text = format!("{station} refuses DCP Set of {element}: {why}{}", times(count, last));
            findings.add(
                DCP_REFUSED.finding(FindingSeverity::Warning, CaptureBlame::Controller, first, text).observed(why),
            );
        }
    }
}

/// Why this is not a station name (IEC 61158-6-10): labels of 1 to 63 lower-case letters, digits and hyphens, separated by dots.
fn wrong_name(octets: &[u8]) -> Option<&'static str> {
    Some(match station_name::check(octets).err()? {
        _ if octets.iter().any(u8::is_ascii_uppercase) => "it has capital letters",
        _ if octets.contains(&0) => "it is padded with zero bytes",
        NameProblem::Octet { .. } => "it has characters other than lower-case letters, digits, hyphens and dots",
        NameProblem::Empty | NameProblem::TooLong(_) | NameProblem::EmptyLabel(_) | NameProblem::LongLabel(_) => {
            "the name, or a label between its dots, is empty or too long"
        }
        NameProblem::Hyphen(_) => "a label begins or ends with a hyphen",
        NameProblem::LikeAnAddress => "it looks like an IP address",
        NameProblem::LikeAPort => "it has the form of a port name",
    })
}

/// Notes that a station claims a name or an address. Returns the other station and its frame, once, if both are present: they
/// claim it at the same time, or in turns.
fn claim<K: std::hash::Hash + Eq>(
    claims: &mut FxHashMap<K, AddressClaim>,
    key: K,
    mac: Mac,
    now: CapturePosition,
) -> Option<(Mac, u64)> {
    if claims.len() >= MOST && !claims.contains_key(&key) {
        return None;
    }
    let claim = claims.entry(key).or_insert(AddressClaim { last: (mac, now), before: None, reported: false });
    if claim.last.0 == mac {
        claim.last.1 = now;
        return None;
    }
    let other = claim.last;
    let together = now.since(other.1).is_some_and(|since| since <= TOGETHER);
    let in_turns = claim.before.is_some_and(|(before, _)| before == mac);
    claim.before = Some(other);
    claim.last = (mac, now);
    let new = (together || in_turns) && !claim.reported;
    claim.reported |= new;
    new.then_some((other.0, other.1.frame))
}

impl StationCheck {
    /// Forgets what a watch that never ends need not remember.
    pub fn forget(&mut self, settled: SettledFrames<'_>) {
        self.names.retain(|_, claim| claim.last.1.frame > settled.old);
        self.addresses.retain(|_, claim| claim.last.1.frame > settled.old);
        self.searches.retain(|_, search| search.last.frame > settled.reported);
        let searches = &self.searches;
        self.numbers.retain(|(source, _), name| searches.contains_key(&(*source, name.clone())));
        self.asked.retain(|_, asked| asked.last.frame > settled.reported);
        self.refused.retain(|_, (_, _, last, _)| *last > settled.reported);
        // These name stations and grow with their number only; what is full is filled again.
        if self.given.len() >= MOST {
            self.given.clear();
        }
        if self.answered.len() >= MOST {
            self.answered.clear();
        }
        if self.wrong.len() >= MOST {
            self.wrong.clear();
        }
    }
}
