//! The clock of isochronous mode: Global_Control once a cycle, which may come at another time or not at all.
//!
//! It notices what a master did to its clock; it must not know what a slave makes of it.

use super::Listener;
use station::{Duration, Time};
use wire::profibus::prm::{Dpv1Status3, Isochronous, PrmBlock, PrmBlockType, SetPrm};

/// Twelfths of a microsecond, in which the block of isochronous mode has its times, in a nanosecond: 3 in 250.
const TWELFTHS: (u64, u64) = (250, 3);
/// By less than this a clock that was recorded does not deviate; the window of a slave is a microsecond to either side.
const JITTER: Duration = Duration::from_micros(2);

/// The clock of the connection that stands.
#[derive(Debug)]
pub(super) struct Clock {
    cycle: Duration,
    /// Since when the connection stands.
    begin: Time,
    /// When it came last; none before the first time.
    last: Option<Time>,
}

impl Clock {
    /// It runs since the connection stands.
    pub fn new(cycle: Duration, begin: Time) -> Clock {
        Clock { cycle, begin, last: None }
    }

    /// Up to when it has to come; the first time it may be anywhere in its cycle.
    fn due(&self) -> Time {
        self.last.map_or(self.begin + self.cycle * 2, |last| last + self.cycle)
    }
}

/// The block of isochronous mode in the parameters of a slave, and the cycle that it tells.
pub(super) fn isochronous(prm: &SetPrm) -> Option<(Isochronous, Duration)> {
    let status = prm.dpv1()?.status_3;
    if !(status.has(Dpv1Status3::ISOCHRONOUS) && status.has(Dpv1Status3::PRM_STRUCTURE)) {
        return None;
    }
    let blocks = PrmBlock::parse_all(prm.behind_dpv1()).ok()?;
    let block = blocks.iter().find(|block| block.kind == PrmBlockType::ISOCHRONOUS)?;
    let times = Isochronous::parse(&block.data).ok()?;
    let (over, under) = TWELFTHS;
    let nanos = u64::from(times.t_base_dp) * u64::from(times.t_dp) * over / under;
    Some((times, Duration::from_nanos(nanos)))
}

impl Listener<'_> {
    /// The clock of the bus came.
    pub(super) fn clock_came(&mut self) {
        let now = self.now.0;
        let Some(clock) = &mut self.start_up.clock else { return };
        let Some(last) = clock.last.replace(now) else { return };
        if now.since(last) + JITTER < clock.cycle || now.since(last) > clock.cycle + JITTER {
            self.out_of_step(now, "the clock of isochronous mode came at another time");
        }
    }

    /// Time goes by.
    pub(super) fn clock_is_missed(&mut self) {
        let due = self.start_up.clock.as_ref().map(Clock::due);
        if let Some(due) = due.filter(|due| self.now.0 > *due + JITTER) {
            self.out_of_step(due, "the clock of isochronous mode did not come");
        }
    }

    /// What a slave makes of it depends on the very cycle, to which our steps are not done again.
    pub(super) fn out_of_step(&mut self, since: Time, what: &str) {
        if self.start_up.clock.take().is_some() {
            self.left_open(since, what);
        }
    }
}
