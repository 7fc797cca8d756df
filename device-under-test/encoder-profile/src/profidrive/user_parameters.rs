//! The user parameter data that encoders of the profile are given at each start: record 0xBF00, 31 octets.
//!
//! Layout, the same in all manuals that follow the profile: octet 0 bits (0 code sequence, 1 class 4, 2 G1_XIST1 preset
//! control, 3 scaling, 4 alarm channel, 5 compatibility), 1-8 units per revolution, 9-16 total range, 17 tolerated
//! failures of the sign of life, 18 velocity unit, 19-30 reserved. Source: XAC77 manual, 11.4.

use super::telegram::Telegram;
use crate::encoder::{Direction, Hardware, Scaling, Settings, Unit};
use crate::profidrive::checks::{Check, Checks};
use core::ops::RangeInclusive;
use device_stack::Attached;
use wire::octets::Reader;

/// Octets of the record.
pub const OCTETS: usize = 31;

/// The user parameters, as far as they have a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UserParameters {
    /// Bits 0 to 5 of octet 0 as they came, for the operating status.
    pub bits: u8,
    /// Bit 0: in which direction the position rises.
    pub direction: Direction,
    /// Bit 1: class 4, without which direction, preset and scaling do nothing.
    pub class_4: bool,
    /// Bit 2, 0 for enabled: whether a preset acts on G1_XIST1.
    pub preset_acts_on_xist1: bool,
    /// Bit 3: scaling.
    pub scaling: bool,
    /// Bit 4: whether diagnoses are sent in compatibility mode.
    pub alarm_channel: bool,
    /// Bit 5, 0 for enabled: compatibility with version 3.1 of the profile.
    pub compatible: bool,
    /// Measuring units per revolution.
    pub units_per_revolution: u64,
    /// Total measuring range in units.
    pub range: u64,
    /// Tolerated failures of the sign of life of the controller in compatibility mode.
    pub life_sign_failures: u8,
    /// In what the velocity is expressed.
    pub speed_unit: u8,
}

/// What a manual allows user parameters to ask for.
#[derive(Debug)]
pub struct StartLimits {
    /// Whether the hardware can serve the scaling of these parameters.
    pub serves: fn(&UserParameters, &Hardware) -> bool,
    /// The velocity units, in the order of their numbers from 0 on.
    pub velocity_units: &'static [Unit],
    /// How many failures of the sign of life can be tolerated in compatibility mode.
    pub tolerated_failures: RangeInclusive<u8>,
}

/// The velocity units of the profile.
pub const VELOCITY_UNITS: &[Unit] = &[Unit::PerSecond, Unit::Per100Milliseconds, Unit::Per10Milliseconds, Unit::Rpm];

/// Whether the hardware can serve a scaling, where the manual says no more than the profile.
///
/// Units per revolution go from 1 to the steps of the hardware, the range from 2 to all its steps, and the range must
/// not need more revolutions than there are. A range below one revolution is served.
pub fn serves(user: &UserParameters, hardware: &Hardware) -> bool {
    let (units, range) = (user.units_per_revolution, user.range);
    (1..=hardware.steps_per_revolution).contains(&units)
        && (2..=hardware.range()).contains(&range)
        && range <= units.saturating_mul(hardware.revolutions)
}

/// The steps from a record to what is in force that a deviation may change; each default changes nothing.
#[allow(unused_variables, reason = "the names tell what a step is about")]
pub trait StartSteps {
    /// The user parameters that are in force without a record.
    fn delivered(&mut self, hardware: &Hardware, right: UserParameters) -> UserParameters {
        right
    }

    /// The settings of the measuring task that user parameters make.
    fn settings(&mut self, user: &UserParameters, hardware: &Hardware, right: Settings) -> Settings {
        right
    }

    /// The velocity unit of a number.
    fn velocity_unit(&mut self, number: u8, right: Unit) -> Unit {
        right
    }
}

/// The encoder that user parameters are for.
pub struct ParametrizedEncoder<'a> {
    /// What its sensor tells apart.
    pub hardware: Hardware,
    /// What its manual allows.
    pub limits: &'static StartLimits,
    /// Its decisions.
    pub checks: &'a Checks,
    /// Its steps.
    pub steps: &'a Attached<dyn StartSteps>,
}

impl UserParameters {
    /// Reads the record; none if it has another length. Reserved bits and octets have no function.
    pub fn parse(octets: &[u8]) -> Option<UserParameters> {
        let mut reader = Reader::new("user parameter data", octets);
        let bits = reader.u8().ok()?;
        let units_per_revolution = u64::from_be_bytes(reader.array().ok()?);
        let range = u64::from_be_bytes(reader.array().ok()?);
        let [life_sign_failures, speed_unit] = reader.array().ok()?;
        reader.take(OCTETS - 19).ok()?;
        if !reader.is_empty() {
            return None;
        }
        Some(UserParameters::of(bits, Scaling { units_per_revolution, range }, life_sign_failures, speed_unit))
    }

    /// Those of a record with these octets and numbers: `bits` is octet 0, of which bits 6 and 7 have no function.
    pub fn of(bits: u8, scaling: Scaling, life_sign_failures: u8, speed_unit: u8) -> UserParameters {
        let bit = |n: u32| bits >> n & 1 != 0;
        UserParameters {
            bits: bits & 0x3F,
            direction: if bit(0) { Direction::Counterclockwise } else { Direction::Clockwise },
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

    /// Whether scaling is in force: with class 4, where it is switched on.
    pub fn scales(&self, checks: &Checks) -> bool {
        checks.check(Check::ScalingActs(*self), self.class_4 && self.scaling)
    }

    /// The scaling in force; none if the encoder cannot serve what is asked for. Values that are not in force are not
    /// looked at.
    pub fn scaling(&self, encoder: &ParametrizedEncoder<'_>) -> Option<Scaling> {
        let ParametrizedEncoder { hardware, limits, checks, .. } = encoder;
        if !self.scales(checks) {
            return Some(Scaling::hardware(hardware));
        }
        let is_served = checks.check(Check::ScalingIsServed(*self, *hardware), (limits.serves)(self, hardware));
        is_served.then_some(Scaling { units_per_revolution: self.units_per_revolution, range: self.range })
    }

    /// Whether there is a velocity unit of this number.
    pub fn has_unit(&self, encoder: &ParametrizedEncoder<'_>) -> bool {
        let is_known = usize::from(self.speed_unit) < encoder.limits.velocity_units.len();
        encoder.checks.check(Check::VelocityUnitExists(self.speed_unit), is_known)
    }

    /// Whether the encoder can do all that is set; if not there is a parametrization error.
    ///
    /// The tolerated failures count in compatibility mode only.
    pub fn are_right(&self, encoder: &ParametrizedEncoder<'_>, telegram: &Telegram) -> bool {
        let ParametrizedEncoder { limits, checks, .. } = encoder;
        let tolerates = !self.compatible || limits.tolerated_failures.contains(&self.life_sign_failures);
        let are_right = self.scaling(encoder).is_some()
            && self.has_unit(encoder)
            && checks.check(Check::ToleranceIsRight(*self), tolerates);
        checks.check(Check::UserParametersAreRight(*self, telegram.number), are_right)
    }

    /// The velocity unit in force; where it is none, steps per second stand in for it.
    pub fn velocity_unit(&self, encoder: &ParametrizedEncoder<'_>) -> Unit {
        let unit = encoder.limits.velocity_units.get(usize::from(self.speed_unit)).copied();
        let unit = unit.unwrap_or(Unit::PerSecond);
        encoder.steps.apply(unit, |steps, unit| steps.velocity_unit(self.speed_unit, unit))
    }

    /// Whether presets and their offset act: with class 4.
    pub fn presets_act(&self, checks: &Checks) -> bool {
        checks.check(Check::PresetsAct(*self), self.class_4)
    }

    /// The settings of the measuring task; where the scaling is wrong, that of the hardware stands in for it.
    pub fn settings(&self, encoder: &ParametrizedEncoder<'_>) -> Settings {
        let ParametrizedEncoder { hardware, checks, steps, .. } = encoder;
        let scaling = self.scaling(encoder).unwrap_or(Scaling::hardware(hardware));
        let direction = match checks.check(Check::CodeSequenceActs(*self), self.class_4) {
            true => self.direction,
            false => Direction::Clockwise,
        };
        let settings = Settings::scaled(direction, scaling, self.presets_act(checks));
        steps.apply(settings, |steps, settings| steps.settings(self, hardware, settings))
    }
}

#[cfg(test)]
mod tests;
