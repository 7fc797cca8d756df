//! What is wrong on the wire whatever the device is: start-up, calls, cyclic frames, alarms, names, addresses, neighbours; slaves,
//! polls and tokens on PROFIBUS.
//!
//! One file for a subject, each a small state machine that is fed with what the trackers observe and asked at the end. Nothing is
//! claimed that the capture could not have shown: whoever misses something asks [`sight::Sight`] first. This room must not know
//! manuals or rules.

mod abort;
mod alarms;
mod bus;
mod calls;
mod cyclic;
mod diagnosis;
mod sight;
mod slaves;
mod start;
mod stations;
mod status;
pub mod table;
mod topology;
mod words;

use super::finding::{Blame, Finding, Severity};
use judge::observe::{Ar, DpTracker, Observation, Tracker};
use sight::{Sight, Told};
use station::Time;
use suite::device::Bus;
use wire::datagram::arp::Arp;
use wire::ethernet::{EtherType, FrameHeader};
use wire::profinet::rt::FrameId;

/// All checks of the protocol on one capture.
#[derive(Debug, Default)]
pub(super) struct Protocol {
    sight: Sight,
    told: Told,
    start: start::Starts,
    calls: calls::Calls,
    cyclic: cyclic::Flows,
    status: status::Statuses,
    abort: abort::Aborts,
    alarms: alarms::Alarms,
    stations: stations::Stations,
    topology: topology::Topology,
    slaves: slaves::Slaves,
    diagnosis: diagnosis::Diagnoses,
    bus: bus::Line,
}

impl Protocol {
    /// A frame begins: its number from 1, its time, and its octets as captured.
    pub fn begin(&mut self, bus: Bus, number: u64, time: Time, octets: &[u8]) {
        self.sight.frame(number, time);
        if bus.is_profibus() {
            return;
        }
        let Ok((header, payload)) = FrameHeader::parse(octets) else { return };
        // Cyclic frames of known connections are counted there; whoever sends others is remembered here.
        match header.ether_type {
            EtherType::PROFINET if FrameId::peek(payload).is_ok_and(FrameId::is_cyclic) => return,
            EtherType::ARP => {
                if let Ok(arp) = Arp::parse(payload) {
                    self.stations.arp(self.sight.now, &arp, &mut self.told);
                }
            }
            _ => {}
        }
        self.sight.seen(header.source, header.destination);
    }

    /// The capture is damaged here: frames may be missing.
    pub fn hole(&mut self) {
        self.sight.hole();
    }

    /// Takes in what a tracker says of the frame.
    pub fn observe(&mut self, bus: Bus, ars: &[Ar], observation: &Observation<'_>) {
        let Protocol { sight, told, .. } = self;
        if bus.is_profibus() {
            self.slaves.observe(sight.now, ars, observation, told);
            self.diagnosis.observe(sight.now, ars, observation, told);
            self.bus.observe(sight.now, observation);
            return;
        }
        if let Observation::Cyclic { .. } = observation {
            self.cyclic.observe(sight.now, ars, observation, told);
            self.status.observe(sight.now, ars, observation, told);
            return;
        }
        self.abort.observe(sight.now, ars, observation, told);
        self.start.observe(sight.now, ars, observation, told);
        self.calls.observe(sight.now, ars, observation, told);
        self.cyclic.observe(sight.now, ars, observation, told);
        self.alarms.observe(sight.now, ars, observation, told);
        self.stations.observe(sight.now, ars, observation, told);
        if let Observation::Lldp { source, pdu } = observation {
            self.topology.observe(sight.now, *source, pdu);
        }
    }

    /// The frames since the last call in which something is, or may turn out to be, wrong.
    pub fn news(&mut self) -> impl Iterator<Item = u64> {
        self.told.news()
    }

    /// All that was found; connections of slaves are counted for themselves.
    pub fn end(self, tracker: &Tracker, slaves: &DpTracker) -> Vec<Finding> {
        let Protocol { mut sight, mut told, .. } = self;
        let ars = tracker.ars();
        for ar in ars {
            for (stream, source, destination) in
                [(&ar.inputs, &ar.device, &ar.controller), (&ar.outputs, &ar.controller, &ar.device)]
            {
                if stream.frames > 0 {
                    sight.seen(source.mac(), destination.mac());
                }
            }
        }
        for stray in tracker.strays() {
            sight.seen(stray.source, stray.destination);
        }
        self.start.end(&sight, ars, &mut told);
        self.calls.end(&sight, ars, &mut told);
        self.cyclic.end(&sight, ars, &mut told);
        self.status.end(&sight, ars, &mut told);
        self.alarms.end(&sight, ars, &mut told);
        self.stations.end(&sight, &mut told);
        self.topology.end(&sight, &mut told);
        self.slaves.end(sight.now, slaves.ars(), &mut told);
        self.diagnosis.end(slaves.ars(), &mut told);
        self.bus.end(slaves.counts(), &mut told);
        let counts = tracker.counts();
        let shows_nothing = counts.profinet == 0 && counts.rpc.is_empty() && slaves.counts().frames == 0;
        // Neighbours and addresses can be judged without a frame of PROFINET. Silence must not look like a good device.
        if told.is_empty() && shows_nothing {
            let text = match counts.frames {
                0 => "no frame is of Ethernet or PROFIBUS: no device and no controller can be judged".to_owned(),
                frames => format!(
                    "none of the {frames} Ethernet frames is of PROFINET: no device and no controller can be judged by them"
                ),
            };
            told.add(table::NOTHING.finding(Severity::Error, Blame::Capture, sight.now.frame, text));
        }
        told.end()
    }
}
