//! What the manual of the A3M60 leaves free: each side of its contradictions and of what it leaves open.

use super::a3m60_state::{
    CodesUntilPowerOff, DelayedFaults, DelayedPresetRequests, HeldPosition, KeptSpeedSettings, LateResponses,
    ParkedPositionsStay, RefusesClockWithIoModules, RoundedLog, Xist2Stays,
};
use super::requests::refuse_all;
use super::rounding::{nearest_of_gear, nearest_position};
use crate::needs::Need;
use crate::seams::Deviations;
use crate::tables::Group;
use crate::tables::dp_diagnosis::without_code;
use crate::tables::signal_image::{EXECUTED, has_error};
use alloc::vec::Vec;
use core::time::Duration;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder_object::PoweredEncoder;
use encoder_profile::facts::{ErrorCause, ErrorFact};
use encoder_profile::profidrive::preset_trigger::TRIGGER;
use encoder_profile::profidrive::sensor::SensorError;
use encoder_profile::profidrive::telegram::SignalImage;
use reference_devices::manuals;
use reference_devices::models::sick_a3m60::A3m60State;
use reference_devices::models::sick_a3m60::hooks::A3m60Check;
use reference_devices::models::sick_a3m60::set_prm::UserByteFields;
use reference_devices::models::sick_a3m60::status::{self, SensorStatusWords};
use wire::profibus::diag::Status1;
use wire::profidrive::{ErrorNumber, ParameterError, RequestId};

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Of(&manuals::SICK_A3M60)],
    deviations: permitted! {
        // Diagnosis
        "one-block-per-cause" "Each bit of the sensor status has its own block."
            "section 5.4.1: three bytes per error that occurs; open whether two causes with one code are two errors"
            => |d| d.a3m60.diagnosis(one_block_per_cause);
        "newest-block-first" "The blocks of the diagnosis are in reverse order."
            "section 5.4.1 prints no order of the blocks"
            => |d| d.a3m60.diagnosis(|_, mut numbers| {
                numbers.reverse();
                numbers
            });
        "eeprom-error-not-in-36" "An EEPROM that does not answer is reported only as a memory error."
            "section 5.4.1, Tab. 34, 38h: bit 7; Tab. 35 has 36h as well"
            => |d| d.a3m60.diagnosis(|encoder, numbers| without(numbers, status::POSITION_ERROR, status::words(encoder).a & status::POSITION == EEPROM));
        "amplitude-alone-in-36" "Only a wrong amplitude has the diagnosis 36h; the other position errors have none."
            "section 5.4.1, Tab. 34, 36h: bit 6; Tab. 35 and Tab. 39 have other bits"
            => |d| d.a3m60.diagnosis(|encoder, numbers| without(numbers, status::POSITION_ERROR, status::words(encoder).a & AMPLITUDE == 0));
        "ext-diag-without-blocks" "With the alarm channel off Ext_Diag still shows an error, without blocks."
            "section 3.6.5 says that only the first six bytes are transferred, not what Ext_Diag is"
            => |d| {
                let words = d.track_status();
                d.slave.diagnosis(move |diag, _| if diag.ext.is_empty() && words.get().a & !status::OVERSPEED | words.get().b != 0 {
                    diag.status_1 = diag.status_1.with(Status1::EXT_DIAG);
                });
            };
        "warning-sets-ext-diag" "The overspeed warning sets Ext_Diag."
            "section 5.4.1, Tab. 34 calls it a warning; the manual is silent about Ext_Diag"
            => |d| d.slave.diagnosis(|diag, _| if diag.ext == [0x81, 0x40, status::TOO_FAST] {
                diag.status_1 = diag.status_1.with(Status1::EXT_DIAG);
            });
        // Sensor status
        "one-turn-is-a-large-deviation" "A deviation of the counters by one turn sets bit 13 and has the code 0002h."
            "section 5.4.4, Tab. 37 prints no number for a large deviation"
            => |d| {
                d.a3m60.status(|_, words| if words.a & SMALL == 0 { words } else { SensorStatusWords { a: words.a & !SMALL | LARGE, ..words } });
                recode(d, |error, code| if is_of(error, "synchronization_start") || is_of(error, "synchronization_shutdown") { code.map(|_| 2) } else { code });
            };
        "bit-12-with-a-cancelled-transmission" "An FRAM that does not answer sets bit 12 in addition to bit 14."
            "section 5.4.3, Tab. 36, 0008h: bits 14 and 12; Tab. 37: bit 12 reserved"
            => |d| d.encoder.element(|_, at, right| if at == (1000, 0) && right & 1 << 14 != 0 { right | 1 << 12 } else { right });
        "bit-9-without-a-code" "A vector that is too short has no code in G1_XIST2 and no error bit."
            "section 5.4.3, Tab. 36, 0001h: bits 8 and 6; Tab. 37: bit 9 reads as bit 8"
            => |d| recode(d, |error, code| if is_of(error, "vector_length") { None } else { code });
        "both-bits-for-a-long-vector" "A vector that is too long sets bits 9 and 8."
            "section 5.4.4, Tab. 37: bits 9 and 8 have the same text"
            => |d| d.a3m60.status(|_, words| if words.a & 0x0100 == 0 { words } else { SensorStatusWords { a: words.a | 0x0200, ..words } });
        "silent-eeprom-has-invalid-parameters" "An EEPROM that does not answer also sets bit 15."
            "section 5.4.4, Tab. 37, bit 15: invalid parameters in the EEPROM; silent about parameters that cannot be read"
            => |d| d.encoder.element(|_, at, right| if at == (1000, 0) && right & 1 << 7 != 0 { right | 1 << 15 } else { right });
        "faults-0-in-v31" "In compatibility mode P65001.2 and .4 are always 0."
            "section 5.4.4: only supported by the encoder profile V4.1"
            => |d| d.encoder.element(|view, at, right| match at {
                (65001, 2 | 4) if view.user.compatible => 0,
                _ => right,
            });
        "overspeed-from-9000-on" "The overspeed warning begins at 8990 rpm, since the speed is measured with an error."
            "section 5.4.4, Tab. 37, bit 5 prints no tolerance of the measured speed"
            => |d| d.checks.check(|check, right| match check { EncoderCheck::TooFast(rpm) => right || (8990..=9000).contains(&rpm.abs()), _ => right });
        "faults-noticed-late" "An error is noticed 300 ms after its cause."
            "the manual prints no time of an error (section 5.4 looked for)"
            => |d| DelayedFaults::attach(d, Duration::from_millis(300));
        // Errors and their acknowledgement
        "errors-clear-themselves" "An error disappears with its cause, without an acknowledgement."
            "section 3.4.3, Tab. 15 bit 15, is silent about how long an error stays"
            => |d| d.checks.check(|check, right| right && !matches!(check, EncoderCheck::LatchesError { .. }));
        "acknowledgement-answered-without-an-error" "Bit 11 of G1_ZSW follows bit 15 of G1_STW, with an error or without."
            "section 3.4.3, Tab. 16 bit 11: reaction to bit 15; silent about a request without an error"
            => |d| d.encoder.signals(|_, now| if now.request.acknowledge && !has_error(&now) { SignalImage { g1_zsw: now.g1_zsw | 0x0800, ..now } } else { now });
        "latest-code-first" "With several errors G1_XIST2 has the code of the latest one."
            "section 5.4.3, Tab. 36 prints no priority of the codes"
            => |d| d.encoder.image(|view, _, now| match view.errors.iter().rev().find_map(|error| error.code) {
                Some(code) if has_error(&now) => SignalImage { g1_xist2: code.into(), ..now },
                _ => now,
            });
        "codes-of-the-telegrams-hidden-too" "With fault codes switched off G1_XIST2 has no codes and the error bit is 0."
            "section 4.4.5 lists the parameter for modules 81 and 83; section 3.6.8 names IO 04 and IO 08 only"
            => |d| d.a3m60.image(|encoder, now| if encoder.model.fields.shows_codes() { now } else { without_code(now) });
        "bit-31-without-a-code" "With fault codes switched off an error sets bit 31 above the position."
            "section 3.4.1, warning: bit 31 shows each serious error; section 3.6.8: no safe detection"
            => |d| d.a3m60.image(|encoder, now| if encoder.model.fields.shows_codes() || status::noticed(encoder).next().is_none() {
                now
            } else {
                SignalImage { plain_position: now.plain_position | TRIGGER, ..now }
            });
        "code-of-several-until-power-off" "The code -16 of the IO modules stays until power-off."
            "section 5.4.2 is silent about when a code disappears; the IO modules have no acknowledgement"
            => |d| d.a3m60.add(CodesUntilPowerOff::default());
        "other-code-without-a-row" "Invalid parameters in the EEPROM have the code -4, a wrong linearization -3."
            "section 5.4.2, Tab. 35 has no row for them"
            => |d| d.a3m60.fault_code(|encoder, code| {
                let mut faults = status::noticed(encoder).map(|fault| fault.name);
                match (code, faults.next(), faults.next()) {
                    (Some(_), Some("eeprom_checksum"), None) => Some(-4),
                    (Some(_), Some("linearization"), None) => Some(-3),
                    _ => code,
                }
            });
        "xist1-0-with-an-error" "G1_XIST1 is 0 while there is an error."
            "section 5.4.3 assigns codes to G1_XIST2 and is silent about G1_XIST1"
            => |d| d.encoder.signals(|_, now| if has_error(&now) { SignalImage { g1_xist1: 0, ..now } } else { now });
        // Isochronous mode
        "no-clock-with-io-modules" "The IO modules cannot be configured with isochronous mode."
            "section 3.6, Tab. 26 lost its marks; the IO modules have no STW2_ENC"
            => |d| d.slave.add(RefusesClockWithIoModules::default());
        "monitoring-restarts-at-1" "After a failure the sign of life of the master is accepted from 1 on."
            "section 3.4.3, Tab. 13: the master starts between 1 and 15; silent about the end of a failure"
            => |d| d.checks.check(|check, right| match check {
                EncoderCheck::FollowsLifeSign { sign, has_failed: true, .. } => right && sign == 1,
                _ => right,
            });
        "sign-of-life-0-with-a-sensor-error" "The sign of life of the encoder is 0 while there is a sensor error."
            "section 3.4.3, Tab. 14: 0000 if an error occurs in the encoder; silent about which errors"
            => |d| d.a3m60.image(|encoder, now| {
                if status::words(encoder).a & !status::OVERSPEED == 0 { now } else { SignalImage { zsw2_enc: now.zsw2_enc & 0x0FFF, ..now } }
            });
        "sign-of-life-free-running" "The sign of life of the encoder counts even without isochronous operation."
            "section 3.4.3, Tab. 14: only relevant in the isochronous mode"
            => |d| d.a3m60.check(|check, right| match check {
                A3m60Check::SignOfLife { is_isochronous, .. } => right || !is_isochronous,
                _ => right,
            });
        "no-control-requested-in-v31" "In compatibility mode bit 9 of ZSW2_ENC is 0."
            "section 3.4.3, Tab. 14 bit 9, and section 3.6.6: control is assumed"
            => |d| d.checks.check(|check, right| match check { EncoderCheck::RequestsControl { compatible, .. } => right && !compatible, _ => right });
        // Parameters
        "p925-always-1" "P925 always reads 1."
            "section 3.5.1, Tab. 23, 925: constant 1; section 3.6.11: 1 to 15"
            => |d| d.encoder.element(|_, at, right| if at == (925, 0) { 1 } else { right });
        "profile-of-v31-in-compatibility-mode" "In compatibility mode P965 is 3D1Fh and P65001.6 is 0301h."
            "section 3.6.6: operates as per encoder profile V3.1; Tab. 23 and Tab. 25 print those of V4.1"
            => |d| d.encoder.element(|view, at, right| match at {
                (965, 0) if view.user.compatible => 0x3D1F,
                (65001, 6) if view.user.compatible => 0x0301,
                _ => right,
            });
        "operating-status-bytes-swapped" "The two bytes of P65001.1 are in the other order."
            "section 3.5.3, Tab. 25, 65001.1: bit oriented, 00.00.AA.BBh; no bit is printed"
            => |d| d.encoder.element(|_, at, right| if at == (65001, 1) { u64::from((right as u16).swap_bytes()) } else { right });
        "sensor-type-without-bit-31" "Bit 31 of P979.1 is 0."
            "section 3.5.1, Tab. 23, 979.1: 00.00.00.02h or 80.00.00.02h"
            => |d| d.encoder.element(|_, at, right| if at == (979, 1) { right & 0x7FFF_FFFF } else { right });
        "telegram-number-of-the-io-modules" "P922 reads 104 or 108 with the IO modules."
            "section 3.5.1, Tab. 23, 922 prints 81 and 83 only"
            => |d| {
                let inputs = d.track(0, |encoder, _, _| encoder.ram.telegram().input_octets);
                d.encoder.element(move |_, at, right| if at == (922, 0) && right == 0 { 100 + u64::from(inputs.get()) } else { right });
            };
        "p971-cannot-be-read" "A read of P971 is refused."
            "section 3.5.1, Tab. 23, 971: access W; no error number is printed"
            => |d| d.encoder.refuse(|request, number, before| match (request, number) {
                (RequestId::REQUEST, 971) => Some(ParameterError { number: ErrorNumber::WRONG_OPERATING_STATE, subindex: None }),
                _ => before,
            });
        "operating-time-in-motion" "P65001.7 counts the time in motion."
            "section 3.5.3, Tab. 25, 65001.7: operating time; silent about which"
            => |d| {
                let motion = d.track(0, |encoder, _, _| encoder.model.log.motion.as_secs());
                d.encoder.element(move |_, at, right| if at == (65001, 7) { motion.get() / 360 } else { right });
            };
        "supported-bits-as-used" "P65001.3 is 21h and P65001.5 is 01h: the bits that can be set."
            "section 5.4.4, Tab. 39 and Tab. 40: the other bits are not supported; Tab. 25: 37h and 03h"
            => |d| d.encoder.element(|_, at, right| match at { (65001, 3) => 0x21, (65001, 5) => 0x01, _ => right });
        "silent-eeprom-is-no-position-fault" "An EEPROM that does not answer sets bit 5 of P65001.2 and not bit 0."
            "section 5.4.4, Tab. 39, memory: bits 15 and 7; position: bits 14 to 6"
            => |d| {
                let words = d.track_status();
                d.encoder.element(move |_, at, right| if at == (65001, 2) && words.get().a & status::POSITION == EEPROM { right & !1 } else { right });
            };
        "date-in-bcd" "Year, day and month of the firmware are in BCD."
            "section 3.5.1, Tab. 23, 964.3 and .4: yyyy and dd.mm; silent about the coding"
            => |d| d.encoder.element(|_, at, right| if let (964 | 975, 3 | 4) = at { in_bcd(right) } else { right });
        "offset-with-the-other-sign" "P65001.8 is the measured position minus the set position."
            "section 3.5.3, Tab. 25, 65001.8 prints no sign of the offset"
            => |d| d.encoder.element(|view, at, right| if at == (65001, 8) { (view.positions - right % view.positions) % view.positions } else { right });
        "range-offset-constant" "P1009.4 is always 1."
            "section 3.5.2, Tab. 24, 1009.4 prints a range and no meaning"
            => |d| d.encoder.element(|_, at, right| if at == (1009, 4) { 1 } else { right });
        "internal-shift-constant" "P1009.5 is always FFFFFFFFh."
            "section 3.5.2, Tab. 24, 1009.5 prints a range and no meaning"
            => |d| d.encoder.element(|_, at, right| if at == (1009, 5) { 0xFFFF_FFFF } else { right });
        "fraction-in-use-reduced" "P1009.6 and .7 are the reduced fraction."
            "section 3.5.2, Tab. 24, 1009.6 and .7: silent about whether they differ from the inputs"
            => |d| d.encoder.parameter(|_, number, mut parameter| {
                if let (1009, [_, _, _, _, _, _, above, below, ..]) = (number, parameter.values.as_mut_slice()) {
                    let common = gcd(*above, *below).max(1);
                    (*above, *below) = (*above / common, *below / common);
                }
                parameter
            });
        "turns-counted-by-two" "P1002.3 and .4 count every second turn."
            "section 3.5.2, Tab. 24, 1002.3 and .4 print no unit of the counters"
            => |d| d.sick.log(|_, mut elements| {
                elements[3] /= 2;
                elements[4] /= 2;
                elements
            });
        "service-log-saved-every-10-s" "After power-off the seconds of motion are those of the last full 10 s."
            "section 3.5.2, Tab. 24, 1002 prints no time of storing"
            => |d| d.sick.add(RoundedLog);
        "speed-settings-kept" "P1008 is kept without power."
            "section 3.5.2, Tab. 24, 1008 is silent about power-off"
            => |d| d.a3m60.add(KeptSpeedSettings::default());
        "parameter-responses-late" "The response to a parameter request is ready after 60 ms."
            "section 3.5 prints no time of a response"
            => |d| LateResponses::attach(d, Duration::from_millis(60));
        "one-parameter-at-a-time" "Requests for several parameters are refused."
            "section 3.5, Tab. 22 prints blocks 1 to N and no number"
            => |d| d.encoder.respond(|request, response| if request.addresses.len() < 2 { response } else {
                refuse_all(request, ErrorNumber::SINGLE_PARAMETER_ONLY)
            });
        // Start parameters
        "unknown-unit-is-rpm" "An unknown unit of the speed is replaced by rpm."
            "section 3.6.12 is silent about other codes"
            => |d| d.fields(|fields| UserByteFields { speed_unit: if fields.speed_unit > 4 { 3 } else { fields.speed_unit }, ..fields });
        "tolerance-limited" "A tolerance outside 1 to 15 is replaced by the nearest one."
            "section 3.6.11 is silent about other values"
            => |d| d.fields(|fields| UserByteFields { failures: fields.failures.clamp(1, 15), ..fields });
        "range-limited-to-all-revolutions" "A range of more than 131072 revolutions is limited to these."
            "section 3.6.10 is silent about larger ranges"
            => |d| d.fields(|fields| {
                let all = u64::from(fields.units) << 17;
                let is_power = fields.units > 0 && fields.range % fields.units == 0 && (fields.range / fields.units).is_power_of_two();
                UserByteFields { range: if is_power && fields.units <= 16384 { u64::from(fields.range).min(all) as u32 } else { fields.range }, ..fields }
            });
        "range-rounded-down" "A range that is no power of two of the revolutions is rounded down to the next one."
            "section 3.6.10 says must and not what happens"
            => |d| d.fields(range_rounded_down);
        "factory-range-limited-on-the-round-axis" "With the factory values the round axis has a range of 04000000h, all steps of 4096 revolutions."
            "section 4.4.5, total resolution 2147483648; section 3.6.14: at most 1073741824, and silent about what happens to more"
            => |d| d.fields(|fields| {
                let is_of_factory = fields.has_axis() && (fields.nominator, fields.divisor, fields.range) == (4096, 1, 1 << 31);
                UserByteFields { range: if is_of_factory { 1 << 26 } else { fields.range }, ..fields }
            });
        // Presets
        "button-always-sets-0" "The button sets the position to 0."
            "section 4.3.3: a pre-defined value, 0 in the factory; silent about where it is changed"
            => |d| d.sick.button(|_| 0);
        "first-outputs-are-an-edge" "A trigger bit that is set in the first outputs makes a preset."
            "section 3.4.1, Preset: 0 in the previous cycle; silent about the first cycle"
            => |d| d.checks.check(|check, right| match check {
                EncoderCheck::TriggersPreset { before: None, now } => now & TRIGGER != 0,
                _ => right,
            });
        "io-positions-of-26-bits" "Without scaling positions and presets of the IO modules have 26 bits."
            "section 3.4.1, Position: always up to 03FFFFFFh; section 3.1: 31 bits"
            => |d| {
                d.encoder.preset_word(|word, _| word & (TRIGGER | LOW_26));
                d.encoder.signals(|_, now| if now.plain_position & TRIGGER == 0 {
                    SignalImage { plain_position: now.plain_position & LOW_26, ..now }
                } else { now });
            };
        "preset-done-within-a-cycle" "A preset is complete within a cycle, so that bit 12 of G1_ZSW is never seen."
            "section 3.4.3, Tab. 16 bit 12: set to 0 on conclusion; silent about the duration"
            => |d| d.encoder.signals(|_, now| SignalImage { g1_zsw: now.g1_zsw & !EXECUTED, ..now });
        "preset-bit-until-its-conclusion" "Bit 12 of G1_ZSW is set for one cycle, while the preset is carried out."
            "section 3.4.3, Tab. 16 bit 12: set to 0 on conclusion"
            => |d| d.encoder.signals(|before, now| SignalImage { g1_zsw: now.g1_zsw & !(before.unhooked.g1_zsw & EXECUTED), ..now });
        "presets-late" "A preset is carried out 80 ms after its request."
            "the manual prints no time of a preset (sections 3.4.1 and 3.4.3 looked for)"
            => |d| d.encoder.add(DelayedPresetRequests::new(Duration::from_millis(80)));
        "preset-stored-late" "Storing the offset of a preset takes 1.5 s."
            "section 3.5.3, Tab. 25, 65001.8: saved in EEPROM; silent about the time"
            => |d| d.encoder.offset_takes(|_| Duration::from_millis(1500));
        // Positions and speed
        "xist2-stays-without-a-request" "Without a request G1_XIST2 keeps the last position."
            "section 3.4.3, Tab. 15 bit 13, is silent about G1_XIST2 without a request"
            => |d| d.encoder.add(Xist2Stays::default());
        "parked-positions-stay" "While parked G1_XIST1 keeps its value."
            "section 3.4.3, Tab. 16 bit 14: no output of position data; silent about the value"
            => |d| d.encoder.add(ParkedPositionsStay::default());
        "scaled-positions-rounded" "Scaled positions are rounded to the nearest one."
            "section 3.6.9 is silent about rounding"
            => |d| {
                d.measuring.position(|at, right| match at.settings.gear {
                    _ if right != at.position() => right,
                    Some(gear) => nearest_of_gear(&gear, &at.hardware, at.unwrapped),
                    None => nearest_position(&at.scaling, &at.hardware, at.place),
                });
            };
        "position-every-2-ms" "The position is determined every 2 ms."
            "section 3.6.13 prints no interval of the position"
            => |d| d.a3m60.add(HeldPosition::new(Duration::from_millis(2)));
        // Controls
        "forbidden-address-is-126" "With the switches at an address that is not permitted the encoder has the address 126."
            "section 4.3.2: the highest address is 125; silent about others"
            => |d| {
                d.a3m60.switches(|set| {
                    let [tens, ones] = set;
                    if (1..=125).contains(&(tens * 10 + ones)) { set } else { [12, 6] }
                });
                d.a3m60.check(|check, right| right || check == A3m60Check::Address(126));
            };
        "memory-errors-on-the-led" "The LED of the encoder is orange with memory errors, too."
            "section 3.7, Tab. 28: internal sensor error; silent about memory errors"
            => |d| {
                let words = d.track_status();
                d.encoder.led(move |led, right| if led.name == "encoder" && right == "green" && words.get().a & status::MEMORY != 0 { "orange" } else { right });
            };
        "undervoltage-below-8-volts" "The LEDs show undervoltage below 8 V."
            "section 3.7, Tab. 28 prints no threshold"
            => |d| d.a3m60.check(|check, right| match check { A3m60Check::Supply(millivolts) => right || millivolts >= 8000, _ => right });
    },
}];

/// Bits of S_STAT-A.
const AMPLITUDE: u16 = 1 << 6;
const EEPROM: u16 = 1 << 7;
const SMALL: u16 = 1 << 11;
const LARGE: u16 = 1 << 13;
/// The positions of 26 bits.
const LOW_26: u32 = 0x03FF_FFFF;

/// Changes the codes in G1_XIST2, given the error and its code so far.
fn recode(d: &mut Deviations, change: fn(&ErrorFact, Option<u16>) -> Option<u16>) {
    d.encoder.causes(move |view, all| {
        let changed = |error: SensorError| match view.facts.errors.get(usize::from(error.number)) {
            Some(fact) => SensorError { code: change(fact, error.code), ..error },
            None => error,
        };
        all.into_iter().map(changed).collect()
    });
}

fn is_of(error: &ErrorFact, name: &'static str) -> bool {
    error.causes.contains(&ErrorCause::Stand(name))
}

fn without(mut numbers: Vec<u8>, number: u8, is_left_out: bool) -> Vec<u8> {
    numbers.retain(|known| *known != number || !is_left_out);
    numbers
}

/// The numbers of the diagnosis, one for each bit of the sensor status.
fn one_block_per_cause(encoder: &PoweredEncoder<'_, A3m60State>, numbers: Vec<u8>) -> Vec<u8> {
    if numbers.is_empty() {
        return numbers;
    }
    let SensorStatusWords { a, b } = status::words(encoder);
    let of_a = (0..16).rev().filter(|bit| a >> bit & 1 != 0).map(|bit| match bit {
        15 | 7 => status::MEMORY_ERROR,
        5 => status::TOO_FAST,
        _ => status::POSITION_ERROR,
    });
    let of_b = (4..7).filter(|bit| b >> bit & 1 != 0).map(|bit| status::LIFE_SIGN - 4 + bit as u8);
    of_a.chain(of_b).collect()
}

/// The decimal digits of a number as hexadecimal ones.
fn in_bcd(number: u64) -> u64 {
    if number == 0 { 0 } else { (in_bcd(number / 10) << 4) | (number % 10) }
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// The bits of the scaling in the first switch byte, and of the round axis in the second one.
const SCALING: u8 = 1 << 3;

fn range_rounded_down(fields: UserByteFields) -> UserByteFields {
    let UserByteFields { switches: [bits, _], units, range, .. } = fields;
    let most = u64::from(units) << 17;
    let is_in_limits = (1..=16384).contains(&units) && range >= units && u64::from(range) <= most;
    if bits & SCALING == 0 || fields.has_axis() || !is_in_limits {
        return fields;
    }
    UserByteFields { range: units << (range / units).ilog2(), ..fields }
}
