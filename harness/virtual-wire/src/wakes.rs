//! The next station to wake, and the recorded violations: shared by all virtual wires.

use station::{Station, Time};

use crate::violation::WireViolation;

/// Number of wake-ups of a station allowed at one instant.
const WAKES_AT_ONE_INSTANT: u32 = 1_000;
/// Number of violations stored; later ones are only counted.
const VIOLATIONS_KEPT: usize = 1_000;

/// Number of wake-ups of each port at the current instant.
#[derive(Debug, Default)]
pub(crate) struct Wakes {
    ports: Vec<PortWakes>,
}

#[derive(Clone, Debug, Default)]
struct PortWakes {
    at: Time,
    count: u32,
    livelocked: bool,
}

impl PortWakes {
    /// Whether the station was woken so often at the instant `due` that it would never stop.
    #[inline]
    fn is_spinning(&self, due: Time) -> bool {
        self.count >= WAKES_AT_ONE_INSTANT && self.at == due
    }
}

impl Wakes {
    /// The next wake-up and its port; of several at one instant, the lowest port.
    #[inline]
    pub fn earliest(&mut self, now: Time, stations: &[&mut dyn Station]) -> Option<(Time, usize)> {
        if self.ports.len() < stations.len() {
            self.ports.resize(stations.len(), PortWakes::default());
        }
        let mut first: Option<(Time, usize)> = None;
        for (index, (station, port)) in stations.iter().zip(&self.ports).enumerate() {
            let Some(due) = station.deadline() else { continue };
            let due = due.max(now);
            if first.is_none_or(|(earliest, _)| due < earliest) && !port.is_spinning(due) {
                first = Some((due, index));
            }
        }
        first
    }

    /// Counts a wake-up of `port`; returns the violation, once, if the station never stops.
    #[inline]
    pub fn woken(&mut self, now: Time, port: usize) -> Option<WireViolation> {
        let state = self.ports.get_mut(port)?;
        state.count = if state.at == now { state.count + 1 } else { 1 };
        state.at = now;
        let is_new = state.count >= WAKES_AT_ONE_INSTANT && !state.livelocked;
        state.livelocked |= is_new;
        is_new.then_some(WireViolation::Livelock { port, time: now })
    }
}

/// The violations on a wire.
#[derive(Debug, Default)]
pub(crate) struct ViolationLog {
    stored: Vec<WireViolation>,
    count: u64,
}

impl ViolationLog {
    /// The stored violations, in order.
    pub fn stored(&self) -> &[WireViolation] {
        &self.stored
    }

    /// The number of violations.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Records a violation and returns it.
    pub fn raise(&mut self, violation: WireViolation) -> WireViolation {
        self.count += 1;
        if self.stored.len() < VIOLATIONS_KEPT {
            self.stored.push(violation);
        }
        violation
    }
}
