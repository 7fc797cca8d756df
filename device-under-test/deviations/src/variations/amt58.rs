//! What the manual of the AMT58 leaves free.

use super::amt58_state::{RefusedOnLeds, SentValues};
use crate::needs::Need;
use crate::tables::Group;
use crate::tables::amt58::diagnosis::{ALARMS, extend, patch};
use crate::tables::amt58::offset_state::LateWrites;
use crate::tables::amt58::values::{set_velocity, velocity, velocity_by};
use core::time::Duration;
use device_stack::profibus::DiagnosisBits;
use encoder_profile::encoder::velocity::MeasuredWay;
use encoder_profile::encoder::{CountingDirection, Hardware, Sampling, Scaling};
use reference_devices::manuals::{DATALOGIC_AMT58, DP_ENCODER};
use reference_devices::models::datalogic_amt58::hooks::Amt58Check;
use reference_devices::models::datalogic_amt58::preset::{CYCLES, TRIGGER, VALUE};
use reference_devices::models::datalogic_amt58::scaling::SentScaling;
use reference_devices::models::datalogic_amt58::set_prm::{
    CLASS_2, COUNTS, EXTENDED, OCTETS, OPERATING, RESOLUTION, VELOCITY, has, number,
};

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::OfEither(&DATALOGIC_AMT58, &DP_ENCODER)],
        deviations: permitted! {
            // Presets
            "preset-in-the-first-cycle-shown-in-the-third" "A preset is made in the first cycle with bit 31; answers have the inputs of two cycles before."
                "section 6.6: bit 31 for three cycles, and a table in which the third answer has the value; it may be two cycles old"
                => |d| {
                    d.amt58.preset_cycles(|cycles, _| cycles == 1);
                    d.slave.inputs_old(2);
                };
            "preset-while-its-bit-is-set" "From the third cycle on, each cycle with bit 31 makes the preset again, so that the position stands still."
                "section 6.6, preset mode: with bit 31 at 1 the value is accepted as a preset; it says nothing of an edge"
                => |d| d.amt58.preset_cycles(|cycles, right| right || cycles > CYCLES);
            "excessive-preset-reduced" "A preset value at or beyond the range is reduced modulo the range and carried out."
                "section 6.6 limits the preset value, and is silent about the reaction to a higher one"
                => |d| d.amt58.outputs(|view, outputs| outputs & TRIGGER | reduced(outputs & VALUE, view.measuring.range()));
            "excessive-preset-reduced-up-to-the-hardware" "A preset value beyond the range, but below the hardware resolution, is reduced modulo the range and carried out."
                "section 6.6 limits the preset value, and is silent about the reaction to a higher one"
                => |d| d.amt58.outputs(|view, outputs| if u64::from(outputs & VALUE) < view.hardware.range() {
                    outputs & TRIGGER | reduced(outputs & VALUE, view.measuring.range())
                } else {
                    outputs
                });

            // Offset in the diagnosis
            "offset-with-the-opposite-sign" "The diagnosis shows the number that is subtracted from the position of the sensor."
                "section 6.7, Offset: neither sign nor format is printed"
                => |d| extend(d, |view, octets| patch(octets, 31, &(-view.offset as i32).to_be_bytes()));
            "offset-modulo-the-range" "The diagnosis shows the offset without a sign, reduced to the range."
                "section 6.7, Offset: neither sign nor format is printed"
                => |d| extend(d, |view, octets| patch(octets, 31, &(view.measuring.offset as u32).to_be_bytes()));

            // Diagnosis
            "memory-alarm-supported" "The supported alarms announce the memory error, which then is an alarm with Ext_Diag."
                "section 6.7 prints no list of supported alarms; the encoder profile has bit 4 for a memory error"
                => |d| d.amt58.diagnosis(|view, octets, bits| {
                    patch(octets, 17, &[0, 0x10]);
                    if view.is_unreadable {
                        patch(octets, ALARMS, &[0x10]);
                    }
                    DiagnosisBits { ext_diag: bits.ext_diag || view.is_unreadable, ..bits }
                });
            "operating-time-not-supported" "The operating time is FFFFFFFFh, as the encoder profile has it for a device that does not count it."
                "section 6.7, Operating time: no unit and no value; encoder profile, operating time"
                => |d| extend(d, |_, octets| patch(octets, 27, &[0xFF; 4]));
            "operating-time-counted" "The operating time is 1234."
                "section 6.7, Operating time: no unit and no value"
                => |d| extend(d, |_, octets| patch(octets, 27, &1234_u32.to_be_bytes()));
            "serial-number-in-text" "The serial number is ten digits."
                "section 6.7, Serial number: no format and no value"
                => |d| extend(d, |_, octets| patch(octets, 47, b"0123456789"));
            "manufacturer-offset-not-0" "The manufacturer offset is 00001000h."
                "section 6.7, Manufacturer offset value: no value"
                => |d| extend(d, |_, octets| patch(octets, 35, &[0, 0, 0x10, 0]));
            "software-of-another-version" "The software version is 0103h."
                "section 6.7, Software version: no value; the dump of section 5.2 is that of one device"
                => |d| extend(d, |_, octets| patch(octets, 25, &[1, 3]));

            // Parameters
            "reserved-bits-refused" "A reserved bit of byte 10 results in Prm_Fault in Class 2."
                "section 6.4.1: the bits are reserved; the manual is silent about a reserved bit at 1"
                => |d| d.amt58.user_octets(|_, user, right| {
                    right && (!has(operating(user), CLASS_2) || operating(user) & RESERVED_BITS == 0)
                });
            "impossible-scaling-on-leds-only" "An impossible scaling is no Prm_Fault: the LEDs show it, and the position is in hardware steps."
                "sections 6.4.2 and 6.4.3, warnings: an error that the LEDs show; the reaction on the bus is not printed"
                => |d| d.amt58.add(RefusedOnLeds::default());

            // Positions and velocity
            "scaled-position-rounded" "The scaled position is rounded to the nearest step instead of down."
                "sections 6.4.2 and 6.4.3: how a position between two steps is rounded is not printed"
                => |d| d.measuring.position(|at, right| match rounded_up(&at.scaling, &at.hardware, at.place) {
                    Some(place) => at.settings.red_zone.position(&at.scaling, &at.hardware, place),
                    None => right,
                });
            "reversed-position-from-the-range" "With code sequence 1 a position is the range minus the clockwise one, and not one less."
                "section 6.4.1, Code sequence: which position an angle has after a reversal is not printed"
                => |d| d.measuring.position(|at, right| match at.settings.direction {
                    CountingDirection::Counterclockwise => (right + 1) % at.scaling.range.max(1),
                    CountingDirection::Clockwise => right,
                });
            "speed-in-hardware-steps" "The velocity in steps per second counts hardware steps although scaling is on."
                "section 6.4.4: steps per second; which steps is not printed"
                => |d| velocity_by(d, |view| Scaling::hardware(&view.hardware));
            "speed-without-sign" "The velocity has no sign."
                "section 6.6, Position and velocity values: the format of the velocity is not printed"
                => |d| d.amt58.inputs(|_, inputs| set_velocity(inputs, velocity(inputs).wrapping_abs()));
            "speed-every-5-ms" "The velocity is measured every 5 ms."
                "section 6.6, Position and velocity values: the time of a measurement is not printed"
                => |d| d.velocity.sampling(|_, _| Sampling::once(Duration::from_millis(5)));
            "speed-every-200-ms" "The velocity is measured every 200 ms."
                "section 6.6, Position and velocity values: the time of a measurement is not printed"
                => |d| d.velocity.sampling(|_, _| Sampling::once(Duration::from_millis(200)));
            "speed-filtered" "The velocity is the mean of the last eight measurements, that is of 400 ms."
                "section 6.6, Position and velocity values: the time of a measurement is not printed"
                => |d| d.velocity.sampling(|_, _| Sampling { interval: Duration::from_millis(50), count: 8 });
        },
    },
    // Only the manual of the AMT58 speaks of these; the plain encoder keeps to one of the readings.
    Group {
        needs: &[Need::Of(&DATALOGIC_AMT58)],
        deviations: permitted! {
            "offset-stored-after-500-ms" "The offset of a preset is in the memory 500 ms after the preset."
                "section 6.6, note: saved immediately after receipt; how long the memory takes is not printed"
                => |d| d.amt58.add(LateWrites::after(Duration::from_millis(500)));
            "steps-as-in-the-dump" "262144 steps per revolution are shown as 00 00 04 00."
                "section 5.2, dump: 00 00 04 00; section 6.4.3: 262144"
                => |d| extend(d, |view, octets| {
                    if view.hardware.steps_per_revolution == DUMPED {
                        patch(octets, 10, &[0, 0, 4, 0]);
                    }
                    if view.parameters.scaling.units_per_revolution == DUMPED {
                        patch(octets, 39, &[0, 0, 4, 0]);
                    }
                });
            "sent-values-shown-without-scaling" "With scaling off bytes 39 to 46 are the values of Set_Prm."
                "section 6.7, Programmed resolution: which one with scaling off is not printed"
                => |d| d.amt58.add(SentValues::default());
            "no-user-bytes-are-the-defaults" "A Set_Prm without user bytes is accepted, and the encoder works in hardware steps, clockwise."
                "the manual is silent about a Set_Prm of another length; section 6.4 was looked at"
                => |d| d.slave.parameters(|parameters| if parameters.user.is_empty() {
                    parameters.user.resize(OCTETS, 0);
                });
            "bits-of-class-2-refused-in-class-1" "In Class 1 the bits for the extended diagnosis and the velocity result in Prm_Fault."
                "section 6.4.1: max. = 0 for Class 1, without a reaction to 1"
                => |d| d.amt58.user_octets(|_, user, right| {
                    right && (has(operating(user), CLASS_2) || operating(user) & (EXTENDED | VELOCITY) == 0)
                });
            "unknown-unit-is-rpm" "A velocity unit above 1 is accepted, and the velocity is in rpm."
                "section 6.4.4: max. = 1, without a reaction to a higher number"
                => |d| d.amt58.check(|_, check, right| right || matches!(check, Amt58Check::Unit(_)));
            "turn-checked-before-clamping" "The range is compared with one revolution before the counts are limited to those of the hardware."
                "sections 6.4.2 and 6.4.3: values are limited and checked; in which order is not printed"
                => |d| d.amt58.scaling(|of, right| right && of.sent.range >= of.sent.units_per_revolution);
            "values-checked-without-scaling" "Counts per revolution and total resolution are checked although scaling is off."
                "section 6.4.1, warning: the values may be sent; whether they are checked is not printed"
                => |d| d.amt58.user_octets(|view, user, right| {
                    let sent = SentScaling::new(number(user, COUNTS), number(user, RESOLUTION), &view.hardware);
                    right && (!has(operating(user), CLASS_2) || sent.is_possible())
                });
            "lock-of-the-address-refused" "A Set_Slave_Address with a lock byte other than 0 changes nothing."
                "section 6.8, byte 3: 0, not supported; the reaction to another number is not printed"
                => |d| d.slave.set_slave_address(|request| if request.no_change != 0 {
                    request.ident = !request.ident;
                });
            "speed-clockwise-positive" "The velocity is positive clockwise, whatever the code sequence."
                "section 6.6, Position and velocity values: the sign of the velocity is not printed"
                => |d| d.velocity.velocity(|way, _| MeasuredWay { direction: CountingDirection::Clockwise, ..*way }.velocity());
        },
    },
];

/// The steps per revolution of the device whose diagnosis the manual prints.
const DUMPED: u64 = 262_144;
/// Reserved bits of the operating parameters in Class 2 (6.4.1).
const RESERVED_BITS: u8 = 0x34;

fn operating(user: &[u8]) -> u8 {
    user.get(OPERATING).copied().unwrap_or_default()
}

fn reduced(value: u32, range: u64) -> u32 {
    (u64::from(value) % range.max(1)) as u32
}

/// The place of the next step, if `place` is in the upper half of its step.
fn rounded_up(scaling: &Scaling, hardware: &Hardware, place: u64) -> Option<u64> {
    let (units, steps) = (u128::from(scaling.units_per_revolution.max(1)), u128::from(hardware.steps_per_revolution));
    let product = u128::from(place) * units;
    let nearest = (product + steps / 2) / steps;
    let next = (nearest > product / steps).then(|| (nearest * steps).div_ceil(units))?;
    Some((next % u128::from(hardware.range())) as u64)
}
