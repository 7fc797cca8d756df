//! Bugs of the scaling.

use crate::tables::Deviation;
use encoder_profile::encoder::{Hardware, Scaling};
use reference_devices::models::datalogic_amt58::knobs::has;
use reference_devices::models::datalogic_amt58::program::{
    self, CLASS_2, OPERATING, Program, SCALING, Scales, VELOCITY, is_possible,
};

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    // Whether it acts
    "scaling-bit-ignored" "In Class 2 scaling acts although it is off; a range of 0 stands for that of the hardware."
        => |b| (b.amt58.scales, b.amt58.clamped) = (|bits| has(bits, CLASS_2), zero_is_all);
    "scaling-bit-inverted" "Scaling acts when its bit is 0."
        => |b| b.amt58.scales = |bits| has(bits, CLASS_2) && !has(bits, SCALING);
    "scaling-without-class-2" "In Class 1 scaling acts if its bit is set."
        => |b| b.amt58.scales = |bits| has(bits, SCALING);
    "scaling-needs-velocity" "Scaling acts in Class 2 with velocity only."
        => |b| b.amt58.scales = |bits| has(bits, CLASS_2 | SCALING | VELOCITY);
    "scaling-lost-with-velocity" "In Class 2 with velocity the position is not scaled."
        => |b| b.amt58.scales = |bits| has(bits, CLASS_2 | SCALING) && !has(bits, VELOCITY);
    "scaling-remembered" "The first scaling that was taken stays in force in all later parameterisations, Class 1 included, and over a loss of power."
        => |b| b.amt58.in_force = |program, first| match first {
            Some(first) => Program { scaling: first.scaling, scales: first.scales, ..program },
            None => program,
        };
    "values-checked-without-scaling" "Counts per revolution and total resolution are looked at although scaling is off."
        => |b| b.amt58.checks_scaling = |_, octets| has(octets[OPERATING], CLASS_2);
    "units-and-range-little-endian" "Counts per revolution and total resolution are read least significant octet first."
        => |b| b.slave.parameters(|parameters| for at in [4, 8] {
            if let Some(number) = parameters.user.get_mut(at..at + 4) {
                number.reverse();
            }
        });

    // Limits
    "limits-of-the-other-variant" "The hardware resolution is that of the other variant, as the limits of the scaling are."
        => |b| b.amt58.hardware = |hardware| match hardware.revolutions {
            1 => Hardware { steps_per_revolution: 65_536, revolutions: 16_384 },
            _ => Hardware { steps_per_revolution: 262_144, revolutions: 1 },
        };
    "one-unit-refused" "One step per revolution is refused with Prm_Fault."
        => |b| b.amt58.takes_scaling = |of| right(of) && of.clamped.units_per_revolution > 1;
    "full-units-refused" "As many steps per revolution as the hardware has are refused with Prm_Fault."
        => |b| b.amt58.takes_scaling = |of| right(of) && of.clamped.units_per_revolution < of.hardware.steps_per_revolution;
    "full-range-refused" "The whole range of the hardware is refused with Prm_Fault."
        => |b| b.amt58.takes_scaling = |of| right(of) && of.clamped.range < of.hardware.range();
    "range-of-one-revolution-refused" "A range of one revolution is refused with Prm_Fault."
        => |b| b.amt58.takes_scaling = |of| right(of) && of.clamped.range != of.clamped.units_per_revolution;
    "too-large-units-refused" "Counts per revolution above those of the hardware are refused with Prm_Fault."
        => |b| b.amt58.takes_scaling = |of| right(of) && of.sent.units_per_revolution <= of.hardware.steps_per_revolution;
    "too-large-range-refused" "A total resolution above that of the hardware is refused with Prm_Fault."
        => |b| b.amt58.takes_scaling = |of| right(of) && of.sent.range <= of.hardware.range();
    "units-with-a-sign" "A number of the scaling with its highest bit set is taken for a negative one and refused."
        => |b| b.amt58.takes_scaling = |of| right(of) && of.sent.units_per_revolution.max(of.sent.range) <= i32::MAX as u64;
    "ratio-checked-before-clamping" "Whether the range is at least one revolution is looked at before the counts are forced to those of the hardware."
        => |b| b.amt58.takes_scaling = |of| right(of) && of.sent.range >= of.sent.units_per_revolution;
    "range-not-clamped" "A total resolution above that of the hardware is used and shown as it is."
        => |b| {
            b.amt58.clamped = |sent, hardware| Scaling { range: sent.range, ..program::clamped(sent, hardware) };
            b.amt58.takes_scaling = |of| is_possible(&program::clamped(of.sent, &of.hardware), &of.hardware);
        };
    "range-clamped-to-multiturn" "The singleturn encoder forces a total resolution to 1073741824 only, and takes more than one revolution."
        => |b| {
            b.amt58.clamped = |sent, hardware| {
                Scaling { range: sent.range.min(1 << 30), ..program::clamped(sent, hardware) }
            };
            b.amt58.takes_scaling = |of| is_possible(&of.clamped, &MULTITURN);
        };
    "impossible-scaling-accepted" "A total resolution of more revolutions than the hardware has is accepted."
        => |b| b.amt58.takes_scaling = |of| has_a_revolution(&of.clamped);
    "range-below-a-revolution-accepted" "A total resolution below the counts per revolution is accepted."
        => |b| b.amt58.takes_scaling = |of| right(of) || of.clamped.range > 0 && of.clamped.range < of.clamped.units_per_revolution;
    "zero-units-stop-the-device" "No counts per revolution stop the device until the supply goes off."
        => |b| b.amt58.stops_at = |sent| sent.units_per_revolution == 0;
    "zero-range-stops-the-device" "A total resolution of 0 stops the device until the supply goes off."
        => |b| b.amt58.stops_at = |sent| sent.range == 0;
    "ratio-cut-off" "The number of revolutions is rounded down before it is compared with that of the hardware."
        => |b| b.amt58.takes_scaling = |of| {
            has_a_revolution(&of.clamped) && of.clamped.range / of.clamped.units_per_revolution <= of.hardware.revolutions
        };
    "clamped-scaling-not-checked" "A scaling of which a value was forced to that of the hardware is not looked at any further."
        => |b| b.amt58.takes_scaling = |of| right(of) || of.sent != of.clamped;
    "revolutions-of-multiturn" "The singleturn encoder accepts up to 16384 revolutions."
        => |b| b.amt58.takes_scaling = |of| is_possible(&of.clamped, &MULTITURN);
    "check-overflows" "The number of revolutions is compared in numbers that are too short."
        => |b| b.amt58.takes_scaling = |of| {
            let most = of.clamped.units_per_revolution * of.hardware.revolutions;
            has_a_revolution(&of.clamped) && of.clamped.range % (1 << 20) <= most % (1 << 20)
        };
    "most-revolutions-refused" "As many revolutions as the hardware has are refused when the steps are scaled."
        => |b| b.amt58.takes_scaling = |of| {
            let Scaling { units_per_revolution: units, range } = of.clamped;
            right(of) && (units == of.hardware.steps_per_revolution || range < units * of.hardware.revolutions)
        };

    // Positions
    "range-as-mask" "The range is taken as the next power of two above it, so that the position runs up to that."
        => |b| b.measuring.range(|scaling, _, _| scaling.range.next_power_of_two());
    "scaled-position-rounded" "The scaled position is rounded to the nearest step instead of down."
        => |b| b.measuring.scale(|scaling, hardware, place| {
            let above = u128::from(place) * u128::from(scaling.units_per_revolution) * 2;
            let rounded = (above / u128::from(hardware.steps_per_revolution)).div_ceil(2);
            (rounded % u128::from(scaling.range.max(1))) as u64
        });
};

const MULTITURN: Hardware = Hardware { steps_per_revolution: 65_536, revolutions: 16_384 };

fn right(of: &Scales) -> bool {
    is_possible(&of.clamped, &of.hardware)
}

fn has_a_revolution(scaling: &Scaling) -> bool {
    scaling.units_per_revolution > 0 && scaling.range >= scaling.units_per_revolution
}

fn zero_is_all(sent: Scaling, hardware: &Hardware) -> Scaling {
    let range = if sent.range == 0 { hardware.range() } else { sent.range };
    let units = if sent.units_per_revolution == 0 { hardware.steps_per_revolution } else { sent.units_per_revolution };
    program::clamped(Scaling { units_per_revolution: units, range }, hardware)
}
