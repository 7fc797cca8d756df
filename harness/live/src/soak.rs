//! An endurance run: many devices on one link, each in cyclic exchange with a controller of its own, and how steady all of it is.
//!
//! Nothing is judged but that each connection stands; the figures are for the page that says what a host can do.

use crate::discover::DiscoveredStation;
use controllers::profinet_io::{
    ArConfig, Controller, ControllerOutcome, ControllerRequest, ControllerSettings, Layout,
};
use link::{Histogram, LinkError, LocalStation, Wire, WireStep};
use plain_text::escaped;
use station::{Duration, Outbox, Station, Time};
use std::net::Ipv4Addr;
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::rt::{CyclicFrame, FrameId, FrameKind};

/// The longest time from a request for all connections to the last of them.
const START_UP: Duration = Duration::from_secs(60);
/// Interval of the calls to `watch`.
const WATCH_INTERVAL: Duration = Duration::from_millis(100);
/// The first controller's MAC address; the others count up from it.
const FIRST_MAC: [u8; 6] = [2, 0, 0, 0x50, 0, 0];

/// A device of the run: where it is, and the connection to it.
#[derive(Clone, Debug)]
pub struct SoakDevice {
    pub station: DiscoveredStation,
    pub connection: ArConfig,
}

/// How one device did.
#[derive(Clone, Debug)]
pub struct SoakResult {
    /// Its station name, without control characters.
    pub name: String,
    pub mac: Mac,
    /// Why its connection was not established, or ended.
    pub lost: Option<String>,
    /// Output frames that were sent to it.
    pub sent: u64,
    /// Input frames that it sent.
    pub received: u64,
    /// Input frames that are missing by its cycle counter.
    pub missing: u64,
    /// The time from one input frame to the next.
    pub intervals: Histogram,
}

/// How the run went.
#[derive(Clone, Debug)]
pub struct SoakReport {
    /// The time until all connections were established.
    pub start_up: Duration,
    /// How long all of them were in cyclic exchange.
    pub lasted: Duration,
    /// The devices in the given order.
    pub devices: Vec<SoakResult>,
    /// How late the controllers were woken.
    pub late: Histogram,
    /// The time from one frame of a controller to its next.
    pub gaps: Histogram,
    /// Resident memory of this process in bytes, when all connections were established and at the end, where the system says it.
    pub memory: Option<(u64, u64)>,
}

impl SoakReport {
    /// The devices without a connection at the end.
    pub fn lost(&self) -> impl Iterator<Item = &SoakResult> {
        self.devices.iter().filter(|device| device.lost.is_some())
    }
}

/// A controller with the statistics of what it receives.
struct SoakStation {
    mac: Mac,
    controller: Controller,
    device: Mac,
    data_length: usize,
    cycle_units: u16,
    last: Option<(Time, u16)>,
    result: SoakResult,
}

impl SoakStation {
    fn new(number: u8, device: &SoakDevice, ip: Ipv4Addr, mask: Ipv4Addr) -> SoakStation {
        let [a, b, c, d, e, _] = FIRST_MAC;
        let mac = Mac([a, b, c, d, e, number]);
        let controller = Controller::new(ControllerSettings {
            mac,
            ip,
            mask,
            gateway: Ipv4Addr::UNSPECIFIED,
            station_name: format!("encspec-soak-{number}").into_bytes(),
            vendor_id: 0xFEED,
            device_id: 0x0001,
            seed: u64::from(std::process::id()) << 8 | u64::from(number),
        });
        let connection = &device.connection;
        let result = SoakResult {
            name: escaped(&device.station.name),
            mac: device.station.mac,
            lost: None,
            sent: 0,
            received: 0,
            missing: 0,
            intervals: Histogram::default(),
        };
        SoakStation {
            mac,
            controller,
            device: device.station.mac,
            data_length: Layout::of(&connection.submodules).input.data_length,
            cycle_units: connection.send_clock_factor.saturating_mul(connection.reduction_ratio).max(1),
            last: None,
            result,
        }
    }

    /// Counts an input frame.
    fn count(&mut self, now: Time, frame: &[u8]) {
        let Ok((header, payload)) = FrameHeader::parse(frame) else { return };
        if header.source != self.device || header.ether_type != EtherType::PROFINET {
            return;
        }
        let is_cyclic =
            FrameId::peek(payload).is_ok_and(|id| matches!(id.kind(), FrameKind::RtClass1 | FrameKind::RtClass2));
        let Some(frame) = CyclicFrame::parse(payload, self.data_length).ok().filter(|_| is_cyclic) else { return };
        let counter = frame.status.cycle_counter;
        if let Some((before, last)) = self.last {
            self.result.intervals.record(now.since(before));
            let cycles = counter.wrapping_sub(last) / self.cycle_units;
            self.result.missing += u64::from(cycles.saturating_sub(1));
        }
        self.result.received += 1;
        self.last = Some((now, counter));
    }

    /// Notes how its connection fares; whether the start-up has ended.
    fn note(&mut self) -> bool {
        if let Some(ControllerOutcome::StartUp(start)) = self.controller.take_outcome()
            && let Some(failed) = start.failed.filter(|_| !start.standing)
        {
            self.result.lost = Some(format!("{failed}"));
        }
        if let Some(end) = self.controller.take_end() {
            self.result.lost.get_or_insert(end.to_string());
        }
        !self.controller.is_busy()
    }

    /// Forgets what was counted during the start-up.
    fn begin(&mut self) {
        let SoakResult { sent, received, missing, intervals, .. } = &mut self.result;
        (*sent, *received, *missing) = (self.controller.cycles_sent(), 0, 0);
        intervals.reset();
        self.last = None;
    }
}

impl Station for SoakStation {
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        self.count(now, frame);
        self.controller.receive(now, frame, out);
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.controller.wake(now, out);
    }

    fn deadline(&self) -> Option<Time> {
        self.controller.deadline()
    }
}

/// Addresses for the controllers: the highest free ones of the subnet of the first device. `None` if it has too few.
fn free_addresses(devices: &[SoakDevice], stations: &[DiscoveredStation]) -> Option<(Vec<Ipv4Addr>, Ipv4Addr)> {
    let IpParameter { address, mask, .. } = devices.first()?.station.ip?;
    let (first, last) = (u32::from(address) & u32::from(mask), u32::from(address) | !u32::from(mask));
    let taken = |ip: &Ipv4Addr| stations.iter().any(|of| of.ip.is_some_and(|of| of.address == *ip));
    let free = (first + 1..last).rev().map(Ipv4Addr::from).filter(|ip| !taken(ip));
    let found: Vec<Ipv4Addr> = free.take(devices.len()).collect();
    (found.len() == devices.len()).then_some((found, mask))
}

/// Connects to all devices at once and exchanges data for `time`. `stations` are all stations of the segment, whose addresses
/// stay theirs. `watch` is called regularly with the time that has passed and the number of connections that stand; it ends the run by
/// returning true.
///
/// # Errors
///
/// The link failed, or its subnet has no free address for each controller.
pub fn soak(
    wire: &mut Wire,
    devices: &[SoakDevice],
    stations: &[DiscoveredStation],
    time: Duration,
    watch: &mut dyn FnMut(Duration, usize) -> bool,
) -> Result<SoakReport, LinkError> {
    let too_few = || LinkError::Unusable("the subnet of the devices has too few free addresses for controllers".into());
    let (addresses, mask) = free_addresses(devices, stations).ok_or_else(too_few)?;
    let numbered = (0..=u8::MAX).zip(devices).zip(addresses);
    let mut soaked: Vec<SoakStation> =
        numbered.map(|((number, device), ip)| SoakStation::new(number, device, ip, mask)).collect();
    let begin = wire.now();
    for (station, device) in soaked.iter_mut().zip(devices) {
        // A new controller is not busy.
        let _ = station.controller.request(begin, ControllerRequest::Connect(Box::new(device.connection.clone())));
    }
    let mut stopped = false;
    let mut is_connected = false;
    while !is_connected && !stopped && wire.now().since(begin) < START_UP {
        run_until(wire, &mut soaked, WATCH_INTERVAL)?;
        let ended = soaked.iter_mut().map(SoakStation::note).filter(|has_ended| *has_ended).count();
        is_connected = ended == soaked.len();
        stopped = watch(Duration::ZERO, standing(&soaked));
    }
    let connected = wire.now();
    soaked.iter_mut().for_each(SoakStation::begin);
    wire.reset_lateness();
    let memory = resident_memory();
    let end = connected + time;
    while !stopped && wire.now() < end {
        run_until(wire, &mut soaked, WATCH_INTERVAL.min(end.since(wire.now())))?;
        soaked.iter_mut().for_each(|station| {
            station.note();
        });
        stopped = watch(wire.now().since(connected), standing(&soaked));
    }
    let lasted = wire.now().since(connected);
    let (late, gaps) = (wire.lateness().wakes().clone(), wire.lateness().gaps().clone());
    let memory = memory.zip(resident_memory());
    release(wire, &mut soaked)?;
    let devices = soaked.into_iter().map(|station| {
        let sent = station.controller.cycles_sent().saturating_sub(station.result.sent);
        SoakResult { sent, ..station.result }
    });
    Ok(SoakReport { start_up: connected.since(begin), lasted, devices: devices.collect(), late, gaps, memory })
}

fn standing(stations: &[SoakStation]) -> usize {
    stations.iter().filter(|station| station.result.lost.is_none()).count()
}

/// Ends all connections, so that no device sees a lost controller.
fn release(wire: &mut Wire, stations: &mut [SoakStation]) -> Result<(), LinkError> {
    let now = wire.now();
    for station in stations.iter_mut().filter(|station| station.result.lost.is_none()) {
        // A connection that stands is not busy.
        let _ = station.controller.request(now, ControllerRequest::Release);
    }
    while stations.iter().any(|station| station.controller.is_busy()) && wire.now().since(now) < START_UP {
        run_until(wire, stations, WATCH_INTERVAL)?;
    }
    Ok(())
}

fn run_until(wire: &mut Wire, stations: &mut [SoakStation], time: Duration) -> Result<(), LinkError> {
    let until = wire.now() + time;
    let devices: Vec<Mac> = stations.iter().map(|station| station.device).collect();
    let mut local: Vec<LocalStation<'_>> =
        stations.iter_mut().map(|station| (station.mac.0, station as &mut dyn Station)).collect();
    // Searches go to all, everything else to the devices of the run.
    let mut guard = |frame: &[u8]| {
        FrameHeader::parse(frame)
            .is_ok_and(|(header, _)| header.destination.is_group() || devices.contains(&header.destination))
    };
    while wire.step(&mut local, until, &mut guard, &mut |_, _| {})? == WireStep::Worked {}
    Ok(())
}

/// The resident memory of this process in bytes; `None` where the system does not say it.
fn resident_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kilobytes: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kilobytes * 1024)
}
