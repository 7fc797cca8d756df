//! How fast the shaft turned: the mean of the last measurements, of which each is the way of one interval.

use super::{Direction, Hardware, Scaling, Shaft};
use alloc::collections::VecDeque;
use core::time::Duration;
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

/// Hardware steps of two windows of measurement, clockwise positive.
#[derive(Clone, Copy, Debug)]
pub struct Steps {
    /// Those of the window before.
    pub before: i64,
    /// Those of the window that has ended.
    pub now: i64,
    /// Those of a revolution.
    pub of_a_revolution: u64,
}

/// What makes a velocity of hardware steps: `above / below` units for each hardware step in a nanosecond.
#[derive(Clone, Copy, Debug)]
pub struct Factor {
    /// Numerator.
    pub above: i128,
    /// Denominator.
    pub below: i128,
}

/// Where bugs can be put into the velocity.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// How long it is from measurement to measurement, from how long it should be and the unit in force.
    pub window: fn(Duration, Unit) -> Duration,
    /// When velocity is measured, from when it should be.
    pub sampling: fn(Sampling) -> Sampling,
    /// The steps that count.
    pub steps: fn(Steps) -> i64,
    /// What makes a velocity of steps.
    pub factor: fn(Unit, &Hardware, &Scaling) -> Factor,
    /// The sign of a velocity clockwise.
    pub sign: fn(Direction) -> i64,
}

impl Default for Rules {
    fn default() -> Rules {
        Rules { window: |window, _| window, sampling: |sampling| sampling, steps: |steps| steps.now, factor, sign }
    }
}

/// Units per revolution over steps per revolution, and nanoseconds of the time of the unit.
pub fn factor(unit: Unit, hardware: &Hardware, scaling: &Scaling) -> Factor {
    let (per_revolution, time) = match unit {
        Unit::PerSecond => (scaling.units_per_revolution, 1_000_000_000),
        Unit::Per100Milliseconds => (scaling.units_per_revolution, 100_000_000),
        Unit::Per10Milliseconds => (scaling.units_per_revolution, 10_000_000),
        Unit::Rpm => (1, 60_000_000_000),
        Unit::RevolutionsPerSecond => (1, 1_000_000_000),
    };
    Factor { above: i128::from(per_revolution) * time, below: hardware.steps_per_revolution.into() }
}

fn sign(direction: Direction) -> i64 {
    match direction {
        Direction::Clockwise => 1,
        Direction::Counterclockwise => -1,
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
    /// How it is measured: what the rules make of `sampling` and `unit`.
    in_force: Sampling,
    last: Time,
    /// When the present interval ends.
    due: Time,
    /// The places at the ends of the intervals of the last two means, the oldest one first.
    places: VecDeque<i64>,
    steps: i64,
    /// The steps as revolutions per minute.
    rpm: i64,
    rules: Rules,
}

impl Velocity {
    /// Begins to measure at `now`, in windows of `window`.
    pub fn new(window: Duration, unit: Unit, hardware: Hardware, now: Time, shaft: &Shaft, rules: Rules) -> Velocity {
        Velocity::sampled(Sampling::once(window), unit, hardware, now, shaft, rules)
    }

    /// Begins to measure at `now`, as `sampling` says.
    pub fn sampled(
        sampling: Sampling,
        unit: Unit,
        hardware: Hardware,
        now: Time,
        shaft: &Shaft,
        rules: Rules,
    ) -> Velocity {
        let places = VecDeque::from([shaft.place(now)]);
        let (in_force, last, due, steps, rpm) = (sampling, now, now, 0, 0);
        let mut velocity = Velocity { unit, hardware, sampling, in_force, last, due, places, steps, rpm, rules };
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
        let Sampling { every, of } = (self.rules.sampling)(self.sampling);
        let every = (self.rules.window)(every, self.unit).max(Duration::from_nanos(1));
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
        let of_a_revolution = self.hardware.steps_per_revolution;
        self.take((self.rules.steps)(Steps { before: self.steps, now: self.ways().1, of_a_revolution }));
        self.due = self.last + every;
    }

    /// Takes the steps of the last measurements.
    fn take(&mut self, steps: i64) {
        self.steps = steps;
        self.rpm = if steps == 0 { 0 } else { self.in_rpm(steps, self.measured_nanos()) };
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
    fn ways(&self) -> (i64, i64) {
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
        self.value_of(self.steps, scaling, direction)
    }

    /// The velocity of the measurements before, which are not the same ones.
    pub fn value_before(&self, scaling: &Scaling, direction: Direction) -> i64 {
        self.value_of(self.ways().0, scaling, direction)
    }

    fn value_of(&self, steps: i64, scaling: &Scaling, direction: Direction) -> i64 {
        if steps == 0 {
            return 0;
        }
        let factor = (self.rules.factor)(self.unit, &self.hardware, scaling);
        let above = i128::from(steps) * i128::from((self.rules.sign)(direction)) * factor.above;
        rounded(above, factor.below * self.measured_nanos())
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
        let nanos = self.measured_nanos();
        self.in_rpm(now.saturating_sub(before), nanos.saturating_mul(nanos) / 1_000_000_000)
    }

    /// `steps` in `nanos` as revolutions per minute.
    fn in_rpm(&self, steps: i64, nanos: i128) -> i64 {
        let steps_per_revolution = i128::from(self.hardware.steps_per_revolution);
        rounded(i128::from(steps) * 60_000_000_000, (steps_per_revolution * nanos).max(1))
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
mod tests {
    use super::*;
    use rstest::rstest;

    const MULTITURN: Hardware = Hardware { steps_per_revolution: 65536, revolutions: 16384 };
    const WINDOW: Duration = Duration::from_millis(100);

    fn millis(millis: u64) -> Time {
        Time::from_nanos(millis * 1_000_000)
    }

    fn standing(shaft: &Shaft, unit: Unit) -> Velocity {
        Velocity::new(WINDOW, unit, MULTITURN, Time::ZERO, shaft, Rules::default())
    }

    fn after(rpm: f64, unit: Unit) -> Velocity {
        let mut shaft = Shaft::new(65536, 0);
        let mut velocity = standing(&shaft, unit);
        shaft.turn(Time::ZERO, rpm);
        velocity.advance(millis(1000), &shaft);
        velocity
    }

    // Catalogue SPD-001 to SPD-004 and SPD-020: 60 rpm of the multiturn encoder in each unit, 6000 rpm both ways.
    #[rstest]
    #[case(60.0, Unit::PerSecond, 65540)]
    #[case(60.0, Unit::Per100Milliseconds, 6554)]
    #[case(60.0, Unit::Per10Milliseconds, 655)]
    #[case(60.0, Unit::Rpm, 60)]
    #[case(-60.0, Unit::Rpm, -60)]
    #[case(6000.0, Unit::Rpm, 6000)]
    #[case(-6000.0, Unit::Rpm, -6000)]
    #[case(0.0, Unit::PerSecond, 0)]
    fn units(#[case] rpm: f64, #[case] unit: Unit, #[case] value: i64) {
        let velocity = after(rpm, unit);
        assert_eq!(velocity.value(&Scaling::hardware(&MULTITURN), Direction::Clockwise), value);
        assert_eq!(velocity.value(&Scaling::hardware(&MULTITURN), Direction::Counterclockwise), -value);
    }

    #[test]
    fn steps_are_those_of_the_scaling() {
        let scaling = Scaling { units_per_revolution: 3600, range: 3600 * 16 };
        assert_eq!(after(60.0, Unit::PerSecond).value(&scaling, Direction::Clockwise), 3600);
        assert_eq!(after(60.0, Unit::Rpm).value(&scaling, Direction::Clockwise), 60);
    }

    #[test]
    fn a_change_is_seen_at_the_end_of_the_window_and_not_before() {
        let mut shaft = Shaft::new(65536, 0);
        let mut velocity = standing(&shaft, Unit::PerSecond);
        velocity.advance(millis(250), &shaft);
        shaft.turn(millis(250), 600.0);
        velocity.advance(millis(299), &shaft);
        assert_eq!(velocity.steps(), 0);
        velocity.advance(millis(300), &shaft);
        assert_eq!(velocity.steps(), 32768);
        velocity.advance(millis(399), &shaft);
        assert_eq!(velocity.steps(), 32768);
        velocity.advance(millis(400), &shaft);
        assert_eq!(velocity.steps(), 65536);
        shaft.turn(millis(400), 0.0);
        velocity.advance(millis(86_400_000), &shaft);
        assert_eq!(velocity.steps(), 0);
    }

    #[test]
    fn the_end_of_time_does_no_harm() {
        let mut shaft = Shaft::new(65536, 0);
        let mut velocity = standing(&shaft, Unit::PerSecond);
        shaft.turn(Time::ZERO, 6000.0);
        velocity.advance(Time::MAX, &shaft);
        assert_eq!(velocity.steps(), 0);
    }

    /// AFS60/AFM60 manual, 3.6.15 and 3.6.16: every T1 the mean of T2 measurements, here 2 ms and 50.
    #[test]
    fn a_mean_of_many_measurements_changes_with_each() {
        let mut shaft = Shaft::new(262_144, 0);
        let hardware = Hardware { steps_per_revolution: 262_144, revolutions: 1 };
        let sampling = Sampling { every: Duration::from_millis(2), of: 50 };
        let mut velocity =
            Velocity::sampled(sampling, Unit::RevolutionsPerSecond, hardware, Time::ZERO, &shaft, Rules::default());
        shaft.turn(Time::ZERO, 600.0);
        let scaling = Scaling::hardware(&hardware);
        for (at, rps, rpm, acceleration) in
            [(50, 5, 300, 3000), (99, 10, 588, 5880), (100, 10, 600, 6000), (200, 10, 600, 0)]
        {
            velocity.advance(millis(at), &shaft);
            assert_eq!(velocity.value(&scaling, Direction::Clockwise), rps, "at {at} ms");
            assert_eq!((velocity.rounded_rpm(), velocity.acceleration()), (rpm, acceleration), "at {at} ms");
        }
        shaft.turn(millis(200), -600.0);
        velocity.advance(millis(500_000), &shaft);
        assert_eq!(velocity.rounded_rpm(), -600);
        assert_eq!(velocity.value(&scaling, Direction::Counterclockwise), 10);
        velocity.sample(Sampling { every: Duration::from_secs(1), of: 1 }, millis(500_000), &shaft);
        assert_eq!(velocity.rounded_rpm(), 0);
        velocity.advance(millis(500_999), &shaft);
        assert_eq!(velocity.rounded_rpm(), 0, "a second has not gone by");
        velocity.advance(millis(501_000), &shaft);
        assert_eq!(velocity.rounded_rpm(), -600);
    }
}
