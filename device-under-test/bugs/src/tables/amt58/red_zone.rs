//! Bugs of the positions in the red zone.

use super::diagnosis::{ALARMS, patch};
use crate::seams::measuring::ShaftStep;
use crate::tables::Deviation;
use device_stack::profibus::DiagnosisBits;
use encoder_profile::encoder::{Hardware, RedZone, Scaling};
use reference_devices::models::datalogic_amt58::red_zone::{is_inside, zone};

/// The bugs of the red zone.
pub static BUGS: &[Deviation] = bugs! {
    "red-zone-from-zero" "Positions in the red zone count from 0 and end before the end of the range."
        => |d| d.measuring.scale(Scaling::position);
    "red-zone-of-wrong-size" "The number of turns in the red zone is computed with one revolution less than the range has."
        => |d| d.measuring.scale(|scaling, hardware, place| {
            let revolutions = (scaling.range / scaling.units_per_revolution.max(1)).saturating_sub(1).max(1);
            let left = u128::from(hardware.revolutions % revolutions * scaling.units_per_revolution);
            with_zone(scaling, hardware, place, left)
        });
    "red-zone-in-hardware-steps" "The start of the red zone is computed as if a unit were a hardware step."
        => |d| d.measuring.scale(|scaling, hardware, place| {
            let begins = hardware.range() - hardware.range() % scaling.range.max(1);
            if place >= begins {
                counted_from_the_end(scaling, hardware, place)
            } else {
                scaling.position(hardware, place)
            }
        });
    "red-zone-subtracted-once" "The range is subtracted from the range of the hardware at most twice."
        => |d| d.measuring.scale(|scaling, hardware, place| {
            let (all, range) = (zone(scaling, hardware).0, u128::from(scaling.range.max(1)));
            with_zone(scaling, hardware, place, all - (all / range).min(2) * range)
        });
    "red-zone-one-late" "The jump comes one hardware step late."
        => |d| d.measuring.scale(|scaling, hardware, place| {
            let before = place.checked_sub(1).map(|before| is_inside(scaling, hardware, before));
            match before {
                Some(false) if is_inside(scaling, hardware, place) => scaling.position(hardware, place),
                _ => position(scaling, hardware, place),
            }
        });
    "red-zone-forward-only" "When the zone is left backward over its inner border, the position continues without a jump for the next 100 steps."
        => |d| d.measuring.slip(forward_only);
    "jump-at-every-section" "The position jumps at the end of every whole range, not only at the border of the zone."
        => |d| d.measuring.scale(|scaling, hardware, place| {
            let (_, zone) = zone(scaling, hardware);
            let (units, range) = (scaling.units(hardware, place), u128::from(scaling.range.max(1)));
            if units < range || zone == 0 {
                position(scaling, hardware, place)
            } else {
                ((units + range - zone) % range) as u64
            }
        });
    "fractional-revolutions-cut-off" "The number of revolutions of the range is truncated to a whole number before it is checked."
        => |d| d.measuring.scale(|scaling, hardware, place| {
            if (scaling.range / scaling.units_per_revolution.max(1)).is_power_of_two() {
                scaling.position(hardware, place)
            } else {
                position(scaling, hardware, place)
            }
        });
    "red-zone-moves-with-preset" "The zone begins where the position including the offset reaches its border, not the position of the shaft."
        => |d| d.measuring.slip(moves_with_preset);
    "red-zone-raises-diagnosis" "In the red zone Ext_Diag is 1 and the alarms are 01h."
        => |d| d.amt58.diagnosis(|view, octets, bits| if view.is_in_zone {
            patch(octets, ALARMS, &[1]);
            DiagnosisBits { ext_diag: true, ..bits }
        } else {
            bits
        });
};

fn position(scaling: &Scaling, hardware: &Hardware, place: u64) -> u64 {
    RedZone::ToTheEnd.position(scaling, hardware, place)
}

/// The position counted so that the last one before the physical zero is the last of the range.
fn counted_from_the_end(scaling: &Scaling, hardware: &Hardware, place: u64) -> u64 {
    let units = scaling.units(hardware, place) as i128;
    (units - zone(scaling, hardware).0 as i128).rem_euclid(i128::from(scaling.range.max(1))) as u64
}

/// The position with a red zone of `of` units.
fn with_zone(scaling: &Scaling, hardware: &Hardware, place: u64, of: u128) -> u64 {
    if scaling.units(hardware, place) >= zone(scaling, hardware).0 - of {
        counted_from_the_end(scaling, hardware, place)
    } else {
        scaling.position(hardware, place)
    }
}

fn forward_only(step: &ShaftStep) -> i64 {
    let (scaling, hardware) = (&step.settings.scaling, &step.hardware);
    let Some((before, _)) = step.before else { return 0 };
    if is_inside(scaling, hardware, step.now) {
        return 0;
    }
    let is_near = is_inside(scaling, hardware, (step.now + 100).min(hardware.range() - 1));
    let goes_on = step.slip != 0 || is_inside(scaling, hardware, before) && step.movement() < 0;
    if is_near && goes_on {
        counted_from_the_end(scaling, hardware, step.now) as i64 - position(scaling, hardware, step.now) as i64
    } else {
        0
    }
}

/// Counts as if the shaft were at the position including the offset.
fn moves_with_preset(step: &ShaftStep) -> i64 {
    let (scaling, hardware) = (&step.settings.scaling, &step.hardware);
    let (all, zone) = zone(scaling, hardware);
    let range = u128::from(scaling.range.max(1));
    let moved = (scaling.units(hardware, step.now) + u128::from(step.offset)) % all.max(1);
    let shown = if zone > 0 && moved >= all - zone { (range + moved).saturating_sub(all) } else { moved % range };
    shown as i64 - step.offset as i64 - position(scaling, hardware, step.now) as i64
}
