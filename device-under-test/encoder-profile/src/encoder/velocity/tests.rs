//! Velocities in each unit, windows and means.

use super::*;
use rstest::rstest;

const MULTITURN: Hardware = Hardware { steps_per_revolution: 65536, revolutions: 16384 };
const WINDOW: Duration = Duration::from_millis(100);

fn millis(millis: u64) -> Time {
    Time::from_nanos(millis * 1_000_000)
}

fn standing(shaft: &Shaft, unit: VelocityUnit) -> Velocity {
    Velocity::new(WINDOW, unit, MULTITURN, Time::ZERO, shaft, Attached::NONE)
}

fn after(rpm: f64, unit: VelocityUnit) -> Velocity {
    let mut shaft = Shaft::new(65536, 0);
    let mut velocity = standing(&shaft, unit);
    shaft.turn(Time::ZERO, rpm);
    velocity.advance(millis(1000), &shaft);
    velocity
}

// Catalogue SPD-001 to SPD-004 and SPD-020: 60 rpm of the multiturn encoder in each unit, 6000 rpm both ways.
#[rstest]
#[case(60.0, VelocityUnit::PerSecond, 65540)]
#[case(60.0, VelocityUnit::Per100Milliseconds, 6554)]
#[case(60.0, VelocityUnit::Per10Milliseconds, 655)]
#[case(60.0, VelocityUnit::Rpm, 60)]
#[case(-60.0, VelocityUnit::Rpm, -60)]
#[case(6000.0, VelocityUnit::Rpm, 6000)]
#[case(-6000.0, VelocityUnit::Rpm, -6000)]
#[case(0.0, VelocityUnit::PerSecond, 0)]
fn units(#[case] rpm: f64, #[case] unit: VelocityUnit, #[case] value: i64) {
    let velocity = after(rpm, unit);
    assert_eq!(velocity.value(&Scaling::hardware(&MULTITURN), CountingDirection::Clockwise), value);
    assert_eq!(velocity.value(&Scaling::hardware(&MULTITURN), CountingDirection::Counterclockwise), -value);
}

#[test]
fn units_per_second_use_the_scaling() {
    let scaling = Scaling { units_per_revolution: 3600, range: 3600 * 16 };
    assert_eq!(after(60.0, VelocityUnit::PerSecond).value(&scaling, CountingDirection::Clockwise), 3600);
    assert_eq!(after(60.0, VelocityUnit::Rpm).value(&scaling, CountingDirection::Clockwise), 60);
}

#[test]
fn a_change_is_measured_at_the_end_of_the_window() {
    let mut shaft = Shaft::new(65536, 0);
    let mut velocity = standing(&shaft, VelocityUnit::PerSecond);
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
fn the_end_of_time_does_not_panic() {
    let mut shaft = Shaft::new(65536, 0);
    let mut velocity = standing(&shaft, VelocityUnit::PerSecond);
    shaft.turn(Time::ZERO, 6000.0);
    velocity.advance(Time::MAX, &shaft);
    assert_eq!(velocity.steps(), 0);
}

/// AFS60/AFM60 manual, 3.6.15 and 3.6.16: every T1 the mean of T2 measurements, here 2 ms and 50.
#[test]
fn a_mean_of_many_measurements_changes_with_each() {
    let mut shaft = Shaft::new(262_144, 0);
    let hardware = Hardware { steps_per_revolution: 262_144, revolutions: 1 };
    let sampling = Sampling { interval: Duration::from_millis(2), count: 50 };
    let mut velocity =
        Velocity::sampled(sampling, VelocityUnit::RevolutionsPerSecond, hardware, Time::ZERO, &shaft, Attached::NONE);
    shaft.turn(Time::ZERO, 600.0);
    let scaling = Scaling::hardware(&hardware);
    for (at, rps, rpm, acceleration) in
        [(50, 5, 300, 3000), (99, 10, 588, 5880), (100, 10, 600, 6000), (200, 10, 600, 0)]
    {
        velocity.advance(millis(at), &shaft);
        assert_eq!(velocity.value(&scaling, CountingDirection::Clockwise), rps, "at {at} ms");
        assert_eq!((velocity.rounded_rpm(), velocity.acceleration()), (rpm, acceleration), "at {at} ms");
    }
    shaft.turn(millis(200), -600.0);
    velocity.advance(millis(500_000), &shaft);
    assert_eq!(velocity.rounded_rpm(), -600);
    assert_eq!(velocity.value(&scaling, CountingDirection::Counterclockwise), 10);
    velocity.sample(Sampling { interval: Duration::from_secs(1), count: 1 }, millis(500_000), &shaft);
    assert_eq!(velocity.rounded_rpm(), 0);
    velocity.advance(millis(500_999), &shaft);
    assert_eq!(velocity.rounded_rpm(), 0, "one second has not elapsed");
    velocity.advance(millis(501_000), &shaft);
    assert_eq!(velocity.rounded_rpm(), -600);
}

#[cfg(feature = "deviations")]
#[test]
fn a_deviation_changes_each_step() {
    use alloc::rc::Rc;
    use core::cell::RefCell;

    struct VelocityDeviation;

    impl VelocitySteps for VelocityDeviation {
        fn sampling(&mut self, unit: VelocityUnit, sampling: Sampling) -> Sampling {
            if unit == VelocityUnit::Rpm { Sampling::once(sampling.interval * 10) } else { sampling }
        }

        fn velocity(&mut self, way: &MeasuredWay, velocity: i64) -> i64 {
            velocity + way.steps
        }
    }

    let mut shaft = Shaft::new(65536, 0);
    let mut velocity = Velocity::new(
        WINDOW,
        VelocityUnit::Rpm,
        MULTITURN,
        Time::ZERO,
        &shaft,
        Attached::new(Rc::new(RefCell::new(VelocityDeviation))),
    );
    shaft.turn(Time::ZERO, 60.0);
    velocity.advance(millis(999), &shaft);
    assert_eq!(velocity.value(&Scaling::hardware(&MULTITURN), CountingDirection::Clockwise), 0);
    velocity.advance(millis(1000), &shaft);
    assert_eq!(velocity.value(&Scaling::hardware(&MULTITURN), CountingDirection::Clockwise), 65536 + 60);
}
