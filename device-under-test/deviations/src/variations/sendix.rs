//! What the manual of the Sendix 58xx leaves free.
//!
//! It prints few times (a preset takes up to 40 ms, the error LED up to 10 s, the velocity is calculated once per second), no rounding, and
//! rarely what happens to a request that it does not permit.

use super::requests::refuse_all;
use super::rounding::nearest_position;
use super::sendix_state::{
    EarlierPresets, HeldRequest, HeldVelocity, LateErrors, LateWarnings, ReadTwice, SettingsOfClass4,
    blocked_preset_is_acknowledged, both_presets, first_position_over_all_revolutions, invalid_record, is_record,
    limit_of_the_record, other_positions_go_on, relative_preset, reported, within_limits,
};
use crate::needs::Need;
use crate::tables::Group;
use crate::tables::signal_image::{ERROR, EXECUTED, PARKED, POSITION, has_error, has_position, is_parked};
use core::time::Duration;
use device_stack::profinet::RecordRefusal;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder::Scaling;
use encoder_profile::encoder::velocity::Sampling;
use encoder_profile::profidrive::telegram::SignalImage;
use reference_devices::manuals;
use wire::profidrive::{ErrorNumber, ParameterError, ParameterFormat, RequestId};

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[
    Group { needs: &[Need::Of(&manuals::KUEBLER_SENDIX58XX)], deviations: TIMES },
    Group { needs: &[Need::Of(&manuals::KUEBLER_SENDIX58XX)], deviations: MEASURED },
    Group { needs: &[Need::Of(&manuals::KUEBLER_SENDIX58XX)], deviations: PRESETS },
    Group { needs: &[Need::Of(&manuals::KUEBLER_SENDIX58XX)], deviations: SIGNALS },
    Group { needs: &[Need::Of(&manuals::KUEBLER_SENDIX58XX)], deviations: RECORDS },
];

/// When the encoder does what it does.
const TIMES: &[crate::tables::Deviation] = permitted! {
    "presets-in-40-ms" "A preset takes 40 ms."
        "sections 8.1 and 8.2: a preset takes up to 40 ms"
        => |d| d.encoder.offset_takes(|_| Duration::from_millis(40));
    "presets-at-once" "A preset is carried out in the cycle in which its request arrives."
        "sections 8.1 and 8.2: a preset takes up to 40 ms; no least time is printed"
        => |d| d.encoder.offset_takes(|_| Duration::ZERO);
    "preset-times-vary" "Each preset takes another time, from 1 ms to 39 ms."
        "sections 8.1 and 8.2: a preset takes up to 40 ms"
        => |d| {
            let mut times = [39, 13, 27, 5, 1].into_iter().cycle();
            d.encoder.offset_takes(move |takes| times.next().map_or(takes, Duration::from_millis));
        };
    "error-led-off-after-ten-seconds" "The error LED goes off 9.5 s after the start of data exchange."
        "section 4.3: it may take up to 10 s until the LED is off"
        => |d| d.encoder.led(|lit, right| match lit.exchanged_for {
            Some(time) if lit.name == "error" && lit.stack.has_supply && right == "dark" && time < Duration::from_millis(9500) => "red",
            _ => right,
        });
    "errors-late" "Errors of sensor and memory are reported 1.5 s after their cause appears or ends."
        "the manual is silent: sections 8.2 and 9.3 print no time for an error"
        => |d| d.encoder.add(LateErrors::new(Duration::from_millis(1500), |code| code != Some(0x1002)));
    "warnings-late" "Warnings are reported 1.5 s after their cause appears or ends."
        "the manual is silent: section 9.3 prints no time for a warning"
        => |d| d.encoder.add(LateWarnings::new(Duration::from_millis(1500)));
    "control-requested-after-100-ms" "Control Requested becomes 1 100 ms after the first data."
        "section 8.2, ZSW2_ENC: permanently 1 after the set-up of the link; no time is printed"
        => |d| d.encoder.image(|view, _, now| match view.exchanged_for {
            Some(time) if time < Duration::from_millis(100) => SignalImage { zsw2_enc: now.zsw2_enc & !0x0200, ..now },
            _ => now,
        });
    "life-sign-of-its-own-clock" "The sign of life counts milliseconds of a clock that is 200 ppm fast, and begins with 8."
        "section 8.2, ZSW2_ENC: it changes with every send clock of 1 ms; neither its first value nor the accuracy of a clock is printed"
        => |d| d.life_sign.count(|elapsed, _, _| 7 + (elapsed.as_nanos() as u64 + elapsed.as_nanos() as u64 / 5000) / 1_000_000);
};

/// What is measured, and how it is rounded.
const MEASURED: &[crate::tables::Deviation] = permitted! {
    "speed-truncated" "The velocity is truncated to an integer."
        "the manual is silent: section 7, Velocity Measuring Unit, prints no rounding"
        => |d| d.velocity.velocity(|way, _| way.fraction().0.checked_div(way.fraction().1).unwrap_or(0) as i64);
    "speed-rounded-up" "The velocity is rounded away from 0."
        "the manual is silent: section 7, Velocity Measuring Unit, prints no rounding"
        => |d| d.velocity.velocity(|way, _| {
            let (above, below) = way.fraction();
            ((above + above.signum() * (below - 1)) / below) as i64
        });
    "speed-of-the-last-100-ms" "The velocity is calculated once per second, from the last 100 ms."
        "section 7: calculated once per second; over which time the movement is measured is not printed"
        => |d| {
            d.velocity.sampling(|_, right| Sampling { interval: Duration::from_millis(100), ..right });
            d.encoder.add(HeldVelocity::default());
        };
    "speed-of-the-last-two-seconds" "The velocity is calculated once per second, from the last two seconds."
        "section 7: calculated once per second; over which time the movement is measured is not printed"
        => |d| d.velocity.sampling(|_, right| Sampling { count: 2, ..right });
    "positions-rounded-to-the-nearest" "A scaled position is the nearest one, not the one below."
        "the manual is silent: section 7, MUR and TMR, prints no rounding"
        => |d| d.measuring.scale(nearest_position);
    "speed-warning-from-9000-rpm" "The speed warning appears at 9000 rpm as measured, not above."
        "section 9.3: above 9000 rpm; the accuracy of the measurement is not printed"
        => |d| d.checks.check(|check, right| match check { EncoderCheck::TooFast(rpm) => rpm.abs() >= 9000, _ => right });
    "speed-warning-above-9005-rpm" "The speed is measured 5 rpm too low, so the warning appears above 9005 rpm."
        "section 9.3: above 9000 rpm; the accuracy of the measurement is not printed"
        => |d| d.checks.check(|check, right| match check { EncoderCheck::TooFast(rpm) => rpm.abs() > 9005, _ => right });
    "st-pos-one-cycle-old" "ST_POS is that of the cycle before."
        "the manual is silent: sections 8.4 and 8.5 promise no consistency across submodules"
        => |d| d.encoder.signals(|before, now| SignalImage {
            single_turn: if before.unhooked.good { before.unhooked.single_turn } else { now.single_turn },
            ..now
        });
    "mt-pos-one-cycle-old" "MT_POS is that of the cycle before."
        "the manual is silent: sections 8.4 and 8.5 promise no consistency across submodules"
        => |d| d.encoder.signals(|before, now| SignalImage {
            multi_turn: if before.unhooked.good { before.unhooked.multi_turn } else { now.multi_turn },
            ..now
        });
};

/// Presets and what the manual does not permit.
const PRESETS: &[crate::tables::Deviation] = permitted! {
    "reserved-preset-bits-limit" "A preset word with bits 28 to 30 set has a value beyond the range, which is limited."
        "section 8.1: the table gives bits 30 to 0 as the value, the details give bits 27 to 0"
        => |d| d.trigger.value(|word, range, right| if word >> 28 & 7 == 0 { right } else { range - 1 });
    "reserved-preset-bits-block" "A preset word with bits 28 to 30 set triggers nothing."
        "the manual is silent: section 8.1 requires these bits to be 0 and prints no reaction"
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::TriggersPreset { now, .. } => right && now >> 28 & 7 == 0,
            _ => right,
        });
    "held-request-needs-a-new-edge" "A request that was set without Control by PLC is not executed when control is granted."
        "the manual is silent: section 8.2 does not say where the edge of bit 12 is detected"
        => |d| d.encoder.add(HeldRequest::default());
    "relative-preset-stops-at-the-end" "A relative preset beyond the range ends at 0 or at TMR-1."
        "the manual is silent: sections 7 and 8.2 do not describe the end of the range"
        => |d| d.encoder.preset_units(|view, mode, right| relative_preset(view, mode, right, true));
    "relative-preset-beyond-the-end-not-executed" "A relative preset beyond the range leaves the position unchanged."
        "the manual is silent: sections 7 and 8.2 do not describe the end of the range"
        => |d| d.encoder.preset_units(|view, mode, right| relative_preset(view, mode, right, false));
    "preset-value-accepted-and-limited" "A preset value beyond the range is accepted, and limited by the preset."
        "the manual is silent: section 7 prints the permitted values and no reaction to others"
        => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::PresetValue { .. }));
    "blocked-preset-acknowledged" "With class 4 off a preset is acknowledged without being executed."
        "the manual is silent: section 7 says that it is blocked, and not what bit 12 of G1_ZSW shows"
        => |d| blocked_preset_is_acknowledged(d);
    "trigger-before-request" "Of two presets in one frame that of the trigger bit remains, and both are acknowledged."
        "section 8.8: they shall not be triggered at the same time; no result is printed"
        => |d| both_presets(d);
    "preset-limited-by-the-unused-range" "With scaling off a preset by the trigger bit is limited to the configured TMR minus 1."
        "section 8.1: limited to TMR-1, whatever the scaling is"
        => |d| limit_of_the_record(d);
    "offset-with-the-other-sign" "The offset in record BF00 has the other sign."
        "the manual is silent: section 9.3, index 32, prints neither sign nor unit"
        => |d| d.encoder.element(|_, at, right| if at == (65001, 8) { u64::from((right as u32).wrapping_neg()) } else { right });
    "offset-in-hardware-steps" "The offset in record BF00 counts hardware steps."
        "the manual is silent: section 9.3, index 32, prints neither sign nor unit"
        => |d| d.encoder.element(|view, at, right| {
            let Scaling { units_per_revolution: units, .. } = view.measuring.settings.scaling;
            if at == (65001, 8) { (right * view.hardware.steps_per_revolution / units.max(1)) & 0xFFFF_FFFF } else { right }
        });
};

/// Signals, errors and LEDs.
const SIGNALS: &[crate::tables::Deviation] = permitted! {
    "xist1-counts-earlier-presets" "Without preset control G1_XIST1 leaves out the last preset only."
        "section 7, G1_XIST1 Preset Control: without taking the last preset into consideration"
        => |d| d.encoder.add(EarlierPresets::default());
    "xist1-over-all-revolutions" "Without preset control G1_XIST1 counts over all revolutions with a cyclic scaling too."
        "section 7, Preset control G1_XIST1 = Disabled: not limited to the scaled range"
        => |d| d.encoder.image(first_position_over_all_revolutions);
    "saturates-with-any-scaling" "Without preset control G1_XIST2 stays at its highest value outside the range with a cyclic scaling too."
        "section 7, Preset control G1_XIST1 = Disabled: the maximum value beyond the range, for any scaling"
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::PositionSaturates(user) => right || !user.preset_acts_on_xist1 && user.class_4 && user.scaling,
            _ => right,
        });
    "class-3-keeps-the-settings" "With class 4 off scaling and direction stay as they were, the defaults after power-up."
        "section 7, Class 4: the settings are blocked; which values then hold is not printed"
        => |d| {
            let kept = SettingsOfClass4::default();
            d.start.settings(move |user, hardware, right| kept.settings(user, hardware, right));
        };
    "parameter-error-is-a-fault" "Fault Present is set with error 1002h too."
        "section 8.2, ZSW2_ENC bit 3, names hardware errors; encoder profile: any fault"
        => |d| d.encoder.image(|view, _, now| {
            let is_wrong = view.errors.iter().any(|error| error.code == Some(0x1002));
            SignalImage { zsw2_enc: now.zsw2_enc | if is_wrong { 8 } else { 0 }, ..now }
        });
    "newest-error-first" "With two errors G1_XIST2 has the code of the newer one."
        "the manual is silent: section 8.2, G1_XIST2, prints no priority"
        => |d| d.encoder.image(|view, _, now| match view.errors.iter().rev().find_map(|error| error.code) {
            Some(code) if has_error(&now) => SignalImage { g1_xist2: code.into(), ..now },
            _ => now,
        });
    "hardware-errors-latched" "Errors of sensor and memory stay until power-off or the next connection."
        "the manual is silent: section 8.2 says that no error can be reset, and not whether one ends with its cause"
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::LatchesError { code } => right || code != Some(0x1002),
            _ => right,
        });
    "parked-without-a-position" "While parked bit 13 of G1_ZSW is 0."
        "section 8.2: bit 13 is 1 with a valid position; whether a parked one is valid is not printed"
        => |d| d.encoder.signals(|_, now| {
            if is_parked(&now) { SignalImage { g1_zsw: now.g1_zsw & !POSITION, ..now } } else { now }
        });
    "parking-freezes-stdtel81-only" "While parked the positions outside StdTel81 follow the shaft."
        "section 8.2: the reported position is fixed; sections 8.1, 8.4 and 8.5 do not mention parking"
        => |d| d.encoder.image(other_positions_go_on);
    "position-zero-with-error" "While an error is present the ManTel860 position and its parts are 0."
        "the manual is silent: sections 8.1, 8.4 and 8.5 do not mention errors"
        => |d| d.encoder.signals(|_, now| if has_error(&now) && !has_position(&now) && now.g1_xist2 != 0x1002 {
            SignalImage { plain_position: 0, single_turn: 0, multi_turn: 0, ..now }
        } else {
            now
        });
    "acknowledged-preset-after-a-cycle" "Bit 12 of G1_ZSW is set and cleared one cycle later."
        "sections 8.1 and 8.2: a preset takes up to 40 ms; no time is printed for the end of the confirmation"
        => |d| d.encoder.signals(|before, now| if before.unhooked.good && now.g1_zsw & (ERROR | PARKED) == 0 {
            SignalImage { g1_zsw: now.g1_zsw & !EXECUTED | before.unhooked.g1_zsw & EXECUTED, ..now }
        } else {
            now
        });
};

/// Records, parameters and identification.
const RECORDS: &[crate::tables::Deviation] = permitted! {
    "operating-status-without-bits-4-and-5" "The operating status has bits 0 to 3 only."
        "section 9.3 names bits 0 to 5; section 9.1 says that bit 4 is used in compatibility mode only, which is not supported"
        => |d| d.encoder.element(|_, at, right| if at == (65001, 1) { right & !0x30 } else { right });
    "invalid-records-refused" "A record BF00 with invalid values is refused by its write response."
        "the manual is silent: sections 8.2 and 9.1 do not say whether a bad record is refused or reported"
        => |d| d.encoder.write_record(|view, access, octets| match octets {
            Ok(octets) if is_record(*access) && !within_limits(&octets, view) => Err(RecordRefusal::InvalidParameter),
            octets => octets,
        });
    "other-lengths-reported" "A record BF00 of another length is accepted and reported as error 1002h."
        "the manual is silent: sections 8.2 and 9.1 do not say whether a bad record is refused or reported"
        => |d| d.encoder.write_record(|_, access, octets| octets.map(|octets| {
            if is_record(*access) && octets.len() != 31 { invalid_record() } else { octets }
        }));
    "compatibility-mode-refused" "A record BF00 with bit 5 = 0 is refused."
        "section 7: profile V3 is not supported; no reaction is printed"
        => |d| d.encoder.write_record(|_, access, octets| match octets {
            Ok(octets) if is_record(*access) && octets.first().is_some_and(|bits| bits & 0x20 == 0) => Err(RecordRefusal::InvalidParameter),
            octets => octets,
        });
    "reserved-bits-reported" "A record BF00 with reserved bits or bytes set is reported as error 1002h."
        "section 9.1: to be set to zero; no reaction is printed"
        => |d| d.encoder.write_record(|_, access, octets| octets.map(|octets| {
            if is_record(*access) && reported(&octets) { invalid_record() } else { octets }
        }));
    "powers-of-two-ratios-only" "A ratio of TMR and MUR that is no power of two is invalid, with or without preset control."
        "section 7, TMR / MUR: a power of 2"
        => |d| d.checks.serves(|user, _, right| {
            let (small, great) = (user.units_per_revolution.min(user.range).max(1), user.units_per_revolution.max(user.range));
            right && great % small == 0 && (great / small).is_power_of_two()
        });
    "axes-refused" "A parameter request for an axis other than 0 and 1 is refused with error 19h."
        "the manual is silent: section 9.2 prints CD as the axis of an example"
        => |d| d.checks.check(|check, right| match check { EncoderCheck::Axis(axis) => axis <= 1, _ => right });
    "preset-value-of-unsigned-32" "The preset value is read with the format of an unsigned number, 07h."
        "the manual is silent: section 9.2 does not describe reading"
        => |d| d.encoder.respond(|_, mut response| {
            for value in response.values.iter_mut().filter(|value| value.format == ParameterFormat::DOUBLE_WORD) {
                value.format = ParameterFormat::UNSIGNED32;
            }
            response
        });
    "neighbouring-error-numbers" "Refused parameter requests have the neighbouring error number: 03h and 04h, 05h and 17h, 16h and 17h."
        "the manual is silent: section 9.2 prints no error numbers; the profile leaves the choice"
        => |d| d.encoder.refuse(|_, _, found| found.map(|error| {
            let number = match error.number {
                ErrorNumber(0x03) => ErrorNumber(0x04),
                ErrorNumber(0x04) => ErrorNumber(0x03),
                ErrorNumber(0x05 | 0x16) => ErrorNumber(0x17),
                ErrorNumber(0x17) => ErrorNumber(0x16),
                other => other,
            };
            ParameterError { number, ..error }
        }));
    "one-parameter-at-a-time" "A request for several parameters is refused for each of them."
        "the manual is silent: section 9.2 prints n parameters in a table and one in the example"
        => |d| d.encoder.respond(|request, response| {
            if request.addresses.len() < 2 || request.header.id != RequestId::REQUEST {
                return response;
            }
            refuse_all(request, ErrorNumber::UNKNOWN_REQUEST)
        });
    "responses-read-twice" "A parameter response can be fetched twice."
        "the manual is silent: section 9.2 does not describe the response"
        => |d| d.encoder.add(ReadTwice::default());
    "later-revisions" "I&M0 reports hardware 3 and firmware V3.2.1."
        "title page: as from firmware version 3.0; section 11 certifies one specimen"
        => |d| d.stack.im0(|im0| {
            im0.hardware_revision = 3;
            (im0.software_revision.bug_fix, im0.software_revision.internal_change) = (2, 1);
        });
};
