//! The way through a capture: each frame once, in the order of time, with what it means to the connections of its bus.
//!
//! Whoever judges or shows a capture watches the same walk, so that the same number is the same connection to all of them. This
//! file must not know what is right or wrong.

use super::layout::Layouts;
use super::read::damage::DamageList;
use super::read::order::{Line, Next};
use super::read::reassembly::{IpReassembler, LostDatagram, Reassembled};
use judge::observe::{Ar, DpTracker, Observation, Tracker};
use std::io::Read;
use suite::device::Bus;
use suite::model::Manual;
use virtual_wire::CaptureReader;
use virtual_wire::capture::{Item, LinkType, NotACapture};
use wire::profinet::rpc;

/// Who is told what comes by.
pub(super) trait Watch {
    /// A frame of this bus; what is observed in it follows.
    fn begin(&mut self, bus: Bus, next: &Next<'_>);

    /// What the frame means.
    fn observe(&mut self, bus: Bus, ars: &[Ar], next: &Next<'_>, observation: &Observation<'_>);

    /// All was told that the frame means.
    fn seen(&mut self, bus: Bus, ars: &[Ar]);

    /// Frames may be missing before this one, or its time is in doubt; told of both buses and before [`begin`](Self::begin).
    fn gap(&mut self, bus: Bus, ars: &[Ar], next: &Next<'_>, observation: &Observation<'_>);

    /// A datagram of RPC that came in fragments cannot be put together; told before the frame that is next.
    fn lost(&mut self, _ars: &[Ar], _datagram: &LostDatagram) {}

    /// Frames may be missing here, also behind the last one.
    fn hole(&mut self);

    /// A frame that is neither of PROFINET nor of PROFIBUS.
    fn other_link(&mut self, next: &Next<'_>);
}

/// What is known at the end of the way.
pub(super) struct Walked<'a> {
    /// The connections of PROFINET.
    pub tracker: Tracker,
    /// Those of PROFIBUS.
    pub slaves: DpTracker,
    /// What was guessed of connections without a Connect.
    pub layouts: Layouts<'a>,
    pub damage: DamageList,
    datagrams: IpReassembler,
    /// How many frames there were.
    pub frames: u64,
}

/// Goes through one capture, pcap or pcapng, packed or not; `told` hears after each frame how many were read, and at the end once
/// more.
///
/// An error says that `input` cannot be read or is no capture; whatever is wrong further on is damage.
pub(super) fn walk<'a>(
    input: impl Read,
    manuals: &'a [Manual],
    watch: &mut impl Watch,
    told: &mut dyn FnMut(u64, bool),
) -> Result<Walked<'a>, NotACapture> {
    let mut reader = CaptureReader::new(input)?;
    let mut walked = Walked {
        tracker: Tracker::recorded(),
        slaves: DpTracker::recorded(),
        layouts: Layouts::new(manuals),
        damage: DamageList::default(),
        datagrams: IpReassembler::default(),
        frames: 0,
    };
    let mut line = Line::default();
    while let Some(item) = reader.next() {
        match item {
            Item::Packet(packet) => {
                walked.frames += 1;
                told(walked.frames, false);
                let behind_damage = walked.damage.is_open();
                walked.damage.close(packet.number as u64);
                if let Some(next) = line.push(&packet, behind_damage) {
                    walked.next(&next, watch);
                }
            }
            Item::Damage(damage) => walked.damage.add(damage, walked.frames),
        }
    }
    if let Some(next) = line.end() {
        walked.next(&next, watch);
    }
    walked.datagrams.interrupt();
    walked.tell_lost(watch);
    if walked.damage.is_open() {
        watch.hole();
    }
    told(walked.frames, true);
    Ok(walked)
}

impl Walked<'_> {
    fn next(&mut self, next: &Next<'_>, watch: &mut impl Watch) {
        if next.interrupted {
            self.datagrams.interrupt();
            self.tell_lost(watch);
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

    fn frame(&mut self, next: &Next<'_>, watch: &mut impl Watch) {
        let reassembled = self.datagrams.take(next.number, next.time, next.octets);
        self.tell_lost(watch);
        let Walked { tracker, layouts, datagrams, .. } = self;
        let octets = if reassembled == Reassembled::Whole { datagrams.whole() } else { next.octets };
        let next = &Next { octets, ..*next };
        watch.begin(Bus::Profinet, next);
        let mut sink = |ars: &[Ar], observation: Observation<'_>| {
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
            let mut tell = |ars: &[Ar], observation: Observation<'_>| {
                watch.observe(Bus::Profinet, ars, next, &observation);
            };
            if let Some(ar) = tracker.adopt(met, &mut tell) {
                layouts.took(ar, guess);
            }
        }
        watch.seen(Bus::Profinet, tracker.ars());
    }

    /// Of the datagrams that cannot be put together those of RPC are told.
    fn tell_lost(&mut self, watch: &mut impl Watch) {
        for datagram in self.datagrams.lost().filter(|of| [of.ports.0, of.ports.1].contains(&rpc::PORT)) {
            watch.lost(self.tracker.ars(), &datagram);
        }
    }

    fn bus_frame(&mut self, next: &Next<'_>, watch: &mut impl Watch) {
        watch.begin(Bus::Profibus, next);
        self.slaves.frame(next.number, next.time, next.octets, &mut |ars, observation| {
            watch.observe(Bus::Profibus, ars, next, &observation);
        });
        watch.seen(Bus::Profibus, self.slaves.ars());
    }
}
