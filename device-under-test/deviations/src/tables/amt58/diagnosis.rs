//! Bugs of the octets behind the six of the diagnosis; they are counted from the first of the six.

use crate::tables::Deviation;
use alloc::vec::Vec;

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    // Form
    "header-without-itself" "The header counts the octets behind it."
        => |b| b.amt58.diagnosis = |_, octets, _| change(octets, HEADER, |header| header - 1);
    "header-of-the-whole" "The header counts the whole diagnosis."
        => |b| b.amt58.diagnosis = |_, octets, _| change(octets, HEADER, |header| header + 6);
    "reduced-diagnosis-differs" "In the reduced diagnosis octets 14 and 15 are 0."
        => |b| b.amt58.diagnosis = |told, octets, _| if !told.program.is_extended {
            patch(octets, 14, &[0, 0]);
        };
    "diagnosis-shifted-by-one" "In the extended diagnosis all from octet 21 on stands one octet later; octet 21 is FFh."
        => |b| b.amt58.diagnosis = |_, octets, _| shift(octets, 21, 62);

    // Operating status
    "type-change-alters-the-class" "With the extended diagnosis the bit of scaling in octet 8 is 0."
        => |b| b.amt58.diagnosis = |told, octets, _| if told.program.is_extended {
            change(octets, STATUS, |status| status & !0x08);
        };
    "operating-status-constant" "Octet 8 is CAh, whatever the operating parameters are."
        => |b| b.amt58.diagnosis = |_, octets, _| patch(octets, STATUS, &[0xCA]);
    "velocity-bit-not-in-status" "Bit 7 of octet 8 is 0."
        => |b| b.amt58.diagnosis = |_, octets, _| change(octets, STATUS, |status| status & !0x80);
    "type-bit-not-in-status" "Bit 6 of octet 8 is 0."
        => |b| b.amt58.diagnosis = |_, octets, _| change(octets, STATUS, |status| status & !0x40);
    "scaling-bit-not-in-status" "Bit 3 of octet 8 is 0."
        => |b| b.amt58.diagnosis = |_, octets, _| change(octets, STATUS, |status| status & !0x08);
    "code-sequence-not-in-status" "Bit 0 of octet 8 is 0."
        => |b| b.amt58.diagnosis = |_, octets, _| change(octets, STATUS, |status| status & !0x01);
    "class-not-in-status" "Bit 1 of octet 8 is 1 in Class 1 too."
        => |b| b.amt58.diagnosis = |_, octets, _| change(octets, STATUS, |status| status | 0x02);
    "class-2-not-in-status" "Bit 1 of octet 8 is 0 in Class 2 too."
        => |b| b.amt58.diagnosis = |_, octets, _| change(octets, STATUS, |status| status & !0x02);
    "velocity-class-reduced" "In Class 2 with velocity octets 6 and 8 are those of Class 2, so that bit 7 of octet 8 is 0."
        => |b| b.amt58.diagnosis = |told, octets, _| if told.program.has_velocity {
            change(octets, STATUS, |status| status & !0x80);
        };

    // Hardware
    "type-of-the-other-variant" "The type of the encoder is that of the other variant."
        => |b| b.amt58.diagnosis = |_, octets, _| change(octets, 9, |kind| kind ^ 1);
    "hardware-steps-scaled" "Octets 10 to 13 tell the programmed counts per revolution."
        => |b| b.amt58.diagnosis = |told, octets, _| {
            patch(octets, 10, &(told.program.scaling.units_per_revolution as u32).to_be_bytes());
        };
    "hardware-steps-of-the-dump" "Octets 10 to 13 tell 00 00 04 00, as the dump of the manual is printed."
        => |b| b.amt58.diagnosis = |_, octets, _| patch(octets, 10, &[0, 0, 4, 0]);
    "hardware-revolutions-0" "The singleturn encoder tells 0 revolutions, the multiturn encoder 1."
        => |b| b.amt58.diagnosis = |told, octets, _| patch(octets, 14, &[0, u8::from(told.hardware.revolutions > 1)]);
    "hardware-revolutions-4096" "The multiturn encoder tells 4096 revolutions."
        => |b| b.amt58.diagnosis = |told, octets, _| if told.hardware.revolutions > 1 {
            patch(octets, 14, &[0x10, 0]);
        };

    // Alarms and warnings
    "alarms-uninitialised" "The alarms are A5h without an alarm."
        => |b| b.amt58.diagnosis = |_, octets, _| patch(octets, ALARMS, &[0xA5]);
    "additional-alarms-uninitialised" "The additional alarms are A5h without an alarm."
        => |b| b.amt58.diagnosis = |_, octets, _| patch(octets, 16, &[0xA5]);
    "warnings-uninitialised" "The warnings are A5A5h without a warning."
        => |b| b.amt58.diagnosis = |_, octets, _| patch(octets, 19, &[0xA5, 0xA5]);
    "supported-alarms-of-the-profile" "The supported alarms are 0010h."
        => |b| b.amt58.diagnosis = |_, octets, _| patch(octets, 17, &[0, 0x10]);
    "announced-alarm-not-raised" "The supported alarms announce the memory error, and a memory error does not raise it."
        => |b| b.amt58.diagnosis = |_, octets, _| patch(octets, 17, &[0, 0x10]);
    "unannounced-alarm-raised" "A memory error raises alarm bit 4 and Ext_Diag, although the supported alarms are 0."
        => |b| b.amt58.diagnosis = |told, octets, bits| if told.is_unreadable {
            bits.ext_diag = true;
            patch(octets, ALARMS, &[0x10]);
        };

    // What the extended diagnosis has besides
    "software-version-changes" "The software version counts the power-ups."
        => |b| b.amt58.diagnosis = |told, octets, _| patch(octets, 25, &(2 + told.power_ups as u16).to_be_bytes());
    "operating-time-all-ones" "The operating time is FFFFFFFFh."
        => |b| b.amt58.diagnosis = |_, octets, _| patch(octets, 27, &[0xFF; 4]);
    "offset-field-shifted" "The offset stands in octets 30 to 33, octet 34 is FFh."
        => |b| b.amt58.diagnosis = |told, octets, _| {
            patch(octets, 30, &(told.offset as i32).to_be_bytes());
            patch(octets, 34, &[0xFF]);
        };
    "preset-in-manufacturer-offset" "The manufacturer's offset is the preset's."
        => |b| b.amt58.diagnosis = |told, octets, _| patch(octets, 35, &(told.offset as i32).to_be_bytes());
    "factory-offset-of-reset" "The manufacturer's offset is 00001000h."
        => |b| b.amt58.diagnosis = |_, octets, _| patch(octets, 35, &[0, 0, 0x10, 0]);
    "programmed-steps-of-hardware" "Octets 39 to 42 tell the counts per revolution of the hardware."
        => |b| b.amt58.diagnosis = |told, octets, _| {
            patch(octets, 39, &(told.hardware.steps_per_revolution as u32).to_be_bytes());
        };
    "programmed-range-of-hardware" "Octets 43 to 46 tell the total resolution of the hardware."
        => |b| b.amt58.diagnosis = |told, octets, _| patch(octets, 43, &(told.hardware.range() as u32).to_be_bytes());
    "programmed-words-swapped" "The two words of the programmed total resolution are swapped."
        => |b| b.amt58.diagnosis = |told, octets, _| {
            patch(octets, 43, &(told.program.scaling.range as u32).rotate_left(16).to_be_bytes());
        };
    "programmed-values-0-without-scaling" "With scaling off octets 39 to 46 are 0."
        => |b| b.amt58.diagnosis = |told, octets, _| if !told.program.scales {
            patch(octets, 39, &[0; 8]);
        };
    "serial-number-shifted" "After power-up the serial number stands one octet further, the first one being FFh."
        => |b| b.amt58.diagnosis = |told, octets, _| if told.power_ups > 0 {
            shift(octets, 47, 56);
        };
    "serial-number-uninitialised" "The serial number is FFh ten times."
        => |b| b.amt58.diagnosis = |_, octets, _| patch(octets, 47, &[0xFF; 10]);
    "preset-in-serial-number" "The last four octets of the serial number are the last preset value."
        => |b| b.amt58.diagnosis = |told, octets, _| patch(octets, 53, &told.last_preset.to_be_bytes());
    "reserved-octets-left-over" "The reserved octets hold what the last telegram left there."
        => |b| b.amt58.diagnosis = |_, octets, _| patch(octets, 57, &[1, 2, 3, 4, 5, 6]);
};

const HEADER: usize = 6;
const ALARMS: usize = 7;
const STATUS: usize = 8;

/// Puts `told` at octet `at`, if there are so many.
pub fn patch(octets: &mut [u8], at: usize, told: &[u8]) {
    if let Some(place) = octets.get_mut(at - HEADER..at - HEADER + told.len()) {
        place.copy_from_slice(told);
    }
}

fn change(octets: &mut [u8], at: usize, by: fn(u8) -> u8) {
    if let Some(octet) = octets.get_mut(at - HEADER) {
        *octet = by(*octet);
    }
}

/// Moves octets `from` to `to` one further; the last one is dropped and the first one is FFh.
fn shift(octets: &mut Vec<u8>, from: usize, to: usize) {
    if octets.len() > to - HEADER {
        octets.remove(to - HEADER);
        octets.insert(from - HEADER, 0xFF);
    }
}
