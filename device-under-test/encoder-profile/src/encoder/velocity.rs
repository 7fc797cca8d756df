//! The velocity of the shaft: the mean of the last measurements. Each measurement is the number of steps in one
//! interval.

use super::{CountingDirection, Hardware, Scaling, Shaft};
use alloc::collections::VecDeque;
use core::time::Duration;
use device_stack::Attached;
use station::Time;

/// The unit of a velocity. The numbers are those of the encoder profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VelocityUnit {
    /// Units per second.
    PerSecond = 0,
    /// Units per 100 ms.
    Per100Milliseconds = 1,
    /// Units per 10 ms.
    Per10Milliseconds = 2,
    /// Revolutions per minute.
    Rpm = 3,
    /// Revolutions per second. The profile has no number for it; some manufacturers use 4.
    RevolutionsPerSecond = 4,
}

/// The interval of measurements, and how many of them the mean covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// The interval. Each measurement results in a new velocity.
    pub interval: Duration,
    /// The number of measurements in a mean, at least 1.
    pub count: u32,
}

impl Sampling {
    /// One measurement per `window`, without a mean.
    pub const fn once(window: Duration) -> Sampling {
        Sampling { interval: window, count: 1 }
    }
}

/// The input of a velocity: steps and the time for them.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredWay {
    /// Hardware steps, clockwise positive.
    pub steps: i64,
    /// The time for the steps in nanoseconds.
    pub nanos: i128,
    pub unit: VelocityUnit,
    pub hardware: Hardware,
    pub scaling: Scaling,
    pub direction: CountingDirection,
}

impl MeasuredWay {
    /// The velocity, rounded to the nearest integer, positive while the position increases.
    pub fn velocity(&self) -> i64 {
        let (above, below) = self.fraction();
        rounded(above, below)
    }

    /// The velocity as a fraction with a positive denominator, positive while the position increases.
    pub fn fraction(&self) -> (i128, i128) {
        let units_per_revolution = self.scaling.units_per_revolution;
        let (per_revolution, time) = match self.unit {
            VelocityUnit::PerSecond => (units_per_revolution, 1_000_000_000),
            VelocityUnit::Per100Milliseconds => (units_per_revolution, 100_000_000),
            VelocityUnit::Per10Milliseconds => (units_per_revolution, 10_000_000),
            VelocityUnit::Rpm => (1, 60_000_000_000),
            VelocityUnit::RevolutionsPerSecond => (1, 1_000_000_000),
        };
        let rising = match self.direction {
            CountingDirection::Clockwise => self.steps,
            CountingDirection::Counterclockwise => -self.steps,
        };
        let above = i128::from(rising) * i128::from(per_revolution) * time;
        (above, (i128::from(self.hardware.steps_per_revolution) * self.nanos).max(1))
    }
}

/// The steps of the velocity whose result a deviation may change. Each default changes nothing.
#[allow(unused_variables, reason = "the names document the step")]
pub trait VelocitySteps {
    /// The sampling in force.
    fn sampling(&mut self, unit: VelocityUnit, sampling: Sampling) -> Sampling {
        sampling
    }

    /// The computed velocity.
    fn velocity(&mut self, way: &MeasuredWay, velocity: i64) -> i64 {
        velocity
    }
}

/// The velocity, measured at the end of each interval.
///
/// It needs no deadline: at any time it returns the result of the last complete interval. Before a change of the
/// motion of the shaft or of the unit, call [`advance`](Velocity::advance), so that the measurements up to now are
/// complete.
#[derive(Clone, Debug)]
pub struct Velocity {
    unit: VelocityUnit,
    hardware: Hardware,
    sampling: Sampling,
    /// `sampling` after the hooks and within its limits.
    in_force: Sampling,
    last: Time,
    /// When the current interval ends.
    due: Time,
    /// The shaft positions at the ends of the intervals of the last two means, the oldest one first.
    places: VecDeque<i64>,
    steps: i64,
    /// The steps as revolutions per minute.
    rpm: i64,
    deviations: Attached<dyn VelocitySteps>,
}

impl Velocity {
    /// Starts to measure at `now`, one measurement per `window`.
    pub fn new(
        window: Duration,
        unit: VelocityUnit,
        hardware: Hardware,
        now: Time,
        shaft: &Shaft,
        deviations: Attached<dyn VelocitySteps>,
    ) -> Velocity {
        Velocity::sampled(Sampling::once(window), unit, hardware, now, shaft, deviations)
    }

    /// Starts to measure at `now` with `sampling`.
    pub fn sampled(
        sampling: Sampling,
        unit: VelocityUnit,
        hardware: Hardware,
        now: Time,
        shaft: &Shaft,
        deviations: Attached<dyn VelocitySteps>,
    ) -> Velocity {
        let places = VecDeque::from([shaft.position(now)]);
        let (in_force, last, due, steps, rpm) = (sampling, now, now, 0, 0);
        let mut velocity = Velocity { unit, hardware, sampling, in_force, last, due, places, steps, rpm, deviations };
        velocity.settle();
        velocity
    }

    /// The unit in force.
    pub fn unit(&self) -> VelocityUnit {
        self.unit
    }

    /// Sets the unit of the velocity.
    pub fn set_unit(&mut self, unit: VelocityUnit) {
        self.unit = unit;
        self.settle();
    }

    /// Recomputes the values that depend only on sampling, unit and the end of the last interval.
    fn settle(&mut self) {
        let (unit, sampling) = (self.unit, self.sampling);
        let Sampling { interval: every, count: of } =
            self.deviations.apply(sampling, |steps, sampling| steps.sampling(unit, sampling));
        let every = every.max(Duration::from_nanos(1));
        self.in_force = Sampling { interval: every, count: of.max(1) };
        self.due = self.last + every;
        self.set_steps(self.steps);
    }

    /// Changes the sampling from `now` on. If it differs, previous measurements are dropped.
    pub fn sample(&mut self, sampling: Sampling, now: Time, shaft: &Shaft) {
        if sampling != self.sampling {
            self.sampling = sampling;
            self.settle();
            self.restart(now, shaft);
        }
    }

    /// Processes all intervals that have ended by `now`.
    #[inline]
    pub fn advance(&mut self, now: Time, shaft: &Shaft) {
        if now >= self.due {
            self.measure(now, shaft);
        }
    }

    fn measure(&mut self, now: Time, shaft: &Shaft) {
        let Sampling { interval: every, count: of } = self.in_force;
        if now.since(self.last) < every {
            return;
        }
        // An interval beyond the range of time does not end.
        let nanos = u64::try_from(every.as_nanos()).unwrap_or(u64::MAX);
        let ended = (now.as_nanos() - self.last.as_nanos()) / nanos;
        let Ok(ended) = u32::try_from(ended) else { return self.restart(now, shaft) };
        // Measurements older than the last two means are not needed.
        let passed_over = ended.saturating_sub(of.saturating_mul(2).saturating_add(1));
        self.last += every * passed_over;
        for _ in passed_over..ended {
            self.last += every;
            self.push_position(shaft.position(self.last), of);
        }
        self.set_steps(self.mean_steps().1);
        self.due = self.last + every;
    }

    /// Sets the steps of the last mean and the velocity in rpm.
    fn set_steps(&mut self, steps: i64) {
        self.steps = steps;
        let way = self.way(steps, VelocityUnit::Rpm, Scaling::hardware(&self.hardware), CountingDirection::Clockwise);
        self.rpm = self.velocity(&way);
    }

    /// Stores the shaft position at the end of an interval. Before the first one the shaft counts as standing still.
    fn push_position(&mut self, place: i64, of: u32) {
        let oldest = self.places.front().copied().unwrap_or(place);
        self.places.push_back(place);
        let count = of as usize * 2 + 1;
        while self.places.len() > count {
            self.places.pop_front();
        }
        while self.places.len() < count {
            self.places.push_front(oldest);
        }
    }

    /// The steps of the last two means, the older one first.
    pub fn mean_steps(&self) -> (i64, i64) {
        let middle = self.places.get(self.places.len() / 2);
        match (self.places.front(), middle, self.places.back()) {
            (Some(first), Some(middle), Some(last)) => (middle.saturating_sub(*first), last.saturating_sub(*middle)),
            _ => (0, 0),
        }
    }

    /// Drops all measurements, as if the shaft had always stood still.
    pub fn restart(&mut self, now: Time, shaft: &Shaft) {
        self.places.clear();
        self.places.push_back(shaft.position(now));
        (self.last, self.due) = (now, now + self.in_force.interval);
        self.set_steps(0);
    }

    /// Hardware steps in the measurements of the last mean, clockwise positive.
    #[inline]
    pub fn steps(&self) -> i64 {
        self.steps
    }

    /// The velocity in the unit in force, rounded to the nearest integer, positive while the position increases.
    pub fn value(&self, scaling: &Scaling, direction: CountingDirection) -> i64 {
        self.velocity(&self.way(self.steps, self.unit, *scaling, direction))
    }

    /// The input of the velocity for a number of hardware steps.
    pub fn way(&self, steps: i64, unit: VelocityUnit, scaling: Scaling, direction: CountingDirection) -> MeasuredWay {
        MeasuredWay { steps, nanos: self.measured_nanos(), unit, hardware: self.hardware, scaling, direction }
    }

    fn velocity(&self, way: &MeasuredWay) -> i64 {
        self.deviations.apply(way.velocity(), |deviations, velocity| deviations.velocity(way, velocity))
    }

    /// Revolutions per minute, clockwise positive, rounded to the nearest integer, independent of the unit in force.
    #[inline]
    pub fn rounded_rpm(&self) -> i64 {
        self.rpm
    }

    /// Revolutions per minute and second, clockwise positive, rounded to the nearest integer: the difference between
    /// the last two means.
    pub fn acceleration(&self) -> i64 {
        let (before, now) = self.mean_steps();
        if before == now {
            return 0;
        }
        let (nanos, steps_per_revolution) = (self.measured_nanos(), i128::from(self.hardware.steps_per_revolution));
        let seconds_squared = nanos.saturating_mul(nanos) / 1_000_000_000;
        let steps = i128::from(now.saturating_sub(before));
        rounded(steps * 60_000_000_000, (steps_per_revolution * seconds_squared).max(1))
    }

    fn measured_nanos(&self) -> i128 {
        let Sampling { interval: every, count: of } = self.in_force;
        every.as_nanos() as i128 * i128::from(of)
    }
}

/// The nearest integer to a fraction with a positive denominator. Halves round away from zero.
fn rounded(above: i128, below: i128) -> i64 {
    if above == 0 {
        return 0;
    }
    // Nearly always both are small, and a division of 128 bits is slow.
    if let (Ok(above), Ok(below)) = (i64::try_from(above), i64::try_from(below))
        && let Some(above) = above.checked_add(above.signum() * (below / 2))
    {
        return above / below;
    }
    i64::try_from((above + above.signum() * below / 2) / below).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests;
