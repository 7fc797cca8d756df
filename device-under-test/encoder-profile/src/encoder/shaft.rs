//! The shaft, which the stand turns: its position at any time.

use core::time::Duration;
use station::Time;

/// The resolution of speeds: a millionth of a revolution per minute.
const MICRO: i128 = 1_000_000;
const NANOS_PER_MINUTE: i128 = 60_000_000_000;
const NANOS_PER_SECOND: i128 = 1_000_000_000;

/// The position of a shaft as a function of time, in hardware steps, clockwise positive.
///
/// The position is unbounded: a shaft can turn any number of revolutions to either side of its physical zero. The
/// range of the sensor is applied elsewhere. All arithmetic is exact on nanoseconds.
#[derive(Clone, Debug)]
pub struct Shaft {
    steps_per_revolution: u64,
    from: i64,
    since: Time,
    motion: Motion,
}

#[derive(Clone, Copy, Debug)]
enum Motion {
    Standing,
    /// Speed in millionths of a revolution per minute.
    Turning {
        speed: i128,
    },
    /// The same, until the shaft has turned by `steps_in`.
    TurningBy {
        speed: i128,
        way: i64,
        until: Time,
    },
    /// A constant acceleration from one speed to another, which is reached at `until` and kept.
    Ramping {
        from: i128,
        to: i128,
        /// Millionths of a revolution per minute, per second; negative if the speed decreases.
        acceleration: i128,
        until: Time,
    },
}

impl Shaft {
    /// A shaft at rest at `position`.
    pub fn new(steps_per_revolution: u64, place: i64) -> Shaft {
        Shaft { steps_per_revolution, from: place, since: Time::ZERO, motion: Motion::Standing }
    }

    /// The position at `now`.
    #[inline]
    pub fn position(&self, now: Time) -> i64 {
        match self.motion {
            Motion::Standing => self.from,
            _ => self.position_in_motion(now),
        }
    }

    fn position_in_motion(&self, now: Time) -> i64 {
        match self.motion {
            Motion::Standing => self.from,
            Motion::Turning { speed } => self.from.saturating_add(self.steps_in(speed, now.since(self.since))),
            Motion::TurningBy { way, until, .. } if now >= until => self.from.saturating_add(way),
            Motion::TurningBy { speed, .. } => self.from.saturating_add(self.steps_in(speed, now.since(self.since))),
            Motion::Ramping { from, to, acceleration, until } => {
                let ramp = self.steps_in_ramp(from, acceleration, now.min(until).since(self.since));
                self.from.saturating_add(ramp).saturating_add(self.steps_in(to, now.max(until).since(until)))
            }
        }
    }

    /// Whether the shaft turns at `now`.
    pub fn is_moving(&self, now: Time) -> bool {
        match self.motion {
            Motion::Standing => false,
            Motion::Turning { speed } => speed != 0,
            Motion::TurningBy { until, .. } => now < until,
            Motion::Ramping { to, until, .. } => to != 0 || now < until,
        }
    }

    /// Revolutions per minute at `now`, rounded to the nearest.
    pub fn rounded_rpm(&self, now: Time) -> i64 {
        let speed = self.speed(now);
        // No valid speed exceeds 64 bits.
        match i64::try_from(speed + speed.signum() * MICRO / 2) {
            Ok(speed) => speed / MICRO as i64,
            Err(_) => ((speed + speed.signum() * MICRO / 2) / MICRO) as i64,
        }
    }

    /// The speed at `now`, in millionths of a revolution per minute.
    fn speed(&self, now: Time) -> i128 {
        match self.motion {
            Motion::Standing => 0,
            Motion::Turning { speed } => speed,
            Motion::TurningBy { speed, until, .. } => {
                if now < until {
                    speed
                } else {
                    0
                }
            }
            Motion::Ramping { to, until, .. } if now >= until => to,
            Motion::Ramping { from, acceleration, .. } => {
                from + acceleration * now.since(self.since).as_nanos() as i128 / NANOS_PER_SECOND
            }
        }
    }

    /// Moves the shaft to `position` at once and stops it.
    pub fn move_to(&mut self, now: Time, place: i64) {
        (self.from, self.since, self.motion) = (place, now, Motion::Standing);
    }

    /// Turns the shaft from `now` on at `rpm` revolutions per minute.
    pub fn turn(&mut self, now: Time, rpm: f64) {
        (self.from, self.since) = (self.position(now), now);
        self.motion = Motion::Turning { speed: to_integer(rpm * MICRO as f64) };
    }

    /// Accelerates or decelerates the shaft from `now` on, by `acceleration` revolutions per minute each second, to
    /// `rpm`. With an acceleration of 0 the speed changes at once.
    pub fn ramp(&mut self, now: Time, rpm: f64, acceleration: f64) {
        let (from, to) = (self.speed(now), to_integer(rpm * MICRO as f64));
        let steepness = to_integer(acceleration * MICRO as f64).abs();
        if steepness == 0 || from == to {
            return self.turn(now, rpm);
        }
        (self.from, self.since) = (self.position(now), now);
        let nanos = ((to - from).abs() * NANOS_PER_SECOND + steepness - 1) / steepness;
        let until = now + Duration::from_nanos(u64::try_from(nanos).unwrap_or(u64::MAX));
        self.motion = Motion::Ramping { from, to, acceleration: steepness * (to - from).signum(), until };
    }

    /// Turns the shaft by `steps` at `rpm` and returns when it arrives.
    ///
    /// With a speed of 0 it arrives at once.
    pub fn turn_by(&mut self, now: Time, steps: f64, rpm: f64) -> Time {
        let way = i64::try_from(to_integer(steps)).unwrap_or(0);
        let speed = to_integer(rpm * MICRO as f64).abs() * i128::from(way.signum());
        (self.from, self.since) = (self.position(now), now);
        let per_nano = self.steps_per_revolution as i128 * speed.abs();
        if per_nano == 0 {
            self.move_to(now, self.from.saturating_add(way));
            return now;
        }
        let nanos = (i128::from(way.abs()) * NANOS_PER_MINUTE * MICRO + per_nano - 1) / per_nano;
        let until = now + Duration::from_nanos(u64::try_from(nanos).unwrap_or(u64::MAX));
        self.motion = Motion::TurningBy { speed, way, until };
        until
    }

    /// Turns the shaft by `revolutions` at `rpm`; see [`Shaft::turn_by`].
    pub fn turn_revolutions(&mut self, now: Time, revolutions: f64, rpm: f64) -> Time {
        self.turn_by(now, revolutions * self.steps_per_revolution as f64, rpm)
    }

    /// The steps in `time`, rounded towards zero.
    fn steps_in(&self, speed: i128, time: Duration) -> i64 {
        // Nearly always the speed is a whole number and the product is small, and a division of 128 bits is slow.
        if let (Ok(speed), Ok(nanos)) = (i64::try_from(speed), i64::try_from(time.as_nanos()))
            && speed % (MICRO as i64) == 0
            && let Some(turned) = (speed / MICRO as i64).checked_mul(nanos)
            && let Some(turned) =
                i64::try_from(self.steps_per_revolution).ok().and_then(|steps| turned.checked_mul(steps))
        {
            return turned / NANOS_PER_MINUTE as i64;
        }
        let turned = (self.steps_per_revolution as i128 * speed).saturating_mul(time.as_nanos() as i128);
        i64::try_from(turned / (NANOS_PER_MINUTE * MICRO)).unwrap_or(i64::MAX)
    }

    /// The steps in `time` since the begin of a ramp: speed times time, plus half the acceleration times the square
    /// of the time.
    fn steps_in_ramp(&self, speed: i128, acceleration: i128, time: Duration) -> i64 {
        let nanos = time.as_nanos() as i128;
        let steady = (2 * NANOS_PER_SECOND).saturating_mul(speed);
        let turned = acceleration.saturating_mul(nanos).saturating_add(steady).saturating_mul(nanos);
        let turned = turned.saturating_mul(self.steps_per_revolution as i128);
        i64::try_from(turned / (2 * NANOS_PER_SECOND * NANOS_PER_MINUTE * MICRO)).unwrap_or(i64::MAX)
    }
}

/// The nearest integer, limited to the values that a shaft supports. Halves round away from zero; NaN gives 0.
fn to_integer(value: f64) -> i128 {
    const LIMIT: f64 = 1e15;
    (value.clamp(-LIMIT, LIMIT) + if value < 0.0 { -0.5 } else { 0.5 }) as i128
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    fn seconds(seconds: u64) -> Time {
        Time::from_nanos(seconds * 1_000_000_000)
    }

    #[rstest]
    #[case::one_revolution_a_second(60.0, 1, 65536)]
    #[case::backwards(-60.0, 1, -65536)]
    #[case::hours_without_drift(60.0, 86_400, 86_400 * 65536)]
    #[case::a_third_of_a_step(0.000305175, 1, 0)]
    #[case::fraction_of_an_rpm(11.25, 16, 3 * 65536)]
    fn a_constant_speed_is_exact(#[case] rpm: f64, #[case] after: u64, #[case] way: i64) {
        let mut shaft = Shaft::new(65536, 1000);
        shaft.turn(Time::ZERO, rpm);
        assert_eq!(shaft.position(seconds(after)), 1000 + way);
    }

    #[test]
    fn a_turn_passes_all_positions_and_ends_at_its_target() {
        let mut shaft = Shaft::new(65536, 0);
        let arrival = shaft.turn_revolutions(seconds(1), -2.5, 60.0);
        assert_eq!(arrival, Time::from_nanos(3_500_000_000));
        assert_eq!(shaft.position(seconds(2)), -65536);
        assert!(shaft.is_moving(seconds(2)));
        assert_eq!(shaft.position(arrival - Duration::from_nanos(1)), -163_839);
        assert_eq!(shaft.position(arrival), -163_840);
        assert!(!shaft.is_moving(arrival));
        assert_eq!(shaft.position(seconds(100)), -163_840);
    }

    #[test]
    fn single_steps_are_exact() {
        let mut shaft = Shaft::new(262_144, 7);
        let arrival = shaft.turn_by(Time::ZERO, 1.0, 60.0);
        assert_eq!(shaft.position(arrival), 8);
        let arrival = shaft.turn_by(arrival, -1.0, 0.0);
        assert_eq!(shaft.position(arrival), 7);
    }

    #[test]
    fn a_change_of_speed_continues_from_the_current_position() {
        let mut shaft = Shaft::new(65536, 0);
        shaft.turn(Time::ZERO, 60.0);
        shaft.turn(seconds(1), -30.0);
        shaft.turn(seconds(3), 0.0);
        assert!(!shaft.is_moving(seconds(3)));
        assert_eq!(shaft.position(seconds(9)), 0);
        shaft.move_to(seconds(9), 1 << 29);
        assert_eq!(shaft.position(seconds(10)), 1 << 29);
    }

    /// The mean speed of a ramp with constant acceleration is half the sum of its end speeds.
    #[rstest]
    #[case::from_rest(0.0, 600.0, 300.0, 2, 10 * 65536)]
    #[case::and_constant_speed_afterwards(0.0, 600.0, 300.0, 5, 40 * 65536)]
    #[case::down_to_rest(600.0, 0.0, 600.0, 9, 5 * 65536)]
    #[case::through_rest_to_the_other_side(60.0, -60.0, 60.0, 2, 0)]
    #[case::at_once(0.0, 60.0, 0.0, 1, 65536)]
    fn a_ramp_has_a_constant_acceleration(
        #[case] from: f64,
        #[case] to: f64,
        #[case] by: f64,
        #[case] after: u64,
        #[case] way: i64,
    ) {
        let mut shaft = Shaft::new(65536, 0);
        shaft.turn(Time::ZERO, from);
        shaft.ramp(seconds(0), to, by);
        assert_eq!(shaft.position(seconds(after)), way);
        assert_eq!(shaft.is_moving(seconds(after)), to != 0.0);
    }

    #[test]
    fn a_ramp_within_a_ramp_starts_with_the_current_speed() {
        let mut shaft = Shaft::new(65536, 0);
        shaft.ramp(Time::ZERO, 600.0, 60.0);
        shaft.ramp(seconds(1), 0.0, 60.0);
        assert_eq!(shaft.position(seconds(2)), 65536, "half a revolution up to 60 rpm and half a revolution down");
        assert!(!shaft.is_moving(seconds(2)));
    }

    #[rstest]
    #[case(f64::NAN)]
    #[case(f64::INFINITY)]
    #[case(1e300)]
    fn invalid_numbers_do_not_panic(#[case] number: f64) {
        let mut shaft = Shaft::new(65536, 0);
        shaft.turn(Time::ZERO, number);
        shaft.position(Time::MAX);
        shaft.turn_by(Time::ZERO, number, number);
        shaft.position(Time::MAX);
        shaft.ramp(Time::ZERO, number, number);
        shaft.position(Time::MAX);
        shaft.ramp(Time::MAX, 60.0, 1e-9);
        shaft.position(Time::MAX);
    }
}
