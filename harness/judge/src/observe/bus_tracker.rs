//! A tracker for either bus.

use super::tracker::Sink;
use super::{DpTracker, ObservedAr, ProfibusWords, Tracker, describe};
use station::Time;
use suite::device::Bus;
use virtual_wire::capture::LinkType;

/// The tracker of one bus.
#[derive(Debug)]
pub enum BusTracker {
    /// PROFINET.
    Profinet(Box<Tracker>),
    /// PROFIBUS.
    Profibus(Box<DpTracker>),
}

/// The link type of captures of a bus.
pub fn link_type(bus: Bus) -> LinkType {
    match bus {
        Bus::Profinet => LinkType::ETHERNET,
        Bus::Profibus => LinkType::PROFIBUS,
    }
}

impl BusTracker {
    /// A tracker without frames.
    pub fn new(bus: Bus) -> BusTracker {
        match bus {
            Bus::Profinet => BusTracker::Profinet(Box::default()),
            Bus::Profibus => BusTracker::Profibus(Box::default()),
        }
    }

    /// A tracker for a trial, in which the harness is the only controller or master.
    pub fn of_harness(bus: Bus) -> BusTracker {
        match bus {
            Bus::Profinet => BusTracker::new(bus),
            Bus::Profibus => BusTracker::Profibus(Box::new(DpTracker::of_harness())),
        }
    }

    /// The connections so far; an [`ArId`](super::ArId) is an index into them.
    pub fn ars(&self) -> &[ObservedAr] {
        match self {
            BusTracker::Profinet(tracker) => tracker.ars(),
            BusTracker::Profibus(tracker) => tracker.ars(),
        }
    }

    /// Processes one frame and passes its observations to `sink`.
    pub fn frame(&mut self, number: u64, time: Time, octets: &[u8], sink: Sink<'_>) {
        match self {
            BusTracker::Profinet(tracker) => tracker.frame(number, time, octets, sink),
            BusTracker::Profibus(tracker) => tracker.frame(number, time, octets, sink),
        }
    }

    /// Advances time: reports connections that are silent for longer than their watchdog time.
    pub fn time(&mut self, now: Time, sink: Sink<'_>) {
        match self {
            BusTracker::Profinet(tracker) => tracker.time(now, sink),
            BusTracker::Profibus(tracker) => tracker.time(now, sink),
        }
    }

    /// Formats consecutive frames as one line each.
    pub fn describe<'f>(&self, frames: impl Iterator<Item = &'f [u8]>) -> Vec<String> {
        match self {
            BusTracker::Profinet(tracker) => frames.map(|frame| describe(frame, tracker.ars())).collect(),
            BusTracker::Profibus(_) => {
                let mut words = ProfibusWords::default();
                frames.map(|frame| words.lines(frame).join(" | ")).collect()
            }
        }
    }
}
