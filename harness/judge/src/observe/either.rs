//! A tracker for the bus at hand: whoever watches one wire need not know which bus it is.

use super::tracker::Sink;
use super::{Ar, DpTracker, ProfibusWords, Tracker, describe};
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

/// How captures of a bus are marked.
pub fn link_type(bus: Bus) -> LinkType {
    match bus {
        Bus::Profinet => LinkType::ETHERNET,
        Bus::Profibus => LinkType::PROFIBUS,
    }
}

impl BusTracker {
    /// A tracker that has not seen anything yet.
    pub fn new(bus: Bus) -> BusTracker {
        match bus {
            Bus::Profinet => BusTracker::Profinet(Box::default()),
            Bus::Profibus => BusTracker::Profibus(Box::default()),
        }
    }

    /// The connections seen so far; an [`ArId`](super::ArId) is an index into them.
    pub fn ars(&self) -> &[Ar] {
        match self {
            BusTracker::Profinet(tracker) => tracker.ars(),
            BusTracker::Profibus(tracker) => tracker.ars(),
        }
    }

    /// Takes in one frame and tells `sink` what it means.
    pub fn frame(&mut self, number: u64, time: Time, octets: &[u8], sink: Sink<'_>) {
        match self {
            BusTracker::Profinet(tracker) => tracker.frame(number, time, octets, sink),
            BusTracker::Profibus(tracker) => tracker.frame(number, time, octets, sink),
        }
    }

    /// Lets time go by: tells what has been silent for longer than its watchdog.
    pub fn time(&mut self, now: Time, sink: Sink<'_>) {
        match self {
            BusTracker::Profinet(tracker) => tracker.time(now, sink),
            BusTracker::Profibus(tracker) => tracker.time(now, sink),
        }
    }

    /// One line for each of these frames, which follow each other.
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
