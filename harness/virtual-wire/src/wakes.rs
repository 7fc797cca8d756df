//! The next station to wake, and the recorded violations: shared by all virtual wires.

use station::{Station, Time};

use crate::violation::Violation;

/// Number of wake-ups of a station allowed at one instant.
const WAKES_AT_ONE_INSTANT: u32 = 1_000;
/// Number of violations stored; later ones are only counted.
const VIOLATIONS_KEPT: usize = 1_000;

/// Number of wake-ups of each port at the current instant.
#[derive(Debug, Default)]
pub(crate) struct Wakes {
    ports: Vec<Port>,
}

#[derive(Clone, Debug, Default)]
struct Port {
    at: Time,
    count: u32,
    livelocked: bool,
}

impl Port {
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
            self.ports.resize(stations.len(), Port::default());
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
    pub fn woken(&mut self, now: Time, port: usize) -> Option<Violation> {
        let state = self.ports.get_mut(port)?;
        state.count = if state.at == now { state.count + 1 } else { 1 };
        state.at = now;
        let is_new = state.count >= WAKES_AT_ONE_INSTANT && !state.livelocked;
        state.livelocked |= is_new;
        is_new.then_some(Violation::Livelock { port, time: now })
    }
}

/// The violations on a wire.
#[derive(Debug, Default)]
pub(crate) struct Objections {
    kept: Vec<Violation>,
    seen: u64,
}

impl Objections {
    /// The stored violations, in order.
    pub fn kept(&self) -> &[Violation] {
        &self.kept
    }

    /// The number of violations.
    pub fn seen(&self) -> u64 {
        self.seen
    }

    /// Records a violation and returns it.
    pub fn raise(&mut self, violation: Violation) -> Violation {
        self.seen += 1;
        if self.kept.len() < VIOLATIONS_KEPT {
            self.kept.push(violation);
        }
        violation
    }
}
