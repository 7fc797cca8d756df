//! Bugs of settings and their limits: speed calculation, temperature, supply, round axis.

use super::Group;
use super::service::status_words;
use super::signals::put;
use super::start::{PARAMETER_ACCESS, USER_PARAMETERS, are_single_limits_kept, unscaled};
use super::unrequested_presets::takes_writes;
use crate::needs::Need;
use crate::seams::Deviations;
use crate::seams::stack::rename;
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::Cell;
use core::time::Duration;
use device_stack::profinet::{RecordAccess, RecordRefusal};
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder::measuring::PositionBasis;
use encoder_profile::encoder::{CountingDirection, Gear, Hardware, MeasuringSettings, Sampling, Scaling};
use encoder_profile::hooks::{EncoderView, RecordOctets};
use encoder_profile::profidrive::sensor::SensorError;
use encoder_profile::profidrive::telegram::InputSignal;
use encoder_profile::profidrive::user_parameters::UserParameterData;
use reference_devices::manuals;
use reference_devices::models::sick::axis::CountedLaps;
use reference_devices::models::sick::hooks;
use reference_devices::models::sick_afx60::StartRecordFields;
use reference_devices::models::sick_afx60::hooks::{self as afx60, Afx60Event};
use wire::profinet::dcp::DcpValue;

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Of(&manuals::SICK_AFX60)],
        deviations: bugs! {
            // Values of settings
            "highest-setting-refused" "The highest permitted value of a setting is refused."
                => |d| d.sick.setting(|at, value, right| right && !highest(at).contains(&value));
            "settings-not-kept" "A write to a setting is acknowledged but has no effect."
                => |d| d.sick.settings(|_, _, before, written| written.copy_from_slice(before));
            "settings-not-checked" "A setting accepts any value."
                => |d| d.sick.setting(|_, _, _| true);
            "settings-clipped" "A value that only the wider of two printed ranges permits is clipped to the narrower range."
                => |d| {
                    d.sick.setting(|at, value, right| right || at == (1005, 2) && (1..=100).contains(&value));
                    d.sick.written(settings_clipped);
                };
            "undefined-choice-taken" "The mode of the round axis and the velocity unit accept any value."
                => |d| d.sick.setting(|at, _, right| right || matches!(at, (1009, 0) | (1005, 1)));
            "limits-clip-values" "A temperature or supply limit beyond its permitted range is clipped and acknowledged."
                => |d| {
                    d.sick.setting(|at, _, right| right || matches!(at.0, 1006 | 1007));
                    d.sick.written(|at, value, _| match at {
                        (1006, 0) => value.clamp(-40, 80),
                        (1006, _) => value.clamp(-20, 120),
                        (1007, 0) => value.clamp(9000, 24_000),
                        (1007, _) => value.clamp(10_000, 30_000),
                        _ => value,
                    });
                };
            "speed-limits-exchanged" "A lowest speed above the highest speed is swapped with it."
                => |d| d.sick.settings(|number, _, _, written| {
                    if let (1005, [.., highest, lowest]) = (number, written)
                        && lowest > highest
                    {
                        core::mem::swap(highest, lowest);
                    }
                });
            "temperature-limits-in-kelvin" "P1006 contains its limits in kelvin."
                => |d| d.encoder.element(|_, at, right| if at.0 == 1006 { right + 273 } else { right });
            "voltage-limits-in-volts" "P1007 contains its limits in volts."
                => |d| d.encoder.element(|_, at, right| if at.0 == 1007 { right / 1000 } else { right });

            // Round axis
            "round-axis-breaks-singleturn" "The round axis can be switched on in the singleturn encoder, and the position is then 0."
                => |d| {
                    d.afx60.set(afx60::Afx60Check::HasRoundAxis, true);
                    // The round axis of an encoder without one has a single position.
                    d.sick_axis.gear(|_, hardware, gear| match hardware.revolutions {
                        1 => Gear { nominator: 1, divisor: 1, range: 1 },
                        _ => gear,
                    });
                };
            "round-axis-outputs-of-delivery" "P1009 contains the factory nominator and divisor instead of those in use."
                => |d| d.encoder.element(|_, at, right| match at { (1009, 6) => 2048, (1009, 7) => 1, _ => right });
            "round-axis-outputs-written" "The outputs of P1009 can be written."
                => |d| takes_writes(d, 1009, 5);
            "fraction-as-remainder" "P1009 contains a remainder instead of the digits after the decimal point."
                => |d| d.encoder.element(fraction_as_remainder);

            "ninth-in-whole-steps" "The range of the round axis is rounded to a whole number of hardware steps."
                => |d| d.measuring.gear(in_whole_steps);
            "odd-ranges-refused" "An odd range of the round axis is invalid."
                => |d| d.sick.axis_range(|range, _, right| right && range.is_multiple_of(2));
            "resolution-scales-round-axis" "The position of the round axis is multiplied by the units per revolution."
                => |d| d.sick_axis.gear(|user, _, gear| Gear {
                    divisor: gear.divisor * user.units_per_revolution.clamp(1, 1 << 18),
                    nominator: gear.nominator * 1000,
                    ..gear
                });
            "round-axis-range-not-checked" "Any range of the round axis is accepted silently."
                => |d| d.sick.axis_range(|_, _, _| true);
            "fraction-clipped" "A nominator above 1024 counts as 1024, a divisor above 32767 as 32767."
                => |d| fraction_clipped(d);
            "divisor-0-accepted" "A nominator or divisor of 0 in the record of the start counts as 1."
                => |d| d.afx60.start_record(|fields| StartRecordFields { nominator: fields.nominator.max(1), divisor: fields.divisor.max(1), ..fields });
            "default-fraction-4096" "The factory nominator is 4096."
                => |d| d.encoder.element(|_, at, right| if matches!(at, (1009, 1 | 6)) && right == 2048 { 4096 } else { right });
            "round-axis-jumps-at-the-physical-zero" "The position of the round axis is computed without laps and jumps at the physical zero."
                => |d| d.measuring.position(without_laps);
            "steps-rounded-up" "The steps per revolution in P1009 are rounded up."
                => |d| d.encoder.element(steps_rounded_up);
            "round-axis-mode-from-0" "P1009 reads 0 for off and 1 for on."
                => |d| d.encoder.element(|_, at, right| if at == (1009, 0) { right - 1 } else { right });
            "round-axis-on-with-each-write" "A write to P1009 switches the round axis on, whatever the mode is."
                => |d| round_axis_on_with_each_write(d);
            "code-sequence-not-of-round-axis" "The code sequence has no effect on the round axis."
                => |d| d.telegram.acts_on(|signal, _, settings| match settings.gear {
                    Some(_) if signal != InputSignal::NistB => MeasuringSettings { direction: CountingDirection::Clockwise, ..settings },
                    _ => settings,
                });
            "round-axis-without-shift" "With the round axis G1_XIST1 is not shifted."
                => |d| d.encoder.signal(|of, octets| if of.signal == InputSignal::G1Xist1 && of.view.measuring.settings.gear.is_some() { put(octets, of.image.g1_xist1) });

            // Start
            "vendor-record-ignored" "The vendor record is ignored."
                => |d| d.afx60.start_record(|_| StartRecordFields::WITHOUT);
            "save-mode-always-auto" "The preset value is saved with each change."
                => |d| d.afx60.start_record(|fields| StartRecordFields { save_mode: 0, ..fields });
            "filter-settings-ignored" "Interval and number of measurements of the start are ignored."
                => |d| d.afx60.start_record(|fields| StartRecordFields { interval: 2, measurements: 10, ..fields });
            "filter-not-checked" "Any interval and number of measurements is accepted."
                => |d| {
                    d.afx60.start_record(|fields| StartRecordFields { interval: fields.interval.max(1), measurements: fields.measurements.max(1), ..fields });
                    d.afx60.check(|check, right| match check {
                        afx60::Afx60Check::StartRecord(fields) => right || fields.interval > 100 || fields.measurements > 200,
                        _ => right,
                    });
                };
            "factory-record-refused" "A record with the full range of the hardware is refused."
                => |d| d.encoder.write_record(factory_record_refused);
            "default-range-of-another-model" "Without scaling a revolution has 8192 units and the range 33554432."
                => |d| d.start.settings(|user, _, right| unscaled(user, right, Scaling { units_per_revolution: 8192, range: 33_554_432 }));
            "preset-control-lost-with-class-4" "After a connection with class 4 off, presets do not act on G1_XIST1 in the next connection."
                => |d| d.encoder.user_parameters(|view, user| UserParameterData { preset_acts_on_xist1: user.preset_acts_on_xist1 && view.user.class_4, ..user });
            "parameters-need-class-4" "With class 4 off parameter requests are refused."
                => |d| d.encoder.write_record(|view, access, octets| if access.index == PARAMETER_ACCESS && !view.user.class_4 {
                    Err(RecordRefusal::StateConflict)
                } else {
                    octets
                });
            "velocity-needs-class-4" "With class 4 off the velocity is 0."
                => |d| d.checks.check(|check, right| right && !matches!(check, EncoderCheck::VelocityIsMeasured(user) if !user.class_4));
            "wrong-value-clipped" "Units and range above their limits are clipped to the limits."
                => |d| d.encoder.user_parameters(wrong_value_clipped);

            // Limits of the speed
            "unit-4-ignored" "Unit 4 is accepted, but the velocity stays in the previous unit."
                => |d| unit_4_ignored(d);
            "two-speed-units" "P1005 always contains unit 3, whatever the unit of the start-up."
                => |d| d.encoder.element(|_, at, right| if at == (1005, 1) { 3 } else { right });
            "averaging-window-in-measurements" "The averaging window has one millisecond per measurement."
                => |d| d.velocity.sampling(|_, right| Sampling { interval: Duration::from_millis(1), ..right });
            "window-clipped-to-100" "More than 100 measurements count as 100."
                => |d| d.velocity.sampling(|_, right| Sampling { count: right.count.min(100), ..right });
            "speed-mode-ignored" "The velocity is calculated regardless of the mode in P1005."
                => |d| d.afx60.set(afx60::Afx60Check::VelocityIsCalculated, true);
            "speed-limit-in-output-unit" "The highest speed is compared with the velocity in the current unit instead of rpm."
                => |d| d.afx60.check(|check, right| match check {
                    afx60::Afx60Check::TooFast(speeds) => speeds.shown.abs() > speeds.highest,
                    _ => right,
                });
            "lowest-speed-never-checked" "The lowest speed is not monitored."
                => |d| d.afx60.check(|check, right| right && !matches!(check, afx60::Afx60Check::TooSlow(_)));
            "lowest-speed-0-warns" "A lowest speed of 0 raises the warning at standstill."
                => |d| d.afx60.check(|check, right| match check {
                    afx60::Afx60Check::TooSlow(speeds) => right || speeds.lowest == 0 && speeds.rpm == 0,
                    _ => right,
                });
            "low-speed-is-a-frequency-warning" "A speed that is too low raises the frequency warning."
                => |d| status_words(d, |_, [a, b, c]| [a, b | a & SPEED_OUTSIDE, c]);

            // Limits of temperature and supply
            "temperature-limits-not-checked" "The temperature limits are always -40 and 120 degrees Celsius."
                => |d| d.afx60.check(|check, right| match check {
                    afx60::Afx60Check::TemperatureIsOutside(celsius, _) => !(-40.0..=120.0).contains(&celsius),
                    _ => right,
                });
            "low-temperature-not-noticed" "The lower temperature limit is not monitored."
                => |d| d.afx60.check(|check, right| match check {
                    afx60::Afx60Check::TemperatureIsOutside(celsius, [_, upper]) => celsius > upper,
                    _ => right,
                });
            "voltage-limits-not-checked" "The supply limits are always 9 V and 30 V."
                => |d| d.afx60.check(|check, right| match check {
                    afx60::Afx60Check::Undervoltage(millivolts, _) => millivolts < 9000,
                    afx60::Afx60Check::Overvoltage(millivolts, _) => millivolts > 30_000,
                    _ => right,
                });
            "undervoltage-at-ten-volts" "A supply voltage of 10 V or less is always undervoltage."
                => |d| d.afx60.check(|check, right| match check {
                    afx60::Afx60Check::Undervoltage(millivolts, _) => millivolts <= 10_000,
                    _ => right,
                });
            "undervoltage-until-power-off" "The undervoltage error stays until power-off."
                => |d| undervoltage_until_power_off(d);
        },
    },
    Group {
        needs: &[Need::OfEither(&manuals::SICK_AFX60, &manuals::SICK_A3M60)],
        deviations: bugs! {
            // Round axis
            "round-axis-cut-short" "P1009 has ten elements."
                => |d| d.encoder.truncate_elements(1009, 10);
            "range-offset-lost" "The laps of the round axis are lost at power-off."
                => |d| {
                    d.sick.laps_loaded(|_, laps| CountedLaps { laps: 0, ..laps });
                    d.afx60.at_event(Afx60Event::PowerUp, |_, mut retained| {
                        retained.axis.base = 0;
                        retained
                    });
                };

            "nominator-and-divisor-exchanged" "Nominator and divisor are swapped in the calculation of the position."
                => |d| d.sick_axis.gear(|_, _, gear| Gear { nominator: gear.divisor, divisor: gear.nominator, ..gear });
            "revolutions-rounded" "The fraction of revolutions is rounded to a whole number."
                => |d| d.sick_axis.gear(revolutions_rounded);
            "round-axis-left-out" "The round axis has no effect on the position, although P1009 shows it."
                => |d| d.sick.set(hooks::SickCheck::RoundAxis, false);
            "rule-of-powers-stays" "The range of the round axis has to be 2^n times the resolution."
                => |d| d.sick.axis_range(|range, units, right| right && has_power_of_two(range, units));

            // Limits of the speed
            "velocity-not-averaged" "The velocity is the last measurement instead of the mean."
                => |d| d.velocity.sampling(|_, right| Sampling { count: 1, ..right });
        },
    },
    Group {
        needs: &[Need::EncoderProfile],
        deviations: bugs! {
            // Start
            "one-unit-refused" "One unit per revolution and a range of 1 are refused."
                => |d| d.checks.serves(|user, _, right| right && user.units_per_revolution != 1 && user.range != 1);
        },
    },
    Group {
        needs: &[Need::Profinet, Need::EncoderProfile],
        deviations: bugs! {
            // Start
            "ratios-above-2048-refused" "A range of more than 2048 revolutions is refused."
                => |d| d.checks.serves(|user, _, right| right && user.range / user.units_per_revolution.max(1) <= 2048);
            "other-ratios-accepted" "A range that is not 2^n revolutions is accepted."
                => |d| d.checks.serves(|user, hardware, right| right || are_single_limits_kept(user, hardware, 1));
        },
    },
    Group {
        needs: &[Need::Profinet],
        deviations: bugs! {
            // Start
            "vendor-of-the-stack-in-get" "DCP Get reports the vendor ID of a sample application."
                => |d| d.stack.get_response(|value| if let DcpValue::DeviceId { vendor_id, .. } = value { *vendor_id = 0x002A });
            "device-id-swapped-in-get" "DCP Get reports the device ID with its bytes swapped."
                => |d| d.stack.get_response(|value| if let DcpValue::DeviceId { device_id, .. } = value { *device_id = device_id.swap_bytes() });
            "name-hidden-from-get" "DCP Get and LLDP report an empty name."
                => |d| {
                d.stack.get_response(|value| if let DcpValue::NameOfStation(name) = value { name.clear() });
                d.stack.lldp(|lldp| {
                    rename(lldp, b"");
                    true
                });
            };
        },
    },
];

fn round_axis_on_with_each_write(d: &mut Deviations) {
    let is_written = Rc::new(Cell::new(false));
    let (written, started) = (is_written.clone(), is_written.clone());
    d.encoder.starts(move |_| started.set(false));
    d.encoder.written(move |_, (number, _), values| {
        written.set(written.get() || number == 1009);
        values
    });
    d.sick.check(move |check, right| right || check == hooks::SickCheck::RoundAxis && is_written.get());
}

/// Bit of S_STAT_A for a speed beyond its limits, and the same bit of S_STAT_B for the frequency.
const SPEED_OUTSIDE: u16 = 1 << 5;

/// Returns the highest values of a setting. If two ranges are printed, it is that of the narrower one.
fn highest(at: (u16, usize)) -> &'static [i64] {
    match at {
        (1005, 0) => &[1],
        (1005, 1) => &[4],
        (1005, 2) => &[2, 50],
        (1005, 3) => &[100],
        (1005, 4) => &[10_000],
        (1005, 5) => &[9000],
        (1006, 0) => &[80],
        (1006, 1) => &[120],
        (1007, 0) => &[24_000],
        (1007, 1) => &[30_000],
        (1009, 0) => &[2],
        (1009, 1) => &[2048],
        (1009, 2) => &[65535],
        (1009, 3) => &[1 << 30],
        _ => &[],
    }
}

fn settings_clipped(at: (u16, usize), value: i64, hardware: &Hardware) -> i64 {
    match (at, value) {
        ((1005, 2), 1..=100) if hardware.revolutions == 1 => 2,
        ((1005, 2), 51..=100) => 50,
        ((1005, 3), 101..=200) => 100,
        ((1009, 1), 2049..=0x1_0000) => 2048,
        ((1009, 2), 0x1_0000) => 65535,
        _ => value,
    }
}

fn fraction_clipped(d: &mut Deviations) {
    d.sick.setting(|at, value, right| right || matches!(at, (1009, 1 | 2)) && value > 0);
    d.sick.written(|at, value, _| match at {
        (1009, 1) => value.min(1024),
        (1009, 2) => value.min(32767),
        _ => value,
    });
    // Values beyond the printed limits are still refused.
    d.afx60.start_record(|fields| StartRecordFields {
        nominator: if fields.nominator <= 2048 { fields.nominator.min(1024) } else { fields.nominator },
        divisor: if fields.divisor <= 65535 { fields.divisor.min(32767) } else { fields.divisor },
        ..fields
    });
}

/// Shows unit 4 after a write, but the previous unit stays in force.
fn unit_4_ignored(d: &mut Deviations) {
    let is_shown = Rc::new(Cell::new(false));
    let (tracked, cleared) = (is_shown.clone(), is_shown.clone());
    d.sick.settings(move |number, _, before, written| {
        if number == 1005 && written[1] != before[1] {
            tracked.set(written[1] == 4);
            written[1] = if written[1] == 4 { before[1] } else { written[1] };
        }
    });
    d.afx60.kept(move |event, _, retained| {
        cleared.set(cleared.get() && event != Afx60Event::Start);
        retained
    });
    d.encoder.element(move |_, at, right| match at {
        (1005, 1) | (65001, 11) if is_shown.get() => 4,
        _ => right,
    });
}

fn undervoltage_until_power_off(d: &mut Deviations) {
    let stays = Rc::new(Cell::new(false));
    let (tracked, cleared) = (stays.clone(), stays.clone());
    d.afx60.check(move |check, right| match check {
        afx60::Afx60Check::Restarts => {
            tracked.set(tracked.get() || right);
            false
        }
        _ => right,
    });
    d.afx60.kept(move |event, _, retained| {
        cleared.set(cleared.get() && event != Afx60Event::PowerUp);
        retained
    });
    d.encoder.causes(move |view, causes| if stays.get() { with_cause(view, causes, 0x1003) } else { causes });
}

/// Adds the error with this code to the causes.
pub(super) fn with_cause(view: &EncoderView<'_>, mut causes: Vec<SensorError>, code: u16) -> Vec<SensorError> {
    let number = view.facts.errors.iter().position(|error| error.code == Some(code)).unwrap_or(0) as u16;
    let error = SensorError { number, code: Some(code) };
    if !causes.contains(&error) {
        causes.push(error);
    }
    causes
}

fn fraction_as_remainder(view: &EncoderView<'_>, at: (u16, usize), right: u64) -> u64 {
    match (at, view.measuring.settings.gear) {
        ((1009, 10), Some(Gear { nominator, divisor, range })) => range * divisor % nominator.max(1),
        _ => right,
    }
}

fn revolutions_rounded(_: &UserParameterData, _: &Hardware, gear: Gear) -> Gear {
    let nominator = (gear.nominator + gear.divisor / 2) / gear.divisor.max(1);
    Gear { nominator: nominator.max(1), divisor: 1, ..gear }
}

fn in_whole_steps(gear: &Gear, hardware: &Hardware, place: i128) -> u64 {
    let steps = (hardware.steps_per_revolution * gear.nominator / gear.divisor.max(1)).max(1);
    let place = place.rem_euclid(steps.into()) as u128;
    (place * u128::from(gear.range) / u128::from(steps)) as u64
}

/// Returns the position of a round axis for a shaft position that wraps at the end of all revolutions.
pub fn without_laps(reading: &PositionBasis, right: u64) -> u64 {
    match reading.settings.gear {
        Some(gear) => {
            let range = i128::from(reading.hardware.range());
            let below_0 = if reading.settings.direction == CountingDirection::Clockwise { 0 } else { range };
            gear.position(&reading.hardware, reading.unwrapped.rem_euclid(range) - below_0)
        }
        None => right,
    }
}

fn has_power_of_two(range: u64, units: u64) -> bool {
    let units = units.max(1);
    range.is_multiple_of(units) && (range / units).is_power_of_two()
}

fn steps_rounded_up(view: &EncoderView<'_>, at: (u16, usize), right: u64) -> u64 {
    match (at, view.measuring.settings.gear) {
        ((1009, 9), Some(Gear { nominator, divisor, range })) => (range * divisor).div_ceil(nominator.max(1)),
        _ => right,
    }
}

fn wrong_value_clipped(_: &EncoderView<'_>, user: UserParameterData) -> UserParameterData {
    let units = user.units_per_revolution.min(1 << 18);
    let range = if user.range == user.units_per_revolution { units } else { user.range.min(1 << 30) };
    UserParameterData { units_per_revolution: units, range, ..user }
}

fn factory_record_refused(view: &EncoderView<'_>, access: &RecordAccess, octets: RecordOctets) -> RecordOctets {
    let user = octets.as_ref().ok().filter(|_| access.index == USER_PARAMETERS);
    match user.and_then(|octets| UserParameterData::parse(octets)) {
        Some(user) if user.range == view.hardware.range() => Err(RecordRefusal::InvalidParameter),
        _ => octets,
    }
}
