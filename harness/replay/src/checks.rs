//! The rules and checks that judge each frame, of a capture as well as of live traffic, and the frames around what they find.

use super::finding::ContextCollector;
use super::protocol::ProtocolChecks;
use super::read::order::OrderedFrame;
use super::read::reassembly::LostDatagram;
use super::rules::{CaptureRules, NewViolation};
use super::walk::CaptureVisitor;
use judge::observe::{Observation, ObservedAr};
use suite::device::Bus;
use suite::model::Manual;

pub(super) struct FrameChecks<'a> {
    pub rules: CaptureRules<'a>,
    pub protocol: ProtocolChecks,
    /// The frames around the findings.
    pub contexts: ContextCollector,
}

impl<'a> FrameChecks<'a> {
    /// No frame yet; `manuals` give the rules.
    pub fn new(manuals: &'a [Manual]) -> FrameChecks<'a> {
        FrameChecks {
            rules: CaptureRules::new(manuals),
            protocol: ProtocolChecks::default(),
            contexts: ContextCollector::default(),
        }
    }
}

impl CaptureVisitor for FrameChecks<'_> {
    fn begin(&mut self, bus: Bus, next: &OrderedFrame<'_>) {
        self.contexts.keep(bus, next.number, next.time, next.octets);
        self.protocol.begin(bus, next.number, next.time, next.octets, next.cut.is_some());
    }

    #[inline]
    fn observe(&mut self, bus: Bus, ars: &[ObservedAr], next: &OrderedFrame<'_>, observation: &Observation<'_>) {
        self.protocol.observe(bus, ars, observation);
        self.rules.observe(bus, ars, (next.time, next.number), observation);
    }

    /// Keeps the frames around the new findings.
    fn frame_done(&mut self, bus: Bus, ars: &[ObservedAr]) {
        let FrameChecks { protocol, rules, contexts } = self;
        if contexts.is_waiting() {
            contexts.fill(ars);
        }
        for NewViolation { frame, trigger, ar } in rules.new_violations(bus) {
            contexts.collect(frame, trigger, ar, ars);
        }
        protocol.frame_done(ars);
        for frame in protocol.news() {
            contexts.collect(frame, None, None, ars);
        }
    }

    fn gap(&mut self, bus: Bus, ars: &[ObservedAr], next: &OrderedFrame<'_>, observation: &Observation<'_>) {
        self.rules.observe(bus, ars, (next.time, next.number), observation);
    }

    fn lost(&mut self, ars: &[ObservedAr], datagram: &LostDatagram) {
        self.protocol.observe(Bus::Profinet, ars, &Observation::Unreadable { why: &datagram.why });
    }

    fn hole(&mut self) {
        self.protocol.hole();
    }

    fn other_link(&mut self, next: &OrderedFrame<'_>) {
        self.contexts.times.take(next.number, next.time);
    }
}
