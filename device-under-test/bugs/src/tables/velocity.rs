//! Bugs of the velocity.

use super::Group;
use super::signal_image::{has_position, velocity_before};
use crate::needs::Need;
use crate::seams::Deviations;
use crate::seams::encoder::SentSignal;
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::Cell;
use core::time::Duration;
use encoder_profile::encoder::measuring::Sampled;
use encoder_profile::encoder::velocity::MeasuredWay;
use encoder_profile::encoder::{CountingDirection, MeasuringSettings, Sampling, Scaling, VelocityUnit};
use encoder_profile::hooks::EncoderView;
use encoder_profile::profidrive::telegram::{InputSignal, PreviousCycle, SignalImage};
use reference_devices::manuals;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Encoder],
        deviations: bugs! {
            "rpm-from-scaled-steps" "The velocity in rpm is computed from scaled steps and the hardware resolution."
                => |d| d.velocity.velocity(rpm_from_scaled_steps);
            "speed-held-at-standstill" "At standstill the last velocity is held."
                => |d| speed_held_at_standstill(d);
        },
    },
    Group {
        needs: &[Need::EncoderProfile],
        deviations: bugs! {
            "speed-ignores-code-sequence" "The code sequence reverses the position but not the velocity."
                => |d| d.velocity.velocity(|way, _| MeasuredWay { direction: CountingDirection::Clockwise, ..*way }.velocity());
            "speed-per-minute" "With unit 0 the velocity is in steps per minute."
                => |d| d.velocity.velocity(speed_per_minute);
            "speed-in-hardware-steps" "The velocity counts hardware steps although scaling is on."
                => |d| d.telegram.acts_on(|signal, hardware, settings| match signal {
                    InputSignal::NistB => MeasuringSettings { scaling: Scaling::hardware(hardware), ..settings },
                    _ => settings,
                });
            "speed-once-a-second" "The velocity is calculated once a second."
                => |d| d.velocity.sampling(|_, right| Sampling { interval: Duration::from_secs(1), ..right });
            "speed-window-by-unit" "With steps per 10 ms the velocity is calculated every 10 ms."
                => |d| d.velocity.sampling(speed_window_by_unit);
            "speed-modulo-a-revolution" "The movement per sampling interval is reduced to less than half a revolution."
                => |d| d.velocity.velocity(speed_modulo_a_revolution);
            "preset-shows-as-speed" "The jump of the position at a preset is reported as a velocity."
                => |d| d.encoder.signals(preset_shows_as_speed);
            "wrap-shows-as-speed" "The jump of the position at the end of its range is reported as a velocity."
                => |d| d.encoder.signals(wrap_shows_as_speed);
            "speed-without-sign" "The velocity has no sign."
                => |d| d.encoder.signals(|_, now| SignalImage { velocity: now.velocity.abs(), ..now });
            "speed-sign-inverted" "The velocity is negative while the position rises and positive while it falls."
                => |d| d.encoder.signals(|_, now| SignalImage { velocity: -now.velocity, ..now });
            "speed-overflows" "The 16-bit velocity wraps instead of being limited."
                => |d| d.encoder.signal(|of, octets| put_short(of, octets, of.image.velocity));
        },
    },
    Group {
        needs: &[Need::Profinet, Need::EncoderProfile],
        deviations: bugs! {
            "speed-units-exchanged" "The unit codes 1 and 2 are swapped."
                => |d| d.start.velocity_unit(speed_units_exchanged);
        },
    },
    Group {
        needs: &[Need::Of(&manuals::KUEBLER_SENDIX58XX)],
        deviations: bugs! {
            "speed-unit-scales-position" "With unit 1 every position is divided by 10, with unit 2 by 100."
                => |d| d.encoder.image(speed_unit_scales_position);
            "speed-every-100ms" "The velocity is calculated every 100 ms."
                => |d| d.velocity.sampling(|_, right| Sampling { interval: Duration::from_millis(100), ..right });
            "short-velocity-limited-symmetrically" "The 16-bit velocity is limited to -32767 instead of -32768."
                => |d| d.encoder.signal(|of, octets| put_short(of, octets, of.image.velocity.clamp(-i64::from(i16::MAX), i16::MAX.into())));
            "long-velocity-limited" "The 32-bit velocity is limited to the range -32768 to 32767."
                => |d| d.encoder.signals(|_, now| SignalImage { velocity: now.velocity.clamp(i16::MIN.into(), i16::MAX.into()), ..now });
            "short-velocity-filtered" "The 16-bit velocity is the mean of the last two values, the 32-bit velocity is the last value."
                => |d| d.encoder.signal(|of, octets| put_short(of, octets, short((of.image.velocity + velocity_before(of.view)) / 2)));
            "unused-scaling-in-velocity" "With scaling off the velocity uses the units per revolution of the record."
                => |d| unused_scaling_in_velocity(d);
        },
    },
];

fn speed_unit_scales_position(view: &EncoderView<'_>, _: &PreviousCycle, now: SignalImage) -> SignalImage {
    let by = match view.user.speed_unit {
        1 => 10,
        2 => 100,
        _ => 1,
    };
    SignalImage { plain_position: now.plain_position / by as u32, ..each_position(now, by) }
}

fn each_position(now: SignalImage, by: u64) -> SignalImage {
    let part = |position: u32| position / by as u32;
    let g1_xist2 = if has_position(&now) { part(now.g1_xist2) } else { now.g1_xist2 };
    let (single_turn, multi_turn) = (part(now.single_turn), part(now.multi_turn));
    SignalImage { g1_xist1: part(now.g1_xist1), g1_xist2, g1_xist3: now.g1_xist3 / by, single_turn, multi_turn, ..now }
}

fn unused_scaling_in_velocity(d: &mut Deviations) {
    let units = Rc::new(Cell::new(None));
    let of_record = Rc::clone(&units);
    d.start.settings(move |user, _, settings| {
        units.set(Some(user.units_per_revolution));
        settings
    });
    d.telegram.acts_on(move |signal, _, settings| match (signal, of_record.get()) {
        (InputSignal::NistB, Some(units_per_revolution)) => {
            MeasuringSettings { scaling: Scaling { units_per_revolution, ..settings.scaling }, ..settings }
        }
        _ => settings,
    });
}

fn short(velocity: i64) -> i64 {
    velocity.clamp(i16::MIN.into(), i16::MAX.into())
}

/// Sets the value of NIST_A.
fn put_short(of: &SentSignal<'_>, octets: &mut Vec<u8>, velocity: i64) {
    if of.signal == InputSignal::NistA {
        *octets = (velocity as u16).to_be_bytes().into();
    }
}

fn speed_per_minute(way: &MeasuredWay, right: i64) -> i64 {
    match way.unit {
        VelocityUnit::PerSecond => MeasuredWay { steps: way.steps * 60, ..*way }.velocity(),
        _ => right,
    }
}

fn rpm_from_scaled_steps(way: &MeasuredWay, right: i64) -> i64 {
    let units = way.scaling.units_per_revolution as i64;
    let nanos = way.nanos * i128::from(way.hardware.steps_per_revolution);
    match way.unit {
        VelocityUnit::Rpm => MeasuredWay { steps: way.steps * units, nanos, ..*way }.velocity(),
        _ => right,
    }
}

fn speed_window_by_unit(unit: VelocityUnit, right: Sampling) -> Sampling {
    match unit {
        VelocityUnit::Per10Milliseconds => Sampling { interval: right.interval / 10, ..right },
        _ => right,
    }
}

fn speed_units_exchanged(number: u8, right: VelocityUnit) -> VelocityUnit {
    match number {
        1 => VelocityUnit::Per10Milliseconds,
        2 => VelocityUnit::Per100Milliseconds,
        _ => right,
    }
}

fn speed_held_at_standstill(d: &mut Deviations) {
    let last = Rc::new(Cell::new(0));
    let held = last.clone();
    d.measuring.sampled(move |_, how| {
        if how != Sampled::Turned {
            last.set(0)
        }
    });
    d.velocity.velocity(move |way, _| {
        if way.steps != 0 {
            held.set(way.steps);
        }
        MeasuredWay { steps: held.get(), ..*way }.velocity()
    });
}

fn speed_modulo_a_revolution(way: &MeasuredWay, _: i64) -> i64 {
    let revolution = way.hardware.steps_per_revolution as i64;
    let steps = (way.steps + revolution / 2).rem_euclid(revolution) - revolution / 2;
    MeasuredWay { steps, ..*way }.velocity()
}

fn movement(before: &PreviousCycle, now: &SignalImage) -> i64 {
    now.position as i64 - before.unhooked.position as i64
}

fn preset_shows_as_speed(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if before.unhooked.good && now.offset != before.unhooked.offset {
        SignalImage { velocity: movement(before, &now), ..now }
    } else {
        now
    }
}

fn wrap_shows_as_speed(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    let movement = movement(before, &now);
    if movement.signum() * now.velocity.signum() < 0 { SignalImage { velocity: movement, ..now } } else { now }
}
