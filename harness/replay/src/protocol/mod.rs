//! What is wrong on the wire independent of the device: start-up, calls, cyclic frames, alarms, names, addresses, neighbours; on
//! PROFIBUS slaves, polls and tokens.
//!
//! There is one file for each subject, a small state machine that takes in the observations of the trackers and reports at the
//! end. A check that reports something as missing first asks [`coverage::CaptureCoverage`] whether the capture could have shown it. This module
//! must not know manuals or rules.

mod abort;
mod accepted;
mod advice;
mod alarms;
mod answers;
mod bus;
mod calls;
mod coverage;
mod cyclic;
mod diagnosis;
mod gaps;
mod slaves;
mod start;
mod stations;
mod status;
mod streams;
mod surroundings;
pub mod table;
mod text;
mod topology;

use super::finding::{CaptureBlame, CaptureFinding, FindingSeverity};
use super::report::StreamCoverage;
pub(crate) use coverage::MORE_OF_A_CHECK;
pub(super) use coverage::SettledFrames;
use coverage::{CaptureCoverage, FindingList};
use gaps::GapList;
use judge::observe::{DpTracker, Observation, ObservedAr, Tracker, Traffic};
use station::Time;
use suite::device::Bus;
use wire::datagram::arp::Arp;
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::profinet::rt::{FrameId, FrameKind};

/// Whether a PROFINET frame is one of the alarm channel.
fn is_alarm(payload: &[u8]) -> bool {
    FrameId::peek(payload).is_ok_and(|id| matches!(id.kind(), FrameKind::AlarmHigh | FrameKind::AlarmLow))
}

/// All protocol checks on one capture.
#[derive(Clone, Debug, Default)]
pub(super) struct ProtocolChecks {
    sight: CaptureCoverage,
    findings: FindingList,
    start: start::StartUpCheck,
    calls: calls::CallCheck,
    cyclic: cyclic::CyclicFlows,
    status: status::StatusChecks,
    streams: streams::WatchedStreams,
    abort: abort::Aborts,
    alarms: alarms::AlarmCheck,
    stations: stations::StationCheck,
    topology: topology::Topology,
    slaves: slaves::PolledSlaves,
    diagnosis: diagnosis::SlaveDiagnoses,
    bus: bus::TokenRing,
    surroundings: surroundings::Surroundings,
    answers: answers::AnswerCheck,
}

impl ProtocolChecks {
    /// A frame begins: its number from 1, its time, and its bytes as captured.
    ///
    /// `is_cut`: the capture kept only a part of it.
    pub fn begin(&mut self, bus: Bus, number: u64, time: Time, octets: &[u8], is_cut: bool) {
        self.sight.frame(number, time);
        self.answers.begin(is_cut);
        if bus.is_profibus() {
            return;
        }
        let Ok((header, payload)) = FrameHeader::parse(octets) else { return };
        // Cyclic frames of known connections are counted by the tracker; senders of all other frames are remembered here.
        match header.ether_type {
            EtherType::PROFINET if FrameId::peek(payload).is_ok_and(FrameId::is_cyclic) => return,
            EtherType::IPV4 => self.streams.called(self.sight.now, header.source),
            EtherType::PROFINET if is_alarm(payload) => self.streams.called(self.sight.now, header.source),
            EtherType::ARP => {
                if let Ok(arp) = Arp::parse(payload) {
                    self.surroundings.arp(self.sight.now, header.source, &arp, &mut self.findings);
                    let claims = self.stations.arp(self.sight.now, &arp, &mut self.findings);
                    if let Some(other) = claims {
                        self.surroundings.duplicate(self.sight.now, (arp.sender_mac, other), arp.sender_ip);
                    }
                }
            }
            _ => {}
        }
        self.surroundings.frame(self.sight.now, &header, &mut self.findings);
        self.sight.note_frame(header.source, header.destination);
    }

    /// All observations of a frame were passed on.
    #[inline]
    pub fn frame_done(&mut self, ars: &[ObservedAr]) {
        self.cyclic.frame_done(ars);
    }

    /// The capture is damaged here: frames may be missing.
    pub fn hole(&mut self) {
        self.sight.hole();
        self.slaves.hole();
    }

    /// Takes in an observation of a tracker.
    pub fn observe(&mut self, bus: Bus, ars: &[ObservedAr], observation: &Observation<'_>) {
        let ProtocolChecks { sight, findings, .. } = self;
        if bus.is_profibus() {
            self.answers.observe(sight.now, observation, findings);
            self.slaves.observe(sight.now, ars, observation, findings);
            self.diagnosis.observe(sight.now, ars, observation, findings);
            self.bus.observe(sight.now, observation);
            return;
        }
        if let Observation::Cyclic { .. } = observation {
            self.cyclic.observe(sight.now, ars, observation, findings);
            self.status.observe(sight.now, ars, observation, findings);
            return;
        }
        if let Observation::Traffic(Traffic::Stray { .. }) = observation {
            self.streams.observe(sight.now, observation, findings);
            return;
        }
        self.streams.identify(observation);
        self.answers.observe(sight.now, observation, findings);
        let evidence = abort::AbortEvidence { accepted: &self.cyclic.accepted, surroundings: &self.surroundings };
        self.abort.observe(sight.now, ars, observation, evidence, findings);
        self.start.observe(sight.now, ars, observation, findings);
        self.calls.observe(sight.now, ars, observation, findings);
        self.cyclic.observe(sight.now, ars, observation, findings);
        self.alarms.observe(sight.now, ars, observation, findings);
        self.stations.observe(sight.now, ars, observation, findings);
        if let Observation::Lldp { source, pdu } = observation {
            self.topology.observe(sight.now, *source, pdu);
        }
    }

    /// The frames since the last call that have a finding or may turn out to have one.
    pub fn news(&mut self) -> impl Iterator<Item = u64> {
        self.findings.noted_frames()
    }

    /// Time passes without a frame.
    pub fn time(&mut self, now: Time) {
        self.sight.now.time = self.sight.now.time.max(now);
    }

    /// The findings since the last call that do not wait for the end of the capture.
    pub fn take_findings(&mut self) -> Vec<CaptureFinding> {
        self.findings.take()
    }

    /// Forgets what a watch that never ends need not remember.
    pub fn forget(&mut self, settled: SettledFrames<'_>, tracker: &Tracker) {
        self.start.forget(settled);
        self.calls.forget(settled);
        self.cyclic.forget(settled, tracker.ars());
        self.status.forget(settled);
        self.streams.forget(settled);
        self.abort.forget(settled);
        self.alarms.forget(settled);
        self.stations.forget(settled);
        self.topology.forget(settled);
        self.surroundings.forget(settled);
        self.answers.forget(settled);
    }

    /// The same for the slaves, whose connections have their own numbering.
    pub fn forget_slaves(&mut self, settled: SettledFrames<'_>, slaves: &DpTracker) {
        self.slaves.forget(settled);
        self.diagnosis.forget(settled);
        self.answers.forget_slaves(settled);
        self.bus.forget(settled, slaves.counts().frames);
    }

    /// All findings, and what of the cyclic frames without a Connect was judged; the connections of slaves have their own numbering.
    pub fn end(mut self, tracker: &Tracker, slaves: &DpTracker) -> (Vec<CaptureFinding>, Vec<StreamCoverage>) {
        self.streams.end_of_capture();
        let ProtocolChecks { mut sight, mut findings, .. } = self;
        let ars = tracker.ars();
        for ar in ars {
            for (stream, source, destination) in
                [(&ar.inputs, &ar.device, &ar.controller), (&ar.outputs, &ar.controller, &ar.device)]
            {
                if stream.frames > 0 {
                    sight.note_frame(source.mac(), destination.mac());
                }
            }
        }
        for stray in tracker.strays() {
            sight.note_frame(stray.source, stray.destination);
        }
        self.start.end(&sight, ars, &mut findings);
        self.calls.end(&sight, ars, &mut findings);
        let of_streams: Vec<(Mac, &GapList)> = self.streams.gaps().collect();
        self.cyclic.end(&of_streams, &sight, ars, &mut findings);
        self.status.end(&sight, ars, &mut findings);
        let of_connections: Vec<(Mac, &GapList)> = self.cyclic.gaps(ars).collect();
        let streams = self.streams.end(&of_connections, &sight, ars, &mut findings);
        self.alarms.end(&sight, ars, &mut findings);
        self.stations.end(&sight, &mut findings);
        self.topology.end(&sight, &mut findings);
        self.slaves.end(sight.now, slaves.ars(), &mut findings);
        self.diagnosis.end(slaves.ars(), &mut findings);
        self.bus.end(slaves.counts(), &mut findings);
        self.surroundings.end(&mut findings);
        self.answers.end(ars, slaves.ars(), &mut findings);
        let counts = tracker.counts();
        let shows_nothing = counts.profinet == 0 && counts.rpc.is_empty() && slaves.counts().frames == 0;
        // Neighbours and addresses can be judged without a PROFINET frame. An empty capture must not pass as a conforming device.
        if findings.is_empty() && shows_nothing {
            let text = match counts.frames {
                0 => "the capture has no Ethernet and no PROFIBUS frame: no device and no controller can be judged"
                    .to_owned(),
                frames => format!(
                    "none of the {frames} Ethernet frames is PROFINET: no device and no controller can be judged"
                ),
            };
            findings.add(table::NOTHING.finding(FindingSeverity::Error, CaptureBlame::Capture, sight.now.frame, text));
        }
        (findings.end(), streams)
    }
}
