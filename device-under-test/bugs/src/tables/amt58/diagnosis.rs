//! Bugs of the extended diagnosis, the bytes after the first six. Bytes are counted from 0, including the first six.

use crate::seams::Deviations;
use crate::tables::Deviation;
use alloc::vec::Vec;
use device_stack::profibus::DiagnosisBits;
use reference_devices::models::datalogic_amt58::hooks::{Amt58Check, Amt58Hooks, Amt58View};

/// The bugs of the diagnosis.
pub static BUGS: &[Deviation] = bugs! {
    // Form
    "header-without-itself" "The header counts only the bytes after it."
        => |d| extend(d, |_, octets| change(octets, HEADER, |header| header - 1));
    "header-of-the-whole" "The header counts the whole diagnosis."
        => |d| extend(d, |_, octets| change(octets, HEADER, |header| header + 6));
    "reduced-diagnosis-differs" "In the reduced diagnosis bytes 14 and 15 are 0."
        => |d| extend(d, |view, octets| if !view.parameters.is_extended {
            patch(octets, 14, &[0, 0]);
        });
    "diagnosis-shifted-by-one" "In the extended diagnosis everything from byte 21 on is shifted by one byte; byte 21 is FFh."
        => |d| extend(d, |_, octets| shift(octets, 21, 62));

    // Operating status
    "type-change-alters-the-class" "In the extended diagnosis the scaling bit in byte 8 is 0."
        => |d| extend(d, |view, octets| if view.parameters.is_extended {
            change(octets, STATUS, |status| status & !0x08);
        });
    "operating-status-constant" "Byte 8 is always CAh, whatever the operating parameters."
        => |d| extend(d, |_, octets| patch(octets, STATUS, &[0xCA]));
    "velocity-bit-not-in-status" "Bit 7 of byte 8 is 0."
        => |d| extend(d, |_, octets| change(octets, STATUS, |status| status & !0x80));
    "type-bit-not-in-status" "Bit 6 of byte 8 is 0."
        => |d| extend(d, |_, octets| change(octets, STATUS, |status| status & !0x40));
    "scaling-bit-not-in-status" "Bit 3 of byte 8 is 0."
        => |d| extend(d, |_, octets| change(octets, STATUS, |status| status & !0x08));
    "code-sequence-not-in-status" "Bit 0 of byte 8 is 0."
        => |d| extend(d, |_, octets| change(octets, STATUS, |status| status & !0x01));
    "class-not-in-status" "Bit 1 of byte 8 is 1 even in Class 1."
        => |d| extend(d, |_, octets| change(octets, STATUS, |status| status | 0x02));
    "class-2-not-in-status" "Bit 1 of byte 8 is 0 even in Class 2."
        => |d| extend(d, |_, octets| change(octets, STATUS, |status| status & !0x02));
    "velocity-class-reduced" "In Class 2 with velocity bytes 6 and 8 are those of Class 2, so that bit 7 of byte 8 is 0."
        => |d| extend(d, |view, octets| if view.parameters.has_velocity {
            change(octets, STATUS, |status| status & !0x80);
        });

    // Hardware
    "type-of-the-other-variant" "The encoder type is that of the other variant."
        => |d| extend(d, |_, octets| change(octets, 9, |kind| kind ^ 1));
    "hardware-steps-scaled" "Bytes 10 to 13 report the programmed counts per revolution."
        => |d| extend(d, |view, octets| {
            patch(octets, 10, &(view.parameters.scaling.units_per_revolution as u32).to_be_bytes());
        });
    "hardware-revolutions-0" "The singleturn encoder reports 0 revolutions, the multiturn encoder 1."
        => |d| extend(d, |view, octets| patch(octets, 14, &[0, u8::from(view.hardware.revolutions > 1)]));
    "hardware-revolutions-4096" "The multiturn encoder reports 4096 revolutions."
        => |d| extend(d, |view, octets| if view.hardware.revolutions > 1 {
            patch(octets, 14, &[0x10, 0]);
        });

    // Alarms and warnings
    "alarms-uninitialised" "Without an alarm the alarm byte is A5h."
        => |d| extend(d, |_, octets| patch(octets, ALARMS, &[0xA5]));
    "additional-alarms-uninitialised" "Without an alarm the additional alarm byte is A5h."
        => |d| extend(d, |_, octets| patch(octets, 16, &[0xA5]));
    "warnings-uninitialised" "Without a warning the warnings are A5A5h."
        => |d| extend(d, |_, octets| patch(octets, 19, &[0xA5, 0xA5]));
    "announced-alarm-not-raised" "The supported alarms announce the memory error, but a memory error does not raise the alarm."
        => |d| extend(d, |_, octets| patch(octets, 17, &[0, 0x10]));
    "unannounced-alarm-raised" "A memory error raises alarm bit 4 and Ext_Diag, although the supported alarms are 0."
        => |d| d.amt58.diagnosis(|view, octets, bits| if view.is_unreadable {
            patch(octets, ALARMS, &[0x10]);
            DiagnosisBits { ext_diag: true, ..bits }
        } else {
            bits
        });

    // Other fields of the extended diagnosis
    "software-version-changes" "The software version counts the power-ups."
        => |d| d.amt58.add(PowerUps { count: 0, change: |octets, count| patch(octets, 25, &(2 + count).to_be_bytes()) });
    "operating-time-counts-down" "The operating time is less after each power-up."
        => |d| d.amt58.add(PowerUps { count: 0, change: |octets, count| patch(octets, 27, &(1000 - u32::from(count)).to_be_bytes()) });
    "offset-field-shifted" "The offset is in bytes 30 to 33; byte 34 is FFh."
        => |d| extend(d, |view, octets| {
            patch(octets, 30, &(view.offset as i32).to_be_bytes());
            patch(octets, 34, &[0xFF]);
        });
    "preset-in-manufacturer-offset" "The manufacturer offset is the preset offset."
        => |d| extend(d, |view, octets| patch(octets, 35, &(view.offset as i32).to_be_bytes()));
    "programmed-steps-of-hardware" "Bytes 39 to 42 report the counts per revolution of the hardware."
        => |d| extend(d, |view, octets| {
            patch(octets, 39, &(view.hardware.steps_per_revolution as u32).to_be_bytes());
        });
    "programmed-range-of-hardware" "Bytes 43 to 46 report the total resolution of the hardware."
        => |d| extend(d, |view, octets| patch(octets, 43, &(view.hardware.range() as u32).to_be_bytes()));
    "programmed-words-swapped" "The two words of the programmed total resolution are swapped."
        => |d| extend(d, |view, octets| {
            patch(octets, 43, &(view.parameters.scaling.range as u32).rotate_left(16).to_be_bytes());
        });
    "programmed-values-0-without-scaling" "With scaling off bytes 39 to 46 are 0."
        => |d| extend(d, |view, octets| if !view.parameters.scales {
            patch(octets, 39, &[0; 8]);
        });
    "serial-number-shifted" "After power-up the serial number is shifted by one byte; its first byte is FFh."
        => |d| d.amt58.add(PowerUps { count: 0, change: |octets, count| if count > 0 {
            shift(octets, 47, 56);
        } });
    "preset-in-serial-number" "The last four bytes of the serial number are the last preset value."
        => |d| d.amt58.add(LastPreset(0));
    "reserved-bytes-left-over" "The reserved bytes contain data of an earlier telegram."
        => |d| extend(d, |_, octets| patch(octets, 57, &[1, 2, 3, 4, 5, 6]));
};

const HEADER: usize = 6;
/// Where the alarms are.
pub const ALARMS: usize = 7;
const STATUS: usize = 8;

/// Changes the extended diagnosis, the bytes after the first six.
pub fn extend(d: &mut Deviations, change: impl Fn(&Amt58View<'_>, &mut Vec<u8>) + 'static) {
    d.amt58.diagnosis(move |view, octets, bits| {
        change(view, octets);
        bits
    });
}

/// Writes `values` from byte `at` on, if the diagnosis is that long.
pub fn patch(octets: &mut [u8], at: usize, values: &[u8]) {
    if let Some(field) = octets.get_mut(at - HEADER..at - HEADER + values.len()) {
        field.copy_from_slice(values);
    }
}

fn change(octets: &mut [u8], at: usize, by: fn(u8) -> u8) {
    if let Some(octet) = octets.get_mut(at - HEADER) {
        *octet = by(*octet);
    }
}

/// Shifts bytes `from` to `to` by one; the last one is dropped and the first one becomes FFh.
fn shift(octets: &mut Vec<u8>, from: usize, to: usize) {
    if octets.len() > to - HEADER {
        octets.remove(to - HEADER);
        octets.insert(from - HEADER, 0xFF);
    }
}

/// Changes the diagnosis, given the number of power-ups.
struct PowerUps {
    count: u16,
    change: fn(&mut Vec<u8>, u16),
}

impl Amt58Hooks for PowerUps {
    fn load(&mut self, _: &Amt58View<'_>, offset: i64) -> i64 {
        self.count = self.count.saturating_add(1);
        offset
    }

    fn diagnosis(&mut self, _: &Amt58View<'_>, octets: &mut Vec<u8>, bits: DiagnosisBits) -> DiagnosisBits {
        (self.change)(octets, self.count);
        bits
    }
}

/// Puts the value of the last preset since power-up into the serial number.
struct LastPreset(u32);

impl Amt58Hooks for LastPreset {
    fn check(&mut self, _: &Amt58View<'_>, check: Amt58Check<'_>, verdict: bool) -> bool {
        if let (Amt58Check::PresetValue(value), true) = (check, verdict) {
            self.0 = value as u32;
        }
        verdict
    }

    fn load(&mut self, _: &Amt58View<'_>, offset: i64) -> i64 {
        self.0 = 0;
        offset
    }

    fn diagnosis(&mut self, _: &Amt58View<'_>, octets: &mut Vec<u8>, bits: DiagnosisBits) -> DiagnosisBits {
        patch(octets, 53, &self.0.to_be_bytes());
        bits
    }
}
