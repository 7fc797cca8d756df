//! The user parameter data, which a controller writes at each start: record 0xBF00, 31 bytes.
//!
//! The layout is the same in all manuals that follow the profile: byte 0 bits (0 code sequence, 1 class 4, 2 G1_XIST1
//! preset control, 3 scaling, 4 alarm channel, 5 compatibility), 1-8 units per revolution, 9-16 total range, 17
//! tolerated failures of the sign of life, 18 velocity unit, 19-30 reserved. Source: XAC77 manual, 11.4.

use super::telegram::Telegram;
use crate::encoder::{CountingDirection, Hardware, MeasuringSettings, Scaling, VelocityUnit};
use crate::profidrive::checks::{AttachedChecks, EncoderCheck};
use core::ops::RangeInclusive;
use device_stack::Attached;
use wire::octets::ByteReader;

/// Length of the record in bytes.
pub const OCTETS: usize = 31;

/// The user parameters that have a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UserParameterData {
    /// Bits 0 to 5 of byte 0 as received, for the operating status.
    pub bits: u8,
    /// Bit 0: code sequence.
    pub direction: CountingDirection,
    /// Bit 1: class 4. Without it direction, preset and scaling have no effect.
    pub class_4: bool,
    /// Bit 2, inverted: whether a preset acts on G1_XIST1.
    pub preset_acts_on_xist1: bool,
    /// Bit 3: scaling.
    pub scaling: bool,
    /// Bit 4: whether diagnoses are sent in compatibility mode.
    pub alarm_channel: bool,
    /// Bit 5, inverted: compatibility with version 3.1 of the profile.
    pub compatible: bool,
    /// Measuring units per revolution.
    pub units_per_revolution: u64,
    /// Total measuring range in units.
    pub range: u64,
    /// Tolerated failures of the sign of life of the controller in compatibility mode.
    pub life_sign_failures: u8,
    /// Number of the velocity unit.
    pub speed_unit: u8,
}

/// The limits of user parameters in a manual.
#[derive(Debug)]
pub struct StartLimits {
    /// Whether the hardware supports the scaling of these parameters.
    pub serves: fn(&UserParameterData, &Hardware) -> bool,
    /// The velocity units by number, from 0.
    pub velocity_units: &'static [VelocityUnit],
    /// The permitted numbers of tolerated sign-of-life failures in compatibility mode.
    pub tolerated_failures: RangeInclusive<u8>,
}

/// The velocity units of the profile.
pub const VELOCITY_UNITS: &[VelocityUnit] =
    &[VelocityUnit::PerSecond, VelocityUnit::Per100Milliseconds, VelocityUnit::Per10Milliseconds, VelocityUnit::Rpm];

/// Whether the hardware supports a scaling by the rules of the profile.
///
/// Units per revolution are 1 to the steps of the hardware, and the range is 2 to all its steps. The range must not
/// need more revolutions than the hardware has. A range below one revolution is supported.
pub fn serves(user: &UserParameterData, hardware: &Hardware) -> bool {
    let (units, range) = (user.units_per_revolution, user.range);
    (1..=hardware.steps_per_revolution).contains(&units)
        && (2..=hardware.range()).contains(&range)
        && range <= units.saturating_mul(hardware.revolutions)
}

/// The steps from a record to the settings in force that a deviation may change. Each default changes nothing.
#[allow(unused_variables, reason = "the names document the step")]
pub trait StartSteps {
    /// The user parameters in force without a record.
    fn factory_parameters(&mut self, hardware: &Hardware, right: UserParameterData) -> UserParameterData {
        right
    }

    /// The settings of the measuring task from user parameters.
    fn settings(
        &mut self,
        user: &UserParameterData,
        hardware: &Hardware,
        right: MeasuringSettings,
    ) -> MeasuringSettings {
        right
    }

    /// The velocity unit for a number.
    fn velocity_unit(&mut self, number: u8, right: VelocityUnit) -> VelocityUnit {
        right
    }
}

/// The encoder for which user parameters are checked and applied.
pub struct ParametrizedEncoder<'a> {
    pub hardware: Hardware,
    pub limits: &'static StartLimits,
    pub checks: &'a AttachedChecks,
    pub steps: &'a Attached<dyn StartSteps>,
}

impl UserParameterData {
    /// Parses the record. Returns `None` if it has the wrong length. Reserved bits and bytes are ignored.
    pub fn parse(octets: &[u8]) -> Option<UserParameterData> {
        let mut reader = ByteReader::new("user parameter data", octets);
        let bits = reader.u8().ok()?;
        let units_per_revolution = u64::from_be_bytes(reader.array().ok()?);
        let range = u64::from_be_bytes(reader.array().ok()?);
        let [life_sign_failures, speed_unit] = reader.array().ok()?;
        reader.take(OCTETS - 19).ok()?;
        if !reader.is_empty() {
            return None;
        }
        Some(UserParameterData::of(bits, Scaling { units_per_revolution, range }, life_sign_failures, speed_unit))
    }

    /// User parameters from the fields of a record. `bits` is byte 0, whose bits 6 and 7 have no function.
    pub fn of(bits: u8, scaling: Scaling, life_sign_failures: u8, speed_unit: u8) -> UserParameterData {
        let bit = |n: u32| bits >> n & 1 != 0;
        UserParameterData {
            bits: bits & 0x3F,
            direction: if bit(0) { CountingDirection::Counterclockwise } else { CountingDirection::Clockwise },
            class_4: bit(1),
            preset_acts_on_xist1: !bit(2),
            scaling: bit(3),
            alarm_channel: bit(4),
            compatible: !bit(5),
            units_per_revolution: scaling.units_per_revolution,
            range: scaling.range,
            life_sign_failures,
            speed_unit,
        }
    }

    /// Whether scaling is applied: with class 4 and if it is enabled.
    pub fn scales(&self, checks: &AttachedChecks) -> bool {
        checks.check(EncoderCheck::ScalingActs(*self), self.class_4 && self.scaling)
    }

    /// The scaling in force; `None` if the encoder does not support it. Values that are not in force are not checked.
    pub fn scaling(&self, encoder: &ParametrizedEncoder<'_>) -> Option<Scaling> {
        let ParametrizedEncoder { hardware, limits, checks, .. } = encoder;
        if !self.scales(checks) {
            return Some(Scaling::hardware(hardware));
        }
        let is_served = checks.check(EncoderCheck::ScalingIsServed(*self, *hardware), (limits.serves)(self, hardware));
        is_served.then_some(Scaling { units_per_revolution: self.units_per_revolution, range: self.range })
    }

    /// Whether the velocity unit exists.
    pub fn has_unit(&self, encoder: &ParametrizedEncoder<'_>) -> bool {
        let is_known = usize::from(self.speed_unit) < encoder.limits.velocity_units.len();
        encoder.checks.check(EncoderCheck::VelocityUnitExists(self.speed_unit), is_known)
    }

    /// Whether the encoder supports all parameters. If not, there is a parametrization error.
    ///
    /// The tolerated failures are checked in compatibility mode only.
    pub fn are_right(&self, encoder: &ParametrizedEncoder<'_>, telegram: &Telegram) -> bool {
        let ParametrizedEncoder { limits, checks, .. } = encoder;
        let tolerates = !self.compatible || limits.tolerated_failures.contains(&self.life_sign_failures);
        let are_right = self.scaling(encoder).is_some()
            && self.has_unit(encoder)
            && checks.check(EncoderCheck::ToleranceIsRight(*self), tolerates);
        checks.check(EncoderCheck::UserParametersAreRight(*self, telegram.number), are_right)
    }

    /// The velocity unit in force; units per second if the number is invalid.
    pub fn velocity_unit(&self, encoder: &ParametrizedEncoder<'_>) -> VelocityUnit {
        let unit = encoder.limits.velocity_units.get(usize::from(self.speed_unit)).copied();
        let unit = unit.unwrap_or(VelocityUnit::PerSecond);
        encoder.steps.apply(unit, |steps, unit| steps.velocity_unit(self.speed_unit, unit))
    }

    /// Whether presets and their offset are applied: with class 4.
    pub fn presets_act(&self, checks: &AttachedChecks) -> bool {
        checks.check(EncoderCheck::PresetsAct(*self), self.class_4)
    }

    /// The settings of the measuring task. If the scaling is invalid, the position is unscaled.
    pub fn settings(&self, encoder: &ParametrizedEncoder<'_>) -> MeasuringSettings {
        let ParametrizedEncoder { hardware, checks, steps, .. } = encoder;
        let scaling = self.scaling(encoder).unwrap_or(Scaling::hardware(hardware));
        let applies = checks.check(EncoderCheck::CodeSequenceActs(*self), self.class_4);
        let direction = if applies { self.direction } else { CountingDirection::Clockwise };
        let settings = MeasuringSettings::scaled(direction, scaling, self.presets_act(checks));
        steps.apply(settings, |steps, settings| steps.settings(self, hardware, settings))
    }
}

#[cfg(test)]
mod tests;
