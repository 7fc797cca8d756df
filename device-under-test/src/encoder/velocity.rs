//! How fast the shaft turned in the last window of measurement.

use super::{Hardware, Scaling, Shaft};
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

/// The velocity, measured anew at the end of each window.
///
/// It needs no deadline: asked at any time, it gives what was measured at the end of the last whole window. Whoever
/// changes the motion of the shaft calls [`advance`](Velocity::advance) before and so keeps the past.
#[derive(Clone, Debug)]
pub struct Velocity {
    window: Duration,
    last: Time,
    place: i64,
    steps: i64,
}

impl Velocity {
    /// Begins to measure at `now`, in windows of `window`.
    pub fn new(window: Duration, now: Time, shaft: &Shaft) -> Velocity {
        Velocity { window, last: now, place: shaft.place(now), steps: 0 }
    }

    /// Measures all windows that have ended by `now`.
    pub fn advance(&mut self, now: Time, shaft: &Shaft) {
        let window = self.window.as_nanos().max(1);
        let ended = now.since(self.last).as_nanos() / window;
        let Ok(ended) = u32::try_from(ended) else { return self.restart(now, shaft) };
        if ended > 1 {
            self.last += self.window * (ended - 1);
            self.place = shaft.place(self.last);
        }
        if ended > 0 {
            self.last += self.window;
            let place = shaft.place(self.last);
            self.steps = place.saturating_sub(self.place);
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

    /// The velocity in `unit`, rounded to the nearest, clockwise positive.
    pub fn value(&self, unit: Unit, hardware: &Hardware, scaling: &Scaling) -> i64 {
        let steps = i128::from(self.steps);
        let (per_revolution, per) = match unit {
            Unit::PerSecond => (scaling.units_per_revolution, 1_000_000_000),
            Unit::Per100Milliseconds => (scaling.units_per_revolution, 100_000_000),
            Unit::Per10Milliseconds => (scaling.units_per_revolution, 10_000_000),
            Unit::Rpm => (1, 60_000_000_000),
        };
        let above = steps * i128::from(per_revolution) * per;
        let below = i128::from(hardware.steps_per_revolution) * self.window.as_nanos().max(1) as i128;
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

    fn after(rpm: f64) -> Velocity {
        let mut shaft = Shaft::new(65536, 0);
        let mut velocity = Velocity::new(WINDOW, Time::ZERO, &shaft);
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
        assert_eq!(after(rpm).value(unit, &MULTITURN, &Scaling::hardware(&MULTITURN)), value);
    }

    #[test]
    fn steps_are_those_of_the_scaling() {
        let scaling = Scaling { units_per_revolution: 3600, range: 3600 * 16 };
        assert_eq!(after(60.0).value(Unit::PerSecond, &MULTITURN, &scaling), 3600);
    }

    #[test]
    fn a_change_is_seen_at_the_end_of_the_window_and_not_before() {
        let mut shaft = Shaft::new(65536, 0);
        let mut velocity = Velocity::new(WINDOW, Time::ZERO, &shaft);
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
        let mut velocity = Velocity::new(WINDOW, Time::ZERO, &shaft);
        shaft.turn(Time::ZERO, 6000.0);
        velocity.advance(Time::MAX, &shaft);
        assert_eq!(velocity.steps(), 0);
    }
}
