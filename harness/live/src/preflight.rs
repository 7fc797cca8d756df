//! Preflight of a PROFINET bench: listens, discovers the stations, prepares the device, and decides what may run.
//!
//! It changes only a station name or an address that the bench file requires; before a restore only an address that is missing. This
//! module must not know suites.

use super::device_discovery::{ExpectedDevice, ObservedTraffic, PreflightDiscovery};
use super::guard::Guard;
use super::journal::{self, InitialDevice, Journal};
use super::line::DeviceLine;
use super::permanence::may_learn;
use super::ticker::{TICK, Ticker};
use super::unusable::{PreflightResult, Unusable, unusable};
use controllers::profinet_io::{Controller, ControllerSettings, IdentifiedStation};
use description::gsdml::ReportedIdentity;
use link::{FrameSocket, Nic, Port, SocketAddress, Wire};
use results::bench_file::{BenchFile, LinkSpec};
use results::journal::change;
use station::{Duration, Time};
use std::net::Ipv4Addr;
use std::path::Path;
use wire::ethernet::Mac;
use wire::profinet::dcp::block::IpParameter;

/// How long the preflight listens before the first frame of the harness.
const LISTEN: Duration = Duration::from_millis(1500);
/// Minimum number of cycles added to the deadlines of the manual.
const SLACK_CYCLES: u32 = 2;
/// Base of the controllers' MAC addresses if the link has no address.
const WITHOUT_INTERFACE: [u8; 6] = [0x02, 0, 0, 0, 0, 0x00];

/// A bench that is ready for use.
pub struct PreparedDevice {
    /// The wire with its frame filter.
    pub line: DeviceLine,
    /// The device as found, before anything was changed.
    pub found: InitialDevice,
    /// The journal, which begins with that state.
    pub journal: Journal,
    /// The changes that may have to be restored, in the words of the journal.
    pub changes: Vec<String>,
    /// The device's own description.
    pub reported: ReportedIdentity,
    /// The device in its current state.
    pub station: IdentifiedStation,
    /// The address that the controller gives it.
    pub ip: IpParameter,
    /// The harness's controllers.
    pub controllers: [(Mac, Ipv4Addr); 2],
    /// A free address of its subnet.
    pub free_ip: Ipv4Addr,
    /// Time added to deadlines.
    pub slack: Duration,
    /// Why only reading trials may run, if so.
    pub passive: Option<String>,
    /// Remarks for the report.
    pub notes: Vec<String>,
}

/// What a bench is prepared for.
#[derive(Clone, Copy, Debug)]
pub enum PreflightPurpose<'j> {
    /// A run, with a new journal.
    Run,
    /// Restoring a device from an open journal, which is continued.
    Restore {
        /// The file.
        journal: &'j Path,
        /// The device as the run found it.
        found: &'j InitialDevice,
    },
}

impl PreflightPurpose<'_> {
    /// The device as found and its journal: a new one that begins with `now`, or the one that is continued.
    pub(crate) fn journal(self, now: InitialDevice) -> PreflightResult<(InitialDevice, Journal)> {
        let folder = Path::new(journal::FOLDER);
        match self {
            PreflightPurpose::Run => match Journal::begin(folder, &now) {
                Ok(journal) => Ok((now, journal)),
                Err(error) => unusable(format!("the journal below {} cannot be written: {error}", folder.display())),
            },
            PreflightPurpose::Restore { journal, found } => match Journal::resume(journal) {
                Ok(journal) => Ok((found.clone(), journal)),
                Err(error) => unusable(format!("the journal {} cannot be written: {error}", journal.display())),
            },
        }
    }

    /// Whether a device is restored.
    pub(crate) fn is_restore(self) -> bool {
        matches!(self, PreflightPurpose::Restore { .. })
    }
}

/// Opens the port of a link.
pub fn open(link: &LinkSpec) -> PreflightResult<Box<dyn Port>> {
    Ok(match link {
        LinkSpec::Nic(name) => Box::new(Nic::open(name)?),
        LinkSpec::Socket(address) => {
            let address: SocketAddress =
                address.parse().map_err(|error| Unusable(format!("socket:{address}: {error}")))?;
            Box::new(FrameSocket::open(&address)?)
        }
        LinkSpec::Serial(path) => return unusable(format!("the serial line {path} carries no Ethernet frames")),
        LinkSpec::App(_) => return unusable("a program has no wire that could be opened".to_owned()),
    })
}

/// The MAC addresses of the controllers: derived from that of the interface and locally administered, so that they differ from
/// the host's own traffic and from each other.
pub fn controller_macs(bench: &BenchFile, port: &dyn Port) -> [Mac; 2] {
    let mut first = port.mac().unwrap_or(WITHOUT_INTERFACE);
    first[0] = (first[0] | 0x02) & 0xFE;
    first[1] ^= 0x45;
    let first = bench.controller_mac.map_or(first, |mac| mac.0);
    let mut second = first;
    second[5] ^= 0x01;
    [Mac(first), Mac(second)]
}

/// Prepares a bench: opens the link, listens, finds the device, and gives it the name and the address of the bench. `opened` is
/// called once the link is open and privileges are dropped, before anything is sent; it returns what the control channel of the stand
/// serves.
pub fn prepare(
    bench: &BenchFile,
    expected: &ExpectedDevice,
    purpose: PreflightPurpose<'_>,
    opened: &mut dyn FnMut() -> Result<Option<Vec<String>>, String>,
) -> PreflightResult<PreparedDevice> {
    prepare_at(open(&bench.link)?, bench, expected, purpose, opened)
}

/// The same at a port that is open already: a process that has dropped its privileges cannot open it again.
pub fn prepare_at(
    port: Box<dyn Port>,
    bench: &BenchFile,
    expected: &ExpectedDevice,
    purpose: PreflightPurpose<'_>,
    opened: &mut dyn FnMut() -> Result<Option<Vec<String>>, String>,
) -> PreflightResult<PreparedDevice> {
    link::privileges::drop()?;
    let offers = opened().map_err(Unusable)?;
    let macs = controller_macs(bench, port.as_ref());
    let mut scout = PreflightDiscovery {
        wire: Wire::new(port),
        guard: Guard::new(None, bench.consent, Vec::new()),
        traffic: ObservedTraffic::default(),
    };
    scout.wire.restart();
    let mut ticker = Ticker(Time::ZERO + TICK);
    let listened = scout.wire.clock().now() + LISTEN;
    scout.run(&mut [(macs[0].0, &mut ticker)], listened, |_| false)?;
    scout.wait_for_end_of_own_exchange(&macs)?;
    let late = scout.wire.lateness().wakes().max();
    let slack = expected.cycle * SLACK_CYCLES + late.min(expected.cycle * SLACK_CYCLES);
    let mut controller = controller(macs[0], Ipv4Addr::UNSPECIFIED, bench.mask);
    let (found, others) = scout.find(bench, expected, &mut controller)?;
    scout.guard = Guard::new(Some(found.mac), bench.consent, expected.firmware_pages.clone());
    let passive = passive(bench, &scout.traffic, &found, &others, &macs);
    let mut notes = Vec::new();
    let mut station = found.clone();
    let now = journal_entry(bench, &station);
    if let PreflightPurpose::Restore { found, .. } = purpose
        && (found.vendor_id, found.device_id) != (now.vendor_id, now.device_id)
    {
        return unusable(format!("{} is not the device of the journal; nothing was restored", station.mac));
    }
    let open_before =
        journal::unrestored(Path::new(journal::FOLDER)).into_iter().find(|(_, kept)| kept.found.mac == now.mac);
    if let (Some((path, _)), false) = (open_before, purpose.is_restore()) {
        notes.push(format!(
            "an earlier run on this device did not restore everything ({}): run `encspec bench restore`",
            path.display()
        ));
    }
    let (mut found, mut journal) = purpose.journal(now)?;
    let initial_ip = IpParameter { address: found.ip, mask: found.mask, gateway: found.gateway };
    scout.guard.allow_initial(found.name.clone(), initial_ip);
    let mut changes = Vec::new();
    if passive.is_none() && !purpose.is_restore() && may_learn(bench, offers, &found) {
        let learned = scout.learn_permanence(bench, &mut controller, &station, &mut found, &mut journal, &mut notes)?;
        changes.extend(learned.into_iter().map(str::to_owned));
    }
    if passive.is_none() && scout.name(bench, &mut controller, &mut station, &mut journal)? {
        changes.push(change::NAME.to_owned());
    }
    let ip = match purpose {
        PreflightPurpose::Run => address(bench, &station, &mut notes)?,
        PreflightPurpose::Restore { .. } => present_address(bench, &station, initial_ip),
    };
    let has_address = !ip.address.is_unspecified();
    let addresses = match has_address {
        true => scout.free_addresses(bench, &ip, &macs, &others)?,
        false => [Ipv4Addr::UNSPECIFIED; 3],
    };
    if has_address && scout.answers(macs[0], ip.address)?.into_iter().any(|mac| mac != station.mac) {
        return unusable(format!(
            "another station has the address {} of the device: give one of them another",
            ip.address
        ));
    }
    if late > expected.cycle {
        notes.push(format!("this host was up to {late:?} late while listening; deadlines are extended by {slack:?}"));
    }
    let [first, second, free_ip] = addresses;
    let controllers = [(macs[0], first), (macs[1], second)];
    let mut says = ReportedIdentity::default();
    if let Some((vendor, device)) = station.id {
        says.ids(vendor, device);
    }
    if passive.is_none() && has_address {
        let mut controller = self::controller(macs[0], first, ip.mask);
        if scout.give_address(&mut controller, &station, ip, &mut journal)? {
            changes.push(change::TEMPORARY_IP.to_owned());
        }
        scout.read_plugged_modules(&mut controller, &station, ip, &mut says)?;
    }
    let PreflightDiscovery { wire, guard, .. } = scout;
    let prepared = PreparedDevice {
        line: DeviceLine::Wire(Box::new(wire), guard),
        found,
        journal,
        changes,
        reported: says,
        station,
        ip,
        controllers,
        free_ip,
        slack,
        passive,
        notes,
    };
    Ok(prepared)
}

/// The device in the form of the journal.
fn journal_entry(bench: &BenchFile, station: &IdentifiedStation) -> InitialDevice {
    let (vendor_id, device_id) = station.id.unwrap_or_default();
    InitialDevice {
        mac: station.mac.to_string(),
        vendor_id,
        device_id,
        name: station.name.clone(),
        ip: station.ip.address,
        mask: station.ip.mask,
        gateway: station.ip.gateway,
        ..InitialDevice::of(bench)
    }
}

/// A controller for the requests of the preflight.
fn controller(mac: Mac, ip: Ipv4Addr, mask: Ipv4Addr) -> Controller {
    Controller::new(ControllerSettings {
        mac,
        ip,
        mask,
        gateway: Ipv4Addr::UNSPECIFIED,
        station_name: b"encspec".to_vec(),
        vendor_id: 0xFEED,
        device_id: 0x0001,
        seed: u64::from(std::process::id()),
    })
}

/// Why only reading trials may run: other stations could be disturbed, or another controller uses the device.
fn passive(
    bench: &BenchFile,
    traffic: &ObservedTraffic,
    found: &IdentifiedStation,
    others: &[IdentifiedStation],
    own: &[Mac; 2],
) -> Option<String> {
    let foreign = |mac: &Mac| !own.contains(mac);
    // A run of encspec that was killed leaves the device in an exchange with one of the own controllers.
    let with_device =
        |pair: &&(Mac, Mac)| (pair.0 == found.mac && foreign(&pair.1)) || (pair.1 == found.mac && foreign(&pair.0));
    if let Some((from, to)) = traffic.cyclic.iter().find(with_device) {
        let partner = if *from == found.mac { to } else { from };
        return Some(format!(
            "the device is connected to the controller {partner}, whose connection must not be disturbed"
        ));
    }
    if bench.consent.alone {
        return None;
    }
    if let Some((from, to)) = traffic.cyclic.iter().find(|(from, to)| foreign(from) && foreign(to)) {
        return Some(format!("{from} and {to} exchange data on this segment, and the bench does not say `alone`"));
    }
    let other = others.iter().map(|station| station.mac).chain(traffic.speakers.iter().copied());
    let other = other.filter(foreign).find(|mac| *mac != found.mac)?;
    Some(format!("another station ({other}) is on this segment, and the bench does not say `alone`"))
}

/// The address over which a device is restored: the one that it has, else its initial one or that of the bench; none if there is none.
fn present_address(bench: &BenchFile, station: &IdentifiedStation, initial: IpParameter) -> IpParameter {
    let has = |ip: &IpParameter| !ip.address.is_unspecified();
    let of_bench = bench.ip.map(|address| IpParameter { address, mask: bench.mask, gateway: Ipv4Addr::UNSPECIFIED });
    [Some(station.ip), Some(initial), of_bench].into_iter().flatten().find(has).unwrap_or(IpParameter::NONE)
}

/// The address for the device: the bench's, else its own.
fn address(bench: &BenchFile, station: &IdentifiedStation, notes: &mut Vec<String>) -> PreflightResult<IpParameter> {
    let has = !station.ip.address.is_unspecified();
    match bench.ip {
        // Even a temporary address may clear the one stored in the device.
        Some(address) if has && address != station.ip.address && !bench.consent.set_ip => {
            let own = station.ip.address;
            notes.push(format!("the device keeps its address {own}, since the bench gives no consent to set_ip"));
            Ok(station.ip)
        }
        // The same address with another mask is another address: setting it would erase a stored one.
        Some(address) if has && address == station.ip.address && !bench.consent.set_ip => {
            if station.ip.mask != bench.mask {
                let (own, mask) = (station.ip.mask, bench.mask);
                notes.push(format!(
                    "the device keeps its subnet mask {own} instead of {mask}, since the bench gives no consent to set_ip"
                ));
            }
            Ok(station.ip)
        }
        Some(address) => {
            // A gateway of another subnet makes the whole block invalid.
            let is_near = station.ip.gateway & bench.mask == address & bench.mask;
            let gateway = if is_near { station.ip.gateway } else { Ipv4Addr::UNSPECIFIED };
            Ok(IpParameter { address, mask: bench.mask, gateway })
        }
        None if station.ip.address != Ipv4Addr::UNSPECIFIED => Ok(station.ip),
        None => unusable(match &bench.path {
            Some(path) => format!("the device has no IP address: say in {} by `ip` which one it gets for the run", path.display()),
            None => "the device has no IP address: write a bench file (`encspec bench init`) with the `ip` that it gets for \
                     the run"
                .to_owned(),
        }),
    }
}
