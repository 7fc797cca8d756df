//! Looks around on a wire before anything is tested: who is there, which of them is meant, which addresses are free.
//!
//! What is done to the device here stands in the journal first. This room must not know suites.

use super::guard::Guard;
use super::journal::{Entry, Journal};
use super::unusable::{Ready, Unusable, unusable};
use controllers::profinet_io::{
    Controller, DcpOutcome, IdentifyBy, Outcome, Partner, RecordOutcome, Request, StationSeen, Target,
};
use description::gsdml::DeviceSays;
use judge::observe::Tracker;
use link::Wire;
use results::bench_file::BenchFile;
use station::{Duration, Outbox, Station, Time};
use std::collections::BTreeSet;
use std::net::Ipv4Addr;
use wire::datagram::arp::Arp;
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{Block, BlockQualifier, Value};
use wire::profinet::rpc::ObjectUuid;

/// How long answers to an Identify are collected.
const IDENTIFY: Duration = Duration::from_millis(1300);
/// How often everybody is asked who is there.
const QUESTIONS: u32 = 4;
/// How long answers to an ARP question are waited for.
const ARP_WAIT: Duration = Duration::from_millis(300);
/// Most octets of a record that are asked for.
const RECORD: u32 = 4096;

/// What the device has to be.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Its vendor number.
    pub vendor_id: u16,
    /// Its device number, where a manual or a description prints it.
    pub device_id: Option<u16>,
    /// The cycle of most connections, for the slack.
    pub cycle: Duration,
    /// The web pages whose forms let it wait for another firmware, by their paths.
    pub firmware_pages: Vec<String>,
}

/// Whether a frame is one of the cyclic exchange, of whatever class; a tag may stand before its type.
pub fn is_cyclic(frame: &[u8]) -> bool {
    let at = if frame.get(12..14) == Some(&[0x81, 0x00]) { 16 } else { 12 };
    frame.get(at..at + 2) == Some(&[0x88, 0x92]) && frame.get(at + 2).is_some_and(|high| (0x01..0xFC).contains(high))
}

/// Who was heard before anybody was asked.
#[derive(Debug, Default)]
pub(super) struct Heard {
    tracker: Tracker,
    frames: u64,
    /// Sender and receiver of cyclic frames.
    pub cyclic: BTreeSet<(Mac, Mac)>,
    /// Senders of PROFINET frames.
    pub speakers: BTreeSet<Mac>,
    /// Who said in ARP that it has which address.
    addresses: Vec<(Ipv4Addr, Mac)>,
}

impl Heard {
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

/// Somebody who sends some frames once.
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

/// Looks around on a wire.
pub(super) struct Scout {
    pub wire: Wire,
    pub guard: Guard,
    pub heard: Heard,
}

impl Scout {
    pub fn run(
        &mut self,
        stations: &mut [([u8; 6], &mut dyn Station)],
        until: Time,
        mut done: impl FnMut(&mut [([u8; 6], &mut dyn Station)]) -> bool,
    ) -> Ready<()> {
        while !done(stations) && self.wire.clock().now() < until {
            if link::interrupt::requested() {
                return unusable("interrupted; `encspec bench restore` puts back what was changed, if anything was");
            }
            let Scout { wire, guard, heard } = self;
            wire.step(stations, until, &mut |frame| guard.allows(frame), &mut |time, frame| heard.hear(time, frame))?;
        }
        Ok(())
    }

    pub fn ask(&mut self, controller: &mut Controller, request: Request) -> Ready<Outcome> {
        let now = self.wire.clock().now();
        controller.request(now, request).map_err(|busy| Unusable(busy.to_string()))?;
        let mac = controller.settings().mac.0;
        loop {
            if let Some(outcome) = controller.take_outcome() {
                return Ok(outcome);
            }
            let until = self.wire.clock().now() + IDENTIFY;
            let mut once = false;
            self.run(&mut [(mac, controller)], until, |_| std::mem::replace(&mut once, true))?;
        }
    }

    /// Finds the device, and tells who else is there.
    pub fn find(
        &mut self,
        bench: &BenchFile,
        wanted: &Wanted,
        controller: &mut Controller,
    ) -> Ready<(StationSeen, Vec<StationSeen>)> {
        let mut stations: Vec<StationSeen> = Vec::new();
        for _ in 0..QUESTIONS {
            let outcome = self.ask(controller, Request::Identify { by: IdentifyBy::All, wait: IDENTIFY })?;
            if let Outcome::Stations(seen) = outcome {
                stations = seen;
            }
            if stations.iter().any(|station| is_meant(bench, wanted, station)) {
                break;
            }
        }
        let meant: Vec<&StationSeen> = stations.iter().filter(|station| is_meant(bench, wanted, station)).collect();
        match meant[..] {
            [one] => {
                let one = one.clone();
                self.check(bench, wanted, &one)?;
                stations.retain(|station| station.mac != one.mac);
                if let Some(twin) = stations.iter().find(|other| !one.name.is_empty() && other.name == one.name) {
                    return unusable(format!(
                        "{} and {} have the same station name: give one of them another",
                        one.mac, twin.mac
                    ));
                }
                Ok((one, stations))
            }
            [] => unusable(nobody(bench, wanted, &stations)),
            _ => {
                let macs: Vec<String> = meant.iter().map(|station| station.mac.to_string()).collect();
                let all = macs.join(", ");
                unusable(format!(
                    "{all} could all be meant: say in a bench file by `station_name` or `mac` which one is"
                ))
            }
        }
    }

    fn check(&self, bench: &BenchFile, wanted: &Wanted, station: &StationSeen) -> Ready<()> {
        let Some((vendor, device)) = station.id else {
            return unusable(format!("{} does not say which device it is, so it is left alone", station.mac));
        };
        if vendor == wanted.vendor_id && wanted.device_id.is_none_or(|id| id == device) {
            return Ok(());
        }
        let claimed = match wanted.device_id {
            Some(id) => format!("vendor 0x{:04X} device 0x{id:04X}", wanted.vendor_id),
            None => format!("vendor 0x{:04X}", wanted.vendor_id),
        };
        let mac = station.mac;
        let manual = &bench.claim.manual;
        unusable(format!(
            "{mac} is vendor 0x{vendor:04X} device 0x{device:04X}, {manual} is {claimed}: it is left alone"
        ))
    }

    /// Gives the device the name of the bench, if it has another one.
    pub fn name(
        &mut self,
        bench: &BenchFile,
        controller: &mut Controller,
        station: &mut StationSeen,
        journal: &mut Journal,
    ) -> Ready<bool> {
        let Some(name) = &bench.station_name else { return Ok(false) };
        if station.name == name.as_bytes() {
            return Ok(false);
        }
        let now = String::from_utf8_lossy(&station.name).escape_debug().to_string();
        if !bench.consent.set_name {
            return unusable(format!(
                "the device is named `{now}`, the bench says `{name}`: put the right name there, or give the consent set_name"
            ));
        }
        let entry = Entry::Changes { trial: "preflight".into(), what: vec!["set_name".into()] };
        journal.add(&entry).map_err(|error| Unusable(format!("the journal cannot be written: {error}")))?;
        let value = Value::NameOfStation(name.clone().into_bytes());
        let blocks = vec![Block::set(BlockQualifier::PERMANENT, value)];
        match self.ask(controller, Request::DcpSet { to: station.mac, blocks })? {
            Outcome::Dcp(DcpOutcome::Accepted) => {
                station.name = name.clone().into_bytes();
                Ok(true)
            }
            outcome => unusable(format!("the device does not take the name `{name}`: {outcome:?}")),
        }
    }

    /// Gives the device the address of this run, until it loses power.
    pub fn give_address(
        &mut self,
        controller: &mut Controller,
        station: &StationSeen,
        ip: IpParameter,
        journal: &mut Journal,
    ) -> Ready<bool> {
        if station.ip.address == ip.address && station.ip.mask == ip.mask {
            return Ok(false);
        }
        let entry = Entry::Changes { trial: "preflight".into(), what: vec!["set_ip".into()] };
        journal.add(&entry).map_err(|error| Unusable(format!("the journal cannot be written: {error}")))?;
        let blocks = vec![Block::set(BlockQualifier::TEMPORARY, Value::IpParameter(ip))];
        match self.ask(controller, Request::DcpSet { to: station.mac, blocks })? {
            Outcome::Dcp(DcpOutcome::Accepted) => Ok(true),
            outcome => unusable(format!("the device does not take the address {}: {outcome:?}", ip.address)),
        }
    }

    /// Reads without a connection which APIs there are, what is plugged in each, and I&M0; what the device refuses stays
    /// unknown.
    pub fn ask_what_is_plugged(
        &mut self,
        controller: &mut Controller,
        station: &StationSeen,
        ip: IpParameter,
        says: &mut DeviceSays,
    ) -> Ready<()> {
        let partner = Partner { mac: station.mac, ip: ip.address };
        let (vendor_id, device_id) = station.id.unwrap_or_default();
        let object = ObjectUuid { instance: 1, device_id, vendor_id };
        let mut read = |scout: &mut Scout, target: Target| -> Ready<Option<Vec<u8>>> {
            let request = Request::ReadImplicit { partner, object, target, length: RECORD };
            Ok(match scout.ask(controller, request)? {
                Outcome::Record(RecordOutcome::Accepted { data }) => Some(data),
                _ => None,
            })
        };
        let place = |api: u32, subslot: u16, index: u16| Target { api, slot: 0, subslot, index };
        let Some(octets) = read(self, place(0, 1, 0xF821))? else { return Ok(()) };
        // What cannot be read stays unknown, as what is refused does; the suite judges the records themselves.
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

    /// Who answers to an address.
    pub fn answers(&mut self, own: Mac, address: Ipv4Addr) -> Ready<Vec<Mac>> {
        self.heard.addresses.clear();
        let question = Arp::request(own, Ipv4Addr::UNSPECIFIED, address);
        let mut frame = Vec::new();
        question.write_frame(&mut frame);
        let mut sender = Sender(vec![frame]);
        let until = self.wire.clock().now() + ARP_WAIT;
        self.run(&mut [(own.0, &mut sender)], until, |_| false)?;
        Ok(self.heard.addresses.iter().filter(|(ip, mac)| *ip == address && *mac != own).map(|(_, mac)| *mac).collect())
    }

    /// Two addresses for our controllers, the bench's and the next free one or two free ones of the device's subnet, and a
    /// third one that stays free.
    pub fn free_addresses(
        &mut self,
        bench: &BenchFile,
        device: &IpParameter,
        macs: &[Mac; 2],
        others: &[StationSeen],
    ) -> Ready<[Ipv4Addr; 3]> {
        let mut free = Vec::new();
        if let Some(own) = bench.controller_ip {
            if let Some(other) = self.answers(macs[0], own)?.first() {
                return unusable(format!(
                    "{other} has the address {own} that our controller is to have: give another `controller.ip`"
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
            "the subnet of {} has not the free addresses that our controllers and some cases need: give `controller.ip`",
            device.address
        ))
    }
}

/// Whether a station is the one that the bench means.
fn is_meant(bench: &BenchFile, wanted: &Wanted, station: &StationSeen) -> bool {
    if let Some(mac) = bench.mac {
        return station.mac == mac;
    }
    match &bench.station_name {
        Some(name) if station.name == name.as_bytes() => true,
        // A device without a name may be given the one of the bench.
        Some(_) if !station.name.is_empty() => false,
        _ => {
            let Some((vendor, device)) = station.id else { return false };
            vendor == wanted.vendor_id && wanted.device_id.is_none_or(|id| id == device)
        }
    }
}

fn nobody(bench: &BenchFile, wanted: &Wanted, stations: &[StationSeen]) -> String {
    let who = match (&bench.mac, &bench.station_name) {
        (Some(mac), _) => format!("the station {mac}"),
        (None, Some(name)) => format!("a station named `{name}`"),
        (None, None) => format!("a device of vendor 0x{:04X}", wanted.vendor_id),
    };
    let others = match stations.len() {
        0 => "nobody answers at all; is it connected and powered?".to_owned(),
        count => format!("{count} other station(s) answer; `encspec discover` lists them"),
    };
    format!("{who} does not answer on {}: {others}", bench.link)
}
