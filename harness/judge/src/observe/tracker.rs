//! The tracker for PROFINET: turns frames into observations and stores the state between frames.
//!
//! Cyclic frames are the hot path: one hash lookup by source, destination and frame id, and no allocation. Calls, alarms and DCP
//! are in separate modules that share this state.

use super::calls::TrackedCalls;
use super::connect::ArLink;
use super::copies::CopyDetector;
use super::counts::FrameCounts;
use super::stations::StationTable;
use super::{
    Address, AdoptedConnection, ArId, ArStage, CyclicStatus, CyclicStream, FrameDirection, Observation, ObservedAr,
    Party, Traffic,
};
use rustc_hash::FxHashMap;
use station::{Duration, Time};
use wire::WireError;
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::lldp::Lldp;
use wire::profinet::rpc::{Reassembler, Uuid};
use wire::profinet::rt::{CyclicFrame, FrameId, FrameKind};

/// Receives the observations.
pub(super) type Sink<'a> = &'a mut dyn FnMut(&[ObservedAr], Observation<'_>);

/// Maximum number of connections in a trace; further ones are counted but not followed.
const MOST_CONNECTIONS: usize = 10_000;
/// Maximum number of cyclic streams without a connection that are counted separately.
const MOST_STRAYS: usize = 1_024;
/// Within this time, frames with the same cycle counter are copies of one frame.
const MIRROR_NS: u64 = 1_000_000;
/// Nanoseconds of one step of the cycle counter.
pub(super) const COUNTER_STEP_NS: u64 = 31_250;

/// Turns frames into observations and stores the connections.
#[derive(Debug)]
pub struct Tracker {
    pub(super) ars: Vec<ObservedAr>,
    /// Internal data of each connection, in the same order.
    pub(super) links: Vec<ArLink>,
    /// The ids of forgotten connections, which later ones get.
    unused: Vec<u32>,
    /// The last connection of each UUID.
    pub(super) by_uuid: FxHashMap<Uuid, u32>,
    /// The last connections between a controller and a device.
    pub(super) by_pair: FxHashMap<(Mac, Mac), Vec<u32>>,
    pub(super) calls: TrackedCalls,
    pub(super) fragments: Reassembler,
    pub(super) stations: StationTable,
    pub(super) counts: FrameCounts,
    routes: FxHashMap<StreamKey, Route>,
    strays: FxHashMap<StreamKey, Stray>,
    /// Connections with a running watchdog.
    standing: Vec<u32>,
    /// The earliest watchdog deadline in nanoseconds.
    earliest: u64,
    repeated: CopyDetector,
    /// Whether the frames are from a recording, in which frames may be missing.
    pub(super) is_recorded: bool,
}

/// The order of a cyclic frame in its stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CounterOrder {
    /// The next frame.
    Next,
    /// A copy of an earlier frame.
    Repeated,
    /// Frames before it are missing.
    AfterLoss,
    /// Out of order: it was sent before the previous frame.
    OutOfOrder,
}

/// Source and frame id in one word, destination in the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct StreamKey(u64, u64);

/// The connection and stream of a cyclic frame.
#[derive(Clone, Copy, Debug)]
struct Route {
    ar: u32,
    direction: FrameDirection,
    /// Steps of the cycle counter from one frame to the next.
    step: u32,
    /// Time in nanoseconds within which the same cycle counter means a copy.
    window: u64,
}

/// A cyclic stream whose connection establishment is not in the trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stray {
    pub source: Mac,
    pub destination: Mac,
    pub frame_id: u16,
    /// Number of frames.
    pub frames: u64,
    /// Number of the first frame.
    pub first_frame: u64,
    /// Time of the first frame.
    pub first_time: Time,
}

impl StreamKey {
    #[inline]
    fn new(source: Mac, destination: Mac, frame_id: u16) -> StreamKey {
        StreamKey(word(source) << 16 | u64::from(frame_id), word(destination))
    }
}

#[inline]
fn word(Mac([a, b, c, d, e, f]): Mac) -> u64 {
    u64::from_be_bytes([0, 0, a, b, c, d, e, f])
}

impl Default for Tracker {
    fn default() -> Tracker {
        Tracker::new()
    }
}

impl Tracker {
    /// A tracker without frames.
    pub fn new() -> Tracker {
        Tracker {
            ars: Vec::new(),
            links: Vec::new(),
            unused: Vec::new(),
            by_uuid: FxHashMap::default(),
            by_pair: FxHashMap::default(),
            calls: TrackedCalls::default(),
            fragments: Reassembler::new(32, 1 << 16),
            stations: StationTable::default(),
            counts: FrameCounts::default(),
            routes: FxHashMap::default(),
            strays: FxHashMap::default(),
            standing: Vec::new(),
            earliest: u64::MAX,
            repeated: CopyDetector::default(),
            is_recorded: false,
        }
    }

    /// A tracker for a recording: reports missing frames as [`Observation::Gap`]; out-of-order cyclic frames are counted but not
    /// reported.
    pub fn recorded() -> Tracker {
        Tracker { is_recorded: true, ..Tracker::new() }
    }

    /// Reports that frames may be missing before `now`, or that the clock was set.
    ///
    /// A stream without frames after the gap is not reported as silent, since the end of its connection may be missing.
    pub fn gap(&mut self, now: Time, sink: &mut dyn FnMut(&[ObservedAr], Observation<'_>)) {
        self.fragments = Reassembler::new(32, 1 << 16);
        for ar in &mut self.ars {
            ar.inputs.interrupt(now);
            ar.outputs.interrupt(now);
        }
        self.earliest = 0;
        sink(&self.ars, Observation::Gap { ar: None });
    }

    /// The connections so far; an [`ArId`] is an index into them.
    pub fn ars(&self) -> &[ObservedAr] {
        &self.ars
    }

    /// Number of frames of each kind.
    pub fn counts(&self) -> &FrameCounts {
        &self.counts
    }

    /// Cyclic streams whose connection establishment is not in the trace, ordered by first frame.
    pub fn strays(&self) -> Vec<Stray> {
        let mut strays: Vec<Stray> = self.strays.values().copied().collect();
        strays.sort_by_key(|stray| (stray.first_frame, stray.frame_id));
        strays
    }

    /// Processes one frame, beginning with its destination address, and passes its observations to `sink`.
    ///
    /// `number` is the number of the frame in the trace, from 1. Times may go backwards. Expired watchdogs are reported before
    /// the frame.
    pub fn frame(
        &mut self,
        number: u64,
        time: Time,
        octets: &[u8],
        sink: &mut dyn FnMut(&[ObservedAr], Observation<'_>),
    ) {
        self.counts.frames += 1;
        self.time(time, sink);
        let Ok((header, payload)) = FrameHeader::parse(octets) else {
            self.counts.other += 1;
            return;
        };
        let received = ReceivedFrame { number, time, octets, header, payload };
        match header.ether_type {
            EtherType::PROFINET => self.profinet(&received, sink),
            EtherType::IPV4 => self.datagram(&received, sink),
            EtherType::LLDP if !self.is_repeated(&received) => match Lldp::parse(payload) {
                Ok(pdu) => sink(&self.ars, Observation::Lldp { source: header.source, pdu: &pdu }),
                Err(error) => self.unreadable(error, sink),
            },
            _ => self.counts.other += 1,
        }
    }

    /// Counts a frame that is a fragment of a datagram which a later frame completes.
    pub fn part(&mut self, time: Time, sink: &mut dyn FnMut(&[ObservedAr], Observation<'_>)) {
        self.counts.frames += 1;
        self.counts.other += 1;
        self.time(time, sink);
    }

    /// Advances time: reports connections that are silent for longer than their watchdog time.
    ///
    /// A delay of less than one cycle is tolerated, since it may be due to the clock of the capture.
    #[inline]
    pub fn time(&mut self, now: Time, sink: &mut dyn FnMut(&[ObservedAr], Observation<'_>)) {
        if now.as_nanos() > self.earliest {
            self.starve(now.as_nanos(), sink);
        }
    }

    fn profinet(&mut self, received: &ReceivedFrame<'_>, sink: Sink<'_>) {
        self.counts.profinet += 1;
        let frame_id = match FrameId::peek(received.payload) {
            Ok(frame_id) => frame_id,
            Err(error) => return self.unreadable(error.at_offset(received.at()), sink),
        };
        if frame_id.is_cyclic() {
            return self.cyclic(received, frame_id, sink);
        }
        match frame_id.kind() {
            FrameKind::AlarmHigh | FrameKind::AlarmLow if !self.is_repeated(received) => {
                self.alarm(received, frame_id, sink)
            }
            FrameKind::DcpHello
            | FrameKind::DcpGetSet
            | FrameKind::DcpIdentifyRequest
            | FrameKind::DcpIdentifyResponse
                if !self.is_repeated(received) =>
            {
                self.dcp(received, sink);
            }
            _ => {}
        }
    }

    fn cyclic(&mut self, received: &ReceivedFrame<'_>, frame_id: FrameId, sink: Sink<'_>) {
        self.counts.cyclic += 1;
        let key = StreamKey::new(received.header.source, received.header.destination, frame_id.0);
        let Some(&route) = self.routes.get(&key) else { return self.stray(key, received, frame_id, sink) };
        let Some(ar) = self.ars.get_mut(route.ar as usize) else { return };
        let stands = ar.stage.stands();
        let stream = match route.direction {
            FrameDirection::ToController => &mut ar.inputs,
            FrameDirection::ToDevice => &mut ar.outputs,
        };
        let frame = CyclicFrame::parse(received.payload, stream.data_length);
        let counter = frame.ok().map(|frame| frame.status.cycle_counter);
        let taken = stream.take(&route, received.number, received.time, counter);
        if taken == CounterOrder::Repeated {
            self.counts.repeated += 1;
            return;
        }
        if stands && let Some(deadline) = stream.deadline() {
            self.earliest = self.earliest.min(deadline);
        }
        if taken != CounterOrder::Next && self.is_recorded && stands {
            sink(&self.ars, Observation::Gap { ar: Some(ArId(route.ar)) });
            if taken == CounterOrder::OutOfOrder {
                return;
            }
        }
        match frame {
            Ok(frame) if stands => sink(
                &self.ars,
                Observation::Cyclic {
                    ar: ArId(route.ar),
                    direction: route.direction,
                    data: frame.data,
                    at: received.at() + CyclicFrame::DATA_OFFSET,
                    status: CyclicStatus::Apdu(frame.status),
                },
            ),
            Ok(_) => {}
            Err(error) => self.unreadable(error.at_offset(received.at()), sink),
        }
    }

    #[cold]
    fn stray(&mut self, key: StreamKey, received: &ReceivedFrame<'_>, FrameId(frame_id): FrameId, sink: Sink<'_>) {
        if let Ok(frame) = CyclicFrame::parse_to_end(received.payload) {
            let (source, destination) = (received.header.source, received.header.destination);
            let (counter, data) = (frame.status.cycle_counter, frame.data);
            let octets = received.payload.get(CyclicFrame::DATA_OFFSET..).unwrap_or_default();
            let at = received.at() + CyclicFrame::DATA_OFFSET;
            let stray = Traffic::Stray { source, destination, frame_id, counter, data, octets, at };
            sink(&self.ars, Observation::Traffic(stray));
        }
        if let Some(stray) = self.strays.get_mut(&key) {
            stray.frames += 1;
        } else if self.strays.len() < MOST_STRAYS {
            let (source, destination) = (received.header.source, received.header.destination);
            let (first_frame, first_time) = (received.number, received.time);
            self.strays.insert(key, Stray { source, destination, frame_id, frames: 1, first_frame, first_time });
        }
    }

    #[cold]
    fn starve(&mut self, now: u64, sink: Sink<'_>) {
        self.earliest = u64::MAX;
        let mut place = 0;
        while let Some(&index) = self.standing.get(place) {
            let Some(ar) = self.ars.get_mut(index as usize).filter(|ar| ar.stage.stands()) else {
                self.standing.remove(place);
                continue;
            };
            let deadlines = [FrameDirection::ToController, FrameDirection::ToDevice]
                .map(|direction| (ar.stream(direction).deadline().unwrap_or(u64::MAX), direction));
            let (deadline, direction) = if deadlines[1].0 < deadlines[0].0 { deadlines[1] } else { deadlines[0] };
            if now > deadline {
                let unsure = ar.stream(direction).unsure;
                ar.stage = ArStage::Starved;
                self.standing.remove(place);
                let ar = ArId(index);
                let observation =
                    if unsure { Observation::Gap { ar: Some(ar) } } else { Observation::Starved { ar, direction } };
                sink(&self.ars, observation);
            } else {
                self.earliest = self.earliest.min(deadline);
                place += 1;
            }
        }
    }

    /// Vendor ID and device ID of a station, as it reports them in DCP, or as a call to it names them.
    pub fn ids_of(&self, mac: Mac) -> Option<(u16, u16)> {
        let mut party = Party::at(Address::Mac(mac));
        self.stations.complete(&mut party);
        // A call also names the device to which it goes.
        let called = || self.ars.iter().rev().find(|ar| ar.device.mac() == mac && ar.device.ids.is_some());
        party.ids.or_else(|| called().and_then(|ar| ar.device.ids))
    }

    /// Takes vendor ID and device ID of a station as known from the first frame on; a later frame of the trace shows them.
    pub fn know(&mut self, mac: Mac, ids: (u16, u16)) {
        self.stations.know(mac, ids);
    }

    /// Follows a connection that was established before the trace began and whose layout the caller knows; `None` if there are
    /// too many connections.
    pub fn adopt(&mut self, met: AdoptedConnection, sink: Sink<'_>) -> Option<ArId> {
        let pair = (met.controller, met.device);
        let known = self.by_pair.get(&pair).and_then(|known| known.last().copied());
        let known = known.filter(|index| {
            let ar = self.ars.get(*index as usize);
            ar.is_some_and(|ar| ar.connect_frame.is_none() && ar.stage.stands() && ar.submodules.is_empty())
        });
        let index = known.or_else(|| self.add_established(Uuid::NIL, met.controller, met.device))?;
        let ar = self.ars.get_mut(index as usize)?;
        ar.device.ids = ar.device.ids.or(Some(met.ids));
        ar.submodules = met.submodules;
        for (stream, (frame_id, data_length, step)) in [(&mut ar.inputs, met.inputs), (&mut ar.outputs, met.outputs)] {
            (stream.frame_id, stream.data_length) = (frame_id, data_length);
            stream.cycle = Duration::from_nanos(u64::from(step) * COUNTER_STEP_NS);
        }
        self.stands_between(index, [met.controller; 2], [met.device; 2]);
        sink(&self.ars, Observation::Connected { ar: ArId(index) });
        Some(ArId(index))
    }

    /// Adds a connection; `None` if there are too many.
    pub(super) fn add(&mut self, ar: ObservedAr, link: ArLink) -> Option<u32> {
        if let Some(index) = self.unused.pop() {
            self.by_uuid.insert(ar.uuid, index);
            self.ars[index as usize] = ar;
            self.links[index as usize] = link;
            return Some(index);
        }
        if self.ars.len() >= MOST_CONNECTIONS {
            self.counts.connections_left_out += 1;
            return None;
        }
        let index = self.ars.len() as u32;
        self.by_uuid.insert(ar.uuid, index);
        self.ars.push(ar);
        self.links.push(link);
        Some(index)
    }

    /// Forgets a connection that has ended, so that a later one may have its id. Only what is followed for an unlimited time needs this.
    pub fn forget(&mut self, ArId(index): ArId) {
        let Some(ar) = self.ars.get_mut(index as usize).filter(|ar| !ar.stage.stands()) else { return };
        *ar = ObservedAr::forgotten();
        self.links[index as usize] = ArLink::default();
        self.by_uuid.retain(|_, known| *known != index);
        self.by_pair.retain(|_, known| {
            known.retain(|known| *known != index);
            !known.is_empty()
        });
        self.routes.retain(|_, route| route.ar != index);
        self.standing.retain(|known| *known != index);
        self.calls.forget_connection(ArId(index));
        self.unused.push(index);
    }

    /// Forgets the streams without a connection that had no frame for long: those for which `is_old` returns true.
    pub fn forget_strays(&mut self, is_old: impl Fn(&Stray) -> bool) {
        self.strays.retain(|_, stray| !is_old(stray));
    }

    /// Removes the routes of ended connections between two stations, because a new connection is requested.
    pub(super) fn remove_ended_routes(&mut self, controller: Mac, device: Mac) {
        for &index in self.by_pair.get(&(controller, device)).into_iter().flatten() {
            let Some(ar) = self.ars.get(index as usize).filter(|ar| !ar.stage.stands()) else { continue };
            self.routes.remove(&StreamKey::new(device, controller, ar.inputs.frame_id));
            self.routes.remove(&StreamKey::new(controller, device, ar.outputs.frame_id));
        }
    }

    /// Registers the addresses of an established connection for its cyclic frames and alarms.
    pub(super) fn stands_between(&mut self, index: u32, controllers: [Mac; 2], devices: [Mac; 2]) {
        let Some(ar) = self.ars.get_mut(index as usize) else { return };
        self.standing.push(index);
        for (controller, device) in controllers.into_iter().flat_map(|one| devices.map(|other| (one, other))) {
            let pair = self.by_pair.entry((controller, device)).or_default();
            if pair.last() != Some(&index) {
                pair.push(index);
            }
            if pair.len() > 8 {
                pair.remove(0);
            }
            let ends = [
                (FrameDirection::ToController, device, controller, &mut ar.inputs),
                (FrameDirection::ToDevice, controller, device, &mut ar.outputs),
            ];
            for (direction, source, destination, stream) in ends {
                if !FrameId(stream.frame_id).is_cyclic() {
                    continue;
                }
                let key = StreamKey::new(source, destination, stream.frame_id);
                self.routes.insert(key, Route::new(index, direction, stream));
                // Cyclic frames may be received before the Connect response.
                if let Some(early) = self.strays.remove(&key)
                    && ar.connect_frame.is_some_and(|connect| connect < early.first_frame)
                {
                    stream.frames += early.frames;
                    stream.first_frame = Some(early.first_frame);
                }
            }
        }
    }

    /// Whether the frame is a copy of a frame less than a millisecond ago, as from a mirror port.
    pub(super) fn is_repeated(&mut self, received: &ReceivedFrame<'_>) -> bool {
        let repeated = self.repeated.is(received.time, &received.header, received.payload);
        self.counts.repeated += u64::from(repeated);
        repeated
    }

    #[cold]
    pub(super) fn unreadable(&mut self, error: WireError, sink: Sink<'_>) {
        self.counts.unreadable += 1;
        sink(&self.ars, Observation::Unreadable { why: &error.to_string() });
    }
}

/// A received frame with its parsed header.
pub(super) struct ReceivedFrame<'a> {
    pub number: u64,
    pub time: Time,
    pub octets: &'a [u8],
    pub header: FrameHeader,
    pub payload: &'a [u8],
}

impl ReceivedFrame<'_> {
    /// Offset of the payload in the frame.
    #[inline]
    pub fn at(&self) -> usize {
        self.octets.len() - self.payload.len()
    }
}

impl Route {
    fn new(ar: u32, direction: FrameDirection, stream: &CyclicStream) -> Route {
        let cycle = u64::try_from(stream.cycle.as_nanos()).unwrap_or(u64::MAX);
        // A stalled counter repeats after one cycle, a mirrored frame repeats immediately.
        let window = if cycle == 0 { MIRROR_NS } else { MIRROR_NS.min(cycle / 2) };
        Route { ar, direction, step: (cycle / COUNTER_STEP_NS) as u32, window }
    }
}

impl CyclicStream {
    /// Counts a frame and classifies it.
    #[inline]
    fn take(&mut self, route: &Route, number: u64, time: Time, counter: Option<u16>) -> CounterOrder {
        let mut taken = CounterOrder::Next;
        if let Some(last) = self.last {
            let gap = time.as_nanos().saturating_sub(last.as_nanos());
            if let (Some(before), Some(counter)) = (self.last_counter, counter) {
                let steps = u64::from(counter.wrapping_sub(before));
                let backwards = steps > 0xF000;
                if (steps == 0 || backwards) && gap < route.window {
                    self.repeated += u64::from(steps == 0);
                    self.out_of_order += u64::from(backwards);
                    return CounterOrder::Repeated;
                }
                let lost = lost(route.step.into(), steps, gap);
                self.lost += lost;
                self.out_of_order += u64::from(backwards && lost == 0);
                taken = match (lost, backwards) {
                    (0, true) => CounterOrder::OutOfOrder,
                    (0, false) => CounterOrder::Next,
                    _ => CounterOrder::AfterLoss,
                };
            }
            if !self.unsure {
                self.max_gap_ns = self.max_gap_ns.max(gap);
            }
        }
        self.first_frame.get_or_insert(number);
        self.frames += 1;
        self.last = Some(time);
        self.last_counter = counter;
        self.unsure = false;
        taken
    }

    /// Frames may be missing before `now`; they are not counted as lost.
    fn interrupt(&mut self, now: Time) {
        if self.last.is_some() {
            self.last = Some(now);
            self.last_counter = None;
            self.unsure = true;
        }
    }

    /// The watchdog deadline in nanoseconds; `None` before the first frame.
    #[inline]
    fn deadline(&self) -> Option<u64> {
        let last = self.last.filter(|_| !self.watchdog.is_zero())?;
        Some((last + self.watchdog + self.cycle).as_nanos())
    }
}

/// Number of missing frames between two frames with counters `steps` apart, for a cycle of `step`; the counter wraps every 2.048 s.
#[inline]
fn lost(step: u64, steps: u64, gap: u64) -> u64 {
    let elapsed = gap / COUNTER_STEP_NS;
    if step == 0 || steps == step && elapsed < 0x8000 {
        return 0;
    }
    let steps = match elapsed.saturating_sub(steps) {
        more if more >= 0x8000 => steps + (more + 0x8000) / 0x1_0000 * 0x1_0000,
        _ if steps > 0xF000 && elapsed < 0x8000 => return 0,
        _ => steps,
    };
    ((steps + step / 2) / step).saturating_sub(1)
}

#[cfg(test)]
mod tests {
    use super::lost;
    use rstest::rstest;

    // 64 steps are 2 ms. The counter has 16 bits of 31.25 us.
    #[rstest]
    #[case::next(64, 64, 2_000_000, 0)]
    #[case::one_left_out(64, 128, 4_000_000, 1)]
    #[case::jitter_of_the_counter(64, 70, 2_200_000, 0)]
    #[case::stands_still(64, 0, 2_000_000, 0)]
    #[case::goes_back(64, 0xFFC0, 2_000_000, 0)]
    #[case::two_seconds(64, 0xFFC0, 2_046_000_000, 1022)]
    #[case::a_whole_turn(64, 64, 2_050_000_000, 1024)]
    #[case::without_times(64, 640, 0, 9)]
    #[case::unknown_cycle(0, 640, 0, 0)]
    fn missing_frames_are_counted_from_the_cycle_counter(
        #[case] step: u64,
        #[case] steps: u64,
        #[case] gap: u64,
        #[case] missing: u64,
    ) {
        assert_eq!(lost(step, steps, gap), missing);
    }
}
