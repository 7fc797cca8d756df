//! Preflight of a PROFIBUS on a serial line: whether the line can keep the timing, which other stations are on it, and whether
//! the slave is present.
//!
//! It listens before the first frame of the harness, and changes nothing. This module must not know suites.

use super::{is_of_master, survey, words};
use crate::fdl::FdlFrames;
use crate::fence::Fence;
use crate::journal::{self, InitialDevice, Journal};
use crate::line::DeviceLine;
use crate::preflight::PreflightPurpose;
use crate::ticker::{TICK, Ticker};
use crate::unusable::{PreflightResult, Unusable, unusable};
use controllers::profibus_dp::LiveBusTiming;
use controllers::profibus_dp::{DataLinkAnswer, MasterOutcome, MasterRequest, ProfibusMaster};
use link::{BusTransmission, Serial, SerialBus, SerialSettings};
use results::bench_file::{BenchFile, Driver, LineSpec, LinkSpec};
use station::{Duration, Time};
use std::path::Path;
use suite::needs::FASTEST_LINE;
use wire::profibus::fdl::{BROADCAST, BaudRate, BitTimes};

/// The rate of a pseudoterminal without a configured rate.
const PSEUDOTERMINAL_BAUD: BaudRate = BaudRate(1_500_000);
/// The rate at which a line is opened to detect its type.
const SLOWEST: BaudRate = BaudRate(9_600);
/// Timeout for the slave; it may just have been switched on.
const SLAVE_TIMEOUT: Duration = Duration::from_secs(10);
/// Number of requests to the slave to measure its response time.
const RESPONSE_SAMPLES: u32 = 8;
/// Timeout for a request of the preflight, including the wait for the token.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(5);
/// Default addresses of the harness's masters.
const MASTERS: [u8; 2] = [1, 2];
/// The highest address of a slave.
const HIGHEST: u8 = 125;

/// The expected slave.
#[derive(Clone, Debug)]
pub struct ExpectedSlave {
    /// Its ident number, if a manual or a description prints it.
    pub ident: Option<u16>,
    /// Its address if the bench file has none.
    pub address: u8,
    /// The cycle of most connections, to compute the slack.
    pub cycle: Duration,
    /// Max TSDR at each baud rate of its GSD; the bench file comes first.
    pub max_tsdr: Vec<(BaudRate, BitTimes)>,
}

/// A bus that is ready for use.
pub struct PreparedBus {
    /// The bus with its frame filter.
    pub line: DeviceLine,
    /// The slave as found.
    pub found: InitialDevice,
    /// The journal, which begins with that state.
    pub journal: Journal,
    /// The address of the slave.
    pub station: u8,
    /// The addresses of the masters.
    pub masters: [u8; 2],
    /// A free address.
    pub free: u8,
    /// The baud rate of the bus.
    pub baud: BaudRate,
    /// The timeouts on this bus.
    pub pace: LiveBusTiming,
    /// Time added to deadlines.
    pub slack: Duration,
    /// Why only reading trials may run, if so.
    pub passive: Option<String>,
    /// Remarks for the report.
    pub notes: Vec<String>,
}

/// Prepares a bus: opens the line, listens, and finds the slave and the other stations. `opened` is called once the line is open
/// and privileges are dropped, before anything is sent.
pub fn prepare(
    bench: &BenchFile,
    expected: &ExpectedSlave,
    purpose: PreflightPurpose<'_>,
    opened: &mut dyn FnMut() -> Result<Option<Vec<String>>, String>,
) -> PreflightResult<PreparedBus> {
    let (serial, baud) = open(bench)?;
    link::privileges::drop()?;
    opened().map_err(Unusable)?;
    let described = expected.max_tsdr.iter().find(|(rate, _)| *rate == baud).map(|(_, bits)| *bits);
    let pace = LiveBusTiming::new(baud, bench.line.slot_time, bench.line.max_tsdr.or(described));
    let (home, masters) = addresses(bench, expected)?;
    let name = serial.describe();
    let mut scout = BusPreflight {
        bus: SerialBus::new(serial, Box::<FdlFrames>::default()),
        fence: Fence::new(home, bench.consent),
        master: ProfibusMaster::new(pace.settings(masters[0], baud, masters[0])),
        name,
        sent: Time::ZERO,
        answered: Duration::ZERO,
    };
    scout.listen(survey::listening_time(baud, bench.line.slot_time))?;
    let late = scout.bus.lateness().wakes().max();
    let mut others = scout.others(home, &masters)?;
    let station = match purpose {
        PreflightPurpose::Run => home,
        PreflightPurpose::Restore { found, .. } => scout.search(home, found.device_id, &others)?,
    };
    others.retain(|other| *other != station);
    let ident = scout.find(station, expected, &others)?;
    scout.fence.set_other_stations(others.clone());
    let now = InitialDevice { station: Some(station), device_id: ident, ..InitialDevice::of(bench) };
    let mut notes = Vec::new();
    let same = |kept: &journal::JournalContent| kept.found.link == now.link && kept.found.station == now.station;
    let open_before = journal::unrestored(Path::new(journal::FOLDER)).into_iter().find(|(_, kept)| same(kept));
    if let (Some((path, _)), false) = (open_before, purpose.is_restore()) {
        notes.push(format!(
            "an earlier run on this device did not restore everything ({}): run `encspec bench restore`",
            path.display()
        ));
    }
    let (found, journal) = purpose.journal(now)?;
    let cycles = expected.cycle * 2;
    // An adapter may delay each answer.
    let slack = cycles + late.min(cycles) + scout.turnaround(station)? * 2;
    if late > expected.cycle {
        notes.push(format!("this host was up to {late:?} late while listening; deadlines are extended by {slack:?}"));
    }
    let passive = others
        .first()
        .filter(|_| !bench.consent.alone)
        .map(|other| format!("another station ({other}) is on this bus, and the bench does not say `alone`"));
    let free =
        (0..=99).rev().find(|address| *address != station && !masters.contains(address) && !others.contains(address));
    let free = free.ok_or_else(|| Unusable("no station address is free on this bus".to_owned()))?;
    let BusPreflight { bus, fence, .. } = scout;
    let line = DeviceLine::Bus(Box::new(bus), fence);
    Ok(PreparedBus { line, found, journal, station, masters, free, baud, pace, slack, passive, notes })
}

/// Opens the line; a line that cannot keep the timing of a master is refused.
fn open(bench: &BenchFile) -> PreflightResult<(Serial, BaudRate)> {
    let LinkSpec::Serial(path) = &bench.link else {
        return unusable(format!("{} is not a serial line", bench.link));
    };
    open_line(path, &bench.line)
}

/// Opens the line at `path`; a line that cannot keep the timing of a master is refused.
pub(super) fn open_line(path: &str, spec: &LineSpec) -> PreflightResult<(Serial, BaudRate)> {
    let settings = SerialSettings {
        baud: spec.baud.unwrap_or(SLOWEST).0,
        parity: spec.parity,
        echo: spec.echo,
        rs485: spec.driver == Some(Driver::Port),
    };
    let serial = Serial::open(Path::new(path), &settings)?;
    let name = serial.describe();
    if serial.is_pty() {
        return Ok((serial, spec.baud.unwrap_or(PSEUDOTERMINAL_BAUD)));
    }
    timed(spec, &name).map(|baud| (serial, baud))
}

/// The rate of the line `name`, which is not a pseudoterminal, if its timing can be kept.
fn timed(spec: &LineSpec, name: &str) -> PreflightResult<BaudRate> {
    match (spec.baud, spec.driver) {
        (None, _) => unusable(format!(
            "set the baud rate of the bus at {name} in a bench file with `line: {{ baud: .. }}`, or with `--baud`"
        )),
        (Some(baud), _) if baud > FASTEST_LINE => unusable(format!(
            "{name} cannot keep the timing of a bus at {} bit/s; set the bus to {} bit/s or less",
            baud.0, FASTEST_LINE.0
        )),
        (_, None) => unusable(format!(
            "the driver of the adapter at {name} has to be switched by hardware; say in a bench file which does it, \
             `line: {{ driver: adapter }}` or `line: {{ driver: port }}`, or with `--driver`"
        )),
        (Some(baud), Some(_)) => Ok(baud),
    }
}

/// The addresses of the slave and of the harness's masters.
fn addresses(bench: &BenchFile, expected: &ExpectedSlave) -> PreflightResult<(u8, [u8; 2])> {
    let (station, masters) = (bench.line.address.unwrap_or(expected.address), bench.line.masters.unwrap_or(MASTERS));
    if masters.contains(&station) {
        return unusable(format!(
            "the device has the address {station} of one of our masters; say in a bench file which others they have: \
             `line: {{ masters: [..] }}`"
        ));
    }
    Ok((station, masters))
}

/// The state of the preflight on a bus.
struct BusPreflight {
    bus: SerialBus,
    fence: Fence,
    master: ProfibusMaster,
    name: String,
    /// When the last frame of the harness had been sent.
    sent: Time,
    /// Delay from the request to the start of the last answer.
    answered: Duration,
}

impl BusPreflight {
    /// Listens for `time`, and refuses a bus on which another master sends.
    fn listen(&mut self, time: Duration) -> PreflightResult<()> {
        self.bus.restart();
        self.bus.reset_lateness();
        let until = self.bus.now() + time;
        let mut ticker = Ticker(Time::ZERO + TICK);
        while self.bus.now() < until {
            interruptible()?;
            let mut received = None;
            let mut tap = |of: BusTransmission<'_>| received = received.take().or_else(|| Some(words(of.octets)));
            self.bus.step(&mut [&mut ticker], until, &mut |_| false, &mut tap)?;
            if let Some(received) = received {
                return unusable(format!(
                    "{} is in use: received {received} before the first frame of the harness; take the other master off the bus",
                    self.name
                ));
            }
        }
        Ok(())
    }

    /// Polls every address with FDL status; returns the stations that are neither the slave nor the harness's masters.
    fn others(&mut self, station: u8, masters: &[u8; 2]) -> PreflightResult<Vec<u8>> {
        let mut others = Vec::new();
        for address in (0..BROADCAST).filter(|address| *address != station && *address != masters[0]) {
            if self.ask(MasterRequest::FdlStatus { to: address })? == DataLinkAnswer::None {
                continue;
            }
            if address == masters[1] {
                return unusable(format!(
                    "a station at {} has the address {address} of our second master; say in a bench file which others our \
                     masters have: `line: {{ masters: [..] }}`",
                    self.name
                ));
            }
            others.push(address);
        }
        Ok(others)
    }

    /// The address at which the slave with this ident is: `home`, or the only other one.
    fn search(&mut self, home: u8, ident: u16, others: &[u8]) -> PreflightResult<u8> {
        let until = self.bus.now() + SLAVE_TIMEOUT;
        loop {
            let mut same = Vec::new();
            for &address in [home].iter().chain(others) {
                self.fence.set_device(address);
                let answer = self.ask(MasterRequest::Diagnosis { to: address })?;
                if answer.diagnosis().is_some_and(|found| found.ident == ident) {
                    if address == home {
                        return Ok(home);
                    }
                    same.push(address);
                }
            }
            self.fence.set_device(home);
            match same[..] {
                [only] => {
                    self.fence.set_device(only);
                    return Ok(only);
                }
                [] if self.bus.now() < until => {}
                [] => {
                    return unusable(format!(
                        "no slave with ident 0x{ident:04X} answers on {}; check its power and cable",
                        self.name
                    ));
                }
                _ => {
                    let all: Vec<String> = same.iter().map(u8::to_string).collect();
                    return unusable(format!(
                        "slaves with ident 0x{ident:04X} are at {}, and none is at {home}: leave only the one of the journal on the bus",
                        all.join(", ")
                    ));
                }
            }
        }
    }

    /// Waits for the diagnosis of the slave; returns its ident number.
    fn find(&mut self, station: u8, expected: &ExpectedSlave, others: &[u8]) -> PreflightResult<u16> {
        let until = self.bus.now() + SLAVE_TIMEOUT;
        loop {
            let answer = self.ask(MasterRequest::Diagnosis { to: station })?;
            match (answer.diagnosis(), expected.ident) {
                (Some(found), Some(ident)) if found.ident != ident => {
                    return unusable(format!(
                        "the slave at station {station} has ident 0x{:04X}, expected 0x{ident:04X}: check the claimed type",
                        found.ident
                    ));
                }
                (Some(found), _) => return Ok(found.ident),
                (None, _) if self.bus.now() < until => {}
                (None, _) => {
                    let there: Vec<String> =
                        others.iter().filter(|of| **of <= HIGHEST + 1).map(u8::to_string).collect();
                    let there = match there.as_slice() {
                        [] => "no other station does; check power and cable".to_owned(),
                        there => format!(
                            "there are stations at {}; set the address in a bench file with `line: {{ address: .. }}`",
                            there.join(", ")
                        ),
                    };
                    return unusable(format!("no slave answers at station {station}; {there}"));
                }
            }
        }
    }

    /// The longest delay from a request to the start of the slave's answer.
    fn turnaround(&mut self, station: u8) -> PreflightResult<Duration> {
        let mut longest = Duration::ZERO;
        for _ in 0..RESPONSE_SAMPLES {
            let answer = self.ask(MasterRequest::Diagnosis { to: station })?;
            if answer.diagnosis().is_some() {
                longest = longest.max(self.answered);
            }
        }
        Ok(longest)
    }

    /// Sends a request that the data link answers.
    fn ask(&mut self, request: MasterRequest) -> PreflightResult<DataLinkAnswer> {
        let now = self.bus.now();
        self.master.request(now, request).map_err(|busy| Unusable(busy.to_string()))?;
        let until = now + REQUEST_TIMEOUT;
        loop {
            match self.master.take_outcome() {
                Some(MasterOutcome::Answer(answer)) => return Ok(answer),
                Some(MasterOutcome::Impossible(why)) => {
                    return unusable(format!("a request on the bus at {} failed: {why}", self.name));
                }
                Some(_) => return unusable(format!("a request on the bus at {} was interrupted", self.name)),
                None if self.bus.now() >= until => {
                    return unusable(format!("the master does not get the token on {}", self.name));
                }
                None => {}
            }
            interruptible()?;
            let BusPreflight { bus, fence, master, name, sent, answered } = self;
            let mut foreign = None;
            let mut tap = |of: BusTransmission<'_>| {
                match of.sender {
                    Some(_) => *sent = of.end,
                    None => *answered = of.begin.since(*sent),
                }
                if of.sender.is_none() && is_of_master(of.octets) {
                    foreign = Some(words(of.octets));
                }
            };
            bus.step(&mut [master], until, &mut |frame| fence.allows(frame), &mut tap)?;
            if let Some(foreign) = foreign {
                return unusable(format!("{name} has another master: received {foreign}; take it off the bus"));
            }
        }
    }
}

/// Fails if the run was interrupted.
pub(super) fn interruptible() -> PreflightResult<()> {
    if link::interrupt::requested() { unusable("interrupted; nothing was changed") } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    #[rstest]
    #[case(
        None,
        Some(Driver::Adapter),
        Err("set the baud rate of the bus at a line in a bench file with `line: { baud: .. }`, or with `--baud`")
    )]
    #[case(
        Some(500_000),
        Some(Driver::Adapter),
        Err("a line cannot keep the timing of a bus at 500000 bit/s; set the bus to 187500 bit/s or less")
    )]
    #[case(Some(9_600), None, Err("the driver of the adapter at a line has to be switched by hardware"))]
    #[case(Some(187_500), Some(Driver::Port), Ok(187_500))]
    fn a_rate_whose_timing_cannot_be_kept_is_refused(
        #[case] baud: Option<u32>,
        #[case] driver: Option<Driver>,
        #[case] expected: Result<u32, &str>,
    ) {
        let spec = LineSpec { baud: baud.map(BaudRate), driver, ..LineSpec::default() };
        match (timed(&spec, "a line"), expected) {
            (Ok(baud), expected) => assert_eq!(Ok(baud.0), expected),
            (Err(Unusable(why)), Err(expected)) => assert!(why.starts_with(expected), "{why}"),
            (Err(why), Ok(_)) => panic!("{why}"),
        }
    }
}
