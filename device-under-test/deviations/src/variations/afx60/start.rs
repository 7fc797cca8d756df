//! The start-up records, the push-button and the preset.

use crate::needs::Need;
use crate::seams::Deviations;
use crate::tables::Group;
use alloc::rc::Rc;
use core::cell::Cell;
use core::time::Duration;
use device_stack::profinet::RecordRefusal;
use encoder_profile::hooks::EncoderView;
use encoder_profile::profidrive::user_parameters::UserParameterData;
use reference_devices::manuals;
use reference_devices::models::sick::hooks::SickCheck;
use reference_devices::models::sick_afx60::hooks::Afx60Check;

/// The variations.
pub const GROUP: Group = Group {
    needs: &[Need::Of(&manuals::SICK_AFX60)],
    deviations: permitted! {
        "invalid-start-parameters-refused" "A start-up record with a value beyond its limits is refused."
            "5.3.1, Table 42, and 5.4.1, Table 45 bit 1: indicated; whether the record is refused is not printed"
            => |d| invalid_start_parameters_refused(d);
        "alarm-switch-refused-in-v41-mode" "A start-up record that switches the alarm channel off without compatibility mode is refused."
            "3.6.5: it can only be deactivated in compatibility mode; the reaction is not printed"
            => |d| d.encoder.write_record(|_, access, octets| {
                let user = octets.as_ref().ok().filter(|_| access.index == USER_PARAMETERS).and_then(|octets| UserParameterData::parse(octets));
                if user.is_some_and(|user| !user.compatible && !user.alarm_channel) { Err(RecordRefusal::InvalidParameter) } else { octets }
            });
        "button-held-for-half-a-second" "The push-button makes a preset if it was held for at least 500 ms."
            "3.6.2 and 4.2 do not print how long to press the button for a preset"
            => |d| d.sick.check(|check, right| match check {
                SickCheck::ButtonPresets(held) => right && held >= Duration::from_millis(500),
                _ => right,
            });
        "preset-beyond-the-range-is-reduced" "A preset beyond the range is reported, and executed with the value reduced to the range."
            "5.4.1, Table 45 bit 4: a warning; whether the position changes is not printed"
            => |d| preset_beyond_the_range_is_reduced(d);
    },
};

/// Record index of the user parameters.
const USER_PARAMETERS: u16 = 0xBF00;
/// Record index of the vendor's start-up parameters.
const VENDOR_PARAMETERS: u16 = 0x1000;
/// Bit of S_STAT_B for an invalid preset.
const INVALID_PRESET: u64 = 1 << 4;

fn invalid_start_parameters_refused(d: &mut Deviations) {
    d.encoder.write_record(|view, access, octets| {
        let Ok(octets) = octets else { return octets };
        let is_right = match access.index {
            USER_PARAMETERS => UserParameterData::parse(&octets).is_none_or(|user| fits(view, &user)),
            VENDOR_PARAMETERS => vendor_fits(&octets),
            _ => true,
        };
        if is_right { Ok(octets) } else { Err(RecordRefusal::InvalidParameter) }
    });
}

/// Whether the scaling, if it is on, is within the limits of its single values.
fn fits(view: &EncoderView<'_>, user: &UserParameterData) -> bool {
    let is_on = user.class_4 && user.scaling;
    !is_on
        || (1..=view.hardware.steps_per_revolution).contains(&user.units_per_revolution)
            && (1..=1 << 30).contains(&user.range)
}

/// Whether interval, number of measurements, nominator and divisor are within their limits.
fn vendor_fits(octets: &[u8]) -> bool {
    let word =
        |at: usize| octets.get(at..at + 4).map_or(0, |word| word.iter().fold(0, |sum, one| sum << 8 | u32::from(*one)));
    let octet = |at: usize| octets.get(at).copied().unwrap_or(0);
    (1..=100).contains(&octet(3))
        && (1..=200).contains(&octet(4))
        && (1..=2048).contains(&word(5))
        && (1..=65535).contains(&word(9))
}

fn preset_beyond_the_range_is_reduced(d: &mut Deviations) {
    let is_reduced = Rc::new(Cell::new(false));
    let (executed, lit, started) = (is_reduced.clone(), is_reduced.clone(), is_reduced.clone());
    d.afx60.check(move |check, right| match check {
        Afx60Check::PresetValue { value, range, .. } => {
            executed.set(value >= range);
            true
        }
        _ => right,
    });
    d.encoder.starts(move |_| started.set(false));
    d.encoder
        .element(move |_, at, right| if at == (1001, 1) && is_reduced.get() { right | INVALID_PRESET } else { right });
    d.encoder
        .led(move |lamp, right| if (lamp.name, right) == ("encoder", "green") && lit.get() { "orange" } else { right });
}
