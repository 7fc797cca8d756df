//! Bugs of the user parameter record, 0xBF00.

use super::Group;
use super::cyclic_state::as_set;
use crate::needs::Need;
use crate::seams::Deviations;
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::Cell;
use core::time::Duration;
use device_stack::Attached;
use device_stack::profinet::{RecordAccess, RecordRefusal};
use encoder_profile::checks::{AttachedChecks, EncoderCheck};
use encoder_profile::encoder::{CountingDirection, Hardware, MeasuringSettings, Scaling, VelocityUnit};
use encoder_profile::hooks::{EncoderHooks, EncoderView, RecordOctets};
use encoder_profile::profidrive::telegram::InputSignal;
use encoder_profile::profidrive::user_parameters::{OCTETS, ParametrizedEncoder, UserParameterData};
use reference_devices::manuals;

/// Record index of the user parameters.
pub const USER_PARAMETERS: u16 = 0xBF00;
/// Record index of the parameter access.
pub const PARAMETER_ACCESS: u16 = 0xB02E;
/// Byte 0 of the default user parameters of the XAC77.
const DEFAULT_SWITCHES: u8 = 0x22;
/// Longer than any controller waits for good data.
const NEVER: Duration = Duration::from_secs(3600);

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[
    // User parameters in a record or in Set_Prm
    Group {
        needs: &[Need::EncoderProfile],
        deviations: bugs! {
            "code-sequence-ignored" "The position always rises clockwise, whatever the code sequence."
                => |d| d.checks.check(|check, right| right && !matches!(check, EncoderCheck::CodeSequenceActs(_)));
            "scaling-without-class-4" "Scaling is active although class 4 is off."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::ScalingActs(user) => user.scaling,
                    _ => right,
                });
            "scaling-bit-ignored" "Scaling is active although it is off."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::ScalingActs(user) => user.class_4,
                    _ => right,
                });
            "full-units-refused" "The full steps per revolution of the hardware are refused as a scaling."
                => |d| d.checks.serves(|user, hardware, right| right && user.units_per_revolution < hardware.steps_per_revolution);
            "powers-of-two-only" "Scaling parameters that are not powers of two are refused."
                => |d| d.checks.serves(|user, _, right| {
                    right && user.units_per_revolution.is_power_of_two() && user.range.is_power_of_two()
                });
            "odd-ranges-rounded-down" "A range of units that are no power of two times a revolution ends at the next lower one."
                => |d| d.encoder.user_parameters(|_, user| match user.range.checked_div(user.units_per_revolution) {
                    Some(ratio) if ratio > 0 && !ratio.is_power_of_two() => {
                        UserParameterData { range: user.units_per_revolution << ratio.ilog2(), ..user }
                    }
                    _ => user,
                });
            "code-sequence-inverted" "The code sequence is inverted."
                => |d| d.start.settings(|user, _, right| match user.direction {
                    CountingDirection::Clockwise if user.class_4 => MeasuringSettings { direction: CountingDirection::Counterclockwise, ..right },
                    _ => MeasuringSettings { direction: CountingDirection::Clockwise, ..right },
                });
        },
    },
    // The user parameter record
    Group {
        needs: &[Need::Profinet, Need::EncoderProfile],
        deviations: bugs! {
            "record-length-not-checked" "A record 0xBF00 of another length is accepted."
                => |d| change_record(d, |octets| octets.resize(OCTETS, 0));
            "record-taken-once" "Only the first record 0xBF00 after power-up is applied."
                => |d| record_taken_once(d);
            "record-half-taken-in-data-exchange" "A record in data exchange is refused but still scales the position."
                => |d| record_half_taken(d);
            "bits-2-and-3-exchanged" "Preset control and scaling are swapped in byte 0."
                => |d| read_octets(d, |octets| octets[0] = octets[0] & 0xF3 | octets[0] >> 1 & 4 | octets[0] << 1 & 8);
            "reserved-bit-7-acts" "Bit 7 of byte 0 inverts the code sequence."
                => |d| read_octets(d, |octets| octets[0] ^= octets[0] >> 7);
            "scaling-little-endian" "The scaling parameters are read with their least significant byte first."
                => |d| read_octets(d, scaling_little_endian);
            "byte-17-as-unit" "The velocity unit is read from byte 17."
                => |d| read_octets(d, |octets| octets[18] = octets[17]);
            "unit-from-byte-19" "The velocity unit is read from byte 19."
                => |d| read_octets(d, |octets| octets[18] = octets[19]);
            "reserved-bytes-act" "Byte 30 is used as the preset value if it is not 0."
                => |d| d.encoder.add(ReservedOctetsAct::default());
            "upper-scaling-bytes-ignored" "Only the lower 32 bits of the scaling parameters are used."
                => |d| d.encoder.user_parameters(upper_scaling_octets_ignored);
            "units-and-range-exchanged" "Units per revolution and total range are swapped."
                => |d| d.encoder.user_parameters(units_and_range_exchanged);
            "compatibility-inverted" "Compatibility mode has the inverse polarity: 1 is enabled."
                => |d| d.encoder.user_parameters(|_, user| UserParameterData { compatible: !user.compatible, ..user });
            "tolerance-0-accepted" "A tolerance of 0 failures of the sign of life is accepted silently."
                => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::ToleranceIsRight(_)));
            "class-4-always-on" "The class 4 bit is ignored: class 4 is always on."
                => |d| d.encoder.user_parameters(|_, user| UserParameterData { class_4: true, ..user });
            "code-sequence-without-class-4" "The code sequence is active although class 4 is off."
                => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::CodeSequenceActs(_)));
            "direction-reversed" "The code sequence of the singleturn encoder is reversed."
                => |d| d.start.settings(direction_reversed);
            "scaling-one-start-late" "The scaling of a record takes effect one start later."
                => |d| d.start.settings(scaling_one_start_late());
            "full-range-refused" "The full range of the hardware is refused."
                => |d| d.checks.serves(|user, hardware, right| right && user.range < hardware.range());
            "limits-of-the-other-variant" "The limits of the scaling are those of the other variant."
                => |d| limits_of_the_other_variant(d);
            "single-limits-not-checked" "Units per revolution and range beyond their limits are accepted silently."
                => |d| d.checks.serves(single_limits_not_checked);
            "impossible-scaling-accepted" "A ratio that the hardware cannot serve is accepted silently."
                => |d| d.checks.serves(|user, hardware, right| right || are_single_limits_kept(user, hardware, 2));
            "zero-units-stop-the-device" "Units per revolution of 0 stop the device, even with scaling off."
                => |d| d.encoder.ready(|view, right| if view.user.units_per_revolution == 0 { NEVER } else { right });
            "speed-unit-not-checked" "An undefined velocity unit is silently treated as steps per second."
                => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::VelocityUnitExists(_)));
            "speed-unit-ignored" "The velocity is always in steps per second."
                => |d| d.start.velocity_unit(|_, _| VelocityUnit::PerSecond);
            "speed-unit-refused-without-velocity" "With telegram 81 a velocity unit other than 0 is an error."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::UserParametersAreRight(user, 81) => right && user.speed_unit == 0,
                    _ => right,
                });
            "defaults-of-another-model" "Without scaling a revolution has 8192 units."
                => |d| d.start.settings(|user, hardware, right| {
                    unscaled(user, right, Scaling { units_per_revolution: 8192, ..Scaling::hardware(hardware) })
                });
            "default-range-of-one-revolution" "Without scaling the total range is one revolution."
                => |d| d.start.settings(|user, hardware, right| {
                    unscaled(user, right, Scaling { range: hardware.steps_per_revolution, ..Scaling::hardware(hardware) })
                });
            "default-switches-inverted" "Without a record each switch of byte 0 is inverted."
                => |d| d.start.factory_parameters(default_switches_inverted);
            "default-tolerance-10" "Without a record ten failures of the sign of life are tolerated."
                => |d| {
                    d.start.factory_parameters(|_, right| UserParameterData { life_sign_failures: 10, ..right });
                    d.life_sign.tolerated(as_set);
                };
            "default-speed-unit-rpm" "Without a record the velocity is in rpm."
                => |d| d.start.factory_parameters(|_, right| UserParameterData { speed_unit: VelocityUnit::Rpm as u8, ..right });
            "scaling-of-32-bits" "The scaling parameters are read as 32-bit values."
                => |d| read_octets(d, scaling_of_32_bits);
            "record-of-30-bytes" "A record 0xBF00 is accepted only with 30 bytes."
                => |d| d.encoder.write_record(record_of_30_octets);
            "life-sign-byte-refused" "A tolerance of the sign of life other than 0 is an error."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::ToleranceIsRight(user) => user.life_sign_failures == 0,
                    _ => right,
                });
            "class-4-inverted" "Class 4 is on while its bit is 0."
                => |d| d.encoder.user_parameters(|_, user| UserParameterData { class_4: !user.class_4, ..user });
            "revolution-of-hardware-steps" "A unit is always a hardware step, whatever the units per revolution."
                => |d| d.measuring.scale(|scaling, _, place| place % scaling.range);
            "range-of-24-bits" "Only the lower 24 bits of the total range are used."
                => |d| d.encoder.user_parameters(|_, user| UserParameterData { range: user.range & 0x00FF_FFFF, ..user });
            "range-of-25-bits" "A range of more than 25 bits is refused."
                => |d| d.checks.serves(|user, _, right| right && user.range <= 1 << 25);
            "profile-version-in-one-byte" "The profile version in P65001 has one byte."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 6) { 0x41 } else { right });
            "profile-version-3-1" "The profile version in P65001 is 3.1."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 6) { 0x301 } else { right });
        },
    },
    // A missing record
    Group {
        needs: &[Need::RequiredRecord],
        deviations: bugs! {
            "missing-record-ignored" "A start without a record raises no error."
                => |d| d.checks.set(EncoderCheck::StartsWithoutRecord, true);
        },
    },
    // A record in data exchange
    Group {
        needs: &[Need::RecordInExchange],
        deviations: bugs! {
            "parameter-error-latched" "Invalid parameters stay an error for the rest of the connection."
                => |d| parameter_error_latched(d);
            "invalid-record-accepted" "With a scaling of 0 the previous parameters stay in force without an error."
                => |d| d.encoder.user_parameters(|view, user| match (user.units_per_revolution, user.range) {
                    (0, 0) => *view.user,
                    _ => user,
                });
            "record-in-exchange-waits-for-start" "A record in data exchange is accepted but has no effect."
                => |d| d.checks.set(EncoderCheck::RecordActsAtOnce, false);
            "record-of-data-exchange-stays" "A record in data exchange overrides those of later starts."
                => |d| record_of_data_exchange_stays(d);
        },
    },
    // The vendor telegram 860
    Group {
        needs: &[Need::Telegram(860)],
        deviations: bugs! {
            "mantel860-waits-for-preset" "With telegram 860 ApplicationReady is not sent without a parameter request in the start."
                => |d| d.encoder.add(Mantel860WaitsForPreset::default());
            "new-scaling-in-mantel860-only" "A record in data exchange scales only the position of telegram 860."
                => |d| new_scaling_in_mantel860_only(d);
        },
    },
    // The operating status as a record
    Group {
        needs: &[Need::Of(&manuals::KUEBLER_SENDIX58XX)],
        deviations: bugs! {
            "status-of-31-bytes" "Reading 0xBF00 returns the record that was written instead of the status."
                => |d| d.encoder.add(StatusOf31Octets::default());
            "status-one-word-late" "The supported warnings are missing in the status record, and all later fields are shifted."
                => |d| d.encoder.read_record(|_, access, octets| match access.index {
                    USER_PARAMETERS => octets.map(|octets| [&octets[..20], &octets[24..], &[0; 4]].concat()),
                    _ => octets,
                });
        },
    },
    // Printed default parameters
    Group {
        needs: &[Need::Of(&manuals::LIKA_XAC77)],
        deviations: bugs! {
            "default-record-is-wrong" "The default switches are treated as an error."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::UserParametersAreRight(user, _) => right && user.bits != DEFAULT_SWITCHES,
                    _ => right,
                });
        },
    },
];

fn scaling_of_32_bits(octets: &mut [u8]) {
    for begin in [1, 9] {
        octets.copy_within(begin..begin + 4, begin + 4);
        octets[begin..begin + 4].fill(0);
    }
}

fn scaling_little_endian(octets: &mut [u8]) {
    octets[1..9].reverse();
    octets[9..17].reverse();
}

fn upper_scaling_octets_ignored(_: &EncoderView<'_>, user: UserParameterData) -> UserParameterData {
    let UserParameterData { units_per_revolution, range, .. } = user;
    UserParameterData { units_per_revolution: units_per_revolution & 0xFFFF_FFFF, range: range & 0xFFFF_FFFF, ..user }
}

fn units_and_range_exchanged(_: &EncoderView<'_>, user: UserParameterData) -> UserParameterData {
    UserParameterData { units_per_revolution: user.range, range: user.units_per_revolution, ..user }
}

fn direction_reversed(_: &UserParameterData, hardware: &Hardware, right: MeasuringSettings) -> MeasuringSettings {
    let direction = match (right.direction, hardware.revolutions) {
        (CountingDirection::Clockwise, 1) => CountingDirection::Counterclockwise,
        (CountingDirection::Counterclockwise, 1) => CountingDirection::Clockwise,
        (direction, _) => direction,
    };
    MeasuringSettings { direction, ..right }
}

/// Whether units and range are each within the limits of the hardware, regardless of their ratio.
pub fn are_single_limits_kept(user: &UserParameterData, hardware: &Hardware, least_range: u64) -> bool {
    (1..=hardware.steps_per_revolution).contains(&user.units_per_revolution)
        && (least_range..=hardware.range()).contains(&user.range)
}

fn single_limits_not_checked(user: &UserParameterData, hardware: &Hardware, right: bool) -> bool {
    right || user.range != 0 && !are_single_limits_kept(user, hardware, 2)
}

fn default_switches_inverted(_: &Hardware, right: UserParameterData) -> UserParameterData {
    UserParameterData {
        bits: right.bits ^ 0x3F,
        direction: CountingDirection::Counterclockwise,
        class_4: !right.class_4,
        preset_acts_on_xist1: !right.preset_acts_on_xist1,
        scaling: !right.scaling,
        alarm_channel: !right.alarm_channel,
        compatible: !right.compatible,
        ..right
    }
}

/// Changes the bytes of each user parameter record.
fn change_record(d: &mut Deviations, change: fn(&mut Vec<u8>)) {
    d.encoder.write_record(move |_, access, octets| match octets {
        Ok(mut octets) if access.index == USER_PARAMETERS => {
            change(&mut octets);
            Ok(octets)
        }
        octets => octets,
    });
}

/// Changes the bytes of each user parameter record of the right length.
fn read_octets(d: &mut Deviations, change: fn(&mut [u8])) {
    d.encoder.write_record(move |_, access, octets| match octets {
        Ok(mut octets) if access.index == USER_PARAMETERS && octets.len() == OCTETS => {
            change(&mut octets);
            Ok(octets)
        }
        octets => octets,
    });
}

fn record_of_30_octets(_: &EncoderView<'_>, access: &RecordAccess, octets: RecordOctets) -> RecordOctets {
    match octets {
        Ok(mut octets) if access.index == USER_PARAMETERS && octets.len() == 30 => {
            octets.push(0);
            Ok(octets)
        }
        Ok(_) if access.index == USER_PARAMETERS => Err(RecordRefusal::WriteLength),
        octets => octets,
    }
}

/// Changes the scaling in the settings if scaling is off.
pub fn unscaled(user: &UserParameterData, right: MeasuringSettings, scaling: Scaling) -> MeasuringSettings {
    if user.class_4 && user.scaling { right } else { MeasuringSettings { scaling, ..right } }
}

/// Uses the first record instead of all later ones.
pub fn first_record(
    first: Rc<Cell<Option<UserParameterData>>>,
) -> impl FnMut(&EncoderView<'_>, UserParameterData) -> UserParameterData {
    move |view, user| {
        let taken = first.get().unwrap_or(user);
        first.set(first.get().or(view.has_record.then_some(user)));
        taken
    }
}

fn record_taken_once(d: &mut Deviations) {
    let first = Rc::new(Cell::new(None));
    d.encoder.user_parameters(first_record(Rc::clone(&first)));
    d.encoder.powered_up(move || first.set(None));
}

fn record_half_taken(d: &mut Deviations) {
    let refused = Rc::new(Cell::new(None));
    let (at_start, acting) = (Rc::clone(&refused), Rc::clone(&refused));
    d.encoder.write_record(move |view, access, octets| {
        let is_refused = access.index == USER_PARAMETERS && view.exchanged_for.is_some();
        let user = octets.as_ref().ok().and_then(|octets| UserParameterData::parse(octets));
        if let (true, Some(user)) = (is_refused, user) {
            let (checks, steps) = (AttachedChecks::default(), Attached::NONE);
            let encoder = ParametrizedEncoder {
                hardware: view.hardware,
                limits: &view.facts.limits,
                checks: &checks,
                steps: &steps,
            };
            refused.set(Some(user.settings(&encoder)));
        }
        octets
    });
    d.encoder.user_parameters(move |_, user| {
        at_start.set(None);
        user
    });
    d.telegram.acts_on(move |_, _, right| acting.get().unwrap_or(right));
}

fn scaling_one_start_late() -> impl FnMut(&UserParameterData, &Hardware, MeasuringSettings) -> MeasuringSettings {
    let mut before = None;
    move |_, _, right| {
        let scaling = before.replace(right.scaling).unwrap_or(right.scaling);
        MeasuringSettings { scaling, ..right }
    }
}

fn limits_of_the_other_variant(d: &mut Deviations) {
    let other = Rc::new(Cell::new(None));
    let known = Rc::clone(&other);
    d.encoder.user_parameters(move |view, user| {
        other.set(Some((view.other_hardware, view.facts.limits.serves)));
        user
    });
    d.checks.serves(move |user, _, right| known.get().map_or(right, |(other, serves)| serves(user, &other)));
}

fn parameter_error_latched(d: &mut Deviations) {
    let is_wrong = Rc::new(Cell::new(false));
    let at_start = Rc::clone(&is_wrong);
    d.encoder.user_parameters(move |view, user| {
        at_start.set(at_start.get() && view.exchanged_for.is_some());
        user
    });
    d.checks.check(move |check, right| match check {
        EncoderCheck::StartsWithoutRecord => {
            is_wrong.set(is_wrong.get() || !right);
            right
        }
        EncoderCheck::UserParametersAreRight(..) => {
            is_wrong.set(is_wrong.get() || !right);
            !is_wrong.get()
        }
        _ => right,
    });
}

fn record_of_data_exchange_stays(d: &mut Deviations) {
    let retained = Rc::new(Cell::new(None));
    let in_memory = Rc::clone(&retained);
    d.encoder.user_parameters(move |view, user| {
        if view.exchanged_for.is_some() {
            retained.set(Some(user));
        }
        retained.get().unwrap_or(user)
    });
    d.encoder.powered_up(move || in_memory.set(None));
}

fn new_scaling_in_mantel860_only(d: &mut Deviations) {
    let at_start = Rc::new(Cell::new(None));
    let known = Rc::clone(&at_start);
    d.encoder.user_parameters(move |view, user| {
        if view.exchanged_for.is_none() {
            at_start.set(None);
        }
        user
    });
    d.telegram.acts_on(move |signal, _, right| {
        let settings = known.get().unwrap_or(right);
        known.set(Some(settings));
        if matches!(signal, InputSignal::Position | InputSignal::NistB) { right } else { settings }
    });
}

/// Shows byte 30 of the last record in P65000, until P65000 is written.
#[derive(Default)]
struct ReservedOctetsAct(Option<(u8, u32)>);

impl EncoderHooks for ReservedOctetsAct {
    fn write_record(&mut self, view: &EncoderView<'_>, access: &RecordAccess, octets: RecordOctets) -> RecordOctets {
        let octet = octets.as_ref().ok().and_then(|octets| octets.get(30)).filter(|octet| **octet != 0);
        if let (USER_PARAMETERS, Some(octet)) = (access.index, octet) {
            self.0 = Some((*octet, view.preset_value));
        }
        octets
    }

    fn element(&mut self, view: &EncoderView<'_>, at: (u16, usize), right: u64) -> u64 {
        match self.0 {
            Some((octet, before)) if at == (65000, 0) && view.preset_value == before => octet.into(),
            _ => right,
        }
    }
}

/// Whether there was a parameter request during the start.
#[derive(Default)]
struct Mantel860WaitsForPreset(bool);

impl EncoderHooks for Mantel860WaitsForPreset {
    fn write_record(&mut self, view: &EncoderView<'_>, access: &RecordAccess, octets: RecordOctets) -> RecordOctets {
        self.0 |= access.index == PARAMETER_ACCESS && view.exchanged_for.is_none();
        octets
    }

    fn ready(&mut self, view: &EncoderView<'_>, right: Duration) -> Duration {
        let had_request = core::mem::take(&mut self.0);
        if view.submodules[0].telegram.number != 860 || had_request { right } else { NEVER }
    }
}

/// The last written record.
#[derive(Default)]
struct StatusOf31Octets([u8; OCTETS]);

impl EncoderHooks for StatusOf31Octets {
    fn write_record(&mut self, _: &EncoderView<'_>, access: &RecordAccess, octets: RecordOctets) -> RecordOctets {
        let record = octets.as_ref().ok().and_then(|octets| octets[..].try_into().ok());
        if let (USER_PARAMETERS, Some(record)) = (access.index, record) {
            self.0 = record;
        }
        octets
    }

    fn read_record(&mut self, _: &EncoderView<'_>, access: &RecordAccess, octets: RecordOctets) -> RecordOctets {
        match access.index {
            USER_PARAMETERS => octets.map(|_| self.0.into()),
            _ => octets,
        }
    }

    fn powered_up(&mut self) {
        self.0 = [0; OCTETS];
    }
}
