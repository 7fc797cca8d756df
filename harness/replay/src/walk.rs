//! Reads a capture frame by frame in order of time, and tracks the connections of its bus.
//!
//! Judging and showing a capture use the same pass, so that a connection has the same number in both. This module must not know
//! what is right or wrong.

use super::layout_guess::{LayoutGuesser, StationIdentity};
use super::read::damage::DamageList;
use super::read::order::{FrameOrder, OrderedFrame};
use super::read::reassembly::{IpReassembler, LostDatagram, Reassembled};
use judge::observe::{DpTracker, Observation, ObservedAr, Tracker};
use std::io::Read;
use suite::device::Bus;
use suite::model::Manual;
use virtual_wire::CaptureReader;
use virtual_wire::capture::{CaptureItem, CapturedPacket, LinkType, NotACapture};
use wire::profinet::rpc;

/// Receives the frames and observations of a capture.
pub(super) trait CaptureVisitor {
    /// A frame on this bus begins; its observations follow.
    fn begin(&mut self, bus: Bus, next: &OrderedFrame<'_>);

    /// An observation in the frame.
    fn observe(&mut self, bus: Bus, ars: &[ObservedAr], next: &OrderedFrame<'_>, observation: &Observation<'_>);

    /// All observations of the frame were passed on.
    fn frame_done(&mut self, bus: Bus, ars: &[ObservedAr]);

    /// Frames may be missing before this one, or its time is in doubt; called for both buses, before [`begin`](Self::begin).
    fn gap(&mut self, bus: Bus, ars: &[ObservedAr], next: &OrderedFrame<'_>, observation: &Observation<'_>);

    /// A fragmented RPC datagram cannot be reassembled; called before the next frame.
    fn lost(&mut self, _ars: &[ObservedAr], _datagram: &LostDatagram) {}

    /// Frames may be missing here; also called after the last one.
    fn hole(&mut self);

    /// A frame that is neither PROFINET nor PROFIBUS.
    fn other_link(&mut self, next: &OrderedFrame<'_>);
}

/// The trackers and counts after the last frame.
pub(super) struct TrackedCapture<'a> {
    /// The connections on PROFINET.
    pub tracker: Tracker,
    /// The connections on PROFIBUS.
    pub slaves: DpTracker,
    /// The guessed layouts of connections without a Connect.
    pub layouts: LayoutGuesser<'a>,
    pub damage: DamageList,
    datagrams: IpReassembler,
    order: FrameOrder,
    pub frames: u64,
}

/// Reads one capture, pcap or pcapng, packed or not; `identities` are of stations that the capture identifies too late. Calls
/// `progress` with the number of frames read after each frame, and at the end once more with `true`.
///
/// # Errors
///
/// `input` cannot be read or is not a capture. Damage after its begin is part of the result.
pub(super) fn walk<'a>(
    input: impl Read,
    manuals: &'a [Manual],
    identities: &[StationIdentity],
    watch: &mut impl CaptureVisitor,
    progress: &mut dyn FnMut(u64, bool),
) -> Result<TrackedCapture<'a>, NotACapture> {
    let mut reader = CaptureReader::new(input)?;
    let mut walked = TrackedCapture::new(manuals);
    for (mac, ids) in identities {
        walked.tracker.know(*mac, *ids);
    }
    while let Some(item) = reader.next() {
        match item {
            CaptureItem::Packet(packet) => {
                progress(walked.frames + 1, false);
                let after_damage = walked.damage.is_open();
                walked.damage.close(packet.number as u64);
                walked.packet(&packet, after_damage, watch);
            }
            CaptureItem::Damage(damage) => walked.damage.add(damage, walked.frames),
        }
    }
    walked.flush(watch);
    walked.datagrams.interrupt();
    walked.pass_on_lost(watch);
    if walked.damage.is_open() {
        watch.hole();
    }
    progress(walked.frames, true);
    Ok(walked)
}

impl<'a> TrackedCapture<'a> {
    /// A capture without frames.
    pub fn new(manuals: &'a [Manual]) -> TrackedCapture<'a> {
        TrackedCapture {
            tracker: Tracker::recorded(),
            slaves: DpTracker::recorded(),
            layouts: LayoutGuesser::new(manuals),
            damage: DamageList::default(),
            datagrams: IpReassembler::default(),
            order: FrameOrder::default(),
            frames: 0,
        }
    }

    /// Takes in the next packet and passes on the one before; `after_damage`: frames may be missing before it.
    pub fn packet(&mut self, packet: &CapturedPacket<'_>, after_damage: bool, watch: &mut impl CaptureVisitor) {
        self.frames += 1;
        let mut order = std::mem::take(&mut self.order);
        if let Some(next) = order.push(packet, after_damage) {
            self.next(&next, watch);
        }
        self.order = order;
    }

    /// Passes on the last packet.
    pub fn flush(&mut self, watch: &mut impl CaptureVisitor) {
        let mut order = std::mem::take(&mut self.order);
        if let Some(next) = order.end() {
            self.next(&next, watch);
        }
        self.order = order;
    }

    fn next(&mut self, next: &OrderedFrame<'_>, watch: &mut impl CaptureVisitor) {
        if next.interrupted {
            self.datagrams.interrupt();
            self.pass_on_lost(watch);
            watch.hole();
            self.tracker.gap(next.time, &mut |ars, observation| watch.gap(Bus::Profinet, ars, next, &observation));
            self.slaves.gap(next.time, &mut |ars, observation| watch.gap(Bus::Profibus, ars, next, &observation));
        }
        match next.link {
            LinkType::ETHERNET => self.frame(next, watch),
            LinkType::PROFIBUS => self.bus_frame(next, watch),
            LinkType(_) => watch.other_link(next),
        }
    }

    fn frame(&mut self, next: &OrderedFrame<'_>, watch: &mut impl CaptureVisitor) {
        let reassembled = self.datagrams.take(next.number, next.time, next.octets);
        self.pass_on_lost(watch);
        let TrackedCapture { tracker, layouts, datagrams, .. } = self;
        let octets = if reassembled == Reassembled::Whole { datagrams.whole() } else { next.octets };
        let next = &OrderedFrame { octets, ..*next };
        watch.begin(Bus::Profinet, next);
        let mut sink = |ars: &[ObservedAr], observation: Observation<'_>| {
            layouts.observe(&observation);
            watch.observe(Bus::Profinet, ars, next, &observation);
        };
        match reassembled {
            Reassembled::Part => tracker.part(next.time, &mut sink),
            Reassembled::Untouched | Reassembled::Whole => {
                tracker.frame(next.number, next.time, next.octets, &mut sink);
            }
        }
        if let Some((met, guess)) = layouts.guessed(tracker) {
            let mut pass_on = |ars: &[ObservedAr], observation: Observation<'_>| {
                watch.observe(Bus::Profinet, ars, next, &observation);
            };
            if let Some(ar) = tracker.adopt(met, &mut pass_on) {
                layouts.remember_guess(ar, guess);
            }
        }
        watch.frame_done(Bus::Profinet, tracker.ars());
    }

    /// Passes on the lost datagrams of RPC.
    fn pass_on_lost(&mut self, watch: &mut impl CaptureVisitor) {
        for datagram in self.datagrams.lost().filter(|of| [of.ports.0, of.ports.1].contains(&rpc::PORT)) {
            watch.lost(self.tracker.ars(), &datagram);
        }
    }

    fn bus_frame(&mut self, next: &OrderedFrame<'_>, watch: &mut impl CaptureVisitor) {
        watch.begin(Bus::Profibus, next);
        self.slaves.frame(next.number, next.time, next.octets, &mut |ars, observation| {
            watch.observe(Bus::Profibus, ars, next, &observation);
        });
        watch.frame_done(Bus::Profibus, self.slaves.ars());
    }
}
