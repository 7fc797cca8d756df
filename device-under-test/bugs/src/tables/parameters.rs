//! Bugs of the contents of parameters.

use super::Group;
use crate::needs::Need;
use encoder_profile::hooks::{EncoderHooks, EncoderView, RetainedEncoderData};
use wire::profidrive::ParameterFormat;

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[
    // P922
    Group {
        needs: &[Need::Parameter(922)],
        deviations: bugs! {
            "p922-always-81" "P922 always reads 81, whatever the telegram."
                => |d| d.encoder.element(|_, at, right| if at == (922, 0) { 81 } else { right });
            "p922-as-bcd" "P922 contains the telegram number in BCD."
                => |d| d.encoder.element(|_, at, right| if at == (922, 0) { ((right / 10) << 4) | (right % 10) } else { right });
        },
    },
    // Identification: P964, P975
    Group {
        needs: &[Need::Parameter(964)],
        deviations: bugs! {
            "software-version-of-another-device" "P964 and P975 contain another software version than I&M0."
                => |d| d.encoder.element(|_, at, right| if let (964 | 975, 2) = at { right + 8 } else { right });
            "software-versions-differ" "Version, year and day of the software in P975 are those of an older version."
                => |d| d.encoder.element(|_, at, right| if let (975, 2..=4) = at { right - 1 } else { right });
            "month-before-day" "The month of the software comes before its day."
                => |d| d.encoder.element(|_, at, right| if let (964 | 975, 4) = at { right % 100 * 100 + right / 100 } else { right });
            "identification-cut-short" "P964 ends after five elements, P975 after six."
                => |d| {
                    d.encoder.truncate_elements(964, 5);
                    d.encoder.truncate_elements(975, 6);
                };
            "type-class-axis" "P975 contains the type class of an axis."
                => |d| d.encoder.element(|_, at, right| if at == (975, 5) { 1 } else { right });
        },
    },
    // Identification on PROFINET, and P965
    Group {
        needs: &[Need::Profinet, Need::Parameter(964)],
        deviations: bugs! {
            "vendor-id-swapped" "The bytes of the vendor ID are swapped in P964 and P975."
                => |d| d.encoder.element(|_, at, right| if let (964 | 975, 0) = at { u64::from((right as u16).swap_bytes()) } else { right });
            "vendor-of-the-stack" "P975 contains the vendor ID of the PROFINET stack."
                => |d| d.encoder.element(|_, at, right| if at == (975, 0) { 0x0106 } else { right });
            "unit-types-wrong" "P964 contains 0 as the type and P975 the number of the encoder interface."
                => |d| d.encoder.element(|_, at, right| match at { (964, 1) => 0, (975, 1) => 5, _ => right });
            "year-of-two-digits" "The year of the software has two digits."
                => |d| d.encoder.element(|_, at, right| if let (964 | 975, 3) = at { right % 100 } else { right });
            "no-drive-objects" "P964 contains 0 as the number of drive objects."
                => |d| d.encoder.element(|_, at, right| if at == (964, 5) { 0 } else { right });
            "profile-number-3" "P965 contains the profile number of PROFIdrive, 3."
                => |d| d.encoder.element(|_, at, right| if at == (965, 0) { upper_octet(right, 3) } else { right });
            "profile-version-constant" "P965 contains version 41 even in compatibility mode."
                => |d| d.encoder.element(profile_version_constant);
            "subclass-follows-class-4" "P975 announces class 3 while class 4 is off."
                => |d| d.encoder.element(|view, at, right| if at == (975, 6) && !view.user.class_4 { 0x4000 } else { right });
            "drive-object-0" "P975 contains 0 as the number of the drive object."
                => |d| d.encoder.element(|_, at, right| if at == (975, 7) { 0 } else { right });
        },
    },
    // Sensor format: P979
    Group {
        needs: &[Need::Parameter(979)],
        deviations: bugs! {
            "p979-of-16-bits" "The elements of P979 have 16 bits."
                => |d| d.encoder.format(979, ParameterFormat::WORD);
            "p979-header-0" "The header of P979 is 0."
                => |d| d.encoder.element(|_, at, right| if at == (979, 0) { 0 } else { right });
            "linear-scale" "P979 describes a linear scale."
                => |d| d.encoder.element(|_, at, right| if at == (979, 1) { right | 1 } else { right });
            "steps-for-revolutions" "P979 contains the steps of all revolutions instead of the number of revolutions."
                => |d| d.encoder.element(|view, at, right| if at == (979, 5) { view.hardware.range() } else { right });
        },
    },
    // Sensor format where there are several variants
    Group {
        needs: &[Need::Profinet, Need::Parameter(979)],
        deviations: bugs! {
            "sensor-format-of-the-other-variant" "P979 contains the resolution and revolutions of the other variant."
                => |d| d.encoder.element(sensor_format_of_the_other_variant);
            "shift-factors-11" "P979 contains shift factors of 11 bits."
                => |d| d.encoder.element(|_, at, right| if let (979, 3 | 4) = at { 11 } else { right });
        },
    },
    // List of numbers: P980
    Group {
        needs: &[Need::Parameter(980)],
        deviations: bugs! {
            "number-list-misses-one" "P980 leaves out P65001."
                => |d| d.encoder.parameter(|_, number, mut parameter| {
                    parameter.values.truncate(parameter.values.len() - usize::from(number == 980));
                    parameter
                });
            "number-list-ends-with-ffff" "P980 ends with an element FFFFh."
                => |d| d.encoder.parameter(|_, number, mut parameter| {
                    if number == 980 {
                        parameter.values.push(0xFFFF);
                    }
                    parameter
                });
            "number-list-of-another-device" "P980 lists wrong parameter numbers."
                => |d| d.encoder.element(|_, at, right| if at.0 == 980 { right + 1 } else { right });
        },
    },
    // Transfer to memory: P971
    Group {
        needs: &[Need::Parameter(971)],
        deviations: bugs! {
            "p971-requires-ffff" "A save is started by FFFFh instead of 1."
                => |d| d.encoder.value(971, |value| u64::from(value == 0xFFFF));
        },
    },
    // IP address: P61001
    Group {
        needs: &[Need::Parameter(61001)],
        deviations: bugs! {
            "ip-bytes-reversed" "The bytes of the IP address in P61001 are in reverse order."
                => |d| d.encoder.element(|_, at, right| if at == (61001, 0) { u64::from((right as u32).swap_bytes()) } else { right });
            "old-address-shown" "P61001 contains the IP address from before the last assignment."
                => |d| d.encoder.add(AddressBefore::default());
        },
    },
    // Preset value, P65000, and the operating status, P65001
    Group {
        needs: &[Need::EncoderProfile],
        deviations: bugs! {
            "parameter-of-16-bits" "Only the lower 16 bits of P65000 are used."
                => |d| d.encoder.value(65000, |value| value & 0xFFFF);
            "operating-status-header-wrong" "The header of P65001 contains a wrong number of elements."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 0) { right ^ 0x0007_0000 } else { right });
            "preset-value-for-offset" "P65001 shows the preset value instead of the offset."
                => |d| d.encoder.element(|view, at, right| if at == (65001, 8) { view.preset_value.into() } else { right });
            "configured-scaling-always-shown" "P65001 shows the configured scaling although scaling is off."
                => |d| d.encoder.element(configured_scaling_always_shown);
            "speed-unit-shown-0" "P65001 always shows the velocity unit as 0."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 11) { 0 } else { right });
        },
    },
    // Operating status of the encoder profile: P65001
    Group {
        needs: &[Need::Parameter(65001)],
        deviations: bugs! {
            "operating-status-cut-short" "P65001 has no velocity unit."
                => |d| d.encoder.truncate_elements(65001, 11);
            "operating-status-0" "P65001 shows all settings as 0."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 1) { 0 } else { right });
            "code-sequence-not-shown" "P65001 always shows the code sequence as clockwise."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 1) { right & !0x01 } else { right });
            "class-4-always-shown" "P65001 always shows class 4 as on."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 1) { right | 0x02 } else { right });
            "preset-control-shown-inverted" "P65001 shows G1_XIST1 preset control inverted."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 1) { right ^ 0x04 } else { right });
            "scaling-always-shown" "P65001 always shows scaling as on."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 1) { right | 0x08 } else { right });
            "alarm-channel-not-shown" "P65001 always shows the alarm channel as off."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 1) { right & !0x10 } else { right });
            "compatibility-shown-inverted" "P65001 shows compatibility mode inverted."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 1) { right ^ 0x20 } else { right });
            "unused-status-bits-random" "Bits 6 and 7 of the operating status change at random."
                => |d| d.encoder.element(|view, at, right| if at == (65001, 1) { right | (((view.now.as_nanos() / 1_000_000) & 3) << 6) } else { right });
            "speed-unit-in-status" "The reserved bits of the operating status contain the velocity unit."
                => |d| d.encoder.element(|view, at, right| if at == (65001, 1) { right | u64::from(view.user.speed_unit) << 8 } else { right });
            "internal-fault-numbers" "The upper byte of the faults in P65001 contains an internal fault number."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 2) { right | right << 20 } else { right });
            "supported-faults-0" "P65001 announces no supported faults."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 3) { 0 } else { right });
            "supported-faults-of-the-profile" "P65001 announces the faults of the profile as supported."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 3) { right | 0x0F } else { right });
            "warnings-of-another-family" "P65001 announces warnings as supported and shows the temperature warning."
                => |d| d.encoder.element(|_, at, right| match at { (65001, 4) => 0x02, (65001, 5) => 0x3F, _ => right });
            "status-version-follows-mode" "P65001 contains profile version 3.1 in compatibility mode."
                => |d| d.encoder.element(|view, at, right| if at == (65001, 6) && view.user.compatible { 0x301 } else { right });
            "operating-time-in-milliseconds" "P65001 counts the operating time in milliseconds."
                => |d| d.encoder.element(|view, at, right| if at == (65001, 7) { view.now.as_nanos() / 1_000_000 } else { right });
            "range-shown-for-units" "P65001 shows the total range in place of the units per revolution."
                => |d| d.encoder.element(|view, at, right| if at == (65001, 9) { view.positions } else { right });
            "operating-time-counts" "P65001 counts the operating time in tenths of an hour."
                => |d| d.encoder.element(|view, at, right| if at == (65001, 7) { view.now.as_nanos() / 360_000_000_000 } else { right });
            "offset-shown-from-power-up" "P65001 shows the offset that was in memory at power-up."
                => |d| d.encoder.add(OffsetOfPowerUp::default());
            "range-in-revolutions" "P65001 shows the total range as a number of revolutions."
                => |d| d.encoder.element(range_in_revolutions);
        },
    },
];

/// Sets the profile number in P965, which has two bytes in some manuals and one word in others.
fn upper_octet(right: u64, profile: u64) -> u64 {
    if right > 0xFF { profile << 8 | right & 0xFF } else { profile }
}

fn profile_version_constant(_: &EncoderView<'_>, at: (u16, usize), right: u64) -> u64 {
    match at {
        (965, 0) if right > 0xFF => right & 0xFF00 | 41,
        (965, 1) => 41,
        _ => right,
    }
}

fn sensor_format_of_the_other_variant(view: &EncoderView<'_>, at: (u16, usize), right: u64) -> u64 {
    match at {
        (979, 2) => view.other_hardware.steps_per_revolution,
        (979, 5) => view.other_hardware.revolutions,
        _ => right,
    }
}

/// Returns the scaling of the record in place of the one in force.
pub fn configured_scaling_always_shown(view: &EncoderView<'_>, at: (u16, usize), right: u64) -> u64 {
    match at {
        (65001, 9) => view.user.units_per_revolution,
        (65001, 10) => view.user.range,
        _ => right,
    }
}

fn range_in_revolutions(view: &EncoderView<'_>, at: (u16, usize), right: u64) -> u64 {
    match at {
        (65001, 10) => right / view.measuring.settings.scaling.units_per_revolution.max(1),
        _ => right,
    }
}

/// Shows the offset that was restored at the last power-up.
#[derive(Default)]
struct OffsetOfPowerUp {
    offset: u64,
}

impl EncoderHooks for OffsetOfPowerUp {
    fn load(&mut self, _: &EncoderView<'_>, retained: RetainedEncoderData) -> RetainedEncoderData {
        self.offset = retained.offset;
        retained
    }

    fn element(&mut self, _: &EncoderView<'_>, at: (u16, usize), right: u64) -> u64 {
        if at == (65001, 8) { self.offset } else { right }
    }
}

/// Shows the IP address before the last assignment since power-up.
#[derive(Default)]
struct AddressBefore {
    current: [u8; 4],
    before: [u8; 4],
}

impl AddressBefore {
    fn note(&mut self, ip: [u8; 4]) {
        if ip != self.current {
            self.before = core::mem::replace(&mut self.current, ip);
        }
    }
}

impl EncoderHooks for AddressBefore {
    fn load(&mut self, _: &EncoderView<'_>, retained: RetainedEncoderData) -> RetainedEncoderData {
        (self.current, self.before) = (retained.station.ip, [0; 4]);
        retained
    }

    fn starts(&mut self, view: &EncoderView<'_>) {
        self.note(view.station.ip);
    }

    fn element(&mut self, view: &EncoderView<'_>, at: (u16, usize), right: u64) -> u64 {
        self.note(view.station.ip);
        if at == (61001, 0) { u32::from_be_bytes(self.before).into() } else { right }
    }
}
