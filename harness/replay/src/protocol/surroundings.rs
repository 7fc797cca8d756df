//! What others do on the network around a connection: forged and duplicate addresses, and floods of frames.

use super::coverage::{CapturePosition, FindingList, SettledFrames};
use super::table::{ADDRESS_FORGED, FLOOD};
use super::text::{span, times};
use crate::finding::{CaptureBlame, FindingSeverity};
use rustc_hash::FxHashMap;
use station::{Duration, Time};
use std::collections::{BTreeMap, VecDeque};
use std::net::Ipv4Addr;
use wire::datagram::arp::Arp;
use wire::ethernet::{EtherType, FrameHeader, Mac};

/// What happened longer ago than this is not named beside the end of a connection.
const NEAR: Duration = Duration::from_secs(5);
/// Frames of one source to group addresses in one second: more is a flood, since each station has to take them.
const MOST_TO_GROUPS: u32 = 1_000;
/// All but the cyclic frames of one source in one second: more is named beside an abort, but may be a transfer of files.
const MOST_FRAMES: u32 = 5_000;
/// This many frames from an address to itself are no accident.
const OFTEN: u64 = 3;
/// The keepalive of switches, which goes from an address to itself (Ethernet configuration testing protocol).
const LOOPBACK: EtherType = EtherType(0x9000);
/// Upper limit of the remembered events and stations.
const MOST_EVENTS: usize = 64;
const MOST_STATIONS: usize = 4_096;

/// Something that a station did which may disturb others.
#[derive(Clone, Debug)]
struct SuspectEvent {
    when: CapturePosition,
    /// The stations that it may disturb; empty for all.
    victims: Vec<Mac>,
    text: String,
}

/// An address that another station uses: how often, the first and the last frame.
type ForgedAddress = (u64, u64, u64);

/// A source that floods the network.
#[derive(Clone, Copy, Debug)]
struct FloodingStation {
    first: u64,
    /// The most frames in one second, and the number of those to group addresses.
    most: (u32, u32),
}

/// The disturbances of a capture.
#[derive(Clone, Debug, Default)]
pub(super) struct Surroundings {
    events: VecDeque<SuspectEvent>,
    /// The frames of the current second by source: all, and those to group addresses.
    rates: FxHashMap<Mac, (u32, u32)>,
    second: Time,
    floods: BTreeMap<Mac, FloodingStation>,
    /// ARP of one station that claims the address of another: sender, claimed MAC address, IP address.
    forged: BTreeMap<(Mac, Mac, Ipv4Addr), ForgedAddress>,
    /// Frames from an address to itself.
    to_itself: BTreeMap<Mac, ForgedAddress>,
}

impl Surroundings {
    /// Forgets what a watch that never ends need not remember.
    pub fn forget(&mut self, settled: SettledFrames<'_>) {
        self.events.retain(|event| event.when.frame > settled.old);
        self.floods.retain(|_, flood| flood.first > settled.reported);
        self.forged.retain(|_, (.., last)| *last > settled.reported);
        self.to_itself.retain(|_, (.., last)| *last > settled.reported);
    }

    /// Takes in a frame that is no cyclic one.
    pub fn frame(&mut self, now: CapturePosition, header: &FrameHeader, findings: &mut FindingList) {
        if now.time.since(self.second) >= Duration::from_secs(1) || now.time < self.second {
            self.second = now.time;
            self.rates.clear();
        }
        let source = header.source;
        if self.rates.len() < MOST_STATIONS || self.rates.contains_key(&source) {
            let rate = self.rates.entry(source).or_default();
            rate.0 += 1;
            rate.1 += u32::from(header.destination.is_group());
            let rate = *rate;
            if rate.1 > MOST_TO_GROUPS || rate.0 > MOST_FRAMES {
                self.flooded(now, source, rate, findings);
            }
        }
        if source == header.destination && header.ether_type != LOOPBACK && self.to_itself.len() < MOST_STATIONS {
            let of = self.to_itself.entry(source).or_insert((0, now.frame, 0));
            (of.0, of.2) = (of.0 + 1, now.frame);
            if of.0 == OFTEN {
                findings.note(of.1);
                let text =
                    format!("frames from {source} to itself, which move this address in the tables of the switches");
                self.remember(now, vec![source], text);
            }
        }
    }

    #[cold]
    fn flooded(&mut self, now: CapturePosition, source: Mac, rate: (u32, u32), findings: &mut FindingList) {
        if rate.1 > MOST_TO_GROUPS {
            let is_new = !self.floods.contains_key(&source);
            let flood = self.floods.entry(source).or_insert(FloodingStation { first: now.frame, most: rate });
            flood.most = flood.most.max(rate);
            if is_new {
                findings.note(now.frame);
            }
        }
        let last = self.events.back().filter(|last| last.victims.is_empty());
        // Once a second is enough.
        if last.is_none_or(|last| now.since(last.when).is_none_or(|since| since >= Duration::from_secs(1))) {
            self.remember(now, Vec::new(), format!("{source} floods the network with frames"));
        }
    }

    /// Takes in an ARP packet with the source of its frame.
    pub fn arp(&mut self, now: CapturePosition, source: Mac, arp: &Arp, findings: &mut FindingList) {
        let (claimed, ip) = (arp.sender_mac, arp.sender_ip);
        if source == claimed || claimed.is_group() || claimed == Mac::ZERO || self.forged.len() >= MOST_STATIONS {
            return;
        }
        let of = self.forged.entry((source, claimed, ip)).or_insert((0, now.frame, 0));
        (of.0, of.2) = (of.0 + 1, now.frame);
        findings.note(now.frame);
        let text = format!("{source} sends ARP in the name of {claimed} ({ip})");
        self.remember(now, vec![claimed], text);
    }

    /// Two stations claim one IP address.
    pub fn duplicate(&mut self, now: CapturePosition, (one, other): (Mac, Mac), ip: Ipv4Addr) {
        self.remember(now, vec![one, other], format!("{one} and {other} both claim the IP address {ip}"));
    }

    fn remember(&mut self, when: CapturePosition, victims: Vec<Mac>, text: String) {
        if self.events.len() >= MOST_EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(SuspectEvent { when, victims, text });
    }

    /// What may have disturbed one of these stations shortly before, in words with its frame.
    pub fn around(&self, now: CapturePosition, stations: [Mac; 2]) -> Vec<String> {
        let is_near = |event: &&SuspectEvent| {
            let meets = event.victims.is_empty() || event.victims.iter().any(|victim| stations.contains(victim));
            meets && now.since(event.when).is_some_and(|since| since <= NEAR)
        };
        let mut texts: Vec<String> = Vec::new();
        for event in self.events.iter().filter(is_near) {
            if !texts.iter().any(|text| text.starts_with(&event.text)) {
                let since = now.since(event.when).map_or_else(String::new, |since| format!(" {} earlier", span(since)));
                texts.push(format!("{} (frame {}{since})", event.text, event.when.frame));
            }
        }
        texts
    }

    pub fn end(self, findings: &mut FindingList) {
        for ((source, claimed, ip), (count, first, last)) in self.forged {
            let text = format!(
                "{source} sends ARP that says {ip} is at {claimed}, in the name of that station{}",
                times(count, last)
            );
            findings.add(ADDRESS_FORGED.finding(FindingSeverity::Warning, CaptureBlame::Network, first, text));
        }
        for (mac, (count, first, last)) in self.to_itself.into_iter().filter(|(_, (count, ..))| *count >= OFTEN) {
            let text = format!(
                "frames from {mac} to itself, which move this address in the tables of the switches{}",
                times(count, last)
            );
            findings.add(ADDRESS_FORGED.finding(FindingSeverity::Warning, CaptureBlame::Network, first, text));
        }
        for (source, FloodingStation { first, most: (frames, to_groups) }) in self.floods {
            let text = format!(
                "{source} sends {frames} frames in one second, {to_groups} of them to all stations or groups of them"
            );
            findings.add(FLOOD.finding(FindingSeverity::Warning, CaptureBlame::Network, first, text));
        }
    }
}
