//! How fast the shaft turned: the mean of the last measurements, of which each is the way of one interval.

use super::{Direction, Hardware, Scaling, Shaft};
use alloc::collections::VecDeque;
use core::time::Duration;
use device_stack::Attached;
use station::Time;

/// In what a velocity is expressed; the number is the one of the encoder profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Units per second.
    PerSecond = 0,
    /// Units per 100 ms.
    Per100Milliseconds = 1,
    /// Units per 10 ms.
    Per10Milliseconds = 2,
    /// Revolutions per minute.
    Rpm = 3,
    /// Revolutions per second; the profile does not number it, some makers say 4.
    RevolutionsPerSecond = 4,
}

/// When velocity is measured, and over how many measurements it is the mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// From measurement to measurement; with each there is a new velocity.
    pub every: Duration,
    /// How many measurements make a velocity, at least 1.
    pub of: u32,
}

impl Sampling {
    /// One measurement in each `window`.
    pub const fn once(window: Duration) -> Sampling {
        Sampling { every: window, of: 1 }
    }
}

/// What a velocity is computed from: a way and how long it took.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredWay {
    /// Hardware steps, clockwise positive.
    pub steps: i64,
    /// In how many nanoseconds they were made.
    pub nanos: i128,
    /// The unit of the velocity.
    pub unit: Unit,
    /// What the sensor can tell apart.
    pub hardware: Hardware,
    /// The scaling in force.
    pub scaling: Scaling,
    /// In which direction positions rise.
    pub direction: Direction,
}

impl MeasuredWay {
    /// The velocity, rounded to the nearest, positive while the position rises.
    pub fn velocity(&self) -> i64 {
        let units_per_revolution = self.scaling.units_per_revolution;
        let (per_revolution, time) = match self.unit {
            Unit::PerSecond => (units_per_revolution, 1_000_000_000),
            Unit::Per100Milliseconds => (units_per_revolution, 100_000_000),
            Unit::Per10Milliseconds => (units_per_revolution, 10_000_000),
            Unit::Rpm => (1, 60_000_000_000),
            Unit::RevolutionsPerSecond => (1, 1_000_000_000),
        };
        let rising = match self.direction {
            Direction::Clockwise => self.steps,
            Direction::Counterclockwise => -self.steps,
        };
        let above = i128::from(rising) * i128::from(per_revolution) * time;
        rounded(above, (i128::from(self.hardware.steps_per_revolution) * self.nanos).max(1))
    }
}

/// The steps of the velocity at which a deviation may take another result; each default changes nothing.
#[allow(unused_variables, reason = "the names say what a step is given")]
pub trait VelocitySteps {
    /// When velocity is measured.
    fn sampling(&mut self, unit: Unit, sampling: Sampling) -> Sampling {
        sampling
    }

    /// The velocity of a measured way.
    fn velocity(&mut self, way: &MeasuredWay, velocity: i64) -> i64 {
        velocity
    }
}

/// The velocity, measured anew at the end of each interval.
///
/// It needs no deadline: asked at any time, it gives what was measured at the end of the last whole interval. Whoever
/// changes the motion of the shaft or the unit calls [`advance`](Velocity::advance) before and so keeps the past.
#[derive(Clone, Debug)]
pub struct Velocity {
    unit: Unit,
    hardware: Hardware,
    sampling: Sampling,
    /// How it is measured: `sampling` within its limits.
    in_force: Sampling,
    last: Time,
    /// When the present interval ends.
    due: Time,
    /// The places at the ends of the intervals of the last two means, the oldest one first.
    places: VecDeque<i64>,
    steps: i64,
    /// The steps as revolutions per minute.
    rpm: i64,
    deviations: Attached<dyn VelocitySteps>,
}

impl Velocity {
    /// Begins to measure at `now`, in windows of `window`.
    pub fn new(
        window: Duration,
        unit: Unit,
        hardware: Hardware,
        now: Time,
        shaft: &Shaft,
        deviations: Attached<dyn VelocitySteps>,
    ) -> Velocity {
        Velocity::sampled(Sampling::once(window), unit, hardware, now, shaft, deviations)
    }

    /// Begins to measure at `now`, as `sampling` says.
    pub fn sampled(
        sampling: Sampling,
        unit: Unit,
        hardware: Hardware,
        now: Time,
        shaft: &Shaft,
        deviations: Attached<dyn VelocitySteps>,
    ) -> Velocity {
        let places = VecDeque::from([shaft.place(now)]);
        let (in_force, last, due, steps, rpm) = (sampling, now, now, 0, 0);
        let mut velocity = Velocity { unit, hardware, sampling, in_force, last, due, places, steps, rpm, deviations };
        velocity.settle();
        velocity
    }

    /// The unit in force.
    pub fn unit(&self) -> Unit {
        self.unit
    }

    /// Gives velocities in `unit` from now on.
    pub fn set_unit(&mut self, unit: Unit) {
        self.unit = unit;
        self.settle();
    }

    /// Works out what only sampling and unit, and the end of the last interval, change.
    fn settle(&mut self) {
        let (unit, sampling) = (self.unit, self.sampling);
        let Sampling { every, of } = self.deviations.apply(sampling, |steps, sampling| steps.sampling(unit, sampling));
        let every = every.max(Duration::from_nanos(1));
        self.in_force = Sampling { every, of: of.max(1) };
        self.due = self.last + every;
        self.take(self.steps);
    }

    /// Measures as `sampling` says from `now` on; what was measured before is forgotten if it is another sampling.
    pub fn sample(&mut self, sampling: Sampling, now: Time, shaft: &Shaft) {
        if sampling != self.sampling {
            self.sampling = sampling;
            self.settle();
            self.restart(now, shaft);
        }
    }

    /// Measures all intervals that have ended by `now`.
    #[inline]
    pub fn advance(&mut self, now: Time, shaft: &Shaft) {
        if now >= self.due {
            self.measure(now, shaft);
        }
    }

    fn measure(&mut self, now: Time, shaft: &Shaft) {
        let Sampling { every, of } = self.in_force;
        if now.since(self.last) < every {
            return;
        }
        // An interval that is longer than all time has not ended.
        let nanos = u64::try_from(every.as_nanos()).unwrap_or(u64::MAX);
        let ended = (now.as_nanos() - self.last.as_nanos()) / nanos;
        let Ok(ended) = u32::try_from(ended) else { return self.restart(now, shaft) };
        // What is older than the last two means counts for neither.
        let passed_over = ended.saturating_sub(of.saturating_mul(2).saturating_add(1));
        self.last += every * passed_over;
        for _ in passed_over..ended {
            self.last += every;
            self.note(shaft.place(self.last), of);
        }
        self.take(self.ways().1);
        self.due = self.last + every;
    }

    /// Takes the steps of the last measurements.
    fn take(&mut self, steps: i64) {
        self.steps = steps;
        let way = self.way(steps, Unit::Rpm, Scaling::hardware(&self.hardware), Direction::Clockwise);
        self.rpm = self.velocity(&way);
    }

    /// Notes a place at the end of an interval; before the first one the shaft stood where it was first seen.
    fn note(&mut self, place: i64, of: u32) {
        let oldest = self.places.front().copied().unwrap_or(place);
        self.places.push_back(place);
        let wanted = of as usize * 2 + 1;
        while self.places.len() > wanted {
            self.places.pop_front();
        }
        while self.places.len() < wanted {
            self.places.push_front(oldest);
        }
    }

    /// The ways of the last two means, the older one first.
    pub fn ways(&self) -> (i64, i64) {
        let middle = self.places.get(self.places.len() / 2);
        match (self.places.front(), middle, self.places.back()) {
            (Some(first), Some(middle), Some(last)) => (middle.saturating_sub(*first), last.saturating_sub(*middle)),
            _ => (0, 0),
        }
    }

    /// Forgets what was measured, as if the shaft had always stood where it is.
    pub fn restart(&mut self, now: Time, shaft: &Shaft) {
        self.places.clear();
        self.places.push_back(shaft.place(now));
        (self.last, self.due) = (now, now + self.in_force.every);
        self.take(0);
    }

    /// Hardware steps in the last measurements that make a velocity, clockwise positive.
    #[inline]
    pub fn steps(&self) -> i64 {
        self.steps
    }

    /// The velocity in the unit in force, rounded to the nearest, positive while the position rises.
    pub fn value(&self, scaling: &Scaling, direction: Direction) -> i64 {
        self.velocity(&self.way(self.steps, self.unit, *scaling, direction))
    }

    /// What a velocity is computed from that has these hardware steps.
    pub fn way(&self, steps: i64, unit: Unit, scaling: Scaling, direction: Direction) -> MeasuredWay {
        MeasuredWay { steps, nanos: self.measured_nanos(), unit, hardware: self.hardware, scaling, direction }
    }

    fn velocity(&self, way: &MeasuredWay) -> i64 {
        self.deviations.apply(way.velocity(), |deviations, velocity| deviations.velocity(way, velocity))
    }

    /// Revolutions per minute, clockwise positive, rounded to the nearest, whatever the unit in force.
    #[inline]
    pub fn rounded_rpm(&self) -> i64 {
        self.rpm
    }

    /// Revolutions per minute and second, clockwise positive, rounded to the nearest: how much the velocity differs from
    /// that of the measurements before, which are not the same ones.
    pub fn acceleration(&self) -> i64 {
        let (before, now) = self.ways();
        if before == now {
            return 0;
        }
        let (nanos, steps_per_revolution) = (self.measured_nanos(), i128::from(self.hardware.steps_per_revolution));
        let seconds_squared = nanos.saturating_mul(nanos) / 1_000_000_000;
        let steps = i128::from(now.saturating_sub(before));
        rounded(steps * 60_000_000_000, (steps_per_revolution * seconds_squared).max(1))
    }

    fn measured_nanos(&self) -> i128 {
        let Sampling { every, of } = self.in_force;
        every.as_nanos() as i128 * i128::from(of)
    }
}

/// The nearest whole number to a fraction with a positive denominator; halves go away from zero.
fn rounded(above: i128, below: i128) -> i64 {
    if above == 0 {
        return 0;
    }
    // Nearly always both are short, and dividing long numbers is slow.
    if let (Ok(above), Ok(below)) = (i64::try_from(above), i64::try_from(below))
        && let Some(above) = above.checked_add(above.signum() * (below / 2))
    {
        return above / below;
    }
    i64::try_from((above + above.signum() * below / 2) / below).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests;
