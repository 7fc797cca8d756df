//! How fast the shaft turned in the last window of measurement.

use super::{Direction, Hardware, Scaling, Shaft};
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
    /// How long a window is, from how long it should be and the unit in force.
    pub window: fn(Duration, Unit) -> Duration,
    /// The steps that count.
    pub steps: fn(Steps) -> i64,
    /// What makes a velocity of steps.
    pub factor: fn(Unit, &Hardware, &Scaling) -> Factor,
    /// The sign of a velocity clockwise.
    pub sign: fn(Direction) -> i64,
}

impl Default for Rules {
    fn default() -> Rules {
        Rules { window: |window, _| window, steps: |steps| steps.now, factor, sign }
    }
}

/// Units per revolution over steps per revolution, and nanoseconds of the time of the unit.
pub fn factor(unit: Unit, hardware: &Hardware, scaling: &Scaling) -> Factor {
    let (per_revolution, time) = match unit {
        Unit::PerSecond => (scaling.units_per_revolution, 1_000_000_000),
        Unit::Per100Milliseconds => (scaling.units_per_revolution, 100_000_000),
        Unit::Per10Milliseconds => (scaling.units_per_revolution, 10_000_000),
        Unit::Rpm => (1, 60_000_000_000),
    };
    Factor { above: i128::from(per_revolution) * time, below: hardware.steps_per_revolution.into() }
}

fn sign(direction: Direction) -> i64 {
    match direction {
        Direction::Clockwise => 1,
        Direction::Counterclockwise => -1,
    }
}

/// The velocity, measured anew at the end of each window.
///
/// It needs no deadline: asked at any time, it gives what was measured at the end of the last whole window. Whoever
/// changes the motion of the shaft or the unit calls [`advance`](Velocity::advance) before and so keeps the past.
#[derive(Clone, Debug)]
pub struct Velocity {
    /// The unit in force.
    pub unit: Unit,
    hardware: Hardware,
    window: Duration,
    last: Time,
    place: i64,
    steps: i64,
    rules: Rules,
}

impl Velocity {
    /// Begins to measure at `now`, in windows of `window`.
    pub fn new(window: Duration, unit: Unit, hardware: Hardware, now: Time, shaft: &Shaft, rules: Rules) -> Velocity {
        Velocity { unit, hardware, window, last: now, place: shaft.place(now), steps: 0, rules }
    }

    fn window(&self) -> Duration {
        (self.rules.window)(self.window, self.unit).max(Duration::from_nanos(1))
    }

    /// Measures all windows that have ended by `now`.
    pub fn advance(&mut self, now: Time, shaft: &Shaft) {
        let window = self.window();
        let ended = now.since(self.last).as_nanos() / window.as_nanos();
        let Ok(ended) = u32::try_from(ended) else { return self.restart(now, shaft) };
        if ended > 1 {
            self.last += window * (ended - 1);
            self.place = shaft.place(self.last);
        }
        if ended > 0 {
            self.last += window;
            let place = shaft.place(self.last);
            let now = place.saturating_sub(self.place);
            let of_a_revolution = self.hardware.steps_per_revolution;
            self.steps = (self.rules.steps)(Steps { before: self.steps, now, of_a_revolution });
            self.place = place;
        }
    }

    /// Forgets what was measured, as if the shaft had always stood where it is.
    pub fn restart(&mut self, now: Time, shaft: &Shaft) {
        (self.last, self.place, self.steps) = (now, shaft.place(now), 0);
    }

    /// Hardware steps in the last whole window, clockwise positive.
    pub fn steps(&self) -> i64 {
        self.steps
    }

    /// The velocity in the unit in force, rounded to the nearest, positive while the position rises.
    pub fn value(&self, scaling: &Scaling, direction: Direction) -> i64 {
        let factor = (self.rules.factor)(self.unit, &self.hardware, scaling);
        let above = i128::from(self.steps) * i128::from((self.rules.sign)(direction)) * factor.above;
        let below = factor.below * self.window().as_nanos() as i128;
        i64::try_from((above + above.signum() * below / 2) / below).unwrap_or(i64::MAX)
    }
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
}
