//! Discovery on a wire before any test: the stations, the device among them, the free addresses.
//!
//! Each change of the device is written to the journal first. This module must not know suites.

use super::guard::Guard;
use super::journal::{Journal, JournalEntry};
use super::ticker::{TICK, Ticker};
use super::unusable::{PreflightResult, Unusable, unusable};
use controllers::profinet_io::{
    Controller, ControllerOutcome, ControllerRequest, DcpOutcome, IdentifiedStation, IdentifyBy, IoRecordOutcome,
    Partner, RecordAddress,
};
use description::gsdml::ReportedIdentity;
use judge::observe::Tracker;
use link::Wire;
use results::bench_file::BenchFile;
use results::journal::change;
use station::{Duration, Outbox, Station, Time};
use std::collections::BTreeSet;
use std::net::Ipv4Addr;
use wire::datagram::arp::Arp;
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockQualifier, DcpBlock, DcpValue};
use wire::profinet::rpc::ObjectUuid;

/// How long answers to an Identify are collected.
const IDENTIFY_TIME: Duration = Duration::from_millis(1300);
/// Number of Identify requests to all stations.
const IDENTIFY_ROUNDS: u32 = 4;
/// How long a connection of a killed run is waited for.
const OWN_EXCHANGE_TIMEOUT: Duration = Duration::from_secs(10);
/// A connection without a frame for this time has ended.
const OWN_EXCHANGE_SILENCE: Duration = Duration::from_millis(600);
/// Timeout for the answers to an ARP request.
const ARP_TIMEOUT: Duration = Duration::from_millis(300);
/// Maximum length of a record that is read, in bytes.
const RECORD_LENGTH: u32 = 4096;

/// The expected device.
#[derive(Clone, Debug)]
pub struct ExpectedDevice {
    /// Vendor ID.
    pub vendor_id: u16,
    /// Device ID, if a manual or a description prints it.
    pub device_id: Option<u16>,
    /// The cycle of most connections, to compute the slack.
    pub cycle: Duration,
    /// Paths of the web pages whose forms make it wait for other firmware.
    pub firmware_pages: Vec<String>,
}

/// Whether a frame is cyclic data of any RT class; it may have a VLAN tag.
pub fn is_cyclic(frame: &[u8]) -> bool {
    let at = if frame.get(12..14) == Some(&[0x81, 0x00]) { 16 } else { 12 };
    frame.get(at..at + 2) == Some(&[0x88, 0x92]) && frame.get(at + 2).is_some_and(|high| (0x01..0xFC).contains(high))
}

/// Traffic observed before the first frame of the harness.
#[derive(Debug, Default)]
pub(super) struct ObservedTraffic {
    tracker: Tracker,
    frames: u64,
    /// Sender and receiver of cyclic frames.
    pub cyclic: BTreeSet<(Mac, Mac)>,
    /// Senders of PROFINET frames.
    pub speakers: BTreeSet<Mac>,
    /// Addresses claimed in ARP, with the claiming station.
    addresses: Vec<(Ipv4Addr, Mac)>,
}

impl ObservedTraffic {
    fn hear(&mut self, time: Time, frame: &[u8]) {
        self.frames += 1;
        self.tracker.frame(self.frames, time, frame, &mut |_, _| {});
        let Ok((header, payload)) = FrameHeader::parse(frame) else { return };
        match header.ether_type {
            EtherType::PROFINET => {
                self.speakers.insert(header.source);
                if is_cyclic(frame) {
                    self.cyclic.insert((header.source, header.destination));
                }
            }
            EtherType::ARP => {
                if let Ok(arp) = Arp::parse(payload) {
                    self.addresses.push((arp.sender_ip, arp.sender_mac));
                }
            }
            _ => {}
        }
    }
}

/// A station that sends some frames once.
struct Sender(Vec<Vec<u8>>);

impl Station for Sender {
    fn receive(&mut self, _: Time, _: &[u8], _: &mut Outbox) {}

    fn wake(&mut self, _: Time, out: &mut Outbox) {
        self.0.drain(..).for_each(|frame| out.push(&frame));
    }

    fn deadline(&self) -> Option<Time> {
        (!self.0.is_empty()).then_some(Time::ZERO)
    }
}

/// The state of the discovery on a wire.
pub(super) struct PreflightDiscovery {
    pub wire: Wire,
    pub guard: Guard,
    pub traffic: ObservedTraffic,
}

impl PreflightDiscovery {
    pub fn run(
        &mut self,
        stations: &mut [([u8; 6], &mut dyn Station)],
        until: Time,
        mut done: impl FnMut(&mut [([u8; 6], &mut dyn Station)]) -> bool,
    ) -> PreflightResult<()> {
        while !done(stations) && self.wire.clock().now() < until {
            if link::interrupt::requested() {
                return unusable("interrupted; run `encspec bench restore` to restore changes, if there were any");
            }
            let PreflightDiscovery { wire, guard, traffic: heard } = self;
            wire.step(stations, until, &mut |frame| guard.allows(frame), &mut |time, frame| heard.hear(time, frame))?;
        }
        Ok(())
    }

    /// Waits until no station exchanges data with one of the own controllers any more: a run that was killed has left its connection to
    /// the watchdog of the device. After a timeout the device is used anyway.
    pub fn wait_for_end_of_own_exchange(&mut self, own: &[Mac; 2]) -> PreflightResult<()> {
        let until = self.wire.clock().now() + OWN_EXCHANGE_TIMEOUT;
        let mut ticker = Ticker(Time::ZERO + TICK);
        while self.traffic.cyclic.iter().any(|(_, to)| own.contains(to)) && self.wire.clock().now() < until {
            self.traffic.cyclic.retain(|(_, to)| !own.contains(to));
            let listened = self.wire.clock().now() + OWN_EXCHANGE_SILENCE;
            self.run(&mut [(own[0].0, &mut ticker)], listened, |_| false)?;
        }
        Ok(())
    }

    pub fn ask(
        &mut self,
        controller: &mut Controller,
        request: ControllerRequest,
    ) -> PreflightResult<ControllerOutcome> {
        let now = self.wire.clock().now();
        controller.request(now, request).map_err(|busy| Unusable(busy.to_string()))?;
        let mac = controller.settings().mac.0;
        loop {
            if let Some(outcome) = controller.take_outcome() {
                return Ok(outcome);
            }
            let until = self.wire.clock().now() + IDENTIFY_TIME;
            let mut once = false;
            self.run(&mut [(mac, controller)], until, |_| std::mem::replace(&mut once, true))?;
        }
    }

    /// Finds the device; also returns the other stations.
    pub fn find(
        &mut self,
        bench: &BenchFile,
        expected: &ExpectedDevice,
        controller: &mut Controller,
    ) -> PreflightResult<(IdentifiedStation, Vec<IdentifiedStation>)> {
        let mut stations: Vec<IdentifiedStation> = Vec::new();
        for _ in 0..IDENTIFY_ROUNDS {
            let outcome =
                self.ask(controller, ControllerRequest::Identify { by: IdentifyBy::All, wait: IDENTIFY_TIME })?;
            if let ControllerOutcome::Stations(seen) = outcome {
                stations = seen;
            }
            if stations.iter().any(|station| matches_bench(bench, expected, station)) {
                break;
            }
        }
        let meant: Vec<&IdentifiedStation> =
            stations.iter().filter(|station| matches_bench(bench, expected, station)).collect();
        match meant[..] {
            [one] => {
                let one = one.clone();
                self.check(bench, expected, &one)?;
                stations.retain(|station| station.mac != one.mac);
                if let Some(twin) = stations.iter().find(|other| !one.name.is_empty() && other.name == one.name) {
                    return unusable(format!(
                        "{} and {} have the same station name: give one of them another",
                        one.mac, twin.mac
                    ));
                }
                Ok((one, stations))
            }
            [] => unusable(no_device_text(bench, expected, &stations)),
            _ => {
                let macs: Vec<String> = meant.iter().map(|station| station.mac.to_string()).collect();
                let all = macs.join(", ");
                unusable(format!(
                    "several stations match: {all}; select one in a bench file with `station_name` or `mac`"
                ))
            }
        }
    }

    fn check(&self, bench: &BenchFile, expected: &ExpectedDevice, station: &IdentifiedStation) -> PreflightResult<()> {
        let Some((vendor, device)) = station.id else {
            return unusable(format!("{} does not send its vendor and device ID, so it is not used", station.mac));
        };
        if vendor == expected.vendor_id && expected.device_id.is_none_or(|id| id == device) {
            return Ok(());
        }
        let claimed = match expected.device_id {
            Some(id) => format!("vendor 0x{:04X} device 0x{id:04X}", expected.vendor_id),
            None => format!("vendor 0x{:04X}", expected.vendor_id),
        };
        let mac = station.mac;
        let manual = &bench.claim.manual;
        unusable(format!("{mac} is vendor 0x{vendor:04X} device 0x{device:04X}, {manual} is {claimed}: it is not used"))
    }

    /// Gives the device the name of the bench, if it has another one.
    pub fn name(
        &mut self,
        bench: &BenchFile,
        controller: &mut Controller,
        station: &mut IdentifiedStation,
        journal: &mut Journal,
    ) -> PreflightResult<bool> {
        let Some(name) = &bench.station_name else { return Ok(false) };
        if station.name == name.as_bytes() {
            return Ok(false);
        }
        let now = String::from_utf8_lossy(&station.name).escape_debug().to_string();
        if !bench.consent.set_name {
            return unusable(format!(
                "the device is named `{now}`, the bench says `{name}`: correct the name in the bench file, or give the consent set_name"
            ));
        }
        let block = DcpBlock::set(BlockQualifier::PERMANENT, DcpValue::NameOfStation(name.clone().into_bytes()));
        let refused = format!("the device does not accept the name `{name}`");
        self.change(controller, journal, station.mac, (change::NAME, block), &refused)?;
        station.name = name.clone().into_bytes();
        Ok(true)
    }

    /// Notes a change in the journal and makes it by a DCP Set; `refused` begins the message if the device refuses it.
    pub(super) fn change(
        &mut self,
        controller: &mut Controller,
        journal: &mut Journal,
        to: Mac,
        (word, block): (&str, DcpBlock),
        refused: &str,
    ) -> PreflightResult<()> {
        let what = vec![word.to_owned()];
        note(journal, &JournalEntry::Changes { trial: "preflight".into(), what, stand: Vec::new() })?;
        match self.ask(controller, ControllerRequest::DcpSet { to, blocks: vec![block] })? {
            ControllerOutcome::Dcp(DcpOutcome::Accepted) => Ok(()),
            outcome => unusable(format!("{refused}: {}", why(&outcome))),
        }
    }

    /// Gives the device the address of this run, until it loses power.
    pub fn give_address(
        &mut self,
        controller: &mut Controller,
        station: &IdentifiedStation,
        ip: IpParameter,
        journal: &mut Journal,
    ) -> PreflightResult<bool> {
        if station.ip == ip {
            return Ok(false);
        }
        let block = DcpBlock::set(BlockQualifier::TEMPORARY, DcpValue::IpParameter(ip));
        let refused = format!("the device does not accept the address {}", ip.address);
        self.change(controller, journal, station.mac, (change::TEMPORARY_IP, block), &refused)?;
        Ok(true)
    }

    /// Reads the APIs, the plugged modules of each and I&M0 without a connection; what the device refuses stays unknown.
    pub fn read_plugged_modules(
        &mut self,
        controller: &mut Controller,
        station: &IdentifiedStation,
        ip: IpParameter,
        says: &mut ReportedIdentity,
    ) -> PreflightResult<()> {
        let partner = Partner { mac: station.mac, ip: ip.address };
        let (vendor_id, device_id) = station.id.unwrap_or_default();
        let object = ObjectUuid { instance: 1, device_id, vendor_id };
        let mut read = |scout: &mut PreflightDiscovery, target: RecordAddress| -> PreflightResult<Option<Vec<u8>>> {
            let request = ControllerRequest::ReadImplicit { partner, object, target, length: RECORD_LENGTH };
            Ok(match scout.ask(controller, request)? {
                ControllerOutcome::Record(IoRecordOutcome::Accepted { data }) => Some(data),
                _ => None,
            })
        };
        let place = |api: u32, subslot: u16, index: u16| RecordAddress { api, slot: 0, subslot, index };
        let Some(octets) = read(self, place(0, 1, 0xF821))? else { return Ok(()) };
        // Unreadable records stay unknown, like refused ones; the suite judges the records themselves.
        for api in says.take_apis(&octets).unwrap_or_default() {
            if let Some(octets) = read(self, place(api, 1, 0xF000))? {
                let _ = says.take_real(api, &octets);
            }
        }
        if let Some(octets) = read(self, place(0, 1, 0xAFF0))? {
            let _ = says.take_im0(&octets);
        }
        Ok(())
    }

    /// The stations that answer to an address.
    pub fn answers(&mut self, own: Mac, address: Ipv4Addr) -> PreflightResult<Vec<Mac>> {
        self.traffic.addresses.clear();
        let question = Arp::request(own, Ipv4Addr::UNSPECIFIED, address);
        let mut frame = Vec::new();
        question.write_frame(&mut frame);
        let mut sender = Sender(vec![frame]);
        let until = self.wire.clock().now() + ARP_TIMEOUT;
        self.run(&mut [(own.0, &mut sender)], until, |_| false)?;
        Ok(self
            .traffic
            .addresses
            .iter()
            .filter(|(ip, mac)| *ip == address && *mac != own)
            .map(|(_, mac)| *mac)
            .collect())
    }

    /// Two addresses for the controllers: the bench's and the next free one, or two free ones of the device's subnet; and a third
    /// one that stays free.
    pub fn free_addresses(
        &mut self,
        bench: &BenchFile,
        device: &IpParameter,
        macs: &[Mac; 2],
        others: &[IdentifiedStation],
    ) -> PreflightResult<[Ipv4Addr; 3]> {
        let mut free = Vec::new();
        if let Some(own) = bench.controller_ip {
            if let Some(other) = self.answers(macs[0], own)?.first() {
                return unusable(format!(
                    "{other} has the address {own} of the controller: set another `controller.ip`"
                ));
            }
            free.push(own);
        }
        let (mask, address) = (u32::from(device.mask), u32::from(device.address));
        let hosts = !mask;
        for host in (1..hosts.min(255)).rev() {
            let candidate = Ipv4Addr::from((address & mask) | host);
            let taken = candidate == device.address
                || free.contains(&candidate)
                || candidate == device.gateway
                || others.iter().any(|station| station.ip.address == candidate);
            if !taken && self.answers(macs[0], candidate)?.is_empty() {
                free.push(candidate);
            }
            if let [first, second, third] = free[..] {
                return Ok([first, second, third]);
            }
        }
        unusable(format!(
            "the subnet of {} has too few free addresses for the controllers and some cases: set `controller.ip`",
            device.address
        ))
    }
}

/// Writes an entry of the preflight to the journal.
pub(super) fn note(journal: &mut Journal, entry: &JournalEntry) -> PreflightResult<()> {
    journal.add(entry).map_err(|error| Unusable(format!("the journal cannot be written: {error}")))
}

/// Why a DCP Set failed, for messages.
fn why(outcome: &ControllerOutcome) -> String {
    match outcome {
        ControllerOutcome::Dcp(outcome) => outcome.to_string(),
        ControllerOutcome::Impossible(why) => (*why).to_owned(),
        _ => "another request is running".to_owned(),
    }
}

/// Whether a station matches the bench file.
fn matches_bench(bench: &BenchFile, expected: &ExpectedDevice, station: &IdentifiedStation) -> bool {
    if let Some(mac) = bench.mac {
        return station.mac == mac;
    }
    match &bench.station_name {
        Some(name) if station.name == name.as_bytes() => true,
        // A device without a name may be given the one of the bench.
        Some(_) if !station.name.is_empty() => false,
        _ => {
            let Some((vendor, device)) = station.id else { return false };
            vendor == expected.vendor_id && expected.device_id.is_none_or(|id| id == device)
        }
    }
}

fn no_device_text(bench: &BenchFile, expected: &ExpectedDevice, stations: &[IdentifiedStation]) -> String {
    let who = match (&bench.mac, &bench.station_name) {
        (Some(mac), _) => format!("the station {mac}"),
        (None, Some(name)) => format!("a station named `{name}`"),
        (None, None) => format!("a device of vendor 0x{:04X}", expected.vendor_id),
    };
    let others = match stations.len() {
        0 => "no station answers; check cable and power".to_owned(),
        count => format!("{count} other station(s) answer; `encspec discover` lists them"),
    };
    format!("{who} does not answer on {}: {others}", bench.link)
}
