//! The clock of isochronous mode: Global_Control once a cycle, which may be early, late or missing.
//!
//! This module detects what a master does with its clock; it must not know how a slave reacts.

use super::ConversationState;
use station::{Duration, Time};
use wire::profibus::prm::{Dpv1Status3, Isochronous, PrmBlock, PrmBlockType, SetPrm};

/// Converts the times of the isochronous block, in twelfths of a microsecond, to nanoseconds: times 250 / 3.
const TWELFTHS: (u64, u64) = (250, 3);
/// Smaller deviations of a recorded clock are ignored; the window of a slave is one microsecond to either side.
const JITTER: Duration = Duration::from_micros(2);

/// The clock of the present connection.
#[derive(Debug)]
pub(super) struct IsochronousClock {
    cycle: Duration,
    /// The begin of the connection.
    begin: Time,
    /// The time of the last clock; `None` before the first.
    last: Option<Time>,
}

impl IsochronousClock {
    /// A clock that begins with the connection.
    pub fn new(cycle: Duration, begin: Time) -> IsochronousClock {
        IsochronousClock { cycle, begin, last: None }
    }

    /// The latest time of the next clock; the first one may be anywhere in its cycle.
    fn due(&self) -> Time {
        self.last.map_or(self.begin + self.cycle * 2, |last| last + self.cycle)
    }
}

/// The isochronous block in the parameters of a slave, and its cycle time.
pub(super) fn isochronous(prm: &SetPrm) -> Option<(Isochronous, Duration)> {
    let status = prm.dpv1()?.status_3;
    if !(status.has(Dpv1Status3::ISOCHRONOUS) && status.has(Dpv1Status3::PRM_STRUCTURE)) {
        return None;
    }
    let blocks = PrmBlock::parse_all(prm.user_after_dpv1()).ok()?;
    let block = blocks.iter().find(|block| block.kind == PrmBlockType::ISOCHRONOUS)?;
    let times = Isochronous::parse(&block.data).ok()?;
    let (over, under) = TWELFTHS;
    let nanos = u64::from(times.t_base_dp) * u64::from(times.t_dp) * over / under;
    Some((times, Duration::from_nanos(nanos)))
}

impl ConversationState<'_> {
    /// Takes in a clock of the bus.
    pub(super) fn clock_came(&mut self) {
        let now = self.now.0;
        let Some(clock) = &mut self.start_up.clock else { return };
        let Some(last) = clock.last.replace(now) else { return };
        if now.since(last) + JITTER < clock.cycle || now.since(last) > clock.cycle + JITTER {
            self.out_of_step(now, "the clock of isochronous mode was early or late");
        }
    }

    /// Advances the time.
    pub(super) fn clock_is_missed(&mut self) {
        let due = self.start_up.clock.as_ref().map(IsochronousClock::due);
        if let Some(due) = due.filter(|due| self.now.0 > *due + JITTER) {
            self.out_of_step(due, "the clock of isochronous mode was missing");
        }
    }

    /// The reaction of a slave depends on the exact cycle, and repeated steps are not exact to a cycle.
    pub(super) fn out_of_step(&mut self, since: Time, what: &str) {
        if self.start_up.clock.take().is_some() {
            self.left_open(since, what);
        }
    }
}
