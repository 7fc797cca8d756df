//! Bugs of the velocity.

use super::Deviation;
use super::image::has_position;
use crate::seams::OfEncoder;
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::Cell;
use core::time::Duration;
use encoder_profile::encoder::measuring::Sampled;
use encoder_profile::encoder::velocity::MeasuredWay;
use encoder_profile::encoder::{Direction, Hardware, Sampling, Scaling, Unit};
use encoder_profile::profidrive::telegram::{self, Before, Image, Signal, Telegram};
use encoder_profile::profidrive::user_parameters::{UserParameters, unit};
use wire::octets::Append;

/// The bugs of this seam.
pub static BUGS: &[Deviation] = encoder_bugs! {
    // Units
    "speed-per-minute" "With unit 0 the velocity is given in steps per minute."
        => |b| b.velocity.velocity(speed_per_minute);
    "speed-units-exchanged" "The two unit codes 1 and 2 are swapped."
        => |b| b.user_parameters.unit = speed_units_exchanged;
    "rpm-from-scaled-steps" "Revolutions per minute are computed from scaled steps and the hardware resolution."
        => |b| b.velocity.velocity(rpm_from_scaled_steps);
    "speed-in-hardware-steps" "The velocity counts steps of the hardware although scaling is on."
        => |b| b.user_parameters.scales_velocity = |_, hardware, _| Scaling::hardware(hardware);

    // Windows
    "speed-once-a-second" "The velocity is calculated once a second."
        => |b| b.velocity.sampling(|_, right| Sampling { every: Duration::from_secs(1), ..right });
    "speed-window-by-unit" "With steps per 10 ms the velocity is calculated every 10 ms."
        => |b| b.velocity.sampling(speed_window_by_unit);
    "speed-held-at-standstill" "The last velocity is held when no steps come."
        => |b| speed_held_at_standstill(b);
    "speed-modulo-a-revolution" "The way of a window is taken as less than half a revolution."
        => |b| b.velocity.velocity(speed_modulo_a_revolution);
    "preset-shows-as-speed" "The jump of the position by a preset is taken for a velocity."
        => |b| b.at_encoder.image(preset_shows_as_speed);
    "wrap-shows-as-speed" "The jump of the position at the end of its range is taken for a velocity."
        => |b| b.at_encoder.image(wrap_shows_as_speed);

    // Sign and limits
    "speed-without-sign" "The velocity is a magnitude."
        => |b| b.at_encoder.image(|_, now| Image { velocity: now.velocity.abs(), ..now });
    "speed-ignores-code-sequence" "The code sequence reverses the position and not the velocity."
        => |b| b.velocity.velocity(|way, _| MeasuredWay { direction: Direction::Clockwise, ..*way }.velocity());
    "speed-overflows" "The 16-bit speed wraps instead of stopping at its limit."
        => |b| b.telegram.put = speed_overflows;
};

/// The bugs of this seam that not all manuals have.
pub static OTHERS: &[Deviation] = encoder_bugs! {
    "speed-unit-scales-position" "With unit 1 every position is divided by 10, with unit 2 by 100."
        => |b| b.at_encoder.image(speed_unit_scales_position);
    "speed-every-100ms" "The velocity is calculated every 100 ms."
        => |b| b.velocity.sampling(|_, right| Sampling { every: Duration::from_millis(100), ..right });
    "speed-sign-inverted" "The velocity is negative while the position rises and positive while it falls."
        => |b| b.at_encoder.image(|_, now| Image { velocity: -now.velocity, ..now });
    "short-velocity-limited-symmetrically" "The 16-bit speed stops at -32767, where -32768 would be shown."
        => |b| b.telegram.put = short_velocity_limited_symmetrically;
    "long-velocity-limited" "The velocity of 32 bits stops at 32767 and at -32768."
        => |b| b.telegram.put = long_velocity_limited;
    "short-velocity-filtered" "The 16-bit speed shows the mean of the last two velocities, that of 32 bits the last one."
        => |b| b.telegram.put = short_velocity_filtered;
    "unused-scaling-in-velocity" "With scaling off the velocity counts the units per revolution of the record."
        => |b| b.user_parameters.scales_velocity = unused_scaling_in_velocity;
};

fn speed_unit_scales_position(_: &Before, now: Image) -> Image {
    let by = match now.speed_unit {
        1 => 10,
        2 => 100,
        _ => 1,
    };
    Image { plain_position: now.plain_position / by as u32, ..each_position(now, by) }
}

fn each_position(now: Image, by: u64) -> Image {
    let part = |position: u32| position / by as u32;
    let g1_xist2 = if has_position(&now) { part(now.g1_xist2) } else { now.g1_xist2 };
    let (single_turn, multi_turn) = (part(now.single_turn), part(now.multi_turn));
    Image { g1_xist1: part(now.g1_xist1), g1_xist2, g1_xist3: now.g1_xist3 / by, single_turn, multi_turn, ..now }
}

fn short_velocity_limited_symmetrically(_: &Telegram, signal: Signal, image: &Image, out: &mut Vec<u8>) {
    let velocity = match signal {
        Signal::NistA => image.velocity.max(-i64::from(i16::MAX)),
        _ => image.velocity,
    };
    telegram::put(signal, &Image { velocity, ..*image }, out);
}

fn long_velocity_limited(_: &Telegram, signal: Signal, image: &Image, out: &mut Vec<u8>) {
    let velocity = image.velocity.clamp(i16::MIN.into(), i16::MAX.into());
    telegram::put(signal, &Image { velocity, ..*image }, out);
}

fn short_velocity_filtered(_: &Telegram, signal: Signal, image: &Image, out: &mut Vec<u8>) {
    let velocity = match signal {
        Signal::NistA => (image.velocity + image.velocity_before) / 2,
        _ => image.velocity,
    };
    telegram::put(signal, &Image { velocity, ..*image }, out);
}

fn unused_scaling_in_velocity(scaling: Scaling, _: &Hardware, user: &UserParameters) -> Scaling {
    Scaling { units_per_revolution: user.units_per_revolution, ..scaling }
}

fn speed_per_minute(way: &MeasuredWay, right: i64) -> i64 {
    match way.unit {
        Unit::PerSecond => MeasuredWay { steps: way.steps * 60, ..*way }.velocity(),
        _ => right,
    }
}

fn rpm_from_scaled_steps(way: &MeasuredWay, right: i64) -> i64 {
    let units = way.scaling.units_per_revolution as i64;
    let nanos = way.nanos * i128::from(way.hardware.steps_per_revolution);
    match way.unit {
        Unit::Rpm => MeasuredWay { steps: way.steps * units, nanos, ..*way }.velocity(),
        _ => right,
    }
}

fn speed_window_by_unit(unit: Unit, right: Sampling) -> Sampling {
    match unit {
        Unit::Per10Milliseconds => Sampling { every: right.every / 10, ..right },
        _ => right,
    }
}

fn speed_units_exchanged(number: u8) -> Option<Unit> {
    match number {
        1 => unit(2),
        2 => unit(1),
        other => unit(other),
    }
}

fn speed_held_at_standstill(b: &mut OfEncoder<'_>) {
    let last = Rc::new(Cell::new(0));
    let held = last.clone();
    b.measuring.sampled(move |_, how| {
        if how != Sampled::Turned {
            last.set(0)
        }
    });
    b.velocity.velocity(move |way, _| {
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

fn movement(before: &Before, now: &Image) -> i64 {
    now.position as i64 - before.truth.position as i64
}

fn preset_shows_as_speed(before: &Before, now: Image) -> Image {
    match before.truth.good && now.offset != before.truth.offset {
        true => Image { velocity: movement(before, &now), ..now },
        false => now,
    }
}

fn wrap_shows_as_speed(before: &Before, now: Image) -> Image {
    let movement = movement(before, &now);
    match movement.signum() * now.velocity.signum() < 0 {
        true => Image { velocity: movement, ..now },
        false => now,
    }
}

fn speed_overflows(_: &Telegram, signal: Signal, image: &Image, out: &mut Vec<u8>) {
    match signal {
        Signal::NistA => out.put_u16(image.velocity as u16),
        other => telegram::put(other, image, out),
    }
}
