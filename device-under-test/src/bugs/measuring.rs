//! Bugs of scaling, red zone and velocity.

use super::Bug;
use crate::encoder::measuring::Crossing;
use crate::encoder::{Scaling, Unit};
use crate::profidrive::telegram::{self, Image, Signal};
use crate::profidrive::user_parameters::unit;
use alloc::vec::Vec;
use wire::octets::Append;

pub(crate) static BUGS: &[Bug] = bugs! {
    // Scaling and velocity
    "red-zone-forward-only" "The jump at the physical zero is missing when turning backwards."
        => |b| b.measuring.beyond = red_zone_forward_only;
    "red-zone-one-late" "The jump comes one position later."
        => |b| b.measuring.beyond = red_zone_one_late;
    "speed-overflows" "The 16-bit speed wraps instead of stopping at its limit."
        => |b| b.telegram.put = speed_overflows;
    "speed-units-exchanged" "The two unit codes 1 and 2 are swapped."
        => |b| b.user_parameters.unit = speed_units_exchanged;
    "speed-without-sign" "The velocity is a magnitude."
        => |b| b.telegram.emit = |_, now| Image { velocity: now.velocity.abs(), ..now };
    "speed-in-hardware-steps" "The velocity counts steps of the hardware although scaling is on."
        => |b| b.user_parameters.scales_velocity = |_, hardware| Scaling::hardware(hardware);
};

fn speed_overflows(signal: Signal, image: &Image, out: &mut Vec<u8>) {
    match signal {
        Signal::NistA => out.put_u16(image.velocity as u16),
        other => telegram::put(other, image, out),
    }
}

fn speed_units_exchanged(number: u8) -> Option<Unit> {
    match number {
        1 => unit(2),
        2 => unit(1),
        other => unit(other),
    }
}

/// Goes on counting below the physical zero, until it is passed forward again.
fn red_zone_forward_only(crossing: Crossing) -> i64 {
    let Crossing { before, now, range, beyond } = crossing;
    match now.abs_diff(before) > range / 2 {
        true if now > before => -1,
        true => 0,
        false => beyond,
    }
}

/// Takes the physical zero, reached from below, as one more place of the range that has ended.
fn red_zone_one_late(crossing: Crossing) -> i64 {
    match crossing {
        Crossing { now: 0, before, range, .. } if before > range / 2 => 1,
        Crossing { now: 0, beyond, .. } => beyond,
        _ => 0,
    }
}
