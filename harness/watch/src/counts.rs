//! What a monitoring system collects: counts for each connection, findings by id, and the load.

use judge::observe::{Address, CyclicStatus, FrameDirection, Observation, ObservedAr, Party, Traffic};
use replay::{CaptureFinding, FindingSeverity};
use station::{Duration, Time};
use std::collections::BTreeMap;
use suite::device::Bus;

/// Upper limit of the connections that are counted one by one; frames of further ones are in the totals only.
const MOST_CONNECTIONS: usize = 512;
/// Upper limit of the ids of findings.
const MOST_IDS: usize = 1_024;
/// Upper limits of the deviations from the cycle, in microseconds; one more class has no limit.
pub(crate) const JITTER_LIMITS_US: [u64; 10] = [1, 10, 25, 50, 100, 250, 500, 1_000, 2_500, 10_000];
/// Preamble, start delimiter, frame check sequence and interframe gap (IEEE 802.3), which a capture does not show.
const ETHERNET_OVERHEAD: u64 = 24;
/// The shortest frame without its frame check sequence (IEEE 802.3).
const SHORTEST_ETHERNET: u64 = 60;

/// The counts since the watch began.
#[derive(Clone, Debug, Default)]
pub struct WatchCounts {
    pub frames: u64,
    /// Bytes on the wire, with what Ethernet adds to a frame.
    pub wire_octets: u64,
    /// Bits per second over the last full second.
    pub load: u64,
    /// Frames that cannot be read.
    pub unreadable: u64,
    /// Frames that the kernel dropped before this process could read them.
    pub lost_by_kernel: u64,
    /// Frames that were kept but not judged, since the watch was behind.
    pub not_judged: u64,
    /// Frames that were judged but are missing in the ring, because the disk did not keep up.
    pub lost_by_ring: u64,
    /// Frames that the interface has transmitted since the watch began, by whatever program of this host.
    pub transmitted: Option<u64>,
    pub incidents: u64,
    /// Findings, hooks and log entries that could not be passed on.
    pub not_passed_on: u64,
    /// Findings by id and severity.
    pub findings: BTreeMap<(String, &'static str), u64>,
    pub connections: BTreeMap<ConnectionName, ConnectionCounts>,
    /// The connection of each id of a tracker, for PROFINET and PROFIBUS.
    known: [Vec<Option<ConnectionName>>; 2],
    /// The second of the load, and its bytes so far.
    second: (u64, u64),
}

/// Controller and device, or the two stations of a stream whose Connect was not received.
pub type ConnectionName = (String, String);

/// What is counted of a connection.
#[derive(Clone, Debug, Default)]
pub struct ConnectionCounts {
    /// From the device, and to it.
    pub directions: [DirectionCounts; 2],
    /// How often it was established.
    pub starts: u64,
    /// How often it ended by a Release.
    pub releases: u64,
    /// How often it ended by an ERR-RTA.
    pub aborts: u64,
    /// How often one side fell silent for longer than the watchdog.
    pub failures: u64,
    pub alarms: u64,
    /// Whether it stands now.
    pub is_up: bool,
}

/// What is counted of one direction.
#[derive(Clone, Debug, Default)]
pub struct DirectionCounts {
    pub frames: u64,
    /// Missing by the cycle counter.
    pub lost: u64,
    /// How often frames are missing.
    pub gaps: u64,
    /// Frames that arrived after a later one.
    pub overtaken: u64,
    /// Changes of the DataStatus.
    pub status_changes: u64,
    /// Deviations of the intervals from the cycle by `JITTER_LIMITS_US`.
    pub jitter: [u64; JITTER_LIMITS_US.len() + 1],
    pub jitter_sum: Duration,
    /// The sum of the intervals, which gives the update rate.
    pub intervals: Duration,
    pub longest_interval: Duration,
    last: Option<Time>,
    status: Option<u8>,
    seen_lost: u64,
    /// The cycle of a stream without a Connect, as it was observed.
    observed_cycle: Option<Duration>,
}

impl WatchCounts {
    /// Counts a frame of `length` bytes.
    #[inline]
    pub fn frame(&mut self, bus: Bus, time: Time, length: usize) {
        self.frames += 1;
        let octets = match bus {
            Bus::Profinet => (length as u64).max(SHORTEST_ETHERNET) + ETHERNET_OVERHEAD,
            Bus::Profibus => length as u64,
        };
        self.wire_octets += octets;
        let second = time.as_nanos() / 1_000_000_000;
        if second != self.second.0 {
            // PROFIBUS sends 11 bits for each byte.
            let bits = if bus.is_profibus() { 11 } else { 8 };
            self.load = if second == self.second.0 + 1 { self.second.1 * bits } else { 0 };
            self.second = (second, 0);
        }
        self.second.1 += octets;
    }

    /// Counts a finding.
    pub fn finding(&mut self, finding: &CaptureFinding) {
        let key = (finding.id.clone(), severity(finding.severity));
        if self.findings.len() < MOST_IDS || self.findings.contains_key(&key) {
            *self.findings.entry(key).or_default() += 1;
        }
    }

    /// Counts what a frame meant.
    pub fn observe(&mut self, bus: Bus, ars: &[ObservedAr], time: Time, observation: &Observation<'_>) {
        match observation {
            Observation::Cyclic { ar, direction, status, .. } => {
                let index = ar.0 as usize;
                let Some(known) = ars.get(index) else { return };
                let Some(counts) = self.connection(bus, index, known) else { return };
                let stream = known.stream(*direction);
                let status = match status {
                    CyclicStatus::Apdu(status) => Some(status.data_status.0),
                    CyclicStatus::Fdl { .. } => None,
                };
                counts.directions[place(*direction)].take(time, stream.cycle, stream.lost, status);
            }
            Observation::Traffic(Traffic::Stray { source, destination, .. }) => {
                let (one, other) = (source.min(destination), source.max(destination));
                let name = (one.to_string(), other.to_string());
                let place = usize::from(source != one);
                if let Some(counts) = self.named(name) {
                    let direction = &mut counts.directions[place];
                    let cycle = direction.observed(time);
                    direction.take(time, cycle, direction.seen_lost, None);
                }
            }
            Observation::Connected { ar } => {
                self.forget(bus, ar.0 as usize);
                self.change(bus, ars, ar.0, |counts| {
                    counts.starts += 1;
                    counts.is_up = true;
                    for direction in &mut counts.directions {
                        (direction.last, direction.seen_lost) = (None, 0);
                    }
                });
            }
            Observation::Released { ar } => self.change(bus, ars, ar.0, |counts| {
                counts.releases += 1;
                counts.is_up = false;
            }),
            Observation::Aborted { ar, .. } => self.change(bus, ars, ar.0, |counts| {
                counts.aborts += 1;
                counts.is_up = false;
            }),
            Observation::Starved { ar, .. } => self.change(bus, ars, ar.0, |counts| {
                counts.failures += 1;
                counts.is_up = false;
            }),
            Observation::Dp { ar: Some(ar), event: judge::observe::Dp::Left { .. } } => {
                self.change(bus, ars, ar.0, |counts| {
                    counts.failures += 1;
                    counts.is_up = false;
                });
            }
            Observation::Alarm { ar, .. } => self.change(bus, ars, ar.0, |counts| counts.alarms += 1),
            // A cyclic frame that arrives after a later one is passed on as a gap without a loss; after a loss the count has changed.
            Observation::Gap { ar: Some(ar) } => {
                if let Some(known) = ars.get(ar.0 as usize)
                    && let Some(counts) = self.connection(bus, ar.0 as usize, known)
                {
                    for direction in [FrameDirection::ToController, FrameDirection::ToDevice] {
                        let stream = known.stream(direction);
                        let of = &mut counts.directions[place(direction)];
                        if stream.last == Some(time) && stream.lost == of.seen_lost {
                            of.overtaken += 1;
                        }
                    }
                }
            }
            Observation::Unreadable { .. } => self.unreadable += 1,
            _ => {}
        }
    }

    /// Frames are missing: no interval is measured across them.
    pub fn interrupt(&mut self) {
        for direction in self.connections.values_mut().flat_map(|counts| &mut counts.directions) {
            direction.last = None;
        }
    }

    fn change(&mut self, bus: Bus, ars: &[ObservedAr], index: u32, change: impl FnOnce(&mut ConnectionCounts)) {
        if let Some(known) = ars.get(index as usize)
            && let Some(counts) = self.connection(bus, index as usize, known)
        {
            change(counts);
        }
    }

    /// Another connection may have this id now.
    fn forget(&mut self, bus: Bus, index: usize) {
        if let Some(known) = self.known[usize::from(bus.is_profibus())].get_mut(index) {
            *known = None;
        }
    }

    fn connection(&mut self, bus: Bus, index: usize, ar: &ObservedAr) -> Option<&mut ConnectionCounts> {
        let known = &mut self.known[usize::from(bus.is_profibus())];
        if known.len() <= index {
            known.resize(index + 1, None);
        }
        let name = known[index].get_or_insert_with(|| (party(&ar.controller), party(&ar.device)));
        if !self.connections.contains_key(name) && self.connections.len() >= MOST_CONNECTIONS {
            return None;
        }
        if !self.connections.contains_key(name) {
            self.connections.insert(name.clone(), ConnectionCounts::default());
        }
        self.connections.get_mut(name)
    }

    fn named(&mut self, name: ConnectionName) -> Option<&mut ConnectionCounts> {
        if !self.connections.contains_key(&name) && self.connections.len() >= MOST_CONNECTIONS {
            return None;
        }
        Some(self.connections.entry(name).or_default())
    }
}

impl DirectionCounts {
    #[inline]
    fn take(&mut self, time: Time, cycle: Duration, lost: u64, status: Option<u8>) {
        self.frames += 1;
        let is_gap = lost > self.seen_lost;
        if is_gap {
            self.lost += lost - self.seen_lost;
            self.gaps += 1;
        }
        self.seen_lost = lost;
        if let Some(last) = self.last.replace(time) {
            let interval = time.since(last);
            self.intervals += interval;
            self.longest_interval = self.longest_interval.max(interval);
            if !cycle.is_zero() && !is_gap {
                let deviation = interval.abs_diff(cycle);
                self.jitter_sum += deviation;
                let micros = deviation.as_nanos().div_ceil(1_000) as u64;
                self.jitter[JITTER_LIMITS_US.partition_point(|limit| *limit < micros)] += 1;
            }
        }
        if let Some(status) = status {
            self.status_changes += u64::from(self.status.is_some_and(|before| before != status));
            self.status = Some(status);
        }
    }

    /// The usual interval of a stream whose cycle is not known.
    fn observed(&mut self, time: Time) -> Duration {
        let Some(interval) = self.last.map(|last| time.since(last)) else { return Duration::ZERO };
        let cycle = self.observed_cycle.get_or_insert(interval);
        // A moving average over some 64 frames.
        *cycle = (*cycle * 63 + interval) / 64;
        *cycle
    }

    /// The median of the deviations from the cycle, as the limit of its class in microseconds; `None` beyond the last limit.
    pub fn jitter_below_us(&self, share: f64) -> Option<u64> {
        let all: u64 = self.jitter.iter().sum();
        let mut sum = 0;
        let class = self.jitter.iter().position(|count| {
            sum += count;
            sum as f64 >= all as f64 * share
        })?;
        JITTER_LIMITS_US.get(class).copied()
    }
}

fn place(direction: FrameDirection) -> usize {
    match direction {
        FrameDirection::ToController => 0,
        FrameDirection::ToDevice => 1,
    }
}

/// The name of a station, else its address.
fn party(party: &Party) -> String {
    match (&party.station, party.address) {
        (Some(name), _) => name.clone(),
        (None, Address::Fdl(number)) => number.to_string(),
        (None, Address::Mac(mac)) => mac.to_string(),
    }
}

pub(crate) fn severity(severity: FindingSeverity) -> &'static str {
    match severity {
        FindingSeverity::Error => "error",
        FindingSeverity::Warning => "warning",
        FindingSeverity::Info => "info",
    }
}
