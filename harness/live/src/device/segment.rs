//! A real line with the harness's stations on it, for one trial: Ethernet frames, or PROFIBUS on a serial line.
//!
//! It also detects conditions that invalidate the evidence: a lost line, lost frames, another station at work. This module must
//! not know trials.

use super::BenchState;
use super::bus_watch::BusWatch;
use crate::device_discovery::is_cyclic;
use crate::frame_limits::FrameLimits;
use crate::journal::Journal;
use crate::line::DeviceLine;
use controllers::profinet_io::Controller;
use engine::Disturbance;
use engine::HarnessStations;
use engine::TrialEnvironment;
use engine::segment::{FrameTap, Segment};
use link::{BusTransmission, LinkError, WireStep};
use results::journal::JournalEntry;
use station::{Duration, Outbox, Stand, Time};
use std::sync::MutexGuard;
use wire::ethernet::Mac;

/// Interval of the checks for a lost line while a trial runs.
const LINE_CHECK_INTERVAL: Duration = Duration::from_millis(20);
/// Interval of the link checks.
const CARRIER_CHECK_INTERVAL: Duration = Duration::from_millis(100);

/// The line of `state`, exclusively for one trial; its clock starts at zero.
pub(super) fn of<'a>(mut state: MutexGuard<'a, BenchState>, place: &TrialEnvironment) -> Box<dyn Segment + 'a> {
    state.line.restart();
    let [(first, _), (second, _)] = place.controllers;
    let others = match &state.line {
        DeviceLine::Bus(_, fence) => fence.other_stations().to_vec(),
        DeviceLine::Wire(..) => Vec::new(),
    };
    let slot = place.line.pace.map(|pace| Duration::from_nanos(place.line.baud.nanoseconds(pace.slot_time)));
    Box::new(LiveSegment {
        state,
        broken: None,
        gone: false,
        discarded: Outbox::new(),
        checked_at: Time::ZERO,
        spoilt: None,
        device: place.mac.unwrap_or_default(),
        ours: [first, second],
        watch: BusWatch::new(slot.unwrap_or_default(), others),
    })
}

/// A real line with the harness's stations on it, for one trial.
struct LiveSegment<'a> {
    state: MutexGuard<'a, BenchState>,
    broken: Option<String>,
    gone: bool,
    discarded: Outbox,
    checked_at: Time,
    /// Why the evidence is invalid although the line is up.
    spoilt: Option<Disturbance>,
    /// The device, and the controllers that may exchange data with it, on PROFINET.
    device: Mac,
    ours: [Mac; 2],
    watch: BusWatch,
}

/// Whether a frame is cyclic data from the device to a controller outside the harness.
fn is_foreign_exchange(frame: &[u8], device: Mac, ours: &[Mac; 2]) -> bool {
    let (Some(to), Some(from)) = (frame.get(..6), frame.get(6..12)) else { return false };
    from == device.0 && !ours.iter().any(|own| own.0 == to) && is_cyclic(frame)
}

/// Notes in the journal what a frame of a drawn sequence changes for the first time, before it is sent; returns whether that is done.
fn are_noted(limits: Option<&mut FrameLimits>, journal: &mut Journal, changes: &mut Vec<String>) -> bool {
    let new = limits.map_or(&[][..], FrameLimits::take_new_changes);
    let what: Vec<String> = new.iter().map(|word| (*word).to_owned()).filter(|word| !changes.contains(word)).collect();
    if what.is_empty() {
        return true;
    }
    changes.extend(what.iter().cloned());
    journal.add(&JournalEntry::Changes { trial: "explore".to_owned(), what, stand: Vec::new() }).is_ok()
}

impl LiveSegment<'_> {
    /// Records conditions that invalidate the evidence although frames still pass: no cable, frames lost on the host.
    fn check_line(&mut self, now: Time) {
        self.checked_at = now + CARRIER_CHECK_INTERVAL;
        let BenchState { line, frames_lost, .. } = &mut *self.state;
        match line {
            DeviceLine::Wire(wire, _) => {
                let port = wire.port_mut();
                if !port.carrier() {
                    let what = format!("nothing is plugged in at the other end of {}", port.describe());
                    self.broken.get_or_insert(what);
                }
                let lost = port.lost();
                if lost > *frames_lost {
                    *frames_lost = lost;
                    let why = "this host was too slow and lost received frames";
                    self.spoilt.get_or_insert(Disturbance::of_harness(why));
                }
            }
            DeviceLine::Bus(bus, _) => {
                let garbled = bus.serial().echo_errors();
                if garbled > *frames_lost {
                    *frames_lost = garbled;
                    let why = "another station sent on the bus at the same time as the harness";
                    self.spoilt.get_or_insert(Disturbance::lasting(why));
                }
            }
        }
    }

    /// Runs without a line: the harness's stations wait without success, and their timers run.
    fn step_without_line(&mut self, ours: &mut HarnessStations, until: Time) -> bool {
        let now = self.state.line.now();
        let due = ours.deadline();
        let next = due.unwrap_or(until).min(until).min(now + LINE_CHECK_INTERVAL);
        self.gone = self.state.line.recover(next).is_err();
        let now = self.state.line.now();
        ours.with_each(|station| {
            if station.deadline().is_some_and(|due| due <= now) {
                station.wake(now, &mut self.discarded);
                self.discarded.clear();
            }
        });
        now < until
    }

    /// Runs the next event on a working line.
    fn step_on_line(
        &mut self,
        stations: &mut HarnessStations,
        until: Time,
        tap: FrameTap<'_>,
    ) -> Result<WireStep, LinkError> {
        let (device, ours, spoilt, watch) = (self.device, self.ours, &mut self.spoilt, &mut self.watch);
        let BenchState { line, journal, changes, .. } = &mut *self.state;
        match line {
            DeviceLine::Wire(wire, guard) => {
                let mac = |controller: &Controller| controller.settings().mac.0;
                let mut fence = |frame: &[u8]| {
                    guard.allows(frame) && are_noted(guard.limits_mut().as_deref_mut(), journal, changes)
                };
                let tap: FrameTap<'_> = &mut |time, frame| {
                    if spoilt.is_none() && is_foreign_exchange(frame, device, &ours) {
                        *spoilt = Some(Disturbance::lasting("another controller exchanges data with the device"));
                    }
                    tap(time, frame);
                };
                match stations.controllers_mut() {
                    [first] => wire.step(&mut [(mac(first), first)], until, &mut fence, tap),
                    [first, second] => {
                        wire.step(&mut [(mac(first), first), (mac(second), second)], until, &mut fence, tap)
                    }
                    _ => wire.step(&mut [], until, &mut fence, tap),
                }
            }
            DeviceLine::Bus(bus, fence) => {
                let mut fence = |octets: &[u8]| {
                    fence.allows(octets) && are_noted(fence.limits_mut().as_deref_mut(), journal, changes)
                };
                let mut tap = |heard: BusTransmission<'_>| {
                    let (begin, objection) = watch.observe(&heard);
                    if spoilt.is_none() {
                        *spoilt = objection;
                    }
                    tap(begin, heard.octets);
                };
                match stations.masters_mut() {
                    [first] => bus.step(&mut [first], until, &mut fence, &mut tap),
                    [first, second] => bus.step(&mut [first, second], until, &mut fence, &mut tap),
                    _ => bus.step(&mut [], until, &mut fence, &mut tap),
                }
            }
        }
    }
}

impl Segment for LiveSegment<'_> {
    fn now(&self) -> Time {
        self.state.line.now()
    }

    fn step(&mut self, stations: &mut HarnessStations, until: Time, tap: FrameTap<'_>) -> bool {
        if self.gone {
            return self.step_without_line(stations, until);
        }
        match self.step_on_line(stations, until, tap) {
            Ok(step) => {
                let now = self.state.line.now();
                if now >= self.checked_at {
                    self.check_line(now);
                }
                step == WireStep::Worked
            }
            Err(error) => {
                self.gone = true;
                self.broken.get_or_insert(error.to_string());
                true
            }
        }
    }

    fn stand(&mut self) -> &mut dyn Stand {
        &mut self.state.stand
    }

    fn is_model(&self) -> bool {
        false
    }

    fn objections(&self) -> Vec<String> {
        let refused = self.state.stand.refused_by_limits().map(str::to_owned);
        self.state.line.withheld_frames().summary().into_iter().chain(refused).collect()
    }

    fn withheld(&self) -> Option<String> {
        self.state.line.withheld_frames().withheld().map(|what| format!("the guard of the bench withheld {what}"))
    }

    fn broken_line(&self) -> Option<String> {
        self.broken.clone()
    }

    fn invalidated(&self) -> Option<Disturbance> {
        self.spoilt.clone()
    }

    fn check_line(&mut self) {
        let now = self.state.line.now();
        self.check_line(now);
    }

    fn is_interrupted(&self) -> bool {
        link::interrupt::requested()
    }

    fn lateness(&self) -> Duration {
        self.state.line.lateness().longest()
    }

    fn shortage(&self) -> Option<Duration> {
        self.state.line.shortage()
    }

    fn lacks_answer(&self) -> bool {
        self.watch.lacks_answer()
    }

    fn latest_answer(&self) -> Duration {
        self.watch.latest()
    }
}

impl Drop for LiveSegment<'_> {
    fn drop(&mut self) {
        self.state.line.forget_withheld();
        self.state.stand.forget_refused();
    }
}
